// Triples, matrices, and what reads derivatives. Formulas and their order of operations: reference osl-numerics, 8.
#define KINORA_KERNEL_FILE "language/vm/vector.cpp"
#include "language/vm/kernel.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/matrix.h"
#include "language/library/vector.h"
#include "language/vm/access.h"
#include "language/vm/operands.h"
#include "language/vm/width_tables.h"

KINORA_KERNELS_BEGIN
using namespace kinora::language;
using lang::Dual;
using lang::Dual3;

using lang::DualWords;
using lang::PlainWords;

template <int W>
KN_INLINE lang::Matrix<W> matrix(const Frame& f, const uint32_t* w, uint32_t i) {
  lang::Matrix<W> m;
  for (uint32_t k = 0; k < 16; ++k) m.m[k] = lang::fetch<W>(f.cells[w[0] + k], i, w[1]);
  return m;
}
template <int W>
KN_INLINE void putMatrix(const Frame& f, uint32_t cell, uint32_t i, const lang::Matrix<W>& m) {
  for (uint32_t k = 0; k < 16; ++k) m.m[k].store(f.cells[cell + k] + i);
}

// ---- the operations; T says plain or dual, `a` and so on are operands ----
#define KN_OPERATION(Name, ...)                                                                                 \
  template <class T>                                                                                            \
  struct Name {                                                                                                 \
    static KN_INLINE void run(const Frame& f, const uint32_t* r, const uint32_t* w, uint32_t i) { __VA_ARGS__ } \
  };
#define KN_TRIPLE(k) T::triple(f, w + (k)*T::kOperand, i)
#define KN_NUMBER(k) T::number(f, w + (k)*T::kOperand, i)
KN_OPERATION(Dot, T::put(f, r, i, lang::dot(KN_TRIPLE(0), KN_TRIPLE(1)));)
KN_OPERATION(Cross, T::put(f, r, i, lang::cross(KN_TRIPLE(0), KN_TRIPLE(1)));)
KN_OPERATION(Length, T::put(f, r, i, lang::length(KN_TRIPLE(0)));)
KN_OPERATION(Distance, T::put(f, r, i, lang::distance(KN_TRIPLE(0), KN_TRIPLE(1)));)
KN_OPERATION(SegmentDistance, T::put(f, r, i, lang::distance(KN_TRIPLE(0), KN_TRIPLE(1), KN_TRIPLE(2)));)
KN_OPERATION(Normalize, T::put(f, r, i, lang::normalize(KN_TRIPLE(0)));)
KN_OPERATION(Reflect, T::put(f, r, i, lang::reflect(KN_TRIPLE(0), KN_TRIPLE(1)));)
KN_OPERATION(Refract, T::put(f, r, i, lang::refract(KN_TRIPLE(0), KN_TRIPLE(1), KN_NUMBER(2)));)
KN_OPERATION(FaceForward, T::put(f, r, i, lang::faceforward(KN_TRIPLE(0), KN_TRIPLE(1), KN_TRIPLE(2)));)
KN_OPERATION(Rotate, T::put(f, r, i, lang::rotate(KN_TRIPLE(0), KN_NUMBER(1), typename T::V(), KN_TRIPLE(2)));)
// triple, then the matrix as a plain operand {cell, varies}
KN_OPERATION(TransformPoint,
             T::put(f, r, i, lang::transformPoint(matrix<T::kWidth>(f, w + T::kOperand, i), KN_TRIPLE(0)));)
KN_OPERATION(TransformVector,
             T::put(f, r, i, lang::transformVector(matrix<T::kWidth>(f, w + T::kOperand, i), KN_TRIPLE(0)));)
KN_OPERATION(TransformNormal,
             T::put(f, r, i, lang::transformNormalByInverse(matrix<T::kWidth>(f, w + T::kOperand, i), KN_TRIPLE(0)));)
#undef KN_OPERATION
#undef KN_TRIPLE
#undef KN_NUMBER

template <template <class> class Op, class T, int W>
void each(const Frame& f, const uint32_t* w) {
  KN_EACH(f, i, W) Op<T>::run(f, w, w + T::kResult, i);
}

// ---- matrices: result, then operands {cell, varies} ----
template <int W>
void matrixMul(const Frame& f, const uint32_t* w) {
  KN_EACH(f, i, W) putMatrix(f, w[0], i, matrix<W>(f, w + 1, i) * matrix<W>(f, w + 3, i));
}
template <int W>
void matrixTranspose(const Frame& f, const uint32_t* w) {
  KN_EACH(f, i, W) putMatrix(f, w[0], i, lang::transpose(matrix<W>(f, w + 1, i)));
}
template <int W>
void matrixDeterminant(const Frame& f, const uint32_t* w) {
  KN_EACH(f, i, W) lang::determinant(matrix<W>(f, w + 1, i)).store(f.cells[w[0]] + i);
}
template <int W>
void matrixInverse(const Frame& f, const uint32_t* w) {
  KN_EACH(f, i, W) putMatrix(f, w[0], i, lang::inverse(matrix<W>(f, w + 1, i)));
}

// ---- derivatives: components, result, operand as dual ----
template <int W>
void filterWidth(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    const lang::DualOperand a(f, w + 2, c);
    KN_EACH(f, i, W) lang::filterwidth(a.get<W>(i)).store(r + i);
  }
}
template <int W, bool kArea>
void swept(const Frame& f, const uint32_t* w) {
  KN_EACH(f, i, W) {
    const Dual3<W> p = DualWords<W>::triple(f, w + 1, i);
    if constexpr (kArea)
      lang::area(p).store(f.cells[w[0]] + i);
    else
      PlainWords<W>::put(f, w, i, lang::calculatenormal(p, Mask<W>(false)));
  }
}

template <int W>
constexpr KernelFunction kVector[] = {
#define KN_X(name) &each<name, PlainWords<W>, W>, &each<name, DualWords<W>, W>,
    KN_VM_VECTOR(KN_X)
#undef KN_X
        & matrixMul<W>,
    &matrixTranspose<W>,
    &matrixDeterminant<W>,
    &matrixInverse<W>,
    &filterWidth<W>,
    &swept<W, true>,
    &swept<W, false>};
KN_VM_TABLES(kVector)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* vectorKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
