// Light samples at the vertices of the forward loop, and their shadow rays; what manifold walks find from there. Called
// by path_loop.h for the contexts of each vertex. Included per target.
#include <kinora/guiding.h>
#include <kinora/light_candidates.h>
#include <kinora/math/sampling.h>
#include <kinora/path_state.h>
#include <kinora/random.h>
#include <kinora/samples_by_lobe.h>
#include <kinora/scatter_once.h>

#if defined(KINORA_PATH_VERTEX_LIGHTS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PATH_VERTEX_LIGHTS_H_TARGET
#undef KINORA_PATH_VERTEX_LIGHTS_H_TARGET
#else
#define KINORA_PATH_VERTEX_LIGHTS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W, class Walks>
class VertexLights {
 public:
  // learned: null, or which lights are worth a sample.
  VertexLights(const PathState<W>& paths, Walks& walks, const guiding::State* learned)
      : p_(paths), g_(paths.g), sv_(paths.sv), o_(paths.o), walks_(walks), learned_(learned) {}

  // Light samples at the points of the contexts: `parts`, and those that lights ask for themselves.
  // once: the contexts are of points in a body that its light has to leave. place: which of `places` points they are that
  // take samples of the same light.
  void sample(uint32_t count, Context* const* contexts, uint32_t depth, uint32_t parts, uint32_t bxdfParts,
              ScatterOnce<W>* once = nullptr, uint32_t place = 0, uint32_t places = 1) {
    const SampleNumbers of{place, places};
    for (uint32_t part = 0; part < parts; ++part)
      sampleEach(count, contexts, depth, part, parts, bxdfParts, nullptr, once, of);
    for (uint32_t k = 0; g_->besideOwnSamples && k < sv_->ownSampleCount; ++k)
      for (uint32_t part = 0; part < sv_->ownSamples[k].samples; ++part)
        sampleEach(count, contexts, depth, part, parts, bxdfParts, &sv_->ownSamples[k], once, of);
  }
  // Light that comes through mirrors and lenses.
  void walk(uint32_t count, Context* const* contexts, uint32_t depth) {
    walks_.connect(
        count, contexts, depth,
        {p_.throughput, p_.state, o_.maxIndirectBounces, o_.clampDepth, o_.clampLuminance, o_.clampCaustic});
  }

 private:
  struct SampleNumbers {
    uint32_t place, places;
  };
  // One light sample for each point of the contexts (own: of that light, else of any); bxdfParts directions will be
  // followed from them.
  void sampleEach(uint32_t count, Context* const* contexts, uint32_t depth, uint32_t part, uint32_t parts,
                  uint32_t bxdfParts, const OwnLightSamples* own, ScatterOnce<W>* once, SampleNumbers of) {
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
      o[c] = p_.floats(room);
      d[c] = p_.floats(room);
      T[c] = p_.floats(room);
      value[c] = p_.floats(room * mostSlots);
    }
    float *tMax = p_.floats(room), *time = p_.floats(room);
    uint32_t* point = p_.words(room);
    ShadowRun* runs = static_cast<ShadowRun*>(sv_->alloc(g_, count * sizeof(ShadowRun)));
    uint32_t* tinted = o_.allowCaustics || !sv_->hasTintedShadows ? nullptr : p_.words(room);
    uint32_t* ray = p_.words(room * mostSlots);  // of each contribution
    uint32_t* owner = p_.words(room * mostSlots);
    uint32_t* light = p_.words(room * mostSlots);
    uint32_t* state = p_.words(room * mostSlots);
    float* share = sv_->wantsUnshadowed || o_.unshadowedEnd > 0 ? p_.floats(room * mostSlots) : nullptr;
    float *spread = nullptr, *shareOfRay = nullptr;
    uint32_t* lightOfRay = sv_->hasShadowControls ? p_.words(room) : nullptr;
    const float most = p_.mostAt(depth + 1);
    const float unshadowed = depth == o_.maxIndirectBounces ? o_.unshadowedEnd : 0;
    uint32_t rays = 0, entries = 0;
    LightLessons<W>* lessons = g_->lightWeights && g_->teaches ? new (sv_->alloc(g_, sizeof(LightLessons<W>)))
                                                                     LightLessons<W>(g_, sv_, points)
                                                               : nullptr;

    for (uint32_t k = 0; k < count; ++k) {
      const Context& c = *contexts[k];
      const uint32_t firstOfContext = rays, firstEntry = entries;
      if (g_->lightWeights && part == 0 && !own) weighLights<W>(g_, sv_, learned_, c);
      const bool byLobe = o_.byLobe.given && p_.isFirst(c, depth);
      const LobeCounts<W> counts(c, o_.byLobe);
      const uint32_t number = p_.isFirst(c, depth) ? part : part + p_.sequence();
      LightCandidates<W> candidates(g_, sv_, c);
      if (own) {
        sv_->ownLightSamples(g_, &c, own->light, number, own->samples, &candidates.samples);
        candidates.scatter();
      } else {
        candidates.make(number + of.place * parts, parts * of.places,
                        p_.isFirst(c, depth) && !byLobe && !lessons ? o_.lightCandidates : 1, p_.throughput,
                        [&](F byLight, F byBxdf)
                            HWY_ATTR { return misPower(byLight * F(float(parts)), byBxdf * F(float(bxdfParts))); });
      }
      const LightSamples& ls = candidates.samples;
      EvaluateArgs& e = candidates.scattered;
      if (lessons) lessons->add(c, ls, p_.throughput, parts);
      if (ls.spread && !spread) spread = p_.floats(room);
      const bool hasAll = c.traits & kTraitScattersOnce && !once;
      if (once && !shareOfRay) shareOfRay = p_.floats(room);
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
        if (p_.share && c.traits & kTraitInSpace) scale = scale * s.get(p_.share);
        if (candidates.factor) scale = scale * F::load(candidates.factor + i);
        Vec3<W> base = Vec3<W>::get(p_.throughput, s) * Vec3<W>::load(ls.radiance, i) * scale;
        Vec3<W> glossy = base;
        if (ls.specularRadiance[0])
          glossy = Vec3<W>::get(p_.throughput, s) * Vec3<W>::load(ls.specularRadiance, i) * scale;
        const Vec3<W> wi = Vec3<W>::load(ls.wi, i);
        // light that a tinted shadow brought to an earlier vertex
        const Mask<W> blocked = o_.allowCaustics ? Mask<W>(false) : p_.blockedByGlass(ls.light + i);
        const Mask<W> behind = p_.standsIn(c) ? p_.hasFlag(s, PathFlags::kHadDiffuse) & !blocked : Mask<W>(false);
        // light that walks bring: by rough boundaries here, and through what tinted shadow rays would pass
        const Mask<W> walked = p_.interfaces && some.any() ? p_.walkedTo(ls.light + i) : Mask<W>(false);
        Mask<W> walkedHere(false);
        if (walked.any() && (c.traits & kTraitWalkable))
          walkedHere = walked & (p_.walkedAfter(c, i, s, Int<W>(p_.walkableSlot(c)), Mask<W>(false)) != Int<W>(0));
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
          const Int<W> passes = select(walked & Mask<W>(p_.walksFrom(c, depth)), Int<W>(2), Int<W>(1));
          pack.put(select(p_.staysInside(c, i, wi) | blocked, Int<W>(0), passes), tinted + rays);
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
        const Int<W> row = s.get(p_.state) * Int<W>(sv_->paths.eventCount);
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
      if (once)
        leaveBody(*once, firstOfContext, rays, firstEntry, entries, point, o, d, tMax, shareOfRay, ray, value);
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
    p_.contribute(out);
  }

  // Shadow rays from within a body, and what they bring: from where they leave it. share: that of the light sample, by
  // ray, where the directions from there find lights too; null: all.
  void leaveBody(ScatterOnce<W>& once, uint32_t first, uint32_t end, uint32_t firstEntry, uint32_t lastEntry,
                 const uint32_t* point, float* const o[3], float* const d[3], float* tMax, const float* share,
                 const uint32_t* ray, float* const value[3]) {
    const uint32_t n = end - first;
    if (!n) return;
    float* const from[3] = {o[0] + first, o[1] + first, o[2] + first};
    const float* const along[3] = {d[0] + first, d[1] + first, d[2] + first};
    float* const factor[3] = {p_.floats(padded(n) + kPad), p_.floats(padded(n) + kPad), p_.floats(padded(n) + kPad)};
    once.leaveBody(n, point + first, from, along, tMax + first, share ? share + first : nullptr, factor);
    for (uint32_t e = firstEntry; e < lastEntry; ++e)
      for (int c = 0; c < 3; ++c) value[c][e] *= factor[c][ray[e] - first];
  }

  // Light samples before their shadow rays. Those of what media emit without their share of the two techniques: rays do
  // not tell of that beyond what they hit.
  void contributeUnshadowed(const Contributions& all, const float* share) {
    Contributions out = all;
    float* value[3];
    for (int c = 0; c < 3; ++c) {
      out.value[c] = value[c] = p_.floats(padded(all.count + 1));
      for (uint32_t i = 0; i < all.count; ++i)
        value[c][i] = all.light[i] == kNoLight ? all.value[c][i] / share[i] : all.value[c][i];
    }
    out.kind = LightKind::Unshadowed;
    p_.contribute(out);
  }

  const PathState<W>& p_;
  Group* g_;
  const Services* sv_;
  const PathLoopOptions& o_;
  Walks& walks_;
  const guiding::State* learned_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
