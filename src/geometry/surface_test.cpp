// Proves the scalar reference formulas on meshes whose answers are known by hand.
#include "geometry/surface.h"
#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {

using namespace testing;

TEST(Surface, DerivativesOverAQuadAreThoseOfThePlane) {
  // P = (3 u, 2 v, u) over a quad; heat = 5 u - 7 v; both triangles must say the same.
  scene::PolygonMesh shape;
  shape.verticesPerLoop = {4};
  shape.vertices = {0, 1, 2, 3};
  scene::Primitive p = primitive(shape);
  p.primvars.set(points({0, 0, 0, 3, 0, 1, 3, 2, 1, 0, 2, 0}));
  p.primvars.set(parameter("heat", StorageClass::FaceVarying, ValueType::Float, {0, 5, -2, -7}));
  p.primvars.set(parameter("part", StorageClass::Uniform, ValueType::Float, {4}));
  Quiet d;
  const Mesh m = *tessellate(p, {}, d);
  for (uint32_t t = 0; t < 2; ++t) {
    const SurfacePoint s = surfacePoint(m, t, 0.25, 0.5);
    EXPECT_NEAR((s.dPdu - V3d(3, 0, 1)).length(), 0, 1e-6);
    EXPECT_NEAR((s.dPdv - V3d(0, 2, 0)).length(), 0, 1e-6);
    EXPECT_NEAR((s.position - V3d(3 * s.uv.x, 2 * s.uv.y, s.uv.x)).length(), 0, 1e-6);
    EXPECT_NEAR((s.geometric - V3d(-2, 0, 6)).length(), 0, 1e-6);
    EXPECT_NEAR((s.shading - V3d(-2, 0, 6).normalized()).length(), 0, 1e-6);
    const PrimvarPoint h = primvarAt(m, *m.find("heat"), t, 0.25, 0.5);
    EXPECT_NEAR(h.value[0], 5 * s.uv.x - 7 * s.uv.y, 1e-5);
    EXPECT_NEAR(h.du[0], 5, 1e-5);
    EXPECT_NEAR(h.dv[0], -7, 1e-5);
    EXPECT_EQ(primvarAt(m, *m.find("part"), t, 0.25, 0.5).value[0], 4);
    EXPECT_EQ(primvarAt(m, *m.find("part"), t, 0.25, 0.5).du[0], 0);
  }
}

TEST(Surface, SphereDerivativesMatchTheClosedForm) {
  Quiet d;
  const Mesh m = *tessellate(quadric(scene::Quadric::Kind::Sphere, {2, -2, 2, 360}), {}, d);
  const double pi = 3.141592653589793;
  for (uint32_t t = 0; t < m.triangleCount(); t += 37) {
    const SurfacePoint s = surfacePoint(m, t, 1 / 3.0, 1 / 3.0);
    if (s.uv.y < 0.25 || s.uv.y > 0.75) continue;  // chords and tangents part towards the poles
    const double a = 2 * pi * s.uv.x, b = pi * (s.uv.y - 0.5);
    const V3d du(-4 * pi * std::sin(a) * std::cos(b), 4 * pi * std::cos(a) * std::cos(b), 0);
    const V3d dv(-2 * pi * std::cos(a) * std::sin(b), -2 * pi * std::sin(a) * std::sin(b), 2 * pi * std::cos(b));
    ASSERT_LT((s.dPdu - du).length(), 0.03 * du.length());
    ASSERT_LT((s.dPdv - dv).length(), 0.03 * dv.length());
    ASSERT_GT(s.dPdu.cross(s.dPdv).dot(s.geometric), 0);
    ASSERT_LT((s.shading - s.position / s.position.length()).length(), 2e-3);
  }
  for (uint32_t t = 0; t < m.triangleCount(); ++t) {  // the poles too
    const SurfacePoint s = surfacePoint(m, t, 0.2, 0.3);
    ASSERT_TRUE(std::isfinite(s.dPdu.length() + s.dPdv.length() + s.shading.length()));
  }
}

TEST(Surface, PlaceOnBentQuadsIsContinuous) {
  // Over the diagonal the two triangles must agree, along each side (u, v) must be linear, at corners exact.
  std::vector<std::array<V3d, 4>> quads = {{V3d(0, 0, 0), V3d(1, 0, 0.3), V3d(1.2, 1, 0), V3d(0.1, 0.9, 0.4)},
                                           {V3d(0, 0, 0), V3d(3, 0, 0), V3d(1, 1, 0), V3d(0, 1, 0)},
                                           {V3d(0, 0, 0), V3d(1, 0, 0), V3d(1, 1, 0), V3d(1, 1, 0)},
                                           {V3d(0, 0, 0), V3d(2, 0, 0), V3d(1, 0.5, 0), V3d(0, 1, 0)},
                                           {V3d(0, 0, 1e-9), V3d(1e-9, 0, 0), V3d(1e-9, 2e-9, 0), V3d(0, 1e-9, 0)}};
  for (const auto& q : quads) {
    scene::PolygonMesh shape;
    shape.verticesPerLoop = {4};
    shape.vertices = {0, 1, 2, 3};
    scene::Primitive p = primitive(shape);
    std::vector<float> list;
    for (const V3d& v : q) list.insert(list.end(), {float(v.x), float(v.y), float(v.z)});
    p.primvars.set(points(list));
    Quiet d;
    const Mesh m = *tessellate(p, {}, d);
    for (double t = 0.05; t < 1; t += 0.1) {
      const SurfacePoint a = surfacePoint(m, 0, 0, t), b = surfacePoint(m, 1, t, 0);  // the diagonal from 0 to 2
      EXPECT_NEAR((a.uv - b.uv).length(), 0, 1e-6);
      EXPECT_NEAR((surfacePoint(m, 0, t, 0).uv - Imath::V2d(t, 0)).length(), 0, 1e-6);
      if (q[2] != q[3]) {
        EXPECT_NEAR((surfacePoint(m, 1, 1 - t, t).uv - Imath::V2d(1 - t, 1)).length(), 0, 1e-6);
      }
      EXPECT_NEAR((surfacePoint(m, 1, 0, t).uv - Imath::V2d(0, t)).length(), 0, 1e-6);
    }
  }
}

TEST(Surface, PairsOfTrianglesAreQuadsAndNothingElse) {
  // Whatever quadOf() says must be two triangles of one face that share the diagonal of a quad; where a maker cuts
  // quads most triangles must be in one, and no triangle in two.
  scene::PolygonMesh mixed;
  mixed.verticesPerLoop = {3, 4, 5, 3, 3, 6, 4};
  mixed.vertices = {0, 1, 2, 0, 2, 3, 4, 0, 4, 5, 6, 7, 0, 1, 2, 0, 2, 3, 0, 1, 2, 3, 4, 5, 0, 5, 6, 7};
  scene::Primitive polygons = primitive(mixed);
  std::vector<float> ring{0, 0, 0};
  for (int i = 0; i < 7; ++i) ring.insert(ring.end(), {float(std::cos(i * 0.8)), float(std::sin(i * 0.8)), 0});
  polygons.primvars.set(points(ring));
  scene::SubdivisionMesh cage;
  cage.scheme = "catmull-clark";
  cage.verticesPerFace = {4, 5, 3};
  cage.vertices = {0, 1, 2, 3, 1, 4, 5, 6, 2, 3, 2, 7};
  cage.tags.push_back({"interpolateboundary", {1}, {}, {}});
  scene::Primitive subdivided = primitive(cage);
  subdivided.primvars.set(points({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 2, 0, 0, 3, 1, 1, 2, 2, 0, 0, 2, 1}));
  DiceRate uneven;
  uneven.edgeLength = [](const V3d& p) { return 0.03 + 0.05 * std::abs(std::sin(7 * p.x + 3 * p.y)); };
  scene::Primitive bicubic = primitive(scene::Patch{true});
  std::vector<float> c;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      c.insert(c.end(), {float(i) * float(j), float(j), float((i * j) % 3)});  // a side is a point
  bicubic.primvars.set(points(c));
  const struct {
    scene::Primitive p;
    double least;  // share of triangles in quads
  } table[] = {{polygons, 0.2},
               {subdivided, 0.5},
               {bicubic, 0.9},
               {quadric(scene::Quadric::Kind::Sphere, {1, -1, 1, 360}), 0.9}};
  for (const auto& row : table) {
    Quiet d;
    const Mesh m = *tessellate(row.p, uneven, d);
    uint32_t in = 0;
    std::map<uint32_t, int> halves;
    for (uint32_t t = 0; t < m.triangleCount(); ++t) {
      const uint32_t first = m.quadOf(t);
      if (first == Mesh::kNoQuad) continue;
      ++in;
      ++halves[first];
      ASSERT_TRUE(t == first || t == first + 1);
      ASSERT_EQ(m.faceOf(first), m.faceOf(first + 1));
      const uint32_t* i = &m.indices[3 * size_t(first)];
      ASSERT_TRUE(i[0] == i[3] && i[2] == i[4]);
      // patch parameters go around the quad, so that the bilinear mixture has no fold
      double area = 0;
      const auto uv = [&](int k) { return Imath::V2d(m.uvOf(first + uint32_t(k == 3), k == 3 ? 2 : k)); };
      for (int k = 0; k < 4; ++k) area += uv(k).cross(uv((k + 1) % 4)) / 2;
      ASSERT_GT(area, 0);
    }
    for (const auto& [first, n] : halves) ASSERT_EQ(n, 2) << first;
    EXPECT_GE(double(in), row.least * m.triangleCount());
  }
  // faces of 4, 4 corners among the seven; those of more or fewer have none
  Quiet d;
  const Mesh m = *tessellate(polygons, {}, d);
  for (uint32_t t = 0; t < m.triangleCount(); ++t)
    EXPECT_EQ(m.quadOf(t) != Mesh::kNoQuad, m.faceOf(t) == 1 || m.faceOf(t) == 6) << t;
}

TEST(Surface, TimesBetweenKeys) {
  scene::Primitive p = primitive(scene::PolygonMesh{});
  p.primvars.set(points({0, 0, 0, 1, 0, 0, 0, 1, 0}));
  p.primvars.set(parameter("N", StorageClass::Varying, ValueType::Normal, {0, 0, 1, 0, 0, 1, 0, 0, 1}));
  p.times = {0, 1, 3};
  p.motion.resize(2);
  p.motion[0].set(points({0, 0, 2, 1, 0, 2, 0, 1, 2}));
  p.motion[1].set(points({0, 0, 4, 1, 0, 4, 0, 1, 4}));
  p.motion[1].set(parameter("N", StorageClass::Varying, ValueType::Normal, {1, 0, 0, 1, 0, 0, 1, 0, 0}));
  Quiet d;
  const Mesh m = *tessellate(p, {}, d);
  for (const auto& [time, z] : std::vector<std::pair<double, double>>{{-1, 0}, {0.5, 1}, {1, 2}, {2, 3}, {9, 4}})
    EXPECT_NEAR(surfacePoint(m, 0, 0.3, 0.3, blendAt(m, time)).position.z, z, 1e-9) << time;
  EXPECT_NEAR(surfacePoint(m, 0, 0.3, 0.3, blendAt(m, 2)).shading.x, std::sqrt(0.5), 1e-6);
}

}  // namespace
}  // namespace kinora::geometry
