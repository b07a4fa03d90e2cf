// LightSet: light paths, and what their weights ask of lights that other paths found.
#include <algorithm>

#include "light/light_set_order.h"

namespace kinora::light {

void LightSet::emitFrom(uint32_t width, Arena& arena, uint32_t n, const uint32_t* chosen, const float* const u[4],
                        const float* time, const Emission& out) const {
  const Order order(*this, width, arena, n, chosen);
  const float* in[5] = {order.take(u[0]), order.take(u[1]), order.take(u[2]), order.take(u[3]), order.take(time)};
  float* outputs[14];
  for (int c = 0; c < 3; ++c) {
    outputs[c] = out.o[c];
    outputs[3 + c] = out.d[c];
    outputs[6 + c] = out.N[c];
    outputs[9 + c] = out.radiance[c];
  }
  outputs[12] = out.pdfPosition;
  outputs[13] = out.pdfDirection;
  float* ordered[14];
  for (int k = 0; k < 14; ++k) ordered[k] = order.room(outputs[k]);
  for (uint32_t r = 0; r < order.runCount(); ++r) {
    const LightOrder::Run& run = order.run(r);
    LightEmitArgs a{};
    order.setLights(a, run);
    setWorld(a);
    a.count = run.count;
    for (int k = 0; k < 4; ++k) a.u[k] = in[k] + run.from;
    a.time = in[4] ? in[4] + run.from : nullptr;
    for (int c = 0; c < 3; ++c) {
      a.o[c] = ordered[c] + run.from;
      a.d[c] = ordered[3 + c] + run.from;
      a.N[c] = ordered[6 + c] + run.from;
      a.radiance[c] = ordered[9 + c] + run.from;
    }
    a.pdfPosition = ordered[12] + run.from;
    a.pdfDirection = ordered[13] + run.from;
    kinds_[run.kind].byWidth[width]->emit(&a);
  }
  for (int k = 0; k < 14; ++k) order.put(ordered[k], outputs[k]);
  fromRest(n, chosen, time, LightVector::Point, out.o);
  fromRest(n, chosen, time, LightVector::Direction, out.d);
  fromRest(n, chosen, time, LightVector::Direction, out.N);
}

void LightSet::emit(uint32_t width, Arena& arena, uint32_t n, const float* uChoice, const float* const u[4],
                    const float* time, float* const o[3], float* const d[3], EmittedLight* out) const {
  const uint32_t room = padded(n) + kPad;
  const auto floats = [&] {
    float* x = arena.make<float>(room);
    std::fill_n(x, room, 0.f);
    return x;
  };
  float *N[3], *pdfPosition = floats(), *pdfDirection = floats();
  uint32_t *light = arena.make<uint32_t>(room), *flags = arena.make<uint32_t>(room);
  float *diffuse = floats(), *specular = floats();
  out->diffuse = diffuse;
  out->specular = specular;
  for (int c = 0; c < 3; ++c) {
    out->throughput[c] = floats();
    out->N[c] = N[c] = floats();
  }
  out->light = light;
  out->pdfPosition = pdfPosition;
  out->pdfDirection = pdfDirection;
  out->flags = flags;
  std::fill_n(light, room, kNoLight);
  std::fill_n(flags, room, 0u);
  // light paths come from all lights
  if (!tree_.topCount() || !n) return;
  uint32_t* chosen = arena.make<uint32_t>(room);
  for (uint32_t i = 0; i < n; ++i)
    chosen[i] = uint32_t(
        std::min<size_t>(size_t(std::upper_bound(emission_.begin(), emission_.end(), uChoice[i]) - emission_.begin()),
                         emission_.size() - 1));
  for (uint32_t i = n; i < padded(n); ++i) chosen[i] = chosen[n - 1];
  float* radiance[3] = {floats(), floats(), floats()};
  emitFrom(width, arena, n, chosen, u, time, {o, d, N, radiance, pdfPosition, pdfDirection});
  // a factor that depends on the lit point is not known yet
  filterRadiance(width, arena, n, chosen, o, d, time, time, nullptr, radiance, FilterUse::EmittedRays);
  for (uint32_t i = 0; i < n; ++i) {
    light[i] = chosen[i];
    flags[i] = endFlags(chosen[i]);
    diffuse[i] = recordOf(chosen[i]).diffuse;
    specular[i] = recordOf(chosen[i]).specular;
    float cosine = 0;
    for (int c = 0; c < 3; ++c) cosine += d[c][i] * N[c][i];
    const float choice = emissionOf(chosen[i]), pdf = pdfPosition[i] * pdfDirection[i] * choice;
    pdfPosition[i] *= choice;
    const float scale = pdf > 0 && cosine > 0 ? cosine / pdf : 0.f;
    for (int c = 0; c < 3; ++c) out->throughput[c][i] = radiance[c][i] * scale;
  }
}

void LightSet::ends(uint32_t width, Arena& arena, const Points& p, LightEnds* end) const {
  const uint32_t n = p.count, room = padded(n) + kPad;
  float *pdf = arena.make<float>(room), *N[3], *pdfPosition = arena.make<float>(room),
        *pdfDirection = arena.make<float>(room);
  uint32_t* flags = arena.make<uint32_t>(room);
  for (int c = 0; c < 3; ++c) end->N[c] = N[c] = arena.make<float>(room);
  end->pdf = pdf;
  end->pdfPosition = pdfPosition;
  end->pdfDirection = pdfDirection;
  end->flags = flags;
  for (uint32_t i = 0; i < room; ++i) {
    pdf[i] = pdfPosition[i] = pdfDirection[i] = 0;
    flags[i] = i < n && end->light[i] != kNoLight ? endFlags(end->light[i]) : 0u;
    for (float* x : N) x[i] = 0;
  }
  if (!n) return;
  const Arena::Mark mark = arena.mark();
  // inputs need not be padded
  const auto taken = [&](const float* x) {
    float* y = arena.make<float>(room);
    std::copy_n(x, n, y);
    padFloats(y, n);
    return static_cast<const float*>(y);
  };
  uint32_t* light = arena.make<uint32_t>(room);
  for (uint32_t i = 0; i < room; ++i) light[i] = end->light[std::min(i, n - 1)];
  const float* const d[3] = {taken(end->d[0]), taken(end->d[1]), taken(end->d[2])};
  const float* inputs[8] = {};
  toRest(arena, n, light, p.time, LightVector::Point, p.P, inputs);
  toRest(arena, n, light, p.time, LightVector::Direction, d, inputs + 3);
  inputs[6] = taken(end->t);
  inputs[7] = p.time;
  float* choice = arena.make<float>(room);
  {
    // of no light there is no choice to be known
    uint32_t* known = arena.make<uint32_t>(room);
    for (uint32_t i = 0; i < room; ++i) known[i] = light[i] != kNoLight ? light[i] : 0u;
    probabilities(width, p, known, choice);
  }
  float* unused[3];
  for (float*& x : unused) x = arena.make<float>(room);
  const Order order(*this, width, arena, n, light);
  const float* in[8];
  for (int k = 0; k < 8; ++k) in[k] = order.take(inputs[k]);
  float* const outputs[6] = {pdf, N[0], N[1], N[2], pdfPosition, pdfDirection};
  float *ordered[6], *radiance[3];
  for (int k = 0; k < 6; ++k) ordered[k] = order.room(outputs[k]);
  for (int c = 0; c < 3; ++c) radiance[c] = order.room(unused[c]);
  for (uint32_t r = 0; r < order.runCount(); ++r) {
    const LightOrder::Run& run = order.run(r);
    const uint32_t at = run.from;
    const LightFunctions& f = *kinds_[run.kind].byWidth[width];
    LightRayArgs a{};
    LightDensityArgs b{};
    order.setLights(a, run);
    order.setLights(b, run);
    setWorld(a);
    setWorld(b);
    a.count = b.count = run.count;
    for (int c = 0; c < 3; ++c) {
      a.o[c] = b.o[c] = in[c] + at;
      a.d[c] = b.d[c] = in[3 + c] + at;
      a.radiance[c] = radiance[c] + at;
      b.N[c] = ordered[1 + c] + at;
    }
    a.t = const_cast<float*>(in[6]) + at;
    b.t = in[6] + at;
    a.time = b.time = in[7] + at;
    a.pdf = ordered[0] + at;
    b.pdfPosition = ordered[4] + at;
    b.pdfDirection = ordered[5] + at;
    f.evaluate(&a);
    if (f.densities) {
      f.densities(&b);
      continue;
    }
    for (int c = 0; c < 3; ++c)
      for (uint32_t i = 0; i < run.count; ++i) b.N[c][i] = -b.d[c][i];
    std::fill_n(b.pdfPosition, run.count, 0.f);
    std::fill_n(b.pdfDirection, run.count, 0.f);
  }
  for (int k = 0; k < 6; ++k) order.put(ordered[k], outputs[k]);
  fromRest(n, light, p.time, LightVector::Direction, N);
  for (uint32_t i = 0; i < n; ++i) {
    if (light[i] == kNoLight) continue;
    pdf[i] = flags[i] & kLightIsDelta ? choice[i] : pdf[i] * choice[i];
    // no light path goes from a light to what it is not linked to
    const bool isLit = links_.areAllWhole() || !p.linkSet || isLinked(p.linkSet[i], light[i]);
    pdfPosition[i] *= isLit ? emissionOf(light[i]) : 0.f;
  }
  arena.release(mark);
}

}  // namespace kinora::light
