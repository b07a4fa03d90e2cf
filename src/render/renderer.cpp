#include "render/renderer.h"

#include <fmt/format.h>
#include <malloc.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <thread>
#include <utility>

#include "base/memory.h"
#include "film/display_output.h"
#include "film/shard.h"
#include "image/colors.h"
#include "plugin/refused.h"
#include "plugin/registry.h"
#include "render/cache_pressure.h"
#include "render/camera_attributes.h"
#include "render/check_scene.h"
#include "render/checkpoint.h"
#include "render/frame.h"
#include "render/frame_identity.h"
#include "render/frame_plan.h"
#include "render/frame_warnings.h"
#include "render/overrides.h"
#include "render/procedurals.h"
#include "render/record_budget.h"
#include "render/render_time.h"
#include "render/sample_counts.h"
#include "render/version.h"
#include "render/world_build.h"
#include "scene/digests.h"
#include "texture/texture_system.h"

namespace kinora::render {

namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

int threadCount(int wanted) {
  const int all = std::max(1, int(std::thread::hardware_concurrency()));
  return std::clamp(wanted > 0 ? wanted : all + wanted, 1, 256);
}

}  // namespace

struct Renderer::Impl {
  Registry& registry;
  Diagnostics& diagnostics;
  Settings settings;
  scene::Scene scene;
  Procedurals procedurals;  // of the scene
  WorldBuilder builder;
  Statistics stats;
  std::unique_ptr<FramePlan> plan;
  Digest ofPlan, ofIntegrator;  // of what they were made of
  FileContents::Names filesOfIntegrator;
  bool isReady = false;   // there is a world to render
  bool isEdited = false;  // the scene is that of the world before, edited
  bool saidAllIsHeld = false;
  std::unique_ptr<film::Film> film;
  std::unique_ptr<film::DisplayOutput> output;
  std::unique_ptr<Frame> frame;
  std::unique_ptr<RenderTime> renderTime;  // while rendering; null: as long as it takes
  Instance integrator;
  RecordBudget recordBudget;
  int threads = 1;
  SampleCounts counts;
  int samplesDone = 0;        // of each pixel that still takes some
  uint64_t samplesTaken = 0;  // of all pixels
  ActivePixels active;
  std::unique_ptr<NoiseEstimate> noise;  // null: every pixel takes the same samples
  Convergence convergence;
  uint64_t takenAtDecision = 0;  // of samplesTaken
  const Hider* hider = nullptr;
  uint64_t plans = 0;  // of what procedurals are held
  FrameIdentity identity;
  Clock::time_point loadedAt;
  MemoryHold sceneHeld{MemoryUse::Description}, filmHeld{MemoryUse::Film}, picturesHeld{MemoryUse::Pictures};
  Checkpointing checkpointing;
  Checkpoints checkpoints;  // of the running render; also what an interrupted part of a frame falls back to

  Impl(Registry& r, Diagnostics& d, Settings s)
      : registry(r), diagnostics(d), settings(std::move(s)), builder(r, d, settings) {
    threads = threadCount(settings.threads);
  }

  bool prepare() {
    if (const std::string& problem = image::Colors::ofEnvironment().problem(); !problem.empty())
      diagnostics.warning("ASSET-COLOR-CONFIG", {}, problem, "linear Rec.709 and sRGB are used, as without $OCIO",
                          "correct or unset OCIO");
    applyOverrides(scene, settings, registry, diagnostics);
    if (diagnostics.count("CLI-SET") > 0) return false;
    if (builder.openTextures(scene, stats)) {
      // filters and integrators may hold images of before
      plan.reset();
      integrator = {};
    }
    if (!builder.buildCamera(scene, stats)) return false;
    counts = sampleCountsOf(scene, settings, diagnostics);
    checkpointing = checkpointingOf(scene, settings.checkpoint, diagnostics);
    return makeIntegrator();
  }

  bool makeIntegrator() {
    const scene::Node* node = scene.integrator.get();
    const std::string name = node ? node->plugin : defaultIntegrator(scene);
    Hasher h;
    h.text(name);
    h.digest(scene::digestOf(scene.integrator));
    if (const Digest digest = h.result(); integrator.plugin() && digest == ofIntegrator) {
      builder.contents().again(filesOfIntegrator);
      return true;
    } else {
      ofIntegrator = digest;
    }
    filesOfIntegrator.clear();
    const FileContents::Listening listening(builder.contents(), filesOfIntegrator);
    ++stats.rebuilt.integrators;
    const Descriptor* d = registry.find(Kind::Integrator, name, diagnostics, node ? node->pos : SourcePos{});
    if (!d) {
      diagnostics.warning("PLUGIN-MISSING", node ? node->pos : scene.pos, "no integrator '" + name + "'",
                          "PxrPathTracer stands in", adviceOnMissing(Kind::Integrator, name));
      d = registry.find(Kind::Integrator, "PxrPathTracer", diagnostics, {});
      node = nullptr;
    }
    if (d && integrator.create(*d, node, nullptr, nullptr, builder.host(), diagnostics)) return true;
    d = registry.find(Kind::Integrator, "PxrPathTracer", diagnostics, {});
    return d && integrator.create(*d, nullptr, nullptr, nullptr, builder.host(), diagnostics);
  }

  bool hasLightStage() const {
    const auto* traits = static_cast<const IntegratorTraits*>(integrator.plugin()->traits);
    if (!traits || !traits->stages) return false;
    Stage list[16];
    const uint32_t n = std::min(traits->stages(integrator.data(), list, 16), 16u);
    return std::any_of(list, list + n, [](const Stage& s) { return s.kind == StageKind::LightPaths; });
  }

  bool tellsLobesApart() const {
    const auto* traits = static_cast<const IntegratorTraits*>(integrator.plugin()->traits);
    return traits && traits->tellsLobesApart && traits->tellsLobesApart(integrator.data());
  }

  static uint64_t bytesForNoise(const film::Window& window) {
    const size_t blocks = ActivePixels(window).blocks();
    return NoiseEstimate::bytesFor(blocks) + Convergence::bytesFor(blocks);
  }
  // The sums, and what writing the largest picture takes on top of them: floats and the encoded file.
  void chargeFilm(const film::Window& window) {
    filmHeld.set(0);
    picturesHeld.set(0);
    // an interrupted part of a frame, and a checkpoint, fall back to the sums of the last complete pass
    const uint64_t copies = settings.firstSample >= 0 || checkpointing.isOn() ? 2 : 1;
    const uint64_t noiseBytes = counts.adaptivity.isOn() ? bytesForNoise(window) : 0;
    filmHeld.set(copies * (film::Film::bytesNeeded(window, plan->displays.layout) + noiseBytes));
    uint64_t floats = 0;
    for (const film::Output& o : plan->displays.outputs) {
      uint64_t n = 0;
      for (const film::OutputChannel& k : o.channels) n += uint64_t(plan->displays.layout[k.channel].width);
      floats = std::max(floats, n);
    }
    picturesHeld.set(floats * window.pixels() * sizeof(float) * 3 / 2);
  }

  // Each half is an estimate of its own: their mean is the pixel, half their difference its error.
  PixelMap relativeError() const {
    PixelMap m;
    if (counts.stride % 2 == 0) return m;  // all samples are of one half
    if (plan->halves[0] < 0 || plan->halves[1] < 0 || samplesDone < 2) return m;
    const film::Window& w = film->window();
    m.x0 = w.x0, m.y0 = w.y0, m.width = w.width(), m.height = w.height();
    m.values.resize(size_t(w.pixels()));
    std::vector<float> level(m.values.size());
    double sum = 0;
    for (int y = w.y0; y < w.y1; ++y)
      for (int x = w.x0; x < w.x1; ++x) {
        float a[4] = {}, b[4] = {};
        film->resolvePixel(plan->halves[0], x, y, a);
        film->resolvePixel(plan->halves[1], x, y, b);
        const size_t i = size_t(y - w.y0) * size_t(m.width) + size_t(x - w.x0);
        for (int c = 0; c < 3; ++c) {
          m.values[i] += 0.5f * std::fabs(a[c] - b[c]) / 3;
          level[i] += 0.5f * std::fabs(a[c] + b[c]) / 3;
        }
        sum += level[i];
      }
    // dark pixels count against a part of the picture's mean, as eyes take them
    const float floor = float(0.05 * sum / double(std::max<size_t>(1, level.size()))) + 1e-9f;
    for (size_t i = 0; i < level.size(); ++i) m.values[i] /= level[i] + floor;
    return m;
  }

  bool makeFilm() {
    procedurals.begin(scene);
    builder.openShaders(procedurals.scene());
    // what has not been read may need it
    const bool lightStage = hasLightStage(),
               split = builder.needsSplit(scene) || tellsLobesApart() || !procedurals.empty();
    const Digest digest = framePlanDigestOf(scene, builder.camera(), lightStage, split);
    if (plan && digest == ofPlan) {
      builder.contents().again(plan->files);
    } else {
      plan = planFrame(scene, settings, lightStage, split, plan.get(), registry, builder, diagnostics);
      if (!plan) return false;
      ofPlan = digest;
      ++stats.rebuilt.plans;
    }
    const auto& c = builder.camera();
    const film::Window window{c.window[0], c.window[1], c.window[2], c.window[3]};
    film.reset();
    chargeFilm(window);
    film::Status made;
    film = film::Film::create(c.resolution[0], c.resolution[1], window, plan->displays.layout, made);
    if (!film) diagnostics.error("FILM-MEMORY", scene.pos, made.what, "nothing is rendered");
    return film != nullptr;
  }

  // The indices that every pixel has taken.
  std::vector<film::SampleRange> rangesDone() const {
    if (counts.stride == 1) return {{uint32_t(counts.first), uint32_t(counts.first + samplesDone)}};
    std::vector<film::SampleRange> ranges;
    for (int k = 0; k < samplesDone; ++k) {
      const uint32_t index = uint32_t(counts.first + k * counts.stride);
      ranges.push_back({index, index + 1});
    }
    return ranges;
  }

  // early: of a picture that should not wait for anything
  film::FrameMetadata metadata(double seconds, bool complete, bool early) {
    film::FrameMetadata m;
    describeCamera(builder.camera(), m);
    m.frame = scene.frame;
    m.seed = settings.seed;
    m.samples = rangesDone();
    m.samplesPerPixel = double(samplesTaken) / double(std::max<uint64_t>(1, film->window().pixels()));
    m.renderSeconds = seconds + checkpoints.recovered().seconds;
    m.kinoraVersion = kVersion;
    m.sceneHash = identity.hash(!early);
    m.pixelFilter = plan->filter.name();
    m.isComplete = complete;
    return m;
  }

  void makeFrame() {
    FrameInput in{};
    in.world = &builder;
    in.integrator = integrator.plugin();
    in.integratorData = integrator.data();
    in.paths = plan->paths.get();
    in.plan = &plan->record;
    in.filter = &plan->filter;
    in.sampleFilters = plan->sampleFilters.empty() ? nullptr : &plan->sampleFilters;
    in.ratios = plan->ratios;
    in.film = film.get();
    in.hider = hider;
    in.seed = settings.seed;
    in.firstSample = counts.first;
    in.lastSample = counts.last;
    if (noise) {
      in.active = &active;
      in.noise = noise.get();
      in.noiseOffset = colourOffset();
    }
    in.threads = threads;
    if (settings.groupSize) in.groupSize = settings.groupSize;
    in.bucketOrder =
        !settings.bucketOrder.empty() ? settings.bucketOrder : scene.options.getString("bucket:order", "horizontal");
    in.jitter = hasJitter(scene);
    in.stop = renderTime ? renderTime->stop() : settings.stop;
    builder.stopDicingBy(in.stop);
    in.rayListener = settings.rayListener;
    in.readMet = [this](std::vector<WaitingGroup*>& groups) { return readFor(groups); };
    in.statistics = &stats;
    frame = std::make_unique<Frame>(in);
    recordBudget = {};
  }

  // A world of the scene as it is now, from what still holds of the one before. When that fails nothing is kept.
  bool build() {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
    identity.wait();  // of the world before, which looks at the scene
    frame.reset();
    isReady = false;
    try {
      isReady = makeWorld();
    } catch (const MemoryExceeded& e) {
      diagnostics.error("MEMORY-LIMIT", scene.pos, e.what(), "nothing is rendered",
                        "raise --memory-limit, or simplify what is largest");
    } catch (const std::bad_alloc&) {
      diagnostics.error("RENDER-MEMORY", scene.pos, "not enough memory to build the scene", "nothing is rendered");
    }
    if (!isReady) forget();
    return isReady;
  }

  // Nothing that was made is used again.
  void forget() {
    isReady = false;
    frame.reset();
    film.reset();
    plan.reset();
    integrator = {};
    builder.forget();
  }

  bool makeWorld() {
    checkScene(scene, diagnostics);
    sceneHeld.set(scene.bytes());
    if (!prepare() || !makeFilm()) return false;
    if (!buildWorld()) return false;
    countProcedurals();
    identity.start(scene, builder.contents(), registry, isEdited);
    isEdited = true;
    // what is read from here on is no part of what the frame is known by: that must not follow from which rays there are
    if (procedurals.resume(builder.contents()) && !nextWorld()) return false;
    countProcedurals();
    if ((settings.readsAllProcedurals || asksObjectsUnseen()) && !readAllProcedurals()) return false;
    if (procedurals.delayed().unread.empty())  // else nobody knows what is in there
      warnOfChannels(*plan, builder, scene, diagnostics);
    // textures live with what is left: a smaller cache costs time only
    constexpr uint64_t kLeast = 16 << 20, kUsual = 1 << 30;
    if (Memory::limit() > 0)
      builder.textures().setCacheLimit(std::max(
          kLeast,
          std::min(settings.textureCacheBytes ? settings.textureCacheBytes : kUsual, Memory::left() / 4 * 3)));
    return true;
  }

  bool buildWorld() {
    const std::vector<SetAsker> askers = setAskersOf(*integrator.plugin(), scene.integrator.get());
    return builder.buildWorld(procedurals.scene(), procedurals.delayed(), plan->paths, askers,
                              aggregatesOf(*integrator.plugin(), scene.integrator.get()), stats);
  }

  // Whether what an object holds may count where no ray has met it: manifold walks aim at objects by a list.
  bool asksObjectsUnseen() const {
    const light::LightSet& lights = *builder.world().lights;
    for (uint32_t i = 0; i < lights.size(); ++i)
      if (lights.isWalkedTo(i)) return true;
    return false;
  }

  // Drops some procedurals, reads others, and makes a world of what is held then. Everything else of it is as it was.
  bool changeProcedurals(const std::vector<uint32_t>& drop, const std::vector<uint32_t>& read) {
    // The world that goes holds what is dropped. Where that is too much beside what is read, another one takes its place
    // before.
    uint64_t together = 0;
    for (uint32_t k = 0; k < procedurals.all().size(); ++k)
      if (procedurals.all()[k].isHeld) together += procedurals.all()[k].bytes;
    for (const uint32_t k : read) together += procedurals.all()[k].bytes;
    procedurals.drop(drop);
    if (!drop.empty() && together > proceduralBudget()) {
      if (!nextWorld()) return false;
      procedurals.countAsGone();
      malloc_trim(0);
    }
    const auto start = Clock::now();
    isReady = false;
    // those inside of others once these are there
    for (std::vector<uint32_t> left = read; !left.empty();) {
      std::vector<uint32_t> now, later;
      for (const uint32_t k : left) {
        const uint32_t inside = procedurals.all()[k].inside;
        (inside == HeldProcedural::kNone || procedurals.all()[inside].isHeld ? now : later).push_back(k);
      }
      if (now.empty()) break;
      procedurals.read(now, builder.contents(), diagnostics, settings.stop);
      if (settings.stop && settings.stop->load()) {
        isReady = true;  // of the world before, which is still there
        return false;
      }
      left = std::move(later);
    }
    stats.proceduralReadSeconds += since(start);
    if (!nextWorld()) return false;
    if (!drop.empty()) malloc_trim(0);  // what was dropped is the system's again: the budget is for its sake
    std::map<uint32_t, uint64_t> bytes;
    for (const Procedurals::Read& r : procedurals.lastRead()) bytes[r.instance];
    builder.findBytes(bytes);
    if (proceduralBudget()) {
      std::map<uint32_t, std::vector<Imath::Box3d>> cells;
      for (const Procedurals::Read& r : procedurals.lastRead())
        if (!procedurals.hasCells(r.number)) cells[r.instance];
      builder.findCells(cells);
      for (const Procedurals::Read& r : procedurals.lastRead())
        if (const auto it = cells.find(r.instance); it != cells.end())
          procedurals.setCells(r.number, std::move(it->second));
    }
    for (const Procedurals::Read& r : procedurals.lastRead()) procedurals.setBytes(r.number, bytes[r.instance]);
    warnOfBounds(procedurals, builder, diagnostics);
    procedurals.settle();
    countProcedurals();
    return true;
  }

  bool nextWorld() {
    const auto start = Clock::now();
    isReady = false;
    sceneHeld.set(scene.bytes() + procedurals.scene().bytes());
    builder.openShaders(procedurals.scene());
    std::vector<ShaderCost> before = std::move(stats.shaders);
    diagnostics.setRepeating(true);
    isReady = buildWorld();
    diagnostics.setRepeating(false);
    addCosts(before);
    stats.proceduralBuildSeconds += since(start);
    ++stats.proceduralWorlds;
    return isReady;
  }

  void countProcedurals() {
    const Procedurals::Counts& c = procedurals.counts();
    stats.procedurals = c.met;
    stats.proceduralsRead = c.read;
    stats.proceduralsAgain = c.again;
    stats.proceduralsDropped = c.dropped;
    stats.proceduralBytes = c.bytes;
    stats.proceduralMostBytes = c.mostBytes;
    stats.proceduralLargest = c.largest;
    stats.proceduralBudget = proceduralBudget();
  }

  // Bytes that procedurals may hold: as much as the geometry cache where somebody has said how much that is, and a half
  // of the limit on memory. 0: all of them.
  uint64_t proceduralBudget() const {
    uint64_t budget = geometryCacheSaid(scene, settings);
    if (const uint64_t half = Memory::limit() / 2) budget = budget ? std::min(budget, half) : half;
    return budget;
  }

  // Lets groups of rays go on that have met what is not held.
  bool readFor(std::vector<WaitingGroup*>& groups) {
    for (WaitingGroup* g : groups) {
      for (const uint32_t bound : g->met)
        for (uint32_t k = procedurals.numberOfUnread(builder.placeOfUnread(bound)); k != HeldProcedural::kNone;
             k = procedurals.all()[k].inside)
          g->needs.push_back(k);
      g->met.clear();
      std::sort(g->needs.begin(), g->needs.end());
      g->needs.erase(std::unique(g->needs.begin(), g->needs.end()), g->needs.end());
    }
    uint64_t budget = proceduralBudget();
    // Records between stages name the objects and triangles of their vertices by places in the world, which are others
    // once something was dropped, and camera paths shade those vertices again.
    if (!budget || frame->store()) budget = std::numeric_limits<uint64_t>::max();
    std::vector<uint32_t> needed;
    for (const WaitingGroup* g : groups) needed.insert(needed.end(), g->needs.begin(), g->needs.end());
    std::sort(needed.begin(), needed.end());
    needed.erase(std::unique(needed.begin(), needed.end()), needed.end());
    if (proceduralBudget()) procedurals.expectSizes(needed);
    const ReadingPlan p = planReading(groups, procedurals.all(), budget);
    ++plans;
    for (const WaitingGroup* g : groups)
      if (g->turn == WaitingGroup::Turn::Now)
        for (const uint32_t k : g->needs) procedurals.setNeeded(k, plans);
    if (p.needed > budget)
      diagnostics.warning(
          "RENDER-PROCEDURAL-BUDGET", scene.pos,
          fmt::format("paths that are followed together meet procedurals of {}, more than the {} that those may hold",
                      asBinaryBytes(p.needed), asBinaryBytes(budget)),
          "they are held together", "a larger --geometry-cache, or archives with less in each");
    if (p.read.empty() && p.drop.empty()) return true;
    if (!changeProcedurals(p.drop, p.read)) return false;
    if (frame->store() && proceduralBudget() && stats.proceduralBytes > proceduralBudget() &&
        !std::exchange(saidAllIsHeld, true))
      diagnostics.warning("RENDER-PROCEDURAL-BUDGET", scene.pos,
                          fmt::format("procedurals hold more than the {} that they may, and the records of light "
                                      "paths name what is in them",
                                      asBinaryBytes(proceduralBudget())),
                          "nothing that was read is dropped", "PxrPathTracer keeps no such records");
    return true;
  }

  bool readAllProcedurals() {
    while (!procedurals.delayed().unread.empty()) {
      std::vector<uint32_t> all;
      for (uint32_t i = 0; i < procedurals.delayed().unread.size(); ++i) all.push_back(procedurals.numberOfUnread(i));
      if (!changeProcedurals({}, all)) return false;
    }
    return true;
  }

  // What programs of the world before have cost goes on to those of their names.
  void addCosts(const std::vector<ShaderCost>& before) {
    for (const ShaderCost& was : before) {
      const auto is = std::find_if(stats.shaders.begin(), stats.shaders.end(),
                                   [&](const ShaderCost& c) { return c.name == was.name; });
      if (is == stats.shaders.end()) continue;
      is->runs += was.runs;
      is->points += was.points;
      is->nanoseconds += was.nanoseconds;
      is->countedRuns += was.countedRuns;
      is->instructions += was.instructions;
      is->uniformInstructions += was.uniformInstructions;
      is->lanes.active += was.lanes.active;
      is->lanes.possible += was.lanes.possible;
    }
  }

  // What the tile cache holds, so that refusals can name it.
  struct CountedTiles {
    int64_t bytes = 0;
    ~CountedTiles() { set(0); }
    void set(int64_t now) {
      Memory::count(MemoryUse::Textures, now - bytes);
      bytes = now;
    }
  } countedTiles;
  void countTextures() {
    if (Memory::limit() > 0) countedTiles.set(int64_t(builder.textures().statistics().cacheBytes));
  }

  // Where the pass that begins at `a` ends: passes end on the same counts however a frame is split, but one that
  // would outlast the time of a snapshot or a checkpoint is cut, and where caches are crowded those to come are as long
  // as passes get. Neither changes a pixel.
  int passEnd(int a, double seconds, bool crowded) const {
    if (counts.stride > 1) return a + 1;
    int b = counts.last;
    for (const auto& [from, to] :
         Frame::passes(counts.first, counts.last, Frame::passSamplesOf(*integrator.plugin(), integrator.data())))
      if (to > a) {
        b = to;
        break;
      }
    const bool keepsRecords = hasLightStage() || Frame::passSamplesOf(*integrator.plugin(), integrator.data());
    if (crowded && !noise && !keepsRecords)
      b = std::min(counts.last, (a / Frame::kMostSamplesOfPass + 1) * Frame::kMostSamplesOfPass);
    constexpr int kLeast = 4;  // smaller passes would not fill a ray group
    double longest = std::numeric_limits<double>::infinity();
    for (const double wanted :
         {settings.snapshotSeconds, checkpoints.wanted().every.seconds, checkpoints.wanted().exitAt.seconds})
      if (wanted > 0) longest = std::min(longest, wanted);
    if (!std::isfinite(longest) || samplesDone == checkpoints.recovered().samples || keepsRecords) return b;
    const double perSample = seconds / (samplesDone - checkpoints.recovered().samples);
    if ((b - a) * perSample <= longest) return b;
    return std::min(b, a + std::max(kLeast, int(longest / perSample)));
  }

  void fitRecords(int first, int last) {
    recordBudget.fit({*frame, integrator, scene, builder.host(), diagnostics}, first, last);
  }

  // Where the record holds the colour whose noise decides, the first; -1: there is none.
  int colourOffset() const {
    const film::ChannelLayout& layout = plan->displays.layout;
    const int c = firstColor(layout);
    return c >= 0 && layout[c].width == 3 ? layout.recordOffset(c) : -1;
  }

  // What is left is at most what active pixels would still take.
  Progress progressAt(double seconds) const {
    Progress p;
    p.samplesDone = samplesDone;
    p.samplesWanted = counts.count();
    p.memoryBytes = Memory::resident();
    const double taken = double(samplesTaken), most = double(p.samplesWanted - samplesDone) * double(active.count());
    // adaptive: what the last decision expects, as far as it has not been taken since
    const bool isExpected = noise && convergence.samplesLeft() >= 0;
    const double left =
        isExpected ? std::clamp(convergence.samplesLeft() - double(samplesTaken - takenAtDecision), 0., most) : most;
    p.seconds = seconds;
    p.isErrorWanted = counts.adaptivity.error > 0;
    if (p.isErrorWanted) p.error = convergence.error();
    if (p.isErrorWanted && !isExpected) return p;  // nobody knows yet
    p.fraction = taken / std::max(1.0, taken + left);
    const double takenNow = taken - double(checkpoints.recovered().taken);
    p.secondsLeft = takenNow > 0 ? seconds / takenNow * left : -1;
    return p;
  }

  // A frame that was to have less noise than it has.
  void tellOfNoise(bool isComplete) {
    const float wanted = counts.adaptivity.error;
    if (!noise || wanted <= 0 || !isComplete || active.count() == 0) return;
    diagnostics.warning(
        "RENDER-NOISE", scene.pos,
        fmt::format("after {} samples a pixel the picture's relative error is about {:.3g}, and {:.3g} "
                    "was asked for",
                    samplesDone, convergence.error(), wanted),
        "the picture is written", "--max-spp allows more samples");
  }

  Sampled sampled() { return {*film, counts, samplesDone, samplesTaken, active, noise.get(), convergence}; }

  // Of the sums as they are, of complete passes.
  film::ShardInfo shardInfo(double seconds) {
    film::ShardInfo info;
    info.sceneHash = identity.hash(true);
    info.inventory = identity.inventory(scene);
    info.lateFiles = identity.lateFiles(builder.contents());
    for (const FileContents::Entry& f : checkpoints.recovered().files)
      if (std::find(info.lateFiles.begin(), info.lateFiles.end(), f) == info.lateFiles.end())
        info.lateFiles.push_back(f);
    info.seed = settings.seed;
    info.frame = scene.frame;
    info.pixelFilter = plan->filter.name();
    info.ranges = rangesDone();
    info.renderSeconds = seconds + checkpoints.recovered().seconds;
    info.kinoraVersion = kVersion;
    info.outputs = film::outputsToJson(plan->displays, metadata(seconds, true, false));
    return info;
  }

  void writeCheckpoint(double seconds) { checkpoints.write(sampled(), shardInfo(seconds), seconds, diagnostics); }
  // The frame ends before its time: the passes that are complete are kept.
  void keepWork(double seconds) {
    if (!checkpoints.wanted().isOn() || samplesDone == 0) return;
    checkpoints.fallBack(sampled());
    writeCheckpoint(seconds);
  }

  Outcome run(bool write, const std::function<void(const Progress&)>& progress);
};

Renderer::Renderer(Registry& registry, Diagnostics& diagnostics, Settings settings)
    : impl_(std::make_unique<Impl>(registry, diagnostics, std::move(settings))) {}
Renderer::~Renderer() = default;

bool Renderer::load(scene::Scene scene, std::shared_ptr<const scene::ProceduralSources> procedurals) {
  Impl& m = *impl_;
  const auto start = Clock::now();
  m.stats = Statistics();
  m.identity.wait();
  m.forget();
  m.isEdited = m.saidAllIsHeld = false;
  m.scene = std::move(scene);
  m.procedurals.setSources(std::move(procedurals));
  if (!m.build()) return false;
  m.stats.loadSeconds = since(start);
  m.loadedAt = Clock::now();
  return true;
}

scene::Scene& Renderer::scene() {
  impl_->identity.wait();  // edits follow
  return impl_->scene;
}

bool Renderer::update() {
  Impl& m = *impl_;
  if (!m.build()) return false;
  m.loadedAt = Clock::now();
  return true;
}

Outcome Renderer::Impl::run(bool write, const std::function<void(const Progress&)>& progress) {
  // one pool for all: Embree and the loop share it
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
  const auto start = Clock::now();
  if (!isReady) {
    diagnostics.error("RENDER-NO-WORLD", scene.pos, "there is no world to render: the last load or update failed",
                      "nothing is rendered", "correct the scene and update again");
    return Outcome::BadScene;
  }
  try {
    if (write) {
      output =
          std::make_unique<film::DisplayOutput>(plan->displays, displayDrivers(registry, diagnostics), diagnostics);
      if (!plan->displayFilters.empty())
        output->setPixelStage([this](const film::Film& f) { return plan->displayFilters.run(f); });
      if (!output->probe()) return Outcome::CannotWrite;
    }
    if (hider && !readAllProcedurals()) return Outcome::Interrupted;  // it may look at objects in other ways
    active = ActivePixels(film->window());
    noise.reset();
    if (counts.adaptivity.error > 0 && colourOffset() < 0) {
      counts.last = std::min(counts.last, counts.first + kUsualSamples);
      diagnostics.warning("RENDER-ADAPTIVE", scene.pos,
                          "an error is asked for, and the picture has no colour to measure it by",
                          "every pixel takes " + std::to_string(counts.last - counts.first) + " samples");
    }
    if (counts.adaptivity.isOn() && colourOffset() >= 0) {
      noise = std::make_unique<NoiseEstimate>(active.blocks());
      convergence = Convergence(counts.adaptivity, counts.first, counts.last - counts.first, active.blocks());
    }
    const float minutes = scene.options.getFloat("limits:rendertime", 0);
    renderTime = minutes > 0 ? std::make_unique<RenderTime>(60. * minutes, settings.stop) : nullptr;
    makeFrame();
    samplesDone = 0;
    samplesTaken = 0;
    checkpoints = Checkpoints(checkpointing);
    if (checkpoints.isThere()) checkpoints.recover(sampled(), shardInfo(0), diagnostics);
    takenAtDecision = samplesTaken;
    auto lastSnapshot = Clock::now();
    bool complete = true, showed = false, leaves = false;
    const bool keepsSums = settings.firstSample >= 0 || checkpoints.wanted().isOn();
    CachePressure caches(builder);
    bool crowded = false;
    for (int a = counts.first + samplesDone * counts.stride; a < counts.last && active.count() > 0;) {
      const int b = passEnd(a, since(start), crowded);
      if (renderTime) renderTime->look();
      if (keepsSums) checkpoints.passBegins(sampled());
      fitRecords(a, b);
      if (!frame->pass(a, b)) {
        complete = false;
        break;
      }
      checkpoints.passEnds();
      crowded = caches.isHigh();
      samplesTaken += uint64_t(b - a) * active.count();
      samplesDone += b - a;
      a = b - 1 + counts.stride;
      if (noise && isDecisionPoint(b)) {
        convergence.decide(*noise, b, active);
        takenAtDecision = samplesTaken;
      }
      const double seconds = since(start);
      if (progress) progress(progressAt(seconds));
      const bool isAsked = settings.snapshotNow && settings.snapshotNow->exchange(false);
      const bool isDue = settings.snapshotSeconds > 0 && (!showed || since(lastSnapshot) > settings.snapshotSeconds);
      if (write && a < counts.last && (isAsked || isDue)) {
        // the first pixels go to the file at once, later ones now and then
        output->snapshot(*film, metadata(seconds, false, true));
        showed = true;
        lastSnapshot = Clock::now();
        if (stats.firstPixelSeconds < 0) stats.firstPixelSeconds = since(loadedAt);
      }
      const bool goesOn = a < counts.last && active.count() > 0;
      if (goesOn && checkpoints.isDue(seconds, isAsked)) writeCheckpoint(seconds);
      leaves = goesOn && checkpoints.isOver(seconds);
      if (leaves) {
        complete = false;
        break;
      }
      countTextures();
      Memory::check(MemoryUse::Textures);
    }
    builder.stopDicingBy(settings.stop);
    renderTime.reset();
    stats.renderSeconds = since(start);
    stats.samples = samplesTaken;
    stats.donePixels = film->window().pixels() - active.count();
    if (noise) stats.noise = convergence.error();
    tellOfNoise(complete);
    frame->addTo(stats);
    const film::FilmCounters counters = film->counters();
    stats.nonFiniteSamples = counters.nonFinite;
    stats.negativeSamples = counters.negative;
    stats.relativeError = relativeError();
    for (uint64_t n : counters.saturated) stats.saturatedSamples += n;
    warnOfSamples(counters, diagnostics);
    warnOfRecords(*frame, integrator, diagnostics);
    warnOfMedia(integrator, builder, stats, diagnostics);
    warnOfPaths(stats, diagnostics);
    const TextureStatistics t = builder.textures().statistics();
    builder.countLevels(stats);
    builder.countVolumes(stats);
    stats.textureLookups = t.lookups;
    stats.textureMisses = t.cacheMisses;
    stats.textureBytes = t.cacheBytes;
    stats.textureTilesAgain = t.tilesAgain;
    stats.textureBytesRead = t.bytesRead;
    stats.largestTextures.clear();
    for (const auto& file : t.largest) stats.largestTextures.push_back({file.path, file.bytesRead, file.tilesAgain});
    stats.memory.push_back({"film", film->bytes()});
    stats.memory.push_back({"group arenas", frame->arenaBytes()});
    if (frame->store()) stats.memory.push_back({"records between stages (peak)", frame->store()->mostBytes()});
    if (frame->learned()) stats.memory.push_back({"learned by paths (peak)", frame->learned()->mostBytes()});
    stats.memory.push_back({"texture cache", t.cacheBytes + t.imageBytes});
    stats.memory.push_back({"process (resident)", Memory::resident()});
    if (write) {
      if (complete) warnOfBlackness(*film, *output, scene, builder.world().hasHoles, registry, diagnostics);
      const bool written = output->write(*film, metadata(stats.renderSeconds, complete, false));
      if (stats.firstPixelSeconds < 0) stats.firstPixelSeconds = since(loadedAt);
      if (complete && written) checkpoints.remove();
      if (complete && !written) keepWork(stats.renderSeconds);
      if (!complete && !leaves) keepWork(stats.renderSeconds);
      if (!written) return Outcome::CannotWrite;
    } else if (!complete && !leaves) {
      keepWork(stats.renderSeconds);
    }
    return complete ? Outcome::Complete : Outcome::Interrupted;
  } catch (const MemoryExceeded& e) {
    diagnostics.error("MEMORY-LIMIT", scene.pos, e.what(), "stopped; the picture has the samples that were done",
                      "raise --memory-limit, or simplify what is largest");
    if (write && output && samplesDone > 0) output->snapshot(*film, metadata(since(start), false, true));
    keepWork(since(start));
    return Outcome::OutOfMemory;
  } catch (const std::bad_alloc&) {
    diagnostics.error("RENDER-MEMORY", scene.pos, "not enough memory to render", "stopped");
    return Outcome::OutOfMemory;
  }
}

Outcome Renderer::render(const std::function<void(const Progress&)>& progress) { return impl_->run(true, progress); }
Outcome Renderer::renderFilm(const std::function<void(const Progress&)>& progress) {
  return impl_->run(false, progress);
}
film::Film& Renderer::film() { return *impl_->film; }
void Renderer::setHider(const Hider* hider) { impl_->hider = hider; }
const Statistics& Renderer::statistics() const { return impl_->stats; }
int Renderer::samplesDone() const { return impl_->samplesDone; }
int Renderer::samplesEnd() const {
  const SampleCounts& c = impl_->counts;
  return impl_->samplesDone ? c.first + (impl_->samplesDone - 1) * c.stride + 1 : c.first;
}

bool Renderer::replay(int x, int y, int sample, const std::function<void(const std::string&)>& print) {
  if (!impl_->isReady) return false;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(impl_->threads));
  impl_->makeFrame();
  impl_->fitRecords(sample, sample + 1);
  return impl_->frame->replay(x, y, sample, print);
}

bool Renderer::writeShard(const std::string& file) {
  Impl& m = *impl_;
  if (m.samplesDone == 0) {
    m.diagnostics.warning("RENDER-NO-SAMPLES", {}, "the render ended before one sample of every pixel was complete",
                          "no part is written");
    return false;
  }
  const bool isComplete = m.samplesDone == m.counts.count();
  if (!isComplete) m.checkpoints.fallBack(m.sampled());
  const film::ShardInfo info = m.shardInfo(m.stats.renderSeconds);
  const film::Status s = film::writeShard(file, *m.film, info);
  if (!s.ok()) m.diagnostics.error("FILM-SHARD-WRITE", {}, s.what, "nothing was written");
  if (s.ok() && isComplete) m.checkpoints.remove();
  return s.ok();
}

std::string Renderer::summary() const {
  const Statistics& s = impl_->stats;
  const auto& c = impl_->builder.camera();
  return std::to_string(c.resolution[0]) + " x " + std::to_string(c.resolution[1]) + " pixels, " +
         (impl_->counts.adaptivity.isOn() ? std::to_string(impl_->counts.adaptivity.least) + " to " : "") +
         std::to_string(impl_->counts.count()) + " samples a pixel; " + std::to_string(s.primitives) +
         " primitives, " + std::to_string(s.instances) + " placements, " + std::to_string(s.triangles) +
         " triangles; " + std::to_string(s.lights) + " lights; " + std::to_string(s.materials) + " materials of " +
         std::to_string(s.programs) + " programs";
}

}  // namespace kinora::render
