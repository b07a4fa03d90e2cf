// Integers, and what turns numbers into them.
#define KINORA_KERNEL_FILE "language/vm/integer.cpp"
#include "language/vm/kernel.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/round_math.h"
#include "language/vm/access.h"
#include "language/vm/width_tables.h"

KINORA_KERNELS_BEGIN
using namespace kinora::language;

template <int W>
KN_INLINE Int<W> answer(Mask<W> m) {
  return lang::choose(m, Int<W>(1), Int<W>(0));
}
#define KN_INT(Name, expression)                     \
  struct Name##Op {                                  \
    template <int W>                                 \
    static KN_INLINE Int<W> of(Int<W> a, Int<W> b) { \
      return expression;                             \
    }                                                \
  };
KN_INT(AddI, a + b)
KN_INT(SubI, a - b)
KN_INT(MulI, a* b)
KN_INT(DivI, lang::divide(a, b))
KN_INT(ModI, lang::remainder(a, b))
KN_INT(FloorModI, lang::mod(a, b))
KN_INT(AndBits, a& b)
KN_INT(OrBits, a | b)
KN_INT(XorBits, a ^ b)
KN_INT(Shl, lang::shiftLeft(a, b))
KN_INT(Shr, lang::shiftRight(a, b))
KN_INT(MinI, lang::choose(b < a, b, a))
KN_INT(MaxI, lang::choose(a < b, b, a))
KN_INT(AndI, answer((a != Int<W>(0)) & (b != Int<W>(0))))
KN_INT(OrI, answer((a != Int<W>(0)) | (b != Int<W>(0))))
#undef KN_INT

#define KN_INT1(Name, expression)          \
  struct Name##Op {                        \
    template <int W>                       \
    static KN_INLINE Int<W> of(Int<W> a) { \
      return expression;                   \
    }                                      \
  };
KN_INT1(NegI, Int<W>(0) - a)
KN_INT1(AbsI, lang::choose(a < Int<W>(0), Int<W>(0) - a, a))
KN_INT1(Complement, a ^ Int<W>(-1))
KN_INT1(ToFloat, asInt(toFloat(a)))
KN_INT1(ToInt, lang::toInteger(asFloat(a)))
KN_INT1(IsNan, answer(asFloat(a) != asFloat(a)))
KN_INT1(IsInf, answer((a & Int<W>(0x7fffffff)) == Int<W>(0x7f800000)))
KN_INT1(IsFinite, answer(isFinite(asFloat(a))))
KN_INT1(NotZeroF, answer(asFloat(a) != Float<W>(0.f)))
#undef KN_INT1

// words: components, result, then operands {cell, step, varies}
template <int W, class Op>
void two(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    const float *a = f.cells[w[2] + c * w[3]], *b = f.cells[w[5] + c * w[6]];
    const bool va = w[4], vb = w[7];
    KN_EACH(f, i, W) lang::put(Op::of(lang::fetchInt<W>(a, i, va), lang::fetchInt<W>(b, i, vb)), r, i);
  }
}
template <int W, class Op>
void one(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    const float* a = f.cells[w[2] + c * w[3]];
    KN_EACH(f, i, W) lang::put(Op::of(asInt(Float<W>::load(a + i))), r, i);
  }
}

template <int W>
constexpr KernelFunction kInteger[] = {
#define KN_X(name) &two<W, name##Op>,
    KN_VM_INT(KN_X)
#undef KN_X
#define KN_X(name) &one<W, name##Op>,
        KN_VM_INT1(KN_X)
#undef KN_X
};
KN_VM_TABLES(kInteger)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* integerKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
