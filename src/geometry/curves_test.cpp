// Proves: curves of every basis become the same Bezier pieces that their own formula describes; widths, normals and
// primvars of every class go along; keys move; what does not fit is left out with one message. Misses: what is seen
// of them (tests/truth/strands_test.cpp).
#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {

using namespace testing;

scene::Primitive curves(bool cubic, bool periodic, std::vector<int> counts, std::vector<float> p) {
  scene::Primitive out = primitive(scene::Curves{cubic, periodic, std::move(counts)});
  out.primvars.set(points(std::move(p)));
  return out;
}
void setBasis(scene::Primitive& p, const std::array<float, 16>& basis, int step) {
  edit(p, [&](scene::Attributes& a) {
    a.vBasis = basis;
    a.vStep = step;
  });
}
std::optional<Mesh> make(const scene::Primitive& p, Diagnostics& d) { return tessellate(p, {}, d); }

V3d bezierAt(const Mesh& m, uint32_t piece, double s, size_t key = 0) {
  const double t = 1 - s, w[4] = {t * t * t, 3 * s * t * t, 3 * s * s * t, s * s * s};
  V3d out(0);
  for (uint32_t k = 0; k < 4; ++k) {
    const Imath::V4f& c = m.spine[key * m.vertexCount + m.indices[piece] + k];
    out += V3d(c.x, c.y, c.z) * w[k];
  }
  return out + m.origin;
}

struct NamedBasis {
  const char* name;
  std::array<float, 16> matrix;
  int step;
};
const NamedBasis kBases[] = {
    {"bezier", {-1, 3, -3, 1, 3, -6, 3, 0, -3, 3, 0, 0, 1, 0, 0, 0}, 3},
    {"b-spline",
     {-1 / 6.f, 3 / 6.f, -3 / 6.f, 1 / 6.f, 3 / 6.f, -1, 3 / 6.f, 0, -3 / 6.f, 0, 3 / 6.f, 0, 1 / 6.f, 4 / 6.f,
      1 / 6.f, 0},
     1},
    {"catmull-rom", {-0.5f, 1.5f, -1.5f, 0.5f, 1, -2.5f, 2, -0.5f, -0.5f, 0, 0.5f, 0, 0, 1, 0, 0}, 1},
    {"hermite", {2, 1, -2, 1, -3, -2, 3, -1, 0, 1, 0, 0, 1, 0, 0, 0}, 2},
    {"power", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, 4},
    {"own", {-1, 2, -1, 0.25f, 0.5f, -1, 0.5f, 0, 0.25f, 0, 0.75f, 0, 0.5f, 0.5f, 0, 0}, 3},
};

TEST(Curves, EveryBasisFollowsItsFormula) {
  for (const NamedBasis& basis : kBases)
    for (const bool periodic : {false, true}) {
      // three pieces, or as many as go around
      const int n = periodic ? 3 * std::max(basis.step, 2) * 2 : 4 + 2 * basis.step;
      std::vector<float> p;
      for (int i = 0; i < 3 * n; ++i) p.push_back(float(std::sin(1.7 * i) + 0.2 * i));
      scene::Primitive c = curves(true, periodic, {n}, p);
      setBasis(c, basis.matrix, basis.step);
      Quiet d;
      const auto m = make(c, d);
      ASSERT_TRUE(m) << basis.name;
      const int pieces = periodic ? n / basis.step : 3;
      ASSERT_EQ(int(m->primitiveCount()), pieces) << basis.name;
      for (int i = 0; i < pieces; ++i) {
        EXPECT_NEAR(m->along[size_t(i)].x, double(i) / pieces, 1e-6);
        for (const double s : {0.0, 0.2, 0.5, 0.9, 1.0}) {
          const double power[4] = {s * s * s, s * s, s, 1};
          V3d expected(0);
          for (int k = 0; k < 4; ++k) {
            double w = 0;
            for (int r = 0; r < 4; ++r) w += power[r] * double(basis.matrix[size_t(4 * r + k)]);
            const size_t v = size_t((i * basis.step + k) % n);
            expected += V3d(p[3 * v], p[3 * v + 1], p[3 * v + 2]) * w;
          }
          EXPECT_LT((bezierAt(*m, uint32_t(i), s) - expected).length(), 2e-5)
              << basis.name << " piece " << i << " at " << s;
        }
      }
      const bool meets = std::string(basis.name) != "power" && std::string(basis.name) != "own";
      EXPECT_EQ(int(m->vertexCount), meets ? 3 * pieces + 1 : 4 * pieces) << basis.name << ": ends are stored once";
    }
}

TEST(Curves, WidthsOfEveryClass) {
  const std::vector<float> p = {0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 1, 0, 0, 1, 1, 0, 1, 2, 0, 1, 3, 0};
  struct Case {
    StorageClass storage;
    const char* name;
    std::vector<float> values;
    std::array<float, 8> radii;  // of the control points of both curves
  };
  const Case cases[] = {
      {StorageClass::Constant, "constantwidth", {0.5f}, {0.25f, 0.25f, 0.25f, 0.25f, 0.25f, 0.25f, 0.25f, 0.25f}},
      {StorageClass::Uniform, "width", {1, 2}, {0.5f, 0.5f, 0.5f, 0.5f, 1, 1, 1, 1}},
      {StorageClass::Varying, "width", {1, 4, 2, 2}, {0.5f, 1, 1.5f, 2, 1, 1, 1, 1}},
      {StorageClass::Vertex, "width", {1, 2, 3, 4, 5, 6, 7, 8}, {0.5f, 1, 1.5f, 2, 2.5f, 3, 3.5f, 4}},
  };
  for (const Case& c : cases) {
    scene::Primitive curve = curves(true, false, {4, 4}, p);
    curve.primvars.set(parameter(c.name, c.storage, ValueType::Float, c.values));
    Quiet d;
    const auto m = make(curve, d);
    ASSERT_TRUE(m);
    EXPECT_EQ(m->kind, Mesh::Kind::CubicTube);
    ASSERT_EQ(m->vertexCount, 8u);
    for (size_t i = 0; i < 8; ++i) EXPECT_NEAR(m->spine[i].w, c.radii[i], 1e-6) << c.name << " " << i;
    EXPECT_EQ(d.warnings() + d.errors(), 0u);
  }
  Quiet d;
  EXPECT_EQ(make(curves(true, false, {4, 4}, p), d)->spine[0].w, 0.5f) << "the default width is 1";
}

TEST(Curves, PrimvarsOfEveryClass) {
  scene::Primitive c = curves(false, false, {3, 2}, {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0});
  c.primvars.set(parameter("k", StorageClass::Constant, ValueType::Float, {7}));
  c.primvars.set(parameter("u", StorageClass::Uniform, ValueType::Color, {1, 0, 0, 0, 1, 0}));
  c.primvars.set(parameter("v", StorageClass::Varying, ValueType::Float, {0, 1, 2, 3, 4}));
  c.primvars.set(parameter("x", StorageClass::Vertex, ValueType::Float, {5, 6, 7, 8, 9}));
  c.primvars.set(parameter("f", StorageClass::FaceVarying, ValueType::Float, {4, 3, 2, 1, 0}));
  Quiet d;
  const auto m = make(c, d);
  ASSERT_TRUE(m);
  ASSERT_EQ(m->primitiveCount(), 3u);
  EXPECT_EQ(m->kind, Mesh::Kind::LinearTube);
  EXPECT_EQ(m->faceOfTriangle, (std::vector<uint32_t>{0, 0, 1}));
  EXPECT_EQ(m->find("k")->data, (std::vector<float>{7}));
  EXPECT_EQ(m->find("u")->rate, Primvar::Rate::PerFace);
  EXPECT_EQ(m->find("v")->data, (std::vector<float>{0, 1, 2, 3, 4}));
  EXPECT_EQ(m->find("x")->data, (std::vector<float>{5, 6, 7, 8, 9}));
  EXPECT_EQ(m->find("f")->data, (std::vector<float>{4, 3, 2, 1, 0}));
  EXPECT_EQ(d.warnings() + d.errors(), 0u);
}

TEST(Curves, KindFollowsNormalsAndAttribute) {
  const std::vector<float> p = {0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0};
  using Kind = Mesh::Kind;
  const auto kindOf = [&](bool cubic, bool normals, int round) {
    scene::Primitive c = curves(cubic, false, {4}, p);
    if (normals) c.primvars.set(parameter("N", StorageClass::Constant, ValueType::Normal, {0, 0, 2}));
    if (round >= 0) setAttribute(c, "dice:roundcurve", round);
    Quiet d;
    const auto m = make(c, d);
    if (m && m->isOriented()) {
      EXPECT_EQ(m->spineNormals.size(), m->vertexCount);
      EXPECT_NEAR(m->spineNormals[1].z, 1, 1e-6) << "a unit vector";
    }
    return m ? m->kind : Kind::Triangles;
  };
  EXPECT_EQ(kindOf(true, false, -1), Kind::CubicTube);
  EXPECT_EQ(kindOf(true, false, 0), Kind::CubicRibbon);
  EXPECT_EQ(kindOf(true, true, -1), Kind::OrientedRibbon);
  EXPECT_EQ(kindOf(true, true, 1), Kind::CubicTube);
  EXPECT_EQ(kindOf(false, false, -1), Kind::LinearTube);
  EXPECT_EQ(kindOf(false, false, 0), Kind::LinearRibbon);
  EXPECT_EQ(kindOf(false, true, 0), Kind::OrientedRibbon);
}

TEST(Curves, KeysMovePointsAndWidths) {
  scene::Primitive c = curves(false, false, {2}, {0, 0, 0, 1, 0, 0});
  c.primvars.set(parameter("width", StorageClass::Constant, ValueType::Float, {1}));
  c.times = {0, 0.5, 2};
  for (const float x : {1.f, 3.f}) {
    scene::ParameterList key;
    key.set(points({0, x, 0, 1, x, 0}));
    key.set(parameter("width", StorageClass::Constant, ValueType::Float, {1 + x}));
    c.motion.push_back(key);
  }
  Quiet d;
  const auto m = make(c, d);
  ASSERT_TRUE(m);
  ASSERT_EQ(m->keyCount(), 3);
  EXPECT_EQ(m->spine[2].y, 1);
  EXPECT_EQ(m->spine[2].w, 1);
  EXPECT_EQ(m->spine[4].y, 3);
  EXPECT_EQ(m->spine[4].w, 2);
  EXPECT_EQ(m->bounds.max.y, 5) << "with the radius of the last key";
  // a key with another number of points: one message, the first key
  c.motion[1].set(points({0, 0, 0}));
  const auto still = make(c, d);
  ASSERT_TRUE(still);
  EXPECT_EQ(still->keyCount(), 1);
  EXPECT_EQ(d.count("GEOM-MOTION-MISMATCH"), 1u);
  // widths alone may move
  scene::Primitive grows = curves(false, false, {2}, {0, 0, 0, 1, 0, 0});
  grows.primvars.set(parameter("width", StorageClass::Constant, ValueType::Float, {1}));
  grows.times = {0, 1};
  grows.motion.push_back(grows.primvars);
  grows.motion[0].set(parameter("width", StorageClass::Constant, ValueType::Float, {3}));
  EXPECT_EQ(make(grows, d)->keyCount(), 2);
}

TEST(Curves, PinnedEndsKeepADirection) {
  // first and last control points three times: the tangent vanishes at both ends
  scene::Primitive c = curves(true, false, {7}, {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0});
  setBasis(c, kBases[1].matrix, 1);
  Quiet d;
  const auto m = make(c, d);
  ASSERT_TRUE(m);
  for (uint32_t i = 0; i < m->primitiveCount(); ++i) {
    const Imath::V4f* b = &m->spine[m->indices[i]];
    const auto far = [](const Imath::V4f& x, const Imath::V4f& y) {
      return std::hypot(x.x - y.x, x.y - y.y, x.z - y.z);
    };
    EXPECT_GT(far(b[0], b[1]), 1e-4f) << i;
    EXPECT_GT(far(b[2], b[3]), 1e-4f) << i;
  }
}

struct Bad {
  const char* what;
  scene::Primitive primitive;
  const char* code;
  int pieces;  // left; -1: nothing at all
};

TEST(Curves, BadInputGivesOneMessageAndAFallback) {
  const auto withWidth = [](std::vector<float> w, StorageClass storage = StorageClass::Varying) {
    scene::Primitive c = curves(false, false, {3}, {0, 0, 0, 1, 0, 0, 2, 0, 0});
    c.primvars.set(parameter("width", storage, ValueType::Float, std::move(w)));
    return c;
  };
  const Bad cases[] = {
      {"no length", curves(false, false, {2, 2}, {0, 0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0}), "GEOM-CURVE-LENGTH", 1},
      {"no length at all", curves(true, false, {4}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}), "GEOM-CURVE-LENGTH", -1},
      {"step does not fit", curves(true, false, {5, 4}, std::vector<float>(27, 0.f)), "GEOM-CURVE-COUNT", -1},
      {"too few", curves(false, false, {1, 2}, {0, 0, 0, 1, 0, 0, 2, 0, 0}), "GEOM-CURVE-COUNT", 1},
      {"more vertices than points", curves(false, false, {9}, {0, 0, 0, 1, 0, 0}), "GEOM-CURVE-COUNT", -1},
      {"huge count", curves(false, false, {2147483647, 2147483647}, {0, 0, 0, 1, 0, 0}), "GEOM-CURVE-COUNT", -1},
      {"negative count", curves(false, false, {-3, 2}, {0, 0, 0, 1, 0, 0}), "GEOM-CURVE-COUNT", 1},
      {"not finite", curves(false, false, {2, 2}, {0, 0, NAN, 1, 0, 0, 1, 0, 0, 2, 0, 0}), "GEOM-NOT-FINITE", 1},
      {"width not a number", withWidth({1, NAN, 1}), "GEOM-WIDTH", 2},
      {"width infinite", withWidth({INFINITY}, StorageClass::Constant), "GEOM-WIDTH", 2},
      {"width negative", withWidth({-1, -1, 1}), "GEOM-WIDTH", 1},
      {"width zero", withWidth({0}, StorageClass::Constant), "GEOM-ZERO-AREA", -1},
      {"widths that do not fit", withWidth({1, 2}), "GEOM-PRIMVAR-COUNT", 2},
  };
  for (const Bad& b : cases) {
    Quiet d;
    const auto m = make(b.primitive, d);
    EXPECT_GE(d.count(b.code), 1u) << b.what;
    EXPECT_LE(d.warnings() + d.errors(), std::string(b.what) == "step does not fit" ? 2u : 1u) << b.what;
    EXPECT_EQ(m.has_value(), b.pieces >= 0) << b.what;
    if (m) {
      EXPECT_EQ(int(m->primitiveCount()), b.pieces) << b.what;
      for (const Imath::V4f& s : m->spine) EXPECT_TRUE(std::isfinite(s.x + s.y + s.z + s.w) && s.w >= 0) << b.what;
    }
  }
}

scene::Primitive cloud(std::vector<float> p) {
  scene::Primitive out = primitive(scene::Points{int(p.size() / 3)});
  out.primvars.set(points(std::move(p)));
  return out;
}
scene::Primitive typed(scene::Primitive p, const char* type) {
  scene::Parameter t;
  t.name = "type";
  t.storage = StorageClass::Uniform;
  t.type = ValueType::String;
  t.strings = {type};
  p.primvars.set(t);
  return p;
}

TEST(Points, KindsWidthsAndPrimvars) {
  scene::Primitive p = cloud({0, 0, 0, 1, 0, 0});
  p.primvars.set(parameter("width", StorageClass::Varying, ValueType::Float, {1, 3}));
  p.primvars.set(parameter("Cs", StorageClass::Vertex, ValueType::Color, {1, 0, 0, 0, 1, 0}));
  Quiet d;
  auto m = make(p, d);
  ASSERT_TRUE(m);
  EXPECT_EQ(m->kind, Mesh::Kind::Disc);
  EXPECT_EQ(m->spine[1].w, 1.5f);
  EXPECT_EQ(m->find("Cs")->data.size(), 6u);
  EXPECT_EQ(m->bounds.max.x, 2.5);
  EXPECT_EQ(make(typed(p, "sphere"), d)->kind, Mesh::Kind::Ball);
  EXPECT_EQ(make(typed(p, "disk"), d)->kind, Mesh::Kind::Disc);
  p.primvars.set(parameter("N", StorageClass::Vertex, ValueType::Normal, {0, 0, 1, 0, 3, 0}));
  EXPECT_EQ(make(p, d)->kind, Mesh::Kind::OrientedDisc);
  EXPECT_EQ(d.warnings() + d.errors(), 0u);
  EXPECT_EQ(make(typed(p, "blobby"), d)->kind, Mesh::Kind::Ball);
  EXPECT_EQ(make(typed(p, "square"), d)->kind, Mesh::Kind::OrientedDisc);
  EXPECT_EQ(d.count("GEOM-POINTS-TYPE"), 2u);
  for (const float power : {0.f, 1.f}) {
    p.primvars.set(parameter("falloffpower", StorageClass::Constant, ValueType::Float, {power}));
    EXPECT_EQ(make(p, d)->kind, Mesh::Kind::OrientedDisc);
    EXPECT_EQ(d.count("GEOM-POINTS-FALLOFF"), power > 0 ? 1u : 0u);
  }
}

TEST(Points, BadInputGivesOneMessageAndAFallback) {
  const auto wide = [](std::vector<float> w) {
    scene::Primitive p = cloud({0, 0, 0, 1, 0, 0});
    p.primvars.set(
        parameter("width", w.size() == 1 ? StorageClass::Constant : StorageClass::Varying, ValueType::Float, w));
    return p;
  };
  const Bad cases[] = {
      {"not finite", cloud({0, NAN, 0, 1, 0, 0}), "GEOM-NOT-FINITE", 1},
      {"negative", wide({-1, 2}), "GEOM-WIDTH", 1},
      {"not a number", wide({NAN, 2}), "GEOM-WIDTH", 2},
      {"nothing to see", wide({0}), "GEOM-ZERO-AREA", -1},
      {"widths that do not fit", wide({1, 2, 3, 4, 5}), "GEOM-PRIMVAR-COUNT", 2},
  };
  for (const Bad& b : cases) {
    Quiet d;
    const auto m = make(b.primitive, d);
    EXPECT_EQ(d.count(b.code), 1u) << b.what;
    EXPECT_EQ(d.warnings() + d.errors(), 1u) << b.what;
    EXPECT_EQ(m.has_value(), b.pieces >= 0) << b.what;
    if (m) {
      EXPECT_EQ(int(m->primitiveCount()), b.pieces) << b.what;
    }
  }
}

// Seen thinner than the attribute says: the width becomes that, and what was the curve's own is kept as a share.
TEST(Curves, ThinOnesAreMadeWiderByTheirShare) {
  scene::Primitive p = curves(true, false, {4}, {0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0});
  setBasis(p, {-1, 3, -3, 1, 3, -6, 3, 0, -3, 3, 0, 0, 1, 0, 0, 0}, 3);
  p.primvars.set(parameter("width", StorageClass::Varying, ValueType::Float, {0.2f, 0}));
  setAttribute(p, "hair:minwidth", 0.5f);
  Quiet d;
  DiceRate rate;
  rate.edgeLength = [](const V3d&) { return 0.6; };
  rate.pixelsPerEdge = 3;  // a pixel is 0.2, the least radius 0.05
  const std::optional<Mesh> m = tessellate(p, rate, d);
  ASSERT_TRUE(m);
  ASSERT_EQ(m->own.size(), 4u);
  for (const float s : {0.f, 0.25f, 0.6f, 0.9f, 1.f}) {
    const float t = 1 - s, w[4] = {t * t * t, 3 * s * t * t, 3 * s * s * t, s * s * s};
    float radius = 0;
    for (size_t k = 0; k < 4; ++k) radius += w[k] * m->spine[k].w;
    EXPECT_GE(radius, 0.05f - 1e-6f);
    EXPECT_NEAR(radius * m->ownWidth(0, s), 0.1f * t, 1e-6f) << s;
  }
  rate.edgeLength = nullptr;  // no camera: as they are
  EXPECT_TRUE(tessellate(p, rate, d)->own.empty());
  rate.edgeLength = [](const V3d&) { return 1e-6; };  // seen from close by; the tip has no width
  EXPECT_EQ(tessellate(p, rate, d)->own[0], 1.f);
}

}  // namespace
}  // namespace kinora::geometry
