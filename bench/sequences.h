// The family "sampling": sequences of samples against each other, by kind of integrand and number of samples, and what
// is left of their errors where neighbouring pixels are averaged.
#pragma once
#include "core.h"

namespace kinora::bench {

void measureIntegrals(const Options& options, Figures& figures);
void measureScreen(const Options& options, Figures& figures);

}  // namespace kinora::bench
