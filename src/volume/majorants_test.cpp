// Proves: a ray walks through the cells of bounds in order and never stands still, whatever its direction; the bound that
// it is told is that of the cell it is in; bounds of fields hold for all lookups in a box.
#include "volume/majorants.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "volume/medium_field.h"

namespace kinora::volume {
namespace {

TEST(Majorants, RaysSeeTheCellThatTheyAreIn) {
  const float low[3] = {-1, 2, 5}, high[3] = {3, 3, 9};
  const int cells[3] = {7, 1, 4};
  Majorants m(low, high, cells);
  ASSERT_EQ(m.count(), 28u);
  for (size_t k = 0; k < m.count(); ++k) m[k] = float(k + 1);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0, 1);
  for (int ray = 0; ray < 2000; ++ray) {
    float o[3], d[3], length = 0;
    for (int k = 0; k < 3; ++k) {
      o[k] = low[k] + (high[k] - low[k]) * unit(random);
      d[k] = unit(random) < 0.2f ? 0.f : unit(random) - 0.5f;  // along the axes too
      if (unit(random) < 0.1f)
        o[k] = low[k] + std::floor(unit(random) * float(cells[k])) * (high[k] - low[k]) / float(cells[k]);
      length += d[k] * d[k];
    }
    if (length == 0) continue;
    for (float& x : d) x /= std::sqrt(length);
    const float inverse[3] = {1 / d[0], 1 / d[1], 1 / d[2]};
    // to the wall of the box
    float end = 1e30f;
    for (int k = 0; k < 3; ++k)
      if (d[k] != 0) end = std::min(end, ((d[k] > 0 ? high[k] : low[k]) - o[k]) / d[k]);
    int steps = 0;
    for (float t = 0; t < end && steps < 1000; ++steps) {
      float until = end;
      const float bound = m.at(o, d, inverse, t, until);
      ASSERT_GT(until, t);
      ASSERT_LE(until, end);
      const float middle = t + 0.5f * (until - t);
      float from[3], to[3];
      m.boundsOf(size_t(bound) - 1, from, to);
      if (until - t > 1e-4f)
        for (int k = 0; k < 3; ++k) {
          ASSERT_GE(o[k] + d[k] * middle, from[k] - 1e-5f) << ray;
          ASSERT_LE(o[k] + d[k] * middle, to[k] + 1e-5f) << ray;
        }
      t = until;
    }
    ASSERT_LT(steps, 40);
  }
}

TEST(MediumField, BoundsHoldForAllLookups) {
  const float bound[6] = {-1, 1, 0, 4, 2, 3};
  const int points[3] = {11, 9, 2};
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<float> values;
  for (int k = 0; k < 11 * 9 * 2; ++k) values.push_back(unit(random) < 0.1f ? 9 * unit(random) : unit(random));
  const MediumField field(bound, points, values.data(), 1);
  for (int box = 0; box < 300; ++box) {
    float low[3], high[3];
    for (int k = 0; k < 3; ++k) {
      const float a = bound[2 * k], b = bound[2 * k + 1], x = unit(random), y = unit(random);
      low[k] = a + (b - a) * std::min(x, y);
      high[k] = a + (b - a) * std::max(x, y);
    }
    const float most = field.most(low, high);
    float seen = 0;
    for (int n = 0; n < 200; ++n) {
      float p[3], v;
      for (int k = 0; k < 3; ++k) p[k] = low[k] + (high[k] - low[k]) * unit(random);
      field.at(p, &v);
      seen = std::max(seen, v);
      ASSERT_LE(v, most * 1.00001f);
    }
    EXPECT_GT(seen, 0);
  }
  EXPECT_EQ(field.levels(), 1u);  // voxels of requests have no others
  // a point of the request is what it says, and the value of its outermost points goes on
  float v;
  const float corner[3] = {-1, 0, 2}, beyond[3] = {-5, -5, -5};
  field.at(corner, &v);
  EXPECT_FLOAT_EQ(v, values[0]);
  field.at(beyond, &v);
  EXPECT_FLOAT_EQ(v, values[0]);
}

TEST(MediumField, BoundsHoldForLookupsOfEachLevel) {
  GridShape shape;
  for (int k = 0; k < 3; ++k) {
    shape.first[k] = -5 + 9 * k;
    shape.size[k] = 40 + 3 * k;
    shape.worldToIndex[5 * k] = 10;
  }
  shape.worldToIndex[15] = 1;
  VoxelGrid grid(shape);
  std::mt19937 random(6);
  std::uniform_real_distribution<float> unit(0, 1);
  for (uint64_t b = 0; b < shape.brickCount(); ++b) {
    if (unit(random) < 0.3f) continue;
    float* const to = grid.addBrick(b);
    for (int i = 0; i < GridShape::kVoxels; ++i) to[i] = unit(random) < 0.1f ? 9 * unit(random) : unit(random);
  }
  grid.coarsen(shape.brickCount());
  const MediumField field(&grid);
  ASSERT_EQ(field.levels(), 3u);
  double last = 1e30;
  for (uint32_t level = 0; level < field.levels(); ++level) {
    double sum = 0;
    for (int box = 0; box < 200; ++box) {
      float low[3], high[3], seen = 0;
      for (int k = 0; k < 3; ++k) {
        const float a = float(shape.first[k]) * 0.1f - 0.5f, length = float(shape.size[k]) * 0.1f + 1;
        low[k] = a + length * unit(random);
        high[k] = low[k] + unit(random);
      }
      const float most = field.most(low, high, level);
      for (int n = 0; n < 200; ++n) {
        float p[3], v;
        for (int k = 0; k < 3; ++k) p[k] = low[k] + (high[k] - low[k]) * unit(random);
        field.at(p, &v, level);
        seen = std::max(seen, v);
        ASSERT_LE(v, most * 1.00001f) << level;
      }
      sum += double(most);
    }
    EXPECT_LT(sum, last);  // means have no peaks
    last = sum;
  }
}

}  // namespace
}  // namespace kinora::volume
