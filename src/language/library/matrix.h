// 4x4 matrices of the language: row vectors (p * M), row-major, without derivatives of their own; what they transform
// may carry some. A singular matrix has the identity for an inverse, as in the reference. Included per target.
#include "language/library/vector.h"

#if defined(KINORA_LANGUAGE_MATRIX_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_MATRIX_H_TARGET
#undef KINORA_LANGUAGE_MATRIX_H_TARGET
#else
#define KINORA_LANGUAGE_MATRIX_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

template <int W>
struct Matrix {
  Float<W> m[16];
  KN_INLINE Matrix() {
    for (int i = 0; i < 16; ++i) m[i] = Float<W>(0.f);
  }
  KN_INLINE explicit Matrix(Float<W> diagonal) {
    for (int i = 0; i < 16; ++i) m[i] = i % 5 == 0 ? diagonal : Float<W>(0.f);
  }
  // of a uniform matrix, and of one a lane: element i at p[i * stride]
  static KN_INLINE Matrix broadcast(const float* p) {
    Matrix r;
    for (int i = 0; i < 16; ++i) r.m[i] = Float<W>(p[i]);
    return r;
  }
  static KN_INLINE Matrix load(const float* p, size_t stride) {
    Matrix r;
    for (int i = 0; i < 16; ++i) r.m[i] = Float<W>::load(p + size_t(i) * stride);
    return r;
  }
  KN_INLINE void store(float* p, size_t stride) const {
    for (int i = 0; i < 16; ++i) m[i].store(p + size_t(i) * stride);
  }
  KN_INLINE Float<W> at(int row, int column) const { return m[4 * row + column]; }
  friend KN_INLINE Matrix operator*(const Matrix& a, const Matrix& b) {
    Matrix r;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        r.m[4 * i + j] = a.m[4 * i] * b.m[j] + a.m[4 * i + 1] * b.m[4 + j] + a.m[4 * i + 2] * b.m[8 + j] +
                         a.m[4 * i + 3] * b.m[12 + j];
    return r;
  }
  friend KN_INLINE Matrix operator*(const Matrix& a, Float<W> s) {
    Matrix r;
    for (int i = 0; i < 16; ++i) r.m[i] = a.m[i] * s;
    return r;
  }
  friend KN_INLINE Mask<W> operator==(const Matrix& a, const Matrix& b) {
    Mask<W> same(true);
    for (int i = 0; i < 16; ++i) same &= a.m[i] == b.m[i];
    return same;
  }
};
template <int W>
KN_INLINE Matrix<W> choose(Mask<W> c, const Matrix<W>& yes, const Matrix<W>& no) {
  Matrix<W> r;
  for (int i = 0; i < 16; ++i) r.m[i] = choose(c, yes.m[i], no.m[i]);
  return r;
}
template <int W>
KN_INLINE Matrix<W> transpose(const Matrix<W>& a) {
  Matrix<W> r;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) r.m[4 * i + j] = a.m[4 * j + i];
  return r;
}
template <int W>
KN_INLINE Float<W> determinant(const Matrix<W>& a) {
  const auto minor = [&](int p, int q, int r) HWY_ATTR {  // rows 1..3 of three columns
    return a.at(1, p) * (a.at(2, q) * a.at(3, r) - a.at(2, r) * a.at(3, q)) -
           a.at(1, q) * (a.at(2, p) * a.at(3, r) - a.at(2, r) * a.at(3, p)) +
           a.at(1, r) * (a.at(2, p) * a.at(3, q) - a.at(2, q) * a.at(3, p));
  };
  return a.at(0, 0) * minor(1, 2, 3) - a.at(0, 1) * minor(0, 2, 3) + a.at(0, 2) * minor(0, 1, 3) -
         a.at(0, 3) * minor(0, 1, 2);
}

// The last column is (0, 0, 0, 1): cofactors. `ok` loses the lanes that are singular.
template <int W>
KN_INLINE Matrix<W> inverseAffine(const Matrix<W>& a, Mask<W>& ok) {
  using F = Float<W>;
  Matrix<W> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int p = (j + 1) % 3, q = (j + 2) % 3, u = (i + 1) % 3, v = (i + 2) % 3;
      r.m[4 * i + j] = a.at(p, u) * a.at(q, v) - a.at(p, v) * a.at(q, u);
    }
  const F d = a.at(0, 0) * r.at(0, 0) + a.at(0, 1) * r.at(1, 0) + a.at(0, 2) * r.at(2, 0);
  const F size = HWY_NAMESPACE::abs(d);
  const Mask<W> large = size >= F(1.f);
  const F bound = size / F(kSmallest);  // quotients beyond it would overflow
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      F& e = r.m[4 * i + j];
      ok &= large | (bound > HWY_NAMESPACE::abs(e));
      e = e / d;
    }
  for (int j = 0; j < 3; ++j)
    r.m[12 + j] = -a.at(3, 0) * r.at(0, j) - a.at(3, 1) * r.at(1, j) - a.at(3, 2) * r.at(2, j);
  r.m[15] = F(1.f);
  return r;
}
// Gauss and Jordan with partial pivoting, lane by lane through conditional swaps.
template <int W>
HWY_ATTR HWY_NOINLINE void inverseGeneral(const Matrix<W>& a, Matrix<W>& r, Mask<W>& ok) {
  using F = Float<W>;
  Matrix<W> t = a;
  r = Matrix<W>(F(1.f));
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const Mask<W> larger = HWY_NAMESPACE::abs(t.at(j, i)) > HWY_NAMESPACE::abs(t.at(i, i));
      for (int k = 0; k < 4; ++k)
        for (Matrix<W>* m : {&t, &r}) {
          const F up = m->at(i, k), down = m->at(j, k);
          m->m[4 * i + k] = choose(larger, down, up);
          m->m[4 * j + k] = choose(larger, up, down);
        }
    }
    ok &= t.at(i, i) != F(0.f);
    for (int j = i + 1; j < 4; ++j) {
      const F f = t.at(j, i) / t.at(i, i);
      for (int k = 0; k < 4; ++k) {
        t.m[4 * j + k] -= f * t.at(i, k);
        r.m[4 * j + k] -= f * r.at(i, k);
      }
    }
  }
  for (int i = 3; i >= 0; --i) {
    const F pivot = t.at(i, i);
    for (int k = 0; k < 4; ++k) r.m[4 * i + k] /= pivot;
    for (int j = 0; j < i; ++j) {
      const F f = t.at(j, i);
      for (int k = 0; k < 4; ++k) r.m[4 * j + k] -= f * r.at(i, k);
    }
  }
}
template <int W>
HWY_ATTR HWY_NOINLINE void invert(const Matrix<W>& a, Matrix<W>& r) {
  using F = Float<W>;
  const Mask<W> affine =
      (a.at(0, 3) == F(0.f)) & (a.at(1, 3) == F(0.f)) & (a.at(2, 3) == F(0.f)) & (a.at(3, 3) == F(1.f));
  const Matrix<W> identity(F(1.f));
  Mask<W> ok(true);
  r = inverseAffine(a, ok);
  r = choose(ok, r, identity);
  if (affine.all()) return;
  Matrix<W> general;
  ok = Mask<W>(true);
  inverseGeneral(a, general, ok);
  r = choose(affine, r, choose(ok, general, identity));
}
template <int W>
KN_INLINE Matrix<W> inverse(const Matrix<W>& a) {
  Matrix<W> r;
  invert(a, r);
  return r;
}

// p * M, divided by w; (0, 0, 0) where w is 0.
template <class V, int W>
KN_INLINE V transformPoint(const Matrix<W>& m, V p) {
  const auto row = [&](int j)
                       HWY_ATTR { return p.x * m.at(0, j) + p.y * m.at(1, j) + p.z * m.at(2, j) + m.at(3, j); };
  const auto w = row(3);
  const V r(divide(row(0), w), divide(row(1), w), divide(row(2), w));
  return keep(valueOf(w) != Float<W>(0.f), r);
}
template <class V, int W>
KN_INLINE V transformVector(const Matrix<W>& m, V p) {
  const auto row = [&](int j) HWY_ATTR { return p.x * m.at(0, j) + p.y * m.at(1, j) + p.z * m.at(2, j); };
  return {row(0), row(1), row(2)};
}
// By the transposed inverse; callers with one matrix for many points invert once and use the second form.
template <class V, int W>
KN_INLINE V transformNormalByInverse(const Matrix<W>& inverse, V n) {
  const auto row = [&](int j)
                       HWY_ATTR { return n.x * inverse.at(j, 0) + n.y * inverse.at(j, 1) + n.z * inverse.at(j, 2); };
  return {row(0), row(1), row(2)};
}
template <class V, int W>
KN_INLINE V transformNormal(const Matrix<W>& m, V n) {
  return transformNormalByInverse(lang::inverse(m), n);
}

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
