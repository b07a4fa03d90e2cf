// Where rays cross the boundaries of media that fill space: those that are boxes, and those that are surfaces, which a world
// of their own holds. What happens between two crossings is of group_space.cpp and group_transmittance.cpp.
#include <algorithm>

#include "shade/context_host.h"
#include "shade/medium_boxes.h"

namespace kinora::shade {

namespace {

constexpr int kMostWalks = 64;  // through the hierarchy of boundaries, for eight crossings each

}  // namespace

// All crossings of the listed rays (by number in the list) into crossings_, ray by ray in order of distance, whatever
// the rays hit: who is inside a medium where he begins sees that by the way out. A medium that is seen inside surfaces
// only is entered and left where these are, too.
void GroupState::findCrossings(const Rays& rays, uint32_t n, const uint32_t* entries, const MediaSight& sight) {
  crossings_.clear();
  crossBoxes(rays, n, entries, sight);
  if (world_.space->boundaries) crossBoundaries(rays, n, entries, sight);
  const auto isBefore = [](const MediumCrossing& a, const MediumCrossing& b) {
    return a.ray != b.ray ? a.ray < b.ray : a.t < b.t;
  };
  if (!std::is_sorted(crossings_.begin(), crossings_.end(), isBefore))
    std::stable_sort(crossings_.begin(), crossings_.end(), isBefore);
  if (world_.space->nameCount) cutOff(entries, sight);
}

void GroupState::crossBoxes(const Rays& rays, uint32_t n, const uint32_t* entries, const MediaSight& sight) {
  const SpaceMedia& space = *world_.space;
  const ArenaScope memory(arena_);
  const float *from[SpaceMedia::kMostBoxes], *to[SpaceMedia::kMostBoxes];
  uint32_t medium[SpaceMedia::kMostBoxes], count = 0;
  for (const uint32_t at : space.boxes) {
    const SpaceMedium& m = space.media[at];
    if (!(space.visibilityOf(at) & sight.kinds)) continue;
    float *begin = arena_.make<float>(padded(n)), *end = arena_.make<float>(padded(n));
    BoxCrossingArgs args{rays.o, rays.d, n, entries, toObject(m.instance, m.geometry, 0), {}, {}, begin, end};
    m.findReach(args.low, args.high);
    boxCrossingKernel(world_.width)(args);
    medium[count] = at;
    from[count] = begin;
    to[count++] = end;
  }
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t k = 0; k < count; ++k) {
      const float begin = from[k][i], end = to[k][i];
      if (!(begin < end && end > 0)) continue;
      if (sight.ofEntry && !(space.visibilityOf(medium[k]) & sight.of(entries[i]))) continue;
      if (begin > 0) crossings_.push_back({i, begin, medium[k], true});
      crossings_.push_back({i, end, medium[k], false});
    }
}

void GroupState::crossBoundaries(const Rays& rays, uint32_t n, const uint32_t* entries, const MediaSight& sight) {
  const SpaceMedia& space = *world_.space;
  const trace::World& boundaries = *space.boundaries;
  RayList& list = *makeRays(n);
  uint32_t *open = arena_.make<uint32_t>(padded(n)), *beyond = arena_.make<uint32_t>(padded(n));
  float* passed = arena_.make<float>(padded(n));
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = entries[i];
    for (int k = 0; k < 3; ++k) {
      list.rays.o[k][i] = rays.o[k][s];
      list.rays.d[k][i] = rays.d[k][s];
    }
    list.rays.tMax[i] = 1e30f;
    list.rays.time[i] = rays.time[s];
    list.rays.radius[i] = list.rays.spread[i] = 0;
    open[i] = i;
    passed[i] = 0;
  }
  uint32_t m = n, last = ~0u;
  trace::Affine toLast;  // of the instance that was met last, where it stands still
  for (int walk = 0; m && walk < kMostWalks; ++walk) {
    boundaries.collectClear(list.rays, m, open, collected_, beyond);
    if (const uint32_t found = uint32_t(collected_.size())) {
      const RayList& hits = *makeRays(found);
      boundaries.resolve(list.rays, found, collected_.data(), hits.hits);
      for (uint32_t k = 0; k < found; ++k) {
        const uint32_t ray = collected_[k].slot, instance = hits.hits.instance[k],
                       at = space.ofBoundary[boundaries.instance(instance).user];
        list.hits.t[ray] = collected_[k].t;
        if (!(space.visibilityOf(at) & sight.of(entries[ray]))) continue;
        if (instance != last) {
          toLast = boundaries.objectToRender(instance, list.rays.time[ray]).inverse();
          last = boundaries.instance(instance).keyCount < 2 ? instance : ~0u;
        }
        float out = 0;
        for (int r = 0; r < 3; ++r) {
          float d = 0;
          for (int c = 0; c < 3; ++c) d += toLast.m[r][c] * list.rays.d[c][ray];
          out += d * hits.hits.ng[r][k];
        }
        crossings_.push_back({ray, passed[ray] + collected_[k].t, at, out * space.sideOf(at) < 0});
      }
    }
    uint32_t going = 0;
    for (uint32_t i = 0; i < m; ++i)
      if (beyond[i]) open[going++] = open[i];
    passThrough(list, going, open, passed);
    m = going;
  }
  counters.endlessRays += m;
}

}  // namespace kinora::shade
