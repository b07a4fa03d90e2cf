// Lookups of many places at once in one grid, trilinear between the centres of voxels, by SIMD kernels: what tracking
// asks of media. Called by MediumField; grids with wraps, closest voxels and footprints, as shaders want them, are
// VoxelGrid::lookUp()'s. A place has the same bits at all widths, alone or in company.
#pragma once
#include <cstdint>

#include "volume/voxel_store.h"

namespace kinora::volume {

// Where the voxels of a grid lie, in numbers that kernels take. Places are counted from a point in the middle of the
// box first, so that a grid far from the origin of its space has the precision of one around it.
struct GridFrame {
  float middle[3];             // of object space
  float first[3];              // that point, in voxels from the first one's centre
  float toVoxels[3][3];        // [k]: voxels along axis k for a step along each axis of object space
  int32_t size[3], offset[3];  // voxels; of the box's first voxel in its brick
  int32_t stride[2];           // of the table of bricks

  // Of a brick, in the table; columns, rows and layers count from the box's first.
  int32_t numberOf(int32_t x, int32_t y, int32_t z) const { return x + y * stride[0] + z * stride[1]; }
  // The brick that a voxel lies in and its number there. `at` counts from the box's first voxel and lies in the box.
  int32_t brickOf(const int32_t at[3]) const {
    return numberOf((at[0] + offset[0]) >> 3, (at[1] + offset[1]) >> 3, (at[2] + offset[2]) >> 3);
  }
  int32_t inBrick(const int32_t at[3]) const {
    return ((at[0] + offset[0]) & 7) + ((at[1] + offset[1]) & 7) * 8 + ((at[2] + offset[2]) & 7) * 64;
  }
};

struct GridLookupArgs {
  const GridFrame* frame;
  const float* const* bricks;  // null: zeros
  VoxelStore* store;           // theirs
  bool isClamped;              // beyond the box its outermost voxels go on; else there is nothing
  uint32_t n;                  // places; arrays have padded(n) elements
  const float* P[3];           // object space
  float* out[3];               // by channel of the grid; null: not wanted
};
using GridLookupKernel = void (*)(const GridLookupArgs&);
GridLookupKernel gridLookupKernel(uint32_t width, int channels);  // 1 or 3 channels

}  // namespace kinora::volume
