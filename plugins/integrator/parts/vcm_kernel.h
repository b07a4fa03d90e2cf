// Bidirectional path tracing with vertex connection and merging (Georgiev, Krivanek, Davidovic, Slusallek: "Light
// Transport Simulation with Vertex Connection and Merging", 2012; Hachisuka, Pantaleoni, Jensen, 2012). Light paths
// run first: their vertices are connected to the camera and stored. Camera paths then meet lights, sample them, are
// connected to the vertices of the light path of their own number, and merged with those of any light path near by.
// All ways to find a path share it by the balance heuristic (kinora/path_densities.h). Included per target, behind
// integrator_author.h.
#include "plugins/integrator/parts/vcm_merged.h"

#if defined(KINORA_VCM_KERNEL_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_VCM_KERNEL_H_TARGET
#undef KINORA_VCM_KERNEL_H_TARGET
#else
#define KINORA_VCM_KERNEL_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
class Vcm {
 public:
  Vcm(Group* group, const Services* services, const vcm::Options& options)
      : g_(group),
        sv_(services),
        o_(options),
        lightPaths_(float(services->resolution[0]) * float(services->resolution[1])),
        paths_(group, services, group->stage == StageKind::LightPaths ? kTraitLightPath : kTraitEyePath,
               options.roulette),
        sums_(group, services, {options.connects, options.connects ? lightPaths_ : 0}),
        arrivals_(group, services),
        shrunk_(std::pow(float(group->paths.sampleIndex[0]) + 1, 0.5f * (options.reduce - 1))),
        readsEvents_(readsEvents(services->paths)) {}

  void run() { g_->stage == StageKind::LightPaths ? lightStage() : cameraStage(); }

  // At the barrier behind light paths.
  static void commit(const vcm::Options& options, uint32_t stage, const CommitServices& services) {
    if (!options.merges || stage) return;
    const StoredRecords s = services.stored(&services, 0);
    const vcm::Stored* all = static_cast<const vcm::Stored*>(s.records);
    services.setIndex(&services, MergeIndex::build(services, s.count,
                                                   [all](uint64_t i) -> const Photon& { return all[i].photon; }));
  }

 private:
  using V = Vec3<1>;
  using Stored = vcm::Stored;
  using Photon = vcm::Photon;
  using MergeIndex = vcm::MergeIndex;
  static constexpr uint32_t kNone = 0xffffffffu;

  template <class T>
  T* make(uint32_t n) const {
    return static_cast<T*>(sv_->alloc(g_, (n + kPad) * sizeof(T)));
  }

  void lightStage() {
    paths_.startAtLights();
    const MemoryMark mark = sv_->markMemory(g_);
    for (uint32_t depth = 0; paths_.count && depth <= o_.bounces; ++depth) {
      Context* const* contexts;
      paths_.trace(depth);
      const uint32_t count = paths_.shade(depth, &contexts);
      for (uint32_t k = 0; k < count; ++k) {
        const Context& c = *contexts[k];
        depth ? sums_.arrive(c) : sums_.begin(g_, sv_, c, paths_.light);
        const Neighbourhood near = neighbourhoodOf(c);
        const bool isStored = depth < o_.bounces || o_.merges;
        if (o_.connects || isStored) {
          const PathVertex* vertices = paths_.vertices(c, depth);
          if (o_.connects) connectCamera(c, depth, vertices, near.merges);
          if (isStored) store(c, vertices, near.radius);
        }
        sums_.leave(c, paths_.scatter(c, depth), near.merges);
      }
      sv_->releaseMemory(g_, mark);
    }
  }

  void cameraStage() {
    paths_.startAtCamera();
    if (o_.connects) shadeLightPaths();
    const MemoryMark mark = sv_->markMemory(g_);
    for (uint32_t depth = 0; paths_.count; ++depth) {
      Context* const* contexts;
      paths_.trace(depth);
      meetLights(depth);
      if (depth > o_.bounces) return;
      const uint32_t count = paths_.shade(depth, &contexts);
      const float** merges = make<const float*>(count);
      for (uint32_t k = 0; k < count; ++k) {
        const Context& c = *contexts[k];
        arrive(c, depth);
        const Neighbourhood near = neighbourhoodOf(c);
        merges[k] = near.merges;
        paths_.contributeEmission(c, depth < o_.clampDepth ? 1e30f : o_.clampLuminance);
        if (o_.merges) merge(c, near);
      }
      sampleLights(count, contexts, merges, depth ? 1 : o_.lightSamples);
      if (o_.connects) connectPaths(count, contexts, merges, depth);
      for (uint32_t k = 0; k < count; ++k) {
        const Context& c = *contexts[k];
        sums_.leave(c, paths_.scatter(c, depth), merges[k]);
      }
      sv_->releaseMemory(g_, mark);
    }
  }

  // ---- radii of merging: functions of the place and the sample's index alone, so that all paths agree on them
  float radiusAt(const Context& c, uint32_t i) const {
    float d2 = 0;
    for (int k = 0; k < 3; ++k) {
      const float d = c.P[k][i] - sv_->cameraCenter[k];
      d2 += d * d;
    }
    const float pixel = sv_->pixelSize + std::sqrt(d2) * sv_->pixelAngle;
    return std::max(o_.radius * pixel * shrunk_, 1e-6f * sv_->worldRadius);
  }
  // How many of a sample's light paths one point there is merged with that they reach with a density of 1 per area,
  // as PathDensities wants it.
  float mergesWithin(float radius, float time) const {
    const float shareInTime = std::min(time + o_.timeRadius, 1.f) - std::max(time - o_.timeRadius, 0.f);
    return lightPaths_ * kPi * radius * radius * shareInTime;
  }
  struct Neighbourhood {
    float *radius, *merges;  // by point; null where nothing is merged
  };
  Neighbourhood neighbourhoodOf(const Context& c) const {
    if (!o_.merges) return {nullptr, nullptr};
    const Neighbourhood n{c.alloc<float>(c.padded), c.alloc<float>(c.padded)};
    for (uint32_t i = 0; i < c.count; ++i) {
      n.radius[i] = radiusAt(c, i);
      n.merges[i] = mergesWithin(n.radius[i], c.time[i]);
    }
    return n;
  }

  // ---- light paths
  void store(const Context& c, const PathVertex* vertices, const float* radius) {
    Stored* records = c.alloc<Stored>(c.count);
    for (uint32_t i = 0; i < c.count; ++i) {
      const PathVertex& v = vertices[i];
      const PathSums& x = sums_[c.path[i]];
      records[i] = {v,
                    x,
                    {{c.P[0][i], c.P[1][i], c.P[2][i]},
                     {c.wo[0][i], c.wo[1][i], c.wo[2][i]},
                     {v.throughput[0], v.throughput[1], v.throughput[2]},
                     x.edge * x.last,
                     x.before,
                     c.time[i],
                     radius ? radius[i] : 1.f,
                     v.light,
                     v.before | (v.factor[0] == 1 && v.factor[1] == 1 ? 0 : Photon::kHasFactors)}};
    }
    sv_->append(g_, 0, c.count, c.path, records);
  }

  void connectCamera(const Context& c, uint32_t depth, const PathVertex* vertices, const float* merges) {
    CameraConnection camera;
    sv_->connectCamera(g_, &c, &camera);
    const EvaluateArgs e = evaluateBxdf(c, camera.wi);
    // rays come from the lens, so that they see what camera rays see
    RayList& rays = *sv_->makeRays(g_, c.count);
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
      const float others = othersOfSplat(sums_[c.path[i]], distance, camera.pdf[i], lightPaths_,
                                         surfaceCosine(c, i, wi), e.pdfReverse[i], merges ? merges[i] : 0);
      share[n] = adjointFactor(c, i, wi).lane0() * camera.importance[i] / (distance * distance * (1 + others));
      fma(wi, Float<1>(distance), P).store(rays.rays.o, n);
      (-wi).store(rays.rays.d, n);
      rays.rays.tMax[n] = distance * 0.99999f - 2 * c.bias[i];
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
        state[m] = stepState(sv_->paths, sv_->paths.start, event, at);
        light[m++] = at.light;
      }
    }
    if (m) sv_->splat(g_, m, raster, value, state, light);
  }

  // ---- camera paths
  void arrive(const Context& c, uint32_t depth) {
    if (depth || !o_.connects) return sums_.arrive(c);
    CameraConnection camera;
    sv_->connectCamera(g_, &c, &camera);
    sums_.beginAtCamera(c, camera.pdf);
  }

  // length: edges of the path, one more than its bounces.
  V clamped(uint32_t length, V v) const {
    if (length <= o_.clampDepth) return v;
    return v * factorToLuminance(v, Float<1>(o_.clampLuminance));
  }

  void meetLights(uint32_t depth) {
    LightHits h;
    sv_->lightHits(g_, &g_->paths, depth ? RayKind::Indirect : RayKind::Camera, paths_.count, paths_.live, &h);
    if (!h.count) return;
    float* weight = make<float>(h.count);
    std::fill_n(weight, h.count, 1.f);
    if (depth) {
      const LightDensities light(g_, sv_, h);
      for (uint32_t i = 0; i < h.count; ++i) {
        const uint32_t s = h.slot[i];
        const bool isSampled = depth > 1 || o_.lightSamples;
        weight[i] = 1 / (1 + othersOfHit(sums_[s], isSampled ? h.pdf[i] : 0, light, i));
      }
    }
    if (depth >= o_.clampDepth)
      for (uint32_t i = 0; i < h.count; ++i) {
        const uint32_t s = h.slot[i];
        const float w = weight[i] * (depth == 0                            ? 1.f
                                     : g_->paths.origin[s] & kFromSpecular ? h.specular[i]
                                                                           : h.diffuse[i]);
        const V v = V::load(paths_.throughput, s) * V::load(h.radiance, i) * Float<1>(w);
        const float before = maxComponent(v).lane0(), after = maxComponent(clamped(depth + 1, v)).lane0();
        if (before > 0) weight[i] *= after / before;
      }
    paths_.contribute(h, depth, weight);
    if (!depth) coverByLights(h);
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

  void sampleLights(uint32_t count, Context* const* contexts, const float* const* merges, uint32_t parts) {
    if (!sv_->lightCount || !parts) return;
    for (uint32_t k = 0; k < count; ++k) {
      arrivals_.of(*contexts[k]);
      for (uint32_t part = 0; part < parts; ++part) sampleLights(*contexts[k], merges[k], part, parts);
    }
    arrivals_.send();
  }
  void sampleLights(const Context& c, const float* merges, uint32_t part, uint32_t parts) {
    LightSamples ls;
    sv_->lightSamples(g_, &c, part, parts, &ls);
    const LightDensities light(g_, sv_, c, ls.wi, ls.t, ls.light);
    const EvaluateArgs e = evaluateBxdf(c, ls.wi);
    for (uint32_t i = 0; i < c.count; ++i) {
      if (!(ls.pdf[i] > 0) || !(e.pdf[i] > 0)) continue;
      const uint32_t s = c.path[i];
      const V wi = V::load(ls.wi, i);
      const float others =
          othersOfSample(sums_[s], c, i, wi, e.pdf[i], e.pdfReverse[i], light, merges ? merges[i] : 0);
      const V arriving =
          V::load(paths_.throughput, s) * V::load(ls.radiance, i) / Float<1>(ls.pdf[i] * (1 + others) * float(parts));
      arrivals_.from(i, wi, ls.distance[i], c.slotCount);
      for (uint32_t l = 0; l < c.slotCount; ++l) {
        const float factor = c.eventOfSlot[l] & 1 ? ls.specular[i] : ls.diffuse[i];
        arrivals_.add(clamped(c.depth + 2, arriving * V::load(e.weight[l], i) * Float<1>(factor)),
                      stepState(sv_->paths, paths_.state[s], c.eventOfSlot[l]), ls.light[i]);
      }
    }
  }

  // ---- connections: contexts of the vertices of the light paths with the numbers of the group's camera paths, those
  // of one depth together
  void shadeLightPaths() {
    const uint32_t n = g_->count;
    uint64_t* first = make<uint64_t>(n);
    uint32_t *found = make<uint32_t>(n), most = 0;
    sv_->findStored(g_, 0, n, g_->number, g_->paths.sampleIndex, first, found);
    const Stored* all = static_cast<const Stored*>(sv_->stored(g_, 0).records);
    for (uint32_t s = 0; s < n; ++s) most = std::max(most, found[s]);
    steps_ = std::min(most, o_.bounces);
    ends_ = make<Ends>(steps_);
    VertexRecord* records = make<VertexRecord>(n * steps_);
    uint32_t *slots = make<uint32_t>(n * steps_), count = 0;
    for (uint32_t v = 0; v < steps_; ++v) {
      Ends& e = ends_[v];
      e.of = make<End>(n);
      e.count = 0;
      for (uint32_t s = 0; s < n; ++s) {
        e.of[s].context = kNone;
        if (v >= found[s]) continue;
        const Stored& stored = all[first[s] + v];
        const PathVertex& at = stored.at;
        const Photon& p = stored.photon;
        e.of[s] = {stored.sums,
                   {at.throughput[0], at.throughput[1], at.throughput[2]},
                   {at.factor[0], at.factor[1]},
                   o_.merges ? mergesWithin(p.radius, p.time) : 0,
                   at.light,
                   kNone,
                   0,
                   &at};
        records[count] = at.vertex;
        slots[count++] = s;
      }
    }
    // contexts hold vertices of one depth
    Context* const* contexts = nullptr;
    const uint32_t contextCount = count ? sv_->shadeVertices(g_, count, records, &contexts) : 0;
    for (uint32_t v = 0; v < steps_; ++v) ends_[v].contexts = make<Context*>(contextCount);
    for (uint32_t k = 0; k < contextCount; ++k) {
      Ends& e = ends_[contexts[k]->depth];
      for (uint32_t j = 0; j < contexts[k]->count; ++j) {
        End& end = e.of[slots[contexts[k]->path[j]]];
        end.context = e.count;
        end.point = j;
      }
      e.contexts[e.count++] = contexts[k];
    }
  }

  void connectPaths(uint32_t count, Context* const* contexts, const float* const* merges, uint32_t depth) {
    if (!steps_ || depth >= o_.bounces) return;
    for (uint32_t v = 0; v < steps_ && v + depth < o_.bounces; ++v) {
      const Ends& ends = ends_[v];
      if (!ends.count) continue;
      const MemoryMark mark = sv_->markMemory(g_);
      // directions from both sides; along the normal where there is no connection
      EvaluateArgs* far = make<EvaluateArgs>(ends.count);
      float*** back = make<float**>(ends.count);
      for (uint32_t k = 0; k < ends.count; ++k) {
        const Context& e = *ends.contexts[k];
        back[k] = make<float*>(3);
        for (int x = 0; x < 3; ++x) {
          back[k][x] = make<float>(e.padded);
          std::copy_n(e.N[x], e.padded, back[k][x]);
        }
      }
      float*** d = make<float**>(count);
      float** distance = make<float*>(count);
      for (uint32_t k = 0; k < count; ++k) {
        const Context& c = *contexts[k];
        d[k] = make<float*>(3);
        distance[k] = make<float>(c.padded);
        for (int x = 0; x < 3; ++x) {
          d[k][x] = make<float>(c.padded);
          std::copy_n(c.N[x], c.padded, d[k][x]);
        }
        for (uint32_t i = 0; i < c.count; ++i) {
          const End& end = ends.of[c.path[i]];
          const uint32_t which = end.context, j = end.point;
          distance[k][i] = 0;
          if (which == kNone) continue;
          const V between = V::load(ends.contexts[which]->P, j) - V::load(c.P, i);
          const Float<1> length = max(kinora::HWY_NAMESPACE::length(between), Float<1>(1e-18f));
          distance[k][i] = length.lane0();
          (between / length).store(d[k], i);
          (-between / length).store(back[which], j);
        }
      }
      for (uint32_t k = 0; k < ends.count; ++k) {
        for (int x = 0; x < 3; ++x) {
          const Context& e = *ends.contexts[k];
          std::fill(back[k][x] + e.count, back[k][x] + e.padded, back[k][x][e.count - 1]);
        }
        far[k] = evaluateBxdf(*ends.contexts[k], back[k]);
      }
      for (uint32_t k = 0; k < count; ++k)
        connectContext(*contexts[k], merges[k], ends, far, d[k], distance[k], depth + v + 3);
      arrivals_.send();
      sv_->releaseMemory(g_, mark);
    }
  }

  struct End {  // what connections ask of a stored vertex, side by side
    PathSums sums;
    float throughput[3], factor[2], merges;
    uint32_t light;
    uint32_t context, point;  // context kNone: the light path is shorter
    const PathVertex* at;
  };
  struct Ends {  // one vertex of each light path
    uint32_t count;
    Context** contexts;
    End* of;  // by slot of the camera path
  };

  void connectContext(const Context& c, const float* merges, const Ends& ends, const EvaluateArgs* far,
                      float* const d[3], const float* distance, uint32_t length) {
    const EvaluateArgs e = evaluateBxdf(c, d);
    arrivals_.of(c);
    for (uint32_t i = 0; i < c.count; ++i) {
      const uint32_t s = c.path[i];
      if (!(distance[i] > 0) || !(e.pdf[i] > 0)) continue;
      const End& at = ends.of[s];
      const Context& end = *ends.contexts[at.context];
      const EvaluateArgs& f = far[at.context];
      const uint32_t j = at.point;
      if (!(f.pdf[j] > 0)) continue;
      const V w = V::load(d, i);
      const float others = othersOfConnection(
          distance[i], {sums_[s], f.pdf[j], surfaceCosine(c, i, w), e.pdfReverse[i], merges ? merges[i] : 0},
          {at.sums, e.pdf[i], surfaceCosine(end, j, w), f.pdfReverse[j], at.merges});
      const Float<1> share = adjointFactor(end, j, -w) * Float<1>(1 / (distance[i] * distance[i] * (1 + others)));
      const V arriving =
          V::load(paths_.throughput, s) * V(at.throughput[0], at.throughput[1], at.throughput[2]) * share;
      arrivals_.from(i, w, distance[i], c.slotCount * end.slotCount);
      for (uint32_t l = 0; l < c.slotCount; ++l)
        for (uint32_t m = 0; m < end.slotCount; ++m) {
          const uint32_t event = end.eventOfSlot[m];
          const V value =
              arriving * V::load(e.weight[l], i) * V::load(f.weight[m], j) * Float<1>(at.factor[event & 1]);
          const uint32_t state = stepState(sv_->paths, paths_.state[s], c.eventOfSlot[l]);
          arrivals_.add(clamped(length, value), readsEvents_ ? stepState(sv_->paths, state, event, *at.at) : state,
                        at.light);
        }
    }
  }

  // ---- merging
  void merge(const Context& c, const Neighbourhood& neighbourhood) {
    const MergeIndex* index = static_cast<const MergeIndex*>(sv_->index(g_));
    if (!index) return;
    const float spread = o_.radius * sv_->pixelAngle + 0.01f;
    Merged<W> merged(g_, sv_, o_, c, *index, readsEvents_);
    for (uint32_t i = 0; i < c.count; ++i) {
      const float P[3] = {c.P[0][i], c.P[1][i], c.P[2][i]}, radius = neighbourhood.radius[i], time = c.time[i];
      const uint32_t s = c.path[i];
      merged.begin(i, neighbourhood.merges[i], sums_[s], V::load(paths_.throughput, s), paths_.state[s]);
      const Vec3<W> at{Float<W>(P[0]), Float<W>(P[1]), Float<W>(P[2])};
      index->near(P, radius, spread, [&](uint32_t cell, uint32_t begin, uint32_t end) {
        for (uint32_t k = begin; k < end; k += W) {
          const Vec3<W> between = Vec3<W>::load(index->P, k) - at;
          const Mask<W> in = Mask<W>::firstN(int(std::min<uint32_t>(end - k, W)));
          const Mask<W> isNear = in & (dot(between, between) <= Float<W>(radius * radius)) &
                                 (Int<W>::load(index->cells + k) == Int<W>(cell));
          for (uint32_t bits = isNear.bits(); bits; bits &= bits - 1) {
            const uint32_t entry = k + uint32_t(__builtin_ctz(bits));
            const Photon& photon = index->photons[entry];
            if (std::fabs(photon.time - time) <= o_.timeRadius && photon.verticesBefore() + c.depth <= o_.bounces)
              merged.add(entry);
          }
        }
      });
      merged.evaluate();
    }
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
  PathDensities sums_;
  Arrivals arrivals_;
  Ends* ends_ = nullptr;
  uint32_t steps_ = 0;
  float shrunk_;      // radii of this sample, as a share of the first one's
  bool readsEvents_;  // see there
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
