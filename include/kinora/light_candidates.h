// Several light samples of a point, of which one is followed by a shadow ray: resampling (Talbot et al., "Importance
// Resampling for Global Illumination", EGSR 2005) in proportion to what each would bring were nothing in its way. What is
// followed stands for all of them: the mean is that of one sample, the noise nearer to that of as many as there are
// candidates where it comes from the choice of light and point and not from shadows. Included per target.
#include <kinora/integrator.h>
#include <kinora/math/sampling.h>
#include <kinora/random.h>

#if defined(KINORA_LIGHT_CANDIDATES_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LIGHT_CANDIDATES_H_TARGET
#undef KINORA_LIGHT_CANDIDATES_H_TARGET
#else
#define KINORA_LIGHT_CANDIDATES_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Light samples of a context's points, and what its bxdf scatters of them.
template <int W>
class LightCandidates {
  using F = Float<W>;
  using I = Int<W>;

 public:
  LightSamples samples;
  EvaluateArgs scattered{};
  float* factor = nullptr;  // on what the sample brings, for the candidates that it stands for; null: 1

  LightCandidates(Group* group, const Services* services, const Context& c) : g_(group), sv_(services), c_(c) {}

  // `count` candidates for the part-th of `parts` samples. shares: by how much the power heuristic counts a sample,
  // of its densities by light and bxdf.
  template <class Shares>
  void make(uint32_t part, uint32_t parts, uint32_t count, const float* const throughput[3], const Shares& shares) {
    sv_->lightSamples(g_, &c_, part * count, parts * count, &samples);
    scatter();
    if (count < 2) return;
    float *x = floats(), *chosen = floats(), *total = floats();
    for (uint32_t i = 0; i < c_.padded; i += W) {
      F unused, u;
      draw2(sv_->samples, I::load(c_.sampleSeed + i), I::load(c_.sampleIndex + i) * I(parts) + I(part),
            subSampled(dimensionAt(c_.depth) + kDimRoulette, part, parts), unused, u);
      u.store(x + i);
      const F w = worth(samples, scattered, i, throughput, shares);
      w.store(chosen + i);
      w.store(total + i);
    }
    const LightSamples first = samples;
    const EvaluateArgs atFirst = scattered;
    own();
    for (uint32_t k = 1; k < count; ++k) {
      LightSamples next;
      EvaluateArgs at{};
      sv_->lightSamples(g_, &c_, part * count + k, parts * count, &next);
      scatter(next, at);
      const LightSamples& before = k == 1 ? first : samples;
      const EvaluateArgs& atBefore = k == 1 ? atFirst : scattered;
      for (uint32_t i = 0; i < c_.padded; i += W) {
        const F w = worth(next, at, i, throughput, shares), sum = F::load(total + i) + w;
        sum.store(total + i);
        const F u = F::load(x + i), p = w / max(sum, F(1e-37f));
        const Mask<W> is = u < p;
        min(select(is, u / max(p, F(1e-37f)), (u - p) / max(F(1.f) - p, F(1e-37f))), F(0.99999994f)).store(x + i);
        select(is, w, F::load(chosen + i)).store(chosen + i);
        const auto pick = [&](const float* a, const float* b, const float* to) HWY_ATTR {
          select(is, F::load(a + i), F::load(b + i)).store(const_cast<float*>(to) + i);
        };
        const auto pickWord = [&](const uint32_t* a, const uint32_t* b, const uint32_t* to) HWY_ATTR {
          select(is, I::load(a + i), I::load(b + i)).store(const_cast<uint32_t*>(to) + i);
        };
        for (int d = 0; d < 3; ++d) {
          pick(next.wi[d], before.wi[d], samples.wi[d]);
          pick(next.radiance[d], before.radiance[d], samples.radiance[d]);
          if (samples.specularRadiance[d])
            pick(next.specularRadiance[d], before.specularRadiance[d], samples.specularRadiance[d]);
          for (uint32_t l = 0; l < c_.slotCount; ++l)
            pick(at.weight[l][d], atBefore.weight[l][d], scattered.weight[l][d]);
        }
        pick(next.distance, before.distance, samples.distance);
        pick(next.pdf, before.pdf, samples.pdf);
        pick(next.diffuse, before.diffuse, samples.diffuse);
        pick(next.specular, before.specular, samples.specular);
        if (samples.spread) pick(next.spread, before.spread, samples.spread);
        pick(at.pdf, atBefore.pdf, scattered.pdf);
        pickWord(next.flags, before.flags, samples.flags);
        pickWord(next.light, before.light, samples.light);
      }
    }
    factor = total;
    for (uint32_t i = 0; i < c_.padded; i += W)
      (F::load(total + i) / max(F::load(chosen + i) * F(float(count)), F(1e-37f))).store(factor + i);
  }

  // What the bxdf scatters of samples that were put here.
  void scatter() { scatter(samples, scattered); }

 private:
  float* floats() { return static_cast<float*>(sv_->alloc(g_, c_.padded * sizeof(float))); }
  void scatter(const LightSamples& from, EvaluateArgs& at) {
    for (int d = 0; d < 3; ++d) at.wi[d] = from.wi[d];
    for (uint32_t l = 0; l < c_.slotCount; ++l)
      for (float*& w : at.weight[l]) w = floats();
    at.pdf = floats();
    c_.bxdf->evaluate(&c_, c_.closure, &at);
  }
  // Memory of its own for the ones that are followed.
  void own() {
    const auto word = [&] { return reinterpret_cast<uint32_t*>(floats()); };
    for (int d = 0; d < 3; ++d) {
      samples.wi[d] = floats();
      samples.radiance[d] = floats();
      if (samples.specularRadiance[d]) samples.specularRadiance[d] = floats();
      scattered.wi[d] = samples.wi[d];
      for (uint32_t l = 0; l < c_.slotCount; ++l) scattered.weight[l][d] = floats();
    }
    samples.distance = floats();
    samples.pdf = floats();
    samples.diffuse = floats();
    samples.specular = floats();
    if (samples.spread) samples.spread = floats();
    scattered.pdf = floats();
    samples.flags = word();
    samples.light = word();
  }
  template <class Shares>
  KN_INLINE F worth(const LightSamples& s, const EvaluateArgs& at, uint32_t i, const float* const throughput[3],
                    const Shares& shares) const {
    const Slots<W> path = Slots<W>::load(c_.path + i);
    const F pdf = F::load(s.pdf + i);
    const Vec3<W> t = Vec3<W>::get(throughput, path), base = t * Vec3<W>::load(s.radiance, i);
    const Vec3<W> glossy = s.specularRadiance[0] ? t * Vec3<W>::load(s.specularRadiance, i) : base;
    F sum(0.f);
    for (uint32_t l = 0; l < c_.slotCount; ++l) {
      const bool isSpecular = c_.eventOfSlot[l] & 1;
      const Vec3<W> v = (isSpecular ? glossy : base) * Vec3<W>::load(at.weight[l], i) *
                        F::load((isSpecular ? s.specular : s.diffuse) + i);
      sum = sum + abs(v.x) + abs(v.y) + abs(v.z);
    }
    const Mask<W> delta = (I::load(s.flags + i) & I(uint32_t(kSampleDelta))) != I(0);
    const F w = sum * select(delta, F(1.f), shares(pdf, F::load(at.pdf + i))) / max(pdf, F(1e-38f));
    return zeroUnless((pdf > F(0.f)) & (w > F(0.f)) & isFinite(w), w);
  }

  Group* g_;
  const Services* sv_;
  const Context& c_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
