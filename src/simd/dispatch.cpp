#include "simd/dispatch.h"

#include <cstdlib>
#include <xmmintrin.h>

namespace kinora {

bool cpuHasAvx2() {
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
#if !defined(__clang__)  // clang 14, which builds the fuzzers, does not know the name
                          __builtin_cpu_supports("f16c") &&
#endif
                          __builtin_cpu_supports("bmi2");
  return has;
}

bool cpuHasAvx512() {
  static const bool has = [] {
    const char* hide = std::getenv("KINORA_HIDE_AVX512");
    if (hide && *hide && *hide != '0') return false;
    return cpuHasAvx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
  }();
  return has;
}

uint32_t bestWidth() { return cpuHasAvx512() ? 16 : 8; }

void setThreadFloatMode() { _mm_setcsr(_mm_getcsr() | 0x8040); }

}  // namespace kinora
