// Rays meet the lights in their way, however many there are: the same as when each light is asked by hand, with the
// probability that a sample would have had, and only where the surface that they left is lit by them.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <set>

#include "light/light_set.h"

namespace kinora::light {
namespace {

struct Ball {
  float center[3], radius;
};

bool meets(const Ball& b, const float o[3], const float d[3], float most, float* at) {
  float along = 0, c = -b.radius * b.radius;
  for (int k = 0; k < 3; ++k) {
    along += (b.center[k] - o[k]) * d[k];
    c += (b.center[k] - o[k]) * (b.center[k] - o[k]);
  }
  const float room = along * along - c;
  if (!(room >= 0) || !(c > 0)) return false;
  *at = along - std::sqrt(room);
  return *at > 0 && *at < most;
}
void sampleBall(const LightSampleArgs*) {}
void meetBall(const LightRayArgs* a) {
  for (uint32_t i = 0; i < a->count; ++i) {
    const float o[3] = {a->o[0][i], a->o[1][i], a->o[2][i]}, d[3] = {a->d[0][i], a->d[1][i], a->d[2][i]};
    float t;
    a->hit[i] = meets(*static_cast<const Ball*>(a->light[i * a->lightStride]), o, d, a->t[i], &t);
    if (a->hit[i]) a->t[i] = t;
  }
}
void shine(const LightRayArgs* a) {
  for (uint32_t i = 0; i < a->count; ++i) {
    a->pdf[i] = 2;
    for (int c = 0; c < 3; ++c) a->radiance[c][i] = 1;
  }
}
void emitBall(const LightEmitArgs*) {}

class LightsMet : public testing::TestWithParam<std::tuple<uint32_t, uint32_t>> {};

TEST_P(LightsMet, AreThoseInTheWay) {
  const auto [count, mixes] = GetParam();
  const LightFunctions functions{&sampleBall, &meetBall, &shine, &emitBall, nullptr, mixes};
  std::mt19937 random(3);
  const auto number = [&](float a, float b) { return a + (b - a) * float(random() >> 8) * 0x1p-24f; };
  std::vector<Ball> balls(count);
  std::vector<LightEntry> entries(count);
  std::vector<std::vector<uint32_t>> sets(2);
  for (uint32_t i = 0; i < count; ++i) {
    balls[i] = {{number(-4, 4), number(-4, 4), number(-4, 4)}, number(0.05f, 0.8f)};
    LightDescription& d = entries[i].description;
    std::copy(balls[i].center, balls[i].center + 3, d.center);
    d.radius = balls[i].radius;
    d.power = d.diffuse = d.specular = 1;
    entries[i].instance = &balls[i];
    sets[0].push_back(i);
    if (i % 3) sets[1].push_back(i);
  }
  LightKind kind;
  for (int w : {1, 4, 8, 16}) kind.byWidth[w] = &functions;
  const float middle[3] = {0, 0, 0};
  const LightSet set({kind}, std::move(entries), sets, middle, 10);

  constexpr uint32_t n = 300, m = 304 + kPad;
  std::vector<float> o[3], d[3], tHit(m), most(m, 1e30f), zero(m, 0.f);
  std::vector<uint32_t> slots(m), links(m), origin(m, 0);
  for (auto* v : {&o[0], &o[1], &o[2], &d[0], &d[1], &d[2]}) v->assign(m, 0.f);
  for (uint32_t i = 0; i < m; ++i) {
    slots[i] = i;
    links[i] = i % 2;
    tHit[i] = i % 5 ? INFINITY : number(1, 5);
    float l2 = 0;
    for (auto& v : o) v[i] = number(-5, 5);
    for (auto& v : d) {
      v[i] = number(-1, 1);
      l2 += v[i] * v[i];
    }
    for (auto& v : d) v[i] /= std::sqrt(l2);
  }
  for (uint32_t i = n; i < m; ++i) slots[i] = slots[n - 1];
  Rays rays{};
  for (int c = 0; c < 3; ++c) {
    rays.o[c] = o[c].data();
    rays.d[c] = d[c].data();
  }
  rays.tMax = most.data();
  rays.time = rays.radius = rays.spread = zero.data();
  const float* noNormal = zero.data();
  Arena arena;
  LightHits found;
  set.hits(8, arena, false,
           {n, slots.data(), &rays, tHit.data(), links.data(), origin.data(), {noNormal, noNormal, noNormal}},
           &found);

  std::set<std::pair<uint32_t, uint32_t>> expected, seen;
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t l = 0; l < count; ++l) {
      const float p[3] = {o[0][i], o[1][i], o[2][i]}, w[3] = {d[0][i], d[1][i], d[2][i]};
      float t;
      if ((i % 2 == 0 || l % 3) && meets(balls[l], p, w, tHit[i], &t)) expected.insert({i, l});
    }
  for (uint32_t e = 0; e < found.count; ++e) {
    EXPECT_TRUE(!e || found.slot[e - 1] <= found.slot[e]);
    seen.insert({found.slot[e], found.light[e]});
    EXPECT_GT(found.pdf[e], 0) << "a light that is met can be sampled";
    EXPECT_LE(found.pdf[e], 2.0001f);
  }
  EXPECT_EQ(seen.size(), found.count);
  EXPECT_EQ(seen, expected);
  EXPECT_GT(2 * expected.size(), count);

  // the camera sees the nearest, and nothing behind it
  const std::vector<float> before = tHit;
  set.hits(8, arena, true,
           {n, slots.data(), &rays, tHit.data(), links.data(), origin.data(), {nullptr, nullptr, nullptr}}, &found);
  std::set<uint32_t> stopped;
  for (uint32_t e = 0; e < found.count; ++e) {
    const uint32_t i = found.slot[e];
    EXPECT_TRUE(stopped.insert(i).second);
    EXPECT_TRUE(std::isinf(tHit[i]));
    for (uint32_t l = 0; l < count; ++l) {
      const float p[3] = {o[0][i], o[1][i], o[2][i]}, w[3] = {d[0][i], d[1][i], d[2][i]};
      float t;
      if (meets(balls[l], p, w, before[i], &t)) {
        EXPECT_GE(t, found.t[e]);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Among, LightsMet,
                         testing::Combine(testing::Values(5u, 8u, 9u, 40u, 500u), testing::Values(0u, 1u)));

struct Sun {
  float towards[3], cosine;
};
uint32_t sunsAsked = 0;
void shineFromFar(const LightRayArgs* a) {
  sunsAsked += a->count;
  for (uint32_t i = 0; i < a->count; ++i) {
    const Sun& s = *static_cast<const Sun*>(a->light[i * a->lightStride]);
    const float cosine = s.towards[0] * a->d[0][i] + s.towards[1] * a->d[1][i] + s.towards[2] * a->d[2][i];
    for (int c = 0; c < 3; ++c) a->radiance[c][i] = cosine >= s.cosine;
    a->pdf[i] = 1;
  }
}

// Escaped rays find the infinite lights that lie where they point, and ask few others.
TEST(InfiniteLights, AreFoundByDirection) {
  constexpr uint32_t kSuns = 1000, kSkies = 3, n = 512;
  const LightFunctions functions{&sampleBall, nullptr, &shineFromFar, &emitBall, nullptr, 1};
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  const auto direction = [&](float* out) {
    double v[3], l2 = 0;
    for (double& x : v) {
      x = normal(random);
      l2 += x * x;
    }
    for (int c = 0; c < 3; ++c) out[c] = float(v[c] / std::sqrt(l2));
  };
  std::vector<Sun> suns(kSuns + kSkies);
  std::vector<LightEntry> entries(suns.size());
  std::vector<uint32_t> all;
  for (uint32_t i = 0; i < suns.size(); ++i) {
    direction(suns[i].towards);
    const float angle = i % 5 ? 0.02f + 0.0003f * float(i % 100) : 1e-4f;
    suns[i].cosine = i < kSuns ? std::cos(angle) : -1.f;  // the last are all around
    LightDescription& d = entries[i].description;
    d.isInfinite = 1;
    d.radius = -1;
    d.power = d.diffuse = d.specular = 1;
    for (int c = 0; c < 3; ++c) d.axis[c] = i < kSuns ? suns[i].towards[c] : 0.f;
    d.cosReach = i < kSuns ? suns[i].cosine : 0.f;
    entries[i].instance = &suns[i];
    all.push_back(i);
  }
  LightKind kind;
  for (const int w : {1, 4, 8, 16}) kind.byWidth[w] = &functions;
  const float center[3] = {0, 0, 0};
  const LightSet set({kind}, std::move(entries), {all}, center, 10);
  std::vector<float> zero(n + kPad, 0.f), d[3], tHit(n + kPad), most(n + kPad, 1e30f);
  std::vector<uint32_t> slots(n + kPad);
  for (auto& x : d) x.assign(n + kPad, 0.f);
  for (uint32_t i = 0; i < n; ++i) {
    float w[3];
    direction(w);
    for (size_t c = 0; c < 3; ++c) d[c][i] = i % 2 ? w[c] : suns[i].towards[c];
    slots[i] = i;
    tHit[i] = i % 8 ? INFINITY : 3.f;
  }
  Rays rays{};
  for (int c = 0; c < 3; ++c) {
    rays.o[c] = zero.data();
    rays.d[c] = d[c].data();
  }
  rays.tMax = most.data();
  rays.time = rays.radius = rays.spread = zero.data();
  std::set<std::pair<uint32_t, uint32_t>> expected;
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t l = 0; l < suns.size() && i % 8; ++l) {
      const float cosine = suns[l].towards[0] * d[0][i] + suns[l].towards[1] * d[1][i] + suns[l].towards[2] * d[2][i];
      if (cosine >= suns[l].cosine) expected.insert({i, l});
    }
  for (const uint32_t width : {1u, 8u}) {
    Arena arena;
    LightHits found;
    sunsAsked = 0;
    set.hits(width, arena, false, {n, slots.data(), &rays, tHit.data(), nullptr, nullptr, {}}, &found);
    std::set<std::pair<uint32_t, uint32_t>> seen;
    for (uint32_t e = 0; e < found.count; ++e) seen.insert({found.slot[e], found.light[e]});
    EXPECT_EQ(seen, expected);
    EXPECT_LT(sunsAsked, n * kSkies + 4 * expected.size()) << "of " << n * suns.size();
  }
  EXPECT_GT(expected.size(), n * kSkies / 2);
}

}  // namespace
}  // namespace kinora::light
