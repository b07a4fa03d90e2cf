// Kernels of grid_lookups.h.
#define KINORA_KERNEL_FILE "volume/grid_lookups.cpp"
#include "volume/grid_lookups.h"

#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include <kinora/simd/wide.h>
#include <kinora/simd/records.h>

KINORA_KERNELS_BEGIN

using volume::GridLookupArgs;

// Of a voxel's number along an axis, the part within its brick, and the last one of a brick.
constexpr int32_t kInside = 7;
// In a brick, from a voxel to its neighbours along y, z and both: the rows of a cell, each two voxels long.
constexpr size_t kRow[4] = {0, 8, 64, 72};
constexpr size_t kReach = 74;  // voxels from a cell's first to behind its last

// The voxels of a cell some of which lie in other bricks, or nowhere.
template <int C>
KN_INLINE void findCorners(const GridLookupArgs& a, const int32_t low[3], const float* corners[8]) {
  static constexpr float kNothing[C] = {};
  const volume::GridFrame& f = *a.frame;
  for (uint32_t corner = 0; corner < 8; ++corner) {
    corners[corner] = kNothing;
    const int32_t at[3] = {low[0] + int32_t(corner & 1), low[1] + int32_t(corner >> 1 & 1),
                           low[2] + int32_t(corner >> 2)};
    if (uint32_t(at[0]) >= uint32_t(f.size[0]) || uint32_t(at[1]) >= uint32_t(f.size[1]) ||
        uint32_t(at[2]) >= uint32_t(f.size[2]))
      continue;
    const float* const brick = a.bricks[f.brickOf(at)];
    if (!brick) continue;
    a.store->use(brick);
    corners[corner] = brick + f.inBrick(at) * C;
    __builtin_prefetch(corners[corner]);
  }
}

// Places of one block: memory is asked for the voxels of all of them before those of the first are read.
constexpr uint32_t kBlock = 64;
struct Block {
  alignas(64) float t[3][kBlock];      // between the cell's voxels
  alignas(64) int32_t low[3][kBlock];  // the cell's first one, counted from that of the box
  alignas(64) int32_t brick[kBlock], first[kBlock];
  const float* from[kBlock];        // the cell as it lies in its brick; null: in several
  const float* corners[kBlock][8];  // of those
  uint64_t isSomewhere, isInOne;    // bits
};

// Which cells places lie in.
template <int W, int C>
KN_INLINE void findCells(const GridLookupArgs& a, uint32_t begin, uint32_t n, Block& block) {
  using F = Float<W>;
  using I = Int<W>;
  const volume::GridFrame& f = *a.frame;
  block.isSomewhere = block.isInOne = 0;
  for (uint32_t i = 0; i < n; i += W) {
    const F p[3] = {F::load(a.P[0] + begin + i) - F(f.middle[0]), F::load(a.P[1] + begin + i) - F(f.middle[1]),
                    F::load(a.P[2] + begin + i) - F(f.middle[2])};
    Mask<W> isSomewhere(true), isInOne(true);
    I within[3], of[3];
    for (int k = 0; k < 3; ++k) {
      const float* m = f.toVoxels[k];
      F x = fma(p[0], F(m[0]), fma(p[1], F(m[1]), fma(p[2], F(m[2]), F(f.first[k]))));
      // what is not a number is nowhere, as what is too far to be one of a voxel
      Mask<W> is = abs(x) < F(1e15f);
      if (a.isClamped)
        x = clamp(x, F(0.f), F(float(f.size[k] - 1)));
      else
        is &= (x > F(-1.f)) & (x < F(float(f.size[k])));
      isSomewhere &= is;
      x = zeroUnless(is, x);
      const F whole = floor(x);
      (x - whole).store(block.t[k] + i);
      const I at = toInt(whole), inBox = at + I(f.offset[k]);
      at.store(block.low[k] + i);
      within[k] = inBox & I(kInside);
      of[k] = inBox.template sar<3>();
      isInOne &= (at >= I(0)) & (at + I(1) < I(f.size[k])) & (within[k] != I(kInside));
    }
    (of[0] + of[1] * I(f.stride[0]) + of[2] * I(f.stride[1])).store(block.brick + i);
    ((within[0] + within[1].template shl<3>() + within[2].template shl<6>()) * I(C)).store(block.first + i);
    block.isSomewhere |= uint64_t(isSomewhere.bits()) << i;
    block.isInOne |= uint64_t((isInOne & isSomewhere).bits()) << i;
  }
}

template <int W, int C>
KN_INLINE void lookUp(const GridLookupArgs& a) {
  using F = Float<W>;
  alignas(64) static constexpr float kNothing[kReach * 3] = {};
  alignas(64) float cells[W][kReach * C];  // of the lanes that need one
  Block block;
  for (uint32_t begin = 0; begin < a.n; begin += kBlock) {
    const uint32_t n = a.n - begin < kBlock ? (a.n - begin + W - 1) / W * W : kBlock;
    findCells<W, C>(a, begin, n, block);
    for (uint64_t bits = block.isInOne; bits; bits &= bits - 1)
      __builtin_prefetch(a.bricks + block.brick[__builtin_ctzll(bits)]);
    for (uint32_t i = 0; i < n; ++i) block.from[i] = kNothing;
    for (uint64_t bits = block.isInOne; bits; bits &= bits - 1) {
      const auto i = uint32_t(__builtin_ctzll(bits));
      const float* const brick = a.bricks[block.brick[i]];
      if (!brick) continue;
      a.store->use(brick);
      block.from[i] = brick + block.first[i];
      for (const size_t row : kRow) __builtin_prefetch(block.from[i] + row * C);
    }
    for (uint64_t bits = block.isSomewhere & ~block.isInOne; bits; bits &= bits - 1) {
      const auto i = uint32_t(__builtin_ctzll(bits));
      const int32_t low[3] = {block.low[0][i], block.low[1][i], block.low[2][i]};
      block.from[i] = nullptr;
      findCorners<C>(a, low, block.corners[i]);
    }
    for (uint32_t i = 0; i < n; i += W) {
      const float* from[W];
      for (uint32_t lane = 0; lane < W; ++lane) {
        from[lane] = block.from[i + lane];
        if (from[lane]) continue;
        // put together as if it lay in one
        for (size_t corner = 0; corner < 8; ++corner)
          for (size_t c = 0; c < C; ++c)
            cells[lane][(kRow[corner >> 1] + (corner & 1)) * C + c] = block.corners[i + lane][corner][c];
        from[lane] = cells[lane];
      }
      const F t[3] = {F::load(block.t[0] + i), F::load(block.t[1] + i), F::load(block.t[2] + i)};
      F along[4][C];  // of each row, by channel
      for (size_t row = 0; row < 4; ++row) {
        const float* at[W];
        for (int lane = 0; lane < W; ++lane) at[lane] = from[lane] + kRow[row] * C;
        F v[2 * C];  // the two voxels' numbers side by side
        for (size_t k = 0; k < C; ++k) {
          loadPairs<W>(at, v + 2 * k);
          for (int lane = 0; lane < W; ++lane) at[lane] += 2;
        }
        for (size_t c = 0; c < C; ++c) along[row][c] = lerp(v[c], v[C + c], t[0]);
      }
      // of places that are nowhere the cell is nothing
      for (size_t c = 0; c < C; ++c)
        if (a.out[c])
          lerp(lerp(along[0][c], along[1][c], t[1]), lerp(along[2][c], along[3][c], t[1]), t[2])
              .store(a.out[c] + begin + i);
    }
  }
}

#define KN_X(W)                                                              \
  [[maybe_unused]] void one##W(const GridLookupArgs& a) { lookUp<W, 1>(a); } \
  [[maybe_unused]] void three##W(const GridLookupArgs& a) { lookUp<W, 3>(a); }
KN_EACH_WIDTH(KN_X)
#undef KN_X
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::volume {

GridLookupKernel gridLookupKernel(uint32_t width, int channels) {
  return channels == 3 ? KN_PICK_WIDTH(width, three) : KN_PICK_WIDTH(width, one);
}

}  // namespace kinora::volume
#endif
