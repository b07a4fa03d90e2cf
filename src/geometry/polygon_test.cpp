// Proves how polygons become triangles: areas with holes and concave outlines, every primvar class, memory and speed
// of large meshes, and what is done about bad input, outlines that cross themselves among it: these cover what they go round. Misses:
// outlines of more than 512 corners that do so, which are only required to survive.
#include <chrono>
#include <random>

#include "geometry/test_support.h"
#include "geometry/triangulate.h"
#include "geometry/winding_fill.h"

namespace kinora::geometry {
namespace {

using namespace testing;

scene::Primitive polygons(PolygonMesh shape, std::vector<float> p) {
  scene::Primitive out = primitive(std::move(shape));
  out.primvars.set(points(std::move(p)));
  return out;
}
V3d normalOf(const Mesh& m, uint32_t t) {
  const auto c = corners(m, t);
  return (c[1] - c[0]).cross(c[2] - c[0]).normalized() * (m.flipNormals ? -1 : 1);
}

// A ring of n points; negative radius turns it the other way.
void ring(std::vector<float>& p, int n, double radius, V3d centre, double wobble = 0) {
  for (int i = 0; i < n; ++i) {
    const double a = 2 * kPi * i / n * (radius < 0 ? -1 : 1), r = std::abs(radius) * (1 + wobble * (i % 2 ? 1 : -1));
    p.insert(p.end(), {float(centre.x + r * std::cos(a)), float(centre.y + r * std::sin(a)), float(centre.z)});
  }
}

TEST(Polygon, ConcaveOutlineKeepsItsArea) {
  // An L of area 3, in a tilted plane.
  const double xy[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  std::vector<float> p;
  for (const auto& q : xy) p.insert(p.end(), {float(q[0]), float(q[1] * 0.6), float(q[1] * 0.8)});
  for (int start = 0; start < 6; ++start) {
    std::rotate(p.begin(), p.begin() + 3, p.end());
    const Mesh m = made(polygons({}, p));
    EXPECT_EQ(m.triangleCount(), 4u);
    EXPECT_NEAR(area(m), 3, 1e-5);
    for (uint32_t t = 0; t < m.triangleCount(); ++t) EXPECT_GT(normalOf(m, t).dot(V3d(0, -0.8, 0.6)), 0.999);
  }
}

TEST(Polygon, HolesAreLeftOpenWhateverWayTheyRun) {
  for (double direction : {1.0, -1.0}) {
    std::vector<float> p{0, 0, 0, 10, 0, 0, 10, 10, 0, 0, 10, 0};
    PolygonMesh shape;
    shape.loopsPerFace = {1};
    shape.verticesPerLoop = {4};
    double holes = 0;
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) {
        const int n = 5 + i + j;
        ring(p, n, direction * 0.9, V3d(1.5 + 2.3 * i, 1.5 + 2.3 * j, 0));
        holes += 0.5 * n * 0.81 * std::sin(2 * kPi / n);
        shape.verticesPerLoop.push_back(n);
        ++shape.loopsPerFace[0];
      }
    const Mesh m = made(polygons(shape, p));
    EXPECT_NEAR(area(m), 100 - holes, 1e-4);
    // n corners and h holes give n + 2 h - 2 triangles; the only open edges are the outlines.
    EXPECT_EQ(m.triangleCount(), p.size() / 3 + 2 * 16 - 2);
    const EdgeCount e = edges(m);
    EXPECT_EQ(e.wrong, 0u);
    EXPECT_EQ(e.open, p.size() / 3);
  }
}

TEST(Polygon, HoleThatTouchesTheOutlineAndCollinearPoints) {
  // A square with points in the middle of its sides, and a diamond hole that touches the left side in such a point.
  std::vector<float> p{0, 0, 0, 1, 0, 0, 2, 0, 0, 2, 1, 0, 2, 2, 0, 1, 2, 0, 0, 2, 0, 0, 1, 0};
  PolygonMesh shape;
  shape.loopsPerFace = {2};
  shape.verticesPerLoop = {8, 4};
  p.insert(p.end(), {0, 1, 0, 0.5f, 0.5f, 0, 1, 1, 0, 0.5f, 1.5f, 0});
  const Mesh m = made(polygons(shape, p));
  EXPECT_NEAR(area(m), 4 - 0.5, 1e-6);
  // Points on straight sides stay corners, so that a neighbour that has them too closes without a crack.
  std::vector<int> used(12);
  for (uint32_t i : m.indices) ++used[i];
  for (int i = 0; i < 7; ++i) EXPECT_GT(used[i], 0) << i;
}

TEST(Polygon, LargeOutlineInReasonableTime) {
  std::vector<float> p;
  const int n = 100000;
  ring(p, n, 10, V3d(0), 0.1);
  double exact = 0;
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    exact += 0.5 * (double(p[3 * i]) * p[3 * j + 1] - double(p[3 * i + 1]) * p[3 * j]);
  }
  const auto start = std::chrono::steady_clock::now();
  const Mesh m = made(polygons({}, p));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("[ measured ] 100,000-corner star: %.3f s\n", seconds);
  EXPECT_EQ(m.triangleCount(), uint32_t(n - 2));
  EXPECT_NEAR(area(m) / exact, 1, 1e-6);
  EXPECT_LT(seconds, 20);  // a quadratic method takes minutes
}

TEST(Polygon, RandomCombsAgreeWithTheirArea) {
  // Monotone zigzags with random teeth: always simple, often very concave, with random rotations of the start.
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int round = 0; round < 300; ++round) {
    const int n = 3 + int(unit(random) * 40);
    std::vector<V3d> c;
    for (int i = 0; i < n; ++i) c.emplace_back(float(i), float(-0.1 - 5 * unit(random)), 0);
    for (int i = n - 1; i >= 0; --i) c.emplace_back(float(i), float(0.1 + 5 * unit(random)), 0);
    std::rotate(c.begin(), c.begin() + int(unit(random) * c.size()) % int(c.size()), c.end());
    double exact = 0, covered = 0;
    for (size_t i = 0; i < c.size(); ++i) exact += 0.5 * c[i].cross(c[(i + 1) % c.size()]).z;
    std::vector<uint32_t> triangles;
    const int size = int(c.size());
    EXPECT_EQ(Triangulator().run(c, std::span(&size, 1), triangles), Triangulator::Outcome::Good);
    for (size_t t = 0; t < triangles.size(); t += 3) {
      const double a = 0.5 * (c[triangles[t + 1]] - c[triangles[t]]).cross(c[triangles[t + 2]] - c[triangles[t]]).z;
      EXPECT_GT(a, 0);
      covered += a;
    }
    EXPECT_NEAR(covered / exact, 1, 1e-9);
    EXPECT_EQ(triangles.size() / 3, c.size() - 2);
  }
}

TEST(Polygon, TangledOutlinesSurvive) {
  const std::vector<std::vector<float>> outlines = {
      {0, 0, 0, 1, 1, 0, 1, 0, 0, 0, 1, 0, 0.5f, 3, 0},                           // crosses itself
      {0, 0, 0, 2, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, 0, 2, 0},                     // doubled points
      {0, 0, 0, 2, 0, 0, 2, 2, 0, 5, 5, 0, 2, 2, 0, 0, 2, 0},                     // a spike
      {0, 1, 0, .59f, -.81f, 0, -.95f, .31f, 0, .95f, .31f, 0, -.59f, -.81f, 0},  // pentagram
  };
  for (const auto& p : outlines) {
    Quiet d;
    const auto m = tessellate(polygons({}, p), {}, d);
    ASSERT_TRUE(m.has_value());
    EXPECT_GT(area(*m), 0);
    for (uint32_t i : m->indices) EXPECT_LT(i, m->vertexCount);
  }
  Quiet d;
  EXPECT_TRUE(tessellate(polygons({}, outlines[3]), {}, d).has_value());
  EXPECT_EQ(d.count("GEOM-FACE-TANGLED"), 1u);
  Quiet none;  // doubled points and spikes change nothing that anyone could see
  EXPECT_NEAR(area(*tessellate(polygons({}, outlines[1]), {}, none)), 4, 1e-6);
  EXPECT_NEAR(area(*tessellate(polygons({}, outlines[2]), {}, none)), 4, 1e-6);
  // Random garbage: no crash, no endless loop, only corners that exist.
  std::mt19937 random(3);
  std::uniform_int_distribution<int> coordinate(0, 6);
  for (int round = 0; round < 500; ++round) {
    std::vector<V3d> c(3 + round % 60);
    for (V3d& v : c) v = V3d(coordinate(random), coordinate(random), 0);
    const int sizes[2] = {int(c.size() - c.size() / 3), int(c.size() / 3)};
    std::vector<uint32_t> triangles;
    Triangulator().run(c, sizes, triangles);
    for (uint32_t i : triangles) ASSERT_LT(i, c.size());
  }
}

// How often a loop goes round (x, y).
int windingOf(std::span<const V3d> loop, double x, double y) {
  int w = 0;
  for (size_t i = 0; i < loop.size(); ++i) {
    const V3d &a = loop[i], &b = loop[(i + 1) % loop.size()];
    const double side = (b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y);
    if (a.y <= y && b.y > y && side > 0) ++w;
    if (a.y > y && b.y <= y && side < 0) --w;
  }
  return w;
}

// Every place once where the outline goes round it and no hole does, none elsewhere, and all facing one way.
TEST(Polygon, CrossedOutlinesCoverWhatTheyGoRound) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  size_t inside = 0;
  for (int round = 0; round < 300; ++round) {
    std::vector<V3d> c(size_t(4 + round % 9) + (round % 3 == 0 ? 5 : 0));
    // on a grid, too: corners upon each other and upon edges
    const auto draw = [&] { return round % 2 ? std::round(3 * coordinate(random)) / 3 : coordinate(random); };
    for (V3d& v : c) {
      const double x = draw(), y = draw();
      v = V3d(x, y, .5 * x - .25 * y);
    }
    std::vector<int> sizes{int(c.size())};
    if (round % 3 == 0) sizes = {int(c.size()) - 5, 5};
    const std::span<const V3d> outer(c.data(), size_t(sizes[0])), hole(c.data() + sizes[0], c.size() - outer.size());
    WindingFill fill;
    fillByWinding(c, sizes, fill);
    std::vector<V3d> at;
    for (const EdgePoint& p : fill.points) at.push_back(c[p.from] + (c[p.to] - c[p.from]) * p.share);
    const auto turn = [](const V3d& p, const V3d& q, double x, double y) {
      return (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
    };
    double way = 0;
    for (size_t t = 0; t < fill.triangles.size(); t += 3) {
      const V3d &a = at[fill.triangles[t]], &b = at[fill.triangles[t + 1]], &d = at[fill.triangles[t + 2]];
      const double twice = turn(a, b, d.x, d.y);
      if (std::abs(twice) < 1e-9) continue;
      if (way == 0) way = twice;
      ASSERT_GT(twice * way, 0) << "round " << round;
    }
    for (int k = 0; k < 40; ++k) {
      const double x = coordinate(random), y = coordinate(random);
      int covered = 0;
      for (size_t t = 0; t < fill.triangles.size(); t += 3) {
        const V3d &a = at[fill.triangles[t]], &b = at[fill.triangles[t + 1]], &d = at[fill.triangles[t + 2]];
        const double u = turn(a, b, x, y), v = turn(b, d, x, y), w = turn(d, a, x, y);
        covered += (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
      }
      const bool isInside = windingOf(outer, x, y) != 0 && (hole.empty() || windingOf(hole, x, y) == 0);
      ASSERT_EQ(covered, int(isInside)) << "round " << round << " at " << x << " " << y;
      inside += isInside;
    }
  }
  EXPECT_GT(inside, 1000u);
}

TEST(Polygon, BowTiesAndStars) {
  struct Case {
    std::vector<float> p;
    double area;
  };
  const Case cases[] = {
      {{0, 0, 0, 1, 1, 0, 1, 0, 0, 0, 1, 0}, .5},  // its halves cancel
      // its diagonals y = x / 2 and y = 3 - 3 x / 2 meet at (1.5, .75)
      {{0, 0, 0, 2, 1, 0, 2, 0, 0, 0, 3, 0}, .5 * 3 * 1.5 + .5 * 1 * .5},
      {{0, 1, 0, .58778525f, -.80901699f, 0, -.95105652f, .30901699f, 0, .95105652f, .30901699f, 0, -.58778525f,
        -.80901699f, 0},
       1.12256994},  // with its middle
  };
  for (size_t k = 0; k < std::size(cases); ++k) {
    Quiet d;
    const auto m = tessellate(polygons({}, cases[k].p), {}, d);
    ASSERT_TRUE(m.has_value()) << k;
    EXPECT_EQ(d.count("GEOM-FACE-TANGLED"), 1u) << k;
    EXPECT_NEAR(area(*m), cases[k].area, 1e-5) << k;
    for (uint32_t t = 1; t < m->triangleCount(); ++t) EXPECT_GT(normalOf(*m, 0).dot(normalOf(*m, t)), .999) << k;
  }
  // new points have what lies between the corners of their edge, at all times
  PolygonMesh shape;
  shape.verticesPerLoop = {4, 4};
  shape.vertices = {0, 1, 2, 3, 2, 4, 5, 1};
  const std::vector<float> p{0, 0, 0, 1, 1, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 2, 1, 0};
  scene::Primitive pair = polygons(shape, p);
  std::vector<float> xs, ys, twice;
  for (size_t i = 0; i < p.size(); ++i) twice.push_back(2 * p[i]);
  for (size_t i = 0; i < p.size(); i += 3) xs.push_back(p[i]);
  for (const int v : shape.vertices) ys.push_back(p[size_t(3 * v + 1)]);
  pair.primvars.set(parameter("xs", StorageClass::Vertex, ValueType::Float, xs));
  pair.primvars.set(parameter("ys", StorageClass::FaceVarying, ValueType::Float, ys));
  pair.primvars.set(parameter("side", StorageClass::Uniform, ValueType::Float, {0, 1}));
  pair.times = {0, 1};
  pair.motion.resize(1);
  pair.motion[0].set(points(twice));
  Quiet d;
  const auto m = tessellate(pair, {}, d);
  ASSERT_TRUE(m.has_value());
  EXPECT_EQ(d.count("GEOM-FACE-TANGLED"), 1u);
  EXPECT_NEAR(area(*m), 1.5, 1e-6);
  EXPECT_NEAR(area(*m, 1), 6, 1e-6);
  EXPECT_GT(m->vertexCount, 6u);
  ASSERT_EQ(m->find("xs")->data.size(), m->vertexCount);
  ASSERT_EQ(m->find("ys")->data.size(), m->indices.size());
  for (uint32_t i = 0; i < m->indices.size(); ++i) {
    const V3d at = vertex(*m, m->indices[i]);
    EXPECT_NEAR(m->find("xs")->data[m->indices[i]], at.x, 1e-6);
    EXPECT_NEAR(m->find("ys")->data[i], at.y, 1e-6);
    EXPECT_EQ(m->faceOf(i / 3), at.x > 1 || (m->faceOf(i / 3) && at.x >= 1) ? 1u : 0u);
  }
}

TEST(Polygon, QuadsChooseTheirDiagonal) {
  // A dart: only the cut from its notch is inside.
  PolygonMesh shape;
  shape.verticesPerLoop = {4};
  shape.vertices = {0, 1, 2, 3};
  const Mesh dart = made(polygons(shape, {0, 0, 0, 2, -2, 0, 0.5f, 0, 0, 2, 2, 0}));
  EXPECT_TRUE(dart.quadPairs);
  EXPECT_NEAR(area(dart), 1, 1e-6);
  const Mesh turned = made(polygons(shape, {2, 2, 0, 0, 0, 0, 2, -2, 0, 0.5f, 0, 0}));
  EXPECT_NEAR(area(turned), 1, 1e-6);
  EXPECT_GT(normalOf(turned, 0).z * normalOf(turned, 1).z, 0);
}

TEST(Polygon, EveryPrimvarClass) {
  // A triangle, a quad and a concave pentagon that share points; so faceOfTriangle is 0, 1, 1, 2, 2, 2.
  PolygonMesh shape;
  shape.verticesPerLoop = {3, 4, 5};
  shape.vertices = {0, 1, 2, 1, 3, 4, 2, 4, 3, 5, 6, 7};
  std::vector<float> p{0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 1, 1, 0, 4, 0, 0, 2.2f, .6f, 0, 4, 2, 0};
  scene::Primitive prim = polygons(shape, p);
  auto numbers = [](int n) {
    std::vector<float> v(n);
    for (int i = 0; i < n; ++i) v[i] = float(i);
    return v;
  };
  prim.primvars.set(parameter("c", StorageClass::Constant, ValueType::Float, {7}));
  prim.primvars.set(parameter("u", StorageClass::Uniform, ValueType::Float, numbers(3)));
  prim.primvars.set(parameter("va", StorageClass::Varying, ValueType::Float, numbers(8)));
  prim.primvars.set(parameter("ve", StorageClass::Vertex, ValueType::Color, numbers(24)));
  prim.primvars.set(parameter("fv", StorageClass::FaceVarying, ValueType::Float, numbers(24), 2));
  prim.primvars.set(parameter("fx", StorageClass::FaceVertex, ValueType::Float, numbers(12)));
  scene::Parameter label;
  label.name = "label";
  label.type = ValueType::String;
  label.strings = {"a", "b", "c"};
  prim.primvars.set(label);
  scene::Parameter number;
  number.name = "id";
  number.type = ValueType::Int;
  number.ints = {5, 6, 7};
  prim.primvars.set(number);
  const Mesh m = made(prim);
  ASSERT_EQ(m.faceOfTriangle, (std::vector<uint32_t>{0, 1, 1, 2, 2, 2}));
  ASSERT_FALSE(m.quadPairs);
  using R = Primvar::Rate;
  EXPECT_EQ(m.find("c")->rate, R::Constant);
  EXPECT_EQ(m.find("u")->rate, R::PerFace);
  EXPECT_EQ(m.find("u")->data, numbers(3));
  EXPECT_EQ(m.find("va")->rate, R::PerVertex);
  EXPECT_EQ(m.find("va")->data, numbers(8));
  EXPECT_EQ(m.find("ve")->width, 3);
  EXPECT_EQ(m.find("label")->strings[2], "c");
  EXPECT_EQ(m.find("label")->rate, R::PerFace);
  EXPECT_EQ(m.find("id")->data, (std::vector<float>{5, 6, 7}));
  // A facevarying value sits at the corner of its face: it leads back to the same point.
  const Primvar *fv = m.find("fv"), *fx = m.find("fx");
  ASSERT_EQ(fv->rate, R::PerCorner);
  ASSERT_EQ(fv->width, 2);
  ASSERT_EQ(fv->data.size(), m.indices.size() * 2);
  const size_t firstCorner[] = {0, 3, 7, 12};
  for (size_t i = 0; i < m.indices.size(); ++i) {
    const size_t corner = size_t(fx->data[i]), face = m.faceOfTriangle[i / 3];
    EXPECT_GE(corner, firstCorner[face]);
    EXPECT_LT(corner, firstCorner[face + 1]);
    EXPECT_EQ(uint32_t(shape.vertices[corner]), m.indices[i]);
    EXPECT_EQ(fv->data[2 * i], float(2 * corner));
    EXPECT_EQ(fv->data[2 * i + 1], float(2 * corner + 1));
  }
}

TEST(Polygon, QuadMeshParametersAndCorners) {
  PolygonMesh shape;
  shape.verticesPerLoop = {4, 4};
  shape.vertices = {0, 1, 4, 3, 1, 2, 5, 4};
  scene::Primitive prim = polygons(shape, {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0});
  prim.primvars.set(parameter("fx", StorageClass::FaceVarying, ValueType::Float, {0, 1, 2, 3, 4, 5, 6, 7}));
  prim.primvars.set(parameter("u", StorageClass::Uniform, ValueType::Float, {3, 4}));
  const Mesh m = made(prim);
  ASSERT_TRUE(m.quadPairs);
  for (uint32_t t = 0; t < 4; ++t) {
    EXPECT_EQ(m.faceOf(t), t / 2);
    for (int k = 0; k < 3; ++k) {
      const int corner = int(m.find("fx")->data[3 * t + k]);
      EXPECT_EQ(uint32_t(shape.vertices[corner]), m.indices[3 * t + k]);
      const Imath::V2f expected[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
      EXPECT_EQ(m.uvOf(t, k), expected[corner % 4]);
    }
  }
}

TEST(Polygon, NormalsOfEveryClass) {
  PolygonMesh shape;
  shape.verticesPerLoop = {3, 3};
  shape.vertices = {0, 1, 2, 2, 1, 3};
  const std::vector<float> p{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  const struct {
    StorageClass storage;
    int count;
    Primvar::Rate rate;
  } table[] = {{StorageClass::Uniform, 2, Primvar::Rate::PerFace},
               {StorageClass::Varying, 4, Primvar::Rate::PerVertex},
               {StorageClass::Vertex, 4, Primvar::Rate::PerVertex},
               {StorageClass::FaceVarying, 6, Primvar::Rate::PerCorner}};
  for (const auto& row : table) {
    scene::Primitive prim = polygons(shape, p);
    std::vector<float> n;
    for (int i = 0; i < row.count; ++i) n.insert(n.end(), {0, 0, float(2 + i)});
    prim.primvars.set(parameter("N", row.storage, ValueType::Normal, n));
    const Mesh m = made(prim);
    ASSERT_EQ(m.find("N")->rate, row.rate);
    for (size_t i = 0; i < m.find("N")->data.size(); ++i) EXPECT_EQ(m.find("N")->data[i], i % 3 == 2 ? 1.f : 0.f);
    // Normals that all point to the back are turned; a zero normal is replaced.
    for (float& f : n) f = -f;
    std::fill(n.begin(), n.begin() + 3, 0.f);
    prim.primvars.set(parameter("N", row.storage, ValueType::Normal, n));
    Quiet d;
    const auto turned = tessellate(prim, {}, d);
    EXPECT_EQ(d.count("GEOM-NORMALS-TURNED"), 1u);
    EXPECT_EQ(d.count("GEOM-NORMAL"), 1u);
    for (size_t i = 2; i < turned->find("N")->data.size(); i += 3) EXPECT_EQ(turned->find("N")->data[i], 1.f);
  }
}

TEST(Polygon, SmoothNormalsAreDerivedOnRequestOnly) {
  // A cube: its corner normals point along the diagonals however its faces are cut, because corners weigh by angle.
  PolygonMesh shape;
  shape.verticesPerLoop = {4, 4, 4, 4, 4, 4};
  shape.vertices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  std::vector<float> p;
  for (int i = 0; i < 8; ++i) p.insert(p.end(), {i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f});
  scene::Primitive prim = polygons(shape, p);
  EXPECT_EQ(made(prim).find("N"), nullptr);
  EXPECT_GT(volume(made(prim)), 7.999);  // outward
  for (bool reverse : {false, true}) {
    setAttribute(prim, "polygon:smoothnormals", 1);
    edit(prim, [&](scene::Attributes& a) { a.reverseOrientation = reverse; });
    const Mesh m = made(prim);
    const Primvar* n = m.find("N");
    ASSERT_NE(n, nullptr);
    const double side = reverse ? -1 : 1;
    for (int i = 0; i < 8; ++i)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(n->data[3 * i + c], side * p[3 * i + c] / std::sqrt(3.0), 0.12);
  }
}

TEST(Polygon, DeformationKeys) {
  scene::Primitive prim = polygons({}, {0, 0, 0, 1, 0, 0, 0, 1, 0});
  prim.primvars.set(parameter("N", StorageClass::Varying, ValueType::Normal, {0, 0, 1, 0, 0, 1, 0, 0, 1}));
  prim.times = {0, 0.5, 1};
  prim.motion.resize(2);
  prim.motion[0].set(points({0, 0, 1, 1, 0, 1, 0, 1, 1}));
  prim.motion[1].set(points({0, 0, 3, 1, 0, 3, 0, 1, 3}));
  prim.motion[1].set(parameter("N", StorageClass::Varying, ValueType::Normal, {0, 0, 1, 0, 1, 0, 0, 0, 1}));
  const Mesh m = made(prim);
  EXPECT_EQ(m.times, prim.times);
  ASSERT_EQ(m.points.size(), 9u);
  EXPECT_EQ(vertex(m, 1, 2), V3d(1, 0, 3));
  ASSERT_EQ(m.find("N")->data.size(), 27u);
  EXPECT_EQ(m.find("N")->data[11], 1.f);      // key 1 repeats key 0
  EXPECT_EQ(m.find("N")->data[18 + 4], 1.f);  // key 2 has its own
  EXPECT_EQ(m.bounds.max.z, 3);
  // A polygon that grows out of a point is cut by the first key that has an area.
  scene::Primitive grows = polygons({}, std::vector<float>(15, 1.f));
  grows.times = {0, 1};
  grows.motion.resize(1);
  grows.motion[0].set(points({0, 0, 0, 4, 0, 0, 4, 4, 0, 2, 1, 0, 0, 4, 0}));
  EXPECT_NEAR(area(made(grows), 1), 10, 1e-6);
  // Keys that say the same thing are one; keys that do not fit are left out.
  scene::Primitive still = prim;
  still.motion.assign(2, still.primvars);
  EXPECT_EQ(made(still).keyCount(), 1);
  prim.motion[1].set(points({0, 0, 0}));
  Quiet d;
  EXPECT_EQ(tessellate(prim, {}, d)->keyCount(), 1);
  EXPECT_EQ(d.count("GEOM-MOTION-MISMATCH"), 1u);
}

TEST(Polygon, FarFromTheOriginKeepsPrecision) {
  std::vector<float> p{1000000.0f, 2000000.0f, 0, 1000001.5f, 2000000.0f, 0, 1000000.0f, 2000001.25f, 0};
  const Mesh m = made(polygons({}, p));
  EXPECT_NE(m.origin, V3d(0));
  for (const V3f& v : m.points) EXPECT_LT(v.length(), 8);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(vertex(m, i), V3d(p[3 * i], p[3 * i + 1], p[3 * i + 2]));
  EXPECT_EQ(made(polygons({}, {1, 0, 0, 2, 0, 0, 1, 1, 0})).origin, V3d(0));
}

TEST(Polygon, BadInputTable) {
  const float nan = std::nanf("");
  const std::vector<float> square{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  std::vector<float> withNan = square, withInf = square;
  withNan[3] = nan;
  withInf[0] = INFINITY;
  const struct {
    PolygonMesh shape;
    std::vector<float> p;
    const char* code;
    uint32_t triangles;  // 0: nothing is made
  } table[] = {
      {{}, {}, "GEOM-NO-POINTS", 0},
      {{}, {0, 0, 0, 1, 1, 1}, "GEOM-FACE-CORNERS", 0},
      {{}, {0, 0, 0, 1, 1, 1, 2, 2, 2}, "GEOM-ZERO-AREA", 0},
      {{}, {0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4}, "GEOM-FACE-AREA", 0},
      {{}, withNan, "GEOM-NOT-FINITE", 0},
      {{{}, {3, 3}, {0, 1, 2, 0, 2, 3}}, withNan, "GEOM-NOT-FINITE", 1},
      {{{}, {3, 3}, {0, 1, 2, 1, 2, 3}}, withInf, "GEOM-NOT-FINITE", 1},
      {{{}, {3, 3}, {0, 1, 2, 0, 2, 4}}, square, "GEOM-INDEX-RANGE", 1},
      {{{}, {3, 3}, {0, 1, 2, 0, 2, -1}}, square, "GEOM-INDEX-RANGE", 1},
      {{{}, {4, 4}, {0, 1, 2, 3, 0, 1, 2, 9}}, square, "GEOM-INDEX-RANGE", 2},
      {{{}, {3, 3}, {0, 1, 2, 0}}, square, "GEOM-FACE-LIST", 1},
      {{{}, {3, -3}, {0, 1, 2, 0, 2, 3}}, square, "GEOM-FACE-LIST", 1},
      {{{}, {3, 2000000000}, {0, 1, 2, 0, 2, 3}}, square, "GEOM-FACE-LIST", 1},
      {{{1, 2000000000}, {3, 3}, {0, 1, 2, 0, 2, 3}}, square, "GEOM-FACE-LIST", 1},
      {{{1, -1}, {3, 3}, {0, 1, 2, 0, 2, 3}}, square, "GEOM-FACE-LIST", 1},
      {{{}, {3, 2}, {0, 1, 2, 0, 2}}, square, "GEOM-FACE-CORNERS", 1},
      {{{1, 0}, {3}, {0, 1, 2}}, square, "GEOM-FACE-CORNERS", 1},
      {{{}, {5}, {}}, square, "GEOM-FACE-LIST", 0},
  };
  for (const auto& row : table) {
    SCOPED_TRACE("row " + std::to_string(&row - table));
    Quiet d;
    const auto m = tessellate(polygons(row.shape, row.p), {}, d);
    EXPECT_EQ(d.count(row.code), 1u) << row.code;
    EXPECT_EQ(m ? m->triangleCount() : 0, row.triangles);
    if (m) {
      for (const V3f& v : m->points) EXPECT_TRUE(std::isfinite(v.x + v.y + v.z));
      EXPECT_TRUE(std::isfinite(m->bounds.max.x));
      for (uint32_t i : m->indices) EXPECT_LT(i, m->vertexCount);
    }
  }
}

TEST(Polygon, BadPrimvarTable) {
  PolygonMesh shape;
  shape.verticesPerLoop = {3, 3};
  shape.vertices = {0, 1, 2, 0, 2, 3};
  const std::vector<float> p{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  auto make = [&](scene::Parameter v, const char* code) {
    scene::Primitive prim = polygons(shape, p);
    v.name = "x";
    prim.primvars.set(v);
    Quiet d;
    auto m = tessellate(prim, {}, d);
    EXPECT_EQ(d.count(code), 1u) << code;
    const Primvar* found = m->find("x");
    return found ? std::optional<Primvar>(*found) : std::nullopt;
  };
  using R = Primvar::Rate;
  EXPECT_FALSE(make(parameter("", StorageClass::Vertex, ValueType::Float, {1, 2, 3}), "GEOM-PRIMVAR-COUNT"));
  EXPECT_EQ(make(parameter("", StorageClass::Vertex, ValueType::Float, {1}), "GEOM-PRIMVAR-COUNT")->rate,
            R::Constant);
  EXPECT_EQ(make(parameter("", StorageClass::Uniform, ValueType::Float, {1, 2, 3, 4}), "GEOM-PRIMVAR-COUNT")->rate,
            R::PerVertex);
  EXPECT_EQ(
      make(parameter("", StorageClass::Vertex, ValueType::Float, {1, 2, 3, 4, 5}), "GEOM-PRIMVAR-COUNT")->data.size(),
      4u);
  EXPECT_FALSE(make(parameter("", StorageClass::Vertex, ValueType::Float, {}), "GEOM-PRIMVAR"));
  scene::Parameter reference = parameter("", StorageClass::Constant, ValueType::Float, {});
  reference.isReference = true;
  EXPECT_FALSE(make(reference, "GEOM-PRIMVAR"));
  scene::Parameter strings;
  strings.storage = StorageClass::Vertex;
  strings.type = ValueType::String;
  strings.strings = {"a", "b", "c", "d"};
  EXPECT_FALSE(make(strings, "GEOM-PRIMVAR"));
}

TEST(Orientation, TableForAPolygon) {
  // x right, y up, z away from the viewer: camera space, left-handed. Seen from the viewer the corners of this
  // triangle run counter-clockwise; under a left-handed orientation the front is where they run clockwise, that is
  // the far side.
  using O = scene::Attributes::Orientation;
  const struct {
    O orientation;
    bool reverse, mirrored;
    double z;  // of the world-space front normal
  } table[] = {
      {O::Outside, false, false, 1},
      {O::Inside, false, false, -1},
      {O::LeftHanded, false, false, 1},
      {O::Outside, true, false, -1},
      {O::RightHanded, false, false, -1},
      // Mirrored in x, the corners run clockwise for the viewer. All orientations turn with the object: the mirror
      // image of an object that showed its back shows its back.
      {O::Outside, false, true, 1},
      {O::LeftHanded, false, true, 1},
      {O::RightHanded, false, true, -1},
      {O::LeftHanded, true, true, -1},
  };
  for (const auto& row : table) {
    scene::Primitive p = polygons({}, {0, 0, 0, 1, 0, 0, 0, 1, 0});
    Imath::M44d m;
    if (row.mirrored) m.setScale(V3d(-1, 1, 1));
    p.toWorld = scene::Transform::fixed(m);
    edit(p, [&](scene::Attributes& a) {
      a.orientation = row.orientation;
      a.reverseOrientation = row.reverse;
    });
    V3d n;
    m.inverse().transposed().multDirMatrix(normalOf(made(p), 0), n);
    EXPECT_NEAR(n.z, row.z, 1e-6) << "row " << (&row - table);
  }
}

TEST(Polygon, AMillionTriangles) {
  // A 708 x 708 grid of triangle pairs: 1,002,528 triangles, only P.
  const int side = 708;
  std::vector<float> p;
  for (int j = 0; j <= side; ++j)
    for (int i = 0; i <= side; ++i) p.insert(p.end(), {float(i), float(j), float((i * j) % 7)});
  PolygonMesh shape;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const int a = j * (side + 1) + i;
      for (int v : {a, a + 1, a + side + 2, a, a + side + 2, a + side + 1}) shape.vertices.push_back(v);
    }
  shape.verticesPerLoop.assign(shape.vertices.size() / 3, 3);
  const double count = double(shape.verticesPerLoop.size());
  scene::Primitive triangles = polygons(shape, p);
  PolygonMesh quads;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const int a = j * (side + 1) + i;
      for (int v : {a, a + 1, a + side + 2, a + side + 1}) quads.vertices.push_back(v);
    }
  quads.verticesPerLoop.assign(quads.vertices.size() / 4, 4);
  for (const scene::Primitive& prim : {triangles, polygons(quads, p)}) {
    const Mesh m = made(prim);
    EXPECT_EQ(double(m.triangleCount()), count);
    EXPECT_TRUE(m.faceOfTriangle.empty());
    EXPECT_LE(double(m.bytes()) / count, 20);
  }
}

// As on patches: the attribute's four places are those of (u, v) = (0,0), (1,0), (0,1), (1,1); corners go around. Faces
// of other counts of corners, and those that say their own, have none of it.
TEST(Polygon, TextureCoordinatesAttribute) {
  const auto with = [](const scene::Primitive& given) {
    scene::Primitive p = given;
    auto a = std::make_shared<scene::Attributes>();
    a->textureCoordinates = {0, 0, 2, 0, 0, 3, 2, 3};
    p.attributes = a;
    return p;
  };
  PolygonMesh one;
  one.verticesPerLoop = {4};
  const scene::Primitive square = polygons(one, {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0});
  EXPECT_EQ(made(square).find("st"), nullptr) << "(u, v) are meant";
  PolygonMesh two;
  two.verticesPerLoop = {4, 4};
  two.vertices = {0, 1, 4, 3, 1, 2, 5, 4};
  const scene::Primitive pair = polygons(two, {-1, -1, 0, 0, -1, 0, 1, -1, 0, -1, 1, 0, 0, 1, 0, 1, 1, 0});
  for (const scene::Primitive& p : {square, pair}) {
    const Mesh m = made(with(p));
    const Primvar* st = m.find("st");
    ASSERT_NE(st, nullptr);
    ASSERT_EQ(st->rate, Primvar::Rate::PerCorner);
    ASSERT_EQ(st->data.size(), 2 * m.indices.size());
    const double side = m.triangleCount() == 2 ? 2 : 1;
    for (size_t i = 0; i < m.indices.size(); ++i) {
      const V3d at = vertex(m, m.indices[i]);
      const double left = side == 2 || i < 6 ? -1 : 0;
      EXPECT_EQ(st->data[2 * i], 2 * (at.x - left) / side) << i;
      EXPECT_EQ(st->data[2 * i + 1], 3 * (at.y + 1) / 2) << i;
    }
  }
  scene::Primitive own = with(square);
  own.primvars.set(parameter("st", StorageClass::FaceVarying, ValueType::Float, {0, 0, 1, 0, 1, 1, 0, 1}, 2));
  EXPECT_EQ(made(own).find("st")->data[2], 1);
  PolygonMesh triangle;
  triangle.verticesPerLoop = {3};
  EXPECT_EQ(made(with(polygons(triangle, {0, 0, 0, 1, 0, 0, 0, 1, 0}))).find("st"), nullptr);
}

}  // namespace
}  // namespace kinora::geometry
