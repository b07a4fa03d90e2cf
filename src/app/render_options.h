// The command line of `kinora render` as values. Made by render_options.cpp, used by the render command; nothing is
// read or opened while parsing.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "app/frame_list.h"
#include "app/progress_reporter.h"
#include "base/diagnostics.h"
#include "render/renderer.h"

namespace kinora::app {

struct RenderOptions {
  std::vector<std::string> files;  // "-": standard input
  render::Settings settings;       // `stop` is not set here
  ProgressMode progress = ProgressMode::Auto;
  std::string statsFile;                         // "": none
  std::optional<std::array<int, 3>> onlySample;  // x, y, sample
  bool check = false;
  int quiet = 0, verbose = 0;  // how often -q and -v were given
  std::vector<std::string> pluginPath, archivePath;
  bool allowExec = false;
  std::vector<std::pair<std::string, std::string>> dirmap;  // FROM, TO
  FrameList frames;                                         // which frames; all when empty
  uint64_t memoryLimit = 0;                                 // bytes; 0: none
  double maxSeconds = -1;                                   // -1: no limit
};

// A value is the exit code with which the program is done.
std::optional<int> parseRenderOptions(const std::vector<std::string>& arguments, RenderOptions& out,
                                      Diagnostics& diagnostics);

}  // namespace kinora::app
