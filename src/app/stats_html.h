// The statistics of a frame as one page that needs no other file: picture, time and memory by owner, rays, lane use,
// and where the picture is slow and where it is noisy. Called by stats_report.cpp.
#pragma once
#include <string>

#include "app/stats_report.h"

namespace kinora::app {

std::string statsAsHtml(const render::Statistics& statistics, const StatsHeading& heading);

}  // namespace kinora::app
