// The forward path loop: next-event estimation and bxdf sampling with multiple importance sampling, over one group of
// camera samples. Stock integrators are thin settings over it; authors may use it, or copy the way it calls the
// services. Included per target.
#include <kinora/clamp_luminance.h>
#include <kinora/cover_by_media.h>
#include <kinora/guiding.h>
#include <kinora/integrator.h>
#include <kinora/light_candidates.h>
#include <kinora/manifold.h>
#include <kinora/math/sampling.h>
#include <kinora/random.h>
#include <kinora/ray_start.h>
#include <kinora/refracted_alpha.h>
#include <kinora/samples_by_lobe.h>
#include <kinora/scatter_once.h>
#include <kinora/subsurface.h>

#include <cmath>

#ifndef KINORA_PATH_LOOP_ONCE
#define KINORA_PATH_LOOP_ONCE
namespace kinora {
struct PathLoopOptions {
  uint32_t maxIndirectBounces = 8;  // 0: direct light only
  uint32_t lightSamples = 1;        // at camera hits; deeper vertices take one
  uint32_t indirectSamples = 1;     // directions followed from each camera hit
  SamplesByLobe byLobe;             // instead of that
  uint32_t lightCandidates = 1;     // of which each light sample there is one, see kinora/light_candidates.h
  uint32_t clampDepth = 2;          // ray depth (camera ray: 0) from which contributions are clamped
  float clampLuminance = 10;        // largest luminance of one contribution there
  float clampDirect = 1e30f;        // and before, but of lights that the camera sees
  float clampCaustic = 1e30f;       // of what manifold walks bring, if that is less
  float emission = 1;               // factor on what surfaces emit
  float farthest = 1e30f;           // surfaces this far from where an indirect or shadow ray starts are not met
  float unshadowedEnd = 0;          // how much of their shadows light samples at the last vertices leave out, to 1
  bool refractsAlpha = false;       // see kinora/refracted_alpha.h
  int32_t mostPassed = -1;          // Group::mostPassed; -1: no limit
  uint32_t rouletteDepth = 4;       // vertex from which Russian roulette is played
  float rouletteThreshold = 0.2f;   // on paths whose throughput is below
  // Light found through a mirror or lens after a diffuse bounce counts. Otherwise shadow rays go straight through
  // glass and take its tint; what refracted paths then find of the same light is left out.
  bool allowCaustics = false;
  bool guides = false;        // directions by what the frame has learned, see kinora/guiding.h
  bool learnsLights = false;  // which lights are worth a sample, region by region
  guiding::Options guiding;
  // IntegratorTraits::tellsLobesApart
  bool tellsLobesApart() const { return byLobe.given || refractsAlpha; }
  // Manifold walks find the light of its `cheapCaustics` lights behind walkable surfaces, whatever allowCaustics says.
  ManifoldOptions manifold;
};
}  // namespace kinora
#endif

#if defined(KINORA_PATH_LOOP_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PATH_LOOP_H_TARGET
#undef KINORA_PATH_LOOP_H_TARGET
#else
#define KINORA_PATH_LOOP_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Footprint growth after a bounce: a direction of density pdf stands for the solid angle 1 / pdf; a quarter of that
// cone's radius keeps neighbouring paths' footprints overlapping (path differentials collapsed to a radius).
template <int W>
KN_INLINE Float<W> spreadAfter(Float<W> spread, Float<W> pdf) {
  const Float<W> cone = Float<W>(0.25f) / sqrt(max(pdf * Float<W>(kPi), Float<W>(0.25f)));
  return max(spread, cone);
}

template <int W>
class PathLoop {
 public:
  PathLoop(Group* group, const Services* services, const PathLoopOptions& options)
      : g_(group), sv_(services), o_(options), walks_(group, services, options.manifold) {
    const uint32_t n = g_->padded + kPad;
    for (int c = 0; c < 3; ++c) {
      throughput_[c] = floats(n);
      medium_[c] = sv_->hasMedia ? floats(n) : nullptr;
      firstThroughput_[c] = nullptr;
    }
    pdf_ = floats(n);
    state_ = words(n);
    flags_ = g_->paths.origin;
    // Where lights are weighed along the ray from within, nothing else may take from them on the way.
    if (!sv_->mediaScatter && (o_.allowCaustics || !sv_->hasTintedShadows))
      for (float*& x : within_) x = floats(n);
    if (o_.guides) {
      const auto* state = static_cast<const guiding::State*>(sv_->learned(g_));
      if (state && state->guides) {
        guide_ = state;
        reference_ = floats(n);
      }
      if (g_->teaches && !(state && state->isIdle))
        lessons_ = new (sv_->alloc(g_, sizeof(Lessons<W>))) Lessons<W>(g_, sv_);
    }
    if (o_.learnsLights && sv_->lightCount > 1) {
      static constexpr float kOnes[kLightClusters] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
      lightState_ = static_cast<const guiding::State*>(sv_->learned(g_));
      g_->lightWeights = lightState_ ? lightState_->floats(lightState_->lightWeights) : kOnes;
    }
    for (int c = 0; c < 3; ++c) g_->paths.throughput[c] = throughput_[c];
    if (o_.refractsAlpha) alpha_ = new (sv_->alloc(g_, sizeof(RefractedAlpha))) RefractedAlpha(g_, sv_);
    if (o_.mostPassed >= 0) g_->mostPassed = uint32_t(o_.mostPassed);
    if (sv_->mediaScatter) {
      share_ = floats(n);
      if (g_->paths.glow[0]) againstLights_ = floats(n);
      if (againstLights_) {
        g_->paths.againstLights = againstLights_;
        g_->paths.share = share_;
      }
    }
  }

  void run() {
    const uint32_t n = g_->count;
    uint32_t* live = words(g_->padded + kPad);
    uint32_t* onward = words(g_->padded + kPad);
    const bool byLobe = o_.byLobe.given;
    parts_ = byLobe ? o_.byLobe.most() : o_.indirectSamples < 1 ? 1 : o_.indirectSamples;
    const uint32_t bxdfParts = byLobe ? 1 : parts_;  // whose number is in densities and throughput
    MemoryMark mark = sv_->markMemory(g_);
    for (uint32_t i = 0; i < g_->padded; ++i) {
      live[i] = i < n ? i : n - 1;
      throughput_[0][i] = throughput_[1][i] = throughput_[2][i] = g_->rayWeight[i < n ? i : n - 1];
      pdf_[i] = 0;
      state_[i] = sv_->paths.start;
      flags_[i] = kFromDiscrete;
      if (share_) share_[i] = 1;
      if (againstLights_) againstLights_[i] = HUGE_VALF;
      if (reference_) reference_[i] = guide_->seen;
    }
    if (sv_->ownSampleCount) g_->besideOwnSamples = o_.lightSamples;
    // camera vertex
    sv_->trace(g_, &g_->paths, RayKind::Camera, 0, n, live, medium());
    if (sv_->mediaScatter) coverByMedia(g_, sv_, n, live, medium_);
    collectLights(RayKind::Camera, 0, 1, 1, n, live);
    collectGlow(0, 1, n, live);
    lightOnTheWay(0, o_.lightSamples, bxdfParts, n, live);
    applyMedium(n, live);
    uint32_t hits = keepHits(n, live);
    Context* const* contexts;
    const uint32_t count =
        sv_->shade(g_, &g_->paths, kTraitEyePath | kTraitPrimaryHit | kTraitSubsurface, 0, hits, live, &contexts);
    for (uint32_t c = 0; c < count; ++c) emission(*contexts[c]);
    directLights(count, contexts, 0, o_.lightSamples, bxdfParts);
    walkToLights(count, contexts, 0);
    if (parts_ > 1) {  // the first vertex is needed again
      keepFirst(hits, live);
      mark = sv_->markMemory(g_);
    }
    for (part_ = 0; part_ < parts_; ++part_) {
      if (part_) {
        restoreFirst(hits, live);
        if (sv_->ownSampleCount) g_->besideOwnSamples = o_.lightSamples;
      }
      follow(count, contexts, bxdfParts, mark, onward);
      if (lessons_) lessons_->end();
    }
    if (alpha_) alpha_->cover();
  }

 private:
  void contribute(const Contributions& c) {
    sv_->contribute(g_, &c);
    if (lessons_) lessons_->collect(c);
  }

  // Beside the bits of RayOrigin. Without caustics:
  enum Flags : uint32_t {
    kHadDiffuse = 1u << kOriginBits,   // some vertex took light samples whose shadow rays went through glass
    kCaustic = 2u << kOriginBits,      // a mirror or lens after that: light that the ray finds does not count
    kRefracted = 4u << kOriginBits,    // through glass after that, which tinted shadows stand for: neither does this
    kSeenThrough = 8u << kOriginBits,  // only refracted since the camera, and no light in its way (RefractedAlpha)
    kFromBody = 16u << kOriginBits  // scattered once within a body, at within_, from where it is weighed for lights
  };
  KN_INLINE bool isBlockedByGlass(uint32_t light) const {
    return sv_->lightExceptions && light < sv_->lightCount && sv_->lightExceptions[light] & kLightBlockedByGlass;
  }
  // Whether what a path with these flags finds of a light does not count.
  KN_INLINE bool isLeftOut(uint32_t flags, uint32_t light) const {
    return flags & kCaustic || (flags & kRefracted && !isBlockedByGlass(light)) || isWalked(flags, light);
  }
  // And from this bit on the state of WalkedPaths.
  static constexpr int kWalkedShift = 24;
  void walkToLights(uint32_t count, Context* const* contexts, uint32_t depth) {
    walks_.connect(count, contexts, depth,
                   {throughput_, state_, o_.maxIndirectBounces, o_.clampDepth, o_.clampLuminance, o_.clampCaustic});
  }
  // Whether what a path finds of a light is left to walks.
  bool isWalked(uint32_t flags, uint32_t light) const {
    return WalkedPaths::isWalked(flags >> kWalkedShift) && sv_->lightWalks[light];
  }
  KN_INLINE Int<W> walkedAfter(const Context& c, uint32_t i, const Slots<W>& s, Int<W> slot, Mask<W> discrete) const {
    if (!walks_.interfaces()) return Int<W>(0);
    const Int<W> before = s.get(flags_).template shr<kWalkedShift>();
    return WalkedPaths::after(c, i, slot, discrete, before, walks_.interfaces()).template shl<kWalkedShift>();
  }

  float* floats(uint32_t n) { return static_cast<float*>(sv_->alloc(g_, n * sizeof(float))); }
  uint32_t* words(uint32_t n) { return static_cast<uint32_t*>(sv_->alloc(g_, n * sizeof(uint32_t))); }

  float* const* medium() const { return sv_->hasMedia ? medium_ : nullptr; }
  void applyMedium(uint32_t n, const uint32_t* live) {
    if (!sv_->hasMedia) return;
    for (uint32_t i = 0; i < n; i += W) {
      const Mask<W> m = Mask<W>::firstN(int(n - i < W ? n - i : W));
      const Slots<W> s = Slots<W>::load(live + i);
      for (int c = 0; c < 3; ++c) s.put(m, s.get(throughput_[c]) * s.get(medium_[c]), throughput_[c]);
    }
  }

  // Lights met by the rays of `live`; the previous vertex took lightParts light samples and bxdfParts directions.
  void collectLights(RayKind kind, uint32_t depth, uint32_t lightParts, uint32_t bxdfParts, uint32_t n,
                     const uint32_t* live) {
    LightHits h;
    sv_->lightHits(g_, &g_->paths, kind, n, live, &h);
    if (!h.count) return;
    for (uint32_t i = 0; alpha_ && i < h.count; ++i)
      if (h.t[i] < 1e30f) flags_[h.slot[i]] &= ~kSeenThrough;
    float* value[3];
    for (float*& v : value) v = floats(padded(h.count));
    uint32_t* slot = words(padded(h.count));
    uint32_t* light = words(padded(h.count));
    uint32_t* state = words(padded(h.count));
    uint32_t m = 0;
    for (uint32_t i = 0; i < h.count; ++i) {
      const uint32_t s = h.slot[i];
      if (isLeftOut(flags_[s], h.light[i])) continue;
      if (flags_[s] & kFromBody && h.t[i] < within_[3][s]) continue;  // within: light samples have it all
      float v[3];
      found(h, i, depth, lightParts, bxdfParts, v);
      for (int c = 0; c < 3; ++c) value[c][m] = v[c];
      slot[m] = s;
      light[m] = h.light[i];
      state[m] = state_[s];
      ++m;
    }
    contributeFound({m, slot, {value[0], value[1], value[2]}, state, light});
    if (kind == RayKind::Camera) {
      float* alpha = floats(padded(h.count));
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
    for (float*& v : value) v = floats(room);
    uint32_t *slot = words(room), *light = words(room), *state = words(room), m = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      float v[3];
      for (int c = 0; c < 3; ++c) v[c] = throughput_[c][s] * glow[c][s] / float(bxdfParts);
      if (!(v[0] != 0 || v[1] != 0 || v[2] != 0)) continue;
      clampOne(depth, v);
      for (int c = 0; c < 3; ++c) value[c][m] = v[c];
      slot[m] = s;
      light[m] = kNoLight;
      state[m++] = state_[s];
    }
    if (m) contributeFound({m, slot, {value[0], value[1], value[2]}, state, light});
  }

  // What glow along new rays is weighed by, see RayList::againstLights.
  void tellAgainstLights(uint32_t lightParts, uint32_t bxdfParts, uint32_t n, const uint32_t* live) {
    if (!againstLights_) return;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      againstLights_[s] =
          flags_[s] & kFromDiscrete || !lightParts ? HUGE_VALF : pdf_[s] * (float(bxdfParts) / float(lightParts));
    }
  }

  // Light scattered in media on the way of the rays of `live`, where it is near lights; what the ends of the rays in
  // media have left of that light.
  void lightOnTheWay(uint32_t depth, uint32_t lightParts, uint32_t bxdfParts, uint32_t n, const uint32_t* live) {
    if (!share_) return;
    TowardsLights found;
    if (lightParts && sv_->lightCount) sv_->scatterTowardsLights(g_, &g_->paths, depth, n, live, &found);
    for (uint32_t i = 0; i < n; ++i) share_[live[i]] = found.share ? found.share[live[i]] : 1.f;
    if (!found.count) return;
    float *kept[3], *share = share_;
    for (int c = 0; c < 3; ++c) {
      kept[c] = throughput_[c];
      throughput_[c] = floats(g_->padded + kPad);
      for (uint32_t i = 0; i < found.count; ++i) {
        const uint32_t s = found.entries[i];
        throughput_[c][s] = kept[c][s] * found.factor[c][s];
      }
    }
    share_ = nullptr;
    Context* const* contexts;
    const uint32_t count =
        sv_->shade(g_, found.list, kTraitEyePath | kTraitScattersOnce, depth, found.count, found.entries, &contexts);
    directLights(count, contexts, depth, lightParts, bxdfParts);
    share_ = share;
    for (int c = 0; c < 3; ++c) throughput_[c] = kept[c];
  }

  // What light `i` met by a ray brings: its share beside light samples, and the clamp.
  void found(const LightHits& h, uint32_t i, uint32_t depth, uint32_t lightParts, uint32_t bxdfParts,
             float v[3]) const {
    const uint32_t s = h.slot[i];
    float w = 1;
    if (!(flags_[s] & kFromDiscrete)) {
      // power heuristic over all samples of both techniques
      const float r = h.pdf[i] * float(lightParts) / (pdf_[s] * float(bxdfParts));
      w = 1.f / (1.f + r * r);
    }
    w *= depth == 0 ? 1.f : (flags_[s] & kFromSpecular) ? h.specular[i] : h.diffuse[i];
    w /= float(bxdfParts);
    if (share_) w *= share_[s];
    const bool isSpecular = depth && flags_[s] & kFromSpecular && h.specularRadiance[0];
    const float* const* radiance = isSpecular ? h.specularRadiance : h.radiance;
    // without shadows light samples have it all
    if (depth > o_.maxIndirectBounces && !(flags_[s] & kFromDiscrete)) w *= 1.f - o_.unshadowedEnd;
    for (int c = 0; c < 3; ++c) v[c] = throughput_[c][s] * radiance[c][i] * w;
    clampOne(depth, v);
  }

  // Lights behind glass, met by directions that light samples with tinted shadows could have had: straight on too.
  void collectTinted(uint32_t depth, uint32_t lightParts, uint32_t bxdfParts, uint32_t n, const uint32_t* live) {
    if (o_.allowCaustics || !sv_->hasTintedShadows) return;
    uint32_t* list = words(padded(n) + kPad);
    uint32_t asked = 0;
    for (uint32_t i = 0; i < n; ++i)
      if (flags_[live[i]] & kFromTintedLight) list[asked++] = live[i];
    if (!asked) return;
    padList(asked, list);
    LightHits h;
    sv_->lightsBeyond(g_, &g_->paths, asked, list, &h);
    if (!h.count) return;
    const uint32_t room = padded(h.count) + kPad;
    float *o[3], *d[3], *T[3], *value[3];
    for (int c = 0; c < 3; ++c) {
      o[c] = floats(room);
      d[c] = floats(room);
      T[c] = floats(room);
      value[c] = floats(room);
    }
    float *tMax = floats(room), *time = floats(room);
    uint32_t *state = words(room), *tinted = words(room);
    const Rays& r = g_->paths.rays;
    for (uint32_t i = 0; i < h.count; ++i) {
      const uint32_t s = h.slot[i];
      for (int c = 0; c < 3; ++c) {
        o[c][i] = r.o[c][s];
        d[c][i] = r.d[c][s];
      }
      tMax[i] = h.t[i] < o_.farthest ? h.t[i] * 0.99999f : o_.farthest;
      time[i] = r.time[s];
      state[i] = state_[s];
      tinted[i] = sv_->walkBoundCount && flags_[s] >> kWalkedShift == 1 && sv_->lightWalks[h.light[i]] ? 2 : 1;
      float v[3];
      found(h, i, depth, lightParts, bxdfParts, v);
      for (int c = 0; c < 3; ++c) value[c][i] = v[c];
    }
    const ShadowRun run{nullptr, &g_->paths, h.count};
    const ShadowRays shadow{h.count, {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, tMax, time, h.slot, 1, &run,
                            tinted,  {T[0], T[1], T[2]}};
    sv_->shadow(g_, depth - 1, &shadow);
    for (uint32_t i = 0; i < h.count; ++i)
      for (int c = 0; c < 3; ++c) value[c][i] *= T[c][i];
    const Contributions out{h.count, h.slot, {value[0], value[1], value[2]}, state, h.light, LightKind::Shadowed};
    contribute(out);
  }

  // Where unshadowed light is wanted, what light samples could have found too is told apart from the rest.
  void contributeFound(const Contributions& all) {
    if (!sv_->wantsUnshadowed) {
      contribute(all);
      return;
    }
    for (const uint32_t kept : {uint32_t(kFromDiscrete), 0u}) {
      const uint32_t room = padded(all.count + 1);
      Contributions part = all;
      uint32_t *slot = words(room), *light = words(room), m = 0;
      uint32_t* state = words(room);
      float* value[3];
      for (int c = 0; c < 3; ++c) part.value[c] = value[c] = floats(room);
      for (uint32_t i = 0; i < all.count; ++i) {
        if ((flags_[all.slot[i]] & kFromDiscrete) != kept) continue;
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
      contribute(part);
    }
  }

  // Light samples before their shadow rays, each without its share of the two techniques.
  void contributeUnshadowed(const Contributions& all, const float* share) {
    Contributions out = all;
    float* value[3];
    for (int c = 0; c < 3; ++c) {
      out.value[c] = value[c] = floats(padded(all.count + 1));
      for (uint32_t i = 0; i < all.count; ++i) value[c][i] = all.value[c][i] / share[i];
    }
    out.kind = LightKind::Unshadowed;
    contribute(out);
  }

  float mostAt(uint32_t depth) const {
    return depth >= o_.clampDepth ? o_.clampLuminance : depth ? o_.clampDirect : 1e30f;
  }
  // depth: of the ray that found the light, camera rays 0.
  void clampOne(uint32_t depth, float v[3]) const {
    const float most = mostAt(depth);
    if (!(most < 1e30f)) return;
    const float k = factorToLuminance(Vec3<1>(v[0], v[1], v[2]), Float<1>(most)).lane0();
    for (int c = 0; c < 3; ++c) v[c] *= k;
  }

  // Drops escaped rays from the list; returns how many stay.
  uint32_t keepHits(uint32_t n, uint32_t* live) {
    uint32_t m = 0;
    for (uint32_t i = 0; i < n; i += W) {
      const Mask<W> in = Mask<W>::firstN(int(n - i < W ? n - i : W));
      const Slots<W> s = Slots<W>::load(live + i);
      const Packer<W> pack(in & (s.get(g_->paths.hits.t) < Float<W>(3e38f)));
      pack.put(s.s, live + m);
      m += uint32_t(pack.count);
    }
    padList(m, live);
    return m;
  }
  void padList(uint32_t m, uint32_t* live) {
    for (uint32_t i = m; i < padded(m); ++i) live[i] = m ? live[m - 1] : 0;
  }

  void emission(const Context& c) {
    if (!c.bxdf->emission) return;
    float* e[3];
    for (float*& x : e) x = floats(c.padded);
    c.bxdf->emission(&c, c.closure, e);
    uint32_t* state = words(c.padded);
    uint32_t* slot = words(c.padded);
    uint32_t* light = words(c.padded);
    uint32_t m = 0;
    for (uint32_t i = 0; i < c.count; ++i) {
      const uint32_t s = c.path[i];
      float v[3];
      for (int k = 0; k < 3; ++k) v[k] = e[k][i] * throughput_[k][s] * o_.emission;
      if (!(v[0] != 0 || v[1] != 0 || v[2] != 0)) continue;
      clampOne(c.depth, v);
      for (int k = 0; k < 3; ++k) e[k][m] = v[k];
      slot[m] = s;
      light[m] = kNoLight;
      state[m] = state_[s];
      ++m;
    }
    if (!m) return;
    const Contributions out{m, slot, {e[0], e[1], e[2]}, state, light};
    contribute(out);
  }

  // Not black; what is not a number counts, so that the film can report it.
  static KN_INLINE Mask<W> isThere(Vec3<W> v) { return abs(v.x) + abs(v.y) + abs(v.z) != Float<W>(0.f); }

  // Light without caustics. Shadow rays go straight through glass with its tint; they stand for all light that a path
  // would find by refraction since the vertex which they left (Flags). Within glass that the path itself entered
  // there are none: rough glass seen by the camera refracts twice, as clear glass does.
  KN_INLINE bool standsIn(const Context& c) const { return !o_.allowCaustics && (c.traits & kTraitTinted); }
  KN_INLINE Mask<W> hasFlag(const Slots<W>& s, uint32_t bit) const {
    return (s.get(flags_) & Int<W>(bit)) != Int<W>(0);
  }
  // Lanes whose light walks go to.
  KN_INLINE Mask<W> walkedTo(const uint32_t* light) const {
    alignas(64) uint32_t is[W];
    for (int l = 0; l < W; ++l) is[l] = light[l] < sv_->lightCount && sv_->lightWalks[light[l]];
    return Int<W>::load(is) != Int<W>(0);
  }
  // Lanes whose light sees glass as opaque.
  KN_INLINE Mask<W> blockedByGlass(const uint32_t* light) const {
    if (!sv_->lightExceptions) return Mask<W>(false);
    alignas(64) uint32_t is[W];
    for (int l = 0; l < W; ++l) is[l] = isBlockedByGlass(light[l]);
    return Int<W>::load(is) != Int<W>(0);
  }
  bool walksFrom(const Context& c, uint32_t depth) const {
    return walks_.interfaces() && !(c.traits & (kTraitWalkable | kTraitScattersOnce)) &&
           depth < o_.maxIndirectBounces;
  }
  static uint32_t walkableSlot(const Context& c) { return uint32_t(__builtin_ctz(c.walkableSlots | 1u << 31)); }
  static KN_INLINE Int<W> flag(Mask<W> m, uint32_t bit) { return select(m, Int<W>(bit), Int<W>(0)); }
  // Whether directions from the context's points lead through glass that its surface bounds.
  static KN_INLINE Mask<W> staysInside(const Context& c, uint32_t i, Vec3<W> wi) {
    if ((c.traits & (kTraitTinted | kTraitEncloses)) != (kTraitTinted | kTraitEncloses)) return Mask<W>(false);
    const Mask<W> below = dot(Vec3<W>::load(c.Ng, i), wi) < Float<W>(0.f);
    const Mask<W> outside = Int<W>::load(c.entering + i) != Int<W>(0);
    return (outside & below) | !(outside | below);
  }
  // The flags of new directions beside those of RayOrigin.
  KN_INLINE Int<W> withoutCaustics(const Context& c, uint32_t i, const Slots<W>& s, Vec3<W> wi, Int<W> slot,
                                   Mask<W> discrete) const {
    const Mask<W> had = hasFlag(s, kHadDiffuse);
    Mask<W> refracted(false), inside(false);
    if (c.traits & kTraitTinted) {
      Mask<W> through(false);
      for (uint32_t l = 0; l < c.slotCount; ++l)
        if (c.tintedSlots >> l & 1) through = through | (slot == Int<W>(l));
      refracted = had & through;
      inside = staysInside(c, i, wi);
    }
    const Mask<W> rough = !discrete;
    return flag(had | (rough & !inside), kHadDiffuse) | flag(had & discrete & !refracted, kCaustic) |
           flag(refracted, kRefracted) | flag(rough & !inside & !refracted, kFromTintedLight);
  }

  // Light samples at the points of the contexts: `parts`, and those that lights ask for themselves.
  void directLights(uint32_t count, Context* const* contexts, uint32_t depth, uint32_t parts, uint32_t bxdfParts) {
    for (uint32_t part = 0; part < parts; ++part)
      directLight(count, contexts, depth, part, parts, bxdfParts, nullptr);
    for (uint32_t k = 0; g_->besideOwnSamples && k < sv_->ownSampleCount; ++k)
      for (uint32_t part = 0; part < sv_->ownSamples[k].samples; ++part)
        directLight(count, contexts, depth, part, parts, bxdfParts, &sv_->ownSamples[k]);
  }
  // One light sample for each point of the contexts (own: of that light, else of any); bxdfParts directions will be
  // followed from them.
  void directLight(uint32_t count, Context* const* contexts, uint32_t depth, uint32_t part, uint32_t parts,
                   uint32_t bxdfParts, const OwnLightSamples* own) {
    using F = Float<W>;
    if (!sv_->lightCount) return;
    uint32_t points = 0, mostSlots = 1;
    for (uint32_t k = 0; k < count; ++k) {
      points += contexts[k]->count;
      mostSlots = contexts[k]->slotCount > mostSlots ? contexts[k]->slotCount : mostSlots;
    }
    const uint32_t room = padded(points) + kPad;
    float *o[3], *d[3], *T[3], *value[3];
    for (int c = 0; c < 3; ++c) {
      o[c] = floats(room);
      d[c] = floats(room);
      T[c] = floats(room);
      value[c] = floats(room * mostSlots);
    }
    float *tMax = floats(room), *time = floats(room);
    uint32_t* point = words(room);
    ShadowRun* runs = static_cast<ShadowRun*>(sv_->alloc(g_, count * sizeof(ShadowRun)));
    uint32_t* tinted = o_.allowCaustics || !sv_->hasTintedShadows ? nullptr : words(room);
    uint32_t* ray = words(room * mostSlots);  // of each contribution
    uint32_t* owner = words(room * mostSlots);
    uint32_t* light = words(room * mostSlots);
    uint32_t* state = words(room * mostSlots);
    float* share = sv_->wantsUnshadowed || o_.unshadowedEnd > 0 ? floats(room * mostSlots) : nullptr;
    float *spread = nullptr, *shareOfRay = nullptr;
    uint32_t* lightOfRay = sv_->hasShadowControls ? words(room) : nullptr;
    const float most = mostAt(depth + 1);
    const float unshadowed = depth == o_.maxIndirectBounces ? o_.unshadowedEnd : 0;
    uint32_t rays = 0, entries = 0;
    LightLessons<W>* lessons = g_->lightWeights && g_->teaches ? new (sv_->alloc(g_, sizeof(LightLessons<W>)))
                                                                     LightLessons<W>(g_, sv_, points)
                                                               : nullptr;

    for (uint32_t k = 0; k < count; ++k) {
      const Context& c = *contexts[k];
      const uint32_t firstOfContext = rays, firstEntry = entries;
      if (g_->lightWeights && part == 0 && !own) weighLights<W>(g_, sv_, lightState_, c);
      const bool byLobe = o_.byLobe.given && isFirst(c, depth);
      const LobeCounts<W> counts(c, o_.byLobe);
      const uint32_t number = isFirst(c, depth) ? part : part + sequence();
      LightCandidates<W> candidates(g_, sv_, c);
      if (own) {
        sv_->ownLightSamples(g_, &c, own->light, number, own->samples, &candidates.samples);
        candidates.scatter();
      } else {
        candidates.make(number, parts, isFirst(c, depth) && !byLobe && !lessons ? o_.lightCandidates : 1, throughput_,
                        [&](F byLight, F byBxdf)
                            HWY_ATTR { return misPower(byLight * F(float(parts)), byBxdf * F(float(bxdfParts))); });
      }
      const LightSamples& ls = candidates.samples;
      EvaluateArgs& e = candidates.scattered;
      if (lessons) lessons->add(c, ls, throughput_, parts);
      if (ls.spread && !spread) spread = floats(room);
      const bool isOnce = once_ && &c == &once_->context();
      const bool hasAll = c.traits & kTraitScattersOnce && !(isOnce && within_[0]);
      if (isOnce && within_[0] && !shareOfRay) shareOfRay = floats(room);
      // what arrives unshadowed: throughput * L / pdf * mis, by slot; rays where any slot is not black
      for (uint32_t i = 0; i < c.count; i += W) {
        const Mask<W> in = Mask<W>::firstN(int(c.count - i < W ? c.count - i : W));
        const Slots<W> s = Slots<W>::load(c.path + i);
        const F pdf = F::load(ls.pdf + i);
        const Mask<W> delta = (Int<W>::load(ls.flags + i) & Int<W>(uint32_t(kSampleDelta))) != Int<W>(0);
        const auto misOf = [&](F directions) {
          const F mis = misPower(pdf * F(float(parts)), F::load(e.pdf + i) * directions);
          return select(delta | Mask<W>(hasAll), F(1.f), mis);
        };
        const F mis = misOf(F(float(bxdfParts)));
        const Mask<W> some = in & (pdf > F(0.f));
        F scale = select(some, (byLobe ? F(1.f) : mis) / max(pdf * F(float(parts)), F(1e-38f)), F(0.f));
        if (share_ && c.traits & kTraitInSpace) scale = scale * s.get(share_);
        if (candidates.factor) scale = scale * F::load(candidates.factor + i);
        Vec3<W> base = Vec3<W>::get(throughput_, s) * Vec3<W>::load(ls.radiance, i) * scale;
        Vec3<W> glossy = base;
        if (ls.specularRadiance[0])
          glossy = Vec3<W>::get(throughput_, s) * Vec3<W>::load(ls.specularRadiance, i) * scale;
        const Vec3<W> wi = Vec3<W>::load(ls.wi, i);
        // light that a tinted shadow brought to an earlier vertex
        const Mask<W> blocked = o_.allowCaustics ? Mask<W>(false) : blockedByGlass(ls.light + i);
        const Mask<W> behind = standsIn(c) ? hasFlag(s, kHadDiffuse) & !blocked : Mask<W>(false);
        // light that walks bring: by rough boundaries here, and through what tinted shadow rays would pass
        const Mask<W> walked = walks_.interfaces() && some.any() ? walkedTo(ls.light + i) : Mask<W>(false);
        Mask<W> walkedHere(false);
        if (walked.any() && (c.traits & kTraitWalkable))
          walkedHere = walked & (walkedAfter(c, i, s, Int<W>(walkableSlot(c)), Mask<W>(false)) != Int<W>(0));
        const F fd = F::load(ls.diffuse + i), fs = F::load(ls.specular + i);
        Mask<W> lit(false);
        const Mask<W> goesThrough = byLobe ? counts.through(i, wi) : Mask<W>(false);
        for (uint32_t l = 0; l < c.slotCount; ++l) {
          F factor = c.eventOfSlot[l] & 1 ? fs : fd;
          if (byLobe) factor = factor * misOf(counts.of(l, goesThrough));
          Vec3<W> v = (c.eventOfSlot[l] & 1 ? glossy : base) * Vec3<W>::load(e.weight[l], i) * factor;
          v = zeroUnless(c.tintedSlots >> l & 1 ? some & !behind : some, v);
          if (c.walkableSlots >> l & 1) v = zeroUnless(!walkedHere, v);
          if (most < 1e30f) {
            const F lum = luminance(v);
            v = select(lum > F(most), v * (F(most) / max(lum, F(1e-30f))), v);
          }
          v.store(e.weight[l], i);  // reused: contribution of the slot
          lit = lit | (some & isThere(v));
        }
        const uint32_t bits = lit.bits();
        if (!bits) continue;
        const F bias = F::load(c.bias + i);
        const Vec3<W> from = leave(Vec3<W>::load(c.P, i), Vec3<W>::load(c.Ng, i), bias, wi);
        const Packer<W> pack(lit);
        from.pack(pack, o, rays);
        wi.pack(pack, d, rays);
        F far = F::load(ls.distance + i);
        if (o_.farthest < 1e30f) far = min(far, F(o_.farthest));
        pack.put(fma(far, F(0.99999f), -(bias + bias)), tMax + rays);
        pack.put(F::load(c.time + i), time + rays);
        pack.put(Int<W>::lanes(int32_t(i)), point + rays);
        if (spread) pack.put(F::load(ls.spread + i), spread + rays);
        if (lightOfRay) pack.put(Int<W>::load(ls.light + i), lightOfRay + rays);
        if (shareOfRay) pack.put(mis, shareOfRay + rays);
        if (tinted) {
          const Int<W> passes = select(walked & Mask<W>(walksFrom(c, depth)), Int<W>(2), Int<W>(1));
          pack.put(select(staysInside(c, i, wi) | blocked, Int<W>(0), passes), tinted + rays);
        }
        if (lessons) lessons->addRays(pack, i, rays);
        // each lane's ray
        Int<W> rank = Int<W>::lanes(int32_t(rays));
        if (!lit.all() && c.slotCount > 1) {
          alignas(64) uint32_t list[W] = {};
          uint32_t k = rays;
          for (uint32_t b = bits; b; b &= b - 1) list[__builtin_ctz(b)] = k++;
          rank = Int<W>::load(list);
        }
        const uint32_t firstRay = rays;
        rays += uint32_t(pack.count);
        const Int<W> row = s.get(state_) * Int<W>(sv_->paths.eventCount);
        for (uint32_t l = 0; l < c.slotCount; ++l) {
          const Vec3<W> v = Vec3<W>::load(e.weight[l], i);
          const Mask<W> some = lit & isThere(v);
          if (some.none()) continue;
          const Packer<W> keep(some);
          v.pack(keep, value, entries);
          keep.put(s.s, owner + entries);
          if (c.slotCount > 1)
            keep.put(rank, ray + entries);
          else
            Int<W>::lanes(int32_t(firstRay)).store(ray + entries);  // every ray has one entry
          keep.put(Int<W>::load(ls.light + i), light + entries);
          if (share) keep.put(byLobe ? misOf(counts.of(l, goesThrough)) : mis, share + entries);
          keep.put(gather(sv_->paths.next, row + Int<W>(uint32_t(c.eventOfSlot[l]))), state + entries);
          entries += uint32_t(keep.count);
        }
      }
      if (isOnce) leaveBody(firstOfContext, rays, firstEntry, entries, point, o, d, tMax, shareOfRay, ray, value);
      runs[k] = {&c, nullptr, rays};
    }
    if (!rays) {
      if (lessons) lessons->end(0, ray, value, T);
      return;
    }
    if (sv_->wantsUnshadowed)
      contributeUnshadowed({entries, owner, {value[0], value[1], value[2]}, state, light}, share);
    const ShadowRays shadow{
        rays,   {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, tMax, time, point, count, runs, tinted, {T[0], T[1], T[2]},
        spread, lightOfRay};
    sv_->shadow(g_, depth, &shadow);
    if (lessons) lessons->end(entries, ray, value, T);
    uint32_t m = 0;
    for (uint32_t i = 0; i < entries; i += W) {
      const Mask<W> in = Mask<W>::firstN(int(entries - i < W ? entries - i : W));
      const Int<W> r = select(in, Int<W>::load(ray + i), Int<W>(0));
      Vec3<W> v = Vec3<W>::load(value, i) * Vec3<W>::gather(T, r);
      if (unshadowed > 0)
        v = v * F(1.f - unshadowed) + Vec3<W>::load(value, i) * (F(unshadowed) / max(F::load(share + i), F(1e-30f)));
      const Mask<W> some = in & isThere(v);
      const Int<W> who = Int<W>::load(owner + i), which = Int<W>::load(light + i), at = Int<W>::load(state + i);
      const Packer<W> pack(some);
      v.pack(pack, value, m);
      pack.put(who, owner + m);
      pack.put(which, light + m);
      pack.put(at, state + m);
      m += uint32_t(pack.count);
    }
    const Contributions out{m, owner, {value[0], value[1], value[2]}, state, light, LightKind::Shadowed};
    contribute(out);
  }

  // Shadow rays from within a body, and what they bring: from where they leave it. share: that of the light sample, by
  // ray, where the directions from there find lights too; null: all.
  void leaveBody(uint32_t first, uint32_t end, uint32_t firstEntry, uint32_t lastEntry, const uint32_t* point,
                 float* const o[3], float* const d[3], float* tMax, const float* share, const uint32_t* ray,
                 float* const value[3]) {
    const uint32_t n = end - first;
    if (!n) return;
    float* const from[3] = {o[0] + first, o[1] + first, o[2] + first};
    const float* const along[3] = {d[0] + first, d[1] + first, d[2] + first};
    float* const factor[3] = {floats(padded(n) + kPad), floats(padded(n) + kPad), floats(padded(n) + kPad)};
    once_->leaveBody(n, point + first, from, along, tMax + first, share ? share + first : nullptr, factor);
    for (uint32_t e = firstEntry; e < lastEntry; ++e)
      for (int c = 0; c < 3; ++c) value[c][e] *= factor[c][ray[e] - first];
  }

  // At the first vertex; where its paths come out that went below is behind it.
  static bool isFirst(const Context& c, uint32_t depth) { return depth == 0 && !(c.traits & kTraitComesOut); }
  // By what sample indices behind the first vertex are raised, where parts have sequences of their own.
  uint32_t sequence() const { return o_.byLobe.given ? part_ * kSequenceOfPart : 0; }

  // New directions from the contexts' points; returns the slots that go on.
  uint32_t scatterPaths(uint32_t count, Context* const* contexts, uint32_t depth, uint32_t part, uint32_t parts,
                        uint32_t* live) {
    using F = Float<W>;
    uint32_t m = 0;
    for (uint32_t k = 0; k < count; ++k) {
      const Context& c = *contexts[k];
      if (c.traits & kTraitScattersOnce) continue;
      float *u[4], *wi[3], *weight[3];
      for (float*& x : u) x = floats(c.padded);
      for (int x = 0; x < 3; ++x) {
        wi[x] = floats(c.padded);
        weight[x] = floats(c.padded);
      }
      float* pdf = floats(c.padded);
      uint32_t *slot = words(c.padded), *flags = words(c.padded);
      const uint32_t dim = subSampled(dimensionAt(depth), part, parts);
      for (uint32_t i = 0; i < c.padded; i += W) {
        const Int<W> seed = Int<W>::load(c.sampleSeed + i);
        const Int<W> sample = Int<W>::load(c.sampleIndex + i) * Int<W>(parts) + Int<W>(part);
        F a, b;
        draw2(sv_->samples, seed, sample, dim + kDimBxdf, a, b);
        a.store(u[0] + i);
        b.store(u[1] + i);
        draw2(sv_->samples, seed, sample, dim + kDimLobe, a, b);
        a.store(u[2] + i);
        b.store(u[3] + i);
      }
      const GenerateArgs ga{{u[0], u[1], u[2], u[3]},
                            {wi[0], wi[1], wi[2]},
                            {weight[0], weight[1], weight[2]},
                            pdf,
                            nullptr,
                            slot,
                            flags};
      c.bxdf->generate(&c, c.closure, &ga);
      ChosenDirections<W> chosen;
      if (guide_ && !(c.traits & kTraitInSpace))
        chosen = guideDirections<W>(g_, sv_, *guide_, c, ga, depth, part, parts);
      const bool byLobe = o_.byLobe.given && depth == 0;
      const LobeCounts<W> counts(c, o_.byLobe);
      uint32_t *point = words(c.padded + kPad), *through = words(c.padded + kPad);
      uint32_t *below = words(c.padded + kPad), leaving = 0, sinking = 0;
      uint32_t *once = c.bxdf->subsurface ? words(c.padded + kPad) : nullptr, scattering = 0;
      for (uint32_t i = 0; i < c.count; i += W) {
        Mask<W> on = Mask<W>::firstN(int(c.count - i < W ? c.count - i : W));
        const Slots<W> s = Slots<W>::load(c.path + i);
        const Int<W> lobe = Int<W>::load(slot + i);
        on = on & (lobe != Int<W>(kNoLobe));
        const F p = F::load(pdf + i);
        on = on & (p > F(0.f));
        Vec3<W> t = Vec3<W>::get(throughput_, s) * Vec3<W>::load(weight, i) * (F(1.f) / max(p, F(1e-38f)));
        F number(1.f);
        if (byLobe) {
          number = counts.of(lobe, Int<W>::load(flags + i));
          on = on & (F(float(part_)) < number);
          t = t * (F(1.f) / number);
        }
        F survival(1.f);
        // Russian roulette on paths that will bring little: as learned, else by their throughput
        if (chosen.reference) s.put(on, F::load(chosen.reference + i), reference_);
        const bool isLearned = chosen.radiance && o_.rouletteThreshold > 0;
        if (isLearned || depth >= o_.rouletteDepth) {
          F r, unused;
          draw2(sv_->samples, Int<W>::load(c.sampleSeed + i),
                Int<W>::load(c.sampleIndex + i) * Int<W>(parts) + Int<W>(part), dim + kDimRoulette, r, unused);
          F q(1.f);
          if (depth >= o_.rouletteDepth) q = clamp(maxComponent(t) * F(1.f / o_.rouletteThreshold), F(0.05f), F(1.f));
          if (isLearned) {
            const F expected = F::load(chosen.radiance + i), brings = (t.x + t.y + t.z) * F(1.f / 3.f) * expected;
            const F worth = brings / max(s.get(reference_) * F(float(parts) * kLearnedRoulette), F(1e-30f));
            q = select(expected < F(0.f), q, clamp(worth, F(kLeastSurvival), F(1.f)));
          }
          on = on & (r < q);
          t = t * (F(1.f) / q);
          survival = q;
        }
        on = on & (maxComponent(t) > F(0.f));
        if (c.bxdf->subsurface) {
          const Mask<W> sinks = on & ((Int<W>::load(flags + i) & Int<W>(uint32_t(kSampleBelow))) != Int<W>(0));
          if (sinks.any()) {
            s.put(sinks, t.x, throughput_[0]);
            s.put(sinks, t.y, throughput_[1]);
            s.put(sinks, t.z, throughput_[2]);
            const Mask<W> single = sinks & ((Int<W>::load(flags + i) & Int<W>(uint32_t(kSampleOnce))) != Int<W>(0));
            const Packer<W> pack(sinks & !single);
            pack.put(Int<W>::lanes(int32_t(i)), below + sinking);
            sinking += uint32_t(pack.count);
            if (single.any()) {
              const Packer<W> packSingle(single);
              packSingle.put(Int<W>::lanes(int32_t(i)), once + scattering);
              scattering += uint32_t(packSingle.count);
            }
            on = on & !sinks;
          }
        }
        const uint32_t bits = on.bits();
        if (!bits) continue;
        const Vec3<W> w = Vec3<W>::load(wi, i);
        const Vec3<W> from = leave(Vec3<W>::load(c.P, i), Vec3<W>::load(c.Ng, i), F::load(c.bias + i), w);
        const Int<W> fl = Int<W>::load(flags + i);
        const Mask<W> discrete = (fl & Int<W>(uint32_t(kSampleDiscrete))) != Int<W>(0);
        if (lessons_ && !(c.traits & kTraitInSpace))
          lessons_->add(on & !discrete, c, i, s, w, t, survival, p, chosen.at(i, p), chosen.isGuided(i),
                        1.f / float(parts), depth == 0 && part_ + 1 == parts_);
        const Rays& r = g_->paths.rays;
        s.put(on, from.x, r.o[0]);
        s.put(on, from.y, r.o[1]);
        s.put(on, from.z, r.o[2]);
        s.put(on, w.x, r.d[0]);
        s.put(on, w.y, r.d[1]);
        s.put(on, w.z, r.d[2]);
        s.put(on, t.x, throughput_[0]);
        s.put(on, t.y, throughput_[1]);
        s.put(on, t.z, throughput_[2]);
        s.put(on, p * number, pdf_);
        s.put(on, F(o_.farthest), r.tMax);
        s.put(on, F::load(c.radius + i), r.radius);
        const F spread = F::load(c.spread + i);
        s.put(on, select(discrete, spread, spreadAfter(spread, p)), r.spread);
        Int<W> event(c.slotCount ? uint32_t(c.eventOfSlot[0]) : 0u);
        for (uint32_t l = 1; l < c.slotCount; ++l)
          event = select(lobe == Int<W>(l), Int<W>(uint32_t(c.eventOfSlot[l])), event);
        const Int<W> next =
            gather(sv_->paths.next, s.get(state_) * Int<W>(sv_->paths.eventCount) + select(on, event, Int<W>(0)));
        s.put(on, next, state_);
        const Mask<W> transmits = (fl & Int<W>(uint32_t(kSampleTransmit))) != Int<W>(0);
        const Mask<W> specular = (event & Int<W>(1)) != Int<W>(0);
        const Int<W> now =
            flag(discrete, kFromDiscrete) | flag(specular, kFromSpecular) | flag(transmits, kFromTransmission);
        Int<W> all = now | walkedAfter(c, i, s, lobe, discrete);
        if (alpha_) {
          const Mask<W> before = depth ? hasFlag(s, kSeenThrough) : Mask<W>(true);
          all = all | flag(before & transmits & specular, kSeenThrough);
        }
        s.put(on, o_.allowCaustics ? all : all | withoutCaustics(c, i, s, w, lobe, discrete), flags_);
        const Packer<W> pack(on);
        pack.put(s.s, live + m);
        pack.put(Int<W>::lanes(int32_t(i)), point + leaving);
        pack.put(flag(transmits, 1), through + leaving);
        m += uint32_t(pack.count);
        leaving += uint32_t(pack.count);
      }
      if (leaving) sv_->leave(g_, &g_->paths, &c, leaving, point, nullptr, through);
      if (sinking) m = followMedia(c, sinking, below, ga, depth, part, parts, live, m);
      if (scattering) m = followOnce(c, scattering, once, ga, depth, part, parts, live, m);
    }
    padList(m, live);
    return m;
  }

  // Paths below the surface, medium by medium of the material.
  uint32_t followMedia(const Context& in, uint32_t n, uint32_t* points, const GenerateArgs& made, uint32_t depth,
                       uint32_t part, uint32_t parts, uint32_t* live, uint32_t m) {
    uint32_t* rest = words(in.padded + kPad);
    while (n) {
      const uint32_t which = made.flags[points[0]] >> kSampleMediumShift;
      uint32_t taken = 0, left = 0;
      for (uint32_t i = 0; i < n; ++i) {
        if (made.flags[points[i]] >> kSampleMediumShift == which)
          points[taken++] = points[i];
        else
          rest[left++] = points[i];
      }
      m = followBelow(in, which, taken, points, made, depth, part, parts, live, m);
      n = left;
      for (uint32_t i = 0; i < n; ++i) points[i] = rest[i];
    }
    return m;
  }

  // Paths below the surface: light where they come out, and their next directions from there. They are still at the
  // vertex where they went in, of which each followed `parts` directions; slots that go on are appended to `live`.
  uint32_t followBelow(const Context& in, uint32_t which, uint32_t n, const uint32_t* points,
                       const GenerateArgs& made, uint32_t depth, uint32_t part, uint32_t parts, uint32_t* live,
                       uint32_t m) {
    using F = Float<W>;
    const Emerged out = PathsBelow<W>(g_, sv_).follow(in, which, n, points, made, part, parts, throughput_);
    const auto scale = [&](float by) {
      for (uint32_t k = 0; parts > 1 && k < out.count; ++k)
        for (uint32_t i = 0; i < out.contexts[k]->count; ++i)
          for (float* t : throughput_) t[out.contexts[k]->path[i]] *= by;
    };
    scale(1.f / float(parts));
    const uint32_t lightParts = depth == 0 ? o_.lightSamples : 1;
    directLights(out.count, out.contexts, depth, lightParts, 1);
    walkToLights(out.count, out.contexts, depth);
    scale(float(parts));
    for (uint32_t k = 0; k < out.count; ++k) {
      const Context& c = *out.contexts[k];
      uint32_t *point = words(c.padded + kPad), *slot = words(c.padded + kPad), leaving = 0;
      for (uint32_t i = 0; i < c.count; i += W) {
        Mask<W> on = Mask<W>::firstN(int(c.count - i < W ? c.count - i : W));
        const Slots<W> s = Slots<W>::load(c.path + i);
        F a, b;
        draw2(sv_->samples, Int<W>::load(c.sampleSeed + i),
              Int<W>::load(c.sampleIndex + i) * Int<W>(parts) + Int<W>(part),
              subSampled(dimensionAt(depth) + kDimBelow, part, parts), a, b);
        const Vec3<W> local = cosineHemisphere(a, b), Ng = Vec3<W>::load(c.Ng, i);
        const Vec3<W> w = Frame<W>(Vec3<W>::load(c.N, i)).toWorld(local);
        on = on & (dot(Ng, w) > F(0.f)) & (local.z > F(0.f)) & (maxComponent(Vec3<W>::get(throughput_, s)) > F(0.f));
        if (on.none()) continue;
        const Vec3<W> from = leave(Vec3<W>::load(c.P, i), Ng, F::load(c.bias + i), w);
        const F p = local.z * F(kInvPi);
        const Rays& r = g_->paths.rays;
        s.put(on, from.x, r.o[0]);
        s.put(on, from.y, r.o[1]);
        s.put(on, from.z, r.o[2]);
        s.put(on, w.x, r.d[0]);
        s.put(on, w.y, r.d[1]);
        s.put(on, w.z, r.d[2]);
        s.put(on, p * F(1.f / float(parts)), pdf_);  // found() reckons with `parts` directions from the same place
        s.put(on, F(o_.farthest), r.tMax);
        s.put(on, F::load(c.radius + i), r.radius);
        s.put(on, spreadAfter(F::load(c.spread + i), p), r.spread);
        const Int<W> row = s.get(state_) * Int<W>(sv_->paths.eventCount);
        s.put(on, gather(sv_->paths.next, select(on, row + Int<W>(uint32_t(c.eventOfSlot[0])), Int<W>(0))), state_);
        const Int<W> walked = walkedAfter(c, i, s, Int<W>(0), Mask<W>(false));
        s.put(on, o_.allowCaustics ? walked : walked | withoutCaustics(c, i, s, w, Int<W>(0), Mask<W>(false)),
              flags_);
        const Packer<W> pack(on);
        pack.put(s.s, live + m);
        pack.put(s.s, slot + leaving);
        pack.put(Int<W>::lanes(int32_t(i)), point + leaving);
        m += uint32_t(pack.count);
        leaving += uint32_t(pack.count);
      }
      if (leaving) sv_->leave(g_, &g_->paths, &c, leaving, point, slot, nullptr);
    }
    return m;
  }

  // Paths that scatter once below the surface, in the same way: light where they scatter, and one direction from there.
  // Lights that it meets beyond the body are weighed against light samples as seen from within.
  uint32_t followOnce(const Context& in, uint32_t n, uint32_t* points, const GenerateArgs& made, uint32_t depth,
                      uint32_t part, uint32_t parts, uint32_t* live, uint32_t m) {
    uint32_t *clear = words(in.padded + kPad), straight = 0, turned = 0;
    for (uint32_t i = 0; i < n; ++i) {
      if (made.flags[points[i]] & kSampleStraight)
        clear[straight++] = points[i];
      else
        points[turned++] = points[i];
    }
    n = turned;
    if (straight) m = followStraight(in, straight, clear, made, part, parts, live, m);
    ScatterOnce<W>* once = new (sv_->alloc(g_, sizeof(ScatterOnce<W>))) ScatterOnce<W>(g_, sv_);
    if (!once->scatter(in, n, points, made, part, parts, throughput_)) return m;
    const Context& c = once->context();
    Context* const contexts[] = {const_cast<Context*>(&c)};
    const auto scale = [&](float by) {
      for (uint32_t i = 0; parts > 1 && i < c.count; ++i)
        for (float* t : throughput_) t[c.path[i]] *= by;
    };
    once_ = once;
    float* share = share_;
    share_ = nullptr;
    scale(1.f / float(parts));
    directLights(1, contexts, depth, depth == 0 ? o_.lightSamples : 1, 1);
    scale(float(parts));
    share_ = share;
    once_ = nullptr;
    float *o[3], *d[3], *factor[3];
    const uint32_t room = c.padded + kPad;
    for (int k = 0; k < 3; ++k) {
      o[k] = floats(room);
      d[k] = floats(room);
      factor[k] = floats(room);
    }
    uint32_t *point = words(room), *slot = words(room), leaving = 0;
    float *pdf = floats(room), *within[3] = {floats(room), floats(room), floats(room)};
    const uint32_t count = once->directions(point, o, d, pdf);
    for (int k = 0; k < 3; ++k)
      for (uint32_t i = 0; i < count; ++i) within[k][i] = o[k][i];
    once->leaveBody(count, point, o, d, nullptr, nullptr, factor);
    const Rays& r = g_->paths.rays;
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t s = c.path[i];
      bool brings = false;
      for (int k = 0; k < 3; ++k) brings |= (throughput_[k][s] *= factor[k][i]) > 0;
      if (!brings) continue;
      for (int k = 0; k < 3; ++k) {
        r.o[k][s] = o[k][i];
        r.d[k][s] = d[k][i];
      }
      uint32_t flags = kFromSpecular | (o_.allowCaustics ? 0u : uint32_t(kHadDiffuse));
      pdf_[s] = 1e-30f;  // lights are left to light samples
      if (within_[0]) {
        flags |= kFromBody;
        pdf_[s] = pdf[i] / float(parts);
        float length = 0;
        for (int k = 0; k < 3; ++k) {
          within_[k][s] = within[k][i];
          length += (o[k][i] - within[k][i]) * d[k][i];
        }
        within_[3][s] = length;
      }
      r.tMax[s] = o_.farthest;
      r.radius[s] = c.radius[i];
      r.spread[s] = spreadAfter(Float<1>(c.spread[i]), Float<1>(kInvTwoPi * 0.5f)).lane0();
      state_[s] = sv_->paths.next[state_[s] * sv_->paths.eventCount + c.eventOfSlot[0]];
      flags_[s] = flags;
      live[m++] = s;
      slot[leaving] = s;
      point[leaving++] = i;
    }
    if (leaving) sv_->leave(g_, &g_->paths, &c, leaving, point, slot, nullptr);
    return m;
  }

  // Paths that go straight through the body, as through clear glass: what they find behind it they find alone.
  uint32_t followStraight(const Context& in, uint32_t n, const uint32_t* points, const GenerateArgs& made,
                          uint32_t part, uint32_t parts, uint32_t* live, uint32_t m) {
    const auto out = ScatterOnce<W>(g_, sv_).pass(in, n, points, made, part, parts, throughput_);
    if (!out.count) return m;
    const Rays& r = g_->paths.rays;
    for (uint32_t i = 0; i < out.count; ++i) {
      const uint32_t s = out.path[i];
      for (int k = 0; k < 3; ++k) {
        r.o[k][s] = out.o[k][i];
        r.d[k][s] = out.d[k][i];
      }
      pdf_[s] = 1;
      r.tMax[s] = o_.farthest;
      r.radius[s] = out.at.radius[i];
      r.spread[s] = out.at.spread[i];
      state_[s] = sv_->paths.next[state_[s] * sv_->paths.eventCount + in.eventOfSlot[made.slot[points[0]]]];
      uint32_t flags = kFromDiscrete | kFromSpecular | kFromTransmission;
      if (!o_.allowCaustics && flags_[s] & kHadDiffuse) flags |= kHadDiffuse | kCaustic;
      flags_[s] = flags;
      live[m++] = s;
    }
    sv_->leave(g_, &g_->paths, &out.at, out.count, out.point, out.path, nullptr);
    return m;
  }

  // `mark`: all that was made since is needed until the next directions are chosen, and no longer.
  void follow(uint32_t count, Context* const* contexts, uint32_t parts, MemoryMark mark, uint32_t* live) {
    for (uint32_t depth = 0;; ++depth) {
      const bool first = depth == 0;
      const uint32_t part = o_.byLobe.given ? sequence() : first ? part_ : 0;
      const uint32_t n = scatterPaths(count, contexts, depth, part, first ? parts : 1, live);
      sv_->releaseMemory(g_, mark);
      if (!n) return;
      const uint32_t lightParts = first ? o_.lightSamples : 1, bxdfParts = first ? parts : 1;
      tellAgainstLights(lightParts, bxdfParts, n, live);
      sv_->trace(g_, &g_->paths, RayKind::Indirect, depth + 1, n, live, medium());
      if (lessons_) lessons_->arrive(n, live);
      if (o_.farthest < 1e30f)  // of surfaces; lights are met wherever they are
        for (uint32_t i = 0; i < n; ++i) g_->paths.rays.tMax[live[i]] = 1e30f;
      collectTinted(depth + 1, lightParts, bxdfParts, n, live);  // as its other half, without what media absorb
      const float* bodies = startWithin(n, live);
      collectLights(RayKind::Indirect, depth + 1, lightParts, bxdfParts, n, live);
      if (bodies) startOutside(n, live, bodies);
      collectGlow(depth + 1, bxdfParts, n, live);
      g_->besideOwnSamples = 0;  // of the first vertex only
      if (alpha_) escape(first ? parts : 1, n, live);
      if (depth >= o_.maxIndirectBounces) return;  // the last directions only looked for light
      if (first && parts > 1)
        for (uint32_t i = 0; i < n; ++i)
          for (int c = 0; c < 3; ++c) throughput_[c][live[i]] /= float(parts);
      lightOnTheWay(depth + 1, 1, 1, n, live);
      applyMedium(n, live);
      const uint32_t hits = keepHits(n, live);
      if (!hits) return;
      count = sv_->shade(g_, &g_->paths, kTraitEyePath | kTraitSubsurface, depth + 1, hits, live, &contexts);
      for (uint32_t c = 0; c < count; ++c) emission(*contexts[c]);
      directLights(count, contexts, depth + 1, 1, 1);
      walkToLights(count, contexts, depth + 1);
    }
  }

  // Rays of kFromBody as from where they were scattered; what they are else, to be given back. Null: there are none.
  const float* startWithin(uint32_t n, const uint32_t* live) {
    if (!within_[0]) return nullptr;
    float* kept = nullptr;
    const Rays& r = g_->paths.rays;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      if (!(flags_[s] & kFromBody)) continue;
      if (!kept) kept = floats(4 * n);
      for (int k = 0; k < 3; ++k) {
        kept[4 * i + uint32_t(k)] = r.o[k][s];
        r.o[k][s] = within_[k][s];
      }
      kept[4 * i + 3] = g_->paths.hits.t[s];
      g_->paths.hits.t[s] += within_[3][s];
    }
    return kept;
  }
  void startOutside(uint32_t n, const uint32_t* live, const float* kept) {
    const Rays& r = g_->paths.rays;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      if (!(flags_[s] & kFromBody)) continue;
      for (int k = 0; k < 3; ++k) r.o[k][s] = kept[4 * i + uint32_t(k)];
      g_->paths.hits.t[s] = kept[4 * i + 3];
    }
  }

  // Rays that met nothing behind what refracted them; the vertex before followed `parts` of them.
  void escape(uint32_t parts, uint32_t n, const uint32_t* live) {
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      if (!(flags_[s] & kSeenThrough) || g_->paths.hits.t[s] < 3e38f) continue;
      float v[3];
      for (int c = 0; c < 3; ++c) v[c] = throughput_[c][s] * (sv_->hasMedia ? medium_[c][s] : 1.f) / float(parts);
      alpha_->add(s, v);
    }
  }

  void keepFirst(uint32_t n, const uint32_t* live) {
    for (int c = 0; c < 3; ++c) firstThroughput_[c] = floats(g_->padded + kPad);
    firstState_ = words(g_->padded + kPad);
    if (share_) firstShare_ = floats(g_->padded + kPad);
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      for (int c = 0; c < 3; ++c) firstThroughput_[c][s] = throughput_[c][s];
      firstState_[s] = state_[s];
      if (share_) firstShare_[s] = share_[s];
    }
  }
  void restoreFirst(uint32_t n, const uint32_t* live) {
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      for (int c = 0; c < 3; ++c) throughput_[c][s] = firstThroughput_[c][s];
      state_[s] = firstState_[s];
      flags_[s] = kFromDiscrete;
      if (share_) share_[s] = firstShare_[s];
    }
  }

  Group* g_;
  const Services* sv_;
  const PathLoopOptions o_;
  ManifoldWalks<W> walks_;
  float *throughput_[3], *medium_[3], *firstThroughput_[3], *pdf_;
  // Where media scatter: how much of the light at the vertex of a path it counts (the rest is lightOnTheWay's); and
  // where they glow, see RayList.
  float *share_ = nullptr, *firstShare_ = nullptr, *againstLights_ = nullptr;
  uint32_t *state_, *firstState_ = nullptr;
  uint32_t* flags_;
  uint32_t part_ = 0, parts_ = 1;  // directions from the first vertex: the one under way, and how many
  // Of what a path is expected to bring to its pixel, over all that is seen there, what lets it go on for certain; and
  // how likely it goes on at least.
  static constexpr float kLearnedRoulette = 0.3f, kLeastSurvival = 0.3f;
  RefractedAlpha* alpha_ = nullptr;
  ScatterOnce<W>* once_ = nullptr;  // whose shadow rays are under way
  // By path of kFromBody: where it was scattered, and how far from there its ray left the body. Null: light samples
  // have all light that was scattered once.
  float* within_[4] = {nullptr, nullptr, nullptr, nullptr};
  const guiding::State* lightState_ = nullptr;
  const guiding::State* guide_ = nullptr;
  float* reference_ = nullptr;  // by path: what is seen at its pixel, see guiding.h
  Lessons<W>* lessons_ = nullptr;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif

#include <kinora/simd/tables.h>
