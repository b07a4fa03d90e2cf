// PxrVCM in media against PxrPathTracer: equal means where both kinds of paths scatter in fog: even, uneven, of several
// channels, overlapping, in glass, scattering once, glowing, with the camera inside, under lights of every kind; with
// connections, and with merging in media. Each set of techniques of surfaces is compared where media are even (a weight
// that is wrong beside media is so there too): they are as in vcm_test.cpp elsewhere. Equal bits for threads, widths,
// groups and splits. Light paths that memory has no room for are left out. It misses how much less noise there is.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>

#include "base/memory.h"
#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora {
const Descriptor* kinoraStock_WrongBeams();
}
namespace kinora::probes {
namespace {

std::string fog(const std::string& material, const std::string& bound, const std::string& more = "[0 0 0]") {
  return "  AttributeBegin\n    Bxdf \"PxrVolume\" \"fog\" " + material + "\n    Volume \"box\" " + bound + " " +
         more + "\n  AttributeEnd\n";
}
const std::string kOften = "\"int multiScatter\" [1] ";
const char* const kAll = "[-1.6 1.6 -0.1 2.1 -0.2 2.1]";  // the room, the lamps in it
void expectConnected(const std::string& text, double sharpness, uint32_t seeds = 24) {
  Workshop stage;
  expectConnectedAlike(stage, text, sharpness, seeds);
}

TEST(VcmMedia, EqualsPathTracerInEvenFog) {
  expectSamePicture(
      room(kRect, kGrey, "", fog(kOften + "\"float densityFloat\" [0.5] \"float anisotropy\" [0.4]", kAll)), 0.05,
      48);
}
// The camera and a point light inside; both see further by several channels.
TEST(VcmMedia, EqualsPathTracerFromWithinFogOfSeveralChannels) {
  expectConnected(room(kPoint, kGrey, "",
                       fog(kOften + "\"color densityColor\" [0.1 0.4 0.9] \"color diffuseColor\" [0.9 0.8 0.6]",
                           "[-3 3 -3 3 -6 4]")),
                  0.07, 24);
}
TEST(VcmMedia, EqualsPathTracerInUnevenSmokeUnderSunAndDome) {
  expectConnected(
      room(std::string(kSun) + kDome, kGrey, "",
           fog(kOften + "\"string densityFloatPrimVar\" [\"density\"] \"color diffuseColor\" [0.9 0.9 0.8]",
               "[-1.2 1.2 0.1 1.6 0.2 1.8]", "[3 2 2] \"varying float density\" [0 1 4 0.3 0 3 0.5 1 0 1 0 2]")),
      0.07, 24);
}
TEST(VcmMedia, EqualsPathTracerWhereMediaOverlap) {
  expectConnected(room(kSphere, kGrey, "",
                       fog(kOften + "\"color densityColor\" [0.3 0.5 0.6]", kAll) +
                           fog(kOften + "\"float densityFloat\" [1.5] \"float anisotropy\" [-0.3]",
                               "[-0.6 0.6 0.2 1.2 0.3 1.4]")),
                  0.07, 24);
}
// A ball of glass that is full of it.
// (What paths bring through it has long tails: in some tiles a hundred seeds meet it once or never.)
TEST(VcmMedia, EqualsPathTracerInGlass) {
  expectConnected(room(kSphere, kGlass, "",
                       "  AttributeBegin\n    Bxdf \"PxrVolume\" \"milk\" " + kOften +
                           "\"color densityColor\" [2 3 4]\n    Translate 0.4 0.45 1.1\n    Sphere 0.35 -0.35 0.35 "
                           "360\n  AttributeEnd\n"),
                  0.08, 200);
}
// What scatters once sees lights alone, a surface in it all of its light.
TEST(VcmMedia, EqualsPathTracerInFogThatScattersOnce) {
  expectConnected(room(std::string(kRect) + kPoint, kGrey, "",
                       fog("\"float densityFloat\" [0.6]", kAll) +
                           fog(kOften + "\"float densityFloat\" [1]", "[-0.6 0.2 0.2 1.2 0.3 1.4]")),
                  0.07, 24);
}
// Flames are found by camera paths and light samples.
TEST(VcmMedia, EqualsPathTracerAroundFire) {
  expectConnected(room(kRect, kGrey, "",
                       fog(kOften + "\"float densityFloat\" [0.6] \"color emitColor\" [3 1.5 0.4]",
                           "[-0.9 -0.3 0.1 0.9 0.6 1.2]")),
                  0.07, 24);
}
// Merging in media, by each of its sets of techniques alone (of surfaces light that is met by chance), and with
// everything else: what it blurs is taken away by extrapolation.
Method merging(const char* techniques, bool isAlone, double radius) {
  Method m = vcm(!isAlone, !isAlone, isAlone ? 1 : radius);
  m.sets.insert(m.sets.end(), {{"integrator.mergeMedia", techniques},
                               {"integrator.mediaRadius", std::to_string(radius)},
                               {"integrator.reduceMediaRadius", "1"}});
  if (isAlone) m.sets.emplace_back("integrator.numLightSamples", "0");
  return m;
}
struct Techniques {
  const char* mergeMedia;
  bool isAlone;
};
TileMoments expectMergedAlike(const std::string& text, double sharpness, uint32_t seeds = 24) {
  Workshop stage;
  const TileMoments reference = renderAll(stage, text, pathTracer(), 1000, seeds).at("Ci");
  EXPECT_GT(reference.mean(), 0.01);
  for (const Techniques& c : {Techniques{"1", true}, Techniques{"2", true}, Techniques{"3", false}}) {
    const auto method = [&](double radius) { return merging(c.mergeMedia, c.isAlone, radius); };
    const TileMoments merged = extrapolated(stage, text, method, 2, 7000, seeds);
    const TileTest t = compareTiles(mainTiles(merged, reference), mainTiles(reference, reference));
    EXPECT_TRUE(t.agrees()) << c.mergeMedia << (c.isAlone ? " alone" : " beside all others") << ": worst z "
                            << t.worstZ << ", means " << merged.mean() << " and " << reference.mean() << "\n"
                            << stage.said;
    EXPECT_LT(t.meanError, sharpness) << c.mergeMedia;
  }
  return reference;
}
// Camera rays begin within the fog, and so do the ways of light to the camera.
TEST(VcmMedia, EqualsPathTracerBehindANearPlane) {
  const std::string text = room(kRect, kGrey, "Clipping 3.4 100\n",
                                fog(kOften + "\"float densityFloat\" [0.7]", "[-1.6 1.6 -0.1 2.1 -2 2.1]"));
  expectConnected(text, 0.07, 24);
  expectMergedAlike(text, 0.15);
}
const std::string kMany = kOften + "\"color densityColor\" [0.8 1.5 3] \"color diffuseColor\" [0.9 0.9 0.7] ";
// A weight that leaves out a factor is noticed: the share of rays that cross beams, without the angle between them. (The
// same integrator with the right share is the second of those above.)
TEST(VcmMedia, MergingKeepsTheMeanAndAWrongWeightOfBeamsIsNoticed) {
  const std::string text = room(kRect, kGrey, "", fog(kMany + "\"float anisotropy\" [0.3]", kAll));
  const TileMoments reference = expectMergedAlike(text, 0.15);
  Workshop stage{kinoraStock_WrongBeams()};
  const auto method = [](double radius) {
    return Method{"WrongBeams", {{"integrator.mediaRadius", std::to_string(radius)}, {"integrator.isWrong", "1"}}};
  };
  const TileMoments wrong = extrapolated(stage, text, method, 2, 7000, 16);
  const TileTest t = compareTiles(mainTiles(wrong, reference), mainTiles(reference, reference));
  EXPECT_FALSE(t.agrees()) << "worst z " << t.worstZ << ", means " << wrong.mean() << " and " << reference.mean()
                           << "\n"
                           << stage.said;
}
// Media in two aggregates that overlap, each with lights of its own, beside light that is for all: also where beams from a
// light cross a medium that it is not linked to.
TEST(VcmMedia, EqualsPathTracerWhereMediaHaveLightsOfTheirOwn) {
  const auto linked = [](const char* names, const std::string& what) {
    return std::string("  AttributeBegin\n    Attribute \"lighting\" \"string subset\" [\"") + names +
           "\"]\n    Attribute \"volume\" \"string aggregate\" [\"" + names + "\"]\n" + what + "  AttributeEnd\n";
  };
  const std::string text =
      room(std::string(kRect) + kPoint, kGrey, "",
           linked("lamp", fog(kOften + "\"color densityColor\" [0.3 0.5 0.6] \"float anisotropy\" [0.3]", kAll)) +
               linked("spot", fog(kOften + "\"float densityFloat\" [1.5]", "[-0.9 0.6 0.2 1.3 0.3 1.4]")));
  const std::string after = "Shutter 0 1\n";
  const auto asking = [&](const std::string& integrator) {
    std::string t = text;
    return t.insert(t.find(after) + after.size(),
                    "Integrator \"" + integrator + "\" \"i\" \"string volumeAggregate\" [\"lamp spot\"]\n");
  };
  Workshop stage;
  const auto rendered = [&](const std::string& integrator, Method m, uint32_t seed) {
    m.integrator.clear();
    return renderAll(stage, asking(integrator), m, seed, 24);
  };
  const Pictures reference = rendered("PxrPathTracer", pathTracer(), 1000);
  EXPECT_GT(reference.at("Ci").mean(), 0.01);
  expectEqual(rendered("PxrVCM", vcm(true, false), 2000), reference, "connections", 0.11);
  // points are as connections are, beams cross media whose lights they do not come from
  const auto beams = [&](double radius) {
    Method m = merging("2", true, radius);
    m.integrator.clear();
    return m;
  };
  const TileMoments crossed = extrapolated(stage, asking("PxrVCM"), beams, 2, 9000, 24), &whole = reference.at("Ci");
  const TileTest c = compareTiles(mainTiles(crossed, whole), mainTiles(whole, whole));
  EXPECT_TRUE(c.agrees()) << "beams: worst z " << c.worstZ << ", means " << crossed.mean() << " and " << whole.mean();
  EXPECT_LT(c.meanError, 0.2);
  EXPECT_EQ(stage.said, "");
}
// A weight of connections that leaves out what media let through is noticed too.
TEST(VcmMedia, AWrongWeightOfConnectionsIsNoticed) {
  const std::string text =
      room(kRect, kGrey, "", fog(kOften + "\"float densityFloat\" [0.5] \"float anisotropy\" [0.4]", kAll));
  Workshop stage{kinoraStock_WrongBeams()};
  const TileMoments reference = renderAll(stage, text, pathTracer(), 1000).at("Ci");
  const TileMoments wrong = renderAll(stage, text, {"WrongBeams", {{"integrator.isWrong", "2"}}}, 2000).at("Ci");
  const TileTest t = compareTiles(mainTiles(wrong, reference), mainTiles(reference, reference));
  EXPECT_FALSE(t.agrees()) << "worst z " << t.worstZ << ", means " << wrong.mean() << " and " << reference.mean();
}

// Less memory than the records of a pass take: fewer light paths are kept, which is told once, and the mean is the same.
TEST(VcmMedia, FewerLightPathsAreKeptWhereMemoryEnds) {
  std::string text = room(kRect, kGrey, "", fog(kMany, kAll));
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  constexpr int kWide = 128;
  replace("Format 32 32 1", "Format 128 128 1");
  replace("\"int maxsamples\" [16]", "\"int maxsamples\" [3]");
  struct Result {
    TileMoments tiles;
    std::string said;  // in the first
    uint64_t most = 0;
  };
  const auto rendered = [&](const Sets& more, uint64_t room, uint32_t firstSeed) {
    Result r;
    Workshop stage;
    for (uint32_t seed = 0; seed < 8; ++seed) {
      render::Settings s;
      s.threads = 1 + int(seed & 1);
      s.seed = firstSeed + seed;
      s.integrator = "PxrVCM";
      s.sets = merging("3", false, 2).sets;
      s.sets.insert(s.sets.end(), more.begin(), more.end());
      const auto renderer = stage.load(sceneOf(text, stage.messages), s);
      if (room) Memory::setLimit(Memory::resident() + room);
      EXPECT_EQ(renderer->renderFilm(), render::Outcome::Complete) << stage.said;
      Memory::setLimit(0);
      r.tiles.add(renderer->film().resolve(renderer->film().layout().find("Ci")), kWide, kWide, kWide / 4);
      for (const auto& owner : renderer->statistics().memory)
        if (std::string(owner.name) == "records between stages (peak)") r.most = std::max(r.most, owner.bytes);
      if (!seed) r.said = stage.said;
    }
    return r;
  };
  const Result all = rendered({}, 0, 1000), quarter = rendered({{"integrator.keptPaths", "0.25"}}, 0, 2000);
  EXPECT_EQ(all.said + quarter.said, "");
  EXPECT_LT(quarter.most, all.most / 2);
  const Result few = rendered({}, all.most, 3000);
  EXPECT_LT(few.most, all.most / 2) << all.most;
  EXPECT_NE(few.said.find("MEMORY-RECORDS"), std::string::npos) << few.said;
  EXPECT_EQ(few.said.find("MEMORY-RECORDS"), few.said.rfind("MEMORY-RECORDS")) << few.said;
  for (const Result* r : {&quarter, &few}) {
    const TileTest t = compareTiles(r->tiles, all.tiles);
    EXPECT_TRUE(t.agrees()) << "worst z " << t.worstZ << ", means " << r->tiles.mean() << " and " << all.tiles.mean();
    EXPECT_LT(t.meanError, 0.05);
  }
}

// The statistics say what a pass has held of light paths, and beams are part of it.
TEST(VcmMedia, StatisticsTellTheMemoryOfRecords) {
  const auto bytesWith = [](const char* mergeMedia) {
    Workshop stage;
    render::Settings s;
    s.threads = 1;
    s.integrator = "PxrVCM";
    s.sets = {{"integrator.mergeMedia", mergeMedia}};
    const auto r = stage.load(sceneOf(room(kRect, kGrey, "", fog(kMany, kAll)), stage.messages), s);
    EXPECT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
    for (const auto& owner : r->statistics().memory)
      if (std::string(owner.name) == "records between stages (peak)") return owner.bytes;
    return uint64_t(0);
  };
  const uint64_t plain = bytesWith("0"), beams = bytesWith("2");
  EXPECT_GT(plain, 10000u);
  EXPECT_GT(beams, plain);
}
// Radii that cannot be are told, one of 0 merges nothing, scenes without media are as they were.
TEST(VcmMedia, MergingTakesAnyRadius) {
  const auto filmWith = [](const std::string& text, const Sets& more, std::string* said) {
    Workshop stage;
    render::Settings s;
    s.threads = 2;
    s.integrator = "PxrVCM";
    s.sets = vcm(true, true).sets;
    s.sets.insert(s.sets.end(), more.begin(), more.end());
    const auto r = stage.load(sceneOf(text, stage.messages), s);
    const image::Image picture = pictureOf(*r);
    EXPECT_TRUE(std::all_of(picture.pixels.begin(), picture.pixels.end(), [](float x) { return std::isfinite(x); }));
    *said = stage.said;
    return stateOf(r->film());
  };
  const std::string foggy = room(kRect, kGrey, "", fog(kMany, kAll)), clear = room(kRect, kGrey);
  const std::pair<std::string, std::string> on{"integrator.mergeMedia", "3"};
  std::string said, silent;
  EXPECT_TRUE(filmWith(foggy, {on, {"integrator.mediaRadius", "0"}}, &said) == filmWith(foggy, {}, &silent));
  EXPECT_TRUE(filmWith(clear, {on}, &said) == filmWith(clear, {}, &silent));
  EXPECT_FALSE(filmWith(foggy, {on}, &said) == filmWith(foggy, {}, &silent));
  EXPECT_EQ(said + silent, "");
  for (const char* radius : {"-2", "1e9"}) {
    filmWith(foggy, {on, {"integrator.mediaRadius", radius}}, &said);
    EXPECT_NE(said.find("mediaRadius"), std::string::npos) << said;
  }
  filmWith(foggy, {on, {"integrator.reduceMediaRadius", "0"}}, &said);
  EXPECT_NE(said.find("reduceMediaRadius"), std::string::npos) << said;
  filmWith(foggy, {{"integrator.mergeMedia", "7"}}, &said);
  EXPECT_NE(said.find("mergeMedia"), std::string::npos) << said;
}

TEST(VcmMedia, SameBits) {
  std::string text = room(std::string(kRect) + kSun + kDome, kGlass, kLens,
                          fog(kOften + "\"color densityColor\" [0.3 0.5 0.9]", kAll) +
                              fog("\"string densityFloatPrimVar\" [\"density\"]", "[-0.6 0.2 0.2 1.2 0.3 1.4]",
                                  "[2 1 2] \"varying float density\" [0 2 3 0.3]"));
  expectSameBits({}, text, "PxrVCM");
  const std::string after = "Shutter 0 1\n";
  text.insert(text.find(after) + after.size(), "Integrator \"PxrVCM\" \"vcm\" \"int mergeMedia\" [3]\n");
  expectSameBits({}, text, "");
}

}  // namespace
}  // namespace kinora::probes
