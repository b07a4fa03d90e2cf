// Merging, of PxrVCM and what else merges: vertices of light paths near a point of a camera path count as if they lay
// on it; on surfaces within a disk, in a medium within a ball (point to point, 3D: Krivanek et al., "Unifying Points,
// Beams, and Paths in Volumetric Light Transport Simulation", 2014). Included per target by vcm_kernel.h.
#include <kinora/clamp_luminance.h>
#include <kinora/path_densities.h>
#include <kinora/subpaths.h>

#ifndef KINORA_VCM_ONCE
#define KINORA_VCM_ONCE
#include "plugins/integrator/parts/vcm_records.h"
#endif

#include "plugins/integrator/parts/vcm_neighbourhoods.h"

#if defined(KINORA_VCM_MERGED_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_VCM_MERGED_H_TARGET
#undef KINORA_VCM_MERGED_H_TARGET
#else
#define KINORA_VCM_MERGED_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Vertices of light paths merged with points of a context: some at a time, at one point.
template <int W>
class Merged {
 public:
  // readsEvents: whether states after the camera's first event still depend on what follows.
  Merged(Group* group, const Services* services, const vcm::Options& options, const Context& c,
         const vcm::MergeIndex& index, bool readsEvents)
      : g_(group),
        sv_(services),
        o_(options),
        c_(c),
        index_(index),
        readsEvents_(readsEvents),
        all_(static_cast<const vcm::Stored*>(services->stored(group, 0).records)),
        e_{} {
    for (int k = 0; k < 3; ++k) {
      e_.wi[k] = wi_[k] = c.alloc<float>(kMostMerged);
      throughput_[k] = c.alloc<float>(kMostMerged);
      value_[k] = c.alloc<float>(kRoom);
    }
    for (uint32_t l = 0; l < c.slotCount; ++l)
      for (float*& w : e_.weight[l]) w = c.alloc<float>(kMostMerged);
    e_.pdf = c.alloc<float>(kMostMerged);
    e_.pdfReverse = c.alloc<float>(kMostMerged);
    last_ = c.alloc<float>(kMostMerged);
    before_ = c.alloc<float>(kMostMerged);
    share_ = c.alloc<float>(kMostMerged);
    entry_ = c.alloc<uint32_t>(kMostMerged);
    for (uint32_t** x : {&slot_, &state_, &light_}) *x = c.alloc<uint32_t>(kRoom);
  }
  // The point that follows, of the context of which `near` is told; the others are its camera path's.
  void begin(uint32_t point, const typename Neighbourhoods<W>::Of& near, const PathSums& sums, Vec3<1> throughput,
             uint32_t state) {
    point_ = point;
    near_ = &near;
    sums_ = sums;
    through_ = throughput;
    from_ = state;
  }
  void add(uint32_t entry) {
    const vcm::Photon& p = index_.photons[entry];
    for (int k = 0; k < 3; ++k) {
      wi_[k][count_] = p.wo[k];
      throughput_[k][count_] = p.throughput[k];
    }
    last_[count_] = o_.samplesLight(c_.depth + p.verticesBefore()) ? p.last : 0;
    before_[count_] = p.before;
    entry_[count_] = entry;
    if (++count_ == kMostMerged) evaluate();
  }
  void evaluate() {
    using F = Float<W>;
    if (!count_) return;
    for (uint32_t i = count_; i < padded(count_); ++i) {
      for (int k = 0; k < 3; ++k) {
        wi_[k][i] = wi_[k][count_ - 1];
        throughput_[k][i] = throughput_[k][count_ - 1];
      }
      last_[i] = last_[count_ - 1];
      before_[i] = before_[count_ - 1];
    }
    c_.bxdf->evaluateAt(&c_, c_.closure, point_, padded(count_), &e_);
    const Vec3<W> Ng(F(c_.Ng[0][point_]), F(c_.Ng[1][point_]), F(c_.Ng[2][point_]));
    Vec3<W> fiber(0.f);
    if (c_.traits & kTraitFiber) {
      const Value along = c_.builtin(Builtin::Fiber);
      fiber = {F(along.data[0][point_]), F(along.data[1][point_]), F(along.data[2][point_])};
    }
    // in media the share of this technique is that of points; beams have the rest, by the angle between the two ways
    const bool isInSpace = c_.traits & kTraitInSpace;
    const float count = near_->count[point_], merges = near_->merges[point_], crossings = near_->crossings[point_];
    float own = count;
    if (isInSpace)
      own *= (near_->extinction[0][point_] + near_->extinction[1][point_] + near_->extinction[2][point_]) * (1.f / 3);
    const Vec3<W> wo(F(c_.wo[0][point_]), F(c_.wo[1][point_]), F(c_.wo[2][point_]));
    for (uint32_t i = 0; i < count_; i += W) {
      const Vec3<W> wi = Vec3<W>::load(wi_, i);
      const F pdf = F::load(e_.pdf + i);
      F others = othersOfMerge(sums_, F::load(last_ + i), F::load(before_ + i), pdf, F::load(e_.pdfReverse + i), own);
      if (isInSpace)
        others = others + (F(merges - own) + F(crossings) * Neighbourhoods<W>::sineOf(wo, wi)) * F(1 / own);
      // what light paths carry has met the surface already: the weight's cosine goes
      const F cosine = isInSpace ? F(1.f) : surfaceCosines(Ng, fiber, wi);
      zeroUnless(pdf > F(0.f), F(1.f) / (F(count) * (F(1.f) + others) * cosine)).store(share_ + i);
    }
    const uint32_t s = c_.path[point_];
    const bool clamps = o_.clampLuminance < 1e30f;
    for (uint32_t l = 0; l < c_.slotCount; ++l) {
      const uint32_t event = c_.eventOfSlot[l], state = stepState(sv_->paths, from_, event);
      for (uint32_t i = 0; i < count_; ++i) {
        V x = through_ * V::load(throughput_, i) * V::load(e_.weight[l], i) * Float<1>(share_[i]);
        if (!(maxComponent(x).lane0() > 0)) continue;
        const vcm::Photon& p = index_.photons[entry_[i]];
        const PathVertex& at = all_[index_.records[entry_[i]]].at;
        if (p.hasFactors()) x = x * Float<1>(at.factorOf(event));
        if (clamps && c_.depth + p.verticesBefore() + 2 > o_.clampDepth)
          x = x * factorToLuminance(x, Float<1>(o_.clampLuminance));
        put(x, s, readsEvents_ ? stepState(sv_->paths, from_, event, at.tail) : state, p.light);
      }
    }
    count_ = 0;
  }
  void send() {
    if (!n_) return;
    const Contributions out{n_, slot_, {value_[0], value_[1], value_[2]}, state_, light_, LightKind::Shadowed};
    sv_->contribute(g_, &out);
    n_ = 0;
  }

 private:
  using V = Vec3<1>;
  static constexpr uint32_t kMostMerged = 64;  // evaluated together
  static constexpr uint32_t kRoom = 4096;
  void put(V x, uint32_t slot, uint32_t state, uint32_t light) {
    if (n_ && slot_[n_ - 1] == slot && state_[n_ - 1] == state && light_[n_ - 1] == light) {
      (V::load(value_, n_ - 1) + x).store(value_, n_ - 1);
      return;
    }
    if (n_ == kRoom) send();
    x.store(value_, n_);
    slot_[n_] = slot;
    state_[n_] = state;
    light_[n_++] = light;
  }
  Group* g_;
  const Services* sv_;
  const vcm::Options& o_;
  const Context& c_;
  const vcm::MergeIndex& index_;
  bool readsEvents_;
  const vcm::Stored* all_;
  EvaluateArgs e_;
  PathSums sums_{};
  V through_{};
  uint32_t from_ = 0;  // state of the camera path
  float *wi_[3], *throughput_[3], *value_[3], *last_, *before_, *share_;
  const typename Neighbourhoods<W>::Of* near_ = nullptr;
  uint32_t *entry_, *slot_, *state_, *light_;
  uint32_t point_ = 0, count_ = 0, n_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
