// Proves the scalar reference formulas on meshes whose answers are known by hand.
#include "geometry/surface.h"
#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {

using namespace testing;
using scene::StorageClass;
using scene::ValueType;

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
