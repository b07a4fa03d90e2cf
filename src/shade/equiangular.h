// Distances along a ray by the angle at which a point beside it sees them: equiangular sampling (Kulla and Fajardo,
// "Importance Sampling Techniques for Path Tracing in Participating Media", EGSR 2012). Scalar; our own functions, so
// that the bits are those of every C library.
#pragma once
#include <limits>

namespace kinora::shade {

// A point as a ray sees it: where along the ray it is nearest, and how far away there (above 0). Of points at infinity
// the distance is infinite, and lengths stand for angles.
struct EquiangularPoint {
  float nearest, distance;
};
inline constexpr EquiangularPoint kPointAtInfinity{0, std::numeric_limits<float>::infinity()};
// o, d: the ray (unit); p: the point.
EquiangularPoint seenFrom(const float o[3], const float d[3], const float p[3]);
float angleAt(const EquiangularPoint& p, float t);
float distanceAt(const EquiangularPoint& p, float angle);
// d angle / d t.
inline float angleDensity(const EquiangularPoint& p, float t) {
  if (p.distance == kPointAtInfinity.distance) return 1;
  const float x = t - p.nearest;
  return p.distance / (x * x + p.distance * p.distance);
}

}  // namespace kinora::shade
