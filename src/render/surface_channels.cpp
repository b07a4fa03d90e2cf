#include "render/surface_channels.h"

#include <algorithm>
#include <cmath>

#include "shade/surface_points.h"

namespace kinora::render {

using film::Source;

SurfaceChannels::Value SurfaceChannels::constant(float v) const {
  float* x = c_->alloc<float>(1);
  *x = v;
  return {{x, x, x}, 0};
}

SurfaceChannels::Value SurfaceChannels::of(Source source) {
  const auto builtin = [&](Builtin b) {
    const kinora::Value v = c_->builtin(b);
    return Value{{v.data[0], v.data[1], v.data[2]}, v.stride};
  };
  switch (source) {
    case Source::Alpha:
    case Source::Opacity:
      return constant(1);
    case Source::Depth:
    case Source::FiniteDepth:
      return depth();
    case Source::Id:
      return one(builtin(Builtin::ObjectId).data[0]);
    case Source::Id2:
      return id2();
    case Source::P:
      return builtin(Builtin::Pworld);
    case Source::Po:
      return builtin(Builtin::Po);
    case Source::PRadius:
    case Source::RayRadius:
      return one(c_->radius);
    case Source::RaySpread:
      return one(c_->spread);
    case Source::MpSize: {
      float* x = floats();
      for (uint32_t i = 0; i < c_->count; ++i) x[i] = 2 * c_->radius[i];
      return one(x);
    }
    case Source::Nn:
      return three(c_->N);
    case Source::Ngn:
      return three(c_->Ng);
    case Source::Tn:
      return builtin(Builtin::Tangent);
    case Source::Vn:
      return three(c_->wo);
    case Source::VLen:
      return one(c_->distance);
    case Source::Albedo: {
      float* rgb[3] = {floats(), floats(), floats()};
      if (c_->bxdf->albedo) {
        c_->bxdf->albedo(c_, c_->closure, rgb);
      } else {
        for (float* x : rgb) std::fill_n(x, c_->padded, 0.f);
      }
      return three(rgb);
    }
    case Source::Curvature: {
      float* x = floats();
      shade::curvatureOf(c_, x);
      return one(x);
    }
    case Source::U:
      return builtin(Builtin::U);
    case Source::V:
      return builtin(Builtin::V);
    case Source::Du:
      return footprintIn(Builtin::DPdu);
    case Source::Dv:
      return footprintIn(Builtin::DPdv);
    case Source::St:
      return builtin(Builtin::St);
    case Source::S:
      return one(builtin(Builtin::St).data[0]);
    case Source::T:
      return one(builtin(Builtin::St).data[1]);
    case Source::DPdu:
      return builtin(Builtin::DPdu);
    case Source::DPdv:
      return builtin(Builtin::DPdv);
    case Source::DPdtime:
    case Source::DPcameradtime:
    case Source::MotionFore:
    case Source::MotionBack:
      return motion(source);
    case Source::Time:
      return one(c_->time);
    case Source::OutsideIor:
      return one(c_->outerIor);
    case Source::BiasR:
    case Source::BiasT:
      return one(c_->bias);
    case Source::GeometryLevel: {
      float* x = floats();
      for (uint32_t i = 0; i < c_->count; ++i) x[i] = float(c_->place.level[i]);
      return one(x);
    }
    // surfaces have no third parameter; the others are not made here
    case Source::W:
    case Source::Dw:
    case Source::DPdw:
    case Source::LightPath:
    case Source::Primvar:
    case Source::Fallback:
    case Source::CpuTime:
    case Source::SampleCount:
      break;
  }
  return constant(0);
}

void SurfaceChannels::toCamera(const float p[3], float t, float out[3]) const {
  const auto& keys = camera_.fromRender;
  const float x = t * float(keys.size() - 1);
  const size_t k = keys.size() > 1 ? std::min(size_t(x), keys.size() - 2) : 0;
  keys[k].point(p, out);
  if (keys.size() < 2) return;
  float q[3];
  keys[k + 1].point(p, q);
  for (int j = 0; j < 3; ++j) out[j] += (x - float(k)) * (q[j] - out[j]);
}

// Along the camera's axis, at the sample's time.
SurfaceChannels::Value SurfaceChannels::depth() const {
  float* z = floats();
  const uint32_t keys = uint32_t(camera_.fromRender.size());
  for (uint32_t i = 0; i < c_->count; ++i) {
    const float x = c_->time[i] * float(keys - 1);
    const uint32_t k = keys > 1 ? std::min(uint32_t(x), keys - 2) : 0;
    const auto at = [&](const trace::Affine& a) {
      return a.m[2][0] * c_->P[0][i] + a.m[2][1] * c_->P[1][i] + a.m[2][2] * c_->P[2][i] + a.t[2];
    };
    z[i] = at(camera_.fromRender[k]);
    if (keys > 1) z[i] += (x - float(k)) * (at(camera_.fromRender[k + 1]) - z[i]);
  }
  return one(z);
}

SurfaceChannels::Value SurfaceChannels::id2() const {
  float* x = floats();
  const shade::ShadingWorld& w = state_.world();
  const Places& at = c_->place;
  for (uint32_t i = 0; i < c_->count; ++i) {
    x[i] = float(w.placementOf(at.instance[i], at.geometry[i]).objectId2);
  }
  return one(x);
}

SurfaceChannels::Value SurfaceChannels::footprintIn(Builtin derivative) const {
  const kinora::Value d = c_->builtin(derivative);
  float* x = floats();
  for (uint32_t i = 0; i < c_->count; ++i) {
    float l2 = 0;
    for (int k = 0; k < 3; ++k) l2 += d.data[k][d.stride * i] * d.data[k][d.stride * i];
    x[i] = l2 > 0 ? 2 * c_->radius[i] / std::sqrt(l2) : 0.f;
  }
  return one(x);
}

// Change per shutter length: of P, of P in the camera, and of its place in the picture, in pixels.
SurfaceChannels::Value SurfaceChannels::motion(Source source) const {
  constexpr float kStep = 1.f / 64;
  float* d[3] = {floats(), floats(), floats()};
  float *time[2] = {floats(), floats()}, *at[2][3];
  for (uint32_t i = 0; i < c_->padded; ++i) {
    time[0][i] = std::max(0.f, c_->time[i] - kStep);
    time[1][i] = std::min(1.f, c_->time[i] + kStep);
  }
  for (int e = 0; e < 2; ++e) {
    for (float*& x : at[e]) x = floats();
    shade::positionsAt(c_, time[e], at[e]);
  }
  for (uint32_t i = 0; i < c_->count; ++i) {
    float p[2][3];
    for (int e = 0; e < 2; ++e) {
      for (int k = 0; k < 3; ++k) p[e][k] = at[e][k][i];
      if (source == Source::DPdtime) continue;
      float q[3];
      toCamera(p[e], time[e][i], q);
      std::copy_n(q, 3, p[e]);
    }
    for (int k = 0; k < 3; ++k) d[k][i] = (p[1][k] - p[0][k]) / (time[1][i] - time[0][i]);
  }
  if (source == Source::DPdtime || source == Source::DPcameradtime) return three(d);
  return rasterMotion(d, source == Source::MotionBack ? -1.f : 1.f);
}

// The projection says where points are in the picture, but not beyond its border: a short step, on or back, is scaled
// up, and what lies outside already is looked at a little nearer to the axis.
SurfaceChannels::Value SurfaceChannels::rasterMotion(const float* const d[3], float sign) const {
  constexpr float kStep = 1.f / 64, kInside = 0.95f;
  const uint32_t n = c_->padded;
  float *lens = floats(), *o[3] = {floats(), floats(), floats()}, *p[3] = {floats(), floats(), floats()},
        *pdf = floats(), *zero = floats();
  std::fill_n(lens, n, 0.5f);
  std::fill_n(zero, n, 0.f);
  struct Seen {
    float *raster[2], *importance;
  };
  const auto look = [&](float step, float scale) {
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t j = std::min(i, c_->count - 1);
      const float at[3] = {c_->P[0][j], c_->P[1][j], c_->P[2][j]};
      float q[3];
      toCamera(at, c_->time[j], q);
      for (int k = 0; k < 3; ++k) p[k][i] = q[k] * (k < 2 ? scale : 1.f) + step * d[k][j];
    }
    const Seen s{{floats(), floats()}, floats()};
    const CameraConnectArgs args{c_->count,          {p[0], p[1], p[2]},         {lens, lens}, c_->time,
                                 {o[0], o[1], o[2]}, {s.raster[0], s.raster[1]}, s.importance, pdf};
    camera_.functions->connect(camera_.projection.data(), &args);
    return s;
  };
  float* out[2] = {floats(), floats()};
  std::fill_n(out[0], n, 0.f);
  std::fill_n(out[1], n, 0.f);
  uint32_t* done = c_->alloc<uint32_t>(n);
  std::fill_n(done, n, 0u);
  for (const float scale : {1.f, kInside}) {
    const Seen here = look(0, scale);
    for (const float step : {kStep, -kStep}) {
      const Seen there = look(step, scale);
      for (uint32_t i = 0; i < c_->count; ++i) {
        if (done[i] || !(here.importance[i] > 0) || !(there.importance[i] > 0)) continue;
        for (int k = 0; k < 2; ++k) out[k][i] = sign * (there.raster[k][i] - here.raster[k][i]) / step;
        done[i] = 1;
      }
    }
  }
  return {{out[0], out[1], zero}, 1};
}

}  // namespace kinora::render
