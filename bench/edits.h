// The family "edits": how soon after an edit rays are traced again.
#pragma once
#include "core.h"

namespace kinora::bench {

void measureEdits(const Options& options, Figures& figures);  // edits.cpp

}  // namespace kinora::bench
