// PxrCombinerLightFilter: names the filters of a light by how they combine. The renderer does the combining; alone the
// filter leaves the light as it is.
#define KINORA_KERNEL_FILE "plugins/lightfilter/PxrCombinerLightFilter/PxrCombinerLightFilter.cpp"
#include <memory>

#include "plugins/lightfilter/parts/filter_setup.h"
// per target from here
#include <kinora/light_filter_author.h>

#if KINORA_PLAIN
namespace kinora::pxrCombinerLightFilter {
constexpr Param kParams[] = {
    param::string("mult", "").help("References to the filters whose factors are multiplied."),
    param::string("max", "").help("References to the filters of which the largest factor counts, by channel."),
    param::string("min", "").help("References to the filters of which the smallest factor counts, by channel."),
    param::string("screen", "").help("References to the filters that combine to 1 - (1 - a) (1 - b) ..."),
    param::onOff("combineShadows", false)
        .help("No effect: filters cast no shadows of their own that could be combined."),
    param::string("notes", "").help("Free text; read by nobody."),
};
struct Data {
  explicit Data(const CreateInfo& info) { NamedValues(info, kParams, std::size(kParams)).warnNoEffect(); }
};
}  // namespace kinora::pxrCombinerLightFilter
#endif

KINORA_KERNELS_BEGIN
using namespace pxrCombinerLightFilter;

struct PxrCombinerLightFilter {
  using Data = pxrCombinerLightFilter::Data;
  template <int W>
  static KN_INLINE Rgb<W> factor(const Data&, const LitPoint<W>&) {
    return {Float<W>(1.f), Float<W>(1.f), Float<W>(1.f)};
  }
};
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(
    PxrCombinerLightFilter,
    .help =
        "Says how the filters that it names combine: multiplied, largest, smallest or screened; these are "
        "multiplied.",
    .params = kParams, .setUp = setUp<Data>, .isUniform = [](const void*) { return 1; })
