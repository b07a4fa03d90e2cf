// Splines of the language over knots in memory, and their inverse. Knots are read through a small source type, so
// that uniform arrays are gathered from one place and varying ones from their lanes:
//   Knots::Value<W>            Float<W> or Dual<W>
//   knots.get<W>(component, i) knot i of each lane
// Too few knots for the basis repeat the last one: the machine reports them. Included per target.
#include "language/library/spline_basis.h"
#include "language/library/vector.h"

#if defined(KINORA_LANGUAGE_SPLINE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_SPLINE_H_TARGET
#undef KINORA_LANGUAGE_SPLINE_H_TARGET
#else
#define KINORA_LANGUAGE_SPLINE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

// Knot i, component c at v[i * element + c].
struct UniformKnots {
  const float* v;
  int element;
  template <int W>
  using Value = Float<W>;
  template <int W>
  KN_INLINE Float<W> get(int c, Int<W> i) const {
    return HWY_NAMESPACE::gather(v + c, i * Int<W>(element));
  }
};
// One array a lane: knot i, component c of lane k at v[i * element + c * component + k].
struct VaryingKnots {
  const float* v;
  int element, component;
  template <int W>
  using Value = Float<W>;
  template <int W>
  KN_INLINE Float<W> get(int c, Int<W> i) const {
    return HWY_NAMESPACE::gather(v + ptrdiff_t(c) * component, i * Int<W>(element) + Int<W>::lanes(0));
  }
};
template <class Plain>
struct DualKnots {
  Plain v, dx, dy;
  template <int W>
  using Value = Dual<W>;
  template <int W>
  KN_INLINE Dual<W> get(int c, Int<W> i) const {
    return {v.template get<W>(c, i), dx.template get<W>(c, i), dy.template get<W>(c, i)};
  }
};

// x brought to [0, 1], without derivatives outside.
template <class F>
KN_INLINE F clampUnit(F x) {
  const auto v = valueOf(x);
  return choose(v < decltype(v)(0.f), F(0.f), choose(v > decltype(v)(1.f), F(1.f), x));
}
// C components of the curve at x, into R = Dual where x or the knots are.
template <int C, class F, class Knots, class R>
KN_INLINE void spline(language::SplineBasis basis, F x, int count, const Knots& knots, R* r) {
  using Plain = decltype(valueOf(x));
  constexpr int W = kWidthOf<F>;
  using I = Int<W>;
  const int segments = language::splineSegments(basis, count);
  const F y = clampUnit(x) * Plain(float(segments));
  I segment = toInteger(valueOf(y));
  segment = choose(segment < I(0), I(0), choose(segment > I(segments - 1), I(segments - 1), segment));
  const F t = y - toFloat(segment);
  const I first = segment * I(language::splineStep(basis)), last(count - 1);
  I index[4];
  for (int k = 0; k < 4; ++k) {
    index[k] = first + I(k);
    index[k] = choose(index[k] > last, last, index[k]);
  }
  if (basis == language::SplineBasis::Constant) {
    for (int c = 0; c < C; ++c) r[c] = R(valueOf(knots.template get<W>(c, index[1])));
    return;
  }
  const float* m = language::kSplineMatrix[int(basis)];
  for (int c = 0; c < C; ++c) {
    typename Knots::template Value<W> p[4], k[4];
    for (int i = 0; i < 4; ++i) p[i] = knots.template get<W>(c, index[i]);
    for (int i = 0; i < 4; ++i)
      k[i] = p[0] * Plain(m[4 * i]) + p[1] * Plain(m[4 * i + 1]) + p[2] * Plain(m[4 * i + 2]) +
             p[3] * Plain(m[4 * i + 3]);
    r[c] = R(((k[0] * t + k[1]) * t + k[2]) * t + k[3]);
  }
}

// Where a monotonic curve of floats has the value v: regula falsi, then bisection, segment by segment. Derivatives
// are those of these steps; those of knots are ignored.
template <class F, class Knots>
KN_INLINE F splineinverse(language::SplineBasis basis, F v, int count, const Knots& knots) {
  using Plain = decltype(valueOf(v));
  constexpr int W = kWidthOf<F>;
  using M = Mask<W>;
  const int segments = language::splineSegments(basis, count);
  const auto curve = [&](F x) HWY_ATTR {
    F r;
    spline<1>(basis, x, count, knots, &r);
    return r;
  };
  const auto knot = [&](int i) HWY_ATTR {
    i = i < 0 ? 0 : i >= count ? count - 1 : i;
    return valueOf(knots.template get<W>(0, Int<W>(i)));
  };
  const bool inner = language::splineStep(basis) == 1;
  const Plain low = knot(inner ? 1 : 0), high = knot(inner ? count - 2 : count - 1), at = valueOf(v);
  const M rises = knot(1) < knot(count - 2);
  const M before = (rises & (at <= low)) | ((!rises) & (at >= low));
  const M after = ((rises & (at >= high)) | ((!rises) & (at <= high))) & (!before);
  F result = choose(after, F(1.f), F(0.f));
  M open = !(before | after);
  const Plain eps(1e-6f), one(1.f);
  for (int s = 0; s < segments && open.any(); ++s) {
    F xl(float(s) / float(segments)), xr(float(s + 1) / float(segments));
    F v0 = curve(xl), v1 = curve(xr);
    const M increasing = valueOf(v0) < valueOf(v1);
    const Plain least = choose(increasing, valueOf(v0), valueOf(v1)),
                most = choose(increasing, valueOf(v1), valueOf(v0));
    const M inside = (at >= least) & (at <= most);
    const M below = at < least;
    const M left = (below & increasing) | ((!below) & (!increasing));
    result = choose(open & (!inside), choose(left, xl, xr), result);
    M live = open & inside;
    result = choose(live, xl, result);  // also the answer where both ends are alike
    open &= !inside;
    live &= HWY_NAMESPACE::abs(valueOf(v0) - valueOf(v1)) >= eps;
    for (int i = 0; i < 32 && live.any(); ++i) {
      F t(0.5f);
      if (i < 24) {
        const F guess = divide(v - v0, v1 - v0);
        t = choose((valueOf(guess) <= Plain(0.f)) | (valueOf(guess) >= one), t, guess);
      }
      const F x = xl * (one - t) + xr * t, f = curve(x);
      result = choose(live, x, result);
      const M under = valueOf(f) < at;
      const M replaceLeft = (under & increasing) | ((!under) & (!increasing));
      xl = choose(replaceLeft, x, xl);
      v0 = choose(replaceLeft, f, v0);
      xr = choose(replaceLeft, xr, x);
      v1 = choose(replaceLeft, v1, f);
      live &= (HWY_NAMESPACE::abs(valueOf(xr) - valueOf(xl)) >= eps) & (HWY_NAMESPACE::abs(valueOf(f) - at) >= eps);
    }
  }
  return result;
}

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
