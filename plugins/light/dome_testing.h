// Latitude-longitude maps for the tests of lights that show one, and their lookup in double precision.
#pragma once
#include <algorithm>

#include "plugins/light/light_testing.h"

namespace kinora::lightTesting {

constexpr double kPi = 3.14159265358979;

struct Picture {
  uint32_t w, h;
  std::vector<float> texels;
  HostImage image;
  Picture(uint32_t width, uint32_t height, float (*f)(double u, double v, int c)) : w(width), h(height) {
    for (uint32_t y = 0; y < h; ++y)
      for (uint32_t x = 0; x < w; ++x)
        for (int c = 0; c < 3; ++c) texels.push_back(f((x + 0.5) / w, (y + 0.5) / h, c));
    image = {texels.data(), w, h, 3};
  }
};
inline float smooth(double u, double v, int c) {
  return float(1 + 0.5 * std::sin(6.2831853 * u + c) + std::cos(3.1415926 * v) * 0.4);
}
inline float sun(double u, double v, int c) {
  return std::fabs(u - 0.3) < 0.006 && std::fabs(v - 0.2) < 0.01 ? 5000.f : float(0.02 + 0.1 * (c == 2) * (v < 0.5));
}
inline float patches(double u, double v, int c) {  // large black parts with hard edges
  return (u > 0.9 || u < 0.05 || (u > 0.4 && u < 0.5)) && v > 0.1 && v < 0.6 ? float(1 + c) : 0.f;
}

// What the light's text says, in double precision.
inline double lookUp(const Picture& p, Vec d) {
  double u = -std::atan2(d[1], d[0]) / (2 * kPi);
  u -= std::floor(u);
  const double v = std::acos(std::fmin(1, std::fmax(-1, d[2]))) / kPi;
  const double x = u * p.w - 0.5, y = v * p.h - 0.5;
  const auto texel = [&](int i, int j) {
    i = ((i % int(p.w)) + int(p.w)) % int(p.w);
    j = std::min(std::max(j, 0), int(p.h) - 1);
    double sum = 0;
    for (int c = 0; c < 3; ++c) sum += p.texels[(size_t(j) * p.w + size_t(i)) * 3 + size_t(c)] / 3;
    return sum;
  };
  const int i = int(std::floor(x)), j = int(std::floor(y));
  const double a = x - i, b = y - j;
  return (texel(i, j) * (1 - a) + texel(i + 1, j) * a) * (1 - b) +
         (texel(i, j + 1) * (1 - a) + texel(i + 1, j + 1) * a) * b;
}

}  // namespace kinora::lightTesting
