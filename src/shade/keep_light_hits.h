// A list of lights met by rays, made shorter. Used where a group of rays learns more about what stands in their way.
#pragma once
#include <kinora/integrator.h>

#include "base/arena.h"

namespace kinora::shade {

// Leaves the entries for which keep(index) holds, in their order, in arrays of the arena.
template <class Keep>
void keepLightHits(Arena& arena, LightHits* hits, Keep&& keep) {
  const LightHits all = *hits;
  const uint32_t room = padded(all.count) + kPad;
  uint32_t* from = arena.make<uint32_t>(room);
  uint32_t m = 0;
  for (uint32_t i = 0; i < all.count; ++i)
    if (keep(i)) from[m++] = i;
  const auto taken = [&]<class T>(const T* values) -> const T* {
    T* to = arena.make<T>(room);
    for (uint32_t i = 0; i < m; ++i) to[i] = values[from[i]];
    return to;
  };
  if (!all.count) return;
  hits->count = m;
  hits->slot = taken(all.slot);
  for (int c = 0; c < 3; ++c) {
    hits->radiance[c] = taken(all.radiance[c]);
    if (all.specularRadiance[c]) hits->specularRadiance[c] = taken(all.specularRadiance[c]);
  }
  hits->pdf = taken(all.pdf);
  hits->t = taken(all.t);
  hits->diffuse = taken(all.diffuse);
  hits->specular = taken(all.specular);
  hits->light = taken(all.light);
  hits->blocks = taken(all.blocks);
}

}  // namespace kinora::shade
