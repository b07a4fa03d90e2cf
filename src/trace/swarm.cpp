#include "trace/swarm.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <tbb/parallel_for.h>

#include "trace/embree_device.h"
#include "trace/world.h"

namespace kinora::trace {

namespace {

// A ray in a part's space. The direction keeps its length, so that distances stay those of render space.
struct Local {
  float o[3], d[3];
};

// By the adjoint: inverses are not stored, since what a ray waits for is memory, not these thirty operations.
Local toPart(const Affine& a, const float o[3], const float d[3]) {
  const float(&m)[3][3] = a.m;
  const float adjoint[3][3] = {{m[1][1] * m[2][2] - m[1][2] * m[2][1], m[0][2] * m[2][1] - m[0][1] * m[2][2],
                                m[0][1] * m[1][2] - m[0][2] * m[1][1]},
                               {m[1][2] * m[2][0] - m[1][0] * m[2][2], m[0][0] * m[2][2] - m[0][2] * m[2][0],
                                m[0][2] * m[1][0] - m[0][0] * m[1][2]},
                               {m[1][0] * m[2][1] - m[1][1] * m[2][0], m[0][1] * m[2][0] - m[0][0] * m[2][1],
                                m[0][0] * m[1][1] - m[0][1] * m[1][0]}};
  const float scale = 1.f / (m[0][0] * adjoint[0][0] + m[0][1] * adjoint[1][0] + m[0][2] * adjoint[2][0]);
  const float from[3] = {o[0] - a.t[0], o[1] - a.t[1], o[2] - a.t[2]};
  Local l;
  for (int i = 0; i < 3; ++i) {
    l.o[i] = (adjoint[i][0] * from[0] + adjoint[i][1] * from[1] + adjoint[i][2] * from[2]) * scale;
    l.d[i] = (adjoint[i][0] * d[0] + adjoint[i][1] * d[1] + adjoint[i][2] * d[2]) * scale;
  }
  return l;
}

}  // namespace

struct Swarm::Calls {
  static void bounds(const RTCBoundsFunctionArguments* a) {
    const Group& g = static_cast<const Swarm*>(a->geometryUserPtr)->groups_[a->primID];
    // no number where all are lost: Embree leaves such a primitive out
    float lower[3], upper[3];
    std::fill_n(lower, 3, std::numeric_limits<float>::quiet_NaN());
    std::fill_n(upper, 3, std::numeric_limits<float>::quiet_NaN());
    for (uint32_t i = 0; i < kTogether; ++i) {
      float from[3], to[3];
      if (!boxOf(g, i, from, to)) continue;
      for (int k = 0; k < 3; ++k) {
        lower[k] = std::fmin(lower[k], from[k]);
        upper[k] = std::fmax(upper[k], to[k]);
      }
    }
    setBounds(*a->bounds_o, lower, upper);
  }

  // Each ray by itself: its answer does not depend on its neighbours.
  static void intersect(const RTCIntersectFunctionNArguments* a) {
    const auto& swarm = *static_cast<const Swarm*>(a->geometryUserPtr);
    RTCRayN* rays = RTCRayHitN_RayN(a->rayhit, a->N);
    RTCHitN* hits = RTCRayHitN_HitN(a->rayhit, a->N);
    alignas(64) RTCRayHit r;
    for (unsigned i = 0; i < a->N; ++i) {
      if (!a->valid[i]) continue;
      eachNear(swarm, a->primID, rays, a->N, i, [&](uint32_t placement, RTCScene scene, const Local& l) {
        const uint32_t id = swarm.firstId_ + (placement - swarm.begin_);
        a->context->instID[0] = id;  // filters are told, and hits carry it
        set(l, rays, a->N, i, r.ray);
        r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, a->context, &r);
        if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return true;
        RTCRayN_tfar(rays, a->N, i) = r.ray.tfar;
        RTCHitN_u(hits, a->N, i) = r.hit.u;
        RTCHitN_v(hits, a->N, i) = r.hit.v;
        RTCHitN_Ng_x(hits, a->N, i) = r.hit.Ng_x;
        RTCHitN_Ng_y(hits, a->N, i) = r.hit.Ng_y;
        RTCHitN_Ng_z(hits, a->N, i) = r.hit.Ng_z;
        RTCHitN_primID(hits, a->N, i) = r.hit.primID;
        RTCHitN_geomID(hits, a->N, i) = r.hit.geomID;
        RTCHitN_instID(hits, a->N, i, 0) = id;
        return true;
      });
    }
    a->context->instID[0] = RTC_INVALID_GEOMETRY_ID;
  }

  static void occluded(const RTCOccludedFunctionNArguments* a) {
    const auto& swarm = *static_cast<const Swarm*>(a->geometryUserPtr);
    alignas(64) RTCRay r;
    for (unsigned i = 0; i < a->N; ++i) {
      if (!a->valid[i]) continue;
      eachNear(swarm, a->primID, a->ray, a->N, i, [&](uint32_t placement, RTCScene scene, const Local& l) {
        a->context->instID[0] = swarm.firstId_ + (placement - swarm.begin_);
        set(l, a->ray, a->N, i, r);
        rtcOccluded1(scene, a->context, &r);
        if (r.tfar < 0) RTCRayN_tfar(a->ray, a->N, i) = -INFINITY;
        return r.tfar >= 0;
      });
    }
    a->context->instID[0] = RTC_INVALID_GEOMETRY_ID;
  }

  // visit(placement, scene, the ray there) for each placement of a primitive that ray i may meet; false from it ends
  // that.
  template <class Visit>
  static void eachNear(const Swarm& swarm, uint32_t primitive, RTCRayN* rays, unsigned n, unsigned i,
                       const Visit& visit) {
    const Group& g = swarm.groups_[primitive];
    const float o[3] = {RTCRayN_org_x(rays, n, i), RTCRayN_org_y(rays, n, i), RTCRayN_org_z(rays, n, i)};
    const float d[3] = {RTCRayN_dir_x(rays, n, i), RTCRayN_dir_y(rays, n, i), RTCRayN_dir_z(rays, n, i)};
    const float first = RTCRayN_tnear(rays, n, i);
    // where the ray comes into each box, and out of it
    float in[kTogether], out[kTogether];
    std::fill_n(in, kTogether, first);
    std::fill_n(out, kTogether, RTCRayN_tfar(rays, n, i));
    for (int k = 0; k < 3; ++k) {
      const float inverse = 1.f / (std::fabs(d[k]) > 1e-18f ? d[k] : 1e-18f);
      const float begin = (g.lower[k] - o[k]) * inverse, step = g.step[k] * inverse;
      for (uint32_t j = 0; j < kTogether; ++j) {
        const float x = begin + float(g.from[k][j]) * step, y = begin + float(g.to[k][j]) * step;
        in[j] = std::max(in[j], std::min(x, y));
        out[j] = std::min(out[j], std::max(x, y));
      }
    }
    // the slack is more than rounding takes here
    for (uint32_t j = 0; j < kTogether; ++j)
      if (!(in[j] <= out[j] + 1e-5f * std::fabs(out[j])) || g.from[0][j] > g.to[0][j]) in[j] = INFINITY;
    for (;;) {
      // what is met first may spare what lies behind it
      uint32_t next = 0;
      for (uint32_t j = 1; j < kTogether; ++j) next = in[j] < in[next] ? j : next;
      const float to = RTCRayN_tfar(rays, n, i);
      if (!(in[next] <= to + 1e-5f * std::fabs(to)) || in[next] == INFINITY) return;
      in[next] = INFINITY;
      const uint32_t placement = swarm.begin_ + primitive * kTogether + next, part = partOf(swarm, placement);
      const Local l = toPart(matrixOf(swarm, placement), o, d);
      if (mayMeet(l, swarm.boxes_[part], first, to) && !visit(placement, swarm.data_.scenes[part], l)) return;
    }
  }

  // Whether a ray may meet a part's box before it ends.
  static bool mayMeet(const Local& l, const Box& box, float from, float to) {
    for (int k = 0; k < 3; ++k) {
      const float inverse = 1.f / (std::fabs(l.d[k]) > 1e-18f ? l.d[k] : 1e-18f);
      const float x = (box.lower[k] - l.o[k]) * inverse, y = (box.upper[k] - l.o[k]) * inverse;
      from = std::max(from, std::min(x, y));
      to = std::min(to, std::max(x, y));
    }
    return from <= to + 1e-5f * std::fabs(to);
  }

  static bool boxOf(const Group& g, uint32_t i, float lower[3], float upper[3]) {
    for (int k = 0; k < 3; ++k) {
      lower[k] = g.lower[k] + float(g.from[k][i]) * g.step[k];
      upper[k] = g.lower[k] + float(g.to[k][i]) * g.step[k];
    }
    return g.from[0][i] <= g.to[0][i];
  }
  static Group groupOf(const Swarm& swarm, uint32_t primitive) {
    const auto [begin, end] = placementsOf(swarm, primitive);
    float from[kTogether][3], to[kTogether][3], lower[3], upper[3];
    std::fill_n(lower, 3, INFINITY);
    std::fill_n(upper, 3, -INFINITY);
    for (uint32_t i = begin; i < end; ++i) {
      if (isLost(swarm, i)) continue;
      boundsOf(swarm, i, from[i - begin], to[i - begin]);
      for (int k = 0; k < 3; ++k) {
        lower[k] = std::min(lower[k], from[i - begin][k]);
        upper[k] = std::max(upper[k], to[i - begin][k]);
      }
    }
    Group g;
    for (int k = 0; k < 3; ++k) {
      const bool isAny = lower[k] <= upper[k];
      // a step more at both ends: rays count in steps, see eachNear()
      const float size = std::max(upper[k] - lower[k], 1e-4f * std::fabs(upper[k]) + 1e-30f);
      g.step[k] = isAny ? size * (1.f / 252) : 0;
      g.lower[k] = isAny ? lower[k] - g.step[k] : 0;
      for (uint32_t i = 0; i < kTogether; ++i) {
        if (begin + i >= end || isLost(swarm, begin + i)) {
          g.from[k][i] = 1;
          g.to[k][i] = 0;
          continue;
        }
        const float a = (from[i][k] - g.lower[k]) / g.step[k] - .01f, b = (to[i][k] - g.lower[k]) / g.step[k] + 1.01f;
        g.from[k][i] = uint8_t(std::clamp(a, 0.f, 255.f));
        g.to[k][i] = uint8_t(std::clamp(b, 0.f, 255.f));
      }
    }
    return g;
  }

  static std::pair<uint32_t, uint32_t> placementsOf(const Swarm& swarm, uint32_t primitive) {
    const uint32_t begin = swarm.begin_ + primitive * kTogether;
    return {begin, std::min(begin + kTogether, swarm.end_)};
  }
  static bool isLost(const Swarm& swarm, uint32_t placement) {
    return !swarm.data_.isLost->empty() && (*swarm.data_.isLost)[placement];
  }
  static const Affine& matrixOf(const Swarm& swarm, uint32_t placement) {
    return (*swarm.data_.keys)[(*swarm.data_.instances)[placement].firstKey];
  }
  static uint32_t partOf(const Swarm& swarm, uint32_t placement) {
    return (*swarm.data_.partOfInfo)[(*swarm.data_.instances)[placement].info];
  }
  static void boundsOf(const Swarm& swarm, uint32_t placement, float from[3], float to[3]) {
    const Affine& m = matrixOf(swarm, placement);
    const Box& box = swarm.boxes_[partOf(swarm, placement)];
    for (int i = 0; i < 3; ++i) {
      from[i] = to[i] = m.t[i];
      float size = std::fabs(m.t[i]);
      for (int j = 0; j < 3; ++j) {
        const float x = m.m[i][j] * box.lower[j], y = m.m[i][j] * box.upper[j];
        from[i] += std::min(x, y);
        to[i] += std::max(x, y);
        size = std::max({size, std::fabs(x), std::fabs(y)});
      }
      // what rounding may have taken away
      const float more = 4 * std::numeric_limits<float>::epsilon() * size;
      from[i] -= more;
      to[i] += more;
    }
  }
  static void set(const Local& l, RTCRayN* rays, unsigned n, unsigned i, RTCRay& r) {
    r.org_x = l.o[0];
    r.org_y = l.o[1];
    r.org_z = l.o[2];
    r.dir_x = l.d[0];
    r.dir_y = l.d[1];
    r.dir_z = l.d[2];
    r.tnear = RTCRayN_tnear(rays, n, i);
    r.tfar = RTCRayN_tfar(rays, n, i);
    r.time = RTCRayN_time(rays, n, i);
    r.mask = RTCRayN_mask(rays, n, i);
    r.id = RTCRayN_id(rays, n, i);
    r.flags = 0;
  }
};

Swarm::Swarm(Data data, uint32_t begin, uint32_t end, uint32_t firstId)
    : data_(std::move(data)), begin_(begin), end_(end), firstId_(firstId) {
  for (const RTCScene scene : data_.scenes) {
    RTCBounds b;
    rtcGetSceneBounds(scene, &b);
    Box box{{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
    float size = 1e-30f;
    for (int k = 0; k < 3; ++k) size = std::max({size, std::fabs(box.lower[k]), std::fabs(box.upper[k])});
    for (int k = 0; k < 3; ++k) {
      const float more = 1e-5f * size;
      box.lower[k] -= more;
      box.upper[k] += more;
    }
    boxes_.push_back(box);
  }
  groups_.resize((end_ - begin_ + kTogether - 1) / kTogether);
  tbb::parallel_for(size_t(0), groups_.size(), [&](size_t i) { groups_[i] = Calls::groupOf(*this, uint32_t(i)); });
}

RTCGeometry Swarm::makeGeometry(RTCDevice device) const {
  const RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(g, unsigned(groups_.size()));
  rtcSetGeometryUserData(g, const_cast<Swarm*>(this));
  rtcSetGeometryBoundsFunction(g, &Calls::bounds, nullptr);
  rtcSetGeometryIntersectFunction(g, &Calls::intersect);
  rtcSetGeometryOccludedFunction(g, &Calls::occluded);
  return g;
}

}  // namespace kinora::trace
