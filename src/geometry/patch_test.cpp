// Proves patches against closed forms (a rational sphere and cylinder, bases against each other), that pieces meet
// without cracks, and the primvar counts of each class.
#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {

using namespace testing;

scene::PatchMesh patchMesh(bool bicubic, int nu, bool uPeriodic, int nv, bool vPeriodic) {
  return {bicubic, uPeriodic, vPeriodic, nu, nv};
}
void expectNormalsOnTheFront(const Mesh& m) {
  const Primvar* n = m.find("N");
  ASSERT_NE(n, nullptr);
  for (uint32_t t = 0; t < m.triangleCount(); ++t) {
    const auto c = corners(m, t);
    const V3d face = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
    for (int k = 0; k < 3; ++k) {
      const float* v = &n->data[size_t(m.indices[3 * t + k]) * 3];
      ASSERT_NEAR(V3d(v[0], v[1], v[2]).length(), 1, 1e-5);
      ASSERT_GT(V3d(v[0], v[1], v[2]).dot(face), 0.5);
    }
  }
}

TEST(Patch, BilinearIsTwoTrianglesWhenFlat) {
  scene::Primitive p = primitive(scene::Patch{false});
  p.primvars.set(points({0, 0, 0, 2, 0, 0, 0, 3, 0, 2, 3, 0}));
  p.primvars.set(parameter("x", StorageClass::Varying, ValueType::Float, {0, 1, 2, 3}));
  const Mesh m = made(p);
  EXPECT_EQ(m.triangleCount(), 2u);
  EXPECT_NEAR(area(m), 6, 1e-6);
  for (uint32_t i = 0; i < 4; ++i) EXPECT_EQ(m.find("x")->data[i], m.vertexUV[i].x + 2 * m.vertexUV[i].y);
  // (u, v) = (0,0), (1,0): dPdu along x, dPdv along y, so the front is +z.
  EXPECT_GT(m.find("N")->data[2], 0.999);
}

TEST(Patch, HyperbolicParaboloidIsCurved) {
  scene::Primitive p = primitive(scene::Patch{false});
  p.primvars.set(points({0, 0, 0, 1, 0, 1, 0, 1, 1, 1, 1, 0}));
  const Mesh m = made(p, edge(0.001));
  EXPECT_GT(m.triangleCount(), 50u);
  for (uint32_t i = 0; i < m.vertexCount; ++i) {
    const V3d q = vertex(m, i);
    ASSERT_NEAR(q.z, q.x + q.y - 2 * q.x * q.y, 1e-6);
  }
  expectNormalsOnTheFront(m);
}

TEST(Patch, BezierPatchMatchesItsPolynomial) {
  // x and y linear, z = 9 u (1 - u) (from control heights 0 3 3 0): exact everywhere.
  scene::Primitive p = primitive(scene::Patch{true});
  std::vector<float> c;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) c.insert(c.end(), {float(i), float(j), i == 1 || i == 2 ? 3.f : 0.f});
  p.primvars.set(points(c));
  std::vector<float> heights;
  for (int i = 0; i < 16; ++i) heights.push_back(c[3 * i + 2]);
  p.primvars.set(parameter("h", StorageClass::Vertex, ValueType::Float, heights));
  const Mesh m = made(p);
  for (uint32_t i = 0; i < m.vertexCount; ++i) {
    const double u = m.vertexUV[i].x;
    ASSERT_NEAR(vertex(m, i).x, 3 * u, 1e-6);
    ASSERT_NEAR(vertex(m, i).z, 9 * u * (1 - u), 1e-5);
    ASSERT_NEAR(m.find("h")->data[i], 9 * u * (1 - u), 1e-5);
  }
  expectNormalsOnTheFront(m);
}

TEST(Patch, PeriodicBSplineTubeClosesWithoutCracks) {
  // 8 x 4 controls, periodic in u: a tube; its open ends are the only open edges.
  scene::Primitive p = primitive(patchMesh(true, 8, true, 6, false));
  edit(p, [](scene::Attributes& a) {
    a.uBasis =
        a.vBasis = {-1 / 6.f, .5f, -.5f, 1 / 6.f, .5f, -1, .5f, 0, -.5f, 0, .5f, 0, 1 / 6.f, 4 / 6.f, 1 / 6.f, 0};
    a.uStep = a.vStep = 1;
  });
  std::vector<float> c, part;
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < 8; ++i)
      c.insert(c.end(), {float(std::cos(i * kPi / 4)), float(std::sin(i * kPi / 4)), float(j)});
  p.primvars.set(points(c));
  for (int i = 0; i < 24; ++i) part.push_back(float(i));
  p.primvars.set(parameter("part", StorageClass::Uniform, ValueType::Float, part));
  std::vector<float> around(8 * 4);
  for (int i = 0; i < 32; ++i) around[i] = float(i / 8);
  p.primvars.set(parameter("row", StorageClass::Varying, ValueType::Float, around));
  const Mesh m = made(p, edge(0.05));
  const EdgeCount e = edges(m);
  EXPECT_EQ(e.wrong, 0u);
  size_t ends = 0;
  for (uint32_t t = 0; t < m.triangleCount(); ++t) {
    EXPECT_LT(m.faceOf(t), 24u);
    for (int k = 0; k < 3; ++k) {
      const V3d a = vertex(m, m.indices[3 * t + k]), b = vertex(m, m.indices[3 * t + (k + 1) % 3]);
      ends += std::abs(a.z - b.z) < 1e-6 && (std::abs(a.z - 1) < 1e-5 || std::abs(a.z - 4) < 1e-5);
    }
  }
  EXPECT_EQ(e.open, ends);
  for (uint32_t i = 0; i < m.vertexCount; ++i) ASSERT_NEAR(m.find("row")->data[i], vertex(m, i).z - 1, 1e-5);
  expectNormalsOnTheFront(m);
}

TEST(Patch, BasesAgreeOnTheSameCurve) {
  // Catmull-Rom controls and the Bezier controls of the same surface: z = f(x), extruded.
  const float y[5] = {0, 1, -1, 2, 0};
  scene::Primitive rom = primitive(patchMesh(true, 5, false, 4, false));
  edit(rom, [](scene::Attributes& a) {
    a.uBasis = a.vBasis = {-.5f, 1.5f, -1.5f, .5f, 1, -2.5f, 2, -.5f, -.5f, 0, .5f, 0, 0, 1, 0, 0};
    a.uStep = a.vStep = 1;
  });
  std::vector<float> c;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 5; ++i) c.insert(c.end(), {float(i), float(j), y[i]});
  rom.primvars.set(points(c));
  scene::Primitive bezier = primitive(patchMesh(true, 7, false, 4, false));
  c.clear();
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 7; ++i) {
      const int at = 1 + i / 3;  // Catmull-Rom points 1, 2, 3 are passed; tangents (next - before) / 2
      auto tangent = [&](int k) { return (y[k + 1] - y[k - 1]) / 2; };
      const float z = i % 3 == 0 ? y[at] : i % 3 == 1 ? y[at] + tangent(at) / 3 : y[at + 1] - tangent(at + 1) / 3;
      c.insert(c.end(), {1 + i / 3.f, 1 + j / 3.f, z});
    }
  bezier.primvars.set(points(c));
  const Mesh a = made(rom, edge(0.01)), b = made(bezier, edge(0.01));
  ASSERT_EQ(a.vertexCount, b.vertexCount);
  for (uint32_t i = 0; i < a.vertexCount; ++i) ASSERT_LT((vertex(a, i) - vertex(b, i)).length(), 1e-5);
}

TEST(Patch, BasesWhoseWeightsDoNotSumToOne) {
  // x and y along 0..2 and 0..3 in each piece: as ends and tangents (hermite), and as coefficients (power). The
  // plane's area, corners and parameters are those of the rectangle whatever the sums of the weights are.
  scene::Primitive hermite = primitive(patchMesh(true, 4, false, 4, false));
  edit(hermite, [](scene::Attributes& a) {
    a.uBasis = a.vBasis = {2, 1, -2, 1, -3, -2, 3, -1, 0, 1, 0, 0, 1, 0, 0, 0};
    a.uStep = a.vStep = 2;
  });
  // u: end 0, tangent, end 1, tangent; the mixed terms are zero tangents of tangents
  const float x[4] = {0, 2, 2, 2}, y[4] = {0, 3, 3, 3}, end[4] = {1, 0, 1, 0};
  std::vector<float> c;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) c.insert(c.end(), {x[i] * end[j], y[j] * end[i], 0});
  hermite.primvars.set(points(c));
  scene::Primitive power = primitive(scene::Patch{true});
  edit(power, [](scene::Attributes& a) {
    a.uBasis = a.vBasis = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    a.uStep = a.vStep = 4;
  });
  c.assign(16 * 3, 0.f);
  c[3 * 14] = 2;      // u
  c[3 * 11 + 1] = 3;  // v
  power.primvars.set(points(c));
  for (const scene::Primitive& p : {hermite, power}) {
    const Mesh m = made(p, edge(0.1));
    EXPECT_NEAR(area(m), 6, 1e-5);
    for (uint32_t i = 0; i < m.vertexCount; ++i) {
      const V3d q = vertex(m, i);
      EXPECT_NEAR(q.x, 2 * double(m.vertexUV[i].x), 1e-5);
      EXPECT_NEAR(q.y, 3 * double(m.vertexUV[i].y), 1e-5);
    }
    EXPECT_GT(m.find("N")->data[2], 0.999);
  }
  // Two pieces of the power basis need not meet: z is 0 on the first and 1 on the second.
  scene::Primitive two = primitive(patchMesh(true, 8, false, 4, false));
  two.attributes = power.attributes;
  c.assign(32 * 3, 0.f);
  for (const int piece : {0, 1}) {
    const auto at = [&](int u, int v) { return &c[3 * size_t(8 * v + 4 * piece + u)]; };
    at(2, 3)[0] = 1;
    at(3, 2)[1] = 1;
    at(3, 3)[0] = float(piece);
    at(3, 3)[2] = float(piece);
  }
  two.primvars.set(points(c));
  EXPECT_NEAR(area(made(two)), 2, 1e-5);
}

TEST(Patch, NurbsSphereAndItsPoles) {
  // The usual 9 x 5 rational quadratic sphere: poles drawn together, a seam, weights sqrt(1/2).
  scene::NuPatch n;
  n.nu = 9, n.uOrder = 3, n.nv = 5, n.vOrder = 3;
  n.uKnots = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
  n.vKnots = {0, 0, 0, 1, 1, 2, 2, 2};
  n.uMin = 0, n.uMax = 4, n.vMin = 0, n.vMax = 2;
  const double h = std::sqrt(0.5);
  const double circle[9][3] = {{1, 0, 1},   {1, 1, h},  {0, 1, 1},  {-1, 1, h}, {-1, 0, 1},
                               {-1, -1, h}, {0, -1, 1}, {1, -1, h}, {1, 0, 1}};
  const double half[5][3] = {{0, -1, 1}, {1, -1, h}, {1, 0, 1}, {1, 1, h}, {0, 1, 1}};
  std::vector<float> pw;
  for (const auto& v : half)
    for (const auto& u : circle) {
      const double w = u[2] * v[2];
      pw.insert(pw.end(), {float(u[0] * v[0] * w), float(u[1] * v[0] * w), float(v[1] * w), float(w)});
    }
  scene::Primitive p = primitive(n);
  p.primvars.set(parameter("Pw", StorageClass::Vertex, ValueType::HPoint, pw));
  const Mesh m = made(p, edge(0.01));
  const Primvar* normals = m.find("N");
  for (uint32_t i = 0; i < m.vertexCount; ++i) {
    ASSERT_NEAR(vertex(m, i).length(), 1, 1e-6);
    const V3d normal(normals->data[3 * i], normals->data[3 * i + 1], normals->data[3 * i + 2]);
    ASSERT_GT(normal.dot(vertex(m, i)), 0.999);
  }
  EXPECT_NEAR(area(m) / (4 * kPi), 1, 3e-3);
  EXPECT_NEAR(volume(m) / (4 * kPi / 3), 1, 5e-3);
  // Half the range in u: half the sphere, and trim curves that are no such thing are told about.
  n.uMax = 2;
  n.trim.set(parameter("ncurves", StorageClass::Constant, ValueType::Float, {1}));
  p.shape = n;
  Quiet d;
  EXPECT_NEAR(area(*tessellate(p, edge(0.01), d)) / (2 * kPi), 1, 3e-3);
  EXPECT_EQ(d.count("GEOM-TRIM"), 1u);
}

TEST(Patch, PeriodicStripOfTwoPointsGoesThereAndBack) {
  scene::Primitive p = primitive(patchMesh(false, 2, true, 2, false));
  p.primvars.set(points({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}));
  EXPECT_NEAR(area(made(p)), 2, 1e-6);
}

TEST(Patch, BadInputTable) {
  const std::vector<float> four{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  std::vector<float> bad = four;
  bad[4] = std::nanf("");
  scene::NuPatch knots;
  knots.nu = knots.nv = knots.uOrder = knots.vOrder = 2;
  knots.uKnots = knots.vKnots = {0, 0, 1, 1};
  scene::NuPatch reversed = knots, few = knots, order = knots, range = knots;
  reversed.uKnots = {0, 1, 0, 1};
  few.vKnots = {0, 1};
  order.uOrder = 2000000000;
  range.uMin = 3, range.uMax = 2;
  const struct {
    scene::Shape shape;
    std::vector<float> p;
    const char* code;
  } table[] = {
      {scene::Patch{true}, four, "GEOM-PATCH-SHAPE"},
      {scene::Patch{false}, bad, "GEOM-NOT-FINITE"},
      {scene::Patch{false}, {}, "GEOM-NO-POINTS"},
      {scene::Patch{false}, std::vector<float>(12, 1.f), "GEOM-ZERO-AREA"},
      {patchMesh(false, 2000000000, false, 2000000000, false), four, "GEOM-PATCH-SHAPE"},
      {patchMesh(false, -2, false, 2, false), four, "GEOM-PATCH-SHAPE"},
      {patchMesh(true, 5, false, 4, false), std::vector<float>(60, 1.f), "GEOM-PATCH-SHAPE"},
      {patchMesh(false, 1, false, 4, false), four, "GEOM-PATCH-SHAPE"},
      {reversed, four, "GEOM-PATCH-SHAPE"},
      {few, four, "GEOM-PATCH-SHAPE"},
      {order, four, "GEOM-PATCH-SHAPE"},
      {range, four, "GEOM-PATCH-SHAPE"},
  };
  for (const auto& row : table) {
    scene::Primitive p = primitive(row.shape);
    if (!row.p.empty()) p.primvars.set(points(row.p));
    Quiet d;
    EXPECT_FALSE(tessellate(p, {}, d).has_value()) << "row " << (&row - table);
    EXPECT_EQ(d.count(row.code), 1u) << "row " << (&row - table);
  }
}

TEST(Tessellate, KindsOfLaterIssuesAreToldByKind) {
  Quiet d;
  EXPECT_FALSE(tessellate(primitive(scene::OtherPrimitive{"Later", {}}), {}, d).has_value());
  EXPECT_EQ(d.count("GEOM-NOT-RENDERED-YET-LATER"), 1u);
  EXPECT_EQ(d.warnings(), 1u);
  for (const char* told : {"Procedural", "Procedural2"}) {  // by the reader
    EXPECT_FALSE(tessellate(primitive(scene::OtherPrimitive{told, {}}), {}, d).has_value()) << told;
    EXPECT_EQ(d.warnings(), 1u) << told;
  }
}

TEST(Tessellate, EveryCodeIsExplained) {
  Explanations all;
  all.add(explanations());
  for (const char* code :
       {"GEOM-FACE-AREA", "GEOM-FACE-CORNERS", "GEOM-FACE-LIST", "GEOM-FACE-TANGLED", "GEOM-INDEX-RANGE",
        "GEOM-MOTION-MISMATCH", "GEOM-NO-POINTS", "GEOM-NORMAL", "GEOM-NORMALS-TURNED", "GEOM-NOT-FINITE",
        "GEOM-NOT-RENDERED-YET-CURVES", "GEOM-PATCH-SHAPE", "GEOM-PRIMVAR", "GEOM-PRIMVAR-COUNT",
        "GEOM-SUBDIVISION-CAGE", "GEOM-TAG", "GEOM-TOO-LARGE", "GEOM-TRIM", "GEOM-ZERO-AREA"}) {
    const Explanation* e = all.find(code);
    ASSERT_NE(e, nullptr) << code;
    EXPECT_GT(e->text.size(), 60u) << code;
  }
}

}  // namespace
}  // namespace kinora::geometry
