#include "language/mock_renderer.h"

#include <cmath>
#include <functional>

#include "language/program/program.h"
#include "language/vm/strings.h"
#include "language/vm/test_runner.h"

namespace kinora::oracle {

using namespace language;

namespace {

std::string textOf(Span s, uint32_t i) { return stringOf(s.integer(0, i)); }
float uOf(void* self, const Batch& b, uint32_t i) {
  return testing::Points::uOf(b.first + i) + static_cast<MockRenderer*>(self)->shiftU;
}
float vOf(void* self, const Batch& b, uint32_t i) {
  return testing::Points::vOf(b.first + i) + static_cast<MockRenderer*>(self)->shiftV;
}
bool is(Span s, Base base) { return s.base == uint8_t(base); }
bool isTripleSpan(Span s) { return isTriple(Base(s.base)) && s.components == 3; }

// For each point that asks.
void each(const Batch& b, bool once, const std::function<void(uint32_t)>& f) {
  for (uint32_t i = 0; i < (once ? 1u : b.points); ++i)
    if (once || b.isLive(i)) f(i);
}

bool toCommon(const std::string& space, float u, float m[16]) {
  for (int k = 0; k < 16; ++k) m[k] = k % 5 == 0;
  if (space == "object")
    m[0] = 2, m[5] = 4, m[10] = 8;
  else if (space == "shader")
    m[12] = 1, m[13] = 2, m[14] = 3;
  else if (space == "camera")
    m[0] = 0, m[1] = 1, m[4] = -1, m[5] = 0;
  else if (space == "moving")
    m[12] = u;
  else
    return false;
  return true;
}
bool fromCommon(const std::string& space, float u, float m[16]) {
  for (int k = 0; k < 16; ++k) m[k] = k % 5 == 0;
  if (space == "object")
    m[0] = .5f, m[5] = .25f, m[10] = .125f;
  else if (space == "shader")
    m[12] = -1, m[13] = -2, m[14] = -3;
  else if (space == "camera")
    m[0] = 0, m[1] = -1, m[4] = 1, m[5] = 0;
  else if (space == "moving")
    m[12] = -u;
  else
    return false;
  return true;
}

template <bool (*kMatrix)(const std::string&, float, float*)>
bool space(void* self, const Batch& b, int32_t name, Span matrix) {
  float m[16];
  if (!kMatrix(stringOf(name), 0, m)) return false;
  each(b, !matrix.varies, [&](uint32_t i) {
    kMatrix(stringOf(name), uOf(self, b, i), m);
    for (uint32_t k = 0; k < 16; ++k) matrix.set(k, i, m[k]);
  });
  return true;
}

void getAttribute(void* self, const Batch& b, Span object, Span name, Span index, Span to, Span found) {
  each(b, !found.varies, [&](uint32_t i) {
    const std::string n = textOf(name, i), o = object.components ? textOf(object, i) : "";
    bool isFound = true;
    const auto put = [&](std::initializer_list<float> values) {
      uint32_t k = 0;
      for (const float f : values) to.set(k++, i, f);
    };
    const bool isOther = o == "other";
    if (index.components && n == "list" && is(to, Base::Float))
      put({10.f * float(index.integer(0, i)) + .5f + (isOther ? 100 : 0)});
    else if (index.components)
      isFound = false;
    else if (isOther && n == "gain" && is(to, Base::Float))
      put({3.5f});
    else if (!o.empty())
      isFound = false;
    else if (n == "flag" && is(to, Base::Int))
      to.set(0, i, int32_t(7));
    else if (n == "gain" && is(to, Base::Float) && to.components == 1)
      put({2.5f});
    else if (n == "tint" && isTripleSpan(to))
      put({.25f, .5f, .75f});
    else if (n == "label" && is(to, Base::String))
      to.set(0, i, internString("mock"));
    else if (n == "where" && is(to, Base::Float))
      put({uOf(self, b, i)});
    else if (n == "pair" && is(to, Base::Float) && to.components == 2)
      put({1, 2});
    else if (n == "frame" && is(to, Base::Matrix))
      put({2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2});
    else
      isFound = false;
    found.set(0, i, int32_t(isFound));
  });
}

float optionsOf(const Span* tokens, const Span* values, uint32_t count, uint32_t i) {
  float sum = 0;
  for (uint32_t k = 0; k < count; ++k) {
    const std::string t = textOf(tokens[k], i);
    const float weight = t == "fill" ? 1000.f : t == "width" ? 2000.f : t == "blur" ? 4000.f : 0.f;
    if (weight != 0)
      sum += weight * (is(values[k], Base::Int) ? float(values[k].integer(0, i)) : values[k].number(0, i));
  }
  return sum;
}
void lookUp(const Batch& b, const TextureCall& t, float perComponent) {
  each(b, !t.result.varies, [&](uint32_t i) {
    const bool isMissing = textOf(t.file, i) == "missing";
    const uint32_t n = t.coordinates.components;
    static constexpr float kWeight[3] = {1, 10, 100};
    for (uint32_t k = 0; k < t.result.components; ++k) {
      float value = perComponent * float(k) + optionsOf(t.tokens, t.values, t.options, i), dx = 0, dy = 0;
      for (uint32_t c = 0; c < n; ++c) {
        value += kWeight[c] * t.coordinates.number(c, i);
        if (c < t.dx.components) dx += kWeight[c] * t.dx.number(c, i);
        if (c < t.dy.components) dy += kWeight[c] * t.dy.number(c, i);
      }
      t.result.set(k, i, isMissing ? -1 : value);
      if (t.resultDx.components) t.resultDx.set(k, i, isMissing ? 0 : dx);
      if (t.resultDy.components) t.resultDy.set(k, i, isMissing ? 0 : dy);
    }
    if (t.alpha.components) t.alpha.set(0, i, textOf(t.file, i) == "ramp" ? t.coordinates.number(0, i) : .5f);
    if (t.alphaDx.components && textOf(t.file, i) == "ramp") {
      t.alphaDx.set(0, i, t.dx.components ? t.dx.number(0, i) : 0.f);
      t.alphaDy.set(0, i, t.dy.components ? t.dy.number(0, i) : 0.f);
    }
    if (t.error.components) t.error.set(0, i, internString(isMissing ? "no file" : ""));
  });
}

void getTextureInfo(void*, const Batch& b, Span file, Span at, Span name, Span to, Span found) {
  each(b, !found.varies, [&](uint32_t i) {
    const std::string n = textOf(name, i);
    const bool isMissing = textOf(file, i) == "missing";
    bool isFound = !isMissing || n == "exists";
    if (n == "exists" && is(to, Base::Int))
      to.set(0, i, int32_t(!isMissing));
    else if (isMissing)
      isFound = false;
    else if (n == "channels" && is(to, Base::Int))
      to.set(0, i, int32_t(at.components ? 4 : 3));
    else if (n == "resolution" && is(to, Base::Int) && to.components == 2)
      to.set(0, i, int32_t(64)), to.set(1, i, int32_t(32));
    else if (n == "type" && is(to, Base::String))
      to.set(0, i, internString("Plain Texture"));
    else if (n == "averagecolor" && isTripleSpan(to))
      to.set(0, i, .1f), to.set(1, i, .2f), to.set(2, i, .3f);
    else if (n == "averagealpha" && is(to, Base::Float))
      to.set(0, i, .5f);
    else
      isFound = false;
    found.set(0, i, int32_t(isFound));
  });
}

}  // namespace

RendererServices MockRenderer::services() {
  RendererServices s;
  s.self = this;
  s.dictionary = &dictionary;
  s.spaceToCommon = &space<toCommon>;
  s.commonToSpace = &space<fromCommon>;
  s.getAttribute = &getAttribute;
  s.texture = [](void*, const Batch& b, const TextureCall& t) { lookUp(b, t, 100); };
  s.texture3d = s.environment = [](void*, const Batch& b, const TextureCall& t) { lookUp(b, t, 1000); };
  s.getTextureInfo = &getTextureInfo;
  s.rayType = [](void*, const Batch& b, Span name, Span result) {
    each(b, !result.varies, [&](uint32_t i) { result.set(0, i, int32_t(textOf(name, i) == "camera")); });
  };
  s.backfacing = [](void* self, const Batch& b, Span result) {
    each(b, !result.varies, [&](uint32_t i) { result.set(0, i, int32_t(vOf(self, b, i) > .5f)); });
  };
  s.surfaceArea = [](void* self, const Batch& b, Span result) {
    each(b, !result.varies, [&](uint32_t i) { result.set(0, i, 2 + uOf(self, b, i)); });
  };
  s.trace = [](void*, const Batch& b, Span position, Span, const Span* tokens, const Span* values, uint32_t options,
               Span result) {
    each(b, !result.varies, [&](uint32_t i) {
      float most = 1;
      for (uint32_t k = 0; k < options; ++k)
        if (textOf(tokens[k], i) == "maxdist") most = values[k].number(0, i);
      result.set(0, i, int32_t(position.number(2, i) < most));
    });
  };
  s.getMessage = [](void*, const Batch& b, Span source, Span name, Span to, Span found) {
    each(b, !found.varies, [&](uint32_t i) {
      const bool isFound = textOf(source, i) == "trace" && textOf(name, i) == "hitdist" && is(to, Base::Float);
      found.set(0, i, int32_t(isFound));
      if (isFound) to.set(0, i, 4.f);
    });
  };
  s.message = [](void* self, MessageKind kind, const char* text, uint32_t length, const char* file) {
    static_cast<MockRenderer*>(self)->messages.push_back({kind, std::string(text, length), file});
  };
  return s;
}

}  // namespace kinora::oracle
