#include "shade/shader_services.h"

#include <cmath>
#include <cstring>
#include <string_view>

#include "language/program/program.h"
#include "language/vm/strings.h"
#include "texture/texture_system.h"

namespace kinora::shade {

using language::Batch;
using language::Span;

namespace {

// Gives back what a call took from the group's arena: shaders call in loops.
class Borrowed {
 public:
  explicit Borrowed(Arena& arena) : arena_(arena), mark_(arena.mark()) {}
  ~Borrowed() { arena_.release(mark_); }

 private:
  Arena& arena_;
  Arena::Mark mark_;
};

}  // namespace

struct ShaderServices::Calls {
  static ShaderServices& of(void* self) { return *static_cast<ShaderServices*>(self); }

  // "common" is world space: what shaders compute does not move with the camera.
  static bool matrix(void* self, const Batch& b, const char* from, const char* to, Span out) {
    const Context* c = of(self).context_;
    const Borrowed memory(of(self).host_.group->arena());
    MatrixValue m{};
    if (!c->fn->matrix(c, from, to, &m)) return false;
    const uint32_t n = out.varies ? b.points : 1;
    for (uint32_t k = 0; k < 16; ++k)
      for (uint32_t i = 0; i < n; ++i) out.set(k, i, m.m[k][m.uniform() ? 0 : b.first + i]);
    return true;
  }
  static bool spaceToCommon(void* self, const Batch& b, int32_t space, Span out) {
    return matrix(self, b, language::stringOf(space).c_str(), "world", out);
  }
  static bool commonToSpace(void* self, const Batch& b, int32_t space, Span out) {
    return matrix(self, b, "world", language::stringOf(space).c_str(), out);
  }

  static int32_t textureOf(ContextHost& h, int32_t name) {
    auto& known = h.group->textureOfString();
    const auto [it, isNew] = known.try_emplace(name, TextureSystem::kNoTexture);
    const std::string& file = language::stringOf(name);
    if (isNew && !file.empty())
      it->second = h.group->world().textures->handle(file, {{}, "a texture call of a shader"});
    return it->second;
  }

  static int wrapOf(std::string_view text, int otherwise) {
    return text == "black" ? 0 : text == "clamp" ? 2 : text == "periodic" ? 3 : otherwise;
  }

  static void texture(void* self, const Batch& batch, const language::TextureCall& call) {
    ShaderServices& s = of(self);
    const Context* c = s.context_;
    const uint32_t n = batch.points, padded = (n + 15) / 16 * 16;
    const Borrowed memory(s.host_.group->arena());
    TextureOptions options;
    options.wrapS = options.wrapT = 0;
    options.filter = 2;
    Span width[2], blur[2];
    for (uint32_t k = 0; k < call.options; ++k) {
      const std::string_view token = language::stringOf(call.tokens[k].integer(0, 0));
      const Span& v = call.values[k];
      const auto text = [&] { return std::string_view(language::stringOf(v.integer(0, 0))); };
      const auto number = [&](uint32_t i) {
        return v.base == uint8_t(language::Base::Int) ? float(v.integer(i, 0)) : v.number(i, 0);
      };
      if (token == "width") width[0] = width[1] = v;
      if (token == "swidth") width[0] = v;
      if (token == "twidth") width[1] = v;
      if (token == "blur") blur[0] = blur[1] = v;
      if (token == "sblur") blur[0] = v;
      if (token == "tblur") blur[1] = v;
      if (token == "wrap" || token == "swrap") options.wrapS = wrapOf(text(), 1);
      if (token == "wrap" || token == "twrap") options.wrapT = wrapOf(text(), 1);
      if (token == "firstchannel") options.firstChannel = int(number(0));
      if (token == "interp" && text() == "closest") options.filter = 0;
      if (token == "missingcolor" && v.components >= 3)
        for (uint32_t j = 0; j < 3; ++j) options.missingColor[j] = number(j);
      if (token == "missingalpha") options.missingAlpha = number(0);
      if (token == "colorspace") options.linearize = text() == "sRGB" ? 1 : 0;
    }
    float* st[3];
    for (float*& x : st) x = c->alloc<float>(padded);
    int32_t* handles = c->alloc<int32_t>(padded);
    if (!call.file.varies) handles[0] = textureOf(s.host_, call.file.integer(0, 0));
    const auto at = [&](const Span& v, uint32_t k, uint32_t i) {
      return v.components <= k                        ? 0.f
             : v.base == uint8_t(language::Base::Int) ? float(v.integer(k, i))
                                                      : v.number(k, i);
    };
    for (uint32_t j = 0; j < padded; ++j) {
      const uint32_t i = j < n ? j : n - 1;
      st[0][j] = call.coordinates.number(0, i);
      st[1][j] = call.coordinates.number(1, i);
      // half the longer step across the picture, as footprints of hits are
      float size = 0;
      for (const Span* d : {&call.dx, &call.dy}) {
        float l2 = 0;
        for (uint32_t k = 0; k < 2; ++k) {
          const float x = at(*d, k, i) * (width[k].components ? at(width[k], 0, i) : 1.f);
          l2 += x * x;
        }
        size = std::fmax(size, 0.5f * std::sqrt(l2));
      }
      st[2][j] = size + 0.5f * std::fmax(at(blur[0], 0, i), at(blur[1], 0, i));
      if (call.file.varies) handles[j] = j < n ? textureOf(s.host_, call.file.integer(0, i)) : handles[n - 1];
    }
    float* rgba[4];
    for (float*& x : rgba) x = c->alloc<float>(padded);
    s.host_.group->world().textures->lookup(handles, call.file.varies, padded, st[0], st[1], st[2], options, rgba);
    for (uint32_t i = 0; i < n; ++i) {
      if (!batch.isLive(i)) continue;
      for (uint32_t k = 0; k < call.result.components; ++k) call.result.set(k, i, rgba[k][i]);
      if (call.alpha.components) call.alpha.set(0, i, rgba[3][i]);
      if (call.error.components)
        call.error.set(
            0, i, language::internString(handles[call.file.varies ? i : 0] < 0 ? "the texture is not there" : ""));
    }
  }

  // Primvars by name; points and directions arrive in world space.
  static void getAttribute(void* self, const Batch& batch, Span object, Span name, Span index, Span to, Span found) {
    ShaderServices& s = of(self);
    const Context* c = s.context_;
    const Borrowed memory(s.host_.group->arena());
    const bool isFloat = to.base != uint8_t(language::Base::Int) && to.base != uint8_t(language::Base::String);
    int32_t last = -1;
    Value value;
    const uint32_t n = found.varies ? batch.points : 1;
    for (uint32_t i = 0; i < n; ++i) {
      if (!batch.isLive(i)) continue;
      const int32_t asked = name.integer(0, i);
      if (asked != last) {
        last = asked;
        value = c->fn->primvar(c, language::stringOf(asked).c_str(), nullptr);
      }
      const bool has = isFloat && value.components > 0 && object.components == 0 && index.components == 0;
      for (uint32_t k = 0; has && k < to.components; ++k)
        to.set(k, i,
               value.components == 1  ? value.data[0][batch.first + i]
               : k < value.components ? value.data[k][batch.first + i]
                                      : 0.f);
      found.set(0, i, int32_t(has));
    }
  }

  static void rayType(void* self, const Batch& batch, Span name, Span result) {
    const Context* c = of(self).context_;
    for (uint32_t i = 0; i < (result.varies ? batch.points : 1); ++i)
      result.set(0, i, int32_t((c->traits & kTraitPrimaryHit) && language::stringOf(name.integer(0, i)) == "camera"));
  }
  static void backfacing(void* self, const Batch& batch, Span result) {
    const Context* c = of(self).context_;
    for (uint32_t i = 0; i < (result.varies ? batch.points : 1); ++i)
      result.set(0, i, int32_t(c->entering[batch.first + i] == 0));
  }
  static void message(void* self, language::MessageKind kind, const char* text, uint32_t length, const char*) {
    Diagnostics* d = of(self).host_.group->world().diagnostics;
    if (!d) return;
    std::string line(text, length);
    while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.pop_back();
    if (kind == language::MessageKind::Error)
      d->error("SHADER-ERROR", {}, line);
    else if (kind == language::MessageKind::Warning)
      d->warning("SHADER-WARNING", {}, line);
    else
      d->info("SHADER-PRINT", {}, line);
  }
};

ShaderServices::ShaderServices(const Context* c, ContextHost& host) : context_(c), host_(host) {
  table_.self = this;
  table_.spaceToCommon = &Calls::spaceToCommon;
  table_.commonToSpace = &Calls::commonToSpace;
  table_.texture = &Calls::texture;
  table_.getAttribute = &Calls::getAttribute;
  table_.rayType = &Calls::rayType;
  table_.backfacing = &Calls::backfacing;
  table_.message = &Calls::message;
}

}  // namespace kinora::shade
