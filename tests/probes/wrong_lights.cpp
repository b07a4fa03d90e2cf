// A path tracer that learns lights, but weighs those that rays meet as if it had chosen light samples by the light tree
// alone: light_learning_test.cpp must notice.
#define KINORA_STOCK_PLUGIN
#define KINORA_KERNEL_FILE "tests/probes/wrong_lights.cpp"
#include <kinora/guiding_teacher.h>
#include <kinora/integrator_author.h>
#include <kinora/path_loop.h>

#if KINORA_PLAIN
#include <atomic>

namespace kinora::wrongLights {
constexpr Param kParams[] = {param::number("clampLuminance", 1e30f).help("Ignored.")};
inline std::unique_ptr<PathLoopOptions> make(const CreateInfo&) {
  auto o = std::make_unique<PathLoopOptions>();
  o->maxIndirectBounces = 2;
  o->clampLuminance = 1e30f;
  o->allowCaustics = true;
  o->learnsLights = true;
  o->guiding = guiding::optionsFor(false, true);
  return o;
}
inline uint32_t learning(const void* data, Learning* out) {
  *out = guiding::learning(static_cast<const PathLoopOptions*>(data)->guiding);
  return 1;
}
using Asks = decltype(Services::lightHits);
inline std::atomic<Asks> asked{nullptr};
inline void askWithoutWeights(Group* group, RayList* list, RayKind kind, uint32_t n, const uint32_t* entries,
                              LightHits* hits) {
  const float* kept = group->lightWeights;
  group->lightWeights = nullptr;
  asked.load()(group, list, kind, n, entries, hits);
  group->lightWeights = kept;
}
}  // namespace kinora::wrongLights
#endif

KINORA_KERNELS_BEGIN
using namespace wrongLights;

struct WrongLights {
  using Data = PathLoopOptions;
  template <int W>
  static void integrate(const Data& options, uint32_t, Group& group, const Services& services) {
    Services wrong = services;
    asked = services.lightHits;
    wrong.lightHits = askWithoutWeights;
    PathLoop<W>(&group, &wrong, options).run();
  }
  static void learn(const Data& options, const LearnServices& services) { guiding::learn(options.guiding, services); }
};

KINORA_KERNELS_END

KINORA_INTEGRATOR(WrongLights, .help = "Learned choice of lights, of which lights met by rays do not know.",
                  .params = kParams, .setUp = setUpBy<make>, .scattersInMedia = scatterInMedia, .learning = learning)
