// All hits along a ray by one walk through the hierarchy: a filter notes each and lets the ray go on.
#include <algorithm>
#include <array>
#include <tuple>

#include "trace/user_calls.h"
#include "trace/world.h"

namespace kinora::trace {

namespace {

// A query's context, and the nearest hits of its ray so far, in order.
struct Collector {
  QueryContext query;
  std::array<World::CollectedHit, World::kMostCollected> hits;
  uint32_t count = 0;
  bool beyond = false;  // there are more

  Collector() : query(false, nullptr, nullptr, nullptr) {}

  // Embree's order of calls says nothing: equal distances are told apart by what was hit.
  static auto order(const World::CollectedHit& h) { return std::tuple(h.t, h.instId, h.geomId, h.primId); }

  void add(const World::CollectedHit& hit) {
    if (count == hits.size()) {
      beyond = true;
      if (!(order(hit) < order(hits[count - 1]))) return;
      --count;
    }
    uint32_t at = count++;
    for (; at > 0 && order(hit) < order(hits[at - 1]); --at) hits[at] = hits[at - 1];
    hits[at] = hit;
  }

  static void note(const RTCFilterFunctionNArguments* a) {
    Collector& c = *reinterpret_cast<Collector*>(a->context);
    if (a->valid[0] == 0) return;
    World::CollectedHit hit;
    hit.t = RTCRayN_tfar(a->ray, a->N, 0);
    hit.u = RTCHitN_u(a->hit, a->N, 0);
    hit.v = RTCHitN_v(a->hit, a->N, 0);
    hit.ng[0] = RTCHitN_Ng_x(a->hit, a->N, 0);
    hit.ng[1] = RTCHitN_Ng_y(a->hit, a->N, 0);
    hit.ng[2] = RTCHitN_Ng_z(a->hit, a->N, 0);
    hit.geomId = RTCHitN_geomID(a->hit, a->N, 0);
    hit.primId = RTCHitN_primID(a->hit, a->N, 0);
    hit.instId = RTCHitN_instID(a->hit, a->N, 0, 0);
    c.add(hit);
    a->valid[0] = 0;
  }
};

}  // namespace

void World::collectClear(const Rays& rays, uint32_t n, const uint32_t* slots, std::vector<CollectedHit>& hits,
                         uint32_t* beyond) const {
  hits.clear();
  Collector collector;
  collector.query.embree.filter = &Collector::note;  // asked after those of surfaces of solids
  collector.query.askSolids(solids_.get(), rays.o, rays.d);
  alignas(64) RTCRayHit r;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots[i];
    collector.count = 0;
    collector.beyond = false;
    setRay(rays, s, kSeenByClearShadow, r);
    rtcIntersect1(top_, &collector.query.embree, &r);
    beyond[i] = collector.beyond;
    for (uint32_t k = 0; k < collector.count; ++k) {
      collector.hits[k].slot = s;
      hits.push_back(collector.hits[k]);
    }
  }
}

void World::resolve(const Rays& rays, uint32_t n, const CollectedHit* hits, const Hits& out) const {
  for (uint32_t i = 0; i < n; ++i) {
    const CollectedHit& h = hits[i];
    out.t[i] = h.t;
    out.u[i] = h.u;
    out.v[i] = h.v;
    for (int c = 0; c < 3; ++c) out.ng[c][i] = h.ng[c];
    resolve(out, i, h.geomId, h.primId, h.instId);
  }
  if (hasFacing_) turnToRays(rays, out, n, nullptr);
}

}  // namespace kinora::trace
