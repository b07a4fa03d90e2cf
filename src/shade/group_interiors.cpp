// Volumes that surfaces have inside: cut off where these end.
#include <algorithm>

#include "shade/medium_tracks.h"

namespace kinora::shade {

// Of the crossings that were found those of interiors go, and those of media that rays of these kinds see only inside of
// them become the ends of what both have in common. Of surfaces that overlap, or pass through themselves, each part
// counts: a ray is inside until it has left as many as it has entered.
void GroupState::cutOff(const uint32_t* entries, const MediaSight& sight) {
  const SpaceMedia& space = *world_.space;
  const ArenaScope memory(arena_);
  const uint32_t media = uint32_t(space.media.size()), all = media + uint32_t(space.interiors.size());
  const size_t count = crossings_.size();
  uint32_t *depth = arena_.make<uint32_t>(all), *askedFor = arena_.make<uint32_t>(space.nameCount),
           *around = arena_.make<uint32_t>(media), *seenBy = arena_.make<uint32_t>(all), aroundCount = 0;
  bool *isThere = arena_.make<bool>(media), *isIgnored = arena_.make<bool>(count + 1);
  std::fill_n(depth, all, 0u);
  std::fill_n(seenBy, all, ~0u);
  std::fill_n(askedFor, space.nameCount, 0u);
  std::fill_n(isThere, media, false);
  std::fill_n(isIgnored, count + 1, false);
  uint32_t visibility = sight.kinds;  // to the ray at hand
  const auto isEverywhere = [&](uint32_t number) {
    return number < media && space.media[number].visibility & visibility;
  };
  const auto isAskedFor = [&](uint32_t medium) {
    const std::vector<uint32_t>& names = space.media[medium].insideOf;
    return std::any_of(names.begin(), names.end(), [&](uint32_t name) { return askedFor[name] > 0; });
  };
  const auto countIn = [&](uint32_t interior, uint32_t by) {
    for (const uint32_t name : space.interiors[interior - media].names) askedFor[name] += by;
  };
  constexpr uint32_t kMinusOne = ~0u;
  constexpr float kSamePlace = 4e-6f;
  cut_.clear();
  for (size_t first = 0, last = 0; first < count; first = last) {
    const uint32_t ray = crossings_[first].ray;
    visibility = sight.of(entries[ray]);
    bool isPlain = true;
    for (; last < count && crossings_[last].ray == ray; ++last) isPlain &= isEverywhere(crossings_[last].medium);
    if (isPlain) {
      cut_.insert(cut_.end(), crossings_.begin() + long(first), crossings_.begin() + long(last));
      continue;
    }
    // From the far end: what is left without having been entered was around the ray from the beginning, and what is
    // entered without being left, through a hole in its surface, is not entered. Rays leave once where they meet an edge
    // of two triangles.
    for (size_t k = last; k-- > first;) {
      const MediumCrossing& c = crossings_[k];
      for (size_t before = k; !c.enters && before-- > first && c.t - crossings_[before].t <= kSamePlace * c.t;)
        isIgnored[k] |= crossings_[before].medium == c.medium && !crossings_[before].enters;
      if (isIgnored[k]) continue;
      if (!c.enters)
        ++depth[c.medium];
      else if (depth[c.medium] > 0)
        --depth[c.medium];
      else
        isIgnored[k] = true;
    }
    for (size_t k = first; k < last; ++k) {
      const uint32_t number = crossings_[k].medium;
      if (seenBy[number] == ray || !depth[number] || isEverywhere(number)) continue;
      seenBy[number] = ray;
      if (number < media)
        around[aroundCount++] = number;
      else
        countIn(number, 1);
    }
    for (uint32_t k = 0; k < aroundCount; ++k) isThere[around[k]] = isAskedFor(around[k]);
    for (size_t k = first; k < last; ++k) {
      const MediumCrossing& c = crossings_[k];
      const uint32_t number = c.medium;
      if (isEverywhere(number)) {
        cut_.push_back(c);
        continue;
      }
      if (isIgnored[k]) continue;
      depth[number] += c.enters ? 1 : kMinusOne;
      if (depth[number] != (c.enters ? 1u : 0u)) continue;  // another part of it is around all the same
      const auto change = [&](uint32_t medium, bool isNow) {
        if (isThere[medium] == isNow) return;
        isThere[medium] = isNow;
        cut_.push_back({ray, c.t, medium, isNow});
      };
      if (number >= media) {
        countIn(number, c.enters ? 1 : kMinusOne);
        for (uint32_t i = 0; i < aroundCount; ++i) change(around[i], isAskedFor(around[i]));
      } else if (c.enters) {
        around[aroundCount++] = number;
        change(number, isAskedFor(number));
      } else {
        change(number, false);
        *std::find(around, around + aroundCount, number) = around[aroundCount - 1];
        --aroundCount;
      }
    }
    // all that was entered is left by now, but what is everywhere was not counted
    for (size_t k = first; k < last; ++k) depth[crossings_[k].medium] = 0;
  }
  crossings_.swap(cut_);
}

}  // namespace kinora::shade
