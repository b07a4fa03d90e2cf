// Frames with media and with subsurface scattering against the same frames without, in turns.
#include "media.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>

#include "plugin/registry.h"
#include "render/renderer.h"
#include "rib/reader.h"

namespace kinora::bench {

namespace {

using render::Renderer;
using render::Settings;

// Some scenes that are rendered in turns, a thread each, and their CPU seconds.
class Turns {
 public:
  explicit Turns(const Options& options) : options_(options) {}

  // A scene of RIB text.
  void add(const std::string& name, const std::string& rib, std::array<int, 2> resolution, int samples) {
    std::optional<scene::Scene> scene;
    rib::RibReader reader(diagnostics_, {}, [&](scene::Scene&& s) { scene = std::move(s); });
    if (!reader.readString(name, rib)) throw std::runtime_error("the scene '" + name + "' is not read");
    reader.finish();
    if (!scene) throw std::runtime_error("the scene '" + name + "' has no world");
    Settings settings;
    settings.threads = 1;
    settings.samplesPerPixel = options_.quick ? 1 : samples;
    settings.resolution = options_.quick ? std::array<int, 2>{16, 12} : resolution;
    frames_.push_back({std::make_unique<Renderer>(registry_, diagnostics_, settings), {}});
    if (!frames_.back().renderer->load(std::move(*scene)))
      throw std::runtime_error("the scene '" + name + "' is not rendered");
    frames_.back().renderer->renderFilm();  // what is made once is made
  }
  void run() {
    for (int r = 0; r < options_.repeat; ++r)
      for (Frame& f : frames_) {
        const double start = threadSeconds();
        f.renderer->renderFilm();
        f.seconds.push_back(threadSeconds() - start);
      }
  }
  const std::vector<double>& seconds(size_t frame) const { return frames_[frame].seconds; }
  // Turn by turn, what one takes over what another does.
  std::vector<double> ratios(size_t frame, size_t base) const {
    std::vector<double> out;
    for (size_t k = 0; k < frames_[frame].seconds.size(); ++k)
      out.push_back(frames_[frame].seconds[k] / frames_[base].seconds[k]);
    return out;
  }
  // Of all times that it was rendered.
  const render::Statistics& statistics(size_t frame) const { return frames_[frame].renderer->statistics(); }
  double timesRendered() const { return options_.repeat + 1; }

 private:
  struct Frame {
    std::unique_ptr<Renderer> renderer;
    std::vector<double> seconds;
  };
  const Options& options_;
  Registry registry_;
  Diagnostics diagnostics_{[](const std::string&, Severity) {}};
  std::vector<Frame> frames_;
};

std::string textOf(const std::string& file) {
  std::ifstream in(file);
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (text.empty()) throw std::runtime_error("'" + file + "' cannot be read");
  return text;
}

// A round cloud of voxels, about so many mean free paths wide, under a sky and a sun.
std::string cloudScene(int bounces, bool quick) {
  const int n = quick ? 12 : 64;
  std::string voxels;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const double p[3] = {2. * x / (n - 1) - 1, 2. * y / (n - 1) - 1, 2. * z / (n - 1) - 1};
        const double bump = std::sin(7 * p[0] + 2 * p[1]) * std::sin(6 * p[1] + p[2]) * std::sin(8 * p[2] - p[0]);
        const double r = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) + 0.15 * bump;
        char text[16];
        std::snprintf(text, sizeof text, "%.3g ", r < 0.9 ? 0.6 + 0.4 * bump : 0.);
        voxels += text;
      }
  const std::string side = std::to_string(n);
  return "Integrator \"PxrPathTracer\" \"paths\" \"int maxIndirectBounces\" [" + std::to_string(bounces) +
         "] \"float clampLuminance\" [50]\nProjection \"perspective\" \"fov\" [32]\nTranslate 0 0 4\nWorldBegin\n"
         "Light \"PxrDomeLight\" \"sky\" \"float intensity\" [0.3]\nAttributeBegin\nRotate 60 1 0 0\n"
         "Light \"PxrDistantLight\" \"sun\" \"float intensity\" [4000] \"float angleExtent\" [0.6]\nAttributeEnd\n"
         "Bxdf \"PxrVolume\" \"water\" \"color diffuseColor\" [0.999 0.999 0.999] \"color densityColor\" [20 20 20]\n"
         "\"string densityFloatPrimVar\" [\"density\"] \"float anisotropy\" [0.6] \"int multiScatter\" [1]\n"
         "Volume \"box\" [-1 1 -1 1 -1 1] [" +
         side + " " + side + " " + side + "] \"varying float density\" [" + voxels + "]\nWorldEnd\n";
}

// A ball on a floor under a sky and a lamp, 16 samples and four bounces.
std::string ballScene(const std::string& parameters) {
  return "Projection \"perspective\" \"fov\" [35]\n"
         "Integrator \"PxrPathTracer\" \"paths\" \"int maxIndirectBounces\" [4]\nTranslate 0 -.4 5\nRotate -12 1 0 "
         "0\n"
         "WorldBegin\nAttributeBegin\nLight \"PxrDomeLight\" \"sky\" \"color lightColor\" [.5 .6 .8]\nAttributeEnd\n"
         "AttributeBegin\nTranslate 2 4 -2\nRotate 90 1 0 0\nLight \"PxrRectLight\" \"lamp\" \"float intensity\" "
         "[20]\n"
         "AttributeEnd\nAttributeBegin\nBxdf \"PxrDiffuse\" \"floor\" \"color diffuseColor\" [.5 .5 .5]\n"
         "Polygon \"P\" [-9 -1 -9 -9 -1 9 9 -1 9 9 -1 -9]\nAttributeEnd\nAttributeBegin\nBxdf \"PxrSurface\" "
         "\"ball\" " +
         parameters + "\nSphere 1 -1 1 360\nAttributeEnd\nWorldEnd\n";
}

}  // namespace

void measureFog(const Options& options, Figures& figures) {
  Turns turns(options);
  const std::string room = textOf(KINORA_SOURCE_DIR "/scenes/cornell.rib");
  std::string foggy = room;
  foggy.insert(foggy.rfind("WorldEnd"),
               "AttributeBegin\nBxdf \"PxrVolume\" \"fog\" \"float densityFloat\" [0.1]\n"
               "Volume \"box\" [-2 2 -1 3 -4 3] [0 0 0]\nAttributeEnd\n");
  turns.add("room", room, {160, 90}, 16);
  turns.add("room in fog", foggy, {160, 90}, 16);
  turns.run();
  figures.add("fog_vs_clear", turns.ratios(1, 0), "scenes/cornell.rib full of even fog, over without");
}

void measureCloud(const Options& options, Figures& figures) {
  Turns turns(options);
  const int bounces[] = {8, 64, 256};
  for (const int b : bounces) turns.add(std::to_string(b) + " bounces", cloudScene(b, options.quick), {96, 72}, 4);
  turns.run();
  std::vector<double> perLookup[3];
  for (size_t k = 0; k < 3; ++k) {
    const double lookups = double(turns.statistics(k).mediaLookups) / turns.timesRendered();
    for (const double s : turns.seconds(k)) perLookup[k].push_back(s / std::max(lookups, 1.) * 1e9);
  }
  std::vector<double> growth;
  for (size_t r = 0; r < perLookup[0].size(); ++r) growth.push_back(perLookup[2][r] / perLookup[0][r]);
  figures.add("ns_cloud_collision_8", perLookup[0],
              "a cloud of voxels, 8 bounces: CPU time by tentative collision, all that happens between them with it");
  figures.add("ns_cloud_collision_256", perLookup[2], "the same with 256 bounces");
  figures.add("cloud_growth_256", growth, "that over the one with 8: 1 is linear in collisions");
  render::LaneUse lanes;
  for (const render::LaneUse& at : turns.statistics(2).lanesAt) {
    lanes.active += at.active;
    lanes.possible += at.possible;
  }
  figures.add("cloud_lane_use", {double(lanes.active) / double(std::max<uint64_t>(lanes.possible, 1))},
              "SIMD lanes in use where paths are shaded, all depths, 256 bounces");
}

void measureBelow(const Options& options, Figures& figures) {
  Turns turns(options);
  turns.add("diffuse", ballScene(""), {320, 320}, 16);
  const char* const lengths[] = {"0.1", "0.3", "1"};
  for (const char* type : {"4", "2"})
    for (const char* length : lengths)
      turns.add(
          std::string("type ") + type + ", " + length,
          ballScene(std::string("\"float diffuseGain\" [0] \"float subsurfaceGain\" [1] \"float unitLength\" [1] "
                                "\"int subsurfaceType\" [") +
                    type + "] \"float subsurfaceDmfp\" [" + length + "]"),
          {320, 320}, 16);
  turns.run();
  for (size_t k = 0; k < 3; ++k)
    figures.add(std::string("walks_vs_diffuse_") + lengths[k], turns.ratios(1 + k, 0),
                std::string("a ball of subsurfaceType 4, diffuse mean free path ") + lengths[k] +
                    " of its radius, over a diffuse one");
  for (size_t k = 0; k < 3; ++k)
    figures.add(std::string("profile_vs_diffuse_") + lengths[k], turns.ratios(4 + k, 0),
                "the same of type 2 (Burley)");
}

}  // namespace kinora::bench
