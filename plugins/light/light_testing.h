// For the tests beside the lights: makes one light from named values and a placement, calls its tables at a chosen
// width over any number of points, and integrates what comes back. The checks that hold for every light live here,
// the closed forms and special cases in each light's test. Statistics over all parameters are the testing kit's.
#pragma once
#include <gtest/gtest.h>
#include <kinora/light.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "plugin/registry.h"

namespace kinora::lightTesting {

using Vec = std::array<double, 3>;
inline Vec operator-(Vec a, Vec b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec operator+(Vec a, Vec b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec operator*(Vec a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
inline double dot(Vec a, Vec b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec unit(Vec a) { return a * (1 / std::sqrt(dot(a, a))); }
inline Vec cross(Vec a, Vec b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline void frame(Vec n, Vec& x, Vec& y) {
  x = unit(cross(std::fabs(n[0]) < 0.5 ? Vec{1, 0, 0} : Vec{0, 1, 0}, n));
  y = cross(n, x);
}

using Matrix = std::array<double, 16>;
inline Matrix identity() { return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; }
inline Matrix scaleMove(double sx, double sy, double sz, Vec t) {
  return {sx, 0, 0, 0, 0, sy, 0, 0, 0, 0, sz, 0, t[0], t[1], t[2], 1};
}
// Rows of a rotation times scales, moved to t: a general rectangle-preserving placement.
inline Matrix turned(double sx, double sy, double sz, Vec t) {
  const Vec z = unit({0.3, -0.8, 0.52});
  Vec x, y;
  frame(z, x, y);
  return {x[0] * sx, x[1] * sx, x[2] * sx, 0, y[0] * sy, y[1] * sy, y[2] * sy, 0,
          z[0] * sz, z[1] * sz, z[2] * sz, 0, t[0],      t[1],      t[2],      1};
}

struct Setting {
  std::string name;
  std::vector<float> numbers;
  std::string text;
};
inline Setting set(const char* name, float x) { return {name, {x}, ""}; }
inline Setting set(const char* name, float r, float g, float b) { return {name, {r, g, b}, ""}; }
inline Setting setText(const char* name, const char* text) { return {name, {}, text}; }

struct Rays {  // structure of arrays, padded
  uint32_t n = 0;
  std::vector<float> a[24];
  explicit Rays(uint32_t count) : n(count) {
    for (auto& v : a) v.assign(padded(count) + kPad, 0.f);
  }
};

class TestLight {
 public:
  TestLight(const char* name, std::vector<Setting> settings, Matrix m = identity(), const HostImage* image = nullptr,
            const void* extra = nullptr)
      : image_(image) {
    for (const Descriptor* d : stockPlugins())
      if (std::string(d->name) == name) d_ = d;
    if (!d_) throw std::string("no such light: ") + name;
    std::vector<ParamValue> values(d_->paramCount);
    std::vector<const char*> texts(d_->paramCount);
    for (uint32_t i = 0; i < d_->paramCount; ++i) {
      const Param& p = d_->params[i];
      texts[i] = p.text;
      values[i].floats = p.value;
      values[i].strings = &texts[i];
      values[i].count = p.type == Type::Float || p.type == Type::Int || p.type == Type::String ? 1 : 3;
      if (p.flags & kParamArray) values[i].floats = p.list, values[i].count = p.listCount;
      for (const Setting& s : settings)
        if (s.name == p.name) {
          if (p.type == Type::String)
            texts[i] = s.text.c_str();
          else
            values[i].floats = s.numbers.data();
          if (p.flags & kParamArray) values[i].count = uint32_t(s.numbers.size());
          values[i].given = 1;
        }
    }
    Host host{this,
              [](void* self, const char* code, const char* what, const char*) {
                static_cast<TestLight*>(self)->warnings.push_back(std::string(code) + ": " + what);
              },
              [](void* self, const char*, int) { return static_cast<TestLight*>(self)->image_; }};
    Placement placement{};
    for (int i = 0; i < 16; ++i) placement.localToRender[i] = m[size_t(i)];
    placement.isStatic = 1;
    const CreateInfo info{&host, "test", values.data(), d_->paramCount, &placement, extra};
    ErrorText text{};
    data_ = d_->create(&info, &text);
    error = text.text;
    if (data_) traits().describe(data_, &description);
  }
  ~TestLight() {
    if (data_) d_->destroy(data_);
  }
  TestLight(const TestLight&) = delete;

  bool made() const { return data_ != nullptr; }
  const void* data() const { return data_; }
  const LightTraits& traits() const { return *static_cast<const LightTraits*>(d_->traits); }
  double closedForm(Vec P, Vec N) const { return traits().irradiance(data_, P.data(), N.data()); }
  const LightFunctions& functions() const { return *static_cast<const LightFunctions*>(functionsFor(*d_, width)); }

  // columns of Rays: 0..2 P, 3 4 u; out 5..7 wi, 8 distance, 9..11 radiance, 12 pdf; flags apart
  void sample(Rays& r, std::vector<uint32_t>* flagsOut = nullptr) const {
    std::vector<uint32_t> flags(r.a[0].size());
    const void* light = data_;
    LightSampleArgs a{};
    a.light = &light;
    a.count = r.n;
    for (int c = 0; c < 3; ++c) {
      a.P[c] = r.a[c].data();
      a.wi[c] = r.a[5 + c].data();
      a.radiance[c] = r.a[9 + c].data();
    }
    a.time = timeOf(r);
    a.u[0] = r.a[3].data();
    a.u[1] = r.a[4].data();
    a.worldRadius = worldRadius;
    a.distance = r.a[8].data();
    a.pdf = r.a[12].data();
    a.flags = flags.data();
    functions().sample(&a);
    if (flagsOut) *flagsOut = flags;
  }
  LightRayArgs rayArgs(Rays& r) const {
    LightRayArgs a{};
    a.light = &data_;
    a.count = r.n;
    for (int c = 0; c < 3; ++c) {
      a.o[c] = r.a[c].data();
      a.d[c] = r.a[5 + c].data();
      a.radiance[c] = r.a[13 + c].data();
    }
    a.time = timeOf(r);
    a.t = r.a[8].data();
    a.pdf = r.a[16].data();
    a.worldRadius = worldRadius;
    return a;
  }
  // columns: 0..2 o, 5..7 d, 8 t; out 13..15 radiance, 16 pdf. Lanes that do not hit give 0.
  void look(Rays& r) const {
    std::vector<uint32_t> hit(r.a[0].size(), 1);
    LightRayArgs a = rayArgs(r);
    a.hit = hit.data();
    if (functions().intersect) functions().intersect(&a);
    functions().evaluate(&a);
    for (uint32_t i = 0; i < r.n; ++i)
      if (!hit[i])
        for (int c = 13; c <= 16; ++c) r.a[c][i] = 0;
  }
  // evaluate alone, at the directions and distances that sample() made
  void evaluate(Rays& r) const {
    const LightRayArgs a = rayArgs(r);
    functions().evaluate(&a);
  }
  // columns: 0..3 u; out 4..6 o, 7..9 d, 10..12 N, 13..15 radiance, 16 pdfPosition, 17 pdfDirection
  void emit(Rays& r) const {
    const void* light = data_;
    LightEmitArgs a{};
    a.light = &light;
    a.count = r.n;
    for (int c = 0; c < 4; ++c) a.u[c] = r.a[c].data();
    a.time = timeOf(r);
    for (int c = 0; c < 3; ++c) {
      a.o[c] = r.a[4 + c].data();
      a.d[c] = r.a[7 + c].data();
      a.N[c] = r.a[10 + c].data();
      a.radiance[c] = r.a[13 + c].data();
      a.worldCenter[c] = float(worldCenter[size_t(c)]);
    }
    a.pdfPosition = r.a[16].data();
    a.pdfDirection = r.a[17].data();
    a.worldRadius = worldRadius;
    functions().emit(&a);
  }

  LightDescription description{};
  std::vector<std::string> warnings;
  std::string error;
  uint32_t width = 16;
  float worldRadius = 10;
  std::optional<float> time;  // of all that is asked; none: each row has its own
  Vec worldCenter{0, 0, 0};

 private:
  const float* timeOf(Rays& r) const {
    if (time) std::fill(r.a[23].begin(), r.a[23].end(), *time);
    return r.a[23].data();
  }
  const Descriptor* d_ = nullptr;
  void* data_ = nullptr;
  const HostImage* image_ = nullptr;
};

// Jittered grid of side^2 points; a fixed seed keeps failures reproducible.
inline void fillGrid(std::vector<float>& u, std::vector<float>& v, uint32_t side, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(0, 1);
  const double below1 = 1 - 6e-8;
  for (uint32_t i = 0; i < side * side; ++i) {
    u[i] = float(std::fmin(below1, (i % side + jitter(random)) / side));
    v[i] = float(std::fmin(below1, (i / side + jitter(random)) / side));
  }
}

inline double mean3(const Rays& r, int column, uint32_t i) {
  return (double(r.a[column][i]) + r.a[column + 1][i] + r.a[column + 2][i]) / 3;
}

// Irradiance on a surface at P facing N, averaged over RGB, from the light's own samples.
inline double irradianceBySampling(const TestLight& light, Vec P, Vec N, uint32_t side = 512) {
  Rays r(side * side);
  fillGrid(r.a[3], r.a[4], side, 1);
  for (int c = 0; c < 3; ++c) std::fill(r.a[c].begin(), r.a[c].end(), float(P[size_t(c)]));
  light.sample(r);
  double sum = 0;
  for (uint32_t i = 0; i < r.n; ++i) {
    const double cosine = r.a[5][i] * N[0] + r.a[6][i] * N[1] + r.a[7][i] * N[2];
    if (r.a[12][i] > 0 && cosine > 0) sum += mean3(r, 9, i) * cosine / r.a[12][i];
  }
  return sum / r.n;
}

// The same by looking into a grid of directions within `half` radians of `axis`; also the integral of the pdf.
struct Looked {
  double irradiance, pdf;
};
inline Looked lookAround(const TestLight& light, Vec P, Vec N, Vec axis, double half, uint32_t side = 1024) {
  Rays r(side * side);
  std::vector<float> u(r.n), v(r.n);
  fillGrid(u, v, side, 2);
  Vec x, y;
  frame(axis, x, y);
  const double top = 2 * std::sin(half / 2) * std::sin(half / 2);
  for (uint32_t i = 0; i < r.n; ++i) {
    const double h = u[i] * top, s = std::sqrt(h * (2 - h)), phi = 6.283185307179586 * v[i];
    const Vec d = x * (s * std::cos(phi)) + y * (s * std::sin(phi)) + axis * (1 - h);
    for (int c = 0; c < 3; ++c) {
      r.a[c][i] = float(P[size_t(c)]);
      r.a[5 + c][i] = float(d[size_t(c)]);
    }
    r.a[8][i] = 1e30f;
  }
  light.look(r);
  double e = 0, p = 0;
  for (uint32_t i = 0; i < r.n; ++i) {
    const double cosine = r.a[5][i] * N[0] + r.a[6][i] * N[1] + r.a[7][i] * N[2];
    if (cosine > 0) e += mean3(r, 13, i) * cosine;
    p += r.a[16][i];
  }
  const double omega = 6.283185307179586 * top;
  return {e * omega / r.n, p * omega / r.n};
}

// Points around a light, for checks that hold everywhere.
inline std::vector<Vec> pointsAround(const TestLight& light, uint32_t n, double nearest = 0.05,
                                     double farthest = 20) {
  std::mt19937 random(7);
  std::normal_distribution<double> g;
  std::uniform_real_distribution<double> u(std::log(nearest), std::log(farthest));
  std::vector<Vec> points(n);
  for (Vec& p : points) {
    const Vec c{light.description.center[0], light.description.center[1], light.description.center[2]};
    const double r = light.description.isInfinite ? 1 : light.description.radius;
    p = c + unit({g(random), g(random), g(random)}) * (r * std::exp(u(random)));
  }
  return points;
}

// `each` samples from each point, and what evaluate() makes of their directions.
inline Rays sampledAndEvaluated(const TestLight& light, const std::vector<Vec>& points, uint32_t each) {
  Rays r(uint32_t(points.size()) * each);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(0, 1 - 6e-8);
  for (uint32_t i = 0; i < r.n; ++i) {
    for (int c = 0; c < 3; ++c) r.a[c][i] = float(points[i / each][size_t(c)]);
    r.a[3][i] = float(u(random));
    r.a[4][i] = float(u(random));
  }
  light.sample(r);
  light.evaluate(r);
  return r;
}

// sample() and evaluate() agree about density and radiance at the directions sample() makes.
inline void expectDensitiesAgree(const TestLight& light, const std::vector<Vec>& points, uint32_t each = 64) {
  const Rays r = sampledAndEvaluated(light, points, each);
  uint32_t wrong = 0, sampled = 0;
  for (uint32_t i = 0; i < r.n; ++i) {
    if (!(r.a[12][i] > 0)) continue;
    ++sampled;
    const bool pdf = std::fabs(r.a[16][i] - r.a[12][i]) <= 1e-4 * r.a[12][i];
    const bool radiance = std::fabs(mean3(r, 13, i) - mean3(r, 9, i)) <= 2e-3 * std::fabs(mean3(r, 9, i)) + 1e-5;
    const double norm = r.a[5][i] * double(r.a[5][i]) + r.a[6][i] * double(r.a[6][i]) + r.a[7][i] * double(r.a[7][i]);
    if (pdf && radiance && std::fabs(norm - 1) < 1e-5) continue;
    if (++wrong <= 5)
      ADD_FAILURE() << "sample " << i << " from " << r.a[0][i] << ' ' << r.a[1][i] << ' ' << r.a[2][i] << ": pdf "
                    << r.a[12][i] << " against " << r.a[16][i] << ", radiance " << mean3(r, 9, i) << " against "
                    << mean3(r, 13, i) << ", u " << r.a[3][i] << ' ' << r.a[4][i] << " |d|^2 " << norm;
  }
  EXPECT_EQ(wrong, 0u) << "of " << sampled;
  EXPECT_GT(sampled, r.n / 20);
}

// Emitted power by emit(), averaged over RGB.
inline double emittedPower(const TestLight& light, uint32_t side = 512) {
  Rays r(side * side);
  fillGrid(r.a[0], r.a[1], side, 4);
  fillGrid(r.a[2], r.a[3], side, 5);
  // the two grids must not be walked in step
  std::mt19937 random(6);
  for (uint32_t i = r.n - 1; i > 0; --i) {
    const uint32_t j = random() % (i + 1);
    std::swap(r.a[2][i], r.a[2][j]);
    std::swap(r.a[3][i], r.a[3][j]);
  }
  light.emit(r);
  double sum = 0;
  for (uint32_t i = 0; i < r.n; ++i) {
    const double p = double(r.a[16][i]) * r.a[17][i];
    const double cosine =
        double(r.a[7][i]) * r.a[10][i] + double(r.a[8][i]) * r.a[11][i] + double(r.a[9][i]) * r.a[12][i];
    if (p > 0) sum += mean3(r, 13, i) * cosine / p;
  }
  return sum / r.n;
}

// Every width gives the same bits in every column.
inline void expectWidthsAgree(TestLight& light, const std::vector<Vec>& points) {
  const auto run = [&](uint32_t width) {
    light.width = width;
    Rays r(uint32_t(points.size())), e(uint32_t(points.size()));
    std::mt19937 random(9);
    std::uniform_real_distribution<double> u(0, 1 - 6e-8);
    for (uint32_t i = 0; i < r.n; ++i) {
      for (int c = 0; c < 3; ++c) r.a[c][i] = float(points[i][size_t(c)]);
      r.a[3][i] = float(u(random));
      r.a[4][i] = float(u(random));
      for (int c = 0; c < 4; ++c) e.a[c][i] = float(u(random));
    }
    light.sample(r);
    light.look(r);
    light.emit(e);
    std::vector<float> all;
    for (int c = 5; c <= 16; ++c) all.insert(all.end(), r.a[c].begin(), r.a[c].begin() + r.n);
    for (int c = 4; c <= 17; ++c) all.insert(all.end(), e.a[c].begin(), e.a[c].begin() + e.n);
    return all;
  };
  const std::vector<float> one = run(1);
  for (uint32_t width : {4u, 8u, 16u}) {
    const std::vector<float> other = run(width);
    ASSERT_EQ(one.size(), other.size());
    size_t differ = 0;
    for (size_t i = 0; i < one.size(); ++i) differ += std::memcmp(&one[i], &other[i], 4) != 0;
    EXPECT_EQ(differ, 0u) << "width " << width;
  }
  light.width = 16;
}

// Whatever the point, nothing that is not a number comes out (infinite distances of infinite lights apart).
inline void expectNoNaN(const TestLight& light) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const float odd[] = {0, 1e-30f, -0.5f, 0.5f, 1e-6f, 1e6f, -1e18f, 3e38f, inf, nan};
  std::vector<Vec> points;
  for (float x : odd)
    for (float y : odd)
      for (float z : odd) points.push_back({x, y, z});
  Rays r(uint32_t(points.size())), e(uint32_t(points.size()));
  std::mt19937 random(9);
  std::uniform_real_distribution<double> u(0, 1 - 6e-8);
  for (uint32_t i = 0; i < r.n; ++i) {
    for (int c = 0; c < 3; ++c) r.a[c][i] = float(points[i][size_t(c)]);
    r.a[3][i] = i % 3 ? float(u(random)) : 0.f;
    r.a[4][i] = i % 5 ? float(u(random)) : 0.99999994f;
    for (int c = 0; c < 4; ++c) e.a[c][i] = i % (c + 3u) ? float(u(random)) : 0.f;
  }
  light.sample(r);
  light.look(r);
  light.emit(e);
  for (uint32_t i = 0; i < r.n; ++i) {
    for (int c : {5, 6, 7, 9, 10, 11, 12, 13, 14, 15, 16})
      ASSERT_TRUE(std::isfinite(r.a[c][i])) << "point " << i << " column " << c;
    ASSERT_FALSE(std::isnan(r.a[8][i])) << "point " << i;
    for (int c = 4; c <= 17; ++c) ASSERT_TRUE(std::isfinite(e.a[c][i])) << "emit " << i << " column " << c;
  }
}

// Placements that leave no light: black with a warning or refused with a reason, never NaN.
inline void expectDegenerateIsSafe(const char* name, bool scaleMatters) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  {
    TestLight light(name, {}, scaleMove(nan, 1, 1, {0, 0, 0}));
    EXPECT_FALSE(light.made());
    EXPECT_FALSE(light.error.empty());
  }
  {
    TestLight light(name, {}, scaleMove(1, 1, 1, {0, nan, 0}));
    EXPECT_FALSE(light.made());
  }
  for (const Matrix& m :
       {scaleMove(0, 0, 0, {1, 2, 3}), scaleMove(0, 1, 1, {0, 0, 0}), scaleMove(1e-200, 1e-200, 1e-200, {0, 0, 0})}) {
    TestLight light(name, {}, m);
    ASSERT_TRUE(light.made());
    if (scaleMatters) {
      EXPECT_FALSE(light.warnings.empty());
      EXPECT_EQ(light.description.power, 0);
    }
    expectNoNaN(light);
  }
  TestLight mirrored(name, {}, turned(-1, 1, 1, {0.2, 0, 0}));
  ASSERT_TRUE(mirrored.made());
  EXPECT_GT(mirrored.description.power, 0);
  expectNoNaN(mirrored);
}

}  // namespace kinora::lightTesting
