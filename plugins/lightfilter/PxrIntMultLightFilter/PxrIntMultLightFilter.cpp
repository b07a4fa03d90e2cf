// PxrIntMultLightFilter: one factor on a light everywhere: intensity * 2^exposure * tint, blended in by density.
#define KINORA_KERNEL_FILE "plugins/lightfilter/PxrIntMultLightFilter/PxrIntMultLightFilter.cpp"
#include <memory>

#include "plugins/lightfilter/parts/filter_setup.h"
// per target from here
#include <kinora/light_filter_author.h>

#if KINORA_PLAIN
namespace kinora::pxrIntMultLightFilter {
using namespace filterParts;
constexpr auto kParams = joinParams(
    intensity(1, "Factor on the light."),
    std::array{
        param::number("exposure", 0.f).range(-8, 8).help("Stops: the factor is multiplied by 2 to this power."),
        param::color("tint", 1.f).help("Colour of the factor."),
    },
    invert("Filters by 1 - density instead."), kStrength, kSaturation);
struct Data {
  float factor[3];
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues v(info, kParams.data(), kParams.size());
  auto data = std::make_unique<Data>();
  double density = strength(v);
  if (v.integer("invert")) density = 1 - density;
  const double scale = v.number("intensity") * std::exp2(std::clamp(v.number("exposure"), -100.0, 100.0));
  double color[3], grey = 0;
  for (int c = 0; c < 3; ++c) {
    constexpr double kLuminance[3] = {0.2126, 0.7152, 0.0722};
    color[c] = v.number("tint", c);
    grey += kLuminance[c] * color[c];
  }
  for (int c = 0; c < 3; ++c) {
    if (const double s = saturation(v); s != 1) color[c] = std::max(grey + s * (color[c] - grey), 0.0);
    const double f = 1 + density * (scale * color[c] - 1);
    if (!(f < 1e30)) throw "the factor is beyond what numbers hold";
    data->factor[c] = float(std::max(f, 0.0));
  }
  v.warnNoEffect();
  return data;
}
float largest(const void* d) {
  const float* f = static_cast<const Data*>(d)->factor;
  return std::max({f[0], f[1], f[2]});
}
}  // namespace kinora::pxrIntMultLightFilter
#endif

KINORA_KERNELS_BEGIN
using namespace pxrIntMultLightFilter;

struct PxrIntMultLightFilter {
  using Data = pxrIntMultLightFilter::Data;
  template <int W>
  static KN_INLINE Rgb<W> factor(const Data& k, const LitPoint<W>&) {
    return {Float<W>(k.factor[0]), Float<W>(k.factor[1]), Float<W>(k.factor[2])};
  }
};
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(
    PxrIntMultLightFilter, .help = "One factor on a light, everywhere.", .params = kParams, .setUp = setUpBy<make>,
    .isUniform = [](const void*) { return 1; }, .largest = largest)
