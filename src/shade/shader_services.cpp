#include "shade/shader_services.h"

#include <cmath>
#include <cstring>
#include <string_view>

#include "language/program/program.h"
#include "language/vm/strings.h"
#include "shade/shader_attributes.h"
#include "shade/shader_scene.h"
#include "shade/shader_textures.h"

namespace kinora::shade {

using language::Batch;
using language::Span;

struct ShaderServices::Calls {
  static ShaderServices& of(void* self) { return *static_cast<ShaderServices*>(self); }
  static ShaderTextures& texturesOf(void* self) { return of(self).host_.group->shaderTextures(); }

  // "common" is world space: what shaders compute does not move with the camera.
  static bool matrix(void* self, const Batch& b, const char* from, const char* to, Span out) {
    const Context* c = of(self).context_;
    const ArenaScope memory(of(self).host_.group->arena());
    MatrixValue m{};
    if (!c->fn->matrix(c, from, to, &m)) {
      ShaderScene* scene = of(self).host_.group->world().shaders.get();
      if (scene) scene->tellOfSpace(std::strcmp(from, "world") ? from : to);
      return false;
    }
    const uint32_t n = out.varies ? b.points : 1;
    for (uint32_t k = 0; k < 16; ++k) {
      if (n > 1 && m.uniform()) {  // lanes that take no part may have it too
        std::fill_n(out.cells[k], n, m.m[k][0]);
        continue;
      }
      for (uint32_t i = 0; i < n; ++i)
        if (n == 1 || b.isLive(i)) out.set(k, i, m.m[k][m.uniform() ? 0 : b.first + i]);
    }
    return true;
  }
  static bool spaceToCommon(void* self, const Batch& b, int32_t space, Span out) {
    return matrix(self, b, language::stringOf(space).c_str(), "world", out);
  }
  static bool commonToSpace(void* self, const Batch& b, int32_t space, Span out) {
    return matrix(self, b, "world", language::stringOf(space).c_str(), out);
  }

  static void texture(void* self, const Batch& b, const language::TextureCall& call) {
    texturesOf(self).texture(b, call);
  }
  static void texture3d(void* self, const Batch& b, const language::TextureCall& call) {
    texturesOf(self).volume(b, call);
  }
  static void environment(void* self, const Batch& b, const language::TextureCall& call) {
    texturesOf(self).environment(b, call);
  }
  static void getTextureInfo(void* self, const Batch& b, Span file, Span place, Span name, Span to, Span found) {
    texturesOf(self).info(b, file, place, name, to, found);
  }
  static void getAttribute(void* self, const Batch& b, Span object, Span name, Span index, Span to, Span found) {
    giveAttribute(of(self).context_, of(self).host_, b, object, name, index, to, found);
  }
  static void surfaceArea(void* self, const Batch& b, Span result) {
    giveSurfaceArea(of(self).context_, of(self).host_, b, result);
  }
  static void trace(void* self, const Batch&, Span, Span, const Span*, const Span*, uint32_t, Span) {
    if (ShaderScene* scene = of(self).host_.group->world().shaders.get()) scene->refuseTrace();
  }

  // What a ray is to shaders. Reflections and refractions are those of specular lobes, as lighters use the words.
  static bool isOfType(RayKind kind, uint32_t origin, std::string_view asked) {
    if (kind == RayKind::Transmission) return asked == "shadow" || asked == "transmission";
    if (kind == RayKind::Camera) return asked == "camera";
    if (!(origin & kFromSpecular)) return asked == "diffuse";
    if (asked == (origin & kFromTransmission ? "refraction" : "reflection")) return true;
    return asked == "specular" || asked == (origin & kFromDiscrete ? "singular" : "glossy");
  }
  static void rayType(void* self, const Batch& batch, Span name, Span result) {
    const Context* c = of(self).context_;
    const ContextHost& host = of(self).host_;
    const RayKind kind = c->traits & kTraitPrimaryHit ? RayKind::Camera : host.rayKind;
    const uint32_t* origin = host.origin;
    for (uint32_t i = 0; i < (result.varies ? batch.points : 1); ++i) {
      if (!batch.isLive(i)) continue;
      // paths of shadow rays are numbers of rays, of which there are more than slots
      const uint32_t from = kind == RayKind::Indirect ? origin[batch.first + i] : 0;
      result.set(0, i, int32_t(isOfType(kind, from, language::stringOf(name.integer(0, i)))));
    }
  }
  static void backfacing(void* self, const Batch& batch, Span result) {
    const Context* c = of(self).context_;
    for (uint32_t i = 0; i < (result.varies ? batch.points : 1); ++i)
      if (batch.isLive(i)) result.set(0, i, int32_t(c->entering[batch.first + i] == 0));
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
  if (host.group->world().shaders) table_.dictionary = &host.group->world().shaders->dictionary;
  table_.texture = &Calls::texture;
  table_.texture3d = &Calls::texture3d;
  table_.environment = &Calls::environment;
  table_.getTextureInfo = &Calls::getTextureInfo;
  table_.surfaceArea = &Calls::surfaceArea;
  table_.trace = &Calls::trace;
  table_.getAttribute = &Calls::getAttribute;
  table_.rayType = &Calls::rayType;
  table_.backfacing = &Calls::backfacing;
  table_.message = &Calls::message;
}

}  // namespace kinora::shade
