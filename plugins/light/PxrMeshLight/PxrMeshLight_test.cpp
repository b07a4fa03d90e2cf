// Proves: one square of two triangles is the rectangle's closed form; a closed convex body and a bowl that hides
// itself against looking; densities, power, the dark back, many triangles, widths, what is no geometry, and what deforms
// against what stands still as it is at that time. Misses: how the renderer makes the mesh (tests/truth).
#include <kinora/light_mesh.h>

#include "plugins/light/light_testing.h"

namespace kinora {
namespace {
using namespace lightTesting;
constexpr const char* kName = "PxrMeshLight";
constexpr double kPi = 3.14159265358979;

struct Body {
  std::vector<float> points;
  std::vector<uint32_t> triangles;
  LightMesh mesh() const {
    return {uint32_t(points.size() / 3), uint32_t(triangles.size() / 3), points.data(), triangles.data()};
  }
};
Body square() { return {{-0.5f, -0.5f, 0, 0.5f, -0.5f, 0, 0.5f, 0.5f, 0, -0.5f, 0.5f, 0}, {0, 1, 2, 0, 2, 3}}; }
// Part of a sphere from its pole down to cosine `low`, seen from outside (or, as a bowl, from inside).
Body cap(double low, bool inside, int rings = 24, int sides = 48) {
  Body b;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < sides; ++j) {
      const double z = 1 - (1 - low) * i / rings, s = std::sqrt(std::fmax(0, 1 - z * z)), a = 2 * kPi * j / sides;
      for (double c : {s * std::cos(a), s * std::sin(a), z}) b.points.push_back(float(c));
    }
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < sides; ++j) {
      const uint32_t p = uint32_t(i * sides + j), q = uint32_t(i * sides + (j + 1) % sides), down = uint32_t(sides);
      const uint32_t out[6] = {p, p + down, q + down, p, q + down, q};
      for (int t = 0; t < 6; t += 3)
        for (int c = 0; c < 3; ++c) b.triangles.push_back(out[t + (inside ? 2 - c : c)]);
    }
  return b;
}

TEST(PxrMeshLight, ASquareIsTheRectanglesClosedForm) {
  const Body body = square();
  const LightMesh mesh = body.mesh();
  TestLight light(kName, {set("intensity", 2), set("textureColor", 0.5f, 0.5f, 0.5f)}, identity(), nullptr, &mesh);
  EXPECT_TRUE(light.warnings.empty());
  for (double h : {0.05, 0.5, 3.0}) {
    const double a = 0.5, q = std::sqrt(a * a + h * h), e = 4 * a / q * std::atan(a / q);
    EXPECT_NEAR(light.closedForm({0, 0, h}, {0, 0, -1}), e, 1e-5 * e);
    EXPECT_NEAR(irradianceBySampling(light, {0, 0, h}, {0, 0, -1}), e, 2e-3 * e) << h;
  }
  EXPECT_EQ(irradianceBySampling(light, {0, 0, -1}, {0, 0, 1}, 32), 0) << "its back is dark";
}

TEST(PxrMeshLight, BodiesThatHideThemselvesAgreeWithLooking) {
  const Body ball = cap(-1, false), bowl = cap(-0.6, true), dome = cap(0.2, false);
  for (const Body* body : {&ball, &bowl, &dome}) {
    const LightMesh mesh = body->mesh();
    TestLight light(kName, {}, identity(), nullptr, &mesh);
    ASSERT_TRUE(light.made()) << light.error;
    for (const Vec& p : {Vec{2, 0.3, 0.5}, Vec{0.5, 0.2, -1.5}, Vec{0.2, -0.1, -0.2}}) {
      const Vec n = unit(Vec{0, 0, 0.3} - p);
      const Looked looked = lookAround(light, p, n, n, kPi, 700);
      EXPECT_NEAR(irradianceBySampling(light, p, n), looked.irradiance, 0.01 * looked.irradiance + 1e-4);
      EXPECT_LE(looked.pdf, 1.01);
    }
  }
  // a fine ball is a sphere: pi L (r / d)^2, less what its flat sides lose
  const LightMesh mesh = ball.mesh();
  TestLight light(kName, {}, identity(), nullptr, &mesh);
  EXPECT_NEAR(irradianceBySampling(light, {3, 0, 0}, {-1, 0, 0}), kPi / 9, 0.015 * kPi / 9);
}

TEST(PxrMeshLight, DensitiesAgreeAndPowerIsTheArea) {
  const Body dome = cap(0.2, false);
  const LightMesh mesh = dome.mesh();
  TestLight light(kName, {set("emissionFocus", 1)}, identity(), nullptr, &mesh);
  std::vector<Vec> points = pointsAround(light, 200, 1.05, 100);
  const Rays r = sampledAndEvaluated(light, points, 64);
  // on the edges of triangles either neighbour may be hit, which differ in density and cosine a little
  uint32_t wrong = 0, sampled = 0;
  for (uint32_t i = 0; i < r.n; ++i) {
    if (!(r.a[12][i] > 0)) continue;
    ++sampled;
    wrong += std::fabs(r.a[16][i] - r.a[12][i]) > 1e-3 * r.a[12][i];
  }
  EXPECT_GT(sampled, r.n / 20);
  EXPECT_LT(wrong, sampled / 200);
  TestLight plain(kName, {}, identity(), nullptr, &mesh);
  EXPECT_NEAR(emittedPower(plain), plain.description.power, 5e-3 * plain.description.power);
  TestLight normalized(kName, {set("areaNormalize", 1)}, identity(), nullptr, &mesh);
  EXPECT_NEAR(emittedPower(normalized), kPi, 5e-3 * kPi);
}

TEST(PxrMeshLight, ManyTrianglesKeepTheirShares) {
  const Body fine = cap(-1, false, 500, 400), coarse = cap(-1, false, 40, 80);
  const LightMesh a = fine.mesh(), b = coarse.mesh();
  TestLight many(kName, {}, identity(), nullptr, &a), few(kName, {}, identity(), nullptr, &b);
  const double e = irradianceBySampling(few, {2, 1, 0}, {-1, 0, 0}, 256);
  EXPECT_NEAR(irradianceBySampling(many, {2, 1, 0}, {-1, 0, 0}, 256), e, 0.015 * e);
}

TEST(PxrMeshLight, WidthsGiveTheSameBits) {
  const Body bowl = cap(-0.6, true);
  const LightMesh mesh = bowl.mesh();
  TestLight light(kName, {set("emissionFocus", 2)}, identity(), nullptr, &mesh);
  expectWidthsAgree(light, pointsAround(light, 301));
  expectNoNaN(light);
}

// At three keys, not on one line.
struct Bending {
  static constexpr uint32_t kKeys = 3;
  Body body = cap(0.2, false, 6, 12);
  uint32_t vertices = uint32_t(body.points.size() / 3);
  Bending() {
    const Body start = body;
    constexpr double kWide[kKeys] = {1, 1.6, 0.8}, kBent[kKeys] = {0, 0.4, -0.2}, kUp[kKeys] = {0, 0.5, 0.1};
    body.points.clear();
    for (uint32_t key = 0; key < kKeys; ++key)
      for (uint32_t i = 0; i < vertices; ++i) {
        const double x = start.points[3 * i], y = start.points[3 * i + 1], z = start.points[3 * i + 2];
        for (double c : {x * kWide[key], y + kBent[key] * x * x, z + kUp[key] * (1 + x)})
          body.points.push_back(float(c));
      }
  }
  LightMesh mesh() const {
    return {vertices, uint32_t(body.triangles.size() / 3), body.points.data(), body.triangles.data(), kKeys};
  }
  Body at(double time) const {
    const uint32_t key = time < 0.5 ? 0 : 1;
    const double part = time * 2 - key;
    Body b;
    b.triangles = body.triangles;
    for (uint32_t i = 0; i < 3 * vertices; ++i) {
      const double from = body.points[key * 3 * vertices + i], to = body.points[(key + 1) * 3 * vertices + i];
      b.points.push_back(float(from + part * (to - from)));
    }
    return b;
  }
};

// areaNormalize goes by the area of each time.
TEST(PxrMeshLight, WhatDeformsKeepsItsPower) {
  const Bending bending;
  const LightMesh mesh = bending.mesh();
  const std::vector<Setting> settings = {{"areaNormalize", {1}, ""}};
  TestLight moving(kName, settings, identity(), nullptr, &mesh);
  ASSERT_TRUE(moving.made()) << moving.error;
  for (const double time : {0.0, 0.2, 0.5, 0.77, 1.0}) {
    const Body body = bending.at(time);
    const LightMesh then = body.mesh();
    TestLight still(kName, settings, identity(), nullptr, &then);
    moving.time = float(time);
    const double power = emittedPower(still, 128);
    EXPECT_NEAR(emittedPower(moving, 128), power, 0.015 * power) << time;
    const Vec p{0.2, -0.4, 3}, n = unit(Vec{0, 0, 0.5} - p);
    const double e = irradianceBySampling(still, p, n, 128);
    EXPECT_NEAR(irradianceBySampling(moving, p, n, 128), e, 0.015 * e) << time;
    EXPECT_NEAR(lookAround(moving, p, n, n, kPi / 2, 300).irradiance, e, 0.03 * e) << time;
  }
  expectWidthsAgree(moving, pointsAround(moving, 101));
}

TEST(PxrMeshLight, WhatDeformsIsAtEachTimeAsWhatStandsStill) {
  const Bending bending;
  const LightMesh mesh = bending.mesh();
  TestLight moving(kName, {}, identity(), nullptr, &mesh);
  ASSERT_TRUE(moving.made()) << moving.error;
  const LightDescription& d = moving.description;
  for (const double time : {0.0, 0.2, 0.5, 0.9}) {
    const Body body = bending.at(time);
    const LightMesh then = body.mesh();
    TestLight still(kName, {}, identity(), nullptr, &then);
    moving.time = float(time);
    for (const Vec& p : {Vec{2, 0.3, 1.5}, Vec{0.2, -0.4, 3}}) {
      const Vec n = unit(Vec{0, 0, 0.5} - p);
      const double e = irradianceBySampling(still, p, n, 128);
      EXPECT_GT(e, 0.01);
      EXPECT_NEAR(irradianceBySampling(moving, p, n, 128), e, 0.015 * e) << time;
      const Looked looked = lookAround(moving, p, n, n, kPi / 2, 300);
      EXPECT_NEAR(looked.irradiance, e, 0.03 * e) << time;
      EXPECT_LE(looked.pdf, 1.02);
    }
    const double power = emittedPower(still, 128);
    EXPECT_NEAR(emittedPower(moving, 128), power, 0.015 * power) << time;
    const Rays r = sampledAndEvaluated(moving, {{2, 0.3, 1.5}, {0.2, -0.4, 3}}, 500);
    uint32_t wrong = 0, sampled = 0;
    for (uint32_t i = 0; i < r.n; ++i) {
      if (!(r.a[12][i] > 0)) continue;
      ++sampled;
      wrong += std::fabs(r.a[16][i] - r.a[12][i]) > 1e-3 * r.a[12][i];
    }
    EXPECT_GT(sampled, r.n / 20);
    EXPECT_LE(wrong, sampled / 100);  // of edges
    // what is said of it holds
    for (uint32_t i = 0; i < bending.vertices; ++i)
      for (int c = 0; c < 3; ++c) {
        EXPECT_GE(body.points[3 * i + uint32_t(c)], d.low[c]);
        EXPECT_LE(body.points[3 * i + uint32_t(c)], d.high[c]);
      }
    if (d.axis[0] == 0 && d.axis[1] == 0 && d.axis[2] == 0) continue;
    for (size_t t = 0; t < body.triangles.size(); t += 3) {
      const auto corner = [&](size_t k) {
        const float* x = body.points.data() + 3 * size_t(body.triangles[t + k]);
        return Vec{x[0], x[1], x[2]};
      };
      const Vec across = cross(corner(1) - corner(0), corner(2) - corner(0));
      if (!(dot(across, across) > 0)) continue;  // shrunk to a line or point: it emits nothing
      const Vec normal = unit(across);
      EXPECT_GE(dot(normal, {d.axis[0], d.axis[1], d.axis[2]}), d.cosNormals - 1e-4) << time;
    }
  }
  moving.time = 0.3f;
  expectWidthsAgree(moving, pointsAround(moving, 101));
  expectNoNaN(moving);
}

// A sheet that is folded together at one end of the shutter, and one that shrinks to nothing.
TEST(PxrMeshLight, WhatHasNoAreaAtTimesIsDarkThen) {
  Body body = square();
  for (int i = 0; i < 12; ++i) body.points.push_back(i % 3 == 0 ? 0.f : body.points[size_t(i)]);
  const LightMesh mesh{4, 2, body.points.data(), body.triangles.data(), 2};
  TestLight light(kName, {}, identity(), nullptr, &mesh);
  EXPECT_TRUE(light.warnings.empty());
  for (const double time : {0.0, 0.5, 1.0}) {
    light.time = float(time);
    const double e = irradianceBySampling(light, {0, 0, 3}, {0, 0, -1}, 128);
    EXPECT_NEAR(e, (1 - time) / 9, 0.06 * (1 - time) + 1e-6) << time;  // about its area by the square of the distance
    expectNoNaN(light);
  }
}

TEST(PxrMeshLight, WhatIsNoGeometryIsBlackWithAMessage) {
  TestLight none(kName, {});
  ASSERT_TRUE(none.made());
  EXPECT_EQ(none.warnings.size(), 1u);
  EXPECT_EQ(none.description.power, 0);
  expectNoNaN(none);
  Body broken = square();
  broken.triangles = {0, 0, 1, 0, 1, 9, 1, 2, 3};
  broken.points[9] = std::nanf("");
  const LightMesh mesh = broken.mesh();
  TestLight bad(kName, {}, identity(), nullptr, &mesh);
  ASSERT_TRUE(bad.made());
  EXPECT_EQ(bad.description.power, 0);
  expectNoNaN(bad);
  TestLight refused(kName, {}, scaleMove(std::nan(""), 1, 1, {0, 0, 0}));
  EXPECT_FALSE(refused.made());
}
}  // namespace
}  // namespace kinora
