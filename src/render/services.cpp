#include "render/services.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "sampling/draw.h"

namespace kinora::render {

RecordPlan planRecord(const film::ChannelLayout& layout, Diagnostics& diagnostics) {
  RecordPlan p;
  SurfaceOutputs& s = p.surface;
  const std::pair<const char*, int SurfaceOutputs::*> known[] = {
      {"a", &SurfaceOutputs::a}, {"z", &SurfaceOutputs::z}, {"P", &SurfaceOutputs::P}, {"Nn", &SurfaceOutputs::Nn},
      {"Ngn", &SurfaceOutputs::Ngn}, {"Vn", &SurfaceOutputs::Vn}, {"albedo", &SurfaceOutputs::albedo},
      {"u", &SurfaceOutputs::u}, {"v", &SurfaceOutputs::v}, {"id", &SurfaceOutputs::id}, {"VLen", &SurfaceOutputs::VLen},
      {"PRadius", &SurfaceOutputs::radius}, {"incidentRaySpread", &SurfaceOutputs::spread},
      {"outsideIOR", &SurfaceOutputs::outsideIor}, {"time", &SurfaceOutputs::time}, {"sampleCount", &SurfaceOutputs::sampleCount},
      {"__Pworld", &SurfaceOutputs::pworld}, {"__Nworld", &SurfaceOutputs::nworld}, {"zfiltered", &SurfaceOutputs::s},
      {"__depth", &SurfaceOutputs::s}};
  for (const film::RecordEntry& e : layout.record()) {
    p.sources.push_back(e.source);
    p.offsets.push_back(e.offset);
    p.widths.push_back(e.width);
    int splat = -1;
    for (int c = 0; c < layout.size(); ++c)
      if (layout[c].splats && (layout[c].source.empty() ? layout[c].name : layout[c].source) == e.source) splat = c;
    p.splatChannel.push_back(splat);
    bool found = film::LightPaths::knows(e.source);
    for (const auto& [name, member] : known)
      if (e.source == name) {
        s.*member = e.offset;
        found = true;
      }
    if (!found)
      diagnostics.warning("DISPLAY-SOURCE", {}, "no output named \"" + e.source + "\" is made by the renderer",
                          "the channel stays black");
  }
  p.floats = layout.recordFloats();
  return p;
}

// Plain functions for the table: each finds the worker through the group.
struct Worker::Calls {
  static Worker& of(Group* g) { return *static_cast<Worker*>(g->host); }
  static void* alloc(Group* g, size_t bytes) { return of(g).state_.arena().allocate(bytes); }
  static void trace(Group* g, RayKind kind, uint32_t depth, uint32_t n, const uint32_t* slots, float* const t[3]) {
    Worker& w = of(g);
    shade::GroupState& s = w.state_;
    s.trace(kind, depth, n, slots, t);
    if (w.print) {
      const uint32_t p = w.printSlot;
      for (uint32_t i = 0; i < n; ++i) {
        if (slots[i] != p) continue;
        char line[512];
        const Rays& r = g->rays;
        if (std::isinf(g->hits.t[p])) {
          std::snprintf(line, sizeof line, "ray %u: from (%.9g %.9g %.9g) along (%.9g %.9g %.9g): escapes", depth, r.o[0][p],
                        r.o[1][p], r.o[2][p], r.d[0][p], r.d[1][p], r.d[2][p]);
        } else {
          const shade::ShadingWorld& sw = s.world();
          const shade::PlacementInfo& place = sw.placements[sw.world->instance(g->hits.instance[p]).user];
          std::snprintf(line, sizeof line,
                        "ray %u: from (%.9g %.9g %.9g) along (%.9g %.9g %.9g): hits '%s' (%s) face %u at distance %.9g", depth,
                        r.o[0][p], r.o[1][p], r.o[2][p], r.d[0][p], r.d[1][p], r.d[2][p],
                        sw.geometries[g->hits.geometry[p]].name.c_str(), place.name.c_str(), g->hits.primitive[p], g->hits.t[p]);
        }
        w.print(line);
      }
    }
  }
  static uint32_t shade(Group* g, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots, Context* const** contexts) {
    Worker& w = of(g);
    const uint32_t count = w.state_.shade(traits, depth, n, slots, contexts);
    if (w.print)
      for (uint32_t c = 0; c < count; ++c)
        for (uint32_t i = 0; i < (*contexts)[c]->count; ++i) {
          const Context& x = *(*contexts)[c];
          if (x.path[i] != w.printSlot) continue;
          char line[512];
          std::snprintf(line, sizeof line, "vertex %u: P (%.9g %.9g %.9g) N (%.9g %.9g %.9g) footprint %.6g %s", depth, x.P[0][i],
                        x.P[1][i], x.P[2][i], x.N[0][i], x.N[1][i], x.N[2][i], x.radius[i],
                        x.entering[i] ? "from outside" : "from inside");
          w.print(line);
        }
    return count;
  }
  static void releaseShading(Group*) {}
  static void lightSamples(Group* g, const Context* c, uint32_t part, uint32_t parts, LightSamples* out) {
    of(g).state_.lightSamples(c, part, parts, out);
  }
  static void lightHits(Group* g, RayKind kind, uint32_t n, const uint32_t* slots, LightHits* out) {
    of(g).state_.lightHits(kind, n, slots, out);
  }
  static void shadow(Group* g, uint32_t depth, const ShadowRays* rays) { of(g).state_.shadow(depth, rays); }
  static void contribute(Group* g, const Contributions* c) { of(g).contribute(c); }
  static void cover(Group* g, uint32_t n, const uint32_t* slots, const float* alpha) {
    Worker& w = of(g);
    if (w.plan_.surface.a < 0) return;
    for (uint32_t i = 0; i < n; ++i) w.records_[size_t(w.plan_.surface.a)][slots[i]] = alpha[i];
  }
  static void cross(Group* g, const Context* c, uint32_t n, const uint32_t* points) { of(g).state_.cross(c, n, points); }
  static const void* keepPaths(Group* g, uint32_t n, const uint32_t* slots) { return of(g).state_.keepPaths(n, slots); }
  static void restorePaths(Group* g, const void* kept) { of(g).state_.restorePaths(kept); }
  static void emitLight(Group* g, uint32_t n, float* const t[3], uint32_t* light) { of(g).emitLight(n, t, light); }
  static void connectCamera(Group* g, const Context* c, CameraConnection* out) { of(g).connectCamera(c, out); }
  static void splat(Group* g, uint32_t n, const float* const raster[2], const float* const value[3], const uint16_t* state) {
    of(g).splat(n, raster, value, state);
  }
  static Context* pointsInSpace(Group* g, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots,
                                const float* t) {
    return of(g).state_.pointsInSpace(traits, depth, n, slots, t);
  }
  static uint16_t event(Group* g, uint32_t type, uint32_t lobe) { return of(g).paths_.event(type | lobe); }
};

Worker::Worker(const shade::ShadingWorld& world, const CameraState& camera, const RecordPlan& plan,
               const film::LightPaths& paths, film::Film& film, uint64_t lightPathsPerPass)
    : state_(world), camera_(camera), plan_(plan), paths_(paths), film_(film), lightPathsPerPass_(lightPathsPerPass) {
  Services& s = services_;
  s.host = this;
  s.samples = world.samples;
  s.paths = paths.states();
  for (int c = 0; c < 3; ++c) s.worldCenter[c] = world.world->center()[c];
  s.worldRadius = world.world->radius();
  s.lightCount = world.lights->size();
  s.alloc = &Calls::alloc;
  s.trace = &Calls::trace;
  s.shade = &Calls::shade;
  s.releaseShading = &Calls::releaseShading;
  s.lightSamples = &Calls::lightSamples;
  s.lightHits = &Calls::lightHits;
  s.shadow = &Calls::shadow;
  s.contribute = &Calls::contribute;
  s.cover = &Calls::cover;
  s.cross = &Calls::cross;
  s.keepPaths = &Calls::keepPaths;
  s.restorePaths = &Calls::restorePaths;
  s.emitLight = &Calls::emitLight;
  s.connectCamera = &Calls::connectCamera;
  s.splat = &Calls::splat;
  s.event = &Calls::event;
  s.pointsInSpace = &Calls::pointsInSpace;
  outputsOfState_.resize(paths.stateCount());
  for (uint32_t k = 0; k < paths.stateCount(); ++k)
    for (uint16_t o : paths.outputs(uint16_t(k))) outputsOfState_[k].emplace_back(plan.offsets[o], plan.splatChannel[o]);
  state_.onPrimary = [this](const Context* c) { primary(c); };
}

void Worker::begin(uint32_t count, StageKind stage) {
  state_.begin(count, stage);
  state_.group().host = this;
  const uint32_t n = state_.group().padded + kPad;
  records_.resize(size_t(plan_.floats));
  for (size_t k = 0; k < records_.size(); ++k) {
    records_[k] = state_.arena().make<float>(n);
    std::memset(records_[k], 0, n * sizeof(float));
  }
  if (plan_.surface.z >= 0) std::fill_n(records_[size_t(plan_.surface.z)], n, INFINITY);
  if (plan_.surface.sampleCount >= 0) std::fill_n(records_[size_t(plan_.surface.sampleCount)], n, 1.f);
}

void Worker::primary(const Context* c) {
  const SurfaceOutputs& o = plan_.surface;
  const auto put = [&](int offset, const float* v) {
    if (offset < 0) return;
    float* r = records_[size_t(offset)];
    for (uint32_t i = 0; i < c->count; ++i) r[c->path[i]] = v[i];
  };
  const auto put3 = [&](int offset, const float* const v[3]) {
    for (int k = 0; k < 3 && offset >= 0; ++k) put(offset + k, v[k]);
  };
  if (o.a >= 0) {
    float* a = records_[size_t(o.a)];
    for (uint32_t i = 0; i < c->count; ++i) a[c->path[i]] = 1.f;
  }
  if (o.z >= 0 || o.s >= 0) {
    // depth along the camera's axis, at the sample's time
    const uint32_t keys = uint32_t(camera_.fromRender.size());
    for (uint32_t i = 0; i < c->count; ++i) {
      const float x = c->time[i] * float(keys - 1);
      const uint32_t k = keys > 1 ? std::min(uint32_t(x), keys - 2) : 0;
      const auto depth = [&](const trace::Affine& a) {
        return a.m[2][0] * c->P[0][i] + a.m[2][1] * c->P[1][i] + a.m[2][2] * c->P[2][i] + a.t[2];
      };
      float z = depth(camera_.fromRender[k]);
      if (keys > 1) z += (x - float(k)) * (depth(camera_.fromRender[k + 1]) - z);
      if (o.z >= 0) records_[size_t(o.z)][c->path[i]] = z;
      if (o.s >= 0) records_[size_t(o.s)][c->path[i]] = z;
    }
  }
  if (o.P >= 0 || o.pworld >= 0) {
    const Value p = c->builtin(Builtin::Pworld);
    put3(o.P, p.data);
    put3(o.pworld, p.data);
  }
  put3(o.Nn, c->N);
  put3(o.nworld, c->N);
  put3(o.Ngn, c->Ng);
  put3(o.Vn, c->wo);
  if (o.albedo >= 0 && c->bxdf->albedo) {
    float* rgb[3];
    for (float*& x : rgb) x = c->alloc<float>(c->padded);
    c->bxdf->albedo(c, c->closure, rgb);
    put3(o.albedo, rgb);
  }
  if (o.u >= 0) put(o.u, c->builtin(Builtin::U).data[0]);
  if (o.v >= 0) put(o.v, c->builtin(Builtin::V).data[0]);
  if (o.id >= 0) put(o.id, c->builtin(Builtin::ObjectId).data[0]);
  put(o.radius, c->radius);
  put(o.spread, c->spread);
  put(o.outsideIor, c->outerIor);
  put(o.time, c->time);
  if (o.VLen >= 0) {
    const Group& g = state_.group();
    float* r = records_[size_t(o.VLen)];
    for (uint32_t i = 0; i < c->count; ++i) r[c->path[i]] = g.hits.t[c->path[i]];
  }
}

void Worker::contribute(const Contributions* c) {
  for (uint32_t i = 0; i < c->count; ++i) {
    const uint32_t s = c->slot[i];
    const float x = c->value[0][i], y = c->value[1][i], z = c->value[2][i];
    for (const auto& [offset, unused] : outputsOfState_[c->state[i]]) {
      records_[size_t(offset)][s] += x;
      records_[size_t(offset) + 1][s] += y;
      records_[size_t(offset) + 2][s] += z;
    }
  }
  if (print)
    for (uint32_t i = 0; i < c->count; ++i) {
      if (c->slot[i] != printSlot) continue;
      char line[256];
      if (c->light[i] == kNoLight)
        std::snprintf(line, sizeof line, "contribution: (%.9g %.9g %.9g) emitted by the surface, state %u", c->value[0][i],
                      c->value[1][i], c->value[2][i], c->state[i]);
      else
        std::snprintf(line, sizeof line, "contribution: (%.9g %.9g %.9g) from light %u, state %u", c->value[0][i], c->value[1][i],
                      c->value[2][i], c->light[i], c->state[i]);
      print(line);
    }
}

void Worker::emitLight(uint32_t n, float* const throughput[3], uint32_t* light) {
  Arena& arena = state_.arena();
  const uint32_t m = padded(n);
  float* u[6];
  for (float*& x : u) x = arena.make<float>(m);
  const DrawSpan draw = drawSpan(state_.world().width);
  const Group& g = state_.group();
  draw(services_.samples, m, g.sampleSeed, g.sampleIndex, kDimFilter, u[0], u[5]);
  draw(services_.samples, m, g.sampleSeed, g.sampleIndex, kDimLens, u[1], u[2]);
  draw(services_.samples, m, g.sampleSeed, g.sampleIndex, kDimLens + 3, u[3], u[4]);
  const float* four[4] = {u[1], u[2], u[3], u[4]};
  state_.world().lights->emit(state_.world().width, arena, n, u[0], four, g.rays.time, g.rays.o, g.rays.d, throughput, light);
  for (uint32_t i = 0; i < n; ++i) {
    g.rays.tMax[i] = 1e30f;
    g.rays.radius[i] = 0;
    g.rays.spread[i] = 0;
  }
  lightRays += n;
}

void Worker::connectCamera(const Context* c, CameraConnection* out) {
  Arena& arena = state_.arena();
  const uint32_t m = c->padded;
  float* x[15];
  for (float*& y : x) y = arena.make<float>(m);
  const DrawSpan draw = drawSpan(state_.world().width);
  draw(services_.samples, m, c->sampleSeed, c->sampleIndex, dimensionAt(c->depth) + kDimUser, x[3], x[4]);
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
  const CameraConnectArgs a{c->count, {x[0], x[1], x[2]}, {x[3], x[4]}, c->time, {x[5], x[6], x[7]}, {x[8], x[9]}, x[10], x[11]};
  camera_.functions->connect(camera_.projection.data(), &a);
  for (uint32_t i = 0; i < m; ++i) {
    const float p[3] = {x[5][i], x[6][i], x[7][i]};
    // an integrator does not know the axis of the camera: the cosine at the lens goes into the importance
    const float v[3] = {x[0][i] - p[0], x[1][i] - p[1], x[2][i] - p[2]};
    const float v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    x[10][i] *= v2 > 0 ? std::max(v[2], 0.f) / std::sqrt(v2) : 0.f;
    if (cut && cut[i]) x[10][i] = 0;
    float q[3];
    at(camera_.toRender, c->time[i]).point(p, q);
    float d2 = 0, d[3];
    for (int k = 0; k < 3; ++k) { d[k] = q[k] - c->P[k][i]; d2 += d[k] * d[k]; }
    const float length = std::sqrt(d2), inv = length > 0 ? 1.f / length : 0.f;
    for (int k = 0; k < 3; ++k) x[12 + k][i] = d[k] * inv;
    x[0][i] = length;
  }
  *out = CameraConnection{{x[12], x[13], x[14]}, x[0], x[10], x[11], {x[8], x[9]}};
}

void Worker::splat(uint32_t n, const float* const raster[2], const float* const value[3], const uint16_t* state) {
  Arena& arena = state_.arena();
  int32_t *px = arena.make<int32_t>(padded(n)), *py = arena.make<int32_t>(padded(n));
  uint32_t* index = arena.make<uint32_t>(padded(n));
  float* v[3];
  for (float*& x : v) x = arena.make<float>(padded(n));
  const float scale = 1.f / float(lightPathsPerPass_ ? lightPathsPerPass_ : 1);
  // channel by channel; states differ by path
  std::vector<int> channels;
  for (uint32_t i = 0; i < n; ++i)
    for (const auto& [offset, channel] : outputsOfState_[state[i]])
      if (channel >= 0 && std::find(channels.begin(), channels.end(), channel) == channels.end()) channels.push_back(channel);
  for (int channel : channels) {
    int m = 0;
    for (uint32_t i = 0; i < n; ++i)
      for (const auto& [offset, c] : outputsOfState_[state[i]]) {
        if (c != channel) continue;
        px[m] = int32_t(std::floor(raster[0][i]));
        py[m] = int32_t(std::floor(raster[1][i]));
        index[m] = i;
        for (int k = 0; k < 3; ++k) v[k][m] = value[k][i] * scale;
        ++m;
      }
    film_.splat({m, channel, px, py, index, v});
  }
}

}  // namespace kinora::render
