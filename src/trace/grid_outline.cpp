#include "trace/grid_outline.h"

#include <algorithm>
#include <cmath>

namespace kinora::trace {

namespace {

constexpr float kParts = 255;

}  // namespace

void GridOutline::set(int eu, int ev, const Imath::V3f* points, const std::array<float, 6>& box, uint32_t keys) {
  const uint32_t nu = 1u << eu, nv = 1u << ev, stride = nu + 1;
  std::fill_n(all_, 3, INFINITY);
  std::fill_n(all_ + 3, 3, -INFINITY);
  for (uint32_t b = 0; b < kBoxes; ++b) {
    const uint32_t i0 = (b % 4) * nu / 4, i1 = (b % 4 + 1) * nu / 4, j0 = (b / 4) * nv / 4, j1 = (b / 4 + 1) * nv / 4;
    for (size_t k = 0; k < 3; ++k) {
      float lower = INFINITY, upper = -INFINITY;
      for (uint32_t key = 0; key < keys; ++key)
        for (uint32_t j = j0; j <= j1; ++j)
          for (uint32_t i = i0; i <= i1; ++i) {
            const float x = points[(size_t(key) * (nv + 1) + j) * stride + i][k];
            lower = std::min(lower, x);
            upper = std::max(upper, x);
          }
      all_[k] = std::min(all_[k], lower);
      all_[3 + k] = std::max(all_[3 + k], upper);
      const float size = box[3 + k] - box[k], scale = size > 0 ? kParts / size : 0;
      lower_[k][b] = uint8_t(std::clamp(std::floor((lower - box[k]) * scale), 0.f, kParts));
      upper_[k][b] = uint8_t(std::clamp(std::ceil((upper - box[k]) * scale), 0.f, kParts));
    }
  }
  largest_ = largestOf(all_);
}

bool GridOutline::mayMeet(const GridRay& ray) const { return meetsBox(ray, all_, 2 * slackOf(ray, largest_)); }

bool GridOutline::mayMeetFine(const std::array<float, 6>& box, const GridRay& ray) const {
  float near[kBoxes], far[kBoxes];
  std::fill_n(near, kBoxes, ray.tMin);
  std::fill_n(far, kBoxes, ray.tMax);
  const float slack = 2 * slackOf(ray, largestOf(box.data()));  // twice that of the tests of tessellations
  for (size_t k = 0; k < 3; ++k) {
    const float part = (box[3 + k] - box[k]) / kParts, from = box[k] - ray.o[k], inverse = ray.inverse[k];
    const float outward = std::copysign(slack, inverse);
    const uint8_t *first = inverse < 0 ? upper_[k] : lower_[k], *last = inverse < 0 ? lower_[k] : upper_[k];
    for (int b = 0; b < kBoxes; ++b) {
      const float enters = (from + part * float(first[b]) - outward) * inverse,
                  leaves = (from + part * float(last[b]) + outward) * inverse;
      near[b] = std::max(near[b], enters);
      far[b] = std::min(far[b], leaves * 1.000001f);
    }
  }
  bool any = false;
  for (int b = 0; b < kBoxes; ++b) any |= near[b] <= far[b];
  return any;
}

}  // namespace kinora::trace
