// The frame of a kernel file, and how it becomes a plug-in. Included by every author's layer.
//   KINORA_KERNELS_BEGIN
//   ... functions over W points, compiled for each instruction set, in a namespace of their own ...
//   KINORA_KERNELS_END
//   KINORA_PLUGIN(Name, Runner, Plugin, .help = "...", .params = kParams)
// makes plug-in `Name` of a runner (LightRunner<MyLight>) and the members of its kind's description (LightPlugin);
// each author's layer has a shorter form of it.
//
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
#undef KINORA_PLUGIN
#if HWY_TARGET == HWY_AVX2  // the last pass
#define KINORA_PLUGIN(Name, Runner, Plugin, ...)                                 \
  KINORA_KERNELS_BEGIN                                                           \
  KINORA_WIDTH_TABLES(Runner, Plugin::Functions)                                 \
  KINORA_KERNELS_END                                                             \
  namespace kinora {                                                             \
  namespace HWY_NAMESPACE {                                                      \
  namespace {                                                                    \
  constexpr Plugin kPlugin{__VA_ARGS__};                                         \
  constexpr auto kTraits = kPlugin.traits();                                     \
  constexpr WidthTable kTables[] = KINORA_ALL_WIDTHS;                            \
  constexpr Descriptor kDescriptor = describe(#Name, kPlugin, kTables, kTraits); \
  }                                                                              \
  }                                                                              \
  KINORA_REGISTER(Name, HWY_NAMESPACE::kDescriptor)                              \
  }
#else
#define KINORA_PLUGIN(Name, Runner, Plugin, ...) \
  KINORA_KERNELS_BEGIN                           \
  KINORA_WIDTH_TABLES(Runner, Plugin::Functions) \
  KINORA_KERNELS_END
#endif
#ifndef KINORA_KERNELS_BEGIN
#define KINORA_KERNELS_BEGIN \
  HWY_BEFORE_NAMESPACE();    \
  namespace kinora {         \
  namespace HWY_NAMESPACE {  \
  namespace {
#define KINORA_KERNELS_END \
  }                        \
  }                        \
  }                        \
  HWY_AFTER_NAMESPACE();
#endif
#ifndef KINORA_ALL_WIDTHS
#define KINORA_ALL_WIDTHS                                                                          \
  {                                                                                                \
    {1, &N_AVX2::kTable1}, {4, &N_AVX2::kTable4}, {8, &N_AVX2::kTable8}, { 16, &N_AVX3::kTable16 } \
  }
#endif
