// A stack of lobes as the functions of a bxdf, compiled once (stack.cpp) for all materials made of one: a material
// fills a lobes::Closure and takes the rest from here. Included per target.
#include <kinora/bxdf_author.h>
#include <new>
#include "closure.h"

#if defined(KINORA_LOBES_STACK_FUNCTIONS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_STACK_FUNCTIONS_H_TARGET
#undef KINORA_LOBES_STACK_FUNCTIONS_H_TARGET
#else
#define KINORA_LOBES_STACK_FUNCTIONS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
struct StackFunctions {
  static void generate(const Context* c, const void* closure, const GenerateArgs* a);
  static void evaluate(const Context* c, const void* closure, const EvaluateArgs* a);
  static void evaluateAt(const Context* c, const void* closure, uint32_t point, uint32_t n, const EvaluateArgs* a);
  static void emission(const Context* c, const void* closure, float* const rgb[3]);
  static void albedo(const Context* c, const void* closure, float* const rgb[3]);
  static void subsurface(const Context* c, const void* closure, Subsurface* out);
  // Of the glass, or where there is none of the first specular lobe.
  static void interface(const Context* c, const void* closure, const InterfaceArgs* a);
  static void interfaceValue(const Context* c, const void* closure, const InterfaceValueArgs* a);
};

// The table of a material M with
//   static void begin(const Context&, lobes::Closure&);                  // fills the closure
// and, if it likes, kGlows, kScatters, kWalkable, presence, interior and thinShadow, as BxdfRunner knows them.
template <class M>
struct StackMaterial {
  static void* begin(const Context* c) {
    lobes::Closure* k = new (c->alloc<lobes::Closure>(1)) lobes::Closure();
    M::begin(*c, *k);
    return k;
  }
  template <int W>
  static constexpr BxdfFunctions table() {
    BxdfFunctions f{};
    f.begin = &begin;
    f.generate = &StackFunctions<W>::generate;
    f.evaluate = &StackFunctions<W>::evaluate;
    f.evaluateAt = &StackFunctions<W>::evaluateAt;
    f.albedo = &StackFunctions<W>::albedo;
    if constexpr (requires { M::kScatters; }) f.subsurface = &StackFunctions<W>::subsurface;
    if constexpr (requires { M::kWalkable; }) {
      f.interface = &StackFunctions<W>::interface;
      f.interfaceValue = &StackFunctions<W>::interfaceValue;
    }
    if constexpr (requires { M::kGlows; }) f.emission = &StackFunctions<W>::emission;
    if constexpr (requires { &M::presence; }) f.presence = &M::presence;
    if constexpr (requires { &M::interior; }) f.interior = &M::interior;
    if constexpr (requires { &M::template thinShadow<W>; }) f.thinShadow = &M::template thinShadow<W>;
    return f;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif

#include <kinora/simd/tables.h>
