// PxrCookieLightFilter: a picture that the light shines through, in the filter's XY plane or all around its origin.
#define KINORA_KERNEL_FILE "plugins/lightfilter/PxrCookieLightFilter/PxrCookieLightFilter.cpp"
#include <memory>

#include "plugins/lightfilter/parts/blurred_picture.h"
// per target from here
#include <kinora/light_filter_author.h>
#include <kinora/math/elementary.h>

#include "plugins/lightfilter/parts/blurred_picture_kernel.h"

#if KINORA_PLAIN
namespace kinora::pxrCookieLightFilter {
using namespace filterParts;
constexpr auto kParams = joinParams(
    planeParams("cookieMode", "0 physical, 1 analytic"), kPictureParams,
    std::array{
        param::onOff("spherical", false)
            .help("1: the image goes around the origin by latitude (poles at +y, -y) and longitude (+z in its "
                  "middle)."),
        param::onOff("invertU", false).help("Mirrors the image in x."),
        param::onOff("invertV", false).help("Mirrors the image in y."),
        param::onOff("useAlpha", true).help("1: transparent parts show fillColor."),
        param::color("tint", 1.f).help("Factor on the image."),
        param::number("whitepoint", 1.f).range(0.1f, 4).help("The image is divided by this first."),
        param::number("midpoint", 0.18f).range(0.01f, 1).help("Value that contrast leaves as it is."),
        param::number("contrast", 1.f).range(0.1f, 4).help("Exponent about midpoint."),
        param::number("densityNearDist", 0.f)
            .range(0, 10)
            .help("Distance behind the plane where densityNearVal holds."),
        param::number("densityNearVal", 1.f).help("Factor on density there and nearer."),
        param::number("densityMidpoint", 0.5f).help("Part of the way where densityMidVal holds."),
        param::number("densityMidVal", 1.f).help("Factor on density there."),
        param::number("densityFarDist", 10.f)
            .range(0, 100)
            .help("Distance behind the plane where densityFarVal holds."),
        param::number("densityFarVal", 1.f).help("Factor on density there and farther."),
        param::number("densityPow", 1.f).range(0.1f, 4).help("Exponent of the way between near and far."),
        param::number("blur", 0.f)
            .help("Blurs the image, with what surrounds it: averages over rectangles so many times as wide and as "
                  "high as it is."),
        param::number("sBlurMult", 1.f).range(0, 10).help("Factor on their width."),
        param::number("tBlurMult", 1.f).range(0, 10).help("Factor on their height."),
        param::number("blurNearDist", 0.f).range(0, 10).help("Distance behind the plane where blurNearVal holds."),
        param::number("blurNearVal", 1.f).range(0, 10).help("Factor on the blur there and nearer."),
        param::number("blurMidpoint", 0.f).help("Part of the way where blurMidVal holds."),
        param::number("blurMidVal", 1.f).range(0, 10).help("Factor on the blur there."),
        param::number("blurFarDist", 10.f).range(0, 100).help("Distance behind the plane where blurFarVal holds."),
        param::number("blurFarVal", 1.f).range(0, 10).help("Factor on the blur there and farther."),
        param::number("blurPow", 1.f).range(0.1f, 4).help("Exponent of the way between near and far."),
    },
    intensity(1, "Factor on the image."), invert("1: the image counts as 1 less itself."), kStrength, kSaturation);

struct Data {
  Plane plane;
  Picture picture;
  BlurredPicture blurred;
  DistanceStrength byDistance, blurByDistance;
  bool spherical;
  float signU, signV, density, saturation;
};

// Copies for the widest blur; by distance shares of it.
void setBlur(const NamedValues& v, Data& k) {
  const auto factor = [&](const char* name) { return std::min(atLeast(v, name, 0), 1e6f); };
  const float near = factor("blurNearVal"), middle = factor("blurMidVal"), far = factor("blurFarVal");
  const float widest = std::max({near, middle, far}), blur = factor("blur") * widest;
  if (!(blur > 0)) return;
  k.blurByDistance.set(v.number("blurNearDist"), v.number("blurFarDist"), v.number("blurPow"), near / widest,
                       far / widest, v.number("blurMidpoint"), middle / widest);
  k.blurred.make(k.picture, blur * factor("sBlurMult"), blur * factor("tBlurMult"),
                 k.blurByDistance.varies ? BlurredPicture::kMost : 1);
}
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
  setBlur(v, *k);
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
  static KN_INLINE Rgb<W> pictureFor(const Data& k, Mask<W> met, Float<W> u, Float<W> v, Float<W> reach) {
    if (!k.blurred.count) return pictureAt<W>(k.picture, met, u, v);
    return blurredAt<W>(k.picture, k.blurred, met, u, v, strengthAt<W>(k.blurByDistance, reach));
  }
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
      color = pictureFor<W>(k, Mask<W>(true), u, fnma(latitude, F(k.signV), F(0.5f)), reach);
    } else {
      OnPlane<W> at = onPlane<W>(k.plane, p);
      reach = at.behind;
      at.x = at.x * F(k.signU);
      at.y = at.y * F(k.signV);
      F u, v;
      const Mask<W> met = placeOnPlane<W>(k.picture, at, u, v);
      color = pictureFor<W>(k, met, u, v, reach);
    }
    return filtered<W>(saturated<W>(color, k.saturation), strengthAt<W>(k.byDistance, reach) * F(k.density));
  }
};
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(PxrCookieLightFilter,
                    .help = "A picture that the light shines through, in a plane or all around.", .params = kParams,
                    .setUp = setUpBy<make>, .largest = largest)
