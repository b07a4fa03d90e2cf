// Proves the quadrics against closed forms (area, volume, outline, normals, parameters) and that closed ones are
// watertight. It does not look at how they shade.
#include <ImathMatrix.h>

#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {

using namespace testing;
using Kind = scene::Quadric::Kind;

// Every vertex has a unit normal on the side of e1 x e2 of its triangles (flat wedges deviate by less than 60
// degrees).
void expectNormals(const Mesh& m) {
  const Primvar* n = m.find("N");
  ASSERT_NE(n, nullptr);
  ASSERT_EQ(n->data.size(), size_t(m.vertexCount) * 3 * m.keyCount());
  for (uint32_t t = 0; t < m.triangleCount(); ++t) {
    const auto c = corners(m, t);
    V3d face = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
    if (m.flipNormals) face = -face;
    for (int k = 0; k < 3; ++k) {
      const float* v = &n->data[size_t(m.indices[3 * t + k]) * 3];
      const V3d normal(v[0], v[1], v[2]);
      ASSERT_NEAR(normal.length(), 1, 1e-6);
      ASSERT_GT(normal.dot(face), 0.5) << "triangle " << t;
    }
  }
}

struct Case {
  const char* name;
  Kind kind;
  std::array<float, 7> args;
  double area, volume;  // volume: with e1 x e2 outward; 0 when the surface is open
};

const Case kCases[] = {
    {"sphere", Kind::Sphere, {2, -2, 2, 360}, 16 * kPi, 32 * kPi / 3},
    {"half sphere", Kind::Sphere, {1, 0, 1, 360}, 2 * kPi, 0},
    {"sphere zone, quarter sweep", Kind::Sphere, {1, -0.5f, 0.25f, 90}, 2 * kPi * 0.75 / 4, 0},
    {"sphere with zmin below -radius", Kind::Sphere, {1, -5, 5, 360}, 4 * kPi, 4 * kPi / 3},
    {"cone", Kind::Cone, {2, 1, 360}, kPi* std::sqrt(5.0), 0},
    {"cylinder", Kind::Cylinder, {1.5f, -1, 2, 360}, 2 * kPi * 1.5 * 3, 0},
    {"cylinder half", Kind::Cylinder, {1.5f, -1, 2, 180}, kPi * 1.5 * 3, 0},
    {"cone frustum as hyperboloid", Kind::Hyperboloid, {2, 0, 0, 1, 0, 1, 360}, kPi * 3 * std::sqrt(2.0), 0},
    {"disk", Kind::Disk, {3, 2, 360}, 4 * kPi, 0},
    {"disk sector", Kind::Disk, {3, 2, 45}, kPi / 2, 0},
    // (pi r / 6 h^2) ((r^2 + 4 h^2)^1.5 - r^3) with r = 1, h = 1
    {"paraboloid", Kind::Paraboloid, {1, 0, 1, 360}, kPi / 6 * (std::pow(5.0, 1.5) - 1), 0},
    {"torus", Kind::Torus, {3, 1, 0, 360, 360}, 12 * kPi* kPi, 6 * kPi* kPi},
    {"torus quarter", Kind::Torus, {3, 1, 0, 360, 90}, 3 * kPi* kPi, 0},
};

TEST(Quadric, AreaVolumeNormalsAndWatertightness) {
  for (const Case& c : kCases) {
    SCOPED_TRACE(c.name);
    const Mesh m = made(quadric(c.kind, c.args));
    EXPECT_NEAR(area(m) / c.area, 1, 1e-3);
    EXPECT_LE(area(m), c.area * (1 + 1e-6));
    expectNormals(m);
    const EdgeCount e = edges(m);
    EXPECT_EQ(e.wrong, 0u);
    if (c.volume > 0) {
      EXPECT_EQ(e.open, 0u);
      EXPECT_NEAR(volume(m) / c.volume, 1, 1.2e-3);
    } else {
      EXPECT_GT(e.open, 0u);
    }
  }
}

TEST(Quadric, HyperboloidOfOneSheet) {
  // The line (1, -1, -1)..(1, 1, 1) sweeps x^2 + y^2 = 1 + z^2.
  const Mesh m = made(quadric(Kind::Hyperboloid, {1, -1, -1, 1, 1, 1, 360}));
  for (uint32_t i = 0; i < m.vertexCount; ++i) {
    const V3d p = vertex(m, i);
    ASSERT_NEAR(p.x * p.x + p.y * p.y, 1 + p.z * p.z, 1e-5);
  }
  // 2 pi times the integral of sqrt(1 + 2 z^2) over -1..1.
  const double exact = 2 * kPi * (std::sqrt(3.0) + std::asinh(std::sqrt(2.0)) / std::sqrt(2.0));
  EXPECT_NEAR(area(m) / exact, 1, 2e-3);
  expectNormals(m);
}

TEST(Quadric, OutlineOfASphereWithinHalfAPerMille) {
  const Mesh m = made(quadric(Kind::Sphere, {1, -1, 1, 360}));
  double worst = 0;
  for (int i = 0; i < 400; ++i) {
    const double z = -1 + 2 * (i + 0.5) / 400, a = i * 2.399963, r = std::sqrt(1 - z * z);
    worst = std::max(worst, 1 - silhouette(m, V3d(r * std::cos(a), r * std::sin(a), z)) / kPi);
  }
  for (const V3d& d : {V3d(0, 0, 1), V3d(1, 0, 0), V3d(std::cos(kPi / 160), std::sin(kPi / 160), 0)})
    worst = std::max(worst, 1 - silhouette(m, d) / kPi);
  EXPECT_GT(worst, 0);
  EXPECT_LT(worst, 5e-4);
}

TEST(Quadric, DiceRateFollowsTheSizeOnScreen) {
  auto triangles = [](double edge) {
    DiceRate rate;
    rate.edgeLength = [=](const V3d&) { return edge; };
    return made(quadric(Kind::Sphere, {1, -1, 1, 360}), rate).triangleCount();
  };
  EXPECT_LT(triangles(1.0), 1000u);                 // one pixel
  EXPECT_LT(triangles(0.1), triangles(0.01));       // 10 and 100 pixels
  EXPECT_EQ(triangles(0.01), triangles(0.02));      // both at the plain minimum
  EXPECT_GT(triangles(1e-3), 2 * triangles(0.01));  // 1,000 pixels
  DiceRate fine;
  fine.edgeLength = [](const V3d&) { return 1e-9; };
  fine.maxTriangles = 100000;
  const uint32_t capped = made(quadric(Kind::Sphere, {1, -1, 1, 360}), fine).triangleCount();
  EXPECT_LE(capped, 100000u);
  EXPECT_GT(capped, 80000u);
  DiceRate broken;
  broken.edgeLength = [](const V3d&) { return std::nan(""); };
  EXPECT_EQ(made(quadric(Kind::Sphere, {1, -1, 1, 360}), broken).triangleCount(), triangles(0.01));
}

TEST(Quadric, ParametersRunAsTheRibSays) {
  // Sphere: u = theta / thetamax, v = latitude from zmin to zmax.
  const Mesh m = made(quadric(Kind::Sphere, {2, -1, 2, 180}));
  const double low = std::asin(-0.5), high = kPi / 2;
  size_t checked = 0;
  for (uint32_t i = 0; i < m.vertexCount; ++i) {
    const double theta = m.vertexUV[i].x * kPi, phi = low + (high - low) * m.vertexUV[i].y;
    const V3d exact(2 * std::cos(theta) * std::cos(phi), 2 * std::sin(theta) * std::cos(phi), 2 * std::sin(phi));
    ASSERT_LT((vertex(m, i) - exact).length(), 1e-6);
    ++checked;
  }
  EXPECT_GT(checked, 1000u);
  const Mesh disk = made(quadric(Kind::Disk, {1, 2, 360}));
  for (uint32_t i = 0; i < disk.vertexCount; ++i)
    ASSERT_NEAR(std::hypot(vertex(disk, i).x, vertex(disk, i).y), 2 * (1 - disk.vertexUV[i].y), 1e-6);
  const Mesh paraboloid = made(quadric(Kind::Paraboloid, {1, 0.5f, 2, 360}));
  for (uint32_t i = 0; i < paraboloid.vertexCount; ++i)
    ASSERT_NEAR(vertex(paraboloid, i).z, 0.5 + 1.5 * paraboloid.vertexUV[i].y, 1e-6);
}

TEST(Quadric, FourValuesAreBilinear) {
  scene::Primitive p = quadric(Kind::Cylinder, {1, 0, 1, 360});
  p.primvars.set(parameter("heat", scene::StorageClass::Varying, scene::ValueType::Float, {1, 2, 3, 5}));
  p.primvars.set(parameter("tint", scene::StorageClass::Uniform, scene::ValueType::Color, {0.1f, 0.2f, 0.3f}));
  p.primvars.set(parameter("s", scene::StorageClass::Varying, scene::ValueType::Float, {0, 1, 0, 1}));
  p.primvars.set(parameter("t", scene::StorageClass::Varying, scene::ValueType::Float, {0, 0, 2, 2}));
  const Mesh m = made(p);
  const Primvar *heat = m.find("heat"), *tint = m.find("tint"), *st = m.find("st");
  ASSERT_TRUE(heat && tint && st);
  EXPECT_EQ(heat->rate, Primvar::Rate::PerVertex);
  EXPECT_EQ(tint->rate, Primvar::Rate::Constant);
  EXPECT_EQ(tint->data, (std::vector<float>{0.1f, 0.2f, 0.3f}));
  for (uint32_t i = 0; i < m.vertexCount; ++i) {
    const double u = m.vertexUV[i].x, v = m.vertexUV[i].y;
    ASSERT_NEAR(heat->data[i], (1 - v) * (1 + u) + v * (3 + 2 * u), 1e-5);
    ASSERT_NEAR(st->data[2 * i], u, 1e-6);
    ASSERT_NEAR(st->data[2 * i + 1], 2 * v, 1e-6);
  }
}

TEST(Quadric, TextureCoordinatesAttribute) {
  scene::Primitive p = quadric(Kind::Disk, {0, 1, 360});
  EXPECT_EQ(made(p).find("st"), nullptr);  // (u, v) are meant
  edit(p, [](scene::Attributes& a) { a.textureCoordinates = {0, 0, 3, 0, 0, 5, 3, 5}; });
  const Mesh m = made(p);
  const Primvar* st = m.find("st");
  ASSERT_NE(st, nullptr);
  for (uint32_t i = 0; i < m.vertexCount; ++i) ASSERT_NEAR(st->data[2 * i + 1], 5 * m.vertexUV[i].y, 1e-5);
}

TEST(Quadric, MovingArgumentsGiveKeys) {
  scene::Primitive p = quadric(Kind::Sphere, {1, -1, 1, 360});
  p.times = {0, 1};
  p.motion.resize(1);
  p.motion[0].set(parameter("__quadric", scene::StorageClass::Constant, scene::ValueType::Float, {2, -2, 2, 360}, 4));
  const Mesh m = made(p);
  ASSERT_EQ(m.keyCount(), 2);
  ASSERT_EQ(m.points.size(), 2 * size_t(m.vertexCount));
  for (uint32_t i = 0; i < m.vertexCount; ++i) ASSERT_LT((vertex(m, i, 1) - 2.0 * vertex(m, i)).length(), 1e-6);
  EXPECT_EQ(m.find("N")->data.size(), 6 * size_t(m.vertexCount));
  EXPECT_NEAR(m.bounds.max.x, 2, 1e-6);
}

TEST(Quadric, BadInputIsToldAndLeftOut) {
  const float nan = std::nanf(""), inf = INFINITY;
  const struct {
    Kind kind;
    std::array<float, 7> args;
    const char* code;
  } table[] = {
      {Kind::Sphere, {0, 0, 0, 360}, "GEOM-ZERO-AREA"},
      {Kind::Sphere, {1, 0.5f, 0.5f, 360}, "GEOM-ZERO-AREA"},
      {Kind::Sphere, {1, -1, 1, 0}, "GEOM-ZERO-AREA"},
      {Kind::Sphere, {nan, -1, 1, 360}, "GEOM-NOT-FINITE"},
      {Kind::Cylinder, {1, 0, inf, 360}, "GEOM-NOT-FINITE"},
      {Kind::Cylinder, {1, 2, 2, 360}, "GEOM-ZERO-AREA"},
      {Kind::Cone, {1, 0, 360}, "GEOM-ZERO-AREA"},
      {Kind::Disk, {1, 0, 360}, "GEOM-ZERO-AREA"},
      {Kind::Paraboloid, {1, -1, 1, 360}, "GEOM-ZERO-AREA"},
      {Kind::Paraboloid, {1, 0, 0, 360}, "GEOM-ZERO-AREA"},
      {Kind::Torus, {1, 0, 0, 360, 360}, "GEOM-ZERO-AREA"},
      {Kind::Hyperboloid, {0, 0, 0, 0, 0, 1, 360}, "GEOM-ZERO-AREA"},
  };
  for (const auto& row : table) {
    Quiet d;
    EXPECT_FALSE(tessellate(quadric(row.kind, row.args), {}, d).has_value());
    EXPECT_EQ(d.count(row.code), 1u) << row.code;
  }
  // Odd but legal: negative radius, more than a full turn, reversed z, spindle torus.
  for (const auto& p : {quadric(Kind::Sphere, {-1, -1, 1, 360}), quadric(Kind::Sphere, {1, -1, 1, 1e9f}),
                        quadric(Kind::Cylinder, {1, 1, 0, -90}), quadric(Kind::Torus, {0.5f, 1, 0, 360, 360}),
                        quadric(Kind::Cone, {0, 1, 360}), quadric(Kind::Sphere, {1e-30f, -1, 1, 360})}) {
    Quiet d;
    const auto m = tessellate(p, {}, d);
    ASSERT_TRUE(m.has_value());
    for (const V3f& v : m->points) ASSERT_TRUE(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z));
  }
}

// ---- orientation ----

// The object-space geometric normal at a vertex with x > 0.9, of a unit sphere.
double outwardness(const scene::Primitive& p, bool worldMirrored = false) {
  Quiet d;
  DiceRate rate;
  rate.worldMirrored = worldMirrored;
  const auto m = tessellate(p, rate, d);
  double sum = 0;
  for (uint32_t t = 0; t < m->triangleCount(); ++t) {
    const auto c = corners(*m, t);
    const V3d n = (c[1] - c[0]).cross(c[2] - c[0]) * (m->flipNormals ? -1 : 1);
    sum += n.dot(c[0]) > 0 ? 1 : -1;
  }
  // The shading normals agree with it everywhere.
  const Primvar* n = m->find("N");
  const float* v = &n->data[3];
  EXPECT_GT(V3d(v[0], v[1], v[2]).dot(vertex(*m, 1)) * sum, 0);
  return sum / m->triangleCount();
}

TEST(Orientation, TableForAQuadric) {
  using O = scene::Attributes::Orientation;
  Imath::M44d mirror;
  mirror.setScale(V3d(1, 1, -1));
  const struct {
    O orientation;
    bool reverse, mirrored, worldMirrored;
    int outward;  // of the object-space normal; 1 or -1
  } table[] = {
      // "outside" and "inside" follow the object's own space, whatever mirrors it later.
      {O::Outside, false, false, false, 1},
      {O::Outside, false, true, false, 1},
      {O::Outside, false, false, true, 1},
      {O::Outside, true, false, false, -1},
      {O::Outside, true, true, false, -1},
      {O::Inside, false, false, false, -1},
      {O::Inside, true, true, false, 1},
      // Camera space is left-handed, so "lh" is "outside" unless the camera mirrors the world, and "rh" the other way
      // round. What mirrors the object takes the orientation along.
      {O::LeftHanded, false, false, false, 1},
      {O::LeftHanded, false, true, false, 1},
      {O::LeftHanded, false, true, true, -1},
      {O::LeftHanded, true, false, false, -1},
      {O::RightHanded, false, false, false, -1},
      {O::RightHanded, false, true, false, -1},
      {O::RightHanded, false, false, true, 1},
      {O::RightHanded, true, true, false, 1},
  };
  for (const auto& row : table) {
    scene::Primitive p = quadric(Kind::Sphere, {1, -1, 1, 360});
    if (row.mirrored) p.toWorld = scene::Transform::fixed(mirror);
    edit(p, [&](scene::Attributes& a) {
      a.orientation = row.orientation;
      a.reverseOrientation = row.reverse;
    });
    EXPECT_EQ(outwardness(p, row.worldMirrored), row.outward) << "row " << (&row - table);
  }
}

TEST(Orientation, SidesDecideDoubleSided) {
  scene::Primitive p = quadric(Kind::Disk, {0, 1, 360});
  EXPECT_TRUE(made(p).doubleSided);
  edit(p, [](scene::Attributes& a) { a.sides = 1; });
  EXPECT_FALSE(made(p).doubleSided);
}

}  // namespace
}  // namespace kinora::geometry
