// Proves that samples drawn from the tables have the filter's moments: against closed forms where they exist and
// against direct quadrature of evaluate() for every filter and several widths. Prints, but does not judge, the
// comparison with splatting that docs/performance.md records. It misses the gather by groups, which render/ tests.
#include "film/pixel_filter.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>

#include "film/film.h"
#include "film/film_test_samples.h"

namespace kinora::film {
namespace {

struct Moments {
  double one = 0, x = 0, y = 0, xx = 0, yy = 0, xxyy = 0, absolute = 0;
};

Moments sampled(const PixelFilter& f, int n) {
  Moments m;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const FilterSample s = f.sample((float(i) + 0.5f) / float(n), (float(j) + 0.5f) / float(n));
      const double w = double(s.weight) / (double(n) * n), x = s.dx, y = s.dy;
      m.one += w;
      m.x += w * x;
      m.y += w * y;
      m.xx += w * x * x;
      m.yy += w * y * y;
      m.xxyy += w * x * x * y * y;
      m.absolute += std::fabs(w);
    }
  return m;
}

Moments integrated(const PixelFilter& f, int n) {
  Moments m;
  double norm = 0;
  const double dx = double(f.xWidth()) / n, dy = double(f.yWidth()) / n;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double x = (i + 0.5) * dx - 0.5 * double(f.xWidth()), y = (j + 0.5) * dy - 0.5 * double(f.yWidth());
      const double w = f.evaluate(x, y);
      norm += w;
      m.x += w * x;
      m.y += w * y;
      m.xx += w * x * x;
      m.yy += w * y * y;
      m.xxyy += w * x * x * y * y;
      m.absolute += std::fabs(w);
    }
  m.one = 1;
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

Measured measure(const PixelFilter& f, Picture picture, bool isSplatted, int spp) {
  constexpr int kSide = 32, kFloats = 30;
  ChannelLayout layout;
  for (int i = 0; i < kFloats / 3; ++i) layout.add(colorChannel("c" + std::to_string(i)));
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
