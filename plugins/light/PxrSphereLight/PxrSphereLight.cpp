// PxrSphereLight: the local sphere of radius 0.5, emitting outwards. Any affine placement: everything happens in
// local space, where the light is round; a direction's density is carried over by the Jacobian of the normalised
// linear map, |det M| / |l M|^3 for a unit local direction l. So ellipsoids are sampled within exactly the cone they
// fill, too. Inside it is dark: its surface emits outwards only, as its power and its light paths have it.
#define KINORA_KERNEL_FILE "plugins/light/PxrSphereLight/PxrSphereLight.cpp"
#include <kinora/light_setup.h>
#include <memory>
#include <kinora/light_author.h>

#include "plugins/light/parts/solid.h"

#if KINORA_PLAIN
namespace kinora::pxrSphereLight {
using namespace lightParts;
constexpr auto kParams =
    joinParams(lightParams::kRadiance, lightParams::kNormalize, lightParams::kShaping, lightParams::kControl);
constexpr float kRadius = 0.5f;  // local

// What samples read stands in the first two lines of the cache: among many lights each is another one's.
struct alignas(64) Data {
  Float3 rows[3];     // local to render, linear part
  Float3 inverse[3];  // render to local: rows of the inverse
  Float3 center;
  float determinant = 1;  // absolute
  LightCommon common;
  bool isShaped = false, isBlack = true;
  Shaping shaping;
  Float3 axis;           // unit, local +Z
  Float3 normalRows[3];  // local normal to render: rows of the inverse transpose
  float rounding = 0;    // of a local direction that went to render space and back, generously
  double area = 0, boundingRadius = 0, sphereRadius = 0;  // sphereRadius: 0 for ellipsoids
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  const LocalFrame f = LocalFrame::of(info);
  auto light = std::make_unique<Data>();
  light->center = Float3(f.origin);
  const SolidFrame frame(f);
  if (!frame.isDegenerate) {
    frame.place(*light);
    light->rounding = frame.rounding(4e-7);
    const double lx = frame.lengths[0], ly = frame.lengths[1], lz = frame.lengths[2];
    light->boundingRadius = 0.5 * std::sqrt(lx * lx + ly * ly + lz * lz);
    const bool round = frame.keepsShape();
    const Double3* const normals = frame.normals;
    // surface: the integral of |det M| |n M^-T| over the local sphere
    constexpr int kRings = 512, kSteps = 128;
    double sum = 0;
    for (int i = 0; i < kRings && !round; ++i)
      for (int j = 0; j < kSteps; ++j) {
        const double z = (2.0 * i + 1) / kRings - 1, s = std::sqrt(1 - z * z);
        const double phi = 6.283185307179586 * (j + 0.5) / kSteps;
        sum += length(normals[0] * (s * std::cos(phi)) + normals[1] * (s * std::sin(phi)) + normals[2] * z);
      }
    light->area = 3.14159265358979 * std::fabs(frame.determinant) * sum / (kRings * kSteps);
    if (round) {
      light->sphereRadius = light->boundingRadius = 0.5 * lx;
      light->area = 3.14159265358979 * lx * lx;
    }
  }
  setSolidLight(values, frame, *light);
  light->isShaped = light->shaping.focused || light->shaping.coned;
  return light;
}

// pi L (r / d)^2 cos for a sphere wholly above the receiver's horizon; -1 for other cases.
double irradiance(const void* data, const double P[3], const double N[3]) {
  const Data& k = *static_cast<const Data*>(data);
  if (k.isBlack) return 0;
  if (k.shaping.focused || k.shaping.coned || k.sphereRadius == 0) return -1;
  const Double3 to = Double3{k.center.x, k.center.y, k.center.z} - Double3{P[0], P[1], P[2]};
  const double d = length(to), height = dot(to, normalized({N[0], N[1], N[2]}));
  if (d <= k.sphereRadius || height <= -k.sphereRadius) return 0;
  if (height < k.sphereRadius) return -1;
  const double mean = (double(k.common.radiance[0]) + k.common.radiance[1] + k.common.radiance[2]) / 3;
  return 3.14159265358979 * mean * k.sphereRadius * k.sphereRadius * height / (d * d * d);
}
}  // namespace kinora::pxrSphereLight
#endif

KINORA_KERNELS_BEGIN
using namespace pxrSphereLight;

// Of each lane's light.
template <int W>
struct Lights {
  const LightOf<Data, W>& of;
  Vec3<W> center, axis, rows[3], inverse[3], normalRows[3];
  Float<W> determinant, rounding;
  KN_INLINE explicit Lights(const LightOf<Data, W>& k)
      : of(k),
        center(k(&Data::center)),
        axis(k(&Data::axis)),
        determinant(k(&Data::determinant)),
        rounding(k(&Data::rounding)) {
    for (int i = 0; i < 3; ++i) {
      rows[i] = k.vector([i](const Data& d) -> const Float3& { return d.rows[i]; });
      inverse[i] = k.vector([i](const Data& d) -> const Float3& { return d.inverse[i]; });
      normalRows[i] = k.vector([i](const Data& d) -> const Float3& { return d.normalRows[i]; });
    }
  }
};

template <int W>
KN_INLINE Vec3<W> times(Vec3<W> v, const Vec3<W> m[3]) {
  return fma(m[0], v.x, fma(m[1], v.y, m[2] * v.z));
}

// The sphere from a point, in local space.
template <int W>
struct View {
  Vec3<W> fromCenter;  // the point
  Float<W> d2;
  Float<W> oneMinusCos;  // of the cone's half angle
  Mask<W> outside;
  KN_INLINE View(const Lights<W>& k, Vec3<W> P) {
    using F = Float<W>;
    fromCenter = times<W>(P - k.center, k.inverse);
    d2 = dot(fromCenter, fromCenter);
    const F r2(kRadius * kRadius);
    outside = d2 > r2;
    const F sin2 = r2 / max(d2, r2);
    oneMinusCos = sin2 / (F(1.f) + safeSqrt(F(1.f) - sin2));
  }
  // Density over directions of render space; stretch = |l M| of the unit local direction.
  KN_INLINE Float<W> density(const Lights<W>& k, Float<W> stretch) const {
    using F = Float<W>;
    return zeroUnless(outside, stretch * stretch * stretch / (F(kTwoPi) * k.determinant * oneMinusCos));
  }
};

struct PxrSphereLight {
  using Data = pxrSphereLight::Data;
  static constexpr bool kIntersects = true, kMixes = true;

  template <int W>
  static KN_INLINE Rgb<W> radiance(const Lights<W>& k, Vec3<W> towardsLight) {
    const Rgb<W> l = k.of.rgb([](const Data& d) { return d.common.radiance; });
    if (!k.of.any([](const Data& d) { return d.isShaped; })) return l;
    return l * shape(k.of, -dot(towardsLight, k.axis));
  }

  template <int W>
  static KN_INLINE void sample(const LightOf<Data, W>& of, const LightPoint<W>& in, LightSample<W>& out) {
    using F = Float<W>;
    if (of.isBlack()) return;
    const Lights<W> k(of);
    const View<W> view(k, in.P);
    const F d = sqrt(view.d2);
    const Frame<W> cone(view.fromCenter * (F(-1.f) / max(d, F(1e-30f))));
    const Vec3<W> inCone = uniformCone(in.u, in.v, view.oneMinusCos);
    const Vec3<W> local = cone.toWorld(inCone);
    const Vec3<W> w = times<W>(local, k.rows);
    const F stretch = length(w);
    // first hit: d cos - sqrt(r^2 - d^2 sin^2), with the sine from the cone's own coordinates
    const F sin2 = fma(inCone.x, inCone.x, inCone.y * inCone.y);
    const F tLocal = fms(d, inCone.z, safeSqrt(fnma(view.d2, sin2, F(kRadius * kRadius))));
    out.wi = w * (F(1.f) / max(stretch, F(1e-30f)));
    out.distance = max(tLocal, F(1e-20f)) * stretch;
    out.pdf = view.density(k, stretch);
    out.radiance = radiance<W>(k, out.wi);
  }

  // Stable form of the quadratic: discriminant from the ray's distance to the centre (Haines et al., Ray Tracing Gems
  // 7).
  template <int W>
  static KN_INLINE Mask<W> intersect(const LightOf<Data, W>& of, Vec3<W> o, Vec3<W> d, Float<W>& t) {
    using F = Float<W>;
    if (of.isBlack()) return Mask<W>(false);
    const Lights<W> k(of);
    const Vec3<W> f = times<W>(o - k.center, k.inverse), l = times<W>(d, k.inverse);
    const F a = dot(l, l), b = -dot(f, l);
    const Vec3<W> nearest = fma(l, b / max(a, F(1e-37f)), f);
    const F room = F(kRadius * kRadius) - dot(nearest, nearest);
    const F c = dot(f, f) - F(kRadius * kRadius);
    const F q = fma(sqrt(max(a * room, F(0.f))), F(1.f), b);  // b > 0 for a sphere ahead
    const F at = c / max(q, F(1e-37f));
    const Mask<W> hit = (room >= F(0.f)) & (c > F(0.f)) & (b > F(0.f)) & (at < t);
    t = select(hit, at, t);
    return hit;
  }

  template <int W>
  static KN_INLINE void evaluate(const LightOf<Data, W>& of, const LightRay<W>& ray, Rgb<W>& l, Float<W>& pdf) {
    using F = Float<W>;
    if (of.isBlack()) return;
    const Lights<W> k(of);
    const View<W> view(k, ray.o);
    const Vec3<W> local = times<W>(ray.d, k.inverse);
    const F inverseStretch = length(local);  // |d M^-1| = 1 / |l M|
    const Vec3<W> unit = local * (F(1.f) / max(inverseStretch, F(1e-37f)));
    const F along = -dot(view.fromCenter, unit);
    const Vec3<W> nearest = fma(unit, along, view.fromCenter);
    // directions made by sample() may miss the rim by rounding, which grows with the distance
    const F rim = fma(sqrt(view.d2), k.rounding, F(kRadius * (1 + 5e-5f)));
    const Mask<W> hit = view.outside & (along > F(0.f)) & (dot(nearest, nearest) <= rim * rim);
    l = zeroUnless(hit, radiance<W>(k, ray.d));
    pdf = zeroUnless(hit, view.density(k, F(1.f) / max(inverseStretch, F(1e-37f))));
  }

  template <int W>
  static KN_INLINE void emit(const LightOf<Data, W>& of, const EmitInput<W>& in, LightEmission<W>& out) {
    using F = Float<W>;
    if (of.isBlack()) return;
    const Lights<W> k(of);
    const Vec3<W> n = uniformSphere(in.u0, in.u1);
    out.o = times<W>(n * F(kRadius), k.rows) + k.center;
    const Vec3<W> normal = times<W>(n, k.normalRows);
    const F stretch = length(normal);
    out.N = normal * (F(1.f) / max(stretch, F(1e-30f)));
    const Vec3<W> c = cosineHemisphere(in.u2, in.u3);
    out.d = Frame<W>(out.N).toWorld(c);
    // an element of local area grows by |det M| |n M^-T|
    out.pdfPosition = F(1.f / (4 * kPi * kRadius * kRadius)) / (k.determinant * stretch);
    out.pdfDirection = c.z * F(kInvPi);
    out.radiance = radiance<W>(k, -out.d);
  }

  template <int W>
  static KN_INLINE void densities(const LightOf<Data, W>& of, const LightRay<W>& ray, LightDensities<W>& out) {
    using F = Float<W>;
    if (of.isBlack()) return;
    const Lights<W> k(of);
    const Vec3<W> local = times<W>(fma(ray.d, ray.t, ray.o - k.center), k.inverse);
    const Vec3<W> normal = times<W>(local * (F(1.f) / max(length(local), F(1e-30f))), k.normalRows);
    const F stretch = length(normal);
    out.N = normal * (F(1.f) / max(stretch, F(1e-30f)));
    out.pdfPosition = F(1.f / (4 * kPi * kRadius * kRadius)) / (k.determinant * stretch);
    out.pdfDirection = max(-dot(out.N, ray.d), F(0.f)) * F(kInvPi);
  }
};

KINORA_KERNELS_END

KINORA_LIGHT(PxrSphereLight,
             .help =
                 "Sphere of local radius 0.5 (an ellipsoid when scaled unevenly), emitting outwards. Focus and cone "
                 "are measured from local +Z; a coneAngle of 90, the default, cuts nothing.",
             .params = kParams, .setUp = setUpBy<make>, .describe = describeSolidLight<Data>,
             .irradiance = irradiance)
