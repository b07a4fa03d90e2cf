// Rays on their way through media that fill space, from one tentative collision to the next, and what they ask there of
// the media. Made and followed by group_space.cpp, for the rays of one call.
#pragma once
#include <vector>

#include "shade/group.h"

namespace kinora::shade {

inline constexpr uint32_t kMostOverlapping = 8;  // media at a point

// A medium around a ray, with the ray in its object space: the same distances lead to the same places.
struct Around {
  uint32_t medium;
  float o[3], d[3];
  float most;  // the bound where the ray is
};

struct Track {
  uint32_t entry;        // of the list
  uint32_t first, next;  // of crossings: this ray's first, and the next one to come
  uint32_t last;         // one behind its last
  uint32_t seed, event;
  float t, end;
  float left;     // of the optical depth to the next tentative collision; below 0: not drawn yet
  float bound;    // at that collision, of all media together
  float w[3];     // the factors on its channels
  float path[3];  // the same of its path before, which chances go by as well: else channels drift apart
  float even[3];  // optical depth of what is known exactly, for rays that are not scattered
  uint32_t count;
  Around around[kMostOverlapping];
};

// Mixes two words for a seed.
uint32_t mixedSeed(uint32_t a, uint32_t b);

class MediumTracks {
 public:
  // crossings: of these rays, ray by ray (numbers in the list of entries) in order of distance; they outlive the tracks.
  // ends: by entry, how far each ray goes. `scatters`: rays are ended by what they meet, else media that are the same
  // everywhere are summed in Track::even.
  MediumTracks(GroupState& g, const std::vector<MediumCrossing>& crossings, const Rays& rays, const float* ends,
               const uint32_t* seed, const uint32_t* index, uint32_t depth, uint32_t n, const uint32_t* entries,
               bool scatters);
  uint32_t count() const { return count_; }  // of rays that cross a boundary
  Track& operator[](uint32_t i) { return tracks_[i]; }
  static float number(Track& t);  // the next random number of its own
  // To the next tentative collision. False: the ray has come to its end.
  bool advance(uint32_t i);

 private:
  void enter(Track& t, uint32_t medium);
  static void leave(Track& t, uint32_t medium);
  void drawFirst(const uint32_t* seed, const uint32_t* index);

  GroupState& g_;
  const SpaceMedia& space_;
  const std::vector<MediumCrossing>& crossings_;
  const Rays& rays_;
  const bool scatters_;
  const uint32_t depth_;
  Track* tracks_ = nullptr;
  uint32_t count_ = 0;
  float* first_ = nullptr;  // of their first flights: of the samples' sequences, which cover the distances evenly
};

// What media are at places along rays, all places that are asked for at once: those whose extinction is a product are
// looked up, for the others their networks run.
class MediumLookups {
 public:
  MediumLookups(Arena& arena, uint32_t room, bool wantsEmission);
  // Of a medium around a track, where that is; answers are numbered in order.
  void add(const SpaceMedia& space, const Track& t, const Around& a);
  // Runs the networks.
  void run(GroupState& g, const Rays& rays, uint32_t depth);
  float *extinction[3], *emission[3];

 private:
  struct Ask {
    uint32_t at, entry, medium;
    float t;
  };
  Ask* ask_;
  uint32_t count_ = 0, asked_ = 0;
  bool emits_;
};

}  // namespace kinora::shade
