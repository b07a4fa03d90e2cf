// Proves: lookups of a grid give the closed forms of a linear field and of single voxels, at voxels, between them and
// outside for each wrap, over bricks that begin below zero; footprints; coarser levels are means of the finest, however
// the bricks come; shapes that are not believed.
#include "volume/voxel_grid.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include <kinora/plugin.h>

#include "simd/dispatch.h"

namespace kinora::volume {
namespace {

// x + 10 y + 100 z of the place in the box, and its negative in a second channel and 1 in the third.
std::unique_ptr<VoxelGrid> linearGrid(int channels, std::array<int, 3> first, std::array<int, 3> size) {
  GridShape shape;
  shape.channels = channels;
  for (int k = 0; k < 3; ++k) {
    shape.first[k] = first[size_t(k)];
    shape.size[k] = size[size_t(k)];
    shape.worldToIndex[5 * k] = 2;
  }
  shape.worldToIndex[12] = -2, shape.worldToIndex[13] = -4, shape.worldToIndex[14] = -6, shape.worldToIndex[15] = 1;
  EXPECT_EQ(shape.disbelief(), nullptr);
  auto grid = std::make_unique<VoxelGrid>(shape);
  uint64_t number = 0;
  for (int bz = 0; bz < shape.bricks(2); ++bz)
    for (int by = 0; by < shape.bricks(1); ++by)
      for (int bx = 0; bx < shape.bricks(0); ++bx) {
        float* to = grid->addBrick(number++);
        const int corner[3] = {(shape.firstBrick(0) + bx) * 8, (shape.firstBrick(1) + by) * 8,
                               (shape.firstBrick(2) + bz) * 8};
        for (int i = 0; i < GridShape::kVoxels; ++i) {
          const float v = float(corner[0] + i % 8 - first[0] + 10 * (corner[1] + i / 8 % 8 - first[1]) +
                                100 * (corner[2] + i / 64 - first[2]));
          *to++ = v;
          if (channels == 3) *to++ = -v, *to++ = 1;
        }
      }
  return grid;
}
float valueAt(const VoxelGrid& grid, double x, double y, double z, const VoxelLookup& how = {}) {
  const double index[3] = {grid.shape().first[0] + x, grid.shape().first[1] + y, grid.shape().first[2] + z};
  float v[3] = {};
  grid.lookUp(index, how, v);
  return v[0];
}

TEST(VoxelGrid, ALinearFieldIsExact) {
  for (const auto& first : {std::array{0, 0, 0}, std::array{-3, 5, 9}, std::array{-17, -8, -1}}) {
    const auto grid = linearGrid(1, first, {20, 9, 6});
    for (double z : {0., 1., 2.5, 4.25})
      for (double y : {0., 3.5, 7.75, 8.})
        for (double x : {0., 2.25, 7.5, 15.125, 19.})
          EXPECT_EQ(valueAt(*grid, x, y, z), float(x + 10 * y + 100 * z)) << x << ' ' << y << ' ' << z;
    VoxelLookup closest;
    closest.isClosest = true;
    EXPECT_EQ(valueAt(*grid, 2.25, 3.75, 0.4, closest), 42.f);
  }
  const auto colour = linearGrid(3, {-3, 5, 9}, {20, 9, 6});
  const double index[3] = {-3 + 2.5, 5 + 1, 9 + 0.5};
  float v[3];
  colour->lookUp(index, {}, v);
  EXPECT_EQ(v[0], 62.5f);
  EXPECT_EQ(v[1], -62.5f);
  EXPECT_EQ(v[2], 1.f);
}

TEST(VoxelGrid, WorldBecomesIndex) {
  const auto grid = linearGrid(1, {0, 0, 0}, {8, 6, 4});
  const float world[3] = {2, 3, 3.5f}, step[3] = {0.5f, 0, 0.25f};
  double index[3];
  grid->toIndex(world, index);
  EXPECT_EQ(index[0], 2);
  EXPECT_EQ(index[1], 2);
  EXPECT_EQ(index[2], 1);
  grid->stepToIndex(step, index);
  EXPECT_EQ(index[0], 1);
  EXPECT_EQ(index[1], 0);
  EXPECT_EQ(index[2], 0.5);
}

TEST(VoxelGrid, Wraps) {
  const auto grid = linearGrid(1, {-3, 5, 9}, {20, 9, 6});
  const auto along = [&](VoxelWrap wrap, double x, bool isClosest = false) {
    VoxelLookup how;
    how.wrap[0] = wrap;
    how.isClosest = isClosest;
    return valueAt(*grid, x, 1, 0, how) - (wrap == VoxelWrap::Black ? 0 : 10);
  };
  // black: half of the last voxel's value half a voxel outside
  EXPECT_EQ(along(VoxelWrap::Black, 19.5), 14.5f);
  EXPECT_EQ(along(VoxelWrap::Black, -0.75), 2.5f);
  EXPECT_EQ(along(VoxelWrap::Black, 20), 0.f);
  EXPECT_EQ(along(VoxelWrap::Black, -1), 0.f);
  EXPECT_EQ(along(VoxelWrap::Black, 19.25, true), 29.f);
  EXPECT_EQ(along(VoxelWrap::Black, 19.75, true), 0.f);
  EXPECT_EQ(along(VoxelWrap::Clamp, 25), 19.f);
  EXPECT_EQ(along(VoxelWrap::Clamp, -5), 0.f);
  EXPECT_EQ(along(VoxelWrap::Periodic, 23), 3.f);
  EXPECT_EQ(along(VoxelWrap::Periodic, -17.5), 2.5f);
  EXPECT_EQ(along(VoxelWrap::Periodic, 19.75), 4.75f);  // between the last voxel and the first
  EXPECT_EQ(along(VoxelWrap::Periodic, -0.25), 4.75f);
  EXPECT_EQ(along(VoxelWrap::Mirror, 19.5), 19.f);
  EXPECT_EQ(along(VoxelWrap::Mirror, 22), 17.f);
  EXPECT_EQ(along(VoxelWrap::Mirror, -0.25), 0.f);
  EXPECT_EQ(along(VoxelWrap::Mirror, -3.5), 2.5f);
  EXPECT_EQ(along(VoxelWrap::Mirror, 45), 5.f);
  // one axis alone
  VoxelLookup how;
  how.wrap[2] = VoxelWrap::Clamp;
  EXPECT_EQ(valueAt(*grid, 1, 1, 50, how), 511.f);
  EXPECT_EQ(valueAt(*grid, 1, 50, 1, how), 0.f);
  for (VoxelWrap wrap : {VoxelWrap::Black, VoxelWrap::Clamp, VoxelWrap::Periodic, VoxelWrap::Mirror})
    for (double x : {1e300, -1e300, 1e14, -1e14, double(NAN), double(INFINITY)}) {
      const float v = along(wrap, x) + (wrap == VoxelWrap::Black ? 0 : 10);
      EXPECT_TRUE(v >= 0 && v <= 29) << x;
    }
}

TEST(VoxelGrid, BricksThatAreNotThereAreBlackAndConstantOnesShareMemory) {
  GridShape shape;
  shape.size[0] = 800, shape.size[1] = 8, shape.size[2] = 8;
  for (int k = 0; k < 4; ++k) shape.worldToIndex[5 * k] = 1;
  VoxelGrid grid(shape);
  const uint64_t empty = grid.bytes();
  const float two = 2;
  for (uint64_t k = 1; k < 100; ++k) grid.addConstantBrick(k, &two);
  EXPECT_LT(grid.bytes() - empty, 33u * 2048);
  EXPECT_EQ(valueAt(grid, 3, 3, 3), 0.f);
  EXPECT_EQ(valueAt(grid, 7.25, 3, 3), 0.5f);
  EXPECT_EQ(valueAt(grid, 795.5, 3, 3.5), 2.f);
}

// Eight places stand for a box: a linear field keeps its value, a step becomes wider by the box.
TEST(VoxelGrid, FootprintsAreAveraged) {
  const auto grid = linearGrid(1, {0, 0, 0}, {20, 9, 6});
  VoxelLookup how;
  how.size[0] = 4, how.size[1] = 0.5f, how.size[2] = 2;
  EXPECT_EQ(valueAt(*grid, 8.25, 4, 2.5, how), 298.25f);
  // at the edge half of the places along x see nothing, the others lie a voxel inside
  EXPECT_EQ(valueAt(*grid, -0.001, 4, 2.5, how), float((0.999 + 40 + 250) / 2));
  how.isClosest = true;
  EXPECT_EQ(valueAt(*grid, 8.25, 4, 2.5, how), 348.f);
  how.isClosest = false;
  how.size[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(valueAt(*grid, 8.25, 4, 2.5, how), 298.25f);
}

// Bricks of random numbers, of one number, and none, over a box that begins and ends within bricks.
std::unique_ptr<VoxelGrid> unevenGrid(int channels, bool atOnce) {
  GridShape shape;
  shape.channels = channels;
  const int first[3] = {-13, 6, -41}, size[3] = {37, 21, 70};
  for (int k = 0; k < 3; ++k) {
    shape.first[k] = first[k];
    shape.size[k] = size[k];
    shape.worldToIndex[5 * k] = 2;
    shape.worldToIndex[12 + k] = 3 - k;
  }
  shape.worldToIndex[15] = 1;
  auto grid = std::make_unique<VoxelGrid>(shape);
  uint32_t random = 1;
  for (uint64_t b = 0; b < shape.brickCount(); ++b) {
    if (b % 3 == 1) continue;
    if (!atOnce) grid->coarsen(b);
    const float one[3] = {float(b % 2), 2, 3};
    if (b % 3 == 2) {
      grid->addConstantBrick(b, one);
      continue;
    }
    float* to = grid->addBrick(b);
    for (int i = 0; i < GridShape::kVoxels * channels; ++i) {
      random = random * 1664525u + 1013904223u;
      to[i] = float(random >> 8) * 0x1p-24f;
    }
  }
  grid->coarsen(shape.brickCount());
  return grid;
}

// Places of world space, in and around the box of a grid whose voxels are half a unit apart.
struct Places {
  explicit Places(const GridShape& shape) {
    uint32_t random = 7;
    for (auto& axis : at) axis.resize(padded(kCount));
    for (size_t i = 0; i < padded(kCount); ++i)
      for (size_t k = 0; k < 3; ++k) {
        random = random * 1664525u + 1013904223u;
        // some of them at the centres of voxels
        const double x = double(random >> 8) * 0x1p-24 * (shape.size[k] + 5) - 3, voxel = i % 7 ? x : std::floor(x);
        at[k][i] = float((shape.first[k] + voxel - shape.worldToIndex[12 + k]) / shape.worldToIndex[5 * k]);
      }
    const float strange[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 3e9f, -3e9f};
    for (size_t i = 0; i < std::size(strange); ++i) at[i % 3][5 * i] = strange[i];
  }
  static constexpr uint32_t kCount = 1003;
  std::vector<float> at[3];
};

TEST(VoxelGrid, KernelsOfAllWidthsLookUpWhatOneLookupDoes) {
  std::vector<uint32_t> widths{1, 4, 8};
  if (cpuHasAvx512()) widths.push_back(16);
  for (const int channels : {1, 3})
    for (const VoxelWrap wrap : {VoxelWrap::Black, VoxelWrap::Clamp}) {
      const auto grid = unevenGrid(channels, true);
      for (uint32_t level = 0; level < 2; ++level) {
        const VoxelGrid& g = grid->level(level);
        const Places places(g.shape());
        const float* const P[3] = {places.at[0].data(), places.at[1].data(), places.at[2].data()};
        std::vector<float> first[3];
        for (const uint32_t width : widths) {
          std::vector<float> found[3];
          for (auto& x : found) x.assign(padded(Places::kCount), -7.f);
          float* const out[3] = {found[0].data(), found[1].data(), found[2].data()};
          g.lookUp(width, Places::kCount, P, wrap, out);
          for (int c = 0; c < channels; ++c) {
            found[c].resize(Places::kCount);
            if (width == 1) first[c] = found[c];
            for (uint32_t i = 0; i < Places::kCount; ++i)
              ASSERT_EQ(found[c][i], first[c][i]) << "width " << width << ", place " << i;
          }
        }
        VoxelLookup how;
        for (VoxelWrap& w : how.wrap) w = wrap;
        for (uint32_t i = 0; i < Places::kCount; ++i) {
          const float place[3] = {P[0][i], P[1][i], P[2][i]};
          double index[3];
          float v[3] = {};
          g.toIndex(place, index);
          g.lookUp(index, how, v);
          // what lies beyond the reach of voxels is nowhere for one, and clamped by the other
          const bool isFar = !(std::fabs(index[0]) + std::fabs(index[1]) + std::fabs(index[2]) < 1e14);
          for (int c = 0; c < channels && !isFar; ++c) ASSERT_NEAR(first[c][i], v[c], 1e-4) << i;
          for (int c = 0; c < channels; ++c) ASSERT_TRUE(std::isfinite(first[c][i])) << i;
        }
        // channels that are not wanted
        std::vector<float> last(padded(Places::kCount));
        float* const one[3] = {nullptr, nullptr, last.data()};
        g.lookUp(8, Places::kCount, P, wrap, one);
        for (uint32_t i = 0; channels == 3 && i < Places::kCount; ++i) ASSERT_EQ(last[i], first[2][i]);
      }
    }
}

// A grid as far from the origin as its space's numbers can still tell its voxels apart.
TEST(VoxelGrid, KernelsLookUpFarFromTheOriginAsPreciselyAsPlacesAre) {
  GridShape shape;
  for (int k = 0; k < 3; ++k) {
    shape.size[k] = 8;
    shape.worldToIndex[5 * k] = 3;
    shape.worldToIndex[12 + k] = -3e5;  // the box begins at 100,000
  }
  shape.worldToIndex[15] = 1;
  VoxelGrid grid(shape);
  float* const brick = grid.addBrick(0);
  for (int i = 0; i < GridShape::kVoxels; ++i) brick[i] = float(i % 8);
  alignas(64) float at[3][kPad] = {}, out[kPad];
  for (uint32_t i = 0; i < kPad; ++i) {
    at[0][i] = 1e5f + float(i) * 0.125f;
    at[1][i] = at[2][i] = 1e5f + 1;
  }
  const float* const P[3] = {at[0], at[1], at[2]};
  float* const to[3] = {out, nullptr, nullptr};
  grid.lookUp(8, kPad, P, VoxelWrap::Black, to);
  for (uint32_t i = 0; i < kPad; ++i) EXPECT_NEAR(out[i], float(i) * 0.375f, 1e-5f) << i;
}

TEST(VoxelGrid, CoarserLevelsAreMeans) {
  for (const int channels : {1, 3}) {
    const auto grid = unevenGrid(channels, false), atOnce = unevenGrid(channels, true);
    ASSERT_EQ(grid->levels(), 4u);  // 70, 35, 18 and 9 voxels
    EXPECT_EQ(&grid->level(9), &grid->level(3));
    EXPECT_EQ(grid->bytes(), atOnce->bytes());
    const GridShape& shape = grid->shape();
    const double mostRounding = 1e-6 * 3;
    for (uint32_t level = 1; level < grid->levels(); ++level) {
      const VoxelGrid& coarse = grid->level(level);
      const int side = 1 << level;
      for (int z = coarse.shape().first[2]; z < coarse.shape().first[2] + coarse.shape().size[2]; ++z)
        for (int y = coarse.shape().first[1]; y < coarse.shape().first[1] + coarse.shape().size[1]; ++y)
          for (int x = coarse.shape().first[0]; x < coarse.shape().first[0] + coarse.shape().size[0]; ++x) {
            double sum[3] = {0, 0, 0};
            for (int i = 0; i < side * side * side; ++i) {
              const double at[3] = {double(x * side + i % side), double(y * side + i / side % side),
                                    double(z * side + i / side / side)};
              float v[3] = {};
              grid->lookUp(at, {}, v);
              for (int c = 0; c < channels; ++c) sum[c] += double(v[c]);
            }
            const double at[3] = {double(x), double(y), double(z)};
            float v[3] = {}, same[3] = {};
            coarse.lookUp(at, {}, v);
            atOnce->level(level).lookUp(at, {}, same);
            for (int c = 0; c < channels; ++c) {
              ASSERT_NEAR(double(v[c]), sum[c] / (side * side * side), mostRounding) << level;
              ASSERT_EQ(v[c], same[c]);
            }
          }
      // the middle of a voxel is that of those which it is the mean of
      for (int k = 0; k < 3; ++k) {
        const float world[3] = {1.5f, -2.25f, 4};
        double fine[3], own[3];
        grid->toIndex(world, fine);
        coarse.toIndex(world, own);
        EXPECT_DOUBLE_EQ(own[k], (fine[k] + 0.5) / side - 0.5) << shape.size[k];
      }
    }
  }
  // what is small has one level
  EXPECT_EQ(linearGrid(1, {0, 0, 0}, {8, 6, 4})->levels(), 1u);
}

TEST(VoxelGrid, ShapesThatAreNotBelieved) {
  GridShape good;
  good.size[0] = good.size[1] = good.size[2] = 8;
  for (int k = 0; k < 4; ++k) good.worldToIndex[5 * k] = 1;
  ASSERT_EQ(good.disbelief(), nullptr);
  const auto spoiled = [&](auto&& change) {
    GridShape shape = good;
    change(shape);
    return shape.disbelief() != nullptr;
  };
  EXPECT_TRUE(spoiled([](GridShape& s) { s.channels = 2; }));
  EXPECT_TRUE(spoiled([](GridShape& s) { s.channels = -1; }));
  EXPECT_TRUE(spoiled([](GridShape& s) { s.size[1] = 0; }));
  EXPECT_TRUE(spoiled([](GridShape& s) { s.size[1] = INT32_MIN; }));
  EXPECT_TRUE(spoiled([](GridShape& s) { s.size[2] = INT32_MAX; }));
  EXPECT_TRUE(spoiled([](GridShape& s) { s.size[0] = s.size[1] = s.size[2] = 1 << 20; }));
  EXPECT_TRUE(spoiled([](GridShape& s) { s.first[0] = INT32_MIN; }));
  EXPECT_TRUE(spoiled([](GridShape& s) { s.worldToIndex[4] = NAN; }));
  EXPECT_TRUE(spoiled([](GridShape& s) { s.worldToIndex[3] = 1; }));
}

}  // namespace
}  // namespace kinora::volume
