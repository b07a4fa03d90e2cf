// Connections of camera paths' vertices with the vertices of the light path of their own number, at most vcm::kConnected
// of them. Included per target by vcm_kernel.h.
#include <kinora/clamp_luminance.h>
#include <kinora/path_densities.h>
#include <kinora/subpaths.h>

#include "plugins/integrator/parts/vcm_neighbourhoods.h"

#if defined(KINORA_VCM_CONNECTIONS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_VCM_CONNECTIONS_H_TARGET
#undef KINORA_VCM_CONNECTIONS_H_TARGET
#else
#define KINORA_VCM_CONNECTIONS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W, class Shares>
class PathConnections {
 public:
  using Near = typename Neighbourhoods<W>::Of;
  // readsEvents: whether states after the camera's first event still depend on what follows.
  PathConnections(Group* group, const Services* services, const vcm::Options& options, const Subpaths<W>& paths,
                  const PathDensities& sums, Arrivals<W>& arrivals, bool readsEvents)
      : g_(group),
        sv_(services),
        o_(options),
        paths_(paths),
        sums_(sums),
        arrivals_(arrivals),
        readsEvents_(readsEvents) {}

  // The ends of all of the group's paths, before their first vertices.
  void findEnds() {
    const uint32_t n = g_->count, room = padded(n) + kPad, all = kConnected * room;
    vcm::Ends& e = ends_;
    e.makeRoom(room, [this](auto*& x, uint32_t many) {
      x = make<std::remove_pointer_t<std::remove_reference_t<decltype(x)>>>(many);
    });

    uint64_t* first = make<uint64_t>(n);
    uint32_t* found = make<uint32_t>(n);
    sv_->findStored(g_, 0, n, g_->number, g_->paths.sampleIndex, first, found);
    const Stored* stored = static_cast<const Stored*>(sv_->stored(g_, 0).records);
    VertexRecord* records = make<VertexRecord>(all);
    uint32_t *endOf = make<uint32_t>(all), count = 0;
    for (uint32_t s = 0; s < n; ++s) {
      uint32_t to = s;
      for (uint32_t v = 0; v < found[s]; ++v) {
        const Stored& x = stored[first[s] + v];
        if (!(x.probability > 0)) continue;
        for (int c = 0; c < 3; ++c) {
          e.P[c][to] = x.photon.P[c];
          e.throughput[c][to] = x.at.throughput[c] / x.probability;
        }
        for (int c = 0; c < 2; ++c) e.factor[c][to] = x.at.factor[c];
        e.before[to] = x.at.before;
        e.light[to] = x.at.light;
        e.last[to] = x.sums.last;
        e.earlier[to] = x.sums.before;
        e.edge[to] = x.sums.edge;
        e.merges[to] = x.merges;
        e.crossings[to] = x.crossings;
        e.tail[to] = x.at.tail;
        records[count] = x.at.vertex;
        endOf[count++] = to;
        to += room;
      }
    }
    Context* const* contexts = nullptr;
    endContextCount_ = count ? sv_->shadeVertices(g_, count, records, &contexts) : 0;
    endContexts_ = make<EndContext>(endContextCount_);
    for (uint32_t k = 0; k < endContextCount_; ++k) {
      const Context& c = *contexts[k];
      endContexts_[k] = {&c, c.alloc<uint32_t>(c.padded), {}};
      for (uint32_t j = 0; j < c.padded; ++j) {
        const uint32_t to = endContexts_[k].end[j] = endOf[c.path[j]];
        if (j >= c.count) continue;
        e.context[to] = k;
        e.point[to] = j;
        for (int x = 0; x < 3; ++x) e.back[x][to] = c.N[x][j];
      }
    }
  }

  // The points of contexts with the ends of their paths.
  void connect(uint32_t count, Context* const* contexts, const Near* nears, uint32_t depth) {
    if (!endContextCount_ || depth >= o_.bounces) return;
    struct Way {
      float *d[3], *distance;  // unit, along the normal where there is no connection
      const float* through;    // transmittanceOfEdges()
    };
    Way* ways = make<Way>(count * kConnected);
    for (uint32_t c = 0; c < count; ++c)
      for (uint32_t k = 0; k < kConnected; ++k) {
        const Context& from = *contexts[c];
        Way& way = ways[c * kConnected + k];
        way.distance = make<float>(from.padded);
        for (float*& x : way.d) x = make<float>(from.padded);
        for (uint32_t i = 0; i < from.padded; i += W) {
          const EndLanes ends = endsOf(from, i, k, depth);
          const Vec3<W> between = Vec3<W>::get(ends_.P, ends.at) - Vec3<W>::load(from.P, i);
          const F distance = max(length(between), F(1e-18f));
          const Vec3<W> d = between / distance;
          select(ends.exist, d, Vec3<W>::load(from.N, i)).store(way.d, i);
          distance.store(way.distance + i);
          const Vec3<W> back = -d;
          ends.at.put(ends.exist, back.x, ends_.back[0]);
          ends.at.put(ends.exist, back.y, ends_.back[1]);
          ends.at.put(ends.exist, back.z, ends_.back[2]);
        }
        way.through = transmittanceOfEdges(g_, sv_, from, way.d, way.distance);
      }
    askEnds(depth);
    for (uint32_t c = 0; c < count; ++c) {
      arrivals_.of(*contexts[c]);
      for (uint32_t k = 0; k < kConnected; ++k) {
        const Way& way = ways[c * kConnected + k];
        connectContext(*contexts[c], nears[c], k, way.d, way.distance, way.through, depth);
      }
    }
    arrivals_.send();
  }

 private:
  using F = Float<W>;
  using Stored = vcm::Stored;
  static constexpr uint32_t kConnected = vcm::kConnected;

  struct EndContext {
    const Context* context;
    uint32_t* end;  // by point
    EvaluateArgs bxdf;
  };

  template <class T>
  T* make(uint32_t n) const {
    return static_cast<T*>(sv_->alloc(g_, (n + kPad) * sizeof(T)));
  }

  // The ends whose paths to the camera are not too long, of lanes at slots `s`, the k-th of each.
  struct EndLanes {
    Slots<W> at;
    Mask<W> exist;
  };
  EndLanes endsOf(const Context& c, uint32_t i, uint32_t k, uint32_t depth) const {
    const Mask<W> in = Mask<W>::firstN(int(std::min<uint32_t>(c.count - std::min(i, c.count), W)));
    const Slots<W> at(Int<W>::load(c.path + i) + Int<W>(k * ends_.room));
    if (c.traits & kTraitScattersOnce) return {at, Mask<W>(false)};  // its light comes from lights alone
    return {at, in & (at.get(ends_.before) < Int<W>(o_.bounces - depth))};
  }

  // What the ends' bxdfs say of the directions back.
  void askEnds(uint32_t depth) {
    for (uint32_t k = 0; k < endContextCount_; ++k) {
      EndContext& e = endContexts_[k];
      const Context& c = *e.context;
      if (c.depth + depth >= o_.bounces) continue;
      float* back[3] = {c.alloc<float>(c.padded), c.alloc<float>(c.padded), c.alloc<float>(c.padded)};
      for (uint32_t j = 0; j < c.padded; j += W) Vec3<W>::get(ends_.back, Slots<W>::load(e.end + j)).store(back, j);
      e.bxdf = evaluateBxdf(c, back);
      for (uint32_t j = 0; j < c.count; j += W) {
        const Mask<W> in = Mask<W>::firstN(int(std::min<uint32_t>(c.count - j, W)));
        const Slots<W> at = Slots<W>::load(e.end + j);
        const Vec3<W> w = Vec3<W>::load(back, j);
        const Vec3<W> start =
            kinora::HWY_NAMESPACE::leave(Vec3<W>::load(c.P, j), Vec3<W>::load(c.Ng, j), F::load(c.bias + j), w);
        at.put(in, start.x, ends_.start[0]);
        at.put(in, start.y, ends_.start[1]);
        at.put(in, start.z, ends_.start[2]);
        const Vec3<W> arriving = Vec3<W>::get(ends_.throughput, at) * adjointFactor(c, j, w);
        Vec3<W> sum(0.f);
        for (uint32_t l = 0; l < c.slotCount; ++l)
          sum += Vec3<W>::load(e.bxdf.weight[l], j) * at.get(ends_.factor[c.eventOfSlot[l] & 1]);
        // where events are read the slots of the end stay apart
        const Vec3<W> value = readsEvents_ ? arriving : arriving * sum;
        at.put(in, value.x, ends_.value[0]);
        at.put(in, value.y, ends_.value[1]);
        at.put(in, value.z, ends_.value[2]);
        at.put(in, F::load(e.bxdf.pdf + j), ends_.pdf);
        at.put(in, F::load(e.bxdf.pdfReverse + j), ends_.reverse);
        at.put(in, surfaceCosines(c, j, w), ends_.cosine);
        const F sine = Neighbourhoods<W>::sineOf(Vec3<W>::load(c.wo, j), w);
        at.put(in, fma(at.get(ends_.crossings), sine, at.get(ends_.merges)), ends_.through);
      }
    }
  }

  void connectContext(const Context& c, const Near& near, uint32_t k, const float* const d[3], const float* distance,
                      const float* through, uint32_t depth) {
    const EvaluateArgs e = evaluateBxdf(c, d);
    for (uint32_t i = 0; i < c.count; i += W) {
      const EndLanes ends = endsOf(c, i, k, depth);
      const Slots<W>& at = ends.at;
      const F pdf = F::load(e.pdf + i), pdfBack = at.get(ends_.pdf);
      const Mask<W> on = ends.exist & (pdf > F(0.f)) & (pdfBack > F(0.f));
      if (on.none()) continue;
      const Slots<W> s = Slots<W>::load(c.path + i);
      const Vec3<W> w = Vec3<W>::load(d, i);
      const F far = F::load(distance + i);
      const F others = othersOfConnection<F>(far,
                                             {sums_.at(s.s), pdfBack, surfaceCosines(c, i, w),
                                              F::load(e.pdfReverse + i), Neighbourhoods<W>::mergesOf(near, c, i, w)},
                                             {{at.get(ends_.last), at.get(ends_.earlier), at.get(ends_.edge)},
                                              pdf,
                                              at.get(ends_.cosine),
                                              at.get(ends_.reverse),
                                              at.get(ends_.through)},
                                             Shares::ofConnection(F::load(through + i)));
      const Vec3<W> arriving = Vec3<W>::get(paths_.throughput, s) * Vec3<W>::get(ends_.value, at) *
                               (F(1.f) / (far * far * (F(1.f) + others)));
      // a path has this vertex, the end and those before both
      const Mask<W> isClamped = at.get(ends_.before) + Int<W>(depth + 3) > Int<W>(o_.clampDepth);
      const auto clamped = [&](Vec3<W> v) {
        return select(isClamped, v * factorToLuminance(v, F(o_.clampLuminance)), v);
      };
      const Int<W> light = at.get(ends_.light);
      // Off both surfaces: a ray from off this one in the direction between the vertices would meet a surface that it
      // comes to at a low angle before the end.
      const Vec3<W> way =
          Vec3<W>::get(ends_.start, at) -
          kinora::HWY_NAMESPACE::leave(Vec3<W>::load(c.P, i), Vec3<W>::load(c.Ng, i), F::load(c.bias + i), w);
      const F reach = max(length(way), F(1e-18f));
      const Vec3<W> towards = select(on, way / reach, w);
      if (readsEvents_) {
        addByEvent(c, i, k, on, arriving, e, clamped, towards, reach);
        continue;
      }
      const Int<W> ray = arrivals_.from(on, i, towards, reach, c.slotCount);
      for (uint32_t l = 0; l < c.slotCount; ++l)
        arrivals_.add(on, clamped(arriving * Vec3<W>::load(e.weight[l], i)), ray, s.s,
                      paths_.stateAfter(s, c.eventOfSlot[l]), light);
    }
  }
  // The same where expressions read the light path: each point has states of its own.
  template <class Clamp>
  void addByEvent(const Context& c, uint32_t i, uint32_t k, Mask<W> on, Vec3<W> arriving, const EvaluateArgs& e,
                  const Clamp& clamped, Vec3<W> w, F far) {
    uint32_t most = 1;
    for (uint32_t m = 0; m < endContextCount_; ++m) most = std::max(most, endContexts_[m].context->slotCount);
    const Int<W> ray = arrivals_.from(on, i, w, far, c.slotCount * most);
    for (uint32_t l = 0; l < c.slotCount; ++l)
      for (uint32_t m = 0; m < most; ++m) {
        alignas(64) float part[3][W] = {};
        alignas(64) uint32_t state[W] = {}, light[W] = {};
        for (uint32_t bits = on.bits(); bits; bits &= bits - 1) {
          const uint32_t lane = uint32_t(__builtin_ctz(bits)), s = c.path[i + lane], at = s + k * ends_.room;
          const EndContext& end = endContexts_[ends_.context[at]];
          if (m >= end.context->slotCount) continue;
          const uint32_t event = end.context->eventOfSlot[m];
          for (int x = 0; x < 3; ++x)
            part[x][lane] = end.bxdf.weight[m][x][ends_.point[at]] * ends_.factor[event & 1][at];
          state[lane] =
              stepState(sv_->paths, stepState(sv_->paths, paths_.state[s], c.eventOfSlot[l]), event, ends_.tail[at]);
          light[lane] = ends_.light[at];
        }
        const Vec3<W> v =
            arriving * Vec3<W>::load(e.weight[l], i) * Vec3<W>(F::load(part[0]), F::load(part[1]), F::load(part[2]));
        arrivals_.add(on, clamped(v), ray, Int<W>::load(c.path + i), Int<W>::load(state), Int<W>::load(light));
      }
  }

  Group* g_;
  const Services* sv_;
  const vcm::Options& o_;
  const Subpaths<W>& paths_;
  const PathDensities& sums_;
  Arrivals<W>& arrivals_;
  bool readsEvents_;
  vcm::Ends ends_{};
  EndContext* endContexts_ = nullptr;
  uint32_t endContextCount_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
