// One number or colour of a medium over the object space of its primitive: a grid of a file, the voxels that a Volume
// request brings, or what a volume plug-in computes. Read by shade/ on any thread, made by render/; it knows no scene.
#pragma once
#include <kinora/volume.h>

#include <memory>
#include <utility>

#include "volume/voxel_grid.h"

namespace kinora::volume {

class MediumField {
 public:
  // A grid that outlives the field; `component`: of its numbers, -1: all of them. Outside of its box there is nothing.
  explicit MediumField(const VoxelGrid* grid, int component = -1) : grid_(grid), component_(component) {}
  // Values at the corners of nx * ny * nz points that divide a box of object space evenly, x fastest; `components` of
  // each, 1 or 3. One point along an axis holds for all of it. Throws as VoxelGrid does.
  MediumField(const float bound[6], const int points[3], const float* values, int components);

  // A field of a volume plug-in, whose data lives as long as the field does.
  MediumField(const VolumeFunctions& functions, const VolumeTraits& traits, uint32_t field,
              std::shared_ptr<const void> data);

  int components() const {
    return plugin_.functions ? plugin_.components : component_ < 0 ? grid_->shape().channels : 1;
  }
  // Of a grid from a file, the finest among them; else 1.
  uint32_t levels() const { return grid_ ? grid_->levels() : 1; }
  // components() numbers. level: the coarsest there is from levels() on.
  void at(const float object[3], float* out, uint32_t level = 0) const;
  // The same at n places by kernels of that width, bit for bit; arrays have padded(n) elements.
  void at(uint32_t width, uint32_t n, const float* const object[3], float* const out[3], uint32_t level = 0) const;
  // Within a box of object space: the largest that at() gives of any component.
  float most(const float low[3], const float high[3], uint32_t level = 0) const;
  // There, the largest absolute value of one component.
  float largest(int component, const float low[3], const float high[3]) const;
  // The side of a voxel of the finest level in object space, about.
  float voxelSize() const;

 private:
  // By component, as at() gives them.
  void extremes(const float low[3], const float high[3], uint32_t level, float least[3], float largest[3]) const;
  struct Plugin {
    const VolumeFunctions* functions = nullptr;  // null: there is a grid
    const VolumeTraits* traits = nullptr;
    uint32_t field = 0;
    int components = 1;
    std::shared_ptr<const void> data;
  };
  Plugin plugin_;
  std::shared_ptr<VoxelGrid> own_;
  const VoxelGrid* grid_ = nullptr;
  int component_ = -1;
  VoxelLookup how_;  // one wrap for all axes
};

}  // namespace kinora::volume
