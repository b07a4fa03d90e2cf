// Lattice noises and hashes. Signed and unsigned, periodic and plain share a kernel: they are told apart by words.
#define KINORA_KERNEL_FILE "language/vm/noise.cpp"
#include "language/vm/kernel.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/cell_noise.h"
#include "language/library/gabor.h"
#include "language/library/perlin.h"
#include "language/library/simplex.h"
#include "language/vm/access.h"
#include "language/vm/width_tables.h"

KINORA_KERNELS_BEGIN
using namespace kinora::language;
using lang::Dual;

template <int N, int W>
KN_INLINE const Float<W>* periods(const Frame& f, const uint32_t* w, uint32_t i, Float<W>* out) {
  for (int k = 0; k < N; ++k) out[k] = lang::fetch<W>(f.cells[w[3 * k]], i, w[3 * k + 2]);
  return out;
}
template <int W, class Kind, int N, int C>
void plain(const Frame& f, const uint32_t* w) {
  KN_EACH(f, i, W) {
    Float<W> x[N], p[N], r[C];
    for (int k = 0; k < N; ++k) x[k] = lang::fetch<W>(f.cells[w[3 + 3 * k]], i, w[5 + 3 * k]);
    Kind::template value<N, C, W>(x, w[1] ? periods<N>(f, w + 3 + 3 * N, i, p) : nullptr, r);
    for (int c = 0; c < C; ++c) (w[0] ? lang::toUnsigned(r[c]) : r[c]).store(f.cells[w[2] + c] + i);
  }
}
template <int W, class Kind, int N, int C>
void dual(const Frame& f, const uint32_t* w) {
  KN_EACH(f, i, W) {
    Dual<W> x[N], r[C];
    Float<W> p[N];
    for (int k = 0; k < N; ++k) x[k] = lang::DualOperand(f, w + 5 + 6 * k, 0).get<W>(i, w[5 + 6 * k + 5]);
    Kind::template dual<N, C, W>(x, w[1] ? periods<N>(f, w + 5 + 6 * N, i, p) : nullptr, r);
    for (int c = 0; c < C; ++c) lang::DualCells(f, w + 2, uint32_t(c)).put(w[0] ? lang::toUnsigned(r[c]) : r[c], i);
  }
}
template <int W, int N>
void hashWords(const Frame& f, const uint32_t* w) {
  KN_EACH(f, i, W) {
    Int<W> k[N];
    for (int n = 0; n < N; ++n) k[n] = lang::fetchInt<W>(f.cells[w[1 + 3 * n]], i, w[3 + 3 * n]);
    lang::put(lang::hashOf<N>(k), f.cells[w[0]], i);
  }
}

// 1 and 2 coordinates are points of an axis or a plane, a fourth one is ignored: one kernel serves all
template <int W, int C>
void gabor(const Frame& f, const uint32_t* w) {
  const uint32_t* x = w + 4;
  const uint32_t* period = x + 18;
  const uint32_t* option = period + 9;
  lang::GaborOptions<W> o;
  std::memcpy(&o.anisotropic, f.cells[option[0]], 4);
  int32_t filter;
  std::memcpy(&filter, f.cells[option[1]], 4);
  o.filter = filter != 0;
  KN_EACH(f, i, W) {
    Dual<W> p[3], r[C];
    Float<W> periodOf[3];
    for (int k = 0; k < 3; ++k) p[k] = lang::DualOperand(f, x + 6 * k, 0).get<W>(i, x[6 * k + 5]);
    const uint32_t* d = option + 2;
    o.direction = Vec3<W>(lang::fetch<W>(f.cells[d[0]], i, d[2]), lang::fetch<W>(f.cells[d[0] + d[1]], i, d[2]),
                          lang::fetch<W>(f.cells[d[0] + 2 * d[1]], i, d[2]));
    o.bandwidth = lang::fetch<W>(f.cells[d[3]], i, d[5]);
    o.impulses = lang::fetch<W>(f.cells[d[6]], i, d[8]);
    lang::GaborNoise::dual<3, C>(p, w[0] ? periods<3>(f, period, i, periodOf) : nullptr, o, r);
    for (int c = 0; c < C; ++c) lang::DualCells(f, w + 1, uint32_t(c)).put(r[c], i);
  }
}

template <int W>
constexpr KernelFunction kNoise[] = {
#define KN_X(Kind, N) &plain<W, Kind, N, 1>, &dual<W, Kind, N, 1>, &plain<W, Kind, N, 3>, &dual<W, Kind, N, 3>,
#define KN_ALL(Kind) KN_X(Kind, 1) KN_X(Kind, 2) KN_X(Kind, 3) KN_X(Kind, 4)
    KN_ALL(lang::PerlinNoise) KN_ALL(lang::SimplexNoise)
#undef KN_X
#define KN_X(Kind, N) &plain<W, Kind, N, 1>, &plain<W, Kind, N, 3>,
            KN_ALL(lang::CellNoise) KN_ALL(lang::HashNoise)
#undef KN_X
#undef KN_ALL
        & hashWords<W, 1>,
    &hashWords<W, 2>,
    &hashWords<W, 3>,
    &hashWords<W, 4>,
    &gabor<W, 1>,
    &gabor<W, 3>};
KN_VM_TABLES(kNoise)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* noiseKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
