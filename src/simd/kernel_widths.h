// A kernel's instances for the widths that a target has, and the choice among them. Included per target, after
// kinora/simd/foreach_target.h: no include guard. Between KINORA_KERNELS_BEGIN and
// KINORA_KERNELS_END
//   #define KN_X(W) [[maybe_unused]] void cross##W(const Args& a) { cross<W>(a); }
//   KN_EACH_WIDTH(KN_X)
//   #undef KN_X
// or, where pointers to the instances of a template will do, KN_POINTERS(kCross, cross);
// and after them, under HWY_ONCE, KN_PICK_WIDTH(width, cross). simd/dispatch.h stands before both.
#include <kinora/simd/tables.h>

#undef KN_EACH_WIDTH
#undef KN_POINTERS
#if HWY_TARGET == HWY_AVX2
#define KN_EACH_WIDTH(X) X(1) X(4) X(8)
#define KN_POINTERS(name, kernel) \
  [[maybe_unused]] constexpr auto name##1 = &kernel<1>, name##4 = &kernel<4>, name##8 = &kernel<8>;
#else
#define KN_EACH_WIDTH(X) X(16)
#define KN_POINTERS(name, kernel) [[maybe_unused]] constexpr auto name##16 = &kernel<16>;
#endif
#ifndef KN_PICK_WIDTH
#define KN_PICK_WIDTH(width, name) \
  kernelFor(width, &N_AVX2::name##1, &N_AVX2::name##4, &N_AVX2::name##8, &N_AVX3::name##16)
#endif
