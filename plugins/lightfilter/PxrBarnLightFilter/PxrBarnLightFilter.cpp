// PxrBarnLightFilter: barn doors, a window with round corners and soft edges in the filter's XY plane. Light goes
// through the window along +z.
#define KINORA_KERNEL_FILE "plugins/lightfilter/PxrBarnLightFilter/PxrBarnLightFilter.cpp"
#include <memory>

#include "plugins/lightfilter/parts/plane.h"
// per target from here
#include <kinora/light_filter_author.h>

#include "plugins/lightfilter/parts/plane_kernel.h"

#if KINORA_PLAIN
namespace kinora::pxrBarnLightFilter {
using namespace filterParts;
enum Before : int { kUnfiltered, kCone, kDark };
constexpr auto side(const char* name, const char* help) { return param::number(name, 0.f).range(-1, 4).help(help); }
constexpr auto sideEdge(const char* name) {
  return param::number(name, 1.f).range(0, 4).help("Factor on the width of the soft edge on this side.");
}
constexpr auto kParams = joinParams(
    planeParams("barnMode", "0 physical, 1 analytic"),
    std::array{
        param::integer("preBarn", kDark)
            .range(0, 2)
            .options("0 no effect, 1 cone, 2 no light")
            .help("What points before the plane get: all the light, what the window lets through behind it, none."),
        param::number("radius", 0.5f).range(0, 2).help("Of the corners; kept within half the window's sizes."),
        param::number("edge", 0.f).range(0, 2).help("Width of the soft edge about the window."),
        param::number("scaleWidth", 1.f).range(0.1f, 4).help("Scales window and edge in x."),
        param::number("scaleHeight", 1.f).range(0.1f, 4).help("Scales window and edge in y."),
        side("left", "Moves the side of -x outwards."),
        sideEdge("leftEdge"),
        side("right", "Moves the side of +x outwards."),
        sideEdge("rightEdge"),
        side("bottom", "Moves the side of -y outwards."),
        sideEdge("bottomEdge"),
        side("top", "Moves the side of +y outwards."),
        sideEdge("topEdge"),
        param::number("densityNear", 0.f).range(0, 10).help("Distance behind the plane where densityNearVal holds."),
        param::number("densityNearVal", 1.f).help("Factor on density there and nearer."),
        param::number("densityFar", 10.f).range(0, 100).help("Distance behind the plane where densityFarVal holds."),
        param::number("densityFarVal", 1.f).help("Factor on density there and farther."),
        param::number("densityPow", 1.f).range(0.1f, 4).help("Exponent of the way between the two."),
    },
    colorRamp("Colours of the factor, from the window (0) to the outside of its edge (1)."),
    intensity(0, "Factor on the light that the doors hold back."),
    invert("1: the window is shut, the doors let light through."), kStrength);

struct Data {
  Plane plane;
  float low[2], high[2], softLow[2], softHigh[2], radius, perWidth, perHeight;
  float intensity, density;
  DistanceStrength byDistance;
  bool inverted;
  int before;
  Ramp color;
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues v(info, kParams.data(), kParams.size());
  auto k = std::make_unique<Data>();
  k->plane.space = FilterSpace::of(info);
  k->plane.setAnalytic(v, "barnMode");
  const char *sizes[2] = {"width", "height"}, *lows[2] = {"left", "bottom"}, *highs[2] = {"right", "top"};
  const char *lowEdges[2] = {"leftEdge", "bottomEdge"}, *highEdges[2] = {"rightEdge", "topEdge"};
  const float edge = atLeast(v, "edge", 0);
  float least = 1e18f;
  for (int c = 0; c < 2; ++c) {
    const float half = atLeast(v, sizes[c], 0) / 2;
    k->low[c] = -half - float(v.number(lows[c]));
    k->high[c] = std::max(half + float(v.number(highs[c])), k->low[c]);
    k->softLow[c] = edge * atLeast(v, lowEdges[c], 0);
    k->softHigh[c] = edge * atLeast(v, highEdges[c], 0);
    least = std::min(least, (k->high[c] - k->low[c]) / 2);
  }
  // the corners' middles span the inner box
  k->radius = std::min(atLeast(v, "radius", 0), least);
  for (int c = 0; c < 2; ++c) {
    k->low[c] += k->radius;
    k->high[c] -= k->radius;
  }
  k->perWidth = float(1 / std::max(v.number("scaleWidth"), 1e-6));
  k->perHeight = float(1 / std::max(v.number("scaleHeight"), 1e-6));
  k->intensity = atLeast(v, "intensity", 0);
  k->density = strength(v);
  k->byDistance.set(v.number("densityNear"), v.number("densityFar"), v.number("densityPow"),
                    v.number("densityNearVal"), v.number("densityFarVal"));
  k->inverted = v.integer("invert") != 0;
  k->before = std::clamp(v.integer("preBarn"), 0, 2);
  k->color.set(v, "colorRamp", "_Colors", 3);
  v.warnNoEffect();
  return k;
}
float largest(const void* data) {
  const Data& k = *static_cast<const Data*>(data);
  return largestOf(std::max(1.f, k.intensity) * k.color.bound());
}
}  // namespace kinora::pxrBarnLightFilter
#endif

KINORA_KERNELS_BEGIN
using namespace pxrBarnLightFilter;

struct PxrBarnLightFilter {
  using Data = pxrBarnLightFilter::Data;
  template <int W>
  static KN_INLINE Rgb<W> factor(const Data& k, const LitPoint<W>& p) {
    using F = Float<W>;
    const OnPlane<W> at = onPlane<W>(k.plane, p);
    Vec3<W> outside, soft;
    outside.x = outsideOf<W>(at.x * F(k.perWidth), k.low[0], k.high[0], k.softLow[0], k.softHigh[0], soft.x);
    outside.y = outsideOf<W>(at.y * F(k.perHeight), k.low[1], k.high[1], k.softLow[1], k.softHigh[1], soft.y);
    const F t = select(at.met, intoEdge<W>(outside, soft, F(k.radius)), F(1.f));
    F open = F(1.f) - smoothly(F(0.f), F(1.f), t);
    if (k.inverted) open = F(1.f) - open;
    const Mask<W> isBefore = at.behind < F(0.f);
    if (k.before == kDark) open = zeroUnless(!isBefore, open);
    F density = strengthAt<W>(k.byDistance, at.behind) * F(k.density);
    if (k.before == kUnfiltered) density = zeroUnless(!isBefore, density);
    return filtered<W>(rampAt<W>(k.color.ramp, t) * lerp(F(k.intensity), F(1.f), open), density);
  }
};
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(PxrBarnLightFilter, .help = "Barn doors: a window with soft edges, through which light goes.",
                    .params = kParams, .setUp = setUpBy<make>, .largest = largest)
