#include "render/detail.h"

#include <algorithm>
#include <cmath>

namespace kinora::render {

bool hasDetail(const scene::Attributes* a) { return a && a->named.find("detail:range"); }

bool isDrawn(const scene::Attributes* a, const scene::Transform& toWorld, const View& view, double relative) {
  if (!hasDetail(a)) return true;
  const std::vector<float> range = a->named.getFloats("detail:range"), corners = a->named.getFloats("detail:corners");
  if (range.size() != 4) return true;
  double area = INFINITY;  // nothing is known of its size
  if (corners.size() == 24) {
    const scene::Matrix toCamera = toWorld.at(view.middle) * view.worldToCamera;
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    bool isInFront = true;
    for (size_t i = 0; i < 24; i += 3) {
      const Imath::V3d p = Imath::V3d(corners[i], corners[i + 1], corners[i + 2]) * toCamera;
      const double pixel = std::max(view.pixelSize, p.z * view.pixelAngle);
      isInFront &= pixel > 0 && (p.z > 0 || view.pixelAngle == 0);
      for (int k = 0; k < 2; ++k) {
        low[k] = std::min(low[k], p[k] / pixel);
        high[k] = std::max(high[k], p[k] / pixel);
      }
    }
    if (isInFront) area = (high[0] - low[0]) * (high[1] - low[1]) * relative;
  }
  if (std::isnan(area)) return true;
  // what has no end takes all that is larger
  const auto middle = [&](size_t first) { return 0.5 * (double(range[first]) + double(range[first + 1])); };
  const double most = middle(2);
  return area >= middle(0) && (area < most || most > 1e37);
}

}  // namespace kinora::render
