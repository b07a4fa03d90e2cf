// PxrDiskLight: the disk of radius 0.5 in the local XY plane, emitting to the side of local +Z. Sampled by solid
// angle within the elliptic cone that it fills (its axes as in Guillen, Urena, King, Fajardo, Georgiev, Lopez-Moreno
// and Jarabo, "Area-Preserving Parameterizations for Spherical Ellipses", EGSR 2017, section 3). Their maps need
// elliptic integrals; here a direction is made as (phi, Y), the coordinates of Archimedes' equal-area cylinder about
// the cone's wider axis: Y evenly between the ends of the slice at phi, phi from a mixture of the two profiles that
// are exact in the limits of narrow cones (a half circle) and of half-open lunes (flat). So densities are evaluated
// exactly and vary little. Everything happens in local space, where the disk is round; density is carried over by the
// Jacobian of the normalised linear map, as in PxrSphereLight.
#define KINORA_KERNEL_FILE "plugins/light/PxrDiskLight/PxrDiskLight.cpp"
#include <kinora/light_setup.h>
#include <memory>
#include <kinora/light_author.h>

#if KINORA_PLAIN
namespace kinora::pxrDiskLight {
constexpr auto kParams =
    joinParams(lightParams::kRadiance, lightParams::kNormalize, lightParams::kShaping, lightParams::kControl);
constexpr float kRadius = 0.5f;  // local

struct Data {
  LightCommon common;
  Shaping shaping;
  Float3 center, normal;
  Float3 rows[3];     // local to render: X, Y, and the normal times a length between theirs
  Float3 inverse[3];  // dot(v, inverse[i]) is local coordinate i
  float determinant = 1, area = 0;
  float rounding = 0;  // of a local position a local distance 1 away, generously
  double boundingRadius = 0;
  bool isBlack = true;
  Double3 axisX, axisY, center64, normal64;
};

constexpr double kPi = 3.14159265358979323846;

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  const LocalFrame f = LocalFrame::of(info);
  auto light = std::make_unique<Data>();
  const Double3 across = cross(f.x, f.y);
  const double square = length(across), area = kPi / 4 * square, lx = length(f.x), ly = length(f.y);
  light->common = LightCommon::of(values, area);
  light->shaping = Shaping::of(values, false);
  values.warnNoEffect();
  light->center = Float3(f.origin);
  if (!(square > 1e-30) || !(square > 1e-6 * lx * ly) || !(std::fmin(lx, ly) > 1e-6 * std::fmax(lx, ly))) {
    values.warn("LIGHT-DEGENERATE", "the light's transformation leaves it no area", "the light is black");
    return light;
  }
  // the side of local +Z; where Z is lost in the plane, that of X cross Y
  const Double3 n = normalized(across) * (dot(across, f.z) < 0 ? -1.0 : 1.0);
  const double scale = std::sqrt(square);
  light->center64 = f.origin;
  light->axisX = f.x;
  light->axisY = f.y;
  light->normal64 = n;
  light->normal = Float3(n);
  light->rows[0] = Float3(f.x);
  light->rows[1] = Float3(f.y);
  light->rows[2] = Float3(n * scale);
  const Double3 up = normalized(across);
  light->inverse[0] = Float3(cross(f.y, up) * (1 / square));
  light->inverse[1] = Float3(cross(up, f.x) * (1 / square));
  light->inverse[2] = Float3(n * (1 / scale));
  light->determinant = float(square * scale);
  light->area = float(area);
  // the ellipse's longer half axis
  const double a = dot(f.x, f.x), b = dot(f.x, f.y), c = dot(f.y, f.y);
  const double longest = std::sqrt((a + c) / 2 + std::sqrt((a - c) * (a - c) / 4 + b * b));
  light->boundingRadius = 0.5 * longest;
  light->rounding = float(4e-7 * std::fmin(longest / scale, 100) * std::fmin(longest * scale / square, 100));
  light->isBlack = light->common.isBlack();
  return light;
}

void describe(const void* data, LightDescription* d) {
  const Data& k = *static_cast<const Data*>(data);
  *d = describeSurfaceLight(k.common, k.shaping, k.isBlack, k.center, k.boundingRadius * (1 + 1e-6), k.area);
  if (!(k.boundingRadius > 0)) return;
  describeEmission(*d, k.shaping, k.normal64);
  // an ellipse reaches as far along an axis as the root of the sum of its half axes' squares there
  const Double3 reach{0.5 * std::hypot(k.axisX.x, k.axisY.x), 0.5 * std::hypot(k.axisX.y, k.axisY.y),
                      0.5 * std::hypot(k.axisX.z, k.axisY.z)};
  LightBox box;
  box.add(k.center64 - reach);
  box.add(k.center64 + reach);
  box.describe(*d);
}

// Lambert's formula over a polygon of many sides and the ellipse's area, cut at the receiver's horizon: within 1e-5.
// -1 where shaping makes the radiance vary.
double irradiance(const void* data, const double P[3], const double N[3]) {
  const Data& k = *static_cast<const Data*>(data);
  if (k.isBlack) return 0;
  if (k.shaping.focused || k.shaping.coned) return -1;
  const Double3 p{P[0], P[1], P[2]}, n = normalized({N[0], N[1], N[2]});
  if (dot(p - k.center64, k.normal64) <= 0) return 0;
  constexpr int kSides = 2048;
  constexpr double kStep = 2 * kPi / kSides;
  const double r = 0.5 * std::sqrt(kStep / std::sin(kStep));
  const auto corner = [&](int i) {
    return k.center64 + k.axisX * (r * std::cos(i * kStep)) + k.axisY * (r * std::sin(i * kStep)) - p;
  };
  Double3 first{}, last{};
  bool any = false;
  double sum = 0;
  const auto edge = [&](Double3 from, Double3 to) {
    const Double3 a = normalized(from), b = normalized(to), c = cross(a, b);
    const double s = length(c);
    if (s > 1e-15) sum += std::atan2(s, dot(a, b)) * dot(c, n) / s;
  };
  const auto vertex = [&](Double3 v) {
    if (any)
      edge(last, v);
    else
      first = v;
    any = true;
    last = v;
  };
  Double3 a = corner(0);
  for (int i = 0; i < kSides; ++i) {
    const Double3 b = corner(i + 1);
    const double ha = dot(a, n), hb = dot(b, n);
    if (ha >= 0) vertex(a);
    if ((ha < 0) != (hb < 0)) vertex(a + (b - a) * (ha / (ha - hb)));
    a = b;
  }
  if (any) edge(last, first);
  const double mean = (double(k.common.radiance[0]) + k.common.radiance[1] + k.common.radiance[2]) / 3;
  return mean * std::fabs(sum) / 2;
}
}  // namespace kinora::pxrDiskLight
#endif

KINORA_KERNELS_BEGIN
using namespace pxrDiskLight;

// Of each lane's light.
template <int W>
struct Lights {
  const LightOf<Data, W>& of;
  Vec3<W> center, normal, rows[3], inverse[3];
  Float<W> determinant, area, rounding, sinCone;
  KN_INLINE explicit Lights(const LightOf<Data, W>& k)
      : of(k),
        center(k(&Data::center)),
        normal(k(&Data::normal)),
        determinant(k(&Data::determinant)),
        area(k(&Data::area)),
        rounding(k(&Data::rounding)),
        sinCone(k.number([](const Data& d) { return d.shaping.sinCone; })) {
    for (int i = 0; i < 3; ++i) {
      rows[i] = k.vector([i](const Data& d) -> const Float3& { return d.rows[i]; });
      inverse[i] = k.vector([i](const Data& d) -> const Float3& { return d.inverse[i]; });
    }
  }
};

template <int W>
KN_INLINE Vec3<W> toLocal(const Lights<W>& k, Vec3<W> v) {
  return {dot(v, k.inverse[0]), dot(v, k.inverse[1]), dot(v, k.inverse[2])};
}
template <int W>
KN_INLINE Vec3<W> toRender(const Lights<W>& k, Vec3<W> l) {
  return fma(k.rows[0], l.x, fma(k.rows[1], l.y, k.rows[2] * l.z));
}

// The disk from a point, in local space. The cone's symmetry plane holds the point, the disk's axis and the cone's
// axis; `along` is horizontal in it, towards the disk's axis.
template <int W>
struct View {
  Vec3<W> P;
  Float<W> alongX, alongY;
  Float<W> sinTilt, cosTilt;     // of the cone's axis against the way straight down
  Float<W> alpha;                // half angle in the symmetry plane
  Float<W> sin2Alpha, tan2Beta;  // beta: half angle across it, the larger one
  Float<W> flat;                 // share of the flat profile
  Mask<W> front;
  KN_INLINE View(const Lights<W>& k, Vec3<W> render) {
    using F = Float<W>;
    const F r(kRadius), tiny(1e-30f);
    P = toLocal<W>(k, render - k.center);
    front = P.z > F(1e-12f);
    const F h = max(P.z, F(1e-12f)), rho = sqrt(fma(P.x, P.x, P.y * P.y));
    const Mask<W> off = rho > F(1e-12f);
    const F inverseRho = F(1.f) / max(rho, F(1e-12f));
    alongX = select(off, -P.x * inverseRho, F(1.f));
    alongY = select(off, -P.y * inverseRho, F(0.f));
    // the rim's nearest and farthest points
    const F a = rho - r, b = rho + r, h2 = h * h;
    const F l0 = sqrt(max(fma(a, a, h2), tiny)), l1 = sqrt(fma(b, b, h2)), both = l0 * l1;
    // both +- q are 2 both cos^2 alpha and 2 both sin^2 alpha; their product is (2 r h)^2
    const F q = fma(a, b, h2), big = both + abs(q), small = F(4.f) * r * r * h2 / big;
    const Mask<W> narrow = q >= F(0.f);
    const F s = select(narrow, big, small), d = select(narrow, small, big);
    alpha = atan2(sqrt(d), sqrt(s));
    sin2Alpha = d / (F(2.f) * both);
    tan2Beta = F(2.f) * r * r / max(s, tiny);
    const F sinBeta = min(F(2.f) * r / (l0 + l1), F(1.f));
    flat = sinBeta * sinBeta * sinBeta;
    // the cone's axis halves the angle between the ways to the two points
    const F across = a / l0 + b / l1, down = h / l0 + h / l1;
    const F inverse = F(1.f) / sqrt(max(fma(across, across, down * down), tiny));
    sinTilt = across * inverse;
    cosTilt = down * inverse;
  }
  // sin(alpha - phi) sin(alpha + phi), and the product of the angles over that of their sines; phi within the cone.
  KN_INLINE void edges(Float<W> phi, Float<W>& sines, Float<W>& ratio) const {
    using F = Float<W>;
    const F below = max(alpha - phi, F(1e-18f)), above = max(alpha + phi, F(1e-18f));
    sines = max(sin(below), F(1e-18f)) * max(sin(above), F(1e-18f));
    ratio = below * above / sines;
  }
  // Greatest Y of the slice at phi.
  KN_INLINE Float<W> reach(Float<W> sines) const {
    using F = Float<W>;
    const F t = tan2Beta * sines / max(sin2Alpha, F(1e-30f));
    return sqrt(t / (F(1.f) + t));
  }
  // Density over directions of render space; stretch = |l M| of the unit local direction.
  KN_INLINE Float<W> density(const Lights<W>& k, Float<W> phi, Float<W> stretch) const {
    using F = Float<W>;
    F sines, ratio;
    edges(phi, sines, ratio);
    // each profile over the slice's length 2 reach(); the half circle's quotient written without 0 / 0 at the rim
    const F even = F(0.25f) * flat / (alpha * max(reach(sines), F(1e-18f)));
    const F round = (F(1.f) - flat) * F(kInvPi) / (alpha * alpha) * sqrt(ratio * (sin2Alpha / tan2Beta + sines));
    return zeroUnless(front, (even + round) * (stretch * stretch * stretch) / k.determinant);
  }
};

struct PxrDiskLight {
  using Data = pxrDiskLight::Data;
  static constexpr bool kIntersects = true, kMixes = true;

  template <int W>
  static KN_INLINE Rgb<W> radiance(const Lights<W>& k, Float<W> cosine) {
    return k.of.rgb([](const Data& d) { return d.common.radiance; }) * shape(k.of, cosine);
  }

  template <int W>
  static KN_INLINE void sample(const LightOf<Data, W>& of, const LightPoint<W>& in, LightSample<W>& out) {
    using F = Float<W>;
    if (of.isBlack()) return;
    const Lights<W> k(of);
    const F one(1.f), two(2.f);
    const View<W> view(k, in.P);
    // which profile: strata of u survive within each
    const Mask<W> even = in.u < view.flat;
    const F u = select(even, in.u / max(view.flat, F(1e-20f)), (in.u - view.flat) / max(one - view.flat, F(1e-7f)));
    F x, y;
    concentricDisk(clamp(u, F(0.f), one), in.v, x, y);
    const F place = select(even, fms(two, u, one), x);
    const F across =
        select(even, fms(two, in.v, one), clamp(y / max(safeSqrt(fnma(x, x, one)), F(1e-12f)), F(-1.f), one));
    const F phi = clamp(place, F(-1.f), one) * view.alpha;
    F sines, ratio, sine, cosine;
    view.edges(phi, sines, ratio);
    sincos(phi, sine, cosine);
    const F Y = across * view.reach(sines), c = safeSqrt(fnma(Y, Y, one));
    const F level = c * fma(cosine, view.sinTilt, sine * view.cosTilt);
    const F down = c * fms(cosine, view.cosTilt, sine * view.sinTilt);
    const Vec3<W> local(fms(view.alongX, level, view.alongY * Y), fma(view.alongY, level, view.alongX * Y), -down);
    const Vec3<W> w = toRender<W>(k, local);
    const F stretch = length(w);
    out.wi = w * (one / max(stretch, F(1e-30f)));
    out.distance = view.P.z / max(down, F(1e-20f)) * stretch;
    out.pdf = zeroUnless(down > F(0.f), view.density(k, phi, stretch));
    out.radiance = radiance<W>(k, -dot(out.wi, k.normal));
  }

  template <int W>
  static KN_INLINE Mask<W> intersect(const LightOf<Data, W>& of, Vec3<W> o, Vec3<W> d, Float<W>& t) {
    using F = Float<W>;
    if (of.isBlack()) return Mask<W>(false);
    const Lights<W> k(of);
    const Vec3<W> p = toLocal<W>(k, o - k.center), l = toLocal<W>(k, d);
    const F at = p.z / max(-l.z, F(1e-30f));
    const F x = fma(l.x, at, p.x), y = fma(l.y, at, p.y);
    const Mask<W> hit = (l.z < F(0.f)) & (p.z > F(0.f)) & (fma(x, x, y * y) <= F(kRadius * kRadius)) & (at < t);
    t = select(hit, at, t);
    return hit;
  }

  template <int W>
  static KN_INLINE void evaluate(const LightOf<Data, W>& of, const LightRay<W>& ray, Rgb<W>& l, Float<W>& pdf) {
    using F = Float<W>;
    if (of.isBlack()) return;
    const Lights<W> k(of);
    const View<W> view(k, ray.o);
    const Vec3<W> local = toLocal<W>(k, ray.d);
    const F inverseStretch = length(local);  // |d M^-1| = 1 / |l M|
    const F at = view.P.z / max(-local.z, F(1e-30f)), reach = inverseStretch * at;
    // directions that sample() made towards the rim may miss it by rounding, which grows with the distance, and where
    // the disk is seen edge-on
    const F x0 = fma(local.x, at, view.P.x), y0 = fma(local.y, at, view.P.y);
    const F rim = fma(reach * reach / max(view.P.z, F(1e-20f)), k.rounding, F(kRadius * (1 + 2e-6f)));
    const Mask<W> hit = view.front & (local.z < F(0.f)) & (fma(x0, x0, y0 * y0) <= rim * rim);
    const F level = fma(local.x, view.alongX, local.y * view.alongY);
    const F x = fma(level, view.cosTilt, local.z * view.sinTilt),
            z = fms(level, view.sinTilt, local.z * view.cosTilt);
    const F phi = clamp(atan2(x, z), -view.alpha, view.alpha);
    l = zeroUnless(hit, radiance<W>(k, -dot(ray.d, k.normal)));
    pdf = zeroUnless(hit, view.density(k, phi, F(1.f) / max(inverseStretch, F(1e-30f))));
  }

  template <int W>
  static KN_INLINE void emit(const LightOf<Data, W>& of, const EmitInput<W>& in, LightEmission<W>& out) {
    using F = Float<W>;
    if (of.isBlack()) return;
    const Lights<W> k(of);
    F x, y, a, b;
    concentricDisk(in.u0, in.u1, x, y);
    out.o = fma(k.rows[0], x * F(kRadius), fma(k.rows[1], y * F(kRadius), k.center));
    out.N = k.normal;
    // cosine-weighted within the cone
    concentricDisk(in.u2, in.u3, a, b);
    a *= k.sinCone;
    b *= k.sinCone;
    const F cosine = safeSqrt(fnma(a, a, fnma(b, b, F(1.f))));
    out.d = Frame<W>(out.N).toWorld({a, b, cosine});
    out.pdfPosition = F(1.f) / k.area;
    out.pdfDirection = cosine * (F(kInvPi) / (k.sinCone * k.sinCone));
    out.radiance = radiance<W>(k, cosine);
  }

  template <int W>
  static KN_INLINE void densities(const LightOf<Data, W>& of, const LightRay<W>& ray, LightDensities<W>& out) {
    if (of.isBlack()) return;
    const Lights<W> k(of);
    out.N = k.normal;
    out.pdfPosition = Float<W>(1.f) / k.area;
    out.pdfDirection = coneDensity<W>(-dot(ray.d, k.normal), k.sinCone);
  }
};

KINORA_KERNELS_END

KINORA_LIGHT(PxrDiskLight,
             .help =
                 "Disk of radius 0.5 in the local XY plane (an ellipse when scaled unevenly), emitting to the side "
                 "of local +Z.",
             .params = kParams, .setUp = setUpBy<make>, .describe = describe, .irradiance = irradiance)
