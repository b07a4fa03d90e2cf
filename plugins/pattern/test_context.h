// A shading context made of plain vectors, for the tests of patterns: parameters, built-in variables, primvars and
// textures are set by hand, then one pattern is run at one width. It knows no renderer and no other kind of plug-in.
#pragma once
#include <kinora/pattern.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "plugin/registry.h"
#include "simd/dispatch.h"

namespace kinora::patternTest {

// A value's numbers: `components` arrays of 1 (uniform) or n floats.
using Numbers = std::vector<std::vector<float>>;

class TestContext {
 public:
  TestContext(const std::string& pattern, uint32_t count) {
    Diagnostics quiet([](const std::string&, Severity) {});
    descriptor_ = Registry().find(Kind::Pattern, pattern, quiet, {});
    if (!descriptor_) std::abort();
    c.count = count;
    c.padded = padded(count);
    c.traits = kTraitEyePath | kTraitPrimaryHit;
    for (auto* place : {&c.P, &c.N, &c.Ng, &c.wo})
      for (uint32_t k = 0; k < 3; ++k) (*place)[k] = keep(std::vector<float>(count, k == 2 ? 1.f : 0.f));
    c.radius = keep(std::vector<float>(count, 0.f));
    c.fn = &kFunctions;
    c.host = this;
  }

  void set(const std::string& name, const Numbers& v) { params_[index(name)] = value(v); }
  void set(const std::string& name, float v) {
    const Param& p = descriptor_->params[index(name)];
    const bool three = p.type != Type::Float && p.type != Type::Int;
    set(name, three ? Numbers{{v}, {v}, {v}} : Numbers{{v}});
  }
  // What a pattern feeds, not the scene.
  void connect(const std::string& name, const Numbers& v) {
    set(name, v);
    connected_.insert(index(name));
  }
  // The same of a number, with the gradient of what feeds it.
  void connect(const std::string& name, const Numbers& v, const Numbers& gradient) {
    connect(name, v);
    paramGradients_[index(name)] = value(gradient);
  }
  void setText(const std::string& name, const std::string& text) { texts_[index(name)] = text; }
  void setList(const std::string& name, std::vector<float> list) { lists_[index(name)] = std::move(list); }
  void setManifold(const std::string& name, const Numbers& q, const Numbers& radius) {
    Manifold m;
    m.q = value(q);
    m.radius = value(radius);
    m.dimensions = uint32_t(q.size());
    manifolds_[index(name)] = m;
  }
  // Half diameters of footprints: of a manifold that was set, or ("") of the texture coordinates.
  void setEllipses(const std::string& manifold, const Numbers& first, const Numbers& second) {
    Value* const to = manifold.empty() ? ellipses_ : manifolds_[index(manifold)].axis;
    to[0] = value(first);
    to[1] = value(second);
  }
  void setBuiltin(Builtin b, const Numbers& v) { builtins_[b] = value(v); }
  void setPrimvar(const std::string& name, const Numbers& v, float radius = 0) {
    primvars_[name] = {value(v), value({{radius}})};
  }
  // Of a component of a primvar, "" for texture coordinates; without: along x, along y and 0.
  void setGradient(const std::string& name, uint32_t component, const Numbers& v) {
    gradients_[{name, component}] = value(v);
  }
  void setVectors(const float* (&place)[3], const Numbers& v) {
    for (uint32_t k = 0; k < 3; ++k) place[k] = keep(v[k]);
  }
  std::function<void(int handle, float s, float t, float radius, const TextureOptions&, float rgba[4])> onTexture;
  // What the last lookup was asked with, by axis and point; none: circles.
  std::vector<float> axesAsked[4];
  std::function<float(const ProbeRays&, uint32_t ray)> onProbe;  // its distance
  std::map<std::string, std::vector<float>> matrices;            // "from>to"

  // Runs the pattern; false when this CPU lacks the width.
  bool run(uint32_t width) {
    uint32_t got = 0;
    const auto* f = static_cast<const PatternFunctions*>(functionsFor(*descriptor_, width, &got));
    if (got != width) return false;
    setThreadFloatMode();
    c.width = width;
    names_.clear();
    for (uint32_t i = 0; i < descriptor_->paramCount; ++i)
      if (descriptor_->params[i].flags & kParamOutput) names_.push_back(descriptor_->params[i].name);
    const std::vector<uint8_t> wanted(names_.size(), kWantValue | kWantGradients);
    outputs_.assign(names_.size(), Value());
    manifoldsOut_.assign(names_.size(), Manifold());
    const PatternArgs args{uint32_t(names_.size()), wanted.data(), outputs_.data(), manifoldsOut_.data()};
    f->compute(&c, &args);
    return true;
  }
  const Value& out(const std::string& name) const { return outputs_[outputIndex(name)]; }
  const Manifold& outManifold(const std::string& name) const { return manifoldsOut_[outputIndex(name)]; }
  float at(const std::string& name, uint32_t point = 0, uint32_t component = 0) const {
    const Value& v = out(name);
    return v.data[component][v.stride ? point : 0];
  }
  // Component `k` of an output at all points, padding included.
  std::vector<float> all(const std::string& name, uint32_t k) const {
    std::vector<float> r;
    for (uint32_t i = 0; i < c.padded; ++i) r.push_back(at(name, i, k));
    return r;
  }
  const std::vector<std::string>& outputNames() const { return names_; }

  Context c{};

 private:
  uint32_t index(const std::string& name) const {
    for (uint32_t i = 0; i < descriptor_->paramCount; ++i)
      if (name == descriptor_->params[i].name) return i;
    ADD_FAILURE() << "no parameter " << name;
    return 0;
  }
  size_t outputIndex(const std::string& name) const {
    for (size_t i = 0; i < names_.size(); ++i)
      if (names_[i] == name) return i;
    ADD_FAILURE() << "no output " << name;
    return 0;
  }
  const float* keep(std::vector<float> v) {
    // padding repeats the last point
    if (v.size() > 1 || c.count == 1) v.resize(std::max<size_t>(padded(uint32_t(v.size())), v.size()), v.back());
    kept_.push_back(std::move(v));
    return kept_.back().data();
  }
  Value value(const Numbers& n) {
    Value v;
    v.components = uint32_t(n.size());
    v.stride = n[0].size() > 1;
    for (size_t k = 0; k < n.size(); ++k) v.data[k] = keep(n[k]);
    return v;
  }
  static TestContext& self(const Context* c) { return *static_cast<TestContext*>(c->host); }
  static void* alloc(const Context* c, size_t bytes) {
    // poisoned, so that a lane nobody wrote shows as NaN
    auto& list = self(c).memory_;
    list.emplace_back(static_cast<std::byte*>(std::aligned_alloc(64, (bytes + 127) & ~size_t(63))), &std::free);
    std::memset(list.back().get(), 0xff, (bytes + 127) & ~size_t(63));
    return list.back().get();
  }
  static Value param(const Context* c, uint32_t i) {
    TestContext& t = self(c);
    if (const auto it = t.params_.find(i); it != t.params_.end()) return it->second;
    const Param& p = t.descriptor_->params[i];
    if (p.flags & kParamFile) {  // handle 7 of a named file, -1 of none
      const int32_t handle = t.texts_.count(i) ? 7 : -1;
      float bits;
      std::memcpy(&bits, &handle, sizeof bits);
      return t.value({{bits}});
    }
    const bool three = p.type != Type::Float && p.type != Type::Int;
    return t.value(three ? Numbers{{p.value[0]}, {p.value[1]}, {p.value[2]}} : Numbers{{p.value[0]}});
  }
  static const Manifold* manifold(const Context* c, uint32_t i) {
    const auto it = self(c).manifolds_.find(i);
    return it == self(c).manifolds_.end() ? nullptr : &it->second;
  }
  static const char* text(const Context* c, uint32_t i) {
    const auto it = self(c).texts_.find(i);
    return it == self(c).texts_.end() ? self(c).descriptor_->params[i].text : it->second.c_str();
  }
  static uint32_t list(const Context* c, uint32_t i, const float** numbers) {
    const Param& p = self(c).descriptor_->params[i];
    const auto it = self(c).lists_.find(i);
    *numbers = it == self(c).lists_.end() ? p.list : it->second.data();
    return it == self(c).lists_.end() ? p.listCount : uint32_t(it->second.size());
  }
  static Value builtin(const Context* c, Builtin b) {
    const auto it = self(c).builtins_.find(b);
    if (it == self(c).builtins_.end()) return self(c).value({{0.f}, {0.f}, {0.f}});
    return it->second;
  }
  static Value primvar(const Context* c, const char* name, Value* radius) {
    const auto it = self(c).primvars_.find(name);
    if (it == self(c).primvars_.end()) return Value();
    if (radius) *radius = it->second.second;
    return it->second.first;
  }
  static void texture(const Context* c, const Value* handles, const float* s, const float* t, const float* radius,
                      const float* const axes[4], const TextureOptions* o, float* const rgba[4]) {
    for (int k = 0; k < 4; ++k) {
      self(c).axesAsked[k].clear();
      if (axes) self(c).axesAsked[k].assign(axes[k], axes[k] + c->padded);
    }
    for (uint32_t i = 0; i < c->count; ++i) {
      int h = 0;
      std::memcpy(&h, &handles->data[0][handles->stride ? i : 0], sizeof h);
      float v[4];
      self(c).onTexture(h, s[i], t[i], radius[i], *o, v);
      for (int k = 0; k < 4; ++k) rgba[k][i] = v[k];
    }
  }
  static int matrix(const Context* c, const char* from, const char* to, MatrixValue* out) {
    const auto it = self(c).matrices.find(std::string(from) + ">" + to);
    float* entries = c->alloc<float>(16);
    for (int i = 0; i < 16; ++i) {
      entries[i] = it != self(c).matrices.end() ? it->second[size_t(i)] : i % 5 == 0 ? 1.f : 0.f;
      out->m[i] = entries + i;
    }
    out->stride = 0;
    return it != self(c).matrices.end() || !std::strcmp(from, to);
  }
  static Value gradient(const Context* c, const char* name, uint32_t component) {
    TestContext& t = self(c);
    if (const auto it = t.gradients_.find({name ? name : "", component}); it != t.gradients_.end()) return it->second;
    if (name && !t.primvars_.count(name)) return Value();
    return t.value({{name || component != 0 ? 0.f : 1.f}, {name || component != 1 ? 0.f : 1.f}, {0.f}});
  }
  static int probe(const Context* c, const ProbeRays* rays) {
    if (!self(c).onProbe) return 0;
    for (uint32_t i = 0; i < rays->count; ++i) rays->t[i] = self(c).onProbe(*rays, i);
    return 1;
  }
  static int ellipses(const Context* c, const char* name, Value axes[2]) {
    if (name || !self(c).ellipses_[0].components) return 0;
    axes[0] = self(c).ellipses_[0];
    axes[1] = self(c).ellipses_[1];
    return 1;
  }
  static int isConnected(const Context* c, uint32_t i) { return self(c).connected_.count(i) != 0; }
  static Value paramGradient(const Context* c, uint32_t i, uint32_t) {
    const auto it = self(c).paramGradients_.find(i);
    return it == self(c).paramGradients_.end() ? Value() : it->second;
  }
  static constexpr ContextFunctions kFunctions{&alloc,   &param,    &manifold,    &text,         &list,
                                               &builtin, &primvar,  &texture,     &matrix,       &gradient,
                                               &probe,   &ellipses, &isConnected, &paramGradient};

  const Descriptor* descriptor_ = nullptr;
  std::deque<std::vector<float>> kept_;
  std::deque<std::unique_ptr<std::byte, decltype(&std::free)>> memory_;
  std::map<uint32_t, Value> params_;
  std::set<uint32_t> connected_;
  std::map<uint32_t, Value> paramGradients_;
  std::map<uint32_t, Manifold> manifolds_;
  std::map<uint32_t, std::string> texts_;
  std::map<uint32_t, std::vector<float>> lists_;
  std::map<Builtin, Value> builtins_;
  std::map<std::string, std::pair<Value, Value>> primvars_;
  std::map<std::pair<std::string, uint32_t>, Value> gradients_;
  Value ellipses_[2];
  std::vector<std::string> names_;
  std::vector<Value> outputs_;
  std::vector<Manifold> manifoldsOut_;
};

// n numbers from `low` to `high` in an order that is not sorted.
inline std::vector<float> spread(uint32_t n, float low, float high, uint32_t step = 7) {
  std::vector<float> r(n);
  for (uint32_t i = 0; i < n; ++i) r[i] = low + (high - low) * float((i * step) % n) / float(n > 1 ? n - 1 : 1);
  return r;
}

// All outputs at all points, padding included, have the same bits at every width that this CPU runs.
inline void expectSameBitsAtAllWidths(TestContext& t) {
  ASSERT_TRUE(t.run(1));
  std::vector<std::vector<float>> want;
  for (const std::string& name : t.outputNames())
    for (uint32_t k = 0; k < t.out(name).components; ++k) want.push_back(t.all(name, k));
  for (uint32_t width : {4u, 8u, 16u}) {
    if (!t.run(width)) continue;
    size_t j = 0;
    for (const std::string& name : t.outputNames())
      for (uint32_t k = 0; k < t.out(name).components; ++k, ++j) {
        const std::vector<float> got = t.all(name, k);
        for (size_t i = 0; i < got.size(); ++i)
          ASSERT_EQ(std::memcmp(&got[i], &want[j][i], sizeof(float)), 0)
              << name << "[" << k << "] at point " << i << ", width " << width << ": " << got[i] << " against "
              << want[j][i];
      }
  }
}

}  // namespace kinora::patternTest
