// Adds the time from here to the end of a scope to a counter; taken once a call for a whole group.
#pragma once
#include <chrono>
#include <cstdint>

namespace kinora::shade {

struct Clock {
  uint64_t& sum;
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  explicit Clock(uint64_t& s) : sum(s) {}
  ~Clock() {
    sum += uint64_t(
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - start).count());
  }
};

}  // namespace kinora::shade
