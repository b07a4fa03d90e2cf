// PxrRampLightFilter: a factor on the light by the lit point's distance: to the light, or along or about the axes of
// the filter's space.
#define KINORA_KERNEL_FILE "plugins/lightfilter/PxrRampLightFilter/PxrRampLightFilter.cpp"
#include <memory>

#include "plugins/lightfilter/parts/filter_setup.h"
// per target from here
#include <kinora/light_filter_author.h>

#include "plugins/lightfilter/parts/filter_kernels.h"

#if KINORA_PLAIN
namespace kinora::pxrRampLightFilter {
using namespace filterParts;
enum Type_ : int { kToLight, kLinear, kSpherical, kRadial };
constexpr float kRampFloats[] = {0, 0, 1, 1};
constexpr auto kParams = joinParams(
    std::array{
        param::integer("rampType", kToLight)
            .range(0, 3)
            .options(
                "0 distance to the light, 1 along z, 2 distance to the filter's origin, 3 distance to its z axis")
            .help("What runs along the ramps."),
        param::number("beginDist", 0.f).range(0, 10).help("Distance at the ramps' 0."),
        param::number("endDist", 10.f).range(0, 10).help("Distance at the ramps' 1."),
        param::integer("ramp", 4).range(0, 64).help("Number of knots; the arrays' lengths count."),
        param::array(Type::Float, "ramp_Knots", kUnitKnots, 4).help("Places of the factors, ascending."),
        param::array(Type::Float, "ramp_Floats", kRampFloats, 4).help("Factors on the light."),
        param::string("ramp_Interpolation", "linear")
            .options("linear|catmull-rom|bspline|constant")
            .help("Curve between the knots."),
    },
    colorRamp("Colours, multiplied by the factors."), intensity(1, "Factor on the ramps."),
    invert("1: the factor is 1 less itself."), kStrength, kSaturation);

struct Data {
  FilterSpace space;
  int type;
  float begin, perLength, intensity, density, saturation;
  bool inverted;
  Ramp ramp, color;
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues v(info, kParams.data(), kParams.size());
  auto k = std::make_unique<Data>();
  k->space = FilterSpace::of(info);
  k->type = std::clamp(v.integer("rampType"), 0, 3);
  const double begin = v.number("beginDist"), length = v.number("endDist") - begin;
  k->begin = float(begin);
  // a ramp of no length is a step
  k->perLength = float(1 / (std::fabs(length) > 1e-9 ? length : 1e-9));
  k->intensity = atLeast(v, "intensity", 0);
  k->density = strength(v);
  k->saturation = saturation(v);
  k->inverted = v.integer("invert") != 0;
  k->ramp.set(v, "ramp", "_Floats", 1);
  k->color.set(v, "colorRamp", "_Colors", 3);
  v.warnNoEffect();
  return k;
}
float largest(const void* data) {
  const Data& k = *static_cast<const Data*>(data);
  return largestOf((k.intensity * k.ramp.bound() * k.color.bound() + (k.inverted ? 1.f : 0.f)) *
                   std::max(k.saturation, 1.f));
}
}  // namespace kinora::pxrRampLightFilter
#endif

KINORA_KERNELS_BEGIN
using namespace pxrRampLightFilter;

struct PxrRampLightFilter {
  using Data = pxrRampLightFilter::Data;
  template <int W>
  static KN_INLINE Rgb<W> factor(const Data& k, const LitPoint<W>& p) {
    using F = Float<W>;
    const Vec3<W> at = placeIn<W>(k.space, p.P);
    F reach = min(p.distance, F(1e18f));
    if (k.type == kLinear) reach = at.z;
    if (k.type == kSpherical) reach = length(at);
    if (k.type == kRadial) reach = sqrt(fma(at.x, at.x, at.y * at.y));
    const F t = clamp((reach - F(k.begin)) * F(k.perLength), F(0.f), F(1.f));
    Rgb<W> color = rampAt<W>(k.color.ramp, t) * rampAt<W>(k.ramp.ramp, t) * F(k.intensity);
    if (k.inverted) color = Rgb<W>(F(1.f), F(1.f), F(1.f)) - color;
    return filtered<W>(saturated<W>(color, k.saturation), F(k.density));
  }
};
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(PxrRampLightFilter, .help = "Changes the light by the lit point's distance, along ramps.",
                    .params = kParams, .setUp = setUpBy<make>, .largest = largest)
