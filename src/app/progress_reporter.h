// Progress as a person or a program wants to read it. Made by the render command for one frame, called back by the
// renderer from any thread. It measures nothing itself.
#pragma once
#include <cstdio>
#include <mutex>
#include <string>

#include "render/renderer.h"

namespace kinora::app {

enum class ProgressMode { Auto, Bar, Lines, Json, None };

class ProgressReporter {
 public:
  // Auto is a bar on a terminal, else lines. `label` names the frame ("" when there is one only).
  ProgressReporter(ProgressMode mode, std::FILE* to, std::string label);
  ~ProgressReporter();  // ends the bar's line
  ProgressReporter(const ProgressReporter&) = delete;
  ProgressReporter& operator=(const ProgressReporter&) = delete;
  void operator()(const render::Progress& progress);

 private:
  void drawBar(const render::Progress& progress);
  std::mutex mutex_;
  ProgressMode mode_;
  std::FILE* to_;
  std::string label_;
  int percent_ = -1;     // last one shown
  double shownAt_ = -1;  // seconds of the frame
  bool isLineOpen_ = false;
};

// One line of each form, without an end of line; for the reporter and its test.
std::string progressLine(const render::Progress& progress, const std::string& label);
std::string progressJson(const render::Progress& progress, const std::string& label);

// "0:07", "1:02:03"; "?" for a negative time.
std::string asClock(double seconds);
// "812 kB", "1.4 GB": powers of ten.
std::string asBytes(uint64_t bytes);

}  // namespace kinora::app
