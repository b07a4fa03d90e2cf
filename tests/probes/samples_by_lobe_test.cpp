// PxrPathTracer's sampleMode manual: numbers of directions by kind of lobe at what the camera sees. The mean is that of
// one direction for all, whatever the numbers; they lower the noise of their own kind. It misses what a number costs.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

Method manual(int diffuse, int specular, int refraction, int subsurface, bool caustics = true) {
  Method m = pathTracer();
  if (!caustics) m.sets.pop_back();
  m.sets.insert(m.sets.end(), {{"integrator.sampleMode", "manual"},
                               {"integrator.numDiffuseSamples", std::to_string(diffuse)},
                               {"integrator.numSpecularSamples", std::to_string(specular)},
                               {"integrator.numRefractionSamples", std::to_string(refraction)},
                               {"integrator.numSubsurfaceSamples", std::to_string(subsurface)}});
  return m;
}
const char* const kPlastic = R"(Bxdf "PxrSurface" "plastic" "color diffuseColor" [0.6 0.3 0.2]
    "int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1] "color specularIor" [1.8 1.8 1.8]
    "float specularRoughness" [0.25])";
const char* const kWax = R"(Bxdf "PxrSurface" "wax" "float diffuseGain" [0.3] "float subsurfaceGain" [0.7]
    "color subsurfaceColor" [0.8 0.6 0.5] "float subsurfaceDmfp" [0.2] "color subsurfaceDmfpColor" [1 0.5 0.3]
    "int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1] "color specularIor" [1.5 1.5 1.5])";

TEST(SamplesByLobe, LeaveTheMean) {
  Workshop stage;
  struct {
    const char *what, *lights, *ball, *more;
    bool caustics;
  } const kRooms[] = {{"plastic, rectangle", kRect, kPlastic, "", true},
                      {"glass, sphere", kSphere, kGlass, "", false},
                      {"rough glass, dome", kDome, kRoughGlass, "", true},
                      {"rough glass, sphere, tinted", kSphere, kRoughGlass, "", false},
                      {"wax, rectangle", kRect, kWax, "", true},
                      {"plastic, sun", kSun, kPlastic, "", true},
                      {"fog, mesh", kMesh, kPlastic, kFog, true}};
  for (const auto& r : kRooms) {
    const std::string text = room(r.lights, r.ball, "", r.more);
    Method one = pathTracer();
    if (!r.caustics) one.sets.pop_back();
    expectEqual(renderAll(stage, text, manual(4, 3, 5, 2, r.caustics), 300, 12), renderAll(stage, text, one, 100, 16),
                r.what, 0.1);
  }
}

std::vector<int64_t> filmOf(const std::string& text, const Method& method, std::string* said = nullptr) {
  Workshop stage;
  render::Settings s;
  s.threads = 2;
  s.integrator = method.integrator;
  s.sets = method.sets;
  const auto r = stage.load(sceneOf(text, stage.messages), s);
  EXPECT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
  if (said) *said = stage.said;
  return stateOf(r->film());
}

TEST(SamplesByLobe, OneOfEachIsTheOtherMode) {
  const std::string text = room(std::string(kRect) + kDome, kWax, "", kFog);
  EXPECT_TRUE(filmOf(text, manual(1, 1, 1, 1)) == filmOf(text, pathTracer()));
  EXPECT_FALSE(filmOf(text, manual(2, 1, 1, 1)) == filmOf(text, pathTracer()));  // that the film tells them apart
}

TEST(SamplesByLobe, LowerTheNoiseOfTheirKindAlone) {
  Workshop stage;
  const std::string text = room(kDome, kRoughGlass);
  // over seeds, of tiles: indirect light of the wall, and of the one that the ball fills
  const auto variance = [&](const Method& m) {
    const std::vector<testing::Moments> tiles = renderAll(stage, text, m, 500, 64).at("indirect").tiles;
    return std::pair(std::pow(tiles[5].standardError(), 2), std::pow(tiles[10].standardError(), 2));
  };
  const auto one = variance(manual(1, 1, 1, 1, false)), diffuse = variance(manual(8, 1, 1, 1, false)),
             refraction = variance(manual(1, 1, 8, 1, false));
  EXPECT_LT(diffuse.first, 0.4 * one.first);
  EXPECT_GT(diffuse.second, 0.5 * one.second);  // the ball has nothing diffuse
  EXPECT_LT(refraction.second, 0.6 * one.second);
  EXPECT_GT(refraction.first, 0.5 * one.first);
}

TEST(SamplesByLobe, SameBits) {
  expectSameBits({},
                 R"(Integrator "PxrPathTracer" "i" "string sampleMode" ["manual"] "int numDiffuseSamples" [3]
      "int numSpecularSamples" [2] "int numRefractionSamples" [4] "int numSubsurfaceSamples" [2])" +
                     room(std::string(kRect) + kSun + kDome, kGlass, kLens, kFog),
                 "");
}

TEST(SamplesByLobe, GuidedToo) {
  Workshop stage;
  const std::string text = room(kRect, kPlastic);
  Method guided = manual(4, 2, 1, 1);
  guided.sets.insert(guided.sets.end(), {{"integrator.risPathGuiding", "1"}, {"integrator.guidingSamples", "4"}});
  expectEqual(renderAll(stage, text, guided, 700, 12), renderAll(stage, text, pathTracer(), 100, 16), "guided", 0.1);
}

TEST(SamplesByLobe, BadValuesAreTold) {
  std::string said;
  filmOf(room(kPoint, kGrey), manual(1, 1, 1, 100), &said);
  EXPECT_NE(said.find("numSubsurfaceSamples is 100"), std::string::npos) << said;
  Method m = manual(0, 1, 1, 1);
  filmOf(room(kPoint, kGrey), m, &said);
  EXPECT_NE(said.find("numDiffuseSamples is 0"), std::string::npos) << said;
  m.sets.emplace_back("integrator.sampleMode", "automatic");
  const auto film = filmOf(room(kPoint, kGrey), m, &said);
  EXPECT_NE(said.find("PARAM-CHOICE"), std::string::npos) << said;
  EXPECT_TRUE(film == filmOf(room(kPoint, kGrey), pathTracer()));
}

}  // namespace
}  // namespace kinora::probes
