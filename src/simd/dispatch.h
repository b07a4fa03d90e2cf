// What this CPU can run, asked once. KINORA_HIDE_AVX512=1 in the environment hides AVX-512, for tests of equal bits.
#pragma once
#include <cstdint>

namespace kinora {

bool cpuHasAvx2();     // AVX2, FMA, BMI2 and F16C: the least that Kinora runs on
bool cpuHasAvx512();   // F, VL, DQ, BW
uint32_t bestWidth();  // 16 with AVX-512, else 8
// Flush-to-zero and denormals-are-zero for this thread: part of the "same bits" contract, and Embree's advice.
void setThreadFloatMode();

// A kernel's instance for a width: 1, 4, 8 or 16.
template <class Kernel>
Kernel kernelFor(uint32_t width, Kernel one, Kernel four, Kernel eight, Kernel sixteen) {
  return width == 1 ? one : width == 4 ? four : width == 16 ? sixteen : eight;
}

}  // namespace kinora
