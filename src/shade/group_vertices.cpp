// Vertices put aside, and shaded again from their records.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "shade/clock.h"
#include "shade/context_host.h"

namespace kinora::shade {
namespace {

// What a VertexRecord holds. Whatever follows from it in the same world (normals, terminator offsets, materials) is found again.
struct Record {
  float P[3], d[3], ng[3];  // place, direction of the ray that found it, normal as in Hits
  float u, v, distance, time, radius, spread;
  uint32_t instance, geometry, primitive, level;
  uint32_t seed, index;
  uint32_t linkSet,
      media;     // media: in the world's archive; linkSet: of points of media, whose objects know their lights, how
                 // often light was scattered before
  uint32_t how;  // bits from 0: traits, from 9: kind of ray, from 11: RayOrigin, from 14: depth
};
static_assert(sizeof(Record) == sizeof(VertexRecord));
constexpr uint32_t kKeptTraits =
    kTraitEyePath | kTraitLightPath | kTraitPrimaryHit | kTraitSubsurface | kTraitComesOut | kTraitBothEnds;
constexpr uint32_t kOriginMask = kFromDiscrete | kFromSpecular | kFromTransmission;
static_assert(kKeptTraits < 1 << 9 && kOriginMask < 1 << 3);
// Contexts hold points of one of these.
constexpr uint32_t kSameContext = ~(kOriginMask << 11);

uint32_t traitsOf(uint32_t how) { return how & 0x1ff; }
RayKind kindOf(uint32_t how) { return RayKind(how >> 9 & 3); }
uint32_t originOf(uint32_t how) { return how >> 11 & kOriginMask; }
uint32_t depthOf(uint32_t how) { return how >> 14; }

}  // namespace

void GroupState::keepVertices(const Context* c, uint32_t n, const uint32_t* points, VertexRecord* out) {
  const ContextHost& h = ContextHost::of(c);
  const uint32_t how = (c->traits & kKeptTraits) | uint32_t(h.rayKind) << 9 | c->depth << 14;
  uint32_t* media = nullptr;
  if (h.state.media) {
    uint32_t* stacks = arena_.make<uint32_t>(n);
    media = arena_.make<uint32_t>(n);
    for (uint32_t i = 0; i < n; ++i) stacks[i] = h.state.media[points[i]];
    world_.mediaArchive->keep(media_, n, stacks, media);
  }
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = points[i];
    Record r;
    for (int k = 0; k < 3; ++k) {
      r.P[k] = c->P[k][p];
      r.d[k] = -c->wo[k][p];
      r.ng[k] = h.ng[k][p];
    }
    r.u = c->place.u[p];
    r.v = c->place.v[p];
    r.distance = c->distance[p];
    r.time = c->time[p];
    r.radius = c->radius[p];
    r.spread = c->spread[p];
    r.instance = c->place.instance[p];
    r.geometry = c->place.geometry[p];
    r.primitive = c->place.primitive[p];
    r.level = c->place.level[p];
    r.seed = c->sampleSeed[p];
    r.index = c->sampleIndex[p];
    if (c->traits & kTraitInSpace)
      r.linkSet = h.state.bounces ? h.state.bounces[p] - 1 : 0;
    else
      r.linkSet = h.state.linkSet ? h.state.linkSet[p] : 0;
    r.media = media ? media[i] : 0;
    r.how = how | (h.origin[p] & kOriginMask) << 11;
    std::memcpy(&out[i], &r, sizeof r);
  }
}

uint32_t GroupState::makeVertices(uint32_t n, const SurfacePlaces& places, VertexRecord* out, uint32_t* which) {
  const trace::World& w = *world_.world;
  uint32_t count = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t instance = places.instance[i], geometry = places.geometry[i];
    const float u = places.u[i], v = places.v[i];
    if (instance < w.instanceCount() && geometry < w.geometryCount() &&
        places.primitive[i] < w.mesh(geometry).triangleCount() && u >= 0 && v >= 0 && u + v <= 1.0001f &&
        std::isfinite(places.time[i]))
      which[count++] = i;
  }
  if (!count || !out) return count;
  const uint32_t m = padded(count);
  const auto f = [&] { return arena_.make<float>(m); };
  const auto take = [&](const auto* from) {
    auto* x = arena_.make<std::remove_const_t<std::remove_reference_t<decltype(*from)>>>(m);
    if (count == n)
      std::copy_n(from, n, x);
    else
      for (uint32_t i = 0; i < count; ++i) x[i] = from[which[i]];
    std::fill(x + count, x + m, x[count - 1]);
    return x;
  };
  SurfaceArgs a{};
  a.n = m;
  a.world = &world_;
  a.at.instance = take(places.instance);
  a.at.geometry = take(places.geometry);
  a.at.primitive = take(places.primitive);
  a.at.u = take(places.u);
  a.at.v = take(places.v);
  a.time = take(places.time);
  a.isByParameter = world_.placesByParameter;
  if (!a.isByParameter && w.hasUserGeometry()) {  // the finest resolution
    uint32_t* level = arena_.make<uint32_t>(m);
    std::fill_n(level, m, 0u);
    a.at.level = level;
    a.facet = findFacets(*this, a);
  }
  if (a.isByParameter || a.facet) {
    float *quadU = arena_.make<float>(m), *quadV = arena_.make<float>(m);
    findQuadPlaces(*this, a, quadU, quadV);
    a.quad[0] = quadU;
    a.quad[1] = quadV;
  }
  float *P[3] = {f(), f(), f()}, *facet[3] = {f(), f(), f()}, *normal[3] = {f(), f(), f()};
  const SurfaceKernels& k = surfaceKernels(world_.width);
  k.positions(a, P);
  k.facets(a, facet);
  k.normals(a, facet, normal, nullptr);
  uint32_t linkSet = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t p = which[i];
    if (i == 0 || a.at.instance[i] != a.at.instance[i - 1] || a.at.geometry[i] != a.at.geometry[i - 1])
      linkSet = world_.tables.linkSetOfInfo[w.infoOf(a.at.instance[i], a.at.geometry[i])];
    float length = 0;
    for (int x = 0; x < 3; ++x) length += normal[x][i] * normal[x][i];
    length = std::sqrt(length);
    const bool isInside = places.isInside && places.isInside[p];
    const float turn = length > 0 ? world_.geometries[a.at.geometry[i]].side * (isInside ? 1.f : -1.f) / length : 0.f;
    Record r{};
    for (int x = 0; x < 3; ++x) {
      r.P[x] = P[x][i];
      r.d[x] = length > 0 ? turn * normal[x][i] : float(x == 2);
      r.ng[x] = facet[x][i];
    }
    r.u = a.at.u[i];
    r.v = a.at.v[i];
    r.time = a.time[i];
    r.radius = places.radius[p];
    r.instance = a.at.instance[i];
    r.geometry = a.at.geometry[i];
    r.primitive = a.at.primitive[i];
    r.seed = places.sampleSeed[p];
    r.index = places.sampleIndex[p];
    r.linkSet = linkSet;
    r.media = MediaPool::kEmpty;
    r.how = kTraitEyePath | uint32_t(RayKind::Indirect) << 9;
    if (places.from) {
      const Context& from = *places.from;
      const VertexState& around = ContextHost::of(&from).state;
      const uint32_t at = places.fromPoint[p];
      if (around.linkSet && world_.indirectSets && around.linkSet[at] >= world_.indirectSets)
        r.linkSet += world_.indirectSets;
      if (around.media) world_.mediaArchive->keep(media_, 1, &around.media[at], &r.media);
      r.how = (from.traits & (kTraitEyePath | kTraitLightPath)) | kTraitComesOut |
              uint32_t(ContextHost::of(&from).rayKind) << 9 | from.depth << 14;
    }
    std::memcpy(&out[i], &r, sizeof r);
  }
  return count;
}

uint32_t GroupState::shadeVertices(uint32_t n, const VertexRecord* records, Context* const** contexts) {
  return contextsOfRecords(n, records, true, contexts);
}

uint32_t GroupState::contextsOfRecords(uint32_t n, const VertexRecord* records, bool bind,
                                       Context* const** contexts) {
  *contexts = nullptr;
  if (!n) return 0;
  const Clock clock(counters.nanoseconds[kTimeGrouping]);
  RayList& list = *makeRays(n);
  ListHost& host = ListHost::of(list);
  float* reach = arena_.make<float>(list.capacity);
  host.reach = reach;
  uint32_t* how = arena_.make<uint32_t>(n);
  uint32_t* media = host.left.media ? arena_.make<uint32_t>(n) : nullptr;
  const Rays& rays = list.rays;
  const Hits& hits = list.hits;
  for (uint32_t i = 0; i < n; ++i) {
    Record r;
    std::memcpy(&r, &records[i], sizeof r);
    for (int k = 0; k < 3; ++k) {
      rays.o[k][i] = r.P[k];
      rays.d[k][i] = r.d[k];
      hits.ng[k][i] = r.ng[k];
    }
    hits.u[i] = r.u;
    hits.v[i] = r.v;
    hits.t[i] = reach[i] = r.distance;
    rays.tMax[i] = 0;
    rays.time[i] = r.time;
    rays.radius[i] = r.radius;
    rays.spread[i] = r.spread;
    hits.instance[i] = r.instance;
    hits.geometry[i] = r.geometry;
    hits.primitive[i] = r.primitive;
    hits.level[i] = r.level;
    list.sampleSeed[i] = r.seed;
    list.sampleIndex[i] = r.index;
    list.origin[i] = originOf(r.how);
    host.left.linkSet[i] = r.linkSet;
    if (host.left.bounces) host.left.bounces[i] = r.linkSet;  // read for points of media alone
    if (media) media[i] = r.media;
    how[i] = r.how & kSameContext;
  }
  if (media) world_.mediaArchive->take(media_, n, media, host.left.media);

  uint32_t* program = arena_.make<uint32_t>(padded(n));
  uint32_t* order = arena_.make<uint32_t>(n);
  for (uint32_t i = 0; i < n; ++i) order[i] = i;
  const ProgramsArgs args{n, order, hits.instance, hits.geometry, &world_.tables, program};
  programsKernel(world_.width)(args);
  const auto isBefore = [&](uint32_t a, uint32_t b) {
    return program[a] != program[b] ? program[a] < program[b] : how[a] != how[b] ? how[a] < how[b] : a < b;
  };
  if (!std::is_sorted(order, order + n, isBefore)) std::sort(order, order + n, isBefore);
  uint32_t count = 0;
  Context** made = arena_.make<Context*>(n);
  for (uint32_t first = 0, end; first < n; first = end) {
    const uint32_t a = order[first];
    for (end = first + 1; end < n && program[order[end]] == program[a] && how[order[end]] == how[a];) ++end;
    host.kind = kindOf(how[a]);
    made[count++] =
        makeContext(list, program[a], traitsOf(how[a]), depthOf(how[a]), end - first, order + first, bind);
    countLanes(traitsOf(how[a]), depthOf(how[a]), end - first);
  }
  *contexts = made;
  return count;
}

bool GroupState::displace(uint32_t n, const SurfacePlaces& places, const float* const P[3], const float* const N[3],
                          float* const offset[3], float* const normal[3]) {
  bool hasNormals = false;
  const ArenaScope memory(arena_);
  VertexRecord* records = arena_.make<VertexRecord>(n);
  uint32_t* which = arena_.make<uint32_t>(padded(n));
  const uint32_t made = makeVertices(n, places, records, which);
  for (int k = 0; k < 3; ++k) {
    std::fill_n(offset[k], n, 0.f);
    std::fill_n(normal[k], n, 0.f);
  }
  Context* const* contexts = nullptr;
  const uint32_t count = contextsOfRecords(made, records, false, &contexts);
  for (uint32_t i = 0; i < count; ++i) {
    const Context* c = contexts[i];
    ContextHost& h = ContextHost::of(c);
    if (h.program->isMovedByShader) {
      const Value moved = c->param(0);
      const bool isTurned = h.program->nodes.back().params[1].from == ParamSource::From::Connected;
      const Value turned = isTurned ? c->param(1) : Value();
      hasNormals |= isTurned;
      trace::Affine toRender, toObject;
      for (uint32_t j = 0; j < c->count; ++j) {
        if (j == 0 || c->place.instance[j] != c->place.instance[j - 1] || c->time[j] != c->time[j - 1]) {
          toRender = world_.world->objectToRender(c->place.instance[j], c->time[j]);
          toObject = toRender.inverse();
        }
        float way[3];
        for (int k = 0; k < 3; ++k) way[k] = moved.data[k][moved.stride ? j : 0] - c->P[k][j];
        for (int k = 0; k < 3; ++k)
          offset[k][which[c->path[j]]] =
              toObject.m[k][0] * way[0] + toObject.m[k][1] * way[1] + toObject.m[k][2] * way[2];
        for (int k = 0; isTurned && k < 3; ++k)
          for (int i = 0; i < 3; ++i)
            normal[k][which[c->path[j]]] += toRender.m[i][k] * turned.data[i][turned.stride ? j : 0];
      }
      continue;
    }
    if (!h.program->displacement) continue;
    // what feeds the displacement sees the points as they stand in the scene, itself it works in their object's space
    const ProgramNode& terminal = h.program->nodes.back();
    for (const ParamSource& s : terminal.params)
      if (s.from == ParamSource::From::Connected) h.evaluate(c, s.node);
    Context own = *c;
    float *p[3], *ownN[3], *out[3];
    for (int k = 0; k < 3; ++k) {
      own.P[k] = p[k] = arena_.make<float>(c->padded);
      own.N[k] = ownN[k] = arena_.make<float>(c->padded);
      out[k] = arena_.make<float>(c->padded);
      for (uint32_t j = 0; j < c->padded; ++j) {
        p[k][j] = P[k][which[c->path[j]]];
        ownN[k][j] = N[k][which[c->path[j]]];
      }
    }
    h.program->displacement->displace(&own, out);
    for (int k = 0; k < 3; ++k)
      for (uint32_t j = 0; j < c->count; ++j) offset[k][which[c->path[j]]] = out[k][j];
  }
  return hasNormals;
}

}  // namespace kinora::shade
