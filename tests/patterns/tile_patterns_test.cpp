// Proves manifolds of tiles, projections and flakes against values worked out by hand, numerical averages and
// statistics, and equal bits at every width. Misses: how pictures of them look.
#include <cmath>
#include <set>

#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {

TEST(TilePatterns, RowsOfTiles) {
  TestContext t("PxrTileManifold", 3);
  t.setBuiltin(Builtin::St, {{0.25f, 1.4f, -0.9f}, {0.5f, 1.75f, 0.25f}});
  t.setBuiltin(Builtin::StRadius, {{0.f}});
  t.set("groutWidth", 0.2f);
  t.set("textureOrder", 0);
  t.set("numTextures", 3);
  ASSERT_TRUE(t.run(8));
  // the upper row is shifted by half: 1.9 is 0.9 of column 1
  const double inS[3] = {(0.25 - 0.1) / 0.8, 1, 0}, inT[3] = {0.5, (0.75 - 0.1) / 0.8, (0.25 - 0.1) / 0.8};
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(t.at("resultS", i), inS[i], 1e-5) << i;
    EXPECT_NEAR(t.at("resultT", i), 1 - inT[i], 1e-5) << i;
  }
  EXPECT_EQ(t.at("resultMask", 0), 1);
  EXPECT_NEAR(t.at("resultMask", 1), 0.5, 0.02) << "on the edge";
  EXPECT_NEAR(t.at("resultMask", 2), 0.5, 0.02) << "on the edge";
  const int texture[3] = {0, 2, 2};  // column + row, modulo 3
  for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(int(t.at("resultMulti", i, 2)), texture[i]) << i;
  t.set("swapTileST", 1);
  t.set("invertT", 0);
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultS", 0), inT[0], 1e-5);
  EXPECT_NEAR(t.at("resultT", 0), inS[0], 1e-5);
  EXPECT_EQ(t.outManifold("resultMulti").dimensions, 2u);
}

// The mask against the mean of many narrow windows.
TEST(TilePatterns, MasksAreFiltered) {
  const auto profile = [](double x, double gap, double bevel) {
    x -= std::floor(x);
    const double e = std::fmin(x, 1 - x) - gap / 2;
    return e <= 0 ? 0 : std::fmin(e / bevel, 1.);
  };
  for (const double bevel : {0.15, 0.02}) {
    TestContext t("PxrTileManifold", 24);
    const std::vector<float> s = spread(24, -2, 2), r = spread(24, 0.01f, 1.7f, 5);
    t.setBuiltin(Builtin::St, {s, std::vector<float>(24, 0.5f)});
    t.setBuiltin(Builtin::StRadius, {r});
    t.set("gridOffset", 0);
    t.set("groutWidth", 0.3f);
    t.set("tileBevelWidth", float(bevel));
    ASSERT_TRUE(t.run(8));
    for (uint32_t i = 0; i < 24; ++i) {
      double along = 0, up = 0;
      constexpr int kSteps = 20000;
      for (int k = 0; k < kSteps; ++k) {
        const double x = r[i] * ((2 * k + 1.) / kSteps - 1);
        along += profile(s[i] + x, 0.3, bevel) / kSteps;
        up += profile(0.5 + x, 0.3, bevel) / kSteps;
      }
      EXPECT_NEAR(t.at("resultMask", i), along * up, 5e-4) << s[i] << " " << r[i];
    }
  }
}

TEST(TilePatterns, GradientsFollowTiles) {
  TestContext t("PxrTileManifold", 1);
  t.setBuiltin(Builtin::St, {{0.3f}, {0.4f}});
  t.setBuiltin(Builtin::StRadius, {{0.f}});
  t.set("groutWidth", 0.5f);
  t.set("scaleS", 3);
  t.set("swapTileST", 1);
  ASSERT_TRUE(t.run(8));
  const Manifold& m = t.outManifold("result");
  EXPECT_FLOAT_EQ(m.gradient[0].data[1][0], 2) << "s of the tile is t";
  EXPECT_FLOAT_EQ(m.gradient[1].data[0][0], -6) << "t of the tile is s, inverted";
}

TEST(TilePatterns, Hexagons) {
  TestContext t("PxrHexTileManifold", 5);
  // the middle of one, near its edge, past it, the middle of the next row, a corner
  const float h = std::sqrt(3.f);
  t.setBuiltin(Builtin::St, {{0.5f, 0.9f, 1.1f, 1.f, 0.5f}, {h / 2, h / 2, h / 2, h, h / 2 + 0.5f}});
  t.setBuiltin(Builtin::StRadius, {{0.f}});
  t.set("groutWidth", 0.4f);
  t.set("invertT", 0);
  ASSERT_TRUE(t.run(8));
  const double s[5] = {0.5, 0.5 + 0.4 / 0.6, 0.5 - 0.4 / 0.6, 0.5, 0.5}, u[5] = {0.5, 0.5, 0.5, 0.5, 0.5 + 0.5 / 0.6};
  const double mask[5] = {1, 0, 0, 1, 0};
  for (uint32_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(t.at("resultS", i), s[i], 1e-5) << i;
    EXPECT_NEAR(t.at("resultT", i), u[i], 1e-5) << i;
    EXPECT_NEAR(t.at("resultMask", i), mask[i], 1e-5) << i;
  }
  t.set("randomOrientation", 1);  // distances from the middle stay
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < 5; ++i)
    EXPECT_NEAR(std::hypot(t.at("resultS", i) - 0.5, t.at("resultT", i) - 0.5), std::hypot(s[i] - 0.5, u[i] - 0.5),
                1e-5);
}

TEST(TilePatterns, FootprintsFollowTheirTiles) {
  TestContext t("PxrTileManifold", 3);
  t.setBuiltin(Builtin::St, {{0.2f, 1.3f, 2.4f}, {0.1f, 1.2f, 0.3f}});
  t.setBuiltin(Builtin::StRadius, {{0.01f}});
  t.setEllipses("", {{0.1f, 0.f, 0.1f}, {0.2f, 0.f, 0.f}}, {{-0.3f, 0.f, 0.f}, {0.4f, 0.f, 0.3f}});
  t.set("gridOffset", 0);
  t.set("groutWidth", 0.5f);
  t.set("scaleS", 3);
  for (const int swap : {0, 1})
    for (const int flip : {0, 1}) {
      t.set("swapTileST", float(swap));
      t.set("invertT", float(flip));
      ASSERT_TRUE(t.run(8));
      const Manifold& m = t.outManifold("result");
      ASSERT_EQ(m.axis[0].components, 2u);
      const float grow = 2, scaled[2][2] = {{0.3f, 0.2f}, {-0.9f, 0.4f}};
      for (uint32_t k = 0; k < 2; ++k) {
        EXPECT_NEAR(m.axis[k].data[0][0], grow * scaled[k][swap], 1e-6f);
        EXPECT_NEAR(m.axis[k].data[1][0], (flip ? -1 : 1) * grow * scaled[k][1 - swap], 1e-6f);
        EXPECT_EQ(m.axis[k].data[0][1], 0.f) << "a circle";
        EXPECT_EQ(t.outManifold("resultMulti").axis[k].data[0], m.axis[k].data[0]);
      }
    }
}

TEST(TilePatterns, TexturesAreChosenEvenly) {
  constexpr uint32_t kCells = 4000;
  TestContext t("PxrTileManifold", kCells);
  std::vector<float> s(kCells), u(kCells);
  for (uint32_t i = 0; i < kCells; ++i) s[i] = float(i % 80) + 0.5f, u[i] = float(i / 80) + 0.5f;
  t.setBuiltin(Builtin::St, {s, u});
  t.setBuiltin(Builtin::StRadius, {{0.f}});
  t.set("gridOffset", 0);
  t.set("numTextures", 4);
  ASSERT_TRUE(t.run(8));
  int count[4] = {0, 0, 0, 0};
  std::set<float> numbers;
  for (uint32_t i = 0; i < kCells; ++i) {
    const float x = t.at("resultMulti", i, 2);
    ASSERT_GE(x, 0);
    ASSERT_LT(x, 4);
    EXPECT_LT(x - std::floor(x), 0.5f) << "the tile's own number";
    ++count[int(x)];
    numbers.insert(x - std::floor(x));
  }
  for (const int n : count) EXPECT_NEAR(n / double(kCells), 0.25, 4 * std::sqrt(0.25 * 0.75 / kCells));
  EXPECT_GT(numbers.size(), kCells * 9 / 10);
}

TEST(TilePatterns, ObjectsPlaceTheirTexturesAtRandom) {
  constexpr uint32_t kObjects = 3000;
  TestContext t("PxrRandomTextureManifold", kObjects);
  std::vector<float> id(kObjects);
  for (uint32_t i = 0; i < kObjects; ++i) id[i] = float(i);
  t.setBuiltin(Builtin::ObjectId, {id});
  t.setBuiltin(Builtin::St, {std::vector<float>(kObjects, 0.2f), std::vector<float>(kObjects, 0.4f)});
  t.setBuiltin(Builtin::StRadius, {{0.25f}});
  t.set("invertT", 0);
  t.set("globalScale", 2);
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultS", 7), 0.4f);
  EXPECT_FLOAT_EQ(t.at("resultT", 7), 0.8f);
  EXPECT_FLOAT_EQ(t.outManifold("resultMulti").radius.data[0][0], 0.5f);
  t.set("randomOrientation", 1);
  ASSERT_TRUE(t.run(8));
  // quarter turns about the middle: 0.4 0.8, 0.2 0.4, 0.6 0.2, 0.8 0.6
  std::map<std::pair<int, int>, int> seen;
  for (uint32_t i = 0; i < kObjects; ++i)
    ++seen[{int(std::lround(10 * t.at("resultS", i))), int(std::lround(10 * t.at("resultT", i)))}];
  ASSERT_EQ(seen.size(), 4u);
  for (const std::pair<int, int>& place : {std::pair(4, 8), std::pair(2, 4), std::pair(6, 2), std::pair(8, 6)})
    EXPECT_NEAR(seen[place] / double(kObjects), 0.25, 4 * std::sqrt(0.25 * 0.75 / kObjects));
  t.set("randomOrientation", 0);
  t.set("randomOffsetS", 1);
  ASSERT_TRUE(t.run(8));
  double sum = 0;
  for (uint32_t i = 0; i < kObjects; ++i) sum += t.at("resultS", i) - 0.4;
  EXPECT_NEAR(sum / kObjects, 0.5, 4 / std::sqrt(12. * kObjects));
}

TEST(TilePatterns, MultiTextureLooksUpTheChosenFile) {
  TestContext t("PxrMultiTexture", 5);
  t.setManifold("manifoldMulti", {{0.1f, 0.2f, 0.3f, 0.4f, 0.5f}, {0.5f}, {0, 1.4f, 2, 3.2f, 0}}, {{0.125f}});
  t.set("blur", 0.25f);
  for (const int k : {0, 1, 2}) {
    const int32_t handle = 30 + k;
    float bits;
    std::memcpy(&bits, &handle, sizeof bits);
    t.set("filename" + std::to_string(k), Numbers{{bits}});
  }
  t.onTexture = [](int handle, float s, float, float radius, const TextureOptions&, float rgba[4]) {
    rgba[0] = float(handle);
    rgba[1] = s;
    rgba[2] = radius;
    rgba[3] = 0.75f;
  };
  ASSERT_TRUE(t.run(8));
  const float file[] = {30, 31, 32, 30, 30};  // the fourth one goes round
  for (uint32_t i = 0; i < 5; ++i) EXPECT_EQ(t.at("resultR", i), file[i]) << i;
  EXPECT_FLOAT_EQ(t.at("resultG", 2), 0.3f);
  EXPECT_FLOAT_EQ(t.at("resultB", 2), 0.375f);
  EXPECT_FLOAT_EQ(t.at("resultA", 2), 0.75f);
  t.set("randomLuminance", 0.5f);
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.at("resultR", 0), t.at("resultR", 4)) << "one tile, one variation";
  EXPECT_NE(t.at("resultR", 0), 30);
  EXPECT_NE(t.at("resultR", 1) / 31, t.at("resultR", 0) / 30);
}

TEST(TilePatterns, ProjectionsInClosedForm) {
  TestContext t("PxrProjector", 4);
  t.matrices["render>object"] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1};
  t.matrices["object>render"] = {.5, 0, 0, 0, 0, .5, 0, 0, 0, 0, .5, 0, 0, 0, 0, 1};
  const std::vector<float> x{0.1f, -0.2f, 0.3f, 0.6f}, y{0.2f, 0.1f, -0.4f, 0}, z{-1, -2, -1, -1};
  t.setVectors(t.c.P, {x, y, z});
  t.setVectors(t.c.N, {{0, 0, 0, 0}, {0, 0, 0, 0}, {1, 1, -1, 1}});
  t.c.radius = std::vector<float>(16, 0.125f).data();
  const std::vector<float> radius(16, 0.125f);
  t.c.radius = radius.data();
  t.set("invertT", 0);
  ASSERT_TRUE(t.run(8));
  const float mask[4] = {1, 1, 0, 0};  // the third looks away, the fourth is outside
  for (uint32_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(t.at("resultS", i), 0.5 + x[i], 1e-6) << i;
    EXPECT_NEAR(t.at("resultT", i), 0.5 + y[i], 1e-6) << i;
    EXPECT_EQ(t.at("resultMask", i), mask[i]) << i;
  }
  EXPECT_FLOAT_EQ(t.outManifold("result").radius.data[0][0], 0.125f);
  t.set("projection", 1);
  t.set("filmFit", 1);
  t.set("resolutionX", 400);
  t.set("resolutionY", 300);
  t.set("focalLength", 35);
  ASSERT_TRUE(t.run(8));
  const double wide = 0.98 * 25.4 / 35, high = wide * 0.75;  // the picture at distance 1
  for (uint32_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(t.at("resultS", i), 0.5 + x[i] / -z[i] / wide, 1e-5) << i;
    EXPECT_NEAR(t.at("resultT", i), 0.5 + y[i] / -z[i] / high, 1e-5) << i;
  }
  t.set("projection", 2);
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(t.at("resultS", i), 0.5 + std::atan2(x[i], z[i]) / (2 * M_PI), 1e-5) << i;
    EXPECT_NEAR(t.at("resultT", i), 0.5 + std::atan2(y[i], std::hypot(x[i], z[i])) / M_PI, 1e-5) << i;
  }
  t.set("projection", 3);
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultT", 1), 0.5 + 0.5 * 2 * y[1], 1e-5);
  t.set("projection", 0);
  t.set("angle", 90);
  t.set("scaleS", 3);
  t.set("offsetT", 0.25f);
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultS", 0), 0.5 - 3 * y[0], 1e-5);
  EXPECT_NEAR(t.at("resultT", 0), 0.75 + x[0], 1e-5);
}

TEST(TilePatterns, FlakesLean) {
  constexpr uint32_t kPoints = 3000;
  TestContext t("PxrFlakes", kPoints);
  std::vector<uint32_t> outside(padded(kPoints), ~0u);
  const std::vector<float> ior(padded(kPoints), 1.f);
  t.c.entering = outside.data();
  t.c.outerIor = ior.data();
  std::vector<float> s(kPoints), u(kPoints);
  for (uint32_t i = 0; i < kPoints; ++i) s[i] = float(i) * 0.317f, u[i] = float(i) * 0.753f;
  t.setManifold("manifold", {s, u, std::vector<float>(kPoints, 0.1f)}, {{0.f}});
  t.set("flakeFreq", 10);
  t.set("flakeAmount", 0.4f);
  t.set("size", 5);
  ASSERT_TRUE(t.run(8));
  double sum[2] = {0, 0}, square = 0, most = 0;
  for (uint32_t i = 0; i < kPoints; ++i) {
    EXPECT_EQ(t.at("resultA", i), 1);
    const double x = t.at("resultN", i, 0), y = t.at("resultN", i, 1), z = t.at("resultN", i, 2);
    EXPECT_NEAR(x * x + y * y + z * z, 1, 1e-5);
    sum[0] += x / z, sum[1] += y / z, square += x * x / (z * z);
    most = std::fmax(most, std::hypot(x, y) / z);
  }
  // slopes: uniform in a ball of radius sqrt(3) 0.4, seen along z, a fifth of the squared radius along each axis
  const double radius = 0.4 * std::sqrt(3), deviation = radius / std::sqrt(5.);
  EXPECT_NEAR(sum[0] / kPoints, 0, 4 * deviation / std::sqrt(kPoints));
  EXPECT_NEAR(sum[1] / kPoints, 0, 4 * deviation / std::sqrt(kPoints));
  EXPECT_NEAR(square / kPoints, deviation * deviation, 0.1 * deviation * deviation);
  EXPECT_LE(most, radius + 1e-4);
  t.set("density", 0);
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.at("resultA", 9), 0);
  EXPECT_EQ(t.at("resultN", 9, 2), 1);
  t.set("density", 1);
  t.set("jitter", 0);
  t.set("size", 0.5f);  // spheres in unit cells, cut by a plane 0.5 above the grid's middles: 0.1 * 10 = 1
  t.setManifold("manifold", {s, u, std::vector<float>(kPoints, 0.05f)}, {{0.f}});
  ASSERT_TRUE(t.run(8));
  int on = 0;
  for (uint32_t i = 0; i < kPoints; ++i) {
    const double x = s[i] * 10 - std::floor(s[i] * 10) - 0.5, y = u[i] * 10 - std::floor(u[i] * 10) - 0.5;
    if (std::fabs(std::hypot(x, y) - 0.5) < 1e-3) continue;
    EXPECT_EQ(t.at("resultA", i), std::hypot(x, y) < 0.5) << i;
    on += t.at("resultA", i) > 0;
  }
  EXPECT_GT(on, 100);
}

TEST(TilePatterns, SameBitsAtAllWidths) {
  for (const char* name :
       {"PxrTileManifold", "PxrHexTileManifold", "PxrRandomTextureManifold", "PxrBumpManifold2D"}) {
    TestContext t(name, 45);
    t.setBuiltin(Builtin::St, {spread(45, -9, 9), spread(45, -9, 9, 11)});
    t.setBuiltin(Builtin::StRadius, {spread(45, 0, 0.7f, 13)});
    t.setBuiltin(Builtin::ObjectId, {spread(45, 0, 44, 17)});
    t.set("angle", 30);
    const std::string kind = name;
    if (kind != "PxrBumpManifold2D") {
      t.set("numTextures", 5);
      t.set("globalScale", 1.7f);
    }
    if (kind == "PxrTileManifold" || kind == "PxrHexTileManifold") {
      t.set("groutWidth", 0.1f);
      t.set("tileBevelWidth", 0.07f);
    }
    if (kind == "PxrHexTileManifold") t.set("randomOrientation", 1);
    if (kind == "PxrRandomTextureManifold")
      for (const char* on : {"randomOrientation", "randomFlipS", "randomFlipT", "randomOffsetS", "randomOffsetT"})
        t.set(on, 1);
    expectSameBitsAtAllWidths(t);
  }
  TestContext p("PxrProjector", 45);
  p.setVectors(p.c.P, {spread(45, -3, 3), spread(45, -2, 2, 11), spread(45, -4, 1, 13)});
  p.setVectors(p.c.N, {spread(45, -1, 1, 17), spread(45, -1, 1, 19), spread(45, -1, 1, 23)});
  for (int projection = 0; projection < 5; ++projection) {
    p.set("projection", float(projection));
    expectSameBitsAtAllWidths(p);
  }
  TestContext f("PxrFlakes", 45);
  std::vector<uint32_t> outside(64, ~0u);
  const std::vector<float> ior(64, 1.f);
  f.c.entering = outside.data();
  f.c.outerIor = ior.data();
  f.setManifold("manifold", {spread(45, -9, 9), spread(45, -9, 9, 11), spread(45, -9, 9, 13)}, {{0.f}});
  f.set("octaves", 3);
  f.set("size", 0.4f);
  f.set("validateNormals", 1);
  expectSameBitsAtAllWidths(f);
}

}  // namespace kinora::patternTest
