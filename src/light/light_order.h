// Entries that want different lights, in an order in which one call to a plug-in serves as many as it can: kind by
// kind, and light by light where the kind does not mix them or each of few lights has entries enough. Arrays are
// taken to that order and put back. Internal to light/.
#pragma once
#include <kinora/light.h>

#include <algorithm>
#include <cstdint>

#include "base/arena.h"

namespace kinora::light {

class LightOrder {
 public:
  struct Run {
    uint32_t kind, from, count;
  };

  // kindOf(light), mixes(kind), instanceOf(light); light: by entry, padded; kNone entries take no part.
  template <class KindOf, class Mixes, class InstanceOf>
  LightOrder(Arena& arena, uint32_t kinds, uint32_t lights, uint32_t n, const uint32_t* light, KindOf kindOf,
             Mixes mixes, InstanceOf instanceOf)
      : arena_(arena), n_(n) {
    constexpr uint32_t kNone = 0xffffffffu, kFewLights = 32, kEnough = 8;
    const bool isByLight = lights <= kFewLights && n >= kEnough * lights;
    const uint32_t keys = isByLight ? lights : kinds;
    const auto keyOf = [&](uint32_t l) { return isByLight ? l : kindOf(l); };
    runs_ = arena.make<Run>(keys + 1);
    if (!n) return;
    const uint32_t first = light[0];
    bool isOneLight = first != kNone, isOneKind = isOneLight;
    const uint32_t kind = isOneKind ? kindOf(first) : 0;
    for (uint32_t i = 1; i < n && isOneKind; ++i) {  // light by light no branch could be foretold
      isOneLight &= light[i] == first;
      isOneKind = light[i] != kNone && (kinds == 1 || kindOf(light[i]) == kind);
    }
    isOneLight = isOneLight && isOneKind;
    if (isOneLight || (isOneKind && mixes(kindOf(first)))) {
      runs_[runCount_++] = {kindOf(first), 0, n};
      stride_ = isOneLight ? 0 : 1;
      const void** at = arena.make<const void*>(isOneLight ? 1 : padded(n));
      for (uint32_t i = 0; i < (isOneLight ? 1 : padded(n)); ++i) at[i] = instanceOf(light[i < n ? i : n - 1]);
      instances_ = at;
      room_ = padded(n);
      return;
    }
    isMoved_ = true;
    uint32_t* count = arena.make<uint32_t>(keys + 1);
    std::fill_n(count, keys + 1, 0u);
    for (uint32_t i = 0; i < n; ++i)
      if (light[i] != kNone) ++count[keyOf(light[i])];
    uint32_t* at = arena.make<uint32_t>(keys + 1);
    for (uint32_t k = 0; k < keys; ++k) {
      at[k] = room_;
      if (!count[k]) continue;
      runs_[runCount_++] = {isByLight ? kindOf(k) : k, room_, count[k]};
      room_ += padded(count[k]);
    }
    from_ = arena.make<uint32_t>(room_ + kPad);
    for (uint32_t i = 0; i < n; ++i)
      if (light[i] != kNone) from_[at[keyOf(light[i])]++] = i;
    const void** instances = arena.make<const void*>(room_ + kPad);
    for (uint32_t r = 0; r < runCount_; ++r) {
      const Run& run = runs_[r];
      uint32_t* list = from_ + run.from;
      if (!isByLight && !mixes(run.kind))
        std::sort(list, list + run.count,
                  [&](uint32_t a, uint32_t b) { return light[a] != light[b] ? light[a] < light[b] : a < b; });
      for (uint32_t i = run.count; i < padded(run.count); ++i) list[i] = list[run.count - 1];
      for (uint32_t i = 0; i < (isByLight ? 1 : padded(run.count)); ++i)
        instances[run.from + i] = instanceOf(light[list[i]]);
    }
    isOneEach_ = isByLight;
    instances_ = instances;
  }

  uint32_t runCount() const { return runCount_; }
  const Run& run(uint32_t r) const { return runs_[r]; }
  void setLights(LightLanes& lanes, const Run& run) const {
    lanes.light = instances_ + (stride_ ? run.from : 0);
    lanes.lightStride = isOneEach_ ? 0 : stride_;
  }
  // An input in this order; one for outputs, and what comes of it by entry.
  const float* take(const float* x) const {
    if (!isMoved_ || !x) return x;
    float* y = arena_.make<float>(room_ + kPad);
    for (uint32_t r = 0; r < runCount_; ++r)
      for (uint32_t i = runs_[r].from, end = i + padded(runs_[r].count); i < end; ++i) y[i] = x[from_[i]];
    return y;
  }
  template <class T>
  T* room(T* x) const {
    return isMoved_ ? arena_.make<T>(room_ + kPad) : x;
  }
  template <class T>
  void put(const T* y, T* x) const {
    if (!isMoved_) return;
    for (uint32_t r = 0; r < runCount_; ++r)
      for (uint32_t i = runs_[r].from, end = i + runs_[r].count; i < end; ++i) x[from_[i]] = y[i];
  }

 private:
  Arena& arena_;
  uint32_t n_, runCount_ = 0, room_ = 0, stride_ = 1;
  Run* runs_;
  uint32_t* from_ = nullptr;
  const void* const* instances_ = nullptr;
  bool isMoved_ = false, isOneEach_ = false;
};

}  // namespace kinora::light
