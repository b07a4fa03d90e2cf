// PxrPathTracer: forward paths (kinora/path_loop.h) with the stock parameters.
#define KINORA_KERNEL_FILE "plugins/integrator/PxrPathTracer/PxrPathTracer.cpp"
#include <kinora/integrator_author.h>
#include <kinora/path_loop.h>

#if KINORA_PLAIN
namespace kinora::pxrPathTracer {
enum : uint32_t {
  kMaxBounces,
  kLightSamples,
  kIndirectSamples,
  kClampDepth,
  kClampLuminance,
  kRouletteDepth,
  kRouletteThreshold,
  kAllowCaustics
};
constexpr Param kParams[] = {
    param::integer("maxIndirectBounces", 8).range(0, 1000).help("Indirect bounces allowed; 0 is direct light only."),
    param::integer("numLightSamples", 1)
        .range(0, 64)
        .help("Light samples at each camera hit; deeper vertices take one."),
    param::integer("numIndirectSamples", 1).range(1, 64).help("Directions followed from each camera hit."),
    param::integer("clampDepth", 2)
        .range(1, 64)
        .help("Ray depth (the camera ray is 1) from which contributions are clamped."),
    param::number("clampLuminance", 10.f)
        .range(0, 1e30f)
        .help("Largest luminance of one contribution there; 1e30 is off."),
    param::integer("rouletteDepth", 4).range(1, 64).help("Path length from which Russian roulette is played."),
    param::number("rouletteThreshold", 0.2f)
        .range(0, 1)
        .help("Only paths whose throughput is below this play it; 0 is off."),
    param::integer("allowCaustics", 0)
        .range(0, 1)
        .options("0 off, 1 on")
        .help("Keep light that reaches a diffuse surface through mirrors or lenses; off: shadows of glass are tinted "
              "instead."),
    param::integer("accumOpacity", 0).range(0, 1).help("Refraction contributes partial alpha. No effect yet."),
    param::integer("numBxdfSamples", 1)
        .range(1, 64)
        .help("Accepted for old scenes; indirect directions serve as bxdf samples."),
    param::integer("numDiffuseSamples", 1).range(1, 64).help("Manual mode. No effect yet."),
    param::integer("numSpecularSamples", 1).range(1, 64).help("Manual mode. No effect yet."),
    param::integer("numRefractionSamples", 1).range(1, 64).help("Manual mode. No effect yet."),
    param::integer("numSubsurfaceSamples", 1).range(1, 64).help("Manual mode. No effect yet."),
    param::string("sampleMode", "bxdf").options("bxdf|manual").help("Manual mode has no effect yet."),
    param::integer("maxPathLength", -1).range(-1, 64).help("Old name: maxIndirectBounces + 1; -1 is not given."),
    param::integer("maxNonStochasticOpacityEvents", 0).range(0, 64).help("No effect yet: presence is stochastic."),
    param::integer("maxContinuationLength", -1).range(-1, 1000).help("No effect yet."),
    param::integer("risPathGuiding", 0).range(0, 1).help("No effect yet."),
    param::integer("jointSampling", 0).range(0, 1).help("Volumes. No effect yet."),
    param::number("jointScatteringBias", 0.5f).range(0, 1).help("Volumes. No effect yet."),
    param::integer("numVolumeAggregateSamples", 1).range(1, 64).help("Volumes. No effect yet."),
    param::string("volumeAggregate", "globalVolumeAggregate").help("Volumes. No effect yet."),
    param::string("volumeAggregateCamera", "").help("Volumes. No effect yet."),
    param::string("volumeAggregateIndirect", "").help("Volumes. No effect yet."),
    param::string("volumeAggregateTransmission", "").help("Volumes. No effect yet."),
};
enum : uint32_t { kMaxPathLength = 15 };

std::unique_ptr<PathLoopOptions> make(const CreateInfo& info) {
  auto o = std::make_unique<PathLoopOptions>();
  const int length = info.integer(kMaxPathLength);
  const int bounces = length > 0 && !info.values[kMaxBounces].given ? length - 1 : info.integer(kMaxBounces);
  const auto count = [](int v, int least, int most) { return uint32_t(v < least ? least : v > most ? most : v); };
  o->maxIndirectBounces = count(bounces, 0, 1000);
  o->lightSamples = count(info.integer(kLightSamples), 0, 1024);
  o->indirectSamples = count(info.integer(kIndirectSamples), 1, 1024);
  o->clampDepth = count(info.integer(kClampDepth), 0, 100000);
  o->clampLuminance = info.number(kClampLuminance);
  o->rouletteDepth = count(info.integer(kRouletteDepth), 0, 100000);
  o->rouletteThreshold = info.number(kRouletteThreshold);
  if (!(o->rouletteThreshold > 0)) o->rouletteDepth = 1u << 30;
  o->allowCaustics = info.integer(kAllowCaustics) != 0;
  return o;
}
}  // namespace kinora::pxrPathTracer
#endif

KINORA_KERNELS_BEGIN
using namespace pxrPathTracer;

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

KINORA_KERNELS_END

KINORA_PLUGIN(PxrPathTracer, Runner, IntegratorPlugin, .help = "Forward path tracing with next-event estimation.",
              .params = kParams, .setUp = setUpBy<make>, .scattersInMedia = 1)
