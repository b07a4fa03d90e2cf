// Volumes that surfaces have inside (volumeAggregateName), cut off where these end, against closed forms: what chords of
// balls and boxes let through to the camera and to shadows, from outside and for a camera inside; surfaces in each
// other, overlapping, mirrored, in instances and on their way; which rays see the surface; media that are uneven or
// emit against the same in an object of the surface's shape. Pictures are the same bits for all widths, threads and
// groups. Misses: integrators but the path tracer (tests/probes/aggregates_test.cpp).
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

constexpr const char* kSky = "Light \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\n";

// Clear, and nothing is bent or reflected.
std::string glass(const std::string& names, const std::string& more = "") {
  return "Bxdf \"PxrSurface\" \"g\" \"float diffuseGain\" [0] \"float refractionGain\" [1] \"float glassRoughness\" "
         "[0] "
         "\"float glassIor\" [1] \"string volumeAggregateName\" [\"" +
         names + "\"] " + more + "\n";
}
std::string block(const std::string& attributes, const std::string& body) {
  return "AttributeBegin\n" + attributes + body + "AttributeEnd\n";
}
// A box far larger than all that stands in it, from z = -9 to 9, in an aggregate.
std::string fog(const std::string& aggregate, const std::string& material) {
  return block("Attribute \"volume\" \"string aggregate\" [\"" + aggregate + "\"]\n",
               "Bxdf \"PxrVolume\" \"m\" " + material + "\nVolume \"box\" [-8 8 -8 8 -9 9] [0 0 0]\n");
}
std::string dark(double extinction) {
  return "\"color diffuseColor\" [0 0 0] \"float densityFloat\" [" + std::to_string(extinction) + "]";
}
// A closed box of polygons from x = y = -2 to 2.
std::string slab(double from, double to) {
  const std::string a = std::to_string(from), b = std::to_string(to);
  return "PointsPolygons [4 4 4 4 4 4] [0 1 2 3  7 6 5 4  0 4 5 1  1 5 6 2  2 6 7 3  3 7 4 0]\n\"vertex point P\" "
         "[-2 -2 " +
         a + " 2 -2 " + a + " 2 2 " + a + " -2 2 " + a + " -2 -2 " + b + " 2 -2 " + b + " 2 2 " + b + " -2 2 " + b +
         "]\n";
}

image::Image picture(const std::string& rib) {
  return pictureTold(rib, {"MEDIUM-AGGREGATE", "MEDIUM-LEFT-OUT", "MEDIUM-BOUND"});  // pictures without the volumes
}
// The sky through what stands before a camera at the origin that looks along z.
std::string through(const std::string& things, int samples = 64) {
  return orthographic(32, 0.4, samples) + unbiased(8) + "WorldBegin\n" + kSky + things + "WorldEnd\n";
}
// A white floor that the camera sees through nothing, and the sun through what only light sees: glass lets shadows through.
image::Image floorInTheSun(const std::string& between, const std::string& before = "") {
  return picture(orthographic(32, 0.5, 4) + before +
                 "Integrator \"PxrPathTracer\" \"i\" \"int maxIndirectBounces\" [0] \"int allowCaustics\" [0]\n"
                 "WorldBegin\nAttributeBegin\nLight \"PxrDistantLight\" \"sun\" \"float intensity\" [1] "
                 "\"float angleExtent\" [0]\nAttributeEnd\n" +
                 block("Attribute \"visibility\" \"int camera\" [0]\n", between) +
                 "Bxdf \"PxrDiffuse\" \"floor\" \"color diffuseColor\" [1 1 1]\n"
                 "Polygon \"P\" [-9 -9 8  9 -9 8  9 9 8  -9 9 8]\nWorldEnd\n");
}
// By the same without a medium: what that lets through.
double shadowOf(const std::string& surfaces, const std::string& fogs) {
  return overPixels(floorInTheSun(surfaces + fogs)).mean() / overPixels(floorInTheSun(surfaces)).mean();
}

TEST(Interiors, CutOffWhatTheCameraSeesThrough) {
  // the fog before and behind the surface is not there
  const std::string in = glass("mist"), mist = fog("mist", dark(0.7));
  EXPECT_MEAN(overPixels(picture(through(block(in, slab(4, 5.5)) + mist))), std::exp(-1.5 * 0.7), 0.006);
  // of a box that ends within the surface there is what both have in common
  EXPECT_MEAN(overPixels(picture(through(block(in, slab(6, 12)) + mist))), std::exp(-3 * 0.7), 0.006);
  // chords of a ball
  const image::Image ball = picture(through(block(in, "Translate 0 0 5\nSphere 1.2 -1.2 1.2 360\n") + mist, 256));
  double expected = 0;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const double u = 0.4 * ((x + 0.5) / 32 - 1), v = 0.4 * ((y + 0.5) / 32 - 1);
      expected += std::exp(-0.7 * 2 * std::sqrt(1.44 - u * u - v * v)) / (64 * 64);
    }
  EXPECT_MEAN(overPixels(ball), expected, 0.004);
  // nothing is cut off without the name, and there is nothing without a surface
  EXPECT_MEAN(overPixels(picture(through(block(glass(""), slab(4, 5.5)) + fog("globalVolumeAggregate", dark(0.2))))),
              std::exp(-9 * 0.2), 0.006);
}

TEST(Interiors, CutOffShadows) {
  const std::string mist = fog("mist", dark(0.7));
  EXPECT_NEAR(shadowOf(block(glass("mist"), slab(4, 5.5)), mist), std::exp(-1.5 * 0.7), 2e-5);
  // with fog that is everywhere beside it, and with media that are tracked
  EXPECT_NEAR(shadowOf(block(glass("mist"), slab(4, 5.5)), mist + fog("globalVolumeAggregate", dark(0.05))) /
                  shadowOf(block(glass("mist"), slab(4, 5.5)), fog("globalVolumeAggregate", dark(0.05))),
              std::exp(-1.5 * 0.7), 2e-5);
  const std::string uneven = block("Attribute \"volume\" \"string aggregate\" [\"mist\"]\n",
                                   "Bxdf \"PxrVolume\" \"m\" \"color diffuseColor\" [0 0 0] \"string "
                                   "densityFloatPrimVar\" [\"density\"]\nVolume \"box\" [-8 8 -8 8 0 8] [1 1 2] "
                                   "\"varying float density\" [0 1]\n");
  // voxels stand at the ends of the bound: a ramp from 0 to 1, or its filter's steps; either is seen from the whole
  const double ramp = -std::log(overPixels(floorInTheSun(uneven + block(glass("mist"), slab(-1, 7.9)))).mean() /
                                overPixels(floorInTheSun(block(glass("mist"), slab(-1, 7.9)))).mean()),
               half[2] = {-std::log(shadowOf(block(glass("mist"), slab(-1, 4)), uneven)),
                          -std::log(shadowOf(block(glass("mist"), slab(4, 7.9)), uneven))};
  EXPECT_NEAR(half[0] + half[1], ramp, 0.02 * ramp);
  EXPECT_LT(half[0], 0.7 * half[1]);
  // pixel by pixel under a ball
  const image::Image bare = floorInTheSun(block(glass("mist"), "Translate 0 0 5\nSphere 1.2 -1.2 1.2 360\n")),
                     seen = floorInTheSun(block(glass("mist"), "Translate 0 0 5\nSphere 1.2 -1.2 1.2 360\n") + mist);
  for (int y = 0; y < 32; y += 5)
    for (int x = 0; x < 32; x += 5) {
      const double u = 0.5 * ((x + 0.5) / 16 - 1), v = 0.5 * ((y + 0.5) / 16 - 1),
                   expected = std::exp(-0.7 * 2 * std::sqrt(1.44 - u * u - v * v));
      EXPECT_NEAR(double(seen.at(x, y)[0]) / double(bare.at(x, y)[0]), expected, 0.01 * expected);
    }
}

TEST(Interiors, SurroundWhoBeginsInside) {
  const std::string mist = fog("mist", dark(0.7));
  EXPECT_MEAN(overPixels(picture(through(block(glass("mist"), slab(-1, 1.5)) + mist))), std::exp(-1.5 * 0.7), 0.006);
  // and again where the way goes on into another
  EXPECT_MEAN(overPixels(picture(through(block(glass("mist"), slab(-1, 1.5) + slab(3, 3.5)) + mist))),
              std::exp(-2 * 0.7), 0.006);
  // behind the camera there is one more, which it does not see
  EXPECT_MEAN(overPixels(picture(through(block(glass("mist"), slab(-3, -1) + slab(3, 3.5)) + mist))),
              std::exp(-0.5 * 0.7), 0.006);
}

TEST(Interiors, OfSurfacesInEachOther) {
  const std::string fogs = fog("a", dark(0.3)) + fog("b", dark(0.8)), both = fog("a b", dark(0.3));
  const auto around = [](const char* names, double from, double to) { return block(glass(names), slab(from, to)); };
  // each its own
  EXPECT_NEAR(shadowOf(around("a", 2, 6) + around("b", 3, 4.5), fogs), std::exp(-(4 * 0.3 + 1.5 * 0.8)), 2e-5);
  // what both ask for is there once; overlapping ones have it wherever one is
  EXPECT_NEAR(shadowOf(around("a", 2, 6) + around("a", 3, 4.5), fogs), std::exp(-4 * 0.3), 2e-5);
  EXPECT_NEAR(shadowOf(around("a", 2, 4) + around("a", 3, 5), fogs), std::exp(-3 * 0.3), 2e-5);
  EXPECT_NEAR(shadowOf(block(glass("a"), slab(2, 4) + slab(3, 5)), fogs), std::exp(-3 * 0.3), 2e-5);
  // one surface has several aggregates, and a volume is in several
  EXPECT_NEAR(shadowOf(around("a b", 2, 6), fogs), std::exp(-4 * 1.1), 2e-5);
  EXPECT_NEAR(shadowOf(around("a", 2, 4) + around("b", 3, 6), both), std::exp(-4 * 0.3), 2e-5);
  // to the camera as well
  EXPECT_MEAN(overPixels(picture(through(around("a", 2, 6) + around("b", 3, 4.5) + fogs))),
              std::exp(-(4 * 0.3 + 1.5 * 0.8)), 0.006);
}

// A mesh that passes through itself: two boxes in one.
TEST(Interiors, OfOneMeshInTwoParts) {
  const std::string two =
      "PointsPolygons [4 4 4 4 4 4 4 4 4 4 4 4] [0 1 2 3 7 6 5 4 0 4 5 1 1 5 6 2 2 6 7 3 3 7 4 0 "
      "8 9 10 11 15 14 13 12 8 12 13 9 9 13 14 10 10 14 15 11 11 15 12 8]\n\"vertex point P\" ["
      "-2 -2 2 2 -2 2 2 2 2 -2 2 2 -2 -2 4 2 -2 4 2 2 4 -2 2 4 "
      "-2 -2 3 2 -2 3 2 2 3 -2 2 3 -2 -2 5 2 -2 5 2 2 5 -2 2 5]\n";
  EXPECT_NEAR(shadowOf(block(glass("mist"), two), fog("mist", dark(0.3))), std::exp(-3 * 0.3), 2e-5);
}

TEST(Interiors, OfMirroredOnesAndInstances) {
  const std::string mist = fog("mist", dark(0.7));
  const double expected = std::exp(-1.5 * 0.7);
  for (const char* before : {"Scale 1 1 -1\nTranslate 0 0 -9.5\n", "ReverseOrientation\n", "Sides 1\nScale -1 2 1\n"})
    EXPECT_NEAR(shadowOf(block(glass("mist") + before, slab(4, 5.5)), mist), expected, 2e-5) << before;
  EXPECT_NEAR(shadowOf("ObjectBegin \"o\"\n" + glass("mist") + slab(1, 1.5) +
                           "ObjectEnd\nAttributeBegin\nScale 1 1 2\nObjectInstance \"o\"\nAttributeEnd\n"
                           "AttributeBegin\nTranslate 0 0 3\nObjectInstance \"o\"\nAttributeEnd\n",
                       mist),
              expected, 2e-5);
  // of a material that the instance gives
  EXPECT_NEAR(
      shadowOf("ObjectBegin \"o\"\n" + slab(1, 2.5) + "ObjectEnd\n" + glass("mist") + "ObjectInstance \"o\"\n", mist),
      expected, 2e-5);
}

TEST(Interiors, MoveWithTheirSurface) {
  // half of the time it stands beside the floor's part that is seen
  const std::string shutter = "Shutter 0 1\n", moving =
                                                   "MotionBegin [0 0.5 0.52 1]\nTranslate 0 0 0\nTranslate 0 0 "
                                                   "0\nTranslate 40 0 0\nTranslate 40 0 0\nMotionEnd\n";
  const std::string box = block(glass("mist") + moving, slab(4, 5.5));
  const auto bare = overPixels(floorInTheSun(box, shutter)),
             seen = overPixels(floorInTheSun(box + fog("mist", dark(0.7)), shutter));
  EXPECT_NEAR(seen.mean() / bare.mean(), 0.5 + 0.5 * std::exp(-1.5 * 0.7), 0.02);
}

// Rays that do not see the surface never enter it.
TEST(Interiors, AreOfRaysThatSeeTheSurface) {
  const std::string mist = fog("mist", dark(0.7));
  const auto seenBy = [](const char* kind, int value) {
    return std::string("Attribute \"visibility\" \"int ") + kind + "\" [" + std::to_string(value) + "]\n";
  };
  EXPECT_NEAR(overPixels(picture(through(block(seenBy("camera", 0) + glass("mist"), slab(4, 5.5)) + mist))).mean(), 1,
              1e-5);
  EXPECT_NEAR(shadowOf(block(seenBy("transmission", 0) + glass("mist"), slab(4, 5.5)), mist), 1, 1e-5);
  // and the volume has its own say
  EXPECT_NEAR(shadowOf(block(glass("mist"), slab(4, 5.5)), block(seenBy("transmission", 0), mist)), 1, 1e-5);
}

// What integrators ask for too is everywhere, for the rays that they ask with.
TEST(Interiors, AreNoBoundsOfWhatIsEverywhere) {
  const auto asked = [](const char* parameter) {
    return orthographic(32, 0.4, 64) + unbiased(8, std::string("\"string ") + parameter + "\" [\"mist\"]") +
           "WorldBegin\n" + kSky + block(glass("mist"), slab(4, 5.5)) + fog("mist", dark(0.2)) + "WorldEnd\n";
  };
  EXPECT_MEAN(overPixels(picture(asked("volumeAggregateTransmission"))), std::exp(-1.5 * 0.2), 0.006);
  EXPECT_MEAN(overPixels(picture(asked("volumeAggregate"))), std::exp(-9 * 0.2), 0.006);
  // the camera knows of it up to the glass, and rays that the glass lets go on inside of that
  EXPECT_MEAN(overPixels(picture(asked("volumeAggregateCamera"))), std::exp(-5.5 * 0.2), 0.006);
}

// Bright, uneven, scattering often: as in an object of the surface's shape.
TEST(Interiors, AreAsMediaOfTheSurfacesShape) {
  const std::string pattern =
      "Pattern \"PxrFractal\" \"n\" \"float frequency\" [2] \"int layers\" [1]\nPattern \"PxrToFloat3\" \"c\" "
      "\"reference float input\" [\"n:resultF\"]\n";
  const std::string material =
      std::string(
          "Bxdf \"PxrVolume\" \"m\" \"reference float densityFloat\" [\"n:resultF\"] \"color densityColor\" [2 3 "
          "4] \"color diffuseColor\" [.9 .9 .8] \"int multiScatter\" [1] \"float maxDensity\" [6]") +
      " \"reference color emitColor\" [\"c:resultRGB\"]\n";
  const std::string clear = glass("mist", "\"float glassIor\" [1.3] \"float reflectionGain\" [1]");
  const std::string shape = "Sphere 0.9 -0.9 0.9 360\n", place = "Translate 0 0 4\n";
  const auto scene = [&](const std::string& volume) {
    return orthographic(12, 1.4, 24) + unbiased(3) + "WorldBegin\n" + kSky + block(place + clear, shape) +
           block(place + "Attribute \"volume\" \"string aggregate\" [\"mist\"]\n" + pattern + material, volume) +
           "Bxdf \"PxrDiffuse\" \"floor\"\nPolygon \"P\" [-9 -9 5.5  9 -9 5.5  9 9 5.5  -9 9 5.5]\nWorldEnd\n";
  };
  const image::Image cut = picture(scene("Volume \"box\" [-1.5 1.5 -1.5 1.5 -1.5 1.5] [0 0 0]\n")),
                     alone = picture(scene(shape));
  testing::Moments difference;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x) difference.add(double(cut.at(x, y)[2]) - double(alone.at(x, y)[2]));
  const double mean = overPixels(alone, 2).mean();
  EXPECT_GT(mean, 0.01);
  EXPECT_LT(difference.standardError(), 0.05 * mean);
  EXPECT_LT(std::fabs(difference.mean()), 4 * difference.standardError()) << "of " << mean;
}

TEST(Interiors, AreTheSameBitsHoweverTheyAreRendered) {
  RenderRequest r;
  r.rib =
      "Format 24 24 1\nPixelFilter \"box\" 1 1\nProjection \"perspective\" \"fov\" [60]\nHider \"raytrace\" \"int "
      "maxsamples\" [8]\n" +
      unbiased(4) + "WorldBegin\n" + kSky +
      block(glass("a", "\"float glassIor\" [1.3] \"float reflectionGain\" [1]") + "Translate 0.3 0 4\n",
            "Sphere 1.3 -1.3 1.3 360\n") +
      block(glass("b a") + "Translate -0.8 0.2 3.6\nRotate 40 1 1 0\nScale .3 .3 .3\n", slab(-2, 2)) +
      fog("a", "\"float densityFloat\" [.4] \"int multiScatter\" [1]") +
      fog("b", "\"color densityColor\" [.3 .6 1.4] \"color emitColor\" [.1 .05 0]") +
      fog("globalVolumeAggregate", "\"float densityFloat\" [.03]") +
      "Bxdf \"PxrDiffuse\" \"floor\"\nPolygon \"P\" [-9 -1.2 -9  -9 -1.2 9  9 -1.2 9  9 -1.2 -9]\nWorldEnd\n";
  EXPECT_NE(hashHoweverRendered(r), 0u);
}

TEST(Interiors, NeedASurfaceThatEnclosesSomething) {
  const auto said = [](const std::string& things) {
    RenderRequest r;
    r.rib = through(things + fog("mist", dark(0.7)), 1);
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    std::string all;
    for (const std::string& m : render.messages()) all += m + "\n";
    return std::pair(all, render.ok() ? overPixels(render.channel("Ci")).mean() : 0.);
  };
  // what encloses nothing asks for nothing
  for (const char* more : {"\"int thinGlass\" [1]", "\"float refractionGain\" [0]"}) {
    const auto [text, mean] = said(block(glass("mist", more), slab(4, 5.5)));
    EXPECT_NE(text.find("MEDIUM-LEFT-OUT"), std::string::npos) << text;
  }
  const auto [curves, none] = said(
      block(glass("mist"), "Curves \"linear\" [2] \"nonperiodic\" \"P\" [-1 0 5 1 0 5] \"constantwidth\" [.1]\n"));
  EXPECT_NE(curves.find("MEDIUM-OPEN"), std::string::npos) << curves;
  EXPECT_NEAR(none, 1, 1e-3);
  // an open surface, which is told of once: nobody is inside for ever
  const std::string pane = "Polygon \"P\" [-2 -2 4  2 -2 4  2 2 4  -2 2 4]\n";
  const auto [open, all] = said(block(glass("mist"), pane + "ReverseOrientation\n" + pane));
  EXPECT_NE(open.find("MEDIUM-OPEN"), std::string::npos) << open;
  EXPECT_GT(all, 0);
  const auto [solid, clear] = said("SolidBegin \"primitive\"\n" + block(glass("mist"), slab(4, 5.5)) + "SolidEnd\n");
  EXPECT_NE(solid.find("MEDIUM-SOLID"), std::string::npos) << solid;
  EXPECT_NEAR(clear, 1, 1e-3);
}

}  // namespace
}  // namespace kinora::tests
