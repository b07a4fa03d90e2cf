// Proves: archives that are read when a ray first meets their bound give, bit for bit, the picture of all archives read
// before the first sample, through every kind of ray and path, for any threads, widths, groups and crops; what no ray
// meets is not opened; and what is wrong in archives is said when they are read.
// Misses: coincident surfaces of different archives, whose order no ray can tell.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "procedurals/archives.h"

namespace kinora::tests {
namespace {

// The same sums when all is read first, in other threads, widths and groups, and where no two archives fit in memory
// together. Of the procedurals `read` are.
void expectSame(const Files& files, int total, int read, render::Settings settings = {}) {
  const Folder folder(files);
  settings.samplesPerPixel = settings.pixelVariance >= 0 ? 0 : 8;
  render::Settings first = settings;
  first.readsAllProcedurals = true;
  const Rendered all = rendered(folder, first);
  ASSERT_EQ(all.outcome, render::Outcome::Complete) << all.said;
  EXPECT_EQ(all.said, "");
  EXPECT_EQ(int(all.statistics.proceduralsRead), total);
  const Rendered lazy = rendered(folder, settings);
  ASSERT_EQ(lazy.outcome, render::Outcome::Complete) << lazy.said;
  EXPECT_EQ(lazy.said, "");
  EXPECT_EQ(int(lazy.statistics.proceduralsRead), read);
  EXPECT_TRUE(lazy.sums == all.sums);
  EXPECT_EQ(lazy.replayed, all.replayed);
  EXPECT_EQ(lazy.statistics.cameraRays, all.statistics.cameraRays);
  EXPECT_EQ(lazy.statistics.shadowRays, all.statistics.shadowRays);
  EXPECT_EQ(lazy.statistics.cameraHits, all.statistics.cameraHits);
  render::Settings other = settings;
  other.threads = 3;
  other.width = 4;
  other.groupSize = 64;
  const Rendered again = rendered(folder, other);
  EXPECT_TRUE(again.sums == all.sums) << "3 threads, width 4, groups of 64";
  EXPECT_EQ(again.statistics.proceduralsRead, lazy.statistics.proceduralsRead);
  other.threads = 2;
  other.width = 1;
  other.groupSize = 16;
  EXPECT_TRUE(rendered(folder, other).sums == all.sums) << "2 threads, width 1, groups of 16";
  settings.threads = 2;
  settings.geometryCacheBytes = 1;
  const Rendered poor = rendered(folder, settings);
  EXPECT_TRUE(poor.sums == all.sums) << "a budget of nothing: " << poor.said;
  EXPECT_EQ(poor.replayed, all.replayed);
  EXPECT_EQ(poor.statistics.cameraRays, all.statistics.cameraRays);
  EXPECT_EQ(poor.statistics.shadowRays, all.statistics.shadowRays);
  EXPECT_EQ(poor.statistics.proceduralsRead, lazy.statistics.proceduralsRead);
}

TEST(Procedurals, TheCameraSeesThem) {
  expectSame({{"scene.rib", world(delayed("-1 0 5", "a.rib") + delayed("1 .2 4", "b.rib") +
                                  delayed("0 0 12", "behind.rib") + delayed("0 0 -4", "back.rib"))},
              {"a.rib", kBall},
              {"b.rib", kBoxes},
              {"behind.rib", kBall},
              {"back.rib", kBall}},
             4, 3);  // light that the floor throws back finds the one at the camera's back
}

// Worlds that are made because something was read say nothing again.
TEST(Procedurals, WhatASceneHasWrongIsSaidOnce) {
  const Folder folder({{"scene.rib", kHead + "Integrator \"PxrPathTracer\" \"i\"\nWorldBegin\n" +
                                         delayed("0 0 5", "a.rib") + delayed("1 0 5", "b.rib") + "WorldEnd\n"},
                       {"a.rib", kBall},
                       {"b.rib", kBall}});
  render::Settings settings;
  settings.samplesPerPixel = 4;
  const Rendered r = rendered(folder, settings);
  EXPECT_EQ(r.statistics.proceduralsRead, 2u);
  EXPECT_GT(r.statistics.proceduralWorlds, 0u);
  const size_t at = r.said.find("RENDER-NO-LIGHTS");
  EXPECT_NE(at, std::string::npos) << r.said;
  // the black picture says so besides
  EXPECT_LE(r.warnings, 2u) << r.said;
  EXPECT_EQ(r.said.find("RENDER-NO-LIGHTS", at + 1), std::string::npos) << r.said;
}

TEST(Procedurals, AMirrorShowsThem) {
  expectSame(
      {{"scene.rib", world("AttributeBegin\nBxdf \"PxrSurface\" \"m\" \"color specularFaceColor\" [1 1 1] \"color "
                           "specularEdgeColor\" [1 1 1] \"float specularRoughness\" [0.001] \"float diffuseGain\" "
                           "[0]\nPolygon \"P\" [-4 -1 6 4 -1 6 4 4 6 -4 4 6]\nAttributeEnd\n" +
                           delayed("0 0 -1", "a.rib") + delayed("0 0 20", "no.rib"))},
       {"a.rib", kBoxes},
       {"no.rib", kBoxes}},
      2, 1);
}

TEST(Procedurals, TheirShadowsFall) {
  expectSame({{"scene.rib", world(delayed("0 2.2 4", "a.rib"), "Integrator \"PxrDirectLighting\" \"i\"\n")},
              {"a.rib", kBoxes}},
             1, 1);
}

TEST(Procedurals, CutOutsAndGlassLetShadowRaysPass) {
  expectSame({{"scene.rib", world(delayed("0 2 4", "a.rib") + delayed("0 1 4", "b.rib"))},
              {"a.rib", "Bxdf \"PxrSurface\" \"p\" \"float presence\" [.4]\nSphere .5 -.5 .5 360\n"},
              {"b.rib", "Bxdf \"PxrGlass\" \"p\"\nSphere .5 -.5 .5 360\nTranslate .1 0 0\nSphere .4 -.4 .4 360\n"}},
             2, 2);
}

TEST(Procedurals, LightPathsMeetThem) {
  for (const char* merge : {"1", "0"})
    expectSame(
        {{"scene.rib", world(delayed("-1 0 5", "a.rib") + delayed("1 .2 4", "b.rib") + delayed("0 4 -6", "c.rib"),
                             std::string("Integrator \"PxrVCM\" \"i\" \"int mergePaths\" [") + merge +
                                 "] \"int maxPathLength\" [5]\n")},
         {"a.rib", kBall},
         {"b.rib", "Bxdf \"PxrGlass\" \"p\"\nSphere .5 -.5 .5 360\n"},
         {"c.rib", kBall}},
        3, 3);
}

// What light paths leave is looked at once more in a world that holds more, and where that was said before.
TEST(Procedurals, LightPathsMeetWhatIsSaidFirstLast) {
  expectSame({{"scene.rib", world(delayed("0 4 -6", "c.rib", "-1 1 -1 1 -1 1") + delayed("1 .2 4", "b.rib") +
                                      delayed("-1 0 5", "a.rib") + delayed("-1.5 0 4", "d.rib"),
                                  "Integrator \"PxrVCM\" \"i\" \"int maxPathLength\" [5]\n")},
              {"a.rib", kBall},
              {"b.rib", kBoxes},
              {"c.rib", kBoxes + delayed("0 0 0", "d.rib")},
              {"d.rib", kBall}},
             5, 5);
}

TEST(Procedurals, PathsThatLearn) {
  expectSame({{"scene.rib",
               world(delayed("-1 0 5", "a.rib") + delayed("1 .2 4", "b.rib"),
                     "Integrator \"PxrPathTracer\" \"i\" \"int risPathGuiding\" [1] \"int learnLights\" [1]\n")},
              {"a.rib", kBall},
              {"b.rib", kBoxes}},
             2, 2);
}

TEST(Procedurals, LightBelowTheirSurfaces) {
  expectSame({{"scene.rib", world(delayed("0 0 4", "a.rib") + delayed(".4 0 3", "b.rib"))},
              {"a.rib",
               "Bxdf \"PxrSurface\" \"s\" \"float subsurfaceGain\" [1] \"color subsurfaceColor\" [.8 .5 .4] "
               "\"float subsurfaceDmfp\" [.2]\nSphere .5 -.5 .5 360\n"},
              {"b.rib", kBall}},
             2, 2);
}

TEST(Procedurals, DisplacedSurfaces) {
  expectSame({{"scene.rib", world(delayed("0 0 4", "a.rib", "-.8 .8 -.8 .8 -.8 .8"))},
              {"a.rib",
               "Attribute \"displacementbound\" \"float sphere\" [.2]\nPattern \"PxrFractal\" \"f\"\nDisplace "
               "\"PxrDisplace\" \"d\" \"float dispAmount\" [.1] \"reference float dispScalar\" "
               "[\"f:resultF\"]\nBxdf \"PxrDiffuse\" \"b\"\nSphere .5 -.5 .5 360\n"}},
             1, 1);
}

TEST(Procedurals, InstancesOfTheirOwnAndOfTheSceneObjects) {
  expectSame({{"scene.rib",
               world("ObjectBegin \"ball\"\nSphere .2 -.2 .2 360\nTranslate .3 0 0\nSphere .1 -.1 .1 "
                     "360\nObjectEnd\nAttributeBegin\nTranslate -1 0 3\nObjectInstance \"ball\"\nAttributeEnd\n" +
                     delayed("0 0 4", "a.rib", "-.9 .9 -.9 .9 -.9 .9") +
                     delayed("1 .5 5", "a.rib", "-.9 .9 -.9 .9 -.9 .9"))},
              {"a.rib",
               "Bxdf \"PxrDiffuse\" \"b\" \"color diffuseColor\" [.1 .3 .8]\nObjectBegin \"own\"\nSphere .1 -.1 .1 "
               "360\nObjectInstance \"ball\"\nObjectEnd\nObjectInstance \"own\"\nTranslate 0 .4 0\nObjectInstance "
               "\"own\"\nTranslate 0 -.8 0\nObjectInstance \"ball\"\n"}},
             2, 2);
}

TEST(Procedurals, WhatMoves) {
  expectSame({{"scene.rib",
               world("AttributeBegin\nMotionBegin [0 1]\nTranslate -1 0 4\nTranslate 1 .3 4\nMotionEnd\nProcedural "
                     "\"DelayedReadArchive\" [\"a.rib\"] [-.6 .6 -.6 .6 -.6 .6]\nAttributeEnd\n" +
                         delayed("0 1 5", "b.rib", "-1 1 -.6 .6 -.6 .6"),
                     "Integrator \"PxrPathTracer\" \"i\"\n", "Shutter 0 1\n")},
              {"a.rib", kBoxes},
              {"b.rib",
               "Bxdf \"PxrDiffuse\" \"b\"\nMotionBegin [0 .5 1]\nTranslate -.4 0 0\nTranslate 0 .1 0\nTranslate .4 0 "
               "0\nMotionEnd\nSphere .4 -.4 .4 360\nSphere .2 -.2 .2 360\n"}},
             2, 2);
}

TEST(Procedurals, InsideOthers) {
  expectSame(
      {{"scene.rib", world(delayed("0 0 5", "a.rib", "-2 2 -1 1 -1 1"))},
       {"a.rib", kBall + delayed("1 0 0", "b.rib") + delayed("-1 0 0", "b.rib") + delayed("0 -.9 3", "under.rib")},
       {"b.rib", "Scale .9 .9 .9\n" + kBoxes + delayed("0 0 -.1", "c.rib", "-.2 .2 -.2 .2 -.2 .2")},
       {"c.rib", "Sphere .15 -.15 .15 360\n"},
       {"under.rib", kBall}},
      6, 5);
}

TEST(Procedurals, FogInThem) {
  expectSame({{"scene.rib", world(delayed("0 0 4", "a.rib", "-1 1 -1 1 -1 1"))},
              {"a.rib",
               "Bxdf \"PxrVolume\" \"v\" \"float densityFloat\" [1.5] \"color diffuseColor\" [.8 .8 .9]\nVolume "
               "\"box\" [-.9 .9 -.9 .9 -.9 .9] [0 0 0]\n"}},
             1, 1);
}

TEST(Procedurals, CurvesPointsAndSolids) {
  expectSame(
      {{"scene.rib", world(delayed("0 0 4", "a.rib", "-1 1 -1 1 -1 1"))},
       {"a.rib",
        "Bxdf \"PxrDiffuse\" \"b\"\nCurves \"linear\" [2 2] \"nonperiodic\" \"P\" [-.8 -.8 0 .8 .8 0 -.8 .8 0 "
        ".8 -.8 0] \"constantwidth\" [.1]\nPoints \"P\" [0 .5 0 .3 .5 .2] \"constantwidth\" "
        "[.2]\nSolidBegin \"difference\"\nSolidBegin \"primitive\"\nSphere .4 -.4 .4 360\nSolidEnd\nSolidBegin "
        "\"primitive\"\nTranslate .2 0 -.3\nSphere .3 -.3 .3 360\nSolidEnd\nSolidEnd\n"}},
      1, 1);
}

TEST(Procedurals, LinksTraceSetsAndHoldouts) {
  expectSame(
      {{"scene.rib",
        world("AttributeBegin\nAttribute \"grouping\" \"string membership\" [\"reds\"]\n" +
              delayed("-1 0 5", "a.rib") +
              "AttributeEnd\nAttribute \"trace\" \"string reflectexcludesubset\" [\"reds\"]\nAttributeBegin\nBxdf "
              "\"PxrSurface\" \"m\" \"color specularFaceColor\" [1 1 1] \"color specularEdgeColor\" [1 1 1] \"float "
              "specularRoughness\" [0.05]\nPolygon \"P\" [-4 -1 6 4 -1 6 4 4 6 -4 4 6]\nAttributeEnd\n" +
              delayed("0 .2 4", "b.rib") + delayed("1 .2 4", "c.rib"))},
       {"a.rib", kBall},
       {"b.rib", "Illuminate \"lamp\" 0\nMatte 1\n" + kBoxes},
       {"c.rib", "Illuminate \"sun\" 0\nAttribute \"trace\" \"int holdout\" [1]\n" + kBall}},
      3, 3);
}

TEST(Procedurals, AWorldOfNothingElse) {
  expectSame({{"scene.rib", kHead + "WorldBegin\n" + kLights + delayed("-1 0 5", "a.rib") +
                                delayed("1 .2 4", "b.rib") + "WorldEnd\n"},
              {"a.rib", kBall},
              {"b.rib", kBoxes}},
             2, 2);
}

TEST(Procedurals, TheCameraInsideABound) {
  expectSame(
      {{"scene.rib", world(delayed("0 0 0", "a.rib", "-5 5 -5 5 -5 9"))}, {"a.rib", "Translate 0 0 4\n" + kBoxes}}, 1,
      1);
}

TEST(Procedurals, LevelsOfDetail) {
  const auto level = [](const std::string& range, const std::string& file) {
    return "AttributeBegin\nTranslate 0 0 4\nDetail [-.6 .6 -.6 .6 -.6 .6]\nDetailRange [" + range +
           "]\nProcedural \"DelayedReadArchive\" [\"" + file + "\"] [-.6 .6 -.6 .6 -.6 .6]\nAttributeEnd\n";
  };
  const Folder folder(
      {{"scene.rib", world(level("0 0 100 100", "coarse.rib") + level("100 100 1e38 1e38", "fine.rib"))},
       {"fine.rib", kBall}});
  const Rendered r = rendered(folder, {});
  EXPECT_EQ(r.outcome, render::Outcome::Complete);
  EXPECT_EQ(r.said, "") << "the other level was read";
  EXPECT_EQ(r.statistics.proceduralsRead, 1u);
}

// A folder's scene to be edited: what is said of it is a failure.
struct Edited {
  Edited(const Folder& folder, int threads, int samples) : said(readScene(folder, diagnostics)) {
    settings.threads = threads;
    settings.samplesPerPixel = samples;
    renderer = load(said.scene.value());
  }
  std::unique_ptr<render::Renderer> load(const scene::Scene& scene) {
    auto r = std::make_unique<render::Renderer>(registry, diagnostics, settings);
    EXPECT_TRUE(r->load(scene, said.procedurals));
    return r;
  }
  static std::vector<int64_t> render(render::Renderer& r) {
    EXPECT_EQ(r.renderFilm(), render::Outcome::Complete);
    return stateOf(r.film());
  }
  std::vector<int64_t> fresh(const scene::Scene& scene) { return render(*load(scene)); }

  Diagnostics diagnostics{[](const std::string& line, Severity) { ADD_FAILURE() << line; }};
  Said said;
  render::Settings settings;
  Registry registry;
  std::unique_ptr<render::Renderer> renderer;
};

TEST(Procedurals, AnEditedSceneIsAFreshOne) {
  const Folder folder(
      {{"scene.rib", world(delayed("-1 0 5", "a.rib") + delayed("1 .2 4", "b.rib") + delayed("9 0 12", "c.rib"))},
       {"a.rib", kBall},
       {"b.rib", kBoxes},
       {"c.rib", kBall}});
  Edited edited(folder, 2, 4);
  render::Renderer& renderer = *edited.renderer;
  ASSERT_FALSE(edited.render(renderer).empty());
  EXPECT_EQ(renderer.statistics().proceduralsRead, 2u);
  uint32_t moved = 0;
  for (const auto& [id, source] : *edited.said.procedurals) moved = std::max(moved, id);
  const auto edit = [&](scene::Scene& s) {
    EXPECT_TRUE(
        s.setPrimitiveTransform(moved, scene::Transform::fixed(scene::Matrix().setTranslation(Imath::V3d(0, 1, 5)))));
    EXPECT_TRUE(s.removePrimitive(moved - 2));
  };
  edit(renderer.scene());
  ASSERT_TRUE(renderer.update());
  const std::vector<int64_t> sums = edited.render(renderer);
  EXPECT_EQ(renderer.statistics().proceduralsRead, 2u);
  scene::Scene scene = *edited.said.scene;
  edit(scene);
  EXPECT_TRUE(sums == edited.fresh(scene));
}

// What an edit did not reach is not read again, unless its file is another.
TEST(Procedurals, AnEditReadsWhatItReached) {
  const Folder folder({{"scene.rib", world(delayed("-1 0 5", "a.rib") + delayed("1 .2 4", "b.rib"))},
                       {"a.rib", kBall},
                       {"b.rib", kBoxes}});
  Edited edited(folder, 1, 2);
  render::Renderer& renderer = *edited.renderer;
  ASSERT_FALSE(edited.render(renderer).empty());
  EXPECT_EQ(renderer.statistics().proceduralsRead, 2u);
  const double seconds = renderer.statistics().proceduralReadSeconds;
  // a light is turned off: both are there
  const auto dim = [](scene::Scene& s) {
    auto node = std::make_shared<scene::Node>(*s.lights[0].node);
    scene::Parameter p = *node->params.find("intensity");
    p.floats = {1};
    node->params.set(std::move(p));
    s.lights[0].node = node;
  };
  dim(renderer.scene());
  ASSERT_TRUE(renderer.update());
  EXPECT_TRUE(edited.render(renderer) == edited.fresh(renderer.scene()));
  EXPECT_EQ(renderer.statistics().proceduralReadSeconds, seconds) << "nothing was read";
  EXPECT_EQ(renderer.statistics().proceduralsRead, 2u);
  // a file is written anew
  std::ofstream(folder.file("a.rib")) << kBoxes << "Sphere .4 -.4 .4 360\n";
  ASSERT_TRUE(renderer.update());
  EXPECT_TRUE(edited.render(renderer) == edited.fresh(renderer.scene()));
  EXPECT_GT(renderer.statistics().proceduralReadSeconds, seconds);
}

TEST(Procedurals, AdaptiveSampling) {
  render::Settings settings;
  settings.pixelVariance = 0.05f;
  settings.leastSamples = 4;
  settings.mostSamples = 32;
  expectSame({{"scene.rib", world(delayed("-1 0 5", "a.rib") + delayed("1 .2 4", "b.rib"))},
              {"a.rib", kBall},
              {"b.rib", kBoxes}},
             2, 2, settings);
}

// Other rays than those of the whole ask for the archives, and in another order.
TEST(Procedurals, ACropShowsWhatTheWholeDoes) {
  const Folder folder(
      {{"scene.rib", world(delayed("-1.5 0 5", "a.rib") + delayed("1.5 .2 4", "b.rib") + delayed("3 0 9", "no.rib"))},
       {"a.rib", kBall},
       {"b.rib", kBoxes},
       {"no.rib", kBoxes}});
  render::Settings settings;
  settings.samplesPerPixel = 4;
  const Rendered whole = rendered(folder, settings);
  EXPECT_EQ(whole.statistics.proceduralsRead, 2u);
  settings.crop = {0, 0.5f, 0, 1};
  const Rendered lazy = rendered(folder, settings);
  settings.readsAllProcedurals = true;
  const Rendered all = rendered(folder, settings);
  EXPECT_LT(lazy.statistics.proceduralsRead, 3u);
  EXPECT_TRUE(lazy.sums == all.sums);
}

TEST(Procedurals, WhatNoRayMeetsIsNotOpened) {
  const std::string scene =
      world(delayed("0 0 12", "gone.rib") + delayed("2 0 12", "broken.rib") + delayed("0 0 5", "a.rib"));
  render::Settings settings;
  settings.firstSample = 0;
  settings.lastSample = 4;
  std::string hash;
  {
    const Folder folder({{"scene.rib", scene}, {"a.rib", kBall}, {"broken.rib", "\x80\x81 ]] \"Sphere -\n"}});
    const Rendered r = rendered(folder, settings);
    EXPECT_EQ(r.outcome, render::Outcome::Complete);
    EXPECT_EQ(r.said, "");
    EXPECT_EQ(r.statistics.procedurals, 3u);
    EXPECT_EQ(r.statistics.proceduralsRead, 1u);
    EXPECT_EQ(r.late, 1u) << "the one that was read is named with its content";
    hash = r.hash;
    EXPECT_NE(hash, "");
  }
  {
    const Folder folder({{"scene.rib", scene}, {"a.rib", kBall}, {"broken.rib", kBall}, {"gone.rib", kBall}});
    EXPECT_EQ(rendered(folder, settings).hash, hash);
    settings.readsAllProcedurals = true;
    const Rendered all = rendered(folder, settings);
    EXPECT_EQ(all.hash, hash) << "which were read does not decide what the frame is";
    EXPECT_EQ(all.late, 3u);
    const Folder other({{"scene.rib", world(delayed("0 0 12", "gone.rib"))}});
    settings.readsAllProcedurals = false;
    EXPECT_NE(rendered(other, settings).hash, hash);
  }
}

TEST(Procedurals, WhatIsMissingIsSaidOnceARayAsksForIt) {
  const Folder folder({{"scene.rib", world(delayed("0 0 5", "gone.rib"))}});
  const Rendered r = rendered(folder, {});
  EXPECT_EQ(r.outcome, render::Outcome::Complete);
  EXPECT_NE(r.said.find("scene.rib:"), std::string::npos) << r.said;
  EXPECT_NE(r.said.find("ASSET-MISSING-ARCHIVE"), std::string::npos) << r.said;
  EXPECT_EQ(r.warnings, 1u) << r.said;
}

TEST(Procedurals, ThatReadThemselves) {
  const Folder folder({{"scene.rib", world(delayed("0 0 5", "a.rib"))},
                       {"a.rib", kBall + delayed("0 0 .1", "b.rib")},
                       {"b.rib", delayed("0 0 0", "a.rib")}});
  const Rendered r = rendered(folder, {});
  EXPECT_EQ(r.outcome, render::Outcome::Complete);
  EXPECT_NE(r.said.find("RIB-RECURSION"), std::string::npos) << r.said;
}

TEST(Procedurals, ProgramsAreRunOnceTheyAreMet) {
  const std::string program =
      "AttributeBegin\nTranslate %s\nProcedural \"RunProgram\" [\"%c\" \"x\"] [-.6 .6 -.6 .6 -.6 "
      ".6]\nAttributeEnd\n";
  const auto of = [&](const std::string& at, const std::string& command) {
    std::string s = program;
    s.replace(s.find("%s"), 2, at);
    s.replace(s.find("%c"), 2, command);
    return s;
  };
  const std::string touched = ::testing::TempDir() + "procedural-touched";
  std::filesystem::remove(touched);
  const Folder folder({{"scene.rib", world(of("0 0 5", "echo Sphere .5 -.5 .5 360") + of("1 0 5", "sleep 20") +
                                           of("0 0 12", "touch " + touched))}});
  const Rendered r = rendered(folder, {}, true);
  EXPECT_EQ(r.outcome, render::Outcome::Complete);
  EXPECT_EQ(r.statistics.proceduralsRead, 2u);
  EXPECT_NE(r.said.find("ASSET-PROGRAM"), std::string::npos) << r.said;
  EXPECT_FALSE(std::filesystem::exists(touched));
}

// Archives with lights, wherever in them these are said, are read with the scene; the others wait.
TEST(Procedurals, LightsInThemShine) {
  const std::string light =
      "AttributeBegin\nTranslate 0 1 -1\nLight \"PxrSphereLight\" \"l\" \"float intensity\" [100]\nAttributeEnd\n";
  const std::string glows =
      "AttributeBegin\nLight \"PxrMeshLight\" \"m\" \"float intensity\" [9]\nSphere .1 -.1 .1 360\nAttributeEnd\n";
  struct Case {
    const char* name;
    Files files;
    uint64_t lights, waiting;
    std::string before;
  };
  const Case cases[] = {
      {"a light", {{"a.rib", kBall + light}}, 4, 0, ""},
      {"abutting", {{"a.rib", "Bxdf \"PxrDiffuse\" \"b\"Light \"PxrSphereLight\" \"l\"\n" + kBall}}, 4, 0, ""},
      {"of a mesh", {{"a.rib", kBall + glows}}, 4, 0, ""},
      {"classic", {{"a.rib", "LightSource \"pointlight\" 7 \"float intensity\" [20]\n" + kBall}}, 4, 0, ""},
      {"an area",
       {{"a.rib", kBall + "AttributeBegin AreaLightSource \"arealight\" 7 Sphere .1 -.1 .1 360 AttributeEnd\n"}},
       4,
       0,
       ""},
      {"in an archive that it reads", {{"a.rib", kBall + "ReadArchive \"b.rib\"\n"}, {"b.rib", light}}, 4, 0, ""},
      {"in one that would wait in it",
       {{"a.rib", kBall + delayed("0 0 0", "b.rib") + delayed(".1 0 0", "c.rib")},
        {"b.rib", kBoxes + light},
        {"c.rib", kBall}},
       4,
       1,
       ""},
      {"three deep",
       {{"a.rib", kBall + delayed("0 0 0", "b.rib")},
        {"b.rib", "ReadArchive \"c.rib\""},
        {"c.rib", delayed("0 0 0", "d.rib")},
        {"d.rib", light}},
       4,
       0,
       ""},
      {"in an inline archive",
       {{"a.rib", kBall + "ReadArchive \"inside\"\n"}},
       4,
       0,
       "ArchiveBegin \"inside\"\n" + light + "ArchiveEnd\n"},
      {"in an object of the scene",
       {{"a.rib", kBall + "ObjectInstance \"o\"\n"}},
       4,
       0,
       "ObjectBegin \"o\"\n" + light + kBoxes + "ObjectEnd\n"},
      {"in an object in an object",
       {{"a.rib", kBall + "ObjectInstance \"p\"\n"}},
       4,
       0,
       "ObjectBegin \"o\"\n" + light + kBoxes + "ObjectEnd\nObjectBegin \"p\"\nObjectInstance \"o\"\nObjectEnd\n"},
      {"in an object of its own",
       {{"a.rib", "ObjectBegin \"o\"\n" + light + kBoxes + "ObjectEnd\nObjectInstance \"o\"\n"}},
       4,
       0,
       ""},
      {"where a condition holds",
       {{"a.rib", kBall + "IfBegin \"$user:lit == 1\"\n" + light + "IfEnd\n"}},
       4,
       0,
       "Attribute \"user\" \"int lit\" [1]\n"},
      {"where none holds",
       {{"a.rib", kBall + "IfBegin \"$user:lit == 1\"\n" + light + "IfEnd\n"}},
       3,
       1,
       "Attribute \"user\" \"int lit\" [0]\n"},
      {"a word alone",
       {{"a.rib", "# Light \"x\"\n" + kBall + "Attribute \"identifier\" \"name\" [\" Light \"]\n" + kBoxes}},
       3,
       1,
       ""},
      {"a word in a name", {{"a.rib", "Attribute \"identifier\" \"name\" [\"TrafficLight\"]\n" + kBall}}, 3, 1, ""},
      {"itself", {{"a.rib", kBall + delayed("0 0 0", "a.rib") + light}}, 4, 0, ""},
      {"far behind",
       {{"a.rib", kBall + std::string(size_t(262144) - kBall.size() - light.find("Light") - 3, '\n') + light}},
       4,
       0,
       ""},
  };
  for (const Case& c : cases) {
    Files files = c.files;
    files["scene.rib"] = world(c.before + delayed("0 0 5", "a.rib"));
    const Folder waits(files);
    const Rendered got = rendered(waits, {});
    files["scene.rib"] =
        world(c.before + "Attribute \"procedural\" \"int immediatesubdivide\" [1]\n" + delayed("0 0 5", "a.rib"));
    const Folder atOnce(files);
    const Rendered expected = rendered(atOnce, {});
    EXPECT_EQ(got.outcome, render::Outcome::Complete) << c.name;
    EXPECT_EQ(got.statistics.lights, c.lights) << c.name << ": " << got.said;
    EXPECT_EQ(got.statistics.procedurals, c.waiting) << c.name;
    EXPECT_EQ(got.said.find("RIB-PROCEDURAL-LIGHT"), std::string::npos) << c.name << ": " << got.said;
    // what waits is an object of its own, whose last bits are others
    if (c.waiting == 0) {
      EXPECT_TRUE(got.sums == expected.sums) << c.name;
    }
    EXPECT_EQ(expected.statistics.lights, c.lights) << c.name << ": " << expected.said;
  }
  // the same in a compressed file, and for any threads and groups
  const Folder plain({{"scene.rib", world(delayed("0 0 5", "a.rib") + delayed("1 0 6", "b.rib"))},
                      {"a.rib", kBall + light},
                      {"b.rib", kBoxes}});
  const Rendered one = rendered(plain, {});
  EXPECT_EQ(one.statistics.procedurals, 1u);
  for (const int threads : {1, 3}) {
    render::Settings s;
    s.threads = threads;
    s.groupSize = threads == 1 ? 64 : 4096;
    s.width = threads == 1 ? 4 : 16;
    s.readsAllProcedurals = threads == 3;
    EXPECT_TRUE(rendered(plain, s).sums == one.sums) << threads;
  }
  ASSERT_EQ(std::system(("gzip -c " + plain.file("a.rib") + " > " + plain.file("z") + " && mv " + plain.file("z") +
                         " " + plain.file("a.rib"))
                            .c_str()),
            0);
  EXPECT_TRUE(rendered(plain, {}).sums == one.sums) << "compressed";
}

// What a program prints is not known before it runs.
TEST(Procedurals, LightsOfProgramsAreLeftOutAndNamed) {
  const std::string program = "Procedural \"RunProgram\" [\"cat FILE\" \"x\"] [-.6 .6 -.6 .6 -.6 .6]\n";
  const auto scene = [&](const Folder& folder, const std::string& before) {
    std::string s = program;
    s.replace(s.find("FILE"), 4, folder.file("a.rib"));
    std::ofstream(folder.file("scene.rib")) << world("Translate 0 0 5\n" + before + s);
  };
  const Folder folder({{"a.rib", kBall + "Light \"PxrSphereLight\" \"l\" \"float intensity\" [100]\n"}});
  scene(folder, "");
  const Rendered r = rendered(folder, {}, true);
  EXPECT_NE(r.said.find("RIB-PROCEDURAL-LIGHT"), std::string::npos) << r.said;
  EXPECT_EQ(r.statistics.lights, 3u);
  scene(folder, "Attribute \"procedural\" \"int immediatesubdivide\" [1]\n");
  const Rendered lit = rendered(folder, {}, true);
  EXPECT_EQ(lit.said, "");
  EXPECT_EQ(lit.statistics.lights, 4u);
  EXPECT_EQ(lit.statistics.procedurals, 0u);
}

// They shone from the ray on that ran the program, without what --set says of lights.
TEST(Procedurals, LightsOfObjectsThatProgramsPlaceAreLeftOutAndNamed) {
  const std::string object =
      "ObjectBegin \"o\"\n" + kBoxes + "Light \"PxrSphereLight\" \"l\" \"float intensity\" [100]\nObjectEnd\n";
  const auto scene = [&](const Folder& folder, const std::string& before) {
    std::ofstream(folder.file("scene.rib"))
        << world("Translate 0 0 5\n" + before + "Procedural \"RunProgram\" [\"cat " + folder.file("a.rib") +
                 "\" \"x\"] [-.6 .6 -.6 .6 -.6 .6]\n");
  };
  const Folder outer({{"a.rib", kBall + "ObjectInstance \"o\"\n"}}),
      own({{"a.rib", object + "ObjectInstance \"o\"\n"}});
  const std::string now = "Attribute \"procedural\" \"int immediatesubdivide\" [1]\n";
  for (const bool isOuter : {true, false}) {
    const Folder& folder = isOuter ? outer : own;
    scene(folder, isOuter ? object : "");
    const Rendered r = rendered(folder, {}, true);
    EXPECT_NE(r.said.find("RIB-PROCEDURAL-LIGHT"), std::string::npos) << isOuter << r.said;
    EXPECT_EQ(r.statistics.lights, 3u) << isOuter;
    scene(folder, (isOuter ? object : "") + now);
    const Rendered lit = rendered(folder, {}, true);
    EXPECT_EQ(lit.said, "") << isOuter;
    EXPECT_EQ(lit.statistics.lights, 4u) << isOuter;
    render::Settings dark;
    dark.sets = {{"light.intensity", "0"}};
    EXPECT_FALSE(rendered(folder, dark, true).sums == lit.sums) << "what is read at once is set as all lights are";
  }
}

TEST(Procedurals, WhatReachesBeyondItsBoundIsNamed) {
  const Folder folder(
      {{"scene.rib", world(delayed("0 0 5", "a.rib", "-.25 .25 -.25 .25 -.25 .25"))}, {"a.rib", kBall}});
  const Rendered r = rendered(folder, {});
  EXPECT_NE(r.said.find("RENDER-PROCEDURAL-BOUND"), std::string::npos) << r.said;
  EXPECT_NE(r.said.find("a bound 2 times as large"), std::string::npos) << r.said;
}

// What stands in an object is read with it, once: instances place it.
TEST(Procedurals, InObjectsTheyAreReadOnceForAllInstances) {
  const std::string places =
      "AttributeBegin\nTranslate -1 0 5\nObjectInstance \"o\"\nAttributeEnd\nAttributeBegin\nTranslate 1 .2 "
      "5\nRotate 30 0 1 0\nObjectInstance \"o\"\nAttributeEnd\nAttributeBegin\nTranslate 0 1 6\nObjectInstance "
      "\"o\"\nAttributeEnd\n";
  const auto object = [&](const std::string& content) {
    return world("ObjectBegin \"o\"\n" + content + "ObjectEnd\n" + places);
  };
  const Folder plain({{"scene.rib", object("AttributeBegin\n" + kBoxes +
                                           "AttributeEnd\nAttributeBegin\nTranslate .4 "
                                           "0 0\nSphere .1 -.1 .1 360\nAttributeEnd\n")}});
  const Rendered expected = rendered(plain, {});
  EXPECT_EQ(expected.said, "");
  const std::string bound = "[-.6 .6 -.6 .6 -.6 .6]\n";
  for (const std::string& request : {"Procedural \"DelayedReadArchive\" [\"a.rib\"] " + bound,
                                     "Procedural2 \"DelayedReadArchive2\" \"SimpleBound\" \"string filename\" "
                                     "[\"a.rib\"] \"float[6] bound\" " +
                                         bound,
                                     std::string("PROGRAM")}) {
    const Folder folder({{"a.rib", kBoxes}, {"run.sh", "echo .>>$1\ncat $2\n"}});
    const std::string count = folder.file("count");
    const std::string program = "Procedural \"RunProgram\" [\"sh " + folder.file("run.sh") + " " + count + " " +
                                folder.file("a.rib") + "\" \"\"] " + bound;
    std::ofstream(folder.file("scene.rib"))
        << object("AttributeBegin\n" + (request == "PROGRAM" ? program : request) +
                  "AttributeEnd\nAttributeBegin\nTranslate .4 0 0\nSphere .1 -.1 .1 360\nAttributeEnd\n");
    const Rendered r = rendered(folder, {}, true);
    EXPECT_EQ(r.said, "") << request;
    EXPECT_TRUE(r.sums == expected.sums) << request;
    EXPECT_EQ(r.statistics.procedurals, 0u);
    EXPECT_EQ(r.statistics.triangles, expected.statistics.triangles);
    if (request == "PROGRAM") {
      EXPECT_EQ(std::filesystem::file_size(count), 2u) << "it was run once";
      const Rendered refused = rendered(folder, {});
      EXPECT_NE(refused.said.find("ASSET-PROGRAM-REFUSED"), std::string::npos) << refused.said;
    }
  }
}

// Bounds that are none are read with the scene.
TEST(Procedurals, WithoutABoundTheyAreReadAtOnce) {
  for (const char* bound : {"-1e30 1e30 -1e30 1e30 -1e30 1e30", "1 -1 0 1 0 1", "0 1"}) {
    const Folder folder({{"scene.rib", world(delayed("0 0 12", "a.rib", bound))}, {"a.rib", kBall}});
    const Rendered r = rendered(folder, {});
    EXPECT_EQ(r.outcome, render::Outcome::Complete);
    EXPECT_EQ(r.statistics.procedurals, 0u) << bound;
    EXPECT_EQ(r.statistics.primitives, 3u) << bound;
  }
}

}  // namespace
}  // namespace kinora::tests
