// A path tracer whose manifold walks leave out the ratio of densities: manifold_test.cpp
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
  return o;
}
}  // namespace kinora::wrongWalks
#endif

KINORA_KERNELS_BEGIN
// In place of DensityRatio.
struct NoRatio {
  template <int W>
  static KN_INLINE Float<W> of(Float<W>) {
    return Float<W>(1.f);
  }
};
struct WrongWalks : RunsPathLoop<NoRatio> {};
KINORA_KERNELS_END

KINORA_INTEGRATOR(WrongWalks, .help = "Walks without their geometric term.", .params = wrongWalks::kParams,
                  .setUp = setUpBy<wrongWalks::make>, .scattersInMedia = scatterInMedia)
