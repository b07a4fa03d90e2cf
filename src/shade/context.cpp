// What a Context answers: parameters (constants, gathered blocks, networks), built-ins, primvars, textures, matrices.
#include <kinora/primvar_kind.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "shade/context_host.h"
#include "shade/implied_primvars.h"
#include "texture/texture_system.h"

namespace kinora::shade {

namespace {

void* alloc(const Context* c, size_t bytes) { return ContextHost::of(c).group->arena().allocate(bytes); }

float* floats(const Context* c) { return static_cast<float*>(alloc(c, c->padded * sizeof(float))); }

Value constantValue(const float* v, uint32_t components) {
  Value r;
  r.components = components;
  for (uint32_t k = 0; k < components; ++k) r.data[k] = v + k;
  return r;
}

Value param(const Context* c, uint32_t index) {
  ContextHost& h = ContextHost::of(c);
  const ParamSource& s = h.program->nodes[h.node].params[index];
  switch (s.from) {
    case ParamSource::From::Constant:
      return constantValue(s.constant, s.components);
    case ParamSource::From::Gathered: {
      Value r;
      r.components = s.components;
      r.stride = 1;
      const float* blocks = h.program->blocks.data();
      const size_t width = h.program->blockFloats;
      for (uint32_t k = 0; k < s.components; ++k) {
        float* out = floats(c);
        const float* base = blocks + s.offset + k;
        for (uint32_t i = 0; i < c->padded; ++i) out[i] = base[h.block[i] * width];
        r.data[k] = out;
      }
      return r;
    }
    case ParamSource::From::Connected:
      break;
  }
  h.evaluate(c, s.node);
  Value v = h.outputs[h.firstOutput[s.node] + s.output];
  if (!v.data[0]) return constantValue(s.constant, s.components);
  if (s.part >= 0) {
    v.data[0] = v.data[s.part];
    v.components = 1;
  }
  if (v.components == s.components) return v;
  if (v.components == 1) {  // a float feeds all components
    v.components = s.components;
    for (uint32_t k = 1; k < s.components; ++k) v.data[k] = v.data[0];
    return v;
  }
  // a colour feeds a float by its luminance-free average
  Value r;
  r.components = 1;
  r.stride = v.stride;
  const uint32_t n = v.stride ? c->padded : 1;
  float* out = floats(c);
  for (uint32_t i = 0; i < n; ++i) out[i] = (v.data[0][i] + v.data[1][i] + v.data[2][i]) * (1.f / 3.f);
  r.data[0] = out;
  return r;
}

const Manifold* manifold(const Context* c, uint32_t index) {
  ContextHost& h = ContextHost::of(c);
  const ParamSource& s = h.program->nodes[h.node].params[index];
  if (s.from != ParamSource::From::Connected) return nullptr;
  h.evaluate(c, s.node);
  const Manifold* m = &h.manifolds[h.firstOutput[s.node] + s.output];
  return m->q.data[0] ? m : nullptr;
}

const char* text(const Context* c, uint32_t index) {
  ContextHost& h = ContextHost::of(c);
  return h.program->nodes[h.node].params[index].text;
}

uint32_t list(const Context* c, uint32_t index, const float** numbers) {
  ContextHost& h = ContextHost::of(c);
  const std::vector<float>& l = h.program->nodes[h.node].params[index].list;
  *numbers = l.data();
  return uint32_t(l.size());
}

const Slopes& slopesOfSt(const Context* c) {
  ContextHost& h = ContextHost::of(c);
  if (!h.known.st.value[0]) {
    h.remember();
    h.known.st = h.surface.slopes({SlopeSource::What::St}, 2);
  }
  return h.known.st;
}

Value builtin(const Context* c, Builtin id) {
  ContextHost& h = ContextHost::of(c);
  ContextHost::Known& known = h.known;
  if (known.haveBuiltin[size_t(id)]) return known.builtins[size_t(id)];
  h.remember();
  const auto keep = [&](Builtin b, std::initializer_list<float*> arrays) {
    Value v;
    for (float* a : arrays) v.data[v.components++] = a;
    v.stride = 1;
    known.builtins[size_t(b)] = v;
    known.haveBuiltin[size_t(b)] = true;
  };
  const uint32_t n = c->padded;
  SurfacePoints& surface = h.surface;
  const SurfaceKernels& k = surface.kernels();
  switch (id) {
    case Builtin::U:
    case Builtin::V: {
      const Slopes uv = surface.slopes({SlopeSource::What::PatchUV}, 2);
      keep(Builtin::U, {uv.value[0]});
      keep(Builtin::V, {uv.value[1]});
      break;
    }
    case Builtin::St:
    case Builtin::StRadius: {
      const Slopes& st = slopesOfSt(c);
      float* r = floats(c);
      k.footprints(n, c->radius, surface.edge(0), surface.edge(1), st, r);
      keep(Builtin::St, {st.value[0], st.value[1]});
      keep(Builtin::StRadius, {r});
      break;
    }
    case Builtin::DPdu:
    case Builtin::DPdv: {
      float *du[3] = {floats(c), floats(c), floats(c)}, *dv[3] = {floats(c), floats(c), floats(c)};
      k.derivatives(n, surface.edge(0), surface.edge(1), surface.slopes({SlopeSource::What::PatchUV}, 2), du, dv);
      keep(Builtin::DPdu, {du[0], du[1], du[2]});
      keep(Builtin::DPdv, {dv[0], dv[1], dv[2]});
      break;
    }
    case Builtin::Fiber: {
      float* along[3] = {floats(c), floats(c), floats(c)};
      const SurfaceArgs& args = surface.args();
      for (uint32_t i = 0; i < n; ++i) {
        const StrandPlace* strand = args.strand ? args.strand[i] : nullptr;
        float length = 0;
        const geometry::Mesh& mesh = h.group->world().world->mesh(c->place.geometry[i]);
        if (strand && mesh.isCurve() && !mesh.isOriented())
          length = std::sqrt(strand->dv[0] * strand->dv[0] + strand->dv[1] * strand->dv[1] +
                             strand->dv[2] * strand->dv[2]);
        for (int j = 0; j < 3; ++j) along[j][i] = length > 0 ? strand->dv[j] / length : 0.f;
      }
      keep(Builtin::Fiber, {along[0], along[1], along[2]});
      break;
    }
    case Builtin::Tangent: {
      float* t[3] = {floats(c), floats(c), floats(c)};
      k.derivatives(n, surface.edge(0), surface.edge(1), slopesOfSt(c), t, nullptr);
      k.across(n, c->N, t);
      keep(Builtin::Tangent, {t[0], t[1], t[2]});
      break;
    }
    case Builtin::Po:
    case Builtin::PoRadius: {
      float *p[3] = {floats(c), floats(c), floats(c)}, *r = floats(c);
      if (c->traits & kTraitInSpace)
        placesInMedia(c, p, r);
      else
        surface.rest(p, r);
      for (uint32_t i = 0; i < n; ++i) r[i] *= c->radius[i];
      keep(Builtin::Po, {p[0], p[1], p[2]});
      keep(Builtin::PoRadius, {r});
      break;
    }
    case Builtin::Pworld: {
      float* a[3];
      for (int j = 0; j < 3; ++j) {
        a[j] = floats(c);
        const double o = h.group->world().worldOrigin[j];
        for (uint32_t i = 0; i < n; ++i) a[j][i] = float(c->P[j][i] + o);
      }
      keep(Builtin::Pworld, {a[0], a[1], a[2]});
      break;
    }
    case Builtin::FacetEdge1:
    case Builtin::FacetEdge2:
    case Builtin::DNEdge1:
    case Builtin::DNEdge2: {
      float* x[4][3];
      for (auto& v : x)
        for (float*& y : v) y = floats(c);
      if (c->traits & kTraitInSpace) {
        for (auto& v : x)
          for (float* y : v) std::fill_n(y, n, 0.f);
      } else {
        k.facetSlopes(surface.meshArgs(), x[0], x[1], x[2], x[3]);
        // N lies on wo's side; where it is the facet's own it does not change
        for (uint32_t i = 0; i < n; ++i) {
          const bool isFacet = c->N[0][i] == c->Ng[0][i] && c->N[1][i] == c->Ng[1][i] && c->N[2][i] == c->Ng[2][i];
          const float side = isFacet ? 0.f : c->entering[i] ? 1.f : -1.f;
          for (int j = 0; j < 3; ++j) {
            x[2][j][i] *= side;
            x[3][j][i] *= side;
          }
        }
      }
      keep(Builtin::FacetEdge1, {x[0][0], x[0][1], x[0][2]});
      keep(Builtin::FacetEdge2, {x[1][0], x[1][1], x[1][2]});
      keep(Builtin::DNEdge1, {x[2][0], x[2][1], x[2][2]});
      keep(Builtin::DNEdge2, {x[3][0], x[3][1], x[3][2]});
      break;
    }
    case Builtin::DNdu:
    case Builtin::DNdv: {
      const Value e1 = builtin(c, Builtin::FacetEdge1), e2 = builtin(c, Builtin::FacetEdge2),
                  n1 = builtin(c, Builtin::DNEdge1), n2 = builtin(c, Builtin::DNEdge2);
      float *a = floats(c), *b = floats(c);
      for (const auto& [step, out] : {std::pair{Builtin::DPdu, Builtin::DNdu}, {Builtin::DPdv, Builtin::DNdv}}) {
        float* d[3] = {floats(c), floats(c), floats(c)};
        k.alongEdges(n, e1.data, e2.data, builtin(c, step).data, a, b);
        for (int j = 0; j < 3; ++j)
          for (uint32_t i = 0; i < n; ++i) d[j][i] = a[i] * n1.data[j][i] + b[i] * n2.data[j][i];
        keep(out, {d[0], d[1], d[2]});
      }
      break;
    }
    case Builtin::ObjectId:
    case Builtin::Count: {
      float* a = floats(c);
      const ShadingWorld& w = h.group->world();
      for (uint32_t i = 0; i < n; ++i)
        a[i] = float(w.placementOf(c->place.instance[i], c->place.geometry[i]).objectId);
      keep(Builtin::ObjectId, {a});
      break;
    }
  }
  return known.builtins[size_t(id)];
}

// How much a number changes over a unit of distance.
float slopeOf(const SurfaceArgs& a, uint32_t point, const float e1[3], const float e2[3], float d1, float d2) {
  const auto along = [](const float e[3], float d) {
    const float l = std::sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
    return l > 0 ? std::fabs(d) / l : 0.f;
  };
  if (a.strand && a.strand[point]) return along(e2, d2);             // it changes along the strand
  if (!a.quad[0] || !(a.quad[0][point] >= 0)) return along(e1, d1);  // on a triangle its first edge will do
  return std::max(along(e1, d1), along(e2, d2));
}

// 1 at points that the camera saw, itself or by mirrors, 0 at those that a diffuse bounce found: they have link sets of
// their own (ShadingWorld::indirectSets).
Value seenAt(const Context* c) {
  const ContextHost& h = ContextHost::of(c);
  Value out;
  const uint32_t indirect = h.group->world().indirectSets;
  if (!indirect || !h.state.linkSet) return out;
  float* seen = floats(c);
  for (uint32_t i = 0; i < c->padded; ++i) seen[i] = h.state.linkSet[i] < indirect ? 1.f : 0.f;
  out.data[0] = seen;
  out.components = out.stride = 1;
  return out;
}

Value acrossRibbon(const Context* c) {
  ContextHost& h = ContextHost::of(c);
  const trace::World& w = *h.group->world().world;
  Value out;
  if (!w.hasRibbons()) return out;
  const SurfaceArgs& args = h.surface.args();
  float* across = floats(c);
  for (uint32_t i = 0; i < c->padded; ++i) {
    const geometry::Mesh& mesh = w.mesh(c->place.geometry[i]);
    const bool isRibbon = mesh.facesRay() && mesh.isCurve() && args.strand && args.strand[i];
    across[i] = isRibbon ? 2 * args.strand[i]->uv[0] - 1 : 2.f;
  }
  out.data[0] = across;
  out.components = out.stride = 1;
  return out;
}

PrimvarKind kindOf(scene::ValueType type) {
  switch (type) {
    case scene::ValueType::Point:
      return PrimvarKind::Point;
    case scene::ValueType::Vector:
      return PrimvarKind::Vector;
    case scene::ValueType::Normal:
      return PrimvarKind::Normal;
    default:
      return PrimvarKind::Number;
  }
}

Value primvar(const Context* c, const char* name, Value* radius) {
  ContextHost& h = ContextHost::of(c);
  const uint32_t n = c->padded;
  Value out;
  if (!std::strcmp(name, kSeenPrimvar)) return seenAt(c);
  if (!std::strcmp(name, kRibbonPrimvar)) return acrossRibbon(c);
  if (c->traits & kTraitInSpace && !h.program) {  // no object is there
    if (radius) *radius = Value();
    return out;
  }
  // The widest of that name in the scene holds for all points, so that it does not matter which ones share a context;
  // objects without it give 0 and say so, numbers fill all components.
  const ShadingWorld& world = h.group->world();
  const auto known = world.primvarWidths.find(std::string_view(name));
  if (known == world.primvarWidths.end()) {
    if (radius) *radius = Value();
    return out;
  }
  const uint32_t width = known->second;
  const Implied implied = impliedBy(name);
  const geometry::Primvar* const* of = primvarsOf(c, name);
  SurfacePoints& surface = h.surface;
  const Slopes s = surface.slopes({SlopeSource::What::Primvar, of, implied}, width);
  const SurfaceArgs& args = surface.args();
  for (uint32_t i = 0; width == 3 && i < n; ++i) {
    if (!of[i] || of[i]->width < 3 || of[i]->type == scene::ValueType::Color) continue;
    float v[3] = {s.value[0][i], s.value[1][i], s.value[2][i]};
    primvarToRender(*of[i], args, i, v);
    for (int j = 0; j < 3; ++j) s.value[j][i] = v[j];
  }
  float* const inField = c->traits & kTraitInSpace && radius ? floats(c) : nullptr;
  if (c->traits & kTraitInSpace) fieldsInMedia(c, name, width, s.value, inField);
  out.components = width;
  out.stride = 1;
  for (uint32_t j = 0; j < width; ++j) out.data[j] = s.value[j];
  if (!radius) return out;
  float *r = floats(c), *components = floats(c), *kind = floats(c);
  const float *const *e1 = surface.edge(0), *const *e2 = surface.edge(1);
  if (width > 1) surface.kernels().footprints(n, c->radius, e1, e2, s, r);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t own = std::min(width, of[i] ? uint32_t(of[i]->width) : widthOf(implied));
    const bool has = hasPrimvar(c, world, of[i], implied, i);
    components[i] = has ? float(own) : inField ? inField[i] : 0.f;
    kind[i] = float(of[i] && own == 3 ? kindOf(of[i]->type) : PrimvarKind::Number);
    if (own == 0) r[i] = 0;
    if (own != 1) continue;
    const float a[3] = {e1[0][i], e1[1][i], e1[2][i]}, b[3] = {e2[0][i], e2[1][i], e2[2][i]};
    r[i] = c->radius[i] * slopeOf(args, i, a, b, s.d1[0][i], s.d2[0][i]);
  }
  *radius = Value();
  radius->data[kPrimvarFootprint] = r;
  radius->data[kPrimvarComponents] = components;
  radius->data[kPrimvarKind] = kind;
  radius->stride = 1;
  radius->components = 3;
  return out;
}

void texture(const Context* c, const Value* handles, const float* s, const float* t, const float* radius,
             const float* const axes[4], const TextureOptions* options, float* const rgba[4]) {
  ContextHost& h = ContextHost::of(c);
  h.group->world().textures->lookup(reinterpret_cast<const int32_t*>(handles->data[0]), handles->stride != 0,
                                    c->padded, s, t, radius, *options, rgba, axes);
}

// What displaces a surface is looked up by circles: neighbours have to agree on each of its points.
int ellipses(const Context* c, const char* name, Value axes[2]) {
  ContextHost& h = ContextHost::of(c);
  if (c->traits & (kTraitLightPath | kTraitInSpace) || h.rayKind == RayKind::Transmission || !h.program ||
      h.program->displacement || h.program->isMovedByShader)
    return 0;
  bool isNarrow = false;
  for (uint32_t i = 0; i < c->count && !isNarrow; ++i) isNarrow = c->spread[i] <= kNarrowSpread;
  if (!isNarrow) return 0;
  const auto answer = [&](float* const a[4]) {
    for (uint32_t k = 0; k < 2; ++k) {
      axes[k] = Value();
      axes[k].data[0] = a[2 * k];
      axes[k].data[1] = a[2 * k + 1];
      axes[k].stride = 1;
      axes[k].components = 2;
    }
    return 1;
  };
  // one material has many lookups at the texture coordinates
  float** const known = h.known.ellipses;
  if (!name && known[0]) return answer(known);
  h.remember();
  SurfacePoints& surface = h.surface;
  const geometry::Primvar* const* of = nullptr;
  Implied implied = Implied::None;
  if (name) {
    const ShadingWorld& world = h.group->world();
    const auto known = world.primvarWidths.find(std::string_view(name));
    if (known == world.primvarWidths.end() || known->second < 2) return 0;
    of = primvarsOf(c, name);
    implied = impliedBy(name);
  }
  const Slopes st = of ? surface.slopes({SlopeSource::What::Primvar, of, implied}, 2) : slopesOfSt(c);
  float* out[4];
  for (float*& x : out) x = floats(c);
  surface.kernels().ellipses(
      {c->padded, c->radius, c->spread, c->sampleIndex, c->wo, c->Ng, surface.edge(0), surface.edge(1), st}, out);
  // thin strands have no long footprints; primvars of other widths are no places in a picture
  const SurfaceArgs& args = surface.args();
  for (uint32_t i = 0; (args.strand || of) && i < c->padded; ++i) {
    const bool isPlace = !of || (of[i] ? of[i]->width : widthOf(implied)) == 2;
    if (isPlace && !(args.strand && args.strand[i])) continue;
    for (float* x : out) x[i] = 0;
  }
  if (!name) std::copy_n(out, 4, known);
  return answer(out);
}

scene::Matrix matrixOf(const trace::Affine& a) {
  scene::Matrix m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m[j][i] = a.m[i][j];
    m[3][i] = a.t[i];
  }
  return m;
}

// A space by name, as points of a context see it: those of objects are each point's own, and what moves is where it is at
// the point's time.
class NamedSpace {
 public:
  NamedSpace(const ShadingWorld& w, const Context* c, const char* name) : w_(w), c_(c), name_(name) {
    const bool isPlaced = c->place.instance != nullptr;
    const auto still = w.spaces.find(name_);
    still_ = still == w.spaces.end() ? nullptr : &still->second;
    const auto moving = w.movingSpaces.find(name_);
    moving_ = moving == w.movingSpaces.end() ? nullptr : &moving->second;
    isRender_ = name_ == "render" || name_ == "current";
    // where a shader was declared is not kept: as exporters write it, that is the object's space
    isObject_ = isPlaced && (name_ == "object" || (name_ == "shader" && !still_));
    isOfObjects_ = isPlaced && w.objectSystems.contains(name_);
  }

  // Names that some object gives are known everywhere, so that which points share a context does not show.
  bool isKnown() const { return isRender_ || isObject_ || isOfObjects_ || still_ || moving_; }
  bool isSameAs(const NamedSpace& o) const { return name_ == o.name_ || (isObject_ && o.isObject_); }
  // What it follows from.
  enum class Varies : uint8_t { Never, ByPlace, ByTime };
  Varies varies() const {
    if (isRender_) return Varies::Never;
    if (isObject_ || isOfObjects_) {
      for (uint32_t i = 0; i < c_->padded; ++i)
        if (moving_ || w_.world->instance(c_->place.instance[i]).keyCount > 1) return Varies::ByTime;
      return Varies::ByPlace;
    }
    return moving_ ? Varies::ByTime : Varies::Never;
  }
  scene::Matrix toRender(uint32_t point) const {
    if (isRender_) return scene::Matrix();
    if (isObject_) return objectToRender(point);
    if (isOfObjects_)
      if (const auto* systems = w_.geometries[c_->place.geometry[point]].systems.get())
        if (const auto it = systems->find(name_); it != systems->end()) return it->second * objectToRender(point);
    if (moving_) return moving_->at(double(c_->time[point]));
    return still_ ? *still_ : scene::Matrix();
  }

 private:
  scene::Matrix objectToRender(uint32_t point) const {
    const uint32_t instance = c_->place.instance[point];
    const scene::Matrix m = matrixOf(w_.spaceOf(instance, c_->place.geometry[point]).fromRender).inverse();
    if (w_.world->instance(instance).keyCount < 2) return m;
    return m * matrixOf(w_.world->objectToRender(instance, 0.5f)).inverse() *
           matrixOf(w_.world->objectToRender(instance, c_->time[point]));
  }

  const ShadingWorld& w_;
  const Context* c_;
  const std::string_view name_;
  const scene::Matrix* still_;
  const scene::Transform* moving_;
  bool isRender_, isObject_, isOfObjects_;
};

int matrix(const Context* c, const char* from, const char* to, MatrixValue* out) {
  const ShadingWorld& w = ContextHost::of(c).group->world();
  const NamedSpace first(w, c, from), second(w, c, to);
  const bool known = first.isKnown() && second.isKnown(), isSame = first.isSameAs(second);
  using Varies = NamedSpace::Varies;
  const Varies varies = !known || isSame ? Varies::Never : std::max(first.varies(), second.varies());
  const auto isAsBefore = [&](uint32_t i) {
    return c->place.instance[i] == c->place.instance[i - 1] && c->place.geometry[i] == c->place.geometry[i - 1];
  };
  bool one = varies != Varies::ByTime;
  for (uint32_t i = 1; varies == Varies::ByPlace && one && i < c->padded; ++i) one = isAsBefore(i);
  float* entries[16];
  for (int k = 0; k < 16; ++k)
    out->m[k] = entries[k] = one ? static_cast<float*>(alloc(c, sizeof(float))) : floats(c);
  out->stride = one ? 0 : 1;
  scene::Matrix m;
  for (uint32_t i = 0; i < (one ? 1 : c->padded); ++i) {
    const bool isNew = i == 0 || varies == Varies::ByTime || !isAsBefore(i);
    if (known && !isSame && isNew) m = first.toRender(i) * second.toRender(i).inverse();
    for (int k = 0; k < 16; ++k) entries[k][i] = float(m[k / 4][k % 4]);
  }
  return known;
}

Value gradient(const Context* c, const char* name, uint32_t component) {
  ContextHost& h = ContextHost::of(c);
  Value out;
  const ShadingWorld& world = h.group->world();
  if (name && !world.primvarWidths.contains(std::string_view(name))) return out;
  const Implied implied = name ? impliedBy(name) : Implied::None;
  out.components = 3;
  out.stride = 1;
  float* g[3];
  for (int j = 0; j < 3; ++j) out.data[j] = g[j] = floats(c);
  SurfacePoints& surface = h.surface;
  const geometry::Primvar* const* of = name ? primvarsOf(c, name) : nullptr;
  // as primvar(): a number fills all components
  const Slopes s = name ? surface.slopes({SlopeSource::What::Primvar, of, implied}, 3) : slopesOfSt(c);
  const uint32_t k = name ? std::min(component, 2u) : component & 1;
  const float *const *x = surface.edge(0), *const *y = surface.edge(1);
  for (uint32_t i = 0; i < c->padded; ++i) {
    float f1 = s.d1[k][i], f2 = s.d2[k][i];
    if (of && of[i] && of[i]->width >= 3 && of[i]->type != scene::ValueType::Color) {
      float d1[3] = {s.d1[0][i], s.d1[1][i], s.d1[2][i]}, d2[3] = {s.d2[0][i], s.d2[1][i], s.d2[2][i]};
      primvarToRender(*of[i], surface.args(), i, d1, true);
      primvarToRender(*of[i], surface.args(), i, d2, true);
      f1 = d1[k];
      f2 = d2[k];
    }
    const float e1[3] = {x[0][i], x[1][i], x[2][i]}, e2[3] = {y[0][i], y[1][i], y[2][i]};
    float at[3];
    gradientOf(e1, e2, f1, f2, at);
    for (int j = 0; j < 3; ++j) g[j][i] = at[j];
  }
  return out;
}

int isConnected(const Context* c, uint32_t index) {
  const ContextHost& h = ContextHost::of(c);
  return h.program->nodes[h.node].params[index].from == ParamSource::From::Connected;
}

int probe(const Context* c, const ProbeRays* rays) { return ContextHost::of(c).group->probe(c, *rays); }

}  // namespace

void ContextHost::evaluate(const Context* c, uint32_t n) {
  if (done[n]) return;
  remember();
  done[n] = 1;
  const ProgramNode& p = program->nodes[n];
  if (p.shader >= 0) {
    const ShaderUse& use = program->shaders[size_t(p.shader)];
    for (const uint32_t member : use.nodes) done[member] = 1;
    runShaders(c, *this, use);
    return;
  }
  if (n >= program->patterns.size() || !program->patterns[n]) return;
  const uint32_t before = node;
  node = n;
  PatternArgs a;
  a.outputCount = uint32_t(p.outputParam.size());
  a.wanted = p.wanted.data();
  a.outputs = outputs + firstOutput[n];
  a.manifolds = manifolds + firstOutput[n];
  program->patterns[n]->compute(c, &a);
  node = before;
}

void ContextHost::startNetwork() {
  Arena& arena = group->arena();
  const uint32_t nodes = uint32_t(program->nodes.size());
  done = arena.make<uint8_t>(nodes);
  std::memset(done, 0, nodes);
  firstOutput = arena.make<uint32_t>(nodes);
  uint32_t outs = 0;
  for (uint32_t k = 0; k < nodes; ++k) {
    firstOutput[k] = outs;
    outs += uint32_t(program->nodes[k].outputParam.size());
  }
  outputs = arena.make<Value>(outs + 1);
  manifolds = arena.make<Manifold>(outs + 1);
  for (uint32_t k = 0; k < outs; ++k) {
    outputs[k] = Value();
    manifolds[k] = Manifold();
  }
  node = nodes - 1;
}

void ContextHost::keepAll(uint64_t mark) {
  static_assert(std::is_trivially_copyable_v<Known> && std::is_trivially_copyable_v<SurfacePoints>);
  Arena& arena = group->arena();
  arena.keepUntilRelease(&known, sizeof known, born);
  arena.keepUntilRelease(&surface, sizeof surface, born);
  if (program) {
    const size_t nodes = program->nodes.size();
    const size_t outs = nodes ? firstOutput[nodes - 1] + program->nodes[nodes - 1].outputParam.size() : 0;
    arena.keepUntilRelease(done, nodes, born);
    arena.keepUntilRelease(outputs, outs * sizeof(Value), born);
    arena.keepUntilRelease(manifolds, outs * sizeof(Manifold), born);
  }
  known.keptFor = mark;
}

const ContextFunctions kContextFunctions{&alloc,   &param,    &manifold,    &text,         &list,
                                         &builtin, &primvar,  &texture,     &matrix,       &gradient,
                                         &probe,   &ellipses, &isConnected, &paramGradient};

}  // namespace kinora::shade
