// The bases of the language's splines: what a name means and the matrices (rows multiply four knots and give the
// coefficients of t^3, t^2, t, 1). Plain, for the compiler and the kernels of spline.h.
#pragma once
#include <string_view>

namespace kinora::language {

enum class SplineBasis : int { CatmullRom, Bezier, BSpline, Hermite, Linear, Constant };
// An unknown name means linear, as in the reference.
constexpr SplineBasis splineBasis(std::string_view name) {
  return name == "catmull-rom" ? SplineBasis::CatmullRom
         : name == "bezier"    ? SplineBasis::Bezier
         : name == "bspline"   ? SplineBasis::BSpline
         : name == "hermite"   ? SplineBasis::Hermite
         : name == "constant"  ? SplineBasis::Constant
                               : SplineBasis::Linear;
}
// How many knots a segment moves on.
constexpr int splineStep(SplineBasis b) { return b == SplineBasis::Bezier ? 3 : b == SplineBasis::Hermite ? 2 : 1; }
constexpr int splineSegments(SplineBasis b, int knots) {
  const int n = (knots - 4) / splineStep(b) + 1;
  return knots < 4 || n < 1 ? 1 : n;
}
inline constexpr float kSplineMatrix[6][16] = {
    {-0.5f, 1.5f, -1.5f, 0.5f, 1, -2.5f, 2, -0.5f, -0.5f, 0, 0.5f, 0, 0, 1, 0, 0},
    {-1, 3, -3, 1, 3, -6, 3, 0, -3, 3, 0, 0, 1, 0, 0, 0},
    {-1.f / 6, 3.f / 6, -3.f / 6, 1.f / 6, 3.f / 6, -1, 3.f / 6, 0, -3.f / 6, 0, 3.f / 6, 0, 1.f / 6, 4.f / 6,
     1.f / 6, 0},
    {2, 1, -2, 1, -3, -2, 3, -1, 0, 1, 0, 0, 1, 0, 0, 0},
    {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 1, 0, 0, 1, 0, 0},
    {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0}};

}  // namespace kinora::language
