// Rays that a pattern sends from all points of its context to one side of their surfaces, and what they meet summed by
// point. What PxrDirt and PxrCurvature have in common. Included per target.
#include <limits>

#include <kinora/pattern_author.h>
#include <kinora/math/sampling.h>
#include <kinora/random.h>

#if defined(KINORA_SIDE_RAYS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SIDE_RAYS_H_TARGET
#undef KINORA_SIDE_RAYS_H_TARGET
#else
#define KINORA_SIDE_RAYS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Sides of a surface: the one that a point is seen from, and the other. Each has random numbers of its own.
enum class ProbeSide : uint32_t { Seen, Behind };
KN_INLINE float signOf(ProbeSide side) { return side == ProbeSide::Seen ? 1.f : -1.f; }

// How directions are spread over the hemisphere: evenly, by the cosine, or by the cosine to a power.
enum class ProbeSpread { Uniform, Cosine, Power };

// A unit direction about +z: of ray `part` of `parts`.
template <int W>
KN_INLINE Vec3<W> drawAboutZ(const Context& c, uint32_t part, uint32_t parts, ProbeSide side, ProbeSpread spread,
                             Float<W> power, At at) {
  using F = Float<W>;
  F u, v;
  draw2(*c.samples, Int<W>::load(c.sampleSeed + at.first),
        Int<W>::load(c.sampleIndex + at.first) * Int<W>(parts) + Int<W>(part),
        dimensionAt(c.depth) + kDimPattern + uint32_t(side), u, v);
  if (spread == ProbeSpread::Uniform) return uniformCone(u, v, F(1.f));
  const Vec3<W> local = cosineHemisphere(u, v);
  return spread == ProbeSpread::Cosine ? local : bendToPower(local, min(max(power, F(0.f)), F(1e4f)));
}

// A direction about +z turned to be about `axis` (unit); what then goes below the surface, whose normal on this side is
// Ng, is mirrored at it.
template <int W>
KN_INLINE Vec3<W> turnTo(Vec3<W> local, Vec3<W> axis, Vec3<W> Ng) {
  using F = Float<W>;
  const Vec3<W> d = Frame<W>(axis).toWorld(local);
  const F height = dot(d, Ng);
  return select(height < F(0.f), fma(Ng, height * F(-2.f), d), d);
}

// By the cosine to a power that a parameter gives, unless it is 1 everywhere.
inline ProbeSpread spreadBy(bool isUniform, const Value& power) {
  if (isUniform) return ProbeSpread::Uniform;
  return power.uniform() && power.data[0][0] == 1.f ? ProbeSpread::Cosine : ProbeSpread::Power;
}

// `parts` rays from each point to a side; farthest: their length, scene units, 0 for any.
template <int W>
class SideRays {
  using F = Float<W>;

 public:
  SideRays(const Context& c, uint32_t parts, const Value& farthest, const char* traceSet) : c_(c), parts_(parts) {
    const uint32_t n = c.padded;
    point_ = c.alloc<uint32_t>(n), part_ = c.alloc<uint32_t>(n), reach_ = c.alloc<float>(n), t_ = c.alloc<float>(n);
    for (float*& axis : d_) axis = c.alloc<float>(n);
    for (uint32_t i = 0; i < n; ++i) point_[i] = i < c.count ? i : c.count - 1;
    for (uint32_t i = 0; i < n; i += W) {
      const F r = loadFloat<W>(farthest, At{i, false});
      select(r > F(0.f), r, F(kInfinity)).store(reach_ + i);
      F(kInfinity).store(t_ + i);
    }
    probe_ = {c.count, point_, part_, {d_[0], d_[1], d_[2]}, reach_, traceSet, t_};
  }
  uint32_t parts() const { return parts_; }

  // Adds what share(distance, at) makes of each hit to `sum`, by point; direction(part, at): where ray `part` goes.
  // The number of rays from each point that were traced: 0 where nothing can be (ContextFunctions::probe).
  template <class Direction, class Share>
  uint32_t add(ProbeSide side, Direction direction, Share share, float* sum) {
    const uint32_t n = c_.padded;
    for (uint32_t k = 0; k < parts_; ++k) {
      if (!c_.samples) return k;
      for (uint32_t i = 0; i < n; ++i) part_[i] = k + uint32_t(side) * parts_;
      for (uint32_t i = 0; i < n; i += W) direction(k, At{i, false}).store(d_, i);
      if (!c_.fn->probe(&c_, &probe_)) return k;
      for (uint32_t i = 0; i < n; i += W) {
        const At at{i, false};
        const F t = F::load(t_ + i);
        const Mask<W> met = t < F(kInfinity);
        (F::load(sum + i) + select(met, share(select(met, t, F(0.f)), at), F(0.f))).store(sum + i);
      }
    }
    return parts_;
  }

 private:
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const Context& c_;
  const uint32_t parts_;
  uint32_t *point_, *part_;
  float *d_[3], *reach_, *t_;
  ProbeRays probe_;
};

// A number of rays as a parameter gives it.
KN_INLINE uint32_t raysAsked(int number) { return number < 1 ? 1u : number > 1024 ? 1024u : uint32_t(number); }

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
