// Where time and memory of a frame went, as JSON for scripts, as text and as a page (stats_html.h) for people. Called
// by the render command for --stats and -v. The figures are render/'s; nothing is measured here.
#pragma once
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "render/statistics.h"

namespace kinora::app {

struct StatsHeading {
  std::string scene;  // files of the scene as given
  int frame = 0;
  std::string outcome;             // "complete", "interrupted" ...
  uint64_t residentPeakBytes = 0;  // of the process; 0: not known
  std::string picture = {};        // the file to show on the page; "": none
};

std::string statsAsJson(const render::Statistics& statistics, const StatsHeading& heading);
std::string statsAsText(const render::Statistics& statistics, const StatsHeading& heading);

struct WorstPixel {
  int x = 0, y = 0;
  float error = 0;
};
std::vector<WorstPixel> worstPixels(const render::Statistics& statistics, size_t most);
std::vector<render::BucketTime> slowestBuckets(const render::Statistics& statistics, size_t most);
std::vector<render::ShaderCost> slowestShaders(const render::Statistics& s, size_t most);
render::ShaderCost costOfShaders(const render::Statistics& s);  // the sum of all

// By the extension, .json, .html or .txt; the file appears whole or not at all. False with a message when it cannot
// be written.
bool writeStats(const std::string& file, const render::Statistics& statistics, const StatsHeading& heading,
                Diagnostics& diagnostics);

uint64_t residentPeakBytes();  // of this process so far

}  // namespace kinora::app
