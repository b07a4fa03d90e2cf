#include "shade/shader_textures.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "base/arena.h"
#include "shade/texture_call.h"
#include "volume/volume_system.h"

namespace kinora::shade {

namespace {

constexpr float kHalfTurn = 3.14159265358979f;

}  // namespace

// What a lookup needs of each point: place and footprint in the picture, and the steps of the place for derivatives.
struct ShaderTextures::Places {
  float *s, *t, *radius;
  float* step[4];  // s and t along x, then along y; null without derivatives
  Places(Arena& arena, uint32_t n, bool hasSteps)
      : s(arena.make<float>(n)), t(arena.make<float>(n)), radius(arena.make<float>(n)), step{} {
    for (int k = 0; hasSteps && k < 4; ++k) step[k] = arena.make<float>(n);
  }
};

int32_t ShaderTextures::handleOf(int32_t name) {
  const auto [it, isNew] = handles_.try_emplace(name, TextureSystem::kNoTexture);
  const std::string& file = language::stringOf(name);
  if (isNew && !file.empty()) it->second = system_->handle(file, {{}, "a texture call of a shader"});
  return it->second;
}

void ShaderTextures::lookUp(const Batch& batch, const TextureCall& call, const Places& at) {
  const uint32_t n = batch.points;
  TextureSystem& textures = *system_;
  int32_t* handles = arena_.make<int32_t>(n);
  int32_t name = 0;  // of the empty string, which no texture has
  int32_t handle = TextureSystem::kNoTexture;
  for (uint32_t i = 0; i < n; ++i) {
    if (batch.isLive(i) && call.file.integer(0, i) != name) {
      name = call.file.integer(0, i);
      handle = handleOf(name);
    }
    handles[i] = handle;
  }
  float *rgba[4], *moved[4], *place[2];
  for (float*& x : rgba) x = arena_.make<float>(n);
  for (float*& x : moved) x = arena_.make<float>(n);
  for (float*& x : place) x = arena_.make<float>(n);
  const bool wantsDerivs = at.step[0] && (call.resultDx.components || call.resultDy.components ||
                                          call.alphaDx.components || call.alphaDy.components);
  const uint32_t components = call.result.components;
  const bool isUniform = !hasVaryingOptions(call);
  // alpha is the channel behind those of the result
  const auto alphaChannel = [&](int channels) { return components == 1 && channels >= 3 ? 1 : 3; };
  for (uint32_t first = 0; first < n;) {
    uint32_t end = first + 1;
    if (isUniform) end = n;
    while (end < n && (!batch.isLive(end) || sameOptions(call, first, end))) ++end;
    const TextureCallOptions o(call, first);
    const auto part = [&](float* const from[4], float* to[4]) {
      for (int k = 0; k < 4; ++k) to[k] = from[k] + first;
    };
    float* out[4];
    part(rgba, out);
    textures.lookup(handles + first, true, end - first, at.s + first, at.t + first, at.radius + first, o.plain,
                    o.part, out);
    for (uint32_t i = first; i < end; ++i) {
      if (!batch.isLive(i)) continue;
      const int channels = textures.channels(handles[i]) - std::max(o.plain.firstChannel, 0);
      const bool isThere = channels > 0;
      // files of one channel are grey, unless the call speaks of channels
      const bool byChannel = isThere && (o.hasFill || o.plain.firstChannel > 0);
      for (uint32_t k = 0; k < components; ++k)
        call.result.set(k, i,
                        !byChannel                ? rgba[k][i]
                        : int(k) >= channels      ? o.fill
                        : channels == 2 && k == 1 ? rgba[3][i]
                                                  : rgba[k][i]);
      if (call.alpha.components) call.alpha.set(0, i, rgba[alphaChannel(channels)][i]);
      if (call.error.components) {
        static const int32_t kNotThere = language::internString("the texture is not there");
        static const int32_t kNoChannel = language::internString("the texture has no such channel");
        call.error.set(0, i, handles[i] < 0 ? kNotThere : isThere ? 0 : kNoChannel);
      }
    }
    for (uint32_t axis = 0; wantsDerivs && axis < 2; ++axis) {
      const Span &to = axis ? call.resultDy : call.resultDx, &alpha = axis ? call.alphaDy : call.alphaDx;
      if (!to.components && !alpha.components) continue;
      for (uint32_t i = first; i < end; ++i) {
        place[0][i] = at.s[i] + at.step[2 * axis][i];
        place[1][i] = at.t[i] + at.step[2 * axis + 1][i];
      }
      part(moved, out);
      textures.lookup(handles + first, true, end - first, place[0] + first, place[1] + first, at.radius + first,
                      o.plain, o.part, out);
      for (uint32_t i = first; i < end; ++i) {
        if (!batch.isLive(i)) continue;
        for (uint32_t k = 0; k < to.components; ++k) to.set(k, i, moved[k][i] - rgba[k][i]);
        if (!alpha.components) continue;
        const int k = alphaChannel(textures.channels(handles[i]) - std::max(o.plain.firstChannel, 0));
        alpha.set(0, i, moved[k][i] - rgba[k][i]);
      }
    }
    first = end;
  }
}

void ShaderTextures::texture(const Batch& all, const TextureCall& call) {
  const Batch batch = pointsOf(all, call);
  const uint32_t n = batch.points;
  const ArenaScope memory(arena_);
  const bool hasSteps = call.dx.components >= 2 && call.dy.components >= 2;
  const Places at(arena_, n, hasSteps);
  const bool isUniform = [&] {
    for (uint32_t k = 0; k < call.options; ++k)
      if (call.tokens[k].varies) return false;
    return true;
  }();
  TextureCallOptions o(call, 0);
  for (uint32_t i = 0; i < n; ++i) {
    if (!isUniform) o = TextureCallOptions(call, i);
    at.s[i] = call.coordinates.number(0, i);
    at.t[i] = call.coordinates.number(1, i);
    // half the longer step across the picture, as footprints of hits are
    float size = 0;
    const Span* const steps[2] = {&call.dx, &call.dy};
    for (int axis = 0; axis < 2; ++axis) {
      float l2 = 0;
      for (uint32_t k = 0; k < 2; ++k) {
        const float d = numberAt(*steps[axis], k, i);
        if (hasSteps) at.step[2 * axis + int(k)][i] = d;
        const float x = d * (o.width[k].components ? numberAt(o.width[k], 0, i) : 1.f);
        l2 += x * x;
      }
      size = std::fmax(size, 0.5f * std::sqrt(l2));
    }
    at.radius[i] = size + 0.5f * std::fmax(numberAt(o.blur[0], 0, i), numberAt(o.blur[1], 0, i));
  }
  lookUp(batch, call, at);
}

void ShaderTextures::environment(const Batch& all, const TextureCall& call) {
  const Batch batch = pointsOf(all, call);
  const uint32_t n = batch.points;
  const ArenaScope memory(arena_);
  const auto place = [](float x, float y, float z, float& s, float& t) {
    const float across = std::sqrt(x * x + z * z);
    s = across > 0 ? std::atan2(-x, z) / (2 * kHalfTurn) + 0.5f : 0.5f;
    t = 0.5f - std::atan2(y, across) / kHalfTurn;
  };
  const bool hasSteps = call.dx.components >= 3 && call.dy.components >= 3;
  const Places at(arena_, n, hasSteps);
  const TextureCallOptions o(call, 0);
  for (uint32_t i = 0; i < n; ++i) {
    float r[3], l2 = 0, size = 0;
    for (uint32_t k = 0; k < 3; ++k) r[k] = numberAt(call.coordinates, k, i), l2 += r[k] * r[k];
    place(r[0], r[1], r[2], at.s[i], at.t[i]);
    const Span* const steps[2] = {&call.dx, &call.dy};
    for (int axis = 0; axis < 2; ++axis) {
      float d[3], d2 = 0;
      for (uint32_t k = 0; k < 3; ++k) d[k] = numberAt(*steps[axis], k, i), d2 += d[k] * d[k];
      const uint32_t side = uint32_t(axis);
      const float width = o.width[side].components ? numberAt(o.width[side], 0, i) : 1.f;
      if (l2 > 0) size = std::fmax(size, 0.5f * width * std::sqrt(d2 / l2) / kHalfTurn);
      if (!hasSteps) continue;
      float s, t;
      place(r[0] + d[0], r[1] + d[1], r[2] + d[2], s, t);
      s -= at.s[i];
      at.step[2 * axis][i] = s - std::round(s);  // over the seam
      at.step[2 * axis + 1][i] = t - at.t[i];
    }
    at.radius[i] = size + 0.5f * std::fmax(numberAt(o.blur[0], 0, i), numberAt(o.blur[1], 0, i));
  }
  // around the horizon the picture goes on, at the poles it ends
  static const int32_t kS = language::internString("swrap"), kT = language::internString("twrap"),
                       kPeriodic = language::internString("periodic"), kClamp = language::internString("clamp");
  float bits[4];
  const int32_t texts[4] = {kS, kT, kPeriodic, kClamp};
  std::memcpy(bits, texts, sizeof bits);
  float* cells[4] = {&bits[0], &bits[1], &bits[2], &bits[3]};
  Span tokens[34], values[34];
  TextureCall wrapped = call;
  wrapped.options = std::min(call.options, 32u);
  std::copy_n(call.tokens, wrapped.options, tokens);
  std::copy_n(call.values, wrapped.options, values);
  for (int k = 0; k < 2; ++k) {
    tokens[wrapped.options] = Span{cells + k, 1, uint8_t(language::Base::String), false};
    values[wrapped.options++] = Span{cells + 2 + k, 1, uint8_t(language::Base::String), false};
  }
  wrapped.tokens = tokens;
  wrapped.values = values;
  lookUp(batch, wrapped, at);
}

const ShaderTextures::File& ShaderTextures::fileOf(int32_t name) {
  const auto [it, isNew] = files_.try_emplace(name);
  if (isNew) {
    const std::string& file = language::stringOf(name);
    it->second.isVolume = volumes_ && !volumes_->find(file).empty();
    if (!it->second.isVolume) it->second.path = system_->find(file, 0.f, 0.5f);
  }
  return it->second;
}

void ShaderTextures::info(const Batch& batch, Span file, Span coordinates, Span name, Span to, Span found) {
  TextureSystem& textures = *system_;
  const bool hasPlace = coordinates.components >= 2;  // of an atlas
  for (uint32_t i = 0; i < (found.varies ? batch.points : 1); ++i) {
    if (!batch.isLive(i)) continue;
    const int32_t handle = file.integer(0, i);
    const File& known = fileOf(handle);
    const std::string path =
        hasPlace && !known.isVolume
            ? textures.find(language::stringOf(handle), coordinates.number(0, i), coordinates.number(1, i))
            : known.path;
    const std::string& what = language::stringOf(name.integer(0, i));
    bool has = false;
    if (known.isVolume) {
      int32_t v[3];
      const uint32_t count = volumeFact(handle, what, v);
      has = count == to.components && language::giveValue({nullptr, v, nullptr, count}, to, i);
    } else if (what == "exists") {
      has = to.base == uint8_t(language::Base::Int) && to.components == 1;
      if (has) to.set(0, i, int32_t(!path.empty()));
    } else if (!path.empty()) {
      const int count = int(to.components);
      if (to.base == uint8_t(language::Base::String)) {
        std::string text;
        has = count == 1 && textures.fact(path, what, 1, nullptr, nullptr, &text);
        if (has) to.set(0, i, language::internString(text));
      } else if (to.base == uint8_t(language::Base::Int)) {
        int v[16];
        has = count <= 16 && textures.fact(path, what, count, v, nullptr, nullptr);
        for (int k = 0; has && k < count; ++k) to.set(uint32_t(k), i, int32_t(v[k]));
      } else {
        float v[16];
        has = count <= 16 && textures.fact(path, what, count, nullptr, v, nullptr);
        for (int k = 0; has && k < count; ++k) to.set(uint32_t(k), i, v[k]);
      }
    }
    found.set(0, i, int32_t(has));
  }
}

}  // namespace kinora::shade
