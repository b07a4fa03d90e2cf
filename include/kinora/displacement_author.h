// The author's layer of displacements; see displacement.h. Included per target, after <kinora/simd/foreach_target.h>.
//
//   struct MyDisplacement {
//     template <int W> static Vec3<W> offset(const Context& c, At at);  // c.param(kAmount), c.P, c.N ... of the object
//   };
//   KINORA_DISPLACEMENT(MyDisplacement, .help = "...", .params = kParams)        // after KINORA_KERNELS_END
#include <kinora/displacement.h>
#ifdef KINORA_KERNEL_FILE
#include <kinora/simd/foreach_target.h>
#endif
#include <kinora/pattern_author.h>

#if defined(KINORA_DISPLACEMENT_AUTHOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_DISPLACEMENT_AUTHOR_H_TARGET
#undef KINORA_DISPLACEMENT_AUTHOR_H_TARGET
#else
#define KINORA_DISPLACEMENT_AUTHOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <class Displacement>
struct DisplacementRunner {
  template <int W>
  static void displace(const Context* c, float* const offset[3]) {
    for (uint32_t i = 0; i < c->padded; i += W) {
      Displacement::template offset<W>(*c, At{i, false}).store(offset, i);
    }
  }
  template <int W>
  static constexpr DisplacementFunctions table() {
    return DisplacementFunctions{&displace<W>};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif

#include <kinora/simd/tables.h>

// Ends the file of a plug-in, whose struct has its name.
#undef KINORA_DISPLACEMENT
#define KINORA_DISPLACEMENT(Name, ...) KINORA_PLUGIN(Name, DisplacementRunner<Name>, DisplacementPlugin, __VA_ARGS__)
