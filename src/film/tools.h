// The work behind `kinora diff`, `kinora merge` and `kinora info IMAGE`. Called by app/, which parses the command
// line, prints the text on standard output and ends with the exit code. Problems go through Diagnostics (IMAGE-*,
// FILM-*, DISPLAY-*); nothing is printed here.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "film/display_output.h"

namespace kinora::film {

// Exit codes of CLI.md that these commands end with.
enum ToolExit : int { kToolOk = 0, kToolDiffers = 1, kToolBadCommand = 2, kToolUnreadable = 3, kToolUnwritable = 6 };

struct ToolResult {
  int exitCode = kToolOk;
  std::string text;  // lines, each ended
};

// Each limit that is given must hold; with none given, any differing value is a difference.
struct DiffLimits {
  std::optional<double> rmse, relativeMse, maximum;
  std::optional<double> differingPixels;  // a share of all pixels, 0..1
  double valueThreshold = 0;              // values this close are equal
  std::vector<std::string> channels;      // empty: all in common
  std::array<float, 4> part{0, 1, 0, 1};  // xmin, xmax, ymin, ymax in 0..1: only these pixels
};

// `picture`: where to write |a - b| x gain ("" for no picture).
ToolResult diffImages(const std::string& a, const std::string& b, const DiffLimits& limits,
                      const std::string& picture, float gain, Diagnostics& diagnostics);

// Makes the display filters that a plan names, for channels of its layout and pictures of the film's size; an empty
// stage where there are none.
using StageMaker = std::function<DisplayOutput::PixelStage(const DisplayPlan&, const Film&)>;

// Parts of one frame become its pictures: the primary one in `output` ("": all by the scene's names). `keepShard`:
// the merged integers are written to `output` instead, as a larger shard. No part is written over.
ToolResult mergeParts(const std::vector<std::string>& parts, const std::string& output, bool keepShard,
                      const DriverLookup& lookup, const StageMaker& stages, Diagnostics& diagnostics);

// Format, sizes, channels, value ranges and metadata of a picture; of a shard what it holds.
ToolResult imageInfo(const std::string& path, Diagnostics& diagnostics);

}  // namespace kinora::film
