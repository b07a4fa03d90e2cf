// Rays that patterns send from the points of their contexts (ContextFunctions::probe).
#include <algorithm>
#include <cstring>

#include "shade/context_host.h"

namespace kinora::shade {

namespace {
constexpr uint32_t kMostAtOnce = 1024;  // rays of a list, which goes when they are traced
}  // namespace

uint32_t GroupState::maskOf(const char* traceSet) const {
  if (!traceSet || !*traceSet) return 0;
  const auto set = world_.setsByText.find(std::string_view(traceSet));
  return set == world_.setsByText.end() ? 0 : set->second;
}

int GroupState::probe(const Context* c, const ProbeRays& rays) {
  // A ray that asks whether what it met is present runs that surface's patterns: theirs go no further.
  if (probing_ || world_.isForPlaces) return 0;
  const uint32_t mask = maskOf(rays.traceSet);
  probing_ = true;
  // The time is that of shading, which waits for the rays.
  const uint64_t indirect = counters.nanoseconds[kTimeTraceIndirect];
  for (uint32_t first = 0; first < rays.count; first += kMostAtOnce)
    probeSome(c, rays, first, std::min(kMostAtOnce, rays.count - first), mask);
  counters.nanoseconds[kTimeTraceIndirect] = indirect;
  probing_ = false;
  return 1;
}

void GroupState::probeSome(const Context* c, const ProbeRays& p, uint32_t first, uint32_t count, uint32_t mask) {
  const ArenaScope memory(arena_);
  RayList& list = *makeRays(count);
  ListHost& host = ListHost::of(list);
  host.seen = mask;
  const VertexState& from = ContextHost::of(c).state;
  const VertexState& left = host.left;
  const Rays& r = list.rays;
  uint32_t* entries = arena_.make<uint32_t>(padded(count));
  for (uint32_t i = 0; i < padded(count); ++i) entries[i] = std::min(i, count - 1);
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t ray = first + i, point = p.point[ray];
    float side = 0;
    for (int k = 0; k < 3; ++k) side += c->Ng[k][point] * p.d[k][ray];
    const float off = side < 0 ? -c->bias[point] : c->bias[point];
    for (int k = 0; k < 3; ++k) {
      r.o[k][i] = c->P[k][point] + off * c->Ng[k][point];
      r.d[k][i] = p.d[k][ray];
    }
    r.tMax[i] = p.reach[ray];
    r.time[i] = c->time[point];
    r.radius[i] = c->radius[point];
    r.spread[i] = c->spread[point];
    list.sampleSeed[i] = hashWords(c->sampleSeed[point], p.part[ray] + 1);
    list.sampleIndex[i] = c->sampleIndex[point];
    // As leave(), but contexts that are asked for presence alone do not know all of their own state.
    if (left.media) left.media[i] = from.media[point];
    for (int k = 0; left.Ng[k] && k < 3; ++k) left.Ng[k][i] = c->Ng[k][point];
    if (left.traceSet && !(c->traits & kTraitInSpace))
      left.traceSet[i] = world_.placementOf(c->place.instance[point], c->place.geometry[point]).traceSet;
  }
  trace(list, RayKind::Indirect, c->depth + 1, count, entries, nullptr);
  std::copy_n(list.hits.t, count, p.t + first);
}

}  // namespace kinora::shade
