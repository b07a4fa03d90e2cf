// What tests of materials for fibres share: a fibre along y, azimuths from z towards x, seen from azimuth 0 at offsets across
// it; Fresnel's reflectance; what the fibre as a whole sends from one direction to another.
#pragma once
#include <gtest/gtest.h>
#include <kinora/testing/statistics.h>

#include "testing/bound_bxdf.h"

namespace kinora::testing::hair {

constexpr double kPi = 3.14159265358979, kDegree = kPi / 180;

inline Setting settingOf(const Descriptor& d, const std::string& text) {
  Setting s;
  std::string error;
  EXPECT_TRUE(parseSetting(d, text, s, error)) << error;
  return s;
}
inline const WidthTable& widest(const Descriptor& d) { return *runnableTables(d).back(); }

inline Vec3 direction(double inclination, double azimuth) {
  return {float(std::cos(inclination) * std::sin(azimuth)), float(std::sin(inclination)),
          float(std::cos(inclination) * std::cos(azimuth))};
}
inline TestPoints fibre(double inclination, const std::vector<double>& normals) {
  TestPoints p;
  p.tangent = {{1, 0, 0}};
  p.bitangent = {{0, 1, 0}};
  p.wo = {direction(inclination, 0)};
  p.N.clear();
  for (const double azimuth : normals) p.N.push_back(direction(0, azimuth));
  return p;
}
inline double reflectance(double cosine, double ior) {
  const double s2 = (1 - cosine * cosine) / (ior * ior), t = std::sqrt(1 - s2);
  const double rs = (cosine - ior * t) / (cosine + ior * t), rp = (ior * cosine - t) / (ior * cosine + t);
  return (rs * rs + rp * rp) / 2;
}
inline double albedoOf(const Descriptor& d, const Setting& s, double inclination, double azimuth, int channel) {
  const BoundBxdf b(d, widest(d), s, fibre(inclination, {azimuth}));
  std::vector<float> rgb[3];
  float* rows[3];
  for (int k = 0; k < 3; ++k) {
    rgb[k].assign(b.context().padded, 0);
    rows[k] = rgb[k].data();
  }
  b.functions().albedo(&b.context(), b.context().closure, rows);
  return rgb[channel][0];
}
// Each sees the fibre's offsets evenly, and a width in proportion to the cosine of its inclination.
inline double wholeFibre(const Descriptor& d, const Setting& s, double from, double to, double azimuth,
                         uint32_t traits) {
  constexpr int kOffsets = 4096;
  std::vector<double> normals;
  for (int i = 0; i < kOffsets; ++i) normals.push_back(std::asin(-1 + (i + 0.5) * 2 / kOffsets));
  TestContextOptions options;
  options.traits = traits;
  options.slots = Slots::One;
  const BoundBxdf b(d, widest(d), s, fibre(from, normals), options);
  Evaluation e(kOffsets);
  for (uint32_t i = 0; i < kOffsets; ++i) e.set(i, direction(to, azimuth));
  b.evaluate(e);
  double sum = 0;
  for (uint32_t i = 0; i < kOffsets; ++i) sum += e.weight(0, 1, i);
  return sum / kOffsets * std::cos(from);
}

}  // namespace kinora::testing::hair
