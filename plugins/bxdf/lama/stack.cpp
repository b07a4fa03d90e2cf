// The functions of functions.h: the one place where a tree of slabs is compiled.
#define KINORA_KERNEL_FILE "plugins/bxdf/lama/stack.cpp"
#include <kinora/bxdf.h>
#include <iterator>
#include <new>
#include <kinora/simd/foreach_target.h>
#include <kinora/bxdf_author.h>
#include <kinora/math/microfacet.h>
#include "functions.h"
#include "stack.h"
#include "plugins/bxdf/lobes/subsurface.h"

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
struct Slabs {
  using Closure = lama::Closure;
  template <int W>
  using Lanes = SlabTree<W>;
};
using SlabRunner = BxdfRunner<Slabs>;
}  // namespace

template <int W>
void SlabFunctions<W>::generate(const Context* c, const void* closure, const GenerateArgs* a) {
  SlabRunner::generate<W>(c, closure, a);
}
template <int W>
void SlabFunctions<W>::evaluate(const Context* c, const void* closure, const EvaluateArgs* a) {
  SlabRunner::evaluate<W>(c, closure, a);
}
template <int W>
void SlabFunctions<W>::evaluateAt(const Context* c, const void* closure, uint32_t point, uint32_t n,
                                  const EvaluateArgs* a) {
  SlabRunner::evaluateAt<W>(c, closure, point, n, a);
}
template <int W>
void SlabFunctions<W>::emission(const Context* c, const void* closure, float* const rgb[3]) {
  const lama::Closure& k = *static_cast<const lama::Closure*>(closure);
  for (uint32_t i = 0; i < c->count; i += W) {
    Rgb<W> sum;
    if (k.glows) sum = SlabTree<W>(k, Surface<W>(*c, At{i, false})).emission();
    sum.store(rgb, i);
  }
}
template <int W>
void SlabFunctions<W>::albedo(const Context* c, const void* closure, float* const rgb[3]) {
  SlabRunner::albedo<W>(c, closure, rgb);
}
template <int W>
void SlabFunctions<W>::straight(const Context* c, const void* closure, float* const rgb[3]) {
  const lama::Closure& k = *static_cast<const lama::Closure*>(closure);
  for (uint32_t i = 0; i < c->count; i += W) {
    const Surface<W> s(*c, At{i, false});
    SlabTree<W>(k, s).straight(s).store(rgb, i);
  }
}
template <int W>
void SlabFunctions<W>::subsurface(const Context* c, const void* closure, Subsurface* out) {
  const auto& k = *static_cast<const lama::Closure*>(closure);
  lobes::describeSubsurface(*c, k.below[out->which < lama::kMaxBelow ? out->which : 0], *out);
}

#if HWY_TARGET == HWY_AVX2
template struct SlabFunctions<1>;
template struct SlabFunctions<4>;
template struct SlabFunctions<8>;
#else
template struct SlabFunctions<16>;
#endif

void slabInterior(const Context* c, const lama::Closure& k, const InteriorArgs* a) {
  for (uint32_t i = 0; i < c->padded; ++i) {
    a->ior[i] = 1;
    for (int channel = 0; channel < 3; ++channel) a->absorption[channel][i] = 0;
    if (k.glass < 0) continue;
    const lama::Leaf& leaf = k.leaves[k.glass];
    const Value &ior = leaf.glass.ior, &color = leaf.absorption, &radius = leaf.absorptionRadius;
    a->ior[i] = ior.data[0][ior.stride ? i : 0];
    if (!color.components) continue;
    const float distance = radius.data[0][radius.stride ? i : 0];
    for (int channel = 0; channel < 3; ++channel) {
      // the colour is what is left after the distance
      const float left = color.data[channel][color.stride ? i : 0], most = left < 1e-4f ? 1e-4f : left;
      const float depth = most < 1 ? -log(Float<8>(most)).lane0() : 0.f;
      a->absorption[channel][i] = distance > 0 ? depth / distance : 0.f;
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
