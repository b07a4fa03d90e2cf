// PxrDistantLight: light from infinitely far away that travels along local +Z (UsdLux has it along -Z in a
// right-handed space, which is +Z in this left-handed light space), from all directions within angleExtent / 2 of
// that. Of the placement only the direction of the Z axis counts. Irradiance facing it is L pi sin^2(angleExtent /
// 2); with areaNormalize it is what the default angle gives, whatever the angle: the intensities that files have with
// it, 800 to 10,000, are those of a sun. Where angleExtent is 0 (one direction, a delta light), it is L itself.
#define KINORA_KERNEL_FILE "plugins/light/PxrDistantLight/PxrDistantLight.cpp"
#include <kinora/light_setup.h>
#include <memory>
#include <kinora/light_author.h>

#if KINORA_PLAIN
namespace kinora::pxrDistantLight {
constexpr float kDefaultAngle = 0.53f;  // of the sun, degrees
constexpr std::array kOwn = {
    param::number("angleExtent", kDefaultAngle)
        .range(0, 180)
        .help("Degrees across the light as seen from the scene; 0 is one direction."),
};
// The common default intensity of 1 is that of a lamp nearby; this light stands for the sun.
constexpr auto withSunIntensity(std::remove_const_t<decltype(lightParams::kRadiance)> list) {
  for (Param& p : list)
    if (std::string_view(p.name) == "intensity") p = param::number("intensity", 50000.f).range(0, 100000).help(p.doc);
  return list;
}
constexpr auto kParams =
    joinParams(withSunIntensity(lightParams::kRadiance), lightParams::kNormalize, kOwn, lightParams::kControl);

struct Data {
  LightCommon common;
  Float3 axis;  // unit, towards the light
  Double3 axis64;
  float oneMinusCos = 0;  // of the half angle
  double sin2 = 0;        // of the half angle, squared
  bool isDelta = false, isBlack = true;
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  const LocalFrame frame = LocalFrame::of(info);
  auto light = std::make_unique<Data>();
  double angle = values.number("angleExtent");
  if (angle < 0 || angle > 180) {
    values.warn("LIGHT-ANGLE", "angleExtent lies outside 0 to 180 degrees", "the nearest of the two is used");
    angle = angle < 0 ? 0 : 180;
  }
  const double half = angle * Shaping::kRadians / 2;
  // narrower than this, single-precision directions do not differ
  light->isDelta = half < 2e-6;
  light->sin2 = light->isDelta ? 0 : std::sin(half) * std::sin(half);
  light->oneMinusCos = light->isDelta ? 0.f : float(2 * std::sin(half / 2) * std::sin(half / 2));
  const double sinOfDefault = std::sin(double(kDefaultAngle) * Shaping::kRadians / 2);
  light->common = LightCommon::of(values, light->isDelta ? 1 : light->sin2 / (sinOfDefault * sinOfDefault));
  values.warnNoEffect();
  light->axis64 = normalized(frame.z) * -1;
  light->axis = Float3(light->axis64);
  if (!(length(frame.z) > 1e-30))
    values.warn("LIGHT-DEGENERATE", "the light's transformation leaves it no direction", "the light is black");
  else
    light->isBlack = light->common.isBlack();
  return light;
}

void describe(const void* data, LightDescription* d) {
  const Data& k = *static_cast<const Data*>(data);
  double sum = 0;
  for (float c : k.common.radiance) sum += std::fabs(double(c)) / 3;
  *d = describeInfiniteLight(k.common, k.isBlack, sum * (k.isDelta ? 1 : 6.283185307179586 * k.oneMinusCos));
  d->isDelta = k.isDelta;
  setAxis(*d, k.axis64 * (1 - 0.5 * k.oneMinusCos));  // the mean over the cone
  d->cosReach = 1 - k.oneMinusCos;
}

// L pi sin^2(half) cos for a cone wholly above the horizon, L cos for one direction; -1 for other cases.
double irradiance(const void* data, const double*, const double N[3]) {
  const Data& k = *static_cast<const Data*>(data);
  if (k.isBlack) return 0;
  const double cosine = dot(normalized({N[0], N[1], N[2]}), k.axis64);
  const double mean = (double(k.common.radiance[0]) + k.common.radiance[1] + k.common.radiance[2]) / 3;
  if (k.isDelta) return cosine > 0 ? mean * cosine : 0;
  const double sine = std::sqrt(k.sin2);
  if (cosine <= -sine) return 0;
  if (cosine < sine) return -1;
  return mean * 3.14159265358979 * k.sin2 * cosine;
}
}  // namespace kinora::pxrDistantLight
#endif

KINORA_KERNELS_BEGIN
using namespace pxrDistantLight;

struct PxrDistantLight {
  using Data = pxrDistantLight::Data;
  static constexpr bool kIntersects = false;

  template <int W>
  static KN_INLINE Vec3<W> direction(const Data& k, Float<W> u, Float<W> v) {
    if (k.isDelta) return wide<W>(k.axis);
    return normalize(Frame<W>(wide<W>(k.axis)).toWorld(uniformCone(u, v, Float<W>(k.oneMinusCos))));
  }
  static float density(const Data& k) { return k.isDelta ? 1.f : kInvTwoPi / k.oneMinusCos; }

  template <int W>
  static KN_INLINE void sample(const Data& k, const LightPoint<W>& in, LightSample<W>& out) {
    using F = Float<W>;
    if (k.isBlack) return;
    out.wi = direction<W>(k, in.u, in.v);
    out.distance = F(__builtin_inff());
    out.pdf = F(density(k));
    out.radiance = wideRgb<W>(k.common.radiance);
    out.delta = Mask<W>(k.isDelta);
  }

  template <int W>
  static KN_INLINE Mask<W> intersect(const Data&, Vec3<W>, Vec3<W>, Float<W>&) {
    return Mask<W>(false);
  }

  template <int W>
  static KN_INLINE void evaluate(const Data& k, const LightRay<W>& ray, Rgb<W>& l, Float<W>& pdf) {
    using F = Float<W>;
    if (k.isBlack || k.isDelta) return;
    // |d - axis|^2 = 2 (1 - cos): keeps its digits for narrow cones; the slack is the rounding of a direction on the
    // rim
    const Vec3<W> off = ray.d - wide<W>(k.axis);
    const float rim = 2 * k.oneMinusCos;
    const Mask<W> hit = dot(off, off) <= F(rim * (1 + 1e-5f) + 4e-7f * __builtin_sqrtf(rim) + 1e-13f);
    l = zeroUnless(hit, wideRgb<W>(k.common.radiance));
    pdf = zeroUnless(hit, F(density(k)));
  }

  // For a delta light pdfDirection is 1 and radiance is the irradiance facing it.
  template <int W>
  static KN_INLINE void emit(const Data& k, const EmitInput<W>& in, LightEmission<W>& out) {
    using F = Float<W>;
    if (k.isBlack) return;
    emitFromDisk<W>(in, -direction<W>(k, in.u2, in.u3), out);
    out.pdfDirection = F(density(k));
    out.radiance = wideRgb<W>(k.common.radiance);
  }
  template <int W>
  static KN_INLINE void densities(const Data& k, const LightRay<W>& ray, LightDensities<W>& out) {
    if (k.isBlack) return;
    Rgb<W> unused;
    if (k.isDelta)
      out.pdfDirection = Float<W>(1.f);
    else
      evaluate<W>(k, ray, unused, out.pdfDirection);
    densityOfDisk<W>(ray, out);
  }
};

KINORA_KERNELS_END

KINORA_LIGHT(
    PxrDistantLight,
    .help = "Light from far away, such as the sun: travels along local +Z. Only the direction of local Z counts.",
    .params = kParams, .setUp = setUpBy<make>, .describe = describe, .irradiance = irradiance)
