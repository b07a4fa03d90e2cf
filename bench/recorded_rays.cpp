#include "recorded_rays.h"

namespace kinora::bench {

void RecordedRays::closest(RayKind, uint32_t depth, const Rays& rays, uint32_t n, const uint32_t* slots) {
  if (!isRecording) return;
  batches_.push_back({false, depth, count(), n});
  for (int c = 0; c < 3; ++c)
    for (uint32_t i = 0; i < n; ++i) {
      data_[c].push_back(rays.o[c][slots[i]]);
      data_[3 + c].push_back(rays.d[c][slots[i]]);
    }
  for (uint32_t i = 0; i < n; ++i) {
    data_[6].push_back(rays.tMax[slots[i]]);
    data_[7].push_back(rays.time[slots[i]]);
  }
}

void RecordedRays::shadow(uint32_t depth, const ShadowRays& rays) {
  if (!isRecording) return;
  batches_.push_back({true, depth, count(), rays.count});
  for (int c = 0; c < 3; ++c) {
    data_[c].insert(data_[c].end(), rays.o[c], rays.o[c] + rays.count);
    data_[3 + c].insert(data_[3 + c].end(), rays.d[c], rays.d[c] + rays.count);
  }
  data_[6].insert(data_[6].end(), rays.tMax, rays.tMax + rays.count);
  data_[7].insert(data_[7].end(), rays.time, rays.time + rays.count);
}

}  // namespace kinora::bench
