// trace_vs_embree, frame_vs_embree and the nanoseconds a ray of each stage.
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "bare_embree.h"
#include "core.h"
#include "plugin/registry.h"
#include "render/renderer.h"

namespace kinora::bench {

namespace {

using render::Renderer;
using render::StageTime;
using render::Statistics;

// What one mesh gives, by repetition.
struct Run {
  std::vector<double> perSample, barePerSample;  // seconds
};

Run measureMesh(const std::string& name, size_t triangles, int repeat, const Options& options, Figures& figures) {
  const int size = options.quick ? 32 : 256;
  const TriangleMesh mesh = bumpyRoom(triangles, 1);
  Registry registry;
  Diagnostics diagnostics;
  RecordedRays recorded;
  render::Settings settings;
  settings.threads = 1;
  // a pass from the middle of a frame: groups are full
  settings.firstSample = 16;
  settings.lastSample = options.quick ? 18 : 20;
  settings.rayListener = &recorded;
  settings.groupSize = options.groupSize;
  Renderer renderer(registry, diagnostics, settings);
  {
    scene::Scene scene = emptyScene(size, size);
    addMesh(scene, mesh, material("PxrDiffuse", "white", "diffuseColor=0.8 0.8 0.8"));
    if (!renderer.load(std::move(scene))) return {};
  }
  recorded.isRecording = true;
  renderer.renderFilm();
  recorded.isRecording = false;
  const Statistics first = renderer.statistics();
  const double rays = double(first.cameraRays + first.indirectRays + first.shadowRays),
               samples = double(first.cameraRays);
  if (size_t(rays) != recorded.count()) {
    std::fprintf(stderr, "kinora-bench: error BENCH-RAYS: %zu rays recorded of %.0f traced\n", recorded.count(),
                 rays);
    return {};
  }
  BareEmbree bare(mesh);
  bare.chooseCalls(recorded, options.quick ? 1 : 4);
  std::printf("  %s: %zu triangles, %.0f rays; bare Embree's calls: %s\n", name.c_str(), mesh.triangleCount(), rays,
              bare.choice().c_str());

  constexpr size_t kStages = size_t(StageTime::Count);
  std::vector<double> traceRatio, frameRatio, bareNs, traceNs, frameNs, shadingNs, otherNs, cpuShare;
  std::array<std::vector<double>, kStages> stageNs;
  std::array<std::vector<double>, 3> bareKindNs;
  Run run;
  for (int r = 0; r < repeat; ++r) {
    const Statistics before = renderer.statistics();
    const double wall0 = wallSeconds(), cpu0 = threadSeconds();
    renderer.renderFilm();
    const double wall = wallSeconds() - wall0, cpu = threadSeconds() - cpu0;
    const double bareWall0 = wallSeconds(), bareCpu0 = threadSeconds();
    const BareEmbree::Seconds bareKinds = bare.replay(recorded);
    // other work on the machine takes wall time from every stage alike: count the share that was ours
    const double bareShare = (threadSeconds() - bareCpu0) / (wallSeconds() - bareWall0),
                 bareTime = bareKinds.sum() * bareShare;
    bareKindNs[0].push_back(1e9 * bareKinds.camera * bareShare / rays);
    bareKindNs[1].push_back(1e9 * bareKinds.indirect * bareShare / rays);
    bareKindNs[2].push_back(1e9 * bareKinds.shadow * bareShare / rays);
    const double share = cpu / wall;
    double trace = 0, shading = 0, known = 0;
    for (size_t k = 0; k < kStages; ++k) {
      const double t = 1e-9 * double(renderer.statistics().stageNanoseconds[k] - before.stageNanoseconds[k]) * share;
      stageNs[k].push_back(1e9 * t / rays);
      known += t;
      const auto stage = StageTime(k);
      if (stage == StageTime::TraceCamera || stage == StageTime::TraceIndirect || stage == StageTime::TraceShadow)
        trace += t;
      if (stage == StageTime::Grouping || stage == StageTime::Closures || stage == StageTime::Lights ||
          stage == StageTime::Integrator)
        shading += t;
    }
    traceRatio.push_back(bareTime / trace);
    frameRatio.push_back(bareTime / cpu);
    bareNs.push_back(1e9 * bareTime / rays);
    traceNs.push_back(1e9 * trace / rays);
    frameNs.push_back(1e9 * cpu / rays);
    shadingNs.push_back(1e9 * shading / rays);
    otherNs.push_back(1e9 * (cpu - known) / rays);
    cpuShare.push_back(share);
    run.perSample.push_back(cpu / samples);
    run.barePerSample.push_back(bareTime / samples);
  }
  const Statistics& after = renderer.statistics();
  const uint64_t hits = (after.cameraHits + after.indirectHits) / uint64_t(repeat + 1);
  if (bare.hits(false) != hits)
    std::fprintf(stderr, "kinora-bench: warning BENCH-HITS: bare Embree hits %llu times, the render %llu\n",
                 static_cast<unsigned long long>(bare.hits(false)), static_cast<unsigned long long>(hits));
  figures.add("trace_vs_embree_" + name, traceRatio, "bare Embree's time for the same rays over the trace stages'");
  figures.add("frame_vs_embree_" + name, frameRatio, "bare Embree's time for the same rays over the whole frame's");
  figures.add("rays_per_sample_" + name, {rays / samples}, "rays a camera sample, shadow rays included");
  figures.add("ns_bare_" + name, bareNs, "nanoseconds a ray: bare Embree");
  static const char* const kKinds[3] = {"camera", "indirect", "shadow"};
  for (int k = 0; k < 3; ++k)
    figures.add(std::string("ns_bare_") + kKinds[k] + "_" + name, bareKindNs[size_t(k)],
                std::string("of which its ") + kKinds[k] + " rays");
  figures.add("ns_frame_" + name, frameNs, "nanoseconds a ray: the whole frame");
  figures.add("ns_trace_" + name, traceNs, "nanoseconds a ray: trace stages");
  figures.add("ns_shading_" + name, shadingNs,
              "nanoseconds a ray: grouping, closures, lights, integrator with bxdfs");
  static const char* const kStageNames[kStages] = {"camera_rays",  "trace_camera", "trace_indirect",
                                                   "trace_shadow", "grouping",     "closures",
                                                   "lights",       "integrator",   "film"};
  for (size_t k = 0; k < kStages; ++k)
    figures.add("ns_" + std::string(kStageNames[k]) + "_" + name, stageNs[k],
                std::string("nanoseconds a ray: ") + render::nameOf(StageTime(k)));
  figures.add("ns_other_" + name, otherNs, "nanoseconds a ray: what no stage counts");
  figures.add("cpu_share_" + name, cpuShare, "CPU time over wall time: below 1 the machine had other work");
  return run;
}

}  // namespace

void measureTracing(const Options& options, Figures& figures) {
  const Run small = measureMesh("10k", options.quick ? 1000 : 10000, options.repeat, options, figures);
  const auto growth = [&](const Run& large, const std::string& name) {
    std::vector<double> ratios;
    for (size_t i = 0; i < std::min(small.perSample.size(), large.perSample.size()); ++i)
      ratios.push_back(large.perSample[i] / small.perSample[i] / (large.barePerSample[i] / small.barePerSample[i]));
    figures.add("time_growth_" + name, ratios, "growth of the time a sample over bare Embree's; at most 1");
  };
  growth(measureMesh("1m", options.quick ? 4000 : 1000000, options.repeat, options, figures), "1e4_1e6");
  if (options.full)
    growth(measureMesh("10m", options.quick ? 8000 : 10000000, options.repeat, options, figures), "1e4_1e7");
}

}  // namespace kinora::bench
