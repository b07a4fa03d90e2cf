// A parallelogram that emits to one side: the unit square of the local XY plane, to the side of local +Z. What
// PxrRectLight and PxrPortalLight have in common when they are made.
#pragma once
#include <kinora/light_setup.h>

namespace kinora::lightParts {

// Below this solid angle (steradians) sampling goes by area: the angles carry errors of 1e-6 in all, so that the
// density by solid angle stays within 2e-5 above it, while the area density of so small a light hardly varies.
constexpr float kLeastSolidAngle = 0.05f;

struct Rectangle {
  LightCommon common;
  Shaping shaping;
  LightMap map;
  Float3 center, edgeX, edgeY;  // whole edges
  Float3 unitX, unitY, normal;  // unit; the three are orthogonal where isRectangle
  Float3 dualX, dualY;          // dot(hit - center, dual) = local x, y in [-.5, .5]
  float halfX = 0, halfY = 0;   // lengths of half the edges
  float area = 0;
  bool isRectangle = false, isBlack = true;
  Double3 corner[4], normal64;

  static double areaOf(const LocalFrame& frame) { return length(cross(frame.x, frame.y)); }

  // With `common` set. A placement without area leaves the light black, with a message.
  void place(const NamedValues& values, const LocalFrame& frame) {
    const Double3 across = cross(frame.x, frame.y);
    const double size = length(across), lx = length(frame.x), ly = length(frame.y);
    center = Float3(frame.origin);
    if (!(size > 1e-30) || !(size > 1e-7 * lx * ly)) {
      values.warn("LIGHT-DEGENERATE", "the light's transformation leaves it no area", "the light is black");
      return;
    }
    // the side of local +Z; where Z is lost in the plane, that of X cross Y
    normal64 = normalized(across) * (dot(across, frame.z) < 0 ? -1.0 : 1.0);
    normal = Float3(normal64);
    edgeX = Float3(frame.x);
    edgeY = Float3(frame.y);
    unitX = Float3(frame.x * (1 / lx));
    unitY = Float3(frame.y * (1 / ly));
    const Double3 n = across * (1 / size);
    dualX = Float3(cross(frame.y, n) * (1 / size));
    dualY = Float3(cross(n, frame.x) * (1 / size));
    halfX = float(lx / 2);
    halfY = float(ly / 2);
    area = float(size);
    isRectangle = std::fabs(dot(frame.x, frame.y)) <= 1e-6 * lx * ly;
    isBlack = common.isBlack();
    const double sx[4] = {-0.5, 0.5, 0.5, -0.5}, sy[4] = {-0.5, -0.5, 0.5, 0.5};
    for (int i = 0; i < 4; ++i) corner[i] = frame.origin + frame.x * sx[i] + frame.y * sy[i];
  }
};

inline LightDescription describe(const Rectangle& k) {
  double radius = 0;
  for (const Double3& c : k.corner)
    if (k.area > 0) radius = std::fmax(radius, length(c - Double3{k.center.x, k.center.y, k.center.z}));
  LightDescription d = describeSurfaceLight(k.common, k.shaping, k.isBlack, k.center, radius, k.area, k.map.mean);
  if (!(k.area > 0)) return d;
  describeEmission(d, k.shaping, k.normal64);
  LightBox box;
  for (const Double3& c : k.corner) box.add(c);
  box.describe(d);
  return d;
}

// Lambert's formula over the part of the parallelogram above the receiver's horizon, averaged over the channels; -1
// where a map or shaping makes the radiance vary.
inline double irradiance(const Rectangle& k, const double P[3], const double N[3]) {
  if (k.isBlack) return 0;
  if (k.map.valid() || k.shaping.focused || k.shaping.coned) return -1;
  const Double3 p{P[0], P[1], P[2]}, n = normalized({N[0], N[1], N[2]});
  if (dot(p - k.corner[0], k.normal64) <= 0) return 0;
  Double3 clipped[8];
  int count = 0;
  for (int i = 0; i < 4; ++i) {
    const Double3 a = k.corner[i] - p, b = k.corner[(i + 1) % 4] - p;
    const double ha = dot(a, n), hb = dot(b, n);
    if (ha >= 0) clipped[count++] = a;
    if ((ha < 0) != (hb < 0)) clipped[count++] = a + (b - a) * (ha / (ha - hb));
  }
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    const Double3 a = normalized(clipped[i]), b = normalized(clipped[(i + 1) % count]), c = cross(a, b);
    const double s = length(c);
    if (s > 1e-15) sum += std::atan2(s, dot(a, b)) * dot(c, n) / s;
  }
  const double mean = (double(k.common.radiance[0]) + k.common.radiance[1] + k.common.radiance[2]) / 3;
  return mean * std::fabs(sum) / 2;
}
}  // namespace kinora::lightParts
