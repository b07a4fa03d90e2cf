#include "render/services.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>

#include "render/marked_channels.h"
#include "render/surface_channels.h"
#include "shade/tees.h"
#include "trace/geometry_cache.h"

namespace kinora::render {

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
  trace::GeometryCache::wasCutShort() = false;
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

}  // namespace kinora::render
