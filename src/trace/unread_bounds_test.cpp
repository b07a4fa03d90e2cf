// Proves: the tree over boxes finds what a look at each box finds, and rays that touch a box are never missed.
#include "trace/unread_bounds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kinora::trace {
namespace {

using Box = UnreadBounds::Box;

// In double, without padding: the distance at which a ray enters, or infinity.
double entry(const Box& b, const float o[3], const float d[3]) {
  double near = 0, far = INFINITY;
  for (int k = 0; k < 3; ++k) {
    if (d[k] == 0) {
      if (o[k] < b.lower[k] || o[k] > b.upper[k]) return INFINITY;
      continue;
    }
    const double p = (double(b.lower[k]) - o[k]) / d[k], q = (double(b.upper[k]) - o[k]) / d[k];
    near = std::max(near, std::min(p, q));
    far = std::min(far, std::max(p, q));
  }
  return near <= far ? near : INFINITY;
}

TEST(UnreadBounds, FindTheFirstBoxOfARay) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<float> u(-1, 1);
  int met = 0, missed = 0;
  for (const int count : {1, 2, 3, 17, 200}) {
    std::vector<Box> boxes;
    for (int i = 0; i < count; ++i) {
      Box b;
      for (int k = 0; k < 3; ++k) {
        const float middle = 10 * u(rng), half = i % 5 == 0 ? 0.f : std::fabs(u(rng));
        b.lower[k] = middle - half;
        b.upper[k] = middle + half;
      }
      boxes.push_back(b);
    }
    const UnreadBounds tree(boxes);
    for (int i = 0; i < 20000; ++i) {
      float o[3], d[3], length = 0;
      const Box& aim = boxes[size_t(i) % boxes.size()];
      for (int k = 0; k < 3; ++k) {
        o[k] = 12 * u(rng);
        // at a corner of a box, or anywhere
        d[k] = (i % 2 ? (i >> (k + 1) & 1 ? aim.upper[k] : aim.lower[k]) : 10 * u(rng)) - o[k];
        if (i % 11 == k) d[k] = 0;
        length += d[k] * d[k];
      }
      length = std::sqrt(length);
      for (float& x : d) x /= length;
      const float most = i % 3 ? 1e30f : 8 * std::fabs(u(rng));
      double best = INFINITY;
      for (const Box& b : boxes) best = std::min(best, entry(b, o, d));
      const uint32_t found = tree.firstOf(o, d, most);
      if (best <= most) {
        ASSERT_NE(found, UnreadBounds::kNone) << i;
        Box padded = boxes[found];
        for (int k = 0; k < 3; ++k) {
          padded.lower[k] -= 1e-4f;
          padded.upper[k] += 1e-4f;
        }
        EXPECT_LE(entry(padded, o, d), best + 1e-3) << i;
        ++met;
      } else if (found == UnreadBounds::kNone) {
        ++missed;
      }
    }
  }
  EXPECT_GT(met, 10000);
  EXPECT_GT(missed, 10000);
}

TEST(UnreadBounds, RaysThatMeetOneFindNothing) {
  const UnreadBounds bounds({{{-1, -1, 4}, {1, 1, 6}}, {{-1, -1, 8}, {1, 1, 9}}, {{20, 20, 20}, {21, 21, 21}}});
  // in front of the first box, behind it, inside it, beside both, and one that is too short
  float zero[5] = {}, x[5] = {0, 0, 0, 3, 0}, z[5] = {0, 0, 5, 0, 0}, one[5] = {1, 1, 1, 1, 1},
        far[5] = {1e30f, 1e30f, 1e30f, 1e30f, 3}, t[5] = {3, 7, 5.5f, INFINITY, INFINITY};
  Rays rays{{x, zero, z}, {zero, zero, one}, far, zero, zero, zero};
  Hits hits{};
  hits.t = t;
  const uint64_t before = UnreadBounds::notesOfThread();
  bounds.meet(rays, hits, 5, nullptr);
  EXPECT_EQ(t[0], 3);
  EXPECT_TRUE(std::isinf(t[1]));
  EXPECT_TRUE(std::isinf(t[2]));
  EXPECT_EQ(UnreadBounds::notesOfThread() - before, 2u);
  EXPECT_EQ(bounds.noted(), std::vector<uint32_t>{0}) << "what stands behind an unread box is not known";
  uint32_t blocked[5] = {1, 0, 0, 0, 0};
  const float *const o[3] = {x, zero, z}, *const d[3] = {zero, zero, one};
  bounds.meet(5, o, d, far, blocked);
  EXPECT_EQ(std::vector<uint32_t>(blocked, blocked + 5), (std::vector<uint32_t>{1, 1, 1, 0, 0}));
  EXPECT_EQ(UnreadBounds::notesOfThread() - before, 4u);
}

}  // namespace
}  // namespace kinora::trace
