// Shapes by name. The teapot against Newell's table, evaluated here in other ways: de Casteljau's construction,
// volumes by quadrature that is exact for the patches' polynomials, the same patches as requests of their own.
#include "geometry/teapot_patches.h"
#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {

using namespace testing;

scene::Primitive named(const std::string& name) {
  scene::OtherPrimitive o{"Geometry", {}};
  scene::Parameter type = parameter("type", StorageClass::Constant, ValueType::String, {});
  type.strings = {name};
  o.args.set(type);
  return primitive(o);
}
scene::Primitive teapotWithBottom() {
  scene::Primitive p = named("teapot");
  p.primvars.set(parameter("bottom", StorageClass::Constant, ValueType::Float, {1}));
  return p;
}

// The triangles of some faces.
Mesh facesOf(const Mesh& m, uint32_t first, uint32_t last) {
  Mesh out;
  out.points = m.points;
  out.vertexCount = m.vertexCount;
  out.origin = m.origin;
  for (uint32_t t = 0; t < m.triangleCount(); ++t)
    if (m.faceOf(t) >= first && m.faceOf(t) <= last)
      out.indices.insert(out.indices.end(), m.indices.begin() + 3 * t, m.indices.begin() + 3 * t + 3);
  return out;
}

// A point of a patch by repeated mixing, with its tangents.
struct Spot {
  V3d p, du, dv;
};
Spot spotOf(int patch, double u, double v) {
  const auto mix = [](std::array<V3d, 4> c, double t, V3d* slope) {
    for (int n = 3; n > 0; --n) {
      if (n == 1 && slope) *slope = (c[1] - c[0]) * 3.0;
      for (int i = 0; i < n; ++i) c[i] = c[i] * (1 - t) + c[i + 1] * t;
    }
    return c[0];
  };
  std::array<V3d, 4> rows, columns;
  const auto control = [&](int i, int j) {
    const float* c = kTeapotPoints[kTeapotPatches[patch][4 * j + i] - 1];
    return V3d(c[0], c[1], c[2] - 0.15);
  };
  for (int k = 0; k < 4; ++k) {
    rows[k] = mix({control(0, k), control(1, k), control(2, k), control(3, k)}, u, nullptr);
    columns[k] = mix({control(k, 0), control(k, 1), control(k, 2), control(k, 3)}, v, nullptr);
  }
  Spot out;
  out.p = mix(rows, v, &out.dv);
  mix(columns, u, &out.du);
  return out;
}
// What the patches enclose, seen from the origin: each integrand is of degree 8 in u and v, for which five places are
// enough.
double volumeOf(int first, int last) {
  constexpr double x[5] = {0, 0.5384693101056831, -0.5384693101056831, 0.9061798459386640, -0.9061798459386640};
  constexpr double w[5] = {0.5688888888888889, 0.4786286704993665, 0.4786286704993665, 0.2369268850561891,
                           0.2369268850561891};
  double sum = 0;
  for (int p = first; p <= last; ++p)
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 5; ++j) {
        const Spot s = spotOf(p, (1 + x[i]) / 2, (1 + x[j]) / 2);
        sum += w[i] * w[j] / 4 * s.p.dot(s.du.cross(s.dv)) / 3;
      }
  return sum;
}

TEST(Teapot, StandsOnTheGroundAndIsThreeHigh) {
  const Mesh m = made(named("teapot"), edge(0.02));
  EXPECT_NEAR(m.bounds.min.z, 0, 1e-6);
  EXPECT_NEAR(m.bounds.max.z, 3, 1e-6);
  EXPECT_NEAR(m.bounds.max.y, 2, 1e-3);
  EXPECT_NEAR(m.bounds.min.y, -2, 1e-3);
  EXPECT_NEAR(m.bounds.min.x, -3, 0.05);     // the handle
  EXPECT_NEAR(m.bounds.max.x, 3.434, 0.01);  // the spout
  EXPECT_NEAR(made(teapotWithBottom(), edge(0.02)).bounds.min.z, -0.15, 1e-6);
}

TEST(Teapot, PointsAndNormalsAreThoseOfTheTable) {
  for (const bool reversed : {false, true}) {
    scene::Primitive p = teapotWithBottom();
    edit(p, [&](scene::Attributes& a) { a.reverseOrientation = reversed; });
    const Mesh m = made(p, edge(0.05));
    const Primvar* n = m.find("N");
    ASSERT_NE(n, nullptr);
    std::vector<bool> seen(32, false);
    for (uint32_t t = 0; t < m.triangleCount(); ++t) {
      seen[m.faceOf(t)] = true;
      for (int k = 0; k < 3; ++k) {
        const Imath::V2f uv = m.uvOf(t, k);
        const Spot s = spotOf(int(m.faceOf(t)), uv.x, uv.y);
        const uint32_t i = m.indices[3 * t + k];
        ASSERT_LT((vertex(m, i) - s.p).length(), 3e-6);
        const V3d normal(n->data[3 * i], n->data[3 * i + 1], n->data[3 * i + 2]), front = s.du.cross(s.dv);
        ASSERT_NEAR(normal.length(), 1, 1e-5);
        if (front.length() > 1e-3) {
          ASSERT_NEAR(normal.dot(front.normalized()), reversed ? -1 : 1, 1e-4);
        }
      }
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 32);
    EXPECT_EQ(m.flipNormals, reversed);
  }
}

TEST(Teapot, PartsHaveNoCracksAndFaceOutward) {
  for (const double e : {0.3, 0.05, 0.02}) {
    const Mesh m = made(teapotWithBottom(), edge(e));
    const struct {
      uint32_t first, last;
      double openAt;  // the height of its only open edges; 0: not looked at
    } parts[] = {{0, 15, 0}, {16, 19, 0}, {20, 27, 2.25}};
    for (const auto& part : parts) EXPECT_EQ(edges(facesOf(m, part.first, part.last)).wrong, 0u);
    // body and bottom are open at the inner side of the rim alone, the lid at its lower side
    for (const bool lid : {false, true}) {
      Mesh part = lid ? facesOf(m, 20, 27) : facesOf(m, 0, 11);
      if (!lid) {
        const Mesh bottom = facesOf(m, 28, 31);
        part.indices.insert(part.indices.end(), bottom.indices.begin(), bottom.indices.end());
      }
      std::map<std::array<float, 6>, int> used;
      for (uint32_t t = 0; t < part.triangleCount(); ++t)
        for (int k = 0; k < 3; ++k) {
          const V3f a = part.points[part.indices[3 * t + k]] + V3f(0),
                    b = part.points[part.indices[3 * t + (k + 1) % 3]] + V3f(0);
          ++used[{a.x, a.y, a.z, b.x, b.y, b.z}];
        }
      size_t open = 0;
      for (const auto& [key, count] : used) {
        ASSERT_EQ(count, 1);
        if (used.contains({key[3], key[4], key[5], key[0], key[1], key[2]})) continue;
        ++open;
        ASSERT_NEAR(key[2], 2.25, 1e-6);
        ASSERT_NEAR(std::hypot(key[0], key[1]), lid ? 1.3 : 1.4, 0.02);
      }
      EXPECT_GT(open, 8u);
      // the openings lie in one plane: closed by it, what is enclosed is above 0 where the front is outside
      const double radius = lid ? 1.3 : 1.4, cap = 2.25 / 3 * kPi * radius * radius * (lid ? -1 : 1);
      EXPECT_GT(volume(part) + cap, 0.5);
      const double exact = lid ? volumeOf(20, 27) : volumeOf(0, 11) + volumeOf(28, 31);
      EXPECT_NEAR(volume(part), exact, area(part) * 0.05 * e);  // the sagitta of dice.h, everywhere
    }
    EXPECT_GT(volumeOf(12, 15), 0);  // the handle
    EXPECT_GT(volumeOf(16, 19), 0);  // the spout
  }
}

TEST(Teapot, IsWhatItsPatchesAreAsRequests) {
  double sum = 0;
  for (int k = 0; k < 28; ++k) {
    scene::Primitive p = primitive(scene::Patch{true});
    std::vector<float> c;
    for (const uint16_t i : kTeapotPatches[k])
      for (int d = 0; d < 3; ++d) c.push_back(kTeapotPoints[i - 1][d] - (d == 2 ? 0.15f : 0.f));
    p.primvars.set(points(c));
    sum += area(made(p, edge(0.02)));
  }
  EXPECT_NEAR(area(made(named("teapot"), edge(0.02))) / sum, 1, 2e-3);
}

TEST(Teapot, TakesPrimvarsAndStaysInBounds) {
  scene::Primitive p = named("Teapot");
  p.primvars.set(parameter("Cs", StorageClass::Uniform, ValueType::Color, {0, 0.5f, 1}));
  p.primvars.set(parameter("corner", StorageClass::Varying, ValueType::Float, {0, 1, 2, 3}));
  const Mesh m = made(p, edge(0.1));
  EXPECT_EQ(m.find("Cs")->rate, Primvar::Rate::Constant);
  for (uint32_t i = 0; i < m.vertexCount; ++i)
    ASSERT_NEAR(m.find("corner")->data[i], m.vertexUV[i].x + 2 * m.vertexUV[i].y, 1e-5);
  DiceRate fine = edge(1e-5);
  fine.maxTriangles = 100'000;
  EXPECT_LE(made(named("teapot"), fine).triangleCount(), 100'000u);
}

TEST(NamedShape, FillTheUnitCube) {
  const struct {
    const char* name;
    double area, volume;
    bool closed;
  } cases[] = {{"cube", 6, 1, true},           {"Box", 6, 1, true},
               {"sphere", kPi, kPi / 6, true}, {"cylinder", kPi, kPi / 6, false},
               {"disk", kPi / 4, 0, false},    {"plane", 1, 0, false}};
  for (const auto& c : cases) {
    scene::Primitive p = named(c.name);
    p.primvars.set(parameter("Cs", StorageClass::Uniform, ValueType::Color, {1, 0, 0}));
    const Mesh m = made(p);
    EXPECT_NEAR(area(m) / c.area, 1, 2e-3) << c.name;
    EXPECT_NEAR(volume(m), c.volume, 2e-3) << c.name;
    EXPECT_EQ(edges(m).open == 0, c.closed) << c.name;
    EXPECT_EQ(m.find("Cs")->rate, Primvar::Rate::Constant) << c.name;
  }
  scene::Primitive p = named("sphere");
  p.primvars.set(parameter("radius", StorageClass::Constant, ValueType::Float, {2}));
  EXPECT_NEAR(area(made(p)) / (16 * kPi), 1, 2e-3);
  p.primvars.set(parameter("radius", StorageClass::Constant, ValueType::Float, {NAN}));
  Quiet d;
  EXPECT_NEAR(area(*tessellate(p, {}, d)) / kPi, 1, 2e-3);
  EXPECT_EQ(d.count("GEOM-SHAPE-NAME"), 1u);
}

TEST(NamedShape, UnknownNamesAreToldByName) {
  std::vector<std::string> lines;
  Diagnostics d([&](const std::string& line, Severity) { lines.push_back(line); });
  for (const char* name : {"gumbo", "gumbo", "dodo", "", "rectlight"})
    EXPECT_FALSE(tessellate(named(name), {}, d).has_value());
  EXPECT_FALSE(tessellate(named(std::string(100'000, 'x')), {}, d).has_value());
  d.summary();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NE(lines[0].find("'gumbo'"), std::string::npos) << lines[0];
  for (const char* name : {"'gumbo'", "'dodo'", "'rectlight'"})
    EXPECT_NE(lines[1].find(name), std::string::npos) << lines[1];
  EXPECT_LT(lines[1].size(), 400u);
  EXPECT_EQ(d.count("GEOM-SHAPE-NAME"), 6u);
}

}  // namespace
}  // namespace kinora::geometry
