// Places on curves and points: parameters and their directions follow from the hit point and the control points,
// because a round strand's hit says only how far along a piece it is.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/one_lane.h"
#include "shade/surface_points.h"

namespace kinora::shade {

namespace {

constexpr float kPi = 3.14159265358979f;

struct V {
  float x, y, z;
  V operator+(const V& o) const { return {x + o.x, y + o.y, z + o.z}; }
  V operator-(const V& o) const { return {x - o.x, y - o.y, z - o.z}; }
  V operator*(float f) const { return {x * f, y * f, z * f}; }
};
float dot(const V& a, const V& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
V cross(const V& a, const V& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
// `other` where a has no direction
V unit(const V& a, const V& other) {
  const float l2 = dot(a, a);
  return l2 > 0 ? a * (1.f / std::sqrt(l2)) : other;
}
V leastAxis(const V& a) {
  const float x = std::fabs(a.x), y = std::fabs(a.y), z = std::fabs(a.z);
  return x <= y && x <= z ? V{1, 0, 0} : y <= z ? V{0, 1, 0} : V{0, 0, 1};
}

using KeyPair = geometry::Mesh::KeyPair;

void weights(int controls, float s, float w[4], float dw[4]) {
  if (controls == 4) {
    const float t = 1 - s;
    w[0] = t * t * t;
    w[1] = 3 * s * t * t;
    w[2] = 3 * s * s * t;
    w[3] = s * s * s;
    dw[0] = -3 * t * t;
    dw[1] = 3 * t * t - 6 * s * t;
    dw[2] = 6 * s * t - 3 * s * s;
    dw[3] = 3 * s * s;
  } else if (controls == 2) {
    w[0] = 1 - s;
    w[1] = s;
    dw[0] = -1;
    dw[1] = 1;
  } else {
    w[0] = 1;
    dw[0] = 0;
  }
}

V pointOf(const geometry::Mesh& m, const KeyPair& k, uint32_t v) {
  const Imath::V4f &a = m.spine[k.first + v], &b = m.spine[k.second + v];
  return {k.mix(a.x, b.x), k.mix(a.y, b.y), k.mix(a.z, b.z)};
}

// From the first to the last control point of the curve that a piece belongs to (of the piece where some are
// missing).
V chordOf(const geometry::Mesh& m, const KeyPair& keys, uint32_t piece) {
  const Imath::V2f range = m.along[piece];
  const float step = range.y - range.x;
  const uint32_t count = step > 0 ? uint32_t(1.f / step + 0.5f) : 1, number = uint32_t(range.x * float(count) + 0.5f);
  uint32_t first = piece, last = piece;
  if (number <= piece && piece - number + count <= m.indices.size() &&
      m.faceOfTriangle[piece - number] == m.faceOfTriangle[piece] &&
      m.faceOfTriangle[piece - number + count - 1] == m.faceOfTriangle[piece]) {
    first = piece - number;
    last = first + count - 1;
  }
  return pointOf(m, keys, m.indices[last] + uint32_t(m.controlsOfPiece()) - 1) - pointOf(m, keys, m.indices[first]);
}

}  // namespace

float strandRadius(const geometry::Mesh& mesh, uint32_t primitive, float s, float time) {
  const KeyPair keys = mesh.keysAt(time);
  const int n = mesh.controlsOfPiece();
  float w[4], dw[4], r = 0;
  weights(n, s, w, dw);
  for (int i = 0; i < n; ++i) {
    const size_t v = mesh.indices[primitive] + size_t(i);
    r += w[i] * keys.mix(mesh.spine[keys.first + v].w, mesh.spine[keys.second + v].w);
  }
  return r;
}

float radiusOfStrand(const trace::World& world, const Places& at, uint32_t point, float time) {
  const float radius = strandRadius(world.mesh(at.geometry[point]), at.primitive[point], at.u[point], time);
  if (world.instance(at.instance[point]).baked) return radius;
  const trace::Affine a = world.objectToRender(at.instance[point], time);
  return radius * std::sqrt(a.m[0][0] * a.m[0][0] + a.m[1][0] * a.m[1][0] + a.m[2][0] * a.m[2][0]);
}

StrandPlace placeOnStrand(const geometry::Mesh& m, uint32_t primitive, float s, float time, bool isBaked,
                          const trace::Affine& toRender, const float P[3], const float towards[3]) {
  StrandPlace on;
  const KeyPair keys = m.keysAt(time);
  const int n = m.controlsOfPiece();
  on.controls = uint32_t(n);
  float dw[4];
  weights(n, s, on.weight, dw);
  V centre{0, 0, 0}, tangent{0, 0, 0}, normal{0, 0, 0}, rest{0, 0, 0};
  for (int i = 0; i < n; ++i) {
    const uint32_t v = on.vertex[i] = m.indices[primitive] + uint32_t(i);
    const V p = pointOf(m, keys, v);
    centre = centre + p * on.weight[i];
    tangent = tangent + p * dw[i];
    const Imath::V4f& r = m.spine[v];
    rest = rest + V{r.x, r.y, r.z} * on.weight[i];
    if (m.isOriented()) {
      const Imath::V3f &a = m.spineNormals[keys.first + v], &b = m.spineNormals[keys.second + v];
      normal = normal + V{keys.mix(a.x, b.x), keys.mix(a.y, b.y), keys.mix(a.z, b.z)} * on.weight[i];
    }
  }
  const float radius = std::max(strandRadius(m, primitive, s, time), 1e-30f);
  // the hit and the way back in the strand's own space
  V hit{P[0], P[1], P[2]}, back{towards[0], towards[1], towards[2]};
  if (!isBaked) {
    const trace::Affine inverse = toRender.inverse();
    float p[3], d[3];
    inverse.point(P, p);
    for (int c = 0; c < 3; ++c)
      d[c] = inverse.m[c][0] * towards[0] + inverse.m[c][1] * towards[1] + inverse.m[c][2] * towards[2];
    hit = {p[0], p[1], p[2]};
    back = {d[0], d[1], d[2]};
  }
  const V off = hit - centre;
  V du, dv;
  if (m.isCurve()) {
    const Imath::V2f range = m.along[primitive];
    const float perV = 1.f / (range.y - range.x);
    for (int i = 0; i < n; ++i) on.slope[i] = dw[i] * perV;
    dv = tangent * perV;
    on.uv[1] = range.x + s * (range.y - range.x);
    const V t = unit(tangent, {0, 0, 1});
    if (m.isTube()) {
      // the angle around the tube, from a direction that is the same for the whole curve
      const V axis = leastAxis(chordOf(m, keys, primitive));
      const V x = unit(axis - t * dot(axis, t), leastAxis(t)), y = cross(t, x);
      const float angle = oneLane::atan2(dot(off, y), dot(off, x)) / (2 * kPi);
      on.uv[0] = angle < 0 ? angle + 1 : angle;
      du = unit(cross(t, off), x) * (2 * kPi * radius);
    } else {
      const V across = unit(cross(m.isOriented() ? normal : back, t), cross(leastAxis(t), t));
      on.uv[0] = std::clamp(0.5f + 0.5f * dot(off, across) / radius, 0.f, 1.f);
      du = across * (2 * radius);
    }
  } else {
    on.slope[0] = 0;
    if (m.kind == geometry::Mesh::Kind::Ball) {
      // longitude and latitude about z, as on a Sphere
      const V d = unit(off, {0, 0, 1});
      const float angle = oneLane::atan2(d.y, d.x) / (2 * kPi);
      on.uv[0] = angle < 0 ? angle + 1 : angle;
      on.uv[1] = 0.5f + oneLane::asin(std::clamp(d.z, -1.f, 1.f)) / kPi;
      const float ring = std::sqrt(std::max(d.x * d.x + d.y * d.y, 1e-12f));
      du = V{-d.y, d.x, 0} * (2 * kPi * radius);
      dv = V{-d.x * d.z / ring, -d.y * d.z / ring, ring} * (kPi * radius);
      if (!(dot(du, du) > 0)) du = V{0, 1e-6f * radius, 0};
    } else {
      const V face = unit(m.isOriented() ? normal : back, {0, 0, 1}), axis = leastAxis(face);
      const V x = unit(axis - face * dot(axis, face), {1, 0, 0}), y = cross(face, x);
      on.uv[0] = 0.5f + 0.5f * dot(off, x) / radius;
      on.uv[1] = 0.5f + 0.5f * dot(off, y) / radius;
      du = x * (2 * radius);
      dv = y * (2 * radius);
    }
  }
  rest = rest + off;
  on.rest[0] = rest.x + float(m.origin.x);
  on.rest[1] = rest.y + float(m.origin.y);
  on.rest[2] = rest.z + float(m.origin.z);
  const auto turn = [&](const V& a, float out[3]) {
    if (isBaked) {
      out[0] = a.x;
      out[1] = a.y;
      out[2] = a.z;
      return;
    }
    for (int c = 0; c < 3; ++c) out[c] = toRender.m[c][0] * a.x + toRender.m[c][1] * a.y + toRender.m[c][2] * a.z;
  };
  turn(du, on.du);
  turn(dv, on.dv);
  return on;
}

}  // namespace kinora::shade
