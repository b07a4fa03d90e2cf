// A pixel filter: a cone that falls to 0 at the widths.
//   PixelFilter "Tent" 3 3
#include <kinora/pixel_filter.h>

#include <cmath>
#include <memory>

namespace kinora {
namespace {

struct Tent {
  double halfX, halfY;
};

void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&]() -> void* {
    const auto* size = static_cast<const PixelFilterInfo*>(info->extra);
    return std::make_unique<Tent>(Tent{0.5 * size->width[0], 0.5 * size->width[1]}).release();
  });
}

// Called some thousand times when a frame begins; Kinora makes a distribution of it.
double value(const void* filter, double x, double y) {
  const auto* k = static_cast<const Tent*>(filter);
  return std::fmax(0, 1 - std::hypot(x / k->halfX, y / k->halfY));
}

const PixelFilterFunctions kFunctions{&value};
const WidthTable kTables[] = {{1, &kFunctions}};
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::PixelFilter,
                             0,
                             "Tent",
                             "A cone.",
                             nullptr,
                             0,
                             kTables,
                             1,
                             nullptr,
                             create,
                             [](void* d) { delete static_cast<Tent*>(d); }};

}  // namespace
KINORA_REGISTER(Tent, kDescriptor)
}  // namespace kinora
