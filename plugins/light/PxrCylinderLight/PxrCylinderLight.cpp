// PxrCylinderLight: the wall of the cylinder of radius 0.5 and length 1 along local X, emitting outwards; no caps.
// Sampled by solid angle without rejection: planes that hold the point and are parallel to the axis cut the visible
// wall in straight lines; a plane is chosen by its angle phi about the point, and in it Y, the sine of the angle
// against the planes across the axis, evenly between the line's ends. In the coordinates (phi, Y) solid angle is area
// (Archimedes), so the density is p(phi) over the slice's length; p(phi) is a tent between the lengths at the middle
// and at the limb. Any affine placement: everything happens in local space, where the wall is round; density is
// carried over by the Jacobian of the normalised linear map, as in PxrSphereLight. From inside and beyond the ends,
// where the point is nearer to the axis than the wall, it is dark.
#define KINORA_KERNEL_FILE "plugins/light/PxrCylinderLight/PxrCylinderLight.cpp"
#include <kinora/light_setup.h>
#include <memory>
#include <kinora/light_author.h>

#include "plugins/light/parts/solid.h"

#if KINORA_PLAIN
namespace kinora::pxrCylinderLight {
using namespace lightParts;
constexpr auto kParams =
    joinParams(lightParams::kRadiance, lightParams::kNormalize, lightParams::kShaping, lightParams::kControl);
constexpr float kRadius = 0.5f, kHalfLength = 0.5f;  // local

struct Data {
  LightCommon common;
  Shaping shaping;
  Float3 center, axis;    // axis: unit, local +Z, from which focus and cone are measured
  Float3 rows[3];         // local to render, linear part
  Float3 inverse[3];      // render to local: rows of the inverse
  Float3 normalRows[3];   // local normal to render: rows of the inverse transpose
  float determinant = 1;  // absolute
  float rounding = 0;     // of a local direction that went to render space and back, generously
  double area = 0, boundingRadius = 0, scale = 0;  // scale: 0 unless the placement keeps the shape
  Double3 rows64[3], center64;
  bool isBlack = true;
};

constexpr double kPi = 3.14159265358979323846;

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  const LocalFrame f = LocalFrame::of(info);
  auto light = std::make_unique<Data>();
  light->center = Float3(f.origin);
  light->center64 = f.origin;
  const SolidFrame frame(f);
  if (!frame.isDegenerate) {
    frame.place(*light);
    for (int i = 0; i < 3; ++i) light->rows64[i] = frame.rows[i];
    light->rounding = frame.rounding(1.5e-6);
    const bool kept = frame.keepsShape();
    const double lx = frame.lengths[0];
    if (kept) {
      light->scale = lx;
      light->area = kPi * lx * lx;
      light->boundingRadius = std::sqrt(0.5) * lx * (1 + 1e-5);
    }
    constexpr int kSteps = 4096;
    for (int i = 0; i < kSteps && !kept; ++i) {
      const double a = 2 * kPi * (i + 0.5) / kSteps;
      light->area += length(cross(f.x, f.y * (-0.5 * std::sin(a)) + f.z * (0.5 * std::cos(a)))) * 2 * kPi / kSteps;
      const Double3 rim = f.x * 0.5 + f.y * (0.5 * std::cos(a)) + f.z * (0.5 * std::sin(a));
      light->boundingRadius = std::fmax(light->boundingRadius, length(rim) * (1 + 1e-6));
    }
  }
  setSolidLight(values, frame, *light);
  return light;
}

// Of a cylinder wholly above the receiver's horizon; -1 for other cases. Over phi by quadrature, in each slice by the
// primitives of Y and sqrt(1 - Y^2).
double irradiance(const void* data, const double P[3], const double N[3]) {
  const Data& k = *static_cast<const Data*>(data);
  if (k.isBlack) return 0;
  if (k.shaping.focused || k.shaping.coned || k.scale == 0) return -1;
  const Double3 x = normalized(k.rows64[0]), n = normalized({N[0], N[1], N[2]});
  const Double3 to = k.center64 - Double3{P[0], P[1], P[2]};
  const double along = dot(to, x), r = 0.5 * k.scale;
  const Double3 across = to - x * along;
  const double rho = length(across);
  if (rho <= r) return 0;
  // the ends' circles lie above the horizon
  const double nx = dot(n, x), room = r * std::sqrt(std::fmax(0, 1 - nx * nx)), height = dot(to, n);
  if (height - std::fabs(nx) * r - room < 0) return -1;
  const Double3 towards = across * (1 / rho), side = cross(x, towards);
  const double x0 = along - r, x1 = along + r, phiMax = std::asin(r / rho);
  constexpr int kSteps = 4096;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    // substitution phi = phiMax sin(a) takes the root at the limb away
    const double a = kPi * ((i + 0.5) / kSteps - 0.5), phi = phiMax * std::sin(a);
    const double s = rho * std::sin(phi), l = rho * std::cos(phi) - std::sqrt(std::fmax(0, r * r - s * s));
    const double y0 = x0 / std::hypot(x0, l), y1 = x1 / std::hypot(x1, l);
    const double flat = dot(n, towards * std::cos(phi) + side * std::sin(phi));
    const auto primitive = [](double y) { return (y * std::sqrt(1 - y * y) + std::asin(y)) / 2; };
    sum += (nx * (y1 * y1 - y0 * y0) / 2 + flat * (primitive(y1) - primitive(y0))) * phiMax * std::cos(a);
  }
  const double mean = (double(k.common.radiance[0]) + k.common.radiance[1] + k.common.radiance[2]) / 3;
  return mean * sum * kPi / kSteps;
}
}  // namespace kinora::pxrCylinderLight
#endif

KINORA_KERNELS_BEGIN
using namespace pxrCylinderLight;

template <int W>
KN_INLINE Vec3<W> times(Vec3<W> v, const Float3 m[3]) {
  return fma(wide<W>(m[0]), v.x, fma(wide<W>(m[1]), v.y, wide<W>(m[2]) * v.z));
}

// h(y) = y / sqrt(y^2 + d^2), the sine under which the wall's line at distance d begins (y0) and ends (y1): as 1 +
// h0, 1 - h1 and h1 - h0, each without the loss of digits of their differences where d is small beside y or large.
template <int W>
KN_INLINE void sineRange(Float<W> y0, Float<W> y1, Float<W> d2, Float<W>& above0, Float<W>& below1, Float<W>& range) {
  using F = Float<W>;
  const F zero(0.f), one(1.f), l0 = sqrt(max(fma(y0, y0, d2), F(1e-30f))), l1 = sqrt(max(fma(y1, y1, d2), F(1e-30f)));
  const F c0 = d2 / max(l0 * (l0 + abs(y0)), F(1e-37f)), c1 = d2 / max(l1 * (l1 + abs(y1)), F(1e-37f));  // 1 - |h|
  above0 = select(y0 < zero, c0, one + y0 / l0);
  below1 = select(y1 > zero, c1, one - y1 / l1);
  // on one side: the difference of squares over the sum, with the length as it is, not as y1 - y0 rounds it
  const F oneSide =
      d2 * (abs(y0 + y1) * F(2 * kHalfLength)) / max(l0 * l1 * fma(abs(y1), l0, abs(y0) * l1), F(1e-37f));
  range = select((y0 > zero) | (y1 < zero), oneSide, y1 / l1 - y0 / l0);
}

// The wall from a point, in local space.
template <int W>
struct View {
  Vec3<W> P;
  Float<W> towardsY, towardsZ;  // unit, from the point to the axis
  Float<W> rho, beyond;         // distance from the axis; rho^2 - r^2
  Float<W> phiMax;
  Float<W> start, end;    // along the axis, from the point
  Float<W> middle, limb;  // lengths of slices
  Mask<W> outside;
  KN_INLINE View(const Data& k, Vec3<W> render) {
    using F = Float<W>;
    const F r(kRadius);
    P = times<W>(render - wide<W>(k.center), k.inverse);
    rho = sqrt(fma(P.y, P.y, P.z * P.z));
    outside = rho > F(kRadius * (1 + 1e-6f));
    const F inverse = F(-1.f) / max(rho, F(1e-20f));
    towardsY = P.y * inverse;
    towardsZ = P.z * inverse;
    beyond = max((rho - r) * (rho + r), F(1e-12f));
    phiMax = atan2(r, sqrt(beyond));
    start = -P.x - F(kHalfLength);
    end = -P.x + F(kHalfLength);
    F above, below;
    const F near = max(rho - r, F(1e-7f));
    sineRange(start, end, near * near, above, below, middle);
    sineRange(start, end, beyond, above, below, limb);
  }
  // Distance of the wall in the plane at phi, across the axis: the quadratic's smaller root without cancellation.
  KN_INLINE Float<W> wall(Float<W> sine, Float<W> cosine) const {
    using F = Float<W>;
    const F side = rho * sine;
    return beyond / max(fma(rho, cosine, safeSqrt(fnma(side, side, F(kRadius * kRadius)))), F(1e-20f));
  }
  // Density over directions of render space; range: the slice's length, stretch = |l M| of the unit local direction.
  KN_INLINE Float<W> density(const Data& k, Float<W> phi, Float<W> range, Float<W> stretch) const {
    using F = Float<W>;
    const F tent = lerp(middle, limb, min(abs(phi) / phiMax, F(1.f))) / (phiMax * max(middle + limb, F(1e-30f)));
    return zeroUnless(outside & (range > F(0.f)),
                      tent / max(range, F(1e-30f)) * (stretch * stretch * stretch) / F(k.determinant));
  }
};

struct PxrCylinderLight {
  using Data = pxrCylinderLight::Data;
  static constexpr bool kIntersects = true;

  template <int W>
  static KN_INLINE Rgb<W> radiance(const Data& k, Vec3<W> towardsLight) {
    return wideRgb<W>(k.common.radiance) * shape<W>(k.shaping, -dot(towardsLight, wide<W>(k.axis)));
  }

  template <int W>
  static KN_INLINE void sample(const Data& k, const LightPoint<W>& in, LightSample<W>& out) {
    using F = Float<W>;
    if (k.isBlack) return;
    const F one(1.f), two(2.f);
    const View<W> view(k, in.P);
    // the tent's halves share u; each by inversion of a linear density
    const F side = fms(two, in.u, one), u = min(abs(side), one);
    const F m = view.middle, l = view.limb;
    const F x = min(u * (m + l) / max(m + sqrt(lerp(m * m, l * l, u)), F(1e-30f)), one);
    const F phi = copySign(x * view.phiMax, side);
    F sine, cosine, above, below, range;
    sincos(phi, sine, cosine);
    const F across = view.wall(sine, cosine);
    sineRange(view.start, view.end, across * across, above, below, range);
    // 1 + Y and 1 - Y, each with its digits
    const F fromLow = fma(in.v, range, above), fromHigh = fma(one - in.v, range, below);
    const F Y = select(fromLow < fromHigh, fromLow - one, one - fromHigh), c = safeSqrt(fromLow * fromHigh);
    const Vec3<W> local(Y, c * fms(view.towardsY, cosine, view.towardsZ * sine),
                        c * fma(view.towardsZ, cosine, view.towardsY * sine));
    const Vec3<W> w = times<W>(local, k.rows);
    const F stretch = length(w);
    out.wi = w * (one / max(stretch, F(1e-30f)));
    out.distance = across / max(c, F(1e-20f)) * stretch;
    out.pdf = view.density(k, phi, range, stretch);
    out.radiance = radiance<W>(k, out.wi);
  }

  // Where a local ray meets the wall from outside; slack: what a hit may lie beyond the ends and the limb.
  template <int W>
  static KN_INLINE Mask<W> meet(Vec3<W> p, Vec3<W> l, Float<W> slack, Float<W>& at) {
    using F = Float<W>;
    const F r(kRadius), r2(kRadius * kRadius);
    const F a = fma(l.y, l.y, l.z * l.z), b = -fma(p.y, l.y, p.z * l.z), inverse = F(1.f) / max(a, F(1e-37f));
    // from the axis's nearest point of the ray: far rays keep their digits (as for spheres)
    const F y = fma(l.y, b * inverse, p.y), z = fma(l.z, b * inverse, p.z), d2 = fma(y, y, z * z);
    const F rho2 = fma(p.y, p.y, p.z * p.z), c = rho2 - r2;
    at = c / max(b + safeSqrt(a * (r2 - d2)), F(1e-37f));
    const F x = fma(l.x, at, p.x), rim = r + slack;
    return (d2 <= rim * rim) & (c > F(0.f)) & (b > F(0.f)) & (abs(x) <= F(kHalfLength) + slack);
  }

  template <int W>
  static KN_INLINE Mask<W> intersect(const Data& k, Vec3<W> o, Vec3<W> d, Float<W>& t) {
    using F = Float<W>;
    if (k.isBlack) return Mask<W>(false);
    const Vec3<W> p = times<W>(o - wide<W>(k.center), k.inverse), l = times<W>(d, k.inverse);
    F at;
    const Mask<W> hit = meet<W>(p, l, F(0.f), at) & (at < t);
    t = select(hit, at, t);
    return hit;
  }

  template <int W>
  static KN_INLINE void evaluate(const Data& k, const LightRay<W>& ray, Rgb<W>& l, Float<W>& pdf) {
    using F = Float<W>;
    if (k.isBlack) return;
    const View<W> view(k, ray.o);
    const Vec3<W> local = times<W>(ray.d, k.inverse);
    const F inverseStretch = length(local);  // |d M^-1| = 1 / |l M|
    F at;
    // directions made by sample() may miss the edges by rounding, which grows with the distance
    const F slack = fma(sqrt(dot(view.P, view.P)), F(k.rounding), F(2e-5f));
    const Mask<W> hit = view.outside & meet<W>(view.P, local, slack, at);
    const F forward = fma(local.y, view.towardsY, local.z * view.towardsZ);
    const F sideways = fms(local.z, view.towardsY, local.y * view.towardsZ);
    const F phi = clamp(atan2(sideways, forward), -view.phiMax, view.phiMax);
    F sine, cosine, above, below, range;
    sincos(phi, sine, cosine);
    const F across = view.wall(sine, cosine);
    sineRange(view.start, view.end, across * across, above, below, range);
    l = zeroUnless(hit, radiance<W>(k, ray.d));
    pdf = zeroUnless(hit, view.density(k, phi, range, F(1.f) / max(inverseStretch, F(1e-37f))));
  }

  template <int W>
  static KN_INLINE void emit(const Data& k, const EmitInput<W>& in, LightEmission<W>& out) {
    using F = Float<W>;
    if (k.isBlack) return;
    F s, c;
    sincos(in.u1 * F(kTwoPi), s, c);
    const F r(kRadius);
    const Vec3<W> p(in.u0 - F(0.5f), r * c, r * s);
    out.o = times<W>(p, k.rows) + wide<W>(k.center);
    const Vec3<W> normal = times<W>(Vec3<W>(F(0.f), c, s), k.normalRows);
    const F stretch = length(normal);
    out.N = normal * (F(1.f) / max(stretch, F(1e-30f)));
    const Vec3<W> d = cosineHemisphere(in.u2, in.u3);
    out.d = Frame<W>(out.N).toWorld(d);
    // an element of local area grows by |det M| |n M^-T|
    out.pdfPosition = F(1.f / (kTwoPi * kRadius * 2 * kHalfLength)) / (F(k.determinant) * stretch);
    out.pdfDirection = d.z * F(kInvPi);
    out.radiance = radiance<W>(k, -out.d);
  }

  template <int W>
  static KN_INLINE void densities(const Data& k, const LightRay<W>& ray, LightDensities<W>& out) {
    using F = Float<W>;
    if (k.isBlack) return;
    const Vec3<W> local = times<W>(fma(ray.d, ray.t, ray.o - wide<W>(k.center)), k.inverse);
    const F across = F(1.f) / sqrt(max(fma(local.y, local.y, local.z * local.z), F(1e-30f)));
    const Vec3<W> normal = times<W>(Vec3<W>(F(0.f), local.y * across, local.z * across), k.normalRows);
    const F stretch = length(normal);
    out.N = normal * (F(1.f) / max(stretch, F(1e-30f)));
    out.pdfPosition = F(1.f / (kTwoPi * kRadius * 2 * kHalfLength)) / (F(k.determinant) * stretch);
    out.pdfDirection = max(-dot(out.N, ray.d), F(0.f)) * F(kInvPi);
  }
};

KINORA_KERNELS_END

KINORA_LIGHT(PxrCylinderLight,
             .help =
                 "Wall of the cylinder of radius 0.5 and length 1 along local X, emitting outwards; its ends are "
                 "open and dark. Focus and cone are measured from local +Z (emissionFocusNormalize as for a sphere); "
                 "a coneAngle of 90 cuts nothing.",
             .params = kParams, .setUp = setUpBy<make>, .describe = describeSolidLight<Data>,
             .irradiance = irradiance)
