// Which lights are worth a sample, learned over epochs (PxrPathTracer and PxrVCM, learnLights): the mean is that of the
// choice by the light tree alone for kinds of lights, surfaces, links, filters and media, a wrong density is noticed,
// bits do not depend on threads, widths, groups, parts or crops, and where lights are hidden it helps. Misses: by how
// much (docs/performance.md).
#include <cmath>
#include <string>

#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora {
const Descriptor* kinoraStock_WrongLights();
}

namespace kinora::probes {
namespace {

// A screen that hides lamps on the left from the right and the other way round.
const std::string kScreen = "  Polygon \"vertex point P\" [-0.3 0 0.5  -0.3 0 2  -0.3 1.7 2  -0.3 1.7 0.5]\n";
const char* const kLearned = "Integrator \"PxrPathTracer\" \"i\" \"int learnLights\" [1]\n";
const std::string kLamps = std::string(kRect) + kSphere + kSun;

Method learned(bool guided = false) {
  Method m = pathTracer(2);
  m.sets.insert(m.sets.end(), {{"integrator.learnLights", "1"}, {"integrator.risPathGuiding", guided ? "1" : "0"}});
  return m;
}
void expectMeanOfTheTree(const std::string& text, double sharpness = 0.05, const Method& method = learned()) {
  Workshop stage;
  expectEqual(renderAll(stage, text, method, 100), renderAll(stage, text, pathTracer(2), 500), "learned", sharpness);
}
TEST(LearnedLights, KeepTheMeanUnderAreaLightsAndSun) { expectMeanOfTheTree(room(kLamps, kGrey, "", kScreen)); }
TEST(LearnedLights, KeepTheMeanUnderDomeMeshAndPoint) {
  expectMeanOfTheTree(room(std::string(kDome) + kMesh + kPoint, kGrey, "", kScreen));
}
TEST(LearnedLights, KeepTheMeanBesideRoughGlass) {
  expectMeanOfTheTree(room(std::string(kRect) + kSphere + kDome, kRoughGlass, "", kScreen), 0.08);
}
TEST(LearnedLights, KeepTheMeanInMotionThroughALens) {
  expectMeanOfTheTree(room(std::string(kRect) + kDome + kMesh, kGrey, kLens, kScreen));
}
TEST(LearnedLights, KeepTheMeanWithSeveralSamplesAndDirections) {
  Method m = learned();
  m.sets.insert(m.sets.end(), {{"integrator.numLightSamples", "3"}, {"integrator.numIndirectSamples", "2"}});
  expectMeanOfTheTree(room(kLamps + kDome, kGrey, "", kScreen), 0.05, m);
}
TEST(LearnedLights, KeepTheMeanWithGuidedPaths) {
  expectMeanOfTheTree(room(kLamps + kDome, kGrey, "", kScreen), 0.05, learned(true));
}
TEST(LearnedLights, KeepTheMeanWithLinksAndFilters) { expectMeanOfTheTree(roomWithLinks(kScreen)); }
TEST(LearnedLights, KeepTheMeanInFog) { expectMeanOfTheTree(foggyRoom(kScreen), 0.1); }
// More lights than clusters.
TEST(LearnedLights, KeepTheMeanUnderManyLamps) {
  std::string lamps;
  for (int i = 0; i < 40; ++i)
    lamps += "AttributeBegin\n Translate " + std::to_string(-1.4 + 0.4 * (i % 8)) + " " +
             std::to_string(0.4 + 0.3 * (i / 8)) + " " + std::to_string(0.5 + 0.3 * (i % 3)) +
             "\n Scale 0.1 0.1 0.1\n Light \"PxrSphereLight\" \"l" + std::to_string(i) +
             "\" \"float intensity\" [3] \"string lightGroup\" [\"key\"]\nAttributeEnd\n";
  expectMeanOfTheTree(room(lamps, kGrey, "", kScreen));
}

// Paths from both ends: all techniques weigh light samples by the choice as it was learned.
Method learnedBy(Method m) {
  m.sets.emplace_back("integrator.learnLights", "1");
  return m;
}
TEST(LearnedLights, KeepTheMeanOfConnections) {
  expectMeanOfTheTree(room(kLamps, kGrey, "", kScreen), 0.05, learnedBy(vcm(true, false, 5, 2)));
}
TEST(LearnedLights, KeepTheMeanOfConnectionsUnderDomeAndMesh) {
  Method m = learnedBy(vcm(true, false, 5, 2));
  m.sets.emplace_back("integrator.numLightSamples", "2");
  expectMeanOfTheTree(room(std::string(kDome) + kMesh + kPoint, kGrey, kLens, kScreen), 0.05, m);
}
// What merging blurs it blurs either way.
TEST(LearnedLights, KeepTheMeanOfMerges) {
  const std::string text = room(kLamps, kGrey, "", kScreen);
  Workshop stage;
  const Method merges = vcm(true, true, 0.5, 2);
  expectEqual(renderAll(stage, text, learnedBy(merges), 100), renderAll(stage, text, merges, 500), "merges", 0.05);
}
TEST(LearnedLights, KeepTheMeanOfBeams) {
  const std::string fog =
      "  AttributeBegin\n    Bxdf \"PxrVolume\" \"fog\" \"color densityColor\" [0.3 0.4 0.5]\n"
      "    Volume \"box\" [-1.6 1.6 -0.1 2.1 -0.2 2.1] [0 0 0]\n  AttributeEnd\n";
  const std::string text = room(std::string(kRect) + kSphere, kGrey, "", kScreen + fog);
  Workshop stage;
  Method beams = vcm(true, false, 5, 2);
  beams.sets.insert(
      beams.sets.end(),
      {{"integrator.mergeMedia", "3"}, {"integrator.mediaRadius", "1"}, {"integrator.reduceMediaRadius", "1"}});
  expectEqual(renderAll(stage, text, learnedBy(beams), 100), renderAll(stage, text, beams, 500), "beams", 0.1);
}

// Lights that are met by rays as if nothing had been learned.
TEST(LearnedLights, WrongDensityIsNoticed) {
  Workshop stage{kinoraStock_WrongLights()};
  const std::string text = room(std::string(kRect) + kDome, kGrey, "", kScreen);
  const Pictures wrong = renderAll(stage, text, {"WrongLights", {}}, 100),
                 right = renderAll(stage, text, pathTracer(2), 500);
  const TileTest t = compareTiles(wrong.at("Ci"), right.at("Ci"));
  EXPECT_FALSE(t.agrees()) << "worst z " << t.worstZ;
}

TEST(LearnedLights, SameBits) {
  const std::string text = room(kLamps, kGrey, kLearned);
  EXPECT_NE(stateWith(text, "learnLights", "1"), stateWith(text, "learnLights", "0")) << "lights are learned";
  expectSameBits({}, room(kLamps + kDome, kGlass, std::string(kLens) + kLearned, kScreen), "");
}

TEST(LearnedLights, SameBitsWithLightPaths) {
  const std::string learned = "Integrator \"PxrVCM\" \"i\" \"int learnLights\" [1] \"int mergeMedia\" [3]\n";
  const std::string text = room(kLamps, kGrey, learned);
  EXPECT_NE(stateWith(text, "learnLights", "1"), stateWith(text, "learnLights", "0")) << "lights are learned";
  expectSameBits({}, room(kLamps + kDome, kGlass, std::string(kLens) + learned, kScreen), "");
}

TEST(LearnedLights, CropsAreWhatTheyAreInTheWhole) {
  for (const char* integrator : {kLearned, "Integrator \"PxrVCM\" \"i\" \"int learnLights\" [1]\n"})
    expectCropIsPartOfWhole(room(kLamps, kGrey, integrator, kScreen), {0.2f, 0.6f, 0.35f, 0.8f});
}

// A closed room that a sky and a sun outside cannot light.
TEST(LearnedLights, HelpWhereLightsAreHidden) {
  std::string text = room(std::string(kRect) + kSphere + kDome + kSun, kGrey, "", R"(
    Polygon "vertex point P" [-1.5 2 0  1.5 2 0  1.5 2 2  -1.5 2 2]
    Polygon "vertex point P" [1.5 0 0  1.5 0 2  1.5 2 2  1.5 2 0]
    Polygon "vertex point P" [-1.5 0 -0.2  1.5 0 -0.2  1.5 2 -0.2  -1.5 2 -0.2]
  )");
  text.replace(text.find("[16]"), 4, "[256]");
  const auto with = [](Method m) {
    m.sets.emplace_back("integrator.maxIndirectBounces", "0");
    return m;
  };
  const auto varianceWith = [&](const Method& m) {
    Workshop stage;
    return renderAll(stage, text, with(m), 100, 24).at("Ci").meanVariance();
  };
  // of pixels, between two seeds
  const auto noiseWith = [&](const Method& m) {
    image::Image pictures[2];
    for (uint32_t seed = 0; seed < 2; ++seed) {
      Workshop stage;
      render::Settings s;
      s.seed = 7 + seed;
      s.integrator = m.integrator;
      s.sets = with(m).sets;
      pictures[seed] = pictureOf(*stage.load(sceneOf(text, stage.messages), s));
    }
    double sum = 0;
    for (size_t i = 0; i < pictures[0].pixels.size(); ++i)
      sum += std::pow(double(pictures[0].pixels[i]) - double(pictures[1].pixels[i]), 2);
    return sum;
  };
  // 24 seeds of 16 tiles tell a ratio of variances to a tenth
  EXPECT_LT(varianceWith(learned()), 0.85 * varianceWith(pathTracer(2)));
  // Of paths from both ends, whose splats move tiles more than light samples do.
  EXPECT_LT(noiseWith(learnedBy(vcm(true, false))), 0.9 * noiseWith(vcm(true, false)));
}

TEST(LearnedLights, OneLightOrNoneIsWhatItWas) {
  for (const std::string& lights : {std::string(kRect), std::string()}) {
    const auto stateWith = [&](const char* learns, const char* integrator = "") {
      Workshop stage;
      render::Settings s;
      s.threads = 1;
      s.integrator = integrator;
      s.sets = {{"integrator.learnLights", learns}};
      auto r = stage.load(sceneOf(room(lights, kGrey, kLearned), stage.messages), s);
      EXPECT_EQ(r->renderFilm(), render::Outcome::Complete);
      return stateOf(r->film());
    };
    EXPECT_EQ(stateWith("1"), stateWith("0"));
    EXPECT_EQ(stateWith("1", "PxrVCM"), stateWith("0", "PxrVCM"));
  }
}

}  // namespace
}  // namespace kinora::probes
