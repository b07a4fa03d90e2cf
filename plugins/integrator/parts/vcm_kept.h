// Vertices of a group's light paths until these end, and what of them is stored for camera paths to find. Included per
// target by vcm_kernel.h.
#include "plugins/integrator/parts/vcm_neighbourhoods.h"

#if defined(KINORA_VCM_KEPT_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_VCM_KEPT_H_TARGET
#undef KINORA_VCM_KEPT_H_TARGET
#else
#define KINORA_VCM_KEPT_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
class KeptVertices {
 public:
  KeptVertices(Group* group, const Services* services, const vcm::Options& options, const Neighbourhoods<W>& near,
               const PathDensities& sums)
      : g_(group),
        sv_(services),
        o_(options),
        near_(near),
        sums_(sums),
        most_(options.bounces + (options.mergesAny() ? 1 : 0)),
        newest_(make<Kept*>(group->count)) {
    std::fill_n(newest_, g_->count, nullptr);
  }

  // Of a path.
  uint32_t most() const { return most_; }
  // For the next vertex of each of so many paths; it lasts longer than what depths make for themselves.
  void makeRoom(uint32_t paths) { room_ = make<Kept>(paths); }
  void keep(const Context& c, const PathVertex* vertices, const typename Neighbourhoods<W>::Of& near) {
    const bool isInSpace = c.traits & kTraitInSpace;
    for (uint32_t i = 0; i < c.count; ++i) {
      const PathVertex& v = vertices[i];
      const uint32_t s = c.path[i];
      const PathSums& x = sums_[s];
      float passes[3];
      for (int k = 0; k < 3; ++k) {
        const float extinction = near.extinction[k] ? near.extinction[k][i] : 1.f;
        passes[k] = extinction > 0 ? v.throughput[k] / extinction : 0.f;
      }
      *room_ = {{v,
                 x,
                 {{c.P[0][i], c.P[1][i], c.P[2][i]},
                  {c.wo[0][i], c.wo[1][i], c.wo[2][i]},
                  {passes[0], passes[1], passes[2]},
                  x.edge * x.last,
                  x.before,
                  c.time[i],
                  near.radius ? near.radius[i] : 0.f,
                  v.light,
                  v.before | (v.factor[0] == 1 && v.factor[1] == 1 ? 0 : vcm::Photon::kHasFactors),
                  isInSpace ? c.place.instance[i] : vcm::Photon::kNoMedium},
                 near.merges ? near.merges[i] : 0.f,
                 near.merges ? near.crossings[i] : 0.f,
                 0},
                newest_[s]};
      newest_[s] = room_++;
    }
  }
  // What camera paths will ask for: of each path the vertices that are connected, and where they are merged all.
  void store() const {
    constexpr uint32_t kTogether = 128;
    vcm::Stored *out = make<vcm::Stored>(kTogether), **path = make<vcm::Stored*>(most_);
    uint32_t *slots = make<uint32_t>(kTogether), n = 0;
    const auto send = [&] {
      if (n) sv_->append(g_, 0, n, slots, out);
      n = 0;
    };
    for (uint32_t s = 0; s < g_->count; ++s) {
      uint32_t count = 0;
      for (Kept* k = newest_[s]; k; k = k->earlier) path[count++] = &k->stored;
      std::reverse(path, path + count);
      if (o_.connects && count) {
        Float<1> u, unused;
        draw2(sv_->samples, Int<1>(g_->paths.sampleSeed[s]), Int<1>(g_->paths.sampleIndex[s]),
              dimensionAt(0) + kDimUser, u, unused);
        vcm::drawEnds(path, std::min(count, o_.bounces), vcm::connectedOf(o_, sv_->mediaScatter), o_.bounces, o_.kept,
                      u.lane0());
      }
      const bool merged = near_.isMerged(s);
      for (uint32_t v = 0; v < count; ++v) {
        if (!merged && !(path[v]->probability > 0)) continue;
        if (n == kTogether) send();
        if (!merged) path[v]->photon.radius = 0;
        slots[n] = s;
        out[n++] = *path[v];
      }
    }
    send();
  }

 private:
  struct Kept {
    vcm::Stored stored;
    Kept* earlier;  // of the same path
  };
  template <class T>
  T* make(uint32_t n) const {
    return static_cast<T*>(sv_->alloc(g_, (n + kPad) * sizeof(T)));
  }

  Group* g_;
  const Services* sv_;
  const vcm::Options& o_;
  const Neighbourhoods<W>& near_;
  const PathDensities& sums_;
  uint32_t most_;
  Kept** newest_;         // by slot
  Kept* room_ = nullptr;  // for the vertices that follow
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
