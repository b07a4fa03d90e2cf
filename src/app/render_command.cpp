// `kinora render`: reads the files as one stream and renders each world as it comes. Exit codes are decided here.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "app/command_line.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/plugin_path.h"
#include "app/render_options.h"
#include "app/signals.h"
#include "app/stats_report.h"
#include "base/memory.h"
#include "film/display_plan.h"
#include "image/atomic_file.h"
#include "image/picture_library.h"
#include "plugin/registry.h"
#include "render/renderer.h"
#include "render/sample_counts.h"
#include "rib/reader.h"
#include "volume/read_process.h"

namespace kinora::app {

namespace {

using render::Outcome;

int exitCodeOf(Outcome outcome) {
  switch (outcome) {
    case Outcome::Complete:
      return kComplete;
    case Outcome::Interrupted:
      return kInterrupted;
    case Outcome::BadScene:
      return kBadScene;
    case Outcome::OutOfMemory:
      return kOutOfMemory;
    case Outcome::CannotWrite:
      return kCannotWrite;
    case Outcome::Internal:
      return kInternal;
  }
  return kInternal;
}

const char* nameOf(int exitCode) {
  switch (exitCode) {
    case kComplete:
      return "complete";
    case kInterrupted:
      return "interrupted";
    case kOutOfMemory:
      return "out of memory";
    case kCannotWrite:
      return "cannot write";
    default:
      return "failed";
  }
}

// One run of the command. A world is rendered as soon as it is read. Where all frames would go to one name it waits
// until the next one or the end of the stream is met: only then is it known whether there are several. A frame of
// shadow maps waits too: it is rendered only where the stream has no picture.
class RenderRun {
 public:
  RenderRun(RenderOptions options, Diagnostics& diagnostics)
      : options_(std::move(options)), diagnostics_(diagnostics) {
    registry_.setPath(pluginDirectories(options_.pluginPath));
    options_.settings.stop = stopOnSignals();
    options_.settings.snapshotNow = snapshotOnSignal();
    if (options_.maxSeconds >= 0) stopAfter(options_.maxSeconds);
    options_.settings.volumeReader = volume::thisProgram();
    Memory::setLimit(options_.memoryLimit);
    options_.settings.errorMap = extensionIs(options_.statsFile, ".html");
    // textures and shaders may be named as seen from the scene's own folder
    for (const std::string& file : options_.files)
      if (const std::string folder = std::filesystem::path(file).parent_path().string(); !folder.empty()) {
        options_.settings.texturePath.push_back(folder);
        options_.settings.shaderPath.push_back(folder);
      }
  }

  int run() {
    try {
      return runAll();
    } catch (const MemoryExceeded& e) {
      diagnostics_.error("MEMORY-LIMIT", {}, e.what(), "stopped",
                         "raise --memory-limit, or simplify what is largest");
      return kOutOfMemory;
    }
  }

 private:
  static bool extensionIs(const std::string& file, const char* extension) {
    return std::filesystem::path(file).extension() == extension;
  }

  int runAll() {
    if (const int code = checkOutputs(); code != kComplete) return code;
    rib::ReadOptions reading;
    reading.archivePath = options_.archivePath;
    reading.dirmap = options_.dirmap;
    reading.stop = options_.settings.stop;
    reading.allowExec = options_.allowExec;
    std::error_code unknown;
    reading.proceduralHost =
        std::filesystem::read_symlink("/proc/self/exe", unknown).replace_filename("kinora-procedural");
    reading.delaysProcedurals = true;
    rib::RibReader reader(diagnostics_, std::move(reading), [&](scene::Scene&& scene) {
      take({std::move(scene), reader.procedurals()});
    });
    for (const std::string& file : options_.files) {
      if (isOver() || isStopped()) break;
      if (!reader.readFile(file)) return std::max<int>(code_, kBadScene);
    }
    if (isStopped() && isOver()) return code_;
    if (isStopped()) {
      // what was read so far is no whole scene
      diagnostics_.warning("APP-STOPPED", {}, "stopped while the scene was being read",
                           frames_ > 0 ? "the frames before are written" : "nothing is rendered");
      return kInterrupted;
    }
    const size_t closedWorlds = reader.worlds();
    reader.finish();
    if (shadowPass_ && frames_ == 0 && !waiting_) std::swap(waiting_, shadowPass_);
    if (!isOver() && waiting_) renderWaiting();
    // a file cut short gives the picture of what was there, but never the code of a complete one
    const bool isCutShort = diagnostics_.count("RIB-TRUNCATED") > 0 || reader.worlds() > closedWorlds;
    if (code_ == kComplete && (isCutShort || reader.worlds() == 0)) code_ = kBadScene;
    if (code_ == kComplete || code_ == kBadScene) reportMissingFrames(reader.worlds());
    return code_;
  }

  bool isStopped() const { return options_.settings.stop->load(); }
  // A scene that cannot be rendered does not end the stream: the next frame may be well.
  // Nor does one that the scene itself gives no more time.
  bool isOver() const {
    if (code_ == kInterrupted) return isStopped();
    return code_ != kComplete && code_ != kBadScene && code_ != kMissingAsset;
  }

  // Worlds outside FrameBegin are numbered in order.
  bool isWanted(scene::Scene& scene) {
    if (scene.frame == 0 && !scene.hasFrame) scene.frame = worlds_;
    ++worlds_;
    met_.insert(scene.frame);
    return options_.frames.holds(scene.frame);
  }

  void reportMissingFrames(size_t worlds) {
    const std::string missing = worlds > 0 ? options_.frames.missing(met_) : "";
    if (missing.empty()) return;
    diagnostics_.error("APP-FRAMES", {}, "--frames asks for frames that the scene does not have: " + missing,
                       frames_ > 0 ? "the others are written" : "nothing is rendered",
                       "the number is the one after FrameBegin; worlds outside frames count from 0");
    code_ = kBadScene;
  }

  struct World {
    scene::Scene scene;
    std::shared_ptr<const scene::ProceduralSources> procedurals;
  };

  void take(World&& world) {
    scene::Scene& scene = world.scene;
    if (isOver() || isStopped() || !isWanted(scene)) return;
    if (film::isShadowPass(scene)) {
      if (frames_ > 0 || waiting_ || shadowPass_) return leaveOut(scene);
      waitingHeld_.set(scene.bytes());
      shadowPass_ = std::move(world);
      return;
    }
    if (shadowPass_) {
      leaveOut(shadowPass_->scene);
      shadowPass_.reset();
      waitingHeld_.set(0);
    }
    const auto isOneName = [](const std::string& name) {
      return !name.empty() && name.find('#') == std::string::npos;
    };
    const bool mustWait =
        !options_.frames.isSingle() && (isOneName(options_.settings.output) || isOneName(options_.statsFile));
    if (waiting_) {
      for (const std::string& name : {options_.settings.output, options_.statsFile})
        if (!name.empty() && name.find('#') == std::string::npos) {
          code_ = badCommandLine(diagnostics_,
                                 "the scene has several frames, which would all be written to '" + name + "'",
                                 "put #### where the frame's number goes, as in 'name.####.exr'");
          return;
        }
      renderWaiting();
      if (isOver()) return;
    }
    waitingHeld_.set(scene.bytes());
    waiting_ = std::move(world);
    if (!mustWait) renderWaiting();
  }

  void leaveOut(const scene::Scene& pass) {
    diagnostics_.warning("APP-SHADOW-PASS", pass.displays[0].pos,
                         fmt::format("frame {} makes nothing but shadow maps", pass.frame),
                         "it is not rendered: shadows are traced",
                         "--frames with its number alone, or a display driver like \"openexr\", renders it");
  }

  // Before an hour of rendering: can the files named on the command line be made at all?
  int checkOutputs() {
    for (const std::string& name : {options_.settings.output, options_.statsFile}) {
      if (name.empty()) continue;
      if (isOverInput(diagnostics_, name, options_.files)) return kBadCommandLine;
      std::error_code ignored;
      image::Status status;
      if (const auto kind = std::filesystem::status(name, ignored); exists(kind) && !is_regular_file(kind))
        status = image::Status::fail("APP-WRITE", "'" + name + "' is not a regular file");
      else
        status = image::AtomicFile(film::fillFrame(name, 0)).probe();
      if (!status.ok()) {
        diagnostics_.error(status.code, {}, status.what, "nothing was rendered",
                           "name a file in a folder that exists");
        return kCannotWrite;
      }
    }
    return kComplete;
  }

  void renderWaiting() {
    World world = std::move(*waiting_);
    waiting_.reset();
    waitingHeld_.set(0);
    ++frames_;
    const int frame = world.scene.frame;
    std::vector<World> views = viewsOf(std::move(world));
    for (size_t i = 0; i < views.size() && !isOver() && !isStopped(); ++i) {
      const int code = renderFrame(std::move(views[i]), frame, i == 0);
      if (code != kComplete) code_ = code;
    }
  }

  // A frame whose displays name several of its cameras is rendered for each of them, with the displays that are its
  // own; first for that of the primary display.
  std::vector<World> viewsOf(World world) {
    scene::Scene& scene = world.scene;
    const auto cameraOf = [&](const scene::Display& d) -> size_t {
      const std::string name = d.params.getString("camera", "");
      if (name.empty()) return 0;
      for (size_t i = 0; i < scene.cameras.size(); ++i)
        if (scene.cameras[i].name == name) return i;
      diagnostics_.warning("DISPLAY-CAMERA", d.pos, "no camera is called '" + name + "'",
                           "the display shows what the frame's camera sees", "a Camera request gives the name");
      return 0;
    };
    std::vector<size_t> cameras, seen;
    for (const scene::Display& d : scene.displays) {
      cameras.push_back(cameraOf(d));
      if (std::find(seen.begin(), seen.end(), cameras.back()) == seen.end()) seen.push_back(cameras.back());
    }
    std::vector<World> views;
    if (seen.empty() || (seen.size() == 1 && seen[0] == 0)) {
      views.push_back(std::move(world));
      return views;
    }
    if (seen.size() > 1 && (options_.onlySample || (isPart() && !options_.settings.output.empty()))) {
      diagnostics_.warning("DISPLAY-CAMERA", scene.displays[0].pos, "the frame's displays show several cameras",
                           "only that of the first display is rendered",
                           "without -o each camera's part goes beside its picture");
      seen.resize(1);
    }
    const std::vector<scene::Display> displays = std::exchange(scene.displays, {});
    for (size_t i = 0; i < seen.size(); ++i) {
      const size_t camera = seen[i];
      World view = i + 1 < seen.size() ? world : std::move(world);
      scene::Scene& s = view.scene;
      std::rotate(s.cameras.begin(), s.cameras.begin() + long(camera), s.cameras.begin() + long(camera) + 1);
      s.coordinateSystems["camera"] = s.cameras[0].worldToCamera.inverse();
      for (size_t d = 0; d < cameras.size(); ++d)
        if (cameras[d] == camera) s.displays.push_back(displays[d]);
      views.push_back(std::move(view));
    }
    return views;
  }

  // A world with no object and no light at all, and no request among those that are kept that might have made some:
  // mostly an exporter that failed. The picture is written for who meant it.
  bool isEmpty(const scene::Scene& scene) const {
    const auto mightDraw = [](const scene::KeptRequest& k) { return k.request.starts_with("Procedural"); };
    return scene.primitives.empty() && scene.instances.empty() && scene.lights.empty() &&
           scene.classicLights.empty() && std::none_of(scene.kept.begin(), scene.kept.end(), mightDraw);
  }

  // `isFirst`: the view that holds the primary display, which the names on the command line are for.
  int renderFrame(World world, int frame, bool isFirst) {
    const scene::Scene& scene = world.scene;
    render::Settings settings = options_.settings;
    if (!isFirst) settings.output.clear();
    settings.readsAllProcedurals |= options_.check;  // all that is wrong is to be said
    settings.output = film::fillFrame(settings.output, frame);
    // written early: loading takes the scene
    std::vector<std::string> written =
        isPart() ? std::vector{partOf(scene, settings)} : picturesOf(scene, settings.output);
    if (!options_.check && !options_.onlySample)
      if (const int code = claim(written, frame); code != kComplete) return code;

    setCheckpoint(scene, written, settings);
    const bool holdsNothing = isEmpty(scene);
    if (holdsNothing)
      diagnostics_.error("RENDER-EMPTY", scene.pos, "the world holds nothing: no object and no light",
                         options_.check || options_.onlySample ? "" : "an empty picture is written",
                         "look at what wrote the scene, and at the messages about what was left out");
    render::Renderer renderer(registry_, diagnostics_, settings);
    const bool isLoaded = renderer.load(std::move(world.scene), std::move(world.procedurals));
    if (diagnostics_.count("CLI-SET") > 0) return kBadCommandLine;
    if (!image::pictureLibraryProblem().empty()) return kInternal;  // runProgram() says why
    if (settings.strict && diagnostics_.assetProblems() > 0) {
      diagnostics_.error("APP-STRICT", {}, "assets are missing or broken and --strict was given",
                         "nothing was rendered");
      return kMissingAsset;
    }
    if (!isLoaded) {
      if (settings.crop[0] >= 0 && diagnostics_.count("RENDER-CROP") > 0) return kBadCommandLine;
      if (isStopped()) return stoppedEarly();
      const bool isMemory = diagnostics_.count("RENDER-MEMORY") + diagnostics_.count("FILM-MEMORY") +
                                diagnostics_.count("MEMORY-LIMIT") >
                            0;
      return isMemory ? kOutOfMemory : kBadScene;
    }
    if (options_.verbose > 0 || options_.check) fmt::print("{}\n", renderer.summary());
    if (options_.check) return holdsNothing ? kBadScene : kComplete;
    if (options_.onlySample) return replay(renderer);

    const std::string label =
        frames_ > 1 || options_.files.size() > 1 || !options_.frames.isAll() ? fmt::format("frame {}", frame) : "";
    const Outcome outcome = renderWithProgress(renderer, label);
    int code = exitCodeOf(outcome);
    if (isPart() && (code == kComplete || code == kInterrupted)) {
      // an interrupted part says which samples it has; one without any is not written
      if (!renderer.writeShard(written[0])) {
        if (renderer.samplesDone() > 0) code = kCannotWrite;
        written.clear();
      }
    }
    if (settings.strict && code == kComplete && diagnostics_.assetProblems() > 0) code = kMissingAsset;
    if (holdsNothing && code == kComplete) code = kBadScene;
    report(renderer, frame, code, written, isFirst);
    return code;
  }

  // Beside the first picture, or part, of a view.
  static std::string checkpointOf(const std::vector<std::string>& written) {
    return (written.empty() ? std::string("kinora") : image::wholeName(written[0])) + ".checkpoint";
  }
  // What the scene runs after each needs leave.
  void setCheckpoint(const scene::Scene& scene, const std::vector<std::string>& written, render::Settings& settings) {
    render::Checkpointing& c = settings.checkpoint;
    c.file = checkpointOf(written);
    const std::string command = scene.options.getString("checkpoint:command", "");
    if (command.empty()) return;
    if (!options_.allowExec) {
      diagnostics_.warning("RENDER-CHECKPOINT-COMMAND", scene.pos,
                           "Option \"checkpoint\" \"command\" asks to run \"" + command + "\"", "it is not run",
                           "--allow-exec lets scenes run programs");
      return;
    }
    c.wasWritten = [this, command] {
      if (std::system(command.c_str()) != 0)
        diagnostics_.warning("RENDER-CHECKPOINT-COMMAND", {},
                             "Option \"checkpoint\" \"command\" failed: \"" + command + "\"", "the render goes on");
    };
  }

  int stoppedEarly() {
    diagnostics_.warning("APP-STOPPED", {}, "stopped while the scene was being built", "no picture is written");
    return kInterrupted;
  }

  bool isPart() const { return options_.settings.firstSample >= 0; }

  // Where a part of the scene's frame goes: -o, or a name of its own beside that of the picture, which is made of it.
  std::string partOf(const scene::Scene& scene, const render::Settings& settings) const {
    if (!settings.output.empty()) return settings.output;
    const std::vector<std::string> pictures = picturesOf(scene, {});
    const std::filesystem::path picture = pictures.empty() ? "kinora" : pictures[0];
    const auto [first, stride] = render::partIndicesOf(scene, settings);
    return (picture.parent_path() / fmt::format("{}.samples-{}-{}{}.exr", picture.stem().string(), first,
                                                settings.lastSample,
                                                stride > 1 ? fmt::format("-every-{}", stride) : ""))
        .string();
  }

  // Takes the names of the files that a frame is to be written to. Not a frame before it, and no scene, is written
  // over.
  int claim(const std::vector<std::string>& files, int frame) {
    std::set<std::string> own;  // two of one name in a frame are told when its displays are planned
    for (const std::string& file : files) {
      if (isOverInput(diagnostics_, file, options_.files)) return kBadCommandLine;
      const std::string name = image::wholeName(file);
      const auto [it, isNew] = taken_.try_emplace(name, frame);
      if (!isNew && !own.contains(name)) {
        diagnostics_.error(
            "APP-SAME-FILE", {},
            fmt::format("frame {} would be written to '{}', where frame {} is", frame, file, it->second),
            "it is not rendered",
            "put #### where the frame's number goes, as in 'name.####.exr', in the Display or with -o");
        return kBadScene;
      }
      own.insert(name);
      if (!isPart()) continue;
      if (const image::Status status = image::AtomicFile(file).probe(); !status.ok()) {
        diagnostics_.error(status.code, {}, status.what, "nothing was rendered", "name a folder that exists with -o");
        return kCannotWrite;
      }
    }
    return kComplete;
  }

  // The files that a render of the scene writes. Messages about displays are the renderer's to give.
  std::vector<std::string> picturesOf(const scene::Scene& scene, const std::string& output) const {
    Diagnostics silent([](const std::string&, Severity) {});
    const auto driver = [&](const std::string& name) { return registry_.find(Kind::Display, name, silent, {}); };
    std::vector<std::string> files;
    film::PlanOptions planning;
    planning.output = output;
    for (const film::Output& picture : film::planDisplays(scene, planning, driver, silent).outputs)
      files.push_back(picture.file);
    return files;
  }

  Outcome renderWithProgress(render::Renderer& renderer, const std::string& label) {
    const bool isJson = options_.progress == ProgressMode::Json;
    const ProgressMode mode =
        options_.quiet > 0 && options_.progress == ProgressMode::Auto ? ProgressMode::None : options_.progress;
    ProgressReporter reporter(mode, isJson ? stdout : stderr, label);
    const auto show = [&](const render::Progress& progress) { reporter(progress); };
    return isPart() ? renderer.renderFilm(show) : renderer.render(show);
  }

  int replay(render::Renderer& renderer) {
    const auto [x, y, sample] = *options_.onlySample;
    if (renderer.replay(x, y, sample, [](const std::string& line) { fmt::print("{}\n", line); })) return kComplete;
    if (isStopped()) {
      diagnostics_.warning("APP-STOPPED", {}, "stopped while the sample was followed", "nothing is printed of it");
      return kInterrupted;
    }
    return badCommandLine(diagnostics_, fmt::format("there is no sample {} at pixel {},{}", sample, x, y));
  }

  void report(const render::Renderer& renderer, int frame, int& code, const std::vector<std::string>& written,
              bool isFirst) {
    std::string files;
    for (const std::string& file : options_.files) files += (files.empty() ? "" : " ") + file;
    const StatsHeading heading{files, frame, nameOf(code), residentPeakBytes(),
                               isPart() || written.empty() ? "" : written[0]};
    if (isFirst && !options_.statsFile.empty() &&
        !writeStats(film::fillFrame(options_.statsFile, frame), renderer.statistics(), heading, diagnostics_) &&
        code == kComplete)
      code = kCannotWrite;
    if (options_.verbose > 0) fmt::print("{}", statsAsText(renderer.statistics(), heading));
    if (options_.quiet > 0 || (code != kComplete && code != kInterrupted)) return;
    std::error_code ignored;
    std::string note;
    if (code == kInterrupted) {
      note = isPart() ? fmt::format(" (interrupted: samples {}:{})", std::max(0, options_.settings.firstSample),
                                    renderer.samplesEnd())
                      : " (interrupted: fewer samples than asked for)";
      if (!written.empty() && std::filesystem::exists(checkpointOf(written), ignored))
        note += "; --recover goes on from its checkpoint";
    }
    for (const std::string& file : written)
      if (std::filesystem::is_regular_file(file, ignored))
        fmt::print(stderr, "kinora: wrote {}{}\n", std::filesystem::absolute(file, ignored).string(), note);
  }

  RenderOptions options_;
  Diagnostics& diagnostics_;
  mutable Registry registry_;         // finds plug-ins by opening them
  std::map<std::string, int> taken_;  // files that frames are written to, and which
  std::optional<World> waiting_, shadowPass_;
  MemoryHold waitingHeld_{MemoryUse::Description};
  int frames_ = 0, worlds_ = 0;  // rendered, met
  std::set<int> met_;
  int code_ = kComplete;
};

}  // namespace

int runRender(const Arguments& arguments) {
  Diagnostics diagnostics;
  RenderOptions options;
  if (const auto done = parseRenderOptions(arguments, options, diagnostics)) return *done;
  if (const std::string missing = missingDirectory(options.pluginPath); !missing.empty())
    return badCommandLine(diagnostics, "the plug-in folder '" + missing + "' does not exist",
                          "--plugin-path and --search-path plugin= name folders");
  diagnostics.setQuiet(options.quiet);
  if (options.verbose > 0) diagnostics.setShown(20);
  const int code = RenderRun(std::move(options), diagnostics).run();
  diagnostics.summary();
  return code;
}

}  // namespace kinora::app
