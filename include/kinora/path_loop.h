// The forward path loop: next-event estimation and bxdf sampling with multiple importance sampling, over one group of
// camera samples. Stock integrators are thin settings over it (PathLoopOptions); authors may use it, or copy the way it
// calls the services. Its parts: what paths carry (path_state.h), light samples at their vertices (path_vertex_lights.h),
// light that their rays find (path_found_lights.h), their ways below surfaces (path_below.h). Included per target.
#include <kinora/cover_by_media.h>
#include <kinora/path_below.h>
#include <kinora/path_found_lights.h>
#include <kinora/path_vertex_lights.h>
#include <kinora/random.h>

#include <cmath>

#if defined(KINORA_PATH_LOOP_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PATH_LOOP_H_TARGET
#undef KINORA_PATH_LOOP_H_TARGET
#else
#define KINORA_PATH_LOOP_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W, class Walks = ManifoldWalks<W>>
class PathLoop {
 public:
  PathLoop(Group* group, const Services* services, const PathLoopOptions& options)
      : g_(group),
        sv_(services),
        o_(options),
        walks_(group, services, options.manifold),
        p_(group, services, o_, walks_.interfaces()) {
    if (o_.guides) {
      const auto* state = static_cast<const guiding::State*>(sv_->learned(g_));
      if (state && state->guides) {
        guide_ = state;
        reference_ = p_.floats(g_->padded + kPad);
      }
      if (g_->teaches && !(state && state->isIdle))
        p_.lessons = new (sv_->alloc(g_, sizeof(Lessons<W>))) Lessons<W>(g_, sv_);
    }
    if (o_.mostPassed >= 0) g_->mostPassed = uint32_t(o_.mostPassed);
  }

  void run() {
    const uint32_t n = g_->count;
    uint32_t* live = p_.words(g_->padded + kPad);
    uint32_t* onward = p_.words(g_->padded + kPad);
    const bool byLobe = o_.byLobe.given;
    const uint32_t bxdfParts = byLobe ? 1 : p_.parts;  // whose number is in densities and throughput
    MemoryMark mark = sv_->markMemory(g_);
    for (uint32_t i = 0; i < g_->padded; ++i) {
      live[i] = i < n ? i : n - 1;
      p_.start(i, g_->rayWeight[i < n ? i : n - 1]);
      if (reference_) reference_[i] = guide_->seen;
    }
    if (sv_->ownSampleCount) g_->besideOwnSamples = o_.lightSamples;
    // camera vertex
    sv_->trace(g_, &g_->paths, RayKind::Camera, 0, n, live, p_.mediumIfAny());
    if (sv_->mediaScatter) coverByMedia(g_, sv_, n, live, p_.medium);
    found_.collectLights(RayKind::Camera, 0, 1, 1, n, live);
    found_.collectGlow(0, 1, n, live);
    lightOnTheWay(0, o_.placesInMedia, o_.lightSamples, bxdfParts, n, live);
    p_.applyMedium(n, live);
    uint32_t hits = p_.keepHits(n, live);
    Context* const* contexts;
    const uint32_t count =
        sv_->shade(g_, &g_->paths, kTraitEyePath | kTraitPrimaryHit | kTraitSubsurface, 0, hits, live, &contexts);
    for (uint32_t c = 0; c < count; ++c) emission(*contexts[c]);
    lights_.sample(count, contexts, 0, o_.lightSamples, bxdfParts);
    lights_.walk(count, contexts, 0);
    if (p_.parts > 1) {  // the first vertex is needed again
      keepFirst(hits, live);
      mark = sv_->markMemory(g_);
    }
    for (p_.part = 0; p_.part < p_.parts; ++p_.part) {
      if (p_.part) {
        restoreFirst(hits, live);
        if (sv_->ownSampleCount) g_->besideOwnSamples = o_.lightSamples;
      }
      follow(count, contexts, bxdfParts, mark, onward);
      if (p_.lessons) p_.lessons->end();
    }
    if (p_.alpha) p_.alpha->cover();
  }

 private:
  // What was learned of lights, where they are weighed by it.
  static const guiding::State* learnedLights(const PathState<W>& p) {
    return p.o.learnsLights ? chooseLearnedLights(p.g, p.sv) : nullptr;
  }

  // Light scattered in media on the way of the rays of `live`, where it is near lights, at so many places of each; what
  // the ends of the rays in media have left of that light.
  void lightOnTheWay(uint32_t depth, uint32_t places, uint32_t lightParts, uint32_t bxdfParts, uint32_t n,
                     const uint32_t* live) {
    if (!p_.share) return;
    const bool isAsked = lightParts && sv_->lightCount;
    for (uint32_t i = 0; i < n; ++i) p_.share[live[i]] = isAsked ? 0.f : 1.f;
    if (!isAsked) return;
    for (uint32_t k = 0; k < places; ++k) {
      const MemoryMark mark = places > 1 ? sv_->markMemory(g_) : MemoryMark{};
      TowardsLights found;
      sv_->scatterTowardsLights(g_, &g_->paths, depth, k, places, n, live, &found);
      for (uint32_t i = 0; i < n; ++i) p_.share[live[i]] += found.share ? found.share[live[i]] : 1.f;
      lightAtPlaces(found, depth, k, places, lightParts, bxdfParts);
      if (places > 1) sv_->releaseMemory(g_, mark);
    }
    for (uint32_t i = 0; places > 1 && i < n; ++i) p_.share[live[i]] /= float(places);
  }
  void lightAtPlaces(const TowardsLights& found, uint32_t depth, uint32_t place, uint32_t places, uint32_t lightParts,
                     uint32_t bxdfParts) {
    if (!found.count) return;
    float *kept[3], *share = p_.share;
    for (int c = 0; c < 3; ++c) {
      kept[c] = p_.throughput[c];
      p_.throughput[c] = p_.floats(g_->padded + kPad);
      for (uint32_t i = 0; i < found.count; ++i) {
        const uint32_t s = found.entries[i];
        p_.throughput[c][s] = kept[c][s] * found.factor[c][s];
      }
    }
    p_.share = nullptr;
    Context* const* contexts;
    const uint32_t count =
        sv_->shade(g_, found.list, kTraitEyePath | kTraitScattersOnce, depth, found.count, found.entries, &contexts);
    lights_.sample(count, contexts, depth, lightParts, bxdfParts, nullptr, place, places);
    p_.share = share;
    for (int c = 0; c < 3; ++c) p_.throughput[c] = kept[c];
  }

  void emission(const Context& c) {
    if (!c.bxdf->emission) return;
    float* e[3];
    for (float*& x : e) x = p_.floats(c.padded);
    c.bxdf->emission(&c, c.closure, e);
    uint32_t* state = p_.words(c.padded);
    uint32_t* slot = p_.words(c.padded);
    uint32_t* light = p_.words(c.padded);
    uint32_t m = 0;
    for (uint32_t i = 0; i < c.count; ++i) {
      const uint32_t s = c.path[i];
      float v[3];
      for (int k = 0; k < 3; ++k) v[k] = e[k][i] * p_.throughput[k][s] * o_.emission;
      if (!(v[0] != 0 || v[1] != 0 || v[2] != 0)) continue;
      p_.clampOne(c.depth, v);
      for (int k = 0; k < 3; ++k) e[k][m] = v[k];
      slot[m] = s;
      light[m] = kNoLight;
      state[m] = p_.state[s];
      ++m;
    }
    if (!m) return;
    const Contributions out{m, slot, {e[0], e[1], e[2]}, state, light};
    p_.contribute(out);
  }

  // New directions from the contexts' points; returns the slots that go on.
  uint32_t scatterPaths(uint32_t count, Context* const* contexts, uint32_t depth, uint32_t part, uint32_t parts,
                        uint32_t* live) {
    using F = Float<W>;
    uint32_t m = 0;
    for (uint32_t k = 0; k < count; ++k) {
      const Context& c = *contexts[k];
      if (c.traits & kTraitScattersOnce) continue;
      float *u[4], *wi[3], *weight[3];
      for (float*& x : u) x = p_.floats(c.padded);
      for (int x = 0; x < 3; ++x) {
        wi[x] = p_.floats(c.padded);
        weight[x] = p_.floats(c.padded);
      }
      float* pdf = p_.floats(c.padded);
      uint32_t *slot = p_.words(c.padded), *flags = p_.words(c.padded);
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
      uint32_t *point = p_.words(c.padded + kPad), *through = p_.words(c.padded + kPad);
      uint32_t *below = p_.words(c.padded + kPad), leaving = 0, sinking = 0;
      uint32_t *once = c.bxdf->subsurface ? p_.words(c.padded + kPad) : nullptr, scattering = 0;
      for (uint32_t i = 0; i < c.count; i += W) {
        Mask<W> on = Mask<W>::firstN(int(c.count - i < W ? c.count - i : W));
        const Slots<W> s = Slots<W>::load(c.path + i);
        const Int<W> lobe = Int<W>::load(slot + i);
        on = on & (lobe != Int<W>(kNoLobe));
        const F p = F::load(pdf + i);
        on = on & (p > F(0.f));
        Vec3<W> t = Vec3<W>::get(p_.throughput, s) * Vec3<W>::load(weight, i) * (F(1.f) / max(p, F(1e-38f)));
        F number(1.f);
        if (byLobe) {
          number = counts.of(lobe, Int<W>::load(flags + i));
          on = on & (F(float(p_.part)) < number);
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
            const F goesOn = clamp(worth, F(kLeastSurvival), F(1.f));
            q = select(expected < F(0.f), q, chosen.endsPaths ? goesOn : max(q, goesOn));
          }
          on = on & (r < q);
          t = t * (F(1.f) / q);
          survival = q;
        }
        on = on & (maxComponent(t) > F(0.f));
        if (c.bxdf->subsurface) {
          const Mask<W> sinks = on & ((Int<W>::load(flags + i) & Int<W>(uint32_t(kSampleBelow))) != Int<W>(0));
          if (sinks.any()) {
            p_.setThroughput(sinks, s, t);
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
        const Int<W> fl = Int<W>::load(flags + i);
        const Mask<W> discrete = (fl & Int<W>(uint32_t(kSampleDiscrete))) != Int<W>(0);
        if (p_.lessons && !(c.traits & kTraitInSpace))
          p_.lessons->add(on & !discrete, c, i, s, w, t, survival, p, chosen.at(i, p), chosen.isGuided(i),
                          1.f / float(parts), depth == 0 && p_.part + 1 == p_.parts);
        p_.send(on, c, i, s, w);
        p_.setThroughput(on, s, t);
        s.put(on, p * number, p_.pdf);
        const F spread = F::load(c.spread + i);
        s.put(on, select(discrete, spread, spreadAfter(spread, p)), g_->paths.rays.spread);
        Int<W> event(c.slotCount ? uint32_t(c.eventOfSlot[0]) : 0u);
        for (uint32_t l = 1; l < c.slotCount; ++l)
          event = select(lobe == Int<W>(l), Int<W>(uint32_t(c.eventOfSlot[l])), event);
        p_.step(on, s, event);
        const Mask<W> transmits = (fl & Int<W>(uint32_t(kSampleTransmit))) != Int<W>(0);
        const Mask<W> specular = (event & Int<W>(1)) != Int<W>(0);
        const Int<W> now = p_.flag(discrete, kFromDiscrete) | p_.flag(specular, kFromSpecular) |
                           p_.flag(transmits, kFromTransmission);
        Int<W> all = now | p_.walkedAfter(c, i, s, lobe, discrete);
        if (p_.alpha) {
          const Mask<W> before = depth ? p_.hasFlag(s, PathFlags::kSeenThrough) : Mask<W>(true);
          all = all | p_.flag(before & transmits & specular, PathFlags::kSeenThrough);
        }
        s.put(on, o_.allowCaustics ? all : all | p_.withoutCaustics(c, i, s, w, lobe, discrete), p_.flags);
        const Packer<W> pack(on);
        pack.put(s.s, live + m);
        pack.put(Int<W>::lanes(int32_t(i)), point + leaving);
        pack.put(p_.flag(transmits, 1), through + leaving);
        m += uint32_t(pack.count);
        leaving += uint32_t(pack.count);
      }
      if (leaving) sv_->leave(g_, &g_->paths, &c, leaving, point, nullptr, through);
      if (sinking) m = below_.followBelow(c, sinking, below, ga, depth, part, parts, live, m);
      if (scattering) m = below_.followOnce(c, scattering, once, ga, depth, part, parts, live, m);
    }
    p_.padList(m, live);
    return m;
  }

  // `mark`: all that was made since is needed until the next directions are chosen, and no longer.
  void follow(uint32_t count, Context* const* contexts, uint32_t parts, MemoryMark mark, uint32_t* live) {
    for (uint32_t depth = 0;; ++depth) {
      const bool first = depth == 0;
      const uint32_t part = o_.byLobe.given ? p_.sequence() : first ? p_.part : 0;
      const uint32_t n = scatterPaths(count, contexts, depth, part, first ? parts : 1, live);
      sv_->releaseMemory(g_, mark);
      if (!n) return;
      const uint32_t lightParts = first ? o_.lightSamples : 1, bxdfParts = first ? parts : 1;
      found_.tellAgainstLights(lightParts, bxdfParts, n, live);
      sv_->trace(g_, &g_->paths, RayKind::Indirect, depth + 1, n, live, p_.mediumIfAny());
      if (p_.lessons) p_.lessons->arrive(n, live);
      if (o_.farthest < 1e30f)  // of surfaces; lights are met wherever they are
        for (uint32_t i = 0; i < n; ++i) g_->paths.rays.tMax[live[i]] = 1e30f;
      // as its other half, without what media absorb
      found_.collectTinted(depth + 1, lightParts, bxdfParts, n, live);
      found_.collectLights(RayKind::Indirect, depth + 1, lightParts, bxdfParts, n, live);
      below_.endWithin(n, live);
      found_.collectGlow(depth + 1, bxdfParts, n, live);
      g_->besideOwnSamples = 0;  // of the first vertex only
      if (p_.alpha) escape(first ? parts : 1, n, live);
      if (depth >= o_.maxIndirectBounces) return;  // the last directions only looked for light
      if (first && parts > 1)
        for (uint32_t i = 0; i < n; ++i)
          for (int c = 0; c < 3; ++c) p_.throughput[c][live[i]] /= float(parts);
      lightOnTheWay(depth + 1, 1, 1, 1, n, live);
      p_.applyMedium(n, live);
      const uint32_t hits = p_.keepHits(n, live);
      if (!hits) return;
      count = sv_->shade(g_, &g_->paths, kTraitEyePath | kTraitSubsurface, depth + 1, hits, live, &contexts);
      for (uint32_t c = 0; c < count; ++c) emission(*contexts[c]);
      lights_.sample(count, contexts, depth + 1, 1, 1);
      lights_.walk(count, contexts, depth + 1);
    }
  }

  // Rays that met nothing behind what refracted them; the vertex before followed `parts` of them.
  void escape(uint32_t parts, uint32_t n, const uint32_t* live) {
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      if (!(p_.flags[s] & PathFlags::kSeenThrough) || g_->paths.hits.t[s] < 3e38f) continue;
      float v[3];
      for (int c = 0; c < 3; ++c) v[c] = p_.throughput[c][s] * (sv_->hasMedia ? p_.medium[c][s] : 1.f) / float(parts);
      p_.alpha->add(s, v);
    }
  }

  void keepFirst(uint32_t n, const uint32_t* live) {
    for (int c = 0; c < 3; ++c) firstThroughput_[c] = p_.floats(g_->padded + kPad);
    firstState_ = p_.words(g_->padded + kPad);
    if (p_.share) firstShare_ = p_.floats(g_->padded + kPad);
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      for (int c = 0; c < 3; ++c) firstThroughput_[c][s] = p_.throughput[c][s];
      firstState_[s] = p_.state[s];
      if (p_.share) firstShare_[s] = p_.share[s];
    }
  }
  void restoreFirst(uint32_t n, const uint32_t* live) {
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = live[i];
      for (int c = 0; c < 3; ++c) p_.throughput[c][s] = firstThroughput_[c][s];
      p_.state[s] = firstState_[s];
      p_.flags[s] = kFromDiscrete;
      if (p_.share) p_.share[s] = firstShare_[s];
    }
  }

  Group* g_;
  const Services* sv_;
  const PathLoopOptions o_;
  Walks walks_;
  PathState<W> p_;
  FoundLights<W> found_{p_};
  VertexLights<W, Walks> lights_{p_, walks_, learnedLights(p_)};
  SunkPaths<W, VertexLights<W, Walks>> below_{p_, lights_};
  // Of the first vertex, while its directions are followed one by one.
  float *firstThroughput_[3] = {}, *firstShare_ = nullptr;
  uint32_t* firstState_ = nullptr;
  // Of what a path is expected to bring to its pixel, over all that is seen there, what lets it go on for certain; and
  // how likely it goes on at least.
  static constexpr float kLearnedRoulette = 0.3f, kLeastSurvival = 0.3f;
  const guiding::State* guide_ = nullptr;
  float* reference_ = nullptr;  // by path: what is seen at its pixel, see guiding.h
};

// An integrator that is the loop and no more; its data are the options. Ratio: see ManifoldWalks.
template <class Ratio = DensityRatio>
struct RunsPathLoop {
  using Data = PathLoopOptions;
  template <int W>
  static void integrate(const Data& options, uint32_t, Group& group, const Services& services) {
    PathLoop<W, ManifoldWalks<W, Ratio>>(&group, &services, options).run();
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif

#include <kinora/simd/tables.h>
