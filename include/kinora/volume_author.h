// The author's layer of volumes; see volume.h. Included per target, after <kinora/simd/foreach_target.h>.
//
//   struct MyVolume {
//     using Data = ...;
//     template <int W> static Rgb<W> value(const Data&, uint32_t field, Vec3<W> P, Float<W> time);
//   };
//   KINORA_VOLUME(MyVolume, .help = "...", .params = kParams, .setUp = setUp<Data>)        // after
//   KINORA_KERNELS_END
#include <kinora/volume.h>
#ifdef KINORA_KERNEL_FILE
#include <kinora/simd/foreach_target.h>
#endif
#include <kinora/simd/wide.h>

#if defined(KINORA_VOLUME_AUTHOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_VOLUME_AUTHOR_H_TARGET
#undef KINORA_VOLUME_AUTHOR_H_TARGET
#else
#define KINORA_VOLUME_AUTHOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <class Volume>
struct VolumeRunner {
  template <int W>
  static void evaluate(const void* volume, const VolumeArgs* a) {
    for (uint32_t i = 0; i < a->count; i += W) {
      const Rgb<W> v =
          Volume::template value<W>(*static_cast<const typename Volume::Data*>(volume), a->field,
                                    Vec3<W>::load(a->P, i), a->time ? Float<W>::load(a->time + i) : Float<W>(0.f));
      const Rgb<W> kept = zeroUnless(isFinite(v), v);
      kept.x.store(a->value[0] + i);
      if (a->value[1]) kept.y.store(a->value[1] + i);
      if (a->value[2]) kept.z.store(a->value[2] + i);
    }
  }
  template <int W>
  static constexpr VolumeFunctions table() {
    return VolumeFunctions{&evaluate<W>};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif

#include <kinora/simd/tables.h>

// Ends the file of a plug-in, whose struct has its name.
#undef KINORA_VOLUME
#define KINORA_VOLUME(Name, ...) KINORA_PLUGIN(Name, VolumeRunner<Name>, VolumePlugin, __VA_ARGS__)
