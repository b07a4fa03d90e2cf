// Cheap operations of two numbers. Each of them exists for operands that vary or are uniform, plain and dual: here the
// dispatch is most of the time.
#define KINORA_KERNEL_FILE "language/vm/arithmetic.cpp"
#include "language/vm/kernel.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/dual.h"
#include "language/vm/access.h"
#include "language/vm/width_tables.h"

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using namespace kinora::language;
using lang::Dual;

struct AddOp {
  template <class A, class B>
  static KN_INLINE auto of(A a, B b) { return a + b; }
};
struct SubOp {
  template <class A, class B>
  static KN_INLINE auto of(A a, B b) { return a - b; }
};
struct MulOp {
  template <class A, class B>
  static KN_INLINE auto of(A a, B b) { return a * b; }
};
struct DivOp {
  template <class A, class B>
  static KN_INLINE auto of(A a, B b) { return lang::divide(a, b); }
  template <int W>
  static KN_INLINE Dual<W> of(Float<W> a, Dual<W> b) { return lang::divide(Dual<W>(a), b); }
};
// by a divisor that is known not to be 0
struct DivPlainOp {
  template <int W>
  static KN_INLINE Float<W> of(Float<W> a, Float<W> b) { return a / b; }
  template <class A, class B>
  static KN_INLINE auto of(A a, B b) { return DivOp::of(a, b); }
  template <int W>
  static KN_INLINE Dual<W> of(Dual<W> a, Float<W> b) {
    const Float<W> inverse = Float<W>(1.f) / b;
    return {a.v / b, inverse * a.dx, inverse * a.dy};
  }
};
struct MinOp {
  template <class A>
  static KN_INLINE A of(A a, A b) { return lang::least(a, b); }
  template <int W>
  static KN_INLINE Dual<W> of(Dual<W> a, Float<W> b) { return lang::least(a, Dual<W>(b)); }
  template <int W>
  static KN_INLINE Dual<W> of(Float<W> a, Dual<W> b) { return lang::least(Dual<W>(a), b); }
};
struct MaxOp {
  template <class A>
  static KN_INLINE A of(A a, A b) { return lang::greatest(a, b); }
  template <int W>
  static KN_INLINE Dual<W> of(Dual<W> a, Float<W> b) { return lang::greatest(a, Dual<W>(b)); }
  template <int W>
  static KN_INLINE Dual<W> of(Float<W> a, Dual<W> b) { return lang::greatest(Dual<W>(a), b); }
};

template <int W, class Op, bool kUniformA, bool kUniformB>
void plain(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    const float *a = f.cells[w[2] + c * w[3]], *b = f.cells[w[4] + c * w[5]];
    KN_EACH(f, i, W)
      Op::of(lang::fetch<kUniformA, W>(a, i), lang::fetch<kUniformB, W>(b, i)).store(r + i);
  }
}
template <int W, class Op, bool kUniformA, bool kUniformB>
void dual(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    const lang::DualCells r(f, w + 1, c);
    const lang::DualOperand a(f, w + 4, c), b(f, w + 9, c);
    KN_EACH(f, i, W) {
      if constexpr (kUniformA) r.put<W>(Op::of(Float<W>(a.v[0]), b.get<W>(i)), i);
      else if constexpr (kUniformB) r.put<W>(Op::of(a.get<W>(i), Float<W>(b.v[0])), i);
      else r.put<W>(Op::of(a.get<W>(i), b.get<W>(i)), i);
    }
  }
}

template <int W>
constexpr KernelFunction kArithmetic[] = {
#define KN_X(name)                                                                                           \
  &plain<W, name##Op, false, false>, &plain<W, name##Op, true, false>, &plain<W, name##Op, false, true>,     \
      &dual<W, name##Op, false, false>, &dual<W, name##Op, true, false>, &dual<W, name##Op, false, true>,
    KN_VM_BINARY(KN_X)
#undef KN_X
};
KN_VM_TABLES(kArithmetic)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* arithmeticKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
