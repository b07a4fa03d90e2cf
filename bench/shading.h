// The family "shading": what the shading language's group machine costs.
#pragma once
#include "core.h"

namespace kinora::bench {

void measureShading(const Options& options, Figures& figures);  // shading.cpp

}  // namespace kinora::bench
