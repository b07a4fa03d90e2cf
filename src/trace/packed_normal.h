// Unit vectors in 32 bits: normals of tessellations and planes of free space.
#pragma once
#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace kinora::trace {

// A unit vector as a point of an octahedron, 16 bits a coordinate (Z. Cigolle et al., "A Survey of Efficient
// Representations for Independent Unit Vectors", JCGT 3(2), 2014).
inline uint32_t packed(Imath::V3f n) {
  const float l1 = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
  if (!(l1 > 0)) n = Imath::V3f(0, 0, 1);
  float x = n.x / std::max(l1, 1e-30f), y = n.y / std::max(l1, 1e-30f);
  if (n.z < 0) {
    const float a = (1 - std::fabs(y)) * (x >= 0 ? 1.f : -1.f), b = (1 - std::fabs(x)) * (y >= 0 ? 1.f : -1.f);
    x = a;
    y = b;
  }
  const auto round = [](float v) {
    return uint32_t(int32_t(std::floor(std::clamp(v, -1.f, 1.f) * 32767.f + 0.5f)) & 0xffff);
  };
  return round(x) | round(y) << 16;
}

inline Imath::V3f unpacked(uint32_t p) {
  float x = float(int16_t(uint16_t(p & 0xffff))) / 32767.f, y = float(int16_t(uint16_t(p >> 16))) / 32767.f;
  const float z = 1 - std::fabs(x) - std::fabs(y);
  if (z < 0) {
    const float a = (1 - std::fabs(y)) * (x >= 0 ? 1.f : -1.f), b = (1 - std::fabs(x)) * (y >= 0 ? 1.f : -1.f);
    x = a;
    y = b;
  }
  const float l = std::sqrt(x * x + y * y + z * z);
  return {x / l, y / l, z / l};
}

}  // namespace kinora::trace
