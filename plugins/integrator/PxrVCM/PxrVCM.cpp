// PxrVCM: bidirectional path tracing with vertex connection and merging (plugins/integrator/parts/vcm_kernel.h) with
// the stock parameters.
#define KINORA_KERNEL_FILE "plugins/integrator/PxrVCM/PxrVCM.cpp"
#include <kinora/guiding_teacher.h>
#include <kinora/integrator_author.h>

#include "plugins/integrator/parts/vcm_kernel.h"

#if KINORA_PLAIN
#include "plugins/integrator/parts/path_parameters.h"
namespace kinora::pxrVcm {
enum : uint32_t {
  kMaxBounces,
  kConnectPaths,
  kMergePaths,
  kMergeRadius,
  kReduceRadius,
  kMergeMedia,
  kMediaRadius,
  kReduceMediaRadius,
  kTimeRadius,
  kLightSamples,
  kClampDepth,
  kClampLuminance,
  kRouletteDepth,
  kRouletteThreshold,
  kBxdfSamples,
  kMaxPathLength
};
constexpr Param kParams[] = {
    pathParameters::kMaxIndirectBounces,
    param::onOff("connectPaths", true)
        .help("Connect camera paths with light paths, and light paths with the camera."),
    param::onOff("mergePaths", true)
        .help("Merge vertices of camera paths with those of light paths near by: finds caustics seen in mirrors, and "
              "blurs light by the radius."),
    param::number("mergeRadius", 5.f)
        .range(0, 1000)
        .help("Radius of merging in pixels, as wide as they are where the vertex is, of the first sample; 0 merges "
              "nothing."),
    param::number("reduceRadius", 0.67f)
        .range(0.01f, 1)
        .help("How fast the radius shrinks: that of sample i (from 1) is i^((reduceRadius - 1) / 2) of the first; 1 "
              "keeps it."),
    pathParameters::kMergeMedia,
    pathParameters::kMediaRadius,
    pathParameters::kReduceMediaRadius,
    param::number("timeRadius", 1.f)
        .range(0.001f, 1)
        .help("Farthest distance in time of merged vertices, as a share of the shutter's opening."),
    pathParameters::kNumLightSamples,
    pathParameters::kClampDepth,
    pathParameters::kClampLuminance,
    param::integer("rouletteDepth", 4)
        .range(1, 64)
        .help("Path length from which Russian roulette is played; light paths play it from their second vertex, "
              "light's, below twice the threshold, as a share of what they began with."),
    pathParameters::kRouletteThreshold,
    pathParameters::kNumBxdfSamples,
    pathParameters::kMaxPathLength,
    param::number("photonGuiding", 0.f).help("No effect: light paths are emitted as lights are."),
    param::point("photonGuidingBBoxMin", 1e30f, 1e30f, 1e30f).help("No effect: see photonGuiding."),
    param::point("photonGuidingBBoxMax", -1e30f, -1e30f, -1e30f).help("No effect: see photonGuiding."),
    pathParameters::kVolumeAggregate,
    pathParameters::kKeptPaths,
    pathParameters::kLearnLights,
    pathParameters::kGuidingSamples,
    pathParameters::kGuidingRegions,
};

struct Data : vcm::Options {
  explicit Data(const CreateInfo& info) {
    namespace from = pathParameters;
    const NamedValues values(info, kParams, std::size(kParams));
    values.warnNoEffect();
    bounces = from::bounces(info, kMaxBounces, kMaxPathLength, 1000);
    lightSamples = from::count(info, kLightSamples, 0, 1024);
    clampDepth = from::count(info, kClampDepth, 1, 100000);
    connects = info.integer(kConnectPaths) != 0;
    merges = info.integer(kMergePaths) != 0;
    radius = from::within(values, kParams[kMergeRadius]);
    if (!(radius > 0)) merges = false;
    reduce = from::within(values, kParams[kReduceRadius]);
    from::mergeMedia(values, *this);
    kept = from::within(values, from::kKeptPaths);
    from::learning(values, from::within(values, from::kGuidingSamples), false, *this);
    timeRadius = from::within(values, kParams[kTimeRadius]);
    clampLuminance = from::within(values, kParams[kClampLuminance]);
    roulette = {from::rouletteDepth(info, kRouletteDepth, kRouletteThreshold, 1),
                from::within(values, kParams[kRouletteThreshold])};
    rouletteOfLight = from::rouletteOfLight(1, roulette.threshold);
  }
};
}  // namespace kinora::pxrVcm
#endif

KINORA_KERNELS_BEGIN
struct PxrVCM : RunsVcm<pxrVcm::Data> {
  static void learn(const Data& options, const LearnServices& services) { guiding::learn(options.guiding, services); }
};
KINORA_KERNELS_END

KINORA_INTEGRATOR(PxrVCM, .help = "Bidirectional path tracing: vertex connection and merging.",
                  .params = pxrVcm::kParams, .setUp = setUp<pxrVcm::Data>, .stages = vcm::stagesOf<pxrVcm::Data>,
                  .lists = vcm::listsOf<pxrVcm::Data>, .passSamples = 1, .scattersInMedia = scatterInMedia,
                  .learning = vcm::learningOf<pxrVcm::Data>)
