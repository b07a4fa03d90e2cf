// Orders in which the first dimensions of a camera path take the samples of a pixel. Each pair of numbers is a (0,2)
// sequence by itself; shuffled by chance against each other, two pairs are together no better than random. Here sample i
// of a pixel takes sample M i of the pair's sequence, M a matrix over the digits of i in base 2, upper triangular with
// ones on the diagonal, so that aligned blocks of 2^k samples stay ones. A pair is as good by itself as ever, whatever
// its matrix, and the matrices are chosen so that pairs which light transport multiplies (the place in the pixel and the
// point on the light, a direction and the light of what it meets) are stratified together. A relative is Paulin et al.,
// "Cascaded Sobol' Sampling" (SIGGRAPH Asia 2021). Read by sample_table.cpp; what chose them is in bench/match_orders.cpp.
#pragma once
#include <kinora/sample_table.h>

#include <span>

namespace kinora {

struct MatchedOrder {
  static constexpr uint32_t kDigits = 10;
  uint32_t dimension;
  bool usesBoth;              // whether both numbers of the pair decide much; false: the first
  uint16_t columns[kDigits];  // of M: what digit k of the index, 2^k, becomes
  uint32_t of(uint32_t index) const {
    uint32_t to = 0;
    for (uint32_t k = 0; k < kDigits; ++k)
      if (index >> k & 1) to ^= columns[k];
    return to;
  }
};

// Each with a dimension of its own. The lowest digit of the index is the first digit of no number, so that the even
// samples of a pixel, whose mean films keep apart, are spread over all strata too.
std::span<const MatchedOrder> matchedOrders();

}  // namespace kinora
