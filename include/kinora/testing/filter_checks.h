// The contract of sample filters, display filters, light filters, pixel filters, volumes and displacements: every setting that
// follows from the declaration can be made, answers are finite, the same bits at every width, and a point's answer
// does not depend on its neighbours. What a filter means is its own test's business.
#pragma once
#include <kinora/plugin.h>
#include <kinora/testing/report.h>

namespace kinora::testing {

bool hasFilterChecks(Kind kind);
CheckReport checkFilter(const Descriptor& d, uint64_t seed = 1);

}  // namespace kinora::testing
