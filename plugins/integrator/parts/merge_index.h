// Vertices of light paths by place: what merging looks them up in. Built at the barrier behind the stage of light
// paths, from its records alone, and read by all threads. Cells are as large as the powers of two above the radii of
// the vertices in them; a hash of level and block of cells picks buckets that follow each other.
#pragma once
#include <kinora/integrator.h>

#include <algorithm>
#include <bit>
#include <cstdint>

namespace kinora::vcm {

// What merging wants of a stored vertex, in one line of the cache.
struct Photon {
  float P[3], wo[3];    // wo: towards where the path came from
  float throughput[3];  // in media over the extinction there: as much as passes, not as is scattered
  float last, before;   // PathSums, the first only where a method connects the last edge
  float time, radius;   // radius 0: it is not merged
  uint32_t light;
  uint32_t length;                                      // vertices before it; and the bits below
  static constexpr uint32_t kHasFactors = 0x80000000u;  // PathVertex::factor is not 1
  uint32_t medium;                                      // that it lies in: Places::instance; kNoMedium: on a surface
  static constexpr uint32_t kNoMedium = 0xffffffffu;
};

struct MergeIndex {
  uint32_t bucketMask = 0;
  const uint32_t* first = nullptr;  // by bucket, and the end
  // By entry:
  struct Place {
    float P[3];
    uint32_t tag;  // Cell::tag
  };
  const Place* places = nullptr;  // and kTogether more, so that they can be read together
  const Photon* photons = nullptr;
  const uint32_t* records = nullptr;  // indices of the stored vertices

  // e: 2^e is above the radius, and up to twice it.
  static int levelOf(float radius) { return int(std::bit_cast<uint32_t>(std::max(radius, 1e-30f)) >> 23) - 126; }
  // A number that hardly any other cell has, which also picks a bucket. Those of a block of 4 x 4 x 4 cells follow each
  // other, so that what a point is merged with lies close together in memory.
  struct Cell {
    uint32_t tag, bucket;
    static Cell of(int level, int64_t x, int64_t y, int64_t z) { return of(Slab(level, z), y, x); }
    // What cells of one z have in common.
    struct Slab {
      uint32_t h, inBlock;
      Slab(int level, int64_t z)
          : h(uint32_t(z >> 2) * 0x165667B1u ^ uint32_t(level) * 0xD6E8FEB9u), inBlock(uint32_t(z & 3) << 4) {}
    };
    static Cell of(const Slab& slab, int64_t y, int64_t x) {
      uint32_t h = slab.h ^ uint32_t(x >> 2) * 0x9E3779B1u ^ uint32_t(y >> 2) * 0xC2B2AE3Du;
      h = (h ^ h >> 16) * 0x7FEB352Du;
      h = (h ^ h >> 15) * 0x846CA68Bu;
      const uint32_t inBlock = slab.inBlock | uint32_t(y & 3) << 2 | uint32_t(x & 3);
      return {h << 6 | inBlock, (h ^ h >> 16) << 6 | inBlock};
    }
  };
  static int64_t cellOf(float x, int level) {
    const double at = double(x) * std::bit_cast<double>(uint64_t(1023 - level) << 52);
    const int64_t below = int64_t(at);
    return below - (at < double(below));
  }

  struct Query {
    float P[3], radius;
  };
  static constexpr uint32_t kTogether = 16;  // entries that a kernel looks at in one go, at most

  // photonOf(i): of record i. Null where there is no memory for it.
  template <class PhotonOf>
  static const MergeIndex* build(const CommitServices& services, uint64_t count, const PhotonOf& photonOf) {
    constexpr uint64_t kParts = 32, kChunk = 4096;
    const auto make = [&]<class T>(T*& to, uint64_t n) {
      to = static_cast<T*>(services.allocate(&services, n * sizeof(T)));
      return to != nullptr;
    };
    uint32_t buckets = 64;
    while (buckets < count && buckets < 1u << 28) buckets *= 2;
    MergeIndex* index;
    constexpr uint32_t kLeftOut = 0xffffffffu;  // instead of a bucket
    Cell* unsorted;
    uint32_t *first, *totals, *records;
    Place* places;
    Photon* photons;
    if (!make(index, 1) || !make(unsorted, count) || !make(first, buckets + 1) || !make(totals, kParts + 1) ||
        !make(places, count + kTogether) || !make(photons, count) || !make(records, count))
      return nullptr;
    const uint32_t mask = buckets - 1, perPart = buckets / uint32_t(kParts);
    parallel(services, (count + kChunk - 1) / kChunk, [&](uint64_t chunk) {
      for (uint64_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
        const Photon& p = photonOf(i);
        const int level = levelOf(p.radius);
        unsorted[i] = {0, kLeftOut};
        if (!(p.radius > 0)) continue;
        unsorted[i] = Cell::of(level, cellOf(p.P[0], level), cellOf(p.P[1], level), cellOf(p.P[2], level));
        unsorted[i].bucket &= mask;
      }
    });
    // each part counts and fills its own buckets, in the order of the records
    parallel(services, kParts, [&](uint64_t part) {
      const uint32_t from = uint32_t(part) * perPart;
      std::fill_n(first + from, perPart, 0u);
      uint32_t total = 0;
      for (uint64_t i = 0; i < count; ++i)
        if (const uint32_t b = unsorted[i].bucket; b - from < perPart) {
          ++first[b];
          ++total;
        }
      totals[part] = total;
    });
    uint32_t sum = 0;
    for (uint64_t part = 0; part < kParts; ++part) {
      const uint32_t n = totals[part];
      totals[part] = sum;
      sum += n;
    }
    parallel(services, kParts, [&](uint64_t part) {
      const uint32_t from = uint32_t(part) * perPart;
      uint32_t at = totals[part];
      for (uint32_t b = from; b < from + perPart; ++b) {
        at += first[b];
        first[b] = at;  // its end; counted down while it is filled from behind
      }
      for (uint64_t i = count; i-- > 0;)
        if (const uint32_t b = unsorted[i].bucket; b - from < perPart) {
          const uint32_t to = --first[b];
          photons[to] = photonOf(i);
          records[to] = uint32_t(i);
          for (int k = 0; k < 3; ++k) places[to].P[k] = photons[to].P[k];
          places[to].tag = unsorted[i].tag;
        }
    });
    first[buckets] = sum;
    std::fill_n(places + sum, count + kTogether - sum, Place{});
    *index = {mask, first, places, photons, records};
    return index;
  }

 private:
  template <class Body>
  static void parallel(const CommitServices& services, uint64_t n, const Body& body) {
    services.parallelFor(&services, n, const_cast<Body*>(&body),
                         [](void* context, uint64_t i) { (*static_cast<const Body*>(context))(i); });
  }
};

}  // namespace kinora::vcm
