// Proves that the film's state is a function of the set of samples: any order, split, thread or merge gives the same
// integers; that rounding, saturation and bad values are what film.h says. It does not test the displays.
#include "film/film.h"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <thread>

#include "film/film_test_samples.h"

namespace kinora::film {
namespace {

using test::everyReducer, test::makeFilm, test::randomSamples, test::sameState, test::Samples;

constexpr float kInf = std::numeric_limits<float>::infinity();

ChannelLayout oneFloat() {
  ChannelLayout layout;
  layout.add(floatChannel("v"));
  return layout;
}

TEST(Film, AnyOrderAndAnySplitGiveTheSameIntegers) {
  const ChannelLayout layout = everyReducer();
  const Window window{3, 2, 9, 7};
  const Samples samples = randomSamples(layout, window, 9, 1);
  auto whole = makeFilm(12, 10, layout, window);
  samples.addTo(*whole);
  std::mt19937 rng(7);
  std::vector<int> order = samples.inOrder();
  for (int trial = 0; trial < 30; ++trial) {
    std::shuffle(order.begin(), order.end(), rng);
    auto film = makeFilm(12, 10, layout, window);
    auto second = makeFilm(12, 10, layout, window);
    for (size_t i = 0; i < order.size();) {
      const size_t n = std::min<size_t>(1 + rng() % 40, order.size() - i);
      samples.addTo(trial % 2 && rng() % 2 ? *second : *film, order, i, i + n);
      i += n;
    }
    ASSERT_TRUE(film->merge(*second).ok());
    ASSERT_TRUE(sameState(*film, *whole)) << "trial " << trial;
  }
}

TEST(Film, ASampleRoundsToTheNearestStepTiesToEven) {
  ChannelLayout layout;
  Channel c = floatChannel("v");
  c.stepLog2 = 0;
  layout.add(c);
  const std::pair<float, int64_t> table[] = {
      {0.5f, 0},  {1.5f, 2}, {2.5f, 2},    {-0.5f, 0}, {-1.5f, -2}, {-2.5f, -2},       {0.49f, 0},
      {0.51f, 1}, {3.0f, 3}, {-3.49f, -3}, {7.5f, 8},  {1e-40f, 0}, {65535.5f, 65536}, {-65535.5f, -65536}};
  for (const auto& [value, expected] : table) {
    auto film = makeFilm(1, 1, layout);
    Samples s(1);
    s.add(0, 0, 0, 1, {value});
    s.addTo(*film);
    EXPECT_EQ(film->pixel(0, 0)[film->firstSlot(0)], expected) << value;
  }
}

TEST(Film, MeansAreWeightedByTheFilter) {
  auto film = makeFilm(2, 1, oneFloat());
  Samples s(1);
  s.add(0, 0, 0, 1.25f, {2});
  s.add(0, 0, 1, 1.25f, {4});
  s.add(0, 0, 2, -0.5f, {1});
  s.addTo(*film);
  float v = -1;
  film->resolvePixel(0, 0, 0, &v);
  EXPECT_FLOAT_EQ(v, (1.25f * 6 - 0.5f) / 2.0f);
  film->resolvePixel(0, 1, 0, &v);
  EXPECT_EQ(v, 0.0f) << "a pixel without samples";
}

TEST(Film, CancellingWeightsDivideByTheCount) {
  auto film = makeFilm(1, 1, oneFloat());
  Samples s(1);
  s.add(0, 0, 0, 1, {3});
  s.add(0, 0, 1, -1, {1});
  s.addTo(*film);
  float v = 0;
  film->resolvePixel(0, 0, 0, &v);
  EXPECT_EQ(v, 1.0f);
}

TEST(Film, NonFiniteSamplesAreDroppedWithTheirWeightAndReported) {
  ChannelLayout layout;
  layout.add(colorChannel("Ci"));
  layout.add(depthChannel("z"));
  auto film = makeFilm(4, 40, layout);
  Samples s(4);
  const float nan = std::nanf("");
  for (int y = 39; y >= 0; --y) {
    s.add(1, y, 5, 1, {1, y % 2 ? nan : kInf, 1, 2});
    s.add(1, y, 6, 1, {1, 1, 1, kInf});  // a miss is no error
    s.add(2, y, 7, 1, {1, 1, 1, nan});   // but a depth of NaN is
    s.add(3, y, 8, nan, {1, 1, 1, 1});
  }
  s.addTo(*film);
  const FilmCounters c = film->counters();
  EXPECT_EQ(c.nonFinite, 120u);
  ASSERT_EQ(c.bad.size(), 16u);
  EXPECT_EQ(c.bad[0].x, 1);
  EXPECT_EQ(c.bad[0].y, 0);
  EXPECT_EQ(c.bad[0].sampleIndex, 5u);
  EXPECT_EQ(c.bad[0].channel, 0);
  EXPECT_EQ(c.bad[1].channel, 1);
  EXPECT_EQ(c.bad[2].channel, -1);
  EXPECT_EQ(c.bad[3].y, 1) << "the first by position, not by arrival";
  EXPECT_EQ(film->sampleCount(1, 3), 1);
  EXPECT_EQ(film->sampleCount(2, 3), 0);
  float v[3];
  film->resolvePixel(0, 1, 3, v);
  EXPECT_EQ(v[1], 1.0f);
  film->resolvePixel(1, 1, 3, v);
  EXPECT_EQ(v[0], kNoDepth);
}

TEST(Film, SaturationAndNegativeValuesAreCounted) {
  ChannelLayout layout;
  layout.add(colorChannel("Ci"));
  layout.add(normalChannel("Nn"));
  auto film = makeFilm(1, 1, layout);
  Samples s(6);
  s.add(0, 0, 0, 1, {1e9f, -1e9f, 1, -1, -1, -1});
  s.add(0, 0, 1, 1, {1, 1, 1, -1, -1, -1});
  s.addTo(*film);
  const FilmCounters c = film->counters();
  EXPECT_EQ(c.saturated[0], 2u);
  EXPECT_EQ(c.saturated[1], 0u);
  EXPECT_EQ(c.negative, 1u) << "normals may point anywhere";
  EXPECT_EQ(c.nonFinite, 0u);
  const int slot = film->firstSlot(0);
  EXPECT_EQ(film->pixel(0, 0)[slot], (int64_t(1) << 46) + (int64_t(1) << 30));
  EXPECT_EQ(film->pixel(0, 0)[slot + 1], -(int64_t(1) << 46) + (int64_t(1) << 30));
}

TEST(Film, SumsOfTheLargestSamplesDoNotOverflow) {
  auto film = makeFilm(1, 1, oneFloat());
  Samples s(1);
  for (int i = 0; i < 1024; ++i) s.add(0, 0, uint32_t(i), 1, {65536.0f});
  for (int i = 0; i < 64; ++i) s.addTo(*film);  // 2^16 samples
  float v = 0;
  film->resolvePixel(0, 0, 0, &v);
  EXPECT_EQ(v, 65536.0f);
}

TEST(Film, SamplesOutsideTheWindowAreIgnored) {
  auto film = makeFilm(8, 8, oneFloat(), {2, 2, 4, 4});
  Samples s(1);
  for (int y = -2; y < 10; ++y)
    for (int x = -2; x < 10; ++x) s.add(x, y, 0, 1, {1});
  s.addTo(*film);
  for (int y = 2; y < 4; ++y)
    for (int x = 2; x < 4; ++x) EXPECT_EQ(film->sampleCount(x, y), 1);
  EXPECT_EQ(film->counters().nonFinite, 0u);
}

TEST(Film, ReducersKeepExactState) {
  const ChannelLayout layout = everyReducer();
  auto film = makeFilm(1, 1, layout);
  Samples s(layout.recordFloats());
  const auto record = [&](float ci, float a, float p, float z, float id, float time) {
    std::vector<float> r(size_t(layout.recordFloats()), 0.0f);
    for (int k = 0; k < 3; ++k) r[size_t(layout.recordOffset(layout.find("Ci")) + k)] = ci;
    for (int k = 0; k < 3; ++k) r[size_t(layout.recordOffset(layout.find("P")) + k)] = p;
    r[size_t(layout.recordOffset(layout.find("a")))] = a;
    r[size_t(layout.recordOffset(layout.find("z")))] = z;
    r[size_t(layout.recordOffset(layout.find("id")))] = id;
    r[size_t(layout.recordOffset(layout.find("time")))] = time;
    return r;
  };
  s.add(0, 0, 3, 2, record(1, 0.5f, -3, 5, 33, 10));
  s.add(0, 0, 2, 1, record(3, 1.0f, -1, 5, 22, 20));  // the same depth, a lower index: nearest
  s.add(0, 0, 1, 1, record(5, 0.0f, -7, 9, 11, 30));
  s.add(0, 0, 0, 1, record(7, 0.0f, -5, kInf, 0, 40));  // a miss
  s.addTo(*film);
  const auto get = [&](const char* name) {
    float v[4] = {};
    film->resolvePixel(layout.find(name), 0, 0, v);
    return v[0];
  };
  EXPECT_FLOAT_EQ(get("Ci"), (2 * 1 + 3 + 5 + 7) / 5.0f);
  EXPECT_FLOAT_EQ(get("Ci_even"), 5.0f);
  EXPECT_FLOAT_EQ(get("Ci_odd"), (2 * 1 + 5) / 3.0f);
  EXPECT_EQ(get("z"), 5.0f);
  EXPECT_EQ(get("id"), 22.0f);
  EXPECT_EQ(get("Pnear"), -1.0f);
  EXPECT_EQ(get("Pfar"), -5.0f);
  EXPECT_EQ(get("Pmax"), -1.0f);
  EXPECT_EQ(get("time"), 100.0f);
  EXPECT_FLOAT_EQ(get("aPlain"), 0.375f);
}

TEST(Film, SplatsFromManyThreadsAddExactly) {
  const ChannelLayout layout = everyReducer();
  constexpr int kThreads = 4, kEach = 5000;
  const auto run = [&](int threads) {
    auto film = makeFilm(8, 8, layout);
    std::vector<std::thread> pool;
    for (int t = 0; t < threads; ++t)
      pool.emplace_back([&, t] {
        for (int i = t; i < kThreads * kEach; i += threads) {
          const int32_t x = i % 8, y = i / 8 % 9;  // row 8 is outside
          const float v[3] = {float(i % 1000) * 0.001f, 0.1f, i % 5000 == 0 ? NAN : 0.3f};
          const float* arrays[3] = {&v[0], &v[1], &v[2]};
          const uint32_t index = uint32_t(i);
          film->splat({1, 0, &x, &y, &index, arrays});
        }
      });
    for (auto& t : pool) t.join();
    film->addSplatPasses(2);
    return film;
  };
  const auto one = run(1), four = run(4);
  EXPECT_TRUE(sameState(*one, *four));
  EXPECT_EQ(four->counters().nonFinite, 3u) << "the fourth is outside";
  float a[3];
  one->resolvePixel(0, 3, 3, a);
  // pixel (3, 3) gets every 72nd splat, 278 in all of 20,000 over two passes
  EXPECT_NEAR(a[1], 278 * 0.1 / 2, 1e-5);
}

TEST(Film, ImpossibleSizesAreRefused) {
  Status status;
  const ChannelLayout layout = oneFloat();
  EXPECT_FALSE(Film::create(1000000000, 1000000000, {0, 0, 1000000000, 1000000000}, layout, status));
  EXPECT_EQ(status.code, "FILM-SIZE");
  EXPECT_FALSE(Film::create(0, 4, {0, 0, 1, 1}, layout, status));
  EXPECT_FALSE(Film::create(4, 4, {0, 0, 5, 4}, layout, status));
  EXPECT_EQ(status.code, "FILM-WINDOW");
  EXPECT_FALSE(Film::create(4, 4, {2, 2, 2, 3}, layout, status));
  EXPECT_FALSE(Film::create(4, 4, {0, 0, 4, 4}, ChannelLayout(), status));
  EXPECT_EQ(status.code, "FILM-CHANNELS");
  EXPECT_FALSE(Film::create(100000, 100000, {0, 0, 100000, 100000}, layout, status, uint64_t(1) << 30));
  EXPECT_EQ(status.code, "FILM-MEMORY");
}

TEST(ChannelLayout, RefusesWhatItCannotHold) {
  ChannelLayout layout;
  std::string error;
  EXPECT_EQ(layout.add(colorChannel("Ci"), &error), 0);
  EXPECT_EQ(layout.add(colorChannel("Ci"), &error), -1);
  Channel c = floatChannel("x", "Ci");
  EXPECT_EQ(layout.add(c, &error), -1) << "one source, two widths";
  c = floatChannel("x");
  c.width = 5;
  EXPECT_EQ(layout.add(c, &error), -1);
  c = floatChannel("x");
  c.limit = 1e12f;
  EXPECT_EQ(layout.add(c, &error), -1);
  c.limit = NAN;
  EXPECT_EQ(layout.add(c, &error), -1);
  EXPECT_EQ(layout.size(), 1);
  EXPECT_EQ(layout.recordFloats(), 3);
  EXPECT_EQ(layout.add(colorChannel("again", "Ci"), &error), 1);
  EXPECT_EQ(layout.recordFloats(), 3) << "one source, one entry";
}

// Prints what a sample costs; the time itself is judged by the benchmark, not here.
TEST(Film, CostOfASample) {
  ChannelLayout layout;
  for (int i = 0; i < 9; ++i) layout.add(colorChannel("c" + std::to_string(i)));
  layout.add(floatChannel("a"));
  layout.add(floatChannel("b"));
  layout.add(depthChannel("z"));
  ASSERT_EQ(layout.recordFloats(), 30);
  auto film = makeFilm(256, 256, layout);
  constexpr int kSpp = 4;
  const Samples bucket = randomSamples(layout, {0, 0, 16, 16}, kSpp, 3);
  double best = 1e30;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    for (int pass = 0; pass < 40; ++pass) bucket.addTo(*film);
    const std::chrono::duration<double, std::nano> t = std::chrono::steady_clock::now() - start;
    best = std::min(best, t.count() / (40.0 * bucket.size()));
  }
  std::printf("film: %.1f ns a sample of 30 floats\n", best);
  RecordProperty("nanosecondsASample", std::to_string(best));
  EXPECT_EQ(film->sampleCount(0, 0), 5 * 40 * kSpp);
}

}  // namespace
}  // namespace kinora::film
