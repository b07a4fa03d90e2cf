// Faces that are cut where a rate differs over them: nothing opens, nothing moves, and what is left is even enough.
#include "geometry/grade.h"

#include "geometry/refine.h"
#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {

using namespace testing;

constexpr double kSide = 1e4;

scene::Primitive polygons(std::vector<int> sizes, std::vector<int> vertices, std::vector<float> at) {
  scene::PolygonMesh p;
  p.loopsPerFace.assign(sizes.size(), 1);
  p.verticesPerLoop = std::move(sizes);
  p.vertices = std::move(vertices);
  scene::Primitive out = primitive(std::move(p));
  std::vector<float> st;
  for (size_t i = 0; i < at.size(); i += 3) st.insert(st.end(), {at[i] / float(kSide), at[i + 1] / float(kSide)});
  out.primvars.set(points(std::move(at)));
  out.primvars.set(parameter("st", StorageClass::Vertex, ValueType::Float, std::move(st), 2));
  return out;
}

// An eye above the ground, a unit high: a micropolygon is a 25th of its distance.
DiceRate seenFrom(double height) {
  DiceRate r;
  r.edgeLength = [height](const V3d& p) { return 0.04 * (p - V3d(10, 20, height)).length(); };
  r.slope = 0.04;
  return r;
}

// Open edges that are not at the border of the square.
size_t gaps(const Mesh& m) {
  std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> seen;
  const auto at = [&](uint32_t i) {
    const V3d p = vertex(m, i);
    return std::array<float, 3>{float(p.x), float(p.y), float(p.z)};
  };
  for (uint32_t t = 0; t < m.triangleCount(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto a = at(m.indices[3 * t + uint32_t(k)]), b = at(m.indices[3 * t + uint32_t((k + 1) % 3)]);
      ++seen[{a, b}];
      --seen[{b, a}];
    }
  size_t out = 0;
  for (const auto& [e, n] : seen) {
    const auto& [a, b] = e;
    const bool isAtBorder =
        (a[0] == b[0] && std::abs(a[0]) == float(kSide)) || (a[1] == b[1] && std::abs(a[1]) == float(kSide));
    out += n > 0 && !isAtBorder;
  }
  return out;
}

TEST(Grade, CutsAGroundFromTheEyeToTheHorizon) {
  const float s = float(kSide);
  const scene::Primitive one = polygons({4}, {0, 1, 2, 3}, {-s, -s, 0, s, -s, 0, s, s, 0, -s, s, 0});
  // three faces with vertices of their own, and a triangle among them
  const scene::Primitive three =
      polygons({4, 3, 3}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9},
               {-s, -s, 0, 0, -s, 0, 0, s, 0, -s, s, 0, 0, -s, 0, s, -s, 0, s, s, 0, 0, -s, 0, s, s, 0, 0, s, 0});
  for (const scene::Primitive& p : {one, three}) {
    const Mesh base = made(p);
    const DiceRate rate = seenFrom(1);
    const std::optional<Mesh> m = graded(base, rate);
    ASSERT_TRUE(m.has_value());
    EXPECT_EQ(gaps(*m), 0u);
    EXPECT_NEAR(area(*m) / area(base), 1, 1e-6);
    // rings about the eye, each half as large: twelve or so of them
    EXPECT_GT(m->triangleCount(), 100u);
    EXPECT_LT(m->triangleCount(), 4000u);
    const Primvar* st = m->find("st");
    ASSERT_TRUE(st && st->rate == Primvar::Rate::PerVertex);
    for (uint32_t v = 0; v < m->vertexCount; ++v)
      for (int k = 0; k < 2; ++k) ASSERT_NEAR(st->data[2 * v + uint32_t(k)], vertex(*m, v)[k] / kSide, 1e-6);
    for (uint32_t t = 0; t < m->triangleCount(); ++t) {
      const auto c = corners(*m, t);
      const double a = rate.at(c[0]), b = rate.at(c[1]), d = rate.at(c[2]);
      ASSERT_LT(std::max({a, b, d}), 20 * std::min({a, b, d}));
    }
    // and what refined() makes of it is as fine at the eye as it asks, and closed
    const Mesh fine = refined(*m, rate);
    EXPECT_EQ(gaps(fine), 0u);
    EXPECT_LT(fine.triangleCount(), rate.maxTriangles);
    double least = INFINITY;
    for (uint32_t t = 0; t < fine.triangleCount(); ++t) {
      const auto c = corners(fine, t);
      if ((c[0] - V3d(10, 20, 0)).length() < 1) least = std::min(least, (c[1] - c[0]).length());
    }
    EXPECT_LT(least, 0.12);
  }
}

TEST(Grade, LeavesAloneWhatAGridFollows) {
  const float s = float(kSide);
  const scene::Primitive p = polygons({4}, {0, 1, 2, 3}, {-s, -s, 0, s, -s, 0, s, s, 0, -s, s, 0});
  const Mesh base = made(p);
  EXPECT_FALSE(graded(base, seenFrom(kSide / 5)).has_value());
  EXPECT_FALSE(graded(base, edge(1)).has_value());
  EXPECT_FALSE(graded(base, DiceRate()).has_value());
  DiceRate unknown = seenFrom(1);
  unknown.slope = 0;
  EXPECT_FALSE(graded(base, unknown).has_value());
  // an eye on the surface: there is an end
  const std::optional<Mesh> m = graded(base, seenFrom(0));
  ASSERT_TRUE(m.has_value());
  EXPECT_LT(m->triangleCount(), 20000u);
  EXPECT_EQ(gaps(*m), 0u);
}

}  // namespace
}  // namespace kinora::geometry
