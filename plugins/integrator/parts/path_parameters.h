// Parameters that integrators of paths have in common, and what they make of them.
#pragma once
#include <kinora/manifold_options.h>
#include <kinora/named_values.h>
#include <kinora/path_loop_options.h>
#include <kinora/roulette.h>

#include <algorithm>
#include <cstdio>
#include <string_view>

namespace kinora::pathParameters {

inline constexpr Param kMaxIndirectBounces =
    param::integer("maxIndirectBounces", 8).range(0, 1000).help("Indirect bounces allowed; 0 is direct light only.");
inline constexpr Param kNumLightSamples = param::integer("numLightSamples", 1)
                                              .range(0, 64)
                                              .help("Light samples at each camera hit; deeper vertices take one.");
inline constexpr Param kNumIndirectSamples =
    param::integer("numIndirectSamples", 1).range(1, 64).help("Directions followed from each camera hit.");
inline constexpr Param kNumBxdfSamples =
    param::integer("numBxdfSamples", 1)
        .range(1, 64)
        .help("Accepted for old scenes; indirect directions serve as bxdf samples.");
inline constexpr Param kClampDepth = param::integer("clampDepth", 2)
                                         .range(1, 64)
                                         .help(
                                             "Bounces of a path from which contributions are clamped, that to the "
                                             "light included: direct light at what the camera sees is 1.");
inline constexpr Param kClampLuminance = param::number("clampLuminance", 10.f)
                                             .range(0, 1e30f)
                                             .help("Largest luminance of one contribution there; 1e30 is off.");
inline constexpr Param kRouletteDepth =
    param::integer("rouletteDepth", 4).range(1, 64).help("Path length from which Russian roulette is played.");
inline constexpr Param kRouletteThreshold =
    param::number("rouletteThreshold", 0.2f).help("Only paths whose throughput is below this play it; 0 is off.");
inline constexpr Param kMaxPathLength =
    param::integer("maxPathLength", -1).range(-1, 64).help("Old name: maxIndirectBounces + 1; -1 is not given.");

// Of one default or the other.
constexpr Param accumOpacity(int byDefault) {
  return param::integer("accumOpacity", byDefault)
      .options("0 off, 1 on")
      .help(
          "Alpha of what the camera sees through glass: 0: glass covers its pixel; 1: by what it takes of what is "
          "behind, where paths that were only refracted meet nothing there (infinite lights are nothing). Paths "
          "without light paths only.");
}
inline constexpr Param kMaxNonStochasticOpacityEvents =
    param::integer("maxNonStochasticOpacityEvents", 0)
        .range(0, 64)
        .help(
            "No effect: chance decides for each sample whether a surface is present, so that all its channels show "
            "one surface; a sample pattern keeps that noise low.");

inline constexpr Param kMergeMedia =
    param::integer("mergeMedia", 0)
        .range(0, 3)
        .options("0 off, 1 points, 2 beams, 3 both")
        .help(
            "Merge paths in media too. 1: vertices with vertices within a ball; 2: rays with vertices, and rays with "
            "rays (beams); 3: all. Light gathered by glass in thin fog wants beams, dense media want points.");
inline constexpr Param kMediaRadius =
    param::number("mediaRadius", 2.f)
        .range(0, 1000)
        .help(
            "Radius of merging in media in pixels, as mergeRadius; 0 merges nothing there. What is thinner lets "
            "light through in the first samples.");
inline constexpr Param kReduceMediaRadius =
    param::number("reduceMediaRadius", 0.67f)
        .range(0.01f, 1)
        .help(
            "How fast it shrinks: that of sample i (from 1) is i^((reduceMediaRadius - 1) / d) of the first, for "
            "vertices d = 3, for rays with vertices 2, with rays 1; 1 keeps it.");

// The renderer lowers it, by its name, where records do not fit into memory.
inline constexpr Param kKeptPaths =
    param::number("keptPaths", 1.f)
        .range(1e-6f, 1)
        .help(
            "Share of light paths that are kept for camera paths to be connected to and merged with: fewer take less "
            "memory and leave more noise. Where --memory-limit has no room for them, they are fewer than that.");

inline constexpr Param kNumVolumeAggregateSamples =
    param::integer("numVolumeAggregateSamples", 1)
        .range(1, 64)
        .help(
            "Places in media that are drawn on each camera ray by where lights are near, each with light samples of "
            "its own: for beams of light in thin air, where they cost less than samples a pixel that do as much. "
            "Where light paths are traced it has no effect.");

// Which media rays know of; the renderer reads these four by their names.
inline constexpr Param kVolumeAggregate =
    param::string("volumeAggregate", "globalVolumeAggregate")
        .help(
            "Volumes that rays know of: those in an aggregate of this name (several: blanks between them), see "
            "Attribute \"volume\" \"string aggregate\", and those in none.");
inline constexpr Param kVolumeAggregateCamera =
    param::string("volumeAggregateCamera", "").help("Instead for rays of the camera; \"\": as volumeAggregate.");
inline constexpr Param kVolumeAggregateIndirect =
    param::string("volumeAggregateIndirect", "")
        .help("Instead for the rays of paths after the camera's; \"\": as volumeAggregate.");
inline constexpr Param kVolumeAggregateTransmission =
    param::string("volumeAggregateTransmission", "")
        .help("Instead for light on its way from a light to what it is sampled at; \"\": as volumeAggregate.");

inline constexpr Param kLearnLights = param::onOff("learnLights", false)
                                          .help(
                                              "Learn over the first samples which lights are worth a sample, region "
                                              "by region: for rooms where many lights are hidden from many places.");
inline constexpr Param kNumLightCandidates =
    param::integer("numLightCandidates", 1)
        .range(1, 16)
        .help(
            "Light samples at camera hits are chosen each from so many by what they would bring were nothing in "
            "their way, before shadow rays: for skies and many lights. For camera paths alone, and not with "
            "learnLights.");
inline constexpr Param kRisPathGuiding =
    param::onOff("risPathGuiding", false)
        .help(
            "Learn where light comes from over the first samples, and choose directions by that and the materials "
            "together: for light that comes through narrow gaps. Without light paths only.");
inline constexpr Param kGuidingSamples = param::integer("guidingSamples", 64)
                                             .range(1, 4096)
                                             .help(
                                                 "Samples a pixel that are learned from, by learnLights and, where "
                                                 "there is one, risPathGuiding; rounded down to a power of two.");
inline constexpr Param kGuidingRegions = param::integer("guidingRegions", 2048)
                                             .range(16, 65536)
                                             .help(
                                                 "Regions of space that are learned of apart, at most; each takes "
                                                 "200 bytes for learnLights, 14 KB with risPathGuiding.");

inline constexpr Param kManifoldWalk =
    param::integer("manifoldWalk", 0)
        .range(0, 2)
        .options("0 off, 1 on, 2 straight")
        .help(
            "Manifold walks find caustics of lights with cheapCaustics behind materials with mwWalkable; paths leave "
            "that light to them. 1: all of it, without bias; 2: only what walks find that start straight towards the "
            "light, which is less work, and darker where light comes in several ways.");
inline constexpr Param kMaxInterfaces =
    param::integer("maxInterfaces", 2)
        .range(1, 16)
        .help("Boundaries that a walk's path goes through at most: 2 for a body of glass, 4 for a glass of water.");
inline constexpr Param kMaxIterations =
    param::integer("maxIterations", 20).range(1, 100).help("Steps of a walk at most.");

// Of a list that has it.
constexpr const Param& named(const Param* list, std::string_view name) {
  while (list->name != name) ++list;
  return *list;
}
// A number that may not lie outside of its declared range: it is moved there, which is told.
inline float within(const NamedValues& values, const Param& parameter) {
  const float x = float(values.number(parameter.name)), low = parameter.low, high = parameter.high;
  if (x >= low && x <= high) return x;
  const float used = x < low ? low : high;
  char text[64];
  std::snprintf(text, sizeof text, "%s is %g, %s", parameter.name, double(x), x < low ? "too small" : "too large");
  char done[64];
  std::snprintf(done, sizeof done, "%g is used", double(used));
  values.warn("PARAM-RANGE", text, done);
  return used;
}
// Options of merging in media (vcm::Options).
template <class Options>
void mergeMedia(const NamedValues& values, Options& o) {
  const uint32_t media = uint32_t(within(values, kMergeMedia));
  o.mediaRadius = within(values, kMediaRadius);
  o.mergesMedia = media & 1 && o.mediaRadius > 0;
  o.beams = media & 2 && o.mediaRadius > 0;
  o.mediaReduce = within(values, kReduceMediaRadius);
}
// A count, within bounds whatever the file says.
inline uint32_t count(const CreateInfo& info, uint32_t parameter, int least, int most) {
  return uint32_t(std::clamp(info.integer(parameter), least, most));
}
// Indirect bounces by either name; the new one counts where both are given.
inline uint32_t bounces(const CreateInfo& info, uint32_t maxIndirectBounces, uint32_t maxPathLength, int most) {
  const int length = info.integer(maxPathLength);
  const bool isOld = length > 0 && !info.values[maxIndirectBounces].given;
  return uint32_t(std::clamp(isOld ? length - 1 : info.integer(maxIndirectBounces), 0, most));
}
// What camera paths learn over `samples`: directions where they are guided, and lights.
template <class Options>
void learning(const NamedValues& values, float samples, bool guides, Options& o) {
  o.learnsLights = within(values, kLearnLights) != 0;
  o.guiding = guiding::optionsFor(guides, o.learnsLights);
  o.guiding.samples = uint32_t(samples);
  o.guiding.regions = uint32_t(within(values, kGuidingRegions));
}
inline uint32_t lightCandidates(const NamedValues& values) { return uint32_t(within(values, kNumLightCandidates)); }

inline ManifoldOptions manifold(const NamedValues& values) {
  ManifoldOptions o;
  const float walk = within(values, kManifoldWalk), interfaces = within(values, kMaxInterfaces);
  o.interfaces = walk > 0 ? uint32_t(interfaces) : 0;
  o.findsAll = walk < 2;
  o.iterations = uint32_t(within(values, kMaxIterations));
  return o;
}
inline constexpr uint32_t kNever = 1u << 30;  // a depth that no path reaches
// The vertex from which roulette is played.
inline uint32_t rouletteDepth(const CreateInfo& info, uint32_t depth, uint32_t threshold, int least) {
  return info.number(threshold) > 0 ? count(info, depth, least, 100000) : kNever;
}
// Roulette of light paths, from that vertex on: a light path costs as much as a camera path and brings less, so that it
// is played earlier and for more (measured, docs/integrators.md).
inline Roulette rouletteOfLight(uint32_t depth, float threshold) {
  return {threshold > 0 ? depth : kNever, std::min(2 * threshold, 1.f)};
}

}  // namespace kinora::pathParameters
