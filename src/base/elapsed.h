// Wall-clock time for statistics, limits and tests, in seconds.
#pragma once
#include <chrono>

namespace kinora {

inline double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace kinora
