// Where in its primitive a shading point lies, and values there: the one record behind patch parameters, texture
// coordinates, derivatives and primvars. A value is told as the three corners of a triangle around the point with
// weights b; a place on a strand (curve, point) gives corners one unit of u and of v away, and weights (1, 0, 0), so
// that who reads values and slopes need not know the kind. Internal to shade/, inlined into what runs for each point.
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
  uint32_t primitive, face, v[4];
  float b[3];
  trace::Affine toRender;
  float time;
  bool identity, strand;
  StrandPlace on;  // strands only
};

// `s` is the hit's parameter along a piece of curve, `towards` points to where the ray came from.
void placeOnStrand(Where& k, float s, const float P[3], const float towards[3]);
// Radius of the strand there, in its own space.
float strandRadius(const geometry::Mesh& mesh, uint32_t primitive, float s, float time);

inline Where whereOf(const ContextHost& h, const Context* c, uint32_t point) {
  const Group& g = h.group->group();
  const uint32_t s = h.slot[point];
  const trace::World& w = *h.group->world().world;
  Where k;
  k.mesh = &w.mesh(g.hits.geometry[s]);
  k.info = &h.group->world().geometries[g.hits.geometry[s]];
  k.primitive = g.hits.primitive[s];
  k.face = k.mesh->faceOf(k.primitive);
  const trace::Instance& inst = w.instance(g.hits.instance[s]);
  k.identity = inst.baked;
  k.time = std::clamp(c->time[point], 0.f, 1.f);
  if (!k.identity) k.toRender = w.objectToRender(g.hits.instance[s], c->time[point]);
  k.strand = w.hasStrands() && k.mesh->isStrand();
  if (k.strand) {
    const float P[3] = {c->P[0][point], c->P[1][point], c->P[2][point]};
    const float wo[3] = {c->wo[0][point], c->wo[1][point], c->wo[2][point]};
    placeOnStrand(k, g.hits.u[s], P, wo);
    k.b[0] = 1;
    k.b[1] = k.b[2] = 0;
    return k;
  }
  for (int i = 0; i < 3; ++i) k.v[i] = k.mesh->indices[3 * size_t(k.primitive) + i];
  k.b[1] = g.hits.u[s];
  k.b[2] = g.hits.v[s];
  k.b[0] = 1.f - k.b[1] - k.b[2];
  return k;
}

inline float mix(const Where& k, float a, float b, float c) { return k.b[0] * a + k.b[1] * b + k.b[2] * c; }

// From the first corner to the others, in render space.
inline void edges(const Where& k, float e1[3], float e2[3]) {
  if (k.strand) {
    std::memcpy(e1, k.on.du, 12);
    std::memcpy(e2, k.on.dv, 12);
    return;
  }
  const Imath::V3f *p0 = &k.mesh->points[k.v[0]], *p1 = &k.mesh->points[k.v[1]], *p2 = &k.mesh->points[k.v[2]];
  float a[3] = {p1->x - p0->x, p1->y - p0->y, p1->z - p0->z}, b[3] = {p2->x - p0->x, p2->y - p0->y, p2->z - p0->z};
  if (k.mesh->keyCount() > 1) {
    // keys of a deforming mesh are uniform over the shutter
    const float x = k.time * float(k.mesh->keyCount() - 1);
    const uint32_t key = std::min(uint32_t(x), uint32_t(k.mesh->keyCount() - 2));
    const float f = x - float(key);
    const Imath::V3f *q = k.mesh->points.data() + size_t(key) * k.mesh->vertexCount, *r = q + k.mesh->vertexCount;
    for (int i = 0; i < 3; ++i) {
      const float c0 = q[k.v[0]][i] + f * (r[k.v[0]][i] - q[k.v[0]][i]);
      a[i] = q[k.v[1]][i] + f * (r[k.v[1]][i] - q[k.v[1]][i]) - c0;
      b[i] = q[k.v[2]][i] + f * (r[k.v[2]][i] - q[k.v[2]][i]) - c0;
    }
  }
  if (k.identity) {
    std::memcpy(e1, a, 12);
    std::memcpy(e2, b, 12);
    return;
  }
  for (int i = 0; i < 3; ++i) {
    const float* m = k.toRender.m[i];
    e1[i] = m[0] * a[0] + m[1] * a[1] + m[2] * a[2];
    e2[i] = m[0] * b[0] + m[1] * b[1] + m[2] * b[2];
  }
}

inline void patchUV(const Where& k, float uv[3][2]) {
  if (k.strand) {
    for (int i = 0; i < 3; ++i) {
      uv[i][0] = k.on.uv[0] + float(i == 1);
      uv[i][1] = k.on.uv[1] + float(i == 2);
    }
    return;
  }
  for (int i = 0; i < 3; ++i) {
    const Imath::V2f p = k.mesh->uvOf(k.primitive, i);
    uv[i][0] = p.x;
    uv[i][1] = p.y;
  }
}

// A primvar's first `n` (at most 3) components at the corners; the primvar has as many.
inline void cornerValues(const geometry::Primvar& p, const Where& k, uint32_t n, float out[3][3]) {
  using Rate = geometry::Primvar::Rate;
  if (k.strand && p.rate == Rate::PerVertex) {
    for (uint32_t j = 0; j < n; ++j) {
      float value = 0, slope = 0;
      for (uint32_t i = 0; i < k.on.controls; ++i) {
        const float x = p.data[size_t(k.v[i]) * size_t(p.width) + j];
        value += k.on.weight[i] * x;
        slope += k.on.slope[i] * x;
      }
      out[0][j] = out[1][j] = value;
      out[2][j] = value + slope;
    }
    return;
  }
  for (int i = 0; i < 3; ++i) {
    const size_t at = p.rate == Rate::Constant    ? 0
                      : p.rate == Rate::PerFace   ? k.face
                      : p.rate == Rate::PerVertex ? k.v[i]
                                                  : 3 * size_t(k.primitive) + size_t(i);
    const float* v = p.data.data() + at * size_t(p.width);
    for (uint32_t j = 0; j < n; ++j) out[i][j] = v[j];
  }
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

// Texture coordinates of the corners: primvar st, else s and t, else the patch parameters.
inline void textureCoordinates(const Where& k, float st[3][2]) {
  float x[3][3], y[3][3];
  if (const geometry::Primvar* p = k.info->st) {
    cornerValues(*p, k, 2, x);
    for (int i = 0; i < 3; ++i) {
      st[i][0] = x[i][0];
      st[i][1] = x[i][1];
    }
    return;
  }
  if (const geometry::Primvar* s = k.info->s, *t = k.info->t; s && t) {
    cornerValues(*s, k, 1, x);
    cornerValues(*t, k, 1, y);
    for (int i = 0; i < 3; ++i) {
      st[i][0] = x[i][0];
      st[i][1] = y[i][0];
    }
    return;
  }
  patchUV(k, st);
}

// dP along the first and second of two parameters given at the corners.
inline void derivatives(const float e1[3], const float e2[3], const float uv[3][2], float du[3], float dv[3]) {
  const float a = uv[1][0] - uv[0][0], b = uv[1][1] - uv[0][1], c = uv[2][0] - uv[0][0], d = uv[2][1] - uv[0][1];
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

// Footprint in units of a parameter that changes by f1, f2 along the edges: ratio of areas.
inline float scaleOf(const float e1[3], const float e2[3], float f1x, float f1y, float f2x, float f2y) {
  const float cx = e1[1] * e2[2] - e1[2] * e2[1], cy = e1[2] * e2[0] - e1[0] * e2[2],
              cz = e1[0] * e2[1] - e1[1] * e2[0];
  const float area = std::sqrt(cx * cx + cy * cy + cz * cz);
  return area > 0 ? std::sqrt(std::fabs(f1x * f2y - f1y * f2x) / area) : 0.f;
}

}  // namespace kinora::shade
