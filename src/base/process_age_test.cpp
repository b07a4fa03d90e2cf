// Proves: the age grows as the wall clock does and counts from before main(). Misses: containers that hide /proc.
#include "base/process_age.h"

#include <gtest/gtest.h>
#include <time.h>

#include <chrono>
#include <thread>

namespace kinora {
namespace {

TEST(ProcessAge, GrowsWithTheClock) {
  const auto start = std::chrono::steady_clock::now();
  const double a = processAge();
  std::this_thread::sleep_for(std::chrono::milliseconds(120));
  const double b = processAge(),
               waited = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ASSERT_GE(a, 0);
  EXPECT_GE(b - a, 0.1);  // ticks are 10 ms
  EXPECT_LE(b - a, waited + 0.01);
}

TEST(ProcessAge, IsAtLeastTheCpuTimeOfOneThread) {
  timespec t{};
  ASSERT_EQ(clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t), 0);
  const double cpu = double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
  EXPECT_GE(processAge() + 0.02, cpu);
}

}  // namespace
}  // namespace kinora
