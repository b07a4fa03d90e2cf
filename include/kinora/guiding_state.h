// What path guiding learns: where light comes from, region by region of space, and the lessons that it follows from. The
// state is plain data (kinora/integrator.h, Learning); kinora/guiding_teacher.h makes it, kinora/guiding.h looks it up in
// kernels.
//
// Space is an octree over the world; a leaf is a region, and holds a distribution over a sphere of directions: cells of
// equal size on the octahedral map (Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors",
// JCGT 2014), chosen by halving the square, columns and rows in turn. Mueller et al., "Practical Path Guiding for Efficient
// Light-Transport Simulation" (EGSR 2017) have trees of both kinds; here that of directions has one depth, so that lanes
// stay together, and what was seldom seen is smoothed instead. Where a
// region has few lessons in some directions, the larger part of space around it has its say.
//
// Light that comes from near by comes from other directions at one end of a region than at the other. So the sphere has
// a centre in the region and a radius, which is the mean distance that its light comes from; a direction at a point
// stands for the place of the sphere at which the ray leaves it. All points of the region then look towards one and the
// same gap. (Ruppert, Herholz and Lensch, "Robust Fitting of Parallax-Aware Mixtures for Path Guiding", SIGGRAPH 2020,
// move each lobe of a mixture by a distance of its own; one sphere a region keeps the map of directions one to one.)
//
// What arrives at a region, and what the camera sees of it, tell too how much a path is worth that goes on from there:
// Russian roulette follows that (Vorba and Krivanek, "Adjoint-Driven Russian Roulette and Splitting in Light Transport
// Simulation", SIGGRAPH 2016), in all regions that know it.
//
// Which lights are worth a sample is learned over the same regions: a factor for each cluster of lights, from what its
// samples brought through their shadows (after Vevoda, Kondapaneni and Krivanek, "Bayesian Online Regression for Adaptive
// Direct Illumination Sampling", SIGGRAPH 2018: what is expected before, over the frame and from the light tree, counts
// for a few lessons, so that a light not yet seen somewhere keeps its chance).
//
// Each lesson says too what the guided estimate and the unguided one would have added to the variance: regions in which
// guiding does not pay are left alone.
#pragma once
#include <kinora/integrator.h>

#include <algorithm>
#include <cmath>

namespace kinora::guiding {

inline constexpr uint32_t kLevels = 5, kSide = 1u << kLevels, kCells = kSide * kSide;  // of directions
inline constexpr uint32_t kDepth = 10;                                                 // of space, at most
inline constexpr float kLargestWeight = 48;  // of a record: directions hardly ever taken teach no more than that
// Shares of first halves, of 16 bits: the node of a heap (1: the root) stands in one of lines of 64 bytes, the first
// kLevels halvings in one and each subtree below them in another, since a walk down waits for each line.
inline constexpr uint32_t kLine = 1u << kLevels, kSplitWords = (kLine + 1) * kLine / 2;
inline uint32_t splitAt(uint32_t node) {
  uint32_t bits = 0;  // of the node's depth
  while (node >> (bits + 1)) ++bits;
  if (bits < kLevels) return node;
  const uint32_t below = bits - kLevels;
  return ((node >> below) - kLine + 1) * kLine + (1u << below | (node & ((1u << below) - 1)));
}
inline constexpr float kSplitUnit = 1.f / 65536;  // shares: (number + 1/2) of it
inline constexpr float kFarthestInside = 0.25f;   // squared, of a place in the frame of its region

// Entries of the octree: a region of the lower bits where kLeaf is set, else the index of the first of eight entries.
// kIsKnown: it has a distribution; kIsOn: and directions follow it.
inline constexpr uint32_t kLeaf = 0x80000000u, kIsOn = 0x40000000u, kIsKnown = 0x20000000u, kRegion = 0x1fffffffu;

// What a path says of one of its vertices.
struct Lesson {
  float P[3];
  uint32_t cell;  // the direction in which it went on, kDirectionBits of each coordinate, and kWasGuided
  float light;    // radiance from there over the density of the direction
  float guided;   // squared contribution
  float plain;    // expectation, over how the direction was chosen, of that without guiding
  float visits;   // paths that it stands for: one over the chance with which roulette let it go on
  float near;     // one over the distance of what the direction meets; 0: nothing
  float seen;     // at a path's first vertex: all that the path brought to its pixel; below 0: at another one
};
inline constexpr uint32_t kWasGuided = 0x80000000u;
inline constexpr uint32_t kDirectionBits = 14;  // of each coordinate on the octahedral map
// A lesson of a light sample: `cell` is this and the light's cluster; `light` what the sample would have brought were its
// cluster chosen as without weights, squared, times, and `visits` divided by, what made the choice likelier than that.
inline constexpr uint32_t kOfLight = 0x40000000u;

struct Options {
  bool directions = true;     // are learned
  bool lights = false;        // which lights are worth a sample is
  uint32_t samples = 64;      // that teach, a power of two
  uint32_t paths = 1u << 17;  // of an epoch
  uint32_t regions = 2048;    // at most; each takes 14 KB
  uint32_t perRegion = 800;   // lessons of an epoch, of which more are divided
  uint32_t firstOff = 16;     // samples before regions may be left alone
  float gain = 0.75f;  // of the variance without guiding: what a region must come below, a guided path taking longer
  float least = 0.1f;  // share of the paths' vertices: where regions with fewer are guided, all are left alone
};

// Which lights are worth a sample is learned from fewer paths than where light comes from.
inline Options optionsFor(bool directions, bool lights) {
  Options o;
  o.directions = directions;
  o.lights = lights;
  if (!directions) {
    o.paths = 1u << 15;
    o.perRegion = 400;
  }
  return o;
}

inline Learning learning(const Options& o) { return {sizeof(Lesson), o.samples, o.paths}; }

// The head of the state; offsets in words of 32 bits from its beginning.
struct State {
  uint32_t words, regions, entries, guides;  // guides: 1 where some region is known
  float low[3], scale;                       // cells of the finest octree: (P - low) * scale
  uint32_t tree, splits, density, lights, counts, sums, frames;
  uint32_t lightWeights, lightSums;  // by region and cluster: Group::lightWeights; two numbers that they come from
  uint32_t lessons;
  uint32_t isIdle;  // 1: guiding pays nowhere, and nothing more is learned
  // 1: what pays is known; until then camera hits are left alone, whose directions are well stratified
  uint32_t isTried;
  float seen;  // what a path brings to its pixel, in the mean
  const uint32_t* at(uint32_t offset) const { return reinterpret_cast<const uint32_t*>(this) + offset; }
  const float* floats(uint32_t offset) const { return reinterpret_cast<const float*>(this) + offset; }
  float* floats(uint32_t offset) { return reinterpret_cast<float*>(this) + offset; }
  // By region: lights (radiance by cell, as lessons have it), counts (lessons by cell), sums (kSums numbers), frames (the
  // centre of its sphere and one over the radius; 0: directions are the same everywhere).
  enum Sums : uint32_t {
    kGuided,
    kPlain,
    kGuidedLessons,
    kVisits,
    kSeen,
    kSeenLessons,
    kLeftAlone,  // 1: guiding does not pay
    kRadiance,   // radiance that arrives (root of the mean square), over the density of its direction
    kReference,  // what a path brings to its pixel whose first vertex is here
    kSums
  };
};

// Columns and rows of a cell: its bits in turn, from the highest on.
inline void placeOf(uint32_t cell, uint32_t& x, uint32_t& y) {
  x = y = 0;
  for (uint32_t k = 0; k < kLevels; ++k) {
    x |= (cell >> (2 * k + 1) & 1) << k;
    y |= (cell >> (2 * k) & 1) << k;
  }
}
// Solid angle of a cell, about; over all of them the sum is 4 pi.
inline float solidAngle(uint32_t cell) {
  uint32_t x, y;
  placeOf(cell, x, y);
  const float a = std::fabs((float(x) + 0.5f) * (2.f / kSide) - 1),
              b = std::fabs((float(y) + 0.5f) * (2.f / kSide) - 1);
  // the point (p, q, r) of the octahedron
  float p = a, q = b, r = 1 - a - b;
  if (r < 0) {
    p = 1 - b;
    q = 1 - a;
  }
  const float l2 = p * p + q * q + r * r;
  return 4.f / kCells / (l2 * std::sqrt(l2));
}

// The direction of a place on the octahedral map, whose coordinates are from -1 to 1.
inline void directionAt(float a, float b, float d[3]) {
  const float r = 1 - std::fabs(a) - std::fabs(b);
  if (r < 0) {
    const float p = std::copysign(1 - std::fabs(b), a);
    b = std::copysign(1 - std::fabs(a), b);
    a = p;
  }
  const float l = 1 / std::sqrt(a * a + b * b + r * r);
  d[0] = a * l;
  d[1] = b * l;
  d[2] = r * l;
}
// The cell of a direction of any length above 0.
inline uint32_t cellOf(const float d[3]) {
  const float l = 1 / (std::fabs(d[0]) + std::fabs(d[1]) + std::fabs(d[2]));
  float a = d[0] * l, b = d[1] * l;
  if (d[2] < 0) {
    const float p = std::copysign(1 - std::fabs(b), a);
    b = std::copysign(1 - std::fabs(a), b);
    a = p;
  }
  const auto at = [](float x) { return uint32_t(std::clamp((x + 1) * (kSide / 2), 0.f, float(kSide - 1))); };
  const uint32_t x = at(a), y = at(b);
  uint32_t cell = 0;
  for (uint32_t k = 0; k < kLevels; ++k) cell |= (x >> k & 1) << (2 * k + 1) | (y >> k & 1) << (2 * k);
  return cell;
}
// A place in the frame of its region: from the centre of the sphere, whose radius is 1. Places so far out that the sphere
// would be seen from its edge look along the directions as they are.
inline void placeIn(const float frame[4], const float P[3], float e[3]) {
  float square = 0;
  for (int c = 0; c < 3; ++c) {
    e[c] = (P[c] - frame[c]) * frame[3];
    square += e[c] * e[c];
  }
  if (!(square < kFarthestInside)) e[0] = e[1] = e[2] = 0;
}

}  // namespace kinora::guiding
