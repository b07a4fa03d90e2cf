// The light author's layer: write one struct with functions over W points, and LightRunner turns it into the tables
// of light.h; it masks tails and drops samples without density, so that lights need not. Included per target, after
// light_setup.h.
//
//   struct MyLight {
//     using Data = ...;                                          // made by create()
//     static constexpr bool kIntersects = true;                  // false: infinite or delta
//     template <int W> static void sample(const Data&, const LightPoint<W>&, LightSample<W>& out);
//     template <int W> static Mask<W> intersect(const Data&, Vec3<W> o, Vec3<W> d, Float<W>& t);   // nearer than t
//     only template <int W> static void evaluate(const Data&, const LightRay<W>&, Rgb<W>& radiance, Float<W>& pdf);
//     template <int W> static void emit(const Data&, const EmitInput<W>&, LightEmission<W>& out);
//   };
#include <kinora/light_setup.h>
#include <kinora/math/sampling.h>

#if defined(KINORA_LIGHT_AUTHOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LIGHT_AUTHOR_H_TARGET
#undef KINORA_LIGHT_AUTHOR_H_TARGET
#else
#define KINORA_LIGHT_AUTHOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
struct LightPoint {
  Vec3<W> P;
  Float<W> u, v, time;
  KN_INLINE LightPoint() {}
};
template <int W>
struct LightSample {
  Vec3<W> wi;
  Float<W> distance, pdf;
  Rgb<W> radiance;
  Mask<W> delta;
  KN_INLINE LightSample() {}
};
template <int W>
struct LightRay {
  Vec3<W> o, d;
  Float<W> t, time;
  KN_INLINE LightRay() {}
};
template <int W>
struct EmitInput {
  Float<W> u0, u1, u2, u3, time;
  Vec3<W> worldCenter;
  Float<W> worldRadius;
  KN_INLINE EmitInput() {}
};
template <int W>
struct LightEmission {
  Vec3<W> o, d, N;
  Rgb<W> radiance;
  Float<W> pdfPosition, pdfDirection;
  KN_INLINE LightEmission() {}
};

template <int W>
KN_INLINE Vec3<W> wide(const Float3& a) {
  return {Float<W>(a.x), Float<W>(a.y), Float<W>(a.z)};
}
template <int W>
KN_INLINE Rgb<W> wideRgb(const float a[3]) {
  return {Float<W>(a[0]), Float<W>(a[1]), Float<W>(a[2])};
}

// Radiance factor of a light's shaping in a direction that makes this cosine with its axis.
template <int W>
KN_INLINE Rgb<W> shape(const Shaping& s, Float<W> cosine) {
  using F = Float<W>;
  Rgb<W> f(F(1.f), F(1.f), F(1.f));
  if (s.focused) {
    const F fall = zeroUnless(cosine > F(0.f), pow(max(cosine, F(0.f)), F(s.focus)));
    const Rgb<W> tint = wideRgb<W>(s.tint);
    f = lerp(tint, f, fall) * wideRgb<W>(s.scale);
  }
  if (s.coned) {
    const F theta = acos(cosine), width = F(s.coneEnd) - F(s.coneStart);
    const F t = select(width > F(0.f), clamp((theta - F(s.coneStart)) / max(width, F(1e-20f)), F(0.f), F(1.f)),
                       select(theta > F(s.coneEnd), F(1.f), F(0.f)));
    f = f * fnma(t * t, fnma(F(2.f), t, F(3.f)), F(1.f));
  }
  return f;
}

// Bilinear lookup; u in [0, 1] from left, v from top; texel centres at halves. Periodic in u or clamped; clamped in
// v.
template <int W, bool kPeriodic>
KN_INLINE Rgb<W> lookUp(const LightMap& m, Float<W> u, Float<W> v) {
  using F = Float<W>;
  using I = Int<W>;
  const F x = fma(u, F(float(m.width)), F(-0.5f)), y = fma(v, F(float(m.height)), F(-0.5f));
  const F fx = floor(x), fy = floor(y), ax = x - fx, ay = y - fy;
  const I lastX(m.width - 1), lastY(m.height - 1), none(0);
  // u and v may lie beyond the ends by rounding
  const F big(1.0e6f + 1.0e6f);
  I x0 = toInt(clamp(fx, -big, big)), x1 = x0 + I(1);
  I y0 = toInt(clamp(fy, -big, big)), y1 = y0 + I(1);
  if (kPeriodic) {
    x0 = select(x0 < none, x0 + I(m.width), x0);
    x0 = select(x0 > lastX, x0 - I(m.width), x0);
    x1 = select(x1 > lastX, x1 - I(m.width), x1);
  }
  x0 = select(x0 < none, none, select(x0 > lastX, lastX, x0));
  x1 = select(x1 < none, none, select(x1 > lastX, lastX, x1));
  y0 = select(y0 < none, none, select(y0 > lastY, lastY, y0));
  y1 = select(y1 < none, none, select(y1 > lastY, lastY, y1));
  const I stride(m.stride), row0 = y0 * I(m.width), row1 = y1 * I(m.width);
  const I i00 = (row0 + x0) * stride, i10 = (row0 + x1) * stride, i01 = (row1 + x0) * stride,
          i11 = (row1 + x1) * stride;
  Rgb<W> c;
  c.x = lerp(lerp(gather(m.texels, i00), gather(m.texels, i10), ax),
             lerp(gather(m.texels, i01), gather(m.texels, i11), ax), ay);
  const float* g = m.texels + m.green;
  c.y = lerp(lerp(gather(g, i00), gather(g, i10), ax), lerp(gather(g, i01), gather(g, i11), ax), ay);
  const float* b = m.texels + m.blue;
  c.z = lerp(lerp(gather(b, i00), gather(b, i10), ax), lerp(gather(b, i01), gather(b, i11), ax), ay);
  return c;
}

// Start of a light path from an infinite light: on the disk that faces the world sphere, outside of it.
template <int W>
KN_INLINE void emitFromDisk(const EmitInput<W>& in, Vec3<W> travel, LightEmission<W>& out) {
  using F = Float<W>;
  const F r = max(in.worldRadius, F(1e-6f));
  F x, y;
  concentricDisk(in.u0, in.u1, x, y);
  const Frame<W> f(travel);
  out.o = fma(f.x, x * r, fma(f.y, y * r, fma(travel, -r, in.worldCenter)));
  out.d = travel;
  out.N = travel;
  out.pdfPosition = F(1.f) / (F(kPi) * r * r);
}

template <class L>
struct LightRunner {
  using Data = typename L::Data;

  template <int W>
  static void sample(const void* light, const LightSampleArgs* a) {
    using F = Float<W>;
    const Data& k = *static_cast<const Data*>(light);
    for (uint32_t i = 0; i < a->count; i += W) {
      LightPoint<W> p;
      p.P = Vec3<W>::load(a->P, i);
      p.u = F::load(a->u[0] + i);
      p.v = F::load(a->u[1] + i);
      p.time = a->time ? F::load(a->time + i) : F(0.f);
      LightSample<W> s;
      L::template sample<W>(k, p, s);
      // a point that is not finite must not light others, nor a rounding accident
      const Mask<W> good =
          (s.pdf > F(0.f)) & isFinite(s.pdf) & isFinite(s.wi) & isFinite(s.radiance) & (s.distance > F(0.f));
      select(good, s.wi, Vec3<W>(F(0.f), F(0.f), F(1.f))).store(a->wi, i);
      zeroUnless(good, s.distance).store(a->distance + i);
      zeroUnless(good, s.radiance).store(a->radiance, i);
      zeroUnless(good, s.pdf).store(a->pdf + i);
      select(good & s.delta, Int<W>(uint32_t(kSampleDelta)), Int<W>(0)).store(a->flags + i);
    }
  }
  template <int W>
  static void intersect(const void* light, const LightRayArgs* a) {
    using F = Float<W>;
    const Data& k = *static_cast<const Data*>(light);
    for (uint32_t i = 0; i < a->count; i += W) {
      const F limit = F::load(a->t + i);
      F t = limit;
      Mask<W> hit = L::template intersect<W>(k, Vec3<W>::load(a->o, i), Vec3<W>::load(a->d, i), t);
      hit &= (t > F(0.f)) & (t < limit);
      select(hit, t, limit).store(a->t + i);
      select(hit, Int<W>(1), Int<W>(0)).store(a->hit + i);
    }
  }
  template <int W>
  static void evaluate(const void* light, const LightRayArgs* a) {
    using F = Float<W>;
    const Data& k = *static_cast<const Data*>(light);
    for (uint32_t i = 0; i < a->count; i += W) {
      LightRay<W> r;
      r.o = Vec3<W>::load(a->o, i);
      r.d = Vec3<W>::load(a->d, i);
      r.t = a->t ? F::load(a->t + i) : F(0.f);
      r.time = a->time ? F::load(a->time + i) : F(0.f);
      Rgb<W> radiance;
      F pdf;
      L::template evaluate<W>(k, r, radiance, pdf);
      const Mask<W> good = isFinite(radiance) & isFinite(pdf);
      zeroUnless(good, radiance).store(a->radiance, i);
      zeroUnless(good, pdf).store(a->pdf + i);
    }
  }
  template <int W>
  static void emit(const void* light, const LightEmitArgs* a) {
    using F = Float<W>;
    const Data& k = *static_cast<const Data*>(light);
    for (uint32_t i = 0; i < a->count; i += W) {
      EmitInput<W> in;
      in.u0 = F::load(a->u[0] + i);
      in.u1 = F::load(a->u[1] + i);
      in.u2 = F::load(a->u[2] + i);
      in.u3 = F::load(a->u[3] + i);
      in.time = a->time ? F::load(a->time + i) : F(0.f);
      in.worldCenter = Vec3<W>(F(a->worldCenter[0]), F(a->worldCenter[1]), F(a->worldCenter[2]));
      in.worldRadius = F(a->worldRadius);
      LightEmission<W> e;
      L::template emit<W>(k, in, e);
      const Mask<W> good = (e.pdfPosition > F(0.f)) & (e.pdfDirection > F(0.f)) & isFinite(e.pdfPosition) &
                           isFinite(e.pdfDirection) & isFinite(e.radiance) & isFinite(e.o) & isFinite(e.d) &
                           isFinite(e.N);
      const Vec3<W> up(F(0.f), F(0.f), F(1.f));
      zeroUnless(good, e.o).store(a->o, i);
      select(good, e.d, up).store(a->d, i);
      select(good, e.N, up).store(a->N, i);
      zeroUnless(good, e.radiance).store(a->radiance, i);
      zeroUnless(good, e.pdfPosition).store(a->pdfPosition + i);
      zeroUnless(good, e.pdfDirection).store(a->pdfDirection + i);
    }
  }
  template <int W>
  static constexpr LightFunctions table() {
    LightFunctions f{};
    f.sample = &sample<W>;
    if constexpr (L::kIntersects) f.intersect = &intersect<W>;
    f.evaluate = &evaluate<W>;
    f.emit = &emit<W>;
    return f;
  }
};

// For lights from infinitely far, known by direction alone. `B` has
//   template <int W> static Vec3<W> direction(const Data&, Float<W> u, Float<W> v);              // towards the
//   light, unit template <int W> static void at(const Data&, Vec3<W> d, Rgb<W>& radiance, Float<W>& pdf);     // of
//   that direction
// and Data has isBlack.
template <class B, class DataType>
struct DirectionalLight {
  using Data = DataType;
  static constexpr bool kIntersects = false;
  template <int W>
  static KN_INLINE void sample(const Data& k, const LightPoint<W>& in, LightSample<W>& out) {
    if (k.isBlack) return;
    out.wi = B::template direction<W>(k, in.u, in.v);
    out.distance = Float<W>(__builtin_inff());
    B::template at<W>(k, out.wi, out.radiance, out.pdf);
  }
  template <int W>
  static KN_INLINE Mask<W> intersect(const Data&, Vec3<W>, Vec3<W>, Float<W>&) {
    return Mask<W>(false);
  }
  template <int W>
  static KN_INLINE void evaluate(const Data& k, const LightRay<W>& ray, Rgb<W>& l, Float<W>& pdf) {
    if (k.isBlack) return;
    B::template at<W>(k, ray.d, l, pdf);
  }
  template <int W>
  static KN_INLINE void emit(const Data& k, const EmitInput<W>& in, LightEmission<W>& out) {
    if (k.isBlack) return;
    const Vec3<W> d = B::template direction<W>(k, in.u2, in.u3);
    emitFromDisk<W>(in, -d, out);
    B::template at<W>(k, d, out.radiance, out.pdfDirection);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

// Under HWY_ONCE, in namespace kinora: the descriptor of light `Name` with its array of parameters, LightTraits,
// create() and the type that it makes.
#undef KINORA_REGISTER_LIGHT
#define KINORA_REGISTER_LIGHT(Name, doc, params, traits, create, Data)         \
  namespace {                                                                  \
  const WidthTable kTables[] = KINORA_ALL_WIDTHS;                              \
  const Descriptor kDescriptor{kAbiVersion,                                    \
                               sizeof(Descriptor),                             \
                               Kind::Light,                                    \
                               0,                                              \
                               #Name,                                          \
                               doc,                                            \
                               params.data(),                                  \
                               uint32_t(params.size()),                        \
                               kTables,                                        \
                               std::size(kTables),                             \
                               &traits,                                        \
                               create,                                         \
                               [](void* d) { delete static_cast<Data*>(d); }}; \
  }                                                                            \
  KINORA_REGISTER(Name, kDescriptor)

#endif

#include <kinora/simd/tables.h>
