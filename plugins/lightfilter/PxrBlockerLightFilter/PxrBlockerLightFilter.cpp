// PxrBlockerLightFilter: the former PxrRodLightFilter, without extents and edges of single sides.
#define KINORA_KERNEL_FILE "plugins/lightfilter/PxrBlockerLightFilter/PxrBlockerLightFilter.cpp"
#include "plugins/lightfilter/parts/rod.h"
// per target from here
#include <kinora/light_filter_author.h>

#include "plugins/lightfilter/parts/rod_kernel.h"

#if KINORA_PLAIN
namespace kinora::pxrBlockerLightFilter {
using namespace filterParts;
constexpr auto kParams = kRodCommon;

std::unique_ptr<Rod> make(const CreateInfo& info) {
  return makeRod(NamedValues(info, kParams.data(), kParams.size()), false);
}
}  // namespace kinora::pxrBlockerLightFilter
#endif

KINORA_KERNELS_BEGIN
using namespace pxrBlockerLightFilter;

struct PxrBlockerLightFilter : RodFilter {};
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(
    PxrBlockerLightFilter,
    .help = "Changes the light on points within a rounded box of space; PxrRodLightFilter took its place.",
    .params = kParams, .setUp = setUpBy<make>, .largest = filterParts::largestOfRod)
