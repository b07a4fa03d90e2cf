// PxrVCM against PxrPathTracer: equal means in rooms with every kind of light, glass, motion and a lens, for the
// picture and for channels by path, with each set of techniques; what merging blurs is taken away by extrapolation to
// a radius of 0. Equal bits for threads, widths, groups and splits. Caustics that only light paths find.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "film/splat_filter.h"
#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

TEST(Vcm, EqualsPathTracerUnderPointAndSun) { expectSamePicture(room(std::string(kPoint) + kSun, kGrey), 0.03); }
TEST(Vcm, EqualsPathTracerUnderAreaLights) { expectSamePicture(room(std::string(kRect) + kSphere, kGrey), 0.03); }
TEST(Vcm, EqualsPathTracerUnderDome) { expectSamePicture(room(kDome, kGrey), 0.03); }
TEST(Vcm, EqualsPathTracerUnderMeshLight) { expectSamePicture(room(kMesh, kGrey), 0.03); }
TEST(Vcm, EqualsPathTracerBehindGlass) {
  expectSamePicture(roomBehindGlass(), 0.04, 100);  // paths through the balls to the lamp by chance have long tails
}
TEST(Vcm, EqualsPathTracerInMotionThroughALens) { expectSamePicture(roomInMotionThroughALens(), 0.03); }

// Lights that the camera sees, factors of lights on lobes, objects hidden from the camera, a wide pixel filter.
TEST(Vcm, ObeysVisibilityFactorsAndPixelFilter) {
  std::string text = room(std::string(kRect) + kSphere, kGrey, "", R"(
  AttributeBegin
    Attribute "visibility" "int camera" [0]
    Bxdf "PxrDiffuse" "hidden" "color diffuseColor" [0.9 0.2 0.1]
    Polygon "vertex point P" [-0.4 0.2 0.2  0.2 0.2 0.2  0.2 0.7 0.2  -0.4 0.7 0.2]
  AttributeEnd
)");
  const auto replace = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
  };
  replace("PixelFilter \"box\" 1 1", "PixelFilter \"gaussian\" 3 3");
  replace("\"PxrSphereLight\" \"bulb\"",
          "\"PxrSphereLight\" \"bulb\" \"float diffuse\" [0.4] \"float specular\" [1.5]");
  replace("Attribute \"visibility\" \"int camera\" [0]", "Attribute \"visibility\" \"int camera\" [1]");
  expectSamePicture(text, 0.05, 80);
}

// What stands before the near plane or beyond another hides nothing from the camera, though light falls on it; camera
// rays begin at the plane, and the weights of both ways to make a path are by the lens.
TEST(Vcm, ObeysClippingPlanes) {
  const std::string text = room(std::string(kSphere) + kPoint, kGrey,
                                std::string(kLens) + "Clipping 3.6 5\nClippingPlane 0.9 0 0  1 0 0\n", R"(
  AttributeBegin
    Bxdf "PxrDiffuse" "screen" "color diffuseColor" [0.9 0.2 0.1]
    Polygon "vertex point P" [-1.2 -0.2 -1  0.6 -0.2 -1  0.6 0.9 -1  -1.2 0.9 -1]
  AttributeEnd
)");
  expectSamePicture(text, 0.06);
  // the screen would be seen, were it not cut away
  Workshop stage;
  std::string uncut = text;
  uncut.replace(uncut.find("Clipping 3.6"), 12, "Clipping 0.1");
  const double seen = renderAll(stage, text, pathTracer(1), 1, 4).at("Ci").mean(),
               hidden = renderAll(stage, uncut, pathTracer(1), 1, 4).at("Ci").mean();
  EXPECT_GT(std::abs(seen - hidden), 0.1 * seen);
}

// The underside of a plate, far from the camera, under which light from a wide floor gathers: connections that come to the
// floor at low angles. Rays start off the surface by more the farther it is from the camera, and met the floor before their end.
TEST(Vcm, ConnectsToWhatIsSeenAtLowAnglesFromAfar) {
  const std::string text = std::string(kShown) + R"(ScreenWindow -0.0175 0.0175 0.0825 0.1175
Projection "perspective" "fov" [90]
WorldBegin
  AttributeBegin
    Translate 0.2 3.2 3.5
    Light "PointLight" "lamp" "float intensity" [30] "string lightGroup" ["key"]
  AttributeEnd
  Bxdf "PxrDiffuse" "floor" "color diffuseColor" [0.5 0.5 0.5]
  Polygon "vertex point P" [-4 -0.3 0.5  4 -0.3 0.5  4 -0.3 8.5  -4 -0.3 8.5]
  AttributeBegin
    Attribute "identifier" "string lpegroup" ["ball"]
    Bxdf "PxrDiffuse" "plate" "color diffuseColor" [0.6 0.6 0.6]
    Polygon "vertex point P" [-0.5 0.5 4.5  0.5 0.5 4.5  0.5 0.5 5.5  -0.5 0.5 5.5]
  AttributeEnd
WorldEnd
)";
  Workshop stage;
  const Pictures reference = renderAll(stage, text, pathTracer(1), 1000);
  EXPECT_GT(reference.at("ball").mean(), 0.01) << stage.said;
  expectEqual(renderAll(stage, text, vcm(true, false, 5, 1), 2000), reference, "connections", 0.05);
}

TEST(Vcm, SameBits) { expectSameBits({}, roomOfEverything(), "PxrVCM"); }
// More vertices at a point than are evaluated together: which of them are summed first does not depend on the points
// that were looked up with it.
TEST(Vcm, SameBitsWhereManyAreMerged) {
  const std::string spot = R"(
    AttributeBegin
      ConcatTransform [0.1 0 0 0  0 0 0.1 0  0 -1 0 0  -0.3 1.9 0.6 1]
      Light "PxrRectLight" "lamp" "float intensity" [600] "float emissionFocus" [300] "string lightGroup" ["key"]
    AttributeEnd)";
  expectSameBits({}, room(spot, kGrey), "PxrVCM");
}
// What fibres are asked when a vertex is connected, they have not been asked before.
TEST(Vcm, SameBitsOfHair) {
  expectSameBits({}, room(kRect, "Bxdf \"PxrMarschnerHair\" \"hair\" \"float diffuseGain\" [0.8]\n", kLens),
                 "PxrVCM");
}

// Points of fibres stand on their axes, lines of which a disk of merging holds too much or too little.
TEST(Vcm, FibresAreNotMerged) {
  for (const char* hair : {"PxrMarschnerHair", "LamaHairChiang"}) {
    Workshop stage;
    const std::string text = kShown + std::string(R"(
Projection "orthographic"
ScreenWindow -1 1 -1 1
Translate 0 0 5
WorldBegin
AttributeBegin
  Rotate 30 1 0 0
  Rotate 20 0 1 0
  Light "PxrDistantLight" "sun" "float angleExtent" [40] "float intensity" [5]
AttributeEnd
Bxdf ")") + hair + R"(" "hair"
Curves "linear" [2] "nonperiodic" "P" [-3 0 0  3 0 0] "constantwidth" [1]
WorldEnd
)";
    const double mean = renderAll(stage, text, pathTracer(), 1000, 8).at("Ci").mean();
    EXPECT_GT(mean, 1e-3) << stage.said;
    EXPECT_NEAR(renderAll(stage, text, vcm(true, true), 2000, 8).at("Ci").mean(), mean, 0.04 * mean) << hair;
  }
}

// Light as if nothing were in its way, and what is missing of it, as in the path tracer.
TEST(Vcm, UnshadowedChannelsAreThePathTracers) {
  std::string text = room(kSphere, kGrey);
  const std::string list = "\"Ci,a,indirect,ball,key\"";
  text.replace(text.find(list), list.size(),
               "\"Ci,a,indirect,ball,key\"\n"
               "DisplayChannel \"color ball\" \"string source\" [\"lpe:unoccluded;C[DS]+L\"]\n"
               "DisplayChannel \"color key\" \"string source\" [\"lpe:shadows;C[DS]+L\"]");
  for (const char* old : {"DisplayChannel \"color ball\" \"string source\" [\"lpe:C.*<.[DS]'ball'>.*L\"]\n",
                          "DisplayChannel \"color key\" \"string source\" [\"lpe:C.+<L.'key'>\"]\n"})
    text.replace(text.find(old), std::string(old).size(), "");
  Workshop stage;
  const Pictures reference = renderAll(stage, text, pathTracer(), 1000);
  EXPECT_GT(reference.at("key").mean(), 0.005 * reference.at("ball").mean()) << "nothing is in shadow";
  expectEqual(renderAll(stage, text, vcm(true, false), 2000), reference, "connections", 0.05);
}

// Bounces are counted as the path tracer counts them: direct light at what the camera sees is the first.
TEST(Vcm, ClampsFromTheSameBounceAsThePathTracer) {
  const std::string text = room(kPoint, kGrey);
  const auto meanOf = [&](Method m, int clampDepth, const char* luminance) {
    for (auto& [name, value] : m.sets)
      if (name == "integrator.clampLuminance") value = luminance;
    m.sets.emplace_back("integrator.clampDepth", std::to_string(clampDepth));
    Workshop stage;
    return renderAll(stage, text, m, 1, 2).at("Ci").mean();
  };
  for (const bool isForward : {true, false}) {
    const Method direct = isForward ? pathTracer(0) : vcm(false, false, 5, 0);
    const double free = meanOf(direct, 2, "1e30");
    EXPECT_EQ(meanOf(direct, 2, "1e-4"), free) << direct.integrator;
    EXPECT_LT(meanOf(direct, 1, "1e-4"), 0.01 * free) << direct.integrator;
    const Method indirect = isForward ? pathTracer(1) : vcm(false, false, 5, 1);
    EXPECT_GT(meanOf(indirect, 3, "1e-4"), 1.01 * free) << indirect.integrator;
    EXPECT_LT(meanOf(indirect, 2, "1e-4"), 1.001 * free) << indirect.integrator;
  }
  // connections and merges of more than one bounce
  EXPECT_LT(meanOf(vcm(true, true, 5, 3), 2, "1e-7"), 1.001 * meanOf(vcm(true, true, 5, 0), 2, "1e30"));
}

// What light paths take of the integrator's time is counted: it was less than nothing, and shown as 0.
TEST(Vcm, TimeOfLightPathsIsTheIntegratorsToo) {
  Workshop stage;
  render::Settings s;
  s.threads = 1;
  s.integrator = "PxrVCM";
  s.sets = vcm(true, false).sets;
  const auto r = stage.load(sceneOf(room(kRect, kGrey), stage.messages), s);
  ASSERT_EQ(r->renderFilm(), render::Outcome::Complete);
  const render::Statistics t = r->statistics();
  EXPECT_GT(t.stageNanoseconds[size_t(render::StageTime::Integrator)], 0u);
}

// Nothing to begin a light path with, nothing to merge: black and done.
TEST(Vcm, RendersRoomsWithoutLight) {
  Workshop stage;
  Method m = vcm(true, true, 0);
  m.sets.emplace_back("integrator.numLightSamples", "0");
  const Pictures black = renderAll(stage, room("", kGrey), m, 1, 2);
  EXPECT_EQ(black.at("Ci").mean(), 0);
  const Pictures lit = renderAll(stage, room(kRect, kGrey), m, 1, 2);
  EXPECT_GT(lit.at("Ci").mean(), 0.01);
}

// Radii that cannot be are told and moved to where they can; one as large as the scene merges whatever there is.
TEST(Vcm, RadiiOutsideTheirRangeAreTold) {
  const std::string text = room(std::string(kRect) + kPoint, kGrey);
  const auto filmWith = [&](const char* parameter, const char* value, std::string* said) {
    Workshop stage;
    render::Settings s;
    s.threads = 2;
    s.integrator = "PxrVCM";
    s.sets = vcm(true, true).sets;
    s.sets.emplace_back(std::string("integrator.") + parameter, value);
    const auto r = stage.load(sceneOf(text, stage.messages), s);
    const image::Image picture = pictureOf(*r);
    EXPECT_TRUE(std::all_of(picture.pixels.begin(), picture.pixels.end(), [](float x) { return std::isfinite(x); }));
    *said = stage.said;
    return stateOf(r->film());
  };
  struct Case {
    const char *parameter, *value, *used;
  };
  for (const Case& c :
       {Case{"mergeRadius", "-3", "0"}, Case{"mergeRadius", "1e9", "1000"}, Case{"reduceRadius", "-1", "0.01"},
        Case{"reduceRadius", "7", "1"}, Case{"timeRadius", "0", "0.001"}, Case{"rouletteThreshold", "2", "1"}}) {
    std::string said, silent;
    const auto film = filmWith(c.parameter, c.value, &said);
    EXPECT_NE(said.find("PARAM-RANGE"), std::string::npos) << c.parameter << " " << c.value << ": " << said;
    EXPECT_NE(said.find(c.parameter), std::string::npos) << said;
    EXPECT_NE(said.find(std::string(c.used) + " is used"), std::string::npos) << said;
    EXPECT_TRUE(film == filmWith(c.parameter, c.used, &silent)) << c.parameter << " " << c.value;
    EXPECT_EQ(silent, "");
  }
}

// A point light in the middle of a ball that is white inside: each bounce gives the same everywhere, so that the picture
// is a geometric series, and so is what channels of long paths have of it. With connections light paths have their share
// of all lengths.
TEST(Vcm, FollowsManyBouncesAndTheirExpressions) {
  constexpr double kWhite = 0.95;
  constexpr int kBounces = 60, kLong = 21;
  const std::string text = R"(
Hider "raytrace" "int maxsamples" [4]
Display "probe.exr" "openexr" "Ci,a,indirect,ball,key"
DisplayChannel "color ball" "string source" ["lpe:C[DS]{22,}<L.>"]
DisplayChannel "color key" "string source" ["lpe:C[DS]{5}<L.>"]
Format 32 32 1
PixelFilter "box" 1 1
Projection "perspective" "fov" [60]
Translate 0 0 0.5
WorldBegin
  Light "PointLight" "lamp" "float intensity" [1]
  Bxdf "PxrDiffuse" "white" "color diffuseColor" [0.95 0.95 0.95]
  Sphere 2 -2 2 360
WorldEnd
)";
  const auto sum = [](int from, int to) {  // of k-th powers
    return (std::pow(kWhite, from) - std::pow(kWhite, to + 1)) / (1 - kWhite);
  };
  Workshop stage;
  const double one = renderAll(stage, text, pathTracer(0), 1, 1).at("Ci").mean();
  ASSERT_GT(one, 0.01);
  for (const bool connects : {true, false})
    for (const bool merges : {true, false}) {
      if (!connects && !merges) continue;
      const Pictures p = renderAll(stage, text, vcm(connects, merges, 5, kBounces), 10, 4);
      const auto expectOf = [&](const char* channel, double of) {
        const TileMoments& m = p.at(std::string(channel) + ", whole");
        EXPECT_NEAR(m.mean() / one, of, 0.004 * of + 4 * m.tiles[0].standardError() / one)
            << channel << (connects ? ", connects" : "") << (merges ? ", merges" : "");
        EXPECT_LT(m.tiles[0].standardError(), 0.03 * m.mean()) << channel;
      };
      expectOf("Ci", sum(0, kBounces));
      expectOf("indirect", sum(1, kBounces));
      expectOf("ball", sum(kLong, kBounces));
      expectOf("key", sum(4, 4));
    }
}

// A point light in a shell of glass that hardly refracts, seen through a pane of it: what no technique but merging finds
// is the picture without glass. Paths are too short for two diffuse surfaces.
TEST(Vcm, MergingFindsWhatLiesBetweenSmoothSurfaces) {
  const std::string glass = R"(
    Bxdf "PxrSurface" "clear" "float diffuseGain" [0] "float refractionGain" [1] "float reflectionGain" [0]
      "float glassRoughness" [0] "float glassIor" [1.0005])";
  const std::string between = R"(
  AttributeBegin )" + glass + R"(
    Translate 0 2.3 0.2
    Sphere 0.15 -0.15 0.15 360
  AttributeEnd
  AttributeBegin )" + glass + R"(
    Translate 0 0.8 -1
    PointsPolygons [4 4 4 4 4 4] [0 1 2 3  7 6 5 4  0 4 5 1  1 5 6 2  2 6 7 3  3 7 4 0]
      "vertex point P" [-2 -2 -0.1  2 -2 -0.1  2 2 -0.1  -2 2 -0.1  -2 -2 0.1  2 -2 0.1  2 2 0.1  -2 2 0.1]
  AttributeEnd
)";
  const std::string lamp = R"(
    AttributeBegin
      Translate 0 2.3 0.2
      Light "PointLight" "bare" "float intensity" [6]
    AttributeEnd)";
  const std::string covered = room(lamp, kGrey, "", between);
  Workshop stage;
  EXPECT_LT(renderAll(stage, covered, vcm(true, false, 1, 3), 100, 2).at("Ci").mean(), 1e-6);
  const Pictures open = renderAll(stage, room(lamp, kGrey), pathTracer(0), 100);
  const TileTest t = compareTiles(mainTiles(extrapolated(stage, covered, true, 1, 1000, 48, 3), open.at("Ci")),
                                  mainTiles(open.at("Ci"), open.at("Ci")));
  EXPECT_TRUE(t.agrees()) << "worst z " << t.worstZ << "\n" << stage.said;
  EXPECT_LT(t.meanError, 0.05);
}

// Under wide radii a part of the light paths is merged. On a plane that the sun lights evenly no radius blurs anything,
// and with light samples off merging alone finds it, and is not weighted as if there were any.
TEST(Vcm, MergingAPartOfTheLightPathsKeepsTheMean) {
  const std::string plane = std::string(kShown) + R"(Projection "orthographic"
ScreenWindow -1 1 -1 1
WorldBegin
  AttributeBegin
    Rotate 10 1 0 0
    Light "PxrDistantLight" "sun" "float intensity" [2] "float angleExtent" [0]
  AttributeEnd
  Bxdf "PxrDiffuse" "wall" "color diffuseColor" [0.7 0.6 0.5]
  Polygon "vertex point P" [-3 -3 3  3 -3 3  3 3 3  -3 3 3]
WorldEnd
)";
  Workshop stage;
  const Pictures reference = renderAll(stage, plane, pathTracer(0), 1, 2);
  const double mean = reference.at("Ci").mean();
  EXPECT_GT(mean, 0.01);
  for (const double radius : {1.0, 4.0, 16.0}) {  // all light paths, a sixth, a hundredth
    Method m = vcm(false, true, radius, 0);
    m.sets.emplace_back("integrator.numLightSamples", "0");
    const Pictures merged = renderAll(stage, plane, m, 100);
    const testing::Moments& whole = merged.at("Ci, whole").tiles[0];
    EXPECT_NEAR(whole.mean(), mean, 4 * whole.standardError()) << "radius " << radius;
    EXPECT_LT(whole.standardError(), 0.05 * mean) << "radius " << radius;
  }
}

// What a splat brings to each pixel is the filter's share of it.
TEST(SplatFilter, SharesByTheFiltersValues) {
  for (const auto& [name, width] : std::vector<std::pair<std::string, float>>{
           {"gaussian", 2.f}, {"mitchell", 4.f}, {"box", 1.f}, {"triangle", 3.f}}) {
    film::PixelFilter filter;
    ASSERT_TRUE(film::PixelFilter::make(name, width, width, filter).ok());
    const film::SplatFilter splats(filter);
    // places all over the neighbourhood of pixel (10, 10): the sum of its weights is the filter's integral, 1
    const int n = 1000;
    double sum = 0, aside = 0;
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const float x = 7.5f + 6.f * (float(i) + 0.5f) / float(n), y = 7.5f + 6.f * (float(j) + 0.5f) / float(n);
        const film::SplatFilter::Pixel p = splats.choose(x, y);
        if (p.x != 10 || p.y != 10) continue;
        sum += p.weight;
        aside += p.weight * (double(x) - 10.5) * (double(x) - 10.5);
      }
    const double area = 36.0 / (double(n) * n);
    EXPECT_NEAR(sum * area, 1, 0.02) << name;
    double whole = 0, second = 0;
    for (int i = -300; i < 300; ++i)
      for (int j = -300; j < 300; ++j) {
        const double v = filter.evaluate((i + 0.5) / 100, (j + 0.5) / 100);
        whole += v;
        second += v * (i + 0.5) * (i + 0.5) / 1e4;
      }
    EXPECT_NEAR(aside * area, second / whole, 0.02) << name;
  }
}

}  // namespace
}  // namespace kinora::probes
