// Beams of light paths merged with camera paths in media (J. Krivanek, I. Georgiev, T. Hachisuka, P. Vevoda, M. Sik, D.
// Nowrouzezahrai, W. Jarosz: "Unifying Points, Beams, and Paths in Volumetric Light Transport Simulation", 2014): points
// of light paths near a camera ray (2D), beams near a camera path's vertex (2D), beams that cross a camera ray (1D). All
// beams are short: they end where tracking ended the ray, and have the factor that it had on the way there, so that
// transmittance needs no closed form, and all techniques have that of both edges in their densities. Included per
// target by vcm_kernel.h.
#include <kinora/clamp_luminance.h>
#include <kinora/guiding.h>
#include <kinora/subpaths.h>

#include "plugins/integrator/parts/vcm_neighbourhoods.h"

#if defined(KINORA_VCM_BEAMS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_VCM_BEAMS_H_TARGET
#undef KINORA_VCM_BEAMS_H_TARGET
#else
#define KINORA_VCM_BEAMS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// What the two techniques of media count of their own share. A parameter of the kernels, so that a test can leave one
// out and see that it is missed.
struct VcmShares {
  // Rays that cross a beam, by the sine of the angle between them.
  static float ofCrossing(float sine) { return sine; }
  // A connection, by what media let through.
  template <int W>
  static KN_INLINE Float<W> ofConnection(Float<W> through) {
    return through;
  }
};

template <int W, class Shares>
class Beams {
 public:
  // lightPaths: PathTechniques::lightPaths. learned: what points choose lights by, where Group::lightWeights is set.
  Beams(Group* group, const Services* services, const vcm::Options& options, const Neighbourhoods<W>& near,
        const Subpaths<W>& paths, const PathDensities& sums, float lightPaths, const guiding::State* learned)
      : g_(group),
        sv_(services),
        o_(options),
        near_(near),
        paths_(paths),
        sums_(sums),
        lightPaths_(lightPaths),
        learned_(learned) {
    if (!o_.beams || !sv_->mediaScatter) return;
    g_->paths.wantsWays = 1;
    if (g_->stage == StageKind::LightPaths) return;
    const auto* index = static_cast<const vcm::PassIndex*>(sv_->index(g_));
    index_ = index ? index->beams : nullptr;
    if (!index_ || !index_->pieceCount) {
      index_ = nullptr;
      return;
    }
    reach_ = make<float>(g_->padded);
    cameraPdf_ = make<float>(g_->padded);
    cameraBegin_ = make<float>(g_->padded);
    std::fill_n(reach_, g_->padded, HUGE_VALF);
    crossing_ = make<Crossing>(2 * kTogether);
    for (float*& x : value_) x = make<float>(kRoom);
    for (uint32_t** x : {&slot_, &state_, &light_}) *x = make<uint32_t>(kRoom);
  }

  // ---- light paths
  // The ways of the rays just traced.
  void keepWays(uint32_t depth) const {
    if (!g_->paths.wantsWays) return;
    const MediumWays& ways = g_->paths.ways;
    const Rays& r = g_->paths.rays;
    for (uint32_t i = 0; i < paths_.count; ++i) {
      const uint32_t s = paths_.live[i];
      if (!ways.count[s] || !near_.leavesBeams(s)) continue;
      for (uint32_t k = ways.first[s]; k < ways.first[s] + ways.count[s]; ++k) {
        Beam b = beamOf(s, depth, r.time[s]);
        for (int c = 0; c < 3; ++c) {
          b.o[c] = r.o[c][s];
          b.d[c] = r.d[c][s];
          b.throughput[c] = paths_.throughput[c][s] * ways.factor[c][k];
          b.absorption[c] = ways.absorption[c] ? ways.absorption[c][s] : 0.f;
        }
        b.from = ways.from[k];
        b.to = ways.to[k];
        b.last = sums_[s].last;
        b.before = sums_[s].before;
        sv_->append(g_, 1, 1, &s, &b);
      }
    }
  }
  // Points of a context in a medium.
  void keepPoints(const Context& c) const {
    if (!g_->paths.wantsWays || !(c.traits & kTraitInSpace)) return;
    for (uint32_t i = 0; i < c.count; ++i) {
      const uint32_t s = c.path[i];
      if (!near_.leavesBeams(s)) continue;
      Beam b = beamOf(s, c.depth, c.time[i]);
      for (int k = 0; k < 3; ++k) {
        b.d[k] = -c.wo[k][i];
        b.o[k] = c.P[k][i];
        b.throughput[k] = paths_.throughput[k][s];
        b.absorption[k] = 0;
      }
      b.from = b.to = 0;
      b.last = sums_[s].edge * sums_[s].last;
      b.before = sums_[s].before;
      b.medium = c.place.instance[i];
      sv_->append(g_, 1, 1, &s, &b);
    }
  }

  // ---- camera paths
  // Lights that the camera sees end its rays.
  void endAt(const LightHits& h) {
    for (uint32_t i = 0; index_ && i < h.count; ++i)
      if (h.blocks[i]) reach_[h.slot[i]] = std::min(reach_[h.slot[i]], h.t[i]);
  }
  // What crosses the rays just traced, before their media weigh on throughputs.
  void alongRays(uint32_t depth) {
    if (!index_ || !paths_.count) return;
    const MemoryMark mark = sv_->markMemory(g_);
    if (!depth) findCameraPdf();
    const MediumWays& ways = g_->paths.ways;
    const Rays& r = g_->paths.rays;
    for (uint32_t i = 0; i < paths_.count; ++i) {
      const uint32_t s = paths_.live[i];
      // sums of floats: what is sent together of one ray must not depend on those before it
      if (crossingCount_ > kTogether) sendCrossings(depth);
      uint32_t own = 0;
      for (uint32_t k = ways.first[s]; k < ways.first[s] + ways.count[s]; ++k) {
        const float o[3] = {r.o[0][s], r.o[1][s], r.o[2][s]}, d[3] = {r.d[0][s], r.d[1][s], r.d[2][s]};
        const float from = ways.from[k], to = depth ? ways.to[k] : std::min(ways.to[k], reach_[s]);
        if (!(to > from)) continue;
        index_->near(o, d, from, to, near_.widest(o, d, from, to), [&](const BeamIndex::Piece& piece) {
          const Beam& b = index_->beams[piece.beam];
          Crossing x{s, k, &b, 0, 0, 0};
          if (b.verticesBefore + depth > o_.bounces || std::fabs(b.time - r.time[s]) > o_.timeRadius) return;
          if (!meet(o, d, piece, b, x) || x.t < from || !(x.t < to)) return;
          crossing_[crossingCount_++] = x;
          if (++own % kTogether == 0) sendCrossings(depth);
        });
      }
    }
    sendCrossings(depth);
    send();
    sv_->releaseMemory(g_, mark);
  }
  // Beams near the points of a context in a medium, whose sums are those of the points.
  void atPoints(const Context& c, const typename Neighbourhoods<W>::Of& near) {
    if (!index_ || !(c.traits & kTraitInSpace)) return;
    const bool seesLightsAlone = c.traits & kTraitScattersOnce;
    Crossing* found = c.alloc<Crossing>(kTogether);
    for (uint32_t i = 0; i < c.count; ++i) {
      const float P[3] = {c.P[0][i], c.P[1][i], c.P[2][i]}, along[3] = {0, 0, 1};
      const float mean = (near.extinction[0][i] + near.extinction[1][i] + near.extinction[2][i]) * (1.f / 3);
      const InMedium m = near_.inMedium(P, c.time[i], mean);
      if (!(m.cylinder > 0)) continue;
      uint32_t n = 0;
      const auto sendFound = [&] {
        if (n) atPoint(c, i, m, n, found);
        n = 0;
      };
      index_->near(P, along, 0, 0, m.disk, [&](const BeamIndex::Piece& piece) {
        const Beam& b = index_->beams[piece.beam];
        if (b.isPoint() || b.verticesBefore + c.depth > o_.bounces || (seesLightsAlone && b.verticesBefore) ||
            std::fabs(b.time - c.time[i]) > o_.timeRadius)
          return;
        float s = 0, d2 = 0;
        for (int k = 0; k < 3; ++k) s += (P[k] - b.o[k]) * b.d[k];
        if (s < piece.from || !(s < piece.to)) return;
        for (int k = 0; k < 3; ++k) {
          const float x = P[k] - b.o[k] - s * b.d[k];
          d2 += x * x;
        }
        if (d2 > m.disk * m.disk) return;
        found[n++] = {c.path[i], 0, &b, 0, s, 0};
        if (n == kTogether) sendFound();
      });
      sendFound();
    }
    send();
  }

 private:
  using V = Vec3<1>;
  using Beam = vcm::Beam;
  using BeamIndex = vcm::BeamIndex;
  using InMedium = typename Neighbourhoods<W>::InMedium;
  static constexpr uint32_t kTogether = 256, kRoom = 4096;
  // A camera ray meets a beam.
  struct Crossing {
    uint32_t slot, stretch;
    const Beam* beam;
    float t, s;      // distances along the ray and the beam
    float distance;  // between the two
  };

  template <class T>
  T* make(uint32_t n) const {
    return static_cast<T*>(sv_->alloc(g_, (n + kPad) * sizeof(T)));
  }
  Beam beamOf(uint32_t slot, uint32_t depth, float time) const {
    Beam b{};
    b.time = time;
    b.light = paths_.light[slot];
    b.verticesBefore = depth;
    b.medium = Beam::kNoMedium;
    for (int k = 0; k < 2; ++k) b.factor[k] = depth ? 1.f : paths_.factorOf(slot, k);
    b.tail = paths_.state[slot];
    return b;
  }

  // Where a ray and a piece of a beam are nearest: false: beyond its ends.
  static bool meet(const float o[3], const float d[3], const BeamIndex::Piece& piece, const Beam& b, Crossing& x) {
    double w[3], dw = 0, bw = 0, cosine = 0;
    for (int k = 0; k < 3; ++k) {
      w[k] = double(b.o[k]) - double(o[k]);
      dw += double(d[k]) * w[k];
      bw += double(b.d[k]) * w[k];
      cosine += double(d[k]) * double(b.d[k]);
    }
    double t = dw, s = 0;
    if (!b.isPoint()) {
      const double sine2 = 1 - cosine * cosine;
      if (!(sine2 > 1e-8)) return false;
      t = (dw - cosine * bw) / sine2;
      s = (cosine * dw - bw) / sine2;
      if (s < double(piece.from) || !(s < double(piece.to))) return false;
    }
    double d2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double y = w[k] + s * double(b.d[k]) - t * double(d[k]);
      d2 += y * y;
    }
    x.t = float(t);
    x.s = float(s);
    x.distance = float(std::sqrt(d2));
    return true;
  }

  // With which density the camera makes its rays: the same all along them.
  void findCameraPdf() {
    float* t = make<float>(g_->padded);
    for (uint32_t i = 0; i < paths_.count; ++i) t[paths_.live[i]] = 1;
    const Context& c =
        *sv_->pointsInSpace(g_, &g_->paths, kTraitEyePath | kTraitPrimaryHit, 0, paths_.count, paths_.live, t);
    CameraConnection camera;
    sv_->connectCamera(g_, &c, &camera);
    for (uint32_t i = 0; i < c.count; ++i) {
      cameraPdf_[c.path[i]] = camera.pdf[i];
      cameraBegin_[c.path[i]] = camera.begin[i];
    }
  }

  void sendCrossings(uint32_t depth) {
    const uint32_t n = crossingCount_;
    crossingCount_ = 0;
    if (!n) return;
    const MemoryMark mark = sv_->markMemory(g_);
    uint32_t* entries = make<uint32_t>(n);
    float* t = make<float>(n);
    for (uint32_t i = 0; i < n; ++i) {
      entries[i] = crossing_[i].slot;
      t[i] = crossing_[i].t;
    }
    MediaAt at;
    sv_->mediaAt(g_, &g_->paths, depth, n, entries, t, &at);
    if (at.count) {
      Context* const* contexts;
      const uint32_t count = sv_->shade(g_, at.list, kTraitEyePath, depth, at.count, at.entries, &contexts);
      for (uint32_t k = 0; k < count; ++k) atCrossings(*contexts[k], at, depth);
    }
    sv_->releaseMemory(g_, mark);
  }

  // The sums of a beam's path at distances s along it, where points of a context are (point null: their own), whose
  // directions to the light are wi.
  struct LightSide {
    const float* through;
    const LightDensities* light;
    bool connects;
    float last(const Beam& b, float s, uint32_t i) const {
      if (b.isPoint()) return b.last;
      if (b.verticesBefore) return connects ? b.last * s * s / through[i] : 0.f;
      return light->direct(i) / (light->emission(i) * through[i]);
    }
    float before(const Beam& b, uint32_t i, bool isMet) const {
      if (b.isPoint() || b.verticesBefore) return b.before;
      return !isMet || light->template isDelta<1>(i).any() ? 0.f : 1 / (light->emission(i) * through[i]);
    }
  };

  // own: what this technique counts, of all; see Neighbourhoods::Of::merges.
  float share(const PathSums& camera, float last, float before, float pdf, float reverse, float own,
              float all) const {
    const float others = camera.edge * camera.last + camera.before * reverse + last + before * pdf + all;
    return pdf > 0 && others > 0 ? own / others : 0.f;
  }

  // Of points of media where beams cross rays, or points lie near them.
  void atCrossings(const Context& c, const MediaAt& at, uint32_t depth) {
    float *wi[3], *s = c.alloc<float>(c.padded + kPad);
    for (float*& x : wi) x = c.alloc<float>(c.padded + kPad);
    uint32_t* first = c.alloc<uint32_t>(c.padded + kPad);  // lights of beams that begin at them
    for (uint32_t i = 0; i < c.padded; ++i) {
      const Crossing& x = crossing_[at.point[c.path[i]]];
      for (int k = 0; k < 3; ++k) wi[k][i] = -x.beam->d[k];
      s[i] = x.s;
      first[i] = x.beam->isPoint() || x.beam->verticesBefore ? kNoLight : x.beam->light;
    }
    const EvaluateArgs e = evaluateBxdf(c, wi);
    if (g_->lightWeights) weighLights<W>(g_, sv_, learned_, c);
    const LightDensities light(g_, sv_, c, wi, s, first);
    const LightSide side{transmittanceOfEdges(g_, sv_, c, wi, s), &light, o_.connects};
    const float* through = transmittanceOfEdges(g_, sv_, c, c.wo, c.distance);
    const bool seesLightsAlone = c.traits & kTraitScattersOnce;
    const MediumWays& ways = g_->paths.ways;
    for (uint32_t i = 0; i < c.count; ++i) {
      const uint32_t entry = c.path[i];
      const Crossing& x = crossing_[at.point[entry]];
      const Beam& b = *x.beam;
      if ((seesLightsAlone && b.verticesBefore) || (b.isPoint() && b.medium != c.place.instance[i])) continue;
      if (first[i] != kNoLight && !(light.emission(i) > 0)) continue;  // the medium is not linked to it
      const V extinction = V::load(at.extinction, entry);
      const float P[3] = {c.P[0][i], c.P[1][i], c.P[2][i]};
      const InMedium m =
          near_.inMedium(P, c.time[i], (extinction.x + extinction.y + extinction.z).lane0() * (1.f / 3));
      if (!(m.merges > 0) || x.distance > (b.isPoint() ? m.disk : m.gap)) continue;
      const float sine = Neighbourhoods<W>::sineOf(V::load(c.wo, i), V::load(wi, i)).lane0();
      const float own = b.isPoint() ? m.cylinder : m.crossings * Shares::ofCrossing(sine),
                  all = m.merges + m.crossings * sine;
      if (!(own > 0)) continue;
      const PathSums camera = cameraSums(x.slot, depth, x.t, through[i]);
      const float last = o_.samplesLight(depth + b.verticesBefore) ? side.last(b, x.s, i) : 0.f;
      const float w = share(camera, last, side.before(b, i, !seesLightsAlone), e.pdf[i], e.pdfReverse[i], own, all) /
                      (b.isPoint() ? m.cylinder : m.wide * sine);
      V v = V::load(paths_.throughput, x.slot) * V::load(ways.factor, x.stretch) * passed(b, x.s) * Float<1>(w);
      if (ways.absorption[0])
        v = v * V(absorbed(ways.absorption[0][x.slot], x.t), absorbed(ways.absorption[1][x.slot], x.t),
                  absorbed(ways.absorption[2][x.slot], x.t));
      if (!b.isPoint()) v = v * extinction;
      for (uint32_t l = 0; l < c.slotCount; ++l) put(v * V::load(e.weight[l], i), x.slot, depth, c.eventOfSlot[l], b);
    }
  }
  PathSums cameraSums(uint32_t slot, uint32_t depth, float t, float through) const {
    if (!depth) {
      const float distance = t + cameraBegin_[slot];
      return {cameraPdf_[slot] > 0 ? lightPaths_ * distance * distance / (cameraPdf_[slot] * through) : 0.f, 0, 1};
    }
    const PathSums& x = sums_[slot];
    return {x.last * t * t / through, x.before, o_.connects ? 1.f : 0.f};
  }

  // Beams near a point of a context.
  void atPoint(const Context& c, uint32_t i, const InMedium& m, uint32_t n, const Crossing* found) {
    const MemoryMark mark = sv_->markMemory(g_);
    const uint32_t room = padded(n);
    float *wi[3], *s = make<float>(room), *P[3], *time = make<float>(room), *through = make<float>(room);
    uint32_t *first = make<uint32_t>(room), *point = make<uint32_t>(room);
    for (float*& x : wi) x = make<float>(room);
    for (int k = 0; k < 3; ++k) {
      P[k] = make<float>(room);
      std::fill_n(P[k], room, c.P[k][i]);
    }
    for (uint32_t j = 0; j < room; ++j) {
      const Crossing& x = found[std::min(j, n - 1)];
      for (int k = 0; k < 3; ++k) wi[k][j] = -x.beam->d[k];
      s[j] = x.s;
      time[j] = c.time[i];
      first[j] = x.beam->verticesBefore ? kNoLight : x.beam->light;
      point[j] = i;
    }
    EvaluateArgs e{{wi[0], wi[1], wi[2]}, {}, make<float>(room), make<float>(room)};
    for (uint32_t l = 0; l < c.slotCount; ++l)
      for (float*& w : e.weight[l]) w = make<float>(room);
    c.bxdf->evaluateAt(&c, c.closure, i, n, &e);
    const LightDensities light(g_, sv_, c, n, point, wi, s, first);
    sv_->meanTransmittance(g_, n, P, wi, s, time, through);
    const LightSide side{through, &light, o_.connects};
    const uint32_t slot = c.path[i];
    const bool isMet = !(c.traits & kTraitScattersOnce);
    for (uint32_t j = 0; j < n; ++j) {
      const Beam& b = *found[j].beam;
      if (first[j] != kNoLight && !(light.emission(j) > 0)) continue;  // the medium is not linked to it
      const float sine = Neighbourhoods<W>::sineOf(V::load(c.wo, i), V::load(wi, j)).lane0();
      const float last = o_.samplesLight(c.depth + b.verticesBefore) ? side.last(b, s[j], j) : 0.f;
      const float w = share(sums_[slot], last, side.before(b, j, isMet), e.pdf[j], e.pdfReverse[j], m.cylinder,
                            m.merges + m.crossings * sine) /
                      m.cylinder;
      const V v = V::load(paths_.throughput, slot) * passed(b, s[j]) * Float<1>(w);
      for (uint32_t l = 0; l < c.slotCount; ++l) put(v * V::load(e.weight[l], j), slot, c.depth, c.eventOfSlot[l], b);
    }
    sv_->releaseMemory(g_, mark);
  }

  static Float<1> absorbed(float absorption, float distance) {
    return absorption > 0 ? exp(Float<1>(-absorption * distance)) : Float<1>(1.f);
  }
  static V passed(const Beam& b, float s) {
    return V(b.throughput[0], b.throughput[1], b.throughput[2]) *
           V(absorbed(b.absorption[0], s), absorbed(b.absorption[1], s), absorbed(b.absorption[2], s));
  }
  void put(V v, uint32_t slot, uint32_t depth, uint32_t event, const Beam& b) {
    v = v * Float<1>(b.factorOf(event));
    if (!(maxComponent(v).lane0() > 0)) return;
    if (const float most = o_.mostAt(depth + b.verticesBefore + 1); most < 1e30f)
      v = v * factorToLuminance(v, Float<1>(most));
    if (count_ == kRoom) send();
    v.store(value_, count_);
    slot_[count_] = slot;
    state_[count_] = stepState(sv_->paths, paths_.state[slot], event, b.tail);
    light_[count_++] = b.light;
  }
  void send() {
    if (!count_) return;
    const Contributions out{count_, slot_, {value_[0], value_[1], value_[2]}, state_, light_, LightKind::Shadowed};
    sv_->contribute(g_, &out);
    count_ = 0;
  }

  Group* g_;
  const Services* sv_;
  const vcm::Options& o_;
  const Neighbourhoods<W>& near_;
  const Subpaths<W>& paths_;
  const PathDensities& sums_;
  float lightPaths_;
  const guiding::State* learned_;
  const BeamIndex* index_ = nullptr;  // null: there are no beams
  // By slot: how far camera rays go before lights that they see, with which density the camera makes them, and how far
  // from the lens they begin (CameraConnection).
  float *reach_ = nullptr, *cameraPdf_ = nullptr, *cameraBegin_ = nullptr;
  Crossing* crossing_ = nullptr;
  uint32_t crossingCount_ = 0;
  float* value_[3] = {};
  uint32_t *slot_ = nullptr, *state_ = nullptr, *light_ = nullptr, count_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
