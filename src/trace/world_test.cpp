// Proves that an answer of World depends on its own ray alone, bit for bit: not on the other rays of the call nor on
// their order. Meshes touch, coincide and lie along the axes, and rays run along edges and end on surfaces, where
// calls would differ if they could. It misses other CPUs: Embree's code paths are pinned by the device string, not
// here.
#include "trace/test_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace kinora::trace {
namespace {

// The surface of a cube of half width `size`, each side n x n squares; bumpy when amplitude is not 0.
std::shared_ptr<geometry::Mesh> cube(int n, float size, float amplitude) {
  auto m = std::make_shared<geometry::Mesh>();
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const uint32_t first = uint32_t(m->points.size());
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        Imath::V3f p;
        p[axis] = face % 2 ? 1.f : -1.f;
        p[(axis + 1) % 3] = -1.f + 2.f * float(i) / float(n);
        p[(axis + 2) % 3] = -1.f + 2.f * float(j) / float(n);
        m->points.push_back(
            p * (size * (1 - amplitude * std::sin(5 * p.x) * std::sin(4 * p.y + 1) * std::sin(6 * p.z + 2))));
      }
    const uint32_t row = uint32_t(n + 1);
    for (uint32_t j = 0; j < uint32_t(n); ++j)
      for (uint32_t i = 0; i < uint32_t(n); ++i) {
        const uint32_t a = first + j * row + i;
        m->indices.insert(m->indices.end(), {a, a + 1, a + row + 1, a, a + row + 1, a + row});
      }
  }
  m->vertexCount = uint32_t(m->points.size());
  return m;
}

struct RayList {
  std::vector<float> column[8];  // origin, direction, largest distance, time
  size_t size() const { return column[0].size(); }
};

// From points of the meshes to points of the meshes, some along edges, some along axes, some ending just there.
RayList raysBetween(const std::vector<std::shared_ptr<geometry::Mesh>>& meshes, size_t count) {
  std::mt19937 random(11);
  const auto unit = [&] { return float(random() >> 8) / 16777216.f; };
  const auto point = [&] {
    const geometry::Mesh& m = *meshes[random() % meshes.size()];
    const size_t t = random() % m.triangleCount();
    float a = unit(), b = unit();
    if (a + b > 1) {
      a = 1 - a;
      b = 1 - b;
    }
    if (random() % 8 == 0) a = 0;
    if (random() % 8 == 0) b = 0;
    const Imath::V3f p = m.points[m.indices[3 * t]], q = m.points[m.indices[3 * t + 1]],
                     r = m.points[m.indices[3 * t + 2]];
    return p + (q - p) * a + (r - p) * b;
  };
  RayList list;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t kind = random() % 8;
    const Imath::V3f o = point();
    Imath::V3f d = point() - o;
    if (kind == 0) d[int(random() % 3)] = 0;
    float l = d.length();
    if (!(l > 1e-6f)) {
      d = {1, 0, 0};
      l = 1;
    }
    d /= l;
    const Imath::V3f from = kind == 1 ? o : o + d * (kind > 3 ? 0.01f : 1e-4f);
    for (int c = 0; c < 3; ++c) {
      list.column[c].push_back(from[c]);
      list.column[3 + c].push_back(d[c]);
    }
    list.column[6].push_back(kind == 2 ? l : kind > 3 ? l * 0.2f * unit() : l * 0.9999f);
    list.column[7].push_back(unit());
  }
  return list;
}

std::vector<uint32_t> occluded(const World& world, const RayList& rays, const std::vector<size_t>& which) {
  RayList part;
  for (int c = 0; c < 8; ++c)
    for (size_t i : which) part.column[c].push_back(rays.column[c][i]);
  const float* o[3] = {part.column[0].data(), part.column[1].data(), part.column[2].data()};
  const float* d[3] = {part.column[3].data(), part.column[4].data(), part.column[5].data()};
  std::vector<uint32_t> blocked(which.size(), 7);
  world.occluded(uint32_t(which.size()), o, d, part.column[6].data(), part.column[7].data(), kSeenByOpaqueShadow,
                 blocked.data(), nullptr, nullptr);
  return blocked;
}

std::shared_ptr<const World> worldOf(const std::vector<std::shared_ptr<geometry::Mesh>>& meshes, bool moving) {
  std::vector<test::Placed> all;
  for (const auto& mesh : meshes) all.push_back({mesh, {}, {}});
  if (moving) {
    all[0].toRender.times = {0, 1};
    all[0].toRender.matrices = {scene::Matrix(), scene::Matrix().setTranslation(Imath::V3d(0.1, 0, 0))};
  }
  return test::worldOf(all);
}

void expectShadowsAlone(bool moving, float amplitude, size_t count) {
  const std::vector<std::shared_ptr<geometry::Mesh>> meshes{cube(20, 1, amplitude), cube(7, 1, amplitude),
                                                            cube(20, 1, amplitude), cube(13, 0.5f, amplitude),
                                                            cube(20, 0.5f, amplitude)};
  const auto world = worldOf(meshes, moving);
  const RayList rays = raysBetween(meshes, count);
  std::vector<uint32_t> alone(count);
  uint32_t blocked = 0;
  for (size_t i = 0; i < count; ++i) blocked += alone[i] = occluded(*world, rays, {i})[0];
  // both answers are common, or the test would prove nothing
  EXPECT_GT(blocked, count / 10);
  EXPECT_LT(blocked, count - count / 10);
  std::vector<size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(5);
  for (int round = 0; round < 3; ++round) {
    for (size_t first = 0; first < count;) {
      const size_t n = std::min<size_t>(count - first, 1 + random() % 1500);
      const std::vector<size_t> part(order.begin() + long(first), order.begin() + long(first + n));
      const std::vector<uint32_t> answer = occluded(*world, rays, part);
      for (size_t i = 0; i < n; ++i)
        ASSERT_EQ(answer[i], alone[part[i]]) << "ray " << part[i] << " in a call of " << n;
      first += n;
    }
    std::shuffle(order.begin(), order.end(), random);
  }
}

// A ray that goes nowhere (a light next to the point, or one that nothing shadows) is in nobody's way, whatever road
// the world takes: Embree writes its hits as negative distances.
TEST(World, NothingBlocksARayWithoutLength) {
  for (const bool moves : {false, true}) {
    const auto world = worldOf({cube(2, 1, 0)}, moves);
    float column[8][6] = {};
    for (int i = 0; i < 6; ++i) {
      column[2][i] = -1;  // on the near side of the cube
      column[5][i] = 1;
      column[6][i] = std::array{-1.f, -1e-6f, 0.f, -0.f, 0.5f, 3.f}[size_t(i)];
    }
    const float *o[3] = {column[0], column[1], column[2]}, *d[3] = {column[3], column[4], column[5]};
    uint32_t blocked[6];
    world->occluded(6, o, d, column[6], column[7], kSeenByOpaqueShadow, blocked, nullptr, nullptr);
    for (int i = 0; i < 4; ++i) EXPECT_FALSE(blocked[i]) << i;
    EXPECT_TRUE(blocked[5]);
  }
}

// Rays in arrays as the world takes them.
struct Asked {
  RayList list;
  std::vector<float> floats;
  std::vector<uint32_t> words;
  Rays rays{};
  Hits hits{};
  explicit Asked(const RayList& r) : list(r), floats(8 * r.size()), words(4 * r.size()) {
    const size_t n = list.size();
    for (int c = 0; c < 3; ++c) {
      rays.o[c] = list.column[c].data();
      rays.d[c] = list.column[3 + c].data();
      hits.ng[c] = &floats[(3 + size_t(c)) * n];
    }
    rays.tMax = list.column[6].data();
    rays.time = list.column[7].data();
    rays.radius = rays.spread = &floats[6 * n];
    hits.t = &floats[0];
    hits.u = &floats[n];
    hits.v = &floats[2 * n];
    hits.instance = &words[0];
    hits.geometry = &words[n];
    hits.primitive = &words[2 * n];
    hits.level = &words[3 * n];
  }
};

// All surfaces along a ray, by one walk, are those that the nearest-hit query finds one after the other; they come in
// order, the nearest where there are too many, and do not depend on the call.
TEST(World, CollectsWhatTheNearestHitsAre) {
  for (const bool moving : {false, true}) {
    std::vector<std::shared_ptr<geometry::Mesh>> meshes;
    for (int i = 0; i < 7; ++i) meshes.push_back(cube(6 + i, 0.3f + 0.11f * float(i), 0.2f));
    const auto world = worldOf(meshes, moving);
    RayList rays = raysBetween(meshes, 3000);
    std::mt19937 random(3);
    const auto unit = [&] { return float(random() >> 8) / 8388608.f - 1; };
    for (size_t i = 0; i < rays.size(); ++i) {  // from outside all through, in general directions
      const Imath::V3f o = Imath::V3f(unit(), unit(), unit()).normalized() * 4.f;
      const Imath::V3f d = (Imath::V3f(unit(), unit(), unit()) * 0.5f - o).normalized();
      for (int c = 0; c < 3; ++c) {
        rays.column[c][i] = o[c];
        rays.column[3 + c][i] = d[c];
      }
      rays.column[6][i] = 8;
    }
    Asked asked(rays);
    std::vector<uint32_t> slots(rays.size()), beyond(rays.size());
    std::iota(slots.begin(), slots.end(), 0u);
    std::vector<World::CollectedHit> all, one;
    world->collectClear(asked.rays, uint32_t(slots.size()), slots.data(), all, beyond.data());
    size_t at = 0, full = 0, unclear = 0;
    for (uint32_t i = 0; i < rays.size(); ++i) {
      size_t end = at;
      bool areApart = true;
      for (; end < all.size() && all[end].slot == i; ++end) {
        ASSERT_TRUE(end == at || all[end].t >= all[end - 1].t);
        areApart = areApart && (end == at || all[end].t - all[end - 1].t > 1e-4f);
      }
      if (!areApart) {  // an edge, or nearly: which of its triangles is first is nobody's promise
        ++unclear;
        at = end;
        continue;
      }
      Asked walk(rays);
      float passed = 0;
      uint32_t found = 0;
      for (; found <= World::kMostCollected; ++found) {
        world->closest(walk.rays, walk.hits, kSeenByClearShadow, 1, &i);
        if (std::isinf(walk.hits.t[i])) break;
        passed += walk.hits.t[i];
        if (found == World::kMostCollected) break;
        ASSERT_LT(at, all.size());
        ASSERT_EQ(all[at].slot, i);
        ASSERT_NEAR(all[at].t, passed, 2e-5f);
        Asked place(rays);
        World::CollectedHit hit = all[at];
        world->resolve(asked.rays, 1, &hit, place.hits);
        ASSERT_EQ(place.hits.geometry[0], walk.hits.geometry[i]);
        ASSERT_EQ(place.hits.primitive[0], walk.hits.primitive[i]);
        ++at;
        const float step = walk.hits.t[i] + 4e-6f;
        for (int c = 0; c < 3; ++c) walk.list.column[c][i] += walk.list.column[3 + c][i] * step;
        walk.list.column[6][i] -= step;
        passed += 4e-6f;
      }
      ASSERT_EQ(beyond[i], found == World::kMostCollected && !std::isinf(walk.hits.t[i])) << "ray " << i;
      full += beyond[i];
      uint32_t alone = 0;
      world->collectClear(asked.rays, 1, &i, one, &alone);
      ASSERT_EQ(one.size(), found);
      ASSERT_EQ(alone, beyond[i]);
      for (size_t k = 0; k < one.size(); ++k) ASSERT_EQ(one[k].t, all[at - one.size() + k].t);
    }
    EXPECT_EQ(at, all.size());
    EXPECT_LT(unclear, rays.size() / 50);
    EXPECT_GT(full, rays.size() / 10);  // too many for one walk are common
    EXPECT_LT(full, rays.size());
  }
}

TEST(World, ShadowOfARayDoesNotDependOnOthersCoplanar) { expectShadowsAlone(false, 0, 60000); }
TEST(World, ShadowOfARayDoesNotDependOnOthersBumpy) { expectShadowsAlone(false, 0.3f, 60000); }
TEST(World, ShadowOfARayDoesNotDependOnOthersMoving) { expectShadowsAlone(true, 0.2f, 30000); }

// Spheres that are said to be free of a surface hold no point of it; most places well inside have one, and a second
// question has the same answer. What moves has none. Misses: places where rounding alone decides.
TEST(World, FreeRegionsHoldNothingOfTheSurface) {
  const auto mesh = cube(12, 1, 0.15f);
  const scene::Matrix stretched = scene::Matrix().setScale(Imath::V3d(2, 0.5, 1)) *
                                  scene::Matrix().rotate(Imath::V3d(0.3, 0.7, 0.2)) *
                                  scene::Matrix().setTranslation(Imath::V3d(5, -3, 2));
  scene::Transform moving;
  moving.times = {0, 1};
  moving.matrices = {scene::Matrix(), stretched};
  scene::Transform still;
  still.matrices = {stretched};
  // of a leaf in several instances too, since those placed once are baked
  const auto world = [&] {
    std::vector<ShapeInput> shapes(2);
    std::vector<PartInput> parts(2);
    for (uint32_t i = 0; i < 2; ++i) {
      shapes[i].key = parts[i].key = i + 1;
      shapes[i].mesh = std::make_shared<geometry::Mesh>(*mesh);
      shapes[i].visibility = 15 | kAskedAlone;
      parts[i].shapes = {i};
      parts[i].instanced = i == 1;
    }
    std::vector<PlacementInput> placements(4);
    for (uint32_t i = 0; i < 4; ++i) {
      placements[i].part = i ? 1 : 0;
      placements[i].visibility = 15 | kAskedAlone;
      if (i >= 2) placements[i].toRender = i == 2 ? still : moving;
    }
    BuildOptions options;
    options.shutterClose = 1;
    BuildCounters counters;
    return World::build(std::move(shapes), std::move(parts), std::move(placements), options, nullptr, counters);
  }();
  ASSERT_EQ(world->instanceCount(), 4u);
  std::mt19937 random(3);
  const auto unit = [&] { return float(random() >> 8) / 16777216.f; };
  constexpr uint32_t n = 2000;
  for (uint32_t instance = 0; instance < 4; ++instance) {
    const uint32_t user = world->instance(instance).user, geometry = user ? 1 : 0;
    const Affine toRender = world->objectToRender(instance, 0);
    // the surface, densely
    std::vector<Imath::V3f> surface;
    for (uint32_t t = 0; t < mesh->triangleCount(); ++t)
      for (int i = 0; i <= 6; ++i)
        for (int j = 0; i + j <= 6; ++j) {
          const auto corner = [&](uint32_t k) { return mesh->points[mesh->indices[3 * t + k]]; };
          const Imath::V3f x =
              corner(0) + (corner(1) - corner(0)) * (float(i) / 6) + (corner(2) - corner(0)) * (float(j) / 6);
          Imath::V3f y;
          toRender.point(&x.x, &y.x);
          surface.push_back(y);
        }
    std::vector<float> P[3], reach(n);
    for (uint32_t i = 0; i < n; ++i) {
      const float inside[3] = {2.4f * unit() - 1.2f, 2.4f * unit() - 1.2f, 2.4f * unit() - 1.2f};
      float x[3];
      toRender.point(inside, x);
      for (int k = 0; k < 3; ++k) P[k].push_back(x[k]);
      reach[i] = i % 3 ? 0.3f : 0.05f;
    }
    const float* const places[3] = {P[0].data(), P[1].data(), P[2].data()};
    const std::vector<uint32_t> instances(n, instance), geometries(n, geometry);
    const auto asked = [&](uint32_t m, const float* const p[3], const float* r) {
      std::vector<float> x(9 * size_t(m));
      const auto of = [&](uint32_t k) { return x.data() + size_t(k) * m; };
      world->freeRegions(m, instances.data(), geometries.data(), p, r,
                         {{of(0), of(1), of(2)}, of(3), {of(4), of(5), of(6)}, of(7), of(8)});
      return x;
    };
    const std::vector<float> x = asked(n, places, reach.data());
    EXPECT_EQ(x, asked(n, places, reach.data()));
    uint32_t found = 0, close = 0, cut = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const float radius = x[3 * n + i], curvature = x[7 * n + i], offset = x[8 * n + i];
      if (!(radius > 0)) continue;
      ++found;
      const Imath::V3f center(x[i], x[n + i], x[2 * n + i]), normal(x[4 * n + i], x[5 * n + i], x[6 * n + i]);
      const auto holds = [&](const Imath::V3f& y) {
        const Imath::V3f from = y - center;
        return from.length() < radius && (from ^ normal) + curvature * from.length2() < offset;
      };
      const Imath::V3f place(P[0][i], P[1][i], P[2][i]);
      ASSERT_TRUE(holds(place)) << "place " << i << " of instance " << instance;
      float least = INFINITY;
      for (const Imath::V3f& y : surface) {
        ASSERT_FALSE(holds(y)) << "place " << i << " of instance " << instance;
        least = std::min(least, (y - place).length());
      }
      close += least < 0.3f * reach[i];
      cut += normal.length2() > 0;
    }
    if (user == 3) {
      EXPECT_EQ(found, 0u);
    } else {
      EXPECT_GT(found, n / 3) << "instance " << instance;
      EXPECT_GT(cut, n / 20) << "instance " << instance;
      EXPECT_GT(close, 10u) << "instance " << instance;
    }
    // lengths that are no numbers, and places beyond all cells
    const float bad[6] = {0, NAN, 1e30f, 0.1f, INFINITY, -1.f}, far[6] = {0, 0, 0, 1e12f, 0, 0}, none[6] = {};
    const float* const out[3] = {far, none, none};
    const std::vector<float> of = asked(6, out, bad);
    for (uint32_t i = 0; i < 6; ++i) EXPECT_EQ(of[18 + i], 0.f);
  }
}

}  // namespace
}  // namespace kinora::trace
