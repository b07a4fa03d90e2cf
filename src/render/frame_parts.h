// What the files of Frame share: frame.cpp (passes, stages, workers), frame_groups.cpp (a group's rays, and its records
// as pixels) and frame_replay.cpp (one sample again, in words).
#pragma once
#include <array>
#include <chrono>
#include <vector>

#include "render/frame.h"

namespace kinora::render {

inline constexpr int kBlock = ActivePixels::kSide;

inline uint64_t now() {
  return uint64_t(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
          .count());
}

struct Frame::Times {
  std::vector<std::array<uint64_t, 4>> byWorker;  // camera rays, integrator, film, groups
  uint64_t samples = 0;
};

}  // namespace kinora::render
