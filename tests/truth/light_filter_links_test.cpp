// Proves: which objects a light's filters are on (linkingGroups, lightfilter:subset), their saturation and parts in diffuse and specular light, and
// intensityNearDist, and where filters stand, on white planes however samples are split between lights and directions; that names which nothing
// has and distances that are none are told of. Misses: light that only marks (PxrAovLight), of which tests/channels knows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

const char* const kSplits[] = {"", "\"int numLightSamples\" [4]",
                               "\"int numLightSamples\" [0] \"int numIndirectSamples\" [8]"};

// Looks along z at a white plane at distance 2, which `attributes` are said of; the light is not seen.
RenderRequest scene(const std::string& lights, const std::string& attributes = "", const std::string& split = "",
                    const std::string& before = "") {
  RenderRequest r;
  r.rib = orthographic(16, 1e-4, 16) + unbiased(0, split) +
          "WorldBegin\nAttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" + lights + "AttributeEnd\n" +
          before + attributes +
          "Bxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\n"
          "Polygon \"P\" [-50 -50 2  -50 50 2  50 50 2  50 -50 2]\nWorldEnd\n";
  return r;
}
std::string half(const char* handle, const char* groups, double factor) {
  return std::string("LightFilter \"PxrIntMultLightFilter\" \"") + handle + "\" \"float intensity\" [" +
         std::to_string(factor) + "] \"string linkingGroups\" [\"" + groups + "\"]\n";
}
const std::string kLamp = "Scale 3 3 1 Light \"PxrRectLight\" \"l\"\n";
std::string subset(const char* groups) {
  return std::string("Attribute \"lightfilter\" \"string subset\" [\"") + groups + "\"]\n";
}

TEST(LightFilterLinks, ObjectsAreWithoutFiltersOfOtherGroups) {
  const std::string lights =
      "LightFilter \"PxrCombinerLightFilter\" \"c\" \"reference lightfilter[3] mult\" [\"a\" "
      "\"b\" \"all\"]\n" +
      half("a", "warm", 0.5) + half("b", "cold,night", 0.25) + half("all", "", 0.9) + kLamp;
  for (const char* split : kSplits) {
    SCOPED_TRACE(split);
    const auto free = overSeeds(scene(kLamp), 16);
    const struct {
      std::string attributes;
      double factor;
    } cases[] = {{"", 0.5 * 0.25 * 0.9},
                 {subset("warm"), 0.5 * 0.9},
                 {subset("night"), 0.25 * 0.9},
                 {subset("night warm"), 0.5 * 0.25 * 0.9}};
    for (const auto& c : cases) {
      const auto m = overSeeds(scene(lights, c.attributes, split), 16);
      EXPECT_NEAR(m.mean(), c.factor * free.mean(), 5 * (m.standardError() + c.factor * free.standardError()) + 1e-6)
          << c.attributes;
      EXPECT_LT(m.standardError(), 0.02 * m.mean());
    }
  }
}

// A rod that takes all light where the camera looks stands in a coordinate system of its light's scope; of lights in
// objects, in that of each instance.
TEST(LightFilterLinks, FiltersStandInTheSystemsOfTheirScope) {
  const std::string rod =
      "LightFilter \"PxrRodLightFilter\" \"rod\" \"float radius\" [.5] \"float edge\" [0] \"string coordsys\" "
      "[\"here\"]\n";
  const auto at = [](const char* request, double z) {
    return "TransformBegin Translate 0 0 " + std::to_string(z) + " " + request + " \"here\" TransformEnd\n";
  };
  // an object with the lamp at its origin, placed `z` further on
  const auto object = [](const std::string& what, double z) {
    return "ObjectBegin \"lamp\"\n" + what + kLamp + "ObjectEnd\nTransformBegin Translate 0 0 " + std::to_string(z) +
           " ObjectInstance \"lamp\" TransformEnd\n";
  };
  const double free = overSeeds(scene(kLamp), 4).mean();
  ASSERT_GT(free, 0.1);
  for (const char* request : {"ScopedCoordinateSystem", "CoordinateSystem"}) {
    SCOPED_TRACE(request);
    const std::string far = at("CoordinateSystem", 90);  // of the same name, elsewhere
    EXPECT_EQ(overSeeds(scene(at(request, 2) + rod + kLamp), 1).mean(), 0);
    EXPECT_NEAR(overSeeds(scene(at(request, 3) + rod + kLamp), 4).mean(), free, 0.02 * free);
    EXPECT_EQ(overSeeds(scene(object(at(request, 2.5) + rod, -0.5), "", "", far), 1).mean(), 0);
    EXPECT_GT(overSeeds(scene(object(at(request, 2) + rod, -0.75), "", "", far), 4).mean(), 0.2 * free);
    EXPECT_EQ(overSeeds(scene("ObjectBegin \"i\"\n" + at(request, 2.5) + rod + kLamp +
                                  "ObjectEnd\nObjectBegin \"o\"\nTranslate 0 0 -1 ObjectInstance \"i\"\nObjectEnd\n"
                                  "TransformBegin Translate 0 0 .5 ObjectInstance \"o\" TransformEnd\n",
                              "", "", far),
                        1)
                  .mean(),
              0);
  }
}

// What bounds a light's power must not take all of it where a filter of factor 0 is not on the object, weighs on part
// of the light or combines with another.
TEST(LightFilterLinks, AFactorOfNothingLeavesTheLightThatIsWithoutIt) {
  const auto nothing = [](const std::string& more) {
    return "LightFilter \"PxrIntMultLightFilter\" \"none\" \"float intensity\" [0] " + more + "\n";
  };
  const auto own = [](const char* handle, const char* mode, double factor) {
    return std::string("LightFilter \"PxrIntMultLightFilter\" \"") + handle + "\" \"float intensity\" [" +
           std::to_string(factor) + "] \"string combineMode\" [\"" + mode + "\"]\n";
  };
  const double free = overSeeds(scene(kLamp), 8).mean();
  ASSERT_GT(free, 0.1);
  const struct {
    std::string filters, attributes;
    double factor;
  } cases[] = {
      {nothing("\"float diffuse\" [0.5]"), "", 0.5},
      {nothing("\"float diffuse\" [0]"), "", 1},
      {nothing("\"float specular\" [0.5]"), "", 0},
      {nothing("\"string linkingGroups\" [\"warm\"]") + half("b", "cold", 0.5), subset("cold"), 0.5},
      {own("a", "max", 0) + own("b", "max", 0.5), "", 0.5},
      {own("a", "screen", 0) + own("b", "screen", 0.5), "", 0.5},
      {own("a", "min", 0) + own("b", "min", 0.5), "", 0},
  };
  for (const auto& c : cases)
    EXPECT_NEAR(overSeeds(scene(c.filters + kLamp, c.attributes), 8).mean(), c.factor * free, 5e-3 * free)
        << c.filters << c.attributes;
}

TEST(LightFilterLinks, SaysWhichNamesNothingHas) {
  SceneRender render(scene(half("a", "warm", 0.5) + kLamp, subset("warmer")));
  ASSERT_TRUE(render.ok());
  EXPECT_EQ(timesSaid(render, {"LIGHT-LINK", "'warmer'"}), 1);
}

TEST(LightFilterLinks, SaturationIsOfTheFiltersColor) {
  const double tint[3] = {0.8, 0.4, 0.2}, grey = 0.2126 * 0.8 + 0.7152 * 0.4 + 0.0722 * 0.2;
  const std::string colors = "\"color[4] colorRamp_Colors\" [.8 .4 .2 .8 .4 .2 .8 .4 .2 .8 .4 .2] ";
  for (const double s : {0.0, 0.5, 1.0, 1.5}) {
    const std::string saturation = "\"float saturation\" [" + std::to_string(s) + "]\n";
    for (const std::string& filter :
         {std::string("\"PxrIntMultLightFilter\" \"f\" \"color tint\" [.8 .4 .2] "),
          "\"PxrRampLightFilter\" \"f\" \"float[4] ramp_Floats\" [1 1 1 1] " + colors,
          "\"PxrRodLightFilter\" \"f\" \"float radius\" [100] \"float intensity\" [1] " + colors})
      for (int c = 0; c < 3; ++c) {
        const auto free = overSeeds(scene(kLamp), 8, "Ci", c);
        const auto m = overSeeds(scene("LightFilter " + filter + saturation + kLamp), 8, "Ci", c);
        EXPECT_NEAR(m.mean(), std::fmax(grey + s * (tint[c] - grey), 0) * free.mean(), 5e-3 * free.mean())
            << filter << s;
      }
  }
}

// A factor of .4 that weighs on each kind of lobe by its own part, on surfaces of one kind, by channel.
TEST(LightFilterLinks, WeighOnDiffuseAndSpecularLight) {
  const std::string glossy =
      "Bxdf \"PxrSurface\" \"gloss\" \"float diffuseGain\" [0] \"color specularFaceColor\" [1 1 1] \"color "
      "specularEdgeColor\" [1 1 1] \"float specularRoughness\" [0.5] \"int specularModelType\" [1]\n"
      "Polygon \"P\" [-50 -50 1.9  -50 50 1.9  50 50 1.9  50 -50 1.9]\n";
  const std::string filter = "LightFilter \"PxrIntMultLightFilter\" \"f\" \"color tint\" [.4 1 .6] ";
  const struct { double diffuse, specular; } cases[] = {{1, 1}, {0, 1}, {1, 0.25}, {0.5, 0.5}};
  for (const bool isGlossy : {false, true})
    for (const char* split : kSplits)
      for (const int c : {0, 1}) {
        SCOPED_TRACE(std::string(isGlossy ? "glossy " : "diffuse ") + split);
        const std::string before = isGlossy ? glossy : "";
        const auto free = overSeeds(scene(kLamp, "", split, before), 16, "Ci", c);
        for (const auto& k : cases) {
          const std::string amounts = "\"float diffuse\" [" + std::to_string(k.diffuse) + "] \"float specular\" [" +
                                      std::to_string(k.specular) + "]\n";
          const double factor = 1 - (c ? 0 : 0.6) * (isGlossy ? k.specular : k.diffuse);
          const auto m = overSeeds(scene(filter + amounts + kLamp, "", split, before), 16, "Ci", c);
          EXPECT_NEAR(m.mean(), factor * free.mean(), 5 * (m.standardError() + free.standardError()) + 1e-6);
          EXPECT_LT(m.standardError(), 0.04 * m.mean());
        }
      }
}

// A bulb at distance 2 of the plane is a hundredth as wide: its light falls with the square of the distance.
TEST(LightFilterLinks, NearDistanceEndsTheRiseOfBrightness) {
  const std::string at = "Scale .02 .02 .02 Light ";
  for (const char* light : {"\"PxrSphereLight\" \"l\" \"float intensity\" [1000] ",
                            "\"PxrDiskLight\" \"l\" \"float intensity\" [1000] "}) {
    const double free = overSeeds(scene(at + light + "\n"), 4).mean();
    ASSERT_GT(free, 1e-3);
    const auto with = [&](double nearest) {
      const std::string parameter = "\"float intensityNearDist\" [" + std::to_string(nearest) + "]\n";
      return overSeeds(scene(at + light + parameter), 4).mean();
    };
    EXPECT_NEAR(with(1.5), free, 2e-3 * free) << light;
    EXPECT_NEAR(with(4), free / 4, 0.02 * free / 4) << light;
  }
  const std::string lamp = "Scale 3 3 1 Light \"PxrRectLight\" \"l\" ";
  const auto reference = overSeeds(scene(lamp + "\"float intensityNearDist\" [2.5]\n", "", kSplits[1]), 16);
  EXPECT_LT(reference.mean(), 0.9 * overSeeds(scene(lamp + "\n"), 16).mean());
  for (const char* split : kSplits)
    EXPECT_SAME_MEAN(overSeeds(scene(lamp + "\"float intensityNearDist\" [2.5]\n", "", split), 16), reference, 0.02);
  SceneRender render(scene(lamp + "\"float intensityNearDist\" [-1]\n"));
  ASSERT_TRUE(render.ok());
  ASSERT_EQ(render.messages().size(), 1u);
  EXPECT_NE(render.messages()[0].find("LIGHT-NEAR"), std::string::npos);
}

}  // namespace
}  // namespace kinora::tests
