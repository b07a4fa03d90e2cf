// Compiles the including kernel file once per instruction set. Use, at the top of a kernel file:
//   #define KINORA_KERNEL_FILE "plugins/bxdf/Lambert/Lambert.cpp"   // path by which an #include finds this very file
//   #include <kinora/bxdf_author.h>                                 // or another author's layer, which includes this
//   one
// Standard and plain headers must be included before that, so that their inline functions stay plain code. What must
// stand once (data of nodes, set-up code) goes into #if KINORA_PLAIN ... #endif.
#if defined(KINORA_FOREACH_TARGET_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#include <kinora/simd/targets.h>
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE KINORA_KERNEL_FILE
#include <hwy/foreach_target.h>  // must come before highway.h
#include <kinora/simd/wide.h>
#ifdef KINORA_FOREACH_TARGET_H_TARGET
#undef KINORA_FOREACH_TARGET_H_TARGET
#else
#define KINORA_FOREACH_TARGET_H_TARGET
#endif

// 1 in the first pass over the file
#undef KINORA_PLAIN
#ifdef KINORA_HAD_PASS
#define KINORA_PLAIN 0
#else
#define KINORA_PLAIN 1
#define KINORA_HAD_PASS
#endif
#endif
