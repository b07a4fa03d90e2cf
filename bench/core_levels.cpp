// Displaced surfaces: how fast they are diced, by a plug-in and by a shader, and what rays take on surfaces that are diced
// where rays ask, against the same micropolygons as a mesh of Embree's.
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core.h"
#include "folder.h"
#include "plugin/registry.h"
#include "render/renderer.h"
#include "rib/reader.h"

namespace kinora::bench {

namespace {

using render::Renderer;
using render::StageTime;

constexpr const char* kShader =
    "displacement bumps() { P += N * .1 * noise(\"perlin\", transform(\"object\", P) * 4); }\n";
constexpr const char* kPlugin =
    "Pattern \"PxrFractal\" \"noise\" \"int surfacePosition\" [1] \"float frequency\" [4] \"int layers\" [1]\n"
    "Displace \"PxrDisplace\" \"bumps\" \"float dispAmount\" [.1] \"reference float dispScalar\" "
    "[\"noise:resultF\"]\n";
constexpr const char* kSquare = "PointsPolygons [4] [0 1 2 3] \"P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0]\n";
constexpr const char* kPatch =
    "Patch \"bicubic\" \"P\" [-1 -1 0  -.33 -1 0  .33 -1 0  1 -1 0   -1 -.33 0  -.33 -.33 .3  .33 -.33 .3  1 -.33 0\n"
    "-1 .33 0  -.33 .33 .3  .33 .33 .3  1 .33 0   -1 1 0  -.33 1 0  .33 1 0  1 1 0]\n";
constexpr const char* kSphere = "Sphere 1 -1 1 360\n";

struct Wanted {
  std::string displacement, shape;
  int levels = 1;  // as `Attribute "dice" "int levels"`
  double length = 1, bound = 0;
  int width = 320, samples = 8;
};

std::string ribOf(const Wanted& w) {
  return "Hider \"raytrace\" \"int minsamples\" [" + std::to_string(w.samples) + "] \"int maxsamples\" [" +
         std::to_string(w.samples) +
         "]\nIntegrator \"PxrPathTracer\" \"paths\" \"int maxIndirectBounces\" [2]\nFormat " +
         std::to_string(w.width) + " " + std::to_string(w.width * 3 / 4) +
         " 1\nProjection \"perspective\" \"fov\" [46]\nDisplay \"bench.exr\" \"openexr\" \"Ci,a\"\nTranslate 0 0 3\n"
         "WorldBegin\nLight \"PxrDistantLight\" \"sun\"\nRotate 20 1 0 0\nAttribute \"dice\" \"int levels\" [" +
         std::to_string(w.levels) + "] \"float micropolygonlength\" [" + std::to_string(w.length) +
         "]\nAttribute \"displacementbound\" \"float sphere\" [" + std::to_string(w.bound) +
         "] \"string coordinatesystem\" [\"object\"]\n" + w.displacement + "Bxdf \"PxrDiffuse\" \"white\"\n" +
         w.shape + "WorldEnd\n";
}

// One thread's; null where the scene is refused.
std::unique_ptr<Renderer> rendererOf(const Wanted& wanted, Registry& registry, Diagnostics& diagnostics) {
  std::optional<scene::Scene> scene;
  rib::RibReader reader(diagnostics, {}, [&](scene::Scene&& s) { scene = std::move(s); });
  if (!reader.readString("bench.rib", ribOf(wanted))) return nullptr;
  reader.finish();
  if (!scene) return nullptr;
  render::Settings settings;
  settings.threads = 1;
  auto renderer = std::make_unique<Renderer>(registry, diagnostics, settings);
  if (!renderer->load(std::move(*scene))) return nullptr;
  return renderer;
}

// Micropolygons that rays of a new world had diced, in millions a second.
void measureDicing(const std::string& name, const std::string& displacement, const Options& options,
                   Figures& figures) {
  Registry registry;
  Diagnostics diagnostics([](const std::string&, Severity) {});
  Wanted wanted{displacement, kSquare};
  wanted.length = options.quick ? 0.5 : 0.08;
  wanted.width = options.quick ? 32 : 160;
  wanted.samples = 1;
  std::vector<double> rate;
  for (int r = 0; r < options.repeat; ++r) {
    const auto renderer = rendererOf(wanted, registry, diagnostics);
    if (!renderer || renderer->renderFilm() != render::Outcome::Complete) return;
    const render::GeometryStatistics& g = renderer->statistics().geometry;
    uint64_t made = 0;
    for (const auto& kinds : g.micropolygons)
      for (const uint64_t n : kinds) made += n;
    if (g.seconds > 0) rate.push_back(1e-6 * double(made) / g.seconds);
  }
  figures.add(name, rate, "millions of micropolygons that a core dices in a second, normals and hierarchy included");
}

// Rays by the second in the stages that trace, dicing left out.
double rateOf(Renderer& renderer) {
  const render::Statistics& s = renderer.statistics();
  double seconds = -s.geometry.seconds;
  for (const StageTime stage : {StageTime::TraceCamera, StageTime::TraceIndirect, StageTime::TraceShadow})
    seconds += 1e-9 * double(s.stageNanoseconds[size_t(stage)]);
  return double(s.cameraRays + s.indirectRays + s.shadowRays) / seconds;
}

void measureRays(const std::string& name, const std::string& shape, double bound, const std::string& meaning,
                 const Options& options, Figures& figures) {
  Registry registry;
  Diagnostics diagnostics([](const std::string&, Severity) {});
  Wanted wanted{kPlugin, shape};
  wanted.bound = bound;
  if (options.quick) wanted.width = 48, wanted.samples = 1;
  std::vector<double> ratio;
  for (int r = 0; r < options.repeat; ++r) {
    double rate[2];
    for (int levels = 0; levels < 2; ++levels) {
      wanted.levels = levels;
      const auto renderer = rendererOf(wanted, registry, diagnostics);
      if (!renderer || renderer->renderFilm() != render::Outcome::Complete) return;
      rate[levels] = rateOf(*renderer);
    }
    ratio.push_back(rate[1] / rate[0]);
  }
  figures.add(name, ratio, meaning);
}

}  // namespace

void measureLevels(const Options& options, Figures& figures) {
  const Folder folder;
  std::ofstream(folder.path() + "/bumps.osl") << kShader;
  measureDicing("dicing_plugin", kPlugin, options, figures);
  measureDicing("dicing_shader",
                "Option \"searchpath\" \"string shader\" [\"" + folder.path() + "\"]\nDisplace \"bumps\" \"bumps\"\n",
                options, figures);
  const std::string of = "rays on a surface that is diced where rays ask against the same as a mesh of Embree's: ";
  measureRays("levels_vs_mesh_patch", kPatch, 0, of + "a bicubic patch", options, figures);
  measureRays("levels_vs_mesh_square", kSquare, 0, of + "a square", options, figures);
  measureRays("levels_vs_mesh_sphere", kSphere, 0, of + "a sphere", options, figures);
  measureRays("levels_vs_mesh_wide_bound", kPatch, 0.2, of + "the patch with a bound of twice what it moves", options,
              figures);
}

}  // namespace kinora::bench
