// Proves: a room lit through its window has one brightness whether the dome is sampled or its portal; which dome a
// portal shows, and what it takes from it; domes with portals shine through them alone; a portal without a dome is
// told and even; what is said of a dome (filters, mute, linking) holds for its portals; domes and portals that turn while
// the shutter is open show what those of each time do. Misses: maps through portals (PxrPortalLight_test.cpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "image/read_write.h"
#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

// A spot of floor at z = 1, seen from below its roof at z = 0: the roof is a ring about a window of 1 x 0.5, which the
// camera does not see.
std::string room(const std::string& lights, const std::string& portal) {
  return orthographic(16, 1e-4, 64) + unbiased(0) + "WorldBegin\n" + lights + "AttributeBegin Scale 1 0.5 1\n" +
         portal + "AttributeEnd\n" +
         R"(Bxdf "PxrDiffuse" "grey" "color diffuseColor" [0.5 0.5 0.5]
AttributeBegin Attribute "visibility" "int camera" [0]
Polygon "vertex point P" [-60 -60 -.001  60 -60 -.001  60 -.25 -.001  -60 -.25 -.001]
Polygon "vertex point P" [-60 .25 -.001  60 .25 -.001  60 60 -.001  -60 60 -.001]
Polygon "vertex point P" [-60 -.25 -.001  -.5 -.25 -.001  -.5 .25 -.001  -60 .25 -.001]
Polygon "vertex point P" [.5 -.25 -.001  60 -.25 -.001  60 .25 -.001  .5 .25 -.001]
AttributeEnd
AttributeBegin Translate 0 0 1 Polygon "vertex point P" [-50 -50 0  -50 50 0  50 50 0  50 -50 0] AttributeEnd
WorldEnd
)";
}
const std::string kDome =
    "AttributeBegin Rotate 30 1 2 3 Light \"PxrDomeLight\" \"sky\" \"float intensity\" [2] \"float exposure\" [1] "
    "\"color lightColor\" [1 0.5 0.25] AttributeEnd\n";
const std::string kBehind = "Attribute \"visibility\" \"int camera\" [0]\n";

// Form factor of a rectangle of half sides a and b straight above, at distance 1.
double formFactor(double a, double b) {
  const double A = std::sqrt(1 + a * a), B = std::sqrt(1 + b * b);
  return 4 / (2 * M_PI) * (a / A * std::atan(b / A) + b / B * std::atan(a / B));
}

testing::Moments lit(const std::string& lights, const std::string& portal, int component = 0) {
  RenderRequest r;
  r.rib = room(lights, portal);
  return overSeeds(r, 8, "Ci", component);
}

TEST(Portals, BringWhatTheWindowLetsThrough) {
  const double sky[3] = {4, 2, 1}, seen = 0.5 * formFactor(0.5, 0.25);
  for (int c = 0; c < 3; ++c)
    EXPECT_MEAN(lit(kDome, kBehind + "Light \"PxrPortalLight\" \"window\"\n", c), seen * sky[c], 4e-3 * sky[c]);
  EXPECT_MEAN(lit(kDome, ""), seen * sky[0], 2e-2 * sky[0]);  // the same by the dome alone
  EXPECT_MEAN(lit(kDome, kBehind + "Light \"PxrPortalLight\" \"window\" \"float intensityMult\" [0.5] \"color tint\" "
                                   "[0.5 1 1]\n"),
              seen * sky[0] / 4, 4e-3 * sky[0]);
}

TEST(Portals, CloseTheirDomeAlone) {
  const std::string portal = kBehind + "Light \"PxrPortalLight\" \"window\" \"float intensity\" [0]\n";
  EXPECT_EQ(lit(kDome, portal).mean(), 0) << "a portal's own value stands before the dome's";
  // of two domes the first is shown, the other one stays
  const std::string other = "Light \"PxrDomeLight\" \"other\" \"float intensity\" [3]\n";
  EXPECT_MEAN(lit(kDome + other, portal), 0.5 * formFactor(0.5, 0.25) * 3, 4e-2);
}

TEST(Portals, WithoutADomeAreToldAndEven) {
  RenderRequest r;
  r.rib = room("", kBehind + "Light \"PxrPortalLight\" \"window\" \"float intensity\" [2]\n");
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  int told = 0;
  for (const std::string& m : render.messages())
    told += m.find("LIGHT-PORTAL") != std::string::npos && m.find("'window'") != std::string::npos;
  EXPECT_EQ(told, 1);
  EXPECT_MEAN(overPixels(render.channel("Ci")), 0.5 * formFactor(0.5, 0.25) * 2, 6e-3);
}

const std::string kWindow = kBehind + "Light \"PxrPortalLight\" \"window\"\n";
// An even dome of radiance 1, with what is said before it.
std::string sky(const std::string& before) {
  return "AttributeBegin " + before + " Light \"PxrDomeLight\" \"sky\" AttributeEnd\n";
}
std::string filter(const char* handle, const char* intensity) {
  return std::string("LightFilter \"PxrIntMultLightFilter\" \"") + handle + "\" \"float intensity\" [" + intensity +
         "]\n";
}

TEST(Portals, HaveTheFiltersOfTheirDomeToo) {
  const double seen = 0.5 * formFactor(0.5, 0.25);
  EXPECT_MEAN(lit(sky(filter("f", ".25")), kWindow), 0.25 * seen, 1e-3);
  EXPECT_MEAN(lit(sky(filter("f", ".25")), filter("f", ".5") + kWindow), 0.125 * seen, 5e-4);
  // as the dome's own combiner has them, beside the portal's
  const std::string larger = filter("a", ".25") + filter("b", ".5") +
                             "LightFilter \"PxrCombinerLightFilter\" \"c\" \"reference lightfilter[2] max\" "
                             "[\"a\" \"b\"]\n";
  EXPECT_MEAN(lit(sky(larger), filter("a", ".5") + kWindow), 0.25 * seen, 1e-3);
}

TEST(Portals, OfMuteDomesAreMute) {
  EXPECT_EQ(lit(sky("Attribute \"lighting\" \"int mute\" [1]"), kWindow).mean(), 0);
}

TEST(Portals, LightWhatTheirDomeLights) {
  const double seen = 0.5 * formFactor(0.5, 0.25);
  const std::string grouped = sky("Attribute \"grouping\" \"string membership\" [\"outside\"]");
  const auto linked = [](const char* list, const char* names) {
    return std::string("Attribute \"lighting\" \"string ") + list + "\" [\"" + names + "\"]\n";
  };
  const std::string ofPortal = "Attribute \"grouping\" \"string membership\" [\"windows\"]\n" + kWindow;
  for (const char* name : {"outside", "sky", "window", "windows"}) {
    EXPECT_EQ(lit(grouped + linked("excludesubset", name), ofPortal).mean(), 0) << name;
    EXPECT_MEAN(lit(grouped + linked("subset", name), ofPortal), seen, 2e-3);
    RenderRequest r;  // a dome that has portals is one that linking may name
    r.rib = room(grouped + linked("subset", name), ofPortal);
    SceneRender render(r);
    for (const std::string& m : render.messages()) EXPECT_EQ(m.find("LIGHT-LINK"), std::string::npos) << m;
  }
  EXPECT_EQ(lit(grouped + "Illuminate \"sky\" 0\n", ofPortal).mean(), 0);
}

// 1 + .9 x in the direction (x, y, z) of the dome's space.
std::string writeSkyMap(const std::string& name) {
  image::Image map({0, 0, 64, 32}, {{"R"}, {"G"}, {"B"}});
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x)
      std::fill_n(map.at(x, y), 3,
                  float(1 + 0.9 * std::cos(2 * M_PI * (x + 0.5) / 64) * std::sin(M_PI * (y + 0.5) / 32)));
  const std::string file = ::testing::TempDir() + "portals_" + name + ".exr";
  EXPECT_TRUE(image::write(file, map).ok());
  return file;
}
double meanThrough(const std::string& shutter, const std::string& dome, const std::string& portal) {
  RenderRequest r;
  r.rib = shutter + room("AttributeBegin " + dome + "AttributeEnd\n", portal);
  SceneRender render(r);
  EXPECT_TRUE(render.ok());
  return overPixels(render.channel("Ci")).mean();
}
std::string turn(double degrees) { return "Rotate " + std::to_string(degrees) + " 0 1 0\n"; }
std::string moving(double from, double to) { return "MotionBegin [0 1]\n" + turn(from) + turn(to) + "MotionEnd\n"; }
// Over as many still frames of what `at` renders at a part of the shutter.
double meanOfStills(const std::function<double(double part)>& at) {
  double sum = 0;
  for (int k = 0; k < 8; ++k) sum += at((k + 0.5) / 8) / 8;
  return sum;
}

TEST(Portals, ShowTheDomeAsItTurns) {
  const std::string dome =
      "Light \"PxrDomeLight\" \"sky\" \"string lightColorMap\" [\"" + writeSkyMap("turns") + "\"]\n";
  const double start = meanThrough("", turn(0) + dome, kWindow), middle = meanThrough("", turn(90) + dome, kWindow);
  ASSERT_GT(std::fabs(middle / start - 1), 0.5) << "the scene tells nothing";
  const double expected =
      meanOfStills([&](double part) { return meanThrough("", turn(180 * part) + dome, kWindow); });
  ASSERT_GT(std::fabs(expected / start - 1), 0.3);
  ASSERT_GT(std::fabs(expected / middle - 1), 0.1);
  EXPECT_NEAR(meanThrough("Shutter 0 1\n", moving(0, 180) + dome, kWindow), expected, 0.02 * expected);
  // frames without blur: a short shutter, and none
  for (const char* shutter : {"Shutter .499 .501\n", "Shutter .5 .5\n"})
    EXPECT_NEAR(meanThrough(shutter, moving(0, 180) + dome, kWindow), middle, 0.01 * middle) << shutter;
}

TEST(Portals, ThatTurnLeaveTheDomeWhereItIs) {
  const std::string dome =
      turn(45) + "Light \"PxrDomeLight\" \"sky\" \"string lightColorMap\" [\"" + writeSkyMap("stays") + "\"]\n";
  const auto window = [](const std::string& placed) {  // room() has scaled already
    return "Scale 1 2 1\n" + placed + "Scale 1 .5 1\n" + kWindow;
  };
  const double expected =
      meanOfStills([&](double part) { return meanThrough("", dome, window(turn(60 * part - 30))); });
  EXPECT_NEAR(meanThrough("Shutter 0 1\n", dome, window(moving(-30, 30))), expected, 0.02 * expected);
  // a room that turns with its surroundings
  const double together = meanOfStills([&](double part) {
    const std::string placed = turn(60 * part - 30);
    return meanThrough("", placed + dome, window(placed));
  });
  EXPECT_NEAR(meanThrough("Shutter 0 1\n", moving(-30, 30) + dome, window(moving(-30, 30))), together,
              0.02 * together);
}

TEST(Portals, TellOnceWhereTheirDomeChangesItsShape) {
  RenderRequest r;
  r.rib = "Shutter 0 1\n" +
          room(
              "AttributeBegin MotionBegin [0 1] Scale 1 1 1 Scale 1 2 1 MotionEnd Light \"PxrDomeLight\" \"sky\" "
              "AttributeEnd\n",
              kWindow + "Light \"PxrPortalLight\" \"other\"\n");
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  EXPECT_EQ(timesSaid(render, {"LIGHT-MOTION", "'sky'"}), 1);
}

}  // namespace
}  // namespace kinora::tests
