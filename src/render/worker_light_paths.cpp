// What integrators with paths from the lights ask of a Worker: rays that lights emit, the way back to the camera, and splats.
#include <algorithm>
#include <cmath>

#include "render/services.h"
#include "sampling/draw.h"
#include "trace/geometry_cache.h"

namespace kinora::render {

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
  if (trace::GeometryCache::wasCutShort()) return;  // what was in the way is not known
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
