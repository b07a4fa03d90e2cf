// hann: PixelFilter "hann" 3 3, the raised cosine (1 + cos) / 2 over each width. Smooth, without negative lobes; the
// stock filters of RIB have none between triangle and gaussian.
#include <kinora/pixel_filter.h>

#include <cmath>
#include <memory>

namespace kinora {
namespace {

struct Hann {
  double halfX, halfY;
};

void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&]() -> void* {
    const auto* size = static_cast<const PixelFilterInfo*>(info->extra);
    return std::make_unique<Hann>(Hann{0.5 * size->width[0], 0.5 * size->width[1]}).release();
  });
}

double value(const void* filter, double x, double y) {
  constexpr double kPi = 3.14159265358979323846;
  const auto* k = static_cast<const Hann*>(filter);
  if (std::fabs(x) >= k->halfX || std::fabs(y) >= k->halfY) return 0;
  return 0.25 * (1 + std::cos(kPi * x / k->halfX)) * (1 + std::cos(kPi * y / k->halfY));
}

const PixelFilterFunctions kFunctions{&value};
const WidthTable kTables[] = {{1, &kFunctions}};
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::PixelFilter,
                             0,
                             "hann",
                             "Raised cosine over the widths.",
                             nullptr,
                             0,
                             kTables,
                             1,
                             nullptr,
                             create,
                             [](void* d) { delete static_cast<Hann*>(d); }};

}  // namespace
KINORA_REGISTER(hann, kDescriptor)
}  // namespace kinora
