#include "texture/area_average.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kinora::texture {
namespace {

// The fine texels under coarse texel i, [first, last], in whole numbers: counted in parts of which a fine texel has
// `coarse` and a coarse one `fine`.
struct Cover {
  int first, last;
  int64_t begin, end;
  int64_t coarse;
  Cover(int i, int coarseSide, int fineSide)
      : begin(int64_t(i) * fineSide), end(begin + fineSide), coarse(coarseSide) {
    first = int(begin / coarse);
    last = int((end - 1) / coarse);
  }
  // parts of fine texel j
  double weight(int j) const { return double(std::min(end, (j + 1) * coarse) - std::max(begin, j * coarse)); }
};

}  // namespace

LevelWindow windowUnder(const LevelWindow& window, LevelSize coarse, LevelSize fine) {
  return {Cover(window.x0, coarse.width, fine.width).first, Cover(window.y0, coarse.height, fine.height).first,
          Cover(window.x1 - 1, coarse.width, fine.width).last + 1,
          Cover(window.y1 - 1, coarse.height, fine.height).last + 1};
}

void averageAreas(const float* pixels, LevelSize fine, LevelSize coarse, const LevelWindow& window, int channels,
                  float* out) {
  const LevelWindow held = windowUnder(window, coarse, fine);
  const double share = 1. / (double(fine.width) * double(fine.height));
  std::vector<double> sum(static_cast<size_t>(channels));
  for (int y = window.y0; y < window.y1; ++y) {
    const Cover rows(y, coarse.height, fine.height);
    for (int x = window.x0; x < window.x1; ++x) {
      const Cover columns(x, coarse.width, fine.width);
      std::fill(sum.begin(), sum.end(), 0.);
      for (int j = rows.first; j <= rows.last; ++j)
        for (int i = columns.first; i <= columns.last; ++i) {
          const double weight = rows.weight(j) * columns.weight(i);
          const float* texel =
              pixels + (size_t(j - held.y0) * size_t(held.width()) + size_t(i - held.x0)) * size_t(channels);
          for (size_t c = 0; c < sum.size(); ++c) sum[c] += weight * double(texel[c]);
        }
      for (double s : sum) *out++ = float(s * share);
    }
  }
}

}  // namespace kinora::texture
