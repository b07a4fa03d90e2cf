// PxrPathTracer: forward paths (kinora/path_loop.h) with the stock parameters.
#define KINORA_KERNEL_FILE "plugins/integrator/PxrPathTracer/PxrPathTracer.cpp"
#include <kinora/integrator_author.h>
#include <kinora/path_loop.h>

#if KINORA_PLAIN
#include <iterator>

#include "plugins/integrator/parts/path_parameters.h"
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
    pathParameters::kMaxIndirectBounces,
    pathParameters::kNumLightSamples,
    pathParameters::kNumIndirectSamples,
    pathParameters::kClampDepth,
    pathParameters::kClampLuminance,
    pathParameters::kRouletteDepth,
    pathParameters::kRouletteThreshold,
    param::integer("allowCaustics", 0)
        .range(0, 1)
        .options("0 off, 1 on")
        .help("Keep light that reaches a diffuse surface through mirrors or lenses; off: shadows of glass are tinted "
              "instead."),
    param::integer("accumOpacity", 0).range(0, 1).help("Refraction contributes partial alpha. No effect yet."),
    pathParameters::kNumBxdfSamples,
    param::integer("numDiffuseSamples", 1).range(1, 64).help("Manual mode. No effect yet."),
    param::integer("numSpecularSamples", 1).range(1, 64).help("Manual mode. No effect yet."),
    param::integer("numRefractionSamples", 1).range(1, 64).help("Manual mode. No effect yet."),
    param::integer("numSubsurfaceSamples", 1).range(1, 64).help("Manual mode. No effect yet."),
    param::string("sampleMode", "bxdf").options("bxdf|manual").help("Manual mode has no effect yet."),
    pathParameters::kMaxPathLength,
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
    pathParameters::kManifoldWalk,
    pathParameters::kMaxInterfaces,
    pathParameters::kMaxIterations,
};
enum : uint32_t { kMaxPathLength = 15 };

std::unique_ptr<PathLoopOptions> make(const CreateInfo& info) {
  namespace from = pathParameters;
  auto o = std::make_unique<PathLoopOptions>();
  o->maxIndirectBounces = from::bounces(info, kMaxBounces, kMaxPathLength, 1000);
  o->lightSamples = from::count(info, kLightSamples, 0, 1024);
  o->indirectSamples = from::count(info, kIndirectSamples, 1, 1024);
  o->clampDepth = from::count(info, kClampDepth, 0, 100000);
  o->clampLuminance = info.number(kClampLuminance);
  o->rouletteDepth = from::rouletteDepth(info, kRouletteDepth, kRouletteThreshold, 0);
  o->rouletteThreshold = info.number(kRouletteThreshold);
  o->allowCaustics = info.integer(kAllowCaustics) != 0;
  o->manifold = from::manifold(NamedValues(info, kParams, std::size(kParams)));
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
              .params = kParams, .setUp = setUpBy<make>, .scattersInMedia = scatterInMedia)
