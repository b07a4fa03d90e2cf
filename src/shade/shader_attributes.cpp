#include "shade/shader_attributes.h"

#include <array>
#include <cmath>
#include <string_view>

#include "language/program/program.h"
#include "language/vm/strings.h"
#include "shade/implied_primvars.h"
#include "shade/shader_scene.h"

namespace kinora::shade {

using language::Batch;
using language::Span;

namespace {

bool giveNumbers(const float* v, uint32_t n, const Span& to, uint32_t i) {
  return language::giveValue({v, nullptr, nullptr, n}, to, i);
}

// What is asked for of `size` values, `per` an element: all, or with an index one element. Of a colour or the like that
// is no array a number takes a component.
struct Part {
  size_t first = 0, count = 0;  // of none where the index is beyond the end
};
Part partOf(size_t size, size_t per, int32_t index, const Span& to) {
  if (index < 0) return {0, size};
  if (size == per && to.components == 1) per = 1;
  const size_t first = size_t(index) * per;
  return {first, first + per <= size ? per : 0};
}
size_t elementSize(scene::ValueType type) {
  return scene::isFloatBased(type) ? size_t(scene::componentsOf(type)) : 1;
}

bool giveParameter(const scene::Parameter& p, int32_t index, const Span& to, uint32_t i) {
  const auto [first, n] = partOf(p.size(), elementSize(p.type), index, to);
  if (n == 0) return false;
  language::GivenValue value;
  value.count = n;
  if (!p.strings.empty())
    value.strings = p.strings.data() + first;
  else if (!p.ints.empty())
    value.ints = p.ints.data() + first;
  else
    value.floats = p.floats.data() + first;
  return language::giveValue(value, to, i);
}

// The values of primvars that shaders ask for by name, all points of the context at once.
class AskedPrimvars {
 public:
  explicit AskedPrimvars(const Context* c) : c_(c) {}
  const Value& of(int32_t name) { return kept(name, kNarrow); }
  // Component j of primvars that have more than three, as it is stored.
  float wide(int32_t name, uint32_t j, uint32_t point) { return kept(name, j / 3).data[j % 3][point]; }

 private:
  static constexpr uint32_t kKept = 8, kNarrow = ~0u;
  const Value& kept(int32_t name, uint32_t triple) {
    for (uint32_t k = 0; k < std::min(count_, kKept); ++k)
      if (names_[k] == name && triples_[k] == triple) return values_[k];
    const uint32_t k = count_++ % kKept;
    names_[k] = name;
    triples_[k] = triple;
    const char* text = language::stringOf(name).c_str();
    if (triple == kNarrow) return values_[k] = c_->fn->primvar(c_, text, nullptr);
    const Slopes s = ContextHost::of(c_).surface.slopes(
        {SlopeSource::What::Primvar, primvarsOf(c_, text), Implied::None, 3 * triple}, 3);
    return values_[k] = {{s.value[0], s.value[1], s.value[2]}, 1, 3};
  }

  const Context* c_;
  uint32_t count_ = 0;
  int32_t names_[kKept];
  uint32_t triples_[kKept];
  Value values_[kKept];
};

// All of a primvar, or one element; what lies in space in the world's.
bool givePrimvar(const Context* c, ContextHost& h, const geometry::Primvar& p, AskedPrimvars& asked, int32_t name,
                 int32_t index, uint32_t point, const Span& to, uint32_t i) {
  using Rate = geometry::Primvar::Rate;
  constexpr uint32_t kMost = 16;
  if (p.width < 1 || uint32_t(p.width) > kMost) return false;
  const uint32_t width = uint32_t(p.width);
  const auto [first, n] = partOf(width, elementSize(p.type), index, to);
  if (n == 0) return false;
  if (!p.strings.empty()) {
    size_t at = first;
    if (p.rate == Rate::PerFace)
      at += size_t(width) * h.group->world().world->mesh(c->place.geometry[point]).faceOf(c->place.primitive[point]);
    return at + n <= p.strings.size() && language::giveValue({nullptr, nullptr, p.strings.data() + at, n}, to, i);
  }
  if (p.data.empty()) return false;
  float v[kMost];
  if (width <= 3) {
    const Value& value = asked.of(name);  // in render space
    if (value.components < width) return false;
    for (uint32_t j = 0; j < width; ++j) v[j] = value.data[j][point];
  } else {
    for (uint32_t j = 0; j < width; ++j) v[j] = p.rate == Rate::Constant ? p.data[j] : asked.wide(name, j, point);
    for (uint32_t j = 0; width % 3 == 0 && j < width; j += 3) primvarToRender(p, h.surface.args(), point, v + j);
  }
  for (uint32_t j = 0; p.type == scene::ValueType::Point && j < width; ++j)
    v[j] += float(h.group->world().worldOrigin[j % 3]);
  if (p.type != scene::ValueType::Int || language::Base(to.base) != language::Base::Int)
    return giveNumbers(v + first, uint32_t(n), to, i);
  int32_t whole[kMost];  // the nearest: between corners with the same int a float may fall short of it
  for (size_t j = 0; j < n; ++j) {
    const float x = std::nearbyint(v[first + j]);
    whole[j] = x >= -0x1p31f && x < 0x1p31f ? int32_t(x) : INT32_MIN;
  }
  return language::giveValue({nullptr, whole, nullptr, n}, to, i);
}

// What objects have without having been given it.
bool giveImplied(Implied what, const Value& value, int32_t index, uint32_t point, const Span& to, uint32_t i) {
  const uint32_t width = widthOf(what);
  const auto [first, n] = partOf(width, width == 3 ? 3 : 1, index, to);
  if (n == 0 || value.components < width) return false;
  float v[3];
  for (uint32_t j = 0; j < width; ++j) v[j] = value.data[j][point];
  return giveNumbers(v + first, uint32_t(n), to, i);
}

// RenderMan's names for what every point has.
bool giveBuiltin(const Context* c, const ContextHost& h, std::string_view name, uint32_t point, const Span& to,
                 uint32_t i) {
  const auto triple = [&](const float* const v[3], double shift) {
    const double* o = h.group->world().worldOrigin;
    const float x[3] = {float(v[0][point] + shift * o[0]), float(v[1][point] + shift * o[1]),
                        float(v[2][point] + shift * o[2])};
    return giveNumbers(x, 3, to, i);
  };
  const auto builtin = [&](Builtin b) {
    const Value v = c->builtin(b);
    float x[3];
    for (uint32_t k = 0; k < v.components; ++k) x[k] = v.data[k][v.stride ? point : 0];
    return giveNumbers(x, v.components, to, i);
  };
  const auto number = [&](float x) { return giveNumbers(&x, 1, to, i); };
  if (name == "P") return triple(c->P, 1);
  if (name == "Po") return builtin(Builtin::Po);
  if (name == "Nn" || name == "N") return triple(c->N, 0);
  if (name == "Ngn" || name == "Ng") return triple(c->Ng, 0);
  if (name == "Vn") return triple(c->wo, 0);
  if (name == "Tn") return builtin(Builtin::Tangent);
  if (name == "dPdu") return builtin(Builtin::DPdu);
  if (name == "dPdv") return builtin(Builtin::DPdv);
  if (name == "u") return builtin(Builtin::U);
  if (name == "v") return builtin(Builtin::V);
  if (name == "st") return builtin(Builtin::St);
  if (name == "id") return builtin(Builtin::ObjectId);
  if (name == "PRadius" || name == "incidentRayRadius") return number(c->radius[point]);
  if (name == "incidentRaySpread") return number(c->spread[point]);
  if (name == "time") return number(c->time[point]);
  return false;
}

}  // namespace

void giveAttribute(const Context* c, ContextHost& h, const Batch& batch, Span object, Span name, Span index, Span to,
                   Span found) {
  const ShadingWorld& world = h.group->world();
  const ShaderScene* scene = world.shaders.get();
  static const int32_t kBuiltin = language::internString("builtin");
  const bool inSpace = c->traits & kTraitInSpace;
  // names are looked up again only where they, or the object, change from one point to the next
  int32_t last = -1;
  const std::string* asked = nullptr;
  AskedPrimvars primvars(c);
  uint32_t lastGeometry = ~0u, lastInstance = ~0u;
  const geometry::Primvar* primvar = nullptr;
  const scene::Parameter* attribute = nullptr;
  Implied implied = Implied::None;
  const uint32_t n = found.varies ? batch.points : 1;
  for (uint32_t i = 0; i < n; ++i) {
    if (!batch.isLive(i)) continue;
    const uint32_t point = batch.first + i;
    const uint32_t geometry = inSpace ? 0 : c->place.geometry[point],
                   instance = inSpace ? 0 : c->place.instance[point];
    const int32_t handle = name.integer(0, i);
    if (handle != last || geometry != lastGeometry || instance != lastInstance) {
      last = handle, lastGeometry = geometry, lastInstance = instance;
      asked = &language::stringOf(handle);
      primvar = nullptr;
      attribute = nullptr;
      if (!inSpace) {
        primvar = world.world->mesh(geometry).find(asked->c_str());
        const uint32_t placement = world.world->infoOf(instance, geometry);
        if (scene && placement < scene->ofPlacement.size() && scene->ofPlacement[placement])
          attribute = scene->ofPlacement[placement]->named.find(*asked);
      }
      if (scene && !attribute) attribute = scene->camera.find(*asked);
      implied = primvar || inSpace ? Implied::None : impliedBy(asked->c_str());
    }
    const int32_t element = index.components ? index.integer(0, i) : -1;
    bool has = false;
    if (object.components && object.integer(0, i) != 0) {
      has = object.integer(0, i) == kBuiltin && !inSpace && giveBuiltin(c, h, *asked, point, to, i);
    } else if (!index.components || element >= 0) {
      if (primvar) has = givePrimvar(c, h, *primvar, primvars, handle, element, point, to, i);
      if (!has && hasPrimvar(c, world, nullptr, implied, point))
        has = giveImplied(implied, primvars.of(handle), element, point, to, i);
      if (!has && attribute) has = giveParameter(*attribute, element, to, i);
    }
    found.set(0, i, int32_t(has));
  }
}

void giveSurfaceArea(const Context* c, ContextHost& h, const Batch& batch, Span result) {
  const ShadingWorld& world = h.group->world();
  if (!world.shaders || c->traits & kTraitInSpace) return;
  uint64_t last = ~uint64_t(0);
  double area = 0;
  for (uint32_t i = 0; i < (result.varies ? batch.points : 1); ++i) {
    if (!batch.isLive(i)) continue;
    const uint32_t geometry = c->place.geometry[batch.first + i], instance = c->place.instance[batch.first + i];
    const uint64_t object = uint64_t(instance) << 32 | geometry;
    if (object != last) {
      last = object;
      area = world.shaders->areaOf(object);
      if (area < 0) {
        // of the triangles when the shutter opens, as large as they stand in the world then
        area = 0;
        const geometry::Mesh& mesh = world.world->mesh(geometry);
        const trace::Instance& placed = world.world->instance(instance);
        const trace::Affine m = placed.baked ? trace::Affine{} : world.world->objectToRender(instance, 0);
        for (size_t t = 0; !mesh.isStrand() && t + 2 < mesh.indices.size(); t += 3) {
          double e[2][3];
          for (int k = 0; k < 2; ++k) {
            const Imath::V3f d = mesh.points[mesh.indices[t + 1 + size_t(k)]] - mesh.points[mesh.indices[t]];
            for (int j = 0; j < 3; ++j)
              e[k][j] =
                  placed.baked ? d[j] : double(m.m[j][0]) * d.x + double(m.m[j][1]) * d.y + double(m.m[j][2]) * d.z;
          }
          const double x = e[0][1] * e[1][2] - e[0][2] * e[1][1], y = e[0][2] * e[1][0] - e[0][0] * e[1][2],
                       z = e[0][0] * e[1][1] - e[0][1] * e[1][0];
          area += 0.5 * std::sqrt(x * x + y * y + z * z);
        }
        world.shaders->setArea(object, area);
      }
    }
    result.set(0, i, float(area));
  }
}

}  // namespace kinora::shade
