// Time for statistics, limits and tests, in seconds: of the clock on the wall, and of a thread.
#pragma once
#include <ctime>

#include <chrono>

namespace kinora {

inline double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// CPU time of this thread, from any beginning: what others do beside it does not count.
inline double threadSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

}  // namespace kinora
