// The sRGB transfer function (IEC 61966-2-1), evaluated at set-up in double precision; pixels only look thresholds
// up.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "image/read_write.h"

namespace kinora::image {
namespace {

double srgbToLinear(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

// thresholds[k]: the least float that encodes to more than k, i.e. the decoded k + 1/2. Rounded to a multiple of
// 2^-30, far coarser than any difference between math libraries.
std::vector<float> thresholds(int levels) {
  std::vector<float> t(size_t(levels) - 1);
  for (size_t k = 0; k < t.size(); ++k)
    t[k] = float(std::round(std::ldexp(srgbToLinear((double(k) + 0.5) / (levels - 1)), 30)) * std::ldexp(1.0, -30));
  return t;
}

int encode(const std::vector<float>& table, float linear) {
  if (!(linear > 0)) return 0;
  return int(std::upper_bound(table.begin(), table.end(), linear) - table.begin());
}

}  // namespace

uint8_t encodeSrgb8(float linear) {
  static const std::vector<float> table = thresholds(256);
  return uint8_t(encode(table, linear));
}
uint16_t encodeSrgb16(float linear) {
  static const std::vector<float> table = thresholds(65536);
  return uint16_t(encode(table, linear));
}
float decodeSrgb(float encoded) { return float(srgbToLinear(encoded)); }

uint8_t quantize8(float v) { return !(v > 0) ? 0 : v >= 1 ? 255 : uint8_t(v * 255.0f + 0.5f); }

}  // namespace kinora::image
