// Sampling, hits and emission of rectangles whose radiance a light decides. Sampled by solid angle with the spherical
// rectangle of Urena, Fajardo and King, "An Area-Preserving Parametrization for Spherical Rectangles" (EGSR 2013); by
// area where the placement shears it, and where it appears so small that the four angles of the spherical rectangle
// cancel in single precision. Included per target, behind light_author.h.
#include "plugins/light/parts/rectangle.h"

#if defined(KINORA_RECTANGLE_KERNEL_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_RECTANGLE_KERNEL_H_TARGET
#undef KINORA_RECTANGLE_KERNEL_H_TARGET
#else
#define KINORA_RECTANGLE_KERNEL_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Of each lane's light.
template <class Data, int W>
struct RectangleLanes {
  const LightOf<Data, W>& of;
  Vec3<W> center, edgeX, edgeY, unitX, unitY, normal, dualX, dualY;
  Float<W> halfX, halfY, area, sinCone;
  Mask<W> isRectangle;
  KN_INLINE explicit RectangleLanes(const LightOf<Data, W>& k)
      : of(k),
        center(k(&Data::center)),
        edgeX(k(&Data::edgeX)),
        edgeY(k(&Data::edgeY)),
        unitX(k(&Data::unitX)),
        unitY(k(&Data::unitY)),
        normal(k(&Data::normal)),
        dualX(k(&Data::dualX)),
        dualY(k(&Data::dualY)),
        halfX(k(&Data::halfX)),
        halfY(k(&Data::halfY)),
        area(k(&Data::area)),
        sinCone(k.number([](const Data& d) { return d.shaping.sinCone; })),
        isRectangle(k(&Data::isRectangle)) {}
};

// The spherical rectangle seen from a point: names follow the paper, z0 < 0.
template <int W>
struct SphericalRectangle {
  Float<W> x0, x1, y0, y1, z0, solidAngle;
  Float<W> k;  // less pi
  Mask<W> front, byArea;
  template <class Data>
  KN_INLINE SphericalRectangle(const RectangleLanes<Data, W>& light, Vec3<W> P) {
    using F = Float<W>;
    const Vec3<W> toPoint = P - light.center;
    const F px = dot(toPoint, light.unitX), py = dot(toPoint, light.unitY);
    z0 = -dot(toPoint, light.normal);
    front = z0 < F(0.f);
    x0 = -px - light.halfX;
    x1 = -px + light.halfX;
    y0 = -py - light.halfY;
    y1 = -py + light.halfY;
    byArea = Mask<W>(true);
    if (light.isRectangle.none()) return;
    // The paper's four angles are pi/2 plus or minus atan(x y / (|z| r)) at the corners, r their distances. Arc
    // cosines of the edges' normals, as it has them, lose half their digits near the rectangle's plane.
    const F z2 = max(z0 * z0, F(1e-30f)), z = sqrt(z2);
    const F a00 = cornerAngle(x0, y0, z, z2), a10 = cornerAngle(x1, y0, z, z2);
    const F a01 = cornerAngle(x0, y1, z, z2), a11 = cornerAngle(x1, y1, z, z2);
    k = a01 - a00;
    solidAngle = (a11 - a10) - (a01 - a00);
    byArea = !(light.isRectangle & (solidAngle >= F(lightParts::kLeastSolidAngle)));
  }
  static KN_INLINE Float<W> cornerAngle(Float<W> x, Float<W> y, Float<W> z, Float<W> z2) {
    return atan(x * y / (z * sqrt(fma(x, x, fma(y, y, z2)))));
  }
  // h(y) = y / sqrt(y^2 + d^2) at both ends, as 1 + h0, 1 - h1 and h1 - h0, each without the loss of digits of their
  // differences where d is small beside y.
  static KN_INLINE void ends(Float<W> y0, Float<W> y1, Float<W> d2, Float<W>& above0, Float<W>& below1,
                             Float<W>& range) {
    using F = Float<W>;
    const F zero(0.f), one(1.f), l0 = sqrt(max(fma(y0, y0, d2), F(1e-30f))),
                                 l1 = sqrt(max(fma(y1, y1, d2), F(1e-30f)));
    const F c0 = d2 / max(l0 * (l0 + abs(y0)), F(1e-37f)), c1 = d2 / max(l1 * (l1 + abs(y1)), F(1e-37f));  // 1 - |h|
    above0 = select(y0 < zero, c0, one + y0 / l0);
    below1 = select(y1 > zero, c1, one - y1 / l1);
    range = select(y0 > zero, c0 - c1, select(y1 < zero, c1 - c0, y1 / l1 - y0 / l0));
  }
  // Point of the rectangle's plane, relative to P in the rectangle's frame (z is z0). The paper's formulas, written
  // in the angle less pi and in complements to 1, which keep their digits near the plane.
  KN_INLINE void sample(Float<W> u, Float<W> v, Float<W>& x, Float<W>& y) const {
    using F = Float<W>;
    const F z2 = max(z0 * z0, F(1e-30f)), tiny(1e-20f);
    F s, c, above0, below1, range;
    sincos(F(0.5f) * fma(u, solidAngle, k), s, c);
    ends(y0, y1, z2, above0, below1, range);
    // fu = (cos a b0 - b1) / sin a with a = phi + pi, b0 = -h0, b1 = h1
    const F l0 = max(fma(y0, y0, z2), F(1e-30f)), b0 = -y0 / sqrt(l0);
    F sine = F(2.f) * s * c;
    sine = select(abs(sine) > tiny, sine, copySign(tiny, sine));
    const F fu = fnma(b0 * F(2.f), s * s, range) / sine;
    x = copySign(sqrt(z2 / max(fms(fu, fu, z2 / l0), tiny)), fu);
    x = clamp(x, x0, x1);
    const F d2 = fma(x, x, z2);
    ends(y0, y1, d2, above0, below1, range);
    const F fromLow = fma(v, range, above0), fromHigh = fma(F(1.f) - v, range, below1);  // 1 + h, 1 - h
    const F h = select(fromLow < fromHigh, fromLow - F(1.f), F(1.f) - fromHigh);
    y = clamp(h * sqrt(d2 / max(fromLow * fromHigh, F(1e-30f))), y0, y1);
  }
};

// `Light` has
//   template <int W> static Rgb<W> radiance(const RectangleLanes<Data, W>&, Vec3<W> wi, Float<W> x, Float<W> y,
//                                           Float<W> cosine);
// towards -wi from the local position (x, y) in [-.5, .5]; `Data` is a Rectangle.
template <class Light, class DataOfLight>
struct RectangleLight {
  using Data = DataOfLight;
  static constexpr bool kIntersects = true, kMixes = true;
  template <int W>
  using Lanes = RectangleLanes<Data, W>;

  template <int W>
  static KN_INLINE void sample(const LightOf<Data, W>& of, const LightPoint<W>& in, LightSample<W>& out) {
    using F = Float<W>;
    if (of.isBlack()) return;
    const Lanes<W> k(of);
    const SphericalRectangle<W> r(k, in.P);
    F x = in.u - F(0.5f), y = in.v - F(0.5f);  // local position
    const Vec3<W> toCenter = k.center - in.P;
    Vec3<W> to = fma(k.edgeX, x, fma(k.edgeY, y, toCenter));
    if (!r.byArea.all()) {
      F sx, sy;
      r.sample(in.u, in.v, sx, sy);
      const Vec3<W> onSphere = fma(k.unitX, sx, fma(k.unitY, sy, k.normal * r.z0));
      to = select(r.byArea, to, onSphere);
      x = select(r.byArea, x, (sx - r.x0) / (F(2.f) * k.halfX) - F(0.5f));
      y = select(r.byArea, y, (sy - r.y0) / (F(2.f) * k.halfY) - F(0.5f));
    }
    const F d2 = dot(to, to), distance = sqrt(d2);
    out.wi = to * (F(1.f) / max(distance, F(1e-30f)));
    out.distance = distance;
    const F cosine = -dot(out.wi, k.normal);
    out.pdf = density(k, r, d2, cosine);
    out.radiance = Light::template radiance<W>(k, out.wi, x, y, cosine);
  }
  // Behind the light and in its plane there is none.
  template <int W>
  static KN_INLINE Float<W> density(const Lanes<W>& k, const SphericalRectangle<W>& r, Float<W> d2, Float<W> cosine) {
    using F = Float<W>;
    const F byArea = d2 / (max(cosine, F(1e-30f)) * k.area);
    return zeroUnless(r.front & (cosine > F(0.f)), select(r.byArea, byArea, F(1.f) / r.solidAngle));
  }

  // How far from the middle, in local units, a hit counts: half, and what rounding may take from a direction that
  // sample() made towards the edge; that grows with the distance.
  template <int W>
  static KN_INLINE Float<W> reach(const Lanes<W>& k, Float<W> t) {
    using F = Float<W>;
    return fma(t, F(1e-6f) / (F(2.f) * min(k.halfX, k.halfY)), F(0.5f + 1e-6f));
  }

  template <int W>
  static KN_INLINE Mask<W> intersect(const LightOf<Data, W>& of, Vec3<W> o, Vec3<W> d, Float<W>& t) {
    using F = Float<W>;
    if (of.isBlack()) return Mask<W>(false);
    const Lanes<W> k(of);
    const Vec3<W> n = k.normal, rel = o - k.center;
    const F falling = -dot(d, n), height = dot(rel, n);
    const F at = height / max(falling, F(1e-30f));
    const Vec3<W> p = fma(d, at, rel);
    const F x = dot(p, k.dualX), y = dot(p, k.dualY);
    const F slack = reach<W>(k, at);
    const Mask<W> hit = (falling > F(0.f)) & (height > F(0.f)) & (abs(x) <= slack) & (abs(y) <= slack) & (at < t);
    t = select(hit, at, t);
    return hit;
  }

  template <int W>
  static KN_INLINE void evaluate(const LightOf<Data, W>& of, const LightRay<W>& ray, Rgb<W>& l, Float<W>& pdf) {
    using F = Float<W>;
    if (of.isBlack()) return;
    const Lanes<W> k(of);
    const SphericalRectangle<W> r(k, ray.o);
    const F cosine = -dot(ray.d, k.normal);
    // the plane's distance, not the caller's: t may have been shortened by a ray offset
    const F t = -r.z0 / max(cosine, F(1e-30f));
    const Vec3<W> p = fma(ray.d, t, ray.o - k.center);
    const F x = dot(p, k.dualX), y = dot(p, k.dualY);
    const F slack = reach<W>(k, t);
    const Mask<W> hit = r.front & (cosine > F(0.f)) & (abs(x) <= slack) & (abs(y) <= slack);
    l = zeroUnless(hit, Light::template radiance<W>(k, ray.d, x, y, cosine));
    pdf = zeroUnless(hit, density(k, r, t * t, cosine));
  }

  template <int W>
  static KN_INLINE void emit(const LightOf<Data, W>& of, const EmitInput<W>& in, LightEmission<W>& out) {
    using F = Float<W>;
    if (of.isBlack()) return;
    const Lanes<W> k(of);
    const F x = in.u0 - F(0.5f), y = in.u1 - F(0.5f);
    const Vec3<W> n = k.normal;
    out.o = fma(k.edgeX, x, fma(k.edgeY, y, k.center));
    out.N = n;
    // cosine-weighted within the cone
    F a, b;
    concentricDisk(in.u2, in.u3, a, b);
    a *= k.sinCone;
    b *= k.sinCone;
    const F cosine = safeSqrt(fnma(a, a, fnma(b, b, F(1.f))));
    out.d = Frame<W>(n).toWorld({a, b, cosine});
    out.pdfPosition = F(1.f) / k.area;
    out.pdfDirection = cosine * (F(kInvPi) / (k.sinCone * k.sinCone));
    out.radiance = Light::template radiance<W>(k, -out.d, x, y, cosine);
  }

  template <int W>
  static KN_INLINE void densities(const LightOf<Data, W>& of, const LightRay<W>& ray, LightDensities<W>& out) {
    if (of.isBlack()) return;
    const Lanes<W> k(of);
    out.N = k.normal;
    out.pdfPosition = Float<W>(1.f) / k.area;
    out.pdfDirection = coneDensity<W>(-dot(ray.d, k.normal), k.sinCone);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
