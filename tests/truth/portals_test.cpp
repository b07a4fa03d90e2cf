// Proves: a room lit through its window has one brightness whether the dome is sampled or its portal; which dome a
// portal shows, and what it takes from it; domes with portals shine through them alone; a portal without a dome is
// told and even. Misses: maps through portals (PxrPortalLight_test.cpp).
#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace kinora::tests
