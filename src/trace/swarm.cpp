#include "trace/swarm.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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
    const auto& swarm = *static_cast<const Swarm*>(a->geometryUserPtr);
    const Item& item = swarm.items_[a->primID];
    const Affine& m = (*swarm.keys_)[item.key];
    RTCBounds local;
    rtcGetSceneBounds(swarm.scenes_[item.part], &local);
    const float lower[3] = {local.lower_x, local.lower_y, local.lower_z},
                upper[3] = {local.upper_x, local.upper_y, local.upper_z};
    float from[3], to[3];
    for (int i = 0; i < 3; ++i) {
      from[i] = to[i] = m.t[i];
      float size = std::fabs(m.t[i]);
      for (int j = 0; j < 3; ++j) {
        const float x = m.m[i][j] * lower[j], y = m.m[i][j] * upper[j];
        from[i] += std::min(x, y);
        to[i] += std::max(x, y);
        size = std::max({size, std::fabs(x), std::fabs(y)});
      }
      // what rounding may have taken away
      const float more = 4 * std::numeric_limits<float>::epsilon() * size;
      from[i] -= more;
      to[i] += more;
    }
    RTCBounds& b = *a->bounds_o;
    b.lower_x = from[0];
    b.lower_y = from[1];
    b.lower_z = from[2];
    b.upper_x = to[0];
    b.upper_y = to[1];
    b.upper_z = to[2];
  }

  // Each ray by itself: its answer does not depend on its neighbours.
  static void intersect(const RTCIntersectFunctionNArguments* a) {
    const auto& swarm = *static_cast<const Swarm*>(a->geometryUserPtr);
    const Item& item = swarm.items_[a->primID];
    const Affine& m = (*swarm.keys_)[item.key];
    const RTCScene scene = swarm.scenes_[item.part];
    RTCRayN* rays = RTCRayHitN_RayN(a->rayhit, a->N);
    RTCHitN* hits = RTCRayHitN_HitN(a->rayhit, a->N);
    alignas(64) RTCRayHit r;
    a->context->instID[0] = swarm.firstId_ + a->primID;  // filters are told, and hits carry it
    for (unsigned i = 0; i < a->N; ++i) {
      if (!a->valid[i]) continue;
      const float o[3] = {RTCRayN_org_x(rays, a->N, i), RTCRayN_org_y(rays, a->N, i), RTCRayN_org_z(rays, a->N, i)};
      const float d[3] = {RTCRayN_dir_x(rays, a->N, i), RTCRayN_dir_y(rays, a->N, i), RTCRayN_dir_z(rays, a->N, i)};
      set(toPart(m, o, d), rays, a->N, i, r.ray);
      r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene, a->context, &r);
      if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
      RTCRayN_tfar(rays, a->N, i) = r.ray.tfar;
      RTCHitN_u(hits, a->N, i) = r.hit.u;
      RTCHitN_v(hits, a->N, i) = r.hit.v;
      RTCHitN_Ng_x(hits, a->N, i) = r.hit.Ng_x;
      RTCHitN_Ng_y(hits, a->N, i) = r.hit.Ng_y;
      RTCHitN_Ng_z(hits, a->N, i) = r.hit.Ng_z;
      RTCHitN_primID(hits, a->N, i) = r.hit.primID;
      RTCHitN_geomID(hits, a->N, i) = r.hit.geomID;
      RTCHitN_instID(hits, a->N, i, 0) = swarm.firstId_ + a->primID;
    }
    a->context->instID[0] = RTC_INVALID_GEOMETRY_ID;
  }

  static void occluded(const RTCOccludedFunctionNArguments* a) {
    const auto& swarm = *static_cast<const Swarm*>(a->geometryUserPtr);
    const Item& item = swarm.items_[a->primID];
    const Affine& m = (*swarm.keys_)[item.key];
    const RTCScene scene = swarm.scenes_[item.part];
    alignas(64) RTCRay r;
    a->context->instID[0] = swarm.firstId_ + a->primID;
    for (unsigned i = 0; i < a->N; ++i) {
      if (!a->valid[i]) continue;
      const float o[3] = {RTCRayN_org_x(a->ray, a->N, i), RTCRayN_org_y(a->ray, a->N, i),
                          RTCRayN_org_z(a->ray, a->N, i)};
      const float d[3] = {RTCRayN_dir_x(a->ray, a->N, i), RTCRayN_dir_y(a->ray, a->N, i),
                          RTCRayN_dir_z(a->ray, a->N, i)};
      set(toPart(m, o, d), a->ray, a->N, i, r);
      rtcOccluded1(scene, a->context, &r);
      if (r.tfar < 0) RTCRayN_tfar(a->ray, a->N, i) = -INFINITY;
    }
    a->context->instID[0] = RTC_INVALID_GEOMETRY_ID;
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

Swarm::Swarm(std::shared_ptr<const std::vector<Affine>> keys, std::vector<RTCScene> scenes, std::vector<Item> items,
             uint32_t firstId)
    : keys_(std::move(keys)), scenes_(std::move(scenes)), items_(std::move(items)), firstId_(firstId) {}

RTCGeometry Swarm::makeGeometry(RTCDevice device) const {
  const RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(g, unsigned(items_.size()));
  rtcSetGeometryUserData(g, const_cast<Swarm*>(this));
  rtcSetGeometryBoundsFunction(g, &Calls::bounds, nullptr);
  rtcSetGeometryIntersectFunction(g, &Calls::intersect);
  rtcSetGeometryOccludedFunction(g, &Calls::occluded);
  return g;
}

}  // namespace kinora::trace
