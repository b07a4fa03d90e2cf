// How finely a curve or sweep is cut. Used by the makers of grids. Two measures: the sagitta (how far the chord
// leaves the arc) governs surfaces that carry exact normals; the edge length itself governs surfaces that will be
// displaced.
#pragma once
#include <ImathVec.h>
#include <algorithm>
#include <cmath>

namespace kinora::geometry {

// A full circle has at least this many segments where it is seen large: the outline of a sphere cut 160 x 80 then
// loses at most d^2/6 along the profile and d^2/8 around (d = 2 pi / 160), together 0.045 % of its area, from any
// side.
inline constexpr int kCircleSegments = 160;
// Sagitta allowed, in micropolygon edges: where a circle is large, and where it is so small that kCircleSegments
// would be wasted on it (radius under some 25 edges).
inline constexpr double kSagittaLarge = 0.05, kSagittaSmall = 0.005;

// Segments for an arc of `angle` radians and `radius`, with micropolygon edge `edge` (infinity: unknown, the plain
// minimum); `byLength` cuts to the edge length (displacement follows).
inline int arcSegments(double angle, double radius, double edge, bool byLength) {
  angle = std::abs(angle);
  radius = std::abs(radius);
  constexpr double kFull = 6.283185307179586;
  double step = kFull / kCircleSegments;
  if (std::isfinite(edge) && radius > 0) {
    const double edges = radius / edge;
    const double small = std::sqrt(8 * kSagittaSmall / edges), large = std::sqrt(8 * kSagittaLarge / edges);
    step = std::min(std::max(step, std::min(small, kFull / 24)), large);
    if (byLength) step = std::min(step, 1 / edges);
  }
  return int(std::clamp(std::ceil(angle / step - 1e-9), 1.0, 1e6));
}

// A full turn has so many segments on surfaces of unknown shape when no size on screen is known, and a segment may
// turn the normal by so much (radians; coarser shading shows).
inline constexpr double kSegmentsOfUnknown = 64, kTurnPerSegment = 0.35;

inline double turnBetween(const Imath::V3d& a, const Imath::V3d& b) {
  return std::atan2(a.cross(b).length(), a.dot(b));
}

// Segments for a piece of surface of this length over which the normal turns by `turn`. Never finer than the
// micropolygon edge: control cages say nothing about what lies below it.
inline double segmentsFor(double length, double turn, double edge, bool displaced) {
  if (!std::isfinite(edge)) return turn * kSegmentsOfUnknown / 6.283185307179586;
  if (displaced) return length / edge;
  if (!(turn > 1e-4) || !(length > 0)) return 1;
  const double bySagitta = turn / std::sqrt(8 * kSagittaLarge * edge * turn / length);
  return std::min(std::max(bySagitta, turn / kTurnPerSegment), length / edge);
}

// Inside a diced quad place and primvars are bilinear. `share` is by how much the middle of a piece of surface misses
// that before it is cut: the point as seen along the surface, in units of the piece, or a primvar in units of its
// range. The error falls with the square of the segments; what is left is a level of an eight-bit picture.
inline constexpr double kPlaceError = 1.0 / 256;
inline double segmentsForPlace(double share, double length, double edge) {
  if (!(share > kPlaceError)) return 1;
  const double wanted = std::sqrt(share / kPlaceError);
  return std::isfinite(edge) ? std::min(wanted, std::max(length / edge, 1.0)) : wanted;
}

// A patch that is seen smaller than two edges is cut where it would miss the outline by a third of a pixel,
// not for its normals: these are interpolated over what is hardly more than a pixel.
inline constexpr double kSmallEdges = 2, kSagittaOfSmall = 0.15;
inline bool isSmall(double length, double edge, bool displaced) {
  return !displaced && std::isfinite(edge) && length < kSmallEdges * edge;
}
inline double segmentsOfSmall(double length, double turn, double edge) {
  return std::sqrt(turn * length / (8 * kSagittaOfSmall * edge));
}

// Scales a grid down to at most `most` triangles.
inline void capGrid(int& nu, int& nv, double most) {
  const double triangles = 2.0 * nu * nv;
  if (triangles <= most) return;
  const double scale = std::sqrt(most / triangles);
  nu = std::max(1, int(nu * scale));
  nv = std::max(1, int(nv * scale));
}

}  // namespace kinora::geometry
