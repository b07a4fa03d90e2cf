// The wide kernel that finds which rays of a list may meet a light, and packs them. Internal to light/.
#pragma once
#include <kinora/integrator.h>

namespace kinora::light {

struct NearRaysArgs {
  uint32_t n;
  const uint32_t* slots;
  const Rays* rays;          // by slot
  const float* tHit;         // by slot
  bool infinite;             // the light is met by rays that hit nothing
  float center[3], radius2;  // else: by those that come near this sphere
  // out, packed, room for n and a full vector more
  float *o[3], *d[3], *time, *t;  // t: where the ray ends
  uint32_t* which;                // index in the list
};
using NearRaysKernel = uint32_t (*)(const NearRaysArgs&);  // how many
NearRaysKernel nearRaysKernel(uint32_t width);

}  // namespace kinora::light
