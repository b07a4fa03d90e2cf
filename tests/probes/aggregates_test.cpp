// Volumes in named aggregates and lights of media: an integrator that asks for names renders the same bits as a scene
// without the other volumes, by kind of ray as `visibility` does; what is asked for in vain is told. Media are lit by the
// lights that their objects are linked to, and light that comes straight from a light is shadowed alike whichever way it
// was found. PxrVCM has these in tests/probes/vcm_media_test.cpp.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

const char* const kHigh = "[-1.6 1.6 0.9 2.1 -0.2 2.1]";
const char* const kLow = "[-1.2 0.8 0 1.2 0.2 1.4]";
// attributes: before the volume
std::string volume(const std::string& attributes, const char* bound, const char* material) {
  return "  AttributeBegin\n    " + attributes + "\n    Bxdf \"PxrVolume\" \"fog\" " + material +
         "\n    Volume \"box\" " + bound + " [0 0 0]\n  AttributeEnd\n";
}
std::string high(const std::string& attributes) {
  return volume(attributes, kHigh, "\"color densityColor\" [0.4 0.6 0.9]");
}
std::string low(const std::string& attributes) {
  return volume(attributes, kLow, "\"float densityFloat\" [1.2] \"int multiScatter\" [1]");
}
std::string aggregate(const std::string& names) {
  return "Attribute \"volume\" \"string aggregate\" [\"" + names + "\"]";
}

struct Rendered {
  std::vector<int64_t> bits;
  std::string said;
};
Rendered rendered(const std::string& volumes, const Sets& more = {}, const char* integrator = "PxrPathTracer") {
  Workshop stage;
  render::Settings s;
  s.threads = 2;
  s.integrator = integrator;
  s.sets = more;
  const auto r = stage.load(sceneOf(room(kRect, kGrey, "", volumes), stage.messages), s);
  EXPECT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
  return {stateOf(r->film()), stage.said};
}
Sets asking(const std::string& names) { return {{"integrator.volumeAggregate", names}}; }

TEST(Aggregates, RaysKnowThoseThatAreAskedFor) {
  const std::string both = high("") + low("");
  const Rendered all = rendered(both), first = rendered(high("")), second = rendered(low("")), none = rendered("");
  EXPECT_FALSE(all.bits == first.bits || all.bits == second.bits || first.bits == none.bits);
  const std::string named = high(aggregate("clouds")) + low(aggregate("ground mist"));
  for (const char* integrator : {"PxrPathTracer", "PxrVCM", "PxrUnified"}) {
    const auto same = [&](const Rendered& one, const std::string& volumes) {
      return one.bits == rendered(volumes, {}, integrator).bits;
    };
    EXPECT_TRUE(same(rendered(named, asking("clouds mist"), integrator), both)) << integrator;
    EXPECT_TRUE(same(rendered(named, asking("clouds,ground,mist"), integrator), both)) << integrator;
    EXPECT_TRUE(same(rendered(named, asking("clouds"), integrator), high(""))) << integrator;
    EXPECT_TRUE(same(rendered(named, asking("mist"), integrator), low(""))) << integrator;
    EXPECT_TRUE(same(rendered(named, {}, integrator), "")) << integrator;  // globalVolumeAggregate
  }
  // an array of names is the same
  EXPECT_TRUE(
      rendered(high("Attribute \"volume\" \"string[2] aggregate\" [\"x\" \"clouds\"]"), asking("clouds")).bits ==
      first.bits);
  // what is in none is there whatever is asked for, and so is everything to integrators that ask for nothing by name
  EXPECT_TRUE(rendered(high(aggregate("")) + low(aggregate("mist")), asking("clouds")).bits == first.bits);
  EXPECT_TRUE(rendered(named, {}, "PxrDirectLighting").bits == rendered(both, {}, "PxrDirectLighting").bits);
}

// Files of when nothing was in an aggregate that did not say so ask for "".
TEST(Aggregates, AskingForNoneLeavesOutWhatSaysItsOwn) {
  const Rendered r = rendered(high("") + low(aggregate("mist")), asking(""));
  EXPECT_TRUE(r.bits == rendered(high("")).bits);
  EXPECT_NE(r.said.find("MEDIUM-LEFT-OUT"), std::string::npos) << r.said;
}

TEST(Aggregates, KindsOfRaysMayAskForOthers) {
  const auto visible = [](int camera, int indirect, int transmission) {
    return "Attribute \"visibility\" \"int camera\" [" + std::to_string(camera) + "] \"int indirect\" [" +
           std::to_string(indirect) + "] \"int transmission\" [" + std::to_string(transmission) + "]";
  };
  struct Case {
    const char* parameter;
    int camera, indirect, transmission;
  };
  for (const Case& c : {Case{"Camera", 1, 0, 0}, Case{"Indirect", 0, 1, 0}, Case{"Transmission", 0, 0, 1}}) {
    const Rendered r =
        rendered(high("") + low(aggregate("mist")),
                 {{std::string("integrator.volumeAggregate") + c.parameter, "mist globalVolumeAggregate"}});
    EXPECT_TRUE(r.bits == rendered(high("") + low(visible(c.camera, c.indirect, c.transmission))).bits)
        << c.parameter;
    EXPECT_EQ(r.said, "");
  }
  // both rules hold, unless the volume does without its visibility
  const std::string unseen = visible(0, 1, 1), mist = aggregate("mist");
  EXPECT_TRUE(rendered(low(unseen + mist), asking("mist")).bits == rendered(low(unseen)).bits);
  EXPECT_TRUE(
      rendered(low(unseen + mist + " Attribute \"volume\" \"int aggregaterespectvisibility\" [0]"), asking("mist"))
          .bits == rendered(low("")).bits);
}

// Surfaces that have an aggregate for their inside ask for it there, for every integrator: a volume that ends before the
// surface is as it is anywhere, bit for bit, and one that goes on beyond is cut off (how, tests/truth/interiors_test.cpp
// measures).
TEST(Aggregates, SurfacesAskForTheirInside) {
  const auto glass = [](const char* name) {
    return std::string(
               "  AttributeBegin\n    Bxdf \"PxrSurface\" \"g\" \"float diffuseGain\" [0] \"float "
               "refractionGain\" [1] \"float reflectionGain\" [1] \"float glassIor\" [1.3] \"string "
               "volumeAggregateName\" [\"") +
           name + "\"]\n    Translate -0.6 0.5 0.8\n    Sphere 0.4 -0.4 0.4 360\n  AttributeEnd\n";
  };
  const auto within = [](const std::string& attributes) {
    return volume(attributes, "[-0.8 -0.4 0.3 0.7 0.6 1]", "\"float densityFloat\" [2] \"int multiScatter\" [1]");
  };
  // a surface that asks for any is a mesh of its own, which rounds otherwise
  const std::string mist = aggregate("mist");
  for (const char* integrator : {"PxrPathTracer", "PxrVCM", "PxrUnified", "PxrDirectLighting"}) {
    const Rendered cut = rendered(glass("mist") + within(mist), {}, integrator);
    EXPECT_TRUE(cut.bits == rendered(glass("other") + within(""), {}, integrator).bits) << integrator;
    EXPECT_FALSE(cut.bits == rendered(glass(""), {}, integrator).bits) << integrator;
    EXPECT_EQ(cut.said, "");
    EXPECT_FALSE(rendered(glass("mist") + low(mist), {}, integrator).bits ==
                 rendered(glass("other") + low(""), {}, integrator).bits)
        << integrator;
  }
  // what is asked for as well is everywhere
  EXPECT_TRUE(rendered(glass("mist") + low(mist), asking("mist")).bits == rendered(glass("other") + low("")).bits);
}

TEST(Aggregates, NamesAskedForInVainAreToldOnce) {
  const Rendered r =
      rendered(high(aggregate("clouds")) + low(aggregate("mist")),
               {{"integrator.volumeAggregate", "cloud mist"}, {"integrator.volumeAggregateCamera", "cloud mist"}});
  const auto count = [&](const std::string& text) {
    uint32_t n = 0;
    for (size_t at = 0; (at = r.said.find(text, at)) != std::string::npos; ++at) ++n;
    return n;
  };
  EXPECT_EQ(count("'cloud'"), 1u) << r.said;
  EXPECT_EQ(count("1 volume ("), 1u) << r.said;
  EXPECT_EQ(count("MEDIUM-AGGREGATE"), 1u) << r.said;
  EXPECT_EQ(count("MEDIUM-LEFT-OUT"), 1u) << r.said;
  EXPECT_EQ(rendered("").said, "");  // the usual name in a scene without volumes
}

TileMoments tilesOf(const std::string& text, const Sets& more, uint32_t firstSeed, uint32_t seeds = 16) {
  Workshop stage;
  Method m = pathTracer();
  m.sets.insert(m.sets.end(), more.begin(), more.end());
  const TileMoments tiles = renderAll(stage, text, m, firstSeed, seeds).at("Ci");
  EXPECT_EQ(stage.said, "");
  return tiles;
}

// Of media that scatter once light is linear in the lights: that of two lights, one of which the fog is not linked to, is
// that of the one and that of the other in fog that only absorbs.
TEST(Aggregates, MediaAreLitByTheLightsThatTheyAreLinkedTo) {
  const std::string sun = std::string("    Attribute \"grouping\" \"string membership\" [\"day\"]\n") + kSun;
  const char *fog = "\"float densityFloat\" [0.6]",
             *soot = "\"float densityFloat\" [0.6] \"color diffuseColor\" [0 0 0]";
  const auto scene = [&](const std::string& lights, const std::string& links, const char* material) {
    return room(lights, kGrey, "", volume(links, "[-1.6 1.6 -0.1 2.1 -0.2 2.1]", material));
  };
  const std::string lamp = std::string("    AttributeBegin\n") + kRect + "\n    AttributeEnd\n",
                    day = "    AttributeBegin\n" + sun + "\n    AttributeEnd\n";
  const TileMoments linked =
      tilesOf(scene(lamp + day, "Attribute \"lighting\" \"string subset\" [\"day\"]", fog), {}, 100);
  const TileMoments ofSun = tilesOf(scene(day, "", fog), {}, 200), ofLamp = tilesOf(scene(lamp, "", soot), {}, 300);
  const TileMoments unlinked = tilesOf(scene(lamp + day, "", fog), {}, 400, 4);
  double largest = 0, different = 0;
  for (size_t i = 0; i < linked.tiles.size(); ++i) {
    const auto &a = linked.tiles[i], &b = ofSun.tiles[i], &c = ofLamp.tiles[i];
    const double error = std::hypot(a.standardError(), b.standardError(), c.standardError());
    largest = std::max(largest, std::fabs(a.mean() - b.mean() - c.mean()) / error);
    different = std::max(different, std::fabs(a.mean() - unlinked.tiles[i].mean()) / error);
  }
  EXPECT_LT(largest, 4.5);  // of 16 tiles: 1 in 9,000 by chance
  EXPECT_GT(different, 20);
}

// What rays of paths know and shadow rays do not takes nothing of light that comes straight, whichever finds it.
TEST(Aggregates, LightIsShadowedAlikeHoweverItIsFound) {
  for (const char* asks : {"Indirect", "Transmission"}) {
    Sets sets{{std::string("integrator.volumeAggregate") + asks, "mist"}, {"integrator.maxIndirectBounces", "0"}};
    const std::string text =
        room(kRect, kGrey, "",
             volume(aggregate("mist"), kHigh, "\"float densityFloat\" [1.5] \"color diffuseColor\" [0 0 0]"));
    const TileMoments sampled = tilesOf(text, sets, 500);
    sets.emplace_back("integrator.numLightSamples", "0");
    const TileMoments met = tilesOf(text, sets, 600, 96);
    const TileTest t = compareTiles(mainTiles(met, sampled), mainTiles(sampled, sampled));
    EXPECT_TRUE(t.agrees()) << asks << ": worst z " << t.worstZ << ", means " << met.mean() << " and "
                            << sampled.mean();
    EXPECT_LT(t.meanError, 0.08);
  }
}

}  // namespace
}  // namespace kinora::probes
