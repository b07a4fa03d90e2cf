// Choice among lights: drawn as often as is said, never without a chance where a light reaches, the same at all
// widths, and of use: sampling follows what lights bring to the point.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "light/light_set.h"
#include "simd/dispatch.h"

namespace kinora::light {
namespace {

// Lights that answer nothing: choice asks descriptions alone.
void sampleNothing(const LightSampleArgs* a) {
  for (uint32_t i = 0; i < a->count; ++i) {
    for (int c = 0; c < 3; ++c) a->wi[c][i] = c == 2, a->radiance[c][i] = 1;
    a->distance[i] = 1;
    a->pdf[i] = 1;
    a->flags[i] = 0;
  }
}
void meetNothing(const LightRayArgs* a) { std::fill_n(a->hit, a->count, 0u); }
void evaluateNothing(const LightRayArgs*) {}
void emitNothing(const LightEmitArgs*) {}
constexpr LightFunctions kSilent{&sampleNothing, &meetNothing, &evaluateNothing, &emitNothing, nullptr, 1};

LightSet setOf(const std::vector<LightDescription>& descriptions, std::vector<std::vector<uint32_t>> sets = {}) {
  LightKind kind;
  for (int w : {1, 4, 8, 16}) kind.byWidth[w] = &kSilent;
  std::vector<LightEntry> list;
  std::vector<uint32_t> all;
  for (const LightDescription& d : descriptions) {
    LightEntry e;
    e.description = d;
    all.push_back(uint32_t(list.size()));
    list.push_back(std::move(e));
  }
  sets.insert(sets.begin(), all);
  const float center[3] = {0, 0, 0};
  return LightSet({kind}, std::move(list), sets, center, 10);
}

using Random = std::mt19937;
float uniform(Random& r, float a = 0, float b = 1) { return a + (b - a) * float(r() >> 8) * 0x1p-24f; }
std::array<float, 3> direction(Random& r) {
  for (;;) {
    const std::array<float, 3> d = {uniform(r, -1, 1), uniform(r, -1, 1), uniform(r, -1, 1)};
    const float l2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    if (l2 > 0.01f && l2 < 1) return {d[0] / std::sqrt(l2), d[1] / std::sqrt(l2), d[2] / std::sqrt(l2)};
  }
}

// Points, spheres, flat lights, spots, groups of normals, two-sided ones, suns and skies.
std::vector<LightDescription> someLights(uint32_t n, uint32_t seed) {
  Random r(seed);
  std::vector<LightDescription> list;
  for (uint32_t i = 0; i < n; ++i) {
    LightDescription d{};
    d.diffuse = d.specular = 1;
    d.power = std::exp(uniform(r, -3, 3));
    const std::array<float, 3> axis = direction(r);
    const uint32_t what = r() % 7;
    if (what == 6) {
      d.isInfinite = 1;
      d.radius = -1;
      const float concentration = r() % 2 ? 1.f : uniform(r);
      for (int c = 0; c < 3; ++c) d.axis[c] = axis[size_t(c)] * concentration;
    } else {
      for (int c = 0; c < 3; ++c) d.center[c] = uniform(r, -4, 4);
      d.radius = what == 0 ? 0 : uniform(r, 0, 0.5f);
      d.isDelta = what == 0;
      if (what > 1) {
        for (int c = 0; c < 3; ++c) d.axis[c] = axis[size_t(c)];
        d.cosNormals = what == 2 ? uniform(r, -1, 1) : what == 3 ? std::cos(uniform(r, 0, 1)) : 1.f;
        d.cosEmission = what == 2 ? 1.f : what == 4 ? std::cos(uniform(r, 0.05f, 1.5f)) : 0.f;
        d.isTwoSided = what == 5;
      }
    }
    list.push_back(d);
  }
  return list;
}

struct Lists {
  static constexpr uint32_t kMost = 1 << 16;
  explicit Lists(uint32_t n) : n(n), m(padded(n)) {
    for (auto* v : {&p[0], &p[1], &p[2], &N[0], &N[1], &N[2], &u[0], &u[1], &time}) v->assign(m, 0.f);
    set.assign(m, 0);
    row.assign(m, 0);
  }
  void fill(const std::array<float, 3>& P, const std::array<float, 3>& normal, uint32_t linkSet, Random& r) {
    for (uint32_t i = 0; i < m; ++i) {
      for (size_t c = 0; c < 3; ++c) {
        p[c][i] = P[c];
        N[c][i] = normal[c];
      }
      u[0][i] = uniform(r);
      u[1][i] = uniform(r);
      set[i] = linkSet;
    }
  }
  LightSet::Points points() const {
    LightSet::Points x;
    x.count = n;
    x.padded = m;
    for (size_t c = 0; c < 3; ++c) {
      x.P[c] = p[c].data();
      x.N[c] = N[c].data();
    }
    x.time = time.data();
    x.linkSet = set.data();
    x.weights = weights;
    x.row = row.data();
    for (size_t k = 0; k < 2; ++k) x.u[k] = x.uChoice[k] = u[k].data();
    return x;
  }
  uint32_t n, m;
  std::vector<float> p[3], N[3], u[2], time;
  std::vector<uint32_t> set, row;
  const float* weights = nullptr;
};

// Of every light, from one point.
std::vector<float> probabilitiesOf(const LightSet& set, const std::array<float, 3>& P,
                                   const std::array<float, 3>& normal, uint32_t linkSet, uint32_t width = 8,
                                   const float* weights = nullptr) {
  Random r(1);
  Lists l(set.size());
  l.weights = weights;
  l.fill(P, normal, linkSet, r);
  std::vector<uint32_t> light(l.m);
  for (uint32_t i = 0; i < l.m; ++i) light[i] = std::min(i, set.size() - 1);
  std::vector<float> p(l.m);
  set.probabilities(width, l.points(), light.data(), p.data());
  p.resize(set.size());
  return p;
}

std::array<float, 3> placeOf(Random& r) { return {uniform(r, -5, 5), uniform(r, -5, 5), uniform(r, -5, 5)}; }
// Unit, half as long, or none.
std::array<float, 3> normalOf(Random& r) {
  std::array<float, 3> n = direction(r);
  const float scale[3] = {1, 0.5f, 0};
  for (float& x : n) x *= scale[r() % 3];
  return n;
}
std::vector<std::vector<uint32_t>> someSets(uint32_t n, uint32_t seed) {
  Random r(seed);
  std::vector<std::vector<uint32_t>> sets(3);
  for (uint32_t i = 0; i < n; ++i) {
    if (r() % 2) sets[0].push_back(i);
    if (r() % 16 == 0) sets[1].push_back(i);
  }
  return sets;  // the last is empty
}

// Of counts from what is said, in standard deviations: chi squared over cells of 20 and more, as a normal deviate (Wilson
// and Hilferty).
double deviation(const std::vector<float>& p, const std::vector<uint32_t>& count, double total) {
  double chi = 0, rest = 0, restCount = 0;
  int freedom = -1;
  for (size_t i = 0; i < p.size(); ++i) {
    rest += p[i] * total;
    restCount += count[i];
    if (rest < 20) continue;
    chi += (restCount - rest) * (restCount - rest) / rest;
    rest = restCount = 0;
    ++freedom;
  }
  if (freedom < 1) return 0;
  return (std::cbrt(chi / freedom) - (1 - 2 / (9.0 * freedom))) / std::sqrt(2 / (9.0 * freedom));
}

class LightChoice : public testing::TestWithParam<uint32_t> {};

TEST_P(LightChoice, IsDrawnAsOftenAsIsSaid) {
  const uint32_t n = GetParam();
  const LightSet set = setOf(someLights(n, n), someSets(n, n));
  Random r(7);
  Arena arena;
  for (uint32_t trial = 0; trial < 12; ++trial) {
    const std::array<float, 3> P = placeOf(r), normal = normalOf(r);
    const uint32_t linkSet = r() % 3;
    const std::vector<float> p = probabilitiesOf(set, P, normal, linkSet);
    double sum = 0;
    for (const float x : p) {
      ASSERT_TRUE(x >= 0 && x <= 1.00001f) << x;
      sum += x;
    }
    if (sum == 0) continue;
    EXPECT_LT(sum, 1.0001);
    std::vector<uint32_t> count(n, 0);
    uint32_t none = 0, total = 0;
    for (int round = 0; round < 8; ++round) {
      arena.reset();
      Lists l(1 << 14);
      l.fill(P, normal, linkSet, r);
      LightSamples s;
      set.sample(8, arena, l.points(), &s);
      for (uint32_t i = 0; i < l.n; ++i, ++total) {
        if (s.light[i] == kNoLight) {
          ++none;
          continue;
        }
        ++count[s.light[i]];
        ASSERT_EQ(s.pdf[i], p[s.light[i]]) << "light " << s.light[i] << " of " << n;
      }
    }
    // what is left of 1 was given to nodes below which nothing reaches the point after all
    EXPECT_NEAR(double(none) / total, 1 - sum, 5 * std::sqrt(std::max(1 - sum, 1e-6) / total) + 1e-5);
    for (uint32_t i = 0; i < n; ++i)
      if (p[i] == 0) {
        EXPECT_EQ(count[i], 0u);
      }
    EXPECT_LT(deviation(p, count, total), 4.5);
  }
}

// A light reaches a point where some place of its sphere and some normal of its cone emit towards it.
TEST_P(LightChoice, EveryLightThatReachesHasAChance) {
  const uint32_t n = GetParam();
  const std::vector<LightDescription> lights = someLights(n, 3 * n);
  const auto sets = someSets(n, n);
  const LightSet set = setOf(lights, sets);
  Random r(11);
  uint32_t reaching = 0;
  for (uint32_t trial = 0; trial < 40; ++trial) {
    const std::array<float, 3> P = placeOf(r), normal = normalOf(r);
    const uint32_t linkSet = r() % 4;
    const std::vector<float> p = probabilitiesOf(set, P, normal, linkSet);
    for (uint32_t i = 0; i < n; ++i) {
      const LightDescription& d = lights[i];
      const bool isLinked = linkSet == 0 || std::count(sets[linkSet - 1].begin(), sets[linkSet - 1].end(), i);
      if (!isLinked) {
        EXPECT_EQ(p[i], 0.f);
        continue;
      }
      bool reaches = d.isInfinite != 0;
      for (int attempt = 0; attempt < 8 && !reaches; ++attempt) {
        const std::array<float, 3> off = direction(r);
        float v[3], l2 = 0;
        for (size_t c = 0; c < 3; ++c) {
          v[c] = P[c] - (d.center[c] + off[c] * d.radius * uniform(r));
          l2 += v[c] * v[c];
        }
        float cosine = 0, axis2 = 0;
        for (int c = 0; c < 3; ++c) {
          cosine += v[c] * d.axis[c] / std::sqrt(l2);
          axis2 += d.axis[c] * d.axis[c];
        }
        if (d.isTwoSided) cosine = std::fabs(cosine);
        // the nearest normal leans towards the point as far as the cone lets it
        const double away = std::acos(std::clamp(double(cosine), -1.0, 1.0)) - std::acos(double(d.cosNormals));
        reaches = axis2 == 0 || away < std::acos(double(d.cosEmission)) - 1e-4;
      }
      if (!reaches) continue;
      ++reaching;
      EXPECT_GT(p[i], 0.f) << "light " << i << " of " << n;
    }
  }
  EXPECT_GT(reaching, n);
}

// allReached: all points have a light, and are asked how likely it was, too.
void expectTheSameAtAllWidths(const LightSet& set, const Lists& l, bool allReached) {
  Arena arena;
  LightSamples one;
  set.sample(1, arena, l.points(), &one);
  for (const uint32_t width : {4u, 8u, 16u}) {
    if (width > bestWidth()) continue;  // what this processor has no instructions for
    LightSamples other;
    set.sample(width, arena, l.points(), &other);
    for (uint32_t i = 0; i < l.n; ++i) {
      ASSERT_EQ(one.light[i], other.light[i]) << width;
      ASSERT_EQ(one.pdf[i], other.pdf[i]) << width;
    }
    if (!allReached) continue;
    std::vector<float> p(l.m);
    set.probabilities(width, l.points(), one.light, p.data());
    for (uint32_t i = 0; i < l.n; ++i) ASSERT_EQ(one.pdf[i], p[i]) << width;
  }
}

TEST_P(LightChoice, IsTheSameAtAllWidths) {
  const uint32_t n = GetParam();
  const LightSet set = setOf(someLights(n, 5 * n), someSets(n, n));
  Lists l(1000);
  Random r(13);
  for (uint32_t i = 0; i < l.m; ++i) {
    const std::array<float, 3> P = placeOf(r), normal = normalOf(r);
    for (size_t c = 0; c < 3; ++c) {
      l.p[c][i] = P[c];
      l.N[c][i] = normal[c];
    }
    l.u[0][i] = uniform(r);
    l.u[1][i] = uniform(r);
    l.set[i] = r() % 4;
  }
  expectTheSameAtAllWidths(set, l, false);
}

// Factors that somebody learned, by row and cluster: drawn as is said with them, and not as is said without them.
TEST_P(LightChoice, FollowsWeights) {
  const uint32_t n = GetParam();
  const LightSet set = setOf(someLights(n, n));
  Random r(23);
  std::vector<float> weights(2 * kLightClusters);
  for (float& w : weights) w = std::exp(uniform(r, -4, 0));
  const std::array<float, 3> normal = {0, 0, 0};
  std::array<float, 3> P{};
  for (int reaching = 0, trial = 0; reaching < 2 && trial < 100; ++trial) {
    P = placeOf(r);
    reaching = 0;
    for (const float x : probabilitiesOf(set, P, normal, 0)) reaching += x > 0.02f;
  }
  const std::vector<float> p = probabilitiesOf(set, P, normal, 0, 8, weights.data()),
                           plain = probabilitiesOf(set, P, normal, 0);
  Arena arena;
  std::vector<uint32_t> count(n, 0);
  uint32_t total = 0;
  for (int round = 0; round < 8; ++round) {
    arena.reset();
    Lists l(1 << 14);
    l.fill(P, normal, 0, r);
    l.weights = weights.data();
    LightSamples s;
    set.sample(8, arena, l.points(), &s);
    for (uint32_t i = 0; i < l.n; ++i, ++total) {
      if (s.light[i] == kNoLight) continue;
      ++count[s.light[i]];
      ASSERT_EQ(s.pdf[i], p[s.light[i]]);
      ASSERT_LT(s.cluster[i], kLightClusters);
      // of lights that are their own clusters: the chance over that of the tree, but for what the defensive part changes
      if (n <= kLightClusters) {
        ASSERT_GT(s.chance[i], 0.7f * weights[s.cluster[i]]);
      }
    }
  }
  const auto chiOf = [&](const std::vector<float>& expected) {
    double chi = 0;
    int cells = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const double e = double(expected[i]) * total;
      if (e < 20) continue;
      chi += (count[i] - e) * (count[i] - e) / e;
      ++cells;
    }
    const double freedom = std::max(cells - 1, 1);
    return (std::cbrt(chi / freedom) - (1 - 2 / (9 * freedom))) / std::sqrt(2 / (9 * freedom));  // Wilson, Hilferty
  };
  EXPECT_LT(chiOf(p), 4.5);
  EXPECT_GT(chiOf(plain), 4.5) << "a density without the weights is noticed";
}

INSTANTIATE_TEST_SUITE_P(Of, LightChoice, testing::Values(2u, 3u, 16u, 17u, 100u, 3000u),
                         [](const auto& info) { return std::to_string(info.param) + "Lights"; });

LightDescription lamp(float x, float y, float z, float power) {
  LightDescription d{};
  d.center[0] = x;
  d.center[1] = y;
  d.center[2] = z;
  d.radius = 0.05f;
  d.power = power;
  return d;
}

// The lamp over the point is taken, however many there are elsewhere.
TEST(LightChoiceOfUse, TakesTheLampNearby) {
  std::vector<LightDescription> lights;
  for (int i = 0; i < 100; ++i)
    for (int j = 0; j < 100; ++j) lights.push_back(lamp(float(i), float(j), 0.5f, 1));
  const LightSet set = setOf(lights);
  Random r(17);
  for (int trial = 0; trial < 20; ++trial) {
    const std::array<float, 3> P = {uniform(r, 20, 80), uniform(r, 20, 80), 0};
    const std::vector<float> p = probabilitiesOf(set, P, {0, 0, 1}, 0);
    // variance of one sample over the squared sum of irradiances
    double sum = 0, second = 0;
    for (size_t i = 0; i < lights.size(); ++i) {
      double d2 = 0, v[3];
      for (int c = 0; c < 3; ++c) {
        v[c] = lights[i].center[c] - P[size_t(c)];
        d2 += v[c] * v[c];
      }
      const double e = v[2] / (d2 * std::sqrt(d2));
      sum += e;
      second += e * e / p[i];
    }
    EXPECT_LT(second / (sum * sum) - 1, 2) << "by power it would be some hundreds";
  }
}

TEST(LightChoiceOfUse, ASunTakesItsShareByPoint) {
  LightDescription sun{};
  sun.isInfinite = 1;
  sun.radius = -1;
  sun.axis[2] = 1;
  sun.power = 1;
  const LightSet set = setOf({lamp(0, 0, 1, 12.566f), sun});  // each 1 right below the lamp
  EXPECT_NEAR(probabilitiesOf(set, {0, 0, 0}, {0, 0, 1}, 0)[0], 0.5, 0.05);
  EXPECT_GT(probabilitiesOf(set, {20, 0, 0}, {0, 0, 1}, 0)[1], 0.9f);
  EXPECT_GT(probabilitiesOf(set, {0, 0, 0.8f}, {0, 0, 1}, 0)[0], 0.85f);
  EXPECT_GT(probabilitiesOf(set, {1, 0, 0.5f}, {-0.9f, 0, -0.43f}, 0)[0], 0.8f);  // turned away from the sun
}

// Many lamps alike but for their power: from afar that alone decides. One outshines all others together, some are
// hardly there.
std::vector<LightDescription> fieldOfLamps(uint32_t n, uint32_t seed) {
  Random r(seed);
  const float side = std::sqrt(float(n));
  std::vector<LightDescription> lights;
  for (uint32_t i = 0; i < n; ++i) {
    const float x = uniform(r, 0, side), y = uniform(r, 0, side), z = uniform(r, 0.3f, 1.5f);
    const float power = i == n / 2 ? 1e6f : i % 97 == 0 ? 1e-6f : std::exp(uniform(r, 0, 4.6f));
    lights.push_back(lamp(x, y, z, power));
  }
  return lights;
}

// Within the field, beside it, and so far that all of it is one place.
const std::array<float, 3> kLeapsFrom[] = {{3.3f, 40.1f, 0}, {-30, 25, 0.1f}, {-4000, 300, 10}};

TEST(LightLeaps, ProbabilitiesAreAllThereIs) {
  constexpr uint32_t n = 3000;
  const auto links = someSets(n, 5);
  const LightSet set = setOf(fieldOfLamps(n, 21)), linked = setOf(fieldOfLamps(n, 21), links);
  for (const std::array<float, 3>& P : kLeapsFrom) {
    double all = 0;
    for (const float p : probabilitiesOf(set, P, {0, 0, 1}, 0)) {
      EXPECT_GT(p, 0.f);
      all += p;
    }
    EXPECT_NEAR(all, 1, 1e-3);
    // where sets leave lights out, each step looks at what they hold
    for (const uint32_t linkSet : {0u, 1u, 2u}) {
      const std::vector<float> p = probabilitiesOf(linked, P, {0, 0, 1}, linkSet);
      double sum = 0;
      for (uint32_t i = 0; i < n; ++i) {
        const bool isLinked = !linkSet || std::binary_search(links[linkSet - 1].begin(), links[linkSet - 1].end(), i);
        EXPECT_EQ(p[i] > 0, isLinked);
        sum += p[i];
      }
      EXPECT_NEAR(sum, 1, 1e-3);
    }
  }
}

TEST(LightLeaps, AreDrawnAsOftenAsIsSaid) {
  for (const uint32_t n : {40u, 3000u, 50000u}) {
    const LightSet set = setOf(fieldOfLamps(n, n));
    Random r(31);
    Arena arena;
    for (const std::array<float, 3>& P : kLeapsFrom) {
      const std::vector<float> p = probabilitiesOf(set, P, {0, 0, 1}, 0);
      std::vector<uint32_t> count(n, 0);
      uint32_t total = 0;
      for (int round = 0; round < 12; ++round) {
        arena.reset();
        Lists l(1 << 14);
        l.fill(P, {0, 0, 1}, 0, r);
        LightSamples s;
        set.sample(8, arena, l.points(), &s);
        for (uint32_t i = 0; i < l.n; ++i, ++total) {
          ASSERT_NE(s.light[i], kNoLight);
          ++count[s.light[i]];
          ASSERT_EQ(s.pdf[i], p[s.light[i]]) << "light " << s.light[i] << " of " << n;
        }
      }
      EXPECT_LT(deviation(p, count, total), 4.5) << n << " lamps from " << P[0];
    }
  }
}

TEST(LightLeaps, AreTheSameAtAllWidths) {
  const LightSet set = setOf(fieldOfLamps(3000, 3));
  Lists l(1000);
  Random r(13);
  for (uint32_t i = 0; i < l.m; ++i) {
    const float range = i % 2 ? 60.f : 1000.f;
    for (size_t c = 0; c < 3; ++c) l.p[c][i] = uniform(r, -range, range);
    l.N[2][i] = 1;
    l.u[0][i] = uniform(r);
    l.u[1][i] = i % 3 ? uniform(r) : 0.99999994f;
  }
  expectTheSameAtAllWidths(set, l, true);
}

// The lights below a node stand side by side, with their power.
TEST(LightLeaps, SumsAreOfWhatIsBelow) {
  constexpr uint32_t n = 2000;
  std::vector<LightDescription> lights = fieldOfLamps(n, 8);
  for (uint32_t i = 0; i < 50; ++i) lights[7 * i] = someLights(50, 4)[i];
  const LightTree tree(lights);
  ASSERT_TRUE(tree.isDeep());
  uint32_t at = 0;
  for (uint32_t k = 0; k < tree.topCount(); ++k) {
    const TopNode& t = tree.top()[k];
    EXPECT_EQ(t.start, at);
    // depth first: the first child, then the second
    std::vector<uint32_t> open{t.node};
    uint32_t last = t.node;
    while (!open.empty()) {
      const uint32_t node = open.back(), child = tree.nodes()[node].child;
      open.pop_back();
      last = std::max(last, node);
      if (child & kLeaf) {
        const uint32_t l = child & ~kLeaf;
        EXPECT_EQ(tree.places()[l].position, at);
        EXPECT_EQ(tree.powers()[at].light, l);
        if (!lights[l].isInfinite) {
          EXPECT_GT(tree.powers()[at + 1].sum, tree.powers()[at].sum);
        }
        ++at;
      } else {
        open.push_back(child + 1);
        open.push_back(child);
      }
    }
    if (last != t.node) {
      EXPECT_EQ(t.end, last + 1);
    }
  }
  EXPECT_EQ(at, n);
  EXPECT_LT(tree.powers()[n].sum, 1u << 31);
}

TEST(LightChoiceBadInput, HasADefinedAnswer) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  // all in one point, without extent
  std::vector<LightDescription> same(1000, lamp(1, 2, 3, 1));
  for (LightDescription& d : same) d.radius = 0;
  const LightSet piled = setOf(same);
  double sum = 0;
  for (const float p : probabilitiesOf(piled, {1, 2, 2}, {0, 0, 1}, 0)) {
    EXPECT_GT(p, 0);
    sum += p;
  }
  EXPECT_NEAR(sum, 1, 1e-4);
  sum = 0;
  for (const float p : probabilitiesOf(piled, {1, 2, 3}, {0, 0, 1}, 0)) sum += p;  // in the lights
  EXPECT_NEAR(sum, 1, 1e-4);
  // nothing that is a number
  std::vector<LightDescription> odd = someLights(40, 1);
  for (size_t i = 0; i < odd.size(); ++i) {
    float* fields[] = {&odd[i].center[0], &odd[i].radius, &odd[i].power, &odd[i].axis[1], &odd[i].cosNormals};
    *fields[i % 5] = i % 2 ? nan : inf;
  }
  odd.push_back(lamp(0, 0, 0, 1e-38f));
  odd.push_back(lamp(0, 0, 0, 1e38f));
  const LightSet broken = setOf(odd);
  for (const std::array<float, 3>& P : {std::array<float, 3>{0, 0, 0}, {1e30f, 0, 0}, {nan, 0, 0}, {inf, 0, 0}})
    for (const float p : probabilitiesOf(broken, P, {0, 0, 1}, 0)) EXPECT_TRUE(p >= 0 && p <= 1) << p;
  // light that is black, and sets that hold none
  const LightSet dark = setOf(std::vector<LightDescription>(1000000, lamp(0, 0, 0, 0)));
  const LightSet unlinked = setOf(someLights(20, 2), {{}});
  Random r(3);
  Arena arena;
  Lists l(16);
  for (const LightSet* set : {&dark, &unlinked}) {
    l.fill({0, 0, 1}, {0, 0, -1}, set == &unlinked, r);
    LightSamples s;
    set->sample(8, arena, l.points(), &s);
    for (uint32_t i = 0; i < l.m; ++i) {
      EXPECT_EQ(s.light[i], kNoLight);
      EXPECT_EQ(s.pdf[i], 0.f);
      EXPECT_EQ(s.radiance[0][i], 0.f);
    }
  }
  EXPECT_EQ(dark.tree().topCount(), 0u);
}

// Sets cost no more than what they leave out.
TEST(LightChoiceMemory, IsInProportionToLights) {
  constexpr uint32_t n = 100000;
  const std::vector<LightDescription> lights = someLights(n, 1);
  const LightSet plain = setOf(lights);
  EXPECT_LT(double(plain.bytes()) / n, 160);
  std::vector<std::vector<uint32_t>> sets;
  for (uint32_t k = 0; k < 50; ++k) {
    sets.emplace_back();
    for (uint32_t i = 0; i < n; ++i)
      if (i != 1000 * k) sets.back().push_back(i);
  }
  const LightSet linked = setOf(lights, sets);
  EXPECT_LT(double(linked.bytes() - plain.bytes()) / 50, 0.1 * n) << "bytes a set";
}

TEST(LightChoiceMemory, IsCharged) {
  const std::vector<LightDescription> lights = someLights(100000, 1);
  const uint64_t before = Memory::used(MemoryUse::Lights);
  {
    const LightSet set = setOf(lights);
    EXPECT_EQ(Memory::used(MemoryUse::Lights) - before, set.bytes());
  }
  EXPECT_EQ(Memory::used(MemoryUse::Lights), before);
  Memory::setLimit(Memory::resident() + (1 << 20));
  EXPECT_THROW(setOf(lights), MemoryExceeded);
  Memory::setLimit(0);
  EXPECT_EQ(Memory::used(MemoryUse::Lights), before);
}

}  // namespace
}  // namespace kinora::light
