// The family "lights": choice and samples among many lights.
#pragma once
#include "core.h"

namespace kinora::bench {

void measureLights(const Options& options, Figures& figures);  // lights.cpp

}  // namespace kinora::bench
