// PxrDirectLighting: the forward path loop without indirect bounces; several light and bxdf samples a camera hit.
#define KINORA_KERNEL_FILE "plugins/integrator/PxrDirectLighting/PxrDirectLighting.cpp"
#include <kinora/integrator_author.h>
#include <kinora/path_loop.h>

#if KINORA_PLAIN
namespace kinora::pxrDirectLighting {
enum : uint32_t { kBxdfSamples, kLightSamples };
constexpr Param kParams[] = {
    param::integer("numBxdfSamples", 4).range(1, 64).help("Bxdf samples of direct light at each camera hit."),
    param::integer("numLightSamples", 4).range(0, 64).help("Light samples at each camera hit."),
};

std::unique_ptr<PathLoopOptions> make(const CreateInfo& info) {
  auto o = std::make_unique<PathLoopOptions>();
  const auto count = [](int v, int least) { return uint32_t(v < least ? least : v > 1024 ? 1024 : v); };
  o->maxIndirectBounces = 0;
  o->indirectSamples = count(info.integer(kBxdfSamples), 1);
  o->lightSamples = count(info.integer(kLightSamples), 0);
  o->clampDepth = 1000;
  o->rouletteDepth = 1000;
  o->allowCaustics = true;
  return o;
}
}  // namespace kinora::pxrDirectLighting
#endif

KINORA_KERNELS_BEGIN
struct PxrDirectLighting : RunsPathLoop<> {};
KINORA_KERNELS_END

KINORA_INTEGRATOR(PxrDirectLighting, .help = "Direct light and emission only.", .params = pxrDirectLighting::kParams,
                  .setUp = setUpBy<pxrDirectLighting::make>, .scattersInMedia = scatterInMedia)
