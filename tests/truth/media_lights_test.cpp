// Light in media by every road that it may be found: distances that suit lights against distances that extinction alone
// draws, over kinds of lights, weights and media, and against quadrature; what media emit as a light, against closed
// forms of what it casts and against the same found by chance; media that are carried by velocities against the same
// displaced by hand; similarity. Misses: how much less noise there is (docs/performance.md).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

std::string volumeMaterial(const std::string& parameters) { return "Bxdf \"PxrVolume\" \"m\" " + parameters + "\n"; }
const char* const kDarkFloor =
    "Bxdf \"PxrDiffuse\" \"f\"\nAttributeBegin Translate 0 -0.8 4 Sphere 0.5 -0.5 0.5 360 AttributeEnd\n";

// A picture of lights in what `media` says, by the weight of distances that suit lights.
testing::Moments litMedia(const std::string& lights, const std::string& media, int samples, int seeds = 8,
                          const std::string& more = "") {
  RenderRequest r;
  r.rib = orthographic(16, 0.5, samples) + unbiased(3, more) +
          "WorldBegin\nAttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" + lights + "\nAttributeEnd\n" +
          media + kDarkFloor + "WorldEnd\n";
  return overSeeds(r, seeds);
}
std::string foggy(const std::string& weight, const std::string& more, const std::string& shape) {
  return volumeMaterial("\"color diffuseColor\" [0.9 0.8 0.7] \"float equiangularWeight\" [" + weight + "] " + more) +
         shape;
}
const char* const kFogBox = "Volume \"box\" [-3 3 -3 3 1 7] [0 0 0]\n";

TEST(MediaLights, DistancesThatSuitLightsChangeNoMean) {
  const std::string lamp = "Translate 0.4 0.3 4 Light \"PxrSphereLight\" \"l\" \"float intensity\" [20]\n",
                    sheet =
                        "Translate 0 2 4 Rotate -90 1 0 0 Scale 3 3 3 Light \"PxrRectLight\" \"l\" \"float "
                        "intensity\" [5]\n",
                    many =
                        "AttributeBegin Translate -0.3 -0.4 3 Scale .1 .1 .1 Light \"PxrSphereLight\" \"a\" \"float "
                        "intensity\" [900] AttributeEnd\nAttributeBegin Translate 0.3 0.4 5 Light \"PxrDiskLight\" "
                        "\"b\" \"float intensity\" [9] AttributeEnd\nLight \"PxrDomeLight\" \"d\" \"float "
                        "intensity\" [0.3]\n",
                    mesh =
                        "Light \"PxrMeshLight\" \"l\" \"float intensity\" [3] Polygon \"P\" [-2 0.7 2  2 0.7 2  2 "
                        "0.8 6  -2 0.8 6]\n";
  const std::string apart =
                        "\"int multiScatter\" [1] \"color densityColor\" [0.2 0.5 1.2] \"float anisotropy\" [0.4] ",
                    once = "\"color densityColor\" [0.4 0.4 0.4] ",
                    uneven = "\"int multiScatter\" [1] \"string densityFloatPrimVar\" [\"density\"] ";
  const std::string cells =
      "Volume \"box\" [-3 3 -3 3 1 7] [3 2 2] \"varying float density\" [0 1 2 0.3 0 2 0.5 1 0 1 0 0.7]\n";
  struct Case {
    const char* name;
    std::string lights, media, shape;
  };
  for (const Case& c : {Case{"lamp, channels apart", lamp, apart, kFogBox}, Case{"lamp, once", lamp, once, kFogBox},
                        Case{"sheet, uneven", sheet, uneven, cells},
                        Case{"many, channels apart", many, apart, kFogBox}, Case{"mesh, once", mesh, once, kFogBox},
                        Case{"lamp, overlapping", lamp, uneven,
                             cells + volumeMaterial(once) +
                                 "AttributeBegin Translate 0.2 0 4 Sphere 1 -1 1 360 "
                                 "AttributeEnd\n"}}) {
    SCOPED_TRACE(c.name);
    const auto without = litMedia(c.lights, foggy("0", c.media, c.shape), 128);
    for (const char* weight : {"0.5", "1"}) {
      SCOPED_TRACE(weight);
      const auto with = litMedia(c.lights, foggy(weight, c.media, c.shape), 64);
      EXPECT_SAME_MEAN(with, without, 0.03);
    }
  }
}

// Several places on each camera ray bring what one does, with less noise where lamps are near. Distances that extinction
// draws share with all of them.
TEST(MediaLights, MorePlacesOnCameraRaysChangeNoMean) {
  const std::string lamp = "Translate 0.4 0.3 4 Light \"PxrSphereLight\" \"l\" \"float intensity\" [20]\n",
                    sky = "Light \"PxrDomeLight\" \"d\" \"float intensity\" [0.3]\n" + lamp;
  const std::string once = "\"color densityColor\" [0.4 0.4 0.4] ",
                    uneven = "\"int multiScatter\" [1] \"string densityFloatPrimVar\" [\"density\"] ",
                    cells =
                        "Volume \"box\" [-3 3 -3 3 1 7] [3 2 2] \"varying float density\" [0 1 2 0.3 0 2 0.5 1 0 1 "
                        "0 0.7]\n",
                    five = "\"int numVolumeAggregateSamples\" [5]";
  for (const auto& [lights, media, shape] :
       {std::tuple(lamp, once, std::string(kFogBox)), std::tuple(sky, uneven, cells)}) {
    const auto one = litMedia(lights, foggy("0.5", media, shape), 32),
               more = litMedia(lights, foggy("0.5", media, shape), 32, 8, five);
    EXPECT_SAME_MEAN(more, one, 0.03);
  }
}

TEST(MediaLights, MorePlacesOnCameraRaysTakeNoiseFromBeams) {
  const auto variance = [](int places) {
    testing::Moments squares;
    image::Image pictures[2];
    for (uint32_t seed = 0; seed < 2; ++seed) {
      RenderRequest r;
      r.settings.seed = seed + 1;
      r.rib = orthographic(16, 0.5, 64) +
              unbiased(0, "\"int numVolumeAggregateSamples\" [" + std::to_string(places) + "]") +
              "WorldBegin\nAttributeBegin Attribute \"visibility\" \"int camera\" [0]\nTranslate 0.4 0.3 4 Light "
              "\"PxrSphereLight\" \"l\" \"float intensity\" [20]\nAttributeEnd\n" +
              foggy("0.5", "\"color densityColor\" [0.03 0.03 0.03] ", kFogBox) + "WorldEnd\n";
      SceneRender render(r);
      pictures[seed] = render.channel("Ci");
    }
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) {
        const double d = double(*pictures[0].at(x, y)) - double(*pictures[1].at(x, y));
        squares.add(d * d);
      }
    return squares.mean();
  };
  // five times the points where the lamp is near; 256 pixels tell a third from a half
  EXPECT_LT(variance(5), 0.5 * variance(1));
}

// Bodies in glass, and what the camera sees of a lamp, end rays before the media do.
TEST(MediaLights, DistancesThatSuitLightsKnowWhatIsInTheWay) {
  const auto mean = [](const char* weight) {
    RenderRequest r;
    r.rib =
        orthographic(16, 0.7, 256) + unbiased(4) +
        "WorldBegin\nAttributeBegin Translate 0.3 0.2 4 Scale .5 .5 .5 Light \"PxrSphereLight\" \"l\" \"float "
        "intensity\" [4] AttributeEnd\n"
        "Bxdf \"PxrSurface\" \"g\" \"float diffuseGain\" [0] \"float refractionGain\" [1] \"float reflectionGain\" "
        "[1] \"float glassRoughness\" [0] \"float glassIor\" [1.3]\nAttributeBegin Translate -0.4 0 5 Sphere 0.6 "
        "-0.6 0.6 360 AttributeEnd\n" +
        foggy(weight, "\"float densityFloat\" [0.5] \"int multiScatter\" [1] ", kFogBox) + "WorldEnd\n";
    return overSeeds(r, 8);
  };
  EXPECT_SAME_MEAN(mean("0.5"), mean("0"), 0.03);
}

// A ball that emits e by length, of radius R, lights a floor at distance h under it by 4 pi / 3 e R^3 / h^2: as its
// power from its centre would, for the integral over the cone of its chords is elementary.
TEST(MediaLights, GlowingBallsLightFloorsAsTheirPowerSays) {
  RenderRequest r;
  r.rib = orthographic(16, 0.02, 256) + unbiased(1) +
          "WorldBegin\nAttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" +
          volumeMaterial("\"float densityFloat\" [0] \"color emitColor\" [1 2 4]") +
          "Translate 0 0 2 Sphere 1 -1 1 360 AttributeEnd\nBxdf \"PxrDiffuse\" \"f\" \"color diffuseColor\" [0.5 0.5 "
          "0.5]\nPolygon \"P\" [-9 -9 5  9 -9 5  9 9 5  -9 9 5]\nWorldEnd\n";
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  for (const std::string& m : render.messages()) EXPECT_EQ(m.find("RENDER-NO-LIGHTS"), std::string::npos) << m;
  for (int c = 0; c < 3; ++c) {
    const double expected = 4. / 3 * 0.5 * (1 << c) / 9;
    EXPECT_MEAN(overPixels(render.channel("Ci"), c), expected, 0.01 * expected);
  }
}

// Found by chance alone (no light samples where the camera looks), and with samples: surfaces and media, in the fire
// and beside it; flames whose cells are partly empty; that move; two of them, with lamps.
TEST(MediaLights, FireIsFoundAlikeBySamplesAndByChance) {
  const std::string voxels =
      "[3 3 3] \"varying float heat\" [0 0 0 0 1 0 0 0 0  0 0 0 0 2 0.1 0 0 0  0 0 0 0 0.5 0 0 0 0] \"varying float "
      "density\" [0 0.2 0 0 0.1 0 0 1 0  0 0.2 0 0.4 0 0.1 0 0 0  0 0.3 0 2 0.5 0 0 0 0]";
  const std::string hot =
      "Pattern \"PxrPrimvar\" \"h\" \"string varname\" [\"heat\"] \"string type\" [\"float\"]\nPattern \"PxrMix\" "
      "\"e\" \"color color2\" [6 3 1] \"reference float mix\" [\"h:resultF\"]\n";
  const std::string fire = hot + volumeMaterial(
                                     "\"reference color emitColor\" [\"e:resultRGB\"] \"string densityFloatPrimVar\" "
                                     "[\"density\"] \"color diffuseColor\" [0.6 0.6 0.6] \"int multiScatter\" [1]");
  struct Case {
    const char* name;
    std::string media;
  };
  const std::string flame = "Volume \"box\" [-0.5 0.5 -0.5 0.5 3 4] " + voxels + "\n";
  for (const Case& c :
       {Case{"alone", fire + flame},
        Case{"moving", fire + "AttributeBegin MotionBegin [0 1] Translate 0 0 0 Translate 0.3 0.2 0 MotionEnd\n" +
                           flame + "AttributeEnd\n"},
        Case{"a ball",
             volumeMaterial("\"color emitColor\" [1 1 1] \"float densityFloat\" [0.5] \"int multiScatter\" [1]") +
                 "AttributeBegin Translate 0.2 0 3.5 Sphere 0.5 -0.5 0.5 360 AttributeEnd\n"},
        Case{"two, with a lamp, in fog",
             fire + "AttributeBegin Translate -0.5 0 0 Scale 0.8 1 1\n" + flame +
                 "AttributeEnd\nAttributeBegin Translate "
                 "0.7 0 0.5\n" +
                 flame +
                 "AttributeEnd\nAttributeBegin Attribute \"visibility\" \"int camera\" [0]\nTranslate 0 2 4 Light "
                 "\"PxrSphereLight\" \"l\" \"float intensity\" [3] AttributeEnd\n" +
                 foggy("0.5", "\"float densityFloat\" [0.3] \"int multiScatter\" [1]", kFogBox)}}) {
    SCOPED_TRACE(c.name);
    const auto mean = [&](int samples) {
      RenderRequest r;
      r.rib = orthographic(16, 0.8, samples ? 32 : 96) + "Shutter 0 1\n" +
              unbiased(2, "\"int numLightSamples\" [" + std::to_string(samples) + "]") + "WorldBegin\n" + c.media +
              kDarkFloor + "WorldEnd\n";
      return overSeeds(r, 6);
    };
    EXPECT_SAME_MEAN(mean(1), mean(0), 0.06);
  }
}

// A slab whose edge a constant velocity carries over the picture's middle during the shutter: what a pixel sees is the
// share of the time for which it is covered. By a constant, by a grid, by three grids; with the shutter open before and
// after the time of the grids.
// A ball under a flame: by samples of lights and by chance it is lit by what its linking says, once some list calls the
// flame by name; else by all that glows.
TEST(MediaLights, FireIsLinkedWhereItIsCalledByName) {
  const std::string flames =
      "AttributeBegin Attribute \"grouping\" \"string membership\" [\"flames\"]\nAttribute \"identifier\" \"string "
      "name\" "
      "[\"torch\"]\nAttribute \"visibility\" \"int camera\" [0]\n" +
      volumeMaterial("\"float densityFloat\" [0] \"color emitColor\" [1 1 1]") +
      "Volume \"box\" [-0.5 0.5 0.3 1 3 4] [0 0 0]\nAttributeEnd\n"
      "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\nTranslate 0 -9 4 Light \"PxrSphereLight\" "
      "\"lamp\" "
      "\"float intensity\" [0.001] AttributeEnd\n";
  const std::string calling =
      "AttributeBegin Attribute \"lighting\" \"string subset\" [\"flames\"]\nTranslate 50 0 4 Sphere 1 -1 1 360\n"
      "AttributeEnd\n";
  for (const int samples : {1, 0}) {
    const auto lit = [&](const std::string& linking, const std::string& others) {
      RenderRequest r;
      r.rib = orthographic(8, 0.3, samples ? 64 : 256) +
              unbiased(1, "\"int numLightSamples\" [" + std::to_string(samples) + "]") +
              "Translate 0 0.8 0\nWorldBegin\n" + flames + others + linking + kDarkFloor + "WorldEnd\n";
      SceneRender render(r);
      for (const std::string& m : render.messages()) ADD_FAILURE() << m;
      return render.ok() ? overPixels(render.channel("Ci")).mean() : -1;
    };
    SCOPED_TRACE(samples);
    const auto subset = [](const std::string& names, const char* which = "subset") {
      return std::string("Attribute \"lighting\" \"string ") + which + "\" [\"" + names + "\"]\n";
    };
    const double all = lit("", "");
    EXPECT_GT(all, 0.01);
    const double tolerance = 0.1 * all;  // the lamp is faint, and a noise of a few percent remains
    EXPECT_NEAR(lit(subset("lamp"), ""), all, tolerance) << "nobody calls it by name";
    EXPECT_NEAR(lit(subset("flames"), ""), all, tolerance);
    EXPECT_NEAR(lit(subset("lamp torch"), ""), all, tolerance);
    EXPECT_NEAR(lit("", calling), all, tolerance);
    EXPECT_NEAR(lit(subset("lamp"), calling), 0, 1e-3 * all);
    EXPECT_NEAR(lit(subset("flames", "excludesubset"), ""), 0, 1e-3 * all);
    EXPECT_NEAR(lit(subset("torch", "excludesubset"), ""), 0, 1e-3 * all);
  }
}

TEST(MediaLights, VelocitiesCarryGridsThroughTheShutter) {
  const std::string ones = " [2 1 1] \"varying float density\" [50 50]";
  for (const auto& [name, velocity, grids] : std::vector<std::array<std::string, 3>>{
           {"constant", "\"vector velocity\" [2 0 0]", ""},
           {"grid", "\"string velocityPrimVar\" [\"vel\"] \"float velocityMultiplier\" [2]",
            " \"varying vector vel\" [1 0 0 1 0 0]"},
           {"three grids", "\"string velocityPrimVar\" [\"vel\"] \"float velocityMultiplier\" [2]",
            " \"varying float vel.x\" [1 1]"}}) {
    for (const char* shutter : {"0 0.5", "-0.25 0.25"}) {
      SCOPED_TRACE(name + " " + shutter);
      RenderRequest r;
      r.rib =
          orthographic(32, 2, 32) + "Shutter " + shutter + "\n" + unbiased(1) +
          "WorldBegin\nLight \"PxrDomeLight\" \"s\" \"float intensity\" [1]\n" +
          volumeMaterial("\"color diffuseColor\" [0 0 0] \"string densityFloatPrimVar\" [\"density\"] " + velocity) +
          "Volume \"box\" [-1 0 -3 3 2 3]" + ones + grids + "\nWorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      for (const std::string& m : render.messages()) ADD_FAILURE() << m;
      const image::Image seen = render.channel("Ci");
      const bool isMiddle = shutter[0] == '-';
      for (int x = 0; x < seen.width(); ++x) {
        double sum = 0;
        for (int y = 0; y < seen.height(); ++y)
          sum += double(seen.pixels[size_t(y * seen.width() + x) * seen.channels.size()]);
        // the world's x of the pixel, and how much of the shutter it is clear for
        const double at = 4 * (x + 0.5) / seen.width() - 2, from = isMiddle ? -0.5 : 0;
        const auto clear = [&](double edge) { return std::clamp(edge, 0.0, 1.0); };
        // behind the slab's back edge (-1 moves), and before its front edge (0 moves)
        const double covered = clear((at + 1 - from) / 1.0) - clear((at - from) / 1.0);
        EXPECT_NEAR(sum / seen.height(), 1 - covered, 0.06) << "at " << at;
      }
    }
  }
}

TEST(MediaLights, VelocitiesThatAreNotThereOrTooLargeAreTold) {
  for (const auto& [velocity, isTold] : std::vector<std::pair<std::string, bool>>{
           {"\"string velocityPrimVar\" [\"wind\"]", true},
           {"\"vector velocity\" [1e9 0 0]", true},
           {"\"vector velocity\" [0.1 0 0]", false},
           {"\"vector velocity\" [1e9 0 0] \"float velocityMultiplier\" [0]", false}}) {
    RenderRequest r;
    r.rib = orthographic(8, 0.5, 4) + "Shutter 0 1\n" + unbiased(1) +
            "WorldBegin\nLight \"PxrDomeLight\" \"s\" \"float intensity\" [1]\n" +
            volumeMaterial("\"string densityFloatPrimVar\" [\"density\"] " + velocity) +
            "Volume \"box\" [-1 1 -1 1 2 3] [2 1 1] \"varying float density\" [1 2]\nWorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    bool wasTold = false;
    for (const std::string& m : render.messages()) wasTold |= m.find("MEDIUM-VELOCITY") != std::string::npos;
    EXPECT_EQ(wasTold, isTold) << velocity;
    const image::Image seen = render.channel("Ci");
    for (const float x : seen.pixels) EXPECT_TRUE(std::isfinite(x)) << velocity;
  }
}

// Multipliers of 1 are no approximation, bit for bit; a medium that grows thinner changes nothing of a furnace; less that
// each scattering brings is darker, down to what is scattered once.
TEST(MediaLights, SimilarityKeepsWhatItShould) {
  const auto picture = [](const std::string& more, int bounces, const char* albedo = "[1 1 1]") {
    RenderRequest r;
    r.rib = orthographic(16, 0.5, 48) + unbiased(bounces) +
            "WorldBegin\nLight \"PxrDomeLight\" \"s\" \"float intensity\" [1]\n" +
            volumeMaterial("\"color diffuseColor\" " + std::string(albedo) +
                           " \"float densityFloat\" [3] \"int multiScatter\" [1] " + more) +
            "AttributeBegin Translate 0 0 5 Sphere 1 -1 1 360 AttributeEnd\nWorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    return render.channel("Ci");
  };
  const std::string by = "\"int multiScatterOpt\" [1] \"float extinctionMultiplier\" [0.5] ";
  EXPECT_EQ(picture("", 40).pixels, picture("\"int multiScatterOpt\" [1]", 40).pixels);
  EXPECT_EQ(picture("", 40).pixels, picture("\"float extinctionMultiplier\" [0.2]", 40).pixels);
  const auto exact = overPixels(picture("", 200)), thinner = overPixels(picture(by, 200));
  EXPECT_MEAN(exact, 1, 0.02);
  EXPECT_MEAN(thinner, 1, 0.02);
  // darker by what further scatterings would have brought, never brighter
  const auto bringing = [&](const char* share) {
    return overPixels(
        picture("\"int multiScatterOpt\" [1] \"float contributionMultiplier\" [" + std::string(share) + "]", 200));
  };
  const auto less = bringing("0.5"), none = bringing("0"),
             once = overPixels(picture("\"int multiScatter\" [0]", 200));
  EXPECT_LT(less.mean(), exact.mean() - 0.05);
  EXPECT_LT(none.mean(), less.mean() - 0.05);
  EXPECT_NEAR(none.mean(), once.mean(), 4 * (none.standardError() + once.standardError()));
}

// A medium that holds out lets its background through as one that absorbs does, and is as clear as that in alpha: with
// a lamp near, which would light it, and what it emits.
TEST(MediaLights, HoldoutsAreBlackAndClear) {
  const auto render = [](const std::string& attributes, const std::string& material, const char* channel) {
    RenderRequest r;
    r.rib =
        orthographic(24, 0.5, 256) + unbiased(1) +
        "WorldBegin\nAttributeBegin Attribute \"visibility\" \"int camera\" [0]\nTranslate 0 0 2.5 Light "
        "\"PxrSphereLight\" \"l\" \"float intensity\" [3] AttributeEnd\nAttributeBegin\n" +
        attributes + volumeMaterial(material + " \"float densityFloat\" [0.5]") +
        "Volume \"box\" [-3 3 -3 3 2 3.5] [0 0 0]\nAttributeEnd\nBxdf \"PxrConstant\" \"wall\" \"color emitColor\" "
        "[1 1 1]\nPolygon \"P\" [-9 -9 5  9 -9 5  9 9 5  -9 9 5]\nWorldEnd\n";
    SceneRender made(r);
    EXPECT_TRUE(made.ok());
    return overPixels(made.channel(channel));
  };
  const std::string hole = "Attribute \"trace\" \"int holdout\" [1]\n", glowing = "\"color emitColor\" [1 1 1] ";
  EXPECT_GT(render("", "", "Ci").mean(), std::exp(-0.75) + 0.1);
  EXPECT_MEAN(render(hole, glowing, "Ci"), std::exp(-0.75), 0.01);
  EXPECT_MEAN(render(hole, glowing, "a"), std::exp(-0.75), 0.01);
}

}  // namespace
}  // namespace kinora::tests
