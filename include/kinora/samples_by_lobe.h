// How many directions are followed from what the camera sees, by the kind of lobe that they come from.
//
// Of a hit's directions, drawn from all its lobes as ever, number i (from 0) is followed if its kind has more than i
// samples, and weighs one over their number: the mean is what it was, whatever the numbers are. A kind that is chosen
// with probability p is followed in p times its number of directions. Light samples share with them by a partition for
// each kind, in which its directions have their density times their number.
//
// Number i of a vertex is a sequence over the samples of a pixel of its own, so that a kind with fewer directions than
// another one is as well distributed as if it were alone.
// Included per target.
#include <kinora/bxdf.h>
#include <kinora/simd/wide.h>

#ifndef KINORA_SAMPLES_BY_LOBE_ONCE
#define KINORA_SAMPLES_BY_LOBE_ONCE
#include <algorithm>
namespace kinora {
struct SamplesByLobe {
  bool given = false;  // false: all kinds have the same
  // Diffuse: scattering in media too. Specular: reflections. Subsurface: paths that go on below the surface.
  uint32_t diffuse = 1, specular = 1, refraction = 1, subsurface = 1;
  constexpr uint32_t most() const { return std::max({diffuse, specular, refraction, subsurface, 1u}); }
};
}  // namespace kinora
#endif

#if defined(KINORA_SAMPLES_BY_LOBE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SAMPLES_BY_LOBE_H_TARGET
#undef KINORA_SAMPLES_BY_LOBE_H_TARGET
#else
#define KINORA_SAMPLES_BY_LOBE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// The numbers at the points of a context.
template <int W>
class LobeCounts {
  using F = Float<W>;

 public:
  LobeCounts(const Context& c, const SamplesByLobe& numbers) : c_(c), n_(numbers) {
    for (uint32_t l = 0; l < c.slotCount; ++l) specular_ |= uint32_t(c.eventOfSlot[l] & 1) << l;
  }
  // Of a slot for directions on either side of the surface.
  KN_INLINE F of(uint32_t slot, Mask<W> through) const {
    if (!(specular_ >> slot & 1)) return F(float(n_.diffuse));
    return select(through, F(float(n_.refraction)), F(float(n_.specular)));
  }
  // Of samples that generate() made.
  KN_INLINE F of(Int<W> slots, Int<W> flags) const {
    F n(float(n_.diffuse));
    const Mask<W> through = (flags & Int<W>(uint32_t(kSampleTransmit))) != Int<W>(0);
    for (uint32_t l = 0; l < c_.slotCount; ++l) n = select(slots == Int<W>(l), of(l, through), n);
    const Mask<W> below = (flags & Int<W>(uint32_t(kSampleBelow))) != Int<W>(0);
    return select(below, F(float(n_.subsurface)), n);
  }
  // Whether W directions from the points from i on go through the surface, as generate() would say.
  KN_INLINE Mask<W> through(uint32_t i, Vec3<W> wi) const { return dot(wi, Vec3<W>::load(c_.Ng, i)) < F(0.f); }

 private:
  const Context& c_;
  const SamplesByLobe n_;
  uint32_t specular_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
