// The world of `kinora shader run`, as CLI.md describes it: a flat patch with spaces, a camera and a few primvars.
// Values and derivatives that nothing here names are zeros. Also what a ray finds (trace): nothing is there, the
// answer is one that tests can predict, u / dot(P, R) > 0.5.
#include <ImathMatrix.h>

#include <cmath>
#include <cstring>

#include "app/shader_run.h"
#include "base/arena.h"
#include "base/diagnostics.h"
#include "language/library/dictionary.h"
#include "language/vm/strings.h"
#include "shade/shader_textures.h"
#include "texture/texture_system.h"
#include "volume/volume_system.h"

namespace kinora::app {

using language::Base;
using language::Batch;
using language::Span;
using language::Type;
using language::Values;
using G = language::GlobalValues;

namespace {

using Matrix = Imath::M44f;

// Row vectors. A rotation about z after which the origin moves.
Matrix placed(float cosine, float sine, float x, float y) {
  return Matrix(cosine, sine, 0, 0, -sine, cosine, 0, 0, 0, 0, 1, 0, x, y, 0, 1);
}

Values floatsOf(std::initializer_list<float> list) { return {{}, list, {}}; }
Values intsOf(std::initializer_list<int32_t> list) { return {list, {}, {}}; }

language::GivenValue givenOf(const Type& type, const Values& v) {
  if (type.base == Base::String) return {nullptr, nullptr, v.strings.data(), v.strings.size()};
  if (type.base == Base::Int) return {nullptr, v.ints.data(), nullptr, v.ints.size()};
  return {v.floats.data(), nullptr, nullptr, v.floats.size()};
}

}  // namespace

struct ShadeWorld::Impl {
  struct Attribute {
    Type type;
    Values values;
  };
  ShadeGrid grid;
  std::vector<NamedValue> userData;
  std::map<int32_t, std::pair<Matrix, Matrix>> spaces;  // by name: to common and back
  std::map<std::string, Attribute> attributes;
  std::string rayType;
  mutable Diagnostics diagnostics;
  // files are named from the working directory
  mutable TextureSystem textures{diagnostics};
  mutable VolumeSystem volumes{diagnostics, volume::thisProgram()};

  void addSpace(const char* name, const Matrix& toCommon) {
    spaces[language::internString(name)] = {toCommon, toCommon.inverse()};
  }
  void addFromCommon(const char* name, const Matrix& fromCommon) {
    Imath::M44d exact(fromCommon);
    spaces[language::internString(name)] = {Matrix(exact.inverse()), fromCommon};
  }
  explicit Impl(const RunJob& job) : grid(job.grid), rayType(job.rayType) {
    // the rotations of single precision: cos(pi/2) is what is left of pi/2 when it is rounded
    addSpace("shader", placed(0.707106769f, 0.707106769f, 1, 0));
    addSpace("object", placed(-4.37113883e-08f, 1, 0, 1));
    Matrix scaled;
    scaled[1][1] = 2;
    addSpace("myspace", scaled);
    const float hither = 0.1f, yon = 1000.f, depth = float(double(yon) - double(hither));
    const Matrix screen(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, yon / depth, 1, 0, 0, -yon * hither / depth, 0);  // fov 90
    const Matrix ndc = screen * Matrix(0.5f, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 1, 0, 0.5f, 0.5f, 0, 1);
    Matrix raster;
    raster[0][0] = float(grid.width);
    raster[1][1] = float(grid.height);
    addSpace("camera", Matrix());
    addFromCommon("screen", screen);
    addFromCommon("NDC", ndc);
    addFromCommon("raster", ndc * raster);
    const auto floats = [&](const char* name, std::initializer_list<float> list) {
      attributes[name] = {{Base::Float, list.size() > 1 ? int32_t(list.size()) : 0, -1}, floatsOf(list)};
    };
    attributes["camera:resolution"] = {{Base::Int, 2, -1}, intsOf({int32_t(grid.width), int32_t(grid.height)})};
    attributes["camera:projection"] = {{Base::String, 0, -1}, {{}, {}, {"perspective"}}};
    floats("camera:pixelaspect", {1});
    floats("camera:screen_window", {-1, -1, 1, 1});
    floats("camera:fov", {90});
    floats("camera:clip", {hither, yon});
    floats("camera:clip_near", {hither});
    floats("camera:clip_far", {yon});
    floats("camera:shutter", {0, 1});
    floats("camera:shutter_open", {0});
    floats("camera:shutter_close", {1});
  }
};

ShadeWorld::ShadeWorld(const RunJob& job, std::vector<NamedValue> userData) : impl_(std::make_unique<Impl>(job)) {
  impl_->userData = std::move(userData);
}
ShadeWorld::~ShadeWorld() = default;

bool ShadeWorld::hasPrimvar(const std::string& name, const Type& type) const {
  if (type == Type{Base::Float, 0, -1} &&
      (name == "s" || name == "t" || name == "red" || name == "green" || name == "blue"))
    return true;
  if (name == "face_idx" && type == Type{Base::Int, 0, -1}) return true;
  for (const NamedValue& v : impl_->userData) {
    const bool isAlike =
        v.type.base == type.base || (language::isTriple(v.type.base) && language::isTriple(type.base));
    if (v.name == name && isAlike && v.type.arrayLength == type.arrayLength) return true;
  }
  return false;
}

struct ShadeWorld::Slice::Impl {
  using Attribute = ShadeWorld::Impl::Attribute;
  const ShadeWorld::Impl& world;
  uint64_t first = 0;
  uint32_t count = 0, most, padded = 0;
  language::GlobalValues globals;
  language::RendererServices services;
  Arena arena;
  shade::ShaderTextures textures;
  enum Array { U, V, UX, UY, VX, VY, One, PX, PY = PX + 3, Arrays = PY + 3 };
  std::vector<float> memory;
  float* array(int k) { return memory.data() + size_t(k) * ((most + 15) / 16 * 16 + 16); }
  // of varying inputs
  std::vector<std::vector<float>> inputMemory;
  std::vector<std::vector<const float*>> inputCells;
  std::vector<language::VaryingInput> varying;

  Impl(const ShadeWorld::Impl& w, language::Dictionary& dictionary, uint32_t mostPoints)
      : world(w), most(mostPoints), textures(&w.textures, &w.volumes, arena) {
    memory.assign(size_t(Arrays) * ((most + 15) / 16 * 16 + 16), 0.f);
    services.self = this;
    services.dictionary = &dictionary;
    services.spaceToCommon = [](void* self, const Batch& b, int32_t space, Span out) {
      return of(self).matrix(b, space, true, out);
    };
    services.commonToSpace = [](void* self, const Batch& b, int32_t space, Span out) {
      return of(self).matrix(b, space, false, out);
    };
    services.getAttribute = [](void* self, const Batch& b, Span object, Span name, Span index, Span to, Span found) {
      of(self).attribute(b, object, name, index, to, found);
    };
    services.texture = [](void* self, const Batch& b, const language::TextureCall& call) {
      of(self).textures.texture(b, call);
    };
    services.texture3d = [](void* self, const Batch& b, const language::TextureCall& call) {
      of(self).textures.volume(b, call);
    };
    services.environment = [](void* self, const Batch& b, const language::TextureCall& call) {
      of(self).textures.environment(b, call);
    };
    services.getTextureInfo = [](void* self, const Batch& b, Span file, Span place, Span name, Span to, Span found) {
      of(self).textures.info(b, file, place, name, to, found);
    };
    services.rayType = [](void* self, const Batch& b, Span name, Span result) {
      for (uint32_t i = 0; i < (result.varies ? b.points : 1); ++i)
        if (!result.varies || b.isLive(i))
          result.set(0, i, int32_t(language::stringOf(name.integer(0, i)) == of(self).world.rayType));
    };
    services.surfaceArea = [](void*, const Batch& b, Span result) {
      for (uint32_t i = 0; i < (result.varies ? b.points : 1); ++i)
        if (!result.varies || b.isLive(i)) result.set(0, i, 1.f);
    };
    services.trace = [](void* self, const Batch& b, Span position, Span direction, const Span*, const Span*, uint32_t,
                        Span result) {
      for (uint32_t i = 0; i < (result.varies ? b.points : 1); ++i) {
        if (result.varies && !b.isLive(i)) continue;
        float dot = 0;
        for (uint32_t k = 0; k < 3; ++k) dot += position.number(k, i) * direction.number(k, i);
        result.set(0, i, int32_t(of(self).array(U)[b.first + i] / dot > 0.5f));
      }
    };
    services.getMessage = [](void* self, const Batch& b, Span source, Span name, Span to, Span found) {
      of(self).message(b, source, name, to, found);
    };
  }
  static Impl& of(void* self) { return *static_cast<Impl*>(self); }

  bool matrix(const Batch& b, int32_t space, bool toCommon, Span out) const {
    const auto known = world.spaces.find(space);
    if (known == world.spaces.end()) return false;
    const Matrix& m = toCommon ? known->second.first : known->second.second;
    const uint32_t n = out.varies ? b.points : 1;
    for (uint32_t k = 0; k < 16; ++k)
      for (uint32_t i = 0; i < n; ++i) out.set(k, i, m[int(k / 4)][int(k % 4)]);
    return true;
  }

  // A primvar at a point: false where it is not there. d: along x and y.
  bool primvar(const std::string& name, uint32_t i, Attribute& out, float (*d)[2]) {
    const auto number = [&](float value, float dx, float dy) {
      out = {{Base::Float, 0, -1}, floatsOf({value})};
      if (d) d[0][0] = dx, d[0][1] = dy;
      return true;
    };
    const float u = array(U)[i], v = array(V)[i], x = u, y = v;
    if (name == "s" || (name == "red" && x > 0.5f)) return number(u, array(UX)[i], array(UY)[i]);
    if (name == "t" || (name == "green" && x < 0.5f)) return number(v, array(VX)[i], array(VY)[i]);
    if (name == "blue" && int32_t(y * 12) % 2 == 0) return number(1.f - u, -array(UX)[i], -array(UY)[i]);
    if (name == "face_idx") {
      out = {{Base::Int, 0, -1}, intsOf({int32_t(4 * u)})};
      return true;
    }
    for (const NamedValue& value : world.userData)
      if (value.name == name) {
        out = {value.type, value.values};
        return true;
      }
    return false;
  }

  void attribute(const Batch& b, Span object, Span name, Span index, Span to, Span found) {
    const uint32_t n = found.varies || to.varies ? b.points : 1;
    for (uint32_t i = 0; i < n; ++i) {
      if (n > 1 && !b.isLive(i)) continue;
      const std::string& asked = language::stringOf(name.integer(0, i));
      const std::string owner = object.components ? language::stringOf(object.integer(0, i)) : std::string();
      Attribute answer;
      bool isThere = false;
      if (const auto known = world.attributes.find(asked); known != world.attributes.end()) {
        answer = known->second;
        isThere = true;
        if (index.components) {  // an element of an array
          const int32_t at = index.integer(0, i);
          const size_t elements = std::max(answer.values.ints.size(), answer.values.floats.size());
          isThere = at >= 0 && size_t(at) < elements && answer.type.arrayLength > 0;
          if (isThere && answer.type.base == Base::Int) answer.values.ints = {answer.values.ints[size_t(at)]};
          if (isThere && answer.type.base == Base::Float) answer.values.floats = {answer.values.floats[size_t(at)]};
        }
      } else if (owner == "options" && asked == "blahblah") {
        answer = {{Base::Float, 0, -1}, floatsOf({3.14159f})};
        isThere = true;
      } else if (owner.empty() && asked == "shading:index") {
        answer = {{Base::Int, 0, -1}, intsOf({int32_t(first + b.first + i)})};
        isThere = true;
      } else if (owner.empty() && !index.components) {
        isThere = primvar(asked, b.first + i, answer, nullptr);
      }
      found.set(0, i, int32_t(isThere && language::giveValue(givenOf(answer.type, answer.values), to, i)));
    }
  }

  // What trace() left.
  void message(const Batch& b, Span source, Span name, Span to, Span found) {
    const uint32_t n = found.varies || to.varies ? b.points : 1;
    for (uint32_t i = 0; i < n; ++i) {
      if ((n > 1 && !b.isLive(i)) || language::stringOf(source.integer(0, i)) != "trace") continue;
      const std::string& asked = language::stringOf(name.integer(0, i));
      const float u = array(U)[b.first + i], v = array(V)[b.first + i];
      const bool isHit = u > 0.5f;
      if (asked == "hit" && Base(to.base) == Base::Int) to.set(0, i, int32_t(isHit));
      if (isHit && asked == "hitdist" && Base(to.base) == Base::Float && to.components == 1) to.set(0, i, 0.5f);
      if (isHit && asked == "geom:name" && Base(to.base) == Base::String)
        to.set(0, i, language::internString("teapot"));
      if (isHit && asked == "N" && Base(to.base) == Base::Normal && to.components == 3) {
        to.set(0, i, float(1.0 - double(v)));
        to.set(1, i, 0.25f);
        to.set(2, i, float(1.0 - double(u)));
      }
      found.set(0, i, int32_t(isHit));
    }
  }

  void fill(uint64_t from, uint32_t points) {
    const ShadeGrid& g = world.grid;
    first = from;
    count = points;
    padded = (points + 15) / 16 * 16;
    const float w = float(g.width), h = float(g.height);
    const float stepU = g.scale[0] / float(std::max(1u, g.width - 1)),
                stepV = g.scale[1] / float(std::max(1u, g.height - 1));
    for (uint32_t i = 0; i < padded; ++i) {
      const uint64_t at = from + std::min(i, points - 1);
      const float x = float(at % g.width), y = float(at / g.width);
      float &u = array(U)[i], &v = array(V)[i];
      if (g.isCentered) {
        u = g.scale[0] * (x + 0.5f) / w + g.offset[0];
        v = g.scale[1] * (y + 0.5f) / h + g.offset[1];
      } else {
        u = g.scale[0] * (g.width == 1 ? 0.5f : x / (w - 1)) + g.offset[0];
        v = g.scale[1] * (g.height == 1 ? 0.5f : y / (h - 1)) + g.offset[1];
      }
      array(UX)[i] = g.varyU ? 1.f - u : g.isCentered ? g.scale[0] / w : stepU;
      array(UY)[i] = g.varyU ? u : 0.f;
      array(VX)[i] = g.varyV ? 1.f - v : 0.f;
      array(VY)[i] = g.varyV ? v : g.isCentered ? g.scale[1] / h : stepV;
      array(PX)[i] = g.varyP ? 1.f - u : stepU;
      array(PX + 1)[i] = g.varyP ? 1.f - v : 0.f;
      array(PX + 2)[i] = g.varyP ? u * 0.5f : 0.f;
      array(PY)[i] = g.varyP ? 1.f - v : 0.f;
      array(PY + 1)[i] = g.varyP ? 1.f - u : stepV;
      array(PY + 2)[i] = g.varyP ? v * 0.5f : 0.f;
      array(One)[i] = 1.f;
    }
    globals = {};
    globals.of[G::u] = {{array(U)}, {array(UX)}, {array(UY)}};
    globals.of[G::v] = {{array(V)}, {array(VX)}, {array(VY)}};
    globals.of[G::P] = {{array(U), array(V), array(One)},
                        {array(PX), array(PX + 1), array(PX + 2)},
                        {array(PY), array(PY + 1), array(PY + 2)}};
    globals.of[G::N].v[2] = globals.of[G::Ng].v[2] = array(One);
    globals.of[G::dPdu].v[0] = globals.of[G::dPdv].v[1] = array(One);
  }
};

ShadeWorld::Slice::Slice(const ShadeWorld& world, language::Dictionary& dictionary, uint32_t most)
    : impl_(std::make_unique<Impl>(*world.impl_, dictionary, most)) {}
ShadeWorld::Slice::~Slice() = default;
void ShadeWorld::Slice::fill(uint64_t first, uint32_t count) { impl_->fill(first, count); }
const language::GlobalValues& ShadeWorld::Slice::globals() const { return impl_->globals; }
const language::RendererServices& ShadeWorld::Slice::services() const { return impl_->services; }

const language::VaryingInput* ShadeWorld::Slice::inputs(const language::Executable& code,
                                                        const language::ShaderGroup& group) {
  Impl& s = *impl_;
  s.varying.clear();
  size_t number = 0;
  const size_t room = (s.most + 15) / 16 * 16 + 16;
  for (const language::Input& input : code.inputs()) {
    if (!input.isVarying) continue;
    if (number == s.inputMemory.size()) s.inputMemory.emplace_back(), s.inputCells.emplace_back();
    const uint32_t components =
        uint32_t(language::componentsOf(input.type.base)) * uint32_t(std::max(1, input.type.arrayLength));
    std::vector<float>& memory = s.inputMemory[number];
    memory.assign(3 * components * room, 0.f);
    std::vector<const float*>& cells = s.inputCells[number++];
    cells.clear();
    for (uint32_t k = 0; k < 3 * components; ++k) cells.push_back(memory.data() + k * room);
    if (input.parameter.ends_with('?')) {  // whether it is there
      const std::string name = input.parameter.substr(0, input.parameter.size() - 1);
      for (uint32_t i = 0; i < s.padded; ++i) {
        Impl::Attribute found;
        const int32_t isThere = s.primvar(name, i, found, nullptr);
        std::memcpy(&memory[i], &isThere, 4);
      }
      continue;
    }
    // what holds where the primvar is not
    const language::Layer& layer = group.layers[size_t(input.layer)];
    const language::SymbolId id = layer.shader->find(input.parameter);
    Values otherwise = layer.shader->symbols[size_t(id)].values;
    for (const language::Setting& setting : layer.settings)
      if (setting.parameter == input.parameter) otherwise = setting.values;
    std::vector<float*> to(components);
    for (uint32_t k = 0; k < components; ++k) to[k] = memory.data() + k * room;
    Span span;
    span.cells = to.data();
    span.components = components;
    span.base = uint8_t(input.type.base);
    span.varies = true;
    for (uint32_t i = 0; i < s.padded; ++i) {
      Impl::Attribute found;
      float d[1][2] = {{0, 0}};
      if (s.primvar(input.parameter, i, found, d) &&
          language::giveValue(givenOf(found.type, found.values), span, i)) {
        memory[components * room + i] = d[0][0];
        memory[2 * components * room + i] = d[0][1];
      } else {
        language::giveValue(givenOf(input.type, otherwise), span, i);
      }
    }
  }
  number = 0;
  for (const language::Input& input : code.inputs()) {
    if (!input.isVarying) continue;
    const size_t components =
        size_t(language::componentsOf(input.type.base)) * size_t(std::max(1, input.type.arrayLength));
    const float* const* cells = s.inputCells[number++].data();
    s.varying.push_back({cells, cells + components, cells + 2 * components});
  }
  return s.varying.data();
}

}  // namespace kinora::app
