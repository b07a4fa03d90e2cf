// Whole frames against each other: widths, threads; and memory, lane use, first pixels.
#include <algorithm>
#include <malloc.h>
#include <unistd.h>

#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>

#include "core.h"
#include "folder.h"
#include "plugin/registry.h"
#include "render/renderer.h"
#include "rib/reader.h"
#include "scenes.h"
#include "simd/dispatch.h"

namespace kinora::bench {

namespace {

using render::Renderer;
using render::Settings;

Settings oneThread(const Options& options) {
  Settings s;
  s.threads = 1;
  s.firstSample = 16;
  s.lastSample = options.quick ? 18 : 20;
  return s;
}

// Two bumpy shells, one in the other, so that what passes through the inner one meets the outer one.
scene::Scene shells(const Options& options, const scene::NetworkPtr& material) {
  const int size = options.quick ? 32 : 160;
  scene::Scene s = emptyScene(size, size);
  addMesh(s, bumpyRoom(options.quick ? 500 : 20000, 1), material);
  addMesh(s, bumpyRoom(options.quick ? 500 : 20000, 2.2f), material);
  return s;
}

void widthGain(const std::string& name, const std::string& meaning, const scene::NetworkPtr& material,
               const Options& options, Figures& figures) {
  Registry registry;
  Diagnostics diagnostics;
  std::vector<uint32_t> widths{1, 8};
  if (cpuHasAvx512()) widths.push_back(16);
  std::map<uint32_t, std::unique_ptr<Renderer>> renderers;
  for (uint32_t w : widths) {
    Settings settings = oneThread(options);
    settings.width = w;
    renderers[w] = std::make_unique<Renderer>(registry, diagnostics, settings);
    if (!renderers[w]->load(shells(options, material))) return;
    renderers[w]->renderFilm();
  }
  std::vector<double> gain;
  std::map<uint32_t, std::vector<double>> seconds;
  for (int r = 0; r < options.repeat; ++r) {
    double best = 1e30;
    for (uint32_t w : widths) {
      const double start = threadSeconds();
      renderers[w]->renderFilm();
      seconds[w].push_back(threadSeconds() - start);
      if (w > 1) best = std::min(best, seconds[w].back());
    }
    gain.push_back(seconds[1].back() / best);
  }
  figures.add(name, gain, meaning);
  for (uint32_t w : widths)
    figures.add(name + "_seconds_" + std::to_string(w), seconds[w],
                "the frame's CPU time at width " + std::to_string(w));
}

void threads(const Options& options, Figures& figures) {
  Registry registry;
  Diagnostics diagnostics;
  std::unique_ptr<Renderer> renderers[2];
  for (int t = 0; t < 2; ++t) {
    Settings settings = oneThread(options);
    settings.threads = t + 1;
    renderers[t] = std::make_unique<Renderer>(registry, diagnostics, settings);
    scene::Scene scene = emptyScene(options.quick ? 32 : 256, options.quick ? 32 : 256);
    addMesh(scene, bumpyRoom(options.quick ? 1000 : 100000, 1),
            material("PxrDiffuse", "white", "diffuseColor=0.8 0.8 0.8"));
    if (!renderers[t]->load(std::move(scene))) return;
    renderers[t]->renderFilm();
  }
  std::vector<double> wall, cpu;
  for (int r = 0; r < options.repeat; ++r) {
    double w[2], c[2];
    for (int t = 0; t < 2; ++t) {
      const double wall0 = wallSeconds(), cpu0 = processSeconds();
      renderers[t]->renderFilm();
      w[t] = wallSeconds() - wall0;
      c[t] = processSeconds() - cpu0;
    }
    wall.push_back(w[0] / w[1]);
    cpu.push_back(2 * c[0] / c[1]);
  }
  figures.add("threads_2", wall, "wall time of a frame with 1 thread over 2; needs two free cores");
  figures.add("threads_2_by_cpu", cpu,
              "the same from CPU time: what two free cores would give but for waiting at the end");
}

// What a dozen light path expressions cost a frame that has Ci and a alone: scenes/cornell.rib, both in turn.
constexpr const char* kTwelve[] = {"emissive",
                                   "diffuse",
                                   "indirectDiffuse",
                                   "specular",
                                   "indirectSpecular",
                                   "subsurface",
                                   "transmissive",
                                   "lpe:CD[S]+<L.>",
                                   "lpe:C<RS'Glass'>[DS]*[LO]",
                                   "lpe:C.*<L.'key'>",
                                   "lpe:C<TS>+<RD>[LO]",
                                   "lpe:C(D[DS]*[LO])|[LO]"};

}  // namespace

void measureLightPaths(const Options& options, Figures& figures) {
  Registry registry;
  Diagnostics diagnostics([](const std::string&, Severity) {});
  std::unique_ptr<Renderer> renderers[2];
  for (int k = 0; k < 2; ++k) {
    std::optional<scene::Scene> scene;
    rib::RibReader reader(diagnostics, {}, [&](scene::Scene&& s) { scene = std::move(s); });
    if (!reader.readFile(KINORA_SOURCE_DIR "/scenes/cornell.rib")) return;
    reader.finish();
    if (!scene) return;
    scene::Display d;
    d.file = "bench.exr";
    d.driver = "openexr";
    d.mode = "Ci,a";
    for (size_t i = 0; k == 1 && i < std::size(kTwelve); ++i) {
      scene::DisplayChannel c;
      c.name = "path" + std::to_string(i);
      scene::Parameter source;
      source.name = "source";
      source.type = scene::ValueType::String;
      source.strings = {kTwelve[i]};
      c.params.set(std::move(source));
      scene->channels.push_back(std::move(c));
      d.mode += ",path" + std::to_string(i);
    }
    scene->displays = {std::move(d)};
    Settings settings = oneThread(options);
    settings.resolution = options.quick ? std::array<int, 2>{64, 36} : std::array<int, 2>{160, 90};
    renderers[k] = std::make_unique<Renderer>(registry, diagnostics, settings);
    if (!renderers[k]->load(std::move(*scene))) return;
    renderers[k]->renderFilm();
  }
  // a few per cent are less than one pair of frames can tell: each figure is the median of many pairs, in turns
  std::vector<double> cost;
  for (int r = 0; r < options.repeat; ++r) {
    std::vector<double> pairs;
    for (int p = 0; p < (options.quick ? 1 : 21); ++p) {
      double seconds[2];
      for (int k = 0; k < 2; ++k) {
        const int which = (p + k) % 2;
        const double start = threadSeconds();
        renderers[which]->renderFilm();
        seconds[which] = threadSeconds() - start;
      }
      pairs.push_back(seconds[1] / seconds[0] - 1);
    }
    std::nth_element(pairs.begin(), pairs.begin() + long(pairs.size() / 2), pairs.end());
    cost.push_back(pairs[pairs.size() / 2]);
  }
  figures.add("lpe_cost_12", cost,
              "CPU time of scenes/cornell.rib with 12 light path channels over that without, less 1");
}

namespace {

uint64_t residentBytes() {
  long pages = 0, resident = 0;
  if (FILE* f = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(f, "%ld %ld", &pages, &resident) != 2) resident = 0;
    std::fclose(f);
  }
  return uint64_t(resident) * uint64_t(sysconf(_SC_PAGESIZE));
}

}  // namespace

void measureFrames(const Options& options, Figures& figures) {
  widthGain("frame_width_gain", "whole frame, width 1 over the best: PxrSurface with all lobes, two PxrFractal",
            fractalSurface(), options, figures);
  const Folder folder;
  widthGain("frame_width_gain_textures", "the same with four image textures",
            texturedSurface(writePictures(folder.path())), options, figures);
  threads(options, figures);
}

void measureMemory(const Options& options, Figures& figures) {
  Registry registry;
  Diagnostics diagnostics;
  Settings settings = oneThread(options);
  const size_t triangles = options.quick ? 10000 : 1000000;
  const auto render = [&](const TriangleMesh& mesh) {
    auto r = std::make_unique<Renderer>(registry, diagnostics, settings);
    scene::Scene scene = emptyScene(32, 32);
    addMesh(scene, mesh, material("PxrDiffuse", "white", ""));
    if (r->load(std::move(scene))) r->renderFilm();
    return r;
  };
  const auto owned = [](const Renderer& r) {
    double sum = 0;
    for (const render::Statistics::Owner& o : r.statistics().memory)
      if (o.name != render::Statistics::kOthers) sum += double(o.bytes);
    return sum;
  };
  // what a scene costs that is nearly empty is no mesh's
  const auto small = render(bumpyRoom(12, 1));
  TriangleMesh mesh = bumpyRoom(triangles, 1);
  const double count = double(mesh.triangleCount());
  malloc_trim(0);
  const double before = double(residentBytes());
  const auto large = render(mesh);
  malloc_trim(0);
  const double grown = double(residentBytes()) - before;
  // Embree's memory is counted for the process: both scenes are in it, the small one without weight
  figures.add("bytes_per_triangle", {(owned(*large) - owned(*small)) / count},
              "bytes a triangle of a 1M mesh in all, by the owners' own counts");
  figures.add("bytes_per_triangle_resident", {grown / count}, "the same from the growth of the process");
  for (const render::Statistics::Owner& o : large->statistics().memory) {
    if (double(o.bytes) / count < 1 || o.name == render::Statistics::kOthers) continue;
    std::string name = o.name.substr(0, o.name.find(" ("));
    for (char& c : name)
      if (c == ' ') c = '_';
    figures.add("bytes_per_triangle_" + name, {double(o.bytes) / count}, "of which " + o.name);
  }
}

void measureLanes(const Options& options, Figures& figures) {
  // a wall of 40 x 25 sheets, each its own material; eight programs in turn, so that neighbours never share one
  static const char* const kPrograms[8][2] = {
      {"PxrDiffuse", "diffuseColor=%f 0.5 0.5"},
      {"PxrSurface", "diffuseGain=1; diffuseColor=%f 0.5 0.5"},
      {"PxrSurface", "diffuseGain=1; specularFaceColor=%f 0.5 0.5; specularEdgeColor=1 1 1"},
      {"PxrSurface",
       "diffuseGain=0; specularFaceColor=%f 0.5 0.5; specularEdgeColor=1 1 1; clearcoatFaceColor=0.1 0.1 0.1"},
      {"PxrSurface", "diffuseGain=1; fuzzGain=0.5; fuzzColor=%f 0.5 0.5"},
      {"PxrSurface", "diffuseGain=0; reflectionGain=%f; refractionGain=0.5"},
      {"PxrSurface", "diffuseGain=1; roughSpecularFaceColor=%f 0.2 0.2; roughSpecularEdgeColor=1 1 1"},
      {"PxrConstant", "emitColor=%f 0.5 0.5"}};
  const int across = options.quick ? 8 : 40, down = options.quick ? 4 : 25;
  scene::Scene scene = emptyScene(options.quick ? 64 : 400, options.quick ? 32 : 250);
  for (int y = 0; y < down; ++y)
    for (int x = 0; x < across; ++x) {
      const int k = y * across + x;
      char text[256];
      std::snprintf(text, sizeof text, kPrograms[(x + 3 * y) % 8][1], 0.1 + 0.8 * k / (across * down));
      const float w = 2.6f / float(across), h = 1.6f / float(down), x0 = -1.3f + w * float(x),
                  y0 = -0.8f + h * float(y);
      addMesh(scene, sheet(x0, y0, x0 + w, y0 + h, 1),
              material(kPrograms[(x + 3 * y) % 8][0], "m" + std::to_string(k), text));
    }
  Registry registry;
  Diagnostics diagnostics;
  Settings settings;
  settings.threads = 1;
  settings.samplesPerPixel = options.quick ? 4 : 16;
  Renderer renderer(registry, diagnostics, settings);
  if (!renderer.load(std::move(scene))) return;
  renderer.renderFilm();
  const render::Statistics& s = renderer.statistics();
  figures.add("lane_use_first_hit", {double(s.lanesAt[0].active) / double(s.lanesAt[0].possible)},
              "SIMD lanes in use at camera hits");
  figures.add("lane_use_materials", {double(s.materials)}, "materials of that scene");
  figures.add("lane_use_programs", {double(s.programs)}, "programs of that scene");
}

void measureFirstPixel(const Options& options, Figures& figures) {
  const Folder folder;
  std::vector<double> seconds;
  for (int r = 0; r < std::min(options.repeat, 5); ++r) {
    Diagnostics diagnostics;
    std::optional<scene::Scene> scene;
    rib::RibReader reader(diagnostics, {}, [&](scene::Scene&& s) { scene = std::move(s); });
    if (!reader.readFile(KINORA_SOURCE_DIR "/scenes/cornell.rib")) return;
    reader.finish();
    if (!scene) return;
    scene->displays.resize(1);  // the others would be written beside the caller
    Registry registry;
    Settings settings;
    settings.samplesPerPixel = 2;  // one pass more than the first pixels need
    settings.output = folder.path() + "/first.exr";
    if (options.quick) settings.resolution = {64, 36};
    Renderer renderer(registry, diagnostics, settings);
    if (!renderer.load(std::move(*scene))) return;
    renderer.render();
    seconds.push_back(renderer.statistics().firstPixelSeconds);
  }
  figures.add("first_pixel_seconds", seconds,
              "scenes/cornell.rib, 640 x 360, all threads: from loaded to pixels in the file");
}

}  // namespace kinora::bench
