// The offset against its formula, at every width with the same bits.
#include <gtest/gtest.h>
#include <kinora/displacement.h>
#include <kinora/testing/test_context.h>

#include <cmath>
#include <cstring>

#include "plugin/registry.h"

namespace kinora {
namespace {

const Descriptor& plugin() {
  for (const Descriptor* d : stockPlugins())
    if (!std::strcmp(d->name, "PxrDisplace")) return *d;
  throw "PxrDisplace is not there";
}

std::vector<float> offsets(const std::string& text, uint32_t width) {
  testing::Setting setting;
  std::string error;
  EXPECT_TRUE(testing::parseSetting(plugin(), text, setting, error)) << error;
  testing::TestPoints points;
  points.P.clear();
  points.N.clear();
  for (int i = 0; i < 21; ++i) {
    points.P.push_back({float(i), 0, 0});
    points.N.push_back({std::sin(float(i)), 0, std::cos(float(i))});
  }
  testing::TestContextOptions options;
  options.width = width;
  testing::TestContext c(plugin(), setting, points, options);
  float* out[3] = {c.floats(21), c.floats(21), c.floats(21)};
  static_cast<const DisplacementFunctions*>(functionsFor(plugin(), width))->displace(&c.context(), out);
  std::vector<float> all;
  for (int k = 0; k < 3; ++k) all.insert(all.end(), out[k], out[k] + 21);
  return all;
}

TEST(PxrDisplace, IsItsFormulaAtEveryWidth) {
  const std::string text = "dispAmount=2; dispScalar=0.25; dispVector=0.5 0 1; modelDispVector=0 0.125 0";
  const std::vector<float> one = offsets(text, 1);
  for (int i = 0; i < 21; ++i) {
    EXPECT_NEAR(one[size_t(i)], 2 * (0.25f * std::sin(float(i)) + 0.5f), 1e-6);
    EXPECT_NEAR(one[size_t(21 + i)], 0.25, 1e-6);
    EXPECT_NEAR(one[size_t(42 + i)], 2 * (0.25f * std::cos(float(i)) + 1), 1e-6);
  }
  for (uint32_t width : {4u, 8u, 16u}) EXPECT_EQ(offsets(text, width), one) << width;
}

TEST(PxrDisplace, SwitchedOffItMovesNothing) {
  for (float v : offsets("enabled=0; dispScalar=1; dispVector=1 1 1", 8)) EXPECT_EQ(v, 0.f);
}

}  // namespace
}  // namespace kinora
