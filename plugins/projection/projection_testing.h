// For the tests beside the projections: makes one from named values, traces rays and connects points at a chosen
// width, and holds the checks that every projection passes: the way back is the inverse, light paths weigh like
// camera paths, all widths agree.
#pragma once
#include <gtest/gtest.h>
#include <kinora/projection.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "plugin/registry.h"

namespace kinora::projectionTesting {

struct Setting {
  std::string name;
  float value = 0;
  const float* list = nullptr;  // of three, instead
  Setting(const char* name, float value) : name(name), value(value) {}
  Setting(const char* name, const float* list) : name(name), list(list) {}
};

inline ProjectionInfo frame(uint32_t width, uint32_t height) {
  ProjectionInfo i{};
  i.resolution[0] = width;
  i.resolution[1] = height;
  i.frameAspect = float(width) / float(height);
  return i;
}

struct Columns {  // 0 1 raster, 2 3 lens, 4 time, 5..7 o, 8..10 d, 11 weight, 12 radius, 13 spread
  uint32_t n;     // connect: 14..16 P, 17..19 o, 20 21 raster, 22 importance, 23 pdf
  std::vector<float> a[24];
  explicit Columns(uint32_t count) : n(count) {
    for (auto& v : a) v.assign(padded(count), 0.f);
  }
};

class TestProjection {
 public:
  TestProjection(const char* name, std::vector<Setting> settings, const ProjectionInfo& info) : info(info) {
    for (const Descriptor* d : stockPlugins())
      if (std::string(d->name) == name) d_ = d;
    if (!d_) throw std::string("no such projection: ") + name;
    std::vector<ParamValue> values(d_->paramCount);
    for (uint32_t i = 0; i < d_->paramCount; ++i) {
      const Param& p = d_->params[i];
      values[i].floats = p.flags & kParamArray ? p.list : p.value;
      values[i].strings = &p.text;
      values[i].count = p.flags & kParamArray ? p.listCount : p.type == Type::Color || p.type == Type::Point ? 3 : 1;
      for (const Setting& s : settings)
        if (s.name == p.name) {
          values[i].floats = s.list ? s.list : &s.value;
          values[i].count = s.list ? 3 : 1;
          values[i].given = 1;
        }
    }
    Host host{this,
              [](void* self, const char* code, const char* what, const char*) {
                static_cast<TestProjection*>(self)->warnings.push_back(std::string(code) + ": " + what);
              },
              nullptr};
    const CreateInfo create{&host, "test", values.data(), d_->paramCount, nullptr, &this->info};
    ErrorText text{};
    data_ = d_->create(&create, &text);
    error = text.text;
  }
  ~TestProjection() {
    if (data_) d_->destroy(data_);
  }
  TestProjection(const TestProjection&) = delete;
  bool made() const { return data_ != nullptr; }
  const ProjectionFunctions& functions() const {
    return *static_cast<const ProjectionFunctions*>(functionsFor(*d_, width));
  }
  void rays(Columns& c) const {
    CameraSampleArgs a{};
    a.count = c.n;
    for (int i = 0; i < 2; ++i) {
      a.raster[i] = c.a[i].data();
      a.lens[i] = c.a[2 + i].data();
    }
    a.time = c.a[4].data();
    for (int i = 0; i < 3; ++i) {
      a.o[i] = c.a[5 + i].data();
      a.d[i] = c.a[8 + i].data();
    }
    a.weight = c.a[11].data();
    a.radius = c.a[12].data();
    a.spread = c.a[13].data();
    functions().rays(data_, &a);
  }
  void connect(Columns& c) const {
    CameraConnectArgs a{};
    a.count = c.n;
    for (int i = 0; i < 2; ++i) {
      a.lens[i] = c.a[2 + i].data();
      a.raster[i] = c.a[20 + i].data();
    }
    a.time = c.a[4].data();
    for (int i = 0; i < 3; ++i) {
      a.P[i] = c.a[14 + i].data();
      a.o[i] = c.a[17 + i].data();
    }
    a.importance = c.a[22].data();
    a.pdf = c.a[23].data();
    functions().connect(data_, &a);
  }
  // The ray of one raster position, through the middle of the lens.
  std::array<double, 6> ray(double x, double y, double u = 0.5, double v = 0.5, double time = 0) const {
    Columns c(1);
    const double in[5] = {x, y, u, v, time};
    for (int i = 0; i < 5; ++i) c.a[i][0] = float(in[i]);
    rays(c);
    std::array<double, 6> r;
    for (int i = 0; i < 6; ++i) r[size_t(i)] = c.a[5 + i][0];
    return r;
  }

  ProjectionInfo info;
  std::vector<std::string> warnings;
  std::string error;
  uint32_t width = 16;

 private:
  const Descriptor* d_ = nullptr;
  void* data_ = nullptr;
};

inline void fill(Columns& c, const ProjectionInfo& info, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(0, 1 - 6e-8);
  for (uint32_t i = 0; i < c.n; ++i) {
    c.a[0][i] = float(0.01 + u(random) * (info.resolution[0] - 0.02));
    c.a[1][i] = float(0.01 + u(random) * (info.resolution[1] - 0.02));
    for (int k = 2; k < 5; ++k) c.a[k][i] = float(u(random));
  }
}

// connect(a point on the ray of rays()) finds the raster position, the lens point and a density again.
inline void expectRoundTrip(const TestProjection& projection) {
  Columns c(512);
  fill(c, projection.info, 1);
  projection.rays(c);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(std::log(0.1), std::log(1000));
  for (uint32_t i = 0; i < c.n; ++i) {
    const double t = std::exp(u(random));
    for (int k = 0; k < 3; ++k) c.a[14 + k][i] = float(c.a[5 + k][i] + t * c.a[8 + k][i]);
  }
  projection.connect(c);
  for (uint32_t i = 0; i < c.n; ++i) {
    ASSERT_NEAR(c.a[20][i], c.a[0][i], 2e-3) << i;
    ASSERT_NEAR(c.a[21][i], c.a[1][i], 2e-3) << i;
    for (int k = 0; k < 3; ++k) ASSERT_NEAR(c.a[17 + k][i], c.a[5 + k][i], 1e-5);
    ASSERT_GT(c.a[22][i], 0);
    ASSERT_GT(c.a[23][i], 0);
  }
}

// A wall at the given depth, tilted, with a radiance that varies: the mean of the camera's samples of the picture
// equals the sum of splats from points chosen evenly over the wall. `pdf` is held against the wall's part that the
// picture sees.
inline void expectLightPathsAgree(const TestProjection& projection, double depth, double halfSize) {
  const double tilt = 0.2;  // the wall: z = depth + tilt * x
  const auto radiance = [](double x, double y) { return 1 + 0.5 * std::sin(3 * x) * std::cos(2 * y); };
  const uint32_t side = 512, n = side * side;
  const double pixels = double(projection.info.resolution[0]) * projection.info.resolution[1];
  Columns c(n);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(0, 1);
  for (uint32_t i = 0; i < n; ++i) {
    c.a[0][i] = float((i % side + u(random)) / side * projection.info.resolution[0] * (1 - 1e-7));
    c.a[1][i] = float((i / side + u(random)) / side * projection.info.resolution[1] * (1 - 1e-7));
    for (int k = 2; k < 5; ++k) c.a[k][i] = float(u(random) * (1 - 6e-8));
  }
  projection.rays(c);
  double camera = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const double t = (depth + tilt * c.a[5][i] - c.a[7][i]) / (c.a[10][i] - tilt * c.a[8][i]);
    const double x = c.a[5][i] + t * c.a[8][i], y = c.a[6][i] + t * c.a[9][i];
    ASSERT_TRUE(t > 0 && std::fabs(x) < halfSize && std::fabs(y) < halfSize) << "the wall must fill the picture";
    camera += c.a[11][i] * radiance(x, y) / n;
  }
  const double slope = std::sqrt(1 + tilt * tilt), area = 4 * halfSize * halfSize * slope;
  for (uint32_t i = 0; i < n; ++i) {
    const double x = ((i % side + u(random)) / side * 2 - 1) * halfSize,
                 y = ((i / side + u(random)) / side * 2 - 1) * halfSize;
    c.a[14][i] = float(x);
    c.a[15][i] = float(y);
    c.a[16][i] = float(depth + tilt * x);
  }
  projection.connect(c);
  double splats = 0, density = 0;
  for (uint32_t i = 0; i < n; ++i) {
    if (!(c.a[22][i] > 0)) continue;
    double w[3], r2 = 0;
    for (int k = 0; k < 3; ++k) {
      w[k] = double(c.a[14 + k][i]) - c.a[17 + k][i];
      r2 += w[k] * w[k];
    }
    const double r = std::sqrt(r2), cosWall = std::fabs(w[2] - tilt * w[0]) / (r * slope);
    splats += radiance(c.a[14][i], c.a[15][i]) * c.a[22][i] * cosWall / r2 * area / n;
    density += c.a[23][i] / pixels * cosWall / r2 * area / n;
  }
  // the picture's mean is the sum of its pixels over their number
  EXPECT_NEAR(splats / pixels, camera, 3e-3 * camera);
  EXPECT_NEAR(density, 1, 3e-3);
}

// The density of rays, integrated over all directions, is the number of pixels that see something. The eye is at the
// origin.
inline void expectDensityCounts(const TestProjection& projection, double pixels, double tolerance = 0.02) {
  constexpr int kSteps = 200, kRows = 4000;
  Columns c(kSteps);
  double sum = 0;
  for (int j = 0; j < kRows; ++j) {
    const double s = -1 + 2 * (j + 0.5) / kRows, across = std::sqrt(1 - s * s);
    for (int i = 0; i < kSteps; ++i) {
      const double turn = 2 * M_PI * (i + 0.5) / kSteps;
      c.a[14][size_t(i)] = float(3 * across * std::sin(turn));
      c.a[15][size_t(i)] = float(3 * s);
      c.a[16][size_t(i)] = float(3 * across * std::cos(turn));
    }
    projection.connect(c);
    for (int i = 0; i < kSteps; ++i) sum += c.a[23][size_t(i)] * 4 * M_PI / (double(kRows) * kSteps);
  }
  EXPECT_NEAR(sum / pixels, 1, tolerance);
}

// The footprint's spread is half the side of a square of the solid angle that a pixel covers, by differences of rays.
inline void expectSpreadsArePixels(const TestProjection& projection, double x, double y) {
  constexpr double kStep = 0.25;
  const auto at = [&](double px, double py) {
    const auto r = projection.ray(px, py);
    return std::array<double, 3>{r[3], r[4], r[5]};
  };
  const auto left = at(x - kStep, y), right = at(x + kStep, y), up = at(x, y - kStep), down = at(x, y + kStep);
  std::array<double, 3> u, v;
  for (size_t k = 0; k < 3; ++k) {
    u[k] = (right[k] - left[k]) / (2 * kStep);
    v[k] = (down[k] - up[k]) / (2 * kStep);
  }
  const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  Columns c(1);
  c.a[0][0] = float(x);
  c.a[1][0] = float(y);
  projection.rays(c);
  const double side = std::sqrt(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]));
  EXPECT_NEAR(2 * c.a[13][0] / side, 1, 0.01) << x << " " << y;
}

inline void expectWidthsAgree(TestProjection& projection) {
  std::vector<float> first;
  for (uint32_t width : {1u, 4u, 8u, 16u}) {
    projection.width = width;
    Columns c(333);
    fill(c, projection.info, 3);
    projection.rays(c);
    for (uint32_t i = 0; i < c.n; ++i)
      for (int k = 0; k < 3; ++k) c.a[14 + k][i] = c.a[5 + k][i] + 3 * c.a[8 + k][i];
    projection.connect(c);
    std::vector<float> all;
    for (auto& column : c.a) all.insert(all.end(), column.begin(), column.begin() + c.n);
    if (first.empty()) first = all;
    EXPECT_EQ(std::memcmp(first.data(), all.data(), all.size() * 4), 0) << "width " << width;
  }
  projection.width = 16;
}

// Points behind, at the eye, beside the picture or not finite are not seen, and give numbers.
inline void expectOddPointsUnseen(const TestProjection& projection) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const float points[][3] = {{0, 0, -1},  {0, 0, 0},     {1e6f, 0, 1}, {nan, 0, 1},           {0, 0, nan},
                             {0, inf, 1}, {inf, 0, inf}, {0, 0, -inf}, {3e38f, 3e38f, 1e-38f}};
  Columns c(uint32_t(std::size(points)));
  for (uint32_t i = 0; i < c.n; ++i)
    for (int k = 0; k < 3; ++k) c.a[14 + k][i] = points[i][k];
  projection.connect(c);
  for (uint32_t i = 0; i < c.n; ++i) {
    EXPECT_EQ(c.a[22][i], 0) << i;
    EXPECT_EQ(c.a[23][i], 0) << i;
    for (int k = 17; k < 24; ++k) EXPECT_TRUE(std::isfinite(c.a[k][i])) << i << ' ' << k;
  }
}

// Frames without pixels or shape are refused with a reason.
inline void expectBadFramesRefused(const char* name) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<ProjectionInfo> bad(5, frame(64, 48));
  bad[0].resolution[0] = 0;
  bad[1].frameAspect = nan;
  bad[2].frameAspect = -1;
  bad[3].screenWindowGiven = 1;  // all zero
  bad[4].screenWindowGiven = 1;
  bad[4].screenWindow[0] = nan;
  for (const ProjectionInfo& info : bad) {
    TestProjection projection(name, {}, info);
    EXPECT_FALSE(projection.made());
    EXPECT_FALSE(projection.error.empty());
  }
}

}  // namespace kinora::projectionTesting
