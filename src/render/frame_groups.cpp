// One group of paths: its samples, their rays, the integrator's turn, and its records as pixels.
#include <algorithm>
#include <cmath>

#include "base/process_age.h"
#include "render/frame_parts.h"
#include "render/shutter.h"
#include "sampling/draw.h"
#include "trace/geometry_cache.h"

namespace kinora::render {

void Frame::addPath(shade::GroupState& s, int x, int y, int sample, uint32_t& n) const {
  s.pixelX()[n] = x;
  s.pixelY()[n] = y;
  s.group().paths.sampleIndex[n] = uint32_t(sample);
  s.group().paths.sampleSeed[n++] = pixelSeed(x, y, in_.seed);
}

// Of a path at a pixel, whose number for it is u: where lines open one after the other, pixels have times of their own.
static float timeOf(const CameraState& camera, float u, int x, int y) {
  const float time = camera.times.empty() ? u : shutterTime(camera.times, u);
  return camera.rolling.rolls() ? camera.rolling.time(x, y, time) : time;
}

void Frame::cameraRays(Worker& w, uint32_t n) {
  shade::GroupState& s = w.state();
  Arena& arena = s.arena();
  const CameraState& camera = in_.world->camera();
  const uint32_t m = padded(n);
  float* x[8];
  for (float*& y : x) y = arena.make<float>(m);
  const DrawSpan draw = drawSpan(in_.world->width());
  const SampleTable& table = w.services().samples;
  for (uint32_t i = n; i < m; ++i) {
    s.pixelX()[i] = s.pixelX()[n - 1];
    s.pixelY()[i] = s.pixelY()[n - 1];
    s.group().paths.sampleIndex[i] = s.group().paths.sampleIndex[n - 1];
    s.group().paths.sampleSeed[i] = s.group().paths.sampleSeed[n - 1];
  }
  draw(table, m, s.group().paths.sampleSeed, s.group().paths.sampleIndex, kDimFilter, x[0], x[1]);
  draw(table, m, s.group().paths.sampleSeed, s.group().paths.sampleIndex, kDimLens, x[2], x[3]);
  draw(table, m, s.group().paths.sampleSeed, s.group().paths.sampleIndex, kDimTime, x[4], x[5]);
  for (uint32_t i = 0; i < m; ++i)
    s.numbers()[i] = uint64_t(int64_t(s.pixelY()[i]) * camera.resolution[0] + s.pixelX()[i]);
  w.filterWeights.resize(in_.ratios.size());
  for (float*& own : w.filterWeights) own = arena.make<float>(m);
  for (uint32_t i = 0; i < m; ++i) {
    film::FilterSample f{0, 0, 1};
    const float u = x[0][i], v = x[1][i];
    if (in_.jitter) f = in_.filter->sample(u, v);
    x[0][i] = float(s.pixelX()[i]) + 0.5f + f.dx;
    x[1][i] = float(s.pixelY()[i]) + 0.5f + f.dy;
    s.weights()[i] = f.weight;
    for (size_t k = 0; k < w.filterWeights.size(); ++k)
      w.filterWeights[k][i] = in_.jitter ? in_.ratios[k].weight(u, v) : 1.f;
    s.group().paths.rays.time[i] = timeOf(camera, x[4][i], s.pixelX()[i], s.pixelY()[i]);
  }
  Rays& r = s.group().paths.rays;
  in_.world->world().world->avoidFlatMoments(r.time, m);
  float* weight = x[6];
  const CameraSampleArgs a{
      n,      {x[0], x[1]}, {x[2], x[3]}, r.time, {r.o[0], r.o[1], r.o[2]}, {r.d[0], r.d[1], r.d[2]},
      weight, r.radius,     r.spread};
  camera.functions->rays(camera.projection.data(), &a);
  for (uint32_t i = n; i < m; ++i) {
    for (int c = 0; c < 3; ++c) {
      r.o[c][i] = r.o[c][n - 1];
      r.d[c][i] = r.d[c][n - 1];
    }
    r.radius[i] = r.radius[n - 1];
    r.spread[i] = r.spread[n - 1];
    weight[i] = weight[n - 1];
  }
  const size_t keys = camera.toRender.size();
  for (uint32_t i = 0; i < m; ++i) {
    trace::Affine t = camera.toRender[0];
    if (keys > 1) {
      const float f = r.time[i] * float(keys - 1);
      const size_t k = std::min(size_t(f), keys - 2);
      const float u = f - float(k);
      const trace::Affine &p = camera.toRender[k], &q = camera.toRender[k + 1];
      for (int c = 0; c < 3; ++c) {
        for (int d = 0; d < 3; ++d) t.m[c][d] = p.m[c][d] + u * (q.m[c][d] - p.m[c][d]);
        t.t[c] = p.t[c] + u * (q.t[c] - p.t[c]);
      }
    }
    float o[3] = {r.o[0][i], r.o[1][i], r.o[2][i]};
    const float d[3] = {r.d[0][i], r.d[1][i], r.d[2][i]};
    float e[3], l2 = 0, last = 1e30f;
    if (!camera.cuts.empty()) {
      float first = 0;
      cutRay(camera.cuts, o, d, first, last);
      if (!(last > first)) first = last = 0;  // nothing is left of it
      for (int c = 0; c < 3; ++c) o[c] += d[c] * first;
      r.radius[i] += r.spread[i] * first;
      last -= first;
    }
    for (int c = 0; c < 3; ++c) {
      r.o[c][i] = t.m[c][0] * o[0] + t.m[c][1] * o[1] + t.m[c][2] * o[2] + t.t[c];
      e[c] = t.m[c][0] * d[0] + t.m[c][1] * d[1] + t.m[c][2] * d[2];
      l2 += e[c] * e[c];
    }
    // cameras may scale; distances are in world units
    const float scale = std::sqrt(l2), inv = scale > 0 ? 1.f / scale : 0.f;
    for (int c = 0; c < 3; ++c) r.d[c][i] = e[c] * inv;
    r.radius[i] *= scale;
    r.tMax[i] = camera.cuts.empty() ? 1e30f : last * scale;
  }
  // the camera's own weight multiplies the path; the filter's weighs the sample in the film
  s.group().rayWeight = weight;
}

void Frame::cameraGroup(Worker& w, uint32_t count, uint32_t stage) {
  shade::GroupState& s = w.state();
  s.group().count = count;
  s.group().padded = padded(count);
  auto& times = times_->byWorker[w.index];
  const uint64_t t0 = now();
  cameraRays(w, count);
  if (teaches_ && learned_) {
    uint32_t* teaches = s.arena().make<uint32_t>(padded(count));
    for (uint32_t i = 0; i < padded(count); ++i)
      teaches[i] = i < count && learned_->teaches(s.pixelX()[i], s.pixelY()[i], int(s.group().paths.sampleIndex[i]));
    s.group().teaches = teaches;
  }
  const uint64_t t1 = now();
  functions_->integrate(in_.integratorData, stage, &s.group(), &w.services());
  times[0] += t1 - t0;
  const uint64_t spent = now() - t1;
  times[1] += spent;
  w.setCpuTime(count, float(double(spent) * 1e-9 / count));
  ++times[3];
}

// Records become pixels.
void Frame::retire(Worker& w, uint32_t count) {
  if (trace::GeometryCache::wasCutShort()) {  // of hiders that do not ask keep()
    isCutShort_ = true;
    return;
  }
  shade::GroupState& s = w.state();
  const uint64_t start = now();
  if (in_.sampleFilters) in_.sampleFilters->run(count, s.pixelX(), s.pixelY(), w.records());
  w.finishRecords(count);
  film::SampleSpan span;
  span.n = int(count);
  span.x = s.pixelX();
  span.y = s.pixelY();
  span.sampleIndex = s.group().paths.sampleIndex;
  span.weight = s.weights();
  span.values = w.values();
  span.zeros = w.zeros();
  span.filterWeights = w.filterWeights.empty() ? nullptr : w.filterWeights.data();
  in_.film->addSamples(span);
  if (in_.noise) addNoise(count, w.values() + in_.noiseOffset, w.tolerances(), s);
  times_->byWorker[w.index][2] += now() - start;
  if (firstGroupAge_.load(std::memory_order_relaxed) < 0) {
    double none = -1;
    firstGroupAge_.compare_exchange_strong(none, processAge());
  }
}

void Frame::addNoise(uint32_t count, const float* const* colour, const float* tolerance, shade::GroupState& s) {
  for (uint32_t i = 0; i < count; ++i) {
    const int x = s.pixelX()[i], y = s.pixelY()[i];
    const int64_t block = in_.active->indexOf(x, y);
    if (block < 0) continue;
    const float rgb[3] = {colour[0][i], colour[1][i], colour[2][i]};
    in_.noise->add(size_t(block), y % kBlock * kBlock + x % kBlock, rgb, tolerance ? tolerance[i] : 1.f);
  }
}

void Frame::lightPaths(Worker& w, uint64_t firstPath, uint32_t count, int sample, uint32_t stage) {
  w.begin(std::max(in_.groupSize, padded(count)), StageKind::LightPaths);
  shade::GroupState& s = w.state();
  s.group().count = count;
  s.group().padded = padded(count);
  Arena& arena = s.arena();
  const uint32_t m = padded(count);
  float *u = arena.make<float>(m), *v = arena.make<float>(m);
  float* weight = arena.make<float>(m);
  uint32_t* timeSeed = arena.make<uint32_t>(m);
  const auto& resolution = in_.world->camera().resolution;
  const uint64_t columns = uint64_t(resolution[0]), pixels = columns * uint64_t(resolution[1]);
  for (uint32_t i = 0; i < m; ++i) {
    const uint64_t path = firstPath + std::min(i, count - 1);
    s.numbers()[i] = path;
    s.pixelX()[i] = int32_t(path & 0xffffffff);
    s.pixelY()[i] = int32_t(path >> 32) + 0x40000000;  // no pixel's address
    s.group().paths.sampleIndex[i] = uint32_t(sample);
    s.group().paths.sampleSeed[i] = pixelSeed(s.pixelX()[i], s.pixelY()[i], in_.seed);
    weight[i] = 1;
    // the time of the camera path of that number, so that the two can be connected
    const uint64_t pixel = path % pixels;
    timeSeed[i] = pixelSeed(int32_t(pixel % columns), int32_t(pixel / columns), in_.seed);
  }
  drawSpan(in_.world->width())(w.services().samples, m, timeSeed, s.group().paths.sampleIndex, kDimTime, u, v);
  const CameraState& camera = in_.world->camera();
  for (uint32_t i = 0; i < m; ++i) {
    const uint64_t pixel = camera.rolling.rolls() ? s.numbers()[i] % pixels : 0;
    s.group().paths.rays.time[i] = timeOf(camera, u[i], int(pixel % columns), int(pixel / columns));
  }
  in_.world->world().world->avoidFlatMoments(s.group().paths.rays.time, m);
  s.group().rayWeight = weight;
  const uint64_t start = now();
  functions_->integrate(in_.integratorData, stage, &s.group(), &w.services());
  auto& spent = times_->byWorker;
  if (w.index < spent.size()) spent[w.index][1] += now() - start;  // a replay keeps no times
}

}  // namespace kinora::render
