// PxrIntMultLightFilter: one factor on a light everywhere: intensity * 2^exposure * tint, blended in by density.
#define KINORA_KERNEL_FILE "plugins/lightfilter/PxrIntMultLightFilter/PxrIntMultLightFilter.cpp"
#include <kinora/light_filter.h>
#include <kinora/named_values.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <kinora/simd/foreach_target.h>
#include <kinora/light_filter_author.h>

#ifndef PXRINTMULTLIGHTFILTER_ONCE
#define PXRINTMULTLIGHTFILTER_ONCE
namespace kinora::pxrIntMultLightFilter {
constexpr Param kParams[] = {
    param::number("intensity", 1.f).range(0, 10).help("Factor on the light."),
    param::number("exposure", 0.f).range(-8, 8).help("Stops: the factor is multiplied by 2 to this power."),
    param::color("tint", 1.f).help("Colour of the factor."),
    param::number("density", 1.f).range(0, 1).help("0 leaves the light as it is, 1 filters it fully."),
    param::integer("invert", 0).range(0, 1).options("0 off, 1 on").help("Filters by 1 - density instead."),
    param::number("saturation", 1.f).range(0, 2).help("No effect yet: saturation of the filtered light."),
    param::number("diffuse", 1.f).range(0, 1).help("No effect yet: influence on diffuse light."),
    param::number("specular", 1.f).range(0, 1).help("No effect yet: influence on specular light."),
    param::string("combineMode", "mult").options("mult|max|min|screen").help("No effect yet: filters multiply."),
    param::string("coordsys", "").help("No effect: the factor is the same everywhere."),
    param::string("linkingGroups", "").help("No effect yet: which lights take the filter."),
    param::string("notes", "").help("Free text; read by nobody."),
};
struct Data {
  float factor[3];
};
}  // namespace kinora::pxrIntMultLightFilter
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
struct IntMult {
  using Data = pxrIntMultLightFilter::Data;
  template <int W>
  static KN_INLINE Rgb<W> factor(const Data& k, const LitPoint<W>&) {
    return {Float<W>(k.factor[0]), Float<W>(k.factor[1]), Float<W>(k.factor[2])};
  }
};
using Runner = LightFilterRunner<IntMult>;
KINORA_WIDTH_TABLES(Runner, LightFilterFunctions)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora {
namespace {
using pxrIntMultLightFilter::Data;
using pxrIntMultLightFilter::kParams;

void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&]() -> void* {
    const NamedValues v(*info, kParams, std::size(kParams));
    auto data = std::make_unique<Data>();
    double density = std::clamp(v.number("density"), 0.0, 1.0);
    if (v.integer("invert")) density = 1 - density;
    const double scale = v.number("intensity") * std::exp2(std::clamp(v.number("exposure"), -100.0, 100.0));
    for (int c = 0; c < 3; ++c) {
      const double f = 1 + density * (scale * v.number("tint", c) - 1);
      if (!(f < 1e30)) throw "the factor is beyond what numbers hold";
      data->factor[c] = float(std::max(f, 0.0));
    }
    v.warnNoEffect();
    return data.release();
  });
}
constexpr LightFilterTraits kTraits{[](const void*) { return 1; },
                                    [](const void* d) {
                                      const float* f = static_cast<const Data*>(d)->factor;
                                      return std::max({f[0], f[1], f[2]});
                                    }};
const WidthTable kTables[] = KINORA_ALL_WIDTHS;
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::LightFilter,
                             0,
                             "PxrIntMultLightFilter",
                             "One factor on a light, everywhere.",
                             kParams,
                             uint32_t(std::size(kParams)),
                             kTables,
                             4,
                             &kTraits,
                             create,
                             [](void* d) { delete static_cast<Data*>(d); }};
}  // namespace
KINORA_REGISTER(PxrIntMultLightFilter, kDescriptor)
}  // namespace kinora
#endif
