// Proves: a tail stepped at the events of a light path takes each state where the automaton goes that reads them one by
// one from the camera, for random paths under many expressions; tails are as many as the expressions read backwards
// need; too many are told and leave events out, no more. Misses: integrators' use of them (tests/probes).
#include "film/path_tails.h"

#include <gtest/gtest.h>

#include <random>

#include "film/light_paths.h"

namespace kinora::film {
namespace {

constexpr uint32_t kFlags[] = {kLobeDiffuse, kLobeSpecular, kLobeTransmit, kLobeTransmit | kLobeSpecular,
                               kLobeVolume};

uint16_t randomEvent(const LightPaths& p, std::mt19937& random) {
  const char* lobes[] = {"", "Subsurface", "Clearcoat"};
  const char* surfaces[] = {"", "chair"};
  return p.event(kFlags[random() % std::size(kFlags)], lobes[random() % 3], surfaces[random() % 2]);
}

// Connects random camera and light paths and compares; how many of them some expression took.
int compareWithSteps(const LightPaths& p) {
  const PathStates s = p.states();
  std::mt19937 random(1);
  int taken = 0;
  for (int k = 0; k < 20000; ++k) {
    const uint32_t before = random() % 4, after = random() % 20;
    std::vector<uint16_t> light;
    uint32_t state = s.start, tail = 0;
    for (uint32_t i = 0; i <= before; ++i) state = s.next[state * s.eventCount + randomEvent(p, random)];
    for (uint32_t i = 0; i < after; ++i) {
      light.push_back(randomEvent(p, random));
      tail = s.nextTail[tail * s.eventCount + light.back()];
    }
    const uint32_t joined = s.end[tail * s.stateCount + state];
    for (; !light.empty(); light.pop_back()) state = s.next[state * s.eventCount + light.back()];
    for (uint32_t end = 0; end < p.ends(); ++end) {
      EXPECT_EQ(p.outputs(joined, end), p.outputs(state, end));
      taken += !p.outputs(state, end).empty();
    }
    if (testing::Test::HasFailure()) return taken;
  }
  return taken;
}

TEST(PathTails, TakeStatesWhereTheEventsDo) {
  const std::vector<std::vector<std::string>> sets = {
      {"Ci"},
      {"Ci", "diffuse", "indirectDiffuse", "specular", "indirectSpecular", "subsurface", "transmissive", "volume"},
      {"lpe:C[DS]*S[DS]{2}<L.'key'>", "lpe:CD[S]+<L.>", "lpe:C[DS]{3}<L.>"},
      {"lpe:C<RD'chair'>[DS]*<L.>", "lpe:C<.D>[<TS>D]*<L.>", "lpe:CD[DS]+D[<L.>O]", "lpe:C.{4,7}<L.>"},
      {"lpe:C(DS)+<L.>", "lpe:C(SD)*S<L.>", "lpe:C[^D]*<L.>"}};
  for (const auto& sources : sets) {
    const LightPaths p(sources, false, LobeNumbers(), true);
    EXPECT_FALSE(p.tails().isTooLarge()) << sources[0];
    EXPECT_GT(compareWithSteps(p), 100) << sources[0];
  }
}

TEST(PathTails, AreNoMoreThanNeeded) {
  EXPECT_EQ(LightPaths({"Ci"}, false, LobeNumbers(), true).tails().count(), 1u) << "every path is taken";
  // none, one event, more
  EXPECT_EQ(LightPaths({"lpe:C[DS]{2}<L.>", "Ci"}, false, LobeNumbers(), true).tails().count(), 3u);
  EXPECT_EQ(LightPaths({"Ci", "indirectDiffuse"}, false).tails().count(), 0u) << "where no paths come from lights";
}

TEST(PathTails, TooManyAreToldAndEventsLeftOut) {
  // which of the twenty events before an S are D: 2^20 functions
  const LightPaths p({"lpe:CD[DS]{20}D[DS]*<L.>", "Ci"}, false, LobeNumbers(), true);
  ASSERT_FALSE(p.isTooLarge());
  EXPECT_TRUE(p.tails().isTooLarge());
  EXPECT_LE(p.tails().end().size(), PathTails::kMostNumbers);
  EXPECT_LE(p.tails().next().size(), PathTails::kMostNumbers);
  const PathStates s = p.states();
  std::mt19937 random(1);
  for (int k = 0; k < 1000; ++k) {
    uint32_t tail = 0;
    for (uint32_t i = 0; i < 40; ++i) tail = s.nextTail[tail * s.eventCount + randomEvent(p, random)];
    const uint32_t first = s.next[s.start * s.eventCount + randomEvent(p, random)];
    const std::vector<uint16_t>& outputs = p.outputs(s.end[tail * s.stateCount + first], 1);
    EXPECT_NE(std::find(outputs.begin(), outputs.end(), uint16_t(1)), outputs.end()) << "beauty takes all";
  }
}

}  // namespace
}  // namespace kinora::film
