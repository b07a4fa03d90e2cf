// Which instruction sets kernels are compiled for. Included before any Highway header, by every kernel file; nothing
// here runs. Kernels exist for AVX2 with FMA (widths 1, 4, 8) and for AVX-512 (width 16); the dispatcher picks at run
// time.
#pragma once
#if defined(HIGHWAY_HWY_BASE_H_) && !defined(KINORA_TARGETS_SET)
#error "include <kinora/...> before any Highway header"
#endif
#define KINORA_TARGETS_SET
// The least CPU is AVX2 with FMA, so AVX2 is the static target; file-wide -m flags are never used (they would leak
// instructions into weak inline symbols), Highway's target pragmas are.
#ifndef HWY_BASELINE_TARGETS
#define HWY_BASELINE_TARGETS HWY_AVX2
#endif
#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_AVX3_DL | HWY_SSE4 | HWY_SSSE3)
#endif
