// The author's layer of integrators; see integrator.h. Included per target: <kinora/simd/foreach_target.h>.
//
//   struct MyIntegrator {
//     using Data = ...;                                                          // of one node
//     template <int W> static void integrate(const Data&, uint32_t stage, Group&, const Services&);
//   };
//   KINORA_INTEGRATOR(MyIntegrator, .help = "...", .params = kParams, .setUp = setUp<Data>)
#include <kinora/integrator.h>

#include <memory>
#ifdef KINORA_KERNEL_FILE
#include <kinora/simd/foreach_target.h>
#endif
#include <kinora/math/sampling.h>
#include <kinora/random.h>

#ifndef KINORA_INTEGRATOR_PLUGIN
#define KINORA_INTEGRATOR_PLUGIN
namespace kinora {
// What an integrator declares; see IntegratorTraits.
struct IntegratorPlugin {
  using Functions = IntegratorFunctions;
  static constexpr Kind kKind = Kind::Integrator;
  const char* help = "";
  ListOf<Param> params = {};
  SetUp setUp = {};
  uint32_t (*stages)(const void* integrator, Stage* out, uint32_t capacity) = nullptr;
  uint32_t (*lists)(const void* integrator, RecordList* out, uint32_t capacity) = nullptr;
  uint32_t passSamples = 0;
  uint32_t (*scattersInMedia)(const void* integrator) = nullptr;
  uint32_t (*learning)(const void* integrator, Learning* out) = nullptr;
  uint32_t (*tellsLobesApart)(const void* integrator) = nullptr;
  constexpr IntegratorTraits traits() const {
    return {stages, lists, passSamples, scattersInMedia, learning, tellsLobesApart};
  }
};
}  // namespace kinora
#endif

#if defined(KINORA_INTEGRATOR_AUTHOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_INTEGRATOR_AUTHOR_H_TARGET
#undef KINORA_INTEGRATOR_AUTHOR_H_TARGET
#else
#define KINORA_INTEGRATOR_AUTHOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <class Integrator>
struct IntegratorRunner {
  using Data = typename Integrator::Data;
  template <int W>
  static void integrate(const void* data, uint32_t stage, Group* g, const Services* services) {
    Integrator::template integrate<W>(*static_cast<const Data*>(data), stage, *g, *services);
  }
  static void commit(const void* data, uint32_t stage, const CommitServices* services) {
    if constexpr (requires { &Integrator::commit; })
      Integrator::commit(*static_cast<const Data*>(data), stage, *services);
  }
  static void learn(const void* data, const LearnServices* services) {
    if constexpr (requires { &Integrator::learn; }) Integrator::learn(*static_cast<const Data*>(data), *services);
  }
  template <int W>
  static constexpr IntegratorFunctions table() {
    IntegratorFunctions f{&integrate<W>};
    if constexpr (requires { &Integrator::commit; }) f.commit = &commit;
    if constexpr (requires { &Integrator::learn; }) f.learn = &learn;
    return f;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif

#include <kinora/simd/tables.h>

// Ends the file of a plug-in, whose struct has its name.
#undef KINORA_INTEGRATOR
#define KINORA_INTEGRATOR(Name, ...) KINORA_PLUGIN(Name, IntegratorRunner<Name>, IntegratorPlugin, __VA_ARGS__)
