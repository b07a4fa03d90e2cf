// Trim curves on surfaces: areas and outlines in closed form, that normals and parameters stay those of the surface,
// and what becomes of curves that cannot be used.
#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {

using namespace testing;

// The arrays of TrimCurve, grown loop by loop.
struct TrimText {
  std::vector<int> ncurves, order, n;
  std::vector<float> knot, min, max, u, v, w;

  void curve(int curveOrder, std::vector<float> knots, const std::vector<std::array<double, 3>>& points) {
    order.push_back(curveOrder);
    n.push_back(int(points.size()));
    min.push_back(knots[size_t(curveOrder) - 1]);
    max.push_back(knots[points.size()]);
    knot.insert(knot.end(), knots.begin(), knots.end());
    for (const auto& p : points) u.push_back(float(p[0])), v.push_back(float(p[1])), w.push_back(float(p[2]));
  }
  // A whole circle as nine rational points of order 3; weighted as "Pw" are.
  void circle(double cu, double cv, double radius) {
    ncurves.push_back(1);
    const double d[9][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
    std::vector<std::array<double, 3>> points;
    for (int i = 0; i < 9; ++i) {
      const double weight = i % 2 ? std::sqrt(0.5) : 1;
      points.push_back({(cu + radius * d[i][0]) * weight, (cv + radius * d[i][1]) * weight, weight});
    }
    curve(3, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}, points);
  }
  void polygon(const std::vector<std::array<double, 2>>& corners) {
    ncurves.push_back(1);
    std::vector<float> knots{0};
    std::vector<std::array<double, 3>> points;
    for (size_t i = 0; i < corners.size(); ++i) {
      knots.push_back(float(i));
      points.push_back({corners[i][0], corners[i][1], 1});
    }
    knots.push_back(knots.back());
    curve(2, knots, points);
  }
  scene::ParameterList list() const {
    scene::ParameterList out;
    const auto ints = [&](const char* name, const std::vector<int>& values) {
      scene::Parameter p = parameter(name, StorageClass::Constant, ValueType::Int, {});
      p.ints = values;
      out.set(p);
    };
    const auto floats = [&](const char* name, const std::vector<float>& values) {
      out.set(parameter(name, StorageClass::Constant, ValueType::Float, values));
    };
    ints("ncurves", ncurves), ints("order", order), floats("knot", knot), floats("min", min), floats("max", max);
    ints("n", n), floats("u", u), floats("v", v), floats("w", w);
    return out;
  }
};

// The square from (0, 0) to (4, 4), its parameters from 0 to 2.
scene::Primitive square(const TrimText& trim) {
  scene::NuPatch n;
  n.nu = n.nv = n.uOrder = n.vOrder = 2;
  n.uKnots = n.vKnots = {0, 0, 2, 2};
  n.uMax = n.vMax = 2;
  n.trim = trim.list();
  scene::Primitive p = primitive(n);
  p.primvars.set(points({0, 0, 0, 4, 0, 0, 0, 4, 0, 4, 4, 0}));
  return p;
}
// A quarter of a cylinder of radius 1 and height 1 over two pieces in v; u runs around.
scene::Primitive quarterTube(const TrimText& trim) {
  scene::NuPatch n;
  n.nu = n.uOrder = 3;
  n.nv = 3;
  n.vOrder = 2;
  n.uKnots = {0, 0, 0, 1, 1, 1};
  n.vKnots = {0, 0, 0.5f, 1, 1};
  n.trim = trim.list();
  scene::Primitive p = primitive(n);
  const float s = float(std::sqrt(0.5));
  std::vector<float> pw;
  for (const float z : {0.f, 0.5f, 1.f}) pw.insert(pw.end(), {1, 0, z, 1, s, s, s * z, s, 0, 1, z, 1});
  p.primvars.set(parameter("Pw", StorageClass::Vertex, ValueType::HPoint, pw));
  return p;
}
void keepOutside(scene::Primitive& p) {
  edit(p, [](scene::Attributes& a) {
    scene::Parameter sense = parameter("trimcurve:sense", StorageClass::Constant, ValueType::String, {});
    sense.strings = {"outside"};
    a.named.set(sense);
  });
}

TEST(Trim, CircleHasItsAreaAndASmoothEdge) {
  TrimText trim;
  trim.circle(1, 1, 0.75);  // radius 1.5
  for (const double e : {0.0, 0.05, 0.005}) {
    const Mesh m = made(square(trim), e > 0 ? edge(e) : DiceRate{});
    const double allowed = e > 0 ? 2 * 0.05 * e / 1.5 : 1e-3;  // the sagitta of dice.h, of the radius
    EXPECT_NEAR(area(m) / (kPi * 2.25), 1, std::max(allowed, 1e-4)) << e;
    // the outline: edges of one triangle, all of them on the circle
    std::map<std::pair<uint32_t, uint32_t>, int> used;
    for (uint32_t t = 0; t < m.triangleCount(); ++t)
      for (int k = 0; k < 3; ++k) ++used[{m.indices[3 * t + k], m.indices[3 * t + (k + 1) % 3]}];
    double length = 0;
    for (const auto& [key, count] : used) {
      ASSERT_EQ(count, 1);
      if (used.contains({key.second, key.first})) continue;
      const V3d a = vertex(m, key.first), b = vertex(m, key.second);
      ASSERT_NEAR((a - V3d(2, 2, 0)).length(), 1.5, 1.5 * std::max(allowed, 1e-4));
      length += (b - a).length();
    }
    EXPECT_NEAR(length / (2 * kPi * 1.5), 1, 2e-3) << e;
    EXPECT_EQ(edges(m).wrong, 0u);
    for (uint32_t i = 0; i < m.vertexCount; ++i) {
      ASSERT_NEAR(m.vertexUV[i].x, vertex(m, i).x / 4, 1e-6);
      ASSERT_NEAR(m.vertexUV[i].y, vertex(m, i).y / 4, 1e-6);
      ASSERT_GT(m.find("N")->data[3 * i + 2], 0.9999);
    }
  }
}

TEST(Trim, SenseAndNestedLoops) {
  TrimText ring;
  ring.circle(1, 1, 0.9);
  ring.circle(1, 1, 0.45);
  scene::Primitive p = square(ring);
  const double expected = kPi * (1.8 * 1.8 - 0.9 * 0.9);
  EXPECT_NEAR(area(made(p)) / expected, 1, 1e-3);
  keepOutside(p);
  EXPECT_NEAR(area(made(p)) / (16 - expected), 1, 1e-3);
  // a hole as exporters write it: the border of the surface, then the hole the other way round
  TrimText hole;
  hole.polygon({{0, 0}, {2, 0}, {2, 2}, {0, 2}, {0, 0}});
  hole.circle(1, 1, 0.5);
  EXPECT_NEAR(area(made(square(hole))), 16 - kPi, 2e-3);
}

TEST(Trim, CurvedSurfacesKeepTheirNormalsAndMeetTheirComplement) {
  TrimText trim;
  trim.circle(0.5, 0.5, 0.3);
  scene::Primitive p = quarterTube(trim);
  p.primvars.set(parameter("part", StorageClass::Uniform, ValueType::Float, {3, 4}));
  p.primvars.set(parameter("height", StorageClass::Vertex, ValueType::Float, {0, 0, 0, .5f, .5f, .5f, 1, 1, 1}));
  const Mesh inside = made(p, edge(0.02));
  keepOutside(p);
  const Mesh outside = made(p, edge(0.02));
  EXPECT_NEAR((area(inside) + area(outside)) / (kPi / 2), 1, 1e-3);
  for (const Mesh* m : {&inside, &outside}) {
    const Primvar *n = m->find("N"), *height = m->find("height");
    for (uint32_t i = 0; i < m->vertexCount; ++i) {
      const V3d at = vertex(*m, i);
      ASSERT_NEAR(std::hypot(at.x, at.y), 1, 1e-6);
      ASSERT_NEAR(n->data[3 * i] * at.x + n->data[3 * i + 1] * at.y, 1, 1e-5);
      ASSERT_NEAR(height->data[i], at.z, 1e-6);
      ASSERT_NEAR(m->vertexUV[i].y, at.z, 1e-6);
    }
    for (uint32_t t = 0; t < m->triangleCount(); ++t) {
      const auto c = corners(*m, t);
      ASSERT_EQ(m->faceOf(t), (c[0].z + c[1].z + c[2].z) / 3 < 0.5 ? 0u : 1u);
    }
  }
  // both together are the whole surface without a crack: nothing is open but its border
  Mesh both = inside;
  both.vertexCount += outside.vertexCount;
  both.points.insert(both.points.end(), outside.points.begin(), outside.points.end());
  for (const uint32_t i : outside.indices) both.indices.push_back(i + inside.vertexCount);
  std::map<std::array<float, 6>, int> used;
  const auto key = [&](uint32_t a, uint32_t b) {
    const V3f p = both.points[a], q = both.points[b];
    return std::array{p.x, p.y, p.z, q.x, q.y, q.z};
  };
  for (uint32_t t = 0; t < both.triangleCount(); ++t)
    for (int k = 0; k < 3; ++k) ++used[key(both.indices[3 * t + k], both.indices[3 * t + (k + 1) % 3])];
  for (const auto& [e, count] : used) {
    ASSERT_EQ(count, 1);
    if (used.contains({e[3], e[4], e[5], e[0], e[1], e[2]})) continue;
    const bool onBorder = (e[2] == 0 && e[5] == 0) || (e[2] == 1 && e[5] == 1) || (e[0] == 0 && e[3] == 0) ||
                          (e[1] == 0 && e[4] == 0) || std::max(std::abs(e[0]), std::abs(e[3])) < 1e-6f ||
                          std::max(std::abs(e[1]), std::abs(e[4])) < 1e-6f;
    ASSERT_TRUE(onBorder) << e[0] << " " << e[1] << " " << e[2];
  }
}

TEST(Trim, DeformationKeysAreTrimmedAlike) {
  TrimText trim;
  trim.circle(1, 1, 0.5);
  scene::Primitive p = square(trim);
  scene::ParameterList later;
  later.set(points({0, 0, 0, 8, 0, 0, 0, 8, 0, 8, 8, 0}));
  p.motion.push_back(later);
  p.times = {0, 1};
  const Mesh m = made(p);
  EXPECT_NEAR(area(m, 0), kPi, 4e-3);
  EXPECT_NEAR(area(m, 1), 4 * kPi, 16e-3);
}

TEST(Trim, BadInputTable) {
  const auto tri = [] {
    TrimText t;
    t.polygon({{0.5, 0.5}, {1.5, 0.5}, {1.5, 1.5}, {0.5, 0.5}});
    return t;
  };
  const auto with = [&](const std::function<void(TrimText&)>& change) {
    TrimText t = tri();
    change(t);
    return t;
  };
  const struct {
    TrimText trim;
    const char* code;
    double area;
  } cases[] = {
      {tri(), nullptr, 2},
      {with([](TrimText& t) { t.u.pop_back(); }), "GEOM-TRIM", 16},
      {with([](TrimText& t) { t.ncurves = {2}; }), "GEOM-TRIM", 16},
      {with([](TrimText& t) {
         t.ncurves = {INT32_MAX, INT32_MAX, 3};
       }),
       "GEOM-TRIM", 16},
      {with([](TrimText& t) { t.n = {INT32_MAX}; }), "GEOM-TRIM", 16},
      {with([](TrimText& t) { t.n = {-4}; }), "GEOM-TRIM", 16},
      {with([](TrimText& t) { t.order = {0}; }), "GEOM-TRIM", 16},
      {with([](TrimText& t) { std::swap(t.knot[2], t.knot[3]); }), "GEOM-TRIM", 16},
      {with([](TrimText& t) { t.knot[3] = NAN; }), "GEOM-TRIM", 16},
      {with([](TrimText& t) { t.min = {7}; }), "GEOM-TRIM", 16},
      {with([](TrimText& t) { t.w[1] = 0; }), "GEOM-TRIM", 16},
      {with([](TrimText& t) { t.w.assign(4, 0); }), "GEOM-TRIM", 16},
      {with([](TrimText& t) { t.u[2] = INFINITY; }), "GEOM-TRIM", 16},
      {with([](TrimText& t) { t.u[3] = 0.75f; }), "GEOM-TRIM-OPEN", 1.5},
      {with([](TrimText& t) {
         t.u = {0.5f, 1.5f, 0.5f, 1.5f}, t.v = {0.5f, 1.5f, 1.5f, 0.5f};
       }),
       "GEOM-TRIM-OPEN", 2},
      // one loop of two is broken: the other one holds
      {[&] {
         TrimText t = tri();
         t.circle(1, 1, 0.2);
         t.w[1] = 0;
         return t;
       }(),
       "GEOM-TRIM", kPi * 0.16},
      {[] {
         TrimText t;  // an hourglass
         t.polygon({{0, 0}, {2, 2}, {2, 0}, {0, 2}, {0, 0}});
         return t;
       }(),
       "GEOM-TRIM-CROSSING", 8},
      {[] {
         TrimText t;  // of no area, and outside of the surface
         t.polygon({{5, 5}, {6, 5}, {6, 6}, {5, 5}});
         return t;
       }(),
       "GEOM-ZERO-AREA", 0},
  };
  size_t i = 0;
  for (const auto& c : cases) {
    Quiet d;
    const std::optional<Mesh> m = tessellate(square(c.trim), edge(0.05), d);
    EXPECT_NEAR(m ? area(*m) : 0, c.area, 0.01) << i;
    if (c.code) {
      EXPECT_GE(d.count(c.code), 1u) << i << " " << c.code;
    }
    EXPECT_EQ(d.warnings() > 0, c.code != nullptr) << i;
    ++i;
  }
}

}  // namespace
}  // namespace kinora::geometry
