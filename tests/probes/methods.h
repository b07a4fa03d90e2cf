// Methods of rendering compared over rooms of 32 x 32 pixels: pictures with several seeds, tile by tile, as the path
// tracer and PxrVCM with its sets of techniques make them. Used by tests of integrators.
#pragma once
#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/probes/probe_support.h"

namespace kinora::probes {

inline constexpr int kSide = 32, kTile = 8;
inline const std::vector<std::string> kChannels{"Ci", "indirect", "ball", "key"};

using Sets = std::vector<std::pair<std::string, std::string>>;
using Pictures = std::map<std::string, TileMoments>;

struct Method {
  std::string integrator;
  Sets sets;
};
inline Sets plain(int bounces) {
  return {{"integrator.maxIndirectBounces", std::to_string(bounces)},
          {"integrator.clampLuminance", "1e30"},
          {"integrator.rouletteThreshold", "0"}};
}
inline Method pathTracer(int bounces = 4) {
  Method m{"PxrPathTracer", plain(bounces)};
  m.sets.emplace_back("integrator.allowCaustics", "1");
  return m;
}
inline Method vcm(bool connects, bool merges, double radius = 5, int bounces = 4) {
  Method m{"PxrVCM", plain(bounces)};
  m.sets.insert(m.sets.end(), {{"integrator.connectPaths", connects ? "1" : "0"},
                               {"integrator.mergePaths", merges ? "1" : "0"},
                               {"integrator.mergeRadius", std::to_string(radius)},
                               {"integrator.reduceRadius", "1"}});
  return m;
}

// Tiles of each channel, and the whole picture.
inline Pictures renderAll(Workshop& stage, const std::string& text, const Method& method, uint32_t firstSeed,
                          uint32_t seeds = 24) {
  Pictures r;
  render::Settings s;
  s.integrator = method.integrator;
  s.sets = method.sets;
  forSeeds(stage, text, s, firstSeed, seeds, [&](render::Renderer& renderer) {
    EXPECT_EQ(renderer.renderFilm(), render::Outcome::Complete) << stage.said;
    for (const std::string& name : kChannels) {
      const image::Image picture = renderer.film().resolve(renderer.film().layout().find(name));
      r[name].add(picture, kSide, kSide, kTile);
      r[name + ", whole"].add(picture, kSide, kSide, kSide);
    }
  });
  return r;
}

// Tiles without those that hold hardly any of the light: what few paths bring has no normal distribution.
inline TileMoments mainTiles(const TileMoments& of, const TileMoments& reference) {
  TileMoments r;
  for (size_t i = 0; i < of.tiles.size(); ++i)
    if (reference.tiles[i].mean() > 0.01 * reference.mean()) r.tiles.push_back(of.tiles[i]);
  return r;
}

inline void expectEqual(const Pictures& one, const Pictures& other, const std::string& what, double sharpness) {
  for (const auto& [name, moments] : one) {
    const TileTest t = compareTiles(mainTiles(moments, other.at(name)), mainTiles(other.at(name), other.at(name)));
    EXPECT_TRUE(t.agrees()) << what << ", " << name << ": worst z " << t.worstZ << ", means " << moments.mean()
                            << " and " << other.at(name).mean();
    if (name == "Ci") {
      EXPECT_LT(t.meanError, sharpness) << what;
    }
  }
}

// Bias goes with the square of the radius: what two radii say of none. method(radius) renders with that.
template <class MethodOf>
TileMoments extrapolated(Workshop& stage, const std::string& text, const MethodOf& method, double radius,
                         uint32_t firstSeed, uint32_t seeds) {
  TileMoments r;
  for (uint32_t seed = 0; seed < seeds; ++seed) {
    image::Image pictures[2];
    for (int k = 0; k < 2; ++k) {
      const Method m = method(k ? radius / 2 : radius);
      render::Settings s;
      s.threads = 1;
      s.seed = firstSeed + seed + seeds * uint32_t(k);
      s.integrator = m.integrator;
      s.sets = m.sets;
      const auto renderer = stage.load(sceneOf(text, stage.messages), s);
      pictures[k] = pictureOf(*renderer);
    }
    for (size_t i = 0; i < pictures[0].pixels.size(); ++i)
      pictures[0].pixels[i] = (4 * pictures[1].pixels[i] - pictures[0].pixels[i]) / 3;
    r.add(pictures[0], kSide, kSide, kTile);
  }
  return r;
}
inline TileMoments extrapolated(Workshop& stage, const std::string& text, bool connects, double radius,
                                uint32_t firstSeed, uint32_t seeds, int bounces = 4) {
  const auto method = [&](double r) { return vcm(connects, true, r, bounces); };
  return extrapolated(stage, text, method, radius, firstSeed, seeds);
}

// The connections of PxrVCM, which the other expectations below have too.
inline Pictures expectConnectedAlike(Workshop& stage, const std::string& text, double sharpness,
                                     uint32_t seeds = 24) {
  const Pictures reference = renderAll(stage, text, pathTracer(), 1000, seeds);
  EXPECT_GT(reference.at("Ci").mean(), 0.01) << stage.said;
  EXPECT_GT(reference.at("indirect").mean(), 0.001);
  expectEqual(renderAll(stage, text, vcm(true, false), 2000, seeds), reference, "connections", sharpness);
  return reference;
}

// With all sets of techniques. `sharpness`: the relative standard error that a tile of Ci may have, on average. Radii of
// merging are half a pixel and less: at edges of what moves the blur is no square of the radius before.
inline void expectSamePicture(const std::string& text, double sharpness, uint32_t seeds = 24) {
  constexpr double kRadius = 0.5;
  Workshop stage;
  const Pictures reference = expectConnectedAlike(stage, text, sharpness, seeds);
  expectEqual(renderAll(stage, text, vcm(false, false), 3000, seeds), reference, "camera paths alone", sharpness);
  for (const bool connects : {true, false}) {
    const TileMoments& all = reference.at("Ci");
    const TileTest t =
        compareTiles(mainTiles(extrapolated(stage, text, connects, kRadius, 4000, seeds), all), mainTiles(all, all));
    EXPECT_TRUE(t.agrees()) << (connects ? "connections and merges" : "merges") << ": worst z " << t.worstZ;
    EXPECT_LT(t.meanError, 4 * sharpness);
  }
}

}  // namespace kinora::probes
