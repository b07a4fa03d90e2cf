// PxrUnified: forward paths (kinora/path_loop.h) or paths from both ends (plugins/integrator/parts/vcm_kernel.h), as
// its parameters say. Its names are those of scenes written for it.
#define KINORA_KERNEL_FILE "plugins/integrator/PxrUnified/PxrUnified.cpp"
#include <kinora/guiding_teacher.h>
#include <kinora/integrator_author.h>
#include <kinora/path_loop.h>

#include "plugins/integrator/parts/vcm_kernel.h"

#if KINORA_PLAIN
#include <kinora/named_values.h>

#include <string>
#include <string_view>

#include "plugins/integrator/parts/path_parameters.h"
namespace kinora::pxrUnified {
enum : uint32_t {
  kLightPaths,
  kMaxBounces,
  kLightSamples,
  kIndirectSamples,
  kIndirectClamp,
  kRouletteDepth,
  kRouletteThreshold,
  kRouletteLightDepth
};
constexpr Param kParams[] = {
    param::integer("traceLightPaths", 0)
        .range(0, 3)
        .options("0 off, 1 bidirectional, 2 photons, 3 both")
        .help("Paths that start at lights too. 0: none, as PxrPathTracer without caustics; 1: connected to camera "
              "paths and to the camera, as PxrVCM with mergePaths 0; 2: merged with camera paths near by, as PxrVCM "
              "with connectPaths 0; 3: PxrVCM with both."),
    pathParameters::kMaxIndirectBounces,
    pathParameters::kNumLightSamples,
    pathParameters::kNumIndirectSamples,
    param::number("indirectClamp", 8.f)
        .range(0, 1e30f)
        .help("Largest luminance of one contribution of indirect light; 1e30 is off."),
    param::integer("rouletteDepth", 1).range(1, 64).help("Path length from which Russian roulette is played."),
    pathParameters::kRouletteThreshold,
    param::integer("rouletteLightDepth", 1)
        .range(1, 64)
        .help("The same of light paths, which play it below twice rouletteThreshold, as a share of what they began "
              "with."),
    pathParameters::kNumBxdfSamples,
    pathParameters::accumOpacity(1),
    param::flag("allowMultilobeIndirect", false)
        .help("No effect: a direction is drawn from one lobe and weighed by all of them."),
    param::number("catchAllLights", 0.f)
        .help("How much of their shadows light samples at the last surface of a path leave out: 1 lights it as if "
              "nothing were in the way, for the light of the bounces that are cut off. With traceLightPaths 0."),
    param::number("causticClamp", 1e6f)
        .range(0, 1e30f)
        .help("Largest luminance of one contribution of manifold walks, where indirectClamp is not smaller. With "
              "traceLightPaths 0: light paths' caustics are indirect light."),
    param::number("directClamp", 1e6f)
        .range(0, 1e30f)
        .help("Largest luminance of one contribution of light that falls on what the camera sees; 1e30 is off."),
    param::number("emissionMultiplier", 1.f).range(0, 100).help("Factor on what surfaces emit, but not lights."),
    param::flag("enableSampleTimers", false).help("No effect: statistics always hold the times of stages."),
    param::flag("enableShadingTimers", false).help("No effect: statistics always hold the times of stages."),
    param::flag("enableVolumeCaustics", false)
        .help("No effect: light paths scatter in media wherever there are any; see mergeMedia."),
    param::number("indirectDirectionalBlurRadius", 0.f)
        .help("No effect: what risPathGuiding learns has no such setting."),
    param::integer("indirectOversampling", 2)
        .range(0, 64)
        .help("No effect: what risPathGuiding learns has no such setting."),
    param::number("indirectSpatialBlurRadius", 0.25f)
        .help("No effect: what risPathGuiding learns has no such setting."),
    param::integer("indirectTrainingSamples", 0)
        .range(0, 4096)
        .help("With risPathGuiding or learnLights: samples a pixel that are learned from, rounded down to a power of "
              "two; 0: 64."),
    pathParameters::kManifoldWalk,
    pathParameters::kMaxInterfaces,
    pathParameters::kMaxIterations,
    pathParameters::kMergeMedia,
    pathParameters::kMediaRadius,
    pathParameters::kReduceMediaRadius,
    param::number("walkThreshold", 0.005f)
        .help("No effect: a walk that has not arrived after maxIterations is dropped."),
    pathParameters::kMaxNonStochasticOpacityEvents,
    param::number("maxRayDistance", 10000.f)
        .range(0, 1e30f)
        .help("Surfaces farther than this from where a ray starts are not met by indirect and shadow rays, "
              "units of the world; lights are. 0 and 1e30 are off. With traceLightPaths 0: a light path that "
              "passes what is farther from the point that it lights would have to light what is in between as "
              "well."),
    pathParameters::kNumVolumeAggregateSamples,
    param::flag("photonAdaptive", false).help("No effect: light paths are emitted as lights are."),
    param::integer("photonEstimationNumber", 64).range(1, 100000).help("No effect: all within the radius count."),
    param::number("photonEstimationRadius", 0.f)
        .range(0, 1000)
        .help("No effect: merging has a radius in pixels, that of PxrVCM with its defaults, 5 that shrink."),
    param::flag("photonVisibilityRod", false).help("No effect: light paths are emitted as lights are."),
    param::number("photonVisibilityRodDirectProb", 0.f).help("No effect: see photonVisibilityRod."),
    param::point("photonVisibilityRodMin", 0.f, 0.f, 0.f).help("No effect: see photonVisibilityRod."),
    param::point("photonVisibilityRodMax", 0.f, 0.f, 0.f).help("No effect: see photonVisibilityRod."),
    pathParameters::kRisPathGuiding,
    pathParameters::kLearnLights,
    pathParameters::kNumLightCandidates,
    pathParameters::kGuidingRegions,
    param::integer("sssOversampling", 8)
        .range(1, 64)
        .help("No effect: a path below a surface is followed by itself, not chosen among candidates."),
    param::flag("suppressNaNs", false)
        .help("No effect: samples that are no numbers are always left out and told of."),
    pathParameters::kVolumeAggregate,
    pathParameters::kKeptPaths,
    param::flag("useTraceDepth", false)
        .help("No effect: bounces are counted by maxIndirectBounces, for all objects and lobes alike."),
};

// Parameters of one way of rendering alone: where light paths are traced, and where none are. One that a scene sets is
// told where it does nothing, but not what only refines another (maxInterfaces, mediaRadius), which exporters write always.
constexpr const char* kOfForward[] = {"numIndirectSamples", "catchAllLights",           "causticClamp",
                                      "manifoldWalk",       "maxRayDistance",           "risPathGuiding",
                                      "numLightCandidates", "numVolumeAggregateSamples"};
constexpr const char* kOfLightPaths[] = {"rouletteLightDepth", "mergeMedia", "keptPaths"};

inline void warnOfIdle(const NamedValues& v, bool isForward) {
  std::string names;
  const auto look = [&](const char* name) {
    const Param& p = pathParameters::named(kParams, name);
    const double x = v.number(name);
    const bool isOff = std::string_view(name) == "maxRayDistance" && (x <= 0 || x >= 1e30);
    if (v.given(name) && float(x) != float(p.value[0]) && !isOff)
      names += (names.empty() ? "'" : ", '") + std::string(name) + "'";
  };
  if (isForward)
    for (const char* name : kOfLightPaths) look(name);
  else
    for (const char* name : kOfForward) look(name);
  if (names.empty()) return;
  const char* where = isForward ? "where traceLightPaths is 0: " : "where light paths are traced: ";
  v.warn("PARAM-NO-EFFECT", "parameters without effect " + (where + names), "ignored");
}

struct Data {
  bool isForward;
  PathLoopOptions forward;
  vcm::Options both;
  explicit Data(const CreateInfo& info) {
    namespace from = pathParameters;
    const NamedValues v(info, kParams, std::size(kParams));
    v.warnNoEffect();
    int light = info.integer(kLightPaths);
    if (light < 0 || light > 3) {
      v.warn("PARAM-CHOICE", "traceLightPaths is 0, 1, 2 or 3, not " + std::to_string(light), "0 is used");
      light = 0;
    }
    isForward = light == 0;
    warnOfIdle(v, isForward);
    both.connects = light & 1;
    both.merges = light & 2;
    const float threshold = float(v.number("rouletteThreshold")), most = float(v.number("indirectClamp"));
    const uint32_t depth = from::rouletteDepth(info, kRouletteDepth, kRouletteThreshold, 1);
    forward.maxIndirectBounces = from::count(info, kMaxBounces, 0, 1000);
    both.bounces = isForward ? 0 : forward.maxIndirectBounces;
    forward.lightSamples = both.lightSamples = from::count(info, kLightSamples, 0, 1024);
    forward.indirectSamples = from::count(info, kIndirectSamples, 1, 1024);
    forward.clampLuminance = both.clampLuminance = most;
    forward.rouletteDepth = depth;
    forward.rouletteThreshold = threshold;
    forward.manifold = from::manifold(v);
    forward.placesInMedia = uint32_t(from::within(v, from::named(kParams, "numVolumeAggregateSamples")));
    forward.refractsAlpha = v.integer("accumOpacity") != 0;
    forward.unshadowedEnd = from::within(v, from::named(kParams, "catchAllLights"));
    forward.clampCaustic = from::within(v, from::named(kParams, "causticClamp"));
    forward.clampDirect = both.clampDirect = from::within(v, from::named(kParams, "directClamp"));
    forward.emission = both.emission = from::within(v, from::named(kParams, "emissionMultiplier"));
    const float farthest = from::within(v, from::named(kParams, "maxRayDistance"));
    if (farthest > 0) forward.farthest = farthest;
    forward.guides = isForward && v.integer("risPathGuiding") != 0;
    const int learned = v.integer("indirectTrainingSamples");
    const float lessons = learned > 0 ? float(std::min(learned, 4096)) : float(guiding::Options().samples);
    if (isForward)
      from::learning(v, lessons, forward.guides, forward);
    else
      from::learning(v, lessons, false, both);
    forward.lightCandidates = from::lightCandidates(v);
    from::mergeMedia(v, both);
    both.kept = from::within(v, from::kKeptPaths);
    if (!both.merges) both.mergesMedia = both.beams = false;
    both.roulette = {depth, threshold};
    both.rouletteOfLight = from::rouletteOfLight(from::count(info, kRouletteLightDepth, 1, 100000), threshold);
  }
};
inline uint32_t stages(const void* data, Stage* out, uint32_t capacity) {
  return vcm::stages(static_cast<const Data*>(data)->both, out, capacity);
}
inline uint32_t learning(const void* data, Learning* out) {
  const auto& d = *static_cast<const Data*>(data);
  if (!d.isForward) return vcm::learning(d.both, out);
  *out = guiding::learning(d.forward.guiding);
  return d.forward.guides || d.forward.learnsLights;
}
inline uint32_t tellsLobesApart(const void* data) {
  const auto& d = *static_cast<const Data*>(data);
  return d.isForward && d.forward.tellsLobesApart();
}
inline uint32_t lists(const void* data, RecordList* out, uint32_t) {
  return vcm::lists(static_cast<const Data*>(data)->both, out);
}
}  // namespace kinora::pxrUnified
#endif

KINORA_KERNELS_BEGIN
struct PxrUnified {
  using Data = pxrUnified::Data;
  template <int W>
  static void integrate(const Data& data, uint32_t, Group& group, const Services& services) {
    if (data.isForward)
      PathLoop<W>(&group, &services, data.forward).run();
    else
      Vcm<W>(&group, &services, data.both).run();
  }
  static void commit(const Data& data, uint32_t stage, const CommitServices& services) {
    vcm::commit(data.both, stage, services);
  }
  static void learn(const Data& data, const LearnServices& services) {
    guiding::learn(data.isForward ? data.forward.guiding : data.both.guiding, services);
  }
};
KINORA_KERNELS_END

KINORA_INTEGRATOR(PxrUnified, .help = "Forward or bidirectional path tracing, as its parameters choose.",
                  .params = pxrUnified::kParams, .setUp = setUp<pxrUnified::Data>, .stages = pxrUnified::stages,
                  .lists = pxrUnified::lists, .passSamples = 1, .scattersInMedia = scatterInMedia,
                  .learning = pxrUnified::learning, .tellsLobesApart = pxrUnified::tellsLobesApart)
