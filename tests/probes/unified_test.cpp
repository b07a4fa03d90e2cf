// PxrUnified renders what the integrator renders that its parameters choose, bit for bit, and says which of them it
// knows by name only.
#include <string>
#include <vector>

#include "tests/probes/probe_support.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

using Sets = std::vector<std::pair<std::string, std::string>>;

std::vector<int64_t> filmOf(const std::string& integrator, const Sets& sets, std::string* said = nullptr) {
  Workshop stage;
  render::Settings s;
  s.threads = 2;
  s.integrator = integrator;
  s.sets = sets;
  const auto r = stage.load(sceneOf(room(std::string(kRect) + kPoint, kGlass), stage.messages), s);
  EXPECT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
  if (said) *said = stage.said;
  return stateOf(r->film());
}

// What both are given, each by its own defaults where they differ.
const Sets kCommon{{"integrator.maxIndirectBounces", "3"}, {"integrator.numLightSamples", "2"}};
Sets with(Sets more) {
  more.insert(more.end(), kCommon.begin(), kCommon.end());
  return more;
}
const Sets kDefaults{{"integrator.rouletteDepth", "1"}, {"integrator.clampLuminance", "8"}};

const Sets kForward{
    {"integrator.rouletteDepth", "1"}, {"integrator.clampLuminance", "8"}, {"integrator.accumOpacity", "1"}};

TEST(Unified, IsThePathTracerWithoutLightPaths) {
  std::string said;
  const auto unified = filmOf("PxrUnified", with({{"integrator.numIndirectSamples", "2"}}), &said);
  EXPECT_EQ(said, "");
  Sets same = with(kForward);
  same.emplace_back("integrator.numIndirectSamples", "2");
  EXPECT_TRUE(unified == filmOf("PxrPathTracer", same));
  EXPECT_FALSE(unified == filmOf("PxrPathTracer", with(kForward)));  // that the film tells them apart
}

TEST(Unified, IsConnectionAndMergingByTheChoiceOfLightPaths) {
  std::vector<std::vector<int64_t>> films;
  for (const int choice : {1, 2, 3}) {
    std::string said;
    films.push_back(filmOf("PxrUnified", with({{"integrator.traceLightPaths", std::to_string(choice)}}), &said));
    EXPECT_EQ(said, "");
    Sets same = with(kDefaults);
    same.emplace_back("integrator.connectPaths", choice & 1 ? "1" : "0");
    same.emplace_back("integrator.mergePaths", choice & 2 ? "1" : "0");
    EXPECT_TRUE(films.back() == filmOf("PxrVCM", same)) << "traceLightPaths " << choice;
  }
  EXPECT_FALSE(films[0] == films[1] || films[1] == films[2] || films[0] == films[2]);
}

TEST(Unified, LearnsAsThePathTracerDoes) {
  for (const Sets& wanted : {Sets{{"integrator.risPathGuiding", "1"}}, Sets{{"integrator.learnLights", "1"}},
                             Sets{{"integrator.numLightCandidates", "4"}}}) {
    Sets unified = with(wanted), same = with(kForward);
    unified.emplace_back("integrator.indirectTrainingSamples", "4");
    same.insert(same.end(), wanted.begin(), wanted.end());
    same.emplace_back("integrator.guidingSamples", "4");
    std::string said;
    const auto film = filmOf("PxrUnified", unified, &said);
    EXPECT_TRUE(film == filmOf("PxrPathTracer", same)) << wanted[0].first;
    EXPECT_FALSE(film == filmOf("PxrUnified", with({}))) << wanted[0].first << " does nothing";
    EXPECT_EQ(said, "");
    // of this only lights are learned where there are light paths
    Sets both = with({{"integrator.traceLightPaths", "1"}, {"integrator.indirectTrainingSamples", "4"}});
    const auto plain = filmOf("PxrUnified", both);
    both.insert(both.end(), wanted.begin(), wanted.end());
    EXPECT_EQ(filmOf("PxrUnified", both) == plain, wanted[0].first != "integrator.learnLights") << wanted[0].first;
  }
}

TEST(Unified, LearnsLightsAsConnectionsDo) {
  Sets unified = with({{"integrator.traceLightPaths", "1"}, {"integrator.indirectTrainingSamples", "4"}}),
       same = with(kDefaults);
  same.insert(same.end(), {{"integrator.mergePaths", "0"}, {"integrator.guidingSamples", "4"}});
  for (Sets* s : {&unified, &same}) s->emplace_back("integrator.learnLights", "1");
  EXPECT_TRUE(filmOf("PxrUnified", unified) == filmOf("PxrVCM", same));
}

TEST(Unified, PassesMergingInMediaOn) {
  const std::string fog = R"(Integrator "PxrUnified" "i" "int traceLightPaths" [3] "int maxIndirectBounces" [3] )";
  const auto film = [&](const std::string& integrator) {
    std::string text = room(kPoint, kGrey, "", R"(
  AttributeBegin
    Bxdf "PxrVolume" "fog" "float densityFloat" [0.5] "int multiScatter" [1]
    Volume "box" [-1.5 1.5 0 2 0 2] [0 0 0]
  AttributeEnd
)");
    Workshop stage;
    render::Settings s;
    s.threads = 2;
    const auto r = stage.load(sceneOf(integrator + "\n" + text, stage.messages), s);
    EXPECT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
    EXPECT_EQ(stage.said, "");
    return stateOf(r->film());
  };
  const std::string media = "\"int mergeMedia\" [3] \"float mediaRadius\" [8] \"float reduceMediaRadius\" [1]";
  const auto merged = film(fog + media);
  EXPECT_FALSE(merged == film(fog));
  EXPECT_TRUE(merged == film("Integrator \"PxrVCM\" \"i\" \"int maxIndirectBounces\" [3] \"int rouletteDepth\" [1] "
                             "\"float clampLuminance\" [8] " +
                             media));
}

TEST(Unified, SaysWhatHasNoEffect) {
  std::string said;
  const auto film =
      filmOf("PxrUnified", with({{"integrator.useTraceDepth", "1"}, {"integrator.photonAdaptive", "1"}}), &said);
  EXPECT_NE(said.find("PARAM-NO-EFFECT"), std::string::npos) << said;
  for (const char* name : {"'useTraceDepth'", "'photonAdaptive'"})
    EXPECT_NE(said.find(name), std::string::npos) << said;
  EXPECT_EQ(said.find("maxIndirectBounces"), std::string::npos) << said;
  EXPECT_TRUE(film == filmOf("PxrUnified", kCommon));
}

// What belongs to the other way of rendering is told, where a scene asks for it.
TEST(Unified, SaysWhatHasNoEffectWithLightPathsOrWithout) {
  struct Case {
    const char *name, *value;
    bool isOfForward;
  };
  const std::string usual = "integrator.maxRayDistance";
  for (const Case& c :
       {Case{"numIndirectSamples", "2", true}, Case{"catchAllLights", "0.5", true}, Case{"causticClamp", "3", true},
        Case{"manifoldWalk", "1", true}, Case{"maxRayDistance", "50", true}, Case{"risPathGuiding", "1", true},
        Case{"numLightCandidates", "2", true}, Case{"numVolumeAggregateSamples", "2", true},
        Case{"rouletteLightDepth", "3", false}, Case{"mergeMedia", "1", false}, Case{"keptPaths", "0.5", false}})
    for (const bool isForward : {true, false}) {
      Workshop stage;
      render::Settings s;
      s.threads = 1;
      s.integrator = "PxrUnified";
      s.sets = {{std::string("integrator.") + c.name, c.value},
                {"integrator.traceLightPaths", isForward ? "0" : "1"}};
      stage.load(sceneOf(room(kPoint, kGrey), stage.messages), s);
      const bool isTold = stage.said.find("PARAM-NO-EFFECT") != std::string::npos &&
                          stage.said.find("'" + std::string(c.name) + "'") != std::string::npos;
      EXPECT_EQ(isTold, c.isOfForward != isForward) << c.name << " " << stage.said;
    }
  // nor what is as it is anyway, or off
  for (const char* distance : {"10000", "0", "1e30"}) {
    std::string said;
    filmOf("PxrUnified", with({{usual, distance}, {"integrator.traceLightPaths", "1"}}), &said);
    EXPECT_EQ(said, "") << distance;
  }
}

TEST(Unified, TakesTheDefaultForAChoiceThatThereIsNot) {
  std::string said;
  const auto film = filmOf("PxrUnified", with({{"integrator.traceLightPaths", "7"}}), &said);
  EXPECT_NE(said.find("PARAM-CHOICE"), std::string::npos) << said;
  EXPECT_NE(said.find("traceLightPaths"), std::string::npos) << said;
  EXPECT_TRUE(film == filmOf("PxrUnified", kCommon));
}

TEST(Unified, SameBits) {
  expectSameBits({}, "Integrator \"PxrUnified\" \"i\" \"int traceLightPaths\" [3]\n" + roomOfEverything(), "");
}

}  // namespace
}  // namespace kinora::probes
