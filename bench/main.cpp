// The program kinora-bench: runs one family of measurements and prints and writes its figures (docs/performance.md
// says what they have been).
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "core.h"
#include "edits.h"
#include "lights.h"
#include "match_orders.h"
#include "media.h"
#include "rich_scene.h"
#include "sequences.h"
#include "shading.h"
#include "simd/dispatch.h"

namespace {

using namespace kinora::bench;

struct Group {
  const char* name;
  void (*run)(const Options&, Figures&);
  const char* meaning;
};
constexpr Group kCore[] = {
    {"surface", &measureSurface,
     "surface_width_gain, width1_vs_scalar, ns_surface_width_*: PxrSurface at width 1 against the best width, and "
     "against "
     "plain scalar code of the same formulas"},
    {"tracing", &measureTracing,
     "trace_vs_embree_*, frame_vs_embree_*, rays_per_sample_*, ns_*: a render's trace stages and its whole frame "
     "against "
     "bare Embree on the same rays with the best call for each kind; ns_above_embree_*: the frame's nanoseconds a "
     "ray "
     "above bare Embree's"},
    {"rich", &measureRich,
     "the same figures of a frame as films have them, *_rich: smooth normals, st, 40 materials of five textures, "
     "instances, motion blur, glass, a dome and 20 lights; ns_outside_trace_rich: what is not in the trace stages"},
    {"curves", &measureCurves,
     "curves_vs_embree: closest hits of round cubic curves through a render's trace stages against bare Embree on "
     "the "
     "same rays with the best call for each kind"},
    {"frames", &measureFrames,
     "frame_width_gain, frame_width_gain_textures: whole frames at width 1 against the best width; threads_2: one "
     "thread "
     "against two"},
    {"levels", &measureLevels,
     "dicing_*: millions of micropolygons that a core dices in a second; levels_vs_mesh_*: rays on surfaces that are "
     "diced where rays ask against the same as a mesh of Embree's"},
    {"light_paths", &measureLightPaths, "lpe_cost_12: what 12 light path channels add to a frame's CPU time"},
    {"textures", &measureTextures,
     "texture_vs_oiio: trilinear lookups of groups of 256 points against OpenImageIO's own call, in cache; "
     "million_lookups*"},
    {"reads", &measureTextureReads,
     "texture_reads_*: tiles a second that 1 to 8 threads read of files that answer after 0, 1 and 10 ms more, "
     "texture_reads_gain_*: over those when each lookup reads by itself; texture_hits_beside_reads: lookups in cache "
     "beside them against alone"},
    {"memory", &measureMemory,
     "bytes_per_triangle: all that a mesh costs, by owner, and the process' growth beside it"},
    {"lanes", &measureLanes, "lane_use_first_hit: SIMD lanes in use at camera hits, 1,000 materials of 8 programs"},
    {"first_pixel", &measureFirstPixel, "first_pixel_seconds: from a scene loaded to its first pixels in the file"},
};

constexpr Group kShading[] = {
    {"machine", &measureShading,
     "vm_vs_fused*: programs of the group machine against the same as fused SIMD C++; vm_width_gain*; "
     "compile_ms_200_lines, network_100_nodes_ms: what compiling takes"},
    {"frames", &measureShadedFrames,
     "frame_vs_patterns: a frame whose materials are networks of ten shaders against the same with plug-ins"},
};

constexpr Group kLights[] = {
    {"lights", &measureLights,
     "ns_light_sample_10, light_growth_*: a light sample among 10, 1,000 and 1,000,000 small lights; "
     "light_noise_vs_power: "
     "its variance against choice by power; bytes_per_light, light_build_seconds"},
};

constexpr Group kMedia[] = {
    {"fog", &measureFog, "fog_vs_clear: a room full of even fog against the same without"},
    {"lookups", &measureVoxelLookups,
     "lookups_vs_openvdb*, ns_lookup*: trilinear lookups of a grid by groups against OpenVDB's sampler at the same "
     "points"},
    {"cloud", &measureCloud,
     "cloud_growth_256, ns_cloud_collision_*, cloud_lane_use: what a collision takes in a cloud with 256 bounces "
     "against 8, and the lanes in use"},
    {"below", &measureBelow,
     "walks_vs_diffuse_*, profile_vs_diffuse_*: a ball with subsurface scattering, by walks and by a profile, "
     "against "
     "a diffuse one"},
};

constexpr Group kSampling[] = {
    {"integrals", &measureIntegrals,
     "error_SEQUENCE_INTEGRAND_N: root mean square error over pixels of N samples, over the integral; "
     "gain_matched_*: "
     "variance of sequences that are shuffled against each other by chance over that of matched ones"},
    {"screen", &measureScreen,
     "screen_*: what is left of the error of pixels when neighbours are averaged, over what is left of independent "
     "errors"},
};

int writeScenes(const std::string& folder, bool quick) {
  if (folder.empty()) {
    std::fputs("kinora-bench: error CLI-NAME: scenes go into a folder; nothing was written; try --out FOLDER\n",
               stderr);
    return 2;
  }
  try {
    std::filesystem::create_directories(folder);
    std::puts(writeRichScene(folder, quick).file.c_str());
    std::puts(writeNestedGlasses(folder, quick).c_str());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "kinora-bench: error BENCH-WRITE: %s\n", e.what());
    return 6;
  }
  return 0;
}

constexpr Group kEdits[] = {
    {"edits", &measureEdits,
     "edit_*_ms, edit_*_cpu_ms: from update() begun to the first ray group after the camera, a light, a dome of 4k, "
     "a "
     "material or an object was edited in a scene of 1M triangles and 200 materials; edit_load_ms: after a load"},
};

int list() {
  std::puts("core: the path tracing loop (ratios within one run, repetitions in turn, medians with least and most)");
  for (const Group& g : kCore) std::printf("  %-12s %s\n", g.name, g.meaning);
  std::puts("shading: the shading language");
  for (const Group& g : kShading) std::printf("  %-12s %s\n", g.name, g.meaning);
  std::puts("lights: choice among many lights");
  for (const Group& g : kLights) std::printf("  %-12s %s\n", g.name, g.meaning);
  std::puts("edits: an edited scene rendered again");
  for (const Group& g : kEdits) std::printf("  %-12s %s\n", g.name, g.meaning);
  std::puts("media: media that fill space, and light below surfaces");
  for (const Group& g : kMedia) std::printf("  %-12s %s\n", g.name, g.meaning);
  std::puts("sampling: sequences of samples against each other");
  for (const Group& g : kSampling) std::printf("  %-12s %s\n", g.name, g.meaning);
  std::puts("match_orders: measures nothing; prints the orders of src/sampling/matched_orders.cpp");
  std::puts("scenes: measures nothing; writes rich.rib and glass.rib with their textures into the folder of --out");
  return 0;
}

}  // namespace

int main(int count, char** values) {
  if (!kinora::cpuHasAvx2()) {
    std::fputs("kinora-bench: error APP-CPU: this CPU lacks AVX2, FMA, BMI2 or F16C; stopped\n", stderr);
    return 9;
  }
  CLI::App app{"Measures Kinora. NAME is a family; `kinora-bench list` says what each measures and against what."};
  std::string name, json, out;
  Options options;
  app.add_option("NAME", name,
                 "a family (core, shading, lights, edits, media, sampling), list, match_orders, or scenes")
      ->required();
  app.add_option("--json", json, "write the figures here as flat JSON");
  app.add_option("--out", out, "folder for what `scenes` writes");
  app.add_option("--repeat", options.repeat, "repetitions of each measure (default 5)")->check(CLI::Range(1, 1000));
  app.add_option("--only", options.filter, "only this group of the family's measures");
  app.add_option("--group-size", options.groupSize, "rays a group of the tracing measures");
  app.add_flag("--quick", options.quick, "tiny sizes: tests the program, measures nothing");
  app.add_flag("--spoil", options.spoil, "changes one of the values that are compared: to test that it is found")
      ->group("");
  app.add_flag("--full", options.full, "with 10 million triangles: more time, 4 GB of memory");
  try {
    app.parse(count, values);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) ? 2 : 0;
  }
  if (name == "list") return list();
  if (name == "scenes") return writeScenes(out, options.quick);
  if (name == "match_orders") return printMatchedOrders(options.quick);
  const std::pair<const char*, std::span<const Group>> families[] = {{"core", kCore},     {"shading", kShading},
                                                                     {"lights", kLights}, {"edits", kEdits},
                                                                     {"media", kMedia},   {"sampling", kSampling}};
  const auto* const family =
      std::find_if(std::begin(families), std::end(families), [&](const auto& f) { return name == f.first; });
  if (family == std::end(families)) {
    std::fprintf(stderr, "kinora-bench: error CLI-NAME: no family '%s'; nothing was run; try `kinora-bench list`\n",
                 name.c_str());
    return 2;
  }
  Figures figures;
  bool ran = false;
  kinora::setThreadFloatMode();
  for (const Group& g : family->second) {
    if (!options.filter.empty() && options.filter != g.name) continue;
    std::printf("%s\n", g.name);
    g.run(options, figures);
    ran = true;
  }
  if (!ran) {
    std::fprintf(stderr, "kinora-bench: error CLI-NAME: no group '%s'; nothing was run; try `kinora-bench list`\n",
                 options.filter.c_str());
    return 2;
  }
  figures.print();
  if (!json.empty() && !figures.writeJson(json)) {
    std::fprintf(stderr, "kinora-bench: error BENCH-WRITE: '%s' cannot be written\n", json.c_str());
    return 6;
  }
  return figures.isSound() ? 0 : 1;
}
