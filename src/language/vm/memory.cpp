// Copies, blends under a mask, and masks.
#define KINORA_KERNEL_FILE "language/vm/memory.cpp"
#include "language/vm/kernel.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/dual.h"
#include "language/vm/access.h"
#include "language/vm/width_tables.h"

KINORA_KERNELS_BEGIN
using namespace kinora::language;
using lang::chunkOf;
using lang::loadMask;
using lang::setChunks;
using lang::storeMask;

// cells, result, source, step
template <int W>
void copy(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    const float* a = f.cells[w[2] + c * w[3]];
    KN_EACH(f, i, W) Float<W>::load(a + i).store(r + i);
  }
}
template <int W>
void broadcast(const Frame& f, const uint32_t* w) {
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    const Float<W> a(f.cells[w[2] + c * w[3]][0]);
    KN_EACH(f, i, W) a.store(r + i);
  }
}
// cells, result, bits
template <int W>
void fill(const Frame& f, const uint32_t* w) {
  const Int<W> a(w[2]);
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    KN_EACH(f, i, W) lang::put(a, r, i);
  }
}
// cells, result, source, step, mask
template <int W>
void blend(const Frame& f, const uint32_t* w) {
  const float* m = f.cells[w[4]];
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    const float* a = f.cells[w[2] + c * w[3]];
    KN_EACH(f, i, W) storeWhere(loadMask<W>(m, i), Float<W>::load(a + i), r + i);
  }
}
template <int W>
void blendUniform(const Frame& f, const uint32_t* w) {
  const float* m = f.cells[w[4]];
  for (uint32_t c = 0; c < w[0]; ++c) {
    float* r = f.cells[w[1] + c];
    const Float<W> a(f.cells[w[2] + c * w[3]][0]);
    KN_EACH(f, i, W) storeWhere(loadMask<W>(m, i), a, r + i);
  }
}
// mask
template <int W>
void maskAll(const Frame& f, const uint32_t* w) {
  float* m = f.cells[w[0]];
  KN_EACH(f, i, W) storeMask(Mask<W>::firstN(int(f.points - i < W ? f.points - i : W)), m, i);
}
// then mask, else mask, any in then, any in else, mask, condition (int)
template <int W>
void maskSplit(const Frame& f, const uint32_t* w) {
  float *yes = f.cells[w[0]], *no = f.cells[w[1]];
  const float *m = f.cells[w[4]], *condition = f.cells[w[5]];
  uint32_t anyYes = 0, anyNo = 0;
  KN_EACH(f, i, W) {
    const Mask<W> live = loadMask<W>(m, i), holds = asInt(Float<W>::load(condition + i)) != Int<W>(0);
    storeMask(live & holds, yes, i);
    storeMask(live & !holds, no, i);
    anyYes |= chunkOf(live & holds, i);
    anyNo |= chunkOf(live & !holds, i);
  }
  setChunks(f.cells[w[2]], anyYes);
  setChunks(f.cells[w[3]], anyNo);
}
// mask &= condition (int); any
template <int W>
void maskAnd(const Frame& f, const uint32_t* w) {
  float* m = f.cells[w[0]];
  const float* condition = f.cells[w[1]];
  uint32_t any = 0;
  KN_EACH(f, i, W) {
    const Mask<W> live = loadMask<W>(m, i) & (asInt(Float<W>::load(condition + i)) != Int<W>(0));
    storeMask(live, m, i);
    any |= chunkOf(live, i);
  }
  setChunks(f.cells[w[2]], any);
}
// result, mask
template <int W>
void maskCopy(const Frame& f, const uint32_t* w) {
  float* r = f.cells[w[0]];
  const float* m = f.cells[w[1]];
  KN_EACH(f, i, W) Float<W>::load(m + i).store(r + i);
}
// mask &= not other
template <int W>
void maskClear(const Frame& f, const uint32_t* w) {
  float* m = f.cells[w[0]];
  const float* other = f.cells[w[1]];
  KN_EACH(f, i, W) storeMask(loadMask<W>(m, i) & !loadMask<W>(other, i), m, i);
}
// mask, any
template <int W>
void maskAny(const Frame& f, const uint32_t* w) {
  const float* m = f.cells[w[0]];
  uint32_t any = 0;
  KN_EACH(f, i, W) any |= chunkOf(loadMask<W>(m, i), i);
  setChunks(f.cells[w[1]], any);
}

template <int W>
constexpr KernelFunction kMemory[] = {&copy<W>,         &broadcast<W>, &fill<W>,      &blend<W>,
                                      &blendUniform<W>, &maskAll<W>,   &maskSplit<W>, &maskAnd<W>,
                                      &maskCopy<W>,     &maskClear<W>, &maskAny<W>};
KN_VM_TABLES(kMemory)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* memoryKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
