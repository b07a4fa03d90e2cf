#include "trace/user_calls.h"

#include <cmath>
#include <cstddef>

#include "trace/embree_device.h"

namespace kinora::trace {

static_assert(offsetof(QueryContext, embree) == 0);

QueryContext::QueryContext(bool coherent, const float* radii, const float* spreads, uint32_t* levels)
    : radius(radii), spread(spreads), level(levels) {
  rtcInitIntersectContext(&embree);
  embree.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
}

namespace {

UserRay rayOf(RTCRayN* rays, unsigned n, unsigned i, const QueryContext& q) {
  UserRay r;
  r.o[0] = RTCRayN_org_x(rays, n, i);
  r.o[1] = RTCRayN_org_y(rays, n, i);
  r.o[2] = RTCRayN_org_z(rays, n, i);
  r.d[0] = RTCRayN_dir_x(rays, n, i);
  r.d[1] = RTCRayN_dir_y(rays, n, i);
  r.d[2] = RTCRayN_dir_z(rays, n, i);
  r.tMin = RTCRayN_tnear(rays, n, i);
  r.tMax = RTCRayN_tfar(rays, n, i);
  r.time = RTCRayN_time(rays, n, i);
  // directions are unit in render space: their length here is the placement's scale along the ray
  const float scale = std::sqrt(r.d[0] * r.d[0] + r.d[1] * r.d[1] + r.d[2] * r.d[2]);
  const unsigned id = RTCRayN_id(rays, n, i);
  r.radius = q.radius ? q.radius[id] * scale : 0.f;
  r.spread = q.spread ? q.spread[id] * scale : 0.f;
  r.mask = RTCRayN_mask(rays, n, i);
  return r;
}

void bounds(const RTCBoundsFunctionArguments* a) {
  float lower[3], upper[3];
  static_cast<const UserGeometry*>(a->geometryUserPtr)->bounds(a->primID, a->timeStep, lower, upper);
  setBounds(*a->bounds_o, lower, upper);
}

// Whether the query's own filter, which Embree calls for triangles, refuses a hit.
bool isRefused(const RTCIntersectFunctionNArguments* a, const UserHit& h, unsigned i) {
  RTCRayN* rays = RTCRayHitN_RayN(a->rayhit, a->N);
  RTCRay ray = rtcGetRayFromRayN(rays, a->N, i);
  ray.tfar = h.t;
  RTCHit hit;
  hit.Ng_x = h.ng[0];
  hit.Ng_y = h.ng[1];
  hit.Ng_z = h.ng[2];
  hit.u = h.u;
  hit.v = h.v;
  hit.primID = h.primitive;
  hit.geomID = a->geomID;
  hit.instID[0] = a->context->instID[0];
  int valid = -1;
  const RTCFilterFunctionNArguments filter{
      &valid, a->geometryUserPtr, a->context, reinterpret_cast<RTCRayN*>(&ray), reinterpret_cast<RTCHitN*>(&hit), 1};
  a->context->filter(&filter);
  return valid == 0;
}

void intersect(const RTCIntersectFunctionNArguments* a) {
  const auto& geometry = *static_cast<const UserGeometry*>(a->geometryUserPtr);
  const auto& query = *reinterpret_cast<const QueryContext*>(a->context);
  RTCRayN* rays = RTCRayHitN_RayN(a->rayhit, a->N);
  RTCHitN* hits = RTCRayHitN_HitN(a->rayhit, a->N);
  for (unsigned i = 0; i < a->N; ++i) {
    if (!a->valid[i]) continue;
    const UserRay ray = rayOf(rays, a->N, i, query);
    UserHit h;
    h.primitive = a->primID;
    if (!geometry.intersect(a->primID, ray, &h) || !(h.t > ray.tMin && h.t < ray.tMax)) continue;
    if (query.embree.filter && isRefused(a, h, i)) continue;
    RTCRayN_tfar(rays, a->N, i) = h.t;
    RTCHitN_u(hits, a->N, i) = h.u;
    RTCHitN_v(hits, a->N, i) = h.v;
    RTCHitN_Ng_x(hits, a->N, i) = h.ng[0];
    RTCHitN_Ng_y(hits, a->N, i) = h.ng[1];
    RTCHitN_Ng_z(hits, a->N, i) = h.ng[2];
    RTCHitN_primID(hits, a->N, i) = h.primitive;
    RTCHitN_geomID(hits, a->N, i) = a->geomID;
    RTCHitN_instID(hits, a->N, i, 0) = a->context->instID[0];
    if (query.level) query.level[RTCRayN_id(rays, a->N, i)] = h.level;
  }
}

void occluded(const RTCOccludedFunctionNArguments* a) {
  const auto& geometry = *static_cast<const UserGeometry*>(a->geometryUserPtr);
  const auto& query = *reinterpret_cast<const QueryContext*>(a->context);
  for (unsigned i = 0; i < a->N; ++i) {
    if (!a->valid[i]) continue;
    const UserRay ray = rayOf(a->ray, a->N, i, query);
    UserHit h;
    if (geometry.intersect(a->primID, ray, &h) && h.t > ray.tMin && h.t < ray.tMax)
      RTCRayN_tfar(a->ray, a->N, i) = -INFINITY;
  }
}

}  // namespace

RTCGeometry makeUserGeometry(RTCDevice device, const UserGeometry& geometry) {
  const RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(g, geometry.patchCount());
  if (geometry.keyCount() > 1) rtcSetGeometryTimeStepCount(g, geometry.keyCount());
  rtcSetGeometryUserData(g, const_cast<UserGeometry*>(&geometry));
  rtcSetGeometryBoundsFunction(g, &bounds, nullptr);
  rtcSetGeometryIntersectFunction(g, &intersect);
  rtcSetGeometryOccludedFunction(g, &occluded);
  return g;
}

}  // namespace kinora::trace
