// One bxdf at one parameter setting, as the two halves of the bxdf checks share it. Not installed.
#pragma once
#include <kinora/testing/bxdf_checks.h>
#include <kinora/testing/statistics.h>

#include <vector>

#include "testing/bound_bxdf.h"
#include "testing/judge.h"

namespace kinora::testing {

struct BxdfCase {
  const Descriptor& bxdf;
  const BxdfTraits& traits;
  const Setting& setting;
  std::vector<const WidthTable*> tables;  // those this CPU runs; not empty
  bool encloses = false;                  // wi and wo may lie in different media
  bool fillsSpace = false;                // a phase function: no cosines
  bool reciprocal = true;
  bool isFiber = false;  // may answer with its adjoint for importance
  bool bumped = false;   // the cosine is not that of the context's normal
  const WidthTable& widest() const { return *tables.back(); }
};

// Where a bxdf is looked at: normal of the test, and wo at a cosine to it.
inline const Vec3 kTestNormal = normalized({0.36f, -0.48f, 0.8f});
inline Vec3 directionAbout(Vec3 n, double cosine, double phi) {
  const Vec3 t = normalized(cross(std::abs(n.x) < 0.7f ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, n)), b = cross(n, t);
  const double s = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  return normalized(t * float(s * std::cos(phi)) + b * float(s * std::sin(phi)) + n * float(cosine));
}
inline Vec3 uniformDirection(Random& r) {
  return directionAbout({0, 0, 1}, 2 * r.uniform() - 1, 6.283185307179586 * r.uniform());
}

// Exact and bounded comparisons at single points.
void checkBxdfPoints(Judge& judge, const BxdfCase& c, uint64_t seed);

// Chi-square, integrals and albedo for one outgoing direction.
struct StatisticsPlan {
  double cosine = 0.7;
  bool outside = true;
  uint32_t samples = 1u << 16;
  bool precise = false;  // sample on until the albedo's error is small enough to show 0.3 %
  bool lossless = false, conserving = false;
};
void checkBxdfStatistics(Judge& judge, const BxdfCase& c, const StatisticsPlan& plan, uint64_t seed);

}  // namespace kinora::testing
