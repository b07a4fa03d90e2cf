// The order in which a LightSet asks the plug-ins of its lights. Internal to light/.
#pragma once
#include <algorithm>

#include "light/light_order.h"
#include "light/light_set.h"

namespace kinora::light {

class LightSet::Order : public LightOrder {
 public:
  Order(const LightSet& set, uint32_t width, Arena& arena, uint32_t n, const uint32_t* light)
      : LightOrder(
            arena, uint32_t(set.kinds_.size()), set.size(), n, light,
            [&](uint32_t l) { return uint32_t(set.recordOf(l).kind); },
            [&](uint32_t k) { return set.kinds_[k].byWidth[width]->mixes != 0; },
            [&](uint32_t l) { return set.lights_[l].instance; }) {}
};

// Repeats the last of n numbers up to the padded length.
inline void padFloats(float* x, uint32_t n) {
  for (uint32_t i = n; n && i < padded(n); ++i) x[i] = x[n - 1];
}

}  // namespace kinora::light
