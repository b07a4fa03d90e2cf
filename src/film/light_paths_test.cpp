// Proves: the grammar of light path expressions, read by an independent walk (a backtracking matcher over the same
// tree is not enough: words are spelled out and checked by hand-made tables and by the C++ library's regular
// expressions); that malformed texts name their place; that the automaton's numbers do not depend on anything but the
// expressions; that the standard set is disjoint and holds every path. Misses: whether integrators step it rightly
// (tests/probes, tests/bits).
#include "film/light_paths.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <regex>

namespace kinora::film {
namespace {

struct Event {
  uint32_t flags;
  const char* lobe = "";
  const char* surface = "";
};
constexpr Event RD{kLobeDiffuse}, RS{kLobeSpecular}, TD{kLobeTransmit}, TS{kLobeTransmit | kLobeSpecular},
    VD{kLobeVolume};

// Indices of the sources that a path adds to. `light`: its group, "-" for glow.
std::vector<uint16_t> walk(const LightPaths& p, const std::vector<Event>& path, const std::string& light = "") {
  const PathStates s = p.states();
  uint32_t state = s.start;
  for (const Event& e : path) state = s.next[state * s.eventCount + p.event(e.flags, e.lobe, e.surface)];
  return p.outputs(state, light == "-" ? LightPaths::kGlow : p.end(light));
}
bool matches(const std::string& expression, const std::vector<Event>& path, const std::string& light = "") {
  PathSyntaxError error;
  EXPECT_TRUE(LightPaths::parse("lpe:" + expression, error)) << expression << ": " << error.what;
  const LightPaths p({"lpe:" + expression}, false);
  return !walk(p, path, light).empty();
}

TEST(LightPathExpression, EventsSetsAndOperators) {
  EXPECT_TRUE(matches("CO", {}, "-"));
  EXPECT_TRUE(matches("CO", {}, "")) << "a light that the camera sees is an emissive object";
  EXPECT_FALSE(matches("CL", {})) << "and nothing else: what sums CL and CO counts it once";
  EXPECT_FALSE(matches("C<L.'key'>", {}, "key"));
  EXPECT_TRUE(matches("C<O.'key'>", {}, "key")) << "the light's own group";
  EXPECT_FALSE(matches("C<O.'key'>", {}, "fill"));
  EXPECT_FALSE(matches("C<O.'key'>", {}, "-")) << "surfaces are in none";
  EXPECT_TRUE(matches("C[<L.>O]", {}, "key"));
  EXPECT_FALSE(matches("CDO", {RD}, "")) << "but not one that is found behind a bounce";
  EXPECT_FALSE(matches("CL", {}, "-"));
  EXPECT_FALSE(matches("CL", {RD}));
  EXPECT_TRUE(matches("C<RD>L", {RD}));
  EXPECT_FALSE(matches("C<RD>L", {TD}));
  EXPECT_TRUE(matches("C<.D>L", {TD}));
  EXPECT_TRUE(matches("CDL", {VD}));
  EXPECT_TRUE(matches("C<V.>L", {VD}));
  EXPECT_TRUE(matches("CVL", {VD}));
  EXPECT_FALSE(matches("CVL", {RD}));
  EXPECT_TRUE(matches("CRTL", {RS, TD}));
  EXPECT_TRUE(matches("C.L", {TS}));
  EXPECT_TRUE(matches("C.*", {TS, RD, RD})) << "\".\" takes the light as well";
  EXPECT_TRUE(matches("C[DS]L", {TS}));
  EXPECT_TRUE(matches("C[^D]L", {TS}));
  EXPECT_FALSE(matches("C[^D]L", {RD}));
  EXPECT_TRUE(matches("C<[RT]S>L", {TS}));
  EXPECT_TRUE(matches("C<T[S]>L", {TS}));
  EXPECT_FALSE(matches("C<T[^S]>L", {TS}));
  EXPECT_TRUE(matches("C<R>L", {RS}));
  EXPECT_TRUE(matches(" C < R S > * < L . > ", {RS, RS}));
  EXPECT_TRUE(matches("C<L.>|CDL", {RD}));
  EXPECT_TRUE(matches("C(DS|SD)+L", {RD, RS, RS, RD}));
  EXPECT_FALSE(matches("C(DS|SD)+L", {RD, RS, RS}));
  EXPECT_TRUE(matches("CD{2}L", {RD, RD}));
  EXPECT_FALSE(matches("CD{2}L", {RD}));
  EXPECT_TRUE(matches("CD{1,}L", {RD, RD, RD}));
  EXPECT_FALSE(matches("CD{1,2}L", {RD, RD, RD}));
  EXPECT_TRUE(matches("CD{0,2}L", {RD}));
  EXPECT_TRUE(matches("CD{0,2}O", {}));
  EXPECT_TRUE(matches("CD?S?L", {RS}));
  EXPECT_TRUE(matches("CD[S]+<L.>", {RD, RS, TS}));
  EXPECT_TRUE(matches("C(D[DS]*[LO])|[LO]", {}, "-")) << "the second alternative begins at the camera too";
  EXPECT_TRUE(matches("C(D[DS]*[LO])|[LO]", {RD, RS}));
  EXPECT_FALSE(matches("C(D[DS]*[LO])|[LO]", {RS}));
}

TEST(LightPathExpression, LobeNumbersLabelsAndGroups) {
  EXPECT_TRUE(matches("CS4L", {{kLobeSpecular, "Clearcoat"}}));
  EXPECT_FALSE(matches("CS4L", {{kLobeSpecular, "Specular"}}));
  EXPECT_TRUE(matches("C<RS2>L", {{kLobeSpecular, "Specular"}}));
  EXPECT_TRUE(matches("CS1L", {{kLobeSpecular, "Nameless"}})) << "lobes of no list are the first";
  EXPECT_TRUE(matches("CD2L", {{kLobeDiffuse, "Diffuse"}}));
  EXPECT_FALSE(matches("CD2L", {{kLobeSpecular, "Diffuse"}})) << "diffuse numbers are of diffuse lobes";
  EXPECT_TRUE(matches("C<RS'Clearcoat'>L", {{kLobeSpecular, "Clearcoat"}})) << "a label may be the lobe's name";
  EXPECT_TRUE(matches("C<.S\"floor\">L", {{kLobeSpecular, "Glass", "floor"}}));
  EXPECT_FALSE(matches("C<.S'floor'>L", {{kLobeSpecular, "Glass", "wall"}}));
  EXPECT_TRUE(matches("C<.[DS]'floor'>[^<.D'floor'>]L", {{kLobeDiffuse, "", "floor"}, {kLobeDiffuse, "", "wall"}}));
  EXPECT_FALSE(matches("C<.[DS]'floor'>[^<.D'floor'>]L", {{kLobeDiffuse, "", "floor"}, {kLobeDiffuse, "", "floor"}}));
  constexpr Event kMirror{kLobeSpecular, "", "collector"};
  EXPECT_TRUE(matches("reflectioncollector", {kMirror, RD}));
  EXPECT_TRUE(matches("reflectioncollector", {kMirror}, "-"));
  EXPECT_FALSE(matches("reflectioncollector", {kMirror})) << "no reflection of a thing";
  EXPECT_FALSE(matches("reflectioncollector", {RS, RD}));
  EXPECT_FALSE(matches("reflectioncollector", {{kLobeDiffuse, "", "collector"}, RD}));
  EXPECT_TRUE(matches("CD<L.'key'>", {RD}, "key"));
  EXPECT_TRUE(matches("CD<L'key'>", {RD}, "key"));
  EXPECT_FALSE(matches("CD<L.'key'>", {RD}, "fill"));
  EXPECT_FALSE(matches("CD<L.'key'>", {RD}, ""));
  EXPECT_TRUE(matches("CD[^<L.'key'>]", {RD}, "fill"));
  EXPECT_TRUE(matches("C[<L.'key'>O]", {}, "-"));
  // sets of labels, and what is without them
  for (const char* key : {"key", "rim"}) EXPECT_TRUE(matches("CD<L.['key' 'rim']>", {RD}, key));
  EXPECT_FALSE(matches("CD<L.['key' 'rim']>", {RD}, "fill"));
  EXPECT_TRUE(matches("CD<L.[^'key''rim']>", {RD}, "fill"));
  EXPECT_TRUE(matches("CD<L.[^'key']>", {RD}, "")) << "a light of no group";
  for (const char* key : {"key", "rim"}) EXPECT_FALSE(matches("CD<L.[^'key' 'rim']>", {RD}, key));
  EXPECT_FALSE(matches("CD<L.[^'key']>", {}, "fill")) << "it is still one event behind another";
  EXPECT_FALSE(matches("CD<L.[^'key']>*", {RD, RD}, "fill")) << "and a light";
  EXPECT_TRUE(matches("C[<L.[^'key']>O]", {}, "-"));
  EXPECT_TRUE(matches("CD[<L.[^'key']>O]", {RD}, "fill"));
  EXPECT_FALSE(matches("CD[<L.[^'key']>O]", {RD}, "key"));
  constexpr Event kFloor{kLobeDiffuse, "", "floor"}, kWall{kLobeDiffuse, "", "wall"};
  EXPECT_TRUE(matches("C<RD[^'floor']>L", {kWall}));
  EXPECT_FALSE(matches("C<RD[^'floor']>L", {kFloor}));
  EXPECT_FALSE(matches("C<RD[^'floor']>L", {RS})) << "the other places hold";
  EXPECT_FALSE(matches("C<RD[^'floor']>L", {{kLobeDiffuse | kLobeTransmit, "", "wall"}}));
  EXPECT_TRUE(matches("C<..[^'floor']>*L", {kWall, RS, TS}));
  EXPECT_FALSE(matches("C<..[^'floor']>*L", {kWall, RS, kFloor}));
  EXPECT_TRUE(matches("C<.D['floor' 'wall']>{2}L", {kWall, kFloor}));
  EXPECT_TRUE(matches("C<...>*<L..>", {kWall, TS})) << "a wildcard stands for any label";

  scene::ParameterList options;
  scene::Parameter p;
  p.name = "lpe:specular5";
  p.type = scene::ValueType::String;
  p.strings = {"Clearcoat, Own"};
  options.set(p);
  p.name = "lpe:specular4";
  p.strings = {""};
  options.set(p);
  const LightPaths moved({"lpe:CS4L", "lpe:CS5L"}, false, LobeNumbers(options));
  EXPECT_EQ(walk(moved, {{kLobeSpecular, "Clearcoat"}}), (std::vector<uint16_t>{1}));
  EXPECT_EQ(walk(moved, {{kLobeSpecular, "Own"}}), (std::vector<uint16_t>{1}));
}

TEST(LightPathExpression, UserLobesArePrefixesAndSignals) {
  const LightPaths p({"lpe:nothruput;noinfinitecheck;noclamp;unoccluded;overwrite;C<.S'passthru'>*((U2L)|O)",
                      "lpe:CU6L", "lpe:unoccluded;C[DS]+[LO]", "lpe:shadows;CDL", "lpe:C.*L"},
                     false);
  EXPECT_EQ(p.userLobes(0), 2u);
  EXPECT_EQ(p.userLobes(1), 32u);
  EXPECT_EQ(p.userLobes(4), 0u) << "signals are meant only where they are named";
  EXPECT_EQ(p.light(2), PathLight::Unoccluded);
  EXPECT_EQ(p.light(3), PathLight::Blocked);
  EXPECT_TRUE(p.wantsUnshadowed());
  EXPECT_FALSE(LightPaths({"lpe:unoccluded;C((U2L)|O)"}, false).wantsUnshadowed()) << "nothing there can be shadowed";
}

TEST(LightPathExpression, MistakesNameTheirPlace) {
  const std::tuple<const char*, size_t, const char*> table[] = {{"lpe:", 4, "no expression"},
                                                                {"lpe:D", 4, "begins with C"},
                                                                {"lpe:CD(", 7, "missing"},
                                                                {"lpe:C(DL", 5, "not closed"},
                                                                {"lpe:C[DS", 5, "not closed"},
                                                                {"lpe:C<RD", 5, "not closed"},
                                                                {"lpe:CX", 5, "no event"},
                                                                {"lpe:C<XD>", 6, "type of the event"},
                                                                {"lpe:C<RX>L", 7, "the event"},
                                                                {"lpe:CD)L", 6, "closes nothing"},
                                                                {"lpe:CL*DCL", 8, "beginning only"},
                                                                {"lpe:C[]L", 5, "empty"},
                                                                {"lpe:CD{3,1}L", 6, "before it begins"},
                                                                {"lpe:CD{99}L", 7, "at most 64"},
                                                                {"lpe:CD{L", 7, "number"},
                                                                {"lpe:CD5L", 6, "1 to 4"},
                                                                {"lpe:CS9L", 6, "1 to 8"},
                                                                {"lpe:C<RD'floor>L", 8, "quotation"},
                                                                {"lpe:<C'x'>L", 6, "no label"},
                                                                {"lpe:shadow;CL", 4, "no prefix"},
                                                                {"lpe:C|", 6, "missing"},
                                                                {"lpe:[CL]", 5, "set"},
                                                                {"lpe:C<RD''>L", 8, "empty"},
                                                                {"lpe:C<RDL>", 8, "\">\""}};
  for (const auto& [text, column, what] : table) {
    PathSyntaxError error;
    EXPECT_FALSE(LightPaths::parse(text, error)) << text;
    EXPECT_EQ(error.column, column) << text << ": " << error.what;
    EXPECT_NE(error.what.find(what), std::string::npos) << text << ": " << error.what;
  }
  EXPECT_EQ(caretBelow("lpe:C<RD", 5), "\x1e    lpe:C<RD\x1e         ^");
  EXPECT_EQ(caretBelow(std::string(200, 'x'), 100).size(), 2 * 4 + 2 + 120 + 3 + 3 + 3 + 60 + 1);
  PathSyntaxError error;
  EXPECT_FALSE(LightPaths::parse("lpe:C" + std::string(100, '('), error));
  EXPECT_FALSE(LightPaths::parse("lpe:C" + std::string(5000, 'D'), error));
}

TEST(LightPaths, WhatIsTooLargeOrMatchesNothingIsTold) {
  std::string deep = "D";
  for (int i = 0; i < 6; ++i) deep = "(" + deep + "S?){0,64}";
  const LightPaths p({"lpe:CDL", "lpe:C" + deep + "L"}, false);
  EXPECT_TRUE(p.isTooLarge());
  EXPECT_EQ(p.unmatched(), (std::vector<uint16_t>{1}));
  EXPECT_EQ(walk(p, {RD}), (std::vector<uint16_t>{0})) << "the others are as they were";
  // 2^20 states if it were determined: it is refused in bounded time
  EXPECT_TRUE(LightPaths({"lpe:C[DS]*D[DS]{20}L"}, false).isTooLarge());
  const LightPaths empty({"lpe:CD", "Ci"}, false);
  EXPECT_FALSE(empty.isTooLarge());
  EXPECT_EQ(empty.unmatched(), (std::vector<uint16_t>{0}));
}

TEST(LightPaths, TellsEventsApartOnlyAsFarAsNeeded) {
  const auto events = [](const std::vector<std::string>& sources, bool split = false) {
    const LightPaths p(sources, split);
    std::set<uint16_t> all;
    for (const Event& e : {RD, RS, TD, TS, Event{kLobeSpecular, "Clearcoat"}}) all.insert(p.event(e.flags, e.lobe));
    return all.size();
  };
  EXPECT_EQ(events({"Ci", "emissive", "a"}), 1u);
  EXPECT_EQ(events({"Ci"}, true), 2u) << "lights differ for diffuse and specular";
  EXPECT_EQ(events({"Ci", "directDiffuse"}), 2u);
  EXPECT_EQ(events({"Ci", "lpe:CS4L"}), 2u);
  EXPECT_EQ(events({"directDiffuse", "specular", "subsurface", "transmissive"}), 4u);
  const LightPaths p({"directDiffuse", "lpe:C<RD>+L"}, true);
  EXPECT_TRUE(p.event(kLobeSpecular) & 1);
  EXPECT_FALSE(p.event(kLobeDiffuse) & 1);
}

// Every path of up to 4 bounces is in exactly one of the disjoint set, and in beauty.
TEST(LightPaths, StandardSetIsDisjointAndWhole) {
  const std::vector<std::string> names{"emissive",     "diffuse",          "indirectDiffuse",
                                       "specular",     "indirectSpecular", "subsurface",
                                       "transmissive", "volume",           "beauty"};
  const LightPaths p(names, false);
  std::vector<Event> path;
  int checked = 0;
  const std::function<void()> all = [&] {
    for (const char* light : {"", "-"}) {
      const std::vector<uint16_t> out = walk(p, path, light);
      ASSERT_EQ(out.size(), 2u);
      EXPECT_EQ(out[1], 8u);
      ++checked;
    }
    if (path.size() == 4) return;
    for (const Event& e : {RD, RS, TD, TS, VD}) {
      path.push_back(e);
      all();
      path.pop_back();
    }
  };
  all();
  EXPECT_EQ(checked, 2 * (1 + 5 + 25 + 125 + 625));
  // upper case does not matter, and lpe:NAME is the same name
  EXPECT_TRUE(LightPaths::knows("DirectDiffuse"));
  EXPECT_EQ(walk(LightPaths({"lpe:indirectdiffuse"}, false), {RD, RS}).size(), 1u);
  EXPECT_FALSE(LightPaths::knows("P"));
}

// Random expressions against std::regex over letters: a independent reading of the operators. Bounces are written as
// d s (reflected), e z (transmitted); the light is l.
TEST(LightPaths, AgreesWithAnotherMatcherOnRandomExpressions) {
  std::mt19937 random(7);
  const auto pick = [&](int n) { return int(random() % uint32_t(n)); };
  const std::pair<const char*, const char*> atoms[] = {{"D", "[de]"},         {"S", "[sz]"},    {"<RD>", "d"},
                                                       {"<TS>", "z"},         {"[^D]", "[sz]"}, {"R", "[ds]"},
                                                       {"[<RD><TS>]", "[dz]"}};
  std::function<std::pair<std::string, std::string>(int)> make =
      [&](int depth) -> std::pair<std::string, std::string> {
    if (depth == 0 || pick(3) == 0) {
      const auto& [a, b] = atoms[pick(7)];
      return {a, b};
    }
    const auto x = make(depth - 1), y = make(depth - 1);
    switch (pick(6)) {
      case 0:
        return {"(" + x.first + "|" + y.first + ")", "(" + x.second + "|" + y.second + ")"};
      case 1:
        return {"(" + x.first + ")*", "(" + x.second + ")*"};
      case 2:
        return {"(" + x.first + ")+", "(" + x.second + ")+"};
      case 3:
        return {"(" + x.first + ")?" + y.first, "(" + x.second + ")?" + y.second};
      case 4:
        return {"(" + x.first + "){1,2}", "(" + x.second + "){1,2}"};
      default:
        return {x.first + y.first, x.second + y.second};
    }
  };
  std::vector<std::string> sources;
  std::vector<std::regex> judges;
  for (int i = 0; i < 12; ++i) {
    const auto [a, b] = make(2);
    // "[^D]" takes lights as well, which the letters do not say: nothing may follow it but L
    sources.push_back("lpe:C(" + a + ")L");
    judges.emplace_back("^(" + b + ")l$");
  }
  const LightPaths together(sources, false);
  ASSERT_FALSE(together.isTooLarge());
  const Event events[] = {RD, RS, TD, TS};
  const char letters[] = {'d', 's', 'e', 'z'};
  int matched = 0;
  for (int word = 0; word < 341; ++word) {  // all words of up to 4 letters
    int length = 0, n = word;
    for (int count = 1; n >= count; n -= count, count *= 4) ++length;
    std::vector<Event> path;
    std::string text;
    for (int k = 0; k < length; ++k, n /= 4) {
      path.push_back(events[n % 4]);
      text += letters[n % 4];
    }
    const std::vector<uint16_t> out = walk(together, path);
    for (uint16_t i = 0; i < sources.size(); ++i) {
      const bool expected = length > 0 && std::regex_match(text + "l", judges[i]);  // a light seen itself is O
      matched += expected;
      ASSERT_EQ(std::find(out.begin(), out.end(), i) != out.end(), expected) << sources[i] << " on " << text;
    }
  }
  EXPECT_GT(matched, 50);
  // again, from the same text: the same numbers
  const LightPaths again(sources, false);
  ASSERT_EQ(again.stateCount(), together.stateCount());
  ASSERT_EQ(again.states().eventCount, together.states().eventCount);
  for (uint32_t i = 0; i < again.stateCount() * again.states().eventCount; ++i)
    ASSERT_EQ(again.states().next[i], together.states().next[i]);
}

}  // namespace
}  // namespace kinora::film
