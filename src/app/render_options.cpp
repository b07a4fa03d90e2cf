#include "app/render_options.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "app/command_line.h"
#include "app/plugin_path.h"
#include "base/quantity.h"
#include "base/text.h"

namespace kinora::app {

namespace {

std::string extensionOf(const std::string& file) {
  const size_t dot = file.find_last_of("./");
  if (dot == std::string::npos || file[dot] == '/') return {};
  return lowerCase(file.substr(dot));
}

bool isOneOf(const std::string& text, std::initializer_list<const char*> list) {
  return std::any_of(list.begin(), list.end(), [&](const char* item) { return text == item; });
}

// Values as text where their form is Kinora's own ("640x360"); CLI11 checks plain numbers.
struct Texts {
  std::string resolution, samples, onlySample, progress = "auto", frames, memoryLimit, textureCache, geometryCache,
                                               volumeCache, maxTime, snapshot, checkpoint;
  std::vector<std::string> sets, searchPaths, dirmaps;
  std::vector<float> crop;
};

std::optional<std::string> readTexts(const Texts& texts, RenderOptions& out) {
  render::Settings& s = out.settings;
  std::vector<int> numbers;
  if (!texts.resolution.empty()) {
    if (!splitInts(texts.resolution, 'x', numbers) || numbers.size() != 2 || numbers[0] < 1 || numbers[1] < 1)
      return "--res '" + texts.resolution + "' is not WIDTHxHEIGHT";
    if (numbers[0] > render::kMostSide || numbers[1] > render::kMostSide ||
        int64_t(numbers[0]) * numbers[1] > render::kMostPixels)
      return "--res '" + texts.resolution + "' is too large: at most 65536 on a side and 2^31 pixels in all";
    s.resolution = {numbers[0], numbers[1]};
  }
  if (!texts.crop.empty()) {
    std::array<float, 4> crop;
    if (auto wrong = readCrop(texts.crop, crop)) return wrong;
    s.crop = crop;
  }
  if (s.samplesPerPixel > 0 && (s.pixelVariance > 0 || s.pictureError > 0 || s.leastSamples > 0 || s.mostSamples > 0))
    return "--spp gives every pixel the same samples; --min-spp, --max-spp, --pixel-variance and --error leave that "
           "to "
           "the picture's noise";
  if (std::isnan(s.pixelVariance)) return std::string("--pixel-variance is no number");
  if (std::isnan(s.pictureError)) return std::string("--error is no number");
  if (s.pixelVariance > 0 && s.pictureError > 0)
    return std::string(
        "--pixel-variance is a bound for each pixel, --error one for the whole picture: give one of them");
  if (!texts.samples.empty() && s.pictureError > 0)
    return std::string("--samples renders all of its samples in every pixel, --error chooses them");
  if (s.mostSamples > 0 && s.leastSamples > s.mostSamples) return "--min-spp is above --max-spp";
  if (!texts.samples.empty() && s.pixelVariance > 0)
    return "--samples renders all of its samples in every pixel: parts by --crop keep --pixel-variance";
  if (!texts.samples.empty()) {
    if (!splitInts(texts.samples, ':', numbers) || numbers.size() != 2 || numbers[0] < 0 || numbers[1] <= numbers[0])
      return "--samples '" + texts.samples + "' is not A:B with 0 <= A < B";
    s.firstSample = numbers[0];
    s.lastSample = numbers[1];
  }
  if (!texts.onlySample.empty()) {
    if (!splitInts(texts.onlySample, ',', numbers) || numbers.size() != 3 || numbers[0] < 0 || numbers[1] < 0 ||
        numbers[2] < 0)
      return "--only-sample '" + texts.onlySample + "' is not X,Y,SAMPLE";
    out.onlySample = {numbers[0], numbers[1], numbers[2]};
  }
  for (const std::string& set : texts.sets) {
    const size_t equals = set.find('='), dot = set.find('.');
    if (equals == std::string::npos || dot == std::string::npos || dot == 0 || dot + 1 >= equals)
      return "--set '" + set + "' is not KIND.NAME=VALUE";
    s.sets.emplace_back(set.substr(0, equals), set.substr(equals + 1));
  }
  for (const std::string& path : texts.searchPaths) {
    const size_t equals = path.find('=');
    const std::string kind = path.substr(0, equals);
    if (equals == std::string::npos ||
        !isOneOf(kind, {"texture", "archive", "plugin", "rixplugin", "display", "procedural", "shader", "resource"}))
      return "--search-path '" + path +
             "' is not KIND=DIRS with texture, archive, plugin, shader, display, procedural or resource as KIND";
    std::vector<std::string> directories = splitPath(path.substr(equals + 1));
    if (directories.empty()) return "--search-path '" + path + "' names no folder";
    for (std::string& directory : directories)
      (kind == "texture" || kind == "resource"     ? s.texturePath
       : kind == "archive" || kind == "procedural" ? out.archivePath
       : kind == "shader"                          ? s.shaderPath
                                                   : out.pluginPath)
          .push_back(std::move(directory));
  }
  for (const std::string& map : texts.dirmaps)
    if (!parseDirmap(map, out.dirmap)) return "--dirmap '" + map + "' is not FROM=TO";
  if (!texts.frames.empty()) {
    const auto frames = FrameList::parse(texts.frames);
    if (!frames) return "--frames '" + texts.frames + "' is neither A-B nor A,B,C with A <= B";
    out.frames = *frames;
  }
  for (const auto& [option, text, to] : {std::tuple{"--memory-limit", &texts.memoryLimit, &out.memoryLimit},
                                         std::tuple{"--texture-cache", &texts.textureCache, &s.textureCacheBytes},
                                         std::tuple{"--geometry-cache", &texts.geometryCache, &s.geometryCacheBytes},
                                         std::tuple{"--volume-cache", &texts.volumeCache, &s.volumeCacheBytes}})
    if (!text->empty() && (*to = parseSize(*text)) == 0)
      return std::string(option) + " '" + *text + "' is no size: 4G, 512M";
  for (const auto& [option, text, to] : {std::tuple{"--max-time", &texts.maxTime, &out.maxSeconds},
                                         std::tuple{"--snapshot", &texts.snapshot, &s.snapshotSeconds}}) {
    if (text->empty()) continue;
    const auto seconds = parseTime(*text);
    if (!seconds) return std::string(option) + " '" + *text + "' is no time: 90s, 5m, 2h";
    *to = *seconds;
  }
  if (!texts.checkpoint.empty()) {
    const size_t comma = texts.checkpoint.find(',');
    const auto every = render::parseCheckpointTime(texts.checkpoint.substr(0, comma));
    const auto exitAt = comma == std::string::npos ? render::CheckpointTime()
                                                   : render::parseCheckpointTime(texts.checkpoint.substr(comma + 1));
    if (!every || !every->isSet() || !exitAt || (comma != std::string::npos && !exitAt->isSet()))
      return "--checkpoint '" + texts.checkpoint + "' is not INTERVAL[,EXITAT]: 30s, 5m, 1h, or passes as 16i";
    s.checkpoint.every = *every;
    s.checkpoint.exitAt = *exitAt;
  }
  static const std::map<std::string, ProgressMode> kModes{{"auto", ProgressMode::Auto},
                                                          {"bar", ProgressMode::Bar},
                                                          {"lines", ProgressMode::Lines},
                                                          {"json", ProgressMode::Json},
                                                          {"none", ProgressMode::None}};
  const auto mode = kModes.find(texts.progress);
  if (mode == kModes.end()) return "--progress '" + texts.progress + "' is not auto, bar, lines, json or none";
  out.progress = mode->second;
  if (!out.statsFile.empty() && !isOneOf(extensionOf(out.statsFile), {".json", ".txt", ".html"}))
    return "--stats '" + out.statsFile + "' ends in none of .json .html .txt";
  if (!s.output.empty()) {
    const std::string extension = extensionOf(s.output);
    if (s.firstSample >= 0 && extension != ".exr")
      return "--samples writes an EXR of sums: the name '" + s.output + "' must end in .exr";
    if (!isOneOf(extension, {".exr", ".png", ".tif", ".tiff", ".jpg", ".jpeg"}))
      return "-o '" + s.output + "' ends in none of .exr .png .tif .jpg";
  }
  if (out.onlySample && s.firstSample >= 0) return std::string("--only-sample and --samples exclude each other");
  if (out.onlySample && out.check) return std::string("--only-sample and --check exclude each other");
  if (std::count(out.files.begin(), out.files.end(), "-") > 1)
    return std::string("standard input (-) can be read only once");
  return std::nullopt;
}

}  // namespace

std::optional<int> parseRenderOptions(const std::vector<std::string>& arguments, RenderOptions& out,
                                      Diagnostics& diagnostics) {
  const auto parser = makeParser("render", "Renders RIB files, read in order as one stream.");
  CLI::App& app = *parser;
  render::Settings& s = out.settings;
  Texts texts;

  // not required(): the parser would name a missing file before an unknown option
  app.add_option("FILE", out.files, "RIB files; - is standard input");
  app.add_option("-o,--output", s.output, "write the primary display here; .exr .png .tif .jpg")->type_name("FILE");
  app.add_option("-t,--threads", s.threads, "worker threads; 0: all, -N: all but N")
      ->type_name("N")
      ->check(CLI::Range(-4096, 4096));
  app.add_option("--spp", s.samplesPerPixel, "samples a pixel; overrides the scene's")
      ->type_name("N")
      ->check(CLI::Range(1, 1 << 16));
  app.add_option(
         "--pixel-variance", s.pixelVariance,
         "adaptive sampling: pixels are done at this relative deviation, say .02; 0: off; overrides the scene's")
      ->type_name("V")
      ->check(CLI::Range(0.f, 1e6f));
  app.add_option(
         "--error", s.pictureError,
         "adaptive sampling: the picture is done at this relative error, say .01; samples go where they help most")
      ->type_name("E")
      ->check(CLI::Range(0.f, 1e6f));
  app.add_option("--min-spp", s.leastSamples, "adaptive sampling: at least so many samples a pixel")
      ->type_name("N")
      ->check(CLI::Range(1, 1 << 16));
  app.add_option("--max-spp", s.mostSamples, "at most so many samples a pixel; overrides the scene's")
      ->type_name("N")
      ->check(CLI::Range(1, 1 << 16));
  app.add_option("--res", texts.resolution, "resolution; overrides the scene's Format")->type_name("WxH");
  addCrop(app, texts.crop, "part of the picture in 0..1, as CropWindow");
  app.add_option("--integrator", s.integrator, "integrator plug-in; overrides the scene's")->type_name("NAME");
  takeOneAtATime(
      app.add_option("--set", texts.sets, "override a parameter or option: integrator.maxIndirectBounces=4")
          ->type_name("KIND.NAME=VALUE"));
  app.add_option("--seed", s.seed, "the frame's seed")->type_name("N");
  app.add_option("--samples", texts.samples, "render only samples A..B-1 of each pixel into an EXR for `merge`")
      ->type_name("A:B");
  app.add_option("--only-sample", texts.onlySample, "replay one sample and print the events of its path")
      ->type_name("X,Y,S");
  app.add_option("--progress", texts.progress, "auto, bar, lines, json (on standard output) or none")
      ->type_name("MODE");
  app.add_option("--stats", out.statsFile, "write where time and memory went; .json, .html or .txt")
      ->type_name("FILE");
  app.add_flag(
      "--allow-exec", out.allowExec,
      "let the scene run programs and shared objects (Procedural and Procedural2 \"RunProgram\", \"DynamicLoad\")");
  app.add_flag("--read-procedurals", s.readsAllProcedurals,
               "read delayed archives before the first sample; changes no pixel");
  takeOneAtATime(app.add_option("--plugin-path", out.pluginPath, "look for plug-ins here first; may be repeated")
                     ->type_name("DIR"));
  takeOneAtATime(app.add_option("--search-path", texts.searchPaths,
                                "look for files of KIND here too: texture, archive, plugin, shader ...")
                     ->type_name("KIND=DIRS"));
  takeOneAtATime(
      app.add_option("--dirmap", texts.dirmaps, "replace the start of paths that the scene names; may be repeated")
          ->type_name("FROM=TO"));
  app.add_option("--frames", texts.frames, "render only these frames; #### in names is the frame's number")
      ->type_name("A-B|A,B,C");
  app.add_option("--memory-limit", texts.memoryLimit, "refuse to hold more than this: 4G, 512M (exit code 5)")
      ->type_name("SIZE");
  app.add_option("--texture-cache", texts.textureCache, "memory for texture tiles; less costs time only")
      ->type_name("SIZE");
  app.add_option("--texture-folder", s.textureFolder,
                 "keep textures that have no mip levels here, made once with them; may be emptied at any time")
      ->type_name("DIR");
  app.add_option("--geometry-cache", texts.geometryCache,
                 "memory for surfaces that are diced where rays ask; less costs time only")
      ->type_name("SIZE");
  app.add_option("--volume-cache", texts.volumeCache,
                 "memory for grids of volume files, the rest of which lies in a file; less costs time only")
      ->type_name("SIZE");
  app.add_option("--max-time", texts.maxTime, "stop as SIGTERM would after this time: 90s, 5m, 2h")->type_name("T");
  app.add_option("--snapshot", texts.snapshot, "write the picture so far every T (default 60s; 0: never)")
      ->type_name("T");
  app.add_option(
         "--checkpoint", texts.checkpoint,
         "keep what --recover needs beside the picture, so often (30s, 5m, 1h, 16i: passes) and when the render "
         "is stopped; stop at EXITAT")
      ->type_name("INTERVAL[,EXITAT]");
  app.add_flag("--recover", s.checkpoint.recovers,
               "go on from the checkpoint beside the picture, where there is one; the same bits");
  app.add_option("--width", s.width, "SIMD width: 1, 4, 8, 16; changes no pixel")
      ->type_name("N")
      ->check(CLI::IsMember({1, 4, 8, 16}));
  app.add_option("--group-size", s.groupSize, "rays a group; changes no pixel")
      ->type_name("N")
      ->check(CLI::Range(1, 1 << 16));
  app.add_option("--bucket-order", s.bucketOrder, "order of buckets; changes no pixel")
      ->type_name("NAME")
      ->check(CLI::IsMember(
          {"horizontal", "vertical", "zigzag-x", "zigzag-y", "spiral", "circle", "spacefill", "random"}));
  app.add_flag("--strict", s.strict, "a missing asset or unknown plug-in is an error (exit code 4)");
  app.add_flag("--check", out.check, "read, load and resolve everything; render nothing");
  app.add_flag("-q", out.quiet, "quieter: no progress; twice: no warnings");
  app.add_flag("-v", out.verbose, "more: what the scene holds and where time went");

  if (const auto done = parse(app, arguments, diagnostics)) return done;
  if (out.files.empty()) return badCommandLine(diagnostics, "no scene is named", "see `kinora render --help`");
  if (const auto wrong = readTexts(texts, out))
    return badCommandLine(diagnostics, *wrong, "see `kinora render --help`");
  return std::nullopt;
}

}  // namespace kinora::app
