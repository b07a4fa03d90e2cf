// Two operations in one pass over a block: the value between them stays in a register, so that it is neither stored
// nor loaded and no instruction is dispatched for it. Each rounds as the two would. Chosen by
// CodeGenerator::findFused().
#define KINORA_KERNEL_FILE "language/vm/fused.cpp"
#include "language/vm/kernel.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/dual.h"
#include "language/vm/access.h"
#include "language/vm/operations.h"
#include "language/vm/width_tables.h"

KINORA_KERNELS_BEGIN
using namespace kinora::language;
using namespace lang::operations;

// Where results go: everywhere, or where a mask's points are.
template <int W, bool kMasked>
KN_INLINE void keep(Float<W> x, const float* mask, float* r, uint32_t i) {
  if constexpr (kMasked)
    storeWhere(lang::loadMask<W>(mask, i), x, r + i);
  else
    x.store(r + i);
}

struct SubFrom {
  template <int W>
  static KN_INLINE Float<W> of(Float<W> a, Float<W> b) {
    return b - a;
  }
};

// words: components, result, a, its step, b, its step, c, its step, mask where kMasked
template <int W, class First, class Second, bool kUniformA, bool kUniformB, bool kUniformC, bool kMasked>
void pair(const Frame& f, const uint32_t* w) {
  const float* mask = kMasked ? f.cells[w[8]] : nullptr;
  for (uint32_t n = 0; n < w[0]; ++n) {
    float* r = f.cells[w[1] + n];
    const float *a = f.cells[w[2] + n * w[3]], *b = f.cells[w[4] + n * w[5]], *c = f.cells[w[6] + n * w[7]];
    KN_EACH(f, i, W) {
      const Float<W> first = First::of(lang::fetch<kUniformA, W>(a, i), lang::fetch<kUniformB, W>(b, i));
      keep<W, kMasked>(Second::of(first, lang::fetch<kUniformC, W>(c, i)), mask, r, i);
    }
  }
}
// words: components, result, a, its step, b, its step, mask
template <int W, class Op, bool kUniformA, bool kUniformB>
void masked(const Frame& f, const uint32_t* w) {
  const float* mask = f.cells[w[6]];
  for (uint32_t n = 0; n < w[0]; ++n) {
    float* r = f.cells[w[1] + n];
    const float *a = f.cells[w[2] + n * w[3]], *b = f.cells[w[4] + n * w[5]];
    KN_EACH(f, i, W)
    keep<W, true>(Op::of(lang::fetch<kUniformA, W>(a, i), lang::fetch<kUniformB, W>(b, i)), mask, r, i);
  }
}

// {a, varies, b, varies}
template <int W, class Op>
struct Test {
  const float *a, *b;
  const bool va, vb;
  KN_INLINE Test(const Frame& f, const uint32_t* w) : a(f.cells[w[0]]), b(f.cells[w[2]]), va(w[1]), vb(w[3]) {}
  KN_INLINE Mask<W> at(uint32_t i) const { return Op::of(lang::fetch<W>(a, i, va), lang::fetch<W>(b, i, vb)); }
};
// words: components, result, condition, then {cell, step, varies} where it does not hold and where it does
template <int W, class Op>
void choose(const Frame& f, const uint32_t* w) {
  const Test<W, Op> condition(f, w + 2);
  const bool vno = w[8], vyes = w[11];
  for (uint32_t n = 0; n < w[0]; ++n) {
    float* r = f.cells[w[1] + n];
    const float *no = f.cells[w[6] + n * w[7]], *yes = f.cells[w[9] + n * w[10]];
    KN_EACH(f, i, W)
    lang::choose(condition.at(i), lang::fetch<W>(yes, i, vyes), lang::fetch<W>(no, i, vno)).store(r + i);
  }
}
// words: components, result, outer condition, inner condition, then {cell, step, varies} where neither holds, where
// only the inner one does, where the outer one does
template <int W, class Outer, class Inner>
void chooseTwice(const Frame& f, const uint32_t* w) {
  const Test<W, Outer> outer(f, w + 2);
  const Test<W, Inner> inner(f, w + 6);
  const bool v0 = w[12], v1 = w[15], v2 = w[18];
  for (uint32_t n = 0; n < w[0]; ++n) {
    float* r = f.cells[w[1] + n];
    const float *a = f.cells[w[10] + n * w[11]], *b = f.cells[w[13] + n * w[14]], *c = f.cells[w[16] + n * w[17]];
    KN_EACH(f, i, W) {
      const Float<W> first = lang::choose(inner.at(i), lang::fetch<W>(b, i, v1), lang::fetch<W>(a, i, v0));
      lang::choose(outer.at(i), lang::fetch<W>(c, i, v2), first).store(r + i);
    }
  }
}
// words: mask, any, condition. mask &= condition
template <int W, class Op>
void narrow(const Frame& f, const uint32_t* w) {
  float* m = f.cells[w[0]];
  const Test<W, Op> condition(f, w + 2);
  uint32_t any = 0;
  KN_EACH(f, i, W) {
    const Mask<W> live = lang::loadMask<W>(m, i) & condition.at(i);
    lang::storeMask(live, m, i);
    any |= lang::chunkOf(live, i);
  }
  lang::setChunks(f.cells[w[1]], any);
}
// words: mask, any, two conditions
template <int W, class Op, class Other>
void narrowTwice(const Frame& f, const uint32_t* w) {
  float* m = f.cells[w[0]];
  const Test<W, Op> condition(f, w + 2);
  const Test<W, Other> other(f, w + 6);
  uint32_t any = 0;
  KN_EACH(f, i, W) {
    const Mask<W> live = lang::loadMask<W>(m, i) & condition.at(i) & other.at(i);
    lang::storeMask(live, m, i);
    any |= lang::chunkOf(live, i);
  }
  lang::setChunks(f.cells[w[1]], any);
}
// words: then mask, else mask, any in then, any in else, mask, condition
template <int W, class Op>
void split(const Frame& f, const uint32_t* w) {
  float *yes = f.cells[w[0]], *no = f.cells[w[1]];
  const float* m = f.cells[w[4]];
  const Test<W, Op> condition(f, w + 5);
  uint32_t anyYes = 0, anyNo = 0;
  KN_EACH(f, i, W) {
    const Mask<W> live = lang::loadMask<W>(m, i), holds = condition.at(i);
    lang::storeMask(live & holds, yes, i);
    lang::storeMask(live & !holds, no, i);
    anyYes |= lang::chunkOf(live & holds, i);
    anyNo |= lang::chunkOf(live & !holds, i);
  }
  lang::setChunks(f.cells[w[2]], anyYes);
  lang::setChunks(f.cells[w[3]], anyNo);
}

template <int W>
constexpr KernelFunction kFused[] = {
#define KN_SECOND(First, ua, ub, Second)                                                       \
  &pair<W, First, Second, ua, ub, false, false>, &pair<W, First, Second, ua, ub, false, true>, \
      &pair<W, First, Second, ua, ub, true, false>, &pair<W, First, Second, ua, ub, true, true>,
#define KN_FIRST(First, ua, ub) \
  KN_SECOND(First, ua, ub, Add) \
  KN_SECOND(First, ua, ub, Sub) \
  KN_SECOND(First, ua, ub, SubFrom) KN_SECOND(First, ua, ub, Mul) KN_SECOND(First, ua, ub, Div)
    KN_FIRST(Add, false, false) KN_FIRST(Add, false, true) KN_FIRST(Mul, false, false) KN_FIRST(Mul, false, true)
        KN_FIRST(Sub, false, false) KN_FIRST(Sub, true, false) KN_FIRST(Sub, false, true)
#undef KN_FIRST
#undef KN_SECOND
#define KN_X(Op) &masked<W, Op, false, false>, &masked<W, Op, true, false>, &masked<W, Op, false, true>,
            KN_VM_BINARY(KN_X)
#undef KN_X
#define KN_X(Op) &choose<W, Op>,
                KN_VM_CONDITION(KN_X)
#undef KN_X
#define KN_X(Op) &narrow<W, Op>,
                    KN_VM_CONDITION(KN_X)
#undef KN_X
#define KN_X(Op) &split<W, Op>,
                        KN_VM_CONDITION(KN_X)
#undef KN_X
#define KN_TWO(kernel, First) \
  &kernel<W, First, LtF>, &kernel<W, First, LeF>, &kernel<W, First, LtI>, &kernel<W, First, LeI>,
#define KN_FOUR(kernel) KN_TWO(kernel, LtF) KN_TWO(kernel, LeF) KN_TWO(kernel, LtI) KN_TWO(kernel, LeI)
                            KN_FOUR(chooseTwice) KN_FOUR(narrowTwice)
#undef KN_FOUR
#undef KN_TWO
};
KN_VM_TABLES(kFused)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* fusedKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
