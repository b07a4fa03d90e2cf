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
  uint32_t verticesBefore() const { return length & ~kHasFactors; }
  bool hasFactors() const { return length & kHasFactors; }
};

struct MergeIndex {
  uint32_t bucketMask = 0;
  const uint32_t* first = nullptr;  // by bucket, and the end
  // By entry:
  struct Place {
    float P[3];
    uint32_t tag;  // Cell::tag
  };
  const Place* places = nullptr;
  const Photon* photons = nullptr;
  const uint32_t* records = nullptr;  // indices of the stored vertices

  // e: 2^e is above the radius, and up to twice it.
  static int levelOf(float radius) { return int(std::bit_cast<uint32_t>(std::max(radius, 1e-30f)) >> 23) - 126; }
  // A number that hardly any other cell has, which also picks a bucket. Those of a block of 4 x 4 x 4 cells follow each
  // other, so that what a point is merged with lies close together in memory.
  struct Cell {
    uint32_t tag, bucket;
    static Cell of(int level, int64_t x, int64_t y, int64_t z) {
      uint64_t h = uint64_t(x >> 2) * 0x9E3779B97F4A7C15ull ^ uint64_t(y >> 2) * 0xC2B2AE3D27D4EB4Full ^
                   uint64_t(z >> 2) * 0x165667B19E3779F9ull ^ uint64_t(int64_t(level)) * 0xD6E8FEB86659FD93ull;
      h ^= h >> 32;
      h *= 0xD6E8FEB86659FD93ull;
      h ^= h >> 29;
      const uint32_t inBlock = uint32_t(z & 3) << 4 | uint32_t(y & 3) << 2 | uint32_t(x & 3);
      return {uint32_t(h) << 6 | inBlock, uint32_t(h >> 32) << 6 | inBlock};
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
  // Calls visit(query, n, entries) for the vertices within the radii of the queries, in their order, for each once or more
  // often. The order depends on the records alone. spread: the most by which radii of vertices that near differ from the
  // query's, as a share of it.
  template <class Visit>
  void near(uint32_t count, const Query* queries, float spread, const Visit& visit) const {
    Rows<Visit> rows(*this, queries, visit);
    for (uint32_t q = 0; q < count; ++q) {
      const auto& [P, radius] = queries[q];
      const int low = levelOf(radius * (1 - std::min(spread, 0.9f))), high = levelOf(radius * (1 + spread));
      for (int level = low; level <= high; ++level) {
        int64_t from[3], to[3];
        for (int k = 0; k < 3; ++k) {
          from[k] = cellOf(P[k] - radius, level);
          to[k] = cellOf(P[k] + radius, level);
        }
        for (int64_t z = from[2]; z <= to[2]; ++z)
          for (int64_t y = from[1]; y <= to[1]; ++y)
            for (int64_t x = from[0], last; x <= to[0]; x = last + 1) {
              last = std::min(to[0], x | 3);  // of this block
              rows.add(q, Cell::of(level, x, y, z), uint32_t(last - x));
            }
      }
    }
    rows.search();
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
    constexpr uint32_t kLeftOut = 0xffffffffu;  // instead of a bucket
    Cell* unsorted;
    uint32_t *first, *totals, *records;
    Place* places;
    Photon* photons;
    if (!make(index, 1) || !make(unsorted, count) || !make(first, buckets + 1) || !make(totals, kParts + 1) ||
        !make(places, count) || !make(photons, count) || !make(records, count))
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
    *index = {mask, first, places, photons, records};
    return index;
  }

 private:
  // Cells that follow each other, of a block. Memory answers late: all that is wanted is asked for before any is read.
  template <class Visit>
  struct Rows {
    const MergeIndex& index;
    const Query* queries;
    const Visit& visit;
    static constexpr uint32_t kMost = 256, kFound = 64;
    Rows(const MergeIndex& in, const Query* of, const Visit& v) : index(in), queries(of), visit(v) {}
    struct Row {
      uint32_t query, tag, more, bucket, begin, end;
    };
    Row rows[kMost];
    uint32_t count = 0;

    void add(uint32_t query, Cell cell, uint32_t more) {
      if (count == kMost) search();
      rows[count] = {query, cell.tag, more, cell.bucket & index.bucketMask, 0, 0};
      __builtin_prefetch(index.first + rows[count++].bucket);
    }
    void search() {
      uint32_t filled = 0;
      for (uint32_t r = 0; r < count; ++r) {
        Row row = rows[r];
        row.begin = index.first[row.bucket];
        row.end = index.first[row.bucket + row.more + 1];
        if (row.begin == row.end) continue;
        __builtin_prefetch(index.places + row.begin);
        rows[filled++] = row;
      }
      uint32_t all[kFound + 2] = {}, *found = all + 1, n = 0, query = 0;
      const auto send = [&] {
        if (n) visit(query, n, found);
        n = 0;
      };
      for (uint32_t r = 0; r < filled; ++r) {
        const Row& row = rows[r];
        if (row.query != query) send();
        query = row.query;
        const auto& [at, radius] = queries[query];
        const float square = radius * radius;
        for (uint32_t i = row.begin; i < row.end;) {
          // what is near is a matter of chance: no branch is taken for it
          for (const uint32_t end = std::min(row.end, i + kFound - n); i < end; ++i) {
            const Place& p = index.places[i];
            const float a = p.P[0] - at[0], b = p.P[1] - at[1], c = p.P[2] - at[2];
            found[n] = i;
            n += uint32_t(a * a + b * b + c * c <= square) & uint32_t(p.tag - row.tag <= row.more);
            __builtin_prefetch(index.photons + found[int(n) - 1]);  // the last that is
          }
          if (n == kFound) send();
        }
      }
      send();
      count = 0;
    }
  };

  template <class Body>
  static void parallel(const CommitServices& services, uint64_t n, const Body& body) {
    services.parallelFor(&services, n, const_cast<Body*>(&body),
                         [](void* context, uint64_t i) { (*static_cast<const Body*>(context))(i); });
  }
};

}  // namespace kinora::vcm
