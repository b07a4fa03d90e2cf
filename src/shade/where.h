// Where in its primitive a shading point lies, and values there: the one record behind patch parameters, texture
// coordinates, derivatives and primvars. A value is told with its changes along two edges (struct Sloped): those of
// the triangle around the point; on a quad and on a strand (curve, point) one unit of u and of v, so that who reads
// values and slopes need not know the kind. Internal to shade/, inlined into what runs for each point.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/context_host.h"

namespace kinora::shade {

// What a place on a strand adds. Render space, but for `rest`.
struct StrandPlace {
  float weight[4], slope[4];  // of control points: for values, for their derivative by v
  uint32_t controls;
  float uv[2];
  float du[3], dv[3];  // dP/du, dP/dv
  float rest[3];       // object space, undeformed
};

struct Where {
  const geometry::Mesh* mesh;
  const GeometryInfo* info;
  const PlacementInfo* placement;
  uint32_t primitive, face;
  uint32_t v[4];  // corners of the triangle, or of the quad; control points of a strand
  float b[3];     // weights of the corners of the triangle that was hit
  trace::Affine toRender;
  float time;
  bool identity, strand;
  uint32_t quad;   // Mesh::quadOf() where place is bilinear, else Mesh::kNoQuad
  float uv[2];     // quads only: parameters there
  StrandPlace on;  // strands only
};

// A value and its changes along the edges() of the place, at most three components.
struct Sloped {
  float value[3], d1[3], d2[3];
};

// `s` is the hit's parameter along a piece of curve, `towards` points to where the ray came from.
void placeOnStrand(Where& k, float s, const float P[3], const float towards[3]);
// Radius of the strand there, in its own space.
float strandRadius(const geometry::Mesh& mesh, uint32_t primitive, float s, float time);

// Parameters in their quads of a context's points; u is -1 where place is the triangle's own: on other triangles, and
// on quads that are not convex.
void findQuadPlaces(GroupState& group, const Context* c, float* u, float* v);

inline Where whereOf(ContextHost& h, const Context* c, uint32_t point) {
  const Places& at = c->place;
  const trace::World& w = *h.group->world().world;
  Where k;
  k.quad = geometry::Mesh::kNoQuad;
  k.mesh = &w.mesh(at.geometry[point]);
  k.info = &h.group->world().geometries[at.geometry[point]];
  k.primitive = at.primitive[point];
  k.face = k.mesh->faceOf(k.primitive);
  const trace::Instance& inst = w.instance(at.instance[point]);
  k.placement = &h.group->world().placements[inst.user];
  k.identity = inst.baked;
  k.time = std::clamp(c->time[point], 0.f, 1.f);
  if (!k.identity) k.toRender = w.objectToRender(at.instance[point], c->time[point]);
  k.strand = w.hasStrands() && k.mesh->isStrand();
  if (k.strand) {
    const float P[3] = {c->P[0][point], c->P[1][point], c->P[2][point]};
    const float wo[3] = {c->wo[0][point], c->wo[1][point], c->wo[2][point]};
    placeOnStrand(k, at.u[point], P, wo);
    k.b[0] = 1;
    k.b[1] = k.b[2] = 0;
    return k;
  }
  k.b[1] = at.u[point];
  k.b[2] = at.v[point];
  k.b[0] = 1.f - k.b[1] - k.b[2];
  if (h.hasQuads) {
    if (!h.quadPlaces[0]) h.findQuadPlaces(c);
    if (h.quadPlaces[0][point] >= 0) {
      k.quad = k.mesh->quadOf(k.primitive);
      for (int i = 0; i < 2; ++i) k.uv[i] = h.quadPlaces[i][point];
      for (int i = 0; i < 4; ++i) k.v[i] = k.mesh->indices[geometry::Mesh::quadCorner(k.quad, i)];
      return k;
    }
  }
  for (int i = 0; i < 3; ++i) k.v[i] = k.mesh->indices[3 * size_t(k.primitive) + i];
  return k;
}
inline bool isOnQuad(const Where& k) { return k.quad != geometry::Mesh::kNoQuad; }

inline float mix(const Where& k, float a, float b, float c) { return k.b[0] * a + k.b[1] * b + k.b[2] * c; }

// Bilinear over the quad, of values at its corners: (0,0), (1,0), (1,1), (0,1).
inline float acrossQuad(const Where& k, const float c[4]) {
  const float u = k.uv[0], v = k.uv[1];
  return (1.f - v) * ((1.f - u) * c[0] + u * c[1]) + v * ((1.f - u) * c[3] + u * c[2]);
}
inline void slopesOfQuad(const Where& k, const float c[4], float& du, float& dv) {
  const float u = k.uv[0], v = k.uv[1];
  du = (1.f - v) * (c[1] - c[0]) + v * (c[2] - c[3]);
  dv = (1.f - u) * (c[3] - c[0]) + u * (c[2] - c[1]);
}
// From values at the corners.
inline void slopeOverQuad(const Where& k, const float c[4], Sloped& out, uint32_t j) {
  out.value[j] = acrossQuad(k, c);
  slopesOfQuad(k, c, out.d1[j], out.d2[j]);
}
inline void slopeOverTriangle(const Where& k, float a, float b, float c, Sloped& out, uint32_t j) {
  out.value[j] = mix(k, a, b, c);
  out.d1[j] = b - a;
  out.d2[j] = c - a;
}

// A direction from object to render space.
inline void directionToRender(const Where& k, const float a[3], float out[3]) {
  if (k.identity) {
    std::memcpy(out, a, 12);
    return;
  }
  for (int i = 0; i < 3; ++i) {
    const float* m = k.toRender.m[i];
    out[i] = m[0] * a[0] + m[1] * a[1] + m[2] * a[2];
  }
}

// What slopes are taken along, in render space: from the first corner of the triangle to the others; one unit of u
// and of v on quads and strands.
inline void edges(const Where& k, float e1[3], float e2[3]) {
  if (k.strand) {
    std::memcpy(e1, k.on.du, 12);
    std::memcpy(e2, k.on.dv, 12);
    return;
  }
  const Imath::V3f* q = k.mesh->points.data();
  float f = 0;
  if (k.mesh->keyCount() > 1) {
    // keys of a deforming mesh are uniform over the shutter
    const float x = k.time * float(k.mesh->keyCount() - 1);
    const uint32_t key = std::min(uint32_t(x), uint32_t(k.mesh->keyCount() - 2));
    f = x - float(key);
    q += size_t(key) * k.mesh->vertexCount;
  }
  const auto corner = [&](int i) {
    const Imath::V3f p = q[k.v[i]];
    return f > 0 ? p + (q[k.mesh->vertexCount + k.v[i]] - p) * f : p;
  };
  const Imath::V3f p0 = corner(0), p1 = corner(1), p2 = corner(2);
  Imath::V3f a = p1 - p0, b = p2 - p0;
  if (isOnQuad(k)) {
    const Imath::V3f p3 = corner(3);
    b = (p3 - p0) * (1.f - k.uv[0]) + (p2 - p1) * k.uv[0];
    a = a * (1.f - k.uv[1]) + (p2 - p3) * k.uv[1];
  }
  directionToRender(k, &a.x, e1);
  directionToRender(k, &b.x, e2);
}

inline Sloped patchUV(const Where& k) {
  Sloped out;
  if (k.strand) {
    for (int j = 0; j < 2; ++j) {
      out.value[j] = k.on.uv[j];
      out.d1[j] = float(j == 0);
      out.d2[j] = float(j == 1);
    }
    return out;
  }
  if (isOnQuad(k)) {
    float uv[2][4];
    for (int i = 0; i < 4; ++i) {
      // the fourth corner is the third of the second triangle
      const Imath::V2f p = k.mesh->uvOf(k.quad + uint32_t(i == 3), i == 3 ? 2 : i);
      uv[0][i] = p.x;
      uv[1][i] = p.y;
    }
    for (uint32_t j = 0; j < 2; ++j) slopeOverQuad(k, uv[j], out, j);
    return out;
  }
  const Imath::V2f a = k.mesh->uvOf(k.primitive, 0), b = k.mesh->uvOf(k.primitive, 1),
                   c = k.mesh->uvOf(k.primitive, 2);
  slopeOverTriangle(k, a.x, b.x, c.x, out, 0);
  slopeOverTriangle(k, a.y, b.y, c.y, out, 1);
  return out;
}

// The primvar of a mesh; null where it has none of that name, or one without values.
inline const geometry::Primvar* primvarOf(const geometry::Mesh& mesh, const char* name) {
  const geometry::Primvar* p = mesh.find(name);
  return p && !p->data.empty() && p->width >= 1 ? p : nullptr;
}

// A primvar's first `n` (at most 3) components; the primvar has as many.
inline Sloped valuesAt(const geometry::Primvar& p, const Where& k, uint32_t n) {
  using Rate = geometry::Primvar::Rate;
  Sloped out;
  const size_t width = size_t(p.width);
  const float* data = p.data.data();
  if (p.rate == Rate::Constant || p.rate == Rate::PerFace) {
    const float* v = data + (p.rate == Rate::Constant ? 0 : k.face * width);
    for (uint32_t j = 0; j < n; ++j) {
      out.value[j] = v[j];
      out.d1[j] = out.d2[j] = 0;
    }
    return out;
  }
  const bool perVertex = p.rate == Rate::PerVertex;
  if (k.strand) {
    for (uint32_t j = 0; j < n; ++j) {
      out.value[j] = out.d1[j] = out.d2[j] = 0;
      for (uint32_t i = 0; perVertex && i < k.on.controls; ++i) {
        const float x = data[k.v[i] * width + j];
        out.value[j] += k.on.weight[i] * x;
        out.d2[j] += k.on.slope[i] * x;
      }
    }
    return out;
  }
  if (isOnQuad(k)) {
    const float* v[4];
    for (int i = 0; i < 4; ++i)
      v[i] = data + (perVertex ? size_t(k.v[i]) : geometry::Mesh::quadCorner(k.quad, i)) * width;
    for (uint32_t j = 0; j < n; ++j) {
      const float c[4] = {v[0][j], v[1][j], v[2][j], v[3][j]};
      slopeOverQuad(k, c, out, j);
    }
    return out;
  }
  const size_t first = 3 * size_t(k.primitive);
  const float *v0 = data + (perVertex ? k.v[0] : first) * width,
              *v1 = data + (perVertex ? k.v[1] : first + 1) * width,
              *v2 = data + (perVertex ? k.v[2] : first + 2) * width;
  for (uint32_t j = 0; j < n; ++j) slopeOverTriangle(k, v0[j], v1[j], v2[j], out, j);
  return out;
}

// A primvar's value, or a difference of values, of three components: points, vectors and normals from object to
// render space, other types stay. Those of objects baked into render space are there already. (The points of a mesh
// are stored from its origin, primvars are not.)
inline void primvarToRender(const geometry::Primvar& p, const Where& k, float v[3], bool isDifference = false) {
  const bool isNormal = p.type == scene::ValueType::Normal,
             isPoint = p.type == scene::ValueType::Point && !isDifference;
  if (k.identity || !(isNormal || p.type == scene::ValueType::Point || p.type == scene::ValueType::Vector)) return;
  float q[3];
  if (isNormal) {
    const trace::Affine inv = k.toRender.inverse();
    for (int j = 0; j < 3; ++j) q[j] = inv.m[0][j] * v[0] + inv.m[1][j] * v[1] + inv.m[2][j] * v[2];
  } else {
    float f[3];
    for (int j = 0; j < 3; ++j) f[j] = isPoint ? v[j] - float(k.mesh->origin[j]) : v[j];
    for (int j = 0; j < 3; ++j)
      q[j] = k.toRender.m[j][0] * f[0] + k.toRender.m[j][1] * f[1] + k.toRender.m[j][2] * f[2] +
             (isPoint ? k.toRender.t[j] : 0.f);
  }
  std::memcpy(v, q, 12);
}
// The same to world space, as shaders have it.
inline void primvarToWorld(const geometry::Primvar& p, const Where& k, const double origin[3], float v[3]) {
  primvarToRender(p, k, v);
  for (int j = 0; p.type == scene::ValueType::Point && j < 3; ++j) v[j] += float(origin[j]);
}

// Texture coordinates: primvar st, else s and t, else the patch parameters.
inline Sloped textureCoordinates(const Where& k) {
  if (const geometry::Primvar* p = k.info->st) return valuesAt(*p, k, 2);
  if (const geometry::Primvar* s = k.info->s, *t = k.info->t; s && t) {
    Sloped out = valuesAt(*s, k, 1);
    const Sloped y = valuesAt(*t, k, 1);
    out.value[1] = y.value[0];
    out.d1[1] = y.d1[0];
    out.d2[1] = y.d2[0];
    return out;
  }
  return patchUV(k);
}

// Primvars that every object answers without having been given them: texture coordinates, Color and Opacity.
enum class Implied : uint8_t { None, St, S, T, Color, Opacity };
inline Implied impliedBy(const char* name) {
  if (!std::strcmp(name, "st")) return Implied::St;
  if (!std::strcmp(name, "s")) return Implied::S;
  if (!std::strcmp(name, "t")) return Implied::T;
  if (!std::strcmp(name, "Cs")) return Implied::Color;
  if (!std::strcmp(name, "Os")) return Implied::Opacity;
  return Implied::None;
}
inline uint32_t widthOf(Implied what) {
  return what == Implied::Color || what == Implied::Opacity ? 3
         : what == Implied::St                              ? 2
         : what == Implied::None                            ? 0
                                                            : 1;
}
// Whether an object has it by what it says: Color and Opacity are white where nothing is said.
inline bool saysImplied(Implied what, const Tint& tint) {
  return what == Implied::Color ? tint.hasColor : what == Implied::Opacity ? tint.hasOpacity : what != Implied::None;
}
inline Sloped impliedValue(Implied what, const Where& k, const Tint& tint) {
  Sloped out{};
  switch (what) {
    case Implied::None:
      break;
    case Implied::St:
    case Implied::S:
      return textureCoordinates(k);
    case Implied::T: {
      const Sloped st = textureCoordinates(k);
      out.value[0] = st.value[1];
      out.d1[0] = st.d1[1];
      out.d2[0] = st.d2[1];
      break;
    }
    case Implied::Color:
    case Implied::Opacity:
      std::copy_n((what == Implied::Color ? tint.color : tint.opacity).data(), 3, out.value);
      break;
  }
  return out;
}

// dP along the first and second of two parameters.
inline void derivatives(const float e1[3], const float e2[3], const Sloped& uv, float du[3], float dv[3]) {
  const float a = uv.d1[0], b = uv.d1[1], c = uv.d2[0], d = uv.d2[1];
  const float det = a * d - b * c;
  const float inv = std::fabs(det) > 1e-20f ? 1.f / det : 0.f;
  for (int i = 0; i < 3; ++i) {
    du[i] = inv ? (d * e1[i] - b * e2[i]) * inv : e1[i];
    dv[i] = inv ? (a * e2[i] - c * e1[i]) * inv : e2[i];
  }
}

// The gradient, in the plane of the edges, of what changes by f1 and f2 along them; 0 where they span no plane.
inline void gradientOf(const float e1[3], const float e2[3], float f1, float f2, float g[3]) {
  // of slivers the determinant is a small difference
  double a = 0, b = 0, c = 0;
  for (int i = 0; i < 3; ++i) {
    a += double(e1[i]) * e1[i];
    b += double(e1[i]) * e2[i];
    c += double(e2[i]) * e2[i];
  }
  const double det = a * c - b * b, inv = det > 1e-14 * a * c ? 1 / det : 0;
  for (int i = 0; i < 3; ++i) g[i] = float(((c * f1 - b * f2) * e1[i] + (a * f2 - b * f1) * e2[i]) * inv);
}

// Makes d perpendicular to the unit vector N; where nothing is left of it any direction across N will do. Returns its
// squared length.
inline float acrossNormal(const float N[3], float d[3]) {
  const float along = d[0] * N[0] + d[1] * N[1] + d[2] * N[2];
  float l2 = 0;
  for (int j = 0; j < 3; ++j) {
    d[j] -= along * N[j];
    l2 += d[j] * d[j];
  }
  if (l2 > 0) return l2;
  const int axis = std::fabs(N[0]) < 0.9f ? 0 : 1;
  float e[3] = {0, 0, 0};
  e[axis] = 1;
  l2 = 0;
  for (int j = 0; j < 3; ++j) {
    d[j] = e[j] - N[axis] * N[j];
    l2 += d[j] * d[j];
  }
  return l2;
}

// Footprint in units of two parameters: ratio of areas.
inline float scaleOf(const float e1[3], const float e2[3], const Sloped& st) {
  const float cx = e1[1] * e2[2] - e1[2] * e2[1], cy = e1[2] * e2[0] - e1[0] * e2[2],
              cz = e1[0] * e2[1] - e1[1] * e2[0];
  const float area = std::sqrt(cx * cx + cy * cy + cz * cz);
  return area > 0 ? std::sqrt(std::fabs(st.d1[0] * st.d2[1] - st.d1[1] * st.d2[0]) / area) : 0.f;
}

}  // namespace kinora::shade
