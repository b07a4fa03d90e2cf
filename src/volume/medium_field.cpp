#include "volume/medium_field.h"

#include <algorithm>
#include <cmath>

namespace kinora::volume {

MediumField::MediumField(const float bound[6], const int points[3], const float* values, int components) {
  GridShape shape;
  shape.channels = components;
  shape.worldToIndex[15] = 1;
  for (int k = 0; k < 3; ++k) {
    shape.size[k] = points[k];
    const double extent = double(bound[2 * k + 1]) - double(bound[2 * k]);
    const double scale = points[k] > 1 && extent > 0 ? double(points[k] - 1) / extent : 0;
    shape.worldToIndex[5 * k] = scale;
    shape.worldToIndex[12 + k] = -double(bound[2 * k]) * scale;
    how_.wrap[k] = VoxelWrap::Clamp;
  }
  own_ = std::make_shared<VoxelGrid>(shape);
  grid_ = own_.get();
  constexpr int kSide = GridShape::kSide;
  uint64_t number = 0;
  for (int z = 0; z < points[2]; z += kSide)
    for (int y = 0; y < points[1]; y += kSide)
      for (int x = 0; x < points[0]; x += kSide) {
        float* const brick = own_->addBrick(number++);
        std::fill_n(brick, GridShape::kVoxels * components, 0.f);
        for (int k = z; k < std::min(z + kSide, points[2]); ++k)
          for (int j = y; j < std::min(y + kSide, points[1]); ++j)
            for (int i = x; i < std::min(x + kSide, points[0]); ++i)
              for (int c = 0; c < components; ++c) {
                const float v = values[((size_t(k) * points[1] + j) * points[0] + i) * components + c];
                brick[((i - x) + (j - y) * 8 + (k - z) * 64) * components + c] = std::isfinite(v) ? v : 0.f;
              }
      }
}

MediumField::MediumField(const VolumeFunctions& functions, const VolumeTraits& traits, uint32_t field,
                         std::shared_ptr<const void> data)
    : plugin_{&functions, &traits, field, traits.fields[field].components == 3 ? 3 : 1, std::move(data)} {}

void MediumField::at(uint32_t width, uint32_t n, const float* const object[3], float* const out[3],
                     uint32_t level) const {
  if (plugin_.functions) {
    constexpr uint32_t kMost = 256;  // places that plug-ins are asked for at a time
    alignas(64) static constexpr float kNoTime[kMost] = {};
    for (uint32_t i = 0; i < n; i += kMost) {
      VolumeArgs args{
          std::min(n - i, kMost), {object[0] + i, object[1] + i, object[2] + i}, kNoTime, plugin_.field, {}};
      for (int k = 0; k < plugin_.components; ++k) args.value[k] = out[k] + i;
      plugin_.functions->evaluate(plugin_.data.get(), &args);
    }
    return;
  }
  float* const one[3] = {component_ == 0 ? out[0] : nullptr, component_ == 1 ? out[0] : nullptr,
                         component_ == 2 ? out[0] : nullptr};
  grid_->level(level).lookUp(width, n, object, how_.wrap[0], component_ < 0 ? out : one);
}

void MediumField::at(const float object[3], float* out, uint32_t level) const {
  alignas(64) float P[3][kPad], value[3][kPad];
  for (int k = 0; k < 3; ++k) std::fill_n(P[k], kPad, object[k]);
  const float* const places[3] = {P[0], P[1], P[2]};
  float* const values[3] = {value[0], value[1], value[2]};
  at(1, 1, places, values, level);
  for (int k = 0; k < components(); ++k) out[k] = value[k][0];
}

void MediumField::extremes(const float low[3], const float high[3], uint32_t level, float least[3],
                           float largest[3]) const {
  if (plugin_.functions) {
    const VolumeBound box{{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
    plugin_.traits->extremes(plugin_.data.get(), plugin_.field, &box, least, largest);
    return;
  }
  const VoxelGrid& grid = grid_->level(level);
  double from[3], to[3];
  for (int corner = 0; corner < 8; ++corner) {
    float p[3];
    for (int k = 0; k < 3; ++k) p[k] = corner >> k & 1 ? high[k] : low[k];
    double index[3];
    grid.toIndex(p, index);
    for (int k = 0; k < 3; ++k) {
      from[k] = corner ? std::min(from[k], index[k]) : index[k];
      to[k] = corner ? std::max(to[k], index[k]) : index[k];
    }
  }
  grid.extremes(from, to, how_, least, largest);
  if (component_ >= 0) {
    least[0] = least[component_];
    largest[0] = largest[component_];
  }
}

float MediumField::most(const float low[3], const float high[3], uint32_t level) const {
  float least[3] = {}, largest[3] = {};
  extremes(low, high, level, least, largest);
  return *std::max_element(largest, largest + components());
}

float MediumField::largest(int component, const float low[3], const float high[3]) const {
  float least[3] = {}, largest[3] = {};
  extremes(low, high, 0, least, largest);
  return std::max(std::fabs(least[component]), std::fabs(largest[component]));
}

float MediumField::voxelSize() const {
  if (plugin_.functions) return INFINITY;
  const double* m = grid_->shape().worldToIndex;
  const double volume = std::fabs(m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
                                  m[2] * (m[4] * m[9] - m[5] * m[8]));
  return volume > 0 ? float(1 / std::cbrt(volume)) : INFINITY;
}

}  // namespace kinora::volume
