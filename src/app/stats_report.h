// Where time and memory of a frame went, as JSON for scripts and as text for people. Called by the render command for
// --stats and -v. The figures are render/'s; nothing is measured here.
#pragma once
#include <string>

#include "base/diagnostics.h"
#include "render/statistics.h"

namespace kinora::app {

struct StatsHeading {
  std::string scene;  // files of the scene as given
  int frame = 0;
  std::string outcome;             // "complete", "interrupted" ...
  uint64_t residentPeakBytes = 0;  // of the process; 0: not known
};

std::string statsAsJson(const render::Statistics& statistics, const StatsHeading& heading);
std::string statsAsText(const render::Statistics& statistics, const StatsHeading& heading);

// By the extension, .json or .txt; the file appears whole or not at all. False with a message when it cannot be
// written.
bool writeStats(const std::string& file, const render::Statistics& statistics, const StatsHeading& heading,
                Diagnostics& diagnostics);

uint64_t residentPeakBytes();  // of this process so far

}  // namespace kinora::app
