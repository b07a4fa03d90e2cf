// PxrPathTracer: forward paths (kinora/path_loop.h) with the stock parameters.
#define KINORA_KERNEL_FILE "plugins/integrator/PxrPathTracer/PxrPathTracer.cpp"
#include <kinora/guiding_teacher.h>
#include <kinora/integrator_author.h>
#include <kinora/path_loop.h>

#if KINORA_PLAIN
#include <iterator>
#include <string>

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
    param::onOff("allowCaustics", false)
        .help("Keep light that reaches a diffuse surface through mirrors or lenses; off: shadows of glass are tinted "
              "instead."),
    pathParameters::accumOpacity(0),
    pathParameters::kNumBxdfSamples,
    param::integer("numDiffuseSamples", 1)
        .range(1, 64)
        .help("With sampleMode manual: diffuse directions, and those that media scatter in."),
    param::integer("numSpecularSamples", 1).range(1, 64).help("With sampleMode manual: reflections."),
    param::integer("numRefractionSamples", 1)
        .range(1, 64)
        .help("With sampleMode manual: directions that specular lobes send through the surface."),
    param::integer("numSubsurfaceSamples", 1)
        .range(1, 64)
        .help("With sampleMode manual: paths that go on below the surface."),
    param::string("sampleMode", "bxdf")
        .options("bxdf|manual")
        .help("Directions followed from each camera hit. bxdf: numIndirectSamples, among all lobes as these weigh. "
              "manual: each kind of lobe has a number of its own; a kind that has a share p in the material's lobes "
              "is followed p times its number, on average over the samples of a pixel."),
    pathParameters::kMaxPathLength,
    pathParameters::kMaxNonStochasticOpacityEvents,
    param::integer("maxContinuationLength", -1)
        .range(-1, 1000)
        .help("How many surfaces a ray of a path goes through for want of presence; the next one is opaque to it, as "
              "if its presence were 1. -1: as many as there are, up to 256. Shadow rays see every presence."),
    pathParameters::kRisPathGuiding,
    param::flag("jointSampling", false)
        .help("No effect: distances along media and lights are always sampled together; `equiangularWeight` of "
              "PxrVolume weighs them."),
    param::number("jointScatteringBias", 0.5f)
        .help("No effect: distances along media and lights are always sampled together; `equiangularWeight` of "
              "PxrVolume weighs them."),
    pathParameters::kNumVolumeAggregateSamples,
    pathParameters::kVolumeAggregate,
    pathParameters::kVolumeAggregateCamera,
    pathParameters::kVolumeAggregateIndirect,
    pathParameters::kVolumeAggregateTransmission,
    pathParameters::kLearnLights,
    pathParameters::kNumLightCandidates,
    pathParameters::kGuidingSamples,
    pathParameters::kGuidingRegions,
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
  const NamedValues values(info, kParams, std::size(kParams));
  values.warnNoEffect();
  if (const std::string mode = values.string("sampleMode"); mode == "manual") {
    const auto number = [&](const char* name) { return uint32_t(from::within(values, from::named(kParams, name))); };
    o->byLobe = {true, number("numDiffuseSamples"), number("numSpecularSamples"), number("numRefractionSamples"),
                 number("numSubsurfaceSamples")};
    o->byLobe.given = o->byLobe.most() > 1;
    o->indirectSamples = 1;
  } else if (mode != "bxdf") {
    values.warn("PARAM-CHOICE", "sampleMode is bxdf or manual, not '" + mode + "'", "bxdf is used");
  }
  o->guides = values.number("risPathGuiding") != 0;
  from::learning(values, from::within(values, from::kGuidingSamples), o->guides, *o);
  o->lightCandidates = from::lightCandidates(values);
  o->manifold = from::manifold(values);
  o->placesInMedia = uint32_t(from::within(values, from::named(kParams, "numVolumeAggregateSamples")));
  o->refractsAlpha = values.number("accumOpacity") != 0;
  o->mostPassed = int32_t(from::within(values, from::named(kParams, "maxContinuationLength")));
  return o;
}
inline uint32_t learning(const void* data, Learning* out) {
  const auto& o = *static_cast<const PathLoopOptions*>(data);
  *out = guiding::learning(o.guiding);
  return o.guides || o.learnsLights;
}
inline uint32_t tellsLobesApart(const void* data) {
  return static_cast<const PathLoopOptions*>(data)->tellsLobesApart();
}
}  // namespace kinora::pxrPathTracer
#endif

KINORA_KERNELS_BEGIN
using namespace pxrPathTracer;

struct PxrPathTracer : RunsPathLoop<> {
  static void learn(const Data& options, const LearnServices& services) { guiding::learn(options.guiding, services); }
};

KINORA_KERNELS_END

KINORA_INTEGRATOR(PxrPathTracer, .help = "Forward path tracing with next-event estimation.", .params = kParams,
                  .setUp = setUpBy<make>, .scattersInMedia = scatterInMedia, .learning = learning,
                  .tellsLobesApart = tellsLobesApart)
