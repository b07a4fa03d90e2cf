// A light made for a test, and the arrays that its functions want. Not installed.
#pragma once
#include <kinora/light.h>
#include <kinora/light_mesh.h>
#include <kinora/testing/light_checks.h>
#include <kinora/testing/statistics.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "testing/bound_bxdf.h"

namespace kinora::testing {

// What a mesh light under test is made of.
struct TestMesh {
  explicit TestMesh(const Placement& placement);
  LightMesh mesh;

 private:
  std::vector<float> points_;
};

class MadeLight {
 public:
  MadeLight(const Descriptor& d, const Setting& s, const Placement& placement);
  ~MadeLight();
  MadeLight(const MadeLight&) = delete;
  MadeLight& operator=(const MadeLight&) = delete;
  void* data() const { return data_; }
  const std::string& error() const { return error_; }  // "" when made
  const LightDescription& description() const { return description_; }

 private:
  const Descriptor& descriptor_;
  void* data_ = nullptr;
  std::string error_;
  LightDescription description_{};
  TestMesh mesh_;
};

inline constexpr float kWorldRadius = 10;

// n rows of floats, padded; outputs start as NaN.
class Rows {
 public:
  Rows(uint32_t n, uint32_t rows)
      : n_(n), padded_(padded(n)), data_(size_t(padded_) * rows, std::numeric_limits<float>::quiet_NaN()) {}
  float* operator[](uint32_t r) { return data_.data() + size_t(r) * padded_; }
  const float* operator[](uint32_t r) const { return data_.data() + size_t(r) * padded_; }
  uint32_t count() const { return n_; }
  void fill(uint32_t r, float v) { std::fill_n((*this)[r], padded_, v); }
  void pad(uint32_t r) { std::fill((*this)[r] + n_, (*this)[r] + padded_, (*this)[r][n_ - 1]); }
  void set(uint32_t r, uint32_t i, Vec3 v) {
    (*this)[r][i] = v.x;
    (*this)[r + 1][i] = v.y;
    (*this)[r + 2][i] = v.z;
  }
  Vec3 get(uint32_t r, uint32_t i) const { return {(*this)[r][i], (*this)[r + 1][i], (*this)[r + 2][i]}; }

 private:
  uint32_t n_, padded_;
  std::vector<float> data_;
};

// sample() at n points.
struct LightSamples {
  enum : uint32_t { kP = 0, kTime = 3, kU = 4, kWi = 6, kDistance = 9, kRadiance = 10, kPdf = 13, kRows };
  Rows a;
  std::vector<uint32_t> flags;
  explicit LightSamples(uint32_t n) : a(n, kRows), flags(padded(n), ~0u) { a.fill(kTime, 0.5f); }
  void run(const LightFunctions& f, const void* light) { run(f, &light, false); }
  void run(const LightFunctions& f, const void* const* lights, bool byLane);
  bool valid(uint32_t i) const { return a[kPdf][i] > 0; }
};
// intersect() and evaluate() along n rays; a ray that hits nothing gives no radiance and pdf 0.
struct LightRays {
  enum : uint32_t { kO = 0, kD = 3, kTime = 6, kT = 7, kRadiance = 8, kPdf = 11, kRows };
  Rows a;
  std::vector<uint32_t> hit;
  explicit LightRays(uint32_t n) : a(n, kRows), hit(padded(n), ~0u) { a.fill(kTime, 0.5f); }
  void run(const LightFunctions& f, const void* light, bool finite) { run(f, &light, false, finite); }
  void run(const LightFunctions& f, const void* const* lights, bool byLane, bool finite);
};
struct LightEmissions {
  enum : uint32_t {
    kU = 0,
    kTime = 4,
    kO = 5,
    kD = 8,
    kN = 11,
    kRadiance = 14,
    kPdfPosition = 17,
    kPdfDirection = 18,
    kRows
  };
  Rows a;
  explicit LightEmissions(uint32_t n) : a(n, kRows) { a.fill(kTime, 0.5f); }
  void run(const LightFunctions& f, const void* light);
};

}  // namespace kinora::testing
