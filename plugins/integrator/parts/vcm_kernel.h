// Bidirectional path tracing with vertex connection and merging (Georgiev, Krivanek, Davidovic, Slusallek: "Light
// Transport Simulation with Vertex Connection and Merging", 2012; Hachisuka, Pantaleoni, Jensen, 2012). Light paths
// run first: their vertices are connected to the camera and stored. Camera paths then meet lights, sample them, are
// connected to the vertices of the light path of their own number, and merged with those of any light path near by.
// All ways to find a path share it by the balance heuristic (kinora/path_densities.h). Both kinds of paths scatter in
// media, whose vertices are connected as those on surfaces are. What media emit is found by camera paths and light
// samples alone. Included per target, behind integrator_author.h.
#include "plugins/integrator/parts/vcm_merged.h"

#include "plugins/integrator/parts/vcm_beams.h"

#include "plugins/integrator/parts/vcm_kept.h"

#include "plugins/integrator/parts/vcm_connections.h"

#include <kinora/guiding.h>
#include <kinora/subpaths_below.h>

#if defined(KINORA_VCM_KERNEL_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_VCM_KERNEL_H_TARGET
#undef KINORA_VCM_KERNEL_H_TARGET
#else
#define KINORA_VCM_KERNEL_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Shares: VcmShares, or what a test puts in its place.
template <int W, class Shares = VcmShares>
class Vcm {
 public:
  Vcm(Group* group, const Services* services, const vcm::Options& options)
      : g_(group),
        sv_(services),
        o_(options),
        lightPaths_(float(services->resolution[0]) * float(services->resolution[1])),
        paths_(group, services,
               kTraitSubsurface | (options.hasLightPaths() ? kTraitBothEnds : 0u) |
                   (group->stage == StageKind::LightPaths ? kTraitLightPath : kTraitEyePath),
               group->stage == StageKind::LightPaths ? options.rouletteOfLight : options.roulette),
        learned_(options.learnsLights ? chooseLearnedLights(group, services) : nullptr),
        connectsCamera_(options.connects && !services->wantsUnshadowed),
        sums_(group, services, {options.connects, connectsCamera_ ? lightPaths_ : 0}),
        arrivals_(group, services, group->stage == StageKind::LightPaths ? 0 : 4096,
                  group->stage == StageKind::LightPaths ? 0 : 16384),
        near_(group, services, options, lightPaths_),
        beams_(group, services, options, near_, paths_, sums_, connectsCamera_ ? lightPaths_ : 0, learned_),
        readsEvents_(readsEvents(services->paths)),
        connections_(group, services, options, paths_, sums_, arrivals_, readsEvents_) {}

  void run() { g_->stage == StageKind::LightPaths ? lightStage() : cameraStage(); }

 private:
  using F = Float<W>;
  using V = Vec3<1>;
  using Stored = vcm::Stored;
  using Photon = vcm::Photon;
  using MergeIndex = vcm::MergeIndex;
  using Near = typename Neighbourhoods<W>::Of;

  template <class T>
  T* make(uint32_t n) const {
    return static_cast<T*>(sv_->alloc(g_, (n + kPad) * sizeof(T)));
  }

  void lightStage() {
    paths_.startAtLights();
    KeptVertices<W> kept(g_, sv_, o_, near_, sums_);
    for (uint32_t depth = 0; paths_.count && depth <= o_.bounces; ++depth) {
      const bool keeps = depth < kept.most();
      if (keeps) kept.makeRoom(paths_.count);
      const MemoryMark mark = sv_->markMemory(g_);
      Context* const* contexts;
      paths_.trace(depth);
      beams_.keepWays(depth);
      const uint32_t count = paths_.shade(depth, &contexts);
      for (uint32_t k = 0; k < count; ++k) {
        const Context& c = *contexts[k];
        if (depth && c.traits & kTraitScattersOnce) continue;  // sees lights alone
        if (!depth) weigh(c);                                  // light samples there are another technique
        depth ? sums_.arrive(c) : sums_.begin(g_, sv_, c, paths_.light);
        const Near near = near_.of(c);
        beams_.keepPoints(c);
        if (connectsCamera_ || keeps) {
          const PathVertex* vertices = paths_.vertices(c, depth);
          if (connectsCamera_) connectCamera(c, depth, vertices, near);
          if (keeps) kept.keep(c, vertices, near);
        }
        leave(c, paths_.scatter(c, depth), near);
      }
      sv_->releaseMemory(g_, mark);
    }
    kept.store();
  }

  void cameraStage() {
    paths_.startAtCamera();
    if (o_.connects) connections_.findEnds();
    const MemoryMark mark = sv_->markMemory(g_);
    for (uint32_t depth = 0; paths_.count; ++depth) {
      Context* const* contexts;
      paths_.trace(depth);
      if (!depth) paths_.coverByMedia();
      meetLights(depth);
      sums_.endLit(paths_.count, paths_.live);
      if (depth <= o_.bounces) beams_.alongRays(depth);
      paths_.contributeGlow(o_.mostAt(depth));
      if (depth > o_.bounces) return;
      const uint32_t count = paths_.shade(depth, &contexts);
      Near* nears = make<Near>(count);
      for (uint32_t k = 0; k < count; ++k) {
        const Context& c = *contexts[k];
        weigh(c);
        arrive(c, depth);
        const Near& near = nears[k] = near_.of(c);
        paths_.contributeEmission(c, o_.mostAt(depth), o_.emission);
        if (c.traits & kTraitInSpace ? o_.mergesMedia : o_.merges) merge(c, near);
        beams_.atPoints(c, near);
      }
      const uint32_t lightParts = depth ? 1 : o_.lightSamples;
      sampleLights(count, contexts, nears, lightParts);
      if (o_.connects) connections_.connect(count, contexts, nears, depth);
      SunkPoints* sunk = make<SunkPoints>(count);
      for (uint32_t k = 0; k < count; ++k) {
        const Context& c = *contexts[k];
        sunk[k].count = 0;
        if (c.traits & kTraitScattersOnce) continue;
        leave(c, paths_.scatter(c, depth, lightParts, &sunk[k]), nears[k]);
      }
      for (uint32_t k = 0; k < count; ++k) followBelow(sunk[k], depth, lightParts);
      sv_->releaseMemory(g_, mark);
    }
  }
  void followBelow(const SunkPoints& sunk, uint32_t depth, uint32_t lightParts) {
    SubpathsBelow<W>(g_, sv_, paths_, sums_)
        .follow(
            sunk,
            [&](const Emerged& out) {
              Near* nears = make<Near>(out.count);
              for (uint32_t k = 0; k < out.count; ++k) {
                weigh(*out.contexts[k]);
                nears[k] = near_.of(*out.contexts[k]);
                if (o_.merges) merge(*out.contexts[k], nears[k]);
              }
              sampleLights(out.count, out.contexts, nears, lightParts);
              if (o_.connects) connections_.connect(out.count, out.contexts, nears, depth);
              for (uint32_t k = 0; k < out.count; ++k)
                leave(*out.contexts[k], paths_.scatter(*out.contexts[k], depth, lightParts), nears[k]);
            },
            [&](const ScatterOnce<W>& once) { sampleLightsWithin(once, lightParts); });
  }

  // By what was learned where its points are they choose lights; densities of that choice are the same from now on.
  void weigh(const Context& c) {
    if (g_->lightWeights) weighLights<W>(g_, sv_, learned_, c);
  }
  // Lessons of so many light samples; null: none is wanted. They teach by end(), when the arrivals have been sent.
  LightLessons<W>* lessonsOf(uint32_t samples) const {
    if (!g_->lightWeights || !g_->teaches) return nullptr;
    return new (sv_->alloc(g_, sizeof(LightLessons<W>))) LightLessons<W>(g_, sv_, samples);
  }

  void leave(const Context& c, const GenerateArgs& a, const Near& near) {
    float* merges = near.merges ? c.alloc<float>(c.padded) : nullptr;
    for (uint32_t i = 0; merges && i < c.count; ++i)
      merges[i] = Neighbourhoods<W>::mergesOf(near, c, i, V::load(a.wi, i)).lane0();
    sums_.leave(c, a, merges);
  }

  // ---- light paths
  void connectCamera(const Context& c, uint32_t depth, const PathVertex* vertices, const Near& near) {
    CameraConnection camera;
    sv_->connectCamera(g_, &c, &camera);
    const EvaluateArgs e = evaluateBxdf(c, camera.wi);
    // Rays come from where those of the camera begin, so that they see what these see.
    float* reach = c.alloc<float>(c.padded + kPad);
    for (uint32_t i = 0; i < c.padded; ++i) reach[i] = std::max(camera.distance[i] - camera.begin[i], 0.f);
    RayList& rays = *sv_->makeRays(g_, c.count);
    rays.passesMedia = 1;
    const float* through = transmittanceOfEdges(g_, sv_, c, camera.wi, reach);
    float *T[3], *value[3], *raster[2], *share = c.alloc<float>(c.padded);
    for (float*& x : T) x = c.alloc<float>(c.padded + kPad);
    for (float*& x : value) x = c.alloc<float>(c.padded * c.slotCount + kPad);
    for (float*& x : raster) x = c.alloc<float>(c.padded * c.slotCount + kPad);
    uint32_t *point = c.alloc<uint32_t>(c.padded), *entries = c.alloc<uint32_t>(c.padded), n = 0;
    uint32_t* isHidden = c.alloc<uint32_t>(c.padded);
    for (uint32_t i = 0; i < c.count; ++i) {
      if (!(camera.importance[i] > 0) || !(e.pdf[i] > 0)) continue;
      const V wi = V::load(camera.wi, i), P = V::load(c.P, i);
      const float distance = std::max(camera.distance[i], 1e-18f);
      PathSums sums = sums_[c.path[i]];
      if (!o_.samplesLight(depth)) sums.last = 0;
      const float others =
          othersOfSplat(sums, distance, camera.pdf[i], lightPaths_, surfaceCosine(c, i, wi), e.pdfReverse[i],
                        Neighbourhoods<W>::mergesOf(near, c, i, wi).lane0(), through[i]);
      share[n] = adjointFactor(c, i, wi).lane0() * camera.importance[i] / (distance * distance * (1 + others));
      const float far = std::max(reach[i], 1e-18f);
      fma(wi, Float<1>(far), P).store(rays.rays.o, n);
      (-wi).store(rays.rays.d, n);
      rays.rays.tMax[n] = far * 0.99999f - 2 * c.bias[i];
      rays.rays.time[n] = c.time[i];
      rays.rays.radius[n] = rays.rays.spread[n] = 0;
      rays.sampleSeed[n] = c.sampleSeed[i];
      rays.sampleIndex[n] = c.sampleIndex[i];
      rays.origin[n] = kFromDiscrete;
      entries[n] = n;
      point[n++] = i;
    }
    if (!n) return;
    for (uint32_t r = n; r < padded(n); ++r) entries[r] = n - 1;
    sv_->trace(g_, &rays, RayKind::Camera, depth, n, entries, T);
    // nor do they pass lights that the camera sees
    for (uint32_t r = 0; r < n; ++r) isHidden[r] = rays.hits.t[r] < rays.rays.tMax[r];
    LightHits lights;
    sv_->lightHits(g_, &rays, RayKind::Camera, n, entries, &lights);
    for (uint32_t k = 0; k < lights.count; ++k)
      isHidden[lights.slot[k]] |= lights.blocks[k] && lights.t[k] < rays.rays.tMax[lights.slot[k]];
    uint32_t *state = c.alloc<uint32_t>(c.padded * c.slotCount + kPad), m = 0;
    uint32_t* light = c.alloc<uint32_t>(c.padded * c.slotCount + kPad);
    for (uint32_t r = 0; r < n; ++r) {
      if (isHidden[r]) continue;
      const uint32_t i = point[r];
      const PathVertex& at = vertices[i];
      const V arriving = V::load(T, r) * V(at.throughput[0], at.throughput[1], at.throughput[2]) * Float<1>(share[r]);
      for (uint32_t l = 0; l < c.slotCount; ++l) {
        const uint32_t event = c.eventOfSlot[l];
        // a pixel gets the share that the light path has in those of the sample
        const V v =
            clamped(depth + 2, arriving * V::load(e.weight[l], i) * Float<1>(at.factorOf(event) / lightPaths_)) *
            Float<1>(lightPaths_);
        if (!(maxComponent(v).lane0() > 0)) continue;
        v.store(value, m);
        for (int k = 0; k < 2; ++k) raster[k][m] = camera.raster[k][i];
        state[m] = stepState(sv_->paths, sv_->paths.start, event, at.tail);
        light[m++] = at.light;
      }
    }
    if (m) sv_->splat(g_, m, raster, value, state, light);
  }

  // ---- camera paths
  void arrive(const Context& c, uint32_t depth) {
    if (depth || !connectsCamera_) return sums_.arrive(c);
    CameraConnection camera;
    sv_->connectCamera(g_, &c, &camera);
    sums_.beginAtCamera(c, camera);
  }

  // length: edges of the path, one more than its bounces.
  V clamped(uint32_t length, V v) const {
    const float most = o_.mostAt(length - 1);
    return most < 1e30f ? v * factorToLuminance(v, Float<1>(most)) : v;
  }

  void meetLights(uint32_t depth) {
    if (depth && sv_->wantsUnshadowed) passLights(depth);
    LightHits h;
    sv_->lightHits(g_, &g_->paths, depth ? RayKind::Indirect : RayKind::Camera, paths_.count, paths_.live, &h);
    if (!h.count) return;
    float* weight = make<float>(h.count);
    std::fill_n(weight, h.count, 1.f);
    if (depth) {
      const LightDensities light(g_, sv_, h);
      const float* through = transmittanceTo(h);
      for (uint32_t i = 0; i < h.count; ++i) {
        const uint32_t s = h.slot[i];
        weight[i] = 1 / (1 + othersOfHit(sums_[s], o_.samplesLight(depth - 1) ? h.pdf[i] : 0, light, i, through[i]));
      }
    }
    clampHits(h, depth, weight);
    paths_.contribute(h, depth, weight);
    if (depth) return;
    coverByLights(h);
    beams_.endAt(h);
  }
  void clampHits(const LightHits& h, uint32_t depth, float* weight) const {
    if (!(o_.mostAt(depth) < 1e30f)) return;
    for (uint32_t i = 0; i < h.count; ++i) {
      const uint32_t s = h.slot[i];
      const float w = weight[i] * (depth == 0                            ? 1.f
                                   : g_->paths.origin[s] & kFromSpecular ? h.specular[i]
                                                                         : h.diffuse[i]);
      const bool isSpecular = depth && g_->paths.origin[s] & kFromSpecular && h.specularRadiance[0];
      const V v =
          V::load(paths_.throughput, s) * V::load(isSpecular ? h.specularRadiance : h.radiance, i) * Float<1>(w);
      const float before = maxComponent(v).lane0(), after = maxComponent(clamped(depth + 1, v)).lane0();
      if (before > 0) weight[i] *= after / before;
    }
  }
  // Lights along rays as if nothing were in the way, beside light samples alone.
  void passLights(uint32_t depth) {
    uint32_t *list = make<uint32_t>(padded(paths_.count)), n = 0;
    for (uint32_t i = 0; i < paths_.count; ++i)
      if (!(g_->paths.origin[paths_.live[i]] & kFromDiscrete)) list[n++] = paths_.live[i];
    if (!n) return;
    std::fill(list + n, list + padded(n), list[n - 1]);
    LightHits h;
    sv_->lightsAlong(g_, &g_->paths, n, list, &h);
    if (!h.count) return;
    float* weight = make<float>(h.count);
    for (uint32_t i = 0; i < h.count; ++i) {
      const float bySamples = o_.samplesLight(depth - 1) ? h.pdf[i] * sums_[h.slot[i]].last : 0.f;
      weight[i] = 1 / (1 + bySamples);
    }
    clampHits(h, depth, weight);
    paths_.contributeUnshadowed(h, depth, weight);
  }
  // transmittanceOfEdges() to lights met.
  const float* transmittanceTo(const LightHits& h) const {
    float* out = make<float>(h.count);
    std::fill_n(out, h.count, 1.f);
    if (!sv_->mediaScatter) return out;
    const Rays& r = g_->paths.rays;
    float *o[3], *d[3], *time = make<float>(h.count);
    for (int k = 0; k < 3; ++k) {
      o[k] = make<float>(h.count);
      d[k] = make<float>(h.count);
      for (uint32_t i = 0; i < h.count; ++i) {
        o[k][i] = r.o[k][h.slot[i]];
        d[k][i] = r.d[k][h.slot[i]];
      }
    }
    for (uint32_t i = 0; i < h.count; ++i) time[i] = r.time[h.slot[i]];
    sv_->meanTransmittance(g_, h.count, o, d, h.t, time, out);
    return out;
  }
  void coverByLights(const LightHits& h) const {
    float* alpha = make<float>(h.count);
    uint32_t *slots = make<uint32_t>(h.count), n = 0;
    for (uint32_t i = 0; i < h.count; ++i)
      if (h.blocks[i]) {
        slots[n] = h.slot[i];
        alpha[n++] = 1;
      }
    if (n) sv_->cover(g_, n, slots, alpha);
  }

  void sampleLights(uint32_t count, Context* const* contexts, const Near* nears, uint32_t parts) {
    if (!sv_->lightCount || !parts) return;
    uint32_t points = 0;
    for (uint32_t k = 0; k < count; ++k) points += contexts[k]->count;
    LightLessons<W>* lessons = lessonsOf(points * parts);
    for (uint32_t k = 0; k < count; ++k)
      for (uint32_t part = 0; part < parts; ++part) sampleLights(*contexts[k], nears[k], part, parts, lessons);
    arrivals_.send();
    if (lessons) lessons->end();
  }
  void sampleLights(const Context& c, const Near& near, uint32_t part, uint32_t parts, LightLessons<W>* lessons) {
    LightSamples ls;
    sv_->lightSamples(g_, &c, part, parts, &ls);
    if (lessons) lessons->add(c, ls, paths_.throughput, parts);
    arrivals_.of(c, lessons ? lessons->brought() : nullptr);
    const LightDensities light(g_, sv_, c, ls.wi, ls.t, ls.light);
    const EvaluateArgs e = evaluateBxdf(c, ls.wi);
    const float* through = transmittanceOfEdges(g_, sv_, c, ls.wi, ls.t);
    const bool isFollowed = !(c.traits & kTraitScattersOnce);
    const float most = o_.mostAt(c.depth + 1);
    Unshadowed open(c, sv_->wantsUnshadowed);
    for (uint32_t i = 0; i < c.count; i += W) {
      const F pdf = F::load(ls.pdf + i), scattered = F::load(e.pdf + i);
      const Mask<W> on =
          Mask<W>::firstN(int(std::min<uint32_t>(c.count - i, W))) & (pdf > F(0.f)) & (scattered > F(0.f));
      if (on.none()) continue;
      const Slots<W> s = Slots<W>::load(c.path + i);
      const Vec3<W> wi = Vec3<W>::load(ls.wi, i);
      const F found = isFollowed ? scattered : F(0.f);
      F others = othersOfSample(sums_.at(s.s), c, i, wi, found, F::load(e.pdfReverse + i), light,
                                Neighbourhoods<W>::mergesOf(near, c, i, wi), F::load(through + i));
      // of what media emit: RayList::againstLights is the other half
      const F byChance = found / (pdf * F(float(parts)));
      others = select(Int<W>::load(ls.light + i) == Int<W>(kNoLight), byChance * byChance, others);
      const Vec3<W> arriving = Vec3<W>::get(paths_.throughput, s) * Vec3<W>::load(ls.radiance, i) *
                               (F(1.f) / (pdf * (F(1.f) + others) * F(float(parts))));
      Vec3<W> glossy = arriving;
      if (ls.specularRadiance[0])
        glossy = Vec3<W>::get(paths_.throughput, s) * Vec3<W>::load(ls.specularRadiance, i) *
                 (F(1.f) / (pdf * (F(1.f) + others) * F(float(parts))));
      // As if nothing were in the way there are rays that meet lights beside it, and no more; and nothing beside samples
      // of what media emit. Nor does more count for what is learned: paths from the lights make up for what a choice
      // leaves out, so that one by what they leave of it would leave out ever more.
      F alone = F(1.f) + others;
      if (sv_->wantsUnshadowed || lessons)
        alone = alone / (F(1.f) + zeroUnless((Int<W>::load(ls.light + i) != Int<W>(kNoLight)) & !light.isDelta<W>(i),
                                             found / light.direct<W>(i)));
      if (lessons) lessons->scale(on, i, alone);
      const Int<W> ray = arrivals_.from(on, i, wi, F::load(ls.distance + i), c.slotCount,
                                        ls.spread ? F::load(ls.spread + i) : F(0.f), Int<W>::load(ls.light + i));
      for (uint32_t l = 0; l < c.slotCount; ++l) {
        const F factor = F::load((c.eventOfSlot[l] & 1 ? ls.specular : ls.diffuse) + i);
        Vec3<W> v = (c.eventOfSlot[l] & 1 ? glossy : arriving) * Vec3<W>::load(e.weight[l], i) * factor;
        if (most < 1e30f) v = v * factorToLuminance(v, F(most));
        const Int<W> state = paths_.stateAfter(s, c.eventOfSlot[l]), from = Int<W>::load(ls.light + i);
        arrivals_.add(on, v, ray, s.s, state, from);
        if (sv_->wantsUnshadowed) open.add(on, v * alone, s.s, state, from);
      }
    }
    open.send(g_, sv_);
  }
  // Light samples at points in a body that their light has to leave; nothing else finds lights from there.
  void sampleLightsWithin(const ScatterOnce<W>& once, uint32_t parts) {
    if (!sv_->lightCount || !parts) return;
    const Context& c = once.context();
    weigh(c);
    LightLessons<W>* lessons = lessonsOf(c.count * parts);
    for (uint32_t part = 0; part < parts; ++part) {
      Unshadowed open(c, sv_->wantsUnshadowed);
      LightSamples ls;
      sv_->lightSamples(g_, &c, part, parts, &ls);
      if (lessons) lessons->add(c, ls, paths_.throughput, parts);
      arrivals_.of(c, lessons ? lessons->brought() : nullptr);
      const EvaluateArgs e = evaluateBxdf(c, ls.wi);
      float *o[3], *factor[3], *tMax = make<float>(c.padded);
      uint32_t* point = make<uint32_t>(c.padded);
      for (int k = 0; k < 3; ++k) {
        o[k] = make<float>(c.padded);
        factor[k] = make<float>(c.padded);
        std::copy_n(c.P[k], c.padded, o[k]);
      }
      for (uint32_t i = 0; i < c.padded; ++i) {
        tMax[i] = ls.distance[i] * 0.99999f;
        point[i] = std::min(i, c.count - 1);
      }
      once.leaveBody(c.count, point, o, ls.wi, tMax, nullptr, factor);
      const uint32_t event = c.eventOfSlot[0];
      const bool isSpecular = event & 1;
      const float* const* radiance = isSpecular && ls.specularRadiance[0] ? ls.specularRadiance : ls.radiance;
      for (uint32_t i = 0; i < c.count; ++i) {
        if (!(ls.pdf[i] > 0)) continue;
        const uint32_t s = c.path[i];
        const float scale = (isSpecular ? ls.specular : ls.diffuse)[i] / (ls.pdf[i] * float(parts));
        const V v = clamped(c.depth + 2, V::load(paths_.throughput, s) * V::load(radiance, i) *
                                             V::load(e.weight[0], i) * V::load(factor, i) * Float<1>(scale));
        if (!(maxComponent(v).lane0() > 0)) continue;
        const uint32_t state = stepState(sv_->paths, paths_.state[s], event);
        arrivals_.from(i, V::load(o, i), V::load(ls.wi, i), tMax[i], 1, ls.spread ? ls.spread[i] : 0.f, ls.light[i]);
        arrivals_.add(v, state, ls.light[i]);
        if (sv_->wantsUnshadowed) open.add(v, s, state, ls.light[i]);
      }
      open.send(g_, sv_);
    }
    arrivals_.send();
    if (lessons) lessons->end();
  }
  // Light samples before their shadow rays.
  struct Unshadowed {
    float* value[3];
    uint32_t *slot, *state, *light, count = 0;
    Unshadowed(const Context& c, bool isWanted) {
      const uint32_t room = isWanted ? c.padded * c.slotCount + kPad : kPad;
      for (float*& x : value) x = c.alloc<float>(room);
      for (uint32_t** x : {&slot, &state, &light}) *x = c.alloc<uint32_t>(room);
    }
    void add(V v, uint32_t s, uint32_t at, uint32_t from) {
      v.store(value, count);
      slot[count] = s;
      state[count] = at;
      light[count++] = from;
    }
    void add(Mask<W> on, Vec3<W> v, Int<W> s, Int<W> at, Int<W> from) {
      const Packer<W> pack(on);
      v.pack(pack, value, count);
      pack.put(s, slot + count);
      pack.put(at, state + count);
      pack.put(from, light + count);
      count += uint32_t(pack.count);
    }
    void send(Group* g, const Services* sv) const {
      const Contributions out{count, slot, {value[0], value[1], value[2]}, state, light, LightKind::Unshadowed};
      if (count) sv->contribute(g, &out);
    }
  };

  // ---- merging
  void merge(const Context& c, const Near& neighbourhood) {
    const auto* pass = static_cast<const vcm::PassIndex*>(sv_->index(g_));
    const MergeIndex* index = pass ? pass->points : nullptr;
    if (!index) return;
    const bool isInSpace = c.traits & kTraitInSpace;
    const float spread = (isInSpace ? o_.mediaRadius : o_.radius) * sv_->pixelAngle + 0.01f;
    Merged<W> merged(g_, sv_, o_, c, *index, readsEvents_);
    MergeIndex::Query* queries = c.alloc<MergeIndex::Query>(c.count);
    uint32_t *point = c.alloc<uint32_t>(c.count), n = 0, last = c.count;
    for (uint32_t i = 0; i < c.count; ++i) {
      if (!(neighbourhood.count[i] > 0)) continue;
      queries[n] = {{c.P[0][i], c.P[1][i], c.P[2][i]}, neighbourhood.radius[i]};
      point[n++] = i;
    }
    findNear<W>(*index, n, queries, spread, [&](uint32_t query, uint32_t found, const uint32_t* entries) {
      const uint32_t i = point[query], s = c.path[i];
      if (i != last) {
        merged.evaluate();
        merged.begin(i, neighbourhood, sums_[s], V::load(paths_.throughput, s), paths_.state[s]);
        last = i;
      }
      for (uint32_t k = 0; k < found; k += MergeIndex::kTogether)
        merged.add(entries + k, std::min(found - k, MergeIndex::kTogether),
                   isInSpace ? c.place.instance[i] : Photon::kNoMedium);
    });
    merged.evaluate();
    merged.send();
  }

  // Whether states after the camera's first event still depend on what follows: expressions that read more of a path
  // than that. Where none does the events of light paths need not be looked up.
  static bool readsEvents(const PathStates& paths) {
    for (uint32_t first = 0; first < paths.eventCount; ++first) {
      const uint32_t state = stepState(paths, paths.start, first);
      for (uint32_t e = 0; e < paths.eventCount; ++e)
        if (stepState(paths, state, e) != state) return true;
    }
    return false;
  }

  Group* g_;
  const Services* sv_;
  const vcm::Options& o_;
  float lightPaths_;
  Subpaths<W> paths_;
  const guiding::State* learned_;
  bool
      connectsCamera_;  // not where unshadowed light is wanted: splats do not know what would have been without shadows
  PathDensities sums_;
  Arrivals<W> arrivals_;
  Neighbourhoods<W> near_;
  Beams<W, Shares> beams_;
  bool readsEvents_;  // see there
  PathConnections<W, Shares> connections_;
};

// An integrator that is Vcm and no more; its data are vcm::Options, or derived from them.
template <class D, class Shares = VcmShares>
struct RunsVcm {
  using Data = D;
  template <int W>
  static void integrate(const Data& data, uint32_t, Group& group, const Services& services) {
    Vcm<W, Shares>(&group, &services, data).run();
  }
  static void commit(const Data& data, uint32_t stage, const CommitServices& services) {
    vcm::commit(data, stage, services);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
