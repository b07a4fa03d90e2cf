// Hits become shading contexts: counting sort by program, points and normals in render space, room for the network.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/clock.h"
#include "shade/context_host.h"
#include "shade/points.h"
#include "shade/where.h"

namespace kinora::shade {

uint32_t GroupState::shade(uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots,
                           Context* const** contexts) {
  *contexts = nullptr;
  if (!n) return 0;
  const bool query = traits & kTraitPresenceQuery;
  uint64_t unused = 0;  // queries happen inside the time of tracing
  const Clock clock(query ? unused : counters.nanoseconds[kTimeGrouping]);
  // Counting sort by program; within a program the order of the list stays.
  uint32_t* programOf = arena_.make<uint32_t>(padded(n));
  const ProgramsArgs programsArgs{n, slots, group_.hits.instance, &world_.tables, programOf};
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

// A context of the listed slots with room for its points, and what the kernel of points reads of the group and writes
// there. The distances, normals and sides are the caller's.
PointsArgs GroupState::startContext(uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots, Context*& c) {
  const uint32_t m = padded(n);
  const auto f = [&] { return arena_.make<float>(m); };
  const auto u = [&] { return arena_.make<uint32_t>(m); };
  uint32_t* slot = u();
  std::memcpy(slot, slots, n * sizeof(uint32_t));
  for (uint32_t i = n; i < m; ++i) slot[i] = slots[n - 1];
  c = new (arena_.allocate(sizeof(Context))) Context();
  ContextHost* h = new (arena_.allocate(sizeof(ContextHost))) ContextHost();
  h->group = this;
  h->rayKind = rayKind_;
  h->slot = slot;
  c->count = n;
  c->padded = m;
  c->width = world_.width;
  c->traits = traits;
  c->path = slot;
  c->depth = depth;
  c->fn = &kContextFunctions;
  c->host = h;
  PointsArgs a{};
  a.n = m;
  a.slots = slot;
  const Rays& r = group_.rays;
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
  a.seed = seed_;
  a.index = index_;
  c->radius = a.outRadius = f();
  c->spread = a.outSpread = f();
  c->time = a.outTime = f();
  c->bias = a.bias = f();
  c->entering = a.entering = u();
  c->sampleSeed = a.outSeed = u();
  c->sampleIndex = a.outIndex = u();
  return a;
}

Context* GroupState::makeContext(uint32_t programIndex, uint32_t traits, uint32_t depth, uint32_t n,
                                 const uint32_t* slots, bool bind) {
  const Program& program = world_.materials->program(programIndex);
  const trace::World& w = *world_.world;
  Context* c;
  PointsArgs a = startContext(traits, depth, n, slots, c);
  const uint32_t m = c->padded;
  const uint32_t* slot = c->path;
  ContextHost* h = static_cast<ContextHost*>(c->host);
  h->program = &program;
  const Rays& r = group_.rays;
  const Hits& hits = group_.hits;
  a.t = hits.t;
  float* ng[3];
  for (int k = 0; k < 3; ++k) {
    ng[k] = arena_.make<float>(m);
    a.ng[k] = ng[k];
  }
  float* side = arena_.make<float>(m);
  uint32_t* block = arena_.make<uint32_t>(m);
  // what a ray only passes does not choose its lights
  SurfacesArgs surfaces{m,
                        slot,
                        hits.instance,
                        hits.geometry,
                        {hits.ng[0], hits.ng[1], hits.ng[2]},
                        &world_.tables,
                        bind && world_.hasLinks ? linkSet_ : nullptr,
                        block,
                        side,
                        {ng[0], ng[1], ng[2]},
                        0,
                        0};
  const uint32_t indirect = bind && depth > 0 ? world_.indirectSets : 0;
  uint32_t* hadDiffuse = indirect ? arena_.make<uint32_t>(padded(n)) : nullptr;
  for (uint32_t i = 0; i < n && indirect; ++i)  // at the vertex before, or on the way from it
    hadDiffuse[i] = linkSet_[slot[i]] >= indirect || !(group_.origin[slot[i]] & (kFromDiscrete | kFromSpecular));
  surfacesKernel(world_.width)(surfaces);
  for (uint32_t i = 0; i < n && indirect; ++i)
    if (hadDiffuse[i]) linkSet_[slot[i]] += indirect;
  const bool smooth = surfaces.anyFlags & kHasNormals, placed = surfaces.anyPlaced;
  h->hasQuads = surfaces.anyFlags & kHasQuads;
  float* nn[3] = {nullptr, nullptr, nullptr};
  if (smooth || placed) {
    if (smooth) {
      for (int k = 0; k < 3; ++k) nn[k] = arena_.make<float>(m);
      if (h->hasQuads) h->findQuadPlaces(c);
    }
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
        float b[4] = {b0, b1, b2, 0};
        uint32_t quad = geometry::Mesh::kNoQuad;
        int corners = 3;
        if (h->hasQuads && h->quadPlaces[0][i] >= 0) {
          const float x = h->quadPlaces[0][i], y = h->quadPlaces[1][i];
          const float bilinear[4] = {(1.f - x) * (1.f - y), x * (1.f - y), x * y, (1.f - x) * y};
          std::memcpy(b, bilinear, sizeof b);
          quad = mesh.quadOf(t);
          corners = 4;
        }
        size_t at[4];
        for (int k = 0; k < corners; ++k) {
          const size_t corner = corners == 4 ? geometry::Mesh::quadCorner(quad, k) : 3 * size_t(t) + size_t(k);
          at[k] = p.rate == geometry::Primvar::Rate::PerVertex   ? mesh.indices[corner]
                  : p.rate == geometry::Primvar::Rate::PerCorner ? corner
                  : p.rate == geometry::Primvar::Rate::PerFace   ? mesh.faceOf(t)
                                                                 : 0;
        }
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
        for (int k = 0; k < corners; ++k)
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
        const float l2 = sm[0] * sm[0] + sm[1] * sm[1] + sm[2] * sm[2];
        const float inv = l2 > 0 ? 1.f / std::sqrt(l2) : 0.f;
        // "N" of the mesh is oriented outward already; zero: the facet's, as in a context without any normals
        for (int k = 0; k < 3; ++k) nn[k][i] = sm[k] * inv;
      }
    }
  }
  const auto pad = [&](float* x) {
    for (uint32_t i = n; i < m; ++i) x[i] = x[n - 1];
  };
  for (int k = 0; k < 3; ++k) {
    if (placed) pad(ng[k]);
    if (nn[k]) pad(nn[k]);
    a.smooth[k] = nn[k];
  }
  a.side = side;
  h->block = block;
  pointsKernel(world_.width)(a);
  if (w.hasStrands()) biasOfStrands(m, slot, a.bias);
  if (bind && lift_[0]) {
    if (program.encloses)
      for (int k = 0; k < 3; ++k)
        for (uint32_t i = 0; i < n; ++i) lift_[k][slot[i]] = 0;
    else
      findLifts(m, slot, c, a.Ng);
  }
  if (bind && leftNg_[0])
    for (uint32_t i = 0; i < n; ++i)
      for (int k = 0; k < 3; ++k) leftNg_[k][slot[i]] = a.Ng[k][i];
  if (bind) setLightNormals(c, &program);
  if (bind && traceSet_)
    for (uint32_t i = 0; i < n; ++i)
      traceSet_[slot[i]] = world_.placements[w.instance(hits.instance[slot[i]]).user].traceSet;

  float* outer = arena_.make<float>(m);
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
  c->tintedSlots = program.tintedSlots;
  c->traits |= (program.encloses ? kTraitEncloses : 0u) | (program.tints ? kTraitTinted : 0u);
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
    counters.nanoseconds[kTimeGrouping] -= time;  // runs inside shade()'s clock
  }
  return c;
}

void GroupState::biasOfStrands(uint32_t n, const uint32_t* slots, float* bias) const {
  const trace::World& w = *world_.world;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots[i];
    const geometry::Mesh& mesh = w.mesh(group_.hits.geometry[s]);
    if (!mesh.isStrand()) continue;
    float radius =
        strandRadius(mesh, group_.hits.primitive[s], group_.hits.u[s], std::clamp(group_.rays.time[s], 0.f, 1.f));
    if (!w.instance(group_.hits.instance[s]).baked) {
      const trace::Affine a = w.objectToRender(group_.hits.instance[s], group_.rays.time[s]);
      radius *= std::sqrt(a.m[0][0] * a.m[0][0] + a.m[1][0] * a.m[1][0] + a.m[2][0] * a.m[2][0]);
    }
    bias[i] = std::max(bias[i], 1e-3f * radius);
  }
}

Context* GroupState::pointsInSpace(uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots,
                                   const float* t) {
  if (!n) return nullptr;
  Context* c;
  PointsArgs a = startContext(traits | kTraitInSpace, depth, n, slots, c);
  const uint32_t m = c->padded;
  const uint32_t* slot = c->path;
  const Rays& r = group_.rays;
  const auto f = [&] { return arena_.make<float>(m); };
  float *ng[3] = {f(), f(), f()}, *side = f(), *outer = f();
  for (uint32_t i = 0; i < m; ++i) {
    for (int k = 0; k < 3; ++k) ng[k][i] = -r.d[k][slot[i]];
    side[i] = outer[i] = 1.f;
    linkSet_[slot[i]] = 0;  // a medium is lit by all lights
    if (traceSet_) traceSet_[slot[i]] = 0;
    if (lift_[0])
      for (int k = 0; k < 3; ++k) lift_[k][slot[i]] = 0;
  }
  for (int k = 0; k < 3; ++k) a.ng[k] = ng[k];
  a.t = t;
  a.side = side;
  pointsKernel(world_.width)(a);
  setLightNormals(c, nullptr);
  c->outerIor = outer;
  return c;
}

}  // namespace kinora::shade
