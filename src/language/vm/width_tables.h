// Turns a family's list of kernels into its tables, one for each width. A family's file defines, per target,
// `template <int W> constexpr KernelFunction kFamily[] = {...}`. Included per target: no include guard.
// KINORA_ONLY_WIDTH_16: width 16 alone, where a test brings sixteen lanes to AVX2 (tests/language/width16).
#include <kinora/simd/tables.h>

#undef KN_VM_TABLES
#ifdef KINORA_ONLY_WIDTH_16
#define KN_VM_TABLES(list) const KernelFunction* const kFamily16 = list<16>;
#define KN_VM_PICK(width) ((width) == 16 ? HWY_NAMESPACE::kFamily16 : nullptr)
#elif HWY_TARGET == HWY_AVX2
#define KN_VM_TABLES(list)                        \
  const KernelFunction* const kFamily1 = list<1>; \
  const KernelFunction* const kFamily4 = list<4>; \
  const KernelFunction* const kFamily8 = list<8>;
#else
#define KN_VM_TABLES(list) const KernelFunction* const kFamily16 = list<16>;
#endif
#ifndef KN_VM_PICK
#define KN_VM_PICK(width)              \
  ((width) == 1    ? N_AVX2::kFamily1  \
   : (width) == 4  ? N_AVX2::kFamily4  \
   : (width) == 8  ? N_AVX2::kFamily8  \
   : (width) == 16 ? N_AVX3::kFamily16 \
                   : nullptr)
#endif
