// Distortion of lenses (PxrCamera): what an ideal lens shows at p of the screen, counted from the distortion's centre, is
// shown at q = (x (1 + a r^2 + c r^4), y (1 + b r^2 + c r^4)), r = |p|: the even polynomial of D. C. Brown, "Decentering
// distortion of lenses" (1966), with a coefficient of the square for each axis. Above 0 they make cushions, below 0
// barrels, which show no more than a disk: what is farther out would be shown a second time, folded back. Included per
// target.
#ifndef KINORA_LENS_DISTORTION_BEFORE
#define KINORA_LENS_DISTORTION_BEFORE
#include <algorithm>
#include <cmath>
#endif
#include <kinora/math/elementary.h>

#ifndef KINORA_LENS_DISTORTION_ONCE
#define KINORA_LENS_DISTORTION_ONCE
namespace kinora {
struct LensDistortion {
  bool isThere = false;
  float square[2] = {0, 0}, fourth = 0, center[2] = {0, 0};
  float limit = 1e9f;  // of r, where the polynomial turns back first

  void set(double a, double b, double c, double x, double y) {
    isThere = a != 0 || b != 0 || c != 0;
    square[0] = float(a);
    square[1] = float(b);
    fourth = float(c);
    center[0] = float(x);
    center[1] = float(y);
    for (const double s : {a, b}) {
      // the smallest root of 1 + 3 s t + 5 c t^2, t = r^2
      double t = 1e18;
      if (c == 0) {
        if (s < 0) t = -1 / (3 * s);
      } else if (const double d = 9 * s * s - 20 * c; d >= 0) {
        for (const double sign : {-1., 1.})
          if (const double root = (-3 * s + sign * std::sqrt(d)) / (10 * c); root > 0) t = std::min(t, root);
      }
      limit = std::min(limit, float(std::sqrt(t)));
    }
  }
};
}  // namespace kinora
#endif

#if defined(KINORA_LENS_DISTORTION_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LENS_DISTORTION_H_TARGET
#undef KINORA_LENS_DISTORTION_H_TARGET
#else
#define KINORA_LENS_DISTORTION_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
struct DistortedPlace {
  Float<W> x, y;
  Float<W> area;  // of the picture there over that of an ideal lens; 0 and below: what is there is not shown
  KN_INLINE DistortedPlace() {}
};

// Where a place of the ideal picture is shown, both of the whole screen.
template <int W>
KN_INLINE DistortedPlace<W> distorted(const LensDistortion& k, Float<W> x, Float<W> y) {
  using F = Float<W>;
  const F a(k.square[0]), b(k.square[1]), c(k.fourth), one(1.f), two(2.f);
  x = x - F(k.center[0]);
  y = y - F(k.center[1]);
  const F r2 = fma(x, x, y * y), r4 = c * r2 * r2;
  const F fx = fma(a, r2, one + r4), fy = fma(b, r2, one + r4);
  // d(factor) / d(r^2)
  const F gx = fma(two * c, r2, a), gy = fma(two * c, r2, b);
  const F xx = fma(two * gx, x * x, fx), yy = fma(two * gy, y * y, fy), xy = two * gx * x * y, yx = two * gy * x * y;
  DistortedPlace<W> out;
  out.x = fma(x, fx, F(k.center[0]));
  out.y = fma(y, fy, F(k.center[1]));
  const F area = fms(xx, yy, xy * yx);
  out.area = zeroUnless(r2 < F(k.limit) * F(k.limit), area);
  return out;
}

// The inverse, by Newton's method: out.x, out.y of the ideal picture; area as above, 0 where nothing is shown.
template <int W>
KN_INLINE DistortedPlace<W> undistorted(const LensDistortion& k, Float<W> x, Float<W> y) {
  using F = Float<W>;
  const F a(k.square[0]), b(k.square[1]), c(k.fourth), one(1.f), two(2.f), most(k.limit);
  x = x - F(k.center[0]);
  y = y - F(k.center[1]);
  // along the ray from the centre a starting point within the limit
  const F far = max(sqrt(fma(x, x, y * y)), F(1e-30f)), start = min(far, most * F(0.9f)) / far;
  F px = x * start, py = y * start, area(0.f);
  for (int step = 0; step < 12; ++step) {
    const F r2 = fma(px, px, py * py), r4 = c * r2 * r2;
    const F fx = fma(a, r2, one + r4), fy = fma(b, r2, one + r4);
    const F gx = fma(two * c, r2, a), gy = fma(two * c, r2, b);
    const F xx = fma(two * gx, px * px, fx), yy = fma(two * gy, py * py, fy);
    const F xy = two * gx * px * py, yx = two * gy * px * py;
    area = fms(xx, yy, xy * yx);
    const F inverse = one / select(area > F(1e-6f), area, F(1e-6f));
    const F ex = fma(px, fx, -x), ey = fma(py, fy, -y);
    px = px - fms(yy, ex, xy * ey) * inverse;
    py = py - fms(xx, ey, yx * ex) * inverse;
    // a step too far comes back
    const F r = max(sqrt(fma(px, px, py * py)), F(1e-30f)), back = min(r, most) / r;
    px = px * back;
    py = py * back;
  }
  DistortedPlace<W> out;
  out.x = px + F(k.center[0]);
  out.y = py + F(k.center[1]);
  const DistortedPlace<W> there = distorted<W>(k, out.x, out.y);
  const F ex = there.x - (x + F(k.center[0])), ey = there.y - (y + F(k.center[1]));
  out.area = zeroUnless(fma(ex, ex, ey * ey) < F(1e-8f) * fma(far, far, one), there.area);
  return out;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
