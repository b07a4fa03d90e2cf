// Light that the rays of the forward loop find by themselves: lights that they meet, what media emit along them, lights
// behind glass that tinted shadows stand for. Called by path_loop.h after each trace. Included per target.
#include <kinora/path_state.h>

#if defined(KINORA_PATH_FOUND_LIGHTS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PATH_FOUND_LIGHTS_H_TARGET
#undef KINORA_PATH_FOUND_LIGHTS_H_TARGET
#else
#define KINORA_PATH_FOUND_LIGHTS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
class FoundLights {
 public:
  FoundLights(const PathState<W>& paths) : p_(paths), g_(paths.g), sv_(paths.sv), o_(paths.o) {}

  // Lights met by the rays of `live`; the previous vertex took lightParts light samples and bxdfParts directions.
  void collectLights(RayKind kind, uint32_t depth, uint32_t lightParts, uint32_t bxdfParts, uint32_t n,
                     const uint32_t* live) {
    if (sv_->wantsUnshadowed && kind != RayKind::Camera) collectUnshadowed(depth, lightParts, bxdfParts, n, live);
    LightHits h;
    sv_->lightHits(g_, &g_->paths, kind, n, live, &h);
    if (!h.count) return;
    for (uint32_t i = 0; p_.alpha && i < h.count; ++i)
      if (h.t[i] < 1e30f) p_.flags[h.slot[i]] &= ~PathFlags::kSeenThrough;
    float* value[3];
    for (float*& v : value) v = p_.floats(padded(h.count));
    uint32_t* slot = p_.words(padded(h.count));
    uint32_t* light = p_.words(padded(h.count));
    uint32_t* state = p_.words(padded(h.count));
    uint32_t m = 0;
    for (uint32_t i = 0; i < h.count; ++i) {
      const uint32_t s = h.slot[i];
      if (p_.isLeftOut(p_.flags[s], h.light[i])) continue;
      float v[3];
      found(h, i, depth, lightParts, bxdfParts, afterShadows(depth, s), v);
      for (int c = 0; c < 3; ++c) value[c][m] = v[c];
      slot[m] = s;
      light[m] = h.light[i];
      state[m] = p_.state[s];
      ++m;
    }
    contributeFound({m, slot, {value[0], value[1], value[2]}, state, light});
    if (kind == RayKind::Camera) {
      float* alpha = p_.floats(padded(h.count));
      uint32_t k = 0;
      for (uint32_t i = 0; i < h.count; ++i)
        if (h.blocks[i]) {
          slot[k] = h.slot[i];
          alpha[k++] = 1.f;
        }
      if (k) sv_->cover(g_, k, slot, alpha);
    }
  }

  // What media emit along the rays of `live`, each one of bxdfParts of its vertex.
  void collectGlow(uint32_t depth, uint32_t bxdfParts, uint32_t n, const uint32_t* live) {
    float* const* glow = g_->paths.glow;
    if (!glow[0]) return;
    const uint32_t room = padded(n);
    float* value[3];
    for (float*& v : value) v = p_.floats(room);
    uint32_t *slot = p_.words(room), *light = p_.words(room), *state = p_.words(room), m = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      float v[3];
      for (int c = 0; c < 3; ++c) v[c] = p_.throughput[c][s] * glow[c][s] / float(bxdfParts);
      if (!(v[0] != 0 || v[1] != 0 || v[2] != 0)) continue;
      p_.clampOne(depth, v);
      for (int c = 0; c < 3; ++c) value[c][m] = v[c];
      slot[m] = s;
      light[m] = kNoLight;
      state[m++] = p_.state[s];
    }
    if (m) contributeFound({m, slot, {value[0], value[1], value[2]}, state, light});
  }

  // What glow along new rays is weighed by, see RayList::againstLights.
  void tellAgainstLights(uint32_t lightParts, uint32_t bxdfParts, uint32_t n, const uint32_t* live) {
    if (!p_.againstLights) return;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      p_.againstLights[s] =
          p_.flags[s] & kFromDiscrete || !lightParts ? HUGE_VALF : p_.pdf[s] * (float(bxdfParts) / float(lightParts));
    }
  }

  // Lights behind glass, met by directions that light samples with tinted shadows could have had: straight on too.
  void collectTinted(uint32_t depth, uint32_t lightParts, uint32_t bxdfParts, uint32_t n, const uint32_t* live) {
    if (o_.allowCaustics || !sv_->hasTintedShadows) return;
    uint32_t* list = p_.words(padded(n) + kPad);
    uint32_t asked = 0;
    for (uint32_t i = 0; i < n; ++i)
      if (p_.flags[live[i]] & kFromTintedLight) list[asked++] = live[i];
    if (!asked) return;
    p_.padList(asked, list);
    LightHits h;
    sv_->lightsBeyond(g_, &g_->paths, asked, list, &h);
    if (!h.count) return;
    const uint32_t room = padded(h.count) + kPad;
    float *o[3], *d[3], *T[3], *value[3];
    for (int c = 0; c < 3; ++c) {
      o[c] = p_.floats(room);
      d[c] = p_.floats(room);
      T[c] = p_.floats(room);
      value[c] = p_.floats(room);
    }
    float *tMax = p_.floats(room), *time = p_.floats(room);
    uint32_t *state = p_.words(room), *tinted = p_.words(room);
    const Rays& r = g_->paths.rays;
    for (uint32_t i = 0; i < h.count; ++i) {
      const uint32_t s = h.slot[i];
      for (int c = 0; c < 3; ++c) {
        o[c][i] = r.o[c][s];
        d[c][i] = r.d[c][s];
      }
      tMax[i] = h.t[i] < o_.farthest ? h.t[i] * 0.99999f : o_.farthest;
      time[i] = r.time[s];
      state[i] = p_.state[s];
      tinted[i] =
          sv_->walkBoundCount && p_.flags[s] >> PathFlags::kWalkedShift == 1 && sv_->lightWalks[h.light[i]] ? 2 : 1;
      float v[3];
      found(h, i, depth, lightParts, bxdfParts, afterShadows(depth, s), v);
      for (int c = 0; c < 3; ++c) value[c][i] = v[c];
    }
    const ShadowRun run{nullptr, &g_->paths, h.count};
    const ShadowRays shadow{h.count, {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, tMax, time, h.slot, 1, &run,
                            tinted,  {T[0], T[1], T[2]}};
    sv_->shadow(g_, depth - 1, &shadow);
    for (uint32_t i = 0; i < h.count; ++i)
      for (int c = 0; c < 3; ++c) value[c][i] *= T[c][i];
    const Contributions out{h.count, h.slot, {value[0], value[1], value[2]}, state, h.light, LightKind::Shadowed};
    p_.contribute(out);
  }

 private:
  // Lights along directions that light samples could have had, too, whatever is in the way.
  void collectUnshadowed(uint32_t depth, uint32_t lightParts, uint32_t bxdfParts, uint32_t n, const uint32_t* live) {
    uint32_t* list = p_.words(padded(n) + kPad);
    uint32_t asked = 0;
    for (uint32_t i = 0; i < n; ++i)
      if (!(p_.flags[live[i]] & kFromDiscrete)) list[asked++] = live[i];
    if (!asked) return;
    p_.padList(asked, list);
    LightHits h;
    sv_->lightsAlong(g_, &g_->paths, asked, list, &h);
    if (!h.count) return;
    const uint32_t room = padded(h.count);
    float* value[3] = {p_.floats(room), p_.floats(room), p_.floats(room)};
    uint32_t *slot = p_.words(room), *light = p_.words(room), *state = p_.words(room), m = 0;
    for (uint32_t i = 0; i < h.count; ++i) {
      const uint32_t s = h.slot[i];
      if (p_.isLeftOut(p_.flags[s], h.light[i])) continue;
      float v[3];
      found(h, i, depth, lightParts, bxdfParts, 1, v);
      for (int c = 0; c < 3; ++c) value[c][m] = v[c];
      slot[m] = s;
      light[m] = h.light[i];
      state[m++] = p_.state[s];
    }
    const Contributions out{m, slot, {value[0], value[1], value[2]}, state, light, LightKind::Unshadowed};
    p_.contribute(out);
  }
  // What is left for directions at the last vertices: without shadows light samples have it all.
  float afterShadows(uint32_t depth, uint32_t slot) const {
    return depth > o_.maxIndirectBounces && !(p_.flags[slot] & kFromDiscrete) ? 1.f - o_.unshadowedEnd : 1.f;
  }
  // What light `i` met by a ray brings: its share beside light samples, and the clamp. factor: on the former.
  void found(const LightHits& h, uint32_t i, uint32_t depth, uint32_t lightParts, uint32_t bxdfParts, float factor,
             float v[3]) const {
    const uint32_t s = h.slot[i];
    float w = 1;
    if (!(p_.flags[s] & kFromDiscrete)) {
      // power heuristic over all samples of both techniques
      const float r = h.pdf[i] * float(lightParts) / (p_.pdf[s] * float(bxdfParts));
      w = 1.f / (1.f + r * r);
    }
    w *= depth == 0 ? 1.f : (p_.flags[s] & kFromSpecular) ? h.specular[i] : h.diffuse[i];
    w /= float(bxdfParts);
    if (p_.share) w *= p_.share[s];
    const bool isSpecular = depth && p_.flags[s] & kFromSpecular && h.specularRadiance[0];
    const float* const* radiance = isSpecular ? h.specularRadiance : h.radiance;
    w *= factor;
    for (int c = 0; c < 3; ++c) v[c] = p_.throughput[c][s] * radiance[c][i] * w;
    p_.clampOne(depth, v);
  }

  // Where unshadowed light is wanted, what light samples could have found too is told apart from the rest.
  void contributeFound(const Contributions& all) {
    if (!sv_->wantsUnshadowed) {
      p_.contribute(all);
      return;
    }
    for (const uint32_t kept : {uint32_t(kFromDiscrete), 0u}) {
      const uint32_t room = padded(all.count + 1);
      Contributions part = all;
      uint32_t *slot = p_.words(room), *light = p_.words(room), m = 0;
      uint32_t* state = p_.words(room);
      float* value[3];
      for (int c = 0; c < 3; ++c) part.value[c] = value[c] = p_.floats(room);
      for (uint32_t i = 0; i < all.count; ++i) {
        if ((p_.flags[all.slot[i]] & kFromDiscrete) != kept) continue;
        for (int c = 0; c < 3; ++c) value[c][m] = all.value[c][i];
        slot[m] = all.slot[i];
        light[m] = all.light[i];
        state[m++] = all.state[i];
      }
      part.count = m;
      part.slot = slot;
      part.light = light;
      part.state = state;
      part.kind = kept ? LightKind::Arrives : LightKind::Shadowed;
      p_.contribute(part);
    }
  }

  const PathState<W>& p_;
  Group* g_;
  const Services* sv_;
  const PathLoopOptions& o_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
