// What a lookup without a file answers. Called by the texture system, and by its store for files that it cannot use.
#pragma once
#include <cmath>

#include "kinora/context.h"

namespace kinora::texture {

// Magenta is what pattern plug-ins ask for unless told otherwise: a whole floor or wall in it drowns the scene. In its
// place comes a checkerboard of two greys, eight squares to a unit of s and t, which shows where an image is missing and
// leaves the scene its colours. Any other colour is the author's wish.
class MissingColor {
 public:
  explicit MissingColor(const TextureOptions& o)
      : color_{o.missingColor[0], o.missingColor[1], o.missingColor[2]},
        checks_(color_[0] == 1 && color_[1] == 0 && color_[2] == 1) {}

  // radius: half of the width of what is averaged, in units of s and t.
  void at(float s, float t, float radius, float out[3]) const {
    if (!checks_) {
      for (int c = 0; c < 3; ++c) out[c] = color_[c];
      return;
    }
    out[0] = out[1] = out[2] =
        kMean + kContrast * wave(kSquares * s, kSquares * radius) * wave(kSquares * t, kSquares * radius);
  }

  static constexpr float kMean = 0.27f, kContrast = 0.09f, kSquares = 8;

 private:
  // Mean over x - r .. x + r of 1 on even and -1 on odd squares.
  static float wave(float x, float r) {
    if (!(std::fabs(x) < 1e6f)) return 0;
    const float half = r > 1e-3f ? (r < 1e3f ? r : 1e3f) : 1e-3f;
    return (area(x + half) - area(x - half)) / (2 * half);
  }
  static float area(float x) {
    const float f = x - 2 * std::floor(0.5f * x);
    return f < 1 ? f : 2 - f;
  }

  float color_[3];
  bool checks_;
};

}  // namespace kinora::texture
