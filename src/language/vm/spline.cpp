// Splines over arrays of knots.
#define KINORA_KERNEL_FILE "language/vm/spline.cpp"
#include "language/vm/kernel.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/spline.h"
#include "language/vm/access.h"
#include "language/vm/operands.h"
#include "language/vm/width_tables.h"

KINORA_KERNELS_BEGIN
using namespace kinora::language;
using lang::DualKnots;
using lang::DualWords;
using lang::PlainWords;
using lang::UniformKnots;
using lang::VaryingKnots;

// Where the knots of a block lie, from point i on.
template <int C, class Knots>
struct Source;
template <int C>
struct Source<C, UniformKnots> {
  static KN_INLINE UniformKnots at(const Frame& f, uint32_t cell, uint32_t) { return {f.cells[cell], C}; }
};
template <int C>
struct Source<C, VaryingKnots> {
  static KN_INLINE VaryingKnots at(const Frame& f, uint32_t cell, uint32_t i) {
    const int component = int(f.cells[cell + 1] - f.cells[cell]);  // cells of an array are equally far apart
    return {f.cells[cell] + i, component * C, component};
  }
};

template <class T, int W, int C, class Knots>
void curve(const Frame& f, const uint32_t* w) {
  using F = typename T::F;
  KN_EACH(f, i, W) {
    F r[C];
    lang::spline<C>(SplineBasis(w[0]), T::number(f, w + 5 + T::kResult, i), int(w[1]),
                    Source<C, Knots>::at(f, w[2], i), r);
    for (int c = 0; c < C; ++c) T::put(f, w + 5, i, r[c], uint32_t(c));
  }
}
template <int W, int C>
void dualKnots(const Frame& f, const uint32_t* w) {
  using T = DualWords<W>;
  KN_EACH(f, i, W) {
    lang::Dual<W> r[C];
    const DualKnots<VaryingKnots> knots{Source<C, VaryingKnots>::at(f, w[2], i),
                                        Source<C, VaryingKnots>::at(f, w[3], i),
                                        Source<C, VaryingKnots>::at(f, w[4], i)};
    lang::spline<C>(SplineBasis(w[0]), T::number(f, w + 5 + T::kResult, i), int(w[1]), knots, r);
    for (int c = 0; c < C; ++c) T::put(f, w + 5, i, r[c], uint32_t(c));
  }
}
template <class T, int W, class Knots>
void inverse(const Frame& f, const uint32_t* w) {
  KN_EACH(f, i, W)
  T::put(f, w + 5, i,
         lang::splineinverse(SplineBasis(w[0]), T::number(f, w + 5 + T::kResult, i), int(w[1]),
                             Source<1, Knots>::at(f, w[2], i)),
         0);
}

template <int W>
constexpr KernelFunction kSpline[] = {
#define KN_X(C)                                                                         \
  &curve<PlainWords<W>, W, C, UniformKnots>, &curve<PlainWords<W>, W, C, VaryingKnots>, \
      &curve<DualWords<W>, W, C, UniformKnots>, &curve<DualWords<W>, W, C, VaryingKnots>, &dualKnots<W, C>,
    KN_X(1) KN_X(3)
#undef KN_X
        & inverse<PlainWords<W>, W, UniformKnots>,
    &inverse<PlainWords<W>, W, VaryingKnots>, &inverse<DualWords<W>, W, UniformKnots>,
    &inverse<DualWords<W>, W, VaryingKnots>};
KN_VM_TABLES(kSpline)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* splineKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
