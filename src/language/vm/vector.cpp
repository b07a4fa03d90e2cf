// Triples, matrices, and what reads derivatives. Formulas and their order of operations: reference osl-numerics, 8.
#define KINORA_KERNEL_FILE "language/vm/vector.cpp"
#include "language/vm/kernel.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/fast_math.h"
#include "language/vm/access.h"
#include "language/vm/width_tables.h"

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using namespace kinora::language;
using lang::Dual;
using lang::Dual3;

// ---- operands: plain {cell, step, varies}, dual {cell, step, dx, dy, derivStep, varies}; results {cell} or {cell, dx, dy}
template <int W>
struct PlainWords {
  using F = Float<W>;
  using V = Vec3<W>;
  static constexpr uint32_t kResult = 1, kOperand = 3;
  static KN_INLINE F number(const Frame& f, const uint32_t* w, uint32_t i) { return lang::fetch<W>(f.cells[w[0]], i, w[2]); }
  static KN_INLINE V triple(const Frame& f, const uint32_t* w, uint32_t i) {
    return {lang::fetch<W>(f.cells[w[0]], i, w[2]), lang::fetch<W>(f.cells[w[0] + w[1]], i, w[2]), lang::fetch<W>(f.cells[w[0] + 2 * w[1]], i, w[2])};
  }
  static KN_INLINE void put(const Frame& f, const uint32_t* w, uint32_t i, F x) { x.store(f.cells[w[0]] + i); }
  static KN_INLINE void put(const Frame& f, const uint32_t* w, uint32_t i, V x) {
    x.x.store(f.cells[w[0]] + i);
    x.y.store(f.cells[w[0] + 1] + i);
    x.z.store(f.cells[w[0] + 2] + i);
  }
};
template <int W>
struct DualWords {
  using F = Dual<W>;
  using V = Dual3<W>;
  static constexpr uint32_t kResult = 3, kOperand = 6;
  static KN_INLINE F number(const Frame& f, const uint32_t* w, uint32_t i, uint32_t c = 0) {
    return lang::DualOperand(f, w, c).template get<W>(i, w[5]);
  }
  static KN_INLINE V triple(const Frame& f, const uint32_t* w, uint32_t i) { return {number(f, w, i, 0), number(f, w, i, 1), number(f, w, i, 2)}; }
  static KN_INLINE void put(const Frame& f, const uint32_t* w, uint32_t i, F x, uint32_t c = 0) { lang::DualCells(f, w, c).put(x, i); }
  static KN_INLINE void put(const Frame& f, const uint32_t* w, uint32_t i, V x) {
    put(f, w, i, x.x, 0);
    put(f, w, i, x.y, 1);
    put(f, w, i, x.z, 2);
  }
};

template <class V>
KN_INLINE auto dotOf(V a, V b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <class V>
KN_INLINE V crossOf(V a, V b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
template <class V>
KN_INLINE V normalizeOf(V a) {
  const auto length = lang::sqrt(dotOf(a, a));
  using Plain = decltype(lang::valueOf(length));
  using F = decltype(a.x);
  return lang::keep(lang::valueOf(length) > Plain(0.f), a * lang::divide(F(1.f), length));
}

// ---- the operations; T says plain or dual ----
template <class T>
struct Dot {
  static constexpr uint32_t kOperands = 2;
  static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) {
    T::put(f, r, i, dotOf(T::triple(f, w, i), T::triple(f, w + T::kOperand, i)));
  }
};
template <class T>
struct Cross {
  static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) {
    T::put(f, r, i, crossOf(T::triple(f, w, i), T::triple(f, w + T::kOperand, i)));
  }
};
template <class T>
struct Length {
  static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) {
    const auto a = T::triple(f, w, i);
    T::put(f, r, i, lang::sqrt(dotOf(a, a)));
  }
};
template <class T>
struct Distance {
  static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) {
    const auto a = T::triple(f, w, i), b = T::triple(f, w + T::kOperand, i), d = a - b;
    T::put(f, r, i, lang::sqrt(dotOf(d, d)));
  }
};
template <class T>
struct Normalize {
  static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) { T::put(f, r, i, normalizeOf(T::triple(f, w, i))); }
};
template <class T>
struct Reflect {  // I, N
  static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) {
    const auto I = T::triple(f, w, i), N = T::triple(f, w + T::kOperand, i);
    T::put(f, r, i, I - N * (typename T::F(2.f) * dotOf(N, I)));
  }
};
template <class T>
struct Refract {  // I, N, eta
  static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) {
    using F = typename T::F;
    const auto I = T::triple(f, w, i), N = T::triple(f, w + T::kOperand, i);
    const F eta = T::number(f, w + 2 * T::kOperand, i), d = dotOf(I, N);
    const F k = F(1.f) - eta * eta * (F(1.f) - d * d);
    using Plain = decltype(lang::valueOf(k));
    T::put(f, r, i, lang::keep(!(lang::valueOf(k) < Plain(0.f)), I * eta - N * (eta * d + lang::sqrt(k))));
  }
};
template <class T>
struct FaceForward {  // N, I, Nref
  static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) {
    const auto N = T::triple(f, w, i), I = T::triple(f, w + T::kOperand, i), ref = T::triple(f, w + 2 * T::kOperand, i);
    const auto d = lang::valueOf(dotOf(I, ref));
    T::put(f, r, i, lang::choose(d > decltype(d)(0.f), -N, N));
  }
};
template <class T>
struct Rotate {  // p, angle, axis
  static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) {
    using F = typename T::F;
    const auto p = T::triple(f, w, i), a = normalizeOf(T::triple(f, w + 2 * T::kOperand, i));
    F s, c;
    lang::sincos(T::number(f, w + T::kOperand, i), s, c);
    const F one(1.f), k = one - c;
    const F xx = a.x * a.x, yy = a.y * a.y, zz = a.z * a.z, xyk = a.x * a.y * k, xzk = a.x * a.z * k, yzk = a.y * a.z * k;
    const F xs = a.x * s, ys = a.y * s, zs = a.z * s;
    const typename T::V out(p.x * (xx + (one - xx) * c) + p.y * (xyk - zs) + p.z * (xzk + ys),
                            p.x * (xyk + zs) + p.y * (yy + (one - yy) * c) + p.z * (yzk - xs),
                            p.x * (xzk - ys) + p.y * (yzk + xs) + p.z * (zz + (one - zz) * c));
    T::put(f, r, i, out);
  }
};
// triple, then the matrix as a plain operand {cell, varies}
template <int W>
KN_INLINE Float<W> matrixCell(const Frame& f, const uint32_t* w, uint32_t i, uint32_t row, uint32_t column) {
  return lang::fetch<W>(f.cells[w[0] + 4 * row + column], i, w[1]);
}
template <int W>
KN_INLINE Vec3<W> over(Vec3<W> v, Float<W> s) { return v * s; }
template <int W>
KN_INLINE Dual3<W> over(Dual3<W> v, Dual<W> s) { return v * s; }
template <class T, int W, bool kPoint>
KN_INLINE void transform(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) {
  using F = typename T::F;
  const auto p = T::triple(f, w, i);
  const uint32_t* m = w + T::kOperand;
  F out[4];
  for (uint32_t c = 0; c < (kPoint ? 4u : 3u); ++c) {
    out[c] = p.x * matrixCell<W>(f, m, i, 0, c) + p.y * matrixCell<W>(f, m, i, 1, c) + p.z * matrixCell<W>(f, m, i, 2, c);
    if (kPoint) out[c] = out[c] + matrixCell<W>(f, m, i, 3, c);
  }
  typename T::V q(out[0], out[1], out[2]);
  if constexpr (kPoint) {
    const auto h = lang::valueOf(out[3]);
    using Plain = decltype(lang::valueOf(out[3]));
    const auto affine = h == Plain(1.f);
    const typename T::V divided(lang::divide(q.x, out[3]), lang::divide(q.y, out[3]), lang::divide(q.z, out[3]));
    q = lang::choose(affine, q, lang::keep(h != Plain(0.f), divided));
  }
  T::put(f, r, i, q);
}
template <class T>
struct WidthOf;
template <int W>
struct WidthOf<PlainWords<W>> {
  static constexpr int kWidth = W;
};
template <int W>
struct WidthOf<DualWords<W>> {
  static constexpr int kWidth = W;
};
template <class T>
struct TransformPoint {
  static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) { transform<T, WidthOf<T>::kWidth, true>(f, r, w, i); }
};
template <class T>
struct TransformVector {
  static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) { transform<T, WidthOf<T>::kWidth, false>(f, r, w, i); }
};

template <template <class> class Op, class T, int W>
void each(const Frame& f, const uint32_t* w) {
  for (uint32_t i = 0, points = f.points; i < points; i += W) Op<T>::run(f, w, w + T::kResult, i);
}

// ---- matrices: 16 cells, row by row; operands {cell, varies} ----
template <int W>
void matrixMul(const Frame& f, const uint32_t* w) {
  for (uint32_t i = 0, points = f.points; i < points; i += W) {
    Float<W> out[16];
    for (uint32_t row = 0; row < 4; ++row)
      for (uint32_t c = 0; c < 4; ++c) {
        Float<W> sum = matrixCell<W>(f, w + 1, i, row, 0) * matrixCell<W>(f, w + 3, i, 0, c);
        for (uint32_t k = 1; k < 4; ++k) sum = sum + matrixCell<W>(f, w + 1, i, row, k) * matrixCell<W>(f, w + 3, i, k, c);
        out[4 * row + c] = sum;
      }
    for (uint32_t k = 0; k < 16; ++k) out[k].store(f.cells[w[0] + k] + i);
  }
}
template <int W>
void matrixTranspose(const Frame& f, const uint32_t* w) {
  for (uint32_t i = 0, points = f.points; i < points; i += W) {
    Float<W> out[16];
    for (uint32_t k = 0; k < 16; ++k) out[k] = matrixCell<W>(f, w + 1, i, k & 3, k >> 2);
    for (uint32_t k = 0; k < 16; ++k) out[k].store(f.cells[w[0] + k] + i);
  }
}
template <int W>
KN_INLINE Float<W> minor3(const Float<W>* m, int r0, int r1, int r2, int c0, int c1, int c2) {
  const auto at = m;
  return at[4 * r0 + c0] * (at[4 * r1 + c1] * at[4 * r2 + c2] - at[4 * r1 + c2] * at[4 * r2 + c1]) -
         at[4 * r0 + c1] * (at[4 * r1 + c0] * at[4 * r2 + c2] - at[4 * r1 + c2] * at[4 * r2 + c0]) +
         at[4 * r0 + c2] * (at[4 * r1 + c0] * at[4 * r2 + c1] - at[4 * r1 + c1] * at[4 * r2 + c0]);
}
template <int W>
void matrixDeterminant(const Frame& f, const uint32_t* w) {
  for (uint32_t i = 0, points = f.points; i < points; i += W) {
    Float<W> m[16];
    for (uint32_t k = 0; k < 16; ++k) m[k] = lang::fetch<W>(f.cells[w[1] + k], i, w[2]);
    const Float<W> d = m[0] * minor3(m, 1, 2, 3, 1, 2, 3) - m[1] * minor3(m, 1, 2, 3, 0, 2, 3) + m[2] * minor3(m, 1, 2, 3, 0, 1, 3) -
                       m[3] * minor3(m, 1, 2, 3, 0, 1, 2);
    d.store(f.cells[w[0]] + i);
  }
}

// ---- derivatives: components, result, operand as dual ----
template <int W>
void filterWidth(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    const lang::DualOperand a(f, w + 2, c);
    for (uint32_t i = 0, points = f.points; i < points; i += W) {
      const Float<W> x = Float<W>::load(a.dx + i), y = Float<W>::load(a.dy + i);
      HWY_NAMESPACE::sqrt(x * x + y * y).store(r + i);
    }
  }
}
template <int W, bool kArea>
void swept(const Frame& f, const uint32_t* w) {
  for (uint32_t i = 0, points = f.points; i < points; i += W) {
    const Dual3<W> p = DualWords<W>::triple(f, w + 1, i);
    const Vec3<W> n = crossOf(p.alongX(), p.alongY());
    if constexpr (kArea) lang::sqrt(dotOf(n, n)).store(f.cells[w[0]] + i);
    else PlainWords<W>::put(f, w, i, n);
  }
}

template <int W>
constexpr KernelFunction kVector[] = {
#define KN_X(name) &each<name, PlainWords<W>, W>, &each<name, DualWords<W>, W>,
    KN_VM_VECTOR(KN_X)
#undef KN_X
    &matrixMul<W>, &matrixTranspose<W>, &matrixDeterminant<W>, &filterWidth<W>, &swept<W, true>, &swept<W, false>};
KN_VM_TABLES(kVector)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* vectorKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
