// Proves cutting and moving of meshes against closed forms: spheres, boxes, waves; that nothing tears wherever vertices
// are apart; what becomes of offsets that are no numbers.
#include "geometry/displace.h"

#include <limits>

#include "geometry/refine.h"
#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {

using namespace testing;
using Field = std::function<V3d(const V3d& p, const V3d& n, size_t key)>;

DiceRate displaced(double e) {
  DiceRate r = edge(e);
  r.isDisplaced = true;
  return r;
}
V3d normal(const Mesh& m, uint32_t v, size_t key = 0) {
  const Primvar& n = *m.find("N");
  const float* x = &n.data[3 * ((m.movesWithKeys(n) ? key * m.vertexCount : 0) + v)];
  return V3d(x[0], x[1], x[2]);
}
DisplacementResult move(Mesh& m, const Field& field) {
  std::vector<V3f> offsets;
  for (size_t key = 0; key < size_t(m.keyCount()); ++key)
    for (uint32_t v = 0; v < m.vertexCount; ++v)
      offsets.emplace_back(field(vertex(m, v, key), normal(m, v, key), key));
  const Micropolygons grid(m);
  return displace(m, grid, std::move(offsets));
}
Field along(double d) {
  return [d](const V3d&, const V3d& n, size_t) { return n * d; };
}

scene::Primitive polygonsOf(PolygonMesh shape, std::vector<float> p) {
  scene::Primitive out = primitive(std::move(shape));
  out.primvars.set(points(std::move(p)));
  return out;
}
scene::Primitive box() {
  return polygonsOf(
      {{}, {4, 4, 4, 4, 4, 4}, {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5}},
      {-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1});
}
// Faces of three, four and five corners side by side, bent along their edges.
scene::Primitive mixed() {
  return polygonsOf({{}, {4, 5, 3}, {0, 1, 2, 3, 1, 4, 5, 6, 2, 3, 2, 6}},
                    {0, 0, 0, 1, 0, .2f, 1, 1, .1f, 0, 1, 0, 2, 0, .4f, 2.3f, .6f, .2f, 1.6f, 1.4f, .3f});
}

// Length of all edges that one triangle alone has, by place.
double openLength(const Mesh& m) {
  std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> count;
  const auto key = [&](uint32_t v) { return std::array<float, 3>{m.points[v].x, m.points[v].y, m.points[v].z}; };
  for (uint32_t t = 0; t < m.triangleCount(); ++t)
    for (size_t k = 0; k < 3; ++k) {
      const auto a = key(m.indices[3 * t + k]), b = key(m.indices[3 * t + (k + 1) % 3]);
      ++count[std::minmax(a, b)];
    }
  double sum = 0;
  for (const auto& [edge, uses] : count)
    if (uses == 1)
      sum += (V3d(edge.first[0], edge.first[1], edge.first[2]) - V3d(edge.second[0], edge.second[1], edge.second[2]))
                 .length();
  return sum;
}

TEST(Refine, KeepsTheSurfaceItsPlacesAndSharedEdges) {
  for (const double e : {0.7, 0.23, 0.05}) {
    const Mesh whole = made(mixed()), m = refined(whole, displaced(e));
    EXPECT_NEAR(area(m), area(whole), 2e-3 * area(whole));
    EXPECT_GT(m.triangleCount(), whole.triangleCount());
    const EdgeCount before = edges(whole), after = edges(m);
    EXPECT_EQ(before.wrong, 0u);
    EXPECT_EQ(after.wrong, 0u);
    // what is open is the rim alone: no inner edge came apart
    double rim = 0, wanted = 0;
    for (const Mesh* mesh : {&whole, &m}) (mesh == &whole ? wanted : rim) = openLength(*mesh);
    EXPECT_NEAR(rim, wanted, 1e-5);
    // every edge is about as long as was asked for, diagonals and what leads from coarse to fine longer
    for (uint32_t t = 0; t < m.triangleCount(); ++t) {
      const auto c = corners(m, t);
      for (int k = 0; k < 3; ++k) EXPECT_LT((c[size_t(k)] - c[size_t((k + 1) % 3)]).length(), 2.5 * e);
    }
  }
}

TEST(Refine, ABoxStaysClosedAndItsNormalsStayFlat) {
  const Mesh m = refined(made(box()), displaced(0.13));
  EXPECT_EQ(edges(m).open, 0u);
  EXPECT_EQ(edges(m).wrong, 0u);
  EXPECT_NEAR(volume(m), 8, 1e-5);
  EXPECT_TRUE(m.quads);
  for (uint32_t t = 0; t < m.triangleCount(); ++t) {
    const auto c = corners(m, t);
    const V3d face = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
    for (int k = 0; k < 3; ++k) EXPECT_GT(face.dot(normal(m, m.indices[3 * t + size_t(k)])), 0.9999);
    EXPECT_LT(m.faceOf(t), 6u);
    for (int k = 0; k < 3; ++k) {
      const Imath::V2f uv = m.uvOf(t, k);
      EXPECT_TRUE(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1);
    }
  }
}

TEST(Refine, ValuesOfCornersComeApartOnlyWhereTheyDiffer) {
  scene::Primitive p =
      polygonsOf({{}, {4, 4}, {0, 1, 2, 3, 1, 4, 5, 2}}, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 2, 0, 0, 2, 1, 0});
  // continuous in x, then with a seam at x = 1
  for (const bool seam : {false, true}) {
    const float s = seam ? 5.f : 1.f;
    p.primvars.set(parameter("st", StorageClass::FaceVarying, ValueType::Float,
                             {0, 0, 1, 0, 1, 1, 0, 1, s, 0, s + 1, 0, s + 1, 1, s, 1}, 2));
    const Mesh m = refined(made(p), displaced(0.25));
    const Primvar& st = *m.find("st");
    ASSERT_EQ(st.rate, Primvar::Rate::PerVertex);
    EXPECT_EQ(m.vertexCount, seam ? 50u : 45u);
    for (uint32_t t = 0; t < m.triangleCount(); ++t)
      for (int k = 0; k < 3; ++k) {
        const uint32_t v = m.indices[3 * t + size_t(k)];
        EXPECT_NEAR(st.data[2 * v], vertex(m, v).x + (m.faceOf(t) == 1 && seam ? 4 : 0), 1e-6);
        EXPECT_NEAR(st.data[2 * v + 1], vertex(m, v).y, 1e-6);
      }
    // displaced by what differs across the seam it is one surface all the same
    Mesh torn = m;
    std::vector<V3f> offsets;
    for (uint32_t v = 0; v < m.vertexCount; ++v) offsets.emplace_back(0.f, 0.f, 0.1f * st.data[2 * v]);
    displace(torn, Micropolygons(m), offsets);
    EXPECT_EQ(edges(torn).open, edges(m).open);
  }
}

TEST(Refine, AFloorToTheHorizonIsCutAsItIsSeen) {
  // edges grow with the distance from an eye over one end
  const V3d eye(0, 0, 1);
  const auto pixel = [&](const V3d& p) { return 0.02 * (p - eye).length(); };
  DiceRate rate = displaced(1);
  rate.edgeLength = pixel;
  const Mesh m = refined(made(polygonsOf({{}, {4, 4}, {0, 1, 2, 3, 3, 2, 4, 5}},
                                         {-5, -1, 0, 5, -1, 0, 5, 60, 0, -5, 60, 0, 5, 99, 0, -5, 99, 0})),
                         rate);
  EXPECT_NEAR(openLength(m), 220, 1e-2);
  size_t coarse = 0;
  double most = 0;
  for (uint32_t t = 0; t < m.triangleCount(); ++t) {
    const auto c = corners(m, t);
    EXPECT_GT((c[1] - c[0]).cross(c[2] - c[0]).z, 0);
    for (size_t k = 0; k < 3; ++k) {
      const double length = (c[k] - c[(k + 1) % 3]).length() / pixel((c[k] + c[(k + 1) % 3]) * 0.5);
      coarse += length > 2;
      most = std::max(most, length);
    }
  }
  EXPECT_LT(most, 4);
  EXPECT_LT(coarse, m.triangleCount() / 10);  // of three edges each
  // evenly cut it would be 500 times 5,000 quads
  EXPECT_LT(m.triangleCount(), 400'000u);
}

// As many as fit, by the rule that was tried step by step before; and nothing that nobody wants.
TEST(Refine, OfSurfacesThatAreFarTooLarge) {
  scene::PolygonMesh square;
  square.verticesPerLoop = {4};
  for (const double size : {1e3, 1e9, 1e18}) {
    scene::Primitive p = primitive(square);
    const float s = float(size);
    p.primvars.set(points({0, 0, 0, s, 0, 0, s, s, 0, 0, s, 0}));
    const Mesh flat = made(p);
    DiceRate rate = edge(1);
    rate.maxTriangles = 5000;
    const Mesh m = refined(flat, rate);
    double steps = size;
    const auto along = [&] { return std::ceil(std::min(steps - 1e-6, 4096.0)); };
    while (2 * along() * along() > rate.maxTriangles) steps *= 0.8;
    EXPECT_EQ(m.triangleCount(), 2 * along() * along()) << size;
    EXPECT_NEAR(area(m) / (size * size), 1, 1e-5) << size;
    const std::atomic<bool> stop = true;
    rate.stop = &stop;
    EXPECT_EQ(refined(flat, rate).triangleCount(), 0u) << size;
  }
}

TEST(Refine, NeverMakesMoreThanItMay) {
  DiceRate rate = displaced(1e-4);
  rate.maxTriangles = 5000;
  const Mesh m = refined(made(box()), rate);
  EXPECT_LE(m.triangleCount(), 5600u);
  EXPECT_GT(m.triangleCount(), 2000u);
  EXPECT_EQ(edges(m).open, 0u);
}

TEST(Displace, ASphereByADistanceIsALargerSphere) {
  for (const double d : {0.25, -0.4}) {
    Mesh m = made(quadric(scene::Quadric::Kind::Sphere, {1, -1, 1, 360}), displaced(0.03));
    const Mesh before = m;
    const DisplacementResult r = move(m, along(d));
    EXPECT_NEAR(r.longest, std::abs(d), 1e-6);
    EXPECT_EQ(r.notFinite, 0u);
    const double radius = 1 + d;
    for (uint32_t v = 0; v < m.vertexCount; ++v) {
      EXPECT_NEAR(vertex(m, v).length(), radius, 2e-6);
      EXPECT_GT(normal(m, v).dot(vertex(m, v).normalized()), 1 - 1e-5);
    }
    EXPECT_NEAR(area(m), area(before) * radius * radius, 2e-4);
    EXPECT_EQ(edges(m).open, 0u);
    EXPECT_EQ(m.indices, before.indices);
    EXPECT_EQ(m.bounds.max.x > 0.99 * radius, true);
  }
}

TEST(Displace, ABoxByADistanceIsALargerBox) {
  // the sides of an edge move in different directions, and meet where both want to be
  Mesh m = refined(made(box()), displaced(0.2));
  move(m, along(0.3));
  EXPECT_EQ(edges(m).open, 0u);
  EXPECT_NEAR(volume(m), std::pow(2.6, 3), 1e-3);
  for (uint32_t v = 0; v < m.vertexCount; ++v) {
    const V3d p = vertex(m, v), n = normal(m, v);
    EXPECT_NEAR(n.dot(p), 1.3, 1e-5) << p.x << ' ' << p.y << ' ' << p.z;
  }
}

TEST(Displace, PolygonsMayMoveAsIfTheyWereSmooth) {
  scene::Primitive p = box();
  setAttribute(p, "polygon:smoothdisplacement", 1);
  EXPECT_EQ(made(p).find("N"), nullptr) << "what is not displaced stays as it is";
  Mesh m = refined(made(p, displaced(0.5)), displaced(0.5));
  const Mesh before = m;
  move(m, along(std::sqrt(3.)));
  EXPECT_EQ(edges(m).open, 0u);
  size_t seen = 0;
  for (uint32_t v = 0; v < m.vertexCount; ++v) {
    const V3d was = vertex(before, v);
    if (std::abs(was.x) < 1 || std::abs(was.y) < 1 || std::abs(was.z) < 1) continue;
    EXPECT_LT((vertex(m, v) - was * 2).length(), 1e-5);
    ++seen;
  }
  EXPECT_EQ(seen, 8u) << "corners are one vertex each";
}

TEST(Displace, AVectorMovesTheWholeSurface) {
  const V3d by(0.5, -0.25, 2);
  for (Mesh m : {refined(made(mixed()), displaced(0.1)), refined(made(box()), displaced(0.3)),
                 made(quadric(scene::Quadric::Kind::Torus, {1, 0.3f, 0, 360, 360}), displaced(0.05))}) {
    const Mesh before = m;
    move(m, [&](const V3d&, const V3d&, size_t) { return by; });
    for (uint32_t v = 0; v < m.vertexCount; ++v) {
      EXPECT_LT((vertex(m, v) - vertex(before, v) - by).length(), 1e-5);
      EXPECT_GT(normal(m, v).dot(normal(before, v)), 1 - 1e-6);
    }
  }
}

// Largest errors of height and normal of a plane that is moved by a wave, between vertices too.
std::pair<double, double> errorsOfWave(double e) {
  const double k = 2 * kPi, a = 0.1;
  Mesh m = refined(made(polygonsOf({{}, {4}, {0, 1, 2, 3}}, {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0})), displaced(e));
  const auto height = [&](double x, double y) { return a * std::sin(k * x) * std::cos(k * y); };
  move(m, [&](const V3d& p, const V3d& n, size_t) { return n * height(p.x, p.y); });
  double atMiddle = 0, ofNormal = 0;
  for (uint32_t t = 0; t < m.triangleCount(); t += 2) {
    EXPECT_EQ(m.quadOf(t), t);
    V3d middle(0);
    for (int c = 0; c < 4; ++c) middle += vertex(m, m.indices[Mesh::quadCorner(t, c)]) * 0.25;
    atMiddle = std::max(atMiddle, std::abs(middle.z - height(middle.x, middle.y)));
  }
  for (uint32_t v = 0; v < m.vertexCount; ++v) {
    const V3d p = vertex(m, v);
    if (p.x < 1e-3 || p.x > 2 - 1e-3 || p.y < 1e-3 || p.y > 2 - 1e-3) continue;  // the rim has neighbours on one side
    const V3d exact =
        V3d(-a * k * std::cos(k * p.x) * std::cos(k * p.y), a * k * std::sin(k * p.x) * std::sin(k * p.y), 1)
            .normalized();
    ofNormal = std::max(ofNormal, exact.cross(normal(m, v)).length());
  }
  return {atMiddle, ofNormal};
}

TEST(Displace, AWaveConvergesAtSecondOrder) {
  const auto coarse = errorsOfWave(0.05), fine = errorsOfWave(0.025), finest = errorsOfWave(0.0125);
  EXPECT_LT(finest.first, 2e-4);
  EXPECT_LT(finest.second, 2e-3);
  for (const auto& [a, b] : {std::pair(coarse, fine), std::pair(fine, finest)}) {
    EXPECT_NEAR(a.first / b.first, 4, 0.5);
    EXPECT_NEAR(a.second / b.second, 4, 0.5);
  }
}

TEST(Displace, NormalsThatAreGivenAreTakenOnTheSurfacesSide) {
  for (const double side : {1., -2.}) {
    Mesh m = made(quadric(scene::Quadric::Kind::Sphere, {1, -1, 1, 360}), displaced(0.2));
    std::vector<V3f> offsets(m.vertexCount, V3f(0)), normals;
    const V3d tilt(0.3, 0, 0);
    for (uint32_t v = 0; v < m.vertexCount; ++v)
      normals.emplace_back(vertex(m, v).z > 0 ? (normal(m, v) + tilt) * side : V3d(0));
    const Mesh before = m;
    displace(m, Micropolygons(m), offsets, normals);
    for (uint32_t v = 0; v < m.vertexCount; ++v) {
      const V3d own = normal(before, v), wanted = vertex(m, v).z > 0 ? (own + tilt).normalized() : own;
      EXPECT_GT(normal(m, v).dot(wanted), 1 - 1e-5);
    }
  }
}

TEST(Displace, EachKeyMovesForItself) {
  scene::Primitive p = box();
  p.times = {0, 1};
  scene::ParameterList later;
  std::vector<float> moved = p.primvars.find("P")->floats;
  for (float& x : moved) x *= 2;
  later.set(points(moved));
  p.motion.push_back(later);
  Mesh m = refined(made(p), displaced(0.25));
  ASSERT_EQ(m.keyCount(), 2);
  move(m, [](const V3d&, const V3d& n, size_t key) { return n * (key ? 0.5 : 0.1); });
  ASSERT_TRUE(m.movesWithKeys(*m.find("N")));
  for (uint32_t v = 0; v < m.vertexCount; ++v) {
    EXPECT_NEAR(normal(m, v, 0).dot(vertex(m, v, 0)), 1.1, 1e-5);
    EXPECT_NEAR(normal(m, v, 1).dot(vertex(m, v, 1)), 2.5, 1e-5);
  }
}

// Two quads that lie flat at first and are folded later are two pieces at both times: what tilts one leaves the normals
// of the other.
TEST(Displace, PiecesAreApartWhereAFoldComesLater) {
  const std::vector<float> flat{-1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 1, 0, 0, 1, 0, 1, 1, 0};
  std::vector<float> folded = flat;
  for (const size_t i : {0u, 2u, 3u, 5u}) folded[3 * i + 2] = 0.6f;
  scene::Primitive p = polygonsOf({{}, {4, 4}, {0, 1, 4, 3, 1, 2, 5, 4}}, flat);
  p.times = {0, 1};
  scene::ParameterList later;
  later.set(points(folded));
  p.motion.push_back(later);
  Mesh m = refined(made(p), displaced(0.25));
  ASSERT_EQ(m.keyCount(), 2);
  move(m, [](const V3d& at, const V3d& n, size_t) { return at.x < 0 ? n * -at.x : V3d(0); });
  size_t onFold = 0;
  for (uint32_t v = 0; v < m.vertexCount; ++v) {
    if (std::abs(vertex(m, v, 1).x) > 1e-6 || normal(m, v, 1).x > 0) continue;  // the fold, seen from the right
    ++onFold;
    EXPECT_LT((normal(m, v, 1) - V3d(-0.6, 0, 1).normalized()).length(), 1e-5);
  }
  EXPECT_GE(onFold, 5u);
}

TEST(Displace, WhatIsNoNumberStaysAndIsCounted) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, 1e20}) {
    Mesh m = made(quadric(scene::Quadric::Kind::Sphere, {1, -1, 1, 360}), displaced(0.2));
    const Mesh before = m;
    size_t wanted = 0;
    const DisplacementResult r = move(m, [&](const V3d& p, const V3d& n, size_t) {
      wanted += p.x > 0.5;
      return n * (p.x > 0.5 ? bad : 0.1);
    });
    EXPECT_EQ(r.notFinite, wanted);
    EXPECT_GT(wanted, 10u);
    EXPECT_NEAR(r.longest, 0.1, 1e-6);
    for (uint32_t v = 0; v < m.vertexCount; ++v) {
      EXPECT_NEAR(vertex(m, v).length(), vertex(before, v).x > 0.5 ? 1 : 1.1, 1e-5);
      EXPECT_NEAR(normal(m, v).length(), 1, 1e-5);
    }
  }
}

}  // namespace
}  // namespace kinora::geometry
