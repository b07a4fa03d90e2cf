// One level of a texture from the next finer one: each texel is the mean of the area that it covers, at any ratio of
// sides, so that a level has the mean of the level before. Used by PyramidInput for files without levels and by
// makeTexture.
#pragma once

namespace kinora::texture {

// Texels [x0, x1) x [y0, y1) of a level.
struct LevelWindow {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
};
struct LevelSize {
  int width = 0, height = 0;
};

inline int coarserSide(int side) { return side > 1 ? side / 2 : 1; }

// What of the fine level lies under a window of the coarse one.
LevelWindow windowUnder(const LevelWindow& window, LevelSize coarse, LevelSize fine);

// Fills `window` of the coarse level; `pixels` hold windowUnder() of it. Rows are tight in both.
void averageAreas(const float* pixels, LevelSize fine, LevelSize coarse, const LevelWindow& window, int channels,
                  float* out);

}  // namespace kinora::texture
