// A path tracer whose manifold walks leave out the ratio of densities (ManifoldOptions::withoutTerm): manifold_test.cpp
// must notice.
#define KINORA_STOCK_PLUGIN
#define KINORA_KERNEL_FILE "tests/probes/wrong_walks.cpp"
#include <kinora/integrator_author.h>
#include <kinora/path_loop.h>

#if KINORA_PLAIN
namespace kinora::wrongWalks {
constexpr Param kParams[] = {param::number("clampLuminance", 1e30f).help("Ignored.")};
inline std::unique_ptr<PathLoopOptions> make(const CreateInfo&) {
  auto o = std::make_unique<PathLoopOptions>();
  o->maxIndirectBounces = 5;
  o->clampLuminance = 1e30f;
  o->rouletteThreshold = 1e-6f;
  o->allowCaustics = true;
  o->manifold.interfaces = 2;
  o->manifold.withoutTerm = true;
  return o;
}
}  // namespace kinora::wrongWalks
#endif

KINORA_KERNELS_BEGIN
using namespace wrongWalks;

struct WrongRunner {
  template <int W>
  static void integrate(const void* integrator, uint32_t, Group* group, const Services* services) {
    PathLoop<W>(group, services, *static_cast<const PathLoopOptions*>(integrator)).run();
  }
  template <int W>
  static constexpr IntegratorFunctions table() {
    return IntegratorFunctions{&integrate<W>};
  }
};

KINORA_KERNELS_END

KINORA_PLUGIN(WrongWalks, WrongRunner, IntegratorPlugin, .help = "Walks without their geometric term.",
              .params = kParams, .setUp = setUpBy<make>, .scattersInMedia = scatterInMedia)
