#include "render/shutter.h"

#include <algorithm>
#include <cmath>

namespace kinora::render {

namespace {

double bezier(double p1, double p2, double s) {
  const double t = 1 - s;
  return 3 * s * t * t * p1 + 3 * s * s * t * p2 + s * s * s;
}
// Height of the curve from (0, 0) over two control points to (1, 1) at x; x grows with s as the control points lie in
// the unit square.
double rise(const double p[4], double x) {
  double low = 0, high = 1;
  for (int i = 0; i < 50; ++i) {
    const double s = 0.5 * (low + high);
    (bezier(p[0], p[2], s) < x ? low : high) = s;
  }
  return bezier(p[1], p[3], 0.5 * (low + high));
}

}  // namespace

bool samplesMotion(const scene::NodePtr& hider) { return !hider || hider->params.getInt("samplemotion", 1) != 0; }

std::vector<float> shutterTimes(const scene::Camera& camera, const scene::NodePtr& hider, Diagnostics& diagnostics) {
  if (!samplesMotion(hider)) return {0, 0};
  double open = camera.params.getFloat("shutterOpenTime", 0), close = camera.params.getFloat("shutterCloseTime", 1);
  std::vector<float> given = camera.params.getFloats("shutteropening");
  if (given.empty() && hider) given = hider->params.getFloats("shutteropening");
  // control points relative to their rectangles; as they are here, both sides are straight
  double shape[8] = {0, 0, 0, 0, 1, 1, 1, 1};
  bool good = given.empty() || given.size() == 2 || given.size() == 8 || given.size() == 10;
  if (good && given.size() % 8 == 2) {  // the older forms begin with the two times, or are them
    open = given[0];
    close = given[1];
  }
  if (good && given.size() >= 8)
    for (size_t i = 0; i < 8; ++i) shape[i] = given[given.size() - 8 + i];
  for (const double x : shape) good &= x >= 0 && x <= 1;
  good &= open >= 0 && close <= 1 && open <= close;
  if (!good) {
    diagnostics.warning(
        "RENDER-SHUTTER", camera.pos,
        "the shutter's opening needs 0 <= shutterOpenTime <= shutterCloseTime <= 1 and 2, 8 or 10 numbers "
        "of 0 to 1 for shutteropening",
        "it opens and closes at once");
    return {};
  }
  if (open <= 0 && close >= 1) return {};
  constexpr int kFine = 8192, kTable = 1024;
  std::vector<double> sum(kFine + 1, 0.0);
  for (int i = 0; i < kFine; ++i) {
    const double t = (i + 0.5) / kFine;
    const double height = t < open    ? rise(shape, t / open)
                          : t > close ? 1 - rise(shape + 4, (t - close) / (1 - close))
                                      : 1;
    sum[size_t(i) + 1] = sum[size_t(i)] + std::max(0.0, height);
  }
  std::vector<float> out;
  size_t k = 0;
  for (int i = 0; i <= kTable; ++i) {
    const double want = sum.back() * i / kTable;
    while (k + 1 < size_t(kFine) && sum[k + 1] < want) ++k;
    const double step = sum[k + 1] - sum[k];
    out.push_back(float((double(k) + (step > 0 ? std::clamp((want - sum[k]) / step, 0.0, 1.0) : 0)) / kFine));
  }
  return out;
}

}  // namespace kinora::render
