// Patches of surfaces that deform: what is cut is cut alike at each key, edges have the steps of the key that asks for
// most, and what is one point, or smooth, is so at all keys.
#include "geometry/patches.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kinora::geometry {
namespace {

using Imath::V3d;
using Imath::V3f;

// Two triangles side by side, by key; normals as they are given, one for each triangle and key.
Mesh twoTriangles(const std::vector<V3f>& points, const std::vector<V3f>& normals) {
  Mesh m;
  m.vertexCount = 6;
  m.indices = {0, 1, 2, 3, 4, 5};
  m.faceOfTriangle = {0, 1};
  const size_t keys = points.size() / 4;
  Primvar n;
  n.name = "N";
  n.type = scene::ValueType::Normal;
  n.width = 3;
  n.rate = Primvar::Rate::PerVertex;
  for (size_t k = 0; k < keys; ++k) {
    if (keys > 1) m.times.push_back(double(k) / double(keys - 1));
    for (const size_t v : {0, 1, 2, 1, 3, 2}) m.points.push_back(points[4 * k + v]);
    for (size_t t = 0; t < 2; ++t)
      for (int v = 0; v < 3; ++v) {
        const V3f& x = normals[2 * k + t];
        n.data.insert(n.data.end(), {x.x, x.y, x.z});
      }
  }
  m.primvars.push_back(n);
  return m;
}

DiceRate every(double length) {
  DiceRate r;
  r.edgeLength = [length](const V3d&) { return length; };
  return r;
}

const std::vector<V3f> kFlat = {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}, {8, 8, 0}};

TEST(Patches, OfSeveralKeysAreCutAlikeAtEach) {
  std::vector<V3f> points = kFlat;
  for (V3f p : kFlat) points.emplace_back(2 * p.x + 1, p.y, p.x + p.y);
  const V3f up(0, 0, 1), aside = V3f(-1, 0, 2).normalized();
  const Patches patches(twoTriangles(points, {up, up, aside, aside}), every(1));
  const Mesh& m = *patches.mesh();
  ASSERT_EQ(patches.count(), 6u);
  ASSERT_EQ(patches.keyCount(), 2u);
  ASSERT_EQ(m.points.size(), 2 * size_t(m.vertexCount));
  for (uint32_t v = 0; v < m.vertexCount; ++v) {
    const V3f &p = m.points[v], &q = m.points[m.vertexCount + v];
    EXPECT_NEAR(q.x, 2 * p.x + 1, 1e-5) << v;
    EXPECT_NEAR(q.y, p.y, 1e-5) << v;
    EXPECT_NEAR(q.z, p.x + p.y, 1e-5) << v;
  }
  const Primvar& n = *m.find("N");
  ASSERT_TRUE(m.movesWithKeys(n));
  for (size_t v = 0; v < m.vertexCount; ++v) {
    EXPECT_EQ(n.data[3 * v + 2], 1.f) << v;
    EXPECT_NEAR(n.data[3 * (m.vertexCount + v)], aside.x, 1e-6) << v;
    EXPECT_NEAR(n.data[3 * (m.vertexCount + v) + 2], aside.z, 1e-6) << v;
  }
}

TEST(Patches, EdgesHaveTheStepsOfTheKeyThatAsksForMost) {
  std::vector<V3f> points = kFlat;
  for (const V3f& p : kFlat) points.emplace_back(4 * p.x, p.y, 0.f);
  const V3f up(0, 0, 1);
  const Patches still(twoTriangles(kFlat, {up, up}), every(1)),
      grows(twoTriangles(points, {up, up, up, up}), every(1));
  ASSERT_EQ(still.count(), grows.count());
  int longer = 0;
  for (uint32_t p = 0; p < still.count(); ++p)
    for (const size_t k : {0, 1, 2, 3}) {
      const Patches::Edge &a = still.edge(still.edgesOf(p)[k]), &b = grows.edge(grows.edgesOf(p)[k]);
      const V3f& from = still.mesh()->points[still.vertexOf(p, int(k))];
      const V3f& to = still.mesh()->points[still.vertexOf(p, int(k + 1) % 4)];
      if (from.x == to.x) {
        EXPECT_EQ(a.exponent, b.exponent);
        EXPECT_EQ(a.size, b.size);
      } else {
        longer += b.exponent > a.exponent;
      }
      // no step is longer than asked, at any key
      EXPECT_LE(b.size, 1.0001f);
      EXPECT_GE(std::ldexp(b.size, b.exponent), std::ldexp(a.size, a.exponent) * 0.9999f);
    }
  EXPECT_GT(longer, 0);
}

// Flat when the shutter opens, with an edge when it closes; and torn apart.
TEST(Patches, AreSmoothAndJoinedWhereTheyAreSoAtAllKeys) {
  const V3f up(0, 0, 1), aside(0, 1, 0);
  std::vector<V3f> points = kFlat;
  points.insert(points.end(), kFlat.begin(), kFlat.end());
  const auto pieces = [](const Patches& patches) {
    int edges = 0, apart = 0;
    for (uint32_t p = 0; p < patches.count(); ++p)
      for (const uint32_t e : patches.edgesOf(p)) {
        uint32_t count;
        const Patches::Side* sides = patches.sides(e, &count);
        if (count < 2 || !patches.edge(e).isJoined) continue;
        ++edges;
        apart += sides[0].piece != sides[1].piece;
      }
    return std::pair{edges, apart};
  };
  EXPECT_EQ(pieces(Patches(twoTriangles(points, {up, up, up, up}), every(1))), (std::pair{4, 0}));
  EXPECT_EQ(pieces(Patches(twoTriangles(points, {up, up, up, aside}), every(1))), (std::pair{4, 4}));
  Mesh torn = twoTriangles(points, {up, up, up, up});
  for (size_t v = 9; v < 12; ++v) torn.points[v] += V3f(1, 1, 0);  // the second triangle, at the second key
  EXPECT_EQ(pieces(Patches(torn, every(1))), (std::pair{0, 0}));
}

}  // namespace
}  // namespace kinora::geometry
