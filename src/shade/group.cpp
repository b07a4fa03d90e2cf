// A group's rays: begin, trace (with presence, sides and media), and keeping paths for another direction.
#include "shade/group.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/clock.h"

namespace kinora::shade {

namespace {
constexpr uint32_t kDimPresence = 12;  // offset within a vertex's dimensions: kDimUser and up are free
}  // namespace

void ShadingWorld::fillTables() {
  SurfaceTables& t = tables;
  t = {};
  for (const GeometryInfo& g : geometries) {
    t.flagsOfGeometry.push_back(g.flags);
    t.sideOfGeometry.push_back(g.side);
  }
  hasLinks = false;
  for (uint32_t i = 0; i < world->instanceCount(); ++i) {
    const PlacementInfo& p = placements[world->instance(i).user];
    t.materialOfInstance.push_back(p.material);
    t.linkSetOfInstance.push_back(p.linkSet);
    t.placedOfInstance.push_back(world->instance(i).baked ? 0u : ~0u);
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

void GroupState::begin(uint32_t count, StageKind stage) {
  arena_.reset();
  const uint32_t n = padded(count) + kPad;
  const auto f = [&] { return arena_.make<float>(n); };
  const auto u = [&] { return arena_.make<uint32_t>(n); };
  group_ = Group{};
  group_.count = count;
  group_.padded = padded(count);
  group_.width = world_.width;
  group_.stage = stage;
  Rays& r = group_.rays;
  for (int c = 0; c < 3; ++c) {
    r.o[c] = f();
    r.d[c] = f();
  }
  r.tMax = f();
  r.time = f();
  r.radius = f();
  r.spread = f();
  Hits& h = group_.hits;
  h.t = f();
  h.u = f();
  h.v = f();
  for (int c = 0; c < 3; ++c) h.ng[c] = f();
  h.instance = u();
  h.geometry = u();
  h.primitive = u();
  h.level = u();
  seed_ = u();
  index_ = u();
  px_ = arena_.make<int32_t>(n);
  py_ = arena_.make<int32_t>(n);
  weight_ = f();
  group_.sampleSeed = seed_;
  group_.sampleIndex = index_;
  group_.pixel[0] = px_;
  group_.pixel[1] = py_;
  group_.rayWeight = weight_;
  linkSet_ = u();
  std::memset(linkSet_, 0, n * sizeof(uint32_t));
  group_.origin = u();
  std::memset(group_.origin, 0, n * sizeof(uint32_t));
  const auto zeros = [&] {
    float* x = f();
    std::memset(x, 0, n * sizeof(float));
    return x;
  };
  const bool sets = !world_.traceSets.empty();
  for (float*& x : leftNg_) x = sets || world_.liftsShadows ? zeros() : nullptr;
  for (float*& x : lift_) x = world_.liftsShadows ? zeros() : nullptr;
  for (float*& x : lightN_) x = world_.lights && world_.lights->hasChoice() ? zeros() : nullptr;
  for (float*& x : facet_) x = world_.liftsShadows ? zeros() : nullptr;
  traceSet_ = nullptr;
  if (sets) {
    traceSet_ = u();
    std::memset(traceSet_, 0, n * sizeof(uint32_t));
  }
  hole_ = world_.hasHoles ? f() : nullptr;
  media_ = nullptr;
  if (world_.hasMedia) {
    media_ = arena_.make<MediaStack>(n);
    for (uint32_t i = 0; i < n; ++i) media_[i].count = 0;
  }
}

// Moves rays just beyond what they hit; `passed` (null: not wanted) sums the distances by slot.
void GroupState::passThrough(uint32_t n, const uint32_t* slots, float* passed) {
  Rays& r = group_.rays;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots[i];
    const float t = group_.hits.t[s];
    float size = t;
    for (int c = 0; c < 3; ++c) size = std::max(size, std::fabs(r.o[c][s] + r.d[c][s] * t));
    const float step = t + size * 8e-6f + 1e-7f;
    for (int c = 0; c < 3; ++c) r.o[c][s] += r.d[c][s] * step;
    r.tMax[s] -= step;
    r.radius[s] += r.spread[s] * step;
    if (passed) passed[s] += step;
  }
}

void GroupState::trace(RayKind kind, uint32_t depth, uint32_t n, const uint32_t* slots,
                       float* const transmittance[3]) {
  const trace::World& w = *world_.world;
  const Clock clock(counters.nanoseconds[kind == RayKind::Camera ? kTimeTraceCamera : kTimeTraceIndirect]);
  rayKind_ = kind;
  if (listener) listener->closest(kind, depth, group_.rays, n, slots);
  const uint32_t mask = kind == RayKind::Camera ? trace::kSeenByCamera : trace::kSeenByIndirect;
  if (kind == RayKind::Camera && n == group_.count && n % 16 == 0) {
    w.closestCamera(group_.rays, group_.hits, n);
  } else if (traceSet_ && kind != RayKind::Camera) {
    closestInSets(false, n, slots);
  } else {
    w.closest(group_.rays, group_.hits, mask, n, slots);
  }
  (kind == RayKind::Camera ? counters.cameraRays : counters.indirectRays) += n;
  if (transmittance)
    for (int c = 0; c < 3; ++c)
      for (uint32_t i = 0; i < n; ++i) transmittance[c][slots[i]] = 1.f;
  if (world_.hasMedia || world_.hasPresence) {
    uint32_t* open = arena_.make<uint32_t>(padded(n));
    uint32_t m = n;
    std::memcpy(open, slots, n * sizeof(uint32_t));
    // rays that passed something, with where they began and how far they have come
    Rays begun{};
    float* passed = nullptr;
    for (int pass = 0; m; ++pass) {
      if (world_.hasMedia && transmittance) media(m, open, transmittance);
      // who goes on?
      uint32_t k = 0;
      uint32_t* onward = arena_.make<uint32_t>(padded(m));
      uint32_t* ask = arena_.make<uint32_t>(padded(m));
      uint32_t asked = 0;
      for (uint32_t i = 0; i < m; ++i) {
        const uint32_t s = open[i];
        if (std::isinf(group_.hits.t[s])) continue;
        const uint32_t material = world_.materialOf(group_.hits.instance[s]);
        if (world_.hasMedia && world_.materials->encloses(material) && insideHigherPriority(s)) {
          // the boundary of a medium that another one displaces: note the crossing, go on. What is not a medium's
          // boundary stays, whatever surrounds it.
          Context* const* contexts;
          const uint32_t count = shade(kTraitEyePath | kTraitPresenceQuery, depth, 1, &s, &contexts);
          const uint32_t zero = 0;
          if (count) cross(contexts[0], 1, &zero);
          onward[k++] = s;
        } else if (!world_.materials->opaque(material)) {
          ask[asked++] = s;
        } else if (world_.geometries[group_.hits.geometry[s]].flags & kOneSided) {
          const GeometryInfo& g = world_.geometries[group_.hits.geometry[s]];
          const trace::Instance& inst = w.instance(group_.hits.instance[s]);
          float ng[3] = {group_.hits.ng[0][s], group_.hits.ng[1][s], group_.hits.ng[2][s]};
          if (!inst.baked) {
            const trace::Affine inverse = w.objectToRender(group_.hits.instance[s], group_.rays.time[s]).inverse();
            float q[3];
            for (int c = 0; c < 3; ++c)
              q[c] = inverse.m[0][c] * ng[0] + inverse.m[1][c] * ng[1] + inverse.m[2][c] * ng[2];
            std::memcpy(ng, q, sizeof ng);
          }
          float d = 0;
          for (int c = 0; c < 3; ++c) d += ng[c] * group_.rays.d[c][s];
          if (d * g.side > 0) onward[k++] = s;
        }
      }
      if (asked) {
        Context* const* contexts;
        const uint32_t count = shade(kTraitEyePath | kTraitPresenceQuery, depth, asked, ask, &contexts);
        for (uint32_t c = 0; c < count; ++c) {
          const Context* x = contexts[c];
          float* presence = x->alloc<float>(x->padded);
          x->bxdf->presence(x, presence);
          for (uint32_t i = 0; i < x->count; ++i) {
            const uint32_t s = x->path[i];
            const float u = drawEvent(seed_[s], index_[s], dimensionAt(depth) + kDimPresence, uint32_t(pass));
            if (!(u < presence[i])) onward[k++] = s;
          }
        }
      }
      if (!k) break;
      std::sort(onward, onward + k);
      if (pass == kMostPasses) {
        counters.passThroughLimit += k;
        for (uint32_t i = 0; i < k; ++i) group_.hits.t[onward[i]] = INFINITY;
        break;
      }
      if (!passed) {
        const uint32_t room = group_.padded + kPad;
        passed = arena_.make<float>(room);
        for (float*& o : begun.o) o = arena_.make<float>(room);
        begun.tMax = arena_.make<float>(room);
        begun.radius = arena_.make<float>(room);
        for (uint32_t i = 0; i < n; ++i) passed[slots[i]] = 0;
      }
      for (uint32_t i = 0; i < k; ++i) {
        const uint32_t s = onward[i];
        if (passed[s] > 0) continue;
        for (int c = 0; c < 3; ++c) begun.o[c][s] = group_.rays.o[c][s];
        begun.tMax[s] = group_.rays.tMax[s];
        begun.radius[s] = group_.rays.radius[s];
      }
      passThrough(k, onward, passed);
      if (traceSet_ && kind != RayKind::Camera)
        closestInSets(false, k, onward);
      else
        w.closest(group_.rays, group_.hits, mask, k, onward);
      open = onward;
      m = k;
    }
    // The ray is again the one that left the last vertex: lights in front of what was passed are met, and their
    // densities are those of that vertex.
    if (passed)
      for (uint32_t i = 0; i < n; ++i) {
        const uint32_t s = slots[i];
        if (!(passed[s] > 0)) continue;
        for (int c = 0; c < 3; ++c) group_.rays.o[c][s] = begun.o[c][s];
        group_.rays.tMax[s] = begun.tMax[s];
        group_.rays.radius[s] = begun.radius[s];
        group_.hits.t[s] += passed[s];
      }
  }
  if (hole_ && kind == RayKind::Camera) endAtHoles(n, slots);
  if (kind == RayKind::Camera) {
    for (uint32_t i = 0; i < n; ++i) counters.cameraHits += !std::isinf(group_.hits.t[slots[i]]);
  } else {
    for (uint32_t i = 0; i < n; ++i) counters.indirectHits += !std::isinf(group_.hits.t[slots[i]]);
  }
}

struct GroupState::KeptPaths {
  uint32_t n;
  const uint32_t* slots;
  float *t, *u, *v, *ng[3];
  uint32_t *instance, *geometry, *primitive, *level, *linkSet, *traceSet;
  float *leftNg[3], *lift[3], *facet[3], *lightN[3];
  MediaStack* media;
};

const void* GroupState::keepPaths(uint32_t n, const uint32_t* slots) {
  KeptPaths* k = new (arena_.allocate(sizeof(KeptPaths))) KeptPaths();
  const auto take = [&]<class T>(const T* from) {
    T* to = arena_.make<T>(n);
    for (uint32_t i = 0; i < n; ++i) to[i] = from[slots[i]];
    return to;
  };
  const Hits& h = group_.hits;
  uint32_t* list = arena_.make<uint32_t>(n);
  std::copy_n(slots, n, list);
  k->n = n;
  k->slots = list;
  k->t = take(h.t);
  k->u = take(h.u);
  k->v = take(h.v);
  for (int c = 0; c < 3; ++c) k->ng[c] = take(h.ng[c]);
  k->instance = take(h.instance);
  k->geometry = take(h.geometry);
  k->primitive = take(h.primitive);
  k->level = take(h.level);
  k->linkSet = take(linkSet_);
  k->traceSet = traceSet_ ? take(traceSet_) : nullptr;
  for (int c = 0; c < 3; ++c) {
    k->leftNg[c] = leftNg_[c] ? take(leftNg_[c]) : nullptr;
    k->lift[c] = lift_[c] ? take(lift_[c]) : nullptr;
    k->facet[c] = facet_[c] ? take(facet_[c]) : nullptr;
    k->lightN[c] = lightN_[c] ? take(lightN_[c]) : nullptr;
  }
  k->media = media_ ? take(media_) : nullptr;
  return k;
}

void GroupState::restorePaths(const void* kept) {
  const KeptPaths& k = *static_cast<const KeptPaths*>(kept);
  Hits& h = group_.hits;
  const auto put = [&]<class T>(const T* from, T* to) {
    for (uint32_t i = 0; i < k.n; ++i) to[k.slots[i]] = from[i];
  };
  put(k.t, h.t);
  put(k.u, h.u);
  put(k.v, h.v);
  for (int c = 0; c < 3; ++c) put(k.ng[c], h.ng[c]);
  put(k.instance, h.instance);
  put(k.geometry, h.geometry);
  put(k.primitive, h.primitive);
  put(k.level, h.level);
  put(k.linkSet, linkSet_);
  if (k.traceSet) put(k.traceSet, traceSet_);
  for (int c = 0; c < 3; ++c) {
    if (k.leftNg[c]) put(k.leftNg[c], leftNg_[c]);
    if (k.lift[c]) put(k.lift[c], lift_[c]);
    if (k.facet[c]) put(k.facet[c], facet_[c]);
    if (k.lightN[c]) put(k.lightN[c], lightN_[c]);
  }
  if (k.media) put(k.media, media_);
}

}  // namespace kinora::shade
