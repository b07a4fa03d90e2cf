// hann: PixelFilter "hann" 3 3, the raised cosine (1 + cos) / 2 over each width. Smooth, without negative lobes; the
// stock filters of RIB have none between triangle and gaussian.
#include <kinora/pixel_filter.h>

#include <cmath>

namespace kinora {
namespace {

struct Hann {
  double halfX, halfY;
  explicit Hann(const PixelFilterInfo& size) : halfX(0.5 * size.width[0]), halfY(0.5 * size.width[1]) {}

  double value(double x, double y) const {
    constexpr double kPi = 3.14159265358979323846;
    if (std::fabs(x) >= halfX || std::fabs(y) >= halfY) return 0;
    return 0.25 * (1 + std::cos(kPi * x / halfX)) * (1 + std::cos(kPi * y / halfY));
  }
};

}  // namespace
}  // namespace kinora

KINORA_PIXEL_FILTER(hann, Hann, .help = "Raised cosine over the widths.")
