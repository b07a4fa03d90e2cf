// Proves that frames show solids (SolidBegin ... SolidEnd) as what they enclose: areas and shadows in closed form, in
// the open and behind transforms, instances and motion; a lens, a hemisphere and a nested object as the same shapes
// told by explicit surfaces, with lit, one-sided and glass materials; the same bits at all widths, with threads and
// groups; messages and the pictures of what cannot be resolved. src/trace/solids_test.cpp has the geometry. Misses:
// media of several kinds in one solid.
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

constexpr double kPi = 3.14159265358979323846;

std::string solid(const std::string& operation, const std::string& operands) {
  return "SolidBegin \"" + operation + "\"\n" + operands + "SolidEnd\n";
}
std::string primitive(const std::string& surfaces) {
  return solid("primitive", "AttributeBegin\n" + surfaces + "AttributeEnd\n");
}
std::string ball(double radius, const std::string& before = "") {
  const std::string r = std::to_string(radius);
  return primitive(before + "Sphere " + r + " -" + r + " " + r + " 360\n");
}
std::string tube(double radius, double half, const std::string& before = "") {
  const std::string r = std::to_string(radius), h = std::to_string(half);
  return primitive(before + "Cylinder " + r + " -" + h + " " + h + " 360\nDisk " + h + " " + r + " 360\nDisk -" + h +
                   " " + r + " 360\n");
}
// Faces turned out; or one by one, as old files have them.
std::string box(double half, const std::string& before = "") {
  return primitive(before + "Scale " + std::to_string(half) + " " + std::to_string(half) + " " +
                   std::to_string(half) +
                   "\nPointsPolygons [4 4 4 4 4 4] [0 2 3 1  4 5 7 6  0 1 5 4  2 6 7 3  0 4 6 2  1 3 7 5] "
                   "\"P\" [-1 -1 -1  1 -1 -1  -1 1 -1  1 1 -1  -1 -1 1  1 -1 1  -1 1 1  1 1 1]\n");
}

const std::string kSky = "Light \"PxrDomeLight\" \"sky\"\n";  // there is no message of what has no light

struct Frame {
  std::string head = orthographic(64, 2, 16);
  render::Settings settings;
};
std::unique_ptr<SceneRender> rendered(const std::string& world, const Frame& frame = {}) {
  RenderRequest r;
  r.rib = frame.head + "Translate 0 0 6\nWorldBegin\n" + world + "WorldEnd\n";
  r.settings = frame.settings;
  auto s = std::make_unique<SceneRender>(r);
  EXPECT_TRUE(s->ok()) << world;
  return s;
}
// Of a frame 4 by 4 units large.
double areaOf(const std::string& world) {
  const auto s = rendered(kSky + "Bxdf \"PxrConstant\" \"c\"\n" + world);
  EXPECT_TRUE(s->messages().empty()) << s->messages()[0];
  return s->ok() ? 16 * overPixels(s->channel("a")).mean() : 0;
}

// A plate with a hole along z, seen from any side by its outline: only the hole shows the operation.
const std::string kPlate = solid("difference", box(1) + tube(0.6, 3));
const double kPlateArea = 4 - kPi * 0.36;

TEST(Solids, AreasInClosedForm) {
  // 64 x 64 pixels of 16 samples: a stratified outline is good to a thousandth of the frame
  constexpr double kGood = 0.016;
  EXPECT_NEAR(areaOf(kPlate), kPlateArea, kGood);
  EXPECT_NEAR(areaOf("Rotate 30 0 0 1\nScale .5 .7 2\n" + kPlate), kPlateArea * 0.35, kGood);
  EXPECT_NEAR(areaOf(solid("intersection", ball(1, "Translate -.5 0 0\n") + ball(1, "Translate .5 0 0\n"))),
              2 * std::acos(0.5) - 0.5 * std::sqrt(3.0), kGood);
  EXPECT_NEAR(areaOf(solid("union", ball(1, "Translate -.5 0 0\n") + ball(1, "Translate .5 0 0\n"))),
              2 * kPi - (2 * std::acos(0.5) - 0.5 * std::sqrt(3.0)), kGood);
  // three levels: (box and sphere) without (a bar and a bar)
  EXPECT_NEAR(areaOf(solid("difference", solid("intersection", box(1) + ball(3)) +
                                             solid("union", tube(0.3, 3, "Translate .5 0 0\n") +
                                                                tube(0.3, 3, "Translate -.5 0 0\n")))),
              4 - 2 * kPi * 0.09, kGood);
  // an object is placed with its hole, and as an operand of others
  const std::string object = "ObjectBegin \"plate\"\n" + kPlate + "ObjectEnd\n";
  EXPECT_NEAR(areaOf(object + "AttributeBegin\nTranslate -1 0 0\nScale .5 .5 .5\nObjectInstance \"plate\"\n"
                              "AttributeEnd\nTranslate .8 .3 0\nScale .7 .7 -.7\nObjectInstance \"plate\"\n"),
              kPlateArea * (0.25 + 0.49), kGood);
  EXPECT_NEAR(areaOf(object + solid("intersection", "ObjectInstance \"plate\"\n" + box(1, "Translate 1 0 0\n"))),
              kPlateArea / 2, kGood);
  // objects without solids of their own bound what they stand in
  EXPECT_NEAR(areaOf("ObjectBegin \"tube\"\nCylinder .6 -3 3 360\nDisk 3 .6 360\nDisk -3 .6 360\nObjectEnd\n" +
                     solid("difference", box(1) + "ObjectInstance \"tube\"\n")),
              kPlateArea, kGood);
  // loose surfaces are operands each
  EXPECT_NEAR(areaOf(solid("union", "Sphere 1 -1 1 360\nSphere .5 -.5 .5 360\n")), kPi, kGood);
}

// A hole that moves by its own width in x over the shutter: what it leaves is there for part of the time.
TEST(Solids, MotionOfOperands) {
  Frame frame;
  frame.head += "Shutter 0 1\n";
  const std::string moved = "MotionBegin [0 1]\nTranslate -.3 0 0\nTranslate .3 0 0\nMotionEnd\n";
  for (const std::string& world :
       {solid("difference", box(1) + tube(0.5, 3, moved)), moved + solid("difference", box(1) + tube(0.5, 3))}) {
    const auto s = rendered(kSky + "Bxdf \"PxrConstant\" \"c\"\n" + world, frame);
    EXPECT_NEAR(16 * overPixels(s->channel("a")).mean(), 4 - kPi * 0.25, 0.02);
  }
}

// Light from behind the camera on a wall behind the plate, which the camera does not see: what the wall lacks is the
// plate's shadow.
TEST(Solids, Shadows) {
  Frame frame;
  frame.head += "Integrator \"PxrDirectLighting\" \"d\"\n";
  const std::string wall =
      "AttributeBegin\nLight \"PxrDistantLight\" \"l\" \"float intensity\" [1] \"float angleExtent\" [0]\n"
      "AttributeEnd\nBxdf \"PxrDiffuse\" \"w\"\nPatch \"bilinear\" \"P\" [-9 9 4  9 9 4  -9 -9 4  9 -9 4]\n";
  const auto lit = [&](const std::string& world) {
    return overPixels(rendered(wall + "Attribute \"visibility\" \"int camera\" [0]\n" + world, frame)->channel("Ci"))
        .mean();
  };
  const double open = lit("");
  EXPECT_GT(open, 0.01);
  EXPECT_NEAR(lit(kPlate) / open, 1 - kPlateArea / 16, 2e-3);
  // half of the light goes on at each of the two surfaces that are there
  EXPECT_NEAR(lit("Bxdf \"PxrDiffuse\" \"p\" \"float presence\" [.5]\n" + kPlate) / open, 1 - 0.75 * kPlateArea / 16,
              4e-3);
}

// Two pictures of the same thing told in two ways: pixel by pixel with the same random numbers.
void expectAlike(const std::string& name, const std::string& one, const std::string& other, double most) {
  Frame frame;
  frame.head = orthographic(48, 1.5, 64) + unbiased(6);
  const std::string lights =
      "Light \"PxrDomeLight\" \"sky\" \"float intensity\" [.5]\nAttributeBegin\nRotate 40 1 1 0\n"
      "Light \"PxrDistantLight\" \"sun\" \"float intensity\" [2] \"float angleExtent\" [5]\nAttributeEnd\n"
      "AttributeBegin\nBxdf \"PxrDiffuse\" \"floor\" \"color diffuseColor\" [.6 .3 .1]\n"
      "Patch \"bilinear\" \"P\" [-5 -1.2 -5  5 -1.2 -5  -5 -1.2 5  5 -1.2 5]\nAttributeEnd\n";
  const auto picture = [&](const std::string& world, const std::string& which) {
    const auto s = rendered(lights + world, frame);
    EXPECT_TRUE(s->messages().empty()) << name << which << ": " << s->messages()[0];
    return s->channel("Ci");
  };
  const image::Image a = picture(one, "solid"), b = picture(other, "explicit");
  double sum = 0, whole = 0;
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x) {
      sum += std::fabs(double(*a.at(x, y)) - double(*b.at(x, y)));
      whole += double(*b.at(x, y));
    }
  EXPECT_GT(whole, 0);
  EXPECT_LT(sum / whole, most) << name << ", see " << SceneRender::keep(a, name + "_solid.exr") << " and "
                               << SceneRender::keep(b, name + "_explicit.exr");
}

const std::string kMatte = "Bxdf \"PxrDiffuse\" \"m\" \"color diffuseColor\" [.7 .7 .7]\n";
const std::string kGlass =
    "Bxdf \"PxrSurface\" \"g\" \"float diffuseGain\" [0] \"float refractionGain\" [1] \"float reflectionGain\" [1] "
    "\"float glassRoughness\" [0] \"color extinction\" [.2 .6 .1]\n";

// Surfaces that are diced apart differ by less than a pixel along their edges; elsewhere pictures are the same up to
// what paths of several bounces make of differences in the last bits.
TEST(Solids, AsExplicitSurfaces) {
  const std::string view = "Rotate -40 1 0 0\nRotate 20 0 1 0\n";
  // sphere caps of radius 1 whose circles meet at z = 0: |z| of a middle is .5, so the caps begin at .5 of them
  const std::string lens = solid("intersection", ball(1, "Translate 0 0 .5\n") + ball(1, "Translate 0 0 -.5\n"));
  const std::string caps =
      "AttributeBegin\nTranslate 0 0 .5\nSphere 1 -1 -.5 360\nAttributeEnd\n"
      "AttributeBegin\nTranslate 0 0 -.5\nSphere 1 .5 1 360\nAttributeEnd\n";
  expectAlike("lens", kMatte + view + lens, kMatte + view + caps, 0.01);
  expectAlike("glass lens", kGlass + view + lens, kGlass + view + caps, 0.02);
  // the half that a box leaves: its face shows the box's other side
  const std::string half = solid("difference", ball(1) + box(2, "Translate 0 0 -2\n"));
  const std::string bowl = "Sphere 1 0 1 360\nReverseOrientation\nDisk 0 1 360\n";
  for (const char* sides : {"Sides 2\n", "Sides 1\n"})
    expectAlike("half", std::string(kMatte) + sides + view + half, std::string(kMatte) + sides + view + bowl, 0.01);
  expectAlike("glass half", kGlass + view + half, kGlass + view + bowl, 0.02);
  // another material on the face, which differs by nothing that is seen: light that came in by the ball leaves there
  const std::string other =
      "Bxdf \"PxrSurface\" \"h\"" + kGlass.substr(std::string("Bxdf \"PxrSurface\" \"g\"").size());
  const std::string tinted = std::string(other).replace(other.find(".2 .6 .1"), 8, ".2 .6 .1001");
  expectAlike("glass half of two materials",
              kGlass + view + solid("difference", ball(1) + box(2, tinted + "Translate 0 0 -2\n")),
              kGlass + view + bowl, 0.02);
}

TEST(Solids, SameBits) {
  const std::string world =
      "Light \"PxrDomeLight\" \"sky\"\nRotate 30 1 1 0\n" + kGlass +
      solid("difference", ball(1) + solid("union", tube(.4, 2, kMatte) + tube(.4, 2, "Rotate 90 1 0 0\n"))) + kMatte +
      solid("union", box(.5, "Translate 1 0 0\n") + box(.5, "Translate 1 1 0\n"));
  Frame frame;
  frame.head = orthographic(24, 2, 16) + unbiased(4);
  const auto hash = [&](uint32_t width, int threads, uint32_t group) {
    frame.settings.width = width;
    frame.settings.threads = threads;
    frame.settings.groupSize = group;
    return hashOf(rendered(world, frame)->film());
  };
  const uint64_t first = hash(8, 1, 512);
  for (const uint32_t width : {1u, 4u, 16u}) EXPECT_EQ(hash(width, 2, 256), first) << width;
  EXPECT_EQ(hash(8, 2, 64), first);
}

// The first message (a code is shown once) has the place that it is about, and surfaces are drawn as they are.
TEST(Solids, WhatCannotBeResolved) {
  const double whole = 4;  // a box of half width 1
  const struct {
    const char* what;
    std::string world;
    const char *message, *place;
    double area;
  } table[] = {
      {"a disk", solid("difference", box(1) + primitive("Disk -2 .5 360\n")), "'Disk at", ":18:", whole},
      {"a tube without ends", solid("difference", box(1) + primitive("Cylinder .5 -2 2 360\n")), "'Cylinder at",
       ":18:", whole},
      {"curves",
       solid("difference", box(1) + primitive("Curves \"linear\" [2] \"nonperiodic\" \"P\" [0 0 -3 0 0 3] "
                                              "\"constantwidth\" [1]\n")),
       "'Curves at", ":18:", -1},
      {"nothing in an operand", solid("difference", box(1) + primitive("")), "a solid holds no surface",
       ":16:", whole},
      {"one operand", solid("difference", box(1)), "a difference has one operand", ":9:", whole},
      {"nothing to take away from", solid("difference", primitive("") + box(1)),
       "a difference has nothing to take away from", ":9:", whole},
      {"flat beyond numbers", solid("difference", box(1) + tube(0.5, 3, "Scale 1 1 1e-20\n")), "a billion times",
       ":9:", whole},
      {"far beyond numbers", solid("difference", box(1) + tube(0.5, 3, "Translate 0 0 1e10\n")), "a billion times",
       ":9:", whole},
      {"nothing at all", solid("union", "") + box(1), "a solid holds no surface", ":9:", whole},
  };
  for (const auto& row : table) {
    const auto s = rendered(kSky + row.world);
    const std::string wanted = row.message;
    int told = 0;
    for (const std::string& m : s->messages()) {
      const bool isIt = m.find("RENDER-SOLID") != std::string::npos && m.find(wanted) != std::string::npos;
      told += isIt;
      EXPECT_TRUE(!isIt || m.find(row.place) != std::string::npos) << row.what << ": " << m;
    }
    EXPECT_EQ(told, 1) << row.what << (s->messages().empty() ? "" : ": " + s->messages()[0]);
    const double area = 16 * overPixels(s->channel("a")).mean();
    EXPECT_NEAR(area, row.area > 0 ? row.area : area, 0.02) << row.what;
  }
}

// Thousands of operands, and blocks in blocks, up to what is resolved and beyond.
TEST(Solids, Many) {
  const auto grid = [](int n) {
    std::string holes;
    for (int i = 0; i < n; ++i)
      holes += ball(0.01, "Translate " + std::to_string(-1.9 + 3.8 * (i % 60) / 59) + " " +
                              std::to_string(-1.9 + 3.8 * (i / 60 % 60) / 59) + " -1\n");
    return solid("difference", box(1) + holes);
  };
  Frame frame;
  frame.head = orthographic(16, 2, 4);
  auto s = rendered(kSky + grid(3000), frame);
  EXPECT_TRUE(s->messages().empty()) << s->messages()[0];
  EXPECT_NEAR(16 * overPixels(s->channel("a")).mean(), 4, 0.1);
  s = rendered(kSky + grid(9000), frame);
  ASSERT_FALSE(s->messages().empty());
  EXPECT_NE(s->messages()[0].find("9002 parts"), std::string::npos) << s->messages()[0];
  std::string deep = box(1) + tube(0.6, 3);
  for (int i = 0; i < 3000; ++i) deep = solid(i % 2 ? "intersection" : "union", i ? deep : solid("difference", deep));
  s = rendered(kSky + deep, frame);
  EXPECT_TRUE(s->messages().empty()) << s->messages()[0];
  EXPECT_NEAR(16 * overPixels(s->channel("a")).mean(), kPlateArea, 0.2);
}

}  // namespace
}  // namespace kinora::tests
