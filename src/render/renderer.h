// Renders one scene: world snapshot, passes, film. The one door of render/ for app/, tests and bench/. It prints
// nothing (messages go through Diagnostics, progress through a callback) and writes files only through film/'s
// displays.
#pragma once
#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "render/checkpointing.h"
#include "render/statistics.h"
#include "scene/procedural.h"
#include "scene/scene.h"
#include "volume/read_process.h"

namespace kinora {
class Registry;
namespace film {
class Film;
}
namespace shade {
class RayListener;
}
namespace render {

class Hider;

// What the command line (or a test) sets on top of the scene.
// Of a picture: pixels on a side, and in all.
inline constexpr int kMostSide = 1 << 16;
inline constexpr int64_t kMostPixels = int64_t(1) << 31;

struct Settings {
  int threads = 0;          // 0: all; -n: all but n
  int samplesPerPixel = 0;  // 0: what the scene says
  // Adaptive sampling: relative deviation at which pixels are done (0: none; -1: what the scene says), or that of the
  // whole picture (root mean square; 0: not asked for), and the least and the most samples a pixel (0: what the scene
  // says, or with pictureError as many as it takes). Not together with samplesPerPixel.
  float pixelVariance = -1, pictureError = 0;
  int leastSamples = 0, mostSamples = 0;
  int firstSample = -1, lastSample = -1;                  // --samples A:B (B exclusive); -1: not given
  std::array<int, 2> resolution{0, 0};                    // 0: the scene's
  std::array<float, 4> crop{-1, -1, -1, -1};              // xmin xmax ymin ymax; -1: the scene's
  std::string integrator;                                 // "": the scene's
  std::vector<std::pair<std::string, std::string>> sets;  // --set KIND.NAME=VALUE, unparsed
  uint32_t seed = 0;
  uint32_t width = 0;       // SIMD width 1, 4, 8, 16; 0: best
  uint32_t groupSize = 0;   // rays a group; 0: default
  std::string bucketOrder;  // "": the scene's, else horizontal, vertical, spiral, random ...
  std::string output;       // -o
  bool strict = false;
  std::vector<std::string> texturePath, shaderPath;  // directories, beside those of the scene
  uint64_t textureCacheBytes = 0;                    // 0: default
  std::string textureFolder;                         // for levels of files that have none; "": none are kept
  uint64_t geometryCacheBytes = 0;                   // 0: what the scene says, else 1 GiB
  uint64_t volumeCacheBytes = 0;  // of grids in memory; 0: what the scene says, else half of the memory limit, if any
  volume::ReaderProgram volumeReader;         // reads files of volumes; without a command none are
  double snapshotSeconds = 60;                // 0: never
  Checkpointing checkpoint;                   // --checkpoint, --recover
  bool readsAllProcedurals = false;           // before the first sample: the same picture
  bool errorMap = false;                      // measure each pixel's error too, for the statistics
  shade::RayListener* rayListener = nullptr;  // for measurements
  std::atomic<bool>* stop = nullptr;          // set by a signal: finish running buckets, then return
  std::atomic<bool>* snapshotNow = nullptr;   // set by a signal: write picture and checkpoint so far, then go on
};

struct Progress {
  double fraction = 0;      // of the samples wanted
  double secondsLeft = -1;  // -1: not known yet
  double seconds = 0;
  bool isErrorWanted = false;  // Settings::pictureError is set
  double error = -1;           // of the picture so far, then; -1: not known yet
  uint64_t memoryBytes = 0;
  int samplesDone = 0, samplesWanted = 0;  // whole passes, a pixel
};

enum class Outcome { Complete, Interrupted, BadScene, OutOfMemory, CannotWrite, Internal };

class Renderer {
 public:
  Renderer(Registry& registry, Diagnostics& diagnostics, Settings settings);
  ~Renderer();
  // Builds the world: plug-ins, textures, BVHs. False when nothing can be rendered (messages say why).
  // `procedurals`: what can be read of the scene's primitives that stand for procedurals, once rays meet them; those of
  // which nothing can be are not rendered.
  bool load(scene::Scene scene, std::shared_ptr<const scene::ProceduralSources> procedurals = nullptr);
  // The scene may be edited in any way between renders; update() makes what the edits reached (Statistics::rebuilt
  // counts it), and the picture is then a fresh load's. False as for load(): nothing is rendered until the next one.
  scene::Scene& scene();
  bool update();
  // Renders and writes displays. May be called again after update().
  Outcome render(const std::function<void(const Progress&)>& progress = {});
  // Renders into the film without writing displays (tests, bench, shards).
  Outcome renderFilm(const std::function<void(const Progress&)>& progress = {});
  film::Film& film();
  // Fills the samples of later renders instead of the loop over rays (null: that loop). It outlives them.
  void setHider(const Hider* hider);
  // Replays one sample at width 1; `print` gets one line for each event of its path. False: no such pixel.
  bool replay(int x, int y, int sample, const std::function<void(const std::string&)>& print);
  const Statistics& statistics() const;
  // Writes the film's integers as a mergeable shard (--samples): after an interruption those of the samples that
  // every pixel has. False with a message when it cannot be written or when no pass was complete.
  bool writeShard(const std::string& file);
  // How many samples of each pixel are complete.
  int samplesDone() const;
  int samplesEnd() const;  // behind the last index done
  // A short text on the scene: counts, memory, lights (kinora info, --check).
  std::string summary() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace render
}  // namespace kinora
