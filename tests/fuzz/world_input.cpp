#include "fuzz/world_input.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "fuzz/rib_input.h"
#include "geometry/tessellate.h"
#include "render/flat_scene.h"
#include "rib/reader.h"
#include "trace/world.h"

namespace kinora::fuzz {

namespace {

// Small worlds, many of them: what is larger is another test's.
constexpr size_t kMostPlacements = 60, kMostShapes = 40;
constexpr uint32_t kMostTriangles = 4000, kMostOfWorld = 60000;
constexpr uint32_t kRays = 64;

[[noreturn]] void fail(const char* what) {
  std::fprintf(stderr, "world: %s\n", what);
  std::abort();
}

void check(const geometry::Mesh& m) {
  const size_t keys = size_t(m.keyCount());
  if (m.isStrand()) {
    if (m.spine.size() != keys * m.vertexCount) fail("strands without their control points");
    for (const uint32_t i : m.indices)
      if (i + size_t(m.controlsOfPiece()) > m.vertexCount) fail("a strand beyond its control points");
    return;
  }
  if (m.indices.size() % 3 != 0 || m.points.size() != keys * m.vertexCount)
    fail("points or indices that do not add up");
  for (const uint32_t i : m.indices)
    if (i >= m.vertexCount) fail("a triangle beyond its points");
  if (!m.faceOfTriangle.empty() && m.faceOfTriangle.size() != m.triangleCount()) fail("triangles without faces");
  for (const geometry::Primvar& p : m.primvars) {
    if (p.data.empty()) continue;
    const size_t have = p.data.size() / size_t(std::max(1, p.width));
    switch (p.rate) {
      case geometry::Primvar::Rate::PerVertex:
        if (have != m.vertexCount && have != keys * m.vertexCount) fail("a primvar of vertices that lacks some");
        break;
      case geometry::Primvar::Rate::PerCorner:
        if (have != 3 * size_t(m.triangleCount())) fail("a primvar of corners that lacks some");
        break;
      case geometry::Primvar::Rate::PerFace:
        for (uint32_t t = 0; t < m.triangleCount(); ++t)
          if (m.faceOf(t) >= have) fail("a primvar of faces that lacks some");
        break;
      case geometry::Primvar::Rate::Constant:
        if (have < 1) fail("a constant primvar without a value");
    }
  }
}

struct RayTable {
  alignas(64) float o[3][kRays], d[3][kRays], tMax[kRays], time[kRays], radius[kRays], spread[kRays];
  alignas(64) float t[kRays], u[kRays], v[kRays], ng[3][kRays];
  alignas(64) uint32_t geometry[kRays], instance[kRays], primitive[kRays], level[kRays], blocked[kRays], slots[kRays];
};

void trace(const trace::World& w) {
  static RayTable r;
  const float size = std::isfinite(w.radius()) && w.radius() < 1e15f ? std::max(w.radius(), 1e-3f) : 1.f;
  float middle[3];
  for (int k = 0; k < 3; ++k) middle[k] = std::fabs(w.center()[k]) < 1e15f ? w.center()[k] : 0.f;
  for (uint32_t i = 0; i < kRays; ++i) {
    const float angle = float(i) * 2.399963f, z = 1 - (2 * float(i) + 1) / kRays, c = std::sqrt(1 - z * z);
    const float d[3] = {c * std::cos(angle), c * std::sin(angle), z};
    // towards the middle from outside, and away from it
    const bool isInside = i % 3 == 2;
    for (int k = 0; k < 3; ++k) {
      r.d[k][i] = d[k];
      r.o[k][i] = middle[k] - (isInside ? 0.f : 1.5f * size * d[k]);
    }
    r.tMax[i] = i % 5 ? INFINITY : size;
    // the ends and the middle of the shutter among them
    r.time[i] = float(i % 9) / 8;
    r.radius[i] = 0, r.spread[i] = 1e-3f;
    r.slots[i] = i;
  }
  w.avoidFlatMoments(r.time, kRays);
  Rays rays{};
  Hits hits{};
  for (int k = 0; k < 3; ++k) rays.o[k] = r.o[k], rays.d[k] = r.d[k], hits.ng[k] = r.ng[k];
  rays.tMax = r.tMax, rays.time = r.time, rays.radius = r.radius, rays.spread = r.spread;
  hits.t = r.t, hits.u = r.u, hits.v = r.v;
  hits.geometry = r.geometry, hits.instance = r.instance, hits.primitive = r.primitive, hits.level = r.level;
  const auto look = [&] {
    for (uint32_t i = 0; i < kRays; ++i) {
      if (!(r.t[i] < INFINITY)) continue;
      if (!(r.t[i] >= 0)) fail("a hit at no distance");
      if (r.geometry[i] >= w.geometryCount() || r.instance[i] >= w.instanceCount()) fail("a hit of nothing");
      if (r.primitive[i] >= w.mesh(r.geometry[i]).primitiveCount()) fail("a hit beyond a mesh");
    }
  };
  w.closestCamera(rays, hits, kRays);
  look();
  w.closest(rays, hits, trace::kSeenByIndirect, kRays, r.slots);
  look();
  const float* o[3] = {r.o[0], r.o[1], r.o[2]};
  const float* d[3] = {r.d[0], r.d[1], r.d[2]};
  w.occluded(kRays, o, d, r.tMax, r.time, trace::kSeenByOpaqueShadow, r.blocked, r.radius, r.spread);
}

size_t build(const scene::Scene& scene) {
  if (scene.primitives.size() > kMostShapes || scene.instances.size() > kMostShapes) return 0;
  for (const scene::Prototype& p : scene.prototypes)
    if (p.instances.size() > 4) return 0;
  Diagnostics silent([](const std::string&, Severity) {});
  const auto flat = render::flatten(
      scene, {}, {}, [](const scene::Attributes*) { return false; }, nullptr, silent);
  if (flat->placements.size() > kMostPlacements || flat->shapes.size() > kMostShapes) return 0;
  geometry::DiceRate rate;
  rate.edgeLength = [](const Imath::V3d&) { return .3; };
  rate.maxTriangles = kMostTriangles;
  std::vector<trace::ShapeInput> shapes(flat->shapes.size());
  size_t count = 0;
  for (size_t i = 0; i < shapes.size(); ++i) {
    shapes[i].key = i + 1;
    scene::Primitive p = *flat->shapes[i].primitive;
    p.attributes = flat->shapes[i].attributes;
    std::optional<geometry::Mesh> mesh = geometry::tessellate(p, rate, silent);
    if (!mesh) continue;
    if (flat->shapes[i].isBaked) trace::bake(*mesh, p.toWorld.matrices[0]);
    check(*mesh);
    count += mesh->primitiveCount();
    if (count > kMostOfWorld) return count;
    shapes[i].mesh = std::make_shared<geometry::Mesh>(std::move(*mesh));
  }
  trace::BuildOptions options;
  options.shutterClose = 1;
  options.watertight = count % 2;
  options.toRender = [&](uint32_t placement) { return flat->toRender(placement); };
  options.swarmFrom = 1 + count % 3;
  std::vector<trace::PlacementInput> placements(flat->placements.size());
  for (size_t i = 0; i < placements.size(); ++i) {
    placements[i].part = flat->partOf(uint32_t(i));
    placements[i].visibility = flat->kinds[flat->placements[i].kind].visibility;
    placements[i].member = flat->memberOf(uint32_t(i));
  }
  trace::BuildCounters counters;
  trace(*trace::World::build(std::move(shapes), flat->parts, std::move(placements), options, nullptr, counters,
                             flat->solids));
  return count;
}

}  // namespace

size_t buildWorldInput(std::string_view bytes) {
  const RibInput in = splitInput(bytes);  // without its further files: rib_input.cpp is for those
  rib::ReadOptions options;
  options.maxArchiveDepth = 4;
  options.maxArchiveReads = 20;
  Diagnostics silent([](const std::string&, Severity) {});
  int worlds = 0;
  size_t count = 0;
  rib::RibReader reader(silent, options, [&](scene::Scene&& s) {
    if (++worlds > 2) return;
    scene::Scene kept = std::move(s);
    count += build(kept);
  });
  reader.readString("main.rib", in.main);
  reader.finish();
  return count;
}

}  // namespace kinora::fuzz
