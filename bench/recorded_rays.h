// The rays of a render, kept as they were traced: by call of a group, with their kind and depth. Filled by the
// renderer's hook; read by BareEmbree.
#pragma once
#include <vector>

#include "shade/ray_listener.h"

namespace kinora::bench {

struct RayBatch {
  bool shadow = false;
  uint32_t depth = 0;  // 0: camera rays, or shadow rays of camera hits
  size_t first = 0;
  uint32_t count = 0;
};

class RecordedRays : public shade::RayListener {
 public:
  bool isRecording = false;
  void closest(RayKind kind, uint32_t depth, const Rays& rays, uint32_t n, const uint32_t* slots) override;
  void shadow(uint32_t depth, const ShadowRays& rays) override;
  const std::vector<RayBatch>& batches() const { return batches_; }
  // origin x y z, direction x y z, largest distance, time
  const float* column(int c) const { return data_[c].data(); }
  size_t count() const { return data_[0].size(); }

 private:
  std::vector<float> data_[8];
  std::vector<RayBatch> batches_;
};

}  // namespace kinora::bench
