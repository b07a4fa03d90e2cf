// For the tests beside the light filters: makes one filter from named values, a placement and an image, and asks its
// tables for factors. Statistics over all parameters are the testing kit's.
#pragma once
#include <gtest/gtest.h>
#include <kinora/light_filter.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "plugin/registry.h"

namespace kinora::filterTesting {

using V = std::vector<float>;
using Vec = std::array<double, 3>;
using Numbers = std::map<std::string, V>;
using Texts = std::map<std::string, std::string>;

class TestFilter {
 public:
  TestFilter(const char* name, Numbers numbers, Texts texts = {}, Vec origin = {0, 0, 0}, double scale = 1,
             const HostImage* image = nullptr, const LightFilterInfo* info = nullptr)
      : image_(image) {
    for (const Descriptor* k : stockPlugins())
      if (!std::strcmp(k->name, name)) d_ = k;
    if (!d_) throw std::string("no such light filter: ") + name;
    std::vector<ParamValue> values(d_->paramCount);
    std::vector<const char*> text(d_->paramCount);
    for (uint32_t i = 0; i < d_->paramCount; ++i) {
      const Param& p = d_->params[i];
      const auto n = numbers.find(p.name);
      const auto t = texts.find(p.name);
      text[i] = t == texts.end() ? p.text : t->second.c_str();
      values[i].strings = &text[i];
      values[i].floats = n != numbers.end() ? n->second.data() : p.flags & kParamArray ? p.list : p.value;
      values[i].count = n != numbers.end()      ? uint32_t(n->second.size())
                        : p.flags & kParamArray ? p.listCount
                        : p.type == Type::Color ? 3
                                                : 1;
      values[i].given = n != numbers.end() || t != texts.end();
    }
    Host host{this,
              [](void* self, const char* code, const char* what, const char*) {
                static_cast<TestFilter*>(self)->warnings.push_back(std::string(code) + ": " + what);
              },
              [](void* self, const char*, int) { return static_cast<TestFilter*>(self)->image_; }};
    Placement place{};
    for (int c = 0; c < 3; ++c) {
      place.localToRender[5 * c] = scale;
      place.localToRender[12 + c] = origin[size_t(c)];
    }
    place.localToRender[15] = 1;
    place.isStatic = 1;
    const CreateInfo create{&host, "test", values.data(), d_->paramCount, &place, info};
    ErrorText text_{};
    data_ = d_->create(&create, &text_);
    error = text_.text;
  }
  ~TestFilter() {
    if (data_) d_->destroy(data_);
  }
  TestFilter(const TestFilter&) = delete;

  bool made() const { return data_ != nullptr; }
  // At P, lit from the point `light`; the same at all widths.
  V at(Vec P, Vec light = {0, 0, 0}) const {
    Vec d = {light[0] - P[0], light[1] - P[1], light[2] - P[2]};
    const double distance = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (double& c : d) c = distance > 0 ? c / distance : 0;
    return from(P, d, distance);
  }
  V from(Vec P, Vec wi, double distance) const {
    V first;
    for (uint32_t width : {1u, 4u, 8u, 16u}) {
      alignas(64) float in[8][16] = {}, out[3][16] = {};
      for (int i = 0; i < 16; ++i) {
        for (size_t c = 0; c < 3; ++c) {
          in[c][i] = float(P[c]);
          in[3 + c][i] = float(wi[c]);
        }
        in[6][i] = float(distance);
      }
      const LightFilterArgs a{3,     {in[0], in[1], in[2]},   {in[3], in[4], in[5]}, in[6],
                              in[7], {out[0], out[1], out[2]}};
      static_cast<const LightFilterFunctions*>(functionsFor(*d_, width))->factor(data_, &a);
      const V now{out[0][1], out[1][1], out[2][1]};
      if (first.empty()) first = now;
      EXPECT_EQ(now, first) << "width " << width;
      for (int c = 0; c < 3; ++c) EXPECT_EQ(out[c][0], out[c][2]);
    }
    return first;
  }
  std::vector<std::string> warnings;
  std::string error;

 private:
  const Descriptor* d_ = nullptr;
  void* data_ = nullptr;
  const HostImage* image_;
};

inline void expectNear(const V& a, const V& b, double tolerance, const std::string& where = "") {
  ASSERT_EQ(a.size(), b.size());
  for (size_t c = 0; c < a.size(); ++c) EXPECT_NEAR(a[c], b[c], tolerance) << where << " channel " << c;
}
inline void expectGrey(const V& a, double grey, double tolerance = 1e-5, const std::string& where = "") {
  expectNear(a, V(3, float(grey)), tolerance, where);
}
inline double smooth(double t) {
  t = std::fmin(1, std::fmax(0, t));
  return t * t * (3 - 2 * t);
}

}  // namespace kinora::filterTesting
