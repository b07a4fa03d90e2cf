// Compiles the including kernel file once per instruction set. Use, at the top of a kernel file:
//   #define KINORA_KERNEL_FILE "plugins/bxdf/Lambert/Lambert.cpp"   // path by which an #include finds this very file
//   #include <kinora/simd/foreach_target.h>
// Standard and plain headers must be included before this one, so that their inline functions stay plain code.
#include <kinora/simd/targets.h>
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE KINORA_KERNEL_FILE
#include <hwy/foreach_target.h>  // must come before highway.h
#include <kinora/simd/wide.h>
