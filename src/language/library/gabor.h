// Gabor noise of the language (Lagae, Lefebvre, Drettakis, Dutre, "Procedural noise using sparse Gabor convolution",
// SIGGRAPH 2009; filtering after Lagae and Drettakis, "Filtering solid Gabor noise", SIGGRAPH 2011), with the
// reference's constants and quirks. It filters itself by its argument's derivatives, so it has a dual form only.
// Gradients are analytic: they are summed with the values and meet the argument's derivatives at the end. About a
// hundred impulses a lookup: some twenty times the cost of perlin noise. Included per target.
#include "language/library/cell_noise.h"
#include "language/library/perlin.h"
#include "language/library/vector.h"
#include <kinora/math/elementary.h>

#if defined(KINORA_LANGUAGE_GABOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_GABOR_H_TARGET
#undef KINORA_LANGUAGE_GABOR_H_TARGET
#else
#define KINORA_LANGUAGE_GABOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

// Options of noise("gabor", ...). The two switches are uniform; a caller whose switches vary runs each value by
// itself.
template <int W>
struct GaborOptions {
  int anisotropic = 0;  // 0 isotropic, 1 along `direction`, else turned about z with the length of `direction`
  bool filter = true;
  Vec3<W> direction;
  Float<W> bandwidth, impulses;
  KN_INLINE GaborOptions() : direction(Float<W>(1.f), Float<W>(0.f), Float<W>(0.f)), bandwidth(1.f), impulses(16.f) {}
};

template <int W>
struct Symmetric2 {  // a 2x2 matrix [[a, b], [b, c]]
  Float<W> a, b, c;
  KN_INLINE Symmetric2(Float<W> x, Float<W> y, Float<W> z) : a(x), b(y), c(z) {}
  KN_INLINE Float<W> determinant() const { return a * c - b * b; }
  KN_INLINE Symmetric2 inverse() const {
    const Float<W> s = Float<W>(1.f) / determinant();
    return {c * s, -b * s, a * s};
  }
  friend KN_INLINE Symmetric2 operator+(Symmetric2 p, Symmetric2 q) { return {p.a + q.a, p.b + q.b, p.c + q.c}; }
  friend KN_INLINE Symmetric2 operator*(Symmetric2 p, Float<W> s) { return {p.a * s, p.b * s, p.c * s}; }
};

// Everything that one lookup's impulses share.
template <int W>
struct GaborSetup {
  Float<W> a, radius, lambda, radius2, decay;  // decay = pi a^2
  Mask<W> filtered;
  Vec3<W> n, t, b;  // the plane of the filter
  Float<W> sumA, sumB, sumC, toWfA, toWfB, toWfC, decayFiltered, weight;

  KN_INLINE GaborSetup(const GaborOptions<W>& o, const Dual3<W>& p) {
    using F = Float<W>;
    const F one(1.f), half(0.5f);
    const F octaves = HWY_NAMESPACE::exp2(HWY_NAMESPACE::clamp(o.bandwidth, F(0.01f), F(100.f)));
    a = F(2.f * 2.128934f) * ((octaves - one) / (octaves + one));
    radius = F(1.11590260f) / a;  // sqrt(-ln(0.02) / pi)
    radius2 = radius * radius;
    lambda = HWY_NAMESPACE::clamp(o.impulses, one, F(32.f)) / (F(1.33333f * kPi) * (radius2 * radius));
    decay = F(kPi) * (a * a);
    filtered = Mask<W>();
    if (!o.filter) return;
    const Vec3<W> px = p.alongX(), py = p.alongY();
    n = lang::cross(px, py);
    const F square = lang::dot(n, n);
    filtered = square >= F(1e-6f);
    if (filtered.none()) return;
    n = lang::normalize(n);
    const F zero(0.f);
    t = lang::normalize(
        choose(HWY_NAMESPACE::abs(n.x) < F(0.9f), Vec3<W>(zero, n.z, -n.y), Vec3<W>(-n.z, zero, n.x)));
    b = lang::cross(n, t);
    const F m00 = px.x * t.x + py.x * t.y, m01 = px.x * b.x + py.x * b.y, m10 = px.y * t.x + py.y * t.y,
            m11 = px.y * b.x + py.y * b.y;
    const Symmetric2<W> spatial =
        Symmetric2<W>(m00 * m00 + m10 * m10, m00 * m01 + m10 * m11, m01 * m01 + m11 * m11) * F(0.25f);
    const F det = spatial.determinant();
    filtered &= !(det < F(1e-18f));
    const F gabor = a * a * F(1.f / (2 * kPi)), perGabor = one / gabor;
    const Symmetric2<W> filter = spatial.inverse() * F(1.f / (4 * kPi * kPi));
    const Symmetric2<W> sum = filter + Symmetric2<W>(gabor, zero, gabor), perSum = sum.inverse();
    const Symmetric2<W> T = (filter.inverse() + Symmetric2<W>(perGabor, zero, perGabor)).inverse();
    sumA = perSum.a * -half, sumB = perSum.b * -half, sumC = perSum.c * -half;
    toWfA = T.a * perGabor, toWfB = T.b * perGabor, toWfC = T.c * perGabor;
    decayFiltered = F(2 * kPi * kPi) * lang::sqrt(T.determinant());  // pi af^2
    weight = one / (F(2 * kPi) * lang::sqrt(det)) / (F(2 * kPi) * lang::sqrt(sum.determinant()));
  }
};

// The kernel at d from its impulse and its gradient there.
template <int W>
KN_INLINE NoiseGradient<W> gaborKernel(const GaborSetup<W>& s, Vec3<W> d, Float<W> square, Vec3<W> omega,
                                       Float<W> phase) {
  using F = Float<W>;
  const F tau(2 * kPi);
  NoiseGradient<W> r;
  F sine, cosine;
  lang::sincos(tau * lang::dot(omega, d) + phase, sine, cosine);
  const F e = lang::exp(-(s.decay * square)), inward = F(-2.f) * s.decay * e * cosine, across = -tau * e * sine;
  r.v = e * cosine;
  r.x = inward * d.x + across * omega.x;
  r.y = inward * d.y + across * omega.y;
  r.z = inward * d.z + across * omega.z;
  return r;
}
template <int W>
KN_INLINE NoiseGradient<W> gaborKernelFiltered(const GaborSetup<W>& s, Vec3<W> d, Vec3<W> omega, Float<W> phase) {
  using F = Float<W>;
  const F tau(2 * kPi), two(2.f);
  const F wt = lang::dot(omega, s.t), wb = lang::dot(omega, s.b), wn = lang::dot(omega, s.n);
  const F along = lang::dot(s.n, d), x = lang::dot(d, s.t), y = lang::dot(d, s.b);
  const F ft = wt * s.toWfA + wb * s.toWfB, fb = wt * s.toWfB + wb * s.toWfC;
  const F e = s.weight * lang::exp(s.sumA * wt * wt + two * s.sumB * wt * wb + s.sumC * wb * wb) *
              lang::exp(-(s.decay * along * along)) * lang::exp(-(s.decayFiltered * (x * x + y * y)));
  F sine, cosine;
  lang::sincos(tau * (ft * x + fb * y) + (phase + tau * along * wn), sine, cosine);
  const F value = e * cosine, across = -tau * e * sine, inward = -two * s.decayFiltered * value;
  const F gn = -two * s.decay * along * value + across * wn, gt = inward * x + across * ft,
          gb = inward * y + across * fb;
  NoiseGradient<W> r;
  r.v = value;
  r.x = gn * s.n.x + gt * s.t.x + gb * s.b.x;
  r.y = gn * s.n.y + gt * s.t.y + gb * s.b.y;
  r.z = gn * s.n.z + gt * s.t.z + gb * s.b.z;
  return r;
}

// A draw of a cell's own generator, in [0, 1].
template <int W>
KN_INLINE Float<W> gaborDraw(Int<W>& state) {
  state = state * Int<W>(3039177861u);
  return toZeroOne(state);
}
// The impulses of one cell, of which e is the way from its corner to the point in units of the radius.
template <int W>
KN_INLINE void gaborCell(const GaborOptions<W>& o, const GaborSetup<W>& s, Int<W> state, Vec3<W> e, Float<W> limit,
                         NoiseGradient<W>& sum) {
  using F = Float<W>;
  const F one(1.f), tau(2 * kPi);
  state = choose(state == Int<W>(0), Int<W>(1), state);
  F t = gaborDraw(state);
  Int<W> count(0);
  for (Mask<W> more = t > limit; more.any(); more = t > limit) {
    count = count + choose(more, Int<W>(1), Int<W>(0));
    Int<W> next = state;
    const F drawn = t * gaborDraw(next);
    state = choose(more, next, state);
    t = choose(more, drawn, F(0.f));
  }
  for (int i = 0;; ++i) {
    const Mask<W> live = count > Int<W>(i);
    if (live.none()) return;
    const F z = gaborDraw(state), y = gaborDraw(state), x = gaborDraw(state);
    const Vec3<W> d = (e - Vec3<W>(x, y, z)) * s.radius;
    Vec3<W> omega = o.direction;
    F sine, cosine;
    if (o.anisotropic == 0) {
      lang::sincos(tau * gaborDraw(state), sine, cosine);
      const F up = F(2.f) * gaborDraw(state) - one, out = lang::sqrt(one - up * up);
      omega = lang::normalize(Vec3<W>(cosine * out, sine * out, up));
    } else if (o.anisotropic != 1) {
      lang::sincos(tau * gaborDraw(state), sine, cosine);
      omega = Vec3<W>(cosine, sine, F(0.f)) * lang::length(o.direction);
    }
    const F phase = tau * gaborDraw(state), square = lang::dot(d, d);
    const Mask<W> reached = live & (square < s.radius2);
    if (reached.none()) continue;
    NoiseGradient<W> k = gaborKernel(s, d, square, omega, phase);
    if ((reached & s.filtered).any()) {
      const NoiseGradient<W> f = gaborKernelFiltered(s, d, omega, phase);
      const Mask<W> use = s.filtered & HWY_NAMESPACE::isFinite(f.v);
      k.v = choose(use, f.v, k.v);
      k.x = choose(use, f.x, k.x);
      k.y = choose(use, f.y, k.y);
      k.z = choose(use, f.z, k.z);
    }
    sum.v += keep(reached, k.v);
    sum.x += keep(reached, k.x);
    sum.y += keep(reached, k.y);
    sum.z += keep(reached, k.z);
  }
}
// period: of three axes, or null.
template <int W>
HWY_ATTR HWY_NOINLINE void gaborLookup(const GaborOptions<W>& o, const Dual3<W>& p, const Float<W>* period,
                                       int components, Dual<W>* r) {
  using F = Float<W>;
  const GaborSetup<W> s(o, p);
  const F gx = p.x.v / s.radius, gy = p.y.v / s.radius, gz = p.z.v / s.radius;
  const F cx = HWY_NAMESPACE::floor(gx), cy = HWY_NAMESPACE::floor(gy), cz = HWY_NAMESPACE::floor(gz);
  const F limit = HWY_NAMESPACE::exp(-(s.lambda * (s.radius2 * s.radius)));
  const F variance = F(1.f / (4 * 1.41421356f)) / (s.a * s.a * s.a);
  const F scale = F(0.5f) / (F(3.f) * lang::sqrt(variance)) / lang::sqrt(s.lambda);
  for (int c = 0; c < components; ++c) {
    NoiseGradient<W> sum;
    for (int cell = 0; cell < 27; ++cell) {
      const F i(float(cell % 3 - 1)), j(float(cell / 3 % 3 - 1)), k(float(cell / 9 - 1));
      F x = cx + i, y = cy + j, z = cz + k;
      if (period) {
        x = wrapCoordinate(x, period[0]);
        y = wrapCoordinate(y, period[1]);
        z = wrapCoordinate(z, period[2]);
      }
      const Int<W> state = hashWords(toInteger(x), toInteger(y), toInteger(z), Int<W>(c));
      gaborCell(o, s, state, Vec3<W>(gx - cx - i, gy - cy - j, gz - cz - k), limit, sum);
    }
    const F g[3] = {scale * sum.x, scale * sum.y, scale * sum.z};
    const Dual<W> at[3] = {p.x, p.y, p.z};
    r[c] = alongGrid<3>(scale * sum.v, g, at);
  }
}

// Of N coordinates (the fourth is ignored), C results; periods count cells of the noise's radius, as in the
// reference.
struct GaborNoise {
  template <int N, int C, int W>
  static KN_INLINE void dual(const Dual<W>* x, const Float<W>* period, const GaborOptions<W>& o, Dual<W>* r) {
    Dual3<W> p;
    Float<W> periods[3] = {Float<W>(1.f), Float<W>(1.f), Float<W>(1.f)};
    p.x = x[0];
    if constexpr (N > 1) p.y = x[1];
    if constexpr (N > 2) p.z = x[2];
    if (period)
      for (int i = 0; i < (N < 3 ? N : 3); ++i) periods[i] = period[i];
    gaborLookup(o, p, period ? periods : nullptr, C, r);
  }
};

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
