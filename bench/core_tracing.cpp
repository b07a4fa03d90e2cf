// trace_vs_embree, frame_vs_embree and the nanoseconds a ray of each stage, in a bare frame and in a rich one.
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "bare_embree.h"
#include "core.h"
#include "folder.h"
#include "plugin/registry.h"
#include "render/renderer.h"
#include "rib/reader.h"
#include "rich_scene.h"

namespace kinora::bench {

render::Settings passOfFullGroups(const Options& options, RecordedRays& recorded) {
  render::Settings settings;
  settings.threads = 1;
  settings.firstSample = 16;
  settings.lastSample = options.quick ? 18 : 20;
  settings.rayListener = &recorded;
  settings.groupSize = options.groupSize;
  return settings;
}

namespace {

using render::Renderer;
using render::StageTime;
using render::Statistics;

// One scene's frame, in turns with bare Embree on the rays that it traced.
// `hitTolerance`: of the hits, as a share.
void measureScene(const std::string& name, scene::Scene scene, BareEmbree& bare, double hitTolerance,
                  const Options& options, Figures& figures) {
  Registry registry;
  Diagnostics diagnostics;
  RecordedRays recorded;
  Renderer renderer(registry, diagnostics, passOfFullGroups(options, recorded));
  if (!renderer.load(std::move(scene))) return;
  recorded.isRecording = true;
  renderer.renderFilm();
  recorded.isRecording = false;
  const Statistics first = renderer.statistics();
  const double rays = double(first.cameraRays + first.indirectRays + first.shadowRays),
               samples = double(first.cameraRays);
  if (size_t(rays) != recorded.count()) {
    figures.fail("BENCH-RAYS", std::to_string(recorded.count()) + " rays recorded of " +
                                   std::to_string(uint64_t(rays)) + " traced");
    return;
  }
  bare.chooseCalls(recorded, options.quick ? 1 : 4);
  std::printf("  %s: %llu triangles, %.0f rays; bare Embree's calls: %s\n", name.c_str(),
              static_cast<unsigned long long>(first.triangles), rays, bare.choice().c_str());

  constexpr size_t kStages = size_t(StageTime::Count);
  std::vector<double> traceRatio, frameRatio, bareNs, aboveNs, traceNs, outsideNs, frameNs, shadingNs, otherNs,
      cpuShare;
  std::array<std::vector<double>, kStages> stageNs;
  std::array<std::vector<double>, 3> bareKindNs;
  for (int r = 0; r < options.repeat; ++r) {
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
    aboveNs.push_back(1e9 * (cpu - bareTime) / rays);
    traceNs.push_back(1e9 * trace / rays);
    outsideNs.push_back(1e9 * (cpu - trace) / rays);
    frameNs.push_back(1e9 * cpu / rays);
    shadingNs.push_back(1e9 * shading / rays);
    otherNs.push_back(1e9 * (cpu - known) / rays);
    cpuShare.push_back(share);
  }
  const Statistics& after = renderer.statistics();
  const uint64_t hits = (after.cameraHits + after.indirectHits) / uint64_t(options.repeat + 1);
  // the bare scene is the render's own but for the last bits of what is placed and turned
  if (std::abs(double(bare.hits(false)) - double(hits)) > hitTolerance * double(hits))
    figures.fail("BENCH-HITS", "bare Embree hits " + std::to_string(bare.hits(false)) + " times, the render " +
                                   std::to_string(hits));
  figures.add("trace_vs_embree_" + name, traceRatio, "bare Embree's time for the same rays over the trace stages'");
  figures.add("frame_vs_embree_" + name, frameRatio, "bare Embree's time for the same rays over the whole frame's");
  figures.add("rays_per_sample_" + name, {rays / samples}, "rays a camera sample, shadow rays included");
  figures.add("ns_above_embree_" + name, aboveNs,
              "nanoseconds a ray that the whole frame takes above bare Embree's for the same rays");
  figures.add("ns_outside_trace_" + name, outsideNs, "nanoseconds a ray of the frame outside the trace stages");
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
  const auto addLanes = [&](const std::string& which, const render::LaneUse& l, const std::string& meaning) {
    if (!l.possible) return;
    figures.add("lane_use_" + which + "_" + name, {double(l.active) / double(l.possible)},
                "SIMD lanes in use at " + meaning);
    figures.add("points_per_group_" + which + "_" + name, {double(l.active) / double(l.groups)},
                "points a shading group there");
  };
  for (size_t k = 0; k < after.lanesAt.size(); ++k)
    addLanes("depth" + std::to_string(k), after.lanesAt[k], "vertices after " + std::to_string(k) + " bounces");
  addLanes("queries", after.lanesQueries, "surfaces asked for presence, clear shadows and media");
  figures.add("cpu_share_" + name, cpuShare, "CPU time over wall time: below 1 the machine had other work");
}

void measureMesh(const std::string& name, size_t triangles, const Options& options, Figures& figures) {
  const int size = options.quick ? 32 : 256;
  const TriangleMesh mesh = bumpyRoom(triangles, 1);
  scene::Scene scene = emptyScene(size, size);
  addMesh(scene, mesh, material("PxrDiffuse", "white", "diffuseColor=0.8 0.8 0.8"));
  BareEmbree bare(mesh);
  measureScene(name, std::move(scene), bare, 0, options, figures);
}

}  // namespace

void measureTracing(const Options& options, Figures& figures) {
  measureMesh("10k", options.quick ? 1000 : 10000, options, figures);
  measureMesh("1m", options.quick ? 4000 : 1000000, options, figures);
  if (options.full) measureMesh("10m", options.quick ? 8000 : 10000000, options, figures);
}

void measureRich(const Options& options, Figures& figures) {
  const Folder folder;
  const RichScene rich = writeRichScene(folder.path(), options.quick);
  Diagnostics diagnostics;
  std::optional<scene::Scene> scene;
  rib::RibReader reader(diagnostics, {}, [&](scene::Scene&& s) { scene = std::move(s); });
  if (!reader.readFile(rich.file)) return;
  reader.finish();
  if (!scene) return;
  BareEmbree bare(rich);
  measureScene("rich", std::move(*scene), bare, 1e-3, options, figures);
}

}  // namespace kinora::bench
