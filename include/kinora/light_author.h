// The light author's layer: write one struct with functions over W points, and LightRunner turns it into the tables
// of light.h; it masks tails and drops samples without density, so that lights need not. Included per target, after
// light_setup.h.
//
//   struct MyLight {
//     using Data = ...;                                          // of one light
//     static constexpr bool kIntersects = true;                  // false: infinite or delta
//     template <int W> static void sample(const Data&, const LightPoint<W>&, LightSample<W>& out);
//     // hits nearer than t alone; with `static constexpr bool kDeforms = true`, where its place depends on the time, of
//     // (const Data&, const LightRay<W>&, Float<W>& t)
//     template <int W> static Mask<W> intersect(const Data&, Vec3<W> o, Vec3<W> d, Float<W>& t);
//     template <int W> static void evaluate(const Data&, const LightRay<W>&, Rgb<W>& radiance, Float<W>& pdf);
//     template <int W> static void emit(const Data&, const EmitInput<W>&, LightEmission<W>& out);
//     // may be left out
//     template <int W> static void densities(const Data&, const LightRay<W>&, LightDensities<W>& out);
//   };
//   KINORA_LIGHT(MyLight, .help = "...", .params = kParams, .setUp = setUp<Data>, .describe = describe)
//
// Lanes may ask for different lights of the kind: the runner calls once for each of them and keeps its lanes. A
// struct with `static constexpr bool kMixes = true` takes `const LightOf<Data, W>&` in place of `const Data&` and
// fetches what it reads by lane, k(&Data::area), so that one call serves them all.
#include <kinora/light_setup.h>
#ifdef KINORA_KERNEL_FILE
#include <kinora/simd/foreach_target.h>
#endif
#include <kinora/math/sampling.h>
#include <kinora/simd/records.h>

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
  Float<W> worldRadius;  // densities() only
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

// Of a ray that met the light: what emit() has for the light that comes back along it.
template <int W>
struct LightDensities {
  Vec3<W> N;
  Float<W> pdfPosition, pdfDirection;
  KN_INLINE LightDensities() {}
};

template <int W>
KN_INLINE Vec3<W> wide(const Float3& a) {
  return {Float<W>(a.x), Float<W>(a.y), Float<W>(a.z)};
}
template <int W>
KN_INLINE Vec3<W> wide(const Vec3<W>& a) {
  return a;
}
template <int W>
KN_INLINE Rgb<W> wideRgb(const float a[3]) {
  return {Float<W>(a[0]), Float<W>(a[1]), Float<W>(a[2])};
}

// The data of W lights, one a lane, or of one light for all lanes.
template <class Data, int W>
class LightOf {
 public:
  KN_INLINE LightOf(const LightLanes& l, uint32_t at) {
    isOne_ = true;
    of_[0] = static_cast<const Data*>(l.light[size_t(at) * l.lightStride]);
    if (!l.lightStride) return;
    for (int k = 1; k < W; ++k) {
      of_[k] = static_cast<const Data*>(l.light[at + uint32_t(k)]);
      isOne_ = isOne_ && of_[k] == of_[0];
    }
  }
  // Of one light: for a light that works in part by lights that mix.
  KN_INLINE explicit LightOf(const Data& light) : isOne_(true) { of_[0] = &light; }
  KN_INLINE bool isOne() const { return isOne_; }
  KN_INLINE const Data& lane(int k) const { return *of_[k]; }
  KN_INLINE Float<W> operator()(float Data::*member) const {
    if (isOne_) return Float<W>(of_[0]->*member);
    alignas(64) float x[W];
    for (int k = 0; k < W; ++k) x[k] = of_[k]->*member;
    return Float<W>::load(x);
  }
  KN_INLINE Vec3<W> operator()(Float3 Data::*member) const {
    return vector([member](const Data& d) -> const Float3& { return d.*member; });
  }
  KN_INLINE Mask<W> operator()(bool Data::*member) const {
    if (isOne_) return Mask<W>(of_[0]->*member);
    return number([member](const Data& d) { return d.*member ? 1.f : 0.f; }) > Float<W>(0.f);
  }
  // What is no plain member: get(const Data&) gives a number, a Float3 that every light holds in the same place, or
  // three numbers.
  template <class Get>
  KN_INLINE Float<W> number(Get get) const {
    if (isOne_) return Float<W>(get(*of_[0]));
    alignas(64) float x[W];
    for (int k = 0; k < W; ++k) x[k] = get(*of_[k]);
    return Float<W>::load(x);
  }
  template <class Get>
  KN_INLINE Vec3<W> vector(Get get) const {
    if (isOne_) return wide<W>(get(*of_[0]));
    // four words at once, where the fourth is of the light as well
    const size_t at = size_t(reinterpret_cast<const char*>(&get(*of_[0])) - reinterpret_cast<const char*>(of_[0]));
    if (W > 1 && at + 4 * sizeof(float) <= sizeof(Data)) {
      const float* from[W];
      for (int k = 0; k < W; ++k)
        from[k] = reinterpret_cast<const float*>(reinterpret_cast<const char*>(of_[k]) + at);
      Float<W> words[4];
      loadFours<W>(from, words);
      return {words[0], words[1], words[2]};
    }
    alignas(64) float x[3][W];
    for (int k = 0; k < W; ++k) {
      const Float3& v = get(*of_[k]);
      x[0][k] = v.x;
      x[1][k] = v.y;
      x[2][k] = v.z;
    }
    return {Float<W>::load(x[0]), Float<W>::load(x[1]), Float<W>::load(x[2])};
  }
  template <class Get>
  KN_INLINE Rgb<W> rgb(Get get) const {
    if (isOne_) return wideRgb<W>(get(*of_[0]));
    alignas(64) float x[3][W];
    for (int k = 0; k < W; ++k) {
      const float* v = get(*of_[k]);
      for (int c = 0; c < 3; ++c) x[c][k] = v[c];
    }
    return {Float<W>::load(x[0]), Float<W>::load(x[1]), Float<W>::load(x[2])};
  }
  template <class Is>
  KN_INLINE bool any(Is is) const {
    bool some = false;
    for (int k = 0; k < (isOne_ ? 1 : W); ++k) some = some || is(*of_[k]);
    return some;
  }
  // One light, and a black one.
  KN_INLINE bool isBlack() const { return isOne_ && of_[0]->isBlack; }
  // Lanes whose light is that of lane k.
  KN_INLINE Mask<W> sameAs(int k) const {
    if (isOne_) return Mask<W>(true);
    alignas(64) int32_t same[W];
    for (int j = 0; j < W; ++j) same[j] = of_[j] == of_[k];
    return Int<W>::load(same) != Int<W>(0);
  }

 private:
  const Data* of_[W];
  bool isOne_;
};

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

// lookUp() by lane, of lights whose Data has a `map`; 1 where it has none.
template <int W, bool kPeriodic, class Data>
KN_INLINE Rgb<W> lookUp(const LightOf<Data, W>& k, Float<W> u, Float<W> v) {
  Rgb<W> c(Float<W>(1.f), Float<W>(1.f), Float<W>(1.f));
  for (int lane = 0; lane < (k.isOne() ? 1 : W); ++lane)
    if (k.lane(lane).map.valid()) c = select(k.sameAs(lane), lookUp<W, kPeriodic>(k.lane(lane).map, u, v), c);
  return c;
}

// Start of a light path from an infinite light: on the disk that faces the world sphere, outside of it. And its
// density there for a ray that found the light.
template <int W>
KN_INLINE void densityOfDisk(const LightRay<W>& ray, LightDensities<W>& out) {
  const Float<W> r = max(ray.worldRadius, Float<W>(1e-6f));
  out.N = -ray.d;
  out.pdfPosition = Float<W>(1.f) / (Float<W>(kPi) * r * r);
}
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

// shape() by lane, of lights whose Data has a `shaping`.
template <class Data, int W>
KN_INLINE Rgb<W> shape(const LightOf<Data, W>& k, Float<W> cosine) {
  using F = Float<W>;
  if (k.isOne()) return shape<W>(k.lane(0).shaping, cosine);
  Rgb<W> f(F(1.f), F(1.f), F(1.f));
  if (k.any([](const Data& d) { return d.shaping.focused; })) {
    const Mask<W> focused = k.number([](const Data& d) { return d.shaping.focused ? 1.f : 0.f; }) > F(0.f);
    const F fall = zeroUnless(cosine > F(0.f),
                              pow(max(cosine, F(0.f)), k.number([](const Data& d) { return d.shaping.focus; })));
    const Rgb<W> tint = k.rgb([](const Data& d) { return d.shaping.tint; });
    f = select(focused, lerp(tint, f, fall) * k.rgb([](const Data& d) { return d.shaping.scale; }), f);
  }
  if (k.any([](const Data& d) { return d.shaping.coned; })) {
    const Mask<W> coned = k.number([](const Data& d) { return d.shaping.coned ? 1.f : 0.f; }) > F(0.f);
    const F end = k.number([](const Data& d) { return d.shaping.coneEnd; });
    const F start = k.number([](const Data& d) { return d.shaping.coneStart; });
    const F theta = acos(cosine), width = end - start;
    const F t = select(width > F(0.f), clamp((theta - start) / max(width, F(1e-20f)), F(0.f), F(1.f)),
                       select(theta > end, F(1.f), F(0.f)));
    f = select(coned, f * fnma(t * t, fnma(F(2.f), t, F(3.f)), F(1.f)), f);
  }
  return f;
}
// What emit() of a flat light has for a direction that makes this cosine with its normal.
template <int W>
KN_INLINE Float<W> coneDensity(Float<W> cosine, Float<W> sinCone) {
  using F = Float<W>;
  const Mask<W> within = (cosine > F(0.f)) & (fnma(cosine, cosine, F(1.f)) <= sinCone * sinCone * F(1.f + 1e-5f));
  return zeroUnless(within, cosine * F(kInvPi) / (sinCone * sinCone));
}

template <int W>
KN_INLINE LightSample<W> select(Mask<W> m, const LightSample<W>& a, const LightSample<W>& b) {
  LightSample<W> r;
  r.wi = select(m, a.wi, b.wi);
  r.distance = select(m, a.distance, b.distance);
  r.pdf = select(m, a.pdf, b.pdf);
  r.radiance = select(m, a.radiance, b.radiance);
  r.delta = (m & a.delta) | ((!m) & b.delta);
  return r;
}
template <int W>
KN_INLINE LightEmission<W> select(Mask<W> m, const LightEmission<W>& a, const LightEmission<W>& b) {
  LightEmission<W> r;
  r.o = select(m, a.o, b.o);
  r.d = select(m, a.d, b.d);
  r.N = select(m, a.N, b.N);
  r.radiance = select(m, a.radiance, b.radiance);
  r.pdfPosition = select(m, a.pdfPosition, b.pdfPosition);
  r.pdfDirection = select(m, a.pdfDirection, b.pdfDirection);
  return r;
}
template <int W>
KN_INLINE LightDensities<W> select(Mask<W> m, const LightDensities<W>& a, const LightDensities<W>& b) {
  LightDensities<W> r;
  r.N = select(m, a.N, b.N);
  r.pdfPosition = select(m, a.pdfPosition, b.pdfPosition);
  r.pdfDirection = select(m, a.pdfDirection, b.pdfDirection);
  return r;
}
// What a ray brings, from intersect() or evaluate().
template <int W>
struct LightAnswer {
  Mask<W> hit;
  Float<W> t, pdf;
  Rgb<W> radiance;
  KN_INLINE LightAnswer() {}
  friend KN_INLINE LightAnswer select(Mask<W> m, const LightAnswer& a, const LightAnswer& b) {
    LightAnswer r;
    r.hit = (m & a.hit) | ((!m) & b.hit);
    r.t = select(m, a.t, b.t);
    r.pdf = select(m, a.pdf, b.pdf);
    r.radiance = select(m, a.radiance, b.radiance);
    return r;
  }
};

// One call for all lanes, or one for each light among them.
template <class L, int W, class Input, class Output, class Call>
KN_INLINE void askLights(const LightLanes& lights, uint32_t at, uint32_t count, const Input& in, Output& out,
                         Call call) {
  const LightOf<typename L::Data, W> k(lights, at);
  if constexpr (requires { L::kMixes; }) {
    call(k, in, out);
  } else {
    if (k.isOne()) {
      call(k.lane(0), in, out);
      return;
    }
    uint32_t left = count - at < W ? (1u << (count - at)) - 1u : W == 32 ? ~0u : (1u << W) - 1u;
    while (left) {
      const int lane = __builtin_ctz(left);
      const Mask<W> same = k.sameAs(lane);
      Output one = out;
      call(k.lane(lane), in, one);
      out = select(same, one, out);
      left &= ~same.bits();
    }
  }
}

template <class L>
struct LightRunner {
  using Data = typename L::Data;

  template <int W>
  static void sample(const LightSampleArgs* a) {
    using F = Float<W>;
    for (uint32_t i = 0; i < a->count; i += W) {
      LightPoint<W> p;
      p.P = Vec3<W>::load(a->P, i);
      p.u = F::load(a->u[0] + i);
      p.v = F::load(a->u[1] + i);
      p.time = a->time ? F::load(a->time + i) : F(0.f);
      LightSample<W> s;
      askLights<L, W>(*a, i, a->count, p, s,
                      [](const auto& k, const LightPoint<W>& in, LightSample<W>& out)
                          HWY_ATTR { L::template sample<W>(k, in, out); });
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
  static KN_INLINE LightRay<W> rayAt(const float* const o[3], const float* const d[3], const float* t,
                                     const float* time, uint32_t i) {
    LightRay<W> r;
    r.o = Vec3<W>::load(o, i);
    r.d = Vec3<W>::load(d, i);
    r.t = t ? Float<W>::load(t + i) : Float<W>(0.f);
    r.time = time ? Float<W>::load(time + i) : Float<W>(0.f);
    return r;
  }
  template <int W>
  static void intersect(const LightRayArgs* a) {
    using F = Float<W>;
    for (uint32_t i = 0; i < a->count; i += W) {
      constexpr bool kAsksTime = requires { L::kDeforms; };
      const LightRay<W> ray = rayAt<W>(a->o, a->d, a->t, kAsksTime ? a->time : nullptr, i);
      LightAnswer<W> answer;
      answer.t = ray.t;
      askLights<L, W>(*a, i, a->count, ray, answer,
                      [](const auto& k, const LightRay<W>& in, LightAnswer<W>& out) HWY_ATTR {
                        if constexpr (requires { L::kDeforms; })
                          out.hit = L::template intersect<W>(k, in, out.t);
                        else
                          out.hit = L::template intersect<W>(k, in.o, in.d, out.t);
                      });
      const F limit = ray.t, t = answer.t;
      const Mask<W> hit = answer.hit & (t > F(0.f)) & (t < limit);
      select(hit, t, limit).store(a->t + i);
      select(hit, Int<W>(1), Int<W>(0)).store(a->hit + i);
    }
  }
  template <int W>
  static void evaluate(const LightRayArgs* a) {
    for (uint32_t i = 0; i < a->count; i += W) {
      const LightRay<W> ray = rayAt<W>(a->o, a->d, a->t, a->time, i);
      LightAnswer<W> answer;
      askLights<L, W>(*a, i, a->count, ray, answer,
                      [](const auto& k, const LightRay<W>& in, LightAnswer<W>& out)
                          HWY_ATTR { L::template evaluate<W>(k, in, out.radiance, out.pdf); });
      const Mask<W> good = isFinite(answer.radiance) & isFinite(answer.pdf);
      zeroUnless(good, answer.radiance).store(a->radiance, i);
      zeroUnless(good, answer.pdf).store(a->pdf + i);
    }
  }
  template <int W>
  static void emit(const LightEmitArgs* a) {
    using F = Float<W>;
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
      askLights<L, W>(*a, i, a->count, in, e,
                      [](const auto& k, const EmitInput<W>& x, LightEmission<W>& out)
                          HWY_ATTR { L::template emit<W>(k, x, out); });
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
  static void densities(const LightDensityArgs* a) {
    using F = Float<W>;
    for (uint32_t i = 0; i < a->count; i += W) {
      LightRay<W> ray = rayAt<W>(a->o, a->d, a->t, a->time, i);
      ray.worldRadius = F(a->worldRadius);
      LightDensities<W> e;
      askLights<L, W>(*a, i, a->count, ray, e,
                      [](const auto& k, const LightRay<W>& in, LightDensities<W>& out)
                          HWY_ATTR { L::template densities<W>(k, in, out); });
      const Mask<W> good = (e.pdfPosition > F(0.f)) & (e.pdfDirection > F(0.f)) & isFinite(e.pdfPosition) &
                           isFinite(e.pdfDirection) & isFinite(e.N);
      select(good, e.N, -ray.d).store(a->N, i);
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
    if constexpr (requires { &L::template densities<W>; }) f.densities = &densities<W>;
    f.mixes = requires { L::kMixes; };
    return f;
  }
};

// For lights that only mark (LightPlugin::mark).
template <class DataType>
struct MarkingLight {
  using Data = DataType;
  static constexpr bool kIntersects = false;
  template <int W>
  static KN_INLINE void sample(const Data&, const LightPoint<W>&, LightSample<W>&) {}
  template <int W>
  static KN_INLINE Mask<W> intersect(const Data&, Vec3<W>, Vec3<W>, Float<W>&) {
    return Mask<W>(false);
  }
  template <int W>
  static KN_INLINE void evaluate(const Data&, const LightRay<W>&, Rgb<W>&, Float<W>&) {}
  template <int W>
  static KN_INLINE void emit(const Data&, const EmitInput<W>&, LightEmission<W>&) {}
};

// For lights from infinitely far, known by direction alone. `B` has
//   // towards the light, unit
//   template <int W> static Vec3<W> direction(const Data&, Float<W> u, Float<W> v);
//   // of that direction
//   template <int W> static void at(const Data&, Vec3<W> d, Rgb<W>& radiance, Float<W>& pdf);
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
  template <int W>
  static KN_INLINE void densities(const Data& k, const LightRay<W>& ray, LightDensities<W>& out) {
    if (k.isBlack) return;
    Rgb<W> unused;
    B::template at<W>(k, ray.d, unused, out.pdfDirection);
    densityOfDisk<W>(ray, out);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif

#include <kinora/simd/tables.h>

// Ends the file of a plug-in, whose struct has its name.
#undef KINORA_LIGHT
#define KINORA_LIGHT(Name, ...) KINORA_PLUGIN(Name, LightRunner<Name>, LightPlugin, __VA_ARGS__)
