// Looks up MergeIndex: what lies within the radii of many queries. Included per target.
#include <kinora/simd/records.h>

#ifndef KINORA_VCM_MERGE_SEARCH_ONCE
#define KINORA_VCM_MERGE_SEARCH_ONCE
#include "plugins/integrator/parts/merge_index.h"
#endif

#if defined(KINORA_VCM_MERGE_SEARCH_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_VCM_MERGE_SEARCH_H_TARGET
#undef KINORA_VCM_MERGE_SEARCH_H_TARGET
#else
#define KINORA_VCM_MERGE_SEARCH_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Calls visit(query, n, entries) for the vertices within the radii of queries, in their order, for each once or more often,
// with kFound entries at most. What it calls with depends on the records alone, not on W.
template <int W, class Visit>
class MergeSearch {
  using F = Float<W>;
  using I = Int<W>;
  using MergeIndex = vcm::MergeIndex;

 public:
  MergeSearch(const MergeIndex& index, const MergeIndex::Query* queries, const Visit& visit)
      : index_(index), queries_(queries), visit_(visit) {}

  // spread: the most by which radii of vertices that near differ from the query's, as a share of it.
  void run(uint32_t count, float spread) {
    for (uint32_t q = 0; q < count; ++q) {
      const auto& [P, radius] = queries_[q];
      const double farthest = double(radius) * radius * (1 + 1e-5);
      const int low = MergeIndex::levelOf(radius * (1 - std::min(spread, 0.9f)));
      const int high = MergeIndex::levelOf(radius * (1 + spread));
      for (int level = low; level <= high; ++level) {
        const double size = std::bit_cast<double>(uint64_t(1023 + level) << 52);
        int64_t from[3], to[3];
        for (int k = 0; k < 3; ++k) {
          from[k] = MergeIndex::cellOf(P[k] - radius, level);
          to[k] = MergeIndex::cellOf(P[k] + radius, level);
        }
        // along an axis, from the place to a cell, squared; cells of a line are asked of again for each other line
        const auto distance = [&](int axis, int64_t cell) {
          const double below = double(cell) * size - double(P[axis]),
                       d = std::max(std::max(below, -below - size), 0.0);
          return d * d;
        };
        constexpr int64_t kKnown = 4;
        double known[3][kKnown];
        for (int k = 0; k < 3; ++k)
          for (int64_t i = 0; i < kKnown && i <= to[k] - from[k]; ++i) known[k][i] = distance(k, from[k] + i);
        const auto away = [&](int axis, int64_t cell) {
          const int64_t i = cell - from[axis];
          return i < kKnown ? known[axis][i] : distance(axis, cell);
        };
        for (int64_t z = from[2]; z <= to[2]; ++z) {
          const typename MergeIndex::Cell::Slab slab(level, z);
          const double far = away(2, z);
          for (int64_t y = from[1]; y <= to[1]; ++y) {
            const double rest = farthest - far - away(1, y);
            if (rest < 0) continue;
            int64_t first = from[0], end = to[0];
            while (first < end && away(0, first) > rest) ++first;
            while (first < end && away(0, end) > rest) --end;
            for (int64_t x = first, last; x <= end; x = last + 1) {
              last = std::min(end, x | 3);  // of this block
              add(q, MergeIndex::Cell::of(slab, y, x), uint32_t(last - x));
            }
          }
        }
      }
    }
    search();
  }

 private:
  // Cells that follow each other, of a block. Memory answers late: all that is wanted is asked for before any is read.
  struct Row {
    uint32_t query, tag, more, bucket, begin, end;
  };
  static constexpr uint32_t kMost = 256, kFound = 64, kTogether = MergeIndex::kTogether;
  static_assert(kTogether % W == 0);

  void add(uint32_t query, MergeIndex::Cell cell, uint32_t more) {
    if (count_ == kMost) search();
    rows_[count_] = {query, cell.tag, more, cell.bucket & index_.bucketMask, 0, 0};
    __builtin_prefetch(index_.first + rows_[count_++].bucket);
  }
  void search() {
    uint32_t filled = 0;
    for (uint32_t r = 0; r < count_; ++r) {
      Row row = rows_[r];
      row.begin = index_.first[row.bucket];
      row.end = index_.first[row.bucket + row.more + 1];
      if (row.begin == row.end) continue;
      __builtin_prefetch(index_.places + row.begin);
      rows_[filled++] = row;
    }
    uint32_t found[kFound + kTogether], n = 0, query = 0;
    const auto send = [&] {
      if (n) visit_(query, n, found);
      n = 0;
    };
    for (uint32_t r = 0; r < filled; ++r) {
      const Row& row = rows_[r];
      if (row.query != query) send();
      query = row.query;
      for (uint32_t i = row.begin; i < row.end; i += kTogether) {
        if (n + kTogether > kFound) send();
        const uint32_t before = n;
        n += lookAt(row, i, std::min(row.end, i + kTogether), found + n);
        for (uint32_t k = before; k < n; ++k) __builtin_prefetch(index_.photons + found[k]);
      }
    }
    send();
    count_ = 0;
  }
  // Writes the entries of [begin, end) that are near, in order, and W of room.
  KN_INLINE uint32_t lookAt(const Row& row, uint32_t begin, uint32_t end, uint32_t* found) const {
    const MergeIndex::Query& query = queries_[row.query];
    const F x(query.P[0]), y(query.P[1]), z(query.P[2]), square(query.radius * query.radius);
    uint32_t n = 0;
    for (uint32_t i = begin; i < end; i += W) {
      const float *const first = index_.places[i].P, *from[W];
#pragma GCC unroll 16
      for (int k = 0; k < W; ++k) from[k] = first + 4 * k;
      F place[4];
      loadFours<W>(from, place);
      const F a = place[0] - x, b = place[1] - y, c = place[2] - z;
      const I cell = asInt(place[3]) - I(row.tag);
      const Mask<W> isNear = (fma(a, a, fma(b, b, c * c)) <= square) & !((cell < I(0)) | (I(row.more) < cell)) &
                             Mask<W>::firstN(int(std::min<uint32_t>(end - i, W)));
      const Packer<W> pack(isNear);
      pack.put(I::lanes(int32_t(i)), found + n);
      n += uint32_t(pack.count);
    }
    return n;
  }

  const MergeIndex& index_;
  const MergeIndex::Query* queries_;
  const Visit& visit_;
  Row rows_[kMost];
  uint32_t count_ = 0;
};
template <int W, class Visit>
void findNear(const vcm::MergeIndex& index, uint32_t count, const vcm::MergeIndex::Query* queries, float spread,
              const Visit& visit) {
  MergeSearch<W, Visit>(index, queries, visit).run(count, spread);
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
