// Where rays cross boxes that stand still: the boundaries of most media (Volume requests, grids of files), for which a
// hierarchy of triangles would take many times as long.
#pragma once
#include <cstdint>

#include "trace/world.h"

namespace kinora::shade {

struct BoxCrossingArgs {
  const float* const* o;  // of rays, render space
  const float* const* d;
  uint32_t n;
  const uint32_t* entries;  // n numbers of rays
  trace::Affine toBox;      // from render space
  float low[3], high[3];    // of the box
  float* from;              // out, by place in the list, padded(n): the part of the ray's line inside;
  float* to;                // from >= to: none. Before the ray begins distances are negative
};
using BoxCrossingKernel = void (*)(const BoxCrossingArgs&);
BoxCrossingKernel boxCrossingKernel(uint32_t width);

}  // namespace kinora::shade
