// Functions of two to four numbers, of which any may be uniform: asked at each vector, because here that costs
// little. Comparisons stand here too.
#define KINORA_KERNEL_FILE "language/vm/mixed.cpp"
#include "language/vm/kernel.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/fast_math.h"
#include "language/library/round_math.h"
#include "language/vm/access.h"
#include "language/vm/operations.h"
#include "language/vm/width_tables.h"

KINORA_KERNELS_BEGIN
using namespace kinora::language;
using namespace lang::operations;
using lang::Dual;

// Functions of the library, of plain numbers and of dual ones.
#define KN_OF_TWO(Name, function)     \
  struct Name {                       \
    template <class F>                \
    static KN_INLINE F of(F a, F b) { \
      return lang::function(a, b);    \
    }                                 \
  };
#define KN_OF_THREE(Name, function)        \
  struct Name {                            \
    template <class F>                     \
    static KN_INLINE F of(F a, F b, F c) { \
      return lang::function(a, b, c);      \
    }                                      \
  };
KN_OF_TWO(PowOp, pow)
KN_OF_TWO(Atan2Op, atan2)
KN_OF_TWO(FmodOp, fmod)
KN_OF_TWO(FloorModOp, mod)
KN_OF_THREE(ClampOp, clampTo)
KN_OF_THREE(MixOp, mix)
KN_OF_THREE(SmoothStepOp, smoothstep)
KN_OF_THREE(LinearStepOp, linearstep)
#undef KN_OF_TWO
#undef KN_OF_THREE
struct StepOp {
  template <int W>
  static KN_INLINE Float<W> of(Float<W> a, Float<W> b) {
    return lang::step(a, b);
  }
  template <int W>
  static KN_INLINE Dual<W> of(Dual<W> a, Dual<W> b) {
    return Dual<W>(lang::step(a.v, b.v));
  }
};
struct SelectOp {
  template <int W>
  static KN_INLINE Float<W> of(Float<W> a, Float<W> b, Float<W> c) {
    return lang::pick(a, b, c);
  }
  template <int W>
  static KN_INLINE Dual<W> of(Dual<W> a, Dual<W> b, Dual<W> c) {
    return lang::pick(a, b, c.v);
  }
};
// the third operand holds ints
struct SelectIOp {
  template <int W>
  static KN_INLINE Float<W> of(Float<W> a, Float<W> b, Float<W> c) {
    return lang::choose(asInt(c) != Int<W>(0), b, a);
  }
  template <int W>
  static KN_INLINE Dual<W> of(Dual<W> a, Dual<W> b, Dual<W> c) {
    return lang::choose(asInt(c.v) != Int<W>(0), b, a);
  }
};
struct SmoothLinearStepOp {
  template <class F>
  static KN_INLINE F of(F a, F b, F x, F eps) {
    return lang::smoothLinearstep(a, b, x, eps);
  }
};

// words of an operand here: plain {cell, step, varies}, dual {cell, step, dx, dy, derivStep, varies}
template <int W, class Op>
void plain2(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    const float *a = f.cells[w[2] + c * w[3]], *b = f.cells[w[5] + c * w[6]];
    const bool va = w[4], vb = w[7];
    KN_EACH(f, i, W) Op::of(lang::fetch<W>(a, i, va), lang::fetch<W>(b, i, vb)).store(r + i);
  }
}
template <int W, class Op>
void dual2(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    const lang::DualCells r(f, w + 1, c);
    const lang::DualOperand a(f, w + 4, c), b(f, w + 10, c);
    const bool va = w[9], vb = w[15];
    KN_EACH(f, i, W) r.put<W>(Op::of(a.get<W>(i, va), b.get<W>(i, vb)), i);
  }
}
template <int W, class Op>
void plain3(const Frame& f, const uint32_t* w) {
  for (uint32_t n = 0; n < w[0]; ++n) {
    float* r = f.cells[w[1] + n];
    const float *a = f.cells[w[2] + n * w[3]], *b = f.cells[w[5] + n * w[6]], *c = f.cells[w[8] + n * w[9]];
    const bool va = w[4], vb = w[7], vc = w[10];
    KN_EACH(f, i, W)
    Op::of(lang::fetch<W>(a, i, va), lang::fetch<W>(b, i, vb), lang::fetch<W>(c, i, vc)).store(r + i);
  }
}
template <int W, class Op>
void dual3(const Frame& f, const uint32_t* w) {
  for (uint32_t n = 0; n < w[0]; ++n) {
    const lang::DualCells r(f, w + 1, n);
    const lang::DualOperand a(f, w + 4, n), b(f, w + 10, n), c(f, w + 16, n);
    const bool va = w[9], vb = w[15], vc = w[21];
    KN_EACH(f, i, W) r.put<W>(Op::of(a.get<W>(i, va), b.get<W>(i, vb), c.get<W>(i, vc)), i);
  }
}
template <int W, class Op>
void plain4(const Frame& f, const uint32_t* w) {
  for (uint32_t n = 0; n < w[0]; ++n) {
    float* r = f.cells[w[1] + n];
    const float *a = f.cells[w[2] + n * w[3]], *b = f.cells[w[5] + n * w[6]], *c = f.cells[w[8] + n * w[9]],
                *d = f.cells[w[11] + n * w[12]];
    const bool va = w[4], vb = w[7], vc = w[10], vd = w[13];
    KN_EACH(f, i, W)
    Op::of(lang::fetch<W>(a, i, va), lang::fetch<W>(b, i, vb), lang::fetch<W>(c, i, vc), lang::fetch<W>(d, i, vd))
        .store(r + i);
  }
}
template <int W, class Op>
void dual4(const Frame& f, const uint32_t* w) {
  for (uint32_t n = 0; n < w[0]; ++n) {
    const lang::DualCells r(f, w + 1, n);
    const lang::DualOperand a(f, w + 4, n), b(f, w + 10, n), c(f, w + 16, n), d(f, w + 22, n);
    const bool va = w[9], vb = w[15], vc = w[21], vd = w[27];
    KN_EACH(f, i, W) r.put<W>(Op::of(a.get<W>(i, va), b.get<W>(i, vb), c.get<W>(i, vc), d.get<W>(i, vd)), i);
  }
}

// words: components, result, then operands {cell, step, varies}. All components must agree, or with Neq any may
// differ.
template <int W, class Op, bool kAny>
void compare(const Frame& f, const uint32_t* w) {
  float* r = f.cells[w[1]];
  const bool va = w[4], vb = w[7];
  if (w[0] == 1) {
    const float *a = f.cells[w[2]], *b = f.cells[w[5]];
    KN_EACH(f, i, W) lang::putAnswer(Op::of(lang::fetch<W>(a, i, va), lang::fetch<W>(b, i, vb)), r, i);
    return;
  }
  KN_EACH(f, i, W) {
    Mask<W> answer(!kAny);
    for (uint32_t c = 0; c < w[0]; ++c) {
      const Mask<W> one =
          Op::of(lang::fetch<W>(f.cells[w[2] + c * w[3]], i, va), lang::fetch<W>(f.cells[w[5] + c * w[6]], i, vb));
      answer = kAny ? answer | one : answer & one;
    }
    lang::putAnswer(answer, r, i);
  }
}
template <class Op>
constexpr bool kAnyOf = false;
template <>
constexpr bool kAnyOf<NeqF> = true;
template <>
constexpr bool kAnyOf<NeqI> = true;

template <int W>
constexpr KernelFunction kMixed[] = {
#define KN_X(name) &plain2<W, name##Op>, &dual2<W, name##Op>,
    KN_VM_MIXED2(KN_X)
#undef KN_X
#define KN_X(name) &plain3<W, name##Op>, &dual3<W, name##Op>,
        KN_VM_MIXED3(KN_X)
#undef KN_X
#define KN_X(name) &plain4<W, name##Op>, &dual4<W, name##Op>,
            KN_VM_MIXED4(KN_X)
#undef KN_X
#define KN_X(name) &compare<W, name, kAnyOf<name>>,
                KN_VM_COMPARE(KN_X)
#undef KN_X
};
KN_VM_TABLES(kMixed)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* mixedKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
