#include "app/stats_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <numeric>

#include "app/progress_reporter.h"
#include "app/stats_html.h"
#include "base/memory.h"
#include "image/atomic_file.h"
#include "render/version.h"

namespace kinora::app {

namespace {

using render::LaneUse;
using render::StageTime;
using render::Statistics;

uint64_t totalRays(const Statistics& s) { return s.cameraRays + s.indirectRays + s.shadowRays + s.lightRays; }

// Of shaders or buckets.
template <class T>
std::vector<T> slowest(std::vector<T> order, size_t most) {
  std::stable_sort(order.begin(), order.end(), [](const T& a, const T& b) { return a.nanoseconds > b.nanoseconds; });
  order.resize(std::min(order.size(), most));
  return order;
}

double ratio(double a, double b) { return b > 0 ? a / b : 0; }
double share(const LaneUse& l) { return ratio(double(l.active), double(l.possible)); }

// Rays that a trace stage works on; 0 for stages whose work is not counted in rays of one kind.
uint64_t raysOf(const Statistics& s, StageTime stage) {
  switch (stage) {
    case StageTime::CameraRays:
    case StageTime::TraceCamera:
      return s.cameraRays;
    case StageTime::TraceIndirect:
      return s.indirectRays;
    case StageTime::TraceShadow:
      return s.shadowRays;
    default:
      return 0;
  }
}

uint64_t loopNanoseconds(const Statistics& s) {
  uint64_t sum = 0;
  for (uint64_t t : s.stageNanoseconds) sum += t;
  return sum;
}

std::vector<Statistics::Owner> largestFirst(const Statistics& s) {
  std::vector<Statistics::Owner> owners = s.memory;
  std::stable_sort(owners.begin(), owners.end(), [](const auto& a, const auto& b) { return a.bytes > b.bytes; });
  return owners;
}

double pointsPerGroup(const LaneUse& l) { return ratio(double(l.active), double(l.groups)); }

// Of all vertices after the camera's.
LaneUse deeperLanes(const Statistics& s) {
  LaneUse sum;
  for (size_t k = 1; k < s.lanesAt.size(); ++k) {
    sum.active += s.lanesAt[k].active;
    sum.possible += s.lanesAt[k].possible;
    sum.groups += s.lanesAt[k].groups;
  }
  return sum;
}

nlohmann::ordered_json asJson(const LaneUse& l) {
  return {{"active", l.active}, {"possible", l.possible}, {"share", share(l)}};
}

nlohmann::ordered_json asJson(const render::ShaderCost& c) {
  return {{"name", c.name},
          {"materials", c.materials},
          {"seconds", double(c.nanoseconds) * 1e-9},
          {"runs", c.runs},
          {"points", c.points},
          {"nanoseconds_per_point", ratio(double(c.nanoseconds), double(c.points))},
          {"instructions_per_run", ratio(double(c.instructions), double(c.countedRuns))},
          {"uniform_instructions_per_run", ratio(double(c.uniformInstructions), double(c.countedRuns))},
          {"lane_use", asJson(c.lanes)}};
}

}  // namespace

std::string statsAsJson(const Statistics& s, const StatsHeading& heading) {
  using Json = nlohmann::ordered_json;
  Json j;
  j["kinora"] = kVersion;
  j["scene"] = heading.scene;
  j["frame"] = heading.frame;
  j["outcome"] = heading.outcome;
  j["seconds"] = {{"load", s.loadSeconds}, {"build", s.buildSeconds}, {"render", s.renderSeconds}};
  if (s.firstPixelSeconds >= 0) j["seconds"]["first_pixel"] = s.firstPixelSeconds;
  if (s.firstGroupSeconds >= 0) j["seconds"]["first_group"] = s.firstGroupSeconds;
  j["world"] = {{"primitives", s.primitives}, {"instances", s.instances},          {"triangles", s.triangles},
                {"lights", s.lights},         {"materials", s.materials},          {"programs", s.programs},
                {"bvh_builds", s.bvhBuilds},  {"bvh_parts_built", s.bvhPartsBuilt}};
  if (s.procedurals)
    j["procedurals"] = {{"met", s.procedurals},
                        {"read", s.proceduralsRead},
                        {"read_again", s.proceduralsAgain},
                        {"dropped", s.proceduralsDropped},
                        {"budget", s.proceduralBudget},
                        {"bytes", s.proceduralBytes},
                        {"most_bytes", s.proceduralMostBytes},
                        {"largest_bytes", s.proceduralLargest},
                        {"worlds", s.proceduralWorlds},
                        {"read_seconds", s.proceduralReadSeconds},
                        {"build_seconds", s.proceduralBuildSeconds}};
  if (s.micropolygons) j["displacement"] = {{"micropolygons", s.micropolygons}, {"seconds", s.displaceSeconds}};
  if (s.geometry.made) {
    const render::GeometryStatistics& g = s.geometry;
    Json levels = Json::array();
    for (const auto& kinds : g.micropolygons)
      levels.push_back({{"camera", kinds[0]}, {"indirect", kinds[1]}, {"shadow", kinds[2]}});
    while (!levels.empty() && levels.back()["camera"] == 0 && levels.back()["indirect"] == 0 &&
           levels.back()["shadow"] == 0)
      levels.erase(levels.size() - 1);
    j["geometry_cache"] = {{"limit", g.limit},
                           {"bytes", g.bytes},
                           {"most_bytes", g.mostBytes},
                           {"found", g.found},
                           {"passed", g.passed},
                           {"made", g.made},
                           {"made_again", g.again},
                           {"made_twice", g.twice},
                           {"evicted", g.evicted},
                           {"micropolygons_in_all", g.whole},
                           {"vertices", g.vertices},
                           {"seconds", g.seconds},
                           {"micropolygons_by_level", levels}};
  }
  Json memory = Json::object();
  uint64_t sum = 0;
  for (const auto& owner : largestFirst(s)) {
    memory[owner.name] = owner.bytes;
    sum += owner.bytes;
  }
  j["memory_bytes"] = {{"by_owner", memory}, {"sum", sum}, {"resident_peak", heading.residentPeakBytes}};
  const uint64_t rays = totalRays(s), loop = loopNanoseconds(s);
  j["rays"] = {{"camera", s.cameraRays},
               {"indirect", s.indirectRays},
               {"shadow", s.shadowRays},
               {"light", s.lightRays},
               {"all", rays},
               {"camera_hits", s.cameraHits},
               {"indirect_hits", s.indirectHits},
               {"per_sample", ratio(double(rays), double(s.samples))},
               {"per_second", ratio(double(rays), s.renderSeconds)},
               {"nanoseconds_per_ray", ratio(double(loop), double(rays))}};
  Json stages = Json::object();
  for (size_t i = 0; i < size_t(StageTime::Count); ++i) {
    const double time = double(s.stageNanoseconds[i]);
    Json& stage = stages[render::nameOf(StageTime(i))];
    stage = {{"seconds", time * 1e-9},
             {"share", ratio(time, double(loop))},
             {"nanoseconds_per_ray", ratio(time, double(rays))}};
    if (const uint64_t own = raysOf(s, StageTime(i))) stage["nanoseconds_per_own_ray"] = time / double(own);
  }
  j["stages"] = stages;
  j["media"] = {{"rays", s.mediaRays}, {"lookups", s.mediaLookups}};
  j["lane_use"] = {{"first_hit", asJson(s.lanesAt[0])},
                   {"deeper", asJson(deeperLanes(s))},
                   {"queries", asJson(s.lanesQueries)},
                   {"walks", asJson(s.lanesWalks)}};
  j["walks"] = {{"begun", s.walksBegun}, {"found", s.walksFound}, {"trials", s.walkTrials}};
  Json depths = Json::array();
  for (const LaneUse& l : s.lanesAt) {
    if (!l.possible) break;
    depths.push_back({{"share", share(l)}, {"points_per_group", pointsPerGroup(l)}, {"groups", l.groups}});
  }
  j["lane_use"]["by_depth"] = depths;
  j["shading"] = {{"points", s.shadingPoints},
                  {"groups", s.shadingGroups},
                  {"points_per_group", ratio(double(s.shadingPoints), double(s.shadingGroups))},
                  {"ray_groups", s.groups}};
  if (const render::ShaderCost all = costOfShaders(s); !s.shaders.empty()) {
    Json list = Json::array();
    for (const render::ShaderCost& c : slowestShaders(s, 10)) list.push_back(asJson(c));
    j["shaders"] = asJson(all);
    j["shaders"].erase("name");
    j["shaders"]["files_compiled"] = s.shadersCompiled;
    j["shaders"]["compile_seconds"] = s.shaderCompileSeconds;
    j["shaders"]["programs"] = s.shaderPrograms;
    j["shaders"]["slowest"] = list;
  }
  j["film"] = {{"samples", s.samples},
               {"pixels_done_early", s.donePixels},
               {"non_finite", s.nonFiniteSamples},
               {"saturated", s.saturatedSamples},
               {"negative", s.negativeSamples}};
  if (s.noise >= 0) j["film"]["relative_error"] = s.noise;
  j["textures"] = {{"lookups", s.textureLookups},
                   {"misses", s.textureMisses},
                   {"bytes", s.textureBytes},
                   {"tiles_read_again", s.textureTilesAgain},
                   {"bytes_read", s.textureBytesRead}};
  for (const auto& file : s.largestTextures)
    j["textures"]["largest"].push_back(
        {{"file", file.path}, {"bytes_read", file.bytesRead}, {"tiles_read_again", file.tilesAgain}});
  if (const auto& v = s.volumes; v.memoryBytes + v.fileBytes)
    j["volumes"] = {{"limit", v.limit},
                    {"bytes_in_memory", v.memoryBytes},
                    {"bytes_in_file", v.fileBytes},
                    {"most_bytes", v.mostBytes},
                    {"let_go", v.letGo}};
  Json slow = Json::array();
  for (const render::BucketTime& b : slowestBuckets(s, 5))
    slow.push_back({{"x", b.x}, {"y", b.y}, {"size", b.size}, {"seconds", double(b.nanoseconds) * 1e-9}});
  j["slowest_buckets"] = slow;
  if (!s.relativeError.values.empty()) {
    Json worst = Json::array();
    for (const WorstPixel& p : worstPixels(s, 10))
      worst.push_back({{"x", p.x}, {"y", p.y}, {"relative_error", p.error}});
    j["worst_pixels"] = worst;
  }
  return j.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

render::ShaderCost costOfShaders(const Statistics& s) {
  render::ShaderCost all;
  all.name = "all";
  for (const render::ShaderCost& c : s.shaders) {
    all.materials += c.materials;
    all.addCost(c);
  }
  return all;
}

std::vector<render::ShaderCost> slowestShaders(const Statistics& s, size_t most) { return slowest(s.shaders, most); }

std::vector<render::BucketTime> slowestBuckets(const Statistics& s, size_t most) { return slowest(s.buckets, most); }

std::vector<WorstPixel> worstPixels(const Statistics& s, size_t most) {
  const render::PixelMap& m = s.relativeError;
  std::vector<size_t> order(m.values.size());
  std::iota(order.begin(), order.end(), size_t(0));
  const size_t shown = std::min(most, order.size());
  std::partial_sort(order.begin(), order.begin() + std::ptrdiff_t(shown), order.end(), [&](size_t a, size_t b) {
    return m.values[a] != m.values[b] ? m.values[a] > m.values[b] : a < b;
  });
  std::vector<WorstPixel> list;
  for (size_t k = 0; k < shown; ++k)
    list.push_back(
        {m.x0 + int(order[k] % size_t(m.width)), m.y0 + int(order[k] / size_t(m.width)), m.values[order[k]]});
  return list;
}

std::string statsAsText(const Statistics& s, const StatsHeading& heading) {
  std::string out;
  const auto line = [&]<class... A>(fmt::format_string<A...> form, A&&... arguments) {
    fmt::format_to(std::back_inserter(out), form, std::forward<A>(arguments)...);
    out += '\n';
  };
  line("Kinora {}: {}, frame {}, {}", kVersion, heading.scene, heading.frame, heading.outcome);
  line("");
  line("Time");
  line("  load {:.2f} s, build {:.2f} s, render {:.2f} s", s.loadSeconds, s.buildSeconds, s.renderSeconds);
  if (s.firstPixelSeconds >= 0) line("  first pixels in the file after {:.2f} s", s.firstPixelSeconds);
  if (s.firstGroupSeconds >= 0) line("  first group of rays {:.2f} s after the program's start", s.firstGroupSeconds);
  const uint64_t rays = totalRays(s), loop = loopNanoseconds(s);
  line("");
  line("Stages (all threads together)         seconds   share   ns a ray   ns an own ray");
  for (size_t i = 0; i < size_t(StageTime::Count); ++i) {
    const double time = double(s.stageNanoseconds[i]);
    const uint64_t own = raysOf(s, StageTime(i));
    line("  {:<34}{:>9.3f}{:>7.1f}%{:>11.1f}{:>16}", render::nameOf(StageTime(i)), time * 1e-9,
         100 * ratio(time, double(loop)), ratio(time, double(rays)),
         own ? fmt::format("{:.1f}", time / double(own)) : "-");
  }
  line("  {:<34}{:>9.3f}{:>8}{:>11.1f}", "sum", double(loop) * 1e-9, "", ratio(double(loop), double(rays)));
  line("");
  line("Rays");
  line("  camera {}, indirect {}, shadow {}, light {}; {:.2f} a sample, {:.3g} a second", s.cameraRays,
       s.indirectRays, s.shadowRays, s.lightRays, ratio(double(rays), double(s.samples)),
       ratio(double(rays), s.renderSeconds));
  line("  hits: camera {}, indirect {}", s.cameraHits, s.indirectHits);
  if (s.mediaRays)
    line("  through media {}, each asking {:.1f} places what is there", s.mediaRays,
         ratio(double(s.mediaLookups), double(s.mediaRays)));
  line("");
  line("Lane use (active of possible lanes)");
  line("  first hit {:.3f}, deeper hits {:.3f}, presence and clear shadows {:.3f}", share(s.lanesAt[0]),
       share(deeperLanes(s)), share(s.lanesQueries));
  if (s.walksBegun)
    line("  manifold walks {:.3f}: {} begun, {} found a path, {} trials to count how likely", share(s.lanesWalks),
         s.walksBegun, s.walksFound, s.walkTrials);
  std::string depths;
  for (const LaneUse& l : s.lanesAt)
    if (l.possible)
      depths += fmt::format("{}{:.2f} ({:.0f})", depths.empty() ? "" : ", ", share(l), pointsPerGroup(l));
  line("  by depth (points a group): {}", depths);
  line("  {} shading groups of {:.1f} points on average, {} ray groups", s.shadingGroups,
       ratio(double(s.shadingPoints), double(s.shadingGroups)), s.groups);
  line("");
  if (!s.shaders.empty()) {
    const render::ShaderCost all = costOfShaders(s);
    line("Shaders (instructions and lanes of every 16th run)");
    line("  {} files compiled to {} programs in {:.4f} s; {} materials", s.shadersCompiled, s.shaderPrograms,
         s.shaderCompileSeconds, all.materials);
    line("  {:<50}{:>9}{:>11}{:>10}{:>9}{:>7}", "", "seconds", "points", "ns/point", "instr.", "lanes");
    const auto shader = [&](const render::ShaderCost& c) {
      line("  {:<50}{:>9.3f}{:>11}{:>10.1f}{:>9.0f}{:>7.3f}", c.name.substr(0, 49), double(c.nanoseconds) * 1e-9,
           c.points, ratio(double(c.nanoseconds), double(c.points)),
           ratio(double(c.instructions + c.uniformInstructions), double(c.countedRuns)), share(c.lanes));
    };
    for (const render::ShaderCost& c : slowestShaders(s, 10)) shader(c);
    shader(all);
    line("");
  }
  line("World");
  line("  {} primitives, {} instances, {} triangles, {} lights, {} materials of {} programs", s.primitives,
       s.instances, s.triangles, s.lights, s.materials, s.programs);
  line("  {} hierarchy builds, {} parts built", s.bvhBuilds, s.bvhPartsBuilt);
  if (s.procedurals)
    line("  {} procedurals: {} read in {:.2f} s, {} that no ray has met; {} worlds made for them in {:.2f} s",
         s.procedurals, s.proceduralsRead, s.proceduralReadSeconds, s.procedurals - s.proceduralsRead,
         s.proceduralWorlds, s.proceduralBuildSeconds);
  if (s.proceduralsRead)
    line("  they hold {}, {} at most{}, the largest {}; {} dropped, {} times one was read again",
         asBinaryBytes(s.proceduralBytes), asBinaryBytes(s.proceduralMostBytes),
         s.proceduralBudget ? " of " + asBinaryBytes(s.proceduralBudget) : std::string(),
         asBinaryBytes(s.proceduralLargest), s.proceduralsDropped, s.proceduralsAgain);
  if (s.micropolygons)
    line("  {} displaced micropolygons, shaded and moved in {:.2f} s (objects made at a time count each)",
         s.micropolygons, s.displaceSeconds);
  if (s.geometry.made) {
    const render::GeometryStatistics& g = s.geometry;
    uint64_t all = 0, fine = 0;
    for (size_t level = 0; level < g.micropolygons.size(); ++level)
      for (const uint64_t n : g.micropolygons[level]) {
        all += n;
        fine += level == 0 ? n : 0;
      }
    line(
        "  {} micropolygons diced where rays asked, {} of them at the camera's rate, in {:.2f} s of all threads; all "
        "patches at that rate have {}",
        all, fine, g.seconds, g.whole);
    line("  {} tessellations made, {} of them once more and {} by two threads at once, {} evicted; {} held of {}",
         g.made, g.again, g.twice, g.evicted, asBytes(g.bytes), asBytes(g.limit));
  }
  line("");
  line("Memory");
  for (const auto& owner : largestFirst(s)) line("  {:<34}{:>10}", owner.name, asBytes(owner.bytes));
  if (heading.residentPeakBytes) line("  {:<34}{:>10}", "process, at its peak", asBytes(heading.residentPeakBytes));
  line("");
  line("Textures");
  line("  {} lookups, {} misses, {} held, {} read, {} tiles of it again", s.textureLookups, s.textureMisses,
       asBytes(s.textureBytes), asBytes(s.textureBytesRead), s.textureTilesAgain);
  for (const auto& file : s.largestTextures)
    line("  {} read of {}, {} tiles of it again", asBytes(file.bytesRead), file.path, file.tilesAgain);
  if (const auto& v = s.volumes; v.memoryBytes + v.fileBytes) {
    line("");
    line("Volumes");
    line("  {} of grids in memory, {} in a file; {} in memory at most{}, {} pieces let go", asBytes(v.memoryBytes),
         asBytes(v.fileBytes), asBytes(v.mostBytes), v.limit ? " of " + asBytes(v.limit) : "", v.letGo);
  }
  line("");
  line("Film");
  line("  {} samples; {} not finite (dropped), {} saturated, {} negative", s.samples, s.nonFiniteSamples,
       s.saturatedSamples, s.negativeSamples);
  if (s.donePixels)
    line("  {} pixels were good enough before they had all samples (adaptive sampling)", s.donePixels);
  if (s.noise >= 0) line("  relative error of the picture, by two halves of its samples: {:.4g}", s.noise);
  return out;
}

bool writeStats(const std::string& file, const Statistics& statistics, const StatsHeading& heading,
                Diagnostics& diagnostics) {
  const std::string text = file.ends_with(".json")   ? statsAsJson(statistics, heading)
                           : file.ends_with(".html") ? statsAsHtml(statistics, heading)
                                                     : statsAsText(statistics, heading);
  image::AtomicFile target(file);
  bool isWritten = false;
  {
    std::ofstream stream(target.path(), std::ios::binary);
    stream << text << std::flush;
    isWritten = stream.good();
  }
  const image::Status status =
      isWritten ? target.commit() : image::Status::fail("APP-WRITE", "statistics '" + file + "' cannot be written");
  if (!status.ok()) diagnostics.error(status.code, {}, status.what, "the picture is not affected");
  return status.ok();
}

uint64_t residentPeakBytes() {
  rusage usage{};
  return getrusage(RUSAGE_SELF, &usage) == 0 ? uint64_t(usage.ru_maxrss) * 1024 : 0;
}

}  // namespace kinora::app
