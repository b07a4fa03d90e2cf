// Alpha of what is seen through glass, for integrators: camera paths that were only refracted on their way, and met
// nothing behind, cover their pixel by what the glass has taken instead of all of it. Infinite lights are nothing, as
// they are where the camera sees them directly.
#pragma once
#include <kinora/integrator.h>

#include <cstring>

namespace kinora {

class RefractedAlpha {
 public:
  RefractedAlpha(Group* group, const Services* services) : g_(group), sv_(services) {
    through_ = static_cast<float*>(sv_->alloc(g_, g_->padded * sizeof(float)));
    std::memset(through_, 0, g_->padded * sizeof(float));
  }
  // A path that escaped; what it carries of the light that comes from there, over the camera's weight.
  void add(uint32_t slot, const float throughput[3]) {
    through_[slot] += (throughput[0] + throughput[1] + throughput[2]) * (1.f / 3.f) / g_->rayWeight[slot];
  }
  // When all paths have ended: alpha of those samples. Chance may have let more through than there was, so that it is
  // below 0: on average it is right.
  void cover() const {
    auto* slots = static_cast<uint32_t*>(sv_->alloc(g_, (g_->count + kPad) * sizeof(uint32_t)));
    auto* alpha = static_cast<float*>(sv_->alloc(g_, (g_->count + kPad) * sizeof(float)));
    uint32_t n = 0;
    for (uint32_t i = 0; i < g_->count; ++i)
      if (through_[i] != 0) {
        slots[n] = i;
        alpha[n++] = 1.f - through_[i];
      }
    if (n) sv_->cover(g_, n, slots, alpha);
  }

 private:
  Group* g_;
  const Services* sv_;
  float* through_;
};

}  // namespace kinora
