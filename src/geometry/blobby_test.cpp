// Proves: surfaces of known shape have their volume, normals and no seam; operations combine fields; leaf values
// blend by the fields; pruning changes no bit; wrong instructions are a message each.
#include <random>

#include "geometry/implicit.h"
#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {
using namespace testing;
using Floats = std::vector<float>;

scene::Primitive blobby(int leaves, std::vector<int> code, Floats floats) {
  scene::OtherPrimitive o{"Blobby", {}};
  const auto ints = [](const char* name, std::vector<int> v) {
    scene::Parameter p;
    p.name = name;
    p.type = scene::ValueType::Int;
    p.ints = std::move(v);
    return p;
  };
  o.args.set(ints("nleaf", {leaves}));
  o.args.set(ints("code", std::move(code)));
  o.args.set(parameter("floats", scene::StorageClass::Uniform, scene::ValueType::Float, std::move(floats)));
  return primitive(std::move(o));
}
Floats ball(float x, float y, float z, float size = 1) {
  return {size, 0, 0, 0, 0, size, 0, 0, 0, 0, size, 0, x, y, z, 1};
}
Floats operator+(Floats a, const Floats& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
void expectClosed(const Mesh& m) {
  const EdgeCount e = edges(m);
  EXPECT_EQ(e.open, 0u);
  EXPECT_EQ(e.wrong, 0u);
  EXPECT_GT(e.total, 1000u);
}

TEST(Blobby, AnEllipsoidIsHalfItsUnitSphere) {
  const Mesh m = made(blobby(1, {1001, 0}, ball(3, -2, 1, 2)));
  expectClosed(m);
  // vertices lie on the sphere of radius 1, so chords lose volume alone: below 1 % at 64 cells
  EXPECT_NEAR(volume(m), 4 * kPi / 3, 0.01 * 4 * kPi / 3);
  const Primvar* n = m.find("N");
  ASSERT_NE(n, nullptr);
  for (uint32_t i = 0; i < m.vertexCount; ++i) {
    const V3d p = vertex(m, i) - V3d(3, -2, 1);
    EXPECT_NEAR(p.length(), 1, 1e-6);
    EXPECT_NEAR(p.dot(V3d(n->data[3 * i], n->data[3 * i + 1], n->data[3 * i + 2])), 1, 1e-6);
  }
}

TEST(Blobby, FinerCellsComeNearerToTheSphere) {
  Quiet d;
  const scene::Primitive p = blobby(1, {1001, 0}, ball(0, 0, 0, 2));
  double before = 1;
  for (double edge : {0.01, 0.005}) {
    const auto m = tessellate(p, {[=](const V3d&) { return edge; }}, d);
    ASSERT_TRUE(m);
    const double lost = 1 - volume(*m) / (4 * kPi / 3);
    EXPECT_GT(lost, 0);
    EXPECT_LT(lost, before);
    before = lost;
  }
  const auto few = tessellate(p, {[](const V3d&) { return 0.001; }, 2000}, d);
  ASSERT_TRUE(few);
  EXPECT_LE(few->triangleCount(), 2000u);
  EXPECT_GT(few->triangleCount(), 100u);
}

TEST(Blobby, SegmentsAreCapsules) {
  // along x from -1 to 1, surface at half the reach of 0.8
  const Mesh m = made(blobby(1, {1002, 0}, Floats{-1, 0, 0, 1, 0, 0, 0.8f} + ball(0, 5, 0)));
  expectClosed(m);
  const double r = 0.4, whole = 4 * kPi / 3 * r * r * r + kPi * r * r * 2;
  EXPECT_NEAR(volume(m), whole, 0.02 * whole);
  for (uint32_t i = 0; i < m.vertexCount; ++i) {
    V3d p = vertex(m, i) - V3d(0, 5, 0);
    p.x -= std::clamp(p.x, -1.0, 1.0);
    EXPECT_NEAR(p.length(), r, 1e-6);
  }
}

TEST(Blobby, OperationsCombineFields) {
  const Floats two = ball(-0.4f, 0, 0, 1.2f) + ball(0.4f, 0, 0, 1.2f);
  const auto volumeOf = [&](std::vector<int> op) {
    std::vector<int> code = {1001, 0, 1001, 16};
    code.insert(code.end(), op.begin(), op.end());
    const Mesh m = made(blobby(2, code, two));
    expectClosed(m);
    return volume(m);
  };
  // spheres of radius 0.6 whose centres are 0.8 apart: the lens they share
  const double r = 0.6, h = r - 0.4, ballVolume = 4 * kPi / 3 * r * r * r, lens = 2 * kPi * h * h * (3 * r - h) / 3;
  EXPECT_NEAR(volumeOf({2, 2, 0, 1}), 2 * ballVolume - lens, 0.02 * ballVolume);  // max: union
  EXPECT_NEAR(volumeOf({3, 2, 0, 1}), lens, 0.05 * lens);                         // min: intersection
  EXPECT_GT(volumeOf({0, 2, 0, 1}), 2 * ballVolume - lens + 0.02);                // add: swells between
  EXPECT_LT(volumeOf({4, 0, 1}), ballVolume - 0.5 * lens);                        // subtract
  EXPECT_NEAR(volumeOf({6, 0, 6, 2, 7, 3, 2, 2, 4, 1}), 2 * ballVolume - lens, 0.02 * ballVolume);  // max(--a, b)
}

TEST(Blobby, InsideTurnsNormals) {
  scene::Primitive p = blobby(1, {1001, 0}, ball(0, 0, 0));
  edit(p, [](scene::Attributes& a) { a.orientation = scene::Attributes::Orientation::Inside; });
  const Mesh m = made(p);
  EXPECT_TRUE(m.flipNormals);
  const Primvar* n = m.find("N");
  ASSERT_NE(n, nullptr);
  EXPECT_LT(vertex(m, 0).dot(V3d(n->data[0], n->data[1], n->data[2])), 0);
}

TEST(Blobby, LeafValuesBlendByTheFields) {
  scene::Primitive p = blobby(2, {1001, 0, 1001, 16, 0, 2, 0, 1}, ball(-0.4f, 0, 0) + ball(0.4f, 0, 0));
  p.primvars.set(parameter("Cs", scene::StorageClass::Vertex, scene::ValueType::Color, {1, 0, 0, 0, 0, 1}));
  p.primvars.set(parameter("k", scene::StorageClass::Uniform, scene::ValueType::Float, {7}));
  const Mesh m = made(p);
  const Primvar *cs = m.find("Cs"), *k = m.find("k");
  ASSERT_TRUE(cs && k);
  EXPECT_EQ(k->rate, Primvar::Rate::Constant);
  ASSERT_EQ(cs->data.size(), size_t(m.vertexCount) * 3);
  for (uint32_t i = 0; i < m.vertexCount; ++i) {
    const V3d at = vertex(m, i);
    const auto f = [&](double x) { return std::pow(std::max(1 - (at - V3d(x, 0, 0)).length2(), 0.0), 3); };
    const double a = f(-0.4000000059604645), b = f(0.4000000059604645);
    EXPECT_NEAR(cs->data[3 * i], a / (a + b), 1e-5);
    EXPECT_NEAR(cs->data[3 * i] + cs->data[3 * i + 2], 1, 1e-5);
  }
}

TEST(Blobby, PruningChangesNoBitAndBoundsHold) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(-1, 1);
  std::vector<int> code, all;
  Floats floats;
  for (int i = 0; i < 40; ++i) {
    code.insert(code.end(), {1001, int(floats.size())});
    floats = floats + ball(u(random), u(random), u(random), 0.6f + 0.3f * u(random));
    all.push_back(i);
  }
  for (const int op : {0, 2}) {  // 40: sum of 20, 41: max of 20; 42: their sum
    code.insert(code.end(), {op, 20});
    for (int i = 0; i < 20; ++i) code.push_back(op * 10 + i);
  }
  code.insert(code.end(), {0, 2, 40, 41});
  const scene::Primitive p = blobby(40, code, floats);
  ImplicitField field;
  uint32_t leaves = 0;
  std::string said;
  ASSERT_EQ(readBlobby(std::get<scene::OtherPrimitive>(p.shape).args, field, leaves, said), "");
  ImplicitField::Scratch s;
  size_t pruned = 0;
  for (int i = 0; i < 300; ++i) {
    const V3d centre(u(random), u(random), u(random)), half(0.05 + 0.04 * u(random));
    ImplicitField small;
    const FieldBounds b = field.boundsOver(centre, half, small, s);
    pruned += !small.nodes.empty() && small.nodes.size() < field.nodes.size();
    for (int j = 0; j < 8; ++j) {
      const V3d at = centre + half * V3d(u(random), u(random), u(random));
      const double v = field.valueAt(at, s);
      EXPECT_GE(v, b.low);
      EXPECT_LE(v, b.high);
      if (!small.nodes.empty()) {
        EXPECT_EQ(v, small.valueAt(at, s));
      }
    }
  }
  EXPECT_GT(pruned, 20u);
}

TEST(Blobby, WrongInstructionsAreOneMessage) {
  const Floats one = ball(0, 0, 0);
  Floats flat = one, infinite = one;
  flat[0] = 0;
  infinite[12] = INFINITY;
  const struct {
    int leaves;
    std::vector<int> code;
    Floats floats;
  } table[] = {{0, {}, {}},
               {2, {1001, 0}, one},  // leaf count
               {1, {1001, 1}, one},  // beyond the floats
               {1, {1001, -1}, one},
               {1, {1001}, one},
               {1, {1001, 0}, infinite},
               {1, {1002, 0}, one},
               {1, {1001, 0, 9, 0}, one},  // unknown
               {1, {1005, 2, 0}, one},     // unknown, and cut short
               {1, {1005, -1}, one},
               {1, {1001, 0, 0, 2, 0, 1}, one},  // its own result
               {1, {1001, 0, 0, 2147483647, 0}, one},
               {1, {1001, 0, 0, -1}, one},
               {1, {1001, 0, 4, 0}, one}};
  for (const auto& row : table) {
    Quiet d;
    EXPECT_FALSE(tessellate(blobby(row.leaves, row.code, row.floats), {}, d).has_value());
    EXPECT_EQ(d.count("GEOM-BLOBBY"), 1u) << "row " << (&row - table);
    EXPECT_EQ(d.errors() + d.warnings(), 1u);
  }
  // leaves that count as nothing: told, the rest is there
  Quiet d;
  EXPECT_TRUE(tessellate(blobby(3, {1001, 0, 1001, 16, 1003, 0, 0, 0, 3, 0, 1, 2}, one + flat), {}, d).has_value());
  EXPECT_EQ(d.count("GEOM-BLOBBY"), 1u);
  // fields of other renderers say how many operands they have
  Quiet foreign;
  EXPECT_TRUE(tessellate(blobby(2, {1001, 0, 9000, 4, 0, 16, 1, 0, 0, 2, 0, 1}, one), {}, foreign).has_value());
  EXPECT_EQ(foreign.count("GEOM-BLOBBY"), 1u);
  Quiet nothing;
  EXPECT_FALSE(tessellate(blobby(1, {1000, 0, 1001, 1, 1, 2, 0, 1}, Floats{0.1f} + one), {}, nothing).has_value());
}

}  // namespace
}  // namespace kinora::geometry
