// The author's layer of light filters; see light_filter.h. Included per target, after <kinora/simd/foreach_target.h>.
//
//   struct MyFilter {
//     using Data = ...;
//     template <int W> static Rgb<W> factor(const Data&, const LitPoint<W>&);
//   };
//   KINORA_LIGHT_FILTER(MyFilter, .help = "...", .params = kParams, .setUp = setUp<Data>)        // after
//   KINORA_KERNELS_END
#include <kinora/light_filter.h>
#ifdef KINORA_KERNEL_FILE
#include <kinora/simd/foreach_target.h>
#endif
#include <kinora/simd/wide.h>

#if defined(KINORA_LIGHT_FILTER_AUTHOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LIGHT_FILTER_AUTHOR_H_TARGET
#undef KINORA_LIGHT_FILTER_AUTHOR_H_TARGET
#else
#define KINORA_LIGHT_FILTER_AUTHOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
struct LitPoint {
  Vec3<W> P, wi;
  Float<W> distance, time;
  KN_INLINE LitPoint() {}
};

template <class Filter>
struct LightFilterRunner {
  template <int W>
  static void factor(const void* filter, const LightFilterArgs* a) {
    using F = Float<W>;
    for (uint32_t i = 0; i < a->count; i += W) {
      LitPoint<W> p;
      p.P = Vec3<W>::load(a->P, i);
      p.wi = Vec3<W>::load(a->wi, i);
      p.distance = F::load(a->distance + i);
      p.time = a->time ? F::load(a->time + i) : F(0.f);
      const Rgb<W> f = Filter::template factor<W>(*static_cast<const typename Filter::Data*>(filter), p);
      // a factor that is not finite would spread; a negative one would not be light
      const Mask<W> good = isFinite(f);
      const Rgb<W> kept = zeroUnless(good, f);
      Rgb<W>(max(kept.x, F(0.f)), max(kept.y, F(0.f)), max(kept.z, F(0.f))).store(a->factor, i);
    }
  }
  template <int W>
  static constexpr LightFilterFunctions table() {
    return LightFilterFunctions{&factor<W>};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif

#include <kinora/simd/tables.h>

// Ends the file of a plug-in, whose struct has its name.
#undef KINORA_LIGHT_FILTER
#define KINORA_LIGHT_FILTER(Name, ...) KINORA_PLUGIN(Name, LightFilterRunner<Name>, LightFilterPlugin, __VA_ARGS__)
