#include "trace/strands.h"

#include <bit>
#include <cmath>

#include "sampling/draw.h"
#include "trace/user_calls.h"
#include "trace/world.h"

namespace kinora::trace {

namespace {

// Quads that Embree cuts a ribbon's cubic piece into: with AVX2 it looks at eight together.
constexpr float kRibbonQuads = 8;

RTCGeometryType typeOf(geometry::Mesh::Kind kind) {
  using Kind = geometry::Mesh::Kind;
  switch (kind) {
    case Kind::LinearTube:
      return RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE;
    case Kind::LinearRibbon:
      return RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE;
    case Kind::CubicTube:
      return RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE;
    case Kind::CubicRibbon:
      return RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE;
    case Kind::OrientedRibbon:
      return RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_BEZIER_CURVE;
    case Kind::Ball:
      return RTC_GEOMETRY_TYPE_SPHERE_POINT;
    case Kind::Disc:
      return RTC_GEOMETRY_TYPE_DISC_POINT;
    case Kind::OrientedDisc:
      return RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT;
    case Kind::Triangles:
      break;
  }
  return RTC_GEOMETRY_TYPE_TRIANGLE;
}

// The dimension of a camera ray's random numbers by which curves are drawn, one for each curve.
constexpr uint32_t kThinCurveDimension = 0x6861u;

// One of Embree's filters: a curve that is drawn wider than it is lets rays pass. Which of them depends on ray and curve
// alone, so that a ray sees all of a curve or nothing, from any thread and in any packet.
void passThinCurves(const RTCFilterFunctionNArguments* a) {
  static const DrawSpan draw = drawSpan(1);
  const auto& mesh = *static_cast<const geometry::Mesh*>(a->geometryUserPtr);
  const Draws& draws = reinterpret_cast<const QueryContext*>(a->context)->draws;
  for (unsigned i = 0; i < a->N; ++i) {
    if (!a->valid[i]) continue;
    const uint32_t piece = RTCHitN_primID(a->hit, a->N, i);
    const float own = mesh.ownWidth(piece, RTCHitN_u(a->hit, a->N, i));
    if (own >= 1) continue;
    uint32_t key = hashWords(mesh.faceOf(piece) + 1, RTCHitN_instID(a->hit, a->N, i, 0));
    float u = 0, v = 0;
    if (draws.table) {
      // stratified over the samples of a pixel
      const uint32_t slot = RTCRayN_id(a->ray, a->N, i), seed = hashWords(draws.seed[slot], key);
      draw(*draws.table, 1, &seed, &draws.sample[slot], kThinCurveDimension, &u, &v);
    } else {
      for (const float x :
           {RTCRayN_org_x(a->ray, a->N, i), RTCRayN_org_y(a->ray, a->N, i), RTCRayN_org_z(a->ray, a->N, i),
            RTCRayN_dir_x(a->ray, a->N, i), RTCRayN_dir_y(a->ray, a->N, i), RTCRayN_dir_z(a->ray, a->N, i)})
        key = hashWords(key, std::bit_cast<uint32_t>(x + 0.f));
      u = float(key >> 8) * 0x1p-24f;
    }
    if (u >= own) a->valid[i] = 0;
  }
}

}  // namespace

RTCGeometry makeStrands(RTCDevice device, geometry::Mesh& mesh) {
  const RTCGeometry g = rtcNewGeometry(device, typeOf(mesh.kind));
  const size_t n = mesh.vertexCount;
  mesh.spineNormals.reserve(mesh.spineNormals.size() + 2);  // Embree reads 16 bytes at each
  rtcSetGeometryTimeStepCount(g, unsigned(mesh.keyCount()));
  for (size_t k = 0; k < size_t(mesh.keyCount()); ++k) {
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, unsigned(k), RTC_FORMAT_FLOAT4, mesh.spine.data(),
                               k * n * sizeof(Imath::V4f), sizeof(Imath::V4f), n);
    if (mesh.isOriented())
      rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_NORMAL, unsigned(k), RTC_FORMAT_FLOAT3, mesh.spineNormals.data(),
                                 k * n * sizeof(Imath::V3f), sizeof(Imath::V3f), n);
  }
  if (mesh.isCurve())
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, mesh.indices.data(), 0, sizeof(uint32_t),
                               mesh.indices.size());
  if (mesh.kind == geometry::Mesh::Kind::LinearTube) {
    // where tubes go on, Embree rounds the joint instead of capping both ends
    auto* flags = static_cast<uint8_t*>(
        rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_FLAGS, 0, RTC_FORMAT_UCHAR, sizeof(uint8_t), mesh.indices.size()));
    const auto joined = [&](size_t a, size_t b) {
      return mesh.faceOf(uint32_t(a)) == mesh.faceOf(uint32_t(b)) && mesh.indices[a] + 1 == mesh.indices[b];
    };
    for (size_t i = 0; i < mesh.indices.size(); ++i) {
      flags[i] = 0;
      if (i > 0 && joined(i - 1, i)) flags[i] |= RTC_CURVE_FLAG_NEIGHBOR_LEFT;
      if (i + 1 < mesh.indices.size() && joined(i, i + 1)) flags[i] |= RTC_CURVE_FLAG_NEIGHBOR_RIGHT;
    }
  }
  if (mesh.kind == geometry::Mesh::Kind::CubicRibbon) rtcSetGeometryTessellationRate(g, kRibbonQuads);
  if (!mesh.own.empty()) {
    rtcSetGeometryUserData(g, &mesh);
    rtcSetGeometryIntersectFilterFunction(g, &passThinCurves);
    rtcSetGeometryOccludedFilterFunction(g, &passThinCurves);
  }
  return g;
}

bool keepsWidths(const scene::Matrix& m) {
  double dots[3][3], largest = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      dots[i][j] = m[i][0] * m[j][0] + m[i][1] * m[j][1] + m[i][2] * m[j][2];
      if (i == j) largest = std::max(largest, dots[i][j]);
    }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::fabs(dots[i][j] - (i == j ? largest : 0)) <= 1e-6 * largest)) return false;
  return largest > 0;
}

void bakeStrands(geometry::Mesh& mesh, const scene::Matrix& local) {
  const double scale = std::sqrt(local[0][0] * local[0][0] + local[0][1] * local[0][1] + local[0][2] * local[0][2]);
  for (Imath::V4f& s : mesh.spine) {
    const Imath::V3f p(Imath::V3d(s.x, s.y, s.z) * local);
    s = Imath::V4f(p.x, p.y, p.z, float(s.w * scale));
  }
  for (Imath::V3f& n : mesh.spineNormals) {
    Imath::V3d out;
    local.multDirMatrix(Imath::V3d(n), out);  // as a vector: the transform turns and scales evenly
    n = Imath::V3f(out / scale);
  }
}

void World::turnToRays(const Rays& rays, const Hits& hits, uint32_t n, const uint32_t* slots) const {
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots ? slots[i] : i;
    if (std::isinf(hits.t[s])) continue;
    const geometry::Mesh& mesh = *meshes_[hits.geometry[s]];
    if (!mesh.facesRay()) continue;
    const Instance& instance = instance_[hits.instance[s]];
    const Affine m = instance.baked ? Affine() : objectToRender(hits.instance[s], rays.time[s]);
    float normal[3] = {-rays.d[0][s], -rays.d[1][s], -rays.d[2][s]};
    if (mesh.isCurve()) {
      // Embree answers with the tangent
      float tangent[3], along = 0, length2 = 0;
      for (int c = 0; c < 3; ++c) {
        tangent[c] = m.m[c][0] * hits.ng[0][s] + m.m[c][1] * hits.ng[1][s] + m.m[c][2] * hits.ng[2][s];
        along += normal[c] * tangent[c];
        length2 += tangent[c] * tangent[c];
      }
      if (length2 > 0 && along * along < 0.9999f * length2)
        for (int c = 0; c < 3; ++c) normal[c] -= tangent[c] * (along / length2);
    }
    // back to the strand's own space as normals go: by the transpose of what will bring it here
    for (int c = 0; c < 3; ++c) hits.ng[c][s] = m.m[0][c] * normal[0] + m.m[1][c] * normal[1] + m.m[2][c] * normal[2];
  }
}

}  // namespace kinora::trace
