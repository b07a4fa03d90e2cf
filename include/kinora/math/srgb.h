// The sRGB transfer function (IEC 61966-2-1) for pictures of 8 and 16 bits. Used by display drivers and by
// src/image/. Codes are found by exact thresholds, so that a pixel's code does not depend on the CPU or the math
// library. It is for writing files, not for shading.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kinora {

inline double srgbToLinear(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

// thresholds[k]: the least value that encodes to more than k, i.e. the decoded k + 1/2. Rounded to a multiple of
// 2^-30, far coarser than any difference between math libraries.
class SrgbEncoder {
 public:
  explicit SrgbEncoder(int codes) : thresholds_(size_t(codes) - 1) {
    for (size_t k = 0; k < thresholds_.size(); ++k)
      thresholds_[k] =
          float(std::round(std::ldexp(srgbToLinear((double(k) + 0.5) / (codes - 1)), 30)) * std::ldexp(1.0, -30));
  }
  // NaN and negative values give 0.
  uint32_t encode(float linear) const {
    if (!(linear > 0)) return 0;
    return uint32_t(std::upper_bound(thresholds_.begin(), thresholds_.end(), linear) - thresholds_.begin());
  }

 private:
  std::vector<float> thresholds_;
};

// Code of a value that is not a colour (alpha): rounded half up, clamped; NaN gives 0.
inline uint32_t quantizeLinear(float v, uint32_t most) {
  return !(v > 0) ? 0 : v >= 1 ? most : uint32_t(v * float(most) + 0.5f);
}

}  // namespace kinora
