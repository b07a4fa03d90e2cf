#include "render/error_map.h"

#include <algorithm>
#include <cmath>

namespace kinora::render {

// Each half is an estimate of its own: their mean is the pixel, half their difference its error.
PixelMap errorMapOf(const film::Film& film, const std::array<int, 2>& halves) {
  PixelMap m;
  if (halves[0] < 0 || halves[1] < 0) return m;
  const film::Window& w = film.window();
  m.x0 = w.x0, m.y0 = w.y0, m.width = w.width(), m.height = w.height();
  m.values.resize(size_t(w.pixels()));
  std::vector<float> level(m.values.size());
  double sum = 0;
  for (int y = w.y0; y < w.y1; ++y)
    for (int x = w.x0; x < w.x1; ++x) {
      float a[4] = {}, b[4] = {};
      film.resolvePixel(halves[0], x, y, a);
      film.resolvePixel(halves[1], x, y, b);
      const size_t i = size_t(y - w.y0) * size_t(m.width) + size_t(x - w.x0);
      for (int c = 0; c < 3; ++c) {
        m.values[i] += 0.5f * std::fabs(a[c] - b[c]) / 3;
        level[i] += 0.5f * std::fabs(a[c] + b[c]) / 3;
      }
      sum += level[i];
    }
  // dark pixels count against a part of the picture's mean, as eyes take them
  const float floor = float(0.05 * sum / double(std::max<size_t>(1, level.size()))) + 1e-9f;
  for (size_t i = 0; i < level.size(); ++i) m.values[i] /= level[i] + floor;
  return m;
}

}  // namespace kinora::render
