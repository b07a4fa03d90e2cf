// What a homogeneous absorber lets through, by our own exponential: the same bits with every C library. Called by the
// media stack for one segment at a time; it knows no geometry.
#pragma once
#include <cstdint>

namespace kinora::shade {

inline constexpr float kOpaqueDepth = 100;  // from which on nothing comes through: e^-88 is the least normal number
// exp(-absorption * distance); 1 without absorption, 0 over an endless way. absorption >= 0, per unit of distance.
float beerLambert(float absorption, float distance);
// In place: the same of optical depths from 0 on, exp(-depth), by kernels of that width. Padded to kPad elements.
void letThrough(uint32_t width, uint32_t n, float* depth);
// The optical depth at which a ray ends that u in [0, 1) was drawn for: -log(1 - u).
float freeDepth(float u);

}  // namespace kinora::shade
