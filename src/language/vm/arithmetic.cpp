// Cheap operations of two numbers. Each of them exists for operands that vary or are uniform, plain and dual: here
// the dispatch is most of the time.
#define KINORA_KERNEL_FILE "language/vm/arithmetic.cpp"
#include "language/vm/kernel.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/dual.h"
#include "language/vm/access.h"
#include "language/vm/operations.h"
#include "language/vm/width_tables.h"

KINORA_KERNELS_BEGIN
using namespace kinora::language;
using namespace lang::operations;

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
      if constexpr (kUniformA)
        r.put<W>(Op::of(Float<W>(a.v[0]), b.get<W>(i)), i);
      else if constexpr (kUniformB)
        r.put<W>(Op::of(a.get<W>(i), Float<W>(b.v[0])), i);
      else
        r.put<W>(Op::of(a.get<W>(i), b.get<W>(i)), i);
    }
  }
}

template <int W>
constexpr KernelFunction kArithmetic[] = {
#define KN_X(name)                                                                           \
  &plain<W, name, false, false>, &plain<W, name, true, false>, &plain<W, name, false, true>, \
      &dual<W, name, false, false>, &dual<W, name, true, false>, &dual<W, name, false, true>,
    KN_VM_BINARY(KN_X)
#undef KN_X
};
KN_VM_TABLES(kArithmetic)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* arithmeticKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
