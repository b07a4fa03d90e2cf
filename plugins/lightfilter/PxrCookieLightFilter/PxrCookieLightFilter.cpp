// PxrCookieLightFilter: a picture that the light shines through, in the filter's XY plane or all around its origin.
#define KINORA_KERNEL_FILE "plugins/lightfilter/PxrCookieLightFilter/PxrCookieLightFilter.cpp"
#include <memory>

#include "plugins/lightfilter/parts/picture.h"
// per target from here
#include <kinora/light_filter_author.h>
#include <kinora/math/elementary.h>

#include "plugins/lightfilter/parts/picture_kernel.h"

#if KINORA_PLAIN
namespace kinora::pxrCookieLightFilter {
using namespace filterParts;
constexpr auto unused(const char* name, float standard) {
  return param::number(name, standard).range(0, 10).help("No effect yet: the image is not blurred.");
}
constexpr auto kParams = joinParams(
    planeParams("cookieMode", "0 physical, 1 analytic"), kPictureParams,
    std::array{
        param::integer("spherical", 0)
            .range(0, 1)
            .options("0 off, 1 on")
            .help("1: the image goes around the origin by latitude (poles at +y, -y) and longitude (+z in its "
                  "middle)."),
        param::integer("invertU", 0).range(0, 1).options("0 off, 1 on").help("Mirrors the image in x."),
        param::integer("invertV", 0).range(0, 1).options("0 off, 1 on").help("Mirrors the image in y."),
        param::integer("useAlpha", 1).range(0, 1).options("0 off, 1 on").help("1: transparent parts show fillColor."),
        param::color("tint", 1.f).help("Factor on the image."),
        param::number("whitepoint", 1.f).range(0.1f, 4).help("The image is divided by this first."),
        param::number("midpoint", 0.18f).range(0.01f, 1).help("Value that contrast leaves as it is."),
        param::number("contrast", 1.f).range(0.1f, 4).help("Exponent about midpoint."),
        param::number("densityNearDist", 0.f)
            .range(0, 10)
            .help("Distance behind the plane where densityNearVal holds."),
        param::number("densityNearVal", 1.f).range(0, 1).help("Factor on density there and nearer."),
        param::number("densityMidpoint", 0.5f).range(0, 1).help("Part of the way where densityMidVal holds."),
        param::number("densityMidVal", 1.f).range(0, 1).help("Factor on density there."),
        param::number("densityFarDist", 10.f)
            .range(0, 100)
            .help("Distance behind the plane where densityFarVal holds."),
        param::number("densityFarVal", 1.f).range(0, 1).help("Factor on density there and farther."),
        param::number("densityPow", 1.f).range(0.1f, 4).help("Exponent of the way between near and far."),
        unused("blur", 0),
        unused("sBlurMult", 1),
        unused("tBlurMult", 1),
        unused("blurNearDist", 0),
        unused("blurNearVal", 1),
        unused("blurMidpoint", 0),
        unused("blurMidVal", 1),
        unused("blurFarDist", 10),
        unused("blurFarVal", 1),
        unused("blurPow", 1),
    },
    intensity(1, "Factor on the image."), invert("1: the image counts as 1 less itself."), kStrength, kSaturation);

struct Data {
  Plane plane;
  Picture picture;
  DistanceStrength byDistance;
  bool spherical;
  float signU, signV, density, saturation;
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues v(info, kParams.data(), kParams.size());
  auto k = std::make_unique<Data>();
  k->plane.space = FilterSpace::of(info);
  k->plane.setAnalytic(v, "cookieMode");
  Picture::Grade grade;
  grade.inverted = v.integer("invert") != 0;
  grade.usesAlpha = v.integer("useAlpha") != 0;
  grade.intensity = atLeast(v, "intensity", 0);
  grade.whitepoint = atLeast(v, "whitepoint", 1e-6);
  grade.midpoint = atLeast(v, "midpoint", 1e-6);
  grade.contrast = atLeast(v, "contrast", 0);
  for (int c = 0; c < 3; ++c) grade.tint[c] = std::clamp(v.number("tint", c), 0.0, 1e9);
  k->picture.set(v, grade);
  k->spherical = v.integer("spherical") != 0;
  k->signU = v.integer("invertU") ? -1.f : 1.f;
  k->signV = v.integer("invertV") ? -1.f : 1.f;
  k->density = k->picture.map.valid() ? strength(v) : 0.f;
  k->saturation = saturation(v);
  k->byDistance.set(v.number("densityNearDist"), v.number("densityFarDist"), v.number("densityPow"),
                    v.number("densityNearVal"), v.number("densityFarVal"), v.number("densityMidpoint"),
                    v.number("densityMidVal"));
  v.warnNoEffect();
  return k;
}
float largest(const void* data) {
  const Data& k = *static_cast<const Data*>(data);
  return largestOf(k.picture.mostOfAll * std::max(k.saturation, 1.f));
}
}  // namespace kinora::pxrCookieLightFilter
#endif

KINORA_KERNELS_BEGIN
using namespace pxrCookieLightFilter;

struct PxrCookieLightFilter {
  using Data = pxrCookieLightFilter::Data;
  template <int W>
  static KN_INLINE Rgb<W> factor(const Data& k, const LitPoint<W>& p) {
    using F = Float<W>;
    if (k.density == 0) return Rgb<W>(F(1.f), F(1.f), F(1.f));
    F reach;
    Rgb<W> color;
    if (k.spherical) {
      const Vec3<W> at = placeIn<W>(k.plane.space, p.P);
      reach = length(at);
      const F u = fma(atan2(at.x, at.z), F(0.5f * kInvPi * k.signU), F(0.5f));
      const F latitude = F(0.5f) - acos(clamp(at.y / max(reach, F(1e-12f)), F(-1.f), F(1.f))) * F(kInvPi);
      color = pictureAt<W>(k.picture, Mask<W>(true), u, fnma(latitude, F(k.signV), F(0.5f)));
    } else {
      OnPlane<W> at = onPlane<W>(k.plane, p);
      reach = at.behind;
      at.x = at.x * F(k.signU);
      at.y = at.y * F(k.signV);
      color = pictureOnPlane<W>(k.picture, at);
    }
    return filtered<W>(saturated<W>(color, k.saturation), strengthAt<W>(k.byDistance, reach) * F(k.density));
  }
};
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(PxrCookieLightFilter,
                    .help = "A picture that the light shines through, in a plane or all around.", .params = kParams,
                    .setUp = setUpBy<make>, .largest = largest)
