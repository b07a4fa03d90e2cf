// The factor from the parameters, and that a wrong number is refused. That samples and hits take it alike is tested
// in src/light and tests/filters.
#include <gtest/gtest.h>
#include <kinora/light_filter.h>

#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "plugin/registry.h"

namespace kinora {
namespace {

// Factor at some points; empty when create() refuses.
std::vector<float> factor(const std::map<std::string, std::vector<float>>& given, uint32_t width = 8) {
  const Descriptor* d = nullptr;
  for (const Descriptor* k : stockPlugins())
    if (!std::strcmp(k->name, "PxrIntMultLightFilter")) d = k;
  std::vector<ParamValue> values(d->paramCount);
  for (uint32_t i = 0; i < d->paramCount; ++i) {
    const auto it = given.find(d->params[i].name);
    values[i].floats = it == given.end() ? d->params[i].value : it->second.data();
    values[i].strings = &d->params[i].text;
    values[i].count = it == given.end() ? (d->params[i].type == Type::Color ? 3 : 1) : uint32_t(it->second.size());
  }
  Host host{nullptr, [](void*, const char*, const char*, const char*) {}, nullptr};
  const CreateInfo info{&host, "f", values.data(), d->paramCount, nullptr, nullptr};
  ErrorText error{};
  void* f = d->create(&info, &error);
  if (!f) return {};
  alignas(64) float zero[16] = {}, out[3][16];
  const LightFilterArgs a{3, {zero, zero, zero}, {zero, zero, zero}, zero, zero, {out[0], out[1], out[2]}};
  static_cast<const LightFilterFunctions*>(functionsFor(*d, width))->factor(f, &a);
  d->destroy(f);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(out[c][0], out[c][2]);
  return {out[0][1], out[1][1], out[2][1]};
}

TEST(PxrIntMultLightFilter, FactorsFollowTheParameters) {
  using V = std::vector<float>;
  EXPECT_EQ(factor({}), (V{1, 1, 1}));
  EXPECT_EQ(factor({{"intensity", {3}}, {"exposure", {1}}}), (V{6, 6, 6}));
  EXPECT_EQ(factor({{"tint", {1, 0.5f, 0}}}), (V{1, 0.5f, 0}));
  EXPECT_EQ(factor({{"intensity", {3}}, {"density", {0.25f}}}), (V{1.5f, 1.5f, 1.5f}));
  EXPECT_EQ(factor({{"intensity", {3}}, {"density", {0.25f}}, {"invert", {1}}}), (V{2.5f, 2.5f, 2.5f}));
  EXPECT_EQ(factor({{"intensity", {-1}}}), (V{0, 0, 0})) << "light is not negative";
  EXPECT_TRUE(factor({{"intensity", {3e38f}}, {"exposure", {10}}}).empty());
  for (uint32_t width : {1u, 4u, 16u})
    EXPECT_EQ(factor({{"intensity", {0.3f}}}, width), factor({{"intensity", {0.3f}}}));
}

}  // namespace
}  // namespace kinora
