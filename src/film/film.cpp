#include "film/film.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <tuple>

#include "film/round_block.h"
#include "film/sample_order.h"

namespace kinora::film {
namespace {

bool takes(Half half, uint32_t sampleIndex) {
  return half == Half::Both || ((sampleIndex & 1u) == 0) == (half == Half::Even);
}

// kBlock floats of a span's array; the last, partial block is copied so that nothing beyond n is read.
const float* blockOf(const float* values, int first, int n, float* padded) {
  if (n == kBlock) return values + first;
  std::fill(std::copy_n(values + first, n, padded), padded + kBlock, 0.0f);
  return padded;
}

}  // namespace

// ---- set-up

void Film::plan() {
  rules_.assign(kHeaderSlots, SlotRule::Add);
  firstSlot_.assign(size_t(layout_.size()), -1);
  firstSplatSlot_.assign(size_t(layout_.size()), -1);
  filterSlots_.assign(size_t(layout_.size()), {});
  std::array<int, 2 * kWeightKinds> slotOfWeight;  // by kind: of the weights; behind them of their squares
  slotOfWeight.fill(-1);
  infinityAllowed_.assign(size_t(layout_.recordFloats()), 1);
  countNegative_.assign(size_t(layout_.recordFloats()), 0);
  const auto newSlot = [&](SlotRule rule) {
    rules_.push_back(rule);
    return int(rules_.size()) - 1;
  };
  // One slot for each weight that some channel asks for.
  const auto weightSlot = [&](int c, uint8_t weight, int what) {
    int& slot = slotOfWeight[size_t(weight) + (what == kItsSquare ? size_t(kWeightKinds) : 0)];
    if (slot < 0) {
      slot = newSlot(SlotRule::Add);
      sums_.push_back(
          {what, weight, SumOf::Value, true, int16_t(c), std::ldexp(1.0, -kWeightStepLog2), std::ldexp(1.0, 46)});
    }
    return slot;
  };
  for (int c = 0; c < layout_.size(); ++c) {
    const Channel& ch = layout_[c];
    if (ch.reducer != Reducer::Sum && ch.reducer != Reducer::Average && ch.reducer != Reducer::Total) continue;
    const int filter = layout_.filterOf(c), half = int(ch.half);
    const bool isFiltered = ch.reducer == Reducer::Sum;
    const bool hasLobes = isFiltered && layout_.negative(filter) > 0;
    const bool hasStatistic = ch.statistic != Statistic::Value, isWeighed = isFiltered && (filter >= 0 || hasLobes);
    // value x weight, and its squares behind for a variance
    const auto addSums = [&](int kind, bool isAgain) {
      const uint8_t weight = uint8_t(kind + half);
      const int first = int(rules_.size());
      for (int k = 0; k < ch.width; ++k) {
        newSlot(SlotRule::Add);
        sums_.push_back({layout_.recordOffset(c) + k, weight, SumOf::Value, isAgain, int16_t(c), 1.0 / ch.step(),
                         double(ch.limit) / ch.step()});
      }
      for (int k = 0; k < ch.width && hasStatistic; ++k) {
        newSlot(SlotRule::Add);
        sums_.push_back({layout_.recordOffset(c) + k, weight, isWeighed ? SumOf::Moment : SumOf::Square, isAgain,
                         int16_t(c), std::ldexp(1.0, -squareStepLog2(ch)), std::ldexp(1.0, 46)});
      }
      return first;
    };
    for (int k = 0; k < ch.width; ++k) {
      infinityAllowed_[size_t(layout_.recordOffset(c) + k)] = 0;
      if (!ch.isData) countNegative_[size_t(layout_.recordOffset(c) + k)] = 1;
    }
    firstSlot_[size_t(c)] = addSums(isFiltered ? kindOf(filter) : int(kOne), false);
    FilterSlots& own = filterSlots_[size_t(c)];
    if (hasLobes) own.negative = addSums(negativeKindOf(filter), true);
    if (isFiltered && filter >= 0 && !hasStatistic) own.plain = addSums(kOne, true);
    const uint8_t all = uint8_t(kindOf(filter) + half), below = uint8_t(negativeKindOf(filter) + half);
    if (isFiltered && filter >= 0) own.weight = weightSlot(c, all, kTheWeight);
    if (hasLobes) own.negativeWeight = weightSlot(c, below, kTheWeight);
    if (isWeighed && hasStatistic) own.weightSquares = weightSlot(c, all, kItsSquare);
    if (hasLobes && hasStatistic) own.negativeSquares = weightSlot(c, below, kItsSquare);
  }
  // addBlock works on pairs of slots; the odd one is padded by a slot that stays 0
  if (sums_.size() % 2) {
    SumSlot pad = sums_.back();
    pad.scale = 0;
    sums_.push_back(pad);
    newSlot(SlotRule::Add);
  }
  for (int c = 0; c < layout_.size(); ++c) {
    const Channel& ch = layout_[c];
    if (ch.reducer != Reducer::Min && ch.reducer != Reducer::Max) continue;
    firstSlot_[size_t(c)] = int(rules_.size());
    for (int k = 0; k < ch.width; ++k)
      extremes_.push_back(
          {newSlot(SlotRule::Maximum), layout_.recordOffset(c) + k, ch.half, ch.reducer == Reducer::Min});
  }
  for (const bool isFar : {false, true})
    for (const Half half : {Half::Both, Half::Even, Half::Odd}) {
      Nearest group;
      group.half = half;
      group.isFar = isFar;
      for (int c = 0; c < layout_.size(); ++c) {
        const Channel& ch = layout_[c];
        if (ch.reducer != (isFar ? Reducer::ZMax : Reducer::ZMin) || ch.half != half) continue;
        if (group.keySlot < 0) group.keySlot = newSlot(SlotRule::Key);
        firstSlot_[size_t(c)] = int(rules_.size());
        for (int k = 0; k < ch.width; ++k)
          group.payload.emplace_back(newSlot(SlotRule::Payload), layout_.recordOffset(c) + k);
      }
      if (group.keySlot >= 0) nearest_.push_back(std::move(group));
    }
  for (int c = 0; c < layout_.size(); ++c) {
    if (!layout_[c].splats || sums_.empty() || firstSlot_[size_t(c)] >= kHeaderSlots + int(sums_.size())) continue;
    firstSplatSlot_[size_t(c)] = int(rules_.size());
    for (int k = 0; k < layout_[c].width; ++k) newSlot(SlotRule::Add);
  }
  slots_ = int(rules_.size());
  stride_ = (slots_ + 1) & ~1;  // 16-byte aligned pixels
}

uint64_t Film::bytesNeeded(const Window& window, const ChannelLayout& layout) {
  Film f;
  f.layout_ = layout;
  f.plan();
  return window.pixels() * uint64_t(f.stride_) * sizeof(int64_t);
}

std::unique_ptr<Film> Film::create(int width, int height, const Window& window, const ChannelLayout& layout,
                                   Status& status, uint64_t maxBytes) {
  status = {};
  const auto refuse = [&](const char* code, std::string what) {
    status = Status::fail(code, std::move(what));
    return nullptr;
  };
  if (width < 1 || height < 1 || width > kMaxResolution || height > kMaxResolution)
    return refuse("FILM-SIZE", "a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                                   " pixels is outside 1 to " + std::to_string(kMaxResolution) + " a side");
  if (window.empty() || !Window{0, 0, width, height}.contains(window))
    return refuse("FILM-WINDOW", "the data window is empty or outside the picture");
  if (layout.size() == 0) return refuse("FILM-CHANNELS", "no channels are asked for");
  std::unique_ptr<Film> film(new Film);
  film->width_ = width;
  film->height_ = height;
  film->window_ = window;
  film->layout_ = layout;
  film->plan();
  if (film->bytes() > maxBytes)
    return refuse("FILM-MEMORY", "the sums of " + std::to_string(window.pixels()) + " pixels need " +
                                     std::to_string(film->bytes() >> 20) + " MiB, " + std::to_string(maxBytes >> 20) +
                                     " are allowed");
  // zeroed by the system page by page as buckets first touch them
  film->state_.reset(static_cast<int64_t*>(std::calloc(size_t(film->bytes()), 1)));
  if (!film->state_)
    return refuse("FILM-MEMORY", "no memory for the pixels' sums (" + std::to_string(film->bytes() >> 20) + " MiB)");
  film->saturated_ = std::make_unique<std::atomic<uint64_t>[]>(size_t(layout.size()));
  return film;
}

uint64_t Film::bytes() const { return window_.pixels() * uint64_t(stride_) * sizeof(int64_t); }

void Film::clear() {
  std::memset(static_cast<void*>(state_.get()), 0, size_t(bytes()));
  splatPasses_ = 0;
  negative_ = 0;
  nonFinite_ = 0;
  for (int c = 0; c < layout_.size(); ++c) saturated_[size_t(c)] = 0;
  bad_.clear();
}

// ---- adding samples

void Film::addSamples(const SampleSpan& span) {
  for (int first = 0; first < span.n; first += kBlock) {
    prefetchBlock(span, first + kBlock);
    addBlock(span, first, std::min(kBlock, span.n - first));
  }
}

// Pixels are seldom in the cache when their next sample comes.
void Film::prefetchBlock(const SampleSpan& span, int first) const {
  for (int i = first; i < std::min(first + kBlock, span.n); ++i) {
    if (!window_.contains(span.x[i], span.y[i])) continue;
    const char* p = reinterpret_cast<const char*>(state_.get() + offsetOf(span.x[i], span.y[i]));
    for (int k = 0; k < slots_ * int(sizeof(int64_t)); k += 64) __builtin_prefetch(p + k, 1);
  }
}

int Film::channelReading(int record) const {
  for (int c = 0; c < layout_.size(); ++c)
    if (record >= layout_.recordOffset(c) && record < layout_.recordOffset(c) + layout_[c].width) return c;
  return -1;
}

void Film::reportBad(const BadSample& bad) {
  nonFinite_.fetch_add(1, std::memory_order_relaxed);
  const auto before = [](const BadSample& a, const BadSample& b) {
    return std::tie(a.y, a.x, a.sampleIndex, a.channel, a.isSplat) <
           std::tie(b.y, b.x, b.sampleIndex, b.channel, b.isSplat);
  };
  std::lock_guard lock(badMutex_);
  bad_.insert(std::upper_bound(bad_.begin(), bad_.end(), bad, before), bad);
  if (bad_.size() > kKeptBad) bad_.pop_back();
}

// Which of the block's samples may be added (bit i: sample first + i): those inside the window with finite values.
// Counts negative colours on the way.
uint32_t Film::inspect(const SampleSpan& span, int first, int n) {
  uint32_t good = 0;
  for (int i = 0; i < n; ++i) good |= uint32_t(window_.contains(span.x[first + i], span.y[first + i])) << i;
  BlockCheck check;
  alignas(32) float padded[kBlock];
  for (size_t f = 0; f < infinityAllowed_.size(); ++f)
    if (span.values[f] != span.zeros)
      check.look(blockOf(span.values[f], first, n, padded), infinityAllowed_[f] != 0, countNegative_[f] != 0);
  uint32_t badBits = check.bad();
  const uint32_t negativeBits = check.negative();
  for (int i = 0; i < n; ++i)
    // a weight of this size is no filter's; it would overflow the sum of weights
    if (!(std::fabs(span.weight[first + i]) <= 4096.0f)) badBits |= 1u << i;
  for (uint32_t b = badBits & good; b; b &= b - 1) {
    const int i = first + std::countr_zero(b);
    BadSample report{span.y[i], span.x[i], span.sampleIndex[i], -1, span.weight[i], false};
    for (size_t f = 0; f < infinityAllowed_.size(); ++f) {
      const float v = span.values[f][i];
      if (std::isnan(v) || (std::isinf(v) && !infinityAllowed_[f])) {
        report.channel = channelReading(int(f));
        report.value = v;
        break;
      }
    }
    reportBad(report);
  }
  good &= ~badBits;
  if (negativeBits & good)
    negative_.fetch_add(uint64_t(std::popcount(negativeBits & good)), std::memory_order_relaxed);
  return good;
}

void Film::addBlock(const SampleSpan& span, int first, int n) {
  const uint32_t good = inspect(span, first, n);
  if (!good) return;
  const bool hasLobes = layout_.negative(-1) > 0;
  // what is not added keeps a null pixel; its values are rounded with the rest and thrown away
  int64_t* pixels[kBlock];
  alignas(16) double weights[kWeightKinds][kBlock];
  for (int i = 0; i < kBlock; ++i) {
    const bool isGood = good >> i & 1u;
    const int s = first + (i < n ? i : 0);
    pixels[i] = isGood ? state_.get() + offsetOf(span.x[s], span.y[s]) : nullptr;
    const double w = isGood ? double(span.weight[s]) : 0.0, one = isGood ? 1.0 : 0.0;
    const bool isEven = !(span.sampleIndex[s] & 1u);
    weights[kFilter][i] = w;
    weights[kFilterEven][i] = isEven ? w : 0.0;
    weights[kFilterOdd][i] = isEven ? 0.0 : w;
    weights[kOne][i] = one;
    weights[kOneEven][i] = isEven ? one : 0.0;
    weights[kOneOdd][i] = isEven ? 0.0 : one;
    const auto bothHalves = [&](int kind, double x) {
      weights[kind][i] = x;
      weights[kind + 1][i] = isEven ? x : 0.0;
      weights[kind + 2][i] = isEven ? 0.0 : x;
    };
    if (hasLobes) bothHalves(kNegative, std::max(-w, 0.0));
    for (int f = 0; f < int(layout_.filters().size()); ++f) {
      const float* own = span.filterWeights ? span.filterWeights[f] : span.weight;
      const double x = isGood ? double(own[s]) : 0.0;
      bothHalves(kindOf(f), x);
      if (layout_.negative(f) > 0) bothHalves(negativeKindOf(f), std::max(-x, 0.0));
    }
    if (isGood) {
      const int64_t fixed = roundToInt(w * 1073741824.0);  // 2^30: kWeightStepLog2
      pixels[i][kWeight] += fixed;
      pixels[i][kWeightEven] += isEven ? fixed : 0;
      pixels[i][kCount] += 1;
      pixels[i][kCountEven] += isEven;
    }
  }

  alignas(32) int64_t rounded[kBlock][kChunk];
  alignas(32) float padded[kChunk][kBlock];
  RoundInput inputs[kChunk];
  bool isClamped = false;
  const int sums = int(sums_.size());
  RoundedRun runs[kChunk];
  for (int begin = 0; begin < sums;) {
    int count = 0, runCount = 0;
    for (; begin < sums && count + 2 <= kChunk; begin += 2) {
      // outputs that nothing of the block reached, as most of a list of light paths, cost a look; slots go in pairs
      bool isZero = true;
      for (int k = begin; k < begin + 2 && isZero; ++k) {
        const SumSlot& s = sums_[size_t(k)];
        isZero = s.record >= 0 && (span.values[s.record] == span.zeros ||
                                   isZeroBlock(blockOf(span.values[s.record], first, n, padded[count])));
      }
      if (isZero) continue;
      for (int k = 0; k < 2; ++k) {
        const SumSlot& s = sums_[size_t(begin + k)];
        RoundInput& input = inputs[count + k];
        float* own = padded[count + k];
        if (s.record < 0) {
          for (int i = 0; i < kBlock; ++i) own[i] = s.record == kTheWeight ? 1.0f : float(weights[s.weight][i]);
          input = {own, weights[s.weight], s.scale, s.limit};
          continue;
        }
        const float* values = blockOf(span.values[s.record], first, n, own);
        if (s.what != SumOf::Value) {
          const bool isSquare = s.what == SumOf::Square;
          for (int i = 0; i < kBlock; ++i) {
            const double y = double(values[i]) * (isSquare ? weights[s.weight][i] : 1);
            own[i] = float(y * y);
          }
          input = {own, weights[isSquare ? int(kOne) : int(s.weight)], s.scale, s.limit};
          continue;
        }
        input = {values, weights[s.weight], s.scale, s.limit};
      }
      const int slot = kHeaderSlots + begin;
      if (runCount && runs[runCount - 1].slot + runs[runCount - 1].count == slot)
        runs[runCount - 1].count += 2;
      else
        runs[runCount++] = {slot, count, 2};
      count += 2;
    }
    isClamped |= roundBlock(inputs, count, rounded);
    addRounded(pixels, n, runs, runCount, rounded);
  }
  if (isClamped) countSaturated(span, first, n, pixels, weights);
  if (!extremes_.empty() || !nearest_.empty()) addExtremes(span, first, n, pixels);
}

void Film::countSaturated(const SampleSpan& span, int first, int n, int64_t* const* pixels,
                          const double (*weights)[kBlock]) {
  for (const SumSlot& s : sums_)
    for (int i = 0; i < n && s.record >= 0 && s.what == SumOf::Value && !s.isAgain; ++i)
      if (pixels[i] && std::fabs(double(span.values[s.record][first + i]) * weights[s.weight][i] * s.scale) > s.limit)
        saturated_[size_t(s.channel)].fetch_add(1, std::memory_order_relaxed);
}

void Film::addExtremes(const SampleSpan& span, int first, int n, int64_t* const* pixels) {
  int64_t payload[4 * ChannelLayout::kMaxChannels];
  for (int i = 0; i < n; ++i) {
    int64_t* p = pixels[i];
    if (!p) continue;
    const uint32_t index = span.sampleIndex[first + i];
    for (const ExtremeSlot& e : extremes_) {
      if (!takes(e.half, index)) continue;
      const float v = span.values[e.record][first + i];
      p[e.slot] = std::max(p[e.slot], e.isMin ? encodeMin(v) : encodeMax(v));
    }
    for (const Nearest& group : nearest_) {
      if (!takes(group.half, index)) continue;
      const int64_t key = encodeKey(span.values[layout_.depthOffset()][first + i], index, group.isFar);
      if (key < p[group.keySlot]) continue;
      for (size_t k = 0; k < group.payload.size(); ++k)
        payload[k] = std::bit_cast<uint32_t>(span.values[group.payload[k].second][first + i]);
      mergeNearest(group, p, key, payload);
    }
  }
}

// Equal keys happen only when one sample is added twice; the larger payload is kept so that order decides nothing.
void Film::mergeNearest(const Nearest& group, int64_t* mine, int64_t key, const int64_t* payload) const {
  if (key < mine[group.keySlot]) return;
  bool takesIt = key > mine[group.keySlot];
  for (size_t k = 0; !takesIt && k < group.payload.size(); ++k) {
    const int64_t old = mine[group.payload[k].first];
    if (payload[k] < old) return;
    takesIt = payload[k] > old;
  }
  if (!takesIt) return;
  mine[group.keySlot] = key;
  for (size_t k = 0; k < group.payload.size(); ++k) mine[group.payload[k].first] = payload[k];
}

void Film::splat(const SplatSpan& span) {
  const Channel& ch = layout_[span.channel];
  const int slot = firstSplatSlot_[size_t(span.channel)];
  if (slot < 0) return;
  const double scale = 1.0 / ch.step(), limit = double(ch.limit) * scale;
  for (int i = 0; i < span.n; ++i) {
    if (!window_.contains(span.x[i], span.y[i])) continue;
    bool isBad = false;
    for (int k = 0; k < ch.width; ++k) isBad |= !std::isfinite(span.values[k][i]);
    if (isBad) {
      BadSample report{span.y[i], span.x[i], span.pathIndex ? span.pathIndex[i] : 0, span.channel, 0, true};
      for (int k = ch.width - 1; k >= 0; --k)
        if (!std::isfinite(span.values[k][i])) report.value = span.values[k][i];
      reportBad(report);
      continue;
    }
    int64_t* p = pixel(span.x[i], span.y[i]) + slot;
    bool isNegative = false;
    for (int k = 0; k < ch.width; ++k) {
      const double t = double(span.values[k][i]) * scale;
      isNegative |= t < 0;
      if (std::fabs(t) > limit) saturated_[size_t(span.channel)].fetch_add(1, std::memory_order_relaxed);
      const int64_t q = roundToInt(std::clamp(t, -limit, limit));
      std::atomic_ref<int64_t>(p[k]).fetch_add(q, std::memory_order_relaxed);
    }
    if (isNegative && !ch.isData) negative_.fetch_add(1, std::memory_order_relaxed);
  }
}

// ---- merging

void Film::addCounters(const FilmCounters& c, int64_t splatPasses) {
  splatPasses_ += splatPasses;
  negative_ += c.negative;
  nonFinite_ += c.nonFinite;
  for (size_t i = 0; i < c.saturated.size() && i < size_t(layout_.size()); ++i) saturated_[i] += c.saturated[i];
  for (const BadSample& b : c.bad) {
    reportBad(b);
    --nonFinite_;  // counted above
  }
}

Status Film::merge(const Film& other) {
  if (other.width_ != width_ || other.height_ != height_ || !(other.window_ == window_))
    return Status::fail("FILM-MERGE-SIZE", "the parts differ in resolution or data window");
  if (!(other.layout_ == layout_)) return Status::fail("FILM-MERGE-CHANNELS", "the parts differ in their channels");
  const size_t pixels = size_t(window_.pixels());
  for (size_t i = 0; i < pixels; ++i) {
    int64_t* mine = state_.get() + i * size_t(stride_);
    const int64_t* theirs = other.state_.get() + i * size_t(stride_);
    for (int s = 0; s < slots_; ++s) {
      // sums wrap as unsigned: what a hostile shard holds must not be undefined
      if (rules_[size_t(s)] == SlotRule::Add) mine[s] = int64_t(uint64_t(mine[s]) + uint64_t(theirs[s]));
      if (rules_[size_t(s)] == SlotRule::Maximum) mine[s] = std::max(mine[s], theirs[s]);
    }
    for (const Nearest& group : nearest_) {
      int64_t payload[4 * ChannelLayout::kMaxChannels];
      for (size_t k = 0; k < group.payload.size(); ++k) payload[k] = theirs[group.payload[k].first];
      if (theirs[group.keySlot]) mergeNearest(group, mine, theirs[group.keySlot], payload);
    }
  }
  addCounters(other.counters(), other.splatPasses());
  return {};
}

FilmCounters Film::counters() const {
  FilmCounters c;
  c.nonFinite = nonFinite_;
  c.negative = negative_;
  for (int i = 0; i < layout_.size(); ++i) c.saturated.push_back(saturated_[size_t(i)]);
  std::lock_guard lock(badMutex_);
  c.bad = bad_;
  return c;
}

}  // namespace kinora::film
