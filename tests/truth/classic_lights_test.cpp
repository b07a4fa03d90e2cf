// Proves: the lights of the RenderMan Interface by the formulas of its specification (3.2, appendix A.2), seen by a
// white diffuse plane that faces the camera, whose colour is Cl times the cosine; which objects they light (the list
// of light sources is an attribute); Illuminate for them and for lights of RIS; lights declared before the world;
// ambient light without shadow, by light samples and by bxdf samples; lights that mirrors do not show; stand-ins for
// lights of other names. Misses: shadow maps, slides and noise of other light shaders.
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

constexpr double kPi = 3.14159265358979323846;
const std::string kDirect = "Integrator \"PxrDirectLighting\" \"i\"\n";
const std::string kWhite = "Bxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\n";
const std::string kPlane = "Polygon \"P\" [-50 -50 2  -50 50 2  50 50 2  50 -50 2]\n";

// Looks along z at (0, 0, 2) of a white plane.
std::string scene(const std::string& lights, const std::string& before = "",
                  const std::string& integrator = kDirect) {
  return orthographic(16, 1e-4, 16) + integrator + before + "WorldBegin\n" + lights + kWhite + kPlane + "WorldEnd\n";
}
double radiance(const std::string& rib, int seeds = 1) {
  RenderRequest r;
  r.rib = rib;
  return overSeeds(r, seeds).mean();
}
#define EXPECT_SEEN(rib, expected) EXPECT_NEAR(radiance(rib), expected, 1e-3 * (expected) + 1e-9)

double smoothstep(double a, double b, double x) {
  const double t = std::fmin(1, std::fmax(0, (x - a) / (b - a)));
  return t * t * (3 - 2 * t);
}

TEST(ClassicLights, PointAndDistant) {
  EXPECT_SEEN(scene("LightSource \"pointlight\" 1 \"intensity\" 4 \"from\" [0 0 0]\n"), 1);
  EXPECT_SEEN(scene("LightSource \"pointlight\" 1 \"intensity\" 4 \"from\" [2 0 0]\n"), 4.0 / 8 * std::sqrt(0.5));
  EXPECT_SEEN(scene("LightSource \"distantlight\" 1 \"intensity\" 0.7 \"from\" [5 0 0] \"to\" [5 1 1]\n"),
              0.7 * std::sqrt(0.5));
  // the distance is taken in the world: a scale around the declaration moves the light and nothing else
  EXPECT_SEEN(scene("TransformBegin Scale 3 3 3\nLightSource \"pointlight\" 1 \"intensity\" 4 \"from\" [0 0 0]\n"
                    "TransformEnd\n"),
              1);
  EXPECT_SEEN(scene("TransformBegin Scale 4 .5 -1\nLightSource \"pointlight\" 1 \"intensity\" 4 \"from\" [.5 0 0]\n"
                    "TransformEnd\n"),
              4.0 / 8 * std::sqrt(0.5));
}

TEST(ClassicLights, SpotByTheSmoothstepOfItsCosine) {
  // from (x, 0, 0) along +z, and the plane is seen at (0, 0, 2)
  for (const double x : {0.0, 0.3, 0.8, 1.0, 1.08, 1.2}) {
    const double d2 = 4 + x * x, cosine = 2 / std::sqrt(d2);
    const double expected = 8 * std::pow(cosine, 2) / d2 * smoothstep(std::cos(0.5), std::cos(0.3), cosine) * cosine;
    const std::string from = std::to_string(x);
    EXPECT_NEAR(radiance(scene("LightSource \"spotlight\" 1 \"intensity\" 8 \"from\" [" + from + " 0 0] \"to\" [" +
                               from + " 0 1] \"coneangle\" .5 \"conedeltaangle\" .2\n")),
                expected, 2e-3 * 2 + 1e-9)
        << x;
  }
}

// Under a card that hides all of the sky: what nothing shadows arrives whole, once, by each of the two techniques.
TEST(ClassicLights, AmbientHasNoShadow) {
  const std::string card =
      "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\nBxdf \"PxrDiffuse\" \"black\" \"color "
      "diffuseColor\" "
      "[0 0 0]\nPolygon \"P\" [-50 -50 1.9  50 -50 1.9  50 50 1.9  -50 50 1.9]\nAttributeEnd\n";
  const std::string ambient = "LightSource \"ambientlight\" 1 \"intensity\" .5\n";
  for (const char* samples :
       {"", "\"int numLightSamples\" [0]", "\"int numLightSamples\" [4]", "\"int numIndirectSamples\" [4]"}) {
    RenderRequest r;
    r.rib = scene(ambient + card, "", unbiased(0, samples));
    EXPECT_MEAN(overSeeds(r, 16), 0.5, 3e-3);
  }
  EXPECT_NEAR(radiance(scene(ambient + card), 4), 0.5, 2e-3);
  EXPECT_NEAR(radiance(scene(ambient), 4), 0.5, 2e-3) << "without the card the same";
  // shadows of other lights do not depend on it
  EXPECT_NEAR(radiance(scene(ambient + "LightSource \"distantlight\" 2 \"to\" [0 0 1]\n" + card), 4), 0.5, 2e-3);
  // it stands for what surfaces send each other: in a closed room each shows its own colour times the light, no more
  const std::string room =
      "AttributeBegin Bxdf \"PxrDiffuse\" \"grey\" \"color diffuseColor\" [.6 .6 .6]\nPointsPolygons [4 4 4 4 4 4] "
      "[0 1 3 2 4 5 7 6 0 1 5 4 2 3 7 6 0 2 6 4 1 3 7 5] \"P\" [-40 -40 -40 40 -40 -40 -40 40 -40 40 40 -40 -40 -40 "
      "40 40 -40 40 -40 40 40 40 40 40]\n"
      "Polygon \"P\" [-5 -5 1.8  -5 5 1.8  5 5 1.8  5 -5 1.8]\nAttributeEnd\n";
  EXPECT_NEAR(radiance(scene(ambient + room, "", unbiased(8)), 4), 0.3, 1e-3);
  // a mirror shows what it lights: the camera sees the room's wall behind it
  const std::string shiny =
      "AttributeBegin Bxdf \"PxrSurface\" \"mirror\" \"float diffuseGain\" [0] \"color specularFaceColor\" "
      "[1 1 1] \"color specularEdgeColor\" [1 1 1] \"float specularRoughness\" [0]\n"
      "Polygon \"P\" [-5 -5 1  -5 5 1  5 5 1  5 -5 1]\nAttributeEnd\n";
  EXPECT_NEAR(radiance(scene(ambient + shiny + room, "", unbiased(8)), 4), 0.3, 1e-3);
  // a mirror shows neither it nor its light
  EXPECT_EQ(radiance(scene(ambient + shiny, "", unbiased(2))), 0);
}

// A scene without an integrator is one of the old renderers, whose lights cast shadows where they were told to.
TEST(ClassicLights, ShadowsAreWhereTheOldRenderersHadThem) {
  const std::string card =
      "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\nBxdf \"PxrDiffuse\" \"black\" \"color "
      "diffuseColor\" [0 0 0]\nPolygon \"P\" [-50 -50 1  50 -50 1  50 50 1  -50 50 1]\nAttributeEnd\n";
  const auto seen = [&](const std::string& lights, const std::string& integrator) {
    return radiance(scene(lights + card, "", integrator));
  };
  const std::string sun = "LightSource \"distantlight\" 1 \"intensity\" .7 \"to\" [0 0 1]\n";
  EXPECT_NEAR(seen(sun, ""), 0.7, 1e-3);
  EXPECT_NEAR(seen(sun, kDirect), 0, 1e-9);
  EXPECT_NEAR(seen("Attribute \"light\" \"shadows\" \"on\"\n" + sun, ""), 0, 1e-9);
  EXPECT_NEAR(seen("LightSource \"pointlight_shadows\" 1 \"intensity\" 4 \"from\" [0 0 0]\n", ""), 0, 1e-9);
  EXPECT_NEAR(seen("LightSource \"spotlight\" 1 \"intensity\" 4 \"shadowname\" \"a.shad\"\n", ""), 0, 1e-9);
  EXPECT_NEAR(seen("LightSource \"pointlight_rts\" 1 \"intensity\" 4 \"from\" [0 0 0]\n", ""), 0, 1e-9);
}

// What no standard light is, at one point, against the formula of what stands in (Barzel 1997 for uberlight).
TEST(ClassicLights, OthersByWordsAndParameters) {
  const auto seen = [](const std::string& what) { return radiance(scene("LightSource " + what + "\n")); };
#define EXPECT_LIGHT(what, expected) EXPECT_NEAR(seen(what), expected, 0.01 * (expected) + 1e-9) << what
  EXPECT_LIGHT("\"shadowspot\" 1 \"intensity\" 8 \"shadowname\" \"none.shad\" \"conedeltaangle\" .1", 2);
  EXPECT_LIGHT("\"shadowdistant\" 1 \"intensity\" .5 \"from\" [0 0 0] \"to\" [0 0 1]", .5);
  EXPECT_LIGHT("\"pointlight_shadows\" 1 \"float intensity\" 4 \"point from\" [0 0 0]", 1);
  EXPECT_LIGHT("\"pointnofalloff\" 1 \"intensity\" .5", .5);
  EXPECT_LIGHT(
      "\"renderman/a/shaders/spotLightShape1_rfm\" 1 \"float intensity\" 2 \"float coneAngle\" 40 \"float "
      "penumbraAngle\" 5 \"float decayRate\" 1 \"color cl\" [.5 .5 .5] \"float dropoff\" 0",
      .5);
  EXPECT_LIGHT("\"Light0x1\" \"spotlight\" \"intensity\" 4", 1);
  // by parameters alone
  EXPECT_LIGHT("\"keylight\" 1 \"intensity\" 4 \"from\" [0 0 1]", 4);
  EXPECT_LIGHT("\"keylight\" 1 \"intensity\" .7 \"from\" [0 0 0] \"to\" [0 0 1]", .7);
  EXPECT_LIGHT("\"keylight\" 1 \"intensity\" 4 \"coneangle\" .5", 1);
  EXPECT_LIGHT("\"keylight\" 1 \"intensity\" .7", .7);
  EXPECT_LIGHT("\"keylight\" 1 \"intensity\" 4 \"falloff\" 1", 2);
  // Barzel's controls: a cone with an edge, cuts, falloff
  EXPECT_LIGHT("\"uberlight\" 1 \"intensity\" .6", .6);
  EXPECT_LIGHT("\"uberlight\" 1 \"intensity\" 8 \"falloff\" 2", 2);
  EXPECT_LIGHT("\"uberlight\" 1 \"intensity\" 8 \"falloff\" 2 \"falloffdist\" 2", 8);
  EXPECT_LIGHT("\"uberlight\" 1 \"intensity\" 8 \"falloff\" 1 \"falloffdist\" 4 \"maxintensity\" 3",
               8 * 3 * std::exp(-std::log(3.0) * std::pow(.5, 1 / std::log(3.0))));
  EXPECT_LIGHT("\"uberlight\" 1 \"string lighttype\" \"omni\" \"cutoff\" 1.5 \"faredge\" 1", .5);
  EXPECT_LIGHT("\"uberlight\" 1 \"cuton\" 2.5 \"nearedge\" 1", .5);
  EXPECT_LIGHT("\"uberlight\" 1 \"cuton\" 2.5", 0.0);
  EXPECT_LIGHT("\"uberlight\" 1 \"parallelrays\" 1 \"intensity\" .5", .5);
  EXPECT_LIGHT("\"envlight\" 1 \"intensity\" .5", .5);
  // a small square, all of it as much as a point
  EXPECT_NEAR(seen("\"arealight\" 1 \"intensity\" 4\nTransformBegin Scale .02 .02 1\nLightSource "
                   "\"arealight\" 2 \"intensity\" 4\nTransformEnd\nIlluminate 1 0"),
              1, 0.02);
  EXPECT_NEAR(seen("\"pointlight\" 1\nTransformBegin Scale .02 .02 1\nLightSource \"plausibleArealight\" 2 "
                   "\"intensity\" 40\nTransformEnd\nIlluminate 1 0"),
              10 / kPi / kPi, 0.02);
#undef EXPECT_LIGHT
}

// The superellipse, with light and point apart: (x, y) off the axis at depth 2.
TEST(ClassicLights, UberlightsConeIsASuperellipse) {
  for (const double roundness : {0.0, 0.5, 1.0})
    for (const double x : {0.1, 0.25, 0.3, 0.34, 0.5})
      for (const double y : {0.0, 0.15, 0.26}) {
        const double a = .2, b = .15, A = a + .1, B = b + .05, u = x / 2, v = y / 2;
        double f;
        if (roundness == 0) {
          f = (1 - smoothstep(a, A, u)) * (1 - smoothstep(b, B, v));
        } else {
          const double e = 2 / roundness;
          const auto scale = [&](double p, double q) {
            return p * q * std::pow(std::pow(q * u, e) + std::pow(p * v, e), -1 / e);
          };
          f = 1 - smoothstep(scale(a, b), scale(A, B), 1);
        }
        const double cosine = 2 / std::sqrt(4 + x * x + y * y);
        const std::string text = "TransformBegin Translate " + std::to_string(-x) + " " + std::to_string(-y) +
                                 " 0\nLightSource \"uberlight\" 1 \"width\" .2 \"height\" .15 \"wedge\" .1 \"hedge\" "
                                 ".05 \"roundness\" " +
                                 std::to_string(roundness) + "\nTransformEnd\n";
        EXPECT_NEAR(radiance(scene(text)), f * cosine, 0.01 * f + 1e-3) << roundness << " " << x << " " << y;
      }
}

// An unknown area light: the shape shines as much as a point light of its intensity, from its outside.
TEST(ClassicLights, AreaLightsOfAnyName) {
  const auto lit = [](const std::string& parameters) {
    return scene("AttributeBegin AreaLightSource \"mylight\" \"a\" " + parameters +
                 "\nAttribute \"visibility\" \"int camera\" [0]\nTranslate 0 0 -2 Disk 0 .05 360 AttributeEnd\n");
  };
  RenderRequest r;
  for (const auto& [parameters, expected] : {std::pair{"\"intensity\" 16", 1.0},
                                             {"\"intensity\" .5 \"float falloff\" 0", .5},
                                             {"\"intensity\" 16 \"color lightcolor\" [.5 .5 .5]", .5}}) {
    r.rib = lit(parameters);
    EXPECT_MEAN(overSeeds(r, 8), expected, 0.01 * expected);
  }
}

// Lights in objects shine from each instance: what two places give together is what lights said there give.
TEST(ClassicLights, InObjectsTheyShineFromEachInstance) {
  const auto point = [](double x, double z) {  // seen at (0, 0, 2)
    const double d2 = x * x + (2 - z) * (2 - z);
    return 4 / d2 * (2 - z) / std::sqrt(d2);
  };
  const std::string lamp =
      "ObjectBegin \"lamp\"\nTranslate 1 0 0\nLightSource \"pointlight\" 1 \"intensity\" 4 \"from\" [0 0 "
      ".5]\nObjectEnd\n";
  const std::string inLamp =
      "ObjectBegin \"two\"\nObjectInstance \"lamp\"\nTranslate 0 0 1\nObjectInstance \"lamp\"\nObjectEnd\n";
  EXPECT_SEEN(scene(lamp + "ObjectInstance \"lamp\"\n"), point(1, .5));
  // one of two lights a sample
  const double both = point(2, .5) + point(0, -.5), nested = point(1, .5) + point(1, 1.5);
  EXPECT_NEAR(
      radiance(
          scene(lamp + "AttributeBegin\nTranslate -3 0 0\nObjectInstance \"lamp\"\nAttributeEnd\nAttributeBegin\n"
                       "Translate -1 0 -1\nObjectInstance \"lamp\"\nAttributeEnd\n"),
          4),
      both, .03 * both);
  EXPECT_NEAR(radiance(scene(lamp + inLamp + "ObjectInstance \"two\"\n"), 4), nested, .03 * nested);
  EXPECT_EQ(radiance(scene(lamp)), 0) << "nobody placed it";
  EXPECT_EQ(radiance(scene(lamp + "ObjectInstance \"lamp\"\nIlluminate 1 0\n")), 0);
  // an area light: its shape in the object, or an object for its shape
  const std::string area = "AreaLightSource \"area\" 1 \"intensity\" 4\n", ball = "Sphere .05 -.05 .05 360\n";
  RenderRequest said, inside, shape, none;
  said.rib = scene("AttributeBegin\nTranslate .5 0 0\n" + area + ball + "AttributeEnd\n");
  inside.rib = scene("ObjectBegin \"o\"\n" + area + ball +
                     "ObjectEnd\nAttributeBegin\nTranslate .5 0 0\nObjectInstance \"o\"\nAttributeEnd\n");
  shape.rib = scene("ObjectBegin \"o\"\n" + ball + "ObjectEnd\nAttributeBegin\nTranslate .5 0 0\n" + area +
                    "ObjectInstance \"o\"\nAttributeEnd\n");
  const double expected = overSeeds(said, 4).mean();
  EXPECT_GT(expected, .1);
  EXPECT_NEAR(overSeeds(inside, 4).mean(), expected, .03 * expected);
  EXPECT_NEAR(overSeeds(shape, 4).mean(), expected, .03 * expected);
  none.rib = scene("ObjectBegin \"o\"\nLightSource \"ambientlight\" 1\nObjectEnd\nObjectInstance \"o\"\n");
  SceneRender render(none);
  EXPECT_EQ(overPixels(render.channel("Ci")).mean(), 0);
  EXPECT_TRUE(says(render, "CLASSIC-LIGHT-OUT"));
}

// A light of which nothing is known is told of; where it was the only one the headlight stays on.
TEST(ClassicLights, NothingKnownIsNotBlack) {
  RenderRequest r;
  for (const char* name : {"causticlight", "strange", ""}) {
    r.rib =
        orthographic(4, 1e-4, 4) + "WorldBegin\nLightSource \"" + name + "\" 1\n" + kWhite + kPlane + "WorldEnd\n";
    SceneRender render(r);
    EXPECT_NEAR(overPixels(render.channel("Ci")).mean(), 1, 1e-3) << name;
    EXPECT_TRUE(says(render, "CLASSIC-LIGHT-OUT")) << name;
  }
}

// What glows lights the rest, where no light does and no integrator is named.
TEST(Lights, WhatGlowsIsNoSceneWithoutLight) {
  const auto lit = [](const std::string& integrator, const std::string& glow) {
    RenderRequest r;
    r.rib = orthographic(4, 1e-4, 64) + integrator +
            "WorldBegin\nAttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" + glow +
            "Polygon \"P\" [-9 -9 -1  9 -9 -1  9 9 -1  -9 9 -1]\nAttributeEnd\n" + kWhite + kPlane + "WorldEnd\n";
    return overSeeds(r, 4);
  };
  const std::string paths = "Integrator \"PxrPathTracer\" \"i\"\n";
  for (const char* glow : {"Bxdf \"PxrConstant\" \"c\" \"color emitColor\" [.3 .3 .3]\n",
                           "Bxdf \"PxrSurface\" \"c\" \"float glowGain\" [.3] \"float diffuseGain\" [0]\n",
                           "Bxdf \"LamaEmission\" \"c\" \"color emissionColor\" [.3 .3 .3]\n"})
    EXPECT_SAME_MEAN(lit("", glow), lit(paths, glow), 0.02);
  const char* const dark = "Bxdf \"PxrConstant\" \"c\" \"color emitColor\" [0 0 0]\n";
  EXPECT_NEAR(lit("", dark).mean(), 1, 1e-3) << "the headlight";
}

// What is said of a light's shape does not change what it lights, and the shape is told of once.
TEST(Lights, AreaLightsThatTheCameraDoesNotSee) {
  for (const char* name : {"PxrStdAreaLight", "arealight"})
    for (const char* shape : {"Sphere .2 -.2 .2 360", "Disk 0 .2 360", "Rotate 180 1 0 0 Geometry \"rectlight\""}) {
      testing::Moments lit[2];
      for (const int seen : {0, 1}) {
        RenderRequest r;
        r.rib = scene("AttributeBegin Attribute \"visibility\" \"int camera\" [" + std::to_string(seen) +
                      "]\nAreaLightSource \"" + name + "\" \"l\" \"float intensity\" [9]\nTranslate .5 0 -1.5 " +
                      shape + " AttributeEnd\n");
        lit[seen] = overSeeds(r, 4);
        SceneRender render(r);
        EXPECT_FALSE(says(render, "RIB-KEPT")) << shape;
      }
      EXPECT_GT(lit[0].mean(), 0.01) << name << shape;
      EXPECT_SAME_MEAN(lit[0], lit[1], 0.02);
    }
}

// Any light may go without shadows; both techniques then go through what is in between, and add up to the light's
// own.
TEST(Lights, EnableShadows) {
  const std::string wall =
      "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\nBxdf \"PxrDiffuse\" \"black\" \"color "
      "diffuseColor\" [0 0 0]\nPolygon \"P\" [-50 -50 1.7  50 -50 1.7  50 50 1.7  -50 50 1.7]\nAttributeEnd\n";
  const std::string unseen = "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\nTranslate 0 0 1 ";
  for (const char* plugin : {"PxrRectLight", "PxrSphereLight", "PxrDiskLight"}) {
    const auto light = [&](int shadows) {
      return unseen + "Light \"" + plugin + "\" \"l\" \"int enableShadows\" [" + std::to_string(shadows) +
             "] AttributeEnd\n";
    };
    for (const char* samples :
         {"\"int numLightSamples\" [4]", "\"int numLightSamples\" [0] \"int numIndirectSamples\" [8]"}) {
      RenderRequest free, through, blocked;
      free.rib = scene(light(1), "", unbiased(0, samples));
      through.rib = scene(light(0) + wall, "", unbiased(0, samples));
      blocked.rib = scene(light(1) + wall, "", unbiased(0, samples));
      EXPECT_SAME_MEAN(overSeeds(free, 16), overSeeds(through, 16), 0.004);
      EXPECT_EQ(overSeeds(blocked, 1).mean(), 0);
    }
  }
}

TEST(ClassicLights, ShineInTheirBlock) {
  const std::string light = "LightSource \"pointlight\" 1 \"intensity\" 4 \"from\" [0 0 0]\n";
  EXPECT_SEEN(scene("AttributeBegin\n" + light + "AttributeEnd\n"), 0);
  EXPECT_SEEN(scene("AttributeBegin\n" + light + "AttributeEnd\nIlluminate 1 1\n"), 1);
  EXPECT_SEEN(scene("TransformBegin\n" + light + "TransformEnd\n"), 1);
  EXPECT_SEEN(scene(light + "Illuminate 1 0\n"), 0);
  EXPECT_SEEN(scene(light + "AttributeBegin Illuminate 1 0\nAttributeEnd\n"), 1);
  EXPECT_SEEN(scene(light + "Illuminate 1 0 Illuminate 1 1\n"), 1);
  // the handle means the light that had it last
  EXPECT_SEEN(scene("AttributeBegin\n" + light +
                    "AttributeEnd\nAttributeBegin LightSource \"distantlight\" 1 \"intensity\" .25 "
                    "AttributeEnd\nIlluminate 1 1\n"),
              0.25);
  // an object before the light is not lit by it
  EXPECT_SEEN(scene(kWhite + "Polygon \"P\" [-50 -50 1  -50 50 1  50 50 1  50 -50 1]\n" + light), 0);
  // instances follow their own attributes
  const std::string object = "ObjectBegin \"o\"\nPolygon \"P\" [-50 -50 1  -50 50 1  50 50 1  50 -50 1]\nObjectEnd\n";
  EXPECT_SEEN(scene(object + light + kWhite + "ObjectInstance \"o\"\n"), 4);
  EXPECT_SEEN(scene(object + light + kWhite + "AttributeBegin Illuminate 1 0 ObjectInstance \"o\" AttributeEnd\n"),
              0);
}

TEST(ClassicLights, BeforeTheWorldStandInCameraSpace) {
  // the camera is at (0, 0, -1); 3 from the plane, the light beside it
  const std::string move = "Translate 0 0 1\n";
  EXPECT_SEEN(scene("", "LightSource \"pointlight\" 1 \"intensity\" 9 \"from\" [0 0 0]\n" + move), 1);
  EXPECT_SEEN(scene("Illuminate 1 0\n", "LightSource \"pointlight\" 1 \"intensity\" 9 \"from\" [0 0 0]\n" + move), 0);
  EXPECT_SEEN(scene("", move + "Light \"PointLight\" \"l\" \"float intensity\" [" + std::to_string(4 * kPi) + "]\n"),
              1);
}

TEST(Lights, OfRisShineEverywhereButWhereSwitchedOff) {
  const std::string dome = "AttributeBegin Light \"PointLight\" \"l\" \"float intensity\" [" +
                           std::to_string(4 * kPi) + "] AttributeEnd\n";
  EXPECT_SEEN(scene(dome), 1);
  EXPECT_SEEN(scene(dome + "Illuminate \"l\" 0\n"), 0);
  EXPECT_SEEN(scene(dome + "AttributeBegin Illuminate \"l\" 0 AttributeEnd\n"), 1);
  EXPECT_SEEN(scene(dome + "Illuminate \"l\" 0 Illuminate \"l\" 1\n"), 1);
}

TEST(Lights, LinkedByListsWithCommas) {
  const auto light = [](const char* name, double intensity) {
    return std::string("Light \"PointLight\" \"") + name + "\" \"float intensity\" [" +
           std::to_string(4 * kPi * intensity) + "]\n";
  };
  const std::string all = light("a", 1) + light("b", 2) + light("c", 4);
  for (const char* list : {"a,c", "a, c", "a c", " a ,\tc,"}) {
    EXPECT_NEAR(radiance(scene(all + "Attribute \"lighting\" \"string subset\" [\"" + list + "\"]\n"), 8), 5, 0.05)
        << list;
    EXPECT_NEAR(radiance(scene(all + "Attribute \"lighting\" \"string excludesubset\" [\"" + list + "\"]\n"), 8), 2,
                0.02)
        << list;
  }
}

// What is said of an old area light's shape holds for the light, before AreaLightSource or after.
TEST(Lights, OldAreaLightsAreAsVisibleAsTheirShape) {
  const std::string area = "AreaLightSource \"PxrStdAreaLight\" \"a\" \"float intensity\" [9]\n";
  const std::string shape = "Translate 0 0 2 Sphere .5 -.5 .5 360\nAttributeEnd\n";
  const std::string mirror =
      "Bxdf \"PxrSurface\" \"mirror\" \"float diffuseGain\" [0] \"color specularFaceColor\" [1 1 1] \"color "
      "specularEdgeColor\" [1 1 1] \"float specularRoughness\" [0]\nPolygon \"P\" [-5 -5 2  -5 5 2  5 5 2  5 -5 2]\n";
  for (const bool isBefore : {false, true})
    for (const int seen : {0, 1}) {
      const auto block = [&](const char* what, const std::string& rest) {
        const std::string said =
            std::string("Attribute \"visibility\" \"int ") + what + "\" [" + std::to_string(seen) + "]\n";
        return "AttributeBegin\n" + (isBefore ? said + area : area + said) + rest;
      };
      const std::string begin = orthographic(16, 1e-4, 16) + kDirect + "WorldBegin\n";
      EXPECT_EQ(radiance(begin + block("camera", shape) + "WorldEnd\n") > 1, seen == 1) << isBefore;
      // behind the camera, in a mirror
      const std::string behind = begin + block("indirect", "Translate 0 0 -4 " + shape) + mirror + "WorldEnd\n";
      EXPECT_EQ(radiance(behind) > 1, seen == 1) << isBefore;
    }
}

// A light with visibility:indirect 0 is in no mirror, and lights what it lit before. Beside a transmission, as exporters
// say it of all lights, it is no wish.
TEST(Lights, HiddenFromMirrors) {
  const auto look = [](const std::string& bxdf, int visible, const char* light, const char* beside = "") {
    return scene("AttributeBegin Attribute \"visibility\" \"int camera\" [0] \"int indirect\" [" +
                     std::to_string(visible) + "]" + beside + "\nTranslate 0 0 -1 " + light + " AttributeEnd\n" +
                     bxdf + "Polygon \"P\" [-50 -50 1  -50 50 1  50 50 1  50 -50 1]\n",
                 "", unbiased(1));
  };
  const std::string mirror =
      "Bxdf \"PxrSurface\" \"m\" \"float diffuseGain\" [0] \"color specularFaceColor\" [1 1 1] \"color "
      "specularEdgeColor\" [1 1 1] \"float specularRoughness\" [";
  for (const char* light : {"Light \"PxrRectLight\" \"l\" \"float intensity\" [3]",
                            "Light \"PxrDomeLight\" \"l\" \"float intensity\" [3]"}) {
    EXPECT_NEAR(radiance(look(mirror + "0]\n", 1, light)), 3, 1e-3);
    EXPECT_EQ(radiance(look(mirror + "0]\n", 0, light)), 0);
    for (const char* transmission : {" \"int transmission\" [0]", " \"int transmission\" [1]"})
      EXPECT_NEAR(radiance(look(mirror + "0]\n", 0, light, transmission)), 3, 1e-3) << transmission;
    for (const std::string& bxdf : {kWhite, mirror + "0.4]\n"}) {
      RenderRequest shown, hidden;
      shown.rib = look(bxdf, 1, light);
      hidden.rib = look(bxdf, 0, light);
      EXPECT_SAME_MEAN(overSeeds(shown, 16), overSeeds(hidden, 16), 0.01);
    }
  }
}

}  // namespace
}  // namespace kinora::tests
