// Displacements by the contract of their kind: finite offsets within the bound that they tell, the same bits at every
// width, no dependence on neighbours. Called by checkFilter().
#pragma once
#include <kinora/testing/filter_checks.h>

namespace kinora::testing {

CheckReport checkDisplacement(const Descriptor& d, uint64_t seed);

}  // namespace kinora::testing
