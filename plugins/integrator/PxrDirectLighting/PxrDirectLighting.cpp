// PxrDirectLighting: the forward path loop without indirect bounces; several light and bxdf samples a camera hit.
#define KINORA_KERNEL_FILE "plugins/integrator/PxrDirectLighting/PxrDirectLighting.cpp"
#include <kinora/integrator.h>
#include <iterator>
#include <new>
#include <kinora/simd/foreach_target.h>
#include <kinora/path_loop.h>

#ifndef PXRDIRECTLIGHTING_ONCE
#define PXRDIRECTLIGHTING_ONCE
namespace kinora::pxrDirectLighting {
enum : uint32_t { kBxdfSamples, kLightSamples };
constexpr Param kParams[] = {
    param::integer("numBxdfSamples", 4).range(1, 64).help("Bxdf samples of direct light at each camera hit."),
    param::integer("numLightSamples", 4).range(0, 64).help("Light samples at each camera hit."),
};
}  // namespace kinora::pxrDirectLighting
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

struct Runner {
  template <int W>
  static void integrate(const void* integrator, uint32_t, Group* group, const Services* services) {
    PathLoop<W>(group, services, *static_cast<const PathLoopOptions*>(integrator)).run();
  }
  template <int W>
  static constexpr IntegratorFunctions table() {
    return IntegratorFunctions{&integrate<W>};
  }
};
KINORA_WIDTH_TABLES(Runner, IntegratorFunctions)

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora {
namespace {
using namespace pxrDirectLighting;
void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&]() -> void* {
    auto* o = new PathLoopOptions();
    const auto count = [](int v, int least) { return uint32_t(v < least ? least : v > 1024 ? 1024 : v); };
    o->maxIndirectBounces = 0;
    o->indirectSamples = count(info->integer(kBxdfSamples), 1);
    o->lightSamples = count(info->integer(kLightSamples), 0);
    o->clampDepth = 1000;
    o->rouletteDepth = 1000;
    o->allowCaustics = true;
    return o;
  });
}
void destroy(void* p) { delete static_cast<PathLoopOptions*>(p); }
const WidthTable kTables[] = KINORA_ALL_WIDTHS;
constexpr IntegratorTraits kTraits{nullptr};
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::Integrator,
                             0,
                             "PxrDirectLighting",
                             "Direct light and emission only.",
                             kParams,
                             std::size(kParams),
                             kTables,
                             4,
                             &kTraits,
                             &create,
                             &destroy};
}  // namespace
KINORA_REGISTER(PxrDirectLighting, kDescriptor)
}  // namespace kinora
#endif
