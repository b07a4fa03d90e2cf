// The voxels of one grid: bricks of 8 x 8 x 8 in a table over the grid's box, and lookups between them. Made by
// receiveGrid() of what another process read; read by shade/ on any thread. Voxel centres lie at whole index
// positions; what no brick holds is 0. A lookup is a function of position and options alone, the same bits wherever
// it is asked. Coarser levels are grids of their own, each voxel the mean of two along each axis of the finer one.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "base/memory.h"
#include "volume/grid_lookups.h"

namespace kinora::volume {

enum class VoxelWrap : uint8_t { Black, Clamp, Periodic, Mirror };

struct VoxelLookup {
  VoxelWrap wrap[3] = {VoxelWrap::Black, VoxelWrap::Black, VoxelWrap::Black};
  bool isClosest = false;
  // Sides of the box around the position over which the grid is averaged, in voxels. Two places along each side
  // longer than a voxel stand for it.
  float size[3] = {0, 0, 0};
};

// What a grid is, apart from its voxels.
struct GridShape {
  int32_t subimage = 0;          // its number in the file
  int32_t channels = 1;          // 1 or 3
  int32_t first[3] = {};         // index of the first voxel of the box
  int32_t size[3] = {};          // voxels of the box
  double worldToIndex[16] = {};  // for row vectors, affine

  static constexpr int32_t kSide = 8, kVoxels = kSide * kSide * kSide;
  // Bricks begin at multiples of 8.
  int32_t firstBrick(int axis) const { return first[axis] >> 3; }
  int32_t bricks(int axis) const { return ((first[axis] + size[axis] - 1) >> 3) - firstBrick(axis) + 1; }
  uint64_t brickCount() const { return uint64_t(bricks(0)) * uint64_t(bricks(1)) * uint64_t(bricks(2)); }
  // "" or what is not believed of it. Sizes are bounded here: a table of 16 million bricks takes 128 MiB.
  const char* disbelief() const;
};

class VoxelGrid {
 public:
  // Throws MemoryExceeded or bad_alloc. The shape is one without disbelief(). store: of its bricks; null: its own, all
  // of it in memory.
  explicit VoxelGrid(const GridShape& shape, std::shared_ptr<VoxelStore> store = nullptr)
      : VoxelGrid(shape, std::move(store), 0) {}
  const GridShape& shape() const { return shape_; }
  // Wherever bricks lie, and of coarser levels too.
  uint64_t bytes() const { return memory_.bytes() + brickBytes_ + (coarser_ ? coarser_->bytes() : 0); }
  // Room for the brick of that number (x fastest), to be filled by the caller: channels of a voxel side by side,
  // voxels x fastest. Throws as the constructor does.
  float* addBrick(uint64_t number);
  // A brick of one value; those of a value in a row share memory.
  void addConstantBrick(uint64_t number, const float* value);

  // Makes what can be made of coarser levels of the bricks with numbers below that, all of which have been filled. In
  // order of numbers, up to brickCount() for all of them. Throws as the constructor does.
  void coarsen(uint64_t below);
  // The finest, which is the grid itself, and those that coarsen() has made.
  uint32_t levels() const { return coarser_ ? coarser_->levels() + 1 : 1; }
  // The coarsest there is from `levels` on.
  const VoxelGrid& level(uint32_t n) const { return n && coarser_ ? coarser_->level(n - 1) : *this; }

  void toIndex(const float world[3], double index[3]) const;
  // Lengths of a step of world space along the axes of the grid, in voxels.
  void stepToIndex(const float world[3], double index[3]) const;
  // channels numbers.
  void lookUp(const double index[3], const VoxelLookup& how, float* out) const;
  // The same at n places of world space by kernels of that width, without footprints and with one wrap for all axes:
  // Clamp or else Black. Arrays have padded(n) elements; out: by channel, null: not wanted. Bits are those of any width.
  void lookUp(uint32_t width, uint32_t n, const float* const world[3], VoxelWrap wrap, float* const out[3]) const;
  // The least and the largest number that lookups between two corners of index space may give, by channel (size[] of
  // `how` aside). Low corners are not above high ones.
  void extremes(const double low[3], const double high[3], const VoxelLookup& how, float* least, float* most) const;

 private:
  VoxelGrid(const GridShape& shape, std::shared_ptr<VoxelStore> store, uint32_t level);
  void setFrame();
  void coarsenLayer(int32_t z);
  bool averageBricks(const int32_t at[3], float* out) const;
  const float* voxel(const int32_t at[3]) const;
  void sample(const double place[3], const VoxelLookup& how, float* out) const;

  GridShape shape_;
  GridFrame frame_{};
  std::vector<const float*> table_;
  std::shared_ptr<VoxelStore> store_;
  float* slab_ = nullptr;  // of kSlab bricks, the one that is being filled
  uint32_t usedOfSlab_ = 0;
  uint64_t brickBytes_ = 0;
  const float* lastConstant_ = nullptr;
  uint32_t level_ = 0;
  std::unique_ptr<VoxelGrid> coarser_;
  int32_t coarsened_ = 0;  // layers of the coarser level that have been made
  MemoryHold memory_{MemoryUse::Textures};
};

}  // namespace kinora::volume
