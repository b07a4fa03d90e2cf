#include "trace/world.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <kinora/sample_table.h>

#include "trace/embree_device.h"
#include "trace/user_calls.h"
#include "trace/world_part.h"

namespace kinora::trace {

Affine Affine::from(const scene::Matrix& a) {
  Affine r;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r.m[i][j] = float(a[j][i]);
    r.t[i] = float(a[3][i]);
  }
  return r;
}

void Affine::point(const float p[3], float out[3]) const {
  for (int i = 0; i < 3; ++i) out[i] = m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + t[i];
}

float Affine::determinant() const {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

Affine Affine::inverse() const {
  Imath::M44d a;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) a[j][i] = m[i][j];
    a[3][i] = t[i];
  }
  return from(a.inverse());
}

World::~World() {
  if (top_) rtcReleaseScene(top_);
}

uint64_t World::embreeBytes() { return deviceBytes(); }
uint64_t World::meshBytes() const {
  uint64_t n = 0;
  for (const auto& p : parts_)
    for (const auto& m : p->meshes) n += m->bytes();
  return n;
}

Affine World::objectToRender(uint32_t index, float time) const {
  const Instance& i = instance_[index];
  const Affine* k = keys(i);
  if (i.keyCount == 1) return *k;
  const float x = std::clamp(time, 0.f, 1.f) * float(i.keyCount - 1);
  const uint32_t a = std::min(uint32_t(x), i.keyCount - 2u);
  const float f = x - float(a);
  Affine r;
  for (int c = 0; c < 3; ++c) {
    for (int d = 0; d < 3; ++d) r.m[c][d] = (1 - f) * k[a].m[c][d] + f * k[a + 1].m[c][d];
    r.t[c] = (1 - f) * k[a].t[c] + f * k[a + 1].t[c];
  }
  return r;
}

void World::resolve(const Hits& hits, uint32_t slot, uint32_t geomId, uint32_t primId, uint32_t instId) const {
  uint32_t instance = kNone;
  uint32_t index = 0;
  if (!single_) {
    instance = instanceOf(instId);
    index = partOf(instId);
  }
  const Target& target = targets_[places_[index].firstTarget + geomId];
  if (!target.merged) {
    hits.geometry[slot] = target.geometry;
    hits.primitive[slot] = primId;
    hits.instance[slot] = instance == kNone ? target.instance : instance;
    if (!target.writesLevel) hits.level[slot] = 0;
    return;
  }
  const Part* part = parts_[index].get();
  const uint32_t first = part->firstSlice[geomId], last = part->firstSlice[geomId + 1];
  uint32_t slice = first;
  if (last - first > 1) {
    const auto it = std::upper_bound(part->slices.begin() + first, part->slices.begin() + last, primId,
                                     [](uint32_t p, const Part::Slice& s) { return p < s.start; });
    slice = uint32_t(it - part->slices.begin()) - 1;
  }
  const Part::Slice& s = part->slices[slice];
  hits.geometry[slot] = places_[index].firstGeometry + s.shape;
  hits.primitive[slot] = primId - s.start;
  hits.instance[slot] = instance == kNone ? places_[index].firstInstance + s.shape : instance;
  hits.level[slot] = 0;  // user geometry, which writes its own, is never merged
}

void World::closestCamera(const Rays& rays, const Hits& hits, uint32_t slots, const Draws& draws) const {
  QueryContext context(true, rays.radius, rays.spread, hits.level);
  context.draws = draws;
  context.askSolids(solids_.get(), rays.o, rays.d);
  alignas(64) RTCRayHit16 r;
  alignas(64) int valid[16];
  for (uint32_t b = 0; b < slots; b += 16) {
    float* const origin[3] = {r.ray.org_x, r.ray.org_y, r.ray.org_z};
    float* const direction[3] = {r.ray.dir_x, r.ray.dir_y, r.ray.dir_z};
    for (int i = 0; i < 3; ++i) {
      std::memcpy(origin[i], rays.o[i] + b, 64);
      std::memcpy(direction[i], rays.d[i] + b, 64);
    }
    std::memcpy(r.ray.tfar, rays.tMax + b, 64);
    std::memcpy(r.ray.time, rays.time + b, 64);
    for (int i = 0; i < 16; ++i) {
      // watertight tests also meet what the eye lies on, which nothing is seen of: by the bias of shading points
      const float far =
          std::max({std::fabs(rays.o[0][b + i]), std::fabs(rays.o[1][b + i]), std::fabs(rays.o[2][b + i])});
      r.ray.tnear[i] = watertight_ ? far * 4e-6f + 1e-7f : 0.f;
      // Embree ends the program on a ray whose numbers are too large, as of a picture plane of 1e19
      const float steep =
          std::max({std::fabs(rays.d[0][b + i]), std::fabs(rays.d[1][b + i]), std::fabs(rays.d[2][b + i])});
      valid[i] = far < float(kMostInSpace) && steep < 2 ? -1 : 0;
      r.ray.mask[i] = kSeenByCamera;
      r.ray.id[i] = b + uint32_t(i);
      r.ray.flags[i] = 0;
      r.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid, top_, &context.embree, &r);
    std::memcpy(hits.ng[0] + b, r.hit.Ng_x, 64);
    std::memcpy(hits.ng[1] + b, r.hit.Ng_y, 64);
    std::memcpy(hits.ng[2] + b, r.hit.Ng_z, 64);
    std::memcpy(hits.u + b, r.hit.u, 64);
    std::memcpy(hits.v + b, r.hit.v, 64);
    for (int i = 0; i < 16; ++i) {
      const uint32_t slot = b + i;
      if (r.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
        hits.t[slot] = INFINITY;
        continue;
      }
      hits.t[slot] = r.ray.tfar[i];
      resolve(hits, slot, r.hit.geomID[i], r.hit.primID[i], r.hit.instID[0][i]);
    }
  }
  if (hasFacing_) turnToRays(rays, hits, slots, nullptr);
  if (unread_) unread_->meet(rays, hits, slots, nullptr);
}

void World::setRay(const Rays& rays, uint32_t s, uint32_t mask, RTCRayHit& r) {
  r.ray.org_x = rays.o[0][s];
  r.ray.org_y = rays.o[1][s];
  r.ray.org_z = rays.o[2][s];
  r.ray.dir_x = rays.d[0][s];
  r.ray.dir_y = rays.d[1][s];
  r.ray.dir_z = rays.d[2][s];
  r.ray.tnear = 0;
  r.ray.tfar = rays.tMax[s];
  r.ray.time = rays.time[s];
  r.ray.mask = mask;
  r.ray.flags = 0;
  r.ray.id = s;
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

void World::closest(const Rays& rays, const Hits& hits, uint32_t mask, uint32_t n, const uint32_t* slots,
                    const Draws& draws) const {
  QueryContext context(false, rays.radius, rays.spread, hits.level);
  context.draws = draws;
  closest(context, rays, hits, mask, n, slots);
  if (unread_ && (mask & ~uint32_t(kAskedAlone | kSeenByWalks))) unread_->meet(rays, hits, n, slots);
}

// A query of closestOn(): a filter refuses what is not of the ray's body.
struct OneBody {
  QueryContext query;
  const World& world;
  const uint32_t* bodies;  // by ray id
  static void refuse(const RTCFilterFunctionNArguments* a) {
    const OneBody& c = *reinterpret_cast<const OneBody*>(a->context);
    if (a->valid[0] == 0) return;
    uint32_t instance, geometry, primitive, level;
    Hits h{};
    h.instance = &instance;
    h.geometry = &geometry;
    h.primitive = &primitive;
    h.level = &level;
    c.world.resolve(h, 0, RTCHitN_geomID(a->hit, a->N, 0), RTCHitN_primID(a->hit, a->N, 0),
                    RTCHitN_instID(a->hit, a->N, 0, 0));
    if (c.world.bodyOf(instance, geometry) != c.bodies[RTCRayN_id(a->ray, a->N, 0)]) a->valid[0] = 0;
  }
};

void World::closestOn(const Rays& rays, const Hits& hits, const uint32_t* bodies, uint32_t n,
                      const uint32_t* slots) const {
  OneBody context{QueryContext(false, rays.radius, rays.spread, hits.level), *this, bodies};
  context.query.embree.filter = &OneBody::refuse;
  closest(context.query, rays, hits, kAskedAlone, n, slots);
}

void World::closest(QueryContext& context, const Rays& rays, const Hits& hits, uint32_t mask, uint32_t n,
                    const uint32_t* slots) const {
  context.askSolids(solids_.get(), rays.o, rays.d);
  alignas(64) RTCRayHit r;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots[i];
    setRay(rays, s, mask, r);
    rtcIntersect1(top_, &context.embree, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
      hits.t[s] = INFINITY;
      continue;
    }
    hits.t[s] = r.ray.tfar;
    hits.u[s] = r.hit.u;
    hits.v[s] = r.hit.v;
    hits.ng[0][s] = r.hit.Ng_x;
    hits.ng[1][s] = r.hit.Ng_y;
    hits.ng[2][s] = r.hit.Ng_z;
    resolve(hits, s, r.hit.geomID, r.hit.primID, r.hit.instID[0]);
  }
  if (hasFacing_) turnToRays(rays, hits, n, slots);
}

void World::occluded(uint32_t n, const float* const o[3], const float* const d[3], const float* tMax,
                     const float* time, uint32_t mask, uint32_t* blocked, const float* radius,
                     const float* spread) const {
  QueryContext context(false, radius, spread, nullptr);
  context.askSolids(solids_.get(), o, d);
  // Streams answer "is something in the way" like single rays, bit for bit, whatever else is in the stream: no
  // nearest hit has to be told from an equal one (world_test.cpp holds that). Over instances single rays are faster.
  if (single_ && !moving_ && !hasUser_ && !hasStrands_) {
    constexpr uint32_t kStream = 512;
    alignas(64) float near[kStream], far[kStream];
    alignas(64) uint32_t masks[kStream], none[kStream], ids[kStream];
    const uint32_t most = std::min(n, kStream);
    std::fill_n(near, most, 0.f);
    std::fill_n(masks, most, mask);
    std::fill_n(none, most, 0u);
    for (uint32_t first = 0; first < n; first += kStream) {
      const uint32_t count = std::min(n - first, kStream);
      // a negative end is Embree's own sign for a hit
      for (uint32_t i = 0; i < count; ++i) far[i] = std::max(tMax[first + i], 0.f);
      // Embree's struct has no const; only tfar is written
      const auto in = [&](const float* p) { return const_cast<float*>(p + first); };
      for (uint32_t i = 0; i < count; ++i) ids[i] = first + i;  // the ray, for geometry that asks for its footprint
      RTCRayNp r{};
      r.org_x = in(o[0]);
      r.org_y = in(o[1]);
      r.org_z = in(o[2]);
      r.dir_x = in(d[0]);
      r.dir_y = in(d[1]);
      r.dir_z = in(d[2]);
      r.tnear = near;
      r.tfar = far;
      r.time = in(time);
      r.mask = masks;
      r.id = ids;
      r.flags = none;
      rtcOccludedNp(top_, &context.embree, &r, count);
      for (uint32_t i = 0; i < count; ++i) blocked[first + i] = far[i] < 0 && tMax[first + i] > 0;
    }
    if (unread_) unread_->meet(n, o, d, tMax, blocked);
    return;
  }
  alignas(64) RTCRay r;
  for (uint32_t i = 0; i < n; ++i) {
    r.org_x = o[0][i];
    r.org_y = o[1][i];
    r.org_z = o[2][i];
    r.dir_x = d[0][i];
    r.dir_y = d[1][i];
    r.dir_z = d[2][i];
    r.tnear = 0;
    r.tfar = std::max(tMax[i], 0.f);
    r.time = time[i];
    r.mask = mask;
    r.flags = 0;
    r.id = i;
    rtcOccluded1(top_, &context.embree, &r);
    blocked[i] = r.tfar < 0 && tMax[i] > 0;
  }
  if (unread_) unread_->meet(n, o, d, tMax, blocked);
}

}  // namespace kinora::trace
