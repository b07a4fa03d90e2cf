// The programs of the family "shading" as a person would write them in C++ for speed: one loop over vectors of
// points, everything in registers, on the public width type and the language's own functions. Same values as the
// machine's.
#pragma once
#include <cstdint>

namespace kinora::bench {

struct FusedArguments {
  uint32_t points = 0;
  const float *P[3], *Pdx[3], *Pdy[3];
  const float *u, *v, *udx, *udy, *vdx, *vdy;
  float* result[3];
  // Filtered lookups of a picture for n points, n a multiple of 16: s, t, half the footprint, colour and alpha.
  void (*lookup)(void* textures, uint32_t n, const float* s, const float* t, const float* radius,
                 float* const rgba[4]) = nullptr;
  void* textures = nullptr;
};
using Fused = void (*)(const FusedArguments&);
struct FusedProgram {
  const char* name;
  const char* source;  // OSL with the same meaning; its output is `result`
  Fused widths[4];     // 1, 4, 8, 16
};
const FusedProgram* fusedPrograms(uint32_t& count);

}  // namespace kinora::bench
