// Where time and memory went. Filled by render/ from per-thread counters at barriers; written by app/ as .json and
// .txt.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace kinora::render {

// Stages of the group loop; time is taken once a group and stage, never per ray.
enum class StageTime : uint32_t {
  CameraRays,
  TraceCamera,
  TraceIndirect,
  TraceShadow,
  Grouping,
  Closures,
  Lights,
  Integrator,
  Film,
  Count
};
const char* nameOf(StageTime s);

// SIMD lanes that held a point, lanes that could have, and of shading also the groups that they were counted over.
struct LaneUse {
  uint64_t active = 0, possible = 0, groups = 0;
};

// Time of one bucket, all passes together.
struct BucketTime {
  int x = 0, y = 0, size = 0;
  uint64_t nanoseconds = 0;
};

// One number for each pixel of the rendered window.
struct PixelMap {
  int x0 = 0, y0 = 0, width = 0, height = 0;
  std::vector<float> values;  // row by row; empty: not measured
};

// One program of the shading language: shaders that run together, for all materials that differ in numbers alone.
// Instructions and lanes are those of a sixteenth of its runs.
struct ShaderCost {
  std::string name;
  uint64_t materials = 0, runs = 0, points = 0, nanoseconds = 0;
  uint64_t countedRuns = 0, instructions = 0, uniformInstructions = 0;
  LaneUse lanes;  // of what kernels worked on: that held a point which took part
  // What another one has cost goes on to this; not how many materials run it.
  void addCost(const ShaderCost& other) {
    runs += other.runs;
    points += other.points;
    nanoseconds += other.nanoseconds;
    countedRuns += other.countedRuns;
    instructions += other.instructions;
    uniformInstructions += other.uniformInstructions;
    lanes.active += other.lanes.active;
    lanes.possible += other.lanes.possible;
  }
};

// What was made, over all load() and update() calls: of what an edit did not reach, nothing.
struct Rebuilt {
  uint64_t textures = 0;  // systems opened: for another search path, or files that have changed
  uint64_t cameras = 0, integrators = 0, plans = 0;  // plans: channels, filters and light paths of a frame
  uint64_t flattened = 0;                            // lists of placed objects
  uint64_t meshes = 0;                               // tessellated, but for those that came out as before
  uint64_t materials = 0;                            // bound to programs
  uint64_t worlds = 0;     // of traced parts; bvhPartsBuilt and bvhBuilds say what was new in them
  uint64_t lights = 0;     // made by their plug-ins
  uint64_t lightSets = 0;  // trees over them
  bool operator==(const Rebuilt&) const = default;
};

// Of surfaces that are diced where rays ask (render/levels.h), over all renders.
struct GeometryStatistics {
  // Quads diced, by level (0: as fine as the camera asks) and kind of the ray that asked: camera, indirect, shadow.
  std::array<std::array<uint64_t, 3>, 11> micropolygons{};
  uint64_t made = 0, again = 0, twice = 0,
           evicted = 0;   // tessellations; again: once more, twice: by two threads at once
  uint64_t found = 0;     // patches that rays found diced, but for some that threads have not told yet
  uint64_t passed = 0;    // patches that were not diced, since an outline of theirs says that the ray goes by
  uint64_t vertices = 0;  // shaded for displacement
  double seconds = 0;     // CPU time of dicing, on all threads
  uint64_t limit = 0, bytes = 0, mostBytes = 0;  // of the cache; held at the end, and at most
  uint64_t whole = 0;  // micropolygons of all patches of the last world, at the camera's rate
};

struct Statistics {
  // world
  Rebuilt rebuilt;
  double loadSeconds = 0, buildSeconds = 0, renderSeconds = 0, firstPixelSeconds = -1;
  double firstGroupSeconds = -1;  // from the start of the process until its first samples were pixels
  uint64_t primitives = 0, instances = 0, triangles = 0, lights = 0, materials = 0, programs = 0;
  uint64_t shadersCompiled = 0, shaderPrograms = 0;  // of the shading language: files, and programs of the machine
  double shaderCompileSeconds = 0;                   // both, within buildSeconds
  uint64_t micropolygons = 0;                        // displaced, over all load() and update() calls
  // Procedurals that are read when rays meet them, of the last load() or update() on: met in the description and in what
  // was read, read, worlds made for them, and the time of both.
  uint64_t procedurals = 0, proceduralsRead = 0, proceduralWorlds = 0;
  // Those that were dropped to keep a budget, and read once more; bytes that they hold at the end, held at most, and of
  // the largest one; the budget, 0: there is none.
  uint64_t proceduralsDropped = 0, proceduralsAgain = 0;
  uint64_t proceduralBytes = 0, proceduralMostBytes = 0, proceduralLargest = 0, proceduralBudget = 0;
  double proceduralReadSeconds = 0, proceduralBuildSeconds = 0;
  double displaceSeconds = 0;                 // shading and moving them; meshes made at a time count each
  uint64_t bvhBuilds = 0, bvhPartsBuilt = 0;  // over all load() and update() calls
  GeometryStatistics geometry;
  // memory by owner, bytes; what the process holds beyond all others stands under kOthers
  static constexpr const char* kOthers = "program, libraries and others";
  struct Owner {
    std::string name;
    uint64_t bytes;
  };
  std::vector<Owner> memory;
  // loop
  std::array<uint64_t, size_t(StageTime::Count)> stageNanoseconds{};
  uint64_t cameraRays = 0, indirectRays = 0, shadowRays = 0, lightRays = 0;
  uint64_t cameraHits = 0, indirectHits = 0;
  uint64_t shadingPoints = 0, shadingGroups = 0;
  // By depth of the vertex: camera hits first, the last for it and all beyond. `lanesQueries`: groups that are asked
  // for presence, the light that surfaces let through and the media behind them, which shade nothing.
  std::array<LaneUse, 12> lanesAt;
  LaneUse lanesQueries, lanesWalks;                         // lanesWalks: of points that manifold walks came by
  uint64_t walksBegun = 0, walksFound = 0, walkTrials = 0;  // trials: that count how likely a path is found
  uint64_t groups = 0, samples = 0;
  double noise =
      -1;  // adaptive: relative error of the picture at the last decision, see Convergence::error; -1: unknown
  uint64_t donePixels = 0;  // that adaptive sampling found good enough before they had all samples
  std::vector<ShaderCost> shaders;
  std::vector<BucketTime> buckets;  // of the last render
  // film
  PixelMap relativeError;  // of the first colour, as its two halves of samples differ
  uint64_t nonFiniteSamples = 0, saturatedSamples = 0, negativeSamples = 0;
  uint64_t endlessRays = 0;  // given up after passing too many surfaces
  // media that fill space: rays that came through some, places where they were asked what they are; rays given up, and
  // media left out where too many overlap; the largest factor over a bound of extinction, and whose
  uint64_t mediaRays = 0, mediaLookups = 0, endlessTracks = 0, mediaOverflows = 0;
  float mediaExcess = 1;
  std::string excessMedium;
  // Paths below surfaces that came out where they went in: those of objects with no inside, those without end; and an
  // object of each, the first of the scene.
  std::array<uint64_t, 2> lostBelow{};
  std::array<std::optional<uint32_t>, 2> lostPlacement;
  std::array<std::string, 2> lostObject;
  // Grids of volume files: the bound of what lies in memory (0: none), what does, what lies in a file, the most that was in
  // memory of both, and how often pieces of the file (2 MiB) were let go.
  struct Volumes {
    uint64_t limit = 0, memoryBytes = 0, fileBytes = 0, mostBytes = 0, letGo = 0;
  } volumes;
  // textures
  uint64_t textureLookups = 0, textureMisses = 0, textureBytes = 0;
  uint64_t textureTilesAgain = 0, textureBytesRead = 0;  // tiles that the cache had dropped; read, uncompressed
  struct TextureFile {
    std::string path;
    uint64_t bytesRead = 0, tilesAgain = 0;
  };
  std::vector<TextureFile> largestTextures;  // those of which most was read
};

}  // namespace kinora::render
