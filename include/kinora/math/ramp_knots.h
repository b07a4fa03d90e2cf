// A spline of colours through knots. Two neighbouring knots make a piece; repeated knots at the ends, as exporters
// write them, are the outer control points of the cubic splines. Plain; ramp.h evaluates it.
#pragma once
#include <cstring>

namespace kinora {
enum class RampCurve { Constant, Linear, Bspline, CatmullRom };

// By the name that scenes have for it.
inline RampCurve rampCurveOf(const char* name, RampCurve otherwise) {
  if (!std::strcmp(name, "constant")) return RampCurve::Constant;
  if (!std::strcmp(name, "linear")) return RampCurve::Linear;
  if (!std::strcmp(name, "bspline")) return RampCurve::Bspline;
  if (!std::strcmp(name, "catmull-rom")) return RampCurve::CatmullRom;
  return otherwise;
}

// Knots ascend. The arrays belong to whoever made them.
struct RampKnots {
  const float* knots = nullptr;
  const float* rgb[3] = {nullptr, nullptr, nullptr};
  int count = 0;
  RampCurve curve = RampCurve::CatmullRom;
};
}  // namespace kinora
