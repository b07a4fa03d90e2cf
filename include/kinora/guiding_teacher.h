// How path guiding learns: the state of an epoch (kinora/guiding_state.h) from that of the one before and its lessons. For
// integrators that learn (IntegratorFunctions::learn); it runs between epochs, on all threads.
#pragma once
#include <kinora/guiding_state.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace kinora::guiding {

// Makes the state of the next epoch.
class Teacher {
 public:
  Teacher(const LearnServices& services, const Options& options)
      : s_(services),
        o_(options),
        old_(static_cast<const State*>(services.state)),
        lessons_(static_cast<const Lesson*>(services.records.records)),
        count_(services.records.count) {}

  void run() {
    if (old_ && old_->isIdle) return;  // the state stays
    const uint64_t most = uint64_t(o_.regions) + 1;
    // the octree that grows: entries, and of each region what it comes from
    if (!make(tree_, 8 * (most + 1)) || !make(from_, most) || !make(share_, most) || !make(region_, count_ + 1) ||
        !make(order_, count_ + 1) || !make(first_, most + 1) || !make(parts_, 4 * kCells))
      return;
    for (uint32_t i = 0; old_ && i < 4 * kCells; ++i) {
      uint32_t x, y;
      placeOf(i / 4, x, y);
      directionAt((float(4 * x + 1 + 2 * (i & 1)) * (0.5f / kSide)) - 1,
                  (float(4 * y + 1 + (i & 2)) * (0.5f / kSide)) - 1, parts_[i]);
    }
    frame();
    grow();
    sort();
    build();
  }

 private:
  template <class T>
  bool make(T*& to, uint64_t n) const {
    to = static_cast<T*>(s_.allocate(&s_, n * sizeof(T)));
    return to != nullptr;
  }
  template <class Body>
  void parallel(uint64_t n, const Body& body) const {
    s_.parallelFor(&s_, n, const_cast<Body*>(&body),
                   [](void* context, uint64_t i) { (*static_cast<const Body*>(context))(i); });
  }

  void frame() {
    if (old_) {
      std::memcpy(low_, old_->low, sizeof low_);
      scale_ = old_->scale;
      entries_ = old_->entries;
      regions_ = old_->regions;
      std::memcpy(tree_, old_->at(old_->tree), entries_ * sizeof(uint32_t));
      for (uint32_t e = 0; e < entries_; ++e)
        if (tree_[e] & kLeaf) tree_[e] &= ~(kIsOn | kIsKnown);
      for (uint32_t r = 0; r < regions_; ++r) {
        from_[r] = r;
        share_[r] = 1;
      }
      return;
    }
    const float radius = std::isfinite(s_.worldRadius) && s_.worldRadius > 0 ? s_.worldRadius * 1.01f : 1.f;
    for (int c = 0; c < 3; ++c) low_[c] = s_.worldCenter[c] - radius;
    scale_ = float(1u << kDepth) / (2 * radius);
    entries_ = 1;
    tree_[0] = kLeaf;  // region 0 holds nothing: it stands where no light has been seen
    regions_ = 1;
    from_[0] = kNone;
    share_[0] = 0;
  }

  uint32_t gridOf(float p, int c) const {
    const float x = (p - low_[c]) * scale_;
    return x > 0 ? uint32_t(std::min(x, float((1u << kDepth) - 1))) : 0u;
  }
  // The entry of the octree that a place falls to, and at which depth.
  uint32_t entryOf(const Lesson& l, uint32_t& depth) const {
    const uint32_t x = gridOf(l.P[0], 0), y = gridOf(l.P[1], 1), z = gridOf(l.P[2], 2);
    uint32_t e = 0;
    for (depth = 0; !(tree_[e] & kLeaf); ++depth) {
      const uint32_t k = kDepth - 1 - depth;
      e = tree_[e] + (x >> k & 1) + 2 * (y >> k & 1) + 4 * (z >> k & 1);
    }
    return e;
  }

  // Divides regions with many lessons. region_ holds each lesson's entry of the octree meanwhile.
  void grow() {
    const uint32_t mostEntries = 8 * o_.regions;
    uint32_t* lessonsAt;
    uint32_t* depthAt;
    if (!make(lessonsAt, mostEntries + 9) || !make(depthAt, mostEntries + 9)) {
      count_ = 0;
      return;
    }
    for (bool again = true; again;) {
      again = false;
      parallel((count_ + kChunk - 1) / kChunk, [&](uint64_t chunk) {
        for (uint64_t i = chunk * kChunk; i < std::min(count_, (chunk + 1) * kChunk); ++i) {
          uint32_t depth;
          region_[i] = entryOf(lessons_[i], depth);
        }
      });
      std::fill_n(lessonsAt, entries_, 0u);
      for (uint64_t i = 0; i < count_; ++i)
        if (lessonsAt[region_[i]]++ == 0) entryOf(lessons_[i], depthAt[region_[i]]);
      const uint32_t before = entries_;
      for (uint32_t e = 0; e < before; ++e) {
        if (!(tree_[e] & kLeaf) || !lessonsAt[e]) continue;
        const uint32_t own = tree_[e] & kRegion;
        const bool divides = lessonsAt[e] > o_.perRegion && depthAt[e] < kDepth && entries_ + 8 <= mostEntries &&
                             regions_ + 8 <= o_.regions;
        if (divides) {
          for (uint32_t k = 0; k < 8; ++k) tree_[entries_ + k] = kLeaf | own;
          tree_[e] = entries_;
          entries_ += 8;
          again = true;
        }
      }
    }
    // Regions of their own for the entries with lessons: the first that shares one keeps it.
    if (!make(owner_, uint64_t(o_.regions) + 1)) {
      count_ = 0;
      return;
    }
    std::fill_n(owner_, o_.regions + 1, uint32_t(kNone));
    owner_[0] = 0;
    for (uint32_t e = 0; e < entries_; ++e) {
      if (!(tree_[e] & kLeaf) || !lessonsAt[e]) continue;
      const uint32_t own = tree_[e] & kRegion;
      if (own && owner_[own] == kNone) {
        owner_[own] = e;
      } else if (regions_ < o_.regions) {
        from_[regions_] = own ? from_[own] : uint32_t(kNone);
        share_[regions_] = 0.25f;
        owner_[regions_] = e;
        if (own) share_[own] = 0.25f;
        tree_[e] = kLeaf | regions_++;
      }
    }
    parallel((count_ + kChunk - 1) / kChunk, [&](uint64_t chunk) {
      for (uint64_t i = chunk * kChunk; i < std::min(count_, (chunk + 1) * kChunk); ++i)
        region_[i] = tree_[region_[i]] & kRegion;
    });
  }

  // Lessons by region, in their order.
  void sort() {
    std::fill_n(first_, regions_ + 1, 0u);
    for (uint64_t i = 0; i < count_; ++i) ++first_[region_[i]];
    uint32_t sum = 0;
    for (uint32_t r = 0; r < regions_; ++r) {
      const uint32_t n = first_[r];
      first_[r] = sum;
      sum += n;
    }
    for (uint64_t i = 0; i < count_; ++i) order_[first_[region_[i]]++] = uint32_t(i);
    for (uint32_t r = regions_; r > 0; --r) first_[r] = first_[r - 1];
    first_[0] = 0;
  }

  void build() {
    const auto rounded = [](uint32_t n) { return (n + 15) / 16 * 16; };
    State head{};
    head.regions = regions_;
    head.entries = entries_;
    std::memcpy(head.low, low_, sizeof low_);
    head.scale = scale_;
    uint32_t at = rounded(sizeof(State) / 4);
    const auto place = [&](uint32_t words) {
      const uint32_t own = at;
      at += rounded(words);
      return own;
    };
    head.tree = place(entries_);
    const uint32_t guided = o_.directions ? regions_ : 0, weighed = o_.lights ? regions_ : 0;
    head.splits = place(guided * kSplitWords);
    head.density = place(guided * kCells);
    head.lights = place(guided * kCells);
    head.counts = place(guided * kCells);
    head.sums = place(guided * State::kSums);
    head.frames = place(guided * 4);
    head.lightWeights = place(weighed * kLightClusters);
    head.lightSums = place(weighed * 2 * kLightClusters);
    head.words = at + 16;
    auto* next = static_cast<State*>(s_.makeState(&s_, uint64_t(head.words) * 4));
    if (!next) return;
    head.lessons = (old_ ? old_->lessons : 0u) + uint32_t(count_);
    *next = head;
    if (o_.lights) weighLights(*next);
    if (o_.directions)
      buildGuides(*next);
    else
      std::memcpy(next->floats(next->tree), tree_, entries_ * sizeof(uint32_t));
  }

  void buildGuides(State& s) {
    State* next = &s;
    float angle[kCells];
    for (uint32_t c = 0; c < kCells; ++c) angle[c] = solidAngle(c);
    parallel(regions_, [&](uint64_t r) {
      frame(*next, uint32_t(r));
      sum(*next, uint32_t(r));
    });
    double seen = 0, seenLessons = 0;
    for (uint32_t r = 0; r < regions_; ++r) {
      const float* sums = next->floats(next->sums) + r * State::kSums;
      seen += double(sums[State::kSeen]);
      seenLessons += double(sums[State::kSeenLessons]);
    }
    next->seen = seenLessons > 0 ? float(seen / seenLessons) : 0.f;
    for (uint32_t r = 0; r < regions_; ++r) {
      float* sums = next->floats(next->sums) + r * State::kSums;
      // few lessons of its own say little
      sums[State::kReference] =
          (sums[State::kSeen] + kSeenPrior * next->seen) / (sums[State::kSeenLessons] + kSeenPrior);
    }
    halveAll(*next, angle);
    next->isTried = s_.lastSample >= o_.firstOff;
    next->isIdle = !o_.lights && next->isTried && paysNowhere(*next);
    uint32_t* tree = const_cast<uint32_t*>(next->at(next->tree));
    for (uint32_t e = 0; e < entries_; ++e) {
      if ((tree_[e] & kLeaf) && isKnown(*next, tree_[e] & kRegion)) {
        const bool isOn = !(next->floats(next->sums)[(tree_[e] & kRegion) * State::kSums + State::kLeftAlone] > 0);
        tree_[e] |= isOn ? kIsKnown | kIsOn : kIsKnown;
        next->guides = !next->isIdle;
      }
      tree[e] = tree_[e];
    }
  }

  // Factors on the clusters. Of a choice with the probabilities q r / sum(q r), where q is what the tree says, the
  // variance over a region is least for r^2 = mean of y^2 / q over mean of q, y being what the cluster brings.
  void weighLights(State& s) const {
    float* sums = s.floats(s.lightSums);
    parallel(regions_, [&](uint64_t r) {
      float* own = sums + r * 2 * kLightClusters;
      if (const uint32_t from = from_[r]; old_ && from != kNone) {
        const float keep = share_[r];
        const float* x = old_->floats(old_->lightSums) + from * 2 * kLightClusters;
        for (uint32_t k = 0; k < 2 * kLightClusters; ++k) own[k] = x[k] * keep;
      }
      for (uint32_t i = first_[r]; i < first_[r + 1]; ++i) {
        const Lesson& l = lessons_[order_[i]];
        if (!(l.cell & kOfLight)) continue;
        const uint32_t k = l.cell & (kLightClusters - 1);
        own[2 * k] += l.light;
        own[2 * k + 1] += l.visits;
      }
    });
    double all[kLightClusters][2] = {}, mean[2] = {};
    for (uint32_t r = 0; r < regions_; ++r)
      for (uint32_t k = 0; k < kLightClusters; ++k)
        for (uint32_t c = 0; c < 2; ++c) {
          const double x = double(sums[(r * kLightClusters + k) * 2 + c]);
          all[k][c] += x;
          mean[c] += x;
        }
    const double level = mean[1] > 0 && mean[0] > 0 ? mean[0] / mean[1] : 1;
    double expected[kLightClusters];
    for (uint32_t k = 0; k < kLightClusters; ++k)
      expected[k] = (all[k][0] + kFrameShare * level) / (all[k][1] + kFrameShare);
    parallel(regions_, [&](uint64_t r) {
      float* weight = s.floats(s.lightWeights) + r * kLightClusters;
      const float* own = sums + r * 2 * kLightClusters;
      double most = 0, x[kLightClusters];
      for (uint32_t k = 0; k < kLightClusters; ++k) {
        const bool isKnown = r > 0 && own[2 * k + 1] > 0;
        x[k] = isKnown ? (double(own[2 * k]) + kRegionShare * expected[k]) / (double(own[2 * k + 1]) + kRegionShare)
                       : expected[k];
        most = std::max(most, x[k]);
      }
      for (uint32_t k = 0; k < kLightClusters; ++k) weight[k] = std::max(float(std::sqrt(x[k] / most)), kLeastWeight);
    });
  }

  // Hardly any path comes to regions in which it is guided.
  bool paysNowhere(const State& s) const {
    double all = 0, on = 0;
    for (uint32_t r = 1; r < regions_; ++r) {
      const float* sums = s.floats(s.sums) + r * State::kSums;
      all += double(sums[State::kVisits]);
      if (isKnown(s, r) && !(sums[State::kLeftAlone] > 0)) on += double(sums[State::kVisits]);
    }
    return on < double(o_.least) * all;
  }
  // Enough has been seen there.
  static bool isKnown(const State& s, uint32_t region) {
    return region && *s.at(s.splits + region * kSplitWords) & 1;
  }

  // The sphere of a region's directions: of its first lessons, for as long as it is not divided.
  void frame(State& s, uint32_t region) const {
    float* f = s.floats(s.frames) + region * 4;
    if (old_ && from_[region] == region && !(share_[region] < 1)) {
      std::memcpy(f, old_->floats(old_->frames) + region * 4, 4 * sizeof(float));
      if (f[3] > 0) return;
    }
    // The mean of one over the distance, since directions turn by that; by what light comes from there.
    double P[3] = {}, near = 0, light = 0;
    uint32_t n = 0;
    for (uint32_t i = first_[region]; region && i < first_[region + 1]; ++i) {
      const Lesson& l = lessons_[order_[i]];
      if (l.cell & kOfLight) continue;
      for (int c = 0; c < 3; ++c) P[c] += double(l.P[c]);
      const double w = std::sqrt(double(l.light));
      near += w * double(l.near);
      light += w;
      ++n;
    }
    if (!n) return;
    for (int c = 0; c < 3; ++c) f[c] = float(P[c] / n);
    f[3] = light > 0 && std::isfinite(near / light) ? float(near / light) : 0.f;
  }
  // Light and counts by cell, seen from another frame: each cell in four parts.
  void inherit(const float* light, const float* count, const float from[4], float keep, const float to[4],
               float* lights, float* counts) const {
    if (std::memcmp(from, to, 4 * sizeof(float)) == 0 || !(from[3] > 0) || !(to[3] > 0)) {
      for (uint32_t c = 0; c < kCells; ++c) {
        lights[c] = light[c] * keep;
        counts[c] = count[c] * keep;
      }
      return;
    }
    std::fill_n(lights, kCells, 0.f);
    std::fill_n(counts, kCells, 0.f);
    const float shrinks = to[3] / from[3],
                moves[3] = {(from[0] - to[0]) * to[3], (from[1] - to[1]) * to[3], (from[2] - to[2]) * to[3]};
    for (uint32_t c = 0; c < kCells; ++c) {
      if (!(light[c] > 0 || count[c] > 0)) continue;
      const float l = light[c] * keep * 0.25f, n = count[c] * keep * 0.25f;
      for (uint32_t k = 0; k < 4; ++k) {
        const float* part = parts_[4 * c + k];
        const float d[3] = {moves[0] + part[0] * shrinks, moves[1] + part[1] * shrinks, moves[2] + part[2] * shrinks};
        const uint32_t cell = guiding::cellOf(d);
        lights[cell] += l;
        counts[cell] += n;
      }
    }
  }
  // The cell of a lesson's direction, in the frame of its region.
  static uint32_t cellOf(const Lesson& l, const float frame[4]) {
    constexpr uint32_t kMost = (1u << kDirectionBits) - 1;
    constexpr float kUnit = 2.f / float(kMost + 1);
    float d[3], e[3], b = 0, square = 0;
    directionAt((float(l.cell >> kDirectionBits & kMost) + 0.5f) * kUnit - 1,
                (float(l.cell & kMost) + 0.5f) * kUnit - 1, d);
    placeIn(frame, l.P, e);
    for (int c = 0; c < 3; ++c) {
      b += e[c] * d[c];
      square += e[c] * e[c];
    }
    const float t = std::sqrt(b * b + 1 - square) - b;
    for (int c = 0; c < 3; ++c) d[c] = e[c] + d[c] * t;
    return guiding::cellOf(d);
  }

  // Lessons of a region, over the epochs.
  void sum(State& s, uint32_t region) const {
    float* lights = s.floats(s.lights) + region * kCells;
    float* counts = s.floats(s.counts) + region * kCells;
    float* sums = s.floats(s.sums) + region * State::kSums;
    if (const uint32_t from = from_[region]; old_ && from != kNone) {
      // what is older counts for less: it was learned with less
      const float keep = 0.5f * share_[region];
      const float *a = old_->floats(old_->lights) + from * kCells, *b = old_->floats(old_->counts) + from * kCells;
      inherit(a, b, old_->floats(old_->frames) + from * 4, keep, s.floats(s.frames) + region * 4, lights, counts);
      const float* x = old_->floats(old_->sums) + from * State::kSums;
      for (uint32_t k = 0; k < State::kLeftAlone; ++k) sums[k] = x[k] * keep;
      sums[State::kLeftAlone] = x[State::kLeftAlone];
    }
    for (uint32_t i = first_[region]; i < first_[region + 1]; ++i) {
      const Lesson& l = lessons_[order_[i]];
      if (l.cell & kOfLight) continue;
      const uint32_t cell = cellOf(l, s.floats(s.frames) + region * 4);
      lights[cell] += l.light;
      counts[cell] += 1;
      sums[State::kVisits] += l.visits;
      if (l.seen >= 0) {
        sums[State::kSeen] += l.seen;
        sums[State::kSeenLessons] += 1;
      }
      if (!(l.cell & kWasGuided)) continue;
      sums[State::kGuided] += l.guided;
      sums[State::kPlain] += l.plain;
      sums[State::kGuidedLessons] += 1;
    }
    if (region == 0) return;
    if (s_.lastSample >= o_.firstOff && sums[State::kGuidedLessons] > 0 &&
        sums[State::kGuided] > o_.gain * sums[State::kPlain])
      sums[State::kLeftAlone] = 1;
  }

  // Halving by halving, the share of the first half: what lessons say, and as many as kPrior of them what a larger part of
  // space (`above`; null: all directions alike) does.
  void halve(const float* lights, const float* counts, const float* angle, const float* above, float* splits) const {
    constexpr float kPrior = 24;
    float light[2 * kCells], count[2 * kCells], size[2 * kCells];
    std::memcpy(light + kCells, lights, kCells * sizeof(float));
    std::memcpy(count + kCells, counts, kCells * sizeof(float));
    std::memcpy(size + kCells, angle, kCells * sizeof(float));
    for (uint32_t k = kCells - 1; k > 0; --k) {
      light[k] = light[2 * k] + light[2 * k + 1];
      count[k] = count[2 * k] + count[2 * k + 1];
      size[k] = size[2 * k] + size[2 * k + 1];
      const float expected = above ? above[k] : size[2 * k] / size[k];
      const float p =
          light[k] > 0 ? (count[k] * (light[2 * k] / light[k]) + kPrior * expected) / (count[k] + kPrior) : expected;
      splits[k] = std::clamp(p, 1e-3f, 0.999f);
    }
  }

  // Distributions, from the whole of space down to its regions.
  void halveAll(State& s, const float* angle) const {
    float *lights, *counts, *splits;  // by entry that has entries below
    uint32_t *inner, *above, n = 0;
    if (!make(inner, entries_) || !make(above, entries_)) return;
    for (uint32_t e = 0; e < entries_; ++e) {
      inner[e] = tree_[e] & kLeaf ? uint32_t(kNone) : n++;
      above[e] = kNone;
    }
    if (!make(lights, uint64_t(n) * kCells) || !make(counts, uint64_t(n) * kCells) ||
        !make(splits, uint64_t(n) * kCells))
      return;
    // entries below one come behind it
    for (uint32_t e = entries_; e-- > 0;) {
      if (inner[e] == kNone) continue;
      float *light = lights + inner[e] * kCells, *count = counts + inner[e] * kCells;
      std::fill_n(light, kCells, 0.f);
      std::fill_n(count, kCells, 0.f);
      for (uint32_t b = tree_[e]; b < tree_[e] + 8; ++b) {
        above[b] = inner[e];
        const uint32_t region = tree_[b] & kRegion;
        if (inner[b] == kNone && (region == 0 || owner_[region] != b)) continue;
        const float* x = inner[b] != kNone ? lights + inner[b] * kCells : s.floats(s.lights) + region * kCells;
        const float* y = inner[b] != kNone ? counts + inner[b] * kCells : s.floats(s.counts) + region * kCells;
        for (uint32_t c = 0; c < kCells; ++c) {
          light[c] += x[c];
          count[c] += y[c];
        }
      }
    }
    const auto expected = [&](uint32_t e) { return above[e] == kNone ? nullptr : splits + above[e] * kCells; };
    for (uint32_t e = 0; e < entries_; ++e)
      if (inner[e] != kNone)
        halve(lights + inner[e] * kCells, counts + inner[e] * kCells, angle, expected(e), splits + inner[e] * kCells);
    parallel(entries_, [&](uint64_t e) {
      const uint32_t region = tree_[e] & kRegion;
      if (inner[e] != kNone || region == 0 || owner_[region] != e) return;
      const float* light = s.floats(s.lights) + region * kCells;
      float sum = 0;
      for (uint32_t c = 0; c < kCells; ++c) sum += light[c];
      if (!(sum > 0) || !std::isfinite(sum)) return;
      float own[kCells];
      halve(light, s.floats(s.counts) + region * kCells, angle, expected(uint32_t(e)), own);
      // Shares of second moments; the density that is best for them goes with their roots (Rath et al., "Variance-Aware
      // Path Guiding", 2020).
      float chance[2 * kCells];
      const auto share = [&] {
        for (uint32_t k = 1; k < kCells; ++k) {
          chance[2 * k] = chance[k] * own[k];
          chance[2 * k + 1] = chance[k] * (1 - own[k]);
        }
      };
      chance[1] = 1;
      share();
      for (uint32_t c = 0; c < kCells; ++c) chance[kCells + c] = std::sqrt(chance[kCells + c] * angle[c]);
      auto* splits = reinterpret_cast<uint16_t*>(const_cast<uint32_t*>(s.at(s.splits + region * kSplitWords)));
      for (uint32_t k = kCells - 1; k > 0; --k) {
        chance[k] = chance[2 * k] + chance[2 * k + 1];
        const float p = std::clamp(chance[2 * k] / chance[k], 1e-3f, 0.999f);
        const auto number = uint16_t(p * (1 / kSplitUnit));
        splits[splitAt(k)] = number;
        own[k] = (float(number) + 0.5f) * kSplitUnit;
      }
      float* sums = s.floats(s.sums) + region * State::kSums;
      sums[State::kRadiance] = chance[1] * std::sqrt(sum / std::max(sums[State::kVisits], 1.f));
      chance[1] = kCells / 4.f;  // per area of the map, which is 4
      share();
      std::memcpy(s.floats(s.density) + region * kCells, chance + kCells, kCells * sizeof(float));
      splits[0] = 1;  // it is there
    });
  }

  static constexpr uint32_t kNone = 0xffffffffu;
  static constexpr uint64_t kChunk = 4096;
  static constexpr float kSeenPrior = 8;
  // Lessons that what is expected counts for: of all clusters for one, of one over the frame for a region.
  static constexpr double kFrameShare = 16, kRegionShare = 2;
  static constexpr float kLeastWeight = 1e-3f;
  const LearnServices& s_;
  const Options& o_;
  const State* old_;
  float (*parts_)[3] = nullptr;  // directions of quarters of cells
  const Lesson* lessons_;
  uint64_t count_;
  uint32_t *tree_ = nullptr, *from_ = nullptr, *region_ = nullptr, *order_ = nullptr, *first_ = nullptr,
           *owner_ = nullptr;
  float* share_ = nullptr;
  uint32_t entries_ = 0, regions_ = 0;
  float low_[3] = {}, scale_ = 1;
};

inline void learn(const Options& options, const LearnServices& services) { Teacher(services, options).run(); }

}  // namespace kinora::guiding
