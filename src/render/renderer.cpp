#include "render/renderer.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "base/elapsed.h"
#include "base/memory.h"
#include "film/display_output.h"
#include "film/shard.h"
#include "image/colors.h"
#include "plugin/registry.h"
#include "render/cache_pressure.h"
#include "render/camera_attributes.h"
#include "render/check_scene.h"
#include "render/checkpoint.h"
#include "render/error_map.h"
#include "render/frame.h"
#include "render/frame_identity.h"
#include "render/frame_integrator.h"
#include "render/frame_memory.h"
#include "render/frame_plan.h"
#include "render/frame_samples.h"
#include "render/frame_statistics.h"
#include "render/frame_warnings.h"
#include "render/frame_world.h"
#include "render/overrides.h"
#include "render/procedurals.h"
#include "render/record_budget.h"
#include "render/render_time.h"
#include "render/sample_counts.h"
#include "render/version.h"
#include "render/world_build.h"

namespace kinora::render {

namespace {

using Clock = std::chrono::steady_clock;

int threadCount(int wanted) {
  const int all = std::max(1, int(std::thread::hardware_concurrency()));
  return std::clamp(wanted > 0 ? wanted : all + wanted, 1, 256);
}

}  // namespace

// What a frame is made of, and the order of its steps. The steps themselves are elsewhere: which samples are taken
// (frame_samples.h), in which world (frame_world.h), a pass over the picture (frame.h), what is said of it
// (frame_warnings.h, frame_statistics.h).
struct Renderer::Impl {
  // How the passes of a render ended: all are there, it was stopped, or it was left at a checkpoint.
  enum class Ended : uint8_t { Complete, Stopped, Left };

  Registry& registry;
  Diagnostics& diagnostics;
  Settings settings;
  scene::Scene scene;
  Procedurals procedurals;  // of the scene
  WorldBuilder builder;
  Statistics stats;
  std::unique_ptr<FramePlan> plan;
  Digest ofPlan;          // of what it was made of
  bool isEdited = false;  // the scene is that of the world before, edited
  std::unique_ptr<film::Film> film;
  std::unique_ptr<film::DisplayOutput> output;
  std::unique_ptr<Frame> frame;
  std::unique_ptr<RenderTime> renderTime;  // while rendering; null: as long as it takes
  FrameIntegrator integrator;
  RecordBudget recordBudget;
  int threads = 1;
  FrameSamples samples;
  const Hider* hider = nullptr;
  FrameIdentity identity;
  Clock::time_point loadedAt, startedAt;  // startedAt: of the running render
  FrameMemory memory;
  FrameWorld world{FrameWorld::Parts{scene, settings, procedurals, builder, integrator, memory, stats, diagnostics}};
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
      integrator.forget();
    }
    if (!builder.buildCamera(scene, stats)) return false;
    samples.setCounts(sampleCountsOf(scene, settings, diagnostics));
    checkpointing = checkpointingOf(scene, settings.checkpoint, diagnostics);
    return integrator.make(scene, registry, builder, diagnostics, stats.rebuilt);
  }

  bool makeFilm() {
    procedurals.begin(scene);
    builder.openShaders(procedurals.scene());
    // what has not been read may need it
    const bool lightStage = integrator.hasLightStage(),
               split = builder.needsSplit(scene) || integrator.tellsLobesApart() || !procedurals.empty();
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
    // an interrupted part of a frame, and a checkpoint, fall back to the sums of the last complete pass
    const int copies = settings.firstSample >= 0 || checkpointing.isOn() ? 2 : 1;
    memory.setFilm(window, plan->displays, copies, samples.counts().adaptivity.isOn());
    film::Status made;
    film = film::Film::create(c.resolution[0], c.resolution[1], window, plan->displays.layout, made);
    if (!film) diagnostics.error("FILM-MEMORY", scene.pos, made.what, "nothing is rendered");
    return film != nullptr;
  }

  // early: of a picture that should not wait for anything
  film::FrameMetadata metadata(double seconds, bool complete, bool early) {
    film::FrameMetadata m;
    describeCamera(builder.camera(), m);
    m.frame = scene.frame;
    m.seed = settings.seed;
    m.samples = samples.ranges();
    m.samplesPerPixel = double(samples.taken()) / double(std::max<uint64_t>(1, film->window().pixels()));
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
    in.integrator = &integrator.plugin();
    in.integratorData = integrator.instance().data();
    in.paths = plan->paths.get();
    in.plan = &plan->record;
    in.filter = &plan->filter;
    in.sampleFilters = plan->sampleFilters.empty() ? nullptr : &plan->sampleFilters;
    in.ratios = plan->ratios;
    in.film = film.get();
    in.hider = hider;
    in.seed = settings.seed;
    in.firstSample = samples.counts().first;
    in.lastSample = samples.counts().last;
    if (samples.isAdaptive()) {
      in.active = &samples.active();
      in.noise = samples.noise();
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
    in.readMet = [this](std::vector<WaitingGroup*>& groups) {
      return world.readFor(groups, frame->store() != nullptr);
    };
    in.statistics = &stats;
    frame = std::make_unique<Frame>(in);
    recordBudget = {};
  }

  // A world of the scene as it is now, from what still holds of the one before. When that fails nothing is kept.
  bool build() {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
    identity.wait();  // of the world before, which looks at the scene
    frame.reset();
    world.close();
    bool isMade = false;
    try {
      isMade = makeWorld();
    } catch (const MemoryExceeded& e) {
      diagnostics.error("MEMORY-LIMIT", scene.pos, e.what(), "nothing is rendered",
                        "raise --memory-limit, or simplify what is largest");
    } catch (const std::bad_alloc&) {
      diagnostics.error("RENDER-MEMORY", scene.pos, "not enough memory to build the scene", "nothing is rendered");
    }
    if (!isMade) forget();
    return isMade;
  }

  // Nothing that was made is used again.
  void forget() {
    world.close();
    frame.reset();
    film.reset();
    plan.reset();
    integrator.forget();
    builder.forget();
  }

  bool makeWorld() {
    checkScene(scene, diagnostics);
    memory.setDescription(scene.bytes());
    if (!prepare() || !makeFilm()) return false;
    if (!world.build(plan->paths)) return false;
    identity.start(scene, builder.contents(), registry, isEdited);
    isEdited = true;
    // what is read from here on is no part of what the frame is known by: that must not follow from which rays there are
    if (!world.resume()) return false;
    if ((settings.readsAllProcedurals || asksObjectsUnseen()) && !world.readAll()) return false;
    if (procedurals.delayed().unread.empty())  // else nobody knows what is in there
      warnOfChannels(*plan, builder, scene, diagnostics);
    FrameMemory::limitTiles(builder.textures(), settings.textureCacheBytes);
    return true;
  }

  // Whether what an object holds may count where no ray has met it: manifold walks aim at objects by a list.
  bool asksObjectsUnseen() const {
    const light::LightSet& lights = *builder.world().lights;
    for (uint32_t i = 0; i < lights.size(); ++i)
      if (lights.isWalkedTo(i)) return true;
    return false;
  }

  void fitRecords(int first, int last) {
    recordBudget.fit({*frame, integrator.instance(), scene, builder.host(), diagnostics}, first, last);
  }

  // Where the record holds the colour whose noise decides, the first; -1: there is none.
  int colourOffset() const {
    const film::ChannelLayout& layout = plan->displays.layout;
    const int c = firstColor(layout);
    return c >= 0 && layout[c].width == 3 ? layout.recordOffset(c) : -1;
  }

  Sampled sampled() { return samples.in(*film); }

  // Passes are no longer than until a picture or a checkpoint is due.
  PassLimits passLimits(bool areCachesCrowded) const {
    PassLimits limits;
    limits.most = integrator.passSamples();
    limits.isFixed = integrator.dependsOnPasses();
    limits.areCachesCrowded = areCachesCrowded;
    limits.seconds = secondsSince(startedAt);
    const Checkpointing& wanted = checkpoints.wanted();
    for (const double seconds : {settings.snapshotSeconds, wanted.every.seconds, wanted.exitAt.seconds})
      if (seconds > 0) limits.longest = std::min(limits.longest, seconds);
    return limits;
  }

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
    info.ranges = samples.ranges();
    info.renderSeconds = seconds + checkpoints.recovered().seconds;
    info.kinoraVersion = kVersion;
    info.outputs = film::outputsToJson(plan->displays, metadata(seconds, true, false));
    return info;
  }

  void writeCheckpoint(double seconds) { checkpoints.write(sampled(), shardInfo(seconds), seconds, diagnostics); }
  // The frame ends before its time: the passes that are complete are kept.
  void keepWork(double seconds) {
    if (!checkpoints.wanted().isOn() || samples.done() == 0) return;
    checkpoints.fallBack(sampled());
    writeCheckpoint(seconds);
  }

  using Listener = std::function<void(const Progress&)>;
  bool openOutput();
  void beginSamples();
  Ended takeSamples(bool write, const Listener& progress);
  void tellOfFrame(bool isComplete);
  Outcome finish(bool write, Ended ended);
  Outcome run(bool write, const Listener& progress);
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
  m.isEdited = false;
  m.world.forgetTold();
  m.scene = std::move(scene);
  m.procedurals.setSources(std::move(procedurals));
  if (!m.build()) return false;
  m.stats.loadSeconds = secondsSince(start);
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

// False when some picture could not be written.
bool Renderer::Impl::openOutput() {
  output = std::make_unique<film::DisplayOutput>(plan->displays, displayDrivers(registry, diagnostics), diagnostics);
  if (!plan->displayFilters.empty())
    output->setPixelStage([this](const film::Film& f) { return plan->displayFilters.run(f); });
  return output->probe();
}

// All that passes need, from nothing or from a checkpoint.
void Renderer::Impl::beginSamples() {
  samples.begin(film->window(), colourOffset() >= 0, scene, diagnostics);
  const float minutes = scene.options.getFloat("limits:rendertime", 0);
  renderTime = minutes > 0 ? std::make_unique<RenderTime>(60. * minutes, settings.stop) : nullptr;
  makeFrame();
  checkpoints = Checkpoints(checkpointing);
  if (checkpoints.isThere()) checkpoints.recover(sampled(), shardInfo(0), diagnostics);
  samples.goOn(checkpoints.recovered());
}

// Pass by pass; pictures and checkpoints between them.
Renderer::Impl::Ended Renderer::Impl::takeSamples(bool write, const Listener& progress) {
  auto lastSnapshot = Clock::now();
  bool showed = false, crowded = false;
  const bool keepsSums = settings.firstSample >= 0 || checkpoints.wanted().isOn();
  CachePressure caches(builder);
  while (samples.areLeft()) {
    const int first = samples.next(), last = samples.passEnd(passLimits(crowded));
    if (renderTime) renderTime->look();
    if (keepsSums) checkpoints.passBegins(sampled());
    fitRecords(first, last);
    if (!frame->pass(first, last)) return Ended::Stopped;
    checkpoints.passEnds();
    crowded = caches.isHigh();
    samples.passDone(last);
    const double seconds = secondsSince(startedAt);
    if (progress) progress(samples.progress(seconds));
    const bool isAsked = settings.snapshotNow && settings.snapshotNow->exchange(false);
    const bool isDue =
        settings.snapshotSeconds > 0 && (!showed || secondsSince(lastSnapshot) > settings.snapshotSeconds);
    if (write && samples.next() < samples.counts().last && (isAsked || isDue)) {
      // the first pixels go to the file at once, later ones now and then
      output->snapshot(*film, metadata(seconds, false, true));
      showed = true;
      lastSnapshot = Clock::now();
      if (stats.firstPixelSeconds < 0) stats.firstPixelSeconds = secondsSince(loadedAt);
    }
    if (samples.areLeft() && checkpoints.isDue(seconds, isAsked)) writeCheckpoint(seconds);
    if (samples.areLeft() && checkpoints.isOver(seconds)) return Ended::Left;
    memory.countTiles(builder.textures());
    Memory::check(MemoryUse::Textures);
  }
  return Ended::Complete;
}

// In statistics and in messages.
void Renderer::Impl::tellOfFrame(bool isComplete) {
  stats.renderSeconds = secondsSince(startedAt);
  stats.samples = samples.taken();
  stats.donePixels = film->window().pixels() - samples.active().count();
  if (samples.isAdaptive()) stats.noise = samples.convergence().error();
  if (isComplete) samples.tellOfNoise(scene, diagnostics);
  // where the step between indices is even all samples are of one half
  const bool hasHalves = samples.counts().stride % 2 && samples.done() >= 2;
  stats.relativeError = hasHalves ? errorMapOf(*film, plan->halves) : PixelMap();
  addFrame(*frame, *film, builder, stats);
  warnOfSamples(film->counters(), diagnostics);
  warnOfRecords(*frame, integrator.instance(), diagnostics);
  warnOfMedia(integrator.instance(), builder, stats, diagnostics);
  warnOfPaths(stats, diagnostics);
}

// The pictures, and what is kept of a frame that is not complete or could not be written.
Outcome Renderer::Impl::finish(bool write, Ended ended) {
  const bool isComplete = ended == Ended::Complete;
  bool isWritten = true;
  if (write) {
    if (isComplete) warnOfBlackness(*film, *output, scene, builder.world().hasHoles, registry, diagnostics);
    isWritten = output->write(*film, metadata(stats.renderSeconds, isComplete, false));
    if (stats.firstPixelSeconds < 0) stats.firstPixelSeconds = secondsSince(loadedAt);
    if (isComplete && isWritten) checkpoints.remove();
  }
  // one that was left has its checkpoint
  if (ended == Ended::Stopped || (isComplete && !isWritten)) keepWork(stats.renderSeconds);
  if (!isWritten) return Outcome::CannotWrite;
  return isComplete ? Outcome::Complete : Outcome::Interrupted;
}

Outcome Renderer::Impl::run(bool write, const Listener& progress) {
  // one pool for all: Embree and the loop share it
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
  startedAt = Clock::now();
  if (!world.isReady()) {
    diagnostics.error("RENDER-NO-WORLD", scene.pos, "there is no world to render: the last load or update failed",
                      "nothing is rendered", "correct the scene and update again");
    return Outcome::BadScene;
  }
  try {
    if (write && !openOutput()) return Outcome::CannotWrite;
    if (hider && !world.readAll()) return Outcome::Interrupted;  // it may look at objects in other ways
    beginSamples();
    const Ended ended = takeSamples(write, progress);
    builder.stopDicingBy(settings.stop);
    renderTime.reset();
    tellOfFrame(ended == Ended::Complete);
    return finish(write, ended);
  } catch (const MemoryExceeded& e) {
    diagnostics.error("MEMORY-LIMIT", scene.pos, e.what(), "stopped; the picture has the samples that were done",
                      "raise --memory-limit, or simplify what is largest");
    const double seconds = secondsSince(startedAt);
    if (write && output && samples.done() > 0) output->snapshot(*film, metadata(seconds, false, true));
    keepWork(seconds);
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
int Renderer::samplesDone() const { return impl_->samples.done(); }
int Renderer::samplesEnd() const { return impl_->samples.end(); }

bool Renderer::replay(int x, int y, int sample, const std::function<void(const std::string&)>& print) {
  if (!impl_->world.isReady()) return false;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(impl_->threads));
  impl_->makeFrame();
  impl_->fitRecords(sample, sample + 1);
  return impl_->frame->replay(x, y, sample, print);
}

bool Renderer::writeShard(const std::string& file) {
  Impl& m = *impl_;
  if (m.samples.done() == 0) {
    m.diagnostics.warning("RENDER-NO-SAMPLES", {}, "the render ended before one sample of every pixel was complete",
                          "no part is written");
    return false;
  }
  const bool isComplete = m.samples.done() == m.samples.counts().count();
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
  const SampleCounts& counts = impl_->samples.counts();
  return std::to_string(c.resolution[0]) + " x " + std::to_string(c.resolution[1]) + " pixels, " +
         (counts.adaptivity.isOn() ? std::to_string(counts.adaptivity.least) + " to " : "") +
         std::to_string(counts.count()) + " samples a pixel; " + std::to_string(s.primitives) + " primitives, " +
         std::to_string(s.instances) + " placements, " + std::to_string(s.triangles) + " triangles; " +
         std::to_string(s.lights) + " lights; " + std::to_string(s.materials) + " materials of " +
         std::to_string(s.programs) + " programs";
}

}  // namespace kinora::render
