#include "shade/group.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "shade/beer_lambert.h"
#include "shade/context_host.h"
#include "shade/points.h"

namespace kinora::shade {

namespace {
constexpr uint32_t kDimPresence = 12;   // offset within a vertex's dimensions: kDimUser and up are free
// Adds the time from here to the end of a scope to a counter.
struct Clock {
  uint64_t& sum;
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  explicit Clock(uint64_t& s) : sum(s) {}
  ~Clock() { sum += uint64_t(std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - start).count()); }
};
constexpr int kMostPasses = 256;        // surfaces a ray may pass for want of presence or priority
}  // namespace

GroupState::GroupState(const ShadingWorld& world) : world_(world) {
  countOfProgram_.assign(world.materials->programCount() + 1, 0);
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
  for (int c = 0; c < 3; ++c) { r.o[c] = f(); r.d[c] = f(); }
  r.tMax = f(); r.time = f(); r.radius = f(); r.spread = f();
  Hits& h = group_.hits;
  h.t = f(); h.u = f(); h.v = f();
  for (int c = 0; c < 3; ++c) h.ng[c] = f();
  h.instance = u(); h.geometry = u(); h.primitive = u(); h.level = u();
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
  media_ = nullptr;
  if (world_.hasMedia) {
    media_ = arena_.make<MediaStack>(n);
    for (uint32_t i = 0; i < n; ++i) media_[i].count = 0;
  }
}

bool GroupState::insideHigherPriority(uint32_t slot) const {
  const MediaStack& m = media_[slot];
  if (!m.count) return false;
  const uint32_t inst = group_.hits.instance[slot], geom = group_.hits.geometry[slot];
  const PlacementInfo& place = world_.placements[world_.world->instance(inst).user];
  const int own = world_.geometries[geom].priority ? world_.geometries[geom].priority : place.priority;
  for (uint32_t i = 0; i < m.count; ++i)
    if (m.entries[i].object != inst && m.entries[i].priority > own) return true;
  return false;
}

void GroupState::media(uint32_t n, const uint32_t* slots, float* const transmittance[3]) {
  // Beer and Lambert along the segment just traced, in the innermost medium of the highest priority
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots[i];
    const MediaStack& m = media_[s];
    if (!m.count) continue;
    uint32_t top = m.count - 1;
    for (uint32_t k = m.count; k-- > 0;)
      if (m.entries[k].priority > m.entries[top].priority) top = k;
    const float* a = m.entries[top].absorption;
    const float t = group_.hits.t[s];
    // a ray that escapes from inside a medium crosses it without end
    for (int c = 0; c < 3; ++c) transmittance[c][s] *= beerLambert(a[c], t);
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

void GroupState::trace(RayKind kind, uint32_t depth, uint32_t n, const uint32_t* slots, float* const transmittance[3]) {
  const trace::World& w = *world_.world;
  const Clock clock(counters.nanoseconds[kind == RayKind::Camera ? kTimeTraceCamera : kTimeTraceIndirect]);
  if (listener) listener->closest(kind, depth, group_.rays, n, slots);
  const uint32_t mask = kind == RayKind::Camera ? trace::kSeenByCamera : trace::kSeenByIndirect;
  if (kind == RayKind::Camera && n == group_.count && n % 16 == 0) {
    w.closestCamera(group_.rays, group_.hits, n);
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
        const uint32_t material = world_.materialOf(group_.hits.instance[s], group_.hits.geometry[s]);
        if (world_.hasMedia && world_.materials->encloses(material) && insideHigherPriority(s)) {
          // the boundary of a medium that another one displaces: note the crossing, go on. What is not a medium's boundary
          // stays, whatever surrounds it.
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
            for (int c = 0; c < 3; ++c) q[c] = inverse.m[0][c] * ng[0] + inverse.m[1][c] * ng[1] + inverse.m[2][c] * ng[2];
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
      w.closest(group_.rays, group_.hits, mask, k, onward);
      open = onward;
      m = k;
    }
    // The ray is again the one that left the last vertex: lights in front of what was passed are met, and their densities
    // are those of that vertex.
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
  if (kind == RayKind::Camera) {
    for (uint32_t i = 0; i < n; ++i) counters.cameraHits += !std::isinf(group_.hits.t[slots[i]]);
  } else {
    for (uint32_t i = 0; i < n; ++i) counters.indirectHits += !std::isinf(group_.hits.t[slots[i]]);
  }
}

uint32_t GroupState::shade(uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots, Context* const** contexts) {
  *contexts = nullptr;
  if (!n) return 0;
  const bool query = traits & kTraitPresenceQuery;
  uint64_t unused = 0;   // queries happen inside the time of tracing
  const Clock clock(query ? unused : counters.nanoseconds[kTimeGrouping]);
  // Counting sort by program; within a program the order of the list stays.
  uint32_t* programOf = arena_.make<uint32_t>(n);
  touched_.clear();
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots[i];
    const uint32_t material = world_.materialOf(group_.hits.instance[s], group_.hits.geometry[s]);
    const uint32_t p = (*world_.materials)[material].program;
    programOf[i] = p;
    if (!countOfProgram_[p]++) touched_.push_back(p);
  }
  std::sort(touched_.begin(), touched_.end());
  uint32_t* order = arena_.make<uint32_t>(n);
  uint32_t* first = arena_.make<uint32_t>(touched_.size() + 1);
  uint32_t sum = 0;
  for (size_t k = 0; k < touched_.size(); ++k) {
    first[k] = sum;
    const uint32_t c = countOfProgram_[touched_[k]];
    countOfProgram_[touched_[k]] = sum;   // cursor
    sum += c;
  }
  first[touched_.size()] = sum;
  for (uint32_t i = 0; i < n; ++i) order[countOfProgram_[programOf[i]]++] = slots[i];
  const uint32_t count = uint32_t(touched_.size());
  Context** list = arena_.make<Context*>(count);
  uint32_t* programs = arena_.make<uint32_t>(count);
  for (uint32_t k = 0; k < count; ++k) {
    programs[k] = touched_[k];
    countOfProgram_[touched_[k]] = 0;
  }
  for (uint32_t k = 0; k < count; ++k)
    list[k] = makeContext(programs[k], traits, depth, first[k + 1] - first[k], order + first[k], !query);
  if (!query) {
    uint64_t* lanes = depth == 0 ? counters.lanesFirst : counters.lanesDeeper;
    for (uint32_t k = 0; k < count; ++k) {
      const uint32_t m = first[k + 1] - first[k], w = world_.width;
      lanes[0] += m;
      lanes[1] += (m + w - 1) / w * w;
    }
    counters.points += n;
    counters.contexts += count;
    if ((traits & kTraitPrimaryHit) && onPrimary)
      for (uint32_t k = 0; k < count; ++k) onPrimary(list[k]);
  }
  *contexts = list;
  return count;
}

Context* GroupState::makeContext(uint32_t programIndex, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots,
                                 bool bind) {
  const Program& program = world_.materials->program(programIndex);
  const trace::World& w = *world_.world;
  const uint32_t m = padded(n);
  uint32_t* slot = arena_.make<uint32_t>(m);
  std::memcpy(slot, slots, n * sizeof(uint32_t));
  for (uint32_t i = n; i < m; ++i) slot[i] = slots[n - 1];
  Context* c = new (arena_.allocate(sizeof(Context))) Context();
  ContextHost* h = new (arena_.allocate(sizeof(ContextHost))) ContextHost();
  c->count = n;
  c->padded = m;
  c->width = world_.width;
  c->traits = traits;
  c->path = slot;
  c->depth = depth;
  c->fn = &kContextFunctions;
  c->host = h;
  h->group = this;
  h->program = &program;
  h->slot = slot;

  PointsArgs a{};
  a.n = m;
  a.slots = slot;
  const Rays& r = group_.rays;
  const Hits& hits = group_.hits;
  for (int k = 0; k < 3; ++k) { a.o[k] = r.o[k]; a.d[k] = r.d[k]; }
  a.t = hits.t; a.radius = r.radius; a.spread = r.spread; a.time = r.time; a.seed = seed_; a.index = index_;
  float* ng[3];
  for (int k = 0; k < 3; ++k) { ng[k] = arena_.make<float>(m); a.ng[k] = ng[k]; }
  float* side = arena_.make<float>(m);
  uint32_t* block = arena_.make<uint32_t>(m);
  bool smooth = false, placed = false;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slot[i], g = hits.geometry[s], inst = hits.instance[s];
    const GeometryInfo& info = world_.geometries[g];
    for (int k = 0; k < 3; ++k) ng[k][i] = hits.ng[k][s];
    side[i] = info.side;
    const trace::Instance& instance = w.instance(inst);
    const uint32_t material = info.material != 0xffffffffu ? info.material : world_.placements[instance.user].material;
    block[i] = (*world_.materials)[material].block;
    smooth |= (info.flags & kHasNormals) != 0;
    placed |= !instance.baked;
    // what a ray only passes does not choose its lights
    if (bind) linkSet_[s] = world_.placements[instance.user].linkSet;
  }
  float* nn[3] = {nullptr, nullptr, nullptr};
  if (smooth || placed) {
    if (smooth)
      for (int k = 0; k < 3; ++k) nn[k] = arena_.make<float>(m);
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = slot[i];
      const GeometryInfo& info = world_.geometries[hits.geometry[s]];
      const trace::Instance& instance = w.instance(hits.instance[s]);
      float q[3] = {ng[0][i], ng[1][i], ng[2][i]}, sm[3] = {0, 0, 0};
      const bool own = smooth && info.N;
      if (own) {
        const geometry::Mesh& mesh = w.mesh(hits.geometry[s]);
        const geometry::Primvar& p = *info.N;
        const uint32_t t = hits.primitive[s];
        const float b1 = hits.u[s], b2 = hits.v[s], b0 = 1.f - b1 - b2;
        const float b[3] = {b0, b1, b2};
        size_t at[3];
        for (int k = 0; k < 3; ++k)
          at[k] = p.rate == geometry::Primvar::Rate::PerVertex ? mesh.indices[3 * size_t(t) + k]
                  : p.rate == geometry::Primvar::Rate::PerCorner ? 3 * size_t(t) + k
                  : p.rate == geometry::Primvar::Rate::PerFace ? mesh.faceOf(t)
                                                               : 0;
        // keys of a deforming mesh: nearest key pair
        size_t key0 = 0, key1 = 0;
        float f = 0;
        if (mesh.keyCount() > 1 && p.rate == geometry::Primvar::Rate::PerVertex &&
            p.data.size() == size_t(mesh.keyCount()) * mesh.vertexCount * 3) {
          const float x = std::clamp(r.time[s], 0.f, 1.f) * float(mesh.keyCount() - 1);
          key0 = std::min<size_t>(size_t(x), size_t(mesh.keyCount() - 2));
          key1 = key0 + 1;
          f = x - float(key0);
        }
        const size_t stride = size_t(mesh.vertexCount) * 3;
        for (int k = 0; k < 3; ++k)
          for (int j = 0; j < 3; ++j) {
            const float v0 = p.data[key0 * stride + 3 * at[k] + size_t(j)];
            sm[j] += b[k] * (f > 0 ? (1 - f) * v0 + f * p.data[key1 * stride + 3 * at[k] + size_t(j)] : v0);
          }
      }
      if (!instance.baked) {
        // cofactors: the inverse transpose times the determinant
        const trace::Affine x = w.objectToRender(hits.instance[s], r.time[s]);
        float cof[3][3];
        for (int u = 0; u < 3; ++u)
          for (int v = 0; v < 3; ++v) {
            const int u1 = (u + 1) % 3, u2 = (u + 2) % 3, v1 = (v + 1) % 3, v2 = (v + 2) % 3;
            cof[u][v] = x.m[u1][v1] * x.m[u2][v2] - x.m[u1][v2] * x.m[u2][v1];
          }
        const float det = x.m[0][0] * cof[0][0] + x.m[0][1] * cof[0][1] + x.m[0][2] * cof[0][2];
        const float sign = det < 0 ? -1.f : 1.f;
        float t[3], ts[3];
        for (int u = 0; u < 3; ++u) {
          t[u] = sign * (cof[u][0] * q[0] + cof[u][1] * q[1] + cof[u][2] * q[2]);
          ts[u] = sign * (cof[u][0] * sm[0] + cof[u][1] * sm[1] + cof[u][2] * sm[2]);
        }
        std::memcpy(q, t, sizeof q);
        std::memcpy(sm, ts, sizeof sm);
        for (int k = 0; k < 3; ++k) ng[k][i] = q[k];
      }
      if (smooth) {
        if (!own)
          for (int k = 0; k < 3; ++k) sm[k] = q[k] * info.side;
        const float l2 = sm[0] * sm[0] + sm[1] * sm[1] + sm[2] * sm[2];
        const float inv = l2 > 0 ? 1.f / std::sqrt(l2) : 0.f;
        // "N" of the mesh is oriented outward already; facets get their side above
        for (int k = 0; k < 3; ++k) nn[k][i] = l2 > 0 ? sm[k] * inv : q[k];
      }
    }
  }
  const auto pad = [&](float* x) { for (uint32_t i = n; i < m; ++i) x[i] = x[n - 1]; };
  for (int k = 0; k < 3; ++k) {
    pad(ng[k]);
    if (nn[k]) pad(nn[k]);
    a.smooth[k] = nn[k];
  }
  pad(side);
  for (uint32_t i = n; i < m; ++i) block[i] = block[n - 1];
  a.side = side;
  h->block = block;
  const auto f = [&] { return arena_.make<float>(m); };
  for (int k = 0; k < 3; ++k) {
    a.P[k] = f(); a.N[k] = f(); a.Ng[k] = f(); a.wo[k] = f();
    c->P[k] = a.P[k]; c->N[k] = a.N[k]; c->Ng[k] = a.Ng[k]; c->wo[k] = a.wo[k];
  }
  c->radius = a.outRadius = f();
  c->spread = a.outSpread = f();
  c->time = a.outTime = f();
  c->bias = a.bias = f();
  c->entering = a.entering = arena_.make<uint32_t>(m);
  c->sampleSeed = a.outSeed = arena_.make<uint32_t>(m);
  c->sampleIndex = a.outIndex = arena_.make<uint32_t>(m);
  pointsKernel(world_.width)(a);

  float* outer = f();
  for (uint32_t i = 0; i < m; ++i) outer[i] = 1.f;
  if (media_)
    for (uint32_t i = 0; i < m; ++i) {
      const MediaStack& stack = media_[slot[i]];
      int best = -1;
      for (uint32_t k = 0; k < stack.count; ++k)
        if (stack.entries[k].object != hits.instance[slot[i]] &&
            (best < 0 || stack.entries[k].priority >= stack.entries[best].priority))
          best = int(k);
      if (best >= 0) outer[i] = stack.entries[best].ior;
    }
  c->outerIor = outer;
  c->lobeCount = program.traits ? program.traits->lobeCount : 0;
  c->slotCount = program.slotCount;
  c->slotOfLobe = program.slotOfLobe.data();
  c->eventOfSlot = program.eventOfSlot.data();
  c->bxdf = program.bxdf;

  // room for the network's outputs
  const uint32_t nodes = uint32_t(program.nodes.size());
  h->done = arena_.make<uint8_t>(nodes);
  std::memset(h->done, 0, nodes);
  h->firstOutput = arena_.make<uint32_t>(nodes);
  uint32_t outputs = 0;
  for (uint32_t k = 0; k < nodes; ++k) {
    h->firstOutput[k] = outputs;
    outputs += uint32_t(program.nodes[k].outputParam.size());
  }
  h->outputs = arena_.make<Value>(outputs + 1);
  h->manifolds = arena_.make<Manifold>(outputs + 1);
  for (uint32_t k = 0; k < outputs; ++k) {
    h->outputs[k] = Value();
    h->manifolds[k] = Manifold();
  }
  h->node = nodes - 1;
  if (bind && program.bxdf->begin) {
    uint64_t time = 0;
    {
      const Clock clock(time);
      c->closure = program.bxdf->begin(c);
    }
    counters.nanoseconds[kTimeClosures] += time;
    counters.nanoseconds[kTimeGrouping] -= time;   // runs inside shade()'s clock
  }
  return c;
}

Context* GroupState::pointsInSpace(uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots, const float* t) {
  if (!n) return nullptr;
  const uint32_t m = padded(n);
  uint32_t* slot = arena_.make<uint32_t>(m);
  for (uint32_t i = 0; i < m; ++i) slot[i] = slots[std::min(i, n - 1)];
  Context* c = new (arena_.allocate(sizeof(Context))) Context();
  ContextHost* h = new (arena_.allocate(sizeof(ContextHost))) ContextHost();
  h->group = this;
  h->program = nullptr;
  h->slot = slot;
  c->count = n;
  c->padded = m;
  c->width = world_.width;
  c->traits = traits | kTraitInSpace;
  c->path = slot;
  c->depth = depth;
  c->fn = &kContextFunctions;
  c->host = h;
  PointsArgs a{};
  a.n = m;
  a.slots = slot;
  const Rays& r = group_.rays;
  const auto f = [&] { return arena_.make<float>(m); };
  float *ng[3] = {f(), f(), f()}, *side = f(), *outer = f();
  for (uint32_t i = 0; i < m; ++i) {
    for (int k = 0; k < 3; ++k) ng[k][i] = -r.d[k][slot[i]];
    side[i] = outer[i] = 1.f;
    linkSet_[slot[i]] = 0;   // a medium is lit by all lights
  }
  for (int k = 0; k < 3; ++k) {
    a.o[k] = r.o[k]; a.d[k] = r.d[k]; a.ng[k] = ng[k];
    c->P[k] = a.P[k] = f(); c->N[k] = a.N[k] = f(); c->Ng[k] = a.Ng[k] = f(); c->wo[k] = a.wo[k] = f();
  }
  a.t = t; a.radius = r.radius; a.spread = r.spread; a.time = r.time; a.seed = seed_; a.index = index_;
  a.side = side;
  c->radius = a.outRadius = f();
  c->spread = a.outSpread = f();
  c->time = a.outTime = f();
  c->bias = a.bias = f();
  c->entering = a.entering = arena_.make<uint32_t>(m);
  c->sampleSeed = a.outSeed = arena_.make<uint32_t>(m);
  c->sampleIndex = a.outIndex = arena_.make<uint32_t>(m);
  pointsKernel(world_.width)(a);
  c->outerIor = outer;
  return c;
}

void GroupState::lightSamples(const Context* c, uint32_t part, uint32_t parts, LightSamples* out) {
  const Clock clock(counters.nanoseconds[kTimeLights]);
  float* u[3];
  for (float*& x : u) x = arena_.make<float>(c->padded);
  float* unused = arena_.make<float>(c->padded);
  const uint32_t dim = dimensionAt(c->depth);
  const DrawSplit draw = drawSplit(world_.width);
  draw(world_.samples, c->padded, c->sampleSeed, c->sampleIndex, dim + kDimLightChoice, part, parts, u[0], unused);
  draw(world_.samples, c->padded, c->sampleSeed, c->sampleIndex, dim + kDimLight, part, parts, u[1], u[2]);
  light::LightSet::Points p;
  p.count = c->count;
  p.padded = c->padded;
  for (int k = 0; k < 3; ++k) p.P[k] = c->P[k];
  p.time = c->time;
  uint32_t* sets = arena_.make<uint32_t>(c->padded);
  for (uint32_t i = 0; i < c->padded; ++i) sets[i] = linkSet_[c->path[i]];
  p.linkSet = sets;
  p.uChoice = u[0];
  p.u[0] = u[1];
  p.u[1] = u[2];
  world_.lights->sample(world_.width, arena_, p, out);
}

void GroupState::lightHits(RayKind kind, uint32_t n, const uint32_t* slots, LightHits* out) {
  const Clock clock(counters.nanoseconds[kTimeLights]);
  light::LightSet::RayList l;
  l.count = n;
  l.slots = slots;
  l.rays = &group_.rays;
  l.tHit = group_.hits.t;
  l.linkSet = linkSet_;
  world_.lights->hits(world_.width, arena_, kind == RayKind::Camera, l, out);
}

void GroupState::shadow(uint32_t depth, const ShadowRays* rays) {
  const uint32_t n = rays->count;
  if (!n) return;
  counters.shadowRays += n;
  if (listener) listener->shadow(depth, *rays);
  const Clock clock(counters.nanoseconds[kTimeTraceShadow]);
  const trace::World& w = *world_.world;
  uint32_t* blocked = arena_.make<uint32_t>(padded(n));
  float *radius = nullptr, *spread = nullptr;
  if (w.hasUserGeometry()) {
    // footprints where the paths' own rays ended choose the level
    radius = arena_.make<float>(padded(n));
    spread = arena_.make<float>(padded(n));
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = rays->slot[i];
      const float t = group_.hits.t[s];
      spread[i] = group_.rays.spread[s];
      radius[i] = group_.rays.radius[s] + (std::isinf(t) ? 0.f : t * spread[i]);
    }
  }
  w.occluded(n, rays->o, rays->d, rays->tMax, rays->time, trace::kSeenByOpaqueShadow, blocked, radius, spread);
  for (uint32_t i = 0; i < n; ++i) {
    const float t = blocked[i] ? 0.f : 1.f;
    for (int c = 0; c < 3; ++c) rays->transmittance[c][i] = t;
  }
  if (!w.hasClearShadows()) return;
  // Survivors walk through what lets light pass, nearest first, in a ray list of their own that borrows the group.
  const Rays keepRays = group_.rays;
  const Hits keepHits = group_.hits;
  uint32_t *const keepSeed = seed_, *const keepIndex = index_;
  uint32_t* const keepLinks = linkSet_;
  MediaStack* const keepMedia = media_;
  const uint32_t m = padded(n) + kPad;
  const auto f = [&] { return arena_.make<float>(m); };
  const auto u = [&] { return arena_.make<uint32_t>(m); };
  Rays r;
  Hits h;
  for (int c = 0; c < 3; ++c) {
    r.o[c] = f(); r.d[c] = f(); h.ng[c] = f();
    std::memcpy(r.o[c], rays->o[c], n * 4);
    std::memcpy(r.d[c], rays->d[c], n * 4);
  }
  r.tMax = f(); r.time = f(); r.radius = f(); r.spread = f();
  h.t = f(); h.u = f(); h.v = f();
  h.instance = u(); h.geometry = u(); h.primitive = u(); h.level = u();
  uint32_t *seed = u(), *index = u(), *open = u(), *links = u();
  uint32_t k = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = rays->slot[i];
    r.tMax[i] = rays->tMax[i];
    r.time[i] = rays->time[i];
    r.radius[i] = keepRays.radius[s];
    r.spread[i] = keepRays.spread[s];
    seed[i] = keepSeed[s];
    index[i] = keepIndex[s];
    if (!blocked[i]) open[k++] = i;
  }
  group_.rays = r;
  group_.hits = h;
  seed_ = seed;
  index_ = index;
  linkSet_ = links;
  media_ = nullptr;
  for (int pass = 0; k && pass < kMostPasses; ++pass) {
    w.closest(group_.rays, group_.hits, trace::kSeenByClearShadow, k, open);
    uint32_t* hit = arena_.make<uint32_t>(padded(k));
    uint32_t hitCount = 0;
    for (uint32_t i = 0; i < k; ++i)
      if (!std::isinf(h.t[open[i]])) hit[hitCount++] = open[i];
    Context* const* contexts;
    const uint32_t count = shade(kTraitEyePath | kTraitPresenceQuery, depth, hitCount, hit, &contexts);
    uint32_t* next = arena_.make<uint32_t>(padded(hitCount));
    uint32_t nextCount = 0;
    for (uint32_t c = 0; c < count; ++c) {
      const Context* x = contexts[c];
      float* presence = x->alloc<float>(x->padded);
      if (x->bxdf->presence) x->bxdf->presence(x, presence);
      else std::fill_n(presence, x->padded, 1.f);
      float* keep[3] = {nullptr, nullptr, nullptr};
      if (rays->thin && x->bxdf->thinShadow) {
        for (float*& q : keep) q = x->alloc<float>(x->padded);
        x->bxdf->thinShadow(x, keep);
      }
      for (uint32_t i = 0; i < x->count; ++i) {
        const uint32_t s = x->path[i];
        float most = 0;
        for (int q = 0; q < 3; ++q) {
          const float pass1 = (1.f - presence[i]) + (keep[q] ? presence[i] * keep[q][i] : 0.f);
          rays->transmittance[q][s] *= std::clamp(pass1, 0.f, 1.f);
          most = std::max(most, rays->transmittance[q][s]);
        }
        if (most > 0) next[nextCount++] = s;
      }
    }
    passThrough(nextCount, next, nullptr);
    open = next;
    k = nextCount;
  }
  group_.rays = keepRays;
  group_.hits = keepHits;
  seed_ = keepSeed;
  index_ = keepIndex;
  linkSet_ = keepLinks;
  media_ = keepMedia;
}

void GroupState::cross(const Context* c, uint32_t n, const uint32_t* points) {
  if (!media_ || !c->bxdf->interior) return;
  const ContextHost& h = ContextHost::of(c);
  if (!h.program->encloses) return;
  float* x[4];
  for (float*& y : x) y = c->alloc<float>(c->padded);
  const InteriorArgs a{x[0], {x[1], x[2], x[3]}};
  c->bxdf->interior(c, &a);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = points[i], s = c->path[p];
    MediaStack& m = media_[s];
    const uint32_t object = group_.hits.instance[s];
    if (c->entering[p]) {
      if (m.count == MediaStack::kDepth) {
        ++counters.mediaOverflow;
        continue;
      }
      const PlacementInfo& place = world_.placements[world_.world->instance(object).user];
      const int own = world_.geometries[group_.hits.geometry[s]].priority;
      m.entries[m.count++] = {object, own ? own : place.priority, x[0][p], {x[1][p], x[2][p], x[3][p]}};
    } else {
      for (uint32_t k = m.count; k-- > 0;)
        if (m.entries[k].object == object) {
          for (uint32_t j = k; j + 1 < m.count; ++j) m.entries[j] = m.entries[j + 1];
          --m.count;
          break;
        }
    }
  }
}

struct GroupState::KeptPaths {
  uint32_t n;
  const uint32_t* slots;
  float *t, *u, *v, *ng[3];
  uint32_t *instance, *geometry, *primitive, *level, *linkSet;
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
  if (k.media) put(k.media, media_);
}

}  // namespace kinora::shade
