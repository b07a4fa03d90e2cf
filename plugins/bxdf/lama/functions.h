// A tree of slabs as the functions of a bxdf, compiled once (stack.cpp) for all materials made of one: a material
// fills a lama::Closure and takes the rest from here. Included per target.
#include <kinora/bxdf_author.h>
#include <new>
#include "closure.h"

#if defined(KINORA_LAMA_FUNCTIONS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LAMA_FUNCTIONS_H_TARGET
#undef KINORA_LAMA_FUNCTIONS_H_TARGET
#else
#define KINORA_LAMA_FUNCTIONS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
struct SlabFunctions {
  static void generate(const Context* c, const void* closure, const GenerateArgs* a);
  static void evaluate(const Context* c, const void* closure, const EvaluateArgs* a);
  static void evaluateAt(const Context* c, const void* closure, uint32_t point, uint32_t n, const EvaluateArgs* a);
  static void emission(const Context* c, const void* closure, float* const rgb[3]);
  static void albedo(const Context* c, const void* closure, float* const rgb[3]);
  static void straight(const Context* c, const void* closure, float* const rgb[3]);
  static void subsurface(const Context* c, const void* closure, Subsurface* out);
};
// Index and absorption of the medium behind the first leaf of glass.
void slabInterior(const Context* c, const lama::Closure& k, const InteriorArgs* a);

// The table of a material M with
//   static void begin(const Context&, lama::Closure&);                 // fills the closure
// and, if it likes, kGlass (it may be glass), kScatters (it may have subsurface scattering) and presence.
template <class M>
struct SlabMaterial {
  static lama::Closure* bind(const Context* c) {
    lama::Closure* k = new (c->alloc<lama::Closure>(1)) lama::Closure();
    k->context = c;
    k->radiance = !(c->traits & kTraitLightPath);
    M::begin(*c, *k);
    return k;
  }
  static void* begin(const Context* c) { return bind(c); }
  static void interior(const Context* c, const InteriorArgs* a) { slabInterior(c, *bind(c), a); }
  template <int W>
  static void thinShadow(const Context* c, float* const rgb[3]) {
    SlabFunctions<W>::straight(c, bind(c), rgb);
  }
  template <int W>
  static constexpr BxdfFunctions table() {
    BxdfFunctions f{};
    f.begin = &begin;
    f.generate = &SlabFunctions<W>::generate;
    f.evaluate = &SlabFunctions<W>::evaluate;
    f.evaluateAt = &SlabFunctions<W>::evaluateAt;
    f.albedo = &SlabFunctions<W>::albedo;
    f.emission = &SlabFunctions<W>::emission;
    if constexpr (requires { &M::presence; }) f.presence = &M::presence;
    if constexpr (requires { M::kScatters; }) f.subsurface = &SlabFunctions<W>::subsurface;
    if constexpr (requires { M::kGlass; }) {
      f.interior = &interior;
      f.thinShadow = &thinShadow<W>;
    }
    return f;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif

#include <kinora/simd/tables.h>
