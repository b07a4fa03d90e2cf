// A bxdf bound to a hand-made context, with output arrays of its own: what the bxdf checks call. Not installed.
#pragma once
#include <kinora/testing/test_context.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "simd/dispatch.h"

namespace kinora::testing {

inline float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 operator*(Vec3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 normalized(Vec3 a) {
  const double l = 1 / std::sqrt(double(a.x) * a.x + double(a.y) * a.y + double(a.z) * a.z);
  return {float(a.x * l), float(a.y * l), float(a.z * l)};
}
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

// The widths of a plug-in that this CPU runs.
inline std::vector<const WidthTable*> runnableTables(const Descriptor& d) {
  std::vector<const WidthTable*> r;
  for (uint32_t i = 0; i < d.tableCount; ++i)
    if (d.tables[i].functions && (d.tables[i].width <= 8 || cpuHasAvx512())) r.push_back(&d.tables[i]);
  return r;
}

// Rows of numbers of n points, padded.
class PointRows {
 protected:
  PointRows(uint32_t n, uint32_t rows) : n_(n), padded_(padded(n)), data_(size_t(padded_) * rows) {}
  float* row(uint32_t r) { return data_.data() + size_t(r) * padded_; }
  // Repeats the last number of the first rows in the padding and makes all others NaN.
  void prepareRows(uint32_t inputs) {
    for (uint32_t k = 0; k < inputs; ++k)
      for (uint32_t i = n_; i < padded_; ++i) row(k)[i] = row(k)[n_ - 1];
    std::fill(data_.begin() + std::ptrdiff_t(inputs) * padded_, data_.end(), std::numeric_limits<float>::quiet_NaN());
  }
  uint32_t n_, padded_;

 private:
  std::vector<float> data_;
};

// Directions of n points, and what evaluate says of them.
class Evaluation : PointRows {
 public:
  explicit Evaluation(uint32_t n) : PointRows(n, 3 + 3 * kMaxSlots + 2) {
    for (int k = 0; k < 3; ++k) args_.wi[k] = row(k);
    for (uint32_t s = 0; s < kMaxSlots; ++s)
      for (int k = 0; k < 3; ++k) args_.weight[s][k] = row(3 + 3 * s + k);
    args_.pdf = row(3 + 3 * kMaxSlots);
    args_.pdfReverse = row(4 + 3 * kMaxSlots);
  }
  uint32_t count() const { return n_; }
  void set(uint32_t i, Vec3 w) {
    row(0)[i] = w.x;
    row(1)[i] = w.y;
    row(2)[i] = w.z;
  }
  Vec3 wi(uint32_t i) const { return {args_.wi[0][i], args_.wi[1][i], args_.wi[2][i]}; }
  // Repeats the last direction in the padding and makes all outputs NaN.
  void prepare() { prepareRows(3); }
  const EvaluateArgs* args() const { return &args_; }
  float weight(uint32_t slot, int k, uint32_t i) const { return args_.weight[slot][k][i]; }
  double total(uint32_t slots, int k, uint32_t i) const {
    double t = 0;
    for (uint32_t s = 0; s < slots; ++s) t += args_.weight[s][k][i];
    return t;
  }
  float pdf(uint32_t i) const { return args_.pdf[i]; }
  float pdfReverse(uint32_t i) const { return args_.pdfReverse[i]; }

 private:
  EvaluateArgs args_{};
};

// Random numbers and samples of n points.
class Generation : PointRows {
 public:
  explicit Generation(uint32_t n) : PointRows(n, 12), words_(size_t(padded_) * 2) {
    for (int k = 0; k < 4; ++k) args_.u[k] = row(k);
    for (int k = 0; k < 3; ++k) args_.wi[k] = row(4 + k);
    for (int k = 0; k < 3; ++k) args_.weight[k] = row(7 + k);
    args_.pdf = row(10);
    args_.pdfReverse = row(11);
    args_.slot = words_.data();
    args_.flags = words_.data() + padded_;
  }
  float* u(int k) { return row(uint32_t(k)); }
  void prepare() {
    prepareRows(4);
    std::fill(words_.begin(), words_.end(), ~0u);
  }
  const GenerateArgs* args() const { return &args_; }
  Vec3 wi(uint32_t i) const { return {args_.wi[0][i], args_.wi[1][i], args_.wi[2][i]}; }
  bool valid(uint32_t i) const { return args_.slot[i] != kNoLobe; }
  bool discrete(uint32_t i) const { return valid(i) && (args_.flags[i] & kSampleDiscrete); }
  uint32_t slot(uint32_t i) const { return args_.slot[i]; }
  uint32_t flags(uint32_t i) const { return args_.flags[i]; }
  float weight(int k, uint32_t i) const { return args_.weight[k][i]; }
  float pdf(uint32_t i) const { return args_.pdf[i]; }
  float pdfReverse(uint32_t i) const { return args_.pdfReverse[i]; }

 private:
  std::vector<uint32_t> words_;
  GenerateArgs args_{};
};

class BoundBxdf {
 public:
  BoundBxdf(const Descriptor& d, const WidthTable& table, const Setting& s, const TestPoints& p,
            TestContextOptions o = {})
      : functions_(static_cast<const BxdfFunctions*>(table.functions)), context_(d, s, p, withWidth(o, table.width)) {
    context_.bind(*functions_);
  }
  const Context& context() const { return context_.context(); }
  const BxdfFunctions& functions() const { return *functions_; }
  uint32_t slots() const { return context().slotCount; }
  void evaluate(Evaluation& e) const {
    e.prepare();
    functions_->evaluate(&context(), context().closure, e.args());
  }
  void evaluateAt(uint32_t point, Evaluation& e) const {
    e.prepare();
    functions_->evaluateAt(&context(), context().closure, point, e.count(), e.args());
  }
  void generate(Generation& g) const {
    g.prepare();
    functions_->generate(&context(), context().closure, g.args());
  }

 private:
  static TestContextOptions withWidth(TestContextOptions o, uint32_t width) {
    o.width = width;
    return o;
  }
  const BxdfFunctions* functions_;
  TestContext context_;
};

}  // namespace kinora::testing
