// PxrBlack: absorbs all light. For hold-outs and objects that only cast shadows; presence is always 1.
#define KINORA_KERNEL_FILE "plugins/bxdf/PxrBlack/PxrBlack.cpp"
#include <kinora/bxdf.h>
#include <new>
#include <kinora/simd/foreach_target.h>
#include <kinora/bxdf_author.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

struct PxrBlack {
  struct Closure {};
  static void begin(const Context&, Closure&) {}
  template <int W>
  struct Lanes {
    KN_INLINE Lanes(const Closure&, const Surface<W>&) {}
    KN_INLINE void evaluate(Vec3<W>, LobeSum<W>&) const {}
    KN_INLINE void sample(Float<W>, Float<W>, Float<W>, LobeSample<W>& out) const {
      out.wi = Vec3<W>(Float<W>(0.f), Float<W>(0.f), Float<W>(1.f));
      out.valid = out.discrete = Mask<W>(false);
    }
    KN_INLINE Rgb<W> albedo() const { return Rgb<W>(); }
  };
};

using Runner = BxdfRunner<PxrBlack>;
KINORA_WIDTH_TABLES(Runner, BxdfFunctions)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora {
namespace {
const char* const kConserving[] = {"", nullptr};
constexpr BxdfTraits kTraits{nullptr, 0, -1, nullptr, nullptr, nullptr, kConserving};
const WidthTable kTables[] = KINORA_ALL_WIDTHS;
const Descriptor kDescriptor{
    kAbiVersion, sizeof(Descriptor), Kind::Bxdf, 0,      "PxrBlack", "Absorbs all light.", nullptr, 0, kTables,
    4,           &kTraits,           nullptr,    nullptr};
}  // namespace
KINORA_REGISTER(PxrBlack, kDescriptor)
}  // namespace kinora
#endif
