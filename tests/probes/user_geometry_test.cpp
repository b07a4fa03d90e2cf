// A geometry with two resolutions of which each ray's footprint chooses one: the picture is the same for any order of
// tracing, whatever happened to be tessellated already. At the level of trace::World: groups in another order, slots
// in another order, one ray at a time, packets, two threads. It misses seams between levels and eviction.
#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <numeric>
#include <thread>

#include "tests/probes/probe_support.h"
#include "trace/transformed_geometry.h"
#include "trace/world.h"

namespace kinora::probes {
namespace {

// A wavy square over [-1, 1]^2 in xy, 8 x 8 patches, each tessellated on demand: 8 x 8 quads, or one.
class TwoLevels final : public trace::UserGeometry {
 public:
  static constexpr int kPatches = 8, kFine = 8;
  mutable std::atomic<int> made{0};

  uint32_t patchCount() const override { return kPatches * kPatches; }
  void bounds(uint32_t patch, uint32_t, float lower[3], float upper[3]) const override {
    const float x = corner(int(patch) % kPatches), y = corner(int(patch) / kPatches);
    const float l[3] = {x, y, -0.06f}, u[3] = {x + kSize, y + kSize, 0.06f};
    std::copy_n(l, 3, lower);
    std::copy_n(u, 3, upper);
  }
  // From the patch and the ray alone: the footprint beside the patch's centre, against the quads of the fine level.
  static uint32_t levelOf(uint32_t patch, const trace::UserRay& r) {
    const float c[3] = {corner(int(patch) % kPatches) + kSize / 2, corner(int(patch) / kPatches) + kSize / 2, 0};
    float along = 0, d2 = 0;
    for (int k = 0; k < 3; ++k) {
      along += (c[k] - r.o[k]) * r.d[k];
      d2 += r.d[k] * r.d[k];
    }
    return r.radius + r.spread * std::max(along / d2, 0.f) > kSize / kFine ? 1 : 0;
  }
  bool intersect(uint32_t patch, const trace::UserRay& r, trace::UserHit* hit) const override {
    const uint32_t level = levelOf(patch, r);
    const std::vector<Imath::V3f>& points = grid(patch, level);
    const int n = level ? 1 : kFine;
    const Imath::V3f o(r.o[0], r.o[1], r.o[2]), d(r.d[0], r.d[1], r.d[2]);
    bool any = false;
    float far = r.tMax;
    for (int q = 0; q < 2 * n * n; ++q) {
      const int i = q / 2 % n, j = q / 2 / n, a = j * (n + 1) + i;
      const Imath::V3f p0 = points[size_t(a)], p1 = points[size_t(q & 1 ? a + n + 2 : a + 1)],
                       p2 = points[size_t(q & 1 ? a + n + 1 : a + n + 2)];
      const Imath::V3f e1 = p1 - p0, e2 = p2 - p0, h = d.cross(e2);
      const float det = e1.dot(h);
      if (det == 0) continue;
      const Imath::V3f s = o - p0, x = s.cross(e1);
      const float u = s.dot(h) / det, v = d.dot(x) / det, t = e2.dot(x) / det;
      if (u < 0 || v < 0 || u + v > 1 || !(t > r.tMin && t < far)) continue;
      const Imath::V3f ng = e1.cross(e2);
      *hit = {t, (float(i) + u) / float(n), (float(j) + v) / float(n), {ng.x, ng.y, ng.z}, level, patch};
      far = t;
      any = true;
    }
    return any;
  }

 private:
  static constexpr float kSize = 2.f / kPatches;
  static float corner(int i) { return float(i) * kSize - 1; }
  const std::vector<Imath::V3f>& grid(uint32_t patch, uint32_t level) const {
    const std::lock_guard lock(mutex_);
    std::vector<Imath::V3f>& g = grids_[patch][level];
    if (g.empty()) {
      ++made;
      const int n = level ? 1 : kFine;
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
          const float x = corner(int(patch) % kPatches) + kSize * float(i) / float(n),
                      y = corner(int(patch) / kPatches) + kSize * float(j) / float(n);
          g.emplace_back(x, y, 0.05f * std::sin(11 * x) * std::cos(13 * y));
        }
    }
    return g;
  }
  mutable std::mutex mutex_;
  mutable std::array<std::array<std::vector<Imath::V3f>, 2>, kPatches * kPatches> grids_;
};

// Unit squares that lie beside each other along x, at x = 2 p, and go up by 10 while the shutter is open.
class Rising final : public trace::UserGeometry {
 public:
  explicit Rising(float atHalfTime) : height_{0, atHalfTime, 10} {}
  uint32_t patchCount() const override { return 40; }
  uint32_t keyCount() const override { return 3; }
  void bounds(uint32_t patch, uint32_t key, float lower[3], float upper[3]) const override {
    const float x = 2 * float(patch), z = height_[key], l[3] = {x, 0, z - 0.01f}, u[3] = {x + 1, 1, z + 0.01f};
    std::copy_n(l, 3, lower);
    std::copy_n(u, 3, upper);
  }
  float heightAt(float time) const {
    const float x = 2 * time;
    return x < 1 ? height_[0] + x * (height_[1] - height_[0]) : height_[1] + (x - 1) * (height_[2] - height_[1]);
  }
  bool intersect(uint32_t patch, const trace::UserRay& r, trace::UserHit* hit) const override {
    asked.fetch_add(1, std::memory_order_relaxed);
    const float t = (heightAt(r.time) - r.o[2]) / r.d[2];
    const float u = r.o[0] + t * r.d[0] - 2 * float(patch), v = r.o[1] + t * r.d[1];
    if (!(t > r.tMin && t < r.tMax) || u < 0 || u > 1 || v < 0 || v > 1) return false;
    *hit = {t, u, v, {0, 0, 1}, 0, patch};
    return true;
  }
  mutable std::atomic<int> asked{0};

 private:
  float height_[3];
};

constexpr uint32_t kSide = 64, kRays = kSide * kSide;

// Storage of rays and hits by slot.
struct Batch {
  std::vector<std::vector<float>> f;
  std::vector<std::vector<uint32_t>> u;
  Rays rays{};
  Hits hits{};
  explicit Batch(uint32_t n) : f(15, std::vector<float>(n + 16)), u(4, std::vector<uint32_t>(n + 16, 77)) {
    for (int k = 0; k < 3; ++k) {
      rays.o[k] = f[size_t(k)].data();
      rays.d[k] = f[size_t(3 + k)].data();
      hits.ng[k] = f[size_t(6 + k)].data();
    }
    rays.tMax = f[9].data();
    rays.time = f[10].data();
    rays.radius = f[11].data();
    rays.spread = f[12].data();
    hits.u = f[13].data();
    hits.v = f[14].data();
    t.resize(n + 16);
    hits.t = t.data();
    hits.instance = u[0].data();
    hits.geometry = u[1].data();
    hits.primitive = u[2].data();
    hits.level = u[3].data();
  }
  std::vector<float> t;
};

struct Pixel {
  float t = 0, u = 0, v = 0, ng[3] = {0, 0, 0};
  uint32_t geometry = 0, primitive = 0, level = 0;
  bool operator==(const Pixel&) const = default;
};
Pixel pixelOf(const Hits& h, uint32_t s) {
  Pixel p;
  p.t = h.t[s];
  if (std::isinf(p.t)) return p;
  p.u = h.u[s];
  p.v = h.v[s];
  for (int k = 0; k < 3; ++k) p.ng[k] = h.ng[k][s];
  p.geometry = h.geometry[s];
  p.primitive = h.primitive[s];
  p.level = h.level[s];
  return p;
}

// Looks from above the near edge over the square, so that distance makes footprints grow past the threshold.
void setRay(const Rays& r, uint32_t slot, uint32_t pixel) {
  const float x = (float(pixel % kSide) + 0.5f) / kSide * 2 - 1, y = (float(pixel / kSide) + 0.5f) / kSide * 2 - 1;
  const Imath::V3f d = Imath::V3f(0.9f * x, 0.9f - 0.6f * y, -0.55f).normalized();
  r.o[0][slot] = 0;
  r.o[1][slot] = -1.4f;
  r.o[2][slot] = 0.8f;
  for (int k = 0; k < 3; ++k) r.d[k][slot] = d[k];
  r.tMax[slot] = 1e30f;
  r.time[slot] = 0;
  r.radius[slot] = 0.001f;
  r.spread[slot] = 0.02f;
}

// The square, once as it is and once small and turned above it, and a triangle before both.
std::shared_ptr<const trace::World> makeWorld(std::shared_ptr<const TwoLevels> geometry) {
  std::vector<trace::ShapeInput> shapes(2);
  shapes[0].key = 1;
  shapes[0].user = std::move(geometry);
  shapes[1].key = 2;
  shapes[1].mesh = std::make_shared<geometry::Mesh>();
  shapes[1].mesh->points = {{-0.9f, -0.8f, 0.2f}, {-0.5f, -0.8f, 0.2f}, {-0.7f, -0.7f, 0.5f}};
  shapes[1].mesh->vertexCount = 3;
  shapes[1].mesh->indices = {0, 1, 2};
  std::vector<trace::PartInput> parts(2);
  parts[0].key = 1;
  parts[0].shapes = {0};
  parts[0].instanced = true;
  parts[1].key = 2;
  parts[1].shapes = {1};
  std::vector<trace::PlacementInput> placements(3);
  scene::Matrix small;
  small.setScale(Imath::V3d(0.25));
  placements[1].toRender =
      scene::concat(scene::Transform::fixed(small),
                    scene::Transform::fixed(scene::Matrix().setTranslation(Imath::V3d(0.3, -0.5, 0.25))));
  placements[2].part = 1;
  trace::BuildCounters counters;
  return trace::World::build(std::move(shapes), std::move(parts), std::move(placements), {}, nullptr, counters);
}

// Traces the pixels in the order given, in groups of `size`, on `threads` threads, over tessellations made anew.
std::vector<Pixel> traceAll(const std::vector<uint32_t>& order, uint32_t size, uint32_t threads, bool packets) {
  const auto world = makeWorld(std::make_shared<TwoLevels>());
  EXPECT_TRUE(world->hasUserGeometry());
  std::vector<Pixel> picture(kRays);
  std::atomic<uint32_t> next{0};
  const auto work = [&] {
    Batch b(size);
    std::vector<uint32_t> slots(size);
    std::iota(slots.begin(), slots.end(), 0u);
    for (;;) {
      const uint32_t first = next.fetch_add(size);
      if (first >= kRays) return;
      const uint32_t n = std::min(size, kRays - first);
      for (uint32_t i = 0; i < n; ++i) setRay(b.rays, i, order[first + i]);
      if (packets)
        world->closestCamera(b.rays, b.hits, n);
      else
        world->closest(b.rays, b.hits, trace::kSeenByCamera, n, slots.data());
      for (uint32_t i = 0; i < n; ++i) picture[order[first + i]] = pixelOf(b.hits, i);
    }
  };
  std::vector<std::thread> pool;
  for (uint32_t t = 1; t < threads; ++t) pool.emplace_back(work);
  work();
  for (std::thread& t : pool) t.join();
  return picture;
}

TEST(UserGeometry, LevelFollowsFromRayAndPatchInAnyOrder) {
  std::vector<uint32_t> order(kRays);
  std::iota(order.begin(), order.end(), 0u);
  const std::vector<Pixel> reference = traceAll(order, 256, 1, false);
  std::array<uint32_t, 2> levels{0, 0};
  uint32_t triangles = 0, misses = 0;
  for (const Pixel& p : reference) {
    if (std::isinf(p.t))
      ++misses;
    else if (p.geometry == 0)
      ++levels[p.level];  // the square; 1 is the triangle
    else
      ++triangles;
  }
  EXPECT_GT(levels[0], 200u);
  EXPECT_GT(levels[1], 200u);
  EXPECT_GT(triangles, 10u);
  EXPECT_GT(misses, 0u);

  EXPECT_EQ(traceAll(order, 256, 1, true), reference) << "packets";
  EXPECT_EQ(traceAll(order, 16, 2, false), reference) << "small groups, two threads";
  std::reverse(order.begin(), order.end());
  EXPECT_EQ(traceAll(order, 256, 1, false), reference) << "backwards";
  EXPECT_EQ(traceAll(order, 256, 1, true), reference) << "backwards, packets";
  testing::Random random(7);
  for (uint32_t i = kRays; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  EXPECT_EQ(traceAll(order, 1, 1, false), reference) << "one ray at a time, shuffled";
  EXPECT_EQ(traceAll(order, 512, 2, false), reference) << "shuffled, two threads";
  EXPECT_EQ(traceAll(order, 64, 2, true), reference) << "shuffled packets, two threads";
}

// 200 rays with times from 0 to 1 against such a row.
struct RayRow {
  static constexpr uint32_t kCount = 200;
  std::shared_ptr<Rising> geometry;
  std::shared_ptr<const trace::World> world;
  Batch b{kCount};
  explicit RayRow(float atHalfTime) : geometry(std::make_shared<Rising>(atHalfTime)) {
    std::vector<trace::ShapeInput> shapes(1);
    shapes[0].key = 1;
    shapes[0].user = geometry;
    std::vector<trace::PartInput> parts(1);
    parts[0].key = 1;
    parts[0].shapes = {0};
    parts[0].instanced = true;
    trace::BuildCounters counters;
    world = trace::World::build(std::move(shapes), std::move(parts), std::vector<trace::PlacementInput>(1), {},
                                nullptr, counters);
  }
  static float timeOf(uint32_t i) { return float(i) / float(kCount - 1); }
  void set(uint32_t i, const Imath::V3f& o, const Imath::V3f& d) {
    for (int k = 0; k < 3; ++k) {
      b.rays.o[k][i] = o[k];
      b.rays.d[k][i] = d[k];
    }
    b.rays.tMax[i] = 1e30f;
    b.rays.time[i] = timeOf(i);
    b.rays.radius[i] = b.rays.spread[i] = 0;
  }
  void trace() {
    std::vector<uint32_t> slots(kCount);
    std::iota(slots.begin(), slots.end(), 0u);
    world->closest(b.rays, b.hits, trace::kSeenByCamera, kCount, slots.data());
  }
};

// Straight down on every place, of which each second one has a patch.
TEST(UserGeometry, BoxesOfKeysHoldThePatchesBetween) {
  RayRow row(2);  // not half of the way at half time
  for (uint32_t i = 0; i < row.kCount; ++i) row.set(i, {float(i % 80) + 0.5f, 0.5f, 20}, {0, 0, -1});
  row.trace();
  for (uint32_t i = 0; i < row.kCount; ++i) {
    ASSERT_EQ(std::isinf(row.b.hits.t[i]), i % 2 == 1) << i;
    if (i % 2) continue;
    EXPECT_EQ(row.b.hits.primitive[i], i % 80 / 2) << i;
    EXPECT_NEAR(row.b.hits.t[i], 20 - row.geometry->heightAt(row.timeOf(i)), 1e-4) << i;
  }
}

// Rays that go along the row above or below it ask nearly nothing, where boxes over the whole shutter would have them ask
// all 40.
TEST(UserGeometry, BoxesMoveWithTheKeys) {
  RayRow row(5);
  for (uint32_t i = 0; i < row.kCount; ++i)
    row.set(i, {-5, 0.5f, row.geometry->heightAt(row.timeOf(i)) + (i % 2 ? 1.f : -1.f)}, {1, 0, 0});
  row.trace();
  EXPECT_LT(row.geometry->asked.load(), int(row.kCount));
}

// A transform that is baked into geometry against a placement by it: mirrored, sheared, of other sizes along each axis.
scene::Matrix uneven() { return scene::Matrix(-0.5, 0.1, 0, 0, 0.2, 0.7, 0, 0, 0.05, 0, 0.4, 0, 0.1, -0.3, 0.2, 1); }

TEST(TransformedGeometry, IsMetAsWhatIsPlacedSo) {
  const auto geometry = std::make_shared<TwoLevels>();
  const auto worldOf = [](std::shared_ptr<const trace::UserGeometry> user, const scene::Matrix& toRender) {
    std::vector<trace::ShapeInput> shapes(1);
    shapes[0].key = 1;
    shapes[0].user = std::move(user);
    std::vector<trace::PartInput> parts(1);
    parts[0].key = 1;
    parts[0].shapes = {0};
    parts[0].instanced = true;
    std::vector<trace::PlacementInput> placements(1);
    placements[0].toRender = scene::Transform::fixed(toRender);
    trace::BuildCounters counters;
    return trace::World::build(std::move(shapes), std::move(parts), std::move(placements), {}, nullptr, counters);
  };
  const scene::Matrix m = uneven(), normals = m.inverse().transposed();
  const auto placed = worldOf(geometry, m),
             baked = worldOf(std::make_shared<trace::TransformedGeometry>(geometry, m), scene::Matrix());
  Batch a(kRays), b(kRays);
  std::vector<uint32_t> slots(kRays);
  std::iota(slots.begin(), slots.end(), 0u);
  for (uint32_t i = 0; i < kRays; ++i) {
    setRay(a.rays, i, i);
    setRay(b.rays, i, i);
    a.rays.spread[i] = b.rays.spread[i] = 0.012f;
  }
  placed->closest(a.rays, a.hits, trace::kSeenByCamera, kRays, slots.data());
  baked->closest(b.rays, b.hits, trace::kSeenByCamera, kRays, slots.data());
  uint32_t hits = 0, differ = 0;
  std::array<uint32_t, 2> levels{0, 0};
  for (uint32_t i = 0; i < kRays; ++i) {
    const bool isA = !std::isinf(a.hits.t[i]), isB = !std::isinf(b.hits.t[i]);
    if (isA != isB || (isA && (a.hits.primitive[i] != b.hits.primitive[i] || a.hits.level[i] != b.hits.level[i]))) {
      ++differ;  // at edges, and where a footprint is near to the size that decides
      continue;
    }
    if (!isA) continue;
    ++hits;
    ++levels[a.hits.level[i]];
    EXPECT_NEAR(b.hits.t[i], a.hits.t[i], 1e-4f * a.hits.t[i]) << i;
    Imath::V3d expected;
    normals.multDirMatrix(Imath::V3d(a.hits.ng[0][i], a.hits.ng[1][i], a.hits.ng[2][i]), expected);
    expected *= m.determinant();
    const Imath::V3d got(b.hits.ng[0][i], b.hits.ng[1][i], b.hits.ng[2][i]);
    differ += !((got - expected).length() < 1e-3 * expected.length());
  }
  EXPECT_GT(hits, 200u);
  EXPECT_GT(levels[0], 20u);
  EXPECT_GT(levels[1], 20u);
  EXPECT_LT(differ, hits / 50);
}

// One micropolygon.
class OneFacet final : public trace::UserGeometry {
 public:
  uint32_t patchCount() const override { return 1; }
  void bounds(uint32_t, uint32_t, float lower[3], float upper[3]) const override {
    for (int k = 0; k < 3; ++k) {
      lower[k] = 0;
      upper[k] = k == 2 ? 0.f : 1.f;
    }
  }
  bool intersect(uint32_t, const trace::UserRay&, trace::UserHit*) const override { return false; }
  bool hasFacets() const override { return true; }
  void facets(uint32_t n, const uint32_t*, const uint32_t*, const float* u, const float* v, const float* time,
              trace::UserFacet* out) const override {
    for (uint32_t i = 0; i < n; ++i) {
      static constexpr float kX[4] = {0, 1, 1, 0}, kY[4] = {0, 0, 1, 1};
      out[i] = {};
      for (int c = 0; c < 4; ++c) {
        out[i].P[c][0] = kX[c];
        out[i].P[c][1] = kY[c];
        out[i].P[c][2] = time[i];
        out[i].N[c][2] = 1;
      }
      out[i].u = u[i];
      out[i].v = v[i];
      out[i].radius = 3;
    }
  }
};

TEST(TransformedGeometry, BringsFacetsAndBoxes) {
  const scene::Matrix m = uneven();
  const trace::TransformedGeometry geometry(std::make_shared<OneFacet>(), m);
  ASSERT_TRUE(geometry.hasFacets());
  trace::UserFacet f[2];
  const uint32_t zero[2] = {0, 0};
  const float u[2] = {.25f, .5f}, v[2] = {.75f, 0}, time[2] = {0, .5f};
  geometry.facets(2, zero, zero, u, v, time, f);
  float lower[3], upper[3];
  geometry.bounds(0, 0, lower, upper);
  Imath::V3d normal;
  m.inverse().transposed().multDirMatrix(Imath::V3d(0, 0, 1), normal);
  normal.normalize();
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(f[i].u, u[i]);
    EXPECT_EQ(f[i].v, v[i]);
    EXPECT_NEAR(f[i].radius, 3 * std::cbrt(std::fabs(m.determinant())), 1e-5);
    for (int c = 0; c < 4; ++c) {
      const Imath::V3d p = Imath::V3d(c == 1 || c == 2, c >= 2, double(time[i])) * m;
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(f[i].P[c][k], p[k], 1e-6);
        EXPECT_NEAR(f[i].N[c][k], normal[k], 1e-6);
        if (i > 0) continue;
        EXPECT_LE(lower[k], f[i].P[c][k] + 1e-6f);
        EXPECT_GE(upper[k], f[i].P[c][k] - 1e-6f);
      }
    }
  }
  EXPECT_NEAR(upper[0] - lower[0], 0.7, 1e-4);  // .5 and .2
  EXPECT_NEAR(upper[1] - lower[1], 0.8, 1e-4);
}

TEST(UserGeometry, OnlyLevelsAskedForAreMade) {
  const auto geometry = std::make_shared<TwoLevels>();
  const auto world = makeWorld(geometry);
  EXPECT_EQ(geometry->made.load(), 0);
  Batch b(1);
  setRay(b.rays, 0, kSide * kSide / 2 + kSide / 2);
  const uint32_t slot = 0;
  world->closest(b.rays, b.hits, trace::kSeenByCamera, 1, &slot);
  EXPECT_GT(geometry->made.load(), 0);
  EXPECT_LT(geometry->made.load(), 32);
}

// A ray's footprint decides, not the distance: the same ray, thin and wide, meets two surfaces; a triangle in front
// of user geometry reports level 0 whatever was met on the way.
TEST(UserGeometry, FootprintChooses) {
  const auto world = makeWorld(std::make_shared<TwoLevels>());
  Batch b(2);
  for (uint32_t i = 0; i < 2; ++i) {
    setRay(b.rays, i, kSide * kSide / 2 + 9);
    b.rays.spread[i] = 0;
    b.rays.radius[i] = i ? 0.2f : 0.f;
  }
  const uint32_t slots[2] = {0, 1};
  world->closest(b.rays, b.hits, trace::kSeenByCamera, 2, slots);
  EXPECT_EQ(b.hits.level[0], 0u);
  EXPECT_EQ(b.hits.level[1], 1u);
  EXPECT_NE(b.hits.t[0], b.hits.t[1]);

  b.rays.o[0][0] = -0.7f;
  b.rays.o[1][0] = -1.4f;
  b.rays.o[2][0] = 0.3f;
  b.rays.d[0][0] = 0;
  b.rays.d[1][0] = 0.8f;
  b.rays.d[2][0] = -0.1f;
  const float l = std::sqrt(0.65f);
  b.rays.d[1][0] /= l;
  b.rays.d[2][0] /= l;
  b.rays.radius[0] = 0.2f;
  b.hits.level[0] = 99;
  world->closest(b.rays, b.hits, trace::kSeenByCamera, 1, slots);
  EXPECT_EQ(world->mesh(b.hits.geometry[0]).triangleCount(), 1u);
  EXPECT_EQ(b.hits.level[0], 0u);
}

// Shadow rays meet the level that closest hits of the same footprint meet.
TEST(UserGeometry, ShadowRaysSeeTheSameLevel) {
  const auto world = makeWorld(std::make_shared<TwoLevels>());
  Batch b(kRays);
  std::vector<uint32_t> slots(kRays), blocked(kRays), wide(kRays);
  std::iota(slots.begin(), slots.end(), 0u);
  for (uint32_t i = 0; i < kRays; ++i) setRay(b.rays, i, i);
  world->closest(b.rays, b.hits, 15, kRays, slots.data());
  uint32_t hits = 0;
  // just beyond the hit: blocked; just before it: free
  for (const float reach : {1.0001f, 0.9999f}) {
    std::vector<float> tMax(kRays);
    for (uint32_t i = 0; i < kRays; ++i) tMax[i] = std::isinf(b.hits.t[i]) ? 1e30f : b.hits.t[i] * reach;
    world->occluded(kRays, b.rays.o, b.rays.d, tMax.data(), b.rays.time, 15, blocked.data(), b.rays.radius,
                    b.rays.spread);
    for (uint32_t i = 0; i < kRays; ++i) {
      const bool expected = !std::isinf(b.hits.t[i]) && reach > 1;
      ASSERT_EQ(blocked[i] != 0, expected) << i;
      hits += expected;
    }
  }
  EXPECT_GT(hits, 1000u);
}

}  // namespace
}  // namespace kinora::probes
