#include "shade/medium_light.h"

#include <kinora/sample_table.h>

#include <algorithm>
#include <cmath>

namespace kinora::shade {

namespace {

// A number in [0, 1) that goes with two others.
float thirdNumber(float u, float v) {
  return float(hashWords(uint32_t(u * 16777216.f), uint32_t(v * 16777216.f)) >> 8) * (1.f / 16777216.f);
}

void direction(const trace::Affine& a, const float d[3], float out[3]) {
  for (int r = 0; r < 3; ++r) out[r] = a.m[r][0] * d[0] + a.m[r][1] * d[1] + a.m[r][2] * d[2];
}

void sampleLanes(const LightSampleArgs* a) {
  for (uint32_t i = 0; i < a->count; ++i) {
    const auto& l = *static_cast<const MediumLight*>(a->light[a->lightStride ? i : 0]);
    const float P[3] = {a->P[0][i], a->P[1][i], a->P[2][i]};
    float wi[3] = {0, 0, 1}, t = 0, weight = 0, pdf = 0;
    l.sample(P, a->u[0][i], a->u[1][i], a->time ? a->time[i] : 0.f, wi, t, weight, pdf);
    for (int k = 0; k < 3; ++k) {
      a->wi[k][i] = wi[k];
      a->radiance[k][i] = weight;
    }
    a->distance[i] = t;
    a->pdf[i] = pdf;
    a->flags[i] = 0;
  }
  // what stands behind the last one
  for (uint32_t i = a->count; i < padded(a->count); ++i) {
    for (int k = 0; k < 3; ++k) {
      a->wi[k][i] = a->wi[k][a->count - 1];
      a->radiance[k][i] = 0;
    }
    a->distance[i] = a->distance[a->count - 1];
    a->pdf[i] = 0;
    a->flags[i] = 0;
  }
}

void evaluateNothing(const LightRayArgs* a) {
  for (uint32_t i = 0; i < padded(a->count); ++i) {
    for (float* x : {a->radiance[0], a->radiance[1], a->radiance[2]}) x[i] = 0;
    a->pdf[i] = 0;
  }
}

void emitNothing(const LightEmitArgs* a) {
  for (uint32_t i = 0; i < padded(a->count); ++i) {
    for (int k = 0; k < 3; ++k) {
      a->o[k][i] = a->radiance[k][i] = 0;
      a->d[k][i] = a->N[k][i] = k == 2;
    }
    a->pdfPosition[i] = a->pdfDirection[i] = 1;
  }
}

}  // namespace

MediumLight::MediumLight(const ShadingWorld& world, const SpaceMedium& medium,
                         std::shared_ptr<const volume::EmissionCells> cells)
    : world_(world.world),
      instance_(medium.instance),
      geometry_(medium.geometry),
      moves_(world.world->instance(medium.instance).keyCount >= 2),
      cells_(std::move(cells)) {
  still_ = world.spaceOf(medium.instance, medium.geometry).fromRender;
}

trace::Affine MediumLight::fromRender(float time) const {
  if (!moves_) return still_;
  trace::Affine a = world_->objectToRender(instance_, time).inverse();
  const Imath::V3d& origin = world_->mesh(geometry_).origin;
  for (int k = 0; k < 3; ++k) a.t[k] += float(origin[k]);
  return a;
}

float MediumLight::density(const float o[3], const float d[3], float time) const {
  const trace::Affine a = fromRender(time);
  float p[3], q[3];
  a.point(o, p);
  direction(a, d, q);
  const float density = cells_->along(p, q).squared * std::fabs(a.determinant());
  return density < 1e30f ? density : 0.f;
}

bool MediumLight::sample(const float P[3], float u, float v, float time, float wi[3], float& t, float& weight,
                         float& pdf) const {
  const trace::Affine a = fromRender(time);
  const float third = thirdNumber(u, v);
  float object[3], y[3], length = 0;
  cells_->sample(u, v, third, object);
  a.inverse().point(object, y);
  for (int k = 0; k < 3; ++k) {
    y[k] -= P[k];
    length += y[k] * y[k];
  }
  length = std::sqrt(length);
  if (!(length > 0) || !(length < 1e30f)) return false;
  for (int k = 0; k < 3; ++k) wi[k] = y[k] / length;
  float p[3], q[3], density = 0;
  a.point(P, p);
  direction(a, wi, q);
  const volume::EmissionCells::Along along = cells_->along(p, q);
  if (!(along.line > 0)) return false;
  t = cells_->distance(p, q, thirdNumber(third, u), along, density);
  pdf = along.squared * std::fabs(a.determinant());
  if (!(t > 0) || !(density > 0) || !(pdf > 0) || !(pdf < 1e30f)) {
    t = pdf = 0;
    return false;
  }
  weight = 1 / density;
  return true;
}

void MediumLight::describe(float power, LightDescription& d) const {
  d = {};
  float low[3], high[3];
  cells_->bounds(low, high);
  for (int k = 0; k < 3; ++k) {
    d.low[k] = 1e30f;
    d.high[k] = -1e30f;
  }
  // where it comes through the shutter, in steps
  constexpr int kSteps = 8;
  for (int step = moves_ ? 0 : kSteps; step <= kSteps; ++step) {
    const trace::Affine toRender = fromRender(float(step) / kSteps).inverse();
    for (int corner = 0; corner < 8; ++corner) {
      const float p[3] = {corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1],
                          corner & 4 ? high[2] : low[2]};
      float q[3];
      toRender.point(p, q);
      for (int k = 0; k < 3; ++k) {
        d.low[k] = std::min(d.low[k], q[k]);
        d.high[k] = std::max(d.high[k], q[k]);
      }
    }
  }
  float radius = 0;
  for (int k = 0; k < 3; ++k) {
    d.center[k] = 0.5f * (d.low[k] + d.high[k]);
    radius += (d.high[k] - d.center[k]) * (d.high[k] - d.center[k]);
  }
  d.radius = std::sqrt(radius);
  d.power = power;
  d.isDelta = 1;  // to rays that look for lights
  d.visibleToCamera = 0;
  d.diffuse = d.specular = 1;
}

light::LightKind mediumLightKind() {
  static const LightFunctions functions{&sampleLanes, nullptr, &evaluateNothing, &emitNothing, nullptr, 1};
  light::LightKind kind;
  for (const uint32_t width : {1u, 4u, 8u, 16u}) kind.byWidth[width] = &functions;
  return kind;
}

}  // namespace kinora::shade
