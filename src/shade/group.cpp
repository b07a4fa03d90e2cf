// A group's rays: lists of them, what they take over from vertices, and trace (with presence, sides and media).

#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/clock.h"
#include "shade/closest_by_mask.h"
#include "shade/context_host.h"
#include "shade/passed_rays.h"

namespace kinora::shade {

namespace {
constexpr uint32_t kDimPresence = 12;  // offset within a vertex's dimensions: kDimUser and up are free
}  // namespace

ObjectSpace ObjectSpace::of(const scene::Matrix& toRender, float unit) {
  ObjectSpace s;
  s.fromRender =
      trace::Affine::from(std::fabs(toRender.determinant()) > 1e-300 ? toRender.inverse() : scene::Matrix());
  s.scale = std::cbrt(std::fabs(s.fromRender.determinant()));
  s.unit = unit;
  return s;
}

ObjectSpace ShadingWorld::spaceOf(uint32_t instance, uint32_t geometry) const {
  const uint32_t placement = world->instance(instance).user;
  if (placement < objectSpaces->size()) return (*objectSpaces)[placement];
  const trace::Affine a = world->objectToRender(instance, 0.5f);
  scene::Matrix m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m[j][i] = double(a.m[i][j]);
    m[3][i] = double(a.t[i]);
  }
  m = scene::Matrix().setTranslation(-world->mesh(geometry).origin) * m;
  if (const BakedSpace* baked = geometries[geometry].baked.get()) m = baked->toMesh * m;
  return ObjectSpace::of(m);
}

void ShadingWorld::fillTables() {
  SurfaceTables& t = tables;
  t = {};
  for (uint32_t g = 0; g < geometries.size(); ++g) {
    const GeometryInfo& info = geometries[g];
    const geometry::Mesh& mesh = world->mesh(g);
    t.flagsOfGeometry.push_back(info.flags);
    t.sideOfGeometry.push_back(info.side);
    const bool hasNormals = info.N && !mesh.isStrand();
    t.meshes.push_back(
        {&mesh, mesh.indices.data(), mesh.isStrand() ? nullptr : mesh.points.data(),
         hasNormals ? info.N->data.data() : nullptr,
         info.st && !mesh.isStrand() && info.st->rate == geometry::Primvar::Rate::PerVertex ? info.st->data.data()
                                                                                            : nullptr,
         hasNormals ? info.N->rate : geometry::Primvar::Rate::Constant, mesh.keyCount() > 1,
         hasNormals && info.N->rate == geometry::Primvar::Rate::PerVertex && mesh.movesWithKeys(*info.N)});
  }
  hasLinks = false;
  t.instances = world->instanceWords();
  t.infoSteps = world->infoSteps();
  for (const PlacementInfo& p : placements) {
    t.materialOfInfo.push_back(p.material);
    t.linkSetOfInfo.push_back(p.linkSet);
    hasLinks |= p.linkSet != 0;
  }
  for (uint32_t m = 0; m < materials->size(); ++m) {
    t.programOfMaterial.push_back((*materials)[m].program);
    t.blockOfMaterial.push_back((*materials)[m].block);
  }
}

GroupState::GroupState(const ShadingWorld& world)
    : world_(world), shaderTextures_(world.textures, world.volumes, arena_) {
  countOfProgram_.assign(world.materials->programCount() + 1, 0);
  shaderCounts.resize(world.materials->shaderUses().size());
}

void GroupState::fillList(RayList& list, uint32_t room) {
  const auto f = [&] { return arena_.make<float>(room); };
  const auto u = [&] { return arena_.make<uint32_t>(room); };
  list.capacity = room;
  Rays& r = list.rays;
  Hits& h = list.hits;
  for (int c = 0; c < 3; ++c) {
    r.o[c] = f();
    r.d[c] = f();
  }
  r.tMax = f();
  r.time = f();
  r.radius = f();
  r.spread = f();
  h.t = f();
  h.u = f();
  h.v = f();
  for (int c = 0; c < 3; ++c) h.ng[c] = f();
  h.instance = u();
  h.geometry = u();
  h.primitive = u();
  h.level = u();
  list.sampleSeed = u();
  list.sampleIndex = u();
  list.origin = u();
  std::memset(list.origin, 0, room * sizeof(uint32_t));
  ListHost* host = new (arena_.allocate(sizeof(ListHost))) ListHost();
  list.host = host;
  VertexState& left = host->left = makeState(room);
  if (!left.linkSet) left.linkSet = u();
  if (world_.space && scattersInMedia) host->surfaceT = f();
  for (int c = 0; c < 3; ++c) {
    if (world_.hasMedia) host->absorbed[c] = f();
    list.glow[c] = host->surfaceT && world_.space->mayEmit ? f() : nullptr;
  }
  const auto clear = [&]<class T>(T* x) {
    if (x) std::memset(x, 0, room * sizeof(T));
  };
  clear(left.linkSet);
  clear(left.traceSet);
  clear(left.lightRow);
  clear(left.media);
  for (int c = 0; c < 3; ++c) {
    clear(left.Ng[c]);
    clear(left.terminatorOffset[c]);
    clear(left.facet[c]);
    clear(left.lightN[c]);
  }
}

VertexState GroupState::makeState(uint32_t n) {
  VertexState s;
  if (world_.hasLinks) s.linkSet = arena_.make<uint32_t>(n);
  if (!world_.traceSets.empty()) s.traceSet = arena_.make<uint32_t>(n);
  if (world_.hasMedia) s.media = arena_.make<uint32_t>(n);
  if (world_.space && world_.space->isSimilar) {
    s.bounces = arena_.make<uint32_t>(n);
    std::fill_n(s.bounces, n, 0u);
  }
  if (weighsLights && world_.lights && world_.lights->hasChoice()) {
    s.lightRow = arena_.make<uint32_t>(n);
    std::fill_n(s.lightRow, n, 0u);
  }
  for (int c = 0; c < 3; ++c) {
    if (world_.movesShadowOrigins || s.traceSet) s.Ng[c] = arena_.make<float>(n);
    if (world_.movesShadowOrigins) s.terminatorOffset[c] = arena_.make<float>(n);
    if (world_.movesShadowOrigins) s.facet[c] = arena_.make<float>(n);
    if (world_.lights && world_.lights->hasChoice()) s.lightN[c] = arena_.make<float>(n);
  }
  return s;
}

RayList* GroupState::makeRays(uint32_t capacity) {
  RayList* list = new (arena_.allocate(sizeof(RayList))) RayList();
  fillList(*list, padded(capacity) + kPad);
  return list;
}

void GroupState::begin(uint32_t count, StageKind stage) {
  arena_.reset();
  media_.reset();
  const uint32_t n = padded(count) + kPad;
  group_ = Group{};
  group_.count = count;
  group_.padded = padded(count);
  group_.width = world_.width;
  group_.stage = stage;
  fillList(group_.paths, n);
  number_ = arena_.make<uint64_t>(n);
  group_.number = number_;
  px_ = arena_.make<int32_t>(n);
  py_ = arena_.make<int32_t>(n);
  weight_ = arena_.make<float>(n);
  group_.pixel[0] = px_;
  group_.pixel[1] = py_;
  group_.rayWeight = weight_;
  hole_ = world_.hasHoles ? arena_.make<float>(n) : nullptr;
}

void GroupState::leave(RayList& list, const Context* c, uint32_t n, const uint32_t* points, const uint32_t* entries,
                       const uint32_t* through) {
  const VertexState& from = ContextHost::of(c).state;
  const VertexState& to = ListHost::of(list).left;
  const auto entryOf = [&](uint32_t i) { return entries ? entries[i] : c->path[points[i]]; };
  if (entries)  // of another list: the address comes along
    for (uint32_t i = 0; i < n; ++i) {
      list.sampleSeed[entries[i]] = c->sampleSeed[points[i]];
      list.sampleIndex[entries[i]] = c->sampleIndex[points[i]];
    }
  const auto take = [&](const auto* x, auto* y) {
    for (uint32_t i = 0; i < n; ++i) y[entryOf(i)] = x[points[i]];
  };
  if (from.linkSet) take(from.linkSet, to.linkSet);
  if (from.traceSet) take(from.traceSet, to.traceSet);
  if (from.bounces) take(from.bounces, to.bounces);
  if (from.lightRow) take(from.lightRow, to.lightRow);
  for (int k = 0; k < 3; ++k) {
    if (from.Ng[k]) take(from.Ng[k], to.Ng[k]);
    if (from.terminatorOffset[k]) take(from.terminatorOffset[k], to.terminatorOffset[k]);
    if (from.facet[k]) take(from.facet[k], to.facet[k]);
    if (from.lightN[k]) take(from.lightN[k], to.lightN[k]);
  }
  if (!from.media) return;
  uint32_t* stacks = arena_.make<uint32_t>(padded(n));
  for (uint32_t i = 0; i < n; ++i) stacks[i] = from.media[points[i]];
  if (through) updateMedia(c, n, points, through, stacks);
  for (uint32_t i = 0; i < n; ++i) to.media[entryOf(i)] = stacks[i];
}

// Moves rays just beyond what they hit; `passed` (null: not wanted) sums the distances by entry.
void GroupState::passThrough(const RayList& list, uint32_t n, const uint32_t* entries, float* passed) {
  const Rays& r = list.rays;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = entries[i];
    const float step = distanceBeyond(r, s, list.hits.t[s]);
    for (int c = 0; c < 3; ++c) r.o[c][s] += r.d[c][s] * step;
    r.tMax[s] -= step;
    r.radius[s] += r.spread[s] * step;
    if (passed) passed[s] += step;
  }
}

// The cosine, unnormalised, between a ray and the outward normal of what it hit: above 0 it comes out there.
float GroupState::outwards(const Hits& hits, uint32_t at, const float d[3], float time) const {
  const trace::World& w = *world_.world;
  float ng[3] = {hits.ng[0][at], hits.ng[1][at], hits.ng[2][at]};
  if (!w.instance(hits.instance[at]).baked) {
    const trace::Affine inverse = w.objectToRender(hits.instance[at], time).inverse();
    float q[3];
    for (int c = 0; c < 3; ++c) q[c] = inverse.m[0][c] * ng[0] + inverse.m[1][c] * ng[1] + inverse.m[2][c] * ng[2];
    std::memcpy(ng, q, sizeof ng);
  }
  return (ng[0] * d[0] + ng[1] * d[1] + ng[2] * d[2]) * world_.geometries[hits.geometry[at]].side;
}

// Whether a hit shows its object's side that Sides 1 takes away.
bool GroupState::averted(const RayList& list, uint32_t s) const {
  if (!(world_.geometries[list.hits.geometry[s]].flags & kOneSided)) return false;
  const float d[3] = {list.rays.d[0][s], list.rays.d[1][s], list.rays.d[2][s]};
  return outwards(list.hits, s, d, list.rays.time[s]) > 0;
}

// Nearest hits by the list's kind of ray.
void GroupState::closest(RayList& list, uint32_t n, const uint32_t* entries) {
  const trace::World& w = *world_.world;
  const ListHost& host = ListHost::of(list);
  if (host.clearMask)
    closestByMask(
        list, [&](uint32_t entry) { return host.clearMask[entry]; }, n, entries);
  else if (host.kind == RayKind::Transmission)
    host.left.traceSet ? closestInSets(list, true, n, entries)
                       : w.closest(list.rays, list.hits, trace::kSeenByClearShadow, n, entries);
  else if (host.kind == RayKind::Camera)
    w.closest(list.rays, list.hits, trace::kSeenByCamera, n, entries,
              {&world_.samples, list.sampleSeed, list.sampleIndex});
  else if (host.seen)
    w.closest(list.rays, list.hits, host.seen, n, entries);
  else if (host.left.traceSet)
    closestInSets(list, false, n, entries);
  else
    w.closest(list.rays, list.hits, trace::kSeenByIndirect, n, entries);
}

void GroupState::trace(RayList& list, RayKind kind, uint32_t depth, uint32_t n, const uint32_t* entries,
                       float* const transmittance[3]) {
  const Clock clock(counters.nanoseconds[kind == RayKind::Camera ? kTimeTraceCamera : kTimeTraceIndirect]);
  ListHost& host = ListHost::of(list);
  Hits& hits = list.hits;
  host.kind = kind;
  host.depth = depth;
  if (listener) listener->closest(kind, depth, list.rays, n, entries);
  if (kind == RayKind::Camera && &list == &group_.paths && n == group_.count && n % 16 == 0)
    world_.world->closestCamera(list.rays, hits, n, {&world_.samples, list.sampleSeed, list.sampleIndex});
  else
    closest(list, n, entries);
  (kind == RayKind::Camera ? counters.cameraRays : counters.indirectRays) += n;
  if (transmittance)
    for (int c = 0; c < 3; ++c)
      for (uint32_t i = 0; i < n; ++i) transmittance[c][entries[i]] = 1.f;
  if (world_.hasMedia || world_.hasPresence) {
    uint32_t* open = arena_.make<uint32_t>(padded(n));
    uint32_t m = n;
    std::memcpy(open, entries, n * sizeof(uint32_t));
    // rays that passed something, with where they began and how far they have come
    PassedRays passed(arena_, list, n, entries);
    for (int pass = 0; m; ++pass) {
      if (host.left.media && transmittance) absorb(list, m, open, transmittance);
      // who goes on?
      uint32_t k = 0, asked = 0, displaced = 0;
      uint32_t* onward = arena_.make<uint32_t>(padded(m));
      uint32_t* ask = arena_.make<uint32_t>(padded(m));
      uint32_t* crossing = arena_.make<uint32_t>(padded(m));
      for (uint32_t i = 0; i < m; ++i) {
        const uint32_t s = open[i];
        if (std::isinf(hits.t[s])) continue;
        const uint32_t material = world_.materialOf(hits.instance[s], hits.geometry[s]);
        // The boundary of a medium that another one displaces: note the crossing, go on. What is not a medium's
        // boundary stays, whatever surrounds it.
        if (host.left.media && world_.materials->encloses(material) && insideHigherPriority(list, s))
          onward[k++] = crossing[displaced++] = s;
        else if (!world_.materials->opaque(material))
          ask[asked++] = s;
        else if (averted(list, s))
          onward[k++] = s;
      }
      if (displaced) crossDisplaced(list, depth, displaced, crossing);
      if (asked) {
        Context* const* contexts;
        const uint32_t count = shade(list, kTraitEyePath | kTraitPresenceQuery, depth, asked, ask, &contexts);
        for (uint32_t c = 0; c < count; ++c) {
          const Context* x = contexts[c];
          float* presence = x->alloc<float>(x->padded);
          x->bxdf->presence(x, presence);
          for (uint32_t i = 0; i < x->count; ++i) {
            const float u =
                drawEvent(x->sampleSeed[i], x->sampleIndex[i], dimensionAt(depth) + kDimPresence, uint32_t(pass));
            if (!(u < presence[i]) && uint32_t(pass) < group_.mostPassed) onward[k++] = x->path[i];
          }
        }
      }
      if (!k) break;
      std::sort(onward, onward + k);
      if (pass == kMostPasses) {
        counters.endlessRays += k;
        for (uint32_t i = 0; i < k; ++i) hits.t[onward[i]] = INFINITY;
        break;
      }
      passThrough(list, k, onward, passed.remember(k, onward));
      closest(list, k, onward);
      open = onward;
      m = k;
    }
    // The ray is again the one that left the last vertex: lights in front of what was passed are met, and their
    // densities are those of that vertex.
    passed.restore();
  }
  if (transmittance && host.absorbed[0])
    for (int c = 0; c < 3; ++c)
      for (uint32_t i = 0; i < n; ++i) host.absorbed[c][entries[i]] = transmittance[c][entries[i]];
  if (host.surfaceT)
    for (uint32_t i = 0; i < n; ++i) host.surfaceT[entries[i]] = hits.t[entries[i]];
  if (list.glow[0])
    for (float* x : list.glow)
      for (uint32_t i = 0; i < n; ++i) x[entries[i]] = 0;
  if (world_.space && transmittance) {
    if (host.surfaceT && !list.passesMedia) {
      scatterInSpace(list, depth, n, entries, transmittance);
    } else {
      float* ends = arena_.make<float>(list.capacity);
      for (uint32_t i = 0; i < n; ++i)
        ends[entries[i]] = std::min({hits.t[entries[i]], list.rays.tMax[entries[i]], 1e30f});
      thinOut(list.rays, ends, mediaSeen(list, n, entries), list.sampleSeed, list.sampleIndex, nullptr, depth, n,
              entries, transmittance);
    }
  }
  if (hole_ && kind == RayKind::Camera && &list == &group_.paths) endAtHoles(list, n, entries);
  uint64_t& met = kind == RayKind::Camera ? counters.cameraHits : counters.indirectHits;
  for (uint32_t i = 0; i < n; ++i) met += !std::isinf(hits.t[entries[i]]);
}

// Chords through the objects of the points: from hit to hit, other objects are only passed. Those of a set are told
// from others by the mask of its rays.
void GroupState::hitsOnObject(const Context* c, uint32_t n, const uint32_t* points, const Rays& rays,
                              ObjectHits* out) {
  const auto f = [&](size_t m) { return arena_.make<float>(m); };
  const auto u = [&](size_t m) { return arena_.make<uint32_t>(m); };
  const uint32_t most = out->most;
  const size_t room = size_t(padded(n)) * most + kPad;
  out->count = u(padded(n));
  out->beyond = u(padded(n));
  out->t = f(room);
  out->u = f(room);
  out->v = f(room);
  for (float*& x : out->ng) x = f(room);
  out->instance = u(room);
  out->geometry = u(room);
  out->primitive = u(room);
  out->level = u(room);
  out->leaves = u(room);
  const uint32_t ofSet = maskOf(out->traceSet);
  RayList& list = *makeRays(n);
  uint32_t* open = u(padded(n));
  float* passed = f(padded(n));
  for (uint32_t i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) {
      list.rays.o[k][i] = rays.o[k][i];
      list.rays.d[k][i] = rays.d[k][i];
    }
    list.rays.tMax[i] = rays.tMax[i];
    list.rays.time[i] = rays.time[i];
    list.rays.radius[i] = rays.radius ? rays.radius[i] : c->radius[points[i]];
    list.rays.spread[i] = rays.spread ? rays.spread[i] : 0.f;
    open[i] = i;
    passed[i] = 0;
    out->count[i] = out->beyond[i] = 0;
  }
  // Materials that paths go below can be asked for alone: what lies on the object's own surface hides nothing of it.
  uint32_t* bodies = nullptr;
  if (const Program* program = ContextHost::of(c).program; !ofSet && program && program->scatters) {
    bodies = u(padded(n));
    for (uint32_t i = 0; i < n; ++i)
      bodies[i] = world_.world->bodyOf(c->place.instance[points[i]], c->place.geometry[points[i]]);
  }
  for (uint32_t open_ = n; open_;) {
    if (bodies)
      world_.world->closestOn(list.rays, list.hits, bodies, open_, open);
    else
      world_.world->closest(list.rays, list.hits, ofSet ? ofSet : ~0u, open_, open);
    const Hits& h = list.hits;
    uint32_t m = 0;
    for (uint32_t k = 0; k < open_; ++k) {
      const uint32_t i = open[k];
      if (std::isinf(h.t[i])) continue;
      open[m++] = i;
      if (!ofSet && h.instance[i] != c->place.instance[points[i]] &&
          world_.world->bodyOf(h.instance[i], h.geometry[i]) !=
              world_.world->bodyOf(c->place.instance[points[i]], c->place.geometry[points[i]]))
        continue;
      if (out->count[i] == most) {
        ++out->beyond[i];
        continue;
      }
      const size_t at = size_t(i) * most + out->count[i]++;
      out->t[at] = passed[i] + h.t[i];
      out->u[at] = h.u[i];
      out->v[at] = h.v[i];
      for (int x = 0; x < 3; ++x) out->ng[x][at] = h.ng[x][i];
      out->instance[at] = h.instance[i];
      out->geometry[at] = h.geometry[i];
      out->primitive[at] = h.primitive[i];
      out->level[at] = h.level[i];
      const float d[3] = {list.rays.d[0][i], list.rays.d[1][i], list.rays.d[2][i]};
      out->leaves[at] = outwards(h, i, d, list.rays.time[i]) > 0;
      if (out->nearestOnly && out->count[i] == most) --m;
    }
    passThrough(list, m, open, passed);
    open_ = m;
  }
}

void GroupState::freeRegions(const Context* c, uint32_t n, const uint32_t* points, const float* const P[3],
                             const float* reach, FreeRegions* out) {
  const ArenaScope scope(arena_);
  uint32_t *instances = arena_.make<uint32_t>(n), *geometries = arena_.make<uint32_t>(n);
  for (uint32_t i = 0; i < n; ++i) {
    instances[i] = c->place.instance[points[i]];
    geometries[i] = c->place.geometry[points[i]];
  }
  world_.world->freeRegions(n, instances, geometries, P, reach, *out);
}

void GroupState::noteBelow(const Context* c, uint32_t n, const uint32_t* points, BelowSurface what) {
  counters.lostBelow[uint32_t(what)] += n;
  uint32_t& first = counters.lostPlacement[uint32_t(what)];
  for (uint32_t i = 0; i < n; ++i) first = std::min(first, world_.world->instance(c->place.instance[points[i]]).user);
}

}  // namespace kinora::shade
