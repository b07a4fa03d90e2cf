#include "app/progress_reporter.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace kinora::app {

namespace {
int percentOf(const render::Progress& p) { return int(std::clamp(p.fraction, 0.0, 1.0) * 100); }
}  // namespace

std::string asClock(double seconds) {
  if (!(seconds >= 0) || seconds > 1e9) return "?";
  const long s = std::lround(seconds);
  if (s < 3600) return fmt::format("{}:{:02}", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::string asBytes(uint64_t bytes) {
  if (bytes < 1000) return fmt::format("{} B", bytes);
  static const char* const kUnits[] = {"kB", "MB", "GB", "TB", "PB", "EB"};
  double value = double(bytes) / 1000;
  size_t unit = 0;
  while (value >= 999.5 && unit + 1 < std::size(kUnits)) value /= 1000, ++unit;
  return fmt::format("{:.{}f} {}", value, value < 9.95 ? 1 : 0, kUnits[unit]);
}

std::string progressLine(const render::Progress& p, const std::string& label) {
  // where an error is asked for, how many samples that takes is not known
  const std::string samples = p.isErrorWanted ? fmt::format("{} samples, error {}", p.samplesDone,
                                                            p.error >= 0 ? fmt::format("{:.3g}", p.error) : "?")
                                              : fmt::format("{}/{} samples", p.samplesDone, p.samplesWanted);
  return fmt::format("{}{:3} %  {}  {} so far  {} left  {}", label.empty() ? "" : label + "  ", percentOf(p), samples,
                     asClock(p.seconds), asClock(p.secondsLeft), asBytes(p.memoryBytes));
}

std::string progressJson(const render::Progress& p, const std::string& label) {
  nlohmann::ordered_json j;
  if (!label.empty()) j["frame"] = label;
  j["fraction"] = std::clamp(p.fraction, 0.0, 1.0);
  j["seconds"] = p.seconds;
  if (p.secondsLeft >= 0)
    j["seconds_left"] = p.secondsLeft;
  else
    j["seconds_left"] = nullptr;
  j["memory_bytes"] = p.memoryBytes;
  j["samples_done"] = p.samplesDone;
  j["samples_wanted"] = p.samplesWanted;
  if (p.isErrorWanted) j["error"] = p.error >= 0 ? nlohmann::ordered_json(p.error) : nlohmann::ordered_json(nullptr);
  return j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

ProgressReporter::ProgressReporter(ProgressMode mode, std::FILE* to, std::string label)
    : mode_(mode), to_(to), label_(std::move(label)) {
  if (mode_ == ProgressMode::Auto) mode_ = isatty(fileno(to)) ? ProgressMode::Bar : ProgressMode::Lines;
}

ProgressReporter::~ProgressReporter() {
  if (isLineOpen_) {
    std::fputc('\n', to_);
    std::fflush(to_);
  }
}

void ProgressReporter::drawBar(const render::Progress& p) {
  constexpr int kCells = 30;
  const int full = int(std::clamp(p.fraction, 0.0, 1.0) * kCells);
  // "\33[K" clears what a longer line before left
  fmt::print(to_, "\r[{}{}] {}\33[K", std::string(size_t(full), '#'), std::string(size_t(kCells - full), '.'),
             progressLine(p, label_));
  std::fflush(to_);
  isLineOpen_ = true;
}

void ProgressReporter::operator()(const render::Progress& p) {
  if (mode_ == ProgressMode::None) return;
  std::lock_guard lock(mutex_);
  const int percent = percentOf(p);
  if (mode_ == ProgressMode::Bar) {
    constexpr double kRedrawSeconds = 0.1;
    const bool isDone = percent == 100 && percent_ != 100;
    if (!isDone && shownAt_ >= 0 && p.seconds - shownAt_ < kRedrawSeconds) return;
    drawBar(p);
  } else {
    if (percent <= percent_) return;
    fmt::print(to_, "{}\n", mode_ == ProgressMode::Json ? progressJson(p, label_) : progressLine(p, label_));
    std::fflush(to_);
  }
  percent_ = percent;
  shownAt_ = p.seconds;
}

}  // namespace kinora::app
