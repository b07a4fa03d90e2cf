// BarzelLightFilter: the shape of light of Barzel, "Lighting Controls for Computer Cinematography" (Journal of
// Graphics Tools, 1997): a cone whose section is a superellipse with soft edges, near and far cuts, falloff with
// distance and off the axis. Stand-ins for classic lights of that model (uberlight) use it. All lengths are those of
// the filter's space, where the light stands at the origin and shines along +Z. Barn doors, slides, noise and fake
// shadows of the paper are not here.
#define KINORA_KERNEL_FILE "plugins/lightfilter/BarzelLightFilter/BarzelLightFilter.cpp"
#include <memory>

#include "plugins/lightfilter/parts/filter_setup.h"
// per target from here
#include <kinora/light_filter_author.h>
#include <kinora/math/elementary.h>

#include "plugins/lightfilter/parts/filter_kernels.h"

#if KINORA_PLAIN
namespace kinora::barzelLightFilter {
using namespace filterParts;
enum Shape : int { kCone, kOmni, kBeam };
constexpr Param kParams[] = {
    param::integer("shape", kCone)
        .range(0, 2)
        .options("0 cone, 1 all around, 2 parallel rays")
        .help("What the superellipse cuts out: directions (x / z, y / z), nothing, or positions (x, y)."),
    param::number("width", 1.f).range(0.1f, 10).help("Half extent in x where the light is whole, at z = 1."),
    param::number("height", 1.f).range(0.1f, 10).help("Half extent in y where the light is whole, at z = 1."),
    param::number("wedge", 0.1f).help("Width of the soft edge beyond width."),
    param::number("hedge", 0.1f).help("Width of the soft edge beyond height."),
    param::number("roundness", 1.f).help("0: a rectangle, 1: an ellipse."),
    param::number("shearx", 0.f).range(-1, 1).help("Moves the cone's middle in x, by z."),
    param::number("sheary", 0.f).range(-1, 1).help("Moves the cone's middle in y, by z."),
    param::number("cuton", 0.f).range(0, 10).help("Light begins here: by z, all around by distance."),
    param::number("cutoff", 1e6f).range(0, 1e6f).help("Light begins to end here."),
    param::number("nearedge", 0.f).range(0, 10).help("It grows over this length before cuton."),
    param::number("faredge", 0.f).range(0, 10).help("It fades over this length behind cutoff."),
    param::number("falloff", 0.f)
        .range(0, 4)
        .help("Beyond falloffdist light falls with distance to this power; 0: it does not fall."),
    param::number("falloffdist", 1.f).range(0.01f, 10).help("Distance at which falloff makes no difference."),
    param::number("maxintensity", 1.f)
        .range(1, 100)
        .help("Factor at the light itself, to which falloff rises smoothly within falloffdist."),
    param::number("beamdistribution", 0.f).range(0, 10).help("Exponent of the cosine to the axis."),
    param::flag("replacesFalloff", true)
        .help("1: the light itself falls with the square of its distance, which is taken out first."),
    param::number("fromDistance", 1.f)
        .range(0.1f, 10)
        .help("replacesFalloff: distance at which the light's own falloff stays as it is. A usual one lets lights be "
              "chosen well among others."),
    param::string("coordsys", "").help("Coordinate system of the filter; empty: the light's."),
};
struct Data {
  FilterSpace space;
  int shape = kCone;
  float width = 1, height = 1, outerWidth = 1, outerHeight = 1, sharpness = 2, shearX = 0, shearY = 0;
  bool isRectangle = false;
  float on = 0, onEdge = 0, off = 0, offEdge = 0;
  float falloff = 0, falloffDistance = 1, rise = 0, beta = 0, beam = 0;  // rise: log of maxintensity
  bool replacesFalloff = true;
  float fromDistance = 1;
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues v(info, kParams, std::size(kParams));
  auto k = std::make_unique<Data>();
  k->space = FilterSpace::of(info);
  k->shape = std::clamp(v.integer("shape"), 0, 2);
  k->width = atLeast(v, "width", 1e-6);
  k->height = atLeast(v, "height", 1e-6);
  k->outerWidth = k->width + atLeast(v, "wedge", 0);
  k->outerHeight = k->height + atLeast(v, "hedge", 0);
  const double roundness = std::clamp(v.number("roundness"), 0.0, 1.0);
  k->isRectangle = roundness < 0.01;  // rounder corners are below a thousandth of the width
  k->sharpness = k->isRectangle ? 2 : float(2 / roundness);
  k->shearX = float(v.number("shearx"));
  k->shearY = float(v.number("sheary"));
  k->on = float(v.number("cuton"));
  k->onEdge = atLeast(v, "nearedge", 0);
  k->off = float(v.number("cutoff"));
  k->offEdge = atLeast(v, "faredge", 0);
  k->falloff = atLeast(v, "falloff", 0);
  k->falloffDistance = atLeast(v, "falloffdist", 1e-6);
  const double most = std::clamp(v.number("maxintensity"), 1.0, 1e18);
  k->rise = float(std::log(most));
  k->beta = most > 1.0001 ? float(k->falloff / std::log(most)) : 0;
  if (k->beta == 0) k->rise = 0;
  k->beam = atLeast(v, "beamdistribution", 0);
  k->replacesFalloff = v.integer("replacesFalloff") != 0 && k->shape != kBeam;
  k->fromDistance = atLeast(v, "fromDistance", 1e-6);
  return k;
}
}  // namespace kinora::barzelLightFilter
#endif

KINORA_KERNELS_BEGIN
using namespace barzelLightFilter;

// By what a point must be scaled to lie on the superellipse of half axes a, b.
template <int W>
KN_INLINE Float<W> scaleToBorder(const Data& k, Float<W> x, Float<W> y, float a, float b) {
  using F = Float<W>;
  const F u = x * F(1 / a), v = y * F(1 / b), most = max(max(u, v), F(1e-18f)), least = min(u, v);
  const F ratio = max(least / most, F(1e-6f)), e(k.sharpness);
  return F(1.f) / (most * pow(F(1.f) + pow(ratio, e), F(1.f) / e));
}

struct BarzelLightFilter {
  using Data = barzelLightFilter::Data;
  template <int W>
  static KN_INLINE Rgb<W> factor(const Data& k, const LitPoint<W>& p) {
    using F = Float<W>;
    const Vec3<W> at = placeIn<W>(k.space, p.P);
    const F distance = max(length(at), F(1e-12f));
    F f(1.f);
    if (k.shape != kOmni) {
      const F depth = max(at.z, F(1e-12f)), one = k.shape == kCone ? F(1.f) / depth : F(1.f);
      const F x = abs(fnma(at.z, F(k.shearX), at.x)) * one, y = abs(fnma(at.z, F(k.shearY), at.y)) * one;
      if (k.isRectangle)
        f = (F(1.f) - smoothly(F(k.width), F(k.outerWidth), x)) *
            (F(1.f) - smoothly(F(k.height), F(k.outerHeight), y));
      else
        f = F(1.f) - smoothly(scaleToBorder(k, x, y, k.width, k.height),
                              scaleToBorder(k, x, y, k.outerWidth, k.outerHeight), F(1.f));
      f = zeroUnless(at.z > F(0.f), f);
    }
    const F reach = k.shape == kOmni ? distance : at.z;
    f = f * smoothly(F(k.on - k.onEdge), F(k.on), reach);
    f = f * (F(1.f) - smoothly(F(k.off), F(k.off + k.offEdge), reach));
    if (k.falloff > 0) {
      const F relative = distance * F(1 / k.falloffDistance);
      const F far = pow(max(relative, F(1.f)), F(-k.falloff));
      F near(1.f);
      if (k.rise > 0) near = exp(F(k.rise) * (F(1.f) - pow(max(min(relative, F(1.f)), F(1e-12f)), F(k.beta))));
      f = f * select(relative > F(1.f), far, near);
    }
    if (k.beam > 0 && k.shape == kCone) f = f * pow(max(at.z / distance, F(1e-12f)), F(k.beam));
    if (k.replacesFalloff) {
      const F away = p.distance * F(1 / k.fromDistance);
      f = f * away * away;
    }
    return Rgb<W>(f, f, f);
  }
};
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(
    BarzelLightFilter,
    .help = "A cone of superelliptic section with soft edges, near and far cuts and falloff (Barzel 1997).",
    .params = kParams, .setUp = setUpBy<make>)
