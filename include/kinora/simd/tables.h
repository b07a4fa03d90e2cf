// Turns a runner with `template <int W> static constexpr Functions table()` into the width tables of a descriptor.
// KINORA_WIDTH_TABLES stands inside the per-target namespace (in an unnamed one, so that plug-ins do not collide);
// KINORA_ALL_WIDTHS stands after it, under HWY_ONCE. All constant-initialised: nothing runs before the CPU is
// checked.
#undef KINORA_WIDTH_TABLES
#if HWY_TARGET == HWY_AVX2
#define KINORA_WIDTH_TABLES(Runner, Functions)               \
  constexpr Functions kTable1 = Runner::template table<1>(); \
  constexpr Functions kTable4 = Runner::template table<4>(); \
  constexpr Functions kTable8 = Runner::template table<8>();
#else
#define KINORA_WIDTH_TABLES(Runner, Functions) constexpr Functions kTable16 = Runner::template table<16>();
#endif
#ifndef KINORA_ALL_WIDTHS
#define KINORA_ALL_WIDTHS                                                                          \
  {                                                                                                \
    {1, &N_AVX2::kTable1}, {4, &N_AVX2::kTable4}, {8, &N_AVX2::kTable8}, { 16, &N_AVX3::kTable16 } \
  }
#endif
