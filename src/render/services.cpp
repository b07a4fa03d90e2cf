#include "render/services.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>

#include "render/marked_channels.h"
#include "render/surface_channels.h"
#include "sampling/draw.h"
#include "shade/tees.h"
#include "trace/unread_notes.h"

namespace kinora::render {

bool isReferenceSource(std::string_view source) {
  return source == "__Pref" || source == "__Nref" || source == "__WPref" || source == "__WNref";
}

RecordPlan planRecord(const film::ChannelLayout& layout) {
  RecordPlan p;
  for (const film::RecordEntry& e : layout.record()) {
    std::array<float, 3> remap;
    const std::string source = film::sourceBehind(e.source, remap);
    if (remap[2] > 0) p.remaps.push_back({e.offset, e.width, remap});
    p.sources.push_back(source);
    p.offsets.push_back(e.offset);
    p.widths.push_back(e.width);
    p.splatChannels.emplace_back();
    for (int c = 0; c < layout.size(); ++c)
      if (layout[c].splats && layout[c].source == e.source) p.splatChannels.back().push_back(c);
    const film::SourceInfo* known = film::findSource(source);
    if (source == film::kVisibleFallback) {
      p.cleared.push_back({e.offset, 1});
      if (e.width == 3) p.cleared.push_back({e.offset + 2, 1});
    } else if (!known) {
      if (!film::LightPaths::knows(source)) p.primvars.push_back({source, e.offset, e.width});
    } else if (known->source == film::Source::SampleCount) {
      p.cleared.push_back({e.offset, 1});
    } else if (known->source == film::Source::CpuTime) {
      p.cpuTime.push_back(e.offset);
    } else {
      if (known->source == film::Source::Depth) p.cleared.push_back({e.offset, INFINITY});
      if (known->source == film::Source::Alpha || known->source == film::Source::Opacity)
        for (int k = 0; k < e.width; ++k) p.coverage.push_back(e.offset + k);
      p.surfaces.push_back({known->source, e.offset, e.width, false});
    }
  }
  p.floats = layout.recordFloats();
  return p;
}

void addUserLobes(const film::LightPaths& paths, RecordPlan& plan) {
  static constexpr std::pair<uint32_t, film::Source> kSignals[] = {
      {2, film::Source::Albedo}, {3, film::Source::P}, {6, film::Source::Nn}};
  for (size_t i = 0; i < plan.sources.size(); ++i)
    for (const auto& [lobe, source] : kSignals)
      if (paths.userLobes(i) >> (lobe - 1) & 1)
        plan.surfaces.push_back({source, plan.offsets[i], plan.widths[i], true});
}

// Plain functions for the table: each finds the worker through the group.
struct Worker::Calls {
  static Worker& of(Group* g) { return *static_cast<Worker*>(g->host); }
  static void* alloc(Group* g, size_t bytes) { return of(g).state_.arena().allocate(bytes); }
  static void trace(Group* g, RayList* list, RayKind kind, uint32_t depth, uint32_t n, const uint32_t* slots,
                    float* const t[3]) {
    Worker& w = of(g);
    shade::GroupState& s = w.state_;
    s.trace(*list, kind, depth, n, slots, t);
    if (w.print && list == &g->paths) {
      const uint32_t p = w.printSlot;
      for (uint32_t i = 0; i < n; ++i) {
        if (slots[i] != p) continue;
        char line[512];
        const Rays& r = list->rays;
        if (std::isinf(list->hits.t[p])) {
          std::snprintf(line, sizeof line, "ray %u: from (%.9g %.9g %.9g) along (%.9g %.9g %.9g): escapes", depth,
                        r.o[0][p], r.o[1][p], r.o[2][p], r.d[0][p], r.d[1][p], r.d[2][p]);
        } else {
          const shade::ShadingWorld& sw = s.world();
          const uint32_t placement = sw.world->instance(list->hits.instance[p]).user;
          std::snprintf(
              line, sizeof line,
              "ray %u: from (%.9g %.9g %.9g) along (%.9g %.9g %.9g): hits '%s' (%s) face %u at distance %.9g", depth,
              r.o[0][p], r.o[1][p], r.o[2][p], r.d[0][p], r.d[1][p], r.d[2][p],
              sw.geometries[list->hits.geometry[p]].name.c_str(),
              (sw.placementName ? sw.placementName(placement) : std::string()).c_str(), list->hits.primitive[p],
              list->hits.t[p]);
        }
        w.print(line);
      }
    }
  }
  static uint32_t shade(Group* g, RayList* list, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots,
                        Context* const** contexts) {
    Worker& w = of(g);
    if ((traits & kTraitLightPath) && depth == 0 && !w.emitted_.empty() && list == &g->paths)
      n = w.keepLinked(n, &slots);
    const uint32_t count = w.state_.shade(*list, traits, depth, n, slots, contexts);
    if (list == &g->paths && g->stage == StageKind::CameraPaths && !w.marks_->empty())
      w.marks_->add(depth, count, *contexts, w.state_, w.recordAt_);
    if (w.print && list == &g->paths)
      for (uint32_t c = 0; c < count; ++c)
        for (uint32_t i = 0; i < (*contexts)[c]->count; ++i) {
          const Context& x = *(*contexts)[c];
          if (x.path[i] != w.printSlot) continue;
          char line[512];
          std::snprintf(line, sizeof line, "vertex %u: P (%.9g %.9g %.9g) N (%.9g %.9g %.9g) footprint %.6g %s",
                        depth, x.P[0][i], x.P[1][i], x.P[2][i], x.N[0][i], x.N[1][i], x.N[2][i], x.radius[i],
                        x.entering[i] ? "from outside" : "from inside");
          w.print(line);
        }
    return count;
  }
  static RayList* makeRays(Group* g, uint32_t capacity) { return of(g).state_.makeRays(capacity); }
  static void leave(Group* g, RayList* list, const Context* c, uint32_t n, const uint32_t* points,
                    const uint32_t* entries, const uint32_t* through) {
    of(g).state_.leave(*list, c, n, points, entries, through);
  }
  static void keepVertices(Group* g, const Context* c, uint32_t n, const uint32_t* points, VertexRecord* out) {
    of(g).state_.keepVertices(c, n, points, out);
  }
  static uint32_t shadeVertices(Group* g, uint32_t n, const VertexRecord* records, Context* const** contexts) {
    return of(g).state_.shadeVertices(n, records, contexts);
  }
  static uint32_t makeVertices(Group* g, uint32_t n, const SurfacePlaces* places, VertexRecord* out,
                               uint32_t* which) {
    return of(g).state_.makeVertices(n, *places, out, which);
  }
  static void hitsOnObject(Group* g, const Context* c, uint32_t n, const uint32_t* points, const Rays* rays,
                           ObjectHits* out) {
    of(g).state_.hitsOnObject(c, n, points, *rays, out);
  }
  static void freeRegions(Group* g, const Context* c, uint32_t n, const uint32_t* points, const float* const P[3],
                          const float* reach, FreeRegions* out) {
    of(g).state_.freeRegions(c, n, points, P, reach, out);
  }
  static void noteBelow(Group* g, const Context* c, uint32_t n, const uint32_t* points, BelowSurface what) {
    of(g).state_.noteBelow(c, n, points, what);
  }
  static MemoryMark markMemory(Group* g) {
    const Arena::Mark m = of(g).state_.arena().mark();
    return {m.block, m.used};
  }
  static void releaseMemory(Group* g, MemoryMark m) {
    of(g).state_.arena().release({size_t(m.block), size_t(m.used)});
  }
  static void lightSamples(Group* g, const Context* c, uint32_t part, uint32_t parts, LightSamples* out) {
    of(g).state_.lightSamples(c, part, parts, out);
  }
  static void ownLightSamples(Group* g, const Context* c, uint32_t light, uint32_t part, uint32_t parts,
                              LightSamples* out) {
    of(g).state_.lightSamples(c, part, parts, out, light);
  }
  static void scatterTowardsLights(Group* g, RayList* list, uint32_t depth, uint32_t part, uint32_t parts, uint32_t n,
                                   const uint32_t* slots, TowardsLights* out) {
    of(g).state_.scatterTowardsLights(*list, depth, part, parts, n, slots, out);
  }
  static void meanTransmittance(Group* g, uint32_t n, const float* const o[3], const float* const d[3],
                                const float* length, const float* time, float* out) {
    of(g).state_.meanTransmittance(n, o, d, length, time, out);
  }
  static void mediumIntervals(Group* g, const RayList* list, uint32_t n, const uint32_t* entries,
                              MediumIntervals* out) {
    of(g).state_.mediumIntervals(*list, n, entries, out);
  }
  static void mediaAt(Group* g, const RayList* list, uint32_t depth, uint32_t n, const uint32_t* entries,
                      const float* t, MediaAt* out) {
    of(g).state_.mediaAt(*list, depth, n, entries, t, out);
  }
  static void lightHits(Group* g, RayList* list, RayKind kind, uint32_t n, const uint32_t* slots, LightHits* out) {
    of(g).state_.lightHits(*list, kind, n, slots, out);
  }
  static void lightsBeyond(Group* g, RayList* list, uint32_t n, const uint32_t* slots, LightHits* out) {
    of(g).state_.lightsBeyond(*list, n, slots, out);
  }
  static void lightsAlong(Group* g, RayList* list, uint32_t n, const uint32_t* slots, LightHits* out) {
    of(g).state_.lightsAlong(*list, n, slots, out);
  }
  static void shadow(Group* g, uint32_t depth, const ShadowRays* rays) { of(g).state_.shadow(depth, rays); }
  static void contribute(Group* g, const Contributions* c) { of(g).contribute(c); }
  static void cover(Group* g, uint32_t n, const uint32_t* slots, const float* alpha) {
    Worker& w = of(g);
    for (const int offset : w.plan_.coverage) {
      float* r = w.record(size_t(offset));
      for (uint32_t i = 0; i < n; ++i) r[slots[i]] = alpha[i];
    }
  }
  static void emitLight(Group* g, uint32_t n, EmittedLight* out) { of(g).emitLight(n, out); }
  static void lightEnds(Group* g, LightEnds* ends) { of(g).state_.lightEnds(ends); }
  static void connectCamera(Group* g, const Context* c, CameraConnection* out) { of(g).connectCamera(c, out); }
  static void splat(Group* g, uint32_t n, const float* const raster[2], const float* const value[3],
                    const uint32_t* state, const uint32_t* light) {
    of(g).splat(n, raster, value, state, light);
  }
  static Context* pointsInSpace(Group* g, RayList* list, uint32_t traits, uint32_t depth, uint32_t n,
                                const uint32_t* slots, const float* t) {
    return of(g).state_.pointsInSpace(*list, traits, depth, n, slots, t);
  }
  static void append(Group* g, uint32_t list, uint32_t n, const uint32_t* slots, const void* records) {
    Worker& w = of(g);
    if (w.store) w.store->append(w.index, list, n, slots, g->number, g->paths.sampleIndex, records);
  }
  static StoredRecords stored(Group* g, uint32_t list) {
    Worker& w = of(g);
    return w.store ? w.store->stored(list) : StoredRecords{};
  }
  static void findStored(Group* g, uint32_t list, uint32_t n, const uint64_t* paths, const uint32_t* samples,
                         uint64_t* first, uint32_t* count) {
    Worker& w = of(g);
    if (w.store) return w.store->find(list, n, paths, samples, first, count);
    for (uint32_t i = 0; i < n; ++i) {
      first[i] = 0;
      count[i] = 0;
    }
  }
  static void traceWalks(Group* g, RayList* list, uint32_t depth, uint32_t n, const uint32_t* entries) {
    of(g).state_.traceWalks(*list, depth, n, entries);
  }
  static void walkTargets(Group* g, uint32_t n, const float* const u[5], const float* time, WalkTargets* out) {
    of(g).state_.walkTargets(n, u, time, out);
  }
  static void deltaLights(Group* g, const RayList* list, uint32_t n, const uint32_t* entries, const uint32_t* light,
                          float* const radiance[3], float* specular) {
    of(g).state_.deltaLights(*list, n, entries, light, radiance, specular);
  }
  static void noteWalks(Group* g, const WalkNote* note) { of(g).noteWalks(*note); }
  static const void* index(Group* g) { return of(g).store ? of(g).store->index() : nullptr; }
  static void weighLights(Group* g, const Context* c, const uint32_t* rows) { of(g).state_.weighLights(c, rows); }
  static void teach(Group* g, uint32_t n, const uint32_t* slots, const void* records) {
    Worker& w = of(g);
    if (!w.learned || !g->teaches) return;
    const size_t bytes = w.learned->recordBytes();
    const auto* at = static_cast<const std::byte*>(records);
    // runs of slots that teach: what others leave is dropped
    for (uint32_t first = 0, end; first < n; first = end) {
      const bool teaches = g->teaches[slots[first]];
      for (end = first + 1; end < n && bool(g->teaches[slots[end]]) == teaches;) ++end;
      if (teaches)
        w.learned->add(w.index, end - first, slots + first, g->number, g->paths.sampleIndex, at + first * bytes);
    }
  }
  static const void* learned(Group* g) { return of(g).learned ? of(g).learned->state() : nullptr; }
  static uint16_t event(Group* g, uint32_t type, uint32_t lobe) { return of(g).paths_.event(type | lobe); }
};

Worker::Worker(const shade::ShadingWorld& world, const CameraState& camera, const RecordPlan& plan,
               const film::LightPaths& paths, film::Film& film, const film::SplatFilter& splatFilter,
               uint64_t lightPathsPerPass)
    : state_(world),
      camera_(camera),
      plan_(plan),
      paths_(paths),
      film_(film),
      splatFilter_(&splatFilter),
      lightPathsPerPass_(lightPathsPerPass) {
  for (const shade::PlacementInfo& p : world.placements) hasTolerances_ |= p.noiseTolerance != 1;
  Services& s = services_;
  s.host = this;
  s.samples = world.samples;
  s.paths = paths.states();
  for (int c = 0; c < 3; ++c) s.worldCenter[c] = world.world->center()[c];
  s.worldRadius = world.world->radius();
  s.lightCount = world.lights->size();
  s.hasMedia = world.hasMedia || world.space;
  s.hasTintedShadows = world.hasTintedShadows;
  s.wantsUnshadowed = paths.wantsUnshadowed();
  s.alloc = &Calls::alloc;
  s.trace = &Calls::trace;
  s.shade = &Calls::shade;
  s.markMemory = &Calls::markMemory;
  s.releaseMemory = &Calls::releaseMemory;
  s.lightSamples = &Calls::lightSamples;
  s.ownLightSamples = &Calls::ownLightSamples;
  s.scatterTowardsLights = &Calls::scatterTowardsLights;
  s.mediumIntervals = &Calls::mediumIntervals;
  s.mediaAt = &Calls::mediaAt;
  s.meanTransmittance = &Calls::meanTransmittance;
  s.lightHits = &Calls::lightHits;
  s.lightsBeyond = &Calls::lightsBeyond;
  s.lightsAlong = &Calls::lightsAlong;
  s.shadow = &Calls::shadow;
  s.contribute = &Calls::contribute;
  s.cover = &Calls::cover;
  s.makeRays = &Calls::makeRays;
  s.leave = &Calls::leave;
  s.keepVertices = &Calls::keepVertices;
  s.shadeVertices = &Calls::shadeVertices;
  s.makeVertices = &Calls::makeVertices;
  s.hitsOnObject = &Calls::hitsOnObject;
  s.freeRegions = &Calls::freeRegions;
  s.noteBelow = &Calls::noteBelow;
  s.emitLight = &Calls::emitLight;
  s.lightEnds = &Calls::lightEnds;
  s.connectCamera = &Calls::connectCamera;
  s.splat = &Calls::splat;
  s.event = &Calls::event;
  s.pointsInSpace = &Calls::pointsInSpace;
  s.append = &Calls::append;
  s.stored = &Calls::stored;
  s.findStored = &Calls::findStored;
  s.index = &Calls::index;
  s.teach = &Calls::teach;
  s.learned = &Calls::learned;
  s.weighLights = &Calls::weighLights;
  s.traceWalks = &Calls::traceWalks;
  s.walkTargets = &Calls::walkTargets;
  s.deltaLights = &Calls::deltaLights;
  s.noteWalks = &Calls::noteWalks;
  for (int c = 0; c < 2; ++c) s.resolution[c] = camera.resolution[c];
  const float eye[3] = {0, 0, 0};
  camera.toRender[camera.toRender.size() / 2].point(eye, s.cameraCenter);
  s.pixelSize = float(camera.pixelSize);
  s.pixelAngle = float(camera.pixelAngle);
  bool isWalkedTo = false, areExceptions = false;
  for (uint32_t i = 0; i < world.lights->size(); ++i) {
    ends_.push_back(uint16_t(world.lights->groupOf(i)));
    walkedTo_.push_back(world.lights->isWalkedTo(i));
    isWalkedTo = isWalkedTo || walkedTo_.back();
    exceptions_.push_back(world.lights->exceptionsOf(i));
    areExceptions = areExceptions || exceptions_.back();
  }
  s.walkBoundCount = isWalkedTo ? uint32_t(world.walkBounds.size()) : 0;
  s.walkBounds = world.walkBounds.data();
  s.lightWalks = walkedTo_.data();
  s.lightExceptions = areExceptions ? exceptions_.data() : nullptr;
  s.hasShadowControls = world.lights->hasShadowControls();
  s.ownSampleCount = uint32_t(world.lights->ownSamples().size());
  s.ownSamples = world.lights->ownSamples().data();
  endCount_ = paths.ends();
  perKind_ = paths.stateCount() * endCount_;
  // what each kind of light adds to light as it arrives, unoccluded, and blocked (the difference of the two)
  static constexpr float kSigns[3][3] = {{1, 1, 0}, {1, 0, -1}, {0, 1, 1}};
  std::map<std::vector<std::pair<int, float>>, uint16_t> sets;
  for (const auto& signs : kSigns)
    for (uint32_t state = 0; state < paths.stateCount(); ++state)
      for (uint32_t end = 0; end < endCount_; ++end) {
        std::vector<std::pair<int, float>> targets;
        for (const uint16_t o : paths.outputs(state, end))
          if (const float sign = signs[size_t(paths.light(o))]; sign != 0)
            targets.emplace_back(plan.offsets[o], sign);
        const auto [it, isNew] = sets.try_emplace(targets, uint16_t(sets.size()));
        setOf_.push_back(it->second);
        if (!isNew) continue;
        first_.push_back(uint32_t(targets_.size()));
        for (const auto& [offset, sign] : targets) targets_.push_back({offset, sign});
      }
  first_.push_back(uint32_t(targets_.size()));
  for (size_t o = 0; o < plan.splatChannels.size(); ++o)
    for (const int channel : plan.splatChannels[o]) {
      splatChannels_.push_back(channel);
      for (uint32_t state = 0; state < paths.stateCount(); ++state)
        for (uint32_t end = 0; end < endCount_; ++end) {
          const auto& list = paths.outputs(state, end);
          takesSplat_.push_back(std::find(list.begin(), list.end(), uint16_t(o)) != list.end() &&
                                paths.light(o) != film::PathLight::Blocked);
        }
    }
  state_.onPrimary = [this](const Context* c) { primary(c); };
  marks_ = std::make_unique<MarkedChannels>(plan, world);
  recordAt_ = [this](int k) { return record(size_t(k)); };
}

Worker::~Worker() = default;

void Worker::scatterInMedia(bool scatters) {
  state_.scattersInMedia = scatters;
  services_.mediaScatter = scatters && state_.world().space;
}

void Worker::begin(uint32_t count, StageKind stage) {
  state_.begin(count, stage);
  emitted_.clear();
  state_.group().host = this;
  const uint32_t n = state_.group().padded + kPad;
  recordBytes_ = n * sizeof(float);
  if (zeros_.size() < n) zeros_.assign(n, 0.f);
  records_.resize(size_t(plan_.floats));
  for (float*& r : records_) r = state_.arena().make<float>(n);
  isWritten_.assign(records_.size(), 0);
  if (hasTolerances_) {
    tolerances_ = state_.arena().make<float>(n);
    std::fill_n(tolerances_, n, 1.f);
  }
  for (const auto& [offset, value] : plan_.cleared) {
    std::fill_n(records_[size_t(offset)], n, value);
    isWritten_[size_t(offset)] = 1;
  }
}

void Worker::beginTry() {
  try_.isOpen = state_.world().world->unread() != nullptr;
  trace::UnreadNotes::ofThread() = {};
  if (!try_.isOpen) return;
  try_.notes = trace::UnreadBounds::notesOfThread();
  try_.met.assign((state_.world().world->unread()->size() + 63) / 64, 0);
  trace::UnreadNotes::ofThread() = {try_.met.data(), try_.met.size()};
  try_.counters = state_.counters;
  try_.lightRays = lightRays;
  try_.splats.clear();
  if (store) store->mark(index, try_.records);
  if (learned) try_.lessons = learned->mark(index);
}

void Worker::beginLook() {
  beginTry();
  if (try_.isOpen) return;
  try_.isOpen = true;
  try_.counters = state_.counters;
  try_.lightRays = lightRays;
  try_.splats.clear();
}

void Worker::endLook() {
  try_.isOpen = false;
  trace::UnreadNotes::ofThread() = {};
  try_.splats.clear();
  state_.counters = try_.counters;
  lightRays = try_.lightRays;
}

bool Worker::keepTry() {
  if (!try_.isOpen) return true;
  try_.isOpen = false;
  trace::UnreadNotes::ofThread() = {};
  if (trace::UnreadBounds::notesOfThread() != try_.notes) {
    const auto spent = std::to_array(state_.counters.nanoseconds);
    state_.counters = try_.counters;
    std::copy(spent.begin(), spent.end(), state_.counters.nanoseconds);
    lightRays = try_.lightRays;
    if (store) store->cut(index, try_.records);
    if (learned) learned->cut(index, try_.lessons);
    return false;
  }
  for (const Try::Splat& s : try_.splats) {
    const float* const values[3] = {&s.value[0], &s.value[1], &s.value[2]};
    const uint32_t first = 0;
    film_.splat({1, s.channel, &s.x, &s.y, &first, values});
  }
  return true;
}

std::vector<uint32_t> Worker::metUnread() const {
  std::vector<uint32_t> out;
  for (uint32_t w = 0; w < try_.met.size(); ++w)
    for (uint64_t bits = try_.met[w]; bits; bits &= bits - 1)
      out.push_back(64 * w + uint32_t(std::countr_zero(bits)));
  return out;
}

const float* const* Worker::values() {
  values_.resize(records_.size());
  for (size_t k = 0; k < records_.size(); ++k) values_[k] = isWritten_[k] ? records_[k] : zeros_.data();
  return values_.data();
}

void Worker::primary(const Context* c) {
  SurfaceChannels values(c, state_, camera_);
  for (const RecordPlan::Surface& o : plan_.surfaces) {
    const SurfaceChannels::Value v = values.of(o.source);
    for (int k = 0; k < std::min(o.width, 3); ++k) {
      if (!v.data[k]) continue;
      float* r = record(size_t(o.offset + k));
      if (o.adds)
        for (uint32_t i = 0; i < c->count; ++i) r[c->path[i]] += v.data[k][i * v.stride];
      else
        for (uint32_t i = 0; i < c->count; ++i) r[c->path[i]] = v.data[k][i * v.stride];
    }
  }
  for (uint32_t i = 0; tolerances_ && i < c->count; ++i) {
    const shade::ShadingWorld& w = state_.world();
    tolerances_[c->path[i]] = w.placementOf(c->place.instance[i], c->place.geometry[i]).noiseTolerance;
  }
  for (const RecordPlan::Primvar& o : plan_.primvars) {
    Value v = shade::teeValue(c, o.name);
    if (!v.components) v = c->fn->primvar(c, o.name.c_str(), nullptr);
    if (!v.components && isReferenceSource(o.name)) v = c->fn->primvar(c, o.name.c_str() + 2, nullptr);
    for (int k = 0; k < std::min(o.width, int(v.components)); ++k) {
      float* r = record(size_t(o.offset + k));
      for (uint32_t i = 0; i < c->count; ++i) r[c->path[i]] = v.data[k][i * v.stride];
    }
  }
}

void Worker::setCpuTime(uint32_t count, float secondsASample) {
  for (const int offset : plan_.cpuTime) std::fill_n(record(size_t(offset)), count, secondsASample);
}

void Worker::finishRecords(uint32_t count) {
  for (const auto& [offset, width, remap] : plan_.remaps)
    for (int k = 0; k < width; ++k) {
      float* r = record(size_t(offset + k));
      for (uint32_t i = 0; i < count; ++i) r[i] = film::compress(r[i], remap);
    }
}

void Worker::contribute(const Contributions* c) {
  // runs that go to the same outputs, which often are the whole list: record by record
  const uint16_t* const setOf = setOf_.data() + uint32_t(c->kind) * perKind_;
  const auto set = [&](uint32_t i) { return setOf[c->state[i] * endCount_ + endOf(c->light[i])]; };
  for (uint32_t first = 0, end; first < c->count; first = end) {
    const uint16_t which = set(first);
    for (end = first + 1; end < c->count && set(end) == which;) ++end;
    for (uint32_t t = first_[which]; t < first_[which + 1]; ++t)
      for (size_t k = 0; k < 3; ++k) {
        float* const to = record(size_t(targets_[t].offset) + k);
        const float sign = targets_[t].sign;
        const float* value = c->value[k];
        for (uint32_t i = first; i < end; ++i) to[c->slot[i]] += sign * value[i];
      }
  }
  if (print && c->kind != LightKind::Unshadowed)
    for (uint32_t i = 0; i < c->count; ++i) {
      if (c->slot[i] != printSlot) continue;
      char line[256];
      if (c->light[i] == kNoLight)
        std::snprintf(line, sizeof line, "contribution: (%.9g %.9g %.9g) emitted by the surface, state %u",
                      c->value[0][i], c->value[1][i], c->value[2][i], c->state[i]);
      else
        std::snprintf(line, sizeof line, "contribution: (%.9g %.9g %.9g) from light %u, state %u", c->value[0][i],
                      c->value[1][i], c->value[2][i], c->light[i], c->state[i]);
      print(line);
    }
}

void Worker::noteWalks(const WalkNote& note) {
  shade::GroupCounters& c = state_.counters;
  for (uint32_t i = 0; i < note.count; ++i) {
    ++c.walksBegun;
    c.walksFound += note.interfaces[i] != 0;
    c.walkTrials += note.trials[i];
    if (!print || note.slot[i] != printSlot) continue;
    char line[512];
    int at = 0;
    if (note.interfaces[i])
      at = std::snprintf(line, sizeof line, "walk: along (%.9g %.9g %.9g) through %u interfaces", note.d[0][i],
                         note.d[1][i], note.d[2][i], note.interfaces[i]);
    else
      at = std::snprintf(line, sizeof line, "walk: no path found");
    if (note.interfaces[i] && note.trials[i])
      at += std::snprintf(line + at, sizeof line - size_t(at), ", found again after %u trials", note.trials[i]);
    if (note.interfaces[i])
      std::snprintf(line + at, sizeof line - size_t(at), ", brings (%.9g %.9g %.9g)", note.value[0][i],
                    note.value[1][i], note.value[2][i]);
    print(line);
  }
}

void Worker::emitLight(uint32_t n, EmittedLight* out) {
  Arena& arena = state_.arena();
  const uint32_t m = padded(n);
  float* u[6];
  for (float*& x : u) x = arena.make<float>(m);
  const DrawSpan draw = drawSpan(state_.world().width);
  const Group& g = state_.group();
  draw(services_.samples, m, g.paths.sampleSeed, g.paths.sampleIndex, kDimFilter | kOwnIndex, u[0], u[5]);
  draw(services_.samples, m, g.paths.sampleSeed, g.paths.sampleIndex, kDimLens | kOwnIndex, u[1], u[2]);
  draw(services_.samples, m, g.paths.sampleSeed, g.paths.sampleIndex, (kDimLens + 3) | kOwnIndex, u[3], u[4]);
  const float* four[4] = {u[1], u[2], u[3], u[4]};
  state_.world().lights->emit(state_.world().width, arena, n, u[0], four, g.paths.rays.time, g.paths.rays.o,
                              g.paths.rays.d, out);
  for (uint32_t i = 0; i < n; ++i) {
    g.paths.rays.tMax[i] = 1e30f;
    g.paths.rays.radius[i] = 0;
    g.paths.rays.spread[i] = 0;
  }
  lightRays += n;
  emitted_.assign(out->light, out->light + n);
}

// A light that is not linked to the surface or medium that its path meets first does not light it: the path ends there.
uint32_t Worker::keepLinked(uint32_t n, const uint32_t** slots) {
  const shade::ShadingWorld& w = state_.world();
  const Hits& hits = state_.group().paths.hits;
  uint32_t* kept = state_.arena().make<uint32_t>(padded(n + 1));
  uint32_t m = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = (*slots)[i], light = emitted_[s];
    const uint32_t set = w.placementOf(hits.instance[s], hits.geometry[s]).linkSet;
    kept[m] = s;
    m += light == kNoLight || w.lights->isLinked(set, light);
  }
  *slots = kept;
  return m;
}

bool Worker::isHidden(uint32_t instance, uint32_t geometry) const {
  const shade::ShadingWorld& w = state_.world();
  const shade::PlacementInfo& p = w.placementOf(instance, geometry);
  return p.isHiddenFromCamera || p.hole;
}

void Worker::connectCamera(const Context* c, CameraConnection* out) {
  Arena& arena = state_.arena();
  const uint32_t m = c->padded;
  float* x[16];
  for (float*& y : x) y = arena.make<float>(m);
  const DrawSpan draw = drawSpan(state_.world().width);
  // back to where a camera ray left the lens, or to anywhere on it
  const bool isBack = c->traits & kTraitPrimaryHit;
  draw(services_.samples, m, c->sampleSeed, c->sampleIndex, isBack ? kDimLens : dimensionAt(c->depth) + kDimUser,
       x[3], x[4]);
  uint8_t* cut = camera_.cuts.empty() ? nullptr : arena.make<uint8_t>(m);
  const auto at = [&](const std::vector<trace::Affine>& keys, float time) {
    if (keys.size() == 1) return keys[0];
    const float f = time * float(keys.size() - 1);
    const size_t k = std::min(size_t(f), keys.size() - 2);
    trace::Affine a = keys[k];
    const float w = f - float(k);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) a.m[i][j] += w * (keys[k + 1].m[i][j] - a.m[i][j]);
      a.t[i] += w * (keys[k + 1].t[i] - a.t[i]);
    }
    return a;
  };
  for (uint32_t i = 0; i < m; ++i) {
    const float p[3] = {c->P[0][i], c->P[1][i], c->P[2][i]};
    float q[3];
    at(camera_.fromRender, c->time[i]).point(p, q);
    for (int k = 0; k < 3; ++k) x[k][i] = q[k];
    if (cut) cut[i] = cutAway(camera_.cuts, q);
  }
  const CameraConnectArgs a{c->count,           {x[0], x[1], x[2]}, {x[3], x[4]}, c->time,
                            {x[5], x[6], x[7]}, {x[8], x[9]},       x[10],        x[11]};
  camera_.functions->connect(camera_.projection.data(), &a);
  for (uint32_t i = 0; i < m; ++i) {
    const float p[3] = {x[5][i], x[6][i], x[7][i]};
    if (cut && cut[i]) x[10][i] = 0;
    float begin = 0, end = 1;  // of the way from the lens
    if (cut) {
      const float way[3] = {x[0][i] - p[0], x[1][i] - p[1], x[2][i] - p[2]};
      cutRay(camera_.cuts, p, way, begin, end);
    }
    if (c->place.instance && isHidden(c->place.instance[i], c->place.geometry[i])) x[10][i] = 0;
    float q[3];
    at(camera_.toRender, c->time[i]).point(p, q);
    float d2 = 0, d[3];
    for (int k = 0; k < 3; ++k) {
      d[k] = q[k] - c->P[k][i];
      d2 += d[k] * d[k];
    }
    const float length = std::sqrt(d2), inv = length > 0 ? 1.f / length : 0.f;
    for (int k = 0; k < 3; ++k) x[12 + k][i] = d[k] * inv;
    x[0][i] = length;
    x[15][i] = std::min(begin, 1.f) * length;
    // of paths at this time, where the pixel that will get their light is open
    if (camera_.rolling.rolls() && x[10][i] > 0) {
      const film::SplatFilter::Pixel p = splatFilter_->choose(x[8][i], x[9][i]);
      x[10][i] *= camera_.rolling.share(p.x, p.y, c->time[i]);
    }
  }
  *out = CameraConnection{{x[12], x[13], x[14]}, x[0], x[10], x[11], {x[8], x[9]}, x[15]};
}

void Worker::splat(uint32_t n, const float* const raster[2], const float* const value[3], const uint32_t* state,
                   const uint32_t* light) {
  Arena& arena = state_.arena();
  const ArenaScope memory(arena);
  int32_t *px = arena.make<int32_t>(padded(n)), *py = arena.make<int32_t>(padded(n));
  uint32_t* index = arena.make<uint32_t>(padded(n));
  float* v[3];
  for (float*& x : v) x = arena.make<float>(padded(n));
  const float scale = 1.f / float(lightPathsPerPass_ ? lightPathsPerPass_ : 1);
  float* share = arena.make<float>(padded(n));
  int32_t *column = arena.make<int32_t>(padded(n)), *row = arena.make<int32_t>(padded(n));
  for (uint32_t i = 0; i < n; ++i) {
    const film::SplatFilter::Pixel p = splatFilter_->choose(raster[0][i], raster[1][i]);
    column[i] = p.x;
    row[i] = p.y;
    share[i] = p.weight * scale;
  }
  // channel by channel; states differ by path
  for (size_t k = 0; k < splatChannels_.size(); ++k) {
    const uint8_t* takes = takesSplat_.data() + k * perKind_;
    int m = 0;
    for (uint32_t i = 0; i < n; ++i) {
      if (!takes[state[i] * endCount_ + (light ? endOf(light[i]) : 1)]) continue;
      px[m] = column[i];
      py[m] = row[i];
      index[m] = i;
      for (int c = 0; c < 3; ++c) v[c][m] = value[c][i] * share[i];
      ++m;
    }
    if (m && try_.isOpen) {
      for (int i = 0; i < m; ++i)
        try_.splats.push_back({splatChannels_[k], px[i], py[i], {v[0][i], v[1][i], v[2][i]}});
      continue;
    }
    if (m) film_.splat({m, splatChannels_[k], px, py, index, v});
  }
}

}  // namespace kinora::render
