// Rays that pass surfaces before they end: where they began, so that each is afterwards again the one that left its
// vertex, with the distance of its hit from there. Used where GroupState looks for nearest hits.
#pragma once
#include <kinora/integrator.h>

#include "base/arena.h"

namespace kinora::shade {

class PassedRays {
 public:
  PassedRays(Arena& arena, const RayList& list, uint32_t n, const uint32_t* entries)
      : arena_(arena), list_(list), n_(n), entries_(entries) {}
  // Before the m listed rays go on. By entry: how far its ray has come, which GroupState::passThrough adds to.
  float* remember(uint32_t m, const uint32_t* onward) {
    if (!passed_) {
      passed_ = arena_.make<float>(list_.capacity);
      for (float*& o : o_) o = arena_.make<float>(list_.capacity);
      tMax_ = arena_.make<float>(list_.capacity);
      radius_ = arena_.make<float>(list_.capacity);
      for (uint32_t i = 0; i < n_; ++i) passed_[entries_[i]] = 0;
    }
    for (uint32_t i = 0; i < m; ++i) {
      const uint32_t s = onward[i];
      if (passed_[s] > 0) continue;
      for (int c = 0; c < 3; ++c) o_[c][s] = list_.rays.o[c][s];
      tMax_[s] = list_.rays.tMax[s];
      radius_[s] = list_.rays.radius[s];
    }
    return passed_;
  }
  void restore() {
    for (uint32_t i = 0; passed_ && i < n_; ++i) {
      const uint32_t s = entries_[i];
      if (!(passed_[s] > 0)) continue;
      for (int c = 0; c < 3; ++c) list_.rays.o[c][s] = o_[c][s];
      list_.rays.tMax[s] = tMax_[s];
      list_.rays.radius[s] = radius_[s];
      list_.hits.t[s] += passed_[s];
    }
  }

 private:
  Arena& arena_;
  const RayList& list_;
  uint32_t n_;
  const uint32_t* entries_;
  float *o_[3] = {}, *tMax_ = nullptr, *radius_ = nullptr, *passed_ = nullptr;
};

}  // namespace kinora::shade
