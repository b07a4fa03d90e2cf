// A volume plug-in, the example's ball of smoke, fills a Volume request that names it: through its middle the way takes
// what the integral of its density says, by name and through a network. One that is not there is a mist, and told.
#include <cmath>

#include "tests/probes/probe_support.h"

namespace kinora {
const Descriptor* kinoraStock_Puff();
namespace probes {
namespace {

// The mean of a sky behind it, and messages.
double skyThrough(const std::string& material, const std::string& volume, std::string& said) {
  Workshop stage{kinoraStock_Puff()};
  render::Settings s;
  s.threads = 1;
  const auto r =
      stage.load(sceneOf("Format 16 16 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [64]\n"
                         "Display \"x.exr\" \"openexr\" \"Ci\"\nScreenWindow -0.001 0.001 -0.001 0.001\n"
                         "Projection \"orthographic\"\nIntegrator \"PxrPathTracer\" \"i\"\nWorldBegin\n"
                         "Light \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\nTranslate 0 0 4\n" +
                             material + "Volume \"blobbydso:" + volume + "\nWorldEnd\n",
                         stage.messages),
                 s);
  const image::Image picture = pictureOf(*r);
  said = stage.said;
  double sum = 0;
  for (const float x : picture.pixels) sum += x;
  return sum / double(picture.pixels.size());
}

TEST(VolumePlugins, FillRequestsThatNameThem) {
  const std::string
      dark = "Bxdf \"PxrVolume\" \"m\" \"color diffuseColor\" [0 0 0] ",
      puff = "Puff\" [-2 2 -2 2 -2 2] [0 0 0] \"constant float radius\" [1.5] \"constant float density\" [0.4]";
  const double expected = std::exp(-0.4 * 1.5 * 4 / 3);  // 2 r (1 - 1/3)
  std::string said;
  EXPECT_NEAR(skyThrough(dark + "\"string densityFloatPrimVar\" [\"density\"]\n", puff, said), expected, 0.015);
  EXPECT_EQ(said, "");
  EXPECT_NEAR(
      skyThrough("Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"density\"] \"string type\" [\"float\"]\n" +
                     dark + "\"reference float densityFloat\" [\"p:resultF\"]\n",
                 puff, said),
      expected, 0.015);
  EXPECT_EQ(said, "");
}

TEST(VolumePlugins, WhatIsNotThereIsMist) {
  std::string said;
  EXPECT_NEAR(
      skyThrough(
          "Bxdf \"PxrVolume\" \"m\" \"color diffuseColor\" [0 0 0] \"string densityFloatPrimVar\" [\"density\"]\n",
          "Poof\" [-2 2 -2 2 -2 2] [0 0 0] \"varying float density\" []", said),
      std::exp(-0.7), 0.015);
  EXPECT_NE(said.find("PLUGIN-MISSING"), std::string::npos) << said;
}

}  // namespace
}  // namespace probes
}  // namespace kinora
