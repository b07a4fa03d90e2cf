// PointLight: light from one point, a delta light: irradiance falls with the square of the distance and no ray finds
// it by chance. With a cone it is the spotlight of the RenderMan Interface (RISpec, appendix A.2): the cosine to the
// axis to the power beamDistribution, and an edge that is a smoothstep in that cosine. Of the placement only position
// and the direction of the Z axis count, so that distances are those of the world.
#define KINORA_KERNEL_FILE "plugins/light/PointLight/PointLight.cpp"
#include <kinora/light_setup.h>
#include <memory>
#include <kinora/light_author.h>

#if KINORA_PLAIN
namespace kinora::pointLight {
constexpr std::array kOwn = {
    param::number("coneAngle", 180.f)
        .range(0, 180)
        .help("Degrees off local +Z beyond which nothing is emitted; 180 emits to all sides."),
    param::number("coneDeltaAngle", 0.f)
        .range(0, 180)
        .help("Degrees inside of coneAngle over which the edge fades, smoothly in the cosine."),
    param::number("beamDistribution", 0.f)
        .range(0, 50)
        .help("Exponent of the cosine to local +Z that multiplies the intensity; 0 leaves it."),
};
constexpr auto withRadiantIntensity(std::remove_const_t<decltype(lightParams::kRadiance)> list) {
  for (Param& p : list)
    if (std::string_view(p.name) == "intensity")
      p = param::number("intensity", 1.f)
              .range(0, 100)
              .help("What a surface that faces the light receives at distance 1.");
  return list;
}
constexpr auto kParams = joinParams(withRadiantIntensity(lightParams::kRadiance), kOwn, lightParams::kControl);

// Cosines near 1 lose the digits of narrow cones: angles are kept as 1 - cos.
struct Data {
  LightCommon common;  // its radiance is the radiant intensity
  Float3 center, axis;
  float outer = 2, inner = 2;  // 1 - cos of the cone's end and of where it begins to fade
  float beam = 0;
  bool isConed = false, isBlack = true;
  double shaped = 1;  // mean of the shape over all directions
};

inline double oneMinusCos(double angle) { return 2 * std::sin(angle / 2) * std::sin(angle / 2); }
inline double shapeAt(const Data& k, double away) {  // away: 1 - cos
  double s = 1;
  if (k.isConed) {
    const double room = double(k.outer) - k.inner;
    const double t = room > 0 ? std::fmin(1, std::fmax(0, (k.outer - away) / room)) : (away <= k.outer ? 1 : 0);
    s = t * t * (3 - 2 * t);
  }
  if (k.beam > 0) s *= away < 1 ? std::pow(1 - away, k.beam) : 0;
  return s;
}

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  const LocalFrame frame = LocalFrame::of(info);
  auto light = std::make_unique<Data>();
  const double cone = std::fmin(180, std::fmax(0, values.number("coneAngle")));
  const double fade = std::fmin(cone, std::fmax(0, values.number("coneDeltaAngle")));
  light->isConed = cone < 180 || fade > 0;
  light->outer = float(oneMinusCos(cone * Shaping::kRadians));
  light->inner = float(oneMinusCos((cone - fade) * Shaping::kRadians));
  light->beam = float(std::fmax(0, values.number("beamDistribution")));
  light->common = LightCommon::of(values, -1);
  light->center = Float3(frame.origin);
  values.warnNoEffect();
  const bool hasAxis = length(frame.z) > 1e-30;
  light->axis = hasAxis ? Float3(normalized(frame.z)) : Float3(0, 0, 1);
  if (!hasAxis && (light->isConed || light->beam > 0)) {
    values.warn("LIGHT-DEGENERATE", "the light's transformation leaves it no direction", "the light is black");
    return light;
  }
  light->isBlack = light->common.isBlack() || !(light->outer > 0);
  constexpr int kSteps = 4096;
  light->shaped = 1;
  if (!light->isConed && !(light->beam > 0)) return light;
  light->shaped = 0;
  for (int i = 0; i < kSteps; ++i)
    light->shaped += shapeAt(*light, light->outer * (i + 0.5) / kSteps) * light->outer / 2 / kSteps;
  return light;
}

void describe(const void* data, LightDescription* d) {
  const Data& k = *static_cast<const Data*>(data);
  double sum = 0;
  for (float c : k.common.radiance) sum += std::fabs(double(c)) / 3;
  *d = describeLight(k.common, k.isBlack, 4 * 3.14159265358979 * sum * k.shaped);
  d->isDelta = 1;
  d->center[0] = k.center.x;
  d->center[1] = k.center.y;
  d->center[2] = k.center.z;
  d->radius = 0;
  if (!k.isConed && !(k.beam > 0)) return;
  // even within the cone; a beam falls off with the cosine at least
  setAxis(*d, {k.axis.x, k.axis.y, k.axis.z});
  d->cosNormals = k.beam > 0 ? 1.f : 1 - k.outer;
  d->cosEmission = k.beam > 0 ? (k.outer < 1 ? 1 - k.outer : 0.f) : 1.f;
}

double irradiance(const void* data, const double P[3], const double N[3]) {
  const Data& k = *static_cast<const Data*>(data);
  if (k.isBlack) return 0;
  const Double3 to = Double3{k.center.x, k.center.y, k.center.z} - Double3{P[0], P[1], P[2]};
  const double d = length(to), cosine = dot(to, normalized({N[0], N[1], N[2]})) / d;
  const double away = 1 + dot(to, {k.axis.x, k.axis.y, k.axis.z}) / d;
  const double mean = (double(k.common.radiance[0]) + k.common.radiance[1] + k.common.radiance[2]) / 3;
  return cosine > 0 ? mean * shapeAt(k, away) * cosine / (d * d) : 0;
}
}  // namespace kinora::pointLight
#endif

KINORA_KERNELS_BEGIN
using namespace pointLight;

struct PointLight {
  using Data = pointLight::Data;
  static constexpr bool kIntersects = false, kMixes = true;

  // `travel`: unit, away from the light.
  template <int W>
  static KN_INLINE Rgb<W> intensity(const LightOf<Data, W>& k, Vec3<W> travel) {
    using F = Float<W>;
    F s(1.f);
    if (k.any([](const Data& d) { return d.isConed || d.beam > 0; })) {
      const Vec3<W> off = travel - k(&Data::axis);
      const F away = F(0.5f) * dot(off, off), outer = k(&Data::outer);  // |d - axis|^2 = 2 (1 - cos)
      const F room = outer - k(&Data::inner), beam = k(&Data::beam);
      const F t = select(room > F(0.f), clamp((outer - away) / max(room, F(1e-30f)), F(0.f), F(1.f)),
                         select(away <= outer, F(1.f), F(0.f)));
      s = select(k(&Data::isConed), t * t * fnma(F(2.f), t, F(3.f)), s);
      if (k.any([](const Data& d) { return d.beam > 0; })) {
        const F cosine = F(1.f) - away;
        const F fall = zeroUnless(cosine > F(0.f), pow(max(cosine, F(0.f)), beam));
        s = select(beam > F(0.f), s * fall, s);
      }
    }
    return k.rgb([](const Data& d) { return d.common.radiance; }) * s;
  }

  template <int W>
  static KN_INLINE void sample(const LightOf<Data, W>& k, const LightPoint<W>& in, LightSample<W>& out) {
    using F = Float<W>;
    if (k.isBlack()) return;
    const Vec3<W> to = k(&Data::center) - in.P;
    out.distance = length(to);
    const F inverse = F(1.f) / max(out.distance, F(1e-30f));
    out.wi = to * inverse;
    out.pdf = F(1.f);
    out.radiance = intensity<W>(k, -out.wi) * (inverse * inverse);
    out.delta = Mask<W>(true);
  }

  template <int W>
  static KN_INLINE Mask<W> intersect(const LightOf<Data, W>&, Vec3<W>, Vec3<W>, Float<W>&) {
    return Mask<W>(false);
  }
  template <int W>
  static KN_INLINE void evaluate(const LightOf<Data, W>&, const LightRay<W>&, Rgb<W>&, Float<W>&) {}

  // All light starts at one point: pdfPosition is 1 and radiance is the intensity.
  template <int W>
  static KN_INLINE void emit(const LightOf<Data, W>& k, const EmitInput<W>& in, LightEmission<W>& out) {
    using F = Float<W>;
    if (k.isBlack()) return;
    out.o = k(&Data::center);
    out.d = normalize(Frame<W>(k(&Data::axis)).toWorld(uniformCone(in.u2, in.u3, k(&Data::outer))));
    out.N = out.d;
    out.pdfPosition = F(1.f);
    out.pdfDirection = F(kInvTwoPi) / k(&Data::outer);
    out.radiance = intensity<W>(k, out.d);
  }
  template <int W>
  static KN_INLINE void densities(const LightOf<Data, W>& k, const LightRay<W>& ray, LightDensities<W>& out) {
    using F = Float<W>;
    if (k.isBlack()) return;
    const Vec3<W> off = -ray.d - k(&Data::axis);
    const F outer = k(&Data::outer);
    out.N = -ray.d;
    out.pdfPosition = F(1.f);
    out.pdfDirection = zeroUnless(F(0.5f) * dot(off, off) <= outer * F(1.f + 1e-5f), F(kInvTwoPi) / outer);
  }
};

KINORA_KERNELS_END

KINORA_LIGHT(PointLight,
             .help =
                 "Light from a point without size; with a cone, the spotlight of the RenderMan Interface: radiant "
                 "intensity times the cosine to local +Z to the power beamDistribution, faded at the edge. Only "
                 "position and the direction of local Z count; neither the camera nor mirrors show it.",
             .params = kParams, .setUp = setUpBy<make>, .describe = describe, .irradiance = irradiance)
