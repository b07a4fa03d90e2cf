// A pixel filter: a cone that falls to 0 at the widths.
//   PixelFilter "Tent" 3 3
#include <kinora/pixel_filter.h>

#include <cmath>

namespace kinora {
namespace {

struct Tent {
  double halfX, halfY;
  explicit Tent(const PixelFilterInfo& size) : halfX(0.5 * size.width[0]), halfY(0.5 * size.width[1]) {}

  // Called some thousand times when a frame begins; Kinora makes a distribution of it.
  double value(double x, double y) const { return std::fmax(0, 1 - std::hypot(x / halfX, y / halfY)); }
};

}  // namespace
}  // namespace kinora

KINORA_PIXEL_FILTER(Tent, Tent, .help = "A cone.")
