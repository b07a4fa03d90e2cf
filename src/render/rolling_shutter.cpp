#include "render/rolling_shutter.h"

#include <algorithm>
#include <cmath>

namespace kinora::render {
namespace {
constexpr float kShortest = 1e-3f;  // of a line; light paths find shorter ones too seldom
constexpr float kRounding = 1e-5f;  // of times, which are moved off flat moments besides
}  // namespace

RollingShutter::RollingShutter(const ShutterSweep& sweep, const std::array<int, 2>& resolution,
                               const std::vector<float>& times)
    : isColumns_(sweep.columns != 0),
      isBackward_(sweep.backward != 0),
      duration_(std::clamp(sweep.duration, kShortest, 1.f)),
      times_(times) {
  lines_ = duration_ < 1 ? resolution[isColumns_ ? 0 : 1] : 0;
}

float RollingShutter::start(int line) const {
  line = std::clamp(line, 0, lines_ - 1);
  const float part = (float(line) + 0.5f) / float(lines_);
  return (1 - duration_) * (isBackward_ ? 1 - part : part);
}

float RollingShutter::density(float time) const {
  if (time < -kRounding || time > 1 + kRounding) return 0;
  if (times_.empty()) return 1;
  // times_ lie at even shares of the light
  const auto after = std::upper_bound(times_.begin() + 1, times_.end() - 1, time);
  return 1 / (float(times_.size() - 1) * std::max(*after - *(after - 1), 1e-7f));
}

float RollingShutter::share(int x, int y, float time) const {
  const auto at = [&](float start) { return density((time - start) / duration_); };
  const float here = at(startOf(x, y));
  if (!(here > 0)) return 0;
  // lines that are open now lie together
  const float reach = duration_ + 2 * kRounding, step = (1 - duration_) / float(lines_);
  const auto lineAt = [&](float start) {
    const float line = start / step - 0.5f;
    return int(std::clamp(line, -1.f, float(lines_)));
  };
  const int first = std::max(lineAt(time - reach) - 1, 0), last = std::min(lineAt(time + kRounding) + 1, lines_ - 1);
  double all = 0;
  for (int i = first; i <= last; ++i) all += double(at((1 - duration_) * (float(i) + 0.5f) / float(lines_)));
  return all > 0 ? float(double(here) * double(lines_) / all) : 0;
}

}  // namespace kinora::render
