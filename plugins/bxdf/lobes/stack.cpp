// The functions of stack_functions.h: the one place where a stack of lobes is compiled.
#define KINORA_KERNEL_FILE "plugins/bxdf/lobes/stack.cpp"
#include <kinora/bxdf.h>
#include <iterator>
#include <new>
#include <kinora/simd/foreach_target.h>
#include <kinora/bxdf_author.h>
#include <kinora/math/microfacet.h>
#include "stack_functions.h"
#include "stack_evaluate.h"
#include "stack_sample.h"
#include "interface.h"
#include "subsurface.h"

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
struct Stack {
  using Closure = lobes::Closure;
  template <int W>
  using HasEmission = void;
  template <int W>
  static HWY_ATTR Rgb<W> emission(const Closure& k, At where) {
    return k.glows ? loadRgb<W>(k.glowColor, where) * loadFloat<W>(k.glowGain, where) : Rgb<W>();
  }
  template <int W>
  using Lanes = LobeStack<W>;
};
using StackRunner = BxdfRunner<Stack>;
}  // namespace

template <int W>
void StackFunctions<W>::generate(const Context* c, const void* closure, const GenerateArgs* a) {
  StackRunner::generate<W>(c, closure, a);
}
template <int W>
void StackFunctions<W>::evaluate(const Context* c, const void* closure, const EvaluateArgs* a) {
  StackRunner::evaluate<W>(c, closure, a);
}
template <int W>
void StackFunctions<W>::evaluateAt(const Context* c, const void* closure, uint32_t point, uint32_t n,
                                   const EvaluateArgs* a) {
  StackRunner::evaluateAt<W>(c, closure, point, n, a);
}
template <int W>
void StackFunctions<W>::emission(const Context* c, const void* closure, float* const rgb[3]) {
  StackRunner::emission<W>(c, closure, rgb);
}
template <int W>
void StackFunctions<W>::albedo(const Context* c, const void* closure, float* const rgb[3]) {
  StackRunner::albedo<W>(c, closure, rgb);
}
template <int W>
void StackFunctions<W>::subsurface(const Context* c, const void* closure, Subsurface* out) {
  const auto& k = *static_cast<const lobes::Closure*>(closure);
  if (out->surface[0]) lobes::describeSubsurface(*c, k.subsurface, *out);
  if (out->single.ior) {
    lobes::describeSingle(*c, k.single, out->single);
    if (!out->surface[0]) out->comesOutBehind = k.single.comesOutBehind;
  }
  out->leavesOutSingle = k.has(lobes::kSingleScatter) && k.single.scatters;
}

template <int W>
void StackFunctions<W>::interface(const Context* c, const void* closure, const InterfaceArgs* a) {
  StackInterface<W>::describe(c, closure, a);
}
template <int W>
void StackFunctions<W>::interfaceValue(const Context* c, const void* closure, const InterfaceValueArgs* a) {
  StackInterface<W>::value(c, closure, a);
}

#if HWY_TARGET == HWY_AVX2
template struct StackFunctions<1>;
template struct StackFunctions<4>;
template struct StackFunctions<8>;
#else
template struct StackFunctions<16>;
#endif

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
