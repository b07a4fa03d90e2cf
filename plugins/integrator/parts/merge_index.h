// Vertices of light paths by place: what merging looks them up in. Built at the barrier behind the stage of light
// paths, from its records alone, and read by all threads. Cells are as large as the powers of two above the radii of
// the vertices in them; a hash of level and cell picks a bucket.
#pragma once
#include <kinora/integrator.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

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
  uint32_t verticesBefore() const { return length & ~kHasFactors; }
  bool hasFactors() const { return length & kHasFactors; }
};

struct MergeIndex {
  uint32_t bucketMask = 0;
  const uint32_t* first = nullptr;  // by bucket, and the end
  // By entry, padded:
  const uint32_t* cells = nullptr;  // hashes of level and cell
  const float* P[3] = {};
  const Photon* photons = nullptr;
  const uint32_t* records = nullptr;  // indices of the stored vertices

  static int levelOf(float radius) {
    int e;
    std::frexp(std::max(radius, 1e-30f), &e);
    return e;  // 2^e is up to twice the radius
  }
  static uint32_t hashOf(int level, int64_t x, int64_t y, int64_t z) {
    uint64_t h = uint64_t(x) * 0x9E3779B97F4A7C15ull ^ uint64_t(y) * 0xC2B2AE3D27D4EB4Full ^
                 uint64_t(z) * 0x165667B19E3779F9ull ^ uint64_t(int64_t(level)) * 0xD6E8FEB86659FD93ull;
    h ^= h >> 32;
    h *= 0xD6E8FEB86659FD93ull;
    return uint32_t(h >> 32) & 0x7fffffffu;  // others stand for no cell
  }
  static int64_t cellOf(float x, int level) { return int64_t(std::floor(std::ldexp(double(x), -level))); }

  // Calls visit(cell, begin, end) for runs of entries: vertices within `radius` of P are among those of them that are of
  // that cell. The order depends on the records alone. spread: the most by which radii of vertices that near differ
  // from this one, as a share of it.
  template <class Visit>
  void near(const float at[3], float radius, float spread, const Visit& visit) const {
    const int low = levelOf(radius * (1 - std::min(spread, 0.9f))), high = levelOf(radius * (1 + spread));
    for (int level = low; level <= high; ++level) {
      int64_t from[3], to[3];
      for (int k = 0; k < 3; ++k) {
        from[k] = cellOf(at[k] - radius, level);
        to[k] = cellOf(at[k] + radius, level);
      }
      for (int64_t z = from[2]; z <= to[2]; ++z)
        for (int64_t y = from[1]; y <= to[1]; ++y)
          for (int64_t x = from[0]; x <= to[0]; ++x) {
            const uint32_t cell = hashOf(level, x, y, z), bucket = cell & bucketMask;
            if (first[bucket] != first[bucket + 1]) visit(cell, first[bucket], first[bucket + 1]);
          }
    }
  }

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
    constexpr uint32_t kLeftOut = 0xffffffffu;  // instead of a hash
    uint32_t *unsorted, *first, *totals, *cells, *records;
    float* P[3];
    Photon* photons;
    const uint64_t room = count + kPad;
    if (!make(index, 1) || !make(unsorted, room) || !make(first, buckets + 1) || !make(totals, kParts + 1) ||
        !make(cells, room) || !make(photons, room) || !make(records, room) || !make(P[0], room) ||
        !make(P[1], room) || !make(P[2], room))
      return nullptr;
    std::memset(cells, 0, room * sizeof(uint32_t));
    for (float* x : P) std::fill_n(x + count, kPad, 0.f);
    const uint32_t mask = buckets - 1, perPart = buckets / uint32_t(kParts);
    parallel(services, (count + kChunk - 1) / kChunk, [&](uint64_t chunk) {
      for (uint64_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
        const Photon& p = photonOf(i);
        const int level = levelOf(p.radius);
        unsorted[i] = p.radius > 0
                          ? hashOf(level, cellOf(p.P[0], level), cellOf(p.P[1], level), cellOf(p.P[2], level))
                          : kLeftOut;
      }
    });
    // each part counts and fills its own buckets, in the order of the records
    parallel(services, kParts, [&](uint64_t part) {
      const uint32_t from = uint32_t(part) * perPart;
      std::fill_n(first + from, perPart, 0u);
      uint32_t total = 0;
      for (uint64_t i = 0; i < count; ++i)
        if (const uint32_t b = unsorted[i] & mask; b - from < perPart && unsorted[i] != kLeftOut) {
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
        if (const uint32_t b = unsorted[i] & mask; b - from < perPart && unsorted[i] != kLeftOut) {
          const uint32_t to = --first[b];
          photons[to] = photonOf(i);
          cells[to] = unsorted[i];
          records[to] = uint32_t(i);
          for (int k = 0; k < 3; ++k) P[k][to] = photons[to].P[k];
        }
    });
    first[buckets] = sum;
    *index = {mask, first, cells, {P[0], P[1], P[2]}, photons, records};
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
