// curves_vs_embree: what curves cost on their way through our trace stages.
#include <cstdio>

#include "bare_embree.h"
#include "core.h"
#include "plugin/registry.h"
#include "render/renderer.h"

namespace kinora::bench {

void measureCurves(const Options& options, Figures& figures) {
  using render::StageTime;
  const int size = options.quick ? 32 : 128;
  const CurveSet curves = scatteredHairs(options.quick ? 1000 : 30000);
  Registry registry;
  Diagnostics diagnostics;
  RecordedRays recorded;
  render::Renderer renderer(registry, diagnostics, passOfFullGroups(options, recorded));
  {
    scene::Scene scene = emptyScene(size, size);
    addCurves(scene, curves, material("PxrDiffuse", "white", "diffuseColor=0.8 0.8 0.8"));
    if (!renderer.load(std::move(scene))) return;
  }
  recorded.isRecording = true;
  renderer.renderFilm();
  recorded.isRecording = false;
  const auto closestSeconds = [&] {
    const auto& ns = renderer.statistics().stageNanoseconds;
    return 1e-9 * double(ns[size_t(StageTime::TraceCamera)] + ns[size_t(StageTime::TraceIndirect)]);
  };
  const double rays = double(renderer.statistics().cameraRays + renderer.statistics().indirectRays);
  BareEmbree bare(curves);
  bare.chooseCalls(recorded, options.quick ? 1 : 4);
  std::printf("  %zu pieces of curves, %.0f closest hits; bare Embree's calls: %s\n", curves.pieceCount(), rays,
              bare.choice().c_str());
  std::vector<double> ratio, bareNs, traceNs;
  for (int r = 0; r < options.repeat; ++r) {
    const double before = closestSeconds(), wall0 = wallSeconds(), cpu0 = threadSeconds();
    renderer.renderFilm();
    // other work on the machine takes wall time from every stage alike: count the share that was ours
    const double share = (threadSeconds() - cpu0) / (wallSeconds() - wall0),
                 ours = (closestSeconds() - before) * share;
    const double bareWall0 = wallSeconds(), bareCpu0 = threadSeconds();
    const BareEmbree::Seconds kinds = bare.replay(recorded);
    const double bareShare = (threadSeconds() - bareCpu0) / (wallSeconds() - bareWall0);
    const double theirs = (kinds.camera + kinds.indirect) * bareShare;
    ratio.push_back(theirs / ours);
    bareNs.push_back(1e9 * theirs / rays);
    traceNs.push_back(1e9 * ours / rays);
  }
  const render::Statistics& after = renderer.statistics();
  const uint64_t hits = (after.cameraHits + after.indirectHits) / uint64_t(options.repeat + 1);
  if (bare.hits(false) != hits)
    std::fprintf(stderr, "kinora-bench: warning BENCH-HITS: bare Embree hits %llu times, the render %llu\n",
                 static_cast<unsigned long long>(bare.hits(false)), static_cast<unsigned long long>(hits));
  figures.add("curves_vs_embree", ratio,
              "curves: bare Embree's time for the same closest hits over the trace stages'");
  figures.add("ns_bare_curves", bareNs, "nanoseconds a closest hit of curves: bare Embree");
  figures.add("ns_trace_curves", traceNs, "nanoseconds a closest hit of curves: trace stages");
}

}  // namespace kinora::bench
