// Shutters that open line by line of pixels, as a projection says (ShutterSweep): the time of a pixel's samples, and how
// light paths, which have the times of all pixels, count at one. Part of CameraState; plain.
#pragma once
#include <kinora/projection.h>

#include <array>
#include <cstdint>
#include <vector>

namespace kinora::render {

class RollingShutter {
 public:
  RollingShutter() = default;  // all pixels at once
  // times: CameraState::times, of each line within its part.
  RollingShutter(const ShutterSweep& sweep, const std::array<int, 2>& resolution, const std::vector<float>& times);

  bool rolls() const { return lines_ > 0; }
  // t: of the shutter's opening, 0..1.
  float time(int x, int y, float t) const { return startOf(x, y) + duration_ * t; }
  // The density of times at a pixel over that of all pixels together.
  float share(int x, int y, float time) const;

 private:
  float start(int line) const;
  float startOf(int x, int y) const { return start(isColumns_ ? x : y); }
  float density(float time) const;  // of a line that begins at 0 and lasts 1
  int lines_ = 0;
  bool isColumns_ = false, isBackward_ = false;
  float duration_ = 1;
  std::vector<float> times_;
};

}  // namespace kinora::render
