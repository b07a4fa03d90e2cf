// The family "media": what media that fill space and light below surfaces cost, against frames without them and against
// OpenVDB's own lookups.
#pragma once
#include "core.h"

namespace kinora::bench {

void measureFog(const Options& options, Figures& figures);           // media.cpp
void measureCloud(const Options& options, Figures& figures);         // media.cpp
void measureBelow(const Options& options, Figures& figures);         // media.cpp
void measureVoxelLookups(const Options& options, Figures& figures);  // media_lookups.cpp

}  // namespace kinora::bench
