// What connection and merging is told, what its light paths leave for its camera paths to find, and what these make
// of it. Plain data; behind kinora/subpaths.h and kinora/path_densities.h, whose plain types it holds.
#pragma once
#include <kinora/guiding_state.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "plugins/integrator/parts/beam_index.h"
#include "plugins/integrator/parts/merge_index.h"

namespace kinora::vcm {

struct Options {
  uint32_t bounces = 8;
  uint32_t lightSamples = 1;  // at camera hits; deeper vertices take one
  bool connects = true;       // vertices of camera paths with those of light paths, and these with the camera
  bool merges = true;         // vertices of camera paths with those of light paths near by
  float radius = 5;           // of merging, pixels; of the first sample
  float reduce = 0.67f;       // sample i (from 1) has i^((reduce - 1) / 2) of it
  bool mergesMedia = false;   // the same of vertices in media
  bool beams = false;         // and beams there: of light paths with camera paths' vertices and rays
  float mediaRadius = 2;      // of both, as `radius`; sample i has i^((mediaReduce - 1) / dimension) of it
  float mediaReduce = 0.67f;
  float kept = 1;                      // share of light paths that leave anything for camera paths to find
  float timeRadius = 1;                // farthest distance in time of merged vertices, of the shutter's opening
  uint32_t clampDepth = 2;             // bounces from which contributions are clamped, as in PathLoopOptions
  float clampLuminance = 10;           // largest luminance of one contribution there
  float clampDirect = 1e30f;           // and before, but of lights that the camera sees
  float emission = 1;                  // factor on what surfaces emit
  Roulette roulette, rouletteOfLight;  // of camera paths and of light paths
  bool learnsLights = false;           // which lights are worth a sample, region by region
  guiding::Options guiding;            // and how
  bool mergesAny() const { return merges || mergesMedia; }
  bool hasLightPaths() const { return connects || mergesAny() || beams; }
  // The largest luminance of one contribution by a path of so many bounces, that to the light included.
  float mostAt(uint32_t bounces) const {
    return bounces >= clampDepth ? clampLuminance : bounces ? clampDirect : 1e30f;
  }
  // Whether a light sample could have made a path with so many vertices before the one that is next to the light.
  bool samplesLight(uint32_t before) const { return before || lightSamples; }
};

// What camera paths look things up in.
struct PassIndex {
  const MergeIndex* points = nullptr;
  const BeamIndex* beams = nullptr;
};

struct Stored {
  PathVertex at;
  PathSums sums;
  Photon photon;
  float merges, crossings;  // as of Neighbourhoods::Of
  float probability;        // with which its path's camera path is connected to it; 0: it is not
};

inline uint32_t stages(const Options& o, Stage* out, uint32_t capacity) {
  if (capacity < 2) return 0;
  if (o.hasLightPaths()) *out++ = {StageKind::LightPaths, 1};
  *out = {StageKind::CameraPaths, 0};
  return o.hasLightPaths() ? 2 : 1;
}
inline uint32_t lists(const Options& o, RecordList* out) {
  out[0] = {sizeof(Stored), 0};
  out[1] = {sizeof(Beam), 0};
  return !o.hasLightPaths() ? 0 : o.beams ? 2 : 1;
}

inline uint32_t learning(const Options& o, Learning* out) {
  *out = guiding::learning(o.guiding);
  return o.learnsLights;
}

// At the barrier behind light paths.
inline void commit(const Options& options, uint32_t stage, const CommitServices& services) {
  if (stage || (!options.mergesAny() && !options.beams)) return;
  auto* index = static_cast<PassIndex*>(services.allocate(&services, sizeof(PassIndex)));
  if (!index) return;
  *index = {};
  if (options.mergesAny()) {
    const StoredRecords s = services.stored(&services, 0);
    const Stored* all = static_cast<const Stored*>(s.records);
    index->points =
        MergeIndex::build(services, s.count, [all](uint64_t i) -> const Photon& { return all[i].photon; });
  }
  if (options.beams) {
    const StoredRecords s = services.stored(&services, 1);
    index->beams = BeamIndex::build(services, s.count, static_cast<const Beam*>(s.records));
  }
  services.setIndex(&services, index);
}

// For the description of an integrator whose data D are Options or derived from them.
template <class D>
uint32_t stagesOf(const void* data, Stage* out, uint32_t capacity) {
  return stages(*static_cast<const D*>(data), out, capacity);
}
template <class D>
uint32_t listsOf(const void* data, RecordList* out, uint32_t) {
  return lists(*static_cast<const D*>(data), out);
}
template <class D>
uint32_t learningOf(const void* data, Learning* out) {
  return learning(*static_cast<const D*>(data), out);
}

// Each camera path is connected to at most so many vertices of its light path, the same ones from all its own.
inline constexpr uint32_t kConnected = 2;
// More bring less than they cost, and where all is merged as well already the second does (docs/integrators.md).
// inMedia: whether vertices lie in media, too.
inline uint32_t connectedOf(const Options& o, bool inMedia) {
  return o.merges && (o.mergesMedia || !inMedia) ? 1 : kConnected;
}

// Draws `most` of them, at most kConnected, each with a probability in proportion to what it carries and to how many
// vertices of camera paths it may be connected to; at most 1. u: random. kept: share of paths that any are drawn of.
inline void drawEnds(Stored* const* path, uint32_t count, uint32_t most, uint32_t bounces, float kept, float u) {
  if (!(u < kept)) return;
  u = std::min(u / kept, 0x1.fffffep-1f);
  if (count <= most) {
    for (uint32_t v = 0; v < count; ++v) path[v]->probability = kept;
    return;
  }
  // until it is known, the place of a vertex' probability holds its share
  float sum = 0, left = float(most);
  for (uint32_t v = 0; v < count; ++v) {
    const float* t = path[v]->at.throughput;
    path[v]->probability = std::max(t[0], std::max(t[1], t[2])) * float(bounces - v);
    sum += path[v]->probability;
  }
  // those that would be drawn more than once are drawn for certain, the others share what is left
  for (uint32_t v = 0; v < count && left > 1; ++v) {
    float& share = path[v]->probability;
    if (!(share * left > sum)) continue;
    sum -= share;
    share = -1;
    --left;
    v = uint32_t(-1);
  }
  uint32_t n = 0;
  float upTo = 0;
  for (uint32_t v = 0; v < count; ++v) {
    float& share = path[v]->probability;
    const float p = share < 0 ? 1.f : std::min(share * left / sum, 1.f);
    upTo += p;
    const bool isDrawn = n < most && p > 0 && u + float(n) < upTo;
    share = isDrawn ? p * kept : 0;
    n += isDrawn;
  }
}

// The vertices that a group's camera paths are connected to. The first of a path stands at its slot, the next `room`
// further on.
struct Ends {
  static constexpr uint32_t kNone = 1u << 20;
  uint32_t room;
  uint32_t *before, *light, *tail;  // before: vertices of the light path before it; kNone: there is no such end
  float *P[3], *throughput[3], *factor[2];  // throughput: over the probability of having been drawn
  float *last, *earlier, *edge, *merges;    // PathSums; Neighbourhoods::Of, as the next
  float *crossings, *through;               // PathDensities::throughVertex, for that direction
  float* back[3];                           // unit, to the vertex that it was connected to last
  float* start[3];                          // where a ray that way leaves it
  // what its bxdf says of that direction
  float *value[3], *pdf, *reverse, *cosine;
  uint32_t *context, *point;

  // make(array, many) gives an array its memory.
  template <class Make>
  void makeRoom(uint32_t each, const Make& make) {
    room = each;
    const uint32_t all = kConnected * room;
    for (uint32_t** x : {&before, &light, &tail, &context, &point}) make(*x, all);
    for (float** x :
         {&last, &earlier, &edge, &merges, &crossings, &through, &factor[0], &factor[1], &pdf, &reverse, &cosine})
      make(*x, all);
    for (int k = 0; k < 3; ++k)
      for (float** x : {&P[k], &throughput[k], &back[k], &start[k], &value[k]}) make(*x, all);
    std::fill_n(before, all, kNone);
  }
};

}  // namespace kinora::vcm
