// Rays against tessellations: what the hierarchy and the rows of cells find is what all triangles one by one have, and
// between two patches with other steps on their common edge no ray passes; with several keys all that at any time. The
// cache: what it holds is bounded.
#include "trace/tessellation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "simd/dispatch.h"
#include "trace/geometry_cache.h"
#include "trace/grid_outline.h"

namespace kinora::trace {
namespace {

using Imath::V3d;
using Imath::V3f;

// Bumps over the unit square, moved by `at`.
Tessellation::Ptr bumps(int eu, int ev, double at) {
  std::vector<V3f> points, normals;
  for (uint32_t j = 0; j <= 1u << ev; ++j)
    for (uint32_t i = 0; i <= 1u << eu; ++i) {
      const double x = at + double(i) / (1u << eu), y = double(j) / (1u << ev);
      points.emplace_back(V3d(x, y, 0.1 * std::sin(9 * x + 2) * std::cos(13 * y)));
      normals.emplace_back(0.f, 0.f, 1.f);
    }
  return Tessellation::make(eu, ev, points.data(), normals.data());
}

// Every so many of the points of bumps(eu, ev, at), 2^level.
Tessellation::Ptr coarseBumps(int eu, int ev, double at, int level, std::vector<V3f>* all) {
  const Tessellation::Ptr fine = bumps(eu, ev, at);
  std::vector<V3f> points, normals;
  all->clear();
  for (uint32_t j = 0; j <= 1u << ev; ++j)
    for (uint32_t i = 0; i <= 1u << eu; ++i) {
      all->push_back(fine->point(i, j));
      if (((i | j) & ((1u << level) - 1)) == 0) points.push_back(all->back());
    }
  normals.assign(points.size(), V3f(0, 0, 1));
  return Tessellation::make(eu - level, ev - level, points.data(), normals.data());
}

// Three keys: bumps that go up and to the side, by more than they are wide, and shrink.
Tessellation::Ptr movingBumps(int eu, int ev, double at, std::vector<V3f>* all = nullptr) {
  std::vector<V3f> points;
  for (int key = 0; key < 3; ++key)
    for (uint32_t j = 0; j <= 1u << ev; ++j)
      for (uint32_t i = 0; i <= 1u << eu; ++i) {
        const double x = at + double(i) / (1u << eu), y = double(j) / (1u << ev), size = 1 - 0.3 * key;
        points.emplace_back(V3d(size * x + 0.7 * key, size * y,
                                0.1 * std::sin(9 * x + 2) * std::cos(13 * y + key) + 0.2 * key * key));
      }
  const std::vector<V3f> normals(points.size(), V3f(0, 0, 1));
  if (all) *all = points;
  return Tessellation::make(eu, ev, points.data(), normals.data(), 3);
}

// As it is at a time, with one key.
Tessellation::Ptr frozen(const Tessellation& moving, float time) {
  const Moment at = momentAt(time, moving.keys());
  std::vector<V3f> points, normals;
  for (uint32_t j = 0; j <= 1u << moving.ev(); ++j)
    for (uint32_t i = 0; i <= 1u << moving.eu(); ++i) {
      points.push_back(moving.point(i, j, at));
      normals.push_back(moving.normal(i, j, at));
    }
  return Tessellation::make(moving.eu(), moving.ev(), points.data(), normals.data());
}

std::array<uint8_t, 4> whole(int eu, int ev) { return {uint8_t(eu), uint8_t(ev), uint8_t(eu), uint8_t(ev)}; }

// In double, by plane and three edges. Distance, or 0; `nearEdge`: rounding may say either.
double triangleHit(const V3d& o, const V3d& d, const V3d& a, const V3d& b, const V3d& c, bool* nearEdge) {
  const V3d n = (b - a).cross(c - a);
  const double det = n.dot(d);
  if (std::fabs(det) < 1e-14) return 0;
  const double t = n.dot(a - o) / det;
  const V3d p = o + d * t;
  double least = INFINITY;
  for (const auto& [x, y] : {std::pair{a, b}, {b, c}, {c, a}})
    least = std::min(least, (y - x).cross(p - x).dot(n) / (n.length() * (y - x).length()));
  if (std::fabs(least) < 1e-6) *nearEdge = true;
  return least >= 0 && t > 0 ? t : 0;
}

// Rays from all around at a box of bumps that lie low in it, at three of its resolutions and with coarser edges.
TEST(GridOutline, TurnsAwayNoRayThatMeetsTheGrid) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  int turnedAway = 0, met = 0, passed = 0;
  for (int level = 0; level < 3; ++level) {
    std::vector<V3f> points;
    const Tessellation::Ptr grid = coarseBumps(4, 5, 3, level, &points);
    std::array<float, 6> box{3.f, 0.f, -.1001f, 4.f, 1.f, .3f};
    for (const V3f& p : points)
      for (size_t k = 0; k < 3; ++k) {
        box[k] = std::min(box[k], p[k]);
        box[3 + k] = std::max(box[3 + k], p[k]);
      }
    GridOutline outline;
    outline.set(4, 5, points.data(), box);
    for (int n = 0; n < 20000; ++n) {
      const V3d from(3 + 3 * unit(random) - 1, 3 * unit(random) - 1, unit(random) - .5);
      const V3d to(3 + unit(random), unit(random), .4 * unit(random) - .1);
      const V3f o(from), d(to - from);
      const GridRay ray(&o[0], &d[0], 0, n % 3 ? INFINITY : 1.f);
      std::array<uint8_t, 4> steps = whole(grid->eu(), grid->ev());
      for (auto& s : steps) s = uint8_t(std::max<int>(GridOutline::kLeastExponent, s - n % 2));
      GridHit hit;
      const bool meets = grid->intersect(ray, steps, &hit), may = outline.mayMeetFine(box, ray);
      EXPECT_TRUE(may || !meets) << level << " " << n;
      EXPECT_TRUE(outline.mayMeet(ray) || !meets) << level << " " << n;
      met += meets;
      passed += !meets;
      turnedAway += !may;
    }
  }
  EXPECT_GT(met, 10000);
  EXPECT_GT(turnedAway, passed / 2);  // what the boxes are for
}

// The coarsest grids too, whose triangles reach from one quarter to another.
TEST(GridOutline, IsAroundEveryResolution) {
  std::mt19937 random(13);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const auto& [eu, ev] : {std::pair{4, 5}, {1, 3}, {0, 0}}) {
    int turnedAway = 0, met = 0;
    for (int level = 0; level <= std::min(eu, ev); ++level) {
      std::vector<V3f> points;
      const Tessellation::Ptr grid = coarseBumps(eu, ev, 3, level, &points);
      const std::array<float, 6> box{2.f, -1.f, -1.f, 5.f, 2.f, 1.f};
      GridOutline outline;
      outline.set(eu, ev, points.data(), box);
      for (int n = 0; n < 4000; ++n) {
        const V3d from(3 + 3 * unit(random) - 1, 3 * unit(random) - 1, unit(random) - .5);
        const V3d to(3 + 1.5 * unit(random), 1.5 * unit(random), .4 * unit(random) - .1);
        const V3f o(from), d(to - from);
        const GridRay ray(&o[0], &d[0], 0, INFINITY);
        std::array<uint8_t, 4> steps = whole(grid->eu(), grid->ev());
        for (auto& s : steps) s = uint8_t(n % 2 ? s : s / 2);
        GridHit hit;
        const bool meets = grid->intersect(ray, steps, &hit), may = outline.mayMeet(ray);
        EXPECT_TRUE(may || !meets) << eu << " " << level << " " << n;
        met += meets;
        turnedAway += !may;
      }
    }
    EXPECT_GT(met, 1000);
    EXPECT_GT(turnedAway, 1000);
  }
}

TEST(Tessellation, RaysFindTheNearestOfAllTriangles) {
  setThreadFloatMode();
  std::mt19937 random(7);
  std::uniform_real_distribution<float> number(-1, 1);
  for (const auto& [eu, ev] : {std::pair{0, 0}, {0, 3}, {1, 2}, {2, 2}, {3, 1}, {4, 3}, {5, 5}, {2, 6}}) {
    const Tessellation::Ptr grid = bumps(eu, ev, 0);
    int hits = 0;
    for (int ray = 0; ray < 400; ++ray) {
      const float o[3] = {number(random) * 2, number(random) * 2, number(random)};
      float d[3] = {0.5f + 0.5f * number(random) - o[0], 0.5f + 0.5f * number(random) - o[1],
                    0.1f * number(random) - o[2]};
      if (ray % 8 == 0) d[ray / 8 % 3] = 0;
      double nearest = INFINITY;
      bool isNear = false;
      const V3d from(o[0], o[1], o[2]), along(d[0], d[1], d[2]);
      for (uint32_t j = 0; j < 1u << ev; ++j)
        for (uint32_t i = 0; i < 1u << eu; ++i) {
          const V3d a(grid->point(i, j)), b(grid->point(i + 1, j)), c(grid->point(i + 1, j + 1)),
              e(grid->point(i, j + 1));
          for (const double t :
               {triangleHit(from, along, a, b, c, &isNear), triangleHit(from, along, a, c, e, &isNear)})
            if (t > 0) nearest = std::min(nearest, t);
        }
      if (isNear) continue;
      GridHit h;
      const bool is = grid->intersect(GridRay(o, d, 0, 1e30f), whole(eu, ev), &h);
      ASSERT_EQ(is, std::isfinite(nearest)) << eu << " " << ev << " " << ray;
      if (!is) continue;
      ++hits;
      EXPECT_NEAR(h.t, nearest, 1e-4 * nearest);
      EXPECT_NEAR(h.u, o[0] + h.t * d[0], 1e-4);
      EXPECT_NEAR(h.v, o[1] + h.t * d[1], 1e-4);
      EXPECT_GT(h.ng[2], 0);
    }
    EXPECT_GT(hits, 100);
  }
}

// Two patches side by side; rays through points of their common edge, and beside it by a little.
TEST(Tessellation, NothingPassesBetweenNeighboursOfOtherSteps) {
  setThreadFloatMode();
  std::mt19937 random(3);
  std::uniform_real_distribution<float> number(0, 1);
  for (const auto& [left, right, edge] : {std::tuple{5, 5, 5}, {5, 3, 3}, {5, 4, 2}, {3, 6, 0}, {6, 6, 4}}) {
    const Tessellation::Ptr a = bumps(left, left, 0), b = bumps(right, right, 1);
    std::array<uint8_t, 4> stepsA = whole(left, left), stepsB = whole(right, right);
    stepsA[1] = stepsB[3] = uint8_t(edge);
    int passed = 0;
    for (int ray = 0; ray < 40000; ++ray) {
      const float y = 0.01f + 0.98f * number(random), side = ray % 2 ? 1.f : -1.f;
      const float to[3] = {1 + (ray % 4 < 2 ? 0.f : 1e-3f * (number(random) - 0.5f)), y, 0};
      const float o[3] = {1 + 0.3f * (number(random) - 0.5f), y + 0.3f * (number(random) - 0.5f), side * 3};
      const float d[3] = {to[0] - o[0], to[1] - o[1], to[2] - o[2]};
      GridHit h;
      const GridRay r(o, d, 0, 1e30f);
      passed += !a->intersect(r, stepsA, &h) && !b->intersect(r, stepsB, &h);
    }
    EXPECT_EQ(passed, 0) << left << " " << right << " " << edge;
  }
}

TEST(Moment, LiesBetweenKeysAtEvenDistances) {
  for (const auto& [time, keys, key, part] : {std::tuple{0.f, 1u, 0u, 0.f},
                                              {.7f, 1u, 0u, 0.f},
                                              {0.f, 3u, 0u, 0.f},
                                              {.25f, 3u, 0u, .5f},
                                              {.5f, 3u, 1u, 0.f},
                                              {1.f, 3u, 1u, 1.f},
                                              {2.f, 3u, 1u, 1.f},
                                              {-1.f, 3u, 0u, 0.f},
                                              {NAN, 2u, 0u, 0.f}}) {
    const Moment m = momentAt(time, keys);
    EXPECT_EQ(m.key, key) << time;
    EXPECT_EQ(m.part, part) << time;
  }
}

// What a ray meets of a tessellation that moves is what it meets of the one that stands where that is at its time: the
// triangles are the same to the bit, only the boxes on the way to them are not.
TEST(Tessellation, OfSeveralKeysIsMetWhereItIsAtTheTime) {
  setThreadFloatMode();
  std::mt19937 random(5);
  std::uniform_real_distribution<float> number(-1, 1), unit(0, 1);
  for (const auto& [eu, ev] : {std::pair{0, 0}, {1, 3}, {2, 2}, {4, 3}, {5, 5}, {2, 6}}) {
    const Tessellation::Ptr moving = movingBumps(eu, ev, 0);
    ASSERT_EQ(moving->keys(), 3u);
    int hits = 0;
    for (int n = 0; n < 60; ++n) {
      const float time = n < 3 ? 0.5f * float(n) : unit(random);
      const Tessellation::Ptr still = frozen(*moving, time);
      const V3f first = still->point(0, 0), last = still->point(1u << eu, 1u << ev);
      std::array<uint8_t, 4> steps = whole(eu, ev);
      if (n % 2)
        for (auto& s : steps) s = uint8_t(s / 2);
      for (int ray = 0; ray < 40; ++ray) {
        const V3f to = first + V3f(unit(random), unit(random), 0.2f * number(random)) * (last - first + V3f(0, 0, 1));
        const float o[3] = {number(random) * 3, number(random) * 3, 2 * number(random)};
        const float d[3] = {to.x - o[0], to.y - o[1], to.z - o[2]};
        GridHit a, b;
        const bool isA = moving->intersect(GridRay(o, d, 0, 1e30f, time), steps, &a),
                   isB = still->intersect(GridRay(o, d, 0, 1e30f), steps, &b);
        ASSERT_EQ(isA, isB) << eu << " " << ev << " " << time << " " << ray;
        if (!isA) continue;
        ++hits;
        EXPECT_EQ(a.t, b.t);
        EXPECT_NEAR(a.u, b.u, 1e-4);
        EXPECT_NEAR(a.v, b.v, 1e-4);
      }
    }
    EXPECT_GT(hits, 300);
  }
}

TEST(Tessellation, NothingPassesBetweenNeighboursThatMove) {
  setThreadFloatMode();
  std::mt19937 random(13);
  std::uniform_real_distribution<float> number(0, 1);
  for (const auto& [left, right, edge] : {std::tuple{5, 5, 5}, {5, 3, 3}, {5, 4, 2}, {3, 6, 0}}) {
    const Tessellation::Ptr a = movingBumps(left, left, 0), b = movingBumps(right, right, 1);
    std::array<uint8_t, 4> stepsA = whole(left, left), stepsB = whole(right, right);
    stepsA[1] = stepsB[3] = uint8_t(edge);
    int passed = 0;
    for (int ray = 0; ray < 20000; ++ray) {
      const float time = number(random), side = ray % 2 ? 1.f : -1.f;
      // where the common edge is at the time
      const float size = 1 - 0.6f * time, x = size + 1.4f * time, y = size * (0.05f + 0.9f * number(random));
      const float z = time < 0.5f ? 0.4f * time : 0.2f + 1.2f * (time - 0.5f);
      const float to[3] = {x + (ray % 4 < 2 ? 0.f : 1e-3f * (number(random) - 0.5f)), y, z};
      const float o[3] = {x + 0.3f * (number(random) - 0.5f), y + 0.3f * (number(random) - 0.5f), side * 3};
      const float d[3] = {to[0] - o[0], to[1] - o[1], to[2] - o[2]};
      GridHit h;
      const GridRay r(o, d, 0, 1e30f, time);
      passed += !a->intersect(r, stepsA, &h) && !b->intersect(r, stepsB, &h);
    }
    EXPECT_EQ(passed, 0) << left << " " << right << " " << edge;
  }
}

TEST(GridOutline, OfSeveralKeysHoldsAtAnyTime) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<V3f> points;
  const Tessellation::Ptr grid = movingBumps(4, 5, 0, &points);
  std::array<float, 6> box{0.f, 0.f, -.2f, 2.f, 1.f, 1.f};
  for (const V3f& p : points)
    for (size_t k = 0; k < 3; ++k) {
      box[k] = std::min(box[k], p[k]);
      box[3 + k] = std::max(box[3 + k], p[k]);
    }
  GridOutline outline;
  outline.set(4, 5, points.data(), box, 3);
  int met = 0, turnedAway = 0;
  for (int n = 0; n < 20000; ++n) {
    const V3d from(4 * unit(random) - 1, 3 * unit(random) - 1, 3 * unit(random) - 1);
    const V3d to(3 * unit(random), unit(random), unit(random));
    const V3f o(from), d(to - from);
    const GridRay ray(&o[0], &d[0], 0, INFINITY, float(unit(random)));
    GridHit hit;
    const bool meets = grid->intersect(ray, whole(4, 5), &hit), may = outline.mayMeetFine(box, ray);
    EXPECT_TRUE(may || !meets) << n;
    EXPECT_TRUE(outline.mayMeet(ray) || !meets) << n;
    met += meets;
    turnedAway += !may;
  }
  EXPECT_GT(met, 500);
  EXPECT_GT(turnedAway, 500);
}

TEST(Tessellation, TakesFewBytesATriangle) {
  for (const uint32_t keys : {1u, 2u, 5u})
    for (const int e : {3, 4, 5, 6, 7})
      EXPECT_LT(double(Tessellation::bytesFor(e, e, keys)) / double(keys * (2u << (2 * e))), 14) << e << " " << keys;
}

TEST(GeometryCache, HoldsNoMoreThanItsSizeAndTheLatest) {
  const uint64_t one = bumps(3, 3, 0)->bytes();
  GeometryCache cache(4 * one);
  std::vector<GeometryCache::Slot> slots(64);
  for (auto& s : slots) {
    GeometryCache::Reading reading;
    EXPECT_EQ(cache.find(s), nullptr);
    const Tessellation* t = cache.put(&cache, s, bumps(3, 3, 0));
    EXPECT_EQ(cache.find(s), t);
    // another thread was faster
    EXPECT_EQ(cache.put(&cache, s, bumps(3, 3, 0)), t);
  }
  const GeometryCache::Counts counts = cache.counts();
  EXPECT_EQ(counts.made, 64u);
  EXPECT_EQ(counts.twice, 64u);
  EXPECT_GE(counts.evicted, 59u);
  EXPECT_LE(counts.mostBytes, 6 * one);
  cache.forget(&cache);
  EXPECT_LE(cache.counts().bytes, one);  // what was evicted while this thread read
}

TEST(GeometryCache, CountsTheBytesOfAllKeys) {
  GeometryCache cache(1 << 20);
  GeometryCache::Slot slots[2];
  GeometryCache::Reading reading;
  cache.put(&cache, slots[0], bumps(4, 4, 0));
  const uint64_t one = cache.counts().bytes;
  cache.put(&cache, slots[1], movingBumps(4, 4, 0));
  EXPECT_EQ(cache.counts().bytes - one, Tessellation::bytesFor(4, 4, 3));
  EXPECT_GT(cache.counts().bytes, 39 * one / 10);
  cache.forget(&cache);
}

}  // namespace
}  // namespace kinora::trace
