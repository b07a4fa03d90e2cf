// Light filters in a light set: the same factor for a light sample and for a ray that meets the light from the same
// point, infinite lights infinitely far in both, and only uniform factors on emitted light. Lights here are made by
// hand; sampling itself is the lights' own tests' business.
#include "light/light_set.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace kinora::light {
namespace {

constexpr float kAway = 2;  // where the light stands, along z

void sampleOne(const LightSampleArgs* a) {
  const bool infinite = a->light[0] != nullptr;
  for (uint32_t i = 0; i < a->count; ++i) {
    for (int c = 0; c < 3; ++c) a->wi[c][i] = c == 2, a->radiance[c][i] = float(c + 1);
    a->distance[i] = infinite ? INFINITY : kAway;
    a->pdf[i] = 1;
    a->flags[i] = 0;
  }
}
void meet(const LightRayArgs* a) {
  for (uint32_t i = 0; i < a->count; ++i) a->t[i] = kAway, a->hit[i] = 1;
}
void shine(const LightRayArgs* a) {
  for (uint32_t i = 0; i < a->count; ++i)
    for (int c = 0; c < 3; ++c) a->radiance[c][i] = float(c + 1), a->pdf[i] = 1;
}
void emit(const LightEmitArgs* a) {
  for (uint32_t i = 0; i < a->count; ++i) {
    for (int c = 0; c < 3; ++c) a->o[c][i] = 0, a->d[c][i] = a->N[c][i] = c == 2, a->radiance[c][i] = 1;
    a->pdfPosition[i] = a->pdfDirection[i] = 1;
  }
}
constexpr LightFunctions kLight{&sampleOne, &meet, &shine, &emit, nullptr, 0};

// Everything that a filter is told goes into the factor.
void tell(const void*, const LightFilterArgs* a) {
  for (uint32_t i = 0; i < a->count; ++i) {
    a->factor[0][i] = 1 + a->P[0][i] * a->P[0][i];
    a->factor[1][i] = 1 + 3 * a->wi[2][i];
    a->factor[2][i] = std::isinf(a->distance[i]) ? 100 : a->distance[i];
  }
}
constexpr LightFilterFunctions kTell{&tell};
void halve(const void*, const LightFilterArgs* a) {
  for (uint32_t i = 0; i < a->count; ++i)
    for (int c = 0; c < 3; ++c) a->factor[c][i] = 0.5f;
}
constexpr LightFilterFunctions kHalve{&halve};

// areTold: they have a filter beside the uniform one.
LightSet lights(int count, bool infinite, bool areTold = true) {
  std::vector<LightEntry> list;
  std::vector<uint32_t> all;
  for (int k = 0; k < count; ++k) {
    LightEntry e;
    LightFilterEntry told, half;
    for (int w : {1, 4, 8, 16}) told.byWidth[w] = &kTell, half.byWidth[w] = &kHalve;
    half.isUniform = true;
    e.instance = infinite ? &kLight : nullptr;
    e.description = {};
    e.description.center[2] = kAway;
    e.description.radius = infinite ? -1.f : 100.f;
    e.description.power = e.description.diffuse = e.description.specular = 1;
    e.description.isInfinite = infinite;
    e.filters = {half};
    if (areTold) e.filters.insert(e.filters.begin(), told);
    list.push_back(e);
    all.push_back(uint32_t(k));
  }
  const float center[3] = {0, 0, 0};
  LightKind kind;
  for (int w : {1, 4, 8, 16}) kind.byWidth[w] = &kLight;
  return LightSet({kind}, std::move(list), {all}, center, 10);
}

class LightFilters : public testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(LightFilters, SamplesAndHitsAgree) {
  const auto [count, infinite] = GetParam();
  const LightSet set = lights(count, infinite);
  constexpr uint32_t n = 5, m = 16;
  alignas(64) float x[m], zero[m] = {}, half[m], t[m], dir[3][m], most[m];
  uint32_t slots[m];
  for (uint32_t i = 0; i < m; ++i) {
    x[i] = float(std::min(i, n - 1));
    half[i] = (float(i) + 0.5f) / m;
    t[i] = INFINITY;
    most[i] = 1e30f;
    slots[i] = i;
    for (int c = 0; c < 3; ++c) dir[c][i] = c == 2;
  }
  Arena arena;
  LightSamples s;
  set.sample(8, arena, {n, m, {x, zero, zero}, {}, zero, nullptr, {half, half}, {half, half}}, &s);
  Rays rays{};
  rays.o[0] = x;
  rays.o[1] = rays.o[2] = zero;
  for (int c = 0; c < 3; ++c) rays.d[c] = dir[c];
  rays.tMax = most;
  rays.time = rays.radius = rays.spread = zero;
  LightHits h;
  set.hits(8, arena, false, {n, slots, &rays, t, nullptr, nullptr, {}}, &h);
  ASSERT_EQ(h.count, n * uint32_t(count));
  for (uint32_t e = 0; e < h.count; ++e) {
    const uint32_t i = h.slot[e];
    const float expected[3] = {0.5f * (1 + x[i] * x[i]), 0.5f * 2 * 4, 0.5f * 3 * (infinite ? 100 : kAway)};
    for (int c = 0; c < 3; ++c) {
      EXPECT_FLOAT_EQ(h.radiance[c][e], expected[c]) << i;
      EXPECT_FLOAT_EQ(s.radiance[c][i], expected[c]) << i;
    }
  }
}

// Light paths start at lights whose filters are the same everywhere, and at no others.
TEST_P(LightFilters, EmittedLightTakesUniformFactorsAlone) {
  const auto [count, infinite] = GetParam();
  const LightSet set = lights(count, infinite, false), told = lights(count, infinite);
  alignas(64) float u[16], time[16] = {}, o[3][16], d[3][16];
  for (int i = 0; i < 16; ++i) u[i] = (float(i) + 0.5f) / 16;
  const float* four[4] = {u, u, u, u};
  float *po[3] = {o[0], o[1], o[2]}, *pd[3] = {d[0], d[1], d[2]};
  Arena arena;
  EmittedLight e;
  set.emit(8, arena, 7, u, four, time, po, pd, &e);
  for (int i = 0; i < 7; ++i) {
    for (int c = 0; c < 3; ++c)
      EXPECT_FLOAT_EQ(e.throughput[c][i], 0.5f * float(count));  // one of `count` was chosen
    EXPECT_FLOAT_EQ(e.pdfPosition[i], 1.f / float(count));
    EXPECT_EQ(e.pdfDirection[i], 1.f);
    EXPECT_EQ(e.flags[i], infinite ? kLightIsInfinite : 0u);
  }
  told.emit(8, arena, 7, u, four, time, po, pd, &e);
  for (int i = 0; i < 7; ++i)
    for (int c = 0; c < 3; ++c) EXPECT_EQ(e.throughput[c][i], 0);
}

INSTANTIATE_TEST_SUITE_P(All, LightFilters, testing::Combine(testing::Values(1, 3), testing::Bool()));

}  // namespace
}  // namespace kinora::light
