#include "light/light_filters.h"

#include <algorithm>

namespace kinora::light {

// Another filter of a group that does not multiply, into the group's factor; never negative.
static void combine(LightFilterMode mode, uint32_t count, const float* factor, float* group) {
  for (uint32_t i = 0; i < count; ++i) {
    const float a = group[i], b = factor[i];
    group[i] = mode == LightFilterMode::Max   ? std::max(a, b)
               : mode == LightFilterMode::Min ? std::min(a, b)
                                              : std::max(0.f, a + b - a * b);
  }
}

LightFilters::LightFilters(Arena& arena, uint32_t most) {
  const uint32_t room = padded(most) + kPad;
  for (float*& f : in) f = arena.make<float>(room);
  for (float*& f : factor_) f = arena.make<float>(room);
  for (float*& f : group_) f = arena.make<float>(room);
  for (float*& f : rest_) f = arena.make<float>(room);
}

void LightFilters::ask(uint32_t width, const LightFilterEntry& filter, uint32_t count, float* const to[3]) const {
  float* const* x = in;
  if (filter.motion) {
    for (uint32_t i = 0; i < padded(count); ++i) {
      float P[3] = {in[0][i], in[1][i], in[2][i]}, wi[3] = {in[3][i], in[4][i], in[5][i]};
      carryToRest(*filter.motion, in[7][i], LightVector::Point, P);
      carryToRest(*filter.motion, in[7][i], LightVector::Direction, wi);
      for (int c = 0; c < 3; ++c) {
        rest_[c][i] = P[c];
        rest_[3 + c][i] = wi[c];
      }
    }
    x = rest_;
  }
  const LightFilterArgs a{count, {x[0], x[1], x[2]}, {x[3], x[4], x[5]}, in[6], in[7], {to[0], to[1], to[2]}};
  filter.byWidth[width]->factor(filter.instance, &a);
}

void LightFilters::apply(uint32_t width, const std::vector<LightFilterEntry>& filters, uint32_t count,
                         const uint32_t* list, float* const value[3], FilterUse use) const {
  for (size_t f = 0, end; f < filters.size(); f = end) {
    bool isUniform = filters[f].isUniform;
    // those that multiply do so one by one
    const bool isAlone = filters[f].mode == LightFilterMode::Multiply;
    for (end = f + 1; !isAlone && end < filters.size() && filters[end].group == filters[f].group; ++end)
      isUniform &= filters[end].isUniform;
    if (use.by == FilterUse::EmittedRays && !isUniform) continue;
    bool isFirst = true;
    for (size_t g = f; g < end; ++g) {
      if (!use.has(filters[g])) continue;
      float* const* to = isFirst ? group_ : factor_;
      ask(width, filters[g], count, to);
      if (const float amount = use.amountOf(filters[g]); amount != 1)
        for (int c = 0; c < 3; ++c)
          for (uint32_t i = 0; i < count; ++i) to[c][i] = 1 + amount * (to[c][i] - 1);
      for (int c = 0; c < 3 && !isFirst; ++c) combine(filters[f].mode, count, factor_[c], group_[c]);
      isFirst = false;
    }
    for (int c = 0; c < 3 && !isFirst; ++c)
      for (uint32_t i = 0; i < count; ++i) value[c][list[i]] *= group_[c][i];
  }
}

static void nearDistanceFactor(const void* filter, const LightFilterArgs* a) {
  const float nearest = *static_cast<const float*>(filter);
  for (uint32_t i = 0; i < a->count; ++i) {
    const float part = std::min(a->distance[i] / nearest, 1.f);
    for (float* f : a->factor) f[i] = part * part;
  }
}

LightFilterEntry nearDistanceFilter(float nearest) {
  static constexpr LightFilterFunctions kFunctions{&nearDistanceFactor};
  LightFilterEntry e;
  for (const uint32_t width : {1u, 4u, 8u, 16u}) e.byWidth[width] = &kFunctions;
  const auto data = std::make_shared<float>(nearest);
  e.owner = data;
  e.instance = data.get();
  e.group = ~0u;
  e.isSeen = false;
  return e;
}

}  // namespace kinora::light
