// What projections share: the screen window, the thin lens with its way back, and the runner that turns a struct with
// functions over W samples into the tables of projection.h. Included per target.
//
//   struct MyProjection {
//     using Data = ...;
//     template <int W> static void rays(const Data&, const CameraSample<W>&, CameraRay<W>& out);
//     template <int W> static void connect(const Data&, const CameraPoint<W>&, CameraLink<W>& out);
//   };
//   KINORA_PROJECTION(MyProjection, .help = "...", .params = kParams, .setUp = setUp<Data>)
//
// Importance and density, as light tracing needs them. A pixel's value is the mean over its raster square of the
// radiance along rays(): I = integral of L dx dy over one square pixel. With a lens point fixed and theta the angle
// of the ray to the view axis, a pixel covers A = (pixel width)(pixel height) on the screen plane at unit distance,
// and there dx dy = dw / (A cos^3 theta). So
//   pdf = 1 / (A cos^3 theta)           per solid angle, for one sample placed evenly in the pixel that is met; divide
//                                       by the number of pixels for a sample placed evenly in the whole picture
//   importance = 1 / (A cos^3 theta)    We cos theta of I = integral of We L cos theta dw; the lens point's density has
//                                       cancelled
// A splat from a point X at distance r is then f(X) * importance * cos(at X) / r^2, and the mean of L * weight over a
// pixel's samples equals the sum of splats over the number of light paths. Both numbers are dx dy / dw for any
// projection, whatever it calls its axis, where rays come from one point for each lens sample. This holds for
// every lens point of a thin lens: the raster maps linearly to a plane of focus that faces the camera, whose scale
// cancels; tilted ones divide both by a determinant (ThinLensProjection).
#include <kinora/projection_setup.h>
#ifdef KINORA_KERNEL_FILE
#include <kinora/simd/foreach_target.h>
#endif
#include <kinora/math/sampling.h>

#if defined(KINORA_PROJECTION_AUTHOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PROJECTION_AUTHOR_H_TARGET
#undef KINORA_PROJECTION_AUTHOR_H_TARGET
#else
#define KINORA_PROJECTION_AUTHOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
struct CameraSample {
  Float<W> x, y, lensU, lensV, time;
  KN_INLINE CameraSample() {}
};
template <int W>
struct CameraRay {
  Vec3<W> o, d;
  Float<W> weight, radius, spread;
  KN_INLINE CameraRay() {}
};
template <int W>
struct CameraPoint {
  Vec3<W> P;
  Float<W> lensU, lensV, time;
  KN_INLINE CameraPoint() {}
};
template <int W>
struct CameraLink {
  Vec3<W> o;
  Float<W> x, y, importance, pdf;
  KN_INLINE CameraLink() {}
};

// Raster to screen plane and back.
template <int W>
KN_INLINE void toScreen(const ScreenMap& m, Float<W> x, Float<W> y, Float<W>& sx, Float<W>& sy) {
  using F = Float<W>;
  const F a = fma(x, F(m.stepX), F(m.left)), b = fnma(y, F(m.stepY), F(m.top));
  sx = fms(a, F(m.cosRoll), b * F(m.sinRoll));
  sy = fma(a, F(m.sinRoll), b * F(m.cosRoll));
}
template <int W>
KN_INLINE void toRaster(const ScreenMap& m, Float<W> sx, Float<W> sy, Float<W>& x, Float<W>& y) {
  using F = Float<W>;
  const F a = fma(sx, F(m.cosRoll), sy * F(m.sinRoll)), b = fms(sy, F(m.cosRoll), sx * F(m.sinRoll));
  x = (a - F(m.left)) / F(m.stepX);
  y = (F(m.top) - b) / F(m.stepY);
}
template <int W>
KN_INLINE Mask<W> insideRaster(const ScreenMap& m, Float<W> x, Float<W> y) {
  using F = Float<W>;
  return (x >= F(0.f)) & (x < F(m.width)) & (y >= F(0.f)) & (y < F(m.height));
}

// A thin lens at the eye, sharp on a plane; a pinhole where its radius is 0. With q = dot(sharp, D) the ray of D,
// whose z is 1, through the middle of the lens is sharp at distance 1 / q, and D - o q is its ray through the lens
// point o. Where the plane lies behind (q < 0) the ray is sharp at infinity. Tilted planes scale areas of directions
// by the determinant of D -> D - o q, which is 1 - dot(sharp, o) (o.z = 0).
struct ThinLensProjection {
  using Data = ThinLens;

  template <int W>
  static KN_INLINE Float<W> perFocus(const ThinLens& k, const Vec3<W>& d) {
    using F = Float<W>;
    return max(fma(d.x, F(k.sharp[0]), fma(d.y, F(k.sharp[1]), d.z * F(k.sharp[2]))), F(0.f));
  }

  template <int W>
  static KN_INLINE Float<W> scale(const ThinLens& k, Float<W> time) {
    using F = Float<W>;
    if (!k.zooms) return F(k.scale);
    return tan(lerp(F(k.halfFov[0]), F(k.halfFov[1]), time));
  }
  template <int W>
  static KN_INLINE Vec3<W> lensPoint(const ThinLens& k, Float<W> u, Float<W> v) {
    using F = Float<W>;
    Vec3<W> o;
    if (k.lensRadius > 0) {
      if (k.aperture.isShaped)
        shapedPoint<W>(k.aperture, u, v, o.x, o.y);
      else
        concentricDisk(u, v, o.x, o.y);
      o.x *= F(k.lensRadius * k.aperture.stretch);
      o.y *= F(k.lensRadius);
    }
    return o;
  }
  template <int W>
  static KN_INLINE Float<W> lookUp(const float* table, Float<W> share) {
    using F = Float<W>;
    const F at = clamp(share, F(0.f), F(1.f)) * F(float(Aperture::kSteps)), below = floor(at);
    const Int<W> i = toInt(below);
    return lerp(gather(table, i), gather(table + 1, i), at - below);
  }
  template <int W>
  static KN_INLINE void shapedPoint(const Aperture& a, Float<W> u, Float<W> v, Float<W>& x, Float<W>& y) {
    using F = Float<W>;
    const F sides(a.sides), place = u * sides, which = min(floor(place), sides - F(1.f));
    const F off = lookUp<W>(a.side, place - which);
    F r = lookUp<W>(a.rho, sqrt(v)), s, c;
    if (a.sides >= 3) {
      sincos(off, s, c);
      r *= fma(F(a.inset) / c - F(1.f), F(1.f - a.roundness), F(1.f));
    }
    sincos(fma(which, F(kTwoPi / a.sides), off) + F(a.angle), s, c);
    x = r * c;
    y = r * s;
  }
  template <int W>
  static KN_INLINE void rays(const ThinLens& k, const CameraSample<W>& in, CameraRay<W>& out) {
    using F = Float<W>;
    F sx, sy;
    toScreen(k.screen, in.x, in.y, sx, sy);
    const F s = scale<W>(k, in.time);
    Vec3<W> d(sx * s, sy * s, F(1.f));
    if (k.lensRadius > 0) {
      out.o = lensPoint<W>(k, in.lensU, in.lensV);
      d = d - out.o * perFocus(k, d);
    }
    const F cosine = F(1.f) / length(d);
    out.d = d * cosine;
    out.weight = F(1.f);
    out.radius = F(0.f);
    // half the side of a square of the pixel's solid angle A cos^3
    out.spread = F(0.5f) * s * sqrt(F(k.screen.pixelArea()) * cosine * cosine * cosine);
  }
  template <int W>
  static KN_INLINE void connect(const ThinLens& k, const CameraPoint<W>& in, CameraLink<W>& out) {
    connectAnywhere<W>(k, in, out);
    out.pdf = zeroUnless(insideRaster(k.screen, out.x, out.y), out.pdf);
    out.importance = out.pdf;
  }
  // The same whether or not the picture reaches so far.
  template <int W>
  static KN_INLINE void connectAnywhere(const ThinLens& k, const CameraPoint<W>& in, CameraLink<W>& out) {
    using F = Float<W>;
    out.o = lensPoint<W>(k, in.lensU, in.lensV);
    const Vec3<W> to = in.P - out.o;
    const F s = scale<W>(k, in.time), invZ = F(1.f) / max(to.z, F(1e-30f));
    // direction of unit z; the raster point is where it meets the plane of focus, scaled to unit distance
    const F dx = to.x * invZ, dy = to.y * invZ;
    F q(0.f), determinant(1.f);
    if (k.lensRadius > 0) {
      const F whole = fnma(out.o.x, F(k.sharp[0]), fnma(out.o.y, F(k.sharp[1]), F(1.f)));
      q = perFocus(k, Vec3<W>(dx, dy, F(1.f))) / whole;
      determinant = select(q > F(0.f), whole, F(1.f));
    }
    toRaster(k.screen, fma(out.o.x, q, dx) / s, fma(out.o.y, q, dy) / s, out.x, out.y);
    Mask<W> seen = to.z > F(1e-30f);
    if (k.farClip > 0) seen &= (in.P.z >= F(k.nearClip)) & (in.P.z <= F(k.farClip));
    const F secant2 = fma(dx, dx, fma(dy, dy, F(1.f)));  // 1 / cos^2
    const F perArea = F(1.f) / (s * s * F(k.screen.pixelArea()) * determinant);
    out.pdf = zeroUnless(seen, perArea * secant2 * sqrt(secant2));
    out.importance = out.pdf;
  }
};

template <class P>
struct ProjectionRunner {
  using Data = typename P::Data;
  template <int W>
  static void rays(const void* projection, const CameraSampleArgs* a) {
    using F = Float<W>;
    const Data& k = *static_cast<const Data*>(projection);
    for (uint32_t i = 0; i < a->count; i += W) {
      CameraSample<W> in;
      in.x = F::load(a->raster[0] + i);
      in.y = F::load(a->raster[1] + i);
      in.lensU = a->lens[0] ? F::load(a->lens[0] + i) : F(0.5f);
      in.lensV = a->lens[1] ? F::load(a->lens[1] + i) : F(0.5f);
      in.time = a->time ? F::load(a->time + i) : F(0.f);
      CameraRay<W> r;
      P::template rays<W>(k, in, r);
      r.o.store(a->o, i);
      r.d.store(a->d, i);
      r.weight.store(a->weight + i);
      r.radius.store(a->radius + i);
      r.spread.store(a->spread + i);
    }
  }
  template <int W>
  static void connect(const void* projection, const CameraConnectArgs* a) {
    using F = Float<W>;
    const Data& k = *static_cast<const Data*>(projection);
    for (uint32_t i = 0; i < a->count; i += W) {
      CameraPoint<W> in;
      in.P = Vec3<W>::load(a->P, i);
      in.lensU = a->lens[0] ? F::load(a->lens[0] + i) : F(0.5f);
      in.lensV = a->lens[1] ? F::load(a->lens[1] + i) : F(0.5f);
      in.time = a->time ? F::load(a->time + i) : F(0.f);
      CameraLink<W> l;
      P::template connect<W>(k, in, l);
      const Mask<W> good = isFinite(in.P) & isFinite(l.importance) & isFinite(l.pdf) & (l.importance > F(0.f));
      zeroUnless(isFinite(l.o), l.o).store(a->o, i);
      zeroUnless(good, l.x).store(a->raster[0] + i);
      zeroUnless(good, l.y).store(a->raster[1] + i);
      zeroUnless(good, l.importance).store(a->importance + i);
      zeroUnless(good, l.pdf).store(a->pdf + i);
    }
  }
  template <int W>
  static constexpr ProjectionFunctions table() {
    return {&rays<W>, &connect<W>};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif

#include <kinora/simd/tables.h>

// Ends the file of a plug-in, whose struct has its name.
#undef KINORA_PROJECTION
#define KINORA_PROJECTION(Name, ...) KINORA_PLUGIN(Name, ProjectionRunner<Name>, ProjectionPlugin, __VA_ARGS__)
