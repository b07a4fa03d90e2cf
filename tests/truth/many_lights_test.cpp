// Proves: light is a sum. A scene with lights of every kind has the mean of the scenes with one of them each (where
// there is nothing to choose), with cones, filters and shadows switched off, for surfaces that send light back, on or
// through, in glass, seen by light samples and by rays that meet lights, and for objects that some lights alone
// light. Misses: media.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

const std::vector<std::string> kLights = {
    "Translate -2 -1 1 Light \"PxrRectLight\" \"spot\" \"float intensity\" [9] \"float coneAngle\" [40] \"float "
    "coneSoftness\" [.3]",
    "Translate 1 2 2.5 Scale .5 .5 .5 Light \"PxrDiskLight\" \"disk\" \"float intensity\" [8] \"float "
    "emissionFocus\" "
    "[3]",
    "LightFilter \"PxrIntMultLightFilter\" \"f\" \"float exposure\" [-1] Translate 2 -2 2.8 Scale .2 .2 .2 Light "
    "\"PxrSphereLight\" \"ball\" \"float intensity\" [30]",
    "Translate -1 2 3 Scale 1 .1 .1 Light \"PxrCylinderLight\" \"tube\" \"float intensity\" [12]",
    "Rotate 35 1 .5 0 Light \"PxrDistantLight\" \"sun\" \"float intensity\" [7440] \"int areaNormalize\" [1]",
    "Light \"PxrDomeLight\" \"sky\" \"float intensity\" [.1]",
    "Translate 0 0 1 Light \"PointLight\" \"bulb\" \"float intensity\" [4] \"float coneAngle\" [30] \"float "
    "coneDeltaAngle\" [5]",
    "Light \"PxrMeshLight\" \"card\" \"float intensity\" [3] Polygon \"P\" [-2.5 1 2  -1.5 1 2  -1.5 2 2.5  -2.5 2 "
    "2.5]",
    "Translate 2.2 .5 2 Scale .4 .4 1 Light \"PxrRectLight\" \"fill\" \"float intensity\" [5] \"int enableShadows\" "
    "[0]",
    // behind what lets light through
    "Translate .5 -.5 5 Rotate 180 1 0 0 Light \"PxrRectLight\" \"behind\" \"float intensity\" [6]",
};

// Objects between the camera, which looks along +z, and a floor across its view.
std::string scene(const std::string& lights, const std::string& floor, const std::string& more) {
  std::string s =
      orthographic(16, 3, 16) + "Hider \"raytrace\" \"int maxsamples\" [16]\n" + more + "WorldBegin\n" + lights;
  s += "AttributeBegin " + floor + "Polygon \"P\" [-4 -4 4  -4 4 4  0 4 4  0 -4 4]\n";
  s += "Attribute \"lighting\" \"string subset\" [\"disk ball sun behind bulb\"]\n";
  s += "Polygon \"P\" [0 -4 4  0 4 4  4 4 4  4 -4 4]\nAttributeEnd\n";
  s += "AttributeBegin Bxdf \"PxrDiffuse\" \"grey\" \"color diffuseColor\" [.4 .4 .4]\nTranslate .7 .8 3.2 Sphere .6 "
       "-.6 .6 "
       "360\nAttributeEnd\n";
  return s + "WorldEnd\n";
}
std::string block(const std::string& light) {
  return "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" + light + "\nAttributeEnd\n";
}

void expectSum(const std::string& floor, const std::string& integrator, int seeds, double relative = 0.005) {
  std::string all;
  double sum = 0, variance = 0;
  for (const std::string& light : kLights) {
    all += block(light);
    RenderRequest one;
    one.rib = scene(block(light), floor, integrator);
    const testing::Moments m = overSeeds(one, seeds);
    sum += m.mean();
    variance += m.standardError() * m.standardError();
  }
  RenderRequest together;
  together.rib = scene(all, floor, integrator);
  const testing::Moments m = overSeeds(together, seeds);
  variance += m.standardError() * m.standardError();
  EXPECT_LE(std::fabs(m.mean() - sum), 4 * std::sqrt(variance)) << m.mean() << " against " << sum;
  EXPECT_LE(std::sqrt(variance), relative * sum) << "too few samples to judge";
}

TEST(ManyLights, LightIsASumOnDiffuse) {
  expectSum("Bxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [.8 .8 .8]\n", unbiased(1), 12);
}
TEST(ManyLights, LightIsASumOnGlossy) {
  expectSum(
      "Bxdf \"PxrSurface\" \"gloss\" \"color diffuseColor\" [.2 .2 .2] \"color specularFaceColor\" [.3 .3 .3] "
      "\"color "
      "specularEdgeColor\" [1 1 1] \"float specularRoughness\" [.3]\n",
      unbiased(1, "\"int numIndirectSamples\" [2]"), 28);
}
TEST(ManyLights, LightIsASumThroughLeaves) {
  expectSum(
      "Bxdf \"PxrDiffuse\" \"leaf\" \"color diffuseColor\" [.3 .3 .3] \"color transmissionColor\" [.5 .5 .5] \"int "
      "transmissionBehavior\" [1]\n",
      unbiased(1), 12);
}
TEST(ManyLights, LightIsASumBehindTintedGlass) {
  expectSum(
      "Bxdf \"PxrSurface\" \"pane\" \"float diffuseGain\" [0] \"float refractionGain\" [.8] \"float reflectionGain\" "
      "[.5] "
      "\"float glassRoughness\" [.2] \"int thinGlass\" [1]\n",
      "Integrator \"PxrPathTracer\" \"i\" \"int maxIndirectBounces\" [2] \"float clampLuminance\" [1e30] \"float "
      "rouletteThreshold\" [0]\n",
      20, 0.012);
}

}  // namespace
}  // namespace kinora::tests
