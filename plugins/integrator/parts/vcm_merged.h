// Merging, of PxrVCM and what else merges: vertices of light paths near a point of a camera path count as if they lay
// on it; on surfaces within a disk, in a medium within a ball (point to point, 3D: Krivanek et al., "Unifying Points,
// Beams, and Paths in Volumetric Light Transport Simulation", 2014). Included per target by vcm_kernel.h.
#include <kinora/clamp_luminance.h>
#include <kinora/path_densities.h>
#include <kinora/simd/records.h>
#include <kinora/subpaths.h>

#ifndef KINORA_VCM_ONCE
#define KINORA_VCM_ONCE
#include "plugins/integrator/parts/vcm_records.h"
#endif

#include "plugins/integrator/parts/merge_search.h"

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
      e_.wi[k] = wi_[k] = c.alloc<float>(kMostHeld);
      brought_[k] = c.alloc<float>(kMostMerged);
      throughput_[k] = c.alloc<float>(kMostHeld);
      value_[k] = c.alloc<float>(kRoom);
    }
    for (uint32_t l = 0; l < c.slotCount; ++l)
      for (float*& w : e_.weight[l]) w = c.alloc<float>(kMostMerged);
    e_.pdf = c.alloc<float>(kMostMerged);
    e_.pdfReverse = c.alloc<float>(kMostMerged);
    last_ = c.alloc<float>(kMostHeld);
    before_ = c.alloc<float>(kMostHeld);
    share_ = c.alloc<float>(kMostMerged);
    // lanes behind the last vertex hold what was there, at first this
    for (int k = 0; k < 3; ++k) {
      std::fill_n(wi_[k], kMostHeld, k == 2 ? 1.f : 0.f);
      std::fill_n(throughput_[k], kMostHeld, 0.f);
    }
    std::fill_n(last_, kMostHeld, 0.f);
    std::fill_n(before_, kMostHeld, 0.f);
    for (uint32_t** x : {&entry_, &lightOf_, &length_}) *x = c.alloc<uint32_t>(kMostHeld);
    std::fill_n(length_, kMostHeld, 0u);
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
  // Those of some entries, at most MergeIndex::kTogether, that the point may be merged with. medium: that it lies in.
  // Which are evaluated together, and summed, follows from the order of all of the point's alone: how many come in a call
  // depends on the points that were looked up with it.
  void add(const uint32_t* entries, uint32_t n, uint32_t medium) {
    using F = Float<W>;
    using I = Int<W>;
    const F time(c_.time[point_]), most(o_.timeRadius);
    // vertices before it: so many at the most
    const int32_t longest = c_.traits & kTraitScattersOnce ? 0 : int32_t(o_.bounces) - int32_t(c_.depth);
    for (uint32_t i = 0; i < n; i += W) {
      alignas(64) uint32_t entry[W];
      const float* from[4][W];
#pragma GCC unroll 16
      for (uint32_t k = 0; k < W; ++k) {
        entry[k] = entries[std::min(i + k, n - 1)];
        const float* photon = index_.photons[entry[k]].P;
#pragma GCC unroll 4
        for (size_t four = 0; four < 4; ++four) from[four][k] = photon + 4 * four;
      }
      F word[16];
      for (size_t four = 0; four < 4; ++four) loadFours<W>(from[four], word + 4 * four);
      const F wo[3] = {word[3], word[4], word[5]}, throughput[3] = {word[6], word[7], word[8]};
      const I length = asInt(word[14]), before = length & I(~vcm::Photon::kHasFactors);
      const Mask<W> on = (asInt(word[15]) == I(medium)) & (abs(word[11] - time) <= most) & !(I(longest) < before) &
                         Mask<W>::firstN(int(std::min<uint32_t>(n - i, W)));
      const Packer<W> pack(on);
      for (int k = 0; k < 3; ++k) {
        pack.put(wo[k], wi_[k] + count_);
        pack.put(throughput[k], throughput_[k] + count_);
      }
      const Mask<W> isSampled = Mask<W>(o_.samplesLight(c_.depth)) | (before != I(0));
      pack.put(zeroUnless(isSampled, word[9]), last_ + count_);
      pack.put(word[10], before_ + count_);
      pack.put(asInt(word[13]), lightOf_ + count_);
      pack.put(length, length_ + count_);
      pack.put(I::load(entry), entry_ + count_);
      count_ += uint32_t(pack.count);
    }
    if (count_ < kMostMerged) return;
    const uint32_t left = count_ - kMostMerged;
    count_ = kMostMerged;
    evaluate();
    for (int k = 0; k < 3; ++k) {
      std::copy_n(wi_[k] + kMostMerged, left, wi_[k]);
      std::copy_n(throughput_[k] + kMostMerged, left, throughput_[k]);
    }
    for (float* x : {last_, before_}) std::copy_n(x + kMostMerged, left, x);
    for (uint32_t* x : {entry_, lightOf_, length_}) std::copy_n(x + kMostMerged, left, x);
    count_ = left;
  }
  void evaluate() {
    using F = Float<W>;
    using I = Int<W>;
    if (!count_) return;
    if (n_ + count_ * c_.slotCount > kRoom) send();
    firstTogether_ = n_;
    c_.bxdf->evaluateAt(&c_, c_.closure, point_, count_, &e_);
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
    const bool clamps = std::min(o_.clampLuminance, o_.clampDirect) < 1e30f;
    // the light's own factors, where any has them, and one sum where the rest of a path does not matter
    uint32_t differs = 0, factors = 0;
    for (uint32_t i = 0; i < count_; ++i) {
      differs |= lightOf_[i] ^ lightOf_[0];
      factors |= length_[i] & vcm::Photon::kHasFactors;
    }
    const bool isOne = !differs && !readsEvents_;
    const auto at = [&](uint32_t i) -> const PathVertex& { return all_[index_.records[entry_[i]]].at; };
    for (uint32_t l = 0; l < c_.slotCount; ++l) {
      const uint32_t event = c_.eventOfSlot[l], state = stepState(sv_->paths, from_, event);
      // the same sums for all widths: of the k-th of each sixteen
      alignas(64) float sums[3][kTogether] = {};
      for (uint32_t i = 0; i < count_; i += W) {
        Vec3<W> x = Vec3<W>(F(through_.x.lane0()), F(through_.y.lane0()), F(through_.z.lane0())) *
                    Vec3<W>::load(throughput_, i) * Vec3<W>::load(e_.weight[l], i) * F::load(share_ + i);
        if (factors) {
          alignas(64) float factor[W];
          for (uint32_t k = 0; k < W; ++k)
            factor[k] = i + k < count_ && length_[i + k] & vcm::Photon::kHasFactors ? at(i + k).factorOf(event) : 1.f;
          x = x * F::load(factor);
        }
        if (clamps) {
          const I before = I::load(length_ + i) & I(~vcm::Photon::kHasFactors);
          const Mask<W> isDeep = I(int32_t(o_.clampDepth) - int32_t(c_.depth) - 2) < before;
          x = x * factorToLuminance(x, select(isDeep, F(o_.clampLuminance), F(o_.clampDirect)));
        }
        x = zeroUnless((maxComponent(x) > F(0.f)) & Mask<W>::firstN(int(std::min<uint32_t>(count_ - i, W))), x);
        if (isOne) {
          float* const to[3] = {sums[0], sums[1], sums[2]};
          (Vec3<W>::load(to, i % kTogether) + x).store(to, i % kTogether);
        } else {
          x.store(brought_, i);
        }
      }
      if (isOne) {
        for (uint32_t half = kTogether / 2; half; half /= 2)
          for (auto& sum : sums)
            for (uint32_t k = 0; k < half; ++k) sum[k] += sum[k + half];
        put(sums[0][0], sums[1][0], sums[2][0], s, state, lightOf_[0]);
        continue;
      }
      for (uint32_t i = 0; i < count_; ++i)
        put(brought_[0][i], brought_[1][i], brought_[2][i], s,
            readsEvents_ ? stepState(sv_->paths, from_, event, at(i).tail) : state, lightOf_[i]);
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
  static constexpr uint32_t kMostMerged = 64;  // evaluated together
  static constexpr uint32_t kTogether = vcm::MergeIndex::kTogether;
  static constexpr uint32_t kMostHeld = kMostMerged + kTogether;
  static constexpr uint32_t kRoom = 4096;
  static_assert(kMostMerged * kMaxSlots <= kRoom);
  void put(float r, float g, float b, uint32_t slot, uint32_t state, uint32_t light) {
    if (!(std::max(r, std::max(g, b)) > 0)) return;
    const bool isLast =
        n_ > firstTogether_ && slot_[n_ - 1] == slot && state_[n_ - 1] == state && light_[n_ - 1] == light;
    if (isLast) {
      value_[0][n_ - 1] += r;
      value_[1][n_ - 1] += g;
      value_[2][n_ - 1] += b;
      return;
    }
    value_[0][n_] = r;
    value_[1][n_] = g;
    value_[2][n_] = b;
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
  Vec3<1> through_{};
  uint32_t from_ = 0;  // state of the camera path
  float *wi_[3], *throughput_[3], *value_[3], *brought_[3], *last_, *before_, *share_;
  const typename Neighbourhoods<W>::Of* near_ = nullptr;
  uint32_t *entry_, *lightOf_, *length_, *slot_, *state_, *light_;
  uint32_t point_ = 0, count_ = 0, n_ = 0;
  uint32_t firstTogether_ = 0;  // of what was evaluated last: nothing else is added to it before it is sent
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
