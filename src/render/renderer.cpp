#include "render/renderer.h"

#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <thread>

#include "film/display_output.h"
#include "film/shard.h"
#include "plugin/registry.h"
#include "render/frame.h"
#include "render/version.h"
#include "render/world_build.h"
#include "texture/texture_system.h"

namespace kinora::render {

namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

uint64_t residentBytes() {
  long pages = 0, resident = 0;
  if (FILE* f = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(f, "%ld %ld", &pages, &resident) != 2) resident = 0;
    std::fclose(f);
  }
  return uint64_t(resident) * uint64_t(sysconf(_SC_PAGESIZE));
}

int threadCount(int wanted) {
  const int all = std::max(1, int(std::thread::hardware_concurrency()));
  return std::clamp(wanted > 0 ? wanted : all + wanted, 1, 256);
}

// 64-bit FNV-1a of what decides a pixel; not a secret, only a fingerprint.
struct Hash {
  uint64_t h = 1469598103934665603ull;
  void bytes(const void* p, size_t n) {
    for (size_t i = 0; i < n; ++i) h = (h ^ static_cast<const unsigned char*>(p)[i]) * 1099511628211ull;
  }
  void text(const std::string& s) { bytes(s.data(), s.size() + 1); }
  void params(const scene::ParameterList& list) {
    for (const scene::Parameter& p : list) {
      text(p.name);
      bytes(p.floats.data(), p.floats.size() * 4);
      bytes(p.ints.data(), p.ints.size() * 4);
      for (const std::string& s : p.strings) text(s);
    }
  }
  void node(const scene::NodePtr& n) {
    if (!n) return;
    text(n->plugin);
    params(n->params);
  }
  void transform(const scene::Transform& t) {
    bytes(t.times.data(), t.times.size() * sizeof(double));
    bytes(t.matrices.data(), t.matrices.size() * sizeof(scene::Matrix));
  }
};

}  // namespace

struct Renderer::Impl {
  Registry& registry;
  Diagnostics& diagnostics;
  Settings settings;
  scene::Scene scene;
  WorldBuilder builder;
  Statistics stats;
  film::DisplayPlan plan;
  std::unique_ptr<film::LightPaths> paths;
  RecordPlan record;
  film::PixelFilter filter;
  FilterChain sampleFilters, displayFilters;
  std::vector<film::FilterRatio> ratios;
  std::unique_ptr<film::Film> film;
  std::unique_ptr<film::DisplayOutput> output;
  std::unique_ptr<Frame> frame;
  Instance integrator;
  int threads = 1, firstSample = 0, lastSample = 64, samplesDone = 0;
  const Hider* hider = nullptr;
  std::string hash;
  Clock::time_point loadedAt;
  std::vector<std::unique_ptr<scene::Node>> overridden;

  Impl(Registry& r, Diagnostics& d, Settings s) : registry(r), diagnostics(d), settings(std::move(s)), builder(r, d, settings) {
    threads = threadCount(settings.threads);
  }

  film::DriverLookup drivers() {
    return [this](const std::string& name) { return registry.find(Kind::Display, name, diagnostics, {}); };
  }

  // --set KIND.NAME=VALUE: a parameter of the integrator, the projection, the hider, every light or bxdf of the kind; or
  // option.GROUP:NAME=VALUE.
  void applySets() {
    for (const auto& [key, value] : settings.sets) {
      const size_t dot = key.find('.');
      const std::string kind = key.substr(0, dot), name = dot == std::string::npos ? "" : key.substr(dot + 1);
      const auto parameter = [&] {
        scene::Parameter p;
        p.name = name;
        std::string v = value;
        for (char& c : v)
          if (c == ',') c = ' ';
        const char* s = v.c_str();
        char* end = nullptr;
        for (;;) {
          while (*s == ' ') ++s;
          if (!*s) break;
          const float f = std::strtof(s, &end);
          if (end == s) {
            p.floats.clear();
            break;
          }
          p.floats.push_back(f);
          s = end;
        }
        if (p.floats.empty()) {
          p.type = scene::ValueType::String;
          p.strings = {value};
        } else {
          p.type = p.floats.size() == 3 ? scene::ValueType::Color : scene::ValueType::Float;
        }
        return p;
      };
      const auto change = [&](const scene::NodePtr& node) -> scene::NodePtr {
        auto copy = std::make_shared<scene::Node>(node ? *node : scene::Node());
        copy->params.set(parameter());
        return copy;
      };
      if (name.empty()) {
        diagnostics.error("CLI-SET", {}, "--set '" + key + "=" + value + "' does not say KIND.NAME=VALUE", "ignored");
      } else if (kind == "integrator") {
        if (!scene.integrator) {
          auto n = std::make_shared<scene::Node>();
          n->kind = "Integrator";
          n->plugin = "PxrPathTracer";
          n->handle = "integrator";
          scene.integrator = n;
        }
        scene.integrator = change(scene.integrator);
      } else if (kind == "hider") {
        scene.hider = change(scene.hider);
      } else if (kind == "projection" && !scene.cameras.empty()) {
        scene.cameras[0].projection = change(scene.cameras[0].projection);
      } else if (kind == "option") {
        scene.options.set(parameter());
      } else if (kind == "light") {
        for (scene::Light& l : scene.lights) l.node = change(l.node);
      } else if (kind == "display") {
        for (scene::Display& d : scene.displays) d.params.set(parameter());
      } else {
        diagnostics.error("CLI-SET", {}, "--set knows no kind '" + kind + "'", "ignored",
                          "integrator, hider, projection, option, light or display");
      }
    }
  }

  bool prepare() {
    if (!settings.integrator.empty()) {
      auto n = std::make_shared<scene::Node>();
      n->kind = "Integrator";
      n->plugin = settings.integrator;
      n->handle = "commandLine";
      scene.integrator = n;
    }
    applySets();
    if (!builder.buildCamera(scene)) return false;
    // samples
    int spp = settings.samplesPerPixel;
    if (spp <= 0) {
      spp = scene.hider ? scene.hider->params.getInt("maxsamples", 0) : 0;
      if (spp <= 0 && scene.pixelSamples[0] > 0) spp = scene.pixelSamples[0] * std::max(1, scene.pixelSamples[1]);
      if (spp <= 0) spp = 64;
    }
    spp = std::clamp(spp, 1, 1 << 16);
    firstSample = 0;
    lastSample = spp;
    if (settings.firstSample >= 0) {
      firstSample = settings.firstSample;
      lastSample = settings.lastSample;
    } else if (scene.hider) {
      firstSample = std::clamp(scene.hider->params.getInt("sampleoffset", 0), 0, 1 << 20);
      lastSample = firstSample + spp;
    }
    return makeIntegrator();
  }

  bool makeIntegrator() {
    const scene::Node* node = scene.integrator.get();
    // a scene that names neither an integrator nor a light is looked at with a headlight
    const bool dark = scene.lights.empty() && scene.classicLights.empty() &&
                      std::all_of(scene.prototypes.begin(), scene.prototypes.end(), [](const scene::Prototype& p) { return p.lights.empty(); });
    const std::string name = node ? node->plugin : dark ? "PxrDefault" : "PxrPathTracer";
    const Descriptor* d = registry.find(Kind::Integrator, name, diagnostics, node ? node->pos : SourcePos{});
    if (!d) {
      diagnostics.warning("PLUGIN-MISSING", node->pos, "no integrator '" + name + "'", "PxrPathTracer stands in");
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

  bool makeFilm() {
    film::PlanOptions options;
    options.output = settings.output;
    options.splats = hasLightStage();
    plan = film::planDisplays(scene, options, drivers(), diagnostics);
    if (!settings.output.empty()) {
      // with -o the primary picture is where the user wants it; others that name a folder of another machine go beside it
      const std::filesystem::path beside = std::filesystem::path(settings.output).parent_path();
      for (size_t i = 1; i < plan.outputs.size(); ++i) {
        std::error_code ec;
        const std::filesystem::path file = plan.outputs[i].file, folder = file.parent_path();
        if (folder.empty() || std::filesystem::is_directory(folder, ec)) continue;
        plan.outputs[i].file = (beside / file.filename()).string();
        diagnostics.warning("DISPLAY-FOLDER", plan.outputs[i].pos, "the folder of picture \"" + file.string() + "\" does not exist",
                            "it is written as \"" + plan.outputs[i].file + "\"");
      }
    }
    makePixelFilter(scene, registry, builder.host(), diagnostics, filter);
    sampleFilters.make(Kind::SampleFilter, scene.sampleFilters, plan.layout, registry, builder.host(), builder.width(), diagnostics);
    displayFilters.make(Kind::DisplayFilter, scene.displayFilters, plan.layout, registry, builder.host(), builder.width(), diagnostics);
    record = planRecord(plan.layout);
    paths = std::make_unique<film::LightPaths>(record.sources, WorldBuilder::lightsNeedSplit(scene), film::LobeNumbers(scene.options));
    addUserLobes(*paths, record);
    tellOfPaths();
    makeRatios();
    const auto& c = builder.camera();
    film::Status made;
    film = film::Film::create(c.resolution[0], c.resolution[1], {c.window[0], c.window[1], c.window[2], c.window[3]}, plan.layout, made);
    if (!film) {
      diagnostics.error("FILM-MEMORY", scene.pos, made.what, "nothing is rendered");
      return false;
    }
    hashScene();
    return true;
  }

  // Expressions that cannot be had as they are written.
  void tellOfPaths() {
    for (const uint16_t i : paths->unmatched()) {
      const std::string what = "the light path expression \"" + record.sources[i] + "\" ";
      if (paths->isTooLarge())
        diagnostics.warning("LPE-SIZE", scene.pos, what + "is too large together with the others", "its channel stays black",
                            "fewer repetitions ({n,m}), labels and channels need less");
      else
        diagnostics.warning("LPE-EMPTY", scene.pos, what + "matches no light path", "its channel stays black",
                            "paths end with L, a light, or O, a glowing surface");
    }
  }

  void makeRatios() {
    ratios.clear();
    for (const film::ChannelFilter& f : plan.layout.filters()) {
      film::PixelFilter own;
      if (!film::PixelFilter::make(f.name, f.xWidth, f.yWidth, own).ok()) own = filter;   // checked by the plan
      ratios.emplace_back(filter, own);
      if (ratios.back().covered() < 0.98)
        diagnostics.warning("DISPLAY-CHANNEL-FILTER", scene.pos,
                            "the filter \"" + f.name + "\" of a channel reaches beyond the frame's pixel filter \"" + filter.name() + "\"",
                            "it is cut there", "give PixelFilter the widest filter of the frame");
    }
  }

  // Sources that are no built-in ones are primvars, and some object should have them.
  void tellOfPrimvars() {
    for (const RecordPlan::Primvar& p : record.primvars)
      if (!builder.world().primvarWidths.contains(p.name))
        diagnostics.warning("DISPLAY-SOURCE", scene.pos,
                            "no output and no primvar named \"" + p.name + "\" is in the scene", "its channel stays black");
  }

  void hashScene() {
    Hash h;
    const auto& c = builder.camera();
    h.bytes(c.resolution.data(), sizeof c.resolution);
    h.bytes(c.window.data(), sizeof c.window);
    h.text(scene.pixelFilter);
    h.bytes(scene.pixelFilterWidth.data(), sizeof scene.pixelFilterWidth);
    for (const auto* list : {&scene.sampleFilters, &scene.displayFilters})
      for (const auto& n : *list) h.node(n);
    h.node(scene.integrator);
    h.node(scene.hider);
    h.params(scene.options);
    for (const scene::Camera& k : scene.cameras) {
      h.transform(k.worldToCamera);
      h.node(k.projection);
      h.bytes(k.screenWindow.data(), sizeof k.screenWindow);
      h.bytes(k.shutter.data(), sizeof k.shutter);
      h.bytes(k.depthOfField.data(), sizeof k.depthOfField);
      h.bytes(k.clipping.data(), sizeof k.clipping);
      for (const auto& plane : k.clippingPlanes) h.bytes(plane.data(), sizeof plane);
      h.params(k.params);
    }
    const auto primitive = [&](const scene::Primitive& p) {
      const uint64_t kind = p.shape.index();
      h.bytes(&kind, sizeof kind);
      if (const auto* q = std::get_if<scene::Quadric>(&p.shape)) h.bytes(q->args.data(), sizeof q->args);
      if (const auto* m = std::get_if<scene::PolygonMesh>(&p.shape)) h.bytes(m->vertices.data(), m->vertices.size() * sizeof(int));
      if (const auto* m = std::get_if<scene::SubdivisionMesh>(&p.shape)) h.bytes(m->vertices.data(), m->vertices.size() * sizeof(int));
      if (const auto* m = std::get_if<scene::Curves>(&p.shape)) {
        h.bytes(&m->cubic, sizeof m->cubic);
        h.bytes(&m->periodic, sizeof m->periodic);
        h.bytes(m->verticesPerCurve.data(), m->verticesPerCurve.size() * sizeof(int));
      }
      h.params(p.primvars);
      for (const auto& m : p.motion) h.params(m);
      h.transform(p.toWorld);
      if (!p.attributes) return;
      h.params(p.attributes->named);
      if (!p.attributes->bxdf) return;
      for (const auto& n : p.attributes->bxdf->patterns) h.node(n);
      h.node(p.attributes->bxdf->terminal);
    };
    for (const auto& p : scene.primitives) primitive(*p);
    for (const auto& proto : scene.prototypes)
      for (const auto& p : proto.primitives) primitive(*p);
    for (const auto& i : scene.instances) h.transform(i.toWorld);
    for (const auto& l : scene.lights) {
      h.node(l.node);
      for (const auto& n : l.filters) h.node(n);
      h.transform(l.toWorld);
    }
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(h.h));
    hash = text;
  }

  film::FrameMetadata metadata(double seconds, bool complete) const {
    film::FrameMetadata m;
    const auto& c = builder.camera();
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) m.worldToCamera[size_t(4 * i + j)] = float(c.worldToCamera[i][j]);
    m.worldToNdc = m.worldToCamera;
    if (const auto* traits = static_cast<const ProjectionTraits*>(c.projection.plugin()->traits); traits && traits->screenMatrix) {
      double s[16];
      traits->screenMatrix(c.projection.data(), s);
      scene::Matrix screen;
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) screen[i][j] = s[4 * i + j];
      const scene::Matrix ndc = c.worldToCamera * screen;
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) m.worldToNdc[size_t(4 * i + j)] = float(ndc[i][j]);
    }
    m.frame = scene.frame;
    m.seed = settings.seed;
    m.samples = {{uint32_t(firstSample), uint32_t(firstSample + samplesDone)}};
    m.samplesPerPixel = samplesDone;
    m.renderSeconds = seconds;
    m.kinoraVersion = kVersion;
    m.sceneHash = hash;
    m.pixelFilter = filter.name();
    m.isComplete = complete;
    return m;
  }

  void makeFrame() {
    FrameInput in{};
    in.world = &builder;
    in.integrator = integrator.plugin();
    in.integratorData = integrator.data();
    in.paths = paths.get();
    in.plan = &record;
    in.filter = &filter;
    in.sampleFilters = sampleFilters.empty() ? nullptr : &sampleFilters;
    in.ratios = ratios;
    in.film = film.get();
    in.hider = hider;
    in.seed = settings.seed;
    in.firstSample = firstSample;
    in.lastSample = lastSample;
    in.threads = threads;
    if (settings.groupSize) in.groupSize = settings.groupSize;
    in.bucketOrder = !settings.bucketOrder.empty() ? settings.bucketOrder : scene.options.getString("bucket:order", "horizontal");
    in.jitter = !scene.hider || scene.hider->params.getInt("jitter", 1) != 0;
    in.stop = settings.stop;
    in.rayListener = settings.rayListener;
    frame = std::make_unique<Frame>(in);
  }

  bool build() {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
    try {
      if (!prepare() || !makeFilm() || !builder.buildWorld(scene, *paths, stats)) return false;
      tellOfPrimvars();
      return true;
    } catch (const std::bad_alloc&) {
      diagnostics.error("RENDER-MEMORY", scene.pos, "not enough memory to build the scene", "nothing is rendered");
      return false;
    }
  }

  Outcome run(bool write, const std::function<void(const Progress&)>& progress);
};

Renderer::Renderer(Registry& registry, Diagnostics& diagnostics, Settings settings)
    : impl_(std::make_unique<Impl>(registry, diagnostics, std::move(settings))) {}
Renderer::~Renderer() = default;

bool Renderer::load(scene::Scene scene) {
  Impl& m = *impl_;
  const auto start = Clock::now();
  m.stats = Statistics();
  m.scene = std::move(scene);
  if (!m.build()) return false;
  m.stats.loadSeconds = since(start);
  m.loadedAt = Clock::now();
  return true;
}

scene::Scene& Renderer::scene() { return impl_->scene; }

bool Renderer::update() {
  Impl& m = *impl_;
  m.frame.reset();
  if (!m.build()) return false;
  m.loadedAt = Clock::now();
  return true;
}

Outcome Renderer::Impl::run(bool write, const std::function<void(const Progress&)>& progress) {
  // one pool for all: Embree and the loop share it
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
  const auto start = Clock::now();
  try {
    if (write) {
      output = std::make_unique<film::DisplayOutput>(plan, drivers(), diagnostics);
      if (!displayFilters.empty())
        output->setPixelStage([this](const film::Film& f) { return displayFilters.run(f); });
      if (!output->probe()) return Outcome::CannotWrite;
    }
    makeFrame();
    const int wanted = lastSample - firstSample;
    samplesDone = 0;
    auto lastSnapshot = Clock::now();
    bool complete = true, written = true, showed = false;
    for (const auto& [a, b] : Frame::passes(firstSample, lastSample)) {
      if (!frame->pass(a, b)) {
        complete = false;
        break;
      }
      samplesDone = b - firstSample;
      const double seconds = since(start);
      if (progress) {
        Progress p;
        p.fraction = double(samplesDone) / wanted;
        p.seconds = seconds;
        p.secondsLeft = samplesDone > 0 ? seconds / samplesDone * (wanted - samplesDone) : -1;
        p.memoryBytes = residentBytes();
        p.samplesDone = samplesDone;
        p.samplesWanted = wanted;
        progress(p);
      }
      if (write && b < lastSample && settings.snapshotSeconds > 0 &&
          (!showed || since(lastSnapshot) > settings.snapshotSeconds)) {
        // the first pixels go to the file at once, later ones now and then
        written = output->write(*film, metadata(seconds, false)) && written;
        showed = true;
        lastSnapshot = Clock::now();
        if (stats.firstPixelSeconds < 0) stats.firstPixelSeconds = since(loadedAt);
      }
    }
    stats.renderSeconds = since(start);
    stats.samples = uint64_t(samplesDone) * uint64_t(film->window().width()) * uint64_t(film->window().height());
    frame->addTo(stats);
    const film::FilmCounters counters = film->counters();
    stats.nonFiniteSamples = counters.nonFinite;
    stats.negativeSamples = counters.negative;
    for (uint64_t n : counters.saturated) stats.saturatedSamples += n;
    if (counters.nonFinite) {
      const film::BadSample bad = counters.bad.empty() ? film::BadSample() : counters.bad.front();
      diagnostics.warning("RENDER-NONFINITE", {}, std::to_string(counters.nonFinite) + " samples were not finite; the first at pixel " +
                              std::to_string(bad.x) + "," + std::to_string(bad.y) + " sample " + std::to_string(bad.sampleIndex),
                          "they were left out with their weight",
                          "--only-sample " + std::to_string(bad.x) + "," + std::to_string(bad.y) + "," + std::to_string(bad.sampleIndex) + " shows the path");
    }
    const TextureStatistics t = builder.textures().statistics();
    stats.textureLookups = t.lookups;
    stats.textureMisses = t.cacheMisses;
    stats.textureBytes = t.cacheBytes;
    stats.memory.push_back({"film", film->bytes()});
    stats.memory.push_back({"group arenas", frame->arenaBytes()});
    stats.memory.push_back({"texture cache", t.cacheBytes + t.imageBytes});
    stats.memory.push_back({"process (resident)", residentBytes()});
    if (write) {
      written = output->write(*film, metadata(stats.renderSeconds, complete)) && written;
      if (stats.firstPixelSeconds < 0) stats.firstPixelSeconds = since(loadedAt);
      if (!written) return Outcome::CannotWrite;
    }
    return complete ? Outcome::Complete : Outcome::Interrupted;
  } catch (const std::bad_alloc&) {
    diagnostics.error("RENDER-MEMORY", scene.pos, "not enough memory to render", "stopped");
    return Outcome::OutOfMemory;
  }
}

Outcome Renderer::render(const std::function<void(const Progress&)>& progress) { return impl_->run(true, progress); }
Outcome Renderer::renderFilm(const std::function<void(const Progress&)>& progress) { return impl_->run(false, progress); }
film::Film& Renderer::film() { return *impl_->film; }
void Renderer::setHider(const Hider* hider) { impl_->hider = hider; }
const Statistics& Renderer::statistics() const { return impl_->stats; }

bool Renderer::replay(int x, int y, int sample, const std::function<void(const std::string&)>& print) {
  impl_->makeFrame();
  return impl_->frame->replay(x, y, sample, print);
}

bool Renderer::writeShard(const std::string& file) {
  Impl& m = *impl_;
  film::ShardInfo info;
  info.sceneHash = m.hash;
  info.seed = m.settings.seed;
  info.frame = m.scene.frame;
  info.pixelFilter = m.filter.name();
  info.ranges = {{uint32_t(m.firstSample), uint32_t(m.firstSample + m.samplesDone)}};
  info.renderSeconds = m.stats.renderSeconds;
  info.kinoraVersion = kVersion;
  info.outputs = film::outputsToJson(m.plan, m.metadata(m.stats.renderSeconds, true));
  const film::Status s = film::writeShard(file, *m.film, info);
  if (!s.ok()) m.diagnostics.error("FILM-SHARD-WRITE", {}, s.what, "nothing was written");
  return s.ok();
}

std::string Renderer::summary() const {
  const Statistics& s = impl_->stats;
  const auto& c = impl_->builder.camera();
  return std::to_string(c.resolution[0]) + " x " + std::to_string(c.resolution[1]) + " pixels, " +
         std::to_string(impl_->lastSample - impl_->firstSample) + " samples a pixel; " + std::to_string(s.primitives) +
         " primitives, " + std::to_string(s.instances) + " placements, " + std::to_string(s.triangles) + " triangles; " +
         std::to_string(s.lights) + " lights; " + std::to_string(s.materials) + " materials of " + std::to_string(s.programs) + " programs";
}

}  // namespace kinora::render
