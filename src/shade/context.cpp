// What a Context answers: parameters (constants, gathered blocks, networks), built-ins, primvars, textures, matrices.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/where.h"
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

Value builtin(const Context* c, Builtin id) {
  ContextHost& h = ContextHost::of(c);
  if (h.haveBuiltin[size_t(id)]) return h.builtins[size_t(id)];
  const auto keep = [&](Builtin b, std::initializer_list<float*> arrays) {
    Value v;
    for (float* a : arrays) v.data[v.components++] = a;
    v.stride = 1;
    h.builtins[size_t(b)] = v;
    h.haveBuiltin[size_t(b)] = true;
  };
  const uint32_t n = c->padded;
  switch (id) {
    case Builtin::U:
    case Builtin::V: {
      float *u = floats(c), *v = floats(c);
      for (uint32_t i = 0; i < n; ++i) {
        const Where k = whereOf(h, c, i);
        const Sloped uv = patchUV(k);
        u[i] = uv.value[0];
        v[i] = uv.value[1];
      }
      keep(Builtin::U, {u});
      keep(Builtin::V, {v});
      break;
    }
    case Builtin::St:
    case Builtin::StRadius: {
      float *s = floats(c), *t = floats(c), *r = floats(c);
      for (uint32_t i = 0; i < n; ++i) {
        const Where k = whereOf(h, c, i);
        float e1[3], e2[3];
        const Sloped st = textureCoordinates(k);
        edges(k, e1, e2);
        s[i] = st.value[0];
        t[i] = st.value[1];
        r[i] = c->radius[i] * scaleOf(e1, e2, st);
      }
      keep(Builtin::St, {s, t});
      keep(Builtin::StRadius, {r});
      break;
    }
    case Builtin::DPdu:
    case Builtin::DPdv: {
      float* a[6];
      for (float*& x : a) x = floats(c);
      for (uint32_t i = 0; i < n; ++i) {
        const Where k = whereOf(h, c, i);
        float e1[3], e2[3], du[3], dv[3];
        edges(k, e1, e2);
        derivatives(e1, e2, patchUV(k), du, dv);
        for (int j = 0; j < 3; ++j) {
          a[j][i] = du[j];
          a[3 + j][i] = dv[j];
        }
      }
      keep(Builtin::DPdu, {a[0], a[1], a[2]});
      keep(Builtin::DPdv, {a[3], a[4], a[5]});
      break;
    }
    case Builtin::Tangent: {
      float* a[3];
      for (float*& x : a) x = floats(c);
      for (uint32_t i = 0; i < n; ++i) {
        const Where k = whereOf(h, c, i);
        float e1[3], e2[3], du[3], dv[3];
        edges(k, e1, e2);
        derivatives(e1, e2, textureCoordinates(k), du, dv);
        const float N[3] = {c->N[0][i], c->N[1][i], c->N[2][i]};
        const float l2 = acrossNormal(N, du);
        const float inv = 1.f / std::sqrt(l2);
        for (int j = 0; j < 3; ++j) a[j][i] = du[j] * inv;
      }
      keep(Builtin::Tangent, {a[0], a[1], a[2]});
      break;
    }
    case Builtin::Po:
    case Builtin::PoRadius: {
      float* a[4];
      for (float*& x : a) x = floats(c);
      const trace::World& w = *h.group->world().world;
      for (uint32_t i = 0; i < n; ++i) {
        const Where k = whereOf(h, c, i);
        float p[3];
        float scale = 1;
        if (k.identity) {
          const trace::Affine& back =
              h.group->world().placements[w.instance(c->place.instance[i]).user].renderToObject;
          const float q[3] = {c->P[0][i], c->P[1][i], c->P[2][i]};
          back.point(q, p);
          const float det = back.m[0][0] * (back.m[1][1] * back.m[2][2] - back.m[1][2] * back.m[2][1]) -
                            back.m[0][1] * (back.m[1][0] * back.m[2][2] - back.m[1][2] * back.m[2][0]) +
                            back.m[0][2] * (back.m[1][0] * back.m[2][1] - back.m[1][1] * back.m[2][0]);
          scale = std::cbrt(std::fabs(det));
        } else if (k.strand) {
          std::memcpy(p, k.on.rest, sizeof p);
          const auto& m = k.toRender.m;
          const float det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                            m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                            m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
          scale = det != 0 ? 1.f / std::cbrt(std::fabs(det)) : 1.f;
        } else {
          // of the triangle that was hit, undeformed; a quad's first or second one
          const Imath::V3f *at = k.mesh->points.data(), *p0 = at + k.v[0];
          const bool second = isOnQuad(k) && k.primitive != k.quad;
          const Imath::V3f *p1 = at + k.v[second ? 2 : 1], *p2 = at + k.v[second ? 3 : 2];
          for (int j = 0; j < 3; ++j) p[j] = mix(k, (*p0)[j], (*p1)[j], (*p2)[j]) + float(k.mesh->origin[j]);
          float e1[3], e2[3];
          edges(k, e1, e2);
          Imath::V3f o1 = *p1 - *p0, o2 = *p2 - *p0;
          if (isOnQuad(k))
            for (int j = 0; j < 3; ++j) {
              const float corner[4] = {at[k.v[0]][j], at[k.v[1]][j], at[k.v[2]][j], at[k.v[3]][j]};
              slopesOfQuad(k, corner, o1[j], o2[j]);
            }
          const float ox = o1.y * o2.z - o1.z * o2.y, oy = o1.z * o2.x - o1.x * o2.z, oz = o1.x * o2.y - o1.y * o2.x;
          const float rx = e1[1] * e2[2] - e1[2] * e2[1], ry = e1[2] * e2[0] - e1[0] * e2[2],
                      rz = e1[0] * e2[1] - e1[1] * e2[0];
          const float render = ox * ox + oy * oy + oz * oz, object = rx * rx + ry * ry + rz * rz;
          scale = object > 0 ? std::sqrt(std::sqrt(render / object)) : 1.f;
        }
        for (int j = 0; j < 3; ++j) a[j][i] = p[j];
        a[3][i] = c->radius[i] * scale;
      }
      keep(Builtin::Po, {a[0], a[1], a[2]});
      keep(Builtin::PoRadius, {a[3]});
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
    case Builtin::ObjectId:
    case Builtin::Count: {
      float* a = floats(c);
      const ShadingWorld& w = h.group->world();
      for (uint32_t i = 0; i < n; ++i)
        a[i] = float(w.placements[w.world->instance(c->place.instance[i]).user].objectId);
      keep(Builtin::ObjectId, {a});
      break;
    }
  }
  return h.builtins[size_t(id)];
}

// How much a number changes over a unit of distance.
float slopeOf(const Where& k, const float e1[3], const float e2[3], const Sloped& v) {
  const auto along = [](const float e[3], float d) {
    const float l = std::sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
    return l > 0 ? std::fabs(d) / l : 0.f;
  };
  if (k.strand) return along(e2, v.d2[0]);      // it changes along the strand
  if (!isOnQuad(k)) return along(e1, v.d1[0]);  // on a triangle its first edge will do
  return std::max(along(e1, v.d1[0]), along(e2, v.d2[0]));
}

Value primvar(const Context* c, const char* name, Value* radius) {
  ContextHost& h = ContextHost::of(c);
  const uint32_t n = c->padded;
  Value out;
  // The widest of that name in the scene holds for all points, so that it does not matter which ones share a context;
  // objects without it give 0, numbers fill all components.
  const ShadingWorld& world = h.group->world();
  const auto known = world.primvarWidths.find(std::string_view(name));
  if (known == world.primvarWidths.end()) {
    if (radius) *radius = Value();
    return out;
  }
  const uint32_t width = known->second;
  const Implied implied = impliedBy(name);
  const geometry::Mesh* last = nullptr;
  const geometry::Primvar* p = nullptr;
  float* a[3] = {nullptr, nullptr, nullptr};
  for (uint32_t j = 0; j < width; ++j) a[j] = floats(c);
  float* r = radius ? floats(c) : nullptr;
  for (uint32_t i = 0; i < n; ++i) {
    const Where k = whereOf(h, c, i);
    if (k.mesh != last) {
      last = k.mesh;
      p = primvarOf(*k.mesh, name);
    }
    if (!p && implied == Implied::None) {
      for (uint32_t j = 0; j < width; ++j) a[j][i] = 0;
      if (r) r[i] = 0;
      continue;
    }
    const uint32_t w = std::min(width, p ? uint32_t(p->width) : widthOf(implied));
    const Sloped v = p ? valuesAt(*p, k, w) : impliedValue(implied, k, world.tints[k.placement->tint]);
    float f[3] = {0, 0, 0};
    for (uint32_t j = 0; j < w; ++j) f[j] = v.value[j];
    if (w == 1) f[1] = f[2] = f[0];
    if (p && w == 3) primvarToRender(*p, k, f);
    for (uint32_t j = 0; j < width; ++j) a[j][i] = f[j];
    if (r) {
      float e1[3], e2[3];
      edges(k, e1, e2);
      r[i] = c->radius[i] * (w >= 2 ? scaleOf(e1, e2, v) : slopeOf(k, e1, e2, v));
    }
  }
  out.components = width;
  out.stride = 1;
  for (uint32_t j = 0; j < width; ++j) out.data[j] = a[j];
  if (radius) {
    *radius = Value();
    if (r) {
      radius->data[0] = r;
      radius->stride = 1;
      radius->components = 1;
    }
  }
  return out;
}

void texture(const Context* c, const Value* handles, const float* s, const float* t, const float* radius,
             const TextureOptions* options, float* const rgba[4]) {
  ContextHost& h = ContextHost::of(c);
  h.group->world().textures->lookup(reinterpret_cast<const int32_t*>(handles->data[0]), handles->stride != 0,
                                    c->padded, s, t, radius, *options, rgba);
}

int matrix(const Context* c, const char* from, const char* to, MatrixValue* out) {
  const ContextHost& h = ContextHost::of(c);
  const ShadingWorld& w = h.group->world();
  const uint32_t* instanceOf = c->place.instance;
  const auto isObject = [](const char* space) { return !std::strcmp(space, "object"); };
  bool known = true;
  const auto toRender = [&](const char* space, uint32_t instance) {
    if (!std::strcmp(space, "render") || !std::strcmp(space, "current")) return scene::Matrix();
    if (isObject(space) && !(c->traits & kTraitInSpace)) {
      const trace::Affine& b = w.placements[w.world->instance(instance).user].renderToObject;
      scene::Matrix m;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) m[j][i] = b.m[i][j];
        m[3][i] = b.t[i];
      }
      return m.inverse();
    }
    const auto it = w.spaces.find(space);
    if (it != w.spaces.end()) return it->second;
    known = false;
    return scene::Matrix();
  };
  const auto between = [&](uint32_t instance) { return toRender(from, instance) * toRender(to, instance).inverse(); };
  // object space is each point's own: which points share a context must not show
  const bool objects = !(c->traits & kTraitInSpace) && (isObject(from) != isObject(to));
  uint32_t instance = objects ? instanceOf[0] : 0;
  bool one = true;
  for (uint32_t i = 1; objects && one && i < c->padded; ++i) one = instanceOf[i] == instance;
  float* entries[16];
  for (int k = 0; k < 16; ++k)
    out->m[k] = entries[k] = one ? static_cast<float*>(alloc(c, sizeof(float))) : floats(c);
  out->stride = one ? 0 : 1;
  scene::Matrix m = isObject(from) && isObject(to) ? scene::Matrix() : between(instance);
  for (uint32_t i = 0; i < (one ? 1 : c->padded); ++i) {
    if (!one && instanceOf[i] != instance) m = between(instance = instanceOf[i]);
    for (int k = 0; k < 16; ++k) entries[k][i] = known ? float(m[k / 4][k % 4]) : float(k % 5 == 0);
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
  const geometry::Mesh* last = nullptr;
  const geometry::Primvar* p = nullptr;
  for (uint32_t i = 0; i < c->padded; ++i) {
    const Where k = whereOf(h, c, i);
    if (name && k.mesh != last) {
      last = k.mesh;
      p = primvarOf(*k.mesh, name);
    }
    float e1[3], e2[3], f[2] = {0, 0}, at[3];
    edges(k, e1, e2);
    if (!name) {
      const Sloped st = textureCoordinates(k);
      f[0] = st.d1[component & 1];
      f[1] = st.d2[component & 1];
    } else if (p || implied != Implied::None) {
      // as primvar(): a number fills all components
      const uint32_t w = p ? std::min<uint32_t>(3, uint32_t(p->width)) : widthOf(implied);
      const uint32_t from = w == 1 ? 0 : component;
      if (from < w) {
        Sloped v = p ? valuesAt(*p, k, w) : impliedValue(implied, k, world.tints[k.placement->tint]);
        if (p && w == 3) {
          primvarToRender(*p, k, v.d1, true);
          primvarToRender(*p, k, v.d2, true);
        }
        f[0] = v.d1[from];
        f[1] = v.d2[from];
      }
    }
    gradientOf(e1, e2, f[0], f[1], at);
    for (int j = 0; j < 3; ++j) g[j][i] = at[j];
  }
  return out;
}

}  // namespace

void ContextHost::findQuadPlaces(const Context* c) {
  for (float*& x : quadPlaces) x = floats(c);
  shade::findQuadPlaces(*group, c, quadPlaces[0], quadPlaces[1]);
}

void ContextHost::evaluate(const Context* c, uint32_t n) {
  if (done[n]) return;
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

const ContextFunctions kContextFunctions{&alloc,   &param,   &manifold, &text,   &list,
                                         &builtin, &primvar, &texture,  &matrix, &gradient};

}  // namespace kinora::shade
