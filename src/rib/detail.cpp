// Levels of detail: Detail, DetailRange, RelativeDetail. They become attributes and an option; which level is drawn is
// known when the camera is (render/detail.h).
#include <algorithm>
#include <cfloat>
#include <cmath>

#include "rib/interpreter.h"

namespace kinora::rib {

namespace {

scene::Parameter floatsOf(const char* name, std::vector<float> values, const SourcePos& pos) {
  scene::Parameter p;
  p.name = name;
  p.isArray = true;
  p.arrayLength = int(values.size());
  p.floats = std::move(values);
  p.pos = pos;
  return p;
}

}  // namespace

// The box's corners in the space of the world or of the object.
void Interpreter::detail(Request& r) {
  Cursor c(r);
  double bound[6];
  if (!numbers(c, 6, bound, "a bound")) return;
  const scene::Matrix m = state_.ctm.at(0);
  std::vector<float> corners;
  for (int i = 0; i < 8; ++i) {
    const Imath::V3d p = Imath::V3d(bound[i & 1], bound[2 + (i >> 1 & 1)], bound[4 + (i >> 2)]) * m;
    for (int k = 0; k < 3; ++k) corners.push_back(float(p[k]));
  }
  edit().named.set(floatsOf("detail:corners", std::move(corners), r.pos));
}

void Interpreter::detailRange(Request& r) {
  Cursor c(r);
  double v[4];
  if (!c.numbers(4, v)) return badArguments(r, "four numbers that do not fall");
  for (int k = 0; k < 4; ++k)
    if (std::isnan(v[k]) || (k > 0 && v[k] < v[k - 1])) return badArguments(r, "four numbers that do not fall");
  std::vector<float> range;
  for (const double x : v) range.push_back(float(std::clamp(x, -double(FLT_MAX), double(FLT_MAX))));
  edit().named.set(floatsOf("detail:range", std::move(range), r.pos));
}

void Interpreter::relativeDetail(Request& r) {
  Cursor c(r);
  double v;
  if (!optionsAllowed(r) || !numbers(c, 1, &v, "a factor")) return;
  if (!(v >= 0)) return badArguments(r, "a factor of at least 0");
  scene::Parameter p;
  p.name = "detail:relative";
  p.floats = {float(v)};
  p.pos = r.pos;
  frame_.options.options.set(std::move(p));
}

}  // namespace kinora::rib
