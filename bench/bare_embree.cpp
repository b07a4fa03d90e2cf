#include "bare_embree.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "figures.h"
#include "trace/embree_device.h"

namespace kinora::bench {

namespace {

constexpr uint32_t kMost = 8192;  // rays a batch: the largest group

template <int N>
struct Packet;
template <>
struct Packet<4> {
  using Ray = RTCRay4;
  using RayHit = RTCRayHit4;
  static void intersect(const int* v, RTCScene s, RTCIntersectContext* c, RayHit* r) { rtcIntersect4(v, s, c, r); }
  static void occluded(const int* v, RTCScene s, RTCIntersectContext* c, Ray* r) { rtcOccluded4(v, s, c, r); }
};
template <>
struct Packet<8> {
  using Ray = RTCRay8;
  using RayHit = RTCRayHit8;
  static void intersect(const int* v, RTCScene s, RTCIntersectContext* c, RayHit* r) { rtcIntersect8(v, s, c, r); }
  static void occluded(const int* v, RTCScene s, RTCIntersectContext* c, Ray* r) { rtcOccluded8(v, s, c, r); }
};
template <>
struct Packet<16> {
  using Ray = RTCRay16;
  using RayHit = RTCRayHit16;
  static void intersect(const int* v, RTCScene s, RTCIntersectContext* c, RayHit* r) { rtcIntersect16(v, s, c, r); }
  static void occluded(const int* v, RTCScene s, RTCIntersectContext* c, Ray* r) { rtcOccluded16(v, s, c, r); }
};

}  // namespace

const char* nameOf(Call call) {
  static const char* const kNames[] = {"1", "4", "8", "16", "1M", "Np"};
  return kNames[size_t(call)];
}

struct BareEmbree::Buffers {
  template <class T>
  struct alignas(64) Column {
    T v[kMost + 16];
  };
  // the state of a group: rays in, hits out
  Column<float> in[8];
  Column<float> t, u, v, ng[3];
  Column<uint32_t> primitive, geometry, instance, blocked;
  // what a stream of arrays needs beside
  Column<float> zero, far;
  Column<uint32_t> mask, none;
  alignas(64) RTCRayHit rayHits[kMost];
  alignas(64) RTCRay shadows[kMost];

  template <int N>
  void pack(uint32_t b, uint32_t n, typename Packet<N>::Ray& r, int* valid) {
    for (int i = 0; i < N; ++i) valid[i] = b + uint32_t(i) < n ? -1 : 0;
    std::memcpy(r.org_x, in[0].v + b, 4 * N);
    std::memcpy(r.org_y, in[1].v + b, 4 * N);
    std::memcpy(r.org_z, in[2].v + b, 4 * N);
    std::memcpy(r.dir_x, in[3].v + b, 4 * N);
    std::memcpy(r.dir_y, in[4].v + b, 4 * N);
    std::memcpy(r.dir_z, in[5].v + b, 4 * N);
    std::memcpy(r.tfar, in[6].v + b, 4 * N);
    std::memcpy(r.time, in[7].v + b, 4 * N);
    for (int i = 0; i < N; ++i) {
      r.tnear[i] = 0;
      r.mask[i] = 0xffffffffu;
      r.id[i] = 0;
      r.flags[i] = 0;
    }
  }
  template <int N>
  void closest(RTCScene scene, RTCIntersectContext* c, uint32_t n) {
    alignas(64) typename Packet<N>::RayHit r;
    alignas(64) int valid[N];
    for (uint32_t b = 0; b < n; b += N) {
      pack<N>(b, n, r.ray, valid);
      for (int i = 0; i < N; ++i) {
        r.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
      }
      Packet<N>::intersect(valid, scene, c, &r);
      std::memcpy(t.v + b, r.ray.tfar, 4 * N);
      std::memcpy(u.v + b, r.hit.u, 4 * N);
      std::memcpy(v.v + b, r.hit.v, 4 * N);
      std::memcpy(ng[0].v + b, r.hit.Ng_x, 4 * N);
      std::memcpy(ng[1].v + b, r.hit.Ng_y, 4 * N);
      std::memcpy(ng[2].v + b, r.hit.Ng_z, 4 * N);
      std::memcpy(primitive.v + b, r.hit.primID, 4 * N);
      std::memcpy(geometry.v + b, r.hit.geomID, 4 * N);
    }
  }
  template <int N>
  void occluded(RTCScene scene, RTCIntersectContext* c, uint32_t n) {
    alignas(64) typename Packet<N>::Ray r;
    alignas(64) int valid[N];
    for (uint32_t b = 0; b < n; b += N) {
      pack<N>(b, n, r, valid);
      Packet<N>::occluded(valid, scene, c, &r);
      std::memcpy(t.v + b, r.tfar, 4 * N);
    }
  }
  RTCRayNp stream(uint32_t n) {
    std::memcpy(t.v, in[6].v, 4 * n);
    RTCRayNp r{};
    r.org_x = in[0].v;
    r.org_y = in[1].v;
    r.org_z = in[2].v;
    r.dir_x = in[3].v;
    r.dir_y = in[4].v;
    r.dir_z = in[5].v;
    r.tnear = zero.v;
    r.tfar = t.v;
    r.time = in[7].v;
    r.mask = mask.v;
    r.id = none.v;
    r.flags = none.v;
    return r;
  }
};

BareEmbree::BareEmbree() {
  device_ = rtcNewDevice(trace::kDeviceConfig);
  if (!device_) throw std::runtime_error("Embree gives no device");
  scene_ = rtcNewScene(device_);
  buffers_ = new Buffers();
  std::fill_n(buffers_->mask.v, kMost, 0xffffffffu);
}

void BareEmbree::attach(RTCGeometry g, RTCScene to) {
  rtcCommitGeometry(g);
  rtcAttachGeometry(to, g);
  rtcReleaseGeometry(g);
}

BareEmbree::BareEmbree(const CurveSet& curves) : BareEmbree() {
  const RTCGeometry g = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE);
  void* points =
      rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 16, 4 * curves.pieceCount());
  std::memcpy(points, curves.controls.data(), 4 * curves.controls.size());
  auto* pieces = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, 4, curves.pieceCount()));
  for (size_t i = 0; i < curves.pieceCount(); ++i) pieces[i] = uint32_t(4 * i);
  attach(g, scene_);
  rtcCommitScene(scene_);
}

// `later`: points at the end of the shutter; empty: it keeps its shape.
void BareEmbree::attachMesh(const TriangleMesh& mesh, const std::vector<float>& later, RTCScene to) {
  const RTCGeometry g = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  const auto points = [&](unsigned step, const std::vector<float>& from) {
    void* place = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, 12, from.size() / 3);
    std::memcpy(place, from.data(), 4 * from.size());
  };
  rtcSetGeometryTimeStepCount(g, later.empty() ? 1 : 2);
  points(0, mesh.points);
  if (!later.empty()) points(1, later);
  void* corners = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangleCount());
  std::memcpy(corners, mesh.vertices.data(), 4 * mesh.vertices.size());
  attach(g, to);
}

BareEmbree::BareEmbree(const TriangleMesh& mesh) : BareEmbree() {
  attachMesh(mesh, {}, scene_);
  rtcCommitScene(scene_);
}

BareEmbree::BareEmbree(const RichScene& rich) : BareEmbree() {
  parts_.resize(rich.meshes.size(), nullptr);
  for (const RichPlacement& p : rich.placements) {
    const RichMesh& m = rich.meshes[p.mesh];
    const bool moves = p.toWorld.matrices.size() > 1;
    if (!p.isInstance && !moves && m.later.empty()) {
      TriangleMesh there = m.mesh;
      for (size_t i = 0; i < there.points.size(); i += 3) {
        const Imath::V3d at = Imath::V3d(there.points[i], there.points[i + 1], there.points[i + 2]) * p.toWorld.at(0);
        for (size_t c = 0; c < 3; ++c) there.points[i + c] = float(at[int(c)]);
      }
      attachMesh(there, {}, scene_);
      continue;
    }
    if (!parts_[p.mesh]) {
      parts_[p.mesh] = rtcNewScene(device_);
      attachMesh(m.mesh, m.later, parts_[p.mesh]);
      rtcCommitScene(parts_[p.mesh]);
    }
    const RTCGeometry g = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(g, parts_[p.mesh]);
    const unsigned keys = moves ? 5 : 1;  // turning bends the way of points: more than its two ends
    rtcSetGeometryTimeStepCount(g, keys);
    for (unsigned k = 0; k < keys; ++k) {
      const scene::Matrix at = p.toWorld.at(keys > 1 ? double(k) / (keys - 1) : 0);
      float rows[12];
      for (int column = 0; column < 4; ++column)
        for (int c = 0; c < 3; ++c) rows[3 * column + c] = float(at[column][c]);
      rtcSetGeometryTransform(g, k, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, rows);
    }
    attach(g, scene_);
  }
  rtcCommitScene(scene_);
}

BareEmbree::~BareEmbree() {
  rtcReleaseScene(scene_);
  for (const RTCScene part : parts_)
    if (part) rtcReleaseScene(part);
  rtcReleaseDevice(device_);
  delete buffers_;
}

double BareEmbree::trace(const RecordedRays& rays, const RayBatch& batch, Call call) {
  Buffers& b = *buffers_;
  const uint32_t n = batch.count;
  if (n > kMost) throw std::runtime_error("a group of more rays than the replay holds");
  for (int c = 0; c < 8; ++c) {
    std::memcpy(b.in[c].v, rays.column(c) + batch.first, 4 * n);
    for (uint32_t i = n; i < n + 16; ++i) b.in[c].v[i] = 0;
  }
  const bool ofRays = call == Call::One || call == Call::StreamOfRays;
  if (ofRays)
    for (uint32_t i = 0; i < n; ++i) {
      RTCRayHit r{};
      r.ray = {b.in[0].v[i],
               b.in[1].v[i],
               b.in[2].v[i],
               0,
               b.in[3].v[i],
               b.in[4].v[i],
               b.in[5].v[i],
               b.in[7].v[i],
               b.in[6].v[i],
               0xffffffffu,
               0,
               0};
      r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      if (batch.shadow)
        b.shadows[i] = r.ray;
      else
        b.rayHits[i] = r;
    }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags =
      !batch.shadow && batch.depth == 0 ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  const double start = wallSeconds();
  if (!batch.shadow) {
    switch (call) {
      case Call::One:
        for (uint32_t i = 0; i < n; ++i) rtcIntersect1(scene_, &context, &b.rayHits[i]);
        break;
      case Call::Four:
        b.closest<4>(scene_, &context, n);
        break;
      case Call::Eight:
        b.closest<8>(scene_, &context, n);
        break;
      case Call::Sixteen:
        b.closest<16>(scene_, &context, n);
        break;
      case Call::StreamOfRays:
        rtcIntersect1M(scene_, &context, b.rayHits, n, sizeof(RTCRayHit));
        break;
      default: {
        std::memset(b.geometry.v, 0xff, 4 * n);
        std::memset(b.instance.v, 0xff, 4 * n);
        RTCRayHitNp r{};
        r.ray = b.stream(n);
        r.hit.Ng_x = b.ng[0].v;
        r.hit.Ng_y = b.ng[1].v;
        r.hit.Ng_z = b.ng[2].v;
        r.hit.u = b.u.v;
        r.hit.v = b.v.v;
        r.hit.primID = b.primitive.v;
        r.hit.geomID = b.geometry.v;
        r.hit.instID[0] = b.instance.v;
        rtcIntersectNp(scene_, &context, &r, n);
      }
    }
  } else {
    switch (call) {
      case Call::One:
        for (uint32_t i = 0; i < n; ++i) rtcOccluded1(scene_, &context, &b.shadows[i]);
        break;
      case Call::Four:
        b.occluded<4>(scene_, &context, n);
        break;
      case Call::Eight:
        b.occluded<8>(scene_, &context, n);
        break;
      case Call::Sixteen:
        b.occluded<16>(scene_, &context, n);
        break;
      case Call::StreamOfRays:
        rtcOccluded1M(scene_, &context, b.shadows, n, sizeof(RTCRay));
        break;
      default: {
        RTCRayNp r = b.stream(n);
        rtcOccludedNp(scene_, &context, &r, n);
      }
    }
  }
  const double time = wallSeconds() - start;
  uint64_t hits = 0;
  for (uint32_t i = 0; i < n; ++i) {
    if (batch.shadow)
      hits += (ofRays ? b.shadows[i].tfar : b.t.v[i]) < 0;
    else
      hits += (ofRays ? b.rayHits[i].hit.geomID : b.geometry.v[i]) != RTC_INVALID_GEOMETRY_ID;
  }
  hits_[batch.shadow] += hits;
  return time;
}

void BareEmbree::chooseCalls(const RecordedRays& rays, int rounds) {
  std::map<Kind, std::array<std::vector<double>, size_t(Call::Count)>> times;
  for (int round = 0; round < rounds; ++round)
    for (size_t call = 0; call < size_t(Call::Count); ++call) {
      std::map<Kind, double> sum;
      for (const RayBatch& b : rays.batches()) sum[{b.shadow, b.depth}] += trace(rays, b, Call(call));
      for (const auto& [kind, t] : sum) times[kind][call].push_back(t);
    }
  for (const auto& [kind, t] : times) {
    size_t best = 0;
    for (size_t call = 1; call < t.size(); ++call)
      if (*std::min_element(t[call].begin(), t[call].end()) < *std::min_element(t[best].begin(), t[best].end()))
        best = call;
    choice_[kind] = Call(best);
  }
}

BareEmbree::Seconds BareEmbree::replay(const RecordedRays& rays) {
  hits_[0] = hits_[1] = 0;
  Seconds sum;
  for (const RayBatch& b : rays.batches())
    (b.shadow ? sum.shadow : b.depth ? sum.indirect : sum.camera) += trace(rays, b, choice_.at({b.shadow, b.depth}));
  return sum;
}

std::string BareEmbree::choice() const {
  std::string s;
  for (const auto& [kind, call] : choice_)
    s += (s.empty() ? "" : ", ") +
         (kind.first    ? "shadow " + std::to_string(kind.second)
          : kind.second ? "indirect " + std::to_string(kind.second)
                        : "camera") +
         ": " + nameOf(call);
  return s;
}

}  // namespace kinora::bench
