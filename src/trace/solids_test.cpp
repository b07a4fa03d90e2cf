// Proves: along rays in all directions, what World shows of solids is what intervals of the same spheres give by the
// rules of sets (worked out here from quadratics), for random trees of operations, with surfaces that move, and with
// faces that several operands have in common; volumes are the closed ones; answers do not depend on the other rays of
// a call; solids with holes are found and drawn as they are. Misses: motion of vertices, and what shading makes of
// the hits (tests/truth/solids_test.cpp).
#include "trace/solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>

#include "trace/test_world.h"

namespace kinora::trace {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kRows = 96;  // of a sphere's triangles, from pole to pole

std::shared_ptr<geometry::Mesh> sphere() {
  auto m = std::make_shared<geometry::Mesh>();
  const uint32_t columns = 2 * kRows;
  for (int j = 0; j <= kRows; ++j)
    for (uint32_t i = 0; i < columns; ++i) {
      const double a = kPi * j / kRows, b = 2 * kPi * i / columns;
      m->points.push_back(Imath::V3f(Imath::V3d(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a))));
    }
  for (uint32_t j = 0; j < kRows; ++j)
    for (uint32_t i = 0; i < columns; ++i) {
      const uint32_t a = j * columns + i, b = j * columns + (i + 1) % columns;
      if (j > 0) m->indices.insert(m->indices.end(), {a, a + columns, b});
      if (j + 1 < kRows) m->indices.insert(m->indices.end(), {b, a + columns, b + columns});
    }
  m->vertexCount = uint32_t(m->points.size());
  return m;
}

// Of half width 1; `faces`: how many of its six.
std::shared_ptr<geometry::Mesh> box(uint32_t faces = 6) {
  auto m = std::make_shared<geometry::Mesh>();
  for (uint32_t face = 0; face < faces; ++face) {
    const uint32_t first = uint32_t(m->points.size());
    for (int k = 0; k < 4; ++k) {
      Imath::V3f p;
      p[int(face / 2)] = face % 2 ? 1.f : -1.f;
      p[int(face / 2 + 1) % 3] = k == 1 || k == 2 ? 1.f : -1.f;
      p[int(face / 2 + 2) % 3] = k >= 2 ? 1.f : -1.f;
      m->points.push_back(p);
    }
    m->indices.insert(m->indices.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
  }
  m->vertexCount = uint32_t(m->points.size());
  return m;
}

scene::Transform at(const Imath::V3d& middle, double size) {
  return scene::Transform::fixed(scene::Matrix().setScale(Imath::V3d(size)) * scene::Matrix().setTranslation(middle));
}

using Surface = test::Placed;
using test::worldOf;

struct Ray {
  Imath::V3d o, d;
  float time = 0;
};
using Interval = std::array<double, 2>;
using Intervals = std::vector<Interval>;

// All rays at once, from hit to hit: where each is inside what it sees.
std::vector<Intervals> seenBy(const World& world, const std::vector<Ray>& rays) {
  const size_t n = rays.size();
  std::vector<std::vector<float>> f(15, std::vector<float>(n + 16));
  std::vector<std::vector<uint32_t>> u(4, std::vector<uint32_t>(n + 16));
  Rays r{};
  Hits h{};
  for (int c = 0; c < 3; ++c) {
    r.o[c] = f[size_t(c)].data();
    r.d[c] = f[size_t(3 + c)].data();
    h.ng[c] = f[size_t(6 + c)].data();
  }
  r.tMax = f[9].data();
  r.time = f[10].data();
  r.radius = f[11].data();
  r.spread = f[14].data();
  h.t = f[12].data();
  h.u = f[13].data();
  std::vector<float> v(n + 16);
  h.v = v.data();
  h.instance = u[0].data();
  h.geometry = u[1].data();
  h.primitive = u[2].data();
  h.level = u[3].data();
  std::vector<uint32_t> open(n);
  std::iota(open.begin(), open.end(), 0);
  std::vector<double> from(n, 0);
  std::vector<std::vector<double>> events(n);
  while (!open.empty()) {
    for (const uint32_t i : open) {
      for (int c = 0; c < 3; ++c) {
        r.o[c][i] = float(rays[i].o[c] + rays[i].d[c] * from[i]);
        r.d[c][i] = float(rays[i].d[c]);
      }
      r.tMax[i] = INFINITY;
      r.time[i] = rays[i].time;
    }
    world.closest(r, h, kSeenByIndirect, uint32_t(open.size()), open.data());
    std::vector<uint32_t> onward;
    for (const uint32_t i : open) {
      if (std::isinf(h.t[i]) || events[i].size() > 100) continue;
      events[i].push_back(from[i] + double(h.t[i]));
      from[i] = events[i].back() + 1e-4;
      onward.push_back(i);
    }
    open = std::move(onward);
  }
  std::vector<Intervals> out(n);
  for (size_t i = 0; i < n; ++i)
    for (size_t k = 0; k < events[i].size(); k += 2)
      out[i].push_back({events[i][k], k + 1 < events[i].size() ? events[i][k + 1] : INFINITY});
  return out;
}

bool isIn(const Intervals& intervals, double t) {
  return std::any_of(intervals.begin(), intervals.end(), [&](const Interval& i) { return t > i[0] && t < i[1]; });
}
double lengthOf(const Intervals& intervals) {
  double sum = 0;
  for (const Interval& i : intervals) sum += i[1] - i[0];
  return sum;
}
// Of what is in one of them only.
double difference(const Intervals& a, const Intervals& b) {
  std::vector<double> ends;
  for (const Intervals* x : {&a, &b})
    for (const Interval& i : *x) ends.insert(ends.end(), {i[0], i[1]});
  std::sort(ends.begin(), ends.end());
  double sum = 0;
  for (size_t k = 0; k + 1 < ends.size(); ++k) {
    const double middle = 0.5 * (ends[k] + ends[k + 1]);
    if (isIn(a, middle) != isIn(b, middle)) sum += ends[k + 1] - ends[k];
  }
  return sum;
}

// Parallel to any direction, through a square around the origin.
std::vector<Ray> raysAround(uint32_t seed, size_t count, double half, double distance) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(-half, half);
  std::vector<Ray> rays(count);
  for (Ray& r : rays) {
    r.d = Imath::V3d(normal(random), normal(random), normal(random)).normalized();
    const Imath::V3d a = r.d.cross(std::fabs(r.d.x) < .7 ? Imath::V3d(1, 0, 0) : Imath::V3d(0, 1, 0)).normalized(),
                     b = r.d.cross(a);
    r.o = a * unit(random) + b * unit(random) - r.d * distance;
    r.time = float((unit(random) + half) / (2 * half));
  }
  return rays;
}

SolidNode node(uint32_t parent, SolidNode::Joins joins, uint32_t leaf = kNoSolid, bool isFull = false) {
  return {parent, joins, isFull, leaf};
}
using Joins = SolidNode::Joins;
SolidInput unionOf(uint32_t leaves) {
  SolidInput s{{node(0, Joins::Or)}, leaves};
  for (uint32_t i = 0; i < leaves; ++i) s.nodes.push_back(node(0, Joins::Or, i));
  return s;
}
SolidInput intersectionOf(uint32_t leaves) {
  SolidInput s{{node(0, Joins::Or, kNoSolid, true)}, leaves};
  for (uint32_t i = 0; i < leaves; ++i) s.nodes.push_back(node(0, Joins::And, i));
  return s;
}
SolidInput differenceOf(uint32_t leaves) {
  SolidInput s = intersectionOf(leaves);
  for (uint32_t i = 1; i < leaves; ++i) s.nodes[i + 1].joins = Joins::AndNot;
  return s;
}

// A sphere that moves along a line over the shutter.
struct Ball {
  Imath::V3d middle, path;
  double radius;
  Interval crossedBy(const Ray& r) const {
    const Imath::V3d x = r.o - middle - path * double(r.time);
    const double b = x.dot(r.d), c = x.dot(x) - radius * radius, root = b * b - c;
    return root > 0 ? Interval{-b - std::sqrt(root), -b + std::sqrt(root)} : Interval{0, 0};
  }
};

TEST(Solids, RandomTreesOfSpheresAgainstIntervals) {
  const auto mesh = sphere();
  for (uint32_t tree = 0; tree < 24; ++tree) {
    std::mt19937 random(tree);
    std::uniform_real_distribution<double> unit(-1, 1);
    const uint32_t leaves = 2 + tree % 5;
    SolidInput solid{{node(0, Joins::Or)}, leaves};
    std::vector<int> kinds{int(random() % 3)}, children{0};
    std::vector<Ball> balls;
    std::vector<Surface> surfaces;
    // under a node each: an operation now and then, with what follows below it
    uint32_t parent = 0;
    solid.nodes[0].isFull = kinds[0] > 0;
    const auto join = [&](uint32_t below) {
      const bool isFirst = children[below]++ == 0;
      return kinds[below] == 0 ? Joins::Or : kinds[below] == 1 || isFirst ? Joins::And : Joins::AndNot;
    };
    for (uint32_t leaf = 0; leaf < leaves; ++leaf) {
      if (leaf > 0 && leaf + 1 < leaves && random() % 2) {
        const int kind = int(random() % 3);
        solid.nodes.push_back(node(parent, join(parent), kNoSolid, kind > 0));
        kinds.push_back(kind);
        children.push_back(0);
        parent = uint32_t(solid.nodes.size() - 1);
      }
      solid.nodes.push_back(node(parent, join(parent), leaf));
      kinds.push_back(-1);
      children.push_back(0);
      const bool moves = tree % 3 == 0 && leaf == 0;
      balls.push_back({Imath::V3d(unit(random), unit(random), unit(random)) * 0.6,
                       moves ? Imath::V3d(0.5, 0.2, 0) : Imath::V3d(0), 0.8 + 0.3 * unit(random)});
      const Ball& b = balls.back();
      scene::Transform t = at(b.middle, b.radius);
      if (moves) {
        t.times = {0, 1};
        t.matrices.push_back(at(b.middle + b.path, b.radius).matrices[0]);
      }
      surfaces.push_back({mesh, t, {0, leaf}});
    }
    const auto world = worldOf(surfaces, {solid});
    ASSERT_TRUE(world->openSolids().empty());
    const std::vector<Ray> rays = raysAround(tree + 100, 600, 1.5, 6);
    const std::vector<Intervals> seen = seenBy(*world, rays);
    double sum = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      std::vector<double> ends;
      for (const Ball& b : balls)
        for (const double t : b.crossedBy(rays[i])) ends.push_back(t);
      std::sort(ends.begin(), ends.end());
      Intervals wanted;
      for (size_t k = 0; k + 1 < ends.size(); ++k) {
        const double middle = 0.5 * (ends[k] + ends[k + 1]);
        // by recursion from the leaves of the list up, with no word of how the world does it
        const std::function<bool(uint32_t)> holds = [&](uint32_t n) {
          if (solid.nodes[n].leaf != kNoSolid) {
            const Interval x = balls[solid.nodes[n].leaf].crossedBy(rays[i]);
            return middle > x[0] && middle < x[1];
          }
          bool value = kinds[n] == 1, isFirst = true;
          for (uint32_t c = n + 1; c < solid.nodes.size(); ++c) {
            if (solid.nodes[c].parent != n) continue;
            const bool one = holds(c);
            if (kinds[n] == 0) value = value || one;
            if (kinds[n] == 1) value = value && one;
            if (kinds[n] == 2) value = isFirst ? one : value && !one;
            isFirst = false;
          }
          return value;
        };
        if (holds(0)) wanted.push_back({ends[k], ends[k + 1]});
      }
      sum += difference(seen[i], wanted);
    }
    // triangles lie at most r (1 - cos(pi / rows)) = 5e-4 r below their sphere, at some 2 crossings a leaf; where rays
    // graze it is more. An operation mistaken moves tenths.
    EXPECT_LT(sum / double(rays.size()), 2e-3 * leaves) << "tree " << tree;
  }
}

// Mean length inside, over parallel rays through an area, times the area.
double volumeOf(const World& world, double half) {
  const int n = 120;
  std::vector<Ray> rays;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      rays.push_back({{half * (2 * (i + 0.5) / n - 1), half * (2 * (j + 0.5) / n - 1), -8}, {0, 0, 1}, 0.25f});
  double sum = 0;
  for (const Intervals& one : seenBy(world, rays)) sum += lengthOf(one);
  return sum * 4 * half * half / double(rays.size());
}
double lens(double a, double b, double d) {  // volume that two spheres have in common
  return kPi * std::pow(a + b - d, 2) * (d * d + 2 * d * (a + b) - 3 * (a - b) * (a - b)) / (12 * d);
}

TEST(Solids, ClosedVolumes) {
  const auto ball = sphere();
  const auto two = [&](const SolidInput& solid) {
    return volumeOf(*worldOf({{ball, at({0, 0, 0}, 1), {0, 0}}, {ball, at({0.3, 0.4, 0.5}, 0.8), {0, 1}}}, {solid}),
                    1.5);
  };
  const double common = lens(1, 0.8, std::sqrt(0.5)), first = 4 * kPi / 3, second = first * 0.512;
  // the grid of rays: 120 in 3 units; triangles take 8e-4 of a sphere
  EXPECT_NEAR(two(intersectionOf(2)), common, 6e-3 * common);
  EXPECT_NEAR(two(unionOf(2)), first + second - common, 6e-3 * first);
  EXPECT_NEAR(two(differenceOf(2)), first - common, 6e-3 * first);
  // concentric: a shell, whose inner surface no other leaf comes near
  const auto shell =
      worldOf({{ball, at({0, 0, 0}, 1), {0, 0}}, {ball, at({0, 0, 0}, 0.9), {0, 1}}}, {differenceOf(2)});
  EXPECT_NEAR(volumeOf(*shell, 1.5), first * (1 - 0.729), 6e-3 * first);
}

// Faces in one plane: a slot that is cut exactly through both faces of a box is open, two boxes side by side have no
// wall between them, a box without itself is nothing.
TEST(Solids, FacesInOnePlane) {
  const auto cube = box();
  scene::Transform slot = at({0, 0, 0}, 1);
  slot.matrices[0] = scene::Matrix().setScale(Imath::V3d(0.5, 0.25, 1));
  const auto cut = worldOf({{cube, at({0, 0, 0}, 1), {0, 0}}, {cube, slot, {0, 1}}}, {differenceOf(2)});
  for (const Intervals& one : seenBy(*cut, {{{0.1, 0.05, -8}, {0, 0, 1}}, {{-0.3, 0.2, -8}, {0, 0, 1}}}))
    EXPECT_TRUE(one.empty());
  const std::vector<Intervals> beside = seenBy(*cut, {{{0.7, 0.05, -8}, {0, 0, 1}}, {{-8, 0.05, 0.1}, {1, 0, 0}}});
  EXPECT_NEAR(lengthOf(beside[0]), 2, 1e-5);
  EXPECT_EQ(beside[1].size(), 2u);
  // at all angles, faces in one plane among them
  const std::vector<Ray> rays = raysAround(5, 4000, 1.5, 6);
  const std::vector<Intervals> seen = seenBy(*cut, rays);
  double sum = 0, wrong = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const auto crossed = [&](const Imath::V3d& half) {
      Interval t{-INFINITY, INFINITY};
      for (int c = 0; c < 3; ++c) {
        const double a = (-half[c] - rays[i].o[c]) / rays[i].d[c], b = (half[c] - rays[i].o[c]) / rays[i].d[c];
        t = {std::max(t[0], std::min(a, b)), std::min(t[1], std::max(a, b))};
      }
      return t;
    };
    const Interval whole = crossed({1, 1, 1}), taken = crossed({0.5, 0.25, 1});
    Intervals wanted;
    if (whole[0] < whole[1]) {
      if (taken[0] >= taken[1]) {
        wanted.push_back(whole);
      } else {
        wanted.push_back({whole[0], taken[0]});
        wanted.push_back({taken[1], whole[1]});
      }
    }
    const double one = difference(seen[i], wanted);
    sum += std::min(one, 10.);
    wrong += one > 1e-3;
  }
  // walls thinner than the step of 1e-4 from hit to hit are all that differs
  EXPECT_LT(sum / double(rays.size()), 1e-3);
  EXPECT_LE(wrong, 2);
  const auto row = worldOf({{cube, at({-1, 0, 0}, 1), {0, 0}}, {cube, at({1, 0, 0}, 1), {0, 1}}}, {unionOf(2)});
  const std::vector<Intervals> through = seenBy(*row, {{{-8, 0.3, 0.2}, {1, 0, 0}}});
  ASSERT_EQ(through[0].size(), 1u);
  EXPECT_NEAR(lengthOf(through[0]), 4, 1e-5);
  const auto nothing =
      worldOf({{cube, at({0, 0, 0}, 1), {0, 0}}, {cube, at({0, 0, 0}, 1), {0, 1}}}, {differenceOf(2)});
  for (const Intervals& one : seenBy(*nothing, raysAround(3, 500, 1.5, 6))) EXPECT_TRUE(one.empty());
}

TEST(Solids, WithHolesAreDrawnAsTheyAre) {
  const auto cut = [](const std::shared_ptr<geometry::Mesh>& second) {
    return worldOf({{box(), at({0, 0, 0}, 1), {0, 0}},
                    {second, at({0, 0, 0.5}, 0.5), {0, 1}},
                    {sphere(), at({5, 0, 0}, 1), {1, 0}},
                    {sphere(), at({5.5, 0, 0}, 1), {1, 1}}},
                   {differenceOf(2), intersectionOf(2)});
  };
  EXPECT_TRUE(cut(box())->openSolids().empty());
  for (const uint32_t faces : {5u, 1u, 0u}) {
    const auto world = cut(box(faces));
    ASSERT_EQ(world->openSolids().size(), 1u) << faces;
    EXPECT_EQ(world->openSolids()[0].solid, 0u);
    EXPECT_EQ(world->openSolids()[0].placement, 1u);
    // both faces of the box are seen; the other solid is one still
    EXPECT_NEAR(seenBy(*world, {{{0.8, 0.8, -8}, {0, 0, 1}}})[0][0][0], 7, 1e-4);
    const std::vector<Intervals> beside = seenBy(*world, {{{2, 0, 0.1}, {1, 0, 0}}});
    ASSERT_EQ(beside[0].size(), 1u);
    EXPECT_NEAR(lengthOf(beside[0]), 2 * std::sqrt(0.99) - 0.5, 2e-3);
    EXPECT_NE(world->bodyOf(0, 0), world->bodyOf(1, 0));
    EXPECT_EQ(world->bodyOf(2, 0), world->bodyOf(3, 0));
  }
}

TEST(Solids, AnAnswerIsItsRaysOwn) {
  const auto ball = sphere();
  const auto world = worldOf({{ball, at({0, 0, 0}, 1), {0, 0}},
                              {ball, at({0.3, 0.4, 0.5}, 0.8), {0, 1}},
                              {ball, at({-0.5, 0, 0.2}, 0.4), {0, 2}}},
                             {differenceOf(3)});
  const std::vector<Ray> rays = raysAround(7, 2000, 1.3, 4);
  std::vector<std::vector<float>> x(8, std::vector<float>(rays.size()));
  for (size_t i = 0; i < rays.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      x[size_t(c)][i] = float(rays[i].o[c]);
      x[size_t(3 + c)][i] = float(rays[i].d[c]);
    }
    x[6][i] = 4.f;  // to the middle of what is there
  }
  const auto ask = [&](size_t first, size_t n) {
    const float *o[3] = {&x[0][first], &x[1][first], &x[2][first]},
                *d[3] = {&x[3][first], &x[4][first], &x[5][first]};
    std::vector<uint32_t> blocked(n);
    world->occluded(uint32_t(n), o, d, &x[6][first], &x[7][first], kSeenByOpaqueShadow, blocked.data());
    return blocked;
  };
  const std::vector<uint32_t> all = ask(0, rays.size());
  const std::vector<Intervals> seen = seenBy(*world, rays);
  size_t blocked = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(all[i], ask(i, 1)[0]);
    EXPECT_EQ(all[i], uint32_t(!seen[i].empty() && seen[i][0][0] < 4));
    blocked += all[i];
  }
  EXPECT_GT(blocked, rays.size() / 10);
  EXPECT_LT(blocked, rays.size() * 9 / 10);
}

}  // namespace
}  // namespace kinora::trace
