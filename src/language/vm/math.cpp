// Functions of one number.
#define KINORA_KERNEL_FILE "language/vm/math.cpp"
#include "language/vm/kernel.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/fast_math.h"
#include "language/library/round_math.h"
#include "language/vm/access.h"
#include "language/vm/width_tables.h"

KINORA_KERNELS_BEGIN
using namespace kinora::language;
using lang::Dual;

#define KN_CALL(Name, function)  \
  struct Name##Op {              \
    template <class F>           \
    static KN_INLINE F of(F x) { \
      return function(x);        \
    }                            \
  };
KN_CALL(Neg, -)
KN_CALL(Abs, lang::abs)
KN_CALL(Sin, lang::sin)
KN_CALL(Cos, lang::cos)
KN_CALL(Tan, lang::tan)
KN_CALL(Asin, lang::asin)
KN_CALL(Acos, lang::acos)
KN_CALL(Atan, lang::atan)
KN_CALL(Sinh, lang::sinh)
KN_CALL(Cosh, lang::cosh)
KN_CALL(Tanh, lang::tanh)
KN_CALL(Exp, lang::exp)
KN_CALL(Exp2, lang::exp2)
KN_CALL(Expm1, lang::expm1)
KN_CALL(Log, lang::log)
KN_CALL(Log2, lang::log2)
KN_CALL(Log10, lang::log10)
KN_CALL(Sqrt, lang::sqrt)
KN_CALL(InverseSqrt, lang::inversesqrt)
KN_CALL(Cbrt, lang::cbrt)
KN_CALL(Erf, lang::erf)
KN_CALL(Erfc, lang::erfc)
KN_CALL(Floor, HWY_NAMESPACE::floor)
KN_CALL(Ceil, lang::ceil)
KN_CALL(Round, lang::round)
KN_CALL(Trunc, lang::trunc)
KN_CALL(Sign, lang::sign)
KN_CALL(Logb, lang::logb)
#undef KN_CALL
template <int W>
KN_INLINE Float<W> times(Float<W> x, float s) {
  return x * Float<W>(s);
}
template <int W>
KN_INLINE Dual<W> times(Dual<W> x, float s) {
  return x * Float<W>(s);
}
struct RadiansOp {
  template <class F>
  static KN_INLINE F of(F x) {
    return times(x, 0.0174532925199432958f);
  }
};
struct DegreesOp {
  template <class F>
  static KN_INLINE F of(F x) {
    return times(x, 57.2957795130823209f);
  }
};

template <int W, class Op>
void plain(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    const float* a = f.cells[w[2] + c * w[3]];
    KN_EACH(f, i, W) Op::of(Float<W>::load(a + i)).store(r + i);
  }
}
template <int W, class Op>
void dual(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    const lang::DualCells r(f, w + 1, c);
    const lang::DualOperand a(f, w + 4, c);
    KN_EACH(f, i, W) r.put<W>(Op::of(a.get<W>(i)), i);
  }
}

template <int W>
constexpr KernelFunction kMath[] = {
#define KN_X(name) &plain<W, name##Op>, &dual<W, name##Op>,
    KN_VM_UNARY(KN_X)
#undef KN_X
#define KN_X(name) &plain<W, name##Op>,
        KN_VM_ROUNDING(KN_X)
#undef KN_X
};
KN_VM_TABLES(kMath)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* mathKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
