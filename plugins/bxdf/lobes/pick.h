// The choice of one of several ways to make a direction, by weights whose sum the scale brings to 1. Included per
// target, behind bxdf_author.h.
#if defined(KINORA_LOBES_PICK_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_PICK_H_TARGET
#undef KINORA_LOBES_PICK_H_TARGET
#else
#define KINORA_LOBES_PICK_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Ways are offered in order, each once. Rounding never walks past the last that has weight.
template <int W>
struct Pick {
  Int<W> made;      // the way; `none` where no way has weight
  Float<W> weight;  // its weight
  Float<W> rest;    // what the number has left within it: from 0 to its weight
  KN_INLINE Pick(Float<W> u, Float<W> scale, uint32_t none)
      : made(none), weight(0.f), rest(u / max(scale, Float<W>(1e-30f))), open_(scale > Float<W>(0.f)) {}
  KN_INLINE void offer(uint32_t way, Float<W> w) {
    const Mask<W> here = open_ & (w > Float<W>(0.f));
    made = select(here, Int<W>(way), made);
    weight = select(here, w, weight);
    const Mask<W> past = here & (rest >= w);
    open_ = past | (open_ & !here);
    rest = select(past, rest - w, rest);
  }

 private:
  Mask<W> open_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
