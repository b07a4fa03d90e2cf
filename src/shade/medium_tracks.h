// Rays on their way through media that fill space, from one tentative collision to the next, and what they ask there of
// the media. Made and followed by group_space.cpp and group_transmittance.cpp, for the rays of one call.
#pragma once
#include <algorithm>
#include <cstring>
#include <vector>

#include "shade/group.h"

namespace kinora::shade {

inline constexpr uint32_t kMostOverlapping = 8;  // media at a point

// A medium around a ray, with the ray in its object space: the same distances lead to the same places.
struct Around {
  uint32_t medium;
  float o[3], d[3], inverse[3];  // inverse: 1 / d, or 0
  float most;                    // the bound where the ray is
  float scale;                   // on its extinction, see SpaceMedium::similarity
  uint32_t level;                // of its fields, where the ray is
  float coarserFrom;             // the distance where the next one begins
};

struct Track {
  uint32_t entry;        // of the list
  uint32_t first, next;  // of crossings: this ray's first, and the next one to come
  uint32_t last;         // one behind its last
  uint32_t seed, event;
  uint32_t bounces;  // scatterings in media before, one after another
  float time, t, end;
  float radius, spread;  // of the ray's footprint
  float left;            // of the optical depth to the next tentative collision; below 0: not drawn yet
  float bound;           // at that collision, of all media together
  float w[3];            // the factors on its channels
  float path[3];         // the same of its path before, which chances go by as well: else channels drift apart
  float even[3];         // optical depth of what is known exactly, for rays that are not scattered
  uint32_t count;
  Around* around;  // room for as many as it crosses boundaries, kMostOverlapping at most
  Track() = default;
  Track(const Track&) = delete;  // see TrackAhead
  Track& operator=(const Track&) = delete;
};

// Mixes two words for a seed.
uint32_t mixedSeed(uint32_t a, uint32_t b);

class MediumTracks {
 public:
  // crossings: of these rays, ray by ray (numbers in the list of entries) in order of distance; they outlive the tracks.
  // part of parts: of so many tracks along the same rays that go by numbers of their own.
  // ends: by entry, how far each ray goes; bounces: how often its light was scattered in media (null: never). `scatters`: rays are ended by what they meet, else media that are the same
  // everywhere are summed in Track::even.
  MediumTracks(GroupState& g, const std::vector<MediumCrossing>& crossings, const Rays& rays, const float* ends,
               const uint32_t* seed, const uint32_t* index, const uint32_t* bounces, uint32_t depth, uint32_t n,
               const uint32_t* entries, bool scatters, uint32_t part = 0, uint32_t parts = 1);
  uint32_t count() const { return count_; }  // of rays that cross a boundary
  Track& operator[](uint32_t i) { return tracks_[i]; }
  static float number(Track& t);  // the next random number of its own
  // A second one that goes with the first of a track's: of the sample's sequence too. Of tracks that scatter.
  float numberTowards(uint32_t i) const { return towards_[i]; }
  // To the next tentative collision. False: the ray has come to its end.
  bool advance(uint32_t i);
  // Without any: what the media around a track are about, as far as the same cells hold. The sum of their extinctions,
  // and how much of these counts for distances that extinction draws (plain) and for those that suit lights (towards).
  struct Stretch {
    float until, extinction[3], plain[3], towards[3];
  };
  void stretch(const Track& t, Stretch& s) const;
  // Up to there the media around a track stay the same.
  float border(const Track& t) const { return t.next < t.last ? std::min(crossings_[t.next].t, t.end) : t.end; }
  bool pass(Track& t, float until);  // to its end, as advance()

 private:
  void enter(Track& t, uint32_t medium);
  static void leave(Track& t, uint32_t medium);
  void drawFirst(const uint32_t* seed, const uint32_t* index, uint32_t part, uint32_t parts);

  GroupState& g_;
  const SpaceMedia& space_;
  const std::vector<MediumCrossing>& crossings_;
  const Rays& rays_;
  const bool scatters_;
  const uint32_t depth_;
  Track* tracks_ = nullptr;
  uint32_t count_ = 0;
  float* first_ = nullptr;  // of their first flights: of the samples' sequences, which cover the distances evenly
  float* towards_ = nullptr;
  // Of the medium that was entered last, where it stands still.
  uint32_t lastMedium_ = ~0u;
  trace::Affine toLast_;
};

inline constexpr uint32_t kMostCollisions = 1u << 16;  // tentative ones of a ray

// Takes the open tracks to their next tentative collisions; end(track) hears of those that have none. Returns how many
// go on, which stay in `open`.
template <class End>
uint32_t advanceAll(MediumTracks& tracks, uint32_t m, uint32_t* open, uint64_t& endless, End&& end) {
  uint32_t going = 0;
  for (uint32_t i = 0; i < m; ++i) {
    Track& t = tracks[open[i]];
    if (t.event > kMostCollisions) {
      ++endless;
      for (float& w : t.w) w = 0;
    } else if (tracks.advance(open[i])) {
      open[going++] = open[i];
      continue;
    }
    end(t);
  }
  return going;
}

// By entry, how far the listed rays go in media, which is `ends`, but for those of the camera no farther than clipping
// planes let it see. The farthest distance of other rays is one of surfaces alone.
inline const float* clippedEnds(Arena& arena, const RayList& list, const float* ends, uint32_t n,
                                const uint32_t* entries) {
  if (ListHost::of(list).kind != RayKind::Camera) return ends;
  const float* tMax = list.rays.tMax;
  if (std::none_of(entries, entries + n, [&](uint32_t s) { return tMax[s] < std::min(ends[s], 1e30f); })) return ends;
  float* clipped = arena.make<float>(list.capacity);
  for (uint32_t i = 0; i < n; ++i) clipped[entries[i]] = std::min(ends[entries[i]], tMax[entries[i]]);
  return clipped;
}

// A copy of a track that goes on without it: to look ahead.
struct TrackAhead {
  Track t;
  explicit TrackAhead(const Track& from) {
    std::memcpy(static_cast<void*>(&t), &from, sizeof t);
    std::copy_n(from.around, from.count, own_);
    t.around = own_;
  }

 private:
  Around own_[kMostOverlapping];
};

// What media are at places along rays, all places that are asked for at once: those whose extinction is a product are
// looked up, for the others, and for what emits, their networks run.
class MediumLookups {
 public:
  MediumLookups(Arena& arena, uint32_t room, bool wantsEmission);
  // Of a medium around a track, where that is; answers are numbered in order.
  void add(const SpaceMedia& space, const Track& t, const Around& a);
  // Looks up and runs the networks.
  void run(GroupState& g, const Rays& rays, uint32_t depth);
  float *extinction[3], *emission[3];

 private:
  struct Ask {
    uint32_t at, entry, medium;
    float t, scale;
    bool isLookedUp;  // its extinction; what emits is asked all the same
  };
  struct Product {
    uint32_t at, medium, level;
    float scale;
  };
  void lookUpProducts(GroupState& g);

  Ask* ask_;
  Product* products_;
  float *place_[3], *time_;  // of products: object space
  uint32_t count_ = 0, asked_ = 0, productCount_ = 0;
  bool emits_;
};

// Runs the networks of media at n entries of a list, which are hits of them: put(entry, channel, extinction, emission),
// what is no usable number is 0.
template <class Put>
void askMedia(GroupState& g, RayList& list, uint32_t n, uint32_t depth, bool wantsEmission, Put&& put) {
  uint32_t* entries = g.arena().make<uint32_t>(padded(n));
  for (uint32_t i = 0; i < padded(n); ++i) {
    list.sampleSeed[i] = list.sampleIndex[i] = 0;
    entries[i] = std::min(i, n - 1);
  }
  Context* const* contexts;
  const uint32_t count =
      g.shade(list, kTraitEyePath | kTraitInSpace | kTraitPresenceQuery, depth, n, entries, &contexts);
  const auto usable = [](float x) { return x > 0 && x < 1e30f ? x : 0.f; };
  for (uint32_t c = 0; c < count; ++c) {
    const Context* x = contexts[c];
    MediumArgs args;
    for (int k = 0; k < 3; ++k) {
      args.extinction[k] = x->alloc<float>(x->padded);
      args.emission[k] = wantsEmission ? x->alloc<float>(x->padded) : nullptr;
    }
    x->bxdf->medium(x, &args);
    for (uint32_t i = 0; i < x->count; ++i)
      for (int k = 0; k < 3; ++k)
        put(x->path[i], k, usable(args.extinction[k][i]), wantsEmission ? usable(args.emission[k][i]) : 0.f);
  }
}

}  // namespace kinora::shade
