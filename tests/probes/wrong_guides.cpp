// A guided path tracer that reckons with a density of directions half as large again as the one they are sampled with:
// guiding_test.cpp must notice.
#define KINORA_STOCK_PLUGIN
#define KINORA_KERNEL_FILE "tests/probes/wrong_guides.cpp"
#include <kinora/guiding_teacher.h>
#include <kinora/integrator_author.h>
#include <kinora/path_loop.h>

#if KINORA_PLAIN
namespace kinora::wrongGuides {
constexpr Param kParams[] = {param::number("factor", 1.5f).help("On the learned density; 1 is right.")};

struct Options {
  PathLoopOptions path;
  float factor;
};
std::unique_ptr<Options> make(const CreateInfo& info) {
  auto o = std::make_unique<Options>();
  o->path.clampLuminance = 1e30f;
  o->path.allowCaustics = true;
  o->path.guides = true;
  o->path.guiding.samples = 16;
  o->factor = info.number(0);
  return o;
}
uint32_t learning(const void* data, Learning* out) {
  *out = guiding::learning(static_cast<const Options*>(data)->path.guiding);
  return 1;
}

// Services that remember which state was made.
struct Watched {
  LearnServices services;  // first: makeState() finds the rest by it
  const LearnServices* inner;
  void* made = nullptr;
};
void* makeState(const LearnServices* services, uint64_t bytes) {
  auto* watched = const_cast<Watched*>(reinterpret_cast<const Watched*>(services));
  return watched->made = watched->inner->makeState(watched->inner, bytes);
}
void learnWrongly(const Options& o, const LearnServices& services) {
  Watched watched{services, &services};
  watched.services.makeState = makeState;
  guiding::learn(o.path.guiding, watched.services);
  auto* state = static_cast<guiding::State*>(watched.made);
  if (!state) return;
  float* density = state->floats(state->density);
  for (uint32_t i = 0; i < state->regions * guiding::kCells; ++i) density[i] *= o.factor;
}
}  // namespace kinora::wrongGuides
#endif

KINORA_KERNELS_BEGIN
using namespace wrongGuides;

struct WrongGuides {
  using Data = wrongGuides::Options;
  template <int W>
  static void integrate(const Data& options, uint32_t, Group& group, const Services& services) {
    PathLoop<W>(&group, &services, options.path).run();
  }
  static void learn(const Data& options, const LearnServices& services) { learnWrongly(options, services); }
};

KINORA_KERNELS_END

KINORA_INTEGRATOR(WrongGuides, .help = "Guides by a density that is not that of its directions.", .params = kParams,
                  .setUp = setUpBy<make>, .scattersInMedia = scatterInMedia, .learning = learning)
