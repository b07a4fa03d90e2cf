// Proves that samples drawn from the tables have the filter's moments: against closed forms where they exist and
// against direct quadrature of evaluate() for every filter and several widths. Prints, but does not judge, the
// comparison with splatting that docs/performance.md records. It misses the gather by groups, which render/ tests.
#include "film/pixel_filter.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <utility>
#include <random>

#include "film/film.h"
#include "film/film_test_samples.h"
#include "film/filter_ratio.h"

namespace kinora::film {
namespace {

struct Moments {
  double one = 0, x = 0, y = 0, xx = 0, yy = 0, xxyy = 0, absolute = 0;
  void add(double w, double dx, double dy) {
    one += w;
    x += w * dx;
    y += w * dy;
    xx += w * dx * dx;
    yy += w * dy * dy;
    xxyy += w * dx * dx * dy * dy;
    absolute += std::fabs(w);
  }
};

Moments sampled(const PixelFilter& f, int n) {
  Moments m;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const FilterSample s = f.sample((float(i) + 0.5f) / float(n), (float(j) + 0.5f) / float(n));
      m.add(double(s.weight) / (double(n) * n), s.dx, s.dy);
    }
  return m;
}

Moments integrated(const PixelFilter& f, int n) {
  Moments m;
  const double dx = double(f.xWidth()) / n, dy = double(f.yWidth()) / n;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double x = (i + 0.5) * dx - 0.5 * double(f.xWidth()), y = (j + 0.5) * dy - 0.5 * double(f.yWidth());
      m.add(f.evaluate(x, y), x, y);
    }
  const double norm = std::exchange(m.one, 1);
  for (double* v : {&m.x, &m.y, &m.xx, &m.yy, &m.xxyy, &m.absolute}) *v /= norm;
  return m;
}

PixelFilter filter(const char* name, float xw, float yw) {
  PixelFilter f;
  const image::Status s = PixelFilter::make(name, xw, yw, f);
  EXPECT_TRUE(s.ok()) << s.what;
  return f;
}

TEST(PixelFilter, SamplesHaveTheFiltersMoments) {
  const std::pair<float, float> widths[] = {{2, 2}, {3, 2.5f}, {6, 6}};
  for (const std::string& name : PixelFilter::names())
    for (const auto& [xw, yw] : widths) {
      const PixelFilter f = filter(name.c_str(), xw, yw);
      const Moments got = sampled(f, 1024), want = integrated(f, 500);
      // of the squared width: a cell is uniform inside, and the planar tables have 128 rows
      const double tolerance = (f.isSeparable() ? 2e-4 : 2e-3) * double(xw) * double(yw) * want.absolute;
      const std::string what = name + " " + std::to_string(xw) + " " + std::to_string(yw);
      EXPECT_NEAR(got.one, 1, 2e-5) << what;
      EXPECT_NEAR(got.x, 0, tolerance) << what;
      EXPECT_NEAR(got.y, 0, tolerance) << what;
      EXPECT_NEAR(got.xx, want.xx, tolerance) << what;
      EXPECT_NEAR(got.yy, want.yy, tolerance) << what;
      EXPECT_NEAR(got.xxyy, want.xxyy, tolerance * double(xw) * double(yw)) << what;
      EXPECT_NEAR(got.absolute, want.absolute, 0.02 * want.absolute) << what;
    }
}

TEST(PixelFilter, ClosedForms) {
  EXPECT_NEAR(sampled(filter("box", 2, 2), 1024).xx, 1.0 / 3, 1e-4);
  EXPECT_NEAR(sampled(filter("triangle", 2, 2), 1024).xx, 1.0 / 6, 1e-4);
  EXPECT_NEAR(sampled(filter("disk", 2, 2), 1024).xx, 0.25, 2e-3);
  // cubics with B + 2C = 1 have the second moment B / 3 at width 4 (Mitchell: B = 1/3; Catmull-Rom: B = 0)
  EXPECT_NEAR(sampled(filter("mitchell", 4, 4), 2048).xx, 1.0 / 9, 1e-3);
  EXPECT_NEAR(sampled(filter("separable-catmull-rom", 4, 4), 2048).xx, 0.0, 1e-3);
  // gaussian exp(-2 t^2) cut at |t| = 1 for width 2: (1 - 2 sqrt(2/pi) e^-2 / erf(sqrt 2)) / 4
  const double pi = 3.14159265358979323846;
  EXPECT_NEAR(sampled(filter("gaussian", 2, 2), 1024).xx,
              (1 - 2 * std::sqrt(2 / pi) * std::exp(-2.0) / std::erf(std::sqrt(2.0))) / 4, 1e-4);
}

TEST(PixelFilter, WeightsOfPositiveFiltersAreOne) {
  for (const char* name : {"gaussian", "box", "triangle", "blackman-harris", "disk"}) {
    const PixelFilter f = filter(name, 2, 3);
    EXPECT_FALSE(f.hasNegativeLobes()) << name;
    for (int i = 0; i < 400; ++i) {
      const FilterSample s = f.sample(float(i % 20) / 20.0f, float(i / 20) / 20.0f);
      EXPECT_NEAR(s.weight, 1.0f, name[0] == 'd' ? 2e-3f : 1e-6f) << name;
      EXPECT_LE(std::fabs(s.dx), 1.0f);
      EXPECT_LE(std::fabs(s.dy), 1.5f);
    }
  }
  for (const char* name : {"catmull-rom", "separable-catmull-rom", "mitchell", "sinc", "bessel", "lanczos"})
    EXPECT_TRUE(filter(name, 4, 4).hasNegativeLobes()) << name;
}

TEST(PixelFilter, TablesAreOrderedAndSampleReadsThem) {
  for (const std::string& name : PixelFilter::names()) {
    const PixelFilter f = filter(name.c_str(), 4, 3);
    const FilterTable t = f.sampleTable();
    for (int j = 0; j < t.cellsY; ++j) {
      EXPECT_LE(t.yEdges[j], t.yEdges[j + 1]) << name;
      for (int i = 0; i < t.cellsX; ++i)
        ASSERT_LE(t.xEdges[j * t.rowStride + i], t.xEdges[j * t.rowStride + i + 1]) << name << j << " " << i;
    }
    for (int k = 0; k < 100; ++k) {
      const float u = float(k) * 0.00999f, v = float((k * 37) % 100) * 0.00999f;
      const int i = int(u * float(t.cellsX)), j = int(v * float(t.cellsY));
      const float* row = t.xEdges + j * t.rowStride;
      const FilterSample s = f.sample(u, v);
      EXPECT_EQ(s.dx, row[i] + (u * float(t.cellsX) - float(i)) * (row[i + 1] - row[i]));
      EXPECT_EQ(s.weight, t.yWeight[j] * t.xWeight[j * t.rowStride + i]);
    }
    const FilterSample last = f.sample(0.99999994f, 0.99999994f);
    EXPECT_TRUE(std::isfinite(last.dx) && std::isfinite(last.weight));
  }
}

TEST(PixelFilter, WhatCannotBeUsedBecomesGaussian) {
  PixelFilter f;
  for (const float w : {0.0f, -1.0f, NAN, INFINITY, 1000.0f}) {
    EXPECT_EQ(PixelFilter::make("box", w, 1, f).code, "FILM-FILTER");
    EXPECT_EQ(f.name(), "gaussian");
    EXPECT_EQ(f.xWidth(), 2.0f);
  }
  EXPECT_EQ(PixelFilter::make("nosuch", 2, 2, f).code, "FILM-FILTER");
  EXPECT_TRUE(PixelFilter::make("Catmull-ROM", 4, 4, f).ok());
  EXPECT_EQ(f.name(), "catmull-rom");
}

// Error and cost of both ways to filter: on pictures whose filtered pixels are known by dense quadrature, and on
// noise (every sample a new random number around 1/2), which is what light transport adds.
enum class Picture { Soft, Edges, Noise };
const char* const kPictures[] = {"soft", "edges", "noise"};

double pictureAt(Picture p, double x, double y) {
  const double stripes = (x * 0.31 + y * 0.17) / 2;
  if (p == Picture::Noise) return 0.5;
  return p == Picture::Soft ? 0.5 + 0.5 * std::sin(0.9 * x + 0.04 * x * y) * std::cos(0.7 * y)
                            : std::floor(2 * stripes) - 2 * std::floor(stripes);
}

struct Measured {
  double pixels = 0, blocks = 0;  // mean square errors: of pixels, of means over 4 x 4 pixels
  double nanoseconds = 0;         // in the film, a traced sample of 30 floats
};

Measured measure(const PixelFilter& f, Picture picture, bool isSplatted, int spp, bool areApart = true) {
  constexpr int kSide = 32, kFloats = 30;
  ChannelLayout layout;
  for (int i = 0; i < kFloats / 3; ++i) layout.add(colorChannel("c" + std::to_string(i)));
  if (!isSplatted && areApart) layout.setNegative(-1, f.negativeMean());
  auto film = test::makeFilm(kSide, kSide, layout);
  test::Samples s(kFloats);
  std::mt19937 rng(9);
  std::uniform_real_distribution<float> uniform(0, 0.9999999f);
  const auto valueAt = [&](double x, double y) {
    return picture == Picture::Noise ? uniform(rng) : float(pictureAt(picture, x, y));
  };
  const int side = int(std::lround(std::sqrt(spp)));
  const int reach = isSplatted ? int(std::ceil(0.5f * f.xWidth() + 0.5f)) : 0;
  for (int py = -reach; py < kSide + reach; ++py)
    for (int px = -reach; px < kSide + reach; ++px)
      for (int i = 0; i < spp; ++i) {
        // jittered: what a stratified sampler gives both ways
        const float u = std::min((float(i % side) + uniform(rng)) / float(side), 0.9999999f);
        const float v = std::min((float(i / side) + uniform(rng)) / float(side), 0.9999999f);
        if (!isSplatted) {
          const FilterSample o = f.sample(u, v);
          const float value = valueAt(px + 0.5 + double(o.dx), py + 0.5 + double(o.dy));
          s.add(px, py, uint32_t(i), o.weight, std::vector<float>(kFloats, value));
          continue;
        }
        const double x = px + double(u), y = py + double(v);
        const float value = valueAt(x, y);
        for (int qy = py - reach; qy <= py + reach; ++qy)
          for (int qx = px - reach; qx <= px + reach; ++qx)
            if (const double w = f.evaluate(x - qx - 0.5, y - qy - 0.5); w != 0 && film->window().contains(qx, qy))
              s.add(qx, qy, uint32_t(i), float(w), std::vector<float>(kFloats, value));
      }
  const auto start = std::chrono::steady_clock::now();
  s.addTo(*film);
  const std::chrono::duration<double, std::nano> t = std::chrono::steady_clock::now() - start;
  Measured m;
  m.nanoseconds = t.count() / (kSide * kSide * spp);
  constexpr int kDense = 60;
  std::vector<double> error(size_t(kSide) * kSide);
  for (int py = 0; py < kSide; ++py)
    for (int px = 0; px < kSide; ++px) {
      double sum = 0, norm = 0;
      for (int j = 0; j < kDense; ++j)
        for (int i = 0; i < kDense; ++i) {
          const double x = ((i + 0.5) / kDense - 0.5) * double(f.xWidth());
          const double y = ((j + 0.5) / kDense - 0.5) * double(f.yWidth());
          const double w = f.evaluate(x, y);
          norm += w;
          sum += w * pictureAt(picture, px + 0.5 + x, py + 0.5 + y);
        }
      // splats are divided by their weights alone; Film's rule for weights that cancel is for importance sampling
      const int64_t* p = film->pixel(px, py);
      float resolved[3];
      film->resolvePixel(0, px, py, resolved);
      const double got = isSplatted ? double(p[film->firstSlot(0)]) / double(p[Film::kWeight]) : double(resolved[0]);
      const double e = error[size_t(py * kSide + px)] = got - sum / norm;
      m.pixels += e * e / (kSide * kSide);
    }
  for (int by = 0; by < kSide; by += 4)
    for (int bx = 0; bx < kSide; bx += 4) {
      double mean = 0;
      for (int k = 0; k < 16; ++k) mean += error[size_t((by + k / 4) * kSide + bx + k % 4)] / 16;
      m.blocks += mean * mean * 16 / (kSide * kSide);
    }
  return m;
}

// Whatever few samples a pixel has, of a filter of any shape, for the frame and for a channel of its own: what is the
// same everywhere stays what it is, in all samples and in halves, and its variance is none.
TEST(PixelFilter, AFlatPictureIsFlatAtAnyNumberOfSamples) {
  const PixelFilter wide = filter("gaussian", 6, 6);
  for (const std::string& name : PixelFilter::names())
    for (const float width : {2.0f, 4.0f, 6.0f}) {
      const PixelFilter own = filter(name.c_str(), width, width);
      for (const bool isOwn : {false, true}) {
        const PixelFilter& frame = isOwn ? wide : own;
        const FilterRatio ratio(frame, own);
        ChannelLayout layout;
        for (const Half half : {Half::Both, Half::Even, Half::Odd}) {
          Channel c = floatChannel("v" + std::to_string(int(half)), "v");
          c.half = half;
          if (isOwn) c.filter = {name, width, width};
          ASSERT_GE(layout.add(c), 0);
        }
        for (const Statistic statistic : {Statistic::Variance, Statistic::MeanVariance}) {
          Channel c = floatChannel("s" + std::to_string(int(statistic)), "v");
          c.statistic = statistic;
          if (isOwn) c.filter = {name, width, width};
          ASSERT_GE(layout.add(c), 0);
        }
        layout.setNegative(-1, frame.negativeMean());
        if (isOwn) layout.setNegative(0, ratio.negativeMean());
        std::mt19937 rng(5);
        std::uniform_real_distribution<float> uniform(0, 0.9999999f);
        for (const int spp : {1, 2, 3, 4, 5, 8, 16, 64}) {
          constexpr int kPixels = 256;
          constexpr float kValue = 0.18f;
          auto film = test::makeFilm(kPixels, 1, layout);
          std::vector<int32_t> x, y;
          std::vector<uint32_t> index;
          std::vector<float> weight, ownWeight, value;
          for (int p = 0; p < kPixels; ++p)
            for (int i = 0; i < spp; ++i) {
              const float u = uniform(rng), v = uniform(rng);
              x.push_back(p);
              y.push_back(0);
              index.push_back(uint32_t(i));
              weight.push_back(frame.sample(u, v).weight);
              ownWeight.push_back(ratio.weight(u, v));
              value.push_back(kValue);
            }
          const float *values = value.data(), *owns = ownWeight.data();
          SampleSpan span{int(x.size()), x.data(), y.data(), index.data(), weight.data(), &values, nullptr, &owns};
          film->addSamples(span);
          for (int p = 0; p < kPixels; ++p) {
            float got[5];
            for (int c = 0; c < 5; ++c) film->resolvePixel(c, p, 0, got + c);
            const std::string what = name + " " + std::to_string(width) + (isOwn ? " of a channel, " : ", ") +
                                     std::to_string(spp) + " samples, pixel " + std::to_string(p);
            for (int c = 0; c < 3; ++c) {
              if (c == 2 && spp == 1) continue;  // there is no odd sample
              // a step of rounding a sample, 2^-30, over the smallest weights of a channel's filter
              ASSERT_NEAR(got[c], kValue, 2e-3f * kValue) << what;
              if (!isOwn) {
                ASSERT_NEAR(got[c], kValue, 1e-6f * kValue) << what;
              }
            }
            // squares are rounded to 2^-26, and divided by the weights, which of a channel's filter may be small
            for (int c = 3; c < 5; ++c) ASSERT_NEAR(got[c], 0, (isOwn ? 0.1f : 1e-5f) * kValue * kValue) << what;
          }
        }
      }
    }
}

// With many samples the filter is what it is, lobes and all: its response to an edge, against quadrature.
TEST(PixelFilter, LobesAreThereInTheLimit) {
  for (const auto& [name, width] : {std::pair{"catmull-rom", 4.0f},
                                    {"separable-catmull-rom", 4.0f},
                                    {"mitchell", 4.0f},
                                    {"sinc", 6.0f},
                                    {"lanczos", 6.0f},
                                    {"bessel", 6.0f}}) {
    const PixelFilter f = filter(name, width, width);
    ChannelLayout layout;
    layout.add(floatChannel("v"));
    layout.setNegative(-1, f.negativeMean());
    bool isSharper = false;
    for (const double edge : {-2.0, -1.6, -1.2, -0.6, 0.0, 0.6, 1.2, 1.6, 2.0}) {
      auto film = test::makeFilm(1, 1, layout);
      test::Samples s(1);
      std::mt19937 rng(3);
      std::uniform_real_distribution<float> uniform(0, 1);
      constexpr int kSide = 256;
      for (int i = 0; i < kSide * kSide; ++i) {
        const FilterSample o = f.sample(std::min((float(i % kSide) + uniform(rng)) / kSide, 0.9999999f),
                                        std::min((float(i / kSide) + uniform(rng)) / kSide, 0.9999999f));
        s.add(0, 0, uint32_t(i), o.weight, {double(o.dx) > edge ? 1.0f : 0.0f});
      }
      s.addTo(*film);
      float got;
      film->resolvePixel(0, 0, 0, &got);
      constexpr int kDense = 600;
      double sum = 0, norm = 0;
      for (int j = 0; j < kDense; ++j)
        for (int i = 0; i < kDense; ++i) {
          const double x = ((i + 0.5) / kDense - 0.5) * double(width), y = ((j + 0.5) / kDense - 0.5) * double(width);
          const double w = f.evaluate(x, y);
          norm += w;
          if (x > edge) sum += w;
        }
      EXPECT_NEAR(double(got), sum / norm, 0.005) << name << " " << edge;
      isSharper |= double(got) > 1.001 || double(got) < -0.001;
    }
    EXPECT_TRUE(isSharper) << name << " has lost its lobes";
  }
}

// Two sums a lobe against one divided by the sum of the weights: never noisier, at the counts that frames have.
TEST(PixelFilter, LobesApartAreNotNoisierThanTogether) {
  std::printf("samples | filter | picture | mse together | apart\n");
  for (const auto& [name, width] : {std::pair{"mitchell", 4.0f}, {"separable-catmull-rom", 4.0f}, {"sinc", 6.0f}})
    for (const int spp : {16, 64, 256})
      for (const Picture picture : {Picture::Soft, Picture::Edges, Picture::Noise}) {
        if (spp == 256 && picture != Picture::Noise) continue;
        const PixelFilter f = filter(name, width, width);
        const double together = measure(f, picture, false, spp, false).pixels,
                     apart = measure(f, picture, false, spp, true).pixels;
        std::printf("%3d | %-21s | %-5s | %.2e | %.2e\n", spp, name, kPictures[int(picture)], together, apart);
        // 1,024 pixels: each error is known to 5 % (one standard deviation)
        EXPECT_LT(apart, 1.15 * together) << name << " " << spp;
      }
}

// The variance that a channel of statistics states is that of the pixels, lobes or not.
TEST(PixelFilter, StatedVariancesAreThoseOfThePixels) {
  for (const auto& [name, width] : {std::pair{"box", 1.0f}, {"mitchell", 4.0f}, {"sinc", 6.0f}}) {
    const PixelFilter f = filter(name, width, width);
    ChannelLayout layout;
    layout.add(floatChannel("v"));
    Channel mse = floatChannel("mse", "v");
    mse.statistic = Statistic::MeanVariance;
    layout.add(mse);
    layout.setNegative(-1, f.negativeMean());
    constexpr int kPixels = 4000, kSpp = 64;
    auto film = test::makeFilm(kPixels, 1, layout);
    test::Samples s(1);
    std::mt19937 rng(4);
    std::uniform_real_distribution<float> uniform(0, 0.9999999f);
    for (int p = 0; p < kPixels; ++p)
      for (int i = 0; i < kSpp; ++i)
        s.add(p, 0, uint32_t(i), f.sample(uniform(rng), uniform(rng)).weight, {uniform(rng)});
    s.addTo(*film);
    double sum = 0, squares = 0, stated = 0;
    for (int p = 0; p < kPixels; ++p) {
      float v, m;
      film->resolvePixel(0, p, 0, &v);
      film->resolvePixel(1, p, 0, &m);
      sum += double(v);
      squares += double(v) * double(v);
      stated += double(m) / kPixels;
    }
    const double variance = (squares - sum * sum / kPixels) / (kPixels - 1);
    // the variance of 4,000 values is known to sqrt(2 / 4000) = 2.2 %
    EXPECT_NEAR(stated, variance, 0.09 * variance) << name;
  }
}

TEST(PixelFilter, ImportanceSamplingAgainstSplatting) {
  const std::tuple<const char*, float> cases[] = {
      {"gaussian", 2.0f}, {"box", 1.0f}, {"mitchell", 4.0f}, {"separable-catmull-rom", 4.0f}, {"sinc", 6.0f}};
  std::printf("16 samples a pixel | picture | importance: mse, mse of 4x4 blocks, ns | splatted: the same\n");
  for (const auto& [name, width] : cases)
    for (const Picture picture : {Picture::Soft, Picture::Edges, Picture::Noise}) {
      const PixelFilter f = filter(name, width, width);
      const Measured a = measure(f, picture, false, 16), b = measure(f, picture, true, 16);
      std::printf("%-21s %.0f | %-5s | %.1e %.1e %5.1f | %.1e %.1e %6.1f\n", name, double(width),
                  kPictures[int(picture)], a.pixels, a.blocks, a.nanoseconds, b.pixels, b.blocks, b.nanoseconds);
      // both estimate the same picture: means over 16 pixels are noise of 256 samples, not bias
      EXPECT_LT(a.blocks, 0.02) << name;
      EXPECT_LT(b.blocks, 0.02) << name;
    }
}

}  // namespace
}  // namespace kinora::film
