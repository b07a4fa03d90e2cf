// Proves that placements in swarms are seen as Embree's own instances are: the same shape, triangle and place for
// nearest hits of single rays and of camera packets, for occlusion and for all hits with clear shadows; under
// transforms that mirror and shear, by visibility, beside moving and lost placements. It misses speed and memory, which
// kinora-bench measures.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "trace/test_world.h"

namespace kinora::trace {
namespace {

constexpr uint32_t kPlaced = 400, kRays = 1024;

std::shared_ptr<geometry::Mesh> tetrahedron(float size) {
  auto m = std::make_shared<geometry::Mesh>();
  m->points = {{-size, -size, -size}, {size, -size, 0}, {0, size, -size}, {0, 0, size}};
  m->indices = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};
  m->vertexCount = 4;
  return m;
}

// Two parts in a cloud; some placements move, one is flat, some are hidden from the camera, some let shadows through.
std::shared_ptr<const World> cloud(uint32_t swarmFrom) {
  std::mt19937 random(3);
  const auto unit = [&] { return double(random() >> 8) / 16777216.; };
  std::vector<ShapeInput> shapes(2);
  std::vector<PartInput> parts(2);
  for (uint32_t i = 0; i < 2; ++i) {
    shapes[i].key = i + 1;
    shapes[i].mesh = tetrahedron(i ? .5f : 1.f);
    shapes[i].visibility = i ? kSeenByCamera | kSeenByIndirect | kSeenByClearShadow
                             : kSeenByCamera | kSeenByIndirect | kSeenByOpaqueShadow;
    parts[i].key = i + 1;
    parts[i].shapes = {i};
    parts[i].instanced = true;
  }
  std::vector<PlacementInput> placements;
  for (uint32_t i = 0; i < kPlaced; ++i) {
    PlacementInput p;
    p.part = i % 3 == 0;
    p.visibility = i % 5 == 0 ? 15u & ~uint32_t(kSeenByCamera) : 15u;
    scene::Matrix m;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) m[r][c] = .4 * (unit() - .5) + (r == c ? (i % 7 == 0 ? -.4 : .4) : 0);
    for (int c = 0; c < 3; ++c) m[3][c] = 10 * (unit() - .5);
    p.toRender = scene::Transform::fixed(m);
    if (i == 11) {
      for (int c = 0; c < 3; ++c) m[1][c] = 0;
      p.toRender = scene::Transform::fixed(m);
    }
    if (i % 40 == 13) {
      p.toRender.times = {0, 1};
      m[3][0] += .5;
      p.toRender.matrices.push_back(m);
    }
    placements.push_back(std::move(p));
  }
  BuildOptions options;
  options.shutterClose = 1;
  options.swarmFrom = swarmFrom;
  BuildCounters counters;
  return World::build(std::move(shapes), std::move(parts), std::move(placements), options, nullptr, counters);
}

struct Traced {
  std::vector<float> o[3], d[3], t, u, v, ng[3], tMax, time, radius, spread;
  std::vector<uint32_t> instance, geometry, primitive, level, slots;
  Rays rays{};
  Hits hits{};
  Traced() {
    std::mt19937 random(7);
    const auto unit = [&] { return float(random() >> 8) / 16777216.f; };
    for (auto* list : {&t, &u, &v, &tMax, &time, &radius, &spread}) list->assign(kRays, 0);
    for (auto* list : {&instance, &geometry, &primitive, &level}) list->assign(kRays, ~0u);
    for (int c = 0; c < 3; ++c) {
      for (uint32_t i = 0; i < kRays; ++i) o[c].push_back(16 * (unit() - .5f));
      d[c].assign(kRays, 0);
      ng[c].assign(kRays, 0);
    }
    for (uint32_t i = 0; i < kRays; ++i) {
      float l = 0, x[3];
      for (int c = 0; c < 3; ++c) x[c] = 8 * (unit() - .5f) - o[c][i], l += x[c] * x[c];
      for (int c = 0; c < 3; ++c) d[c][i] = x[c] / std::sqrt(l);
      tMax[i] = i % 4 == 0 ? std::sqrt(l) : INFINITY;
      time[i] = unit();
      slots.push_back(i);
    }
    for (int c = 0; c < 3; ++c) {
      rays.o[c] = o[c].data();
      rays.d[c] = d[c].data();
      hits.ng[c] = ng[c].data();
    }
    rays.tMax = tMax.data(), rays.time = time.data(), rays.radius = radius.data(), rays.spread = spread.data();
    hits.t = t.data(), hits.u = u.data(), hits.v = v.data();
    hits.instance = instance.data(), hits.geometry = geometry.data(), hits.primitive = primitive.data();
    hits.level = level.data();
  }
};

// Rounding may bring a ray past an edge: so many of a thousand may differ.
constexpr uint32_t kMayDiffer = 2;

void expectSame(const World& a, const World& b, const Traced& x, const Traced& y, const char* how) {
  uint32_t hits = 0, differ = 0;
  for (uint32_t i = 0; i < kRays; ++i) {
    const bool hitsX = x.t[i] < INFINITY, hitsY = y.t[i] < INFINITY;
    hits += hitsX;
    if (hitsX != hitsY || (hitsX && std::fabs(x.t[i] - y.t[i]) > 1e-3f)) {
      ++differ;
      continue;
    }
    if (!hitsX) continue;
    ASSERT_LT(y.instance[i], b.instanceCount()) << how;
    EXPECT_EQ(a.instance(x.instance[i]).user, b.instance(y.instance[i]).user) << how << " ray " << i;
    EXPECT_EQ(x.geometry[i], y.geometry[i]) << how;
    EXPECT_EQ(x.primitive[i], y.primitive[i]) << how;
    EXPECT_NEAR(x.u[i], y.u[i], 1e-3) << how;
    EXPECT_NEAR(x.v[i], y.v[i], 1e-3) << how;
    for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(x.ng[c][i], y.ng[c][i]) << how;
  }
  EXPECT_GT(hits, kRays / 4) << how;
  EXPECT_LT(hits, kRays) << how;
  EXPECT_LE(differ, kMayDiffer) << how;
}

TEST(Swarm, IsSeenAsInstancesAre) {
  const auto plain = cloud(~0u), swarm = cloud(1);
  EXPECT_EQ(plain->lostPlacements(), swarm->lostPlacements());
  EXPECT_EQ(swarm->lostPlacements(), std::vector<uint32_t>{11});
  EXPECT_EQ(plain->triangleCount(), swarm->triangleCount());
  Traced x, y;
  for (const uint32_t mask : {uint32_t(kSeenByIndirect), uint32_t(kSeenByOpaqueShadow), uint32_t(kSeenByCamera)}) {
    plain->closest(x.rays, x.hits, mask, kRays, x.slots.data());
    swarm->closest(y.rays, y.hits, mask, kRays, y.slots.data());
    expectSame(*plain, *swarm, x, y, "single rays");
  }
  plain->closestCamera(x.rays, x.hits, kRays);
  swarm->closestCamera(y.rays, y.hits, kRays);
  expectSame(*plain, *swarm, x, y, "packets");
  Traced alone;
  swarm->closest(alone.rays, alone.hits, kSeenByCamera, kRays, alone.slots.data());
  expectSame(*swarm, *swarm, y, alone, "packets and single rays");

  std::vector<uint32_t> blocked(kRays, 7), blockedToo(kRays, 7);
  const float *o[3] = {x.o[0].data(), x.o[1].data(), x.o[2].data()},
              *d[3] = {x.d[0].data(), x.d[1].data(), x.d[2].data()};
  plain->occluded(kRays, o, d, x.tMax.data(), x.time.data(), kSeenByOpaqueShadow, blocked.data());
  swarm->occluded(kRays, o, d, x.tMax.data(), x.time.data(), kSeenByOpaqueShadow, blockedToo.data());
  uint32_t differ = 0, some = 0;
  for (uint32_t i = 0; i < kRays; ++i) differ += blocked[i] != blockedToo[i], some += blocked[i];
  EXPECT_GT(some, kRays / 8);
  EXPECT_LE(differ, kMayDiffer);
}

TEST(Swarm, LetsAllHitsBeCollected) {
  const auto plain = cloud(~0u), swarm = cloud(1);
  Traced x;
  std::vector<World::CollectedHit> a, b;
  std::vector<uint32_t> beyondA(kRays), beyondB(kRays);
  plain->collectClear(x.rays, kRays, x.slots.data(), a, beyondA.data());
  swarm->collectClear(x.rays, kRays, x.slots.data(), b, beyondB.data());
  EXPECT_GT(a.size(), kRays / 8u);
  EXPECT_NEAR(double(a.size()), double(b.size()), 2 * kMayDiffer);
  Traced y, z;
  const uint32_t n = uint32_t(std::min({a.size(), b.size(), size_t(kRays)}));
  plain->resolve(x.rays, n, a.data(), y.hits);
  swarm->resolve(x.rays, n, b.data(), z.hits);
  uint32_t differ = 0;
  for (uint32_t i = 0; i < n; ++i)
    differ += plain->instance(y.instance[i]).user != swarm->instance(z.instance[i]).user ||
              y.primitive[i] != z.primitive[i] || std::fabs(y.t[i] - z.t[i]) > 1e-3f;
  EXPECT_LE(differ, n / 100);
}

// What an edit did not move stays as it was built, with the swarms that it is made of.
TEST(Swarm, OutlivesTheWorldThatMadeIt) {
  std::shared_ptr<const World> next;
  const auto build = [](const World* previous, BuildCounters& counters) {
    std::vector<ShapeInput> shapes(1);
    shapes[0].key = shapes[0].revision = 1;
    shapes[0].mesh = tetrahedron(1);
    std::vector<PlacementInput> placements(50);
    for (uint32_t i = 0; i < 50; ++i)
      placements[i].toRender = scene::Transform::fixed(scene::Matrix().setTranslation(Imath::V3d(3. * i, 0, 0)));
    BuildOptions options;
    options.swarmFrom = 10;
    return World::build(std::move(shapes), {{1, {0}, true, false}}, std::move(placements), options, previous,
                        counters);
  };
  {
    BuildCounters first, second;
    const auto before = build(nullptr, first);
    next = build(before.get(), second);
    EXPECT_EQ(first.topLevelBuilds, 1u);
    EXPECT_EQ(second.topLevelBuilds, 0u);
    EXPECT_EQ(second.partsKept, 1u);
  }
  Traced x;
  for (uint32_t i = 0; i < kRays; ++i) {
    x.o[0][i] = 3.f * float(i % 50), x.o[1][i] = -.1f, x.o[2][i] = -9;
    x.d[0][i] = x.d[1][i] = 0, x.d[2][i] = 1;
    x.tMax[i] = INFINITY;
  }
  next->closest(x.rays, x.hits, kSeenByIndirect, kRays, x.slots.data());
  for (uint32_t i = 0; i < kRays; ++i) {
    ASSERT_LT(x.t[i], INFINITY);
    EXPECT_EQ(next->instance(x.instance[i]).user, i % 50);
  }
}

}  // namespace
}  // namespace kinora::trace
