// PxrRodLightFilter: a rounded box with soft edges in space; light that falls on points within it is changed.
#define KINORA_KERNEL_FILE "plugins/lightfilter/PxrRodLightFilter/PxrRodLightFilter.cpp"
#include "plugins/lightfilter/parts/rod.h"
// per target from here
#include <kinora/light_filter_author.h>

#include "plugins/lightfilter/parts/rod_kernel.h"

#if KINORA_PLAIN
namespace kinora::pxrRodLightFilter {
using namespace filterParts;
constexpr auto side(const char* name, const char* help) { return param::number(name, 0.f).range(0, 4).help(help); }
constexpr auto sideEdge(const char* name) {
  return param::number(name, 1.f).range(0, 4).help("Factor on the width of the soft edge on this side.");
}
constexpr auto scale(const char* name, const char* help) {
  return param::number(name, 1.f).range(0.1f, 4).help(help);
}
constexpr auto kParams =
    joinParams(kRodCommon, std::array{side("left", "Moves the side of -x outwards."), sideEdge("leftEdge"),
                                      side("right", "Moves the side of +x outwards."), sideEdge("rightEdge"),
                                      side("bottom", "Moves the side of -y outwards."), sideEdge("bottomEdge"),
                                      side("top", "Moves the side of +y outwards."), sideEdge("topEdge"),
                                      side("front", "Moves the side of -z outwards."), sideEdge("frontEdge"),
                                      side("back", "Moves the side of +z outwards."), sideEdge("backEdge"),
                                      scale("scaleWidth", "Scales region and edge in x."),
                                      scale("scaleHeight", "Scales region and edge in y."),
                                      scale("scaleDepth", "Scales region and edge in z.")});

std::unique_ptr<Rod> make(const CreateInfo& info) {
  return makeRod(NamedValues(info, kParams.data(), kParams.size()), true);
}
}  // namespace kinora::pxrRodLightFilter
#endif

KINORA_KERNELS_BEGIN
using namespace pxrRodLightFilter;

struct PxrRodLightFilter : RodFilter {};
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(PxrRodLightFilter, .help = "Changes the light on points within a rounded box of space.",
                    .params = kParams, .setUp = setUpBy<make>, .largest = filterParts::largestOfRod)
