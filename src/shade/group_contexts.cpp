// Hits become shading contexts: counting sort by program, points and normals in render space, room for the network.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/clock.h"
#include "shade/context_host.h"
#include "shade/points.h"

namespace kinora::shade {

namespace {

// What is stored at the corners of the triangles hit lies all over memory: it is on its way before a kernel waits for
// it point by point. First where the corners are, then, when that has arrived, what they have.
class CornerFetch {
 public:
  CornerFetch(const SurfaceTables& tables, const Hits& hits, uint32_t n, const uint32_t* entries)
      : tables_(tables), hits_(hits), n_(n), entries_(entries) {
    for (uint32_t i = 0; i < n_; ++i) __builtin_prefetch(cornersOf(entries_[i], viewOf(entries_[i])));
  }
  void values() const {
    constexpr int kToRead = 0, kKeep = 2;  // in the second cache: a group's values are more than the first one holds
    for (uint32_t i = 0; i < n_; ++i) {
      const MeshView& m = viewOf(entries_[i]);
      if (!m.points) continue;  // strands
      const uint32_t* corners = cornersOf(entries_[i], m);
      for (int k = 0; k < 3; ++k) {
        if (m.normals && m.rateOfNormals == geometry::Primvar::Rate::PerVertex)
          __builtin_prefetch(m.normals + 3 * size_t(corners[k]), kToRead, kKeep);
        __builtin_prefetch(m.points + corners[k], kToRead, kKeep);
        if (m.st) __builtin_prefetch(m.st + 2 * size_t(corners[k]), kToRead, kKeep);
      }
    }
  }

 private:
  const MeshView& viewOf(uint32_t entry) const { return tables_.meshes[hits_.geometry[entry]]; }
  const uint32_t* cornersOf(uint32_t entry, const MeshView& m) const {
    return m.indices + 3 * size_t(hits_.primitive[entry]);
  }
  const SurfaceTables& tables_;
  const Hits& hits_;
  uint32_t n_;
  const uint32_t* entries_;
};

}  // namespace

uint32_t GroupState::shade(RayList& rays, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* entries,
                           Context* const** contexts) {
  *contexts = nullptr;
  if (!n) return 0;
  const bool query = traits & kTraitPresenceQuery;
  uint64_t unused = 0;  // queries happen inside the time of tracing
  const Clock clock(query ? unused : counters.nanoseconds[kTimeGrouping]);
  const CornerFetch fetch(world_.tables, rays.hits, n, entries);
  // Counting sort by program; within a program the order of the list stays.
  uint32_t* programOf = arena_.make<uint32_t>(padded(n));
  const ProgramsArgs programsArgs{n, entries, rays.hits.instance, rays.hits.geometry, &world_.tables, programOf};
  programsKernel(world_.width)(programsArgs);
  touched_.clear();
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = programOf[i];
    if (!countOfProgram_[p]++) touched_.push_back(p);
  }
  std::sort(touched_.begin(), touched_.end());
  uint32_t* order = arena_.make<uint32_t>(n);
  uint32_t* first = arena_.make<uint32_t>(touched_.size() + 1);
  uint32_t sum = 0;
  for (size_t k = 0; k < touched_.size(); ++k) {
    first[k] = sum;
    const uint32_t c = countOfProgram_[touched_[k]];
    countOfProgram_[touched_[k]] = sum;  // cursor
    sum += c;
  }
  first[touched_.size()] = sum;
  for (uint32_t i = 0; i < n; ++i) order[countOfProgram_[programOf[i]]++] = entries[i];
  fetch.values();
  const uint32_t count = uint32_t(touched_.size());
  Context** list = arena_.make<Context*>(count);
  uint32_t* programs = arena_.make<uint32_t>(count);
  for (uint32_t k = 0; k < count; ++k) {
    programs[k] = touched_[k];
    countOfProgram_[touched_[k]] = 0;
  }
  for (uint32_t k = 0; k < count; ++k)
    list[k] = makeContext(rays, programs[k], traits, depth, first[k + 1] - first[k], order + first[k], !query);
  for (uint32_t k = 0; k < count; ++k) countLanes(traits, depth, list[k]->count);
  if (!query && (traits & kTraitPrimaryHit) && onPrimary)
    for (uint32_t k = 0; k < count; ++k) onPrimary(list[k]);
  *contexts = list;
  return count;
}

// A context of the listed entries with room for its points, and what the kernel of points reads of the list and
// writes there. The distances, normals and sides are the caller's.
PointsArgs GroupState::startContext(const RayList& list, uint32_t traits, uint32_t depth, uint32_t n,
                                    const uint32_t* entries, Context*& c) {
  const uint32_t m = padded(n);
  const auto f = [&] { return arena_.make<float>(m); };
  const auto u = [&] { return arena_.make<uint32_t>(m); };
  uint32_t* path = u();
  std::memcpy(path, entries, n * sizeof(uint32_t));
  for (uint32_t i = n; i < m; ++i) path[i] = entries[n - 1];
  c = new (arena_.allocate(sizeof(Context))) Context();
  ContextHost* h = new (arena_.allocate(sizeof(ContextHost))) ContextHost();
  h->born = arena_.now();
  h->group = this;
  h->rayKind = ListHost::of(list).kind;
  c->count = n;
  c->padded = m;
  c->width = world_.width;
  c->traits = traits;
  c->path = path;
  c->samples = &world_.samples;
  c->depth = depth;
  c->fn = &kContextFunctions;
  c->host = h;
  PointsArgs a{};
  a.n = m;
  a.slots = path;
  const Rays& r = list.rays;
  for (int k = 0; k < 3; ++k) {
    a.o[k] = r.o[k];
    a.d[k] = r.d[k];
    c->P[k] = a.P[k] = f();
    c->N[k] = a.N[k] = f();
    c->Ng[k] = a.Ng[k] = f();
    c->wo[k] = a.wo[k] = f();
  }
  a.radius = r.radius;
  a.spread = r.spread;
  a.time = r.time;
  a.seed = list.sampleSeed;
  a.index = list.sampleIndex;
  a.isRecord = ListHost::of(list).reach != nullptr;
  c->radius = a.outRadius = f();
  c->spread = a.outSpread = f();
  c->time = a.outTime = f();
  c->bias = a.bias = f();
  c->entering = a.entering = u();
  c->sampleSeed = a.outSeed = u();
  c->sampleIndex = a.outIndex = u();
  return a;
}

// What the kernel of places reads of a list and writes for a context's points; distances, times and origins are the
// caller's to place. t: by entry.
SurfacesArgs GroupState::placesOf(const RayList& list, const float* t, Context* c) {
  const auto f = [&] { return arena_.make<float>(c->padded); };
  const auto u = [&] { return arena_.make<uint32_t>(c->padded); };
  const Hits& hits = list.hits;
  SurfacesArgs s{};
  s.n = c->padded;
  s.slots = c->path;
  s.instance = hits.instance;
  s.geometry = hits.geometry;
  s.primitive = hits.primitive;
  s.level = hits.level;
  s.u = hits.u;
  s.v = hits.v;
  s.t = t;
  for (int k = 0; k < 3; ++k) s.ng[k] = hits.ng[k];
  s.time = list.rays.time;
  s.origin = list.origin;
  s.tables = &world_.tables;
  s.block = u();
  s.side = f();
  ContextHost& h = ContextHost::of(c);
  for (int k = 0; k < 3; ++k) h.ng[k] = s.outNg[k] = f();
  c->place.instance = s.outInstance = u();
  c->place.geometry = s.outGeometry = u();
  c->place.primitive = s.outPrimitive = u();
  c->place.level = s.outLevel = u();
  c->place.u = s.outU = f();
  c->place.v = s.outV = f();
  return s;
}

Context* GroupState::makeContext(const RayList& list, uint32_t programIndex, uint32_t traits, uint32_t depth,
                                 uint32_t n, const uint32_t* entries, bool bind) {
  const Program& program = world_.materials->program(programIndex);
  if (program.fillsSpace) return makeMediumContext(list, programIndex, traits, depth, n, entries, bind);
  const trace::World& w = *world_.world;
  Context* c;
  PointsArgs a = startContext(list, traits, depth, n, entries, c);
  const uint32_t m = c->padded;
  const uint32_t* path = c->path;
  ContextHost* h = static_cast<ContextHost*>(c->host);
  h->program = &program;
  const Hits& hits = list.hits;
  const ListHost& from = ListHost::of(list);
  const auto f = [&] { return arena_.make<float>(m); };
  const auto u = [&] { return arena_.make<uint32_t>(m); };
  VertexState& state = h->state;
  state = makeState(m);
  // the vertex: where it lies, and how its ray came
  SurfacesArgs s = placesOf(list, from.reach ? from.reach : hits.t, c);
  s.linkSet = state.linkSet;
  uint32_t* block = s.block;
  const float* const* raw = h->ng;
  c->distance = s.outT = f();
  s.outTime = a.outTime;
  h->origin = s.outOrigin = u();
  surfacesKernel(world_.width)(s);
  if (state.linkSet) {
    if (from.reach)  // the record knows
      for (uint32_t i = 0; i < m; ++i) state.linkSet[i] = from.left.linkSet[path[i]];
    else if (const uint32_t indirect = depth > 0 ? world_.indirectSets : 0)
      for (uint32_t i = 0; i < m; ++i)  // at the vertex before, or on the way from it
        if (from.left.linkSet[path[i]] >= indirect || !(h->origin[i] & (kFromDiscrete | kFromSpecular)))
          state.linkSet[i] += indirect;
  }
  const bool smooth = s.anyFlags & kHasNormals, placed = s.anyPlaced;
  h->surface.begin(*this, c, s.anyFlags & kHasQuads);
  float* ng[3] = {nullptr, nullptr, nullptr};
  float* nn[3] = {nullptr, nullptr, nullptr};
  if (smooth || placed) {
    for (int k = 0; k < 3; ++k) {
      if (smooth) nn[k] = f();
      if (placed) ng[k] = f();
    }
    const SurfaceArgs& of = smooth ? h->surface.meshArgs() : h->surface.facetArgs();
    h->surface.kernels().normals(of, raw, placed ? ng : nullptr, smooth ? nn : nullptr);
  }
  a.t = hits.t;
  a.reach = c->distance;
  for (int k = 0; k < 3; ++k) {
    a.ng[k] = placed ? ng[k] : raw[k];
    a.smooth[k] = nn[k];
  }
  a.side = s.side;
  h->block = block;
  pointsKernel(world_.width)(a);
  if (w.hasStrands()) leaveStrands(c, program.isFiber, a.isRecord, a.P, a.bias);
  h->surface.limitFootprints(a.outRadius);
  if (bind) {
    if (state.terminatorOffset[0]) {
      if (program.encloses)
        for (float* x : state.terminatorOffset) std::memset(x, 0, m * sizeof(float));
      else
        findTerminatorOffsets(c, a.Ng);
    }
    findLightNormals(c, &program);
    for (int k = 0; state.Ng[0] && k < 3; ++k) state.Ng[k] = a.Ng[k];
    for (uint32_t i = 0; state.traceSet && i < m; ++i)
      state.traceSet[i] = world_.placementOf(c->place.instance[i], c->place.geometry[i]).traceSet;
  }

  float* outer = arena_.make<float>(m);
  if (state.media && from.left.media) {
    for (uint32_t i = 0; i < m; ++i) state.media[i] = from.left.media[path[i]];
    findOuterIor(c, state.media, outer);
  } else {
    if (state.media) std::fill_n(state.media, m, MediaPool::kEmpty);
    std::fill_n(outer, m, 1.f);
  }
  c->outerIor = outer;
  setProgram(c, program, bind);
  return c;
}

// The points' lobes and room for their network; the closure, where it is wanted.
void GroupState::setProgram(Context* c, const Program& program, bool bind) {
  ContextHost* h = static_cast<ContextHost*>(c->host);
  c->lobeCount = program.traits ? program.traits->lobeCount : 0;
  c->slotCount = program.slotCount;
  c->slotOfLobe = program.slotOfLobe.data();
  c->eventOfSlot = program.eventOfSlot.data();
  c->tintedSlots = program.tintedSlots;
  c->walkableSlots = program.walkableSlots;
  c->traits |= (program.encloses ? kTraitEncloses : 0u) | (program.tints ? kTraitTinted : 0u) |
               (program.isFiber ? kTraitFiber : 0u) | (program.walkableLobes ? kTraitWalkable : 0u);
  c->bxdf = program.bxdf;

  h->startNetwork();
  if (bind && program.bxdf->begin && !(c->traits & kTraitComesOut)) {
    uint64_t time = 0;
    {
      const Clock clock(time);
      c->closure = program.bxdf->begin(c);
    }
    counters.nanoseconds[kTimeClosures] += time;
    counters.nanoseconds[kTimeGrouping] -= time;  // runs inside shade()'s clock
  }
}

void GroupState::leaveStrands(const Context* c, bool isFiber, bool isRecord, float* const P[3], float* bias) const {
  const trace::World& w = *world_.world;
  for (uint32_t i = 0; i < c->padded; ++i) {
    const geometry::Mesh& mesh = w.mesh(c->place.geometry[i]);
    if (!mesh.isStrand()) continue;
    const float radius = radiusOfStrand(w, c->place, i, c->time[i]);
    // What faces its rays turns to those that leave it, which would meet it again: they start off the tube or ball that it
    // stands for.
    const bool leavesAxis = isFiber && mesh.isTube();
    bias[i] = std::max(bias[i], (leavesAxis || mesh.facesRay() ? 1.001f : 1e-3f) * radius);
    // rays that go through a fibre start behind it; a record was made of such a point
    for (int k = 0; leavesAxis && !isRecord && k < 3; ++k) P[k][i] -= radius * c->Ng[k][i];
  }
}

Context* GroupState::pointsInSpace(RayList& list, uint32_t traits, uint32_t depth, uint32_t n,
                                   const uint32_t* entries, const float* t) {
  if (!n) return nullptr;
  countLanes(traits, depth, n);
  return startInSpace(list, traits, depth, n, entries, t);
}

// Points where a medium has ended rays, or where one is asked for. They stand for their object: what asks a surface
// gets an answer for some place of its boundary, which moves and is transformed as the object is.
Context* GroupState::makeMediumContext(const RayList& list, uint32_t programIndex, uint32_t traits, uint32_t depth,
                                       uint32_t n, const uint32_t* entries, bool bind) {
  const Program& program = world_.materials->program(programIndex);
  Context* c = startInSpace(list, traits, depth, n, entries, list.hits.t);
  if (program.mediumFlags & kMediumScattersOnce) c->traits |= kTraitScattersOnce;
  ContextHost& h = ContextHost::of(c);
  h.program = &program;
  SurfacesArgs s = placesOf(list, list.hits.t, c);
  s.linkSet = h.state.linkSet;
  s.outT = arena_.make<float>(s.n);
  s.outTime = arena_.make<float>(s.n);
  s.outOrigin = arena_.make<uint32_t>(s.n);
  surfacesKernel(world_.width)(s);
  h.block = s.block;
  h.surface.begin(*this, c, false);
  setProgram(c, program, bind);
  return c;
}

Context* GroupState::startInSpace(const RayList& list, uint32_t traits, uint32_t depth, uint32_t n,
                                  const uint32_t* entries, const float* t) {
  Context* c;
  PointsArgs a = startContext(list, traits | kTraitInSpace, depth, n, entries, c);
  const uint32_t m = c->padded;
  ContextHost& h = ContextHost::of(c);
  const auto f = [&] { return arena_.make<float>(m); };
  float *ng[3] = {f(), f(), f()}, *side = f(), *outer = f(), *reach = f();
  uint32_t* origin = arena_.make<uint32_t>(m);
  h.state = makeState(m);
  const ListHost& from = ListHost::of(list);
  for (uint32_t i = 0; i < m; ++i) {
    const uint32_t s = c->path[i];
    for (int k = 0; k < 3; ++k) ng[k][i] = -list.rays.d[k][s];
    side[i] = outer[i] = 1.f;
    reach[i] = t[s];
    origin[i] = list.origin[s];
    // all lights, but within a body those that light it
    if (h.state.linkSet) h.state.linkSet[i] = traits & kTraitComesOut ? from.left.linkSet[s] : 0;
    if (h.state.traceSet) h.state.traceSet[i] = 0;
    if (h.state.bounces) h.state.bounces[i] = from.left.bounces[s] + 1;
    if (h.state.media) h.state.media[i] = from.left.media ? from.left.media[s] : MediaPool::kEmpty;
    for (int k = 0; h.state.terminatorOffset[0] && k < 3; ++k)
      h.state.terminatorOffset[k][i] = h.state.facet[k][i] = 0;
  }
  c->distance = reach;
  h.origin = origin;
  for (int k = 0; k < 3; ++k) a.ng[k] = ng[k];
  a.t = t;
  a.reach = reach;
  a.side = side;
  pointsKernel(world_.width)(a);
  for (int k = 0; h.state.Ng[0] && k < 3; ++k) h.state.Ng[k] = a.Ng[k];
  findLightNormals(c, nullptr);
  c->outerIor = outer;
  return c;
}

}  // namespace kinora::shade
