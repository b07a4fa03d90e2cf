// The family "shading": what the shading language's group machine costs.
#pragma once
#include "core.h"

namespace kinora::bench {

void measureShading(const Options& options, Figures& figures);       // shading.cpp
void measureShadedFrames(const Options& options, Figures& figures);  // shading_frames.cpp

}  // namespace kinora::bench
