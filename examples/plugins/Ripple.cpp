// A displacement: waves along s. This version of Kinora finds it, keeps it and does not render it yet.
//   Displace "Ripple" "waves" "float height" [0.2]
#define KINORA_KERNEL_FILE "Ripple.cpp"
#include <kinora/displacement.h>

#include <iterator>

#include <kinora/simd/foreach_target.h>
#include <kinora/displacement_author.h>
#include <kinora/math/elementary.h>

#ifndef RIPPLE_ONCE
#define RIPPLE_ONCE
namespace kinora::ripple {
enum : uint32_t { kHeight, kFrequency };
constexpr Param kParams[] = {
    param::number("height", 0.1f).range(0, 1).help("Of a wave, along the normal."),
    param::number("frequency", 4.f).range(0, 40).help("Waves over s from 0 to 1."),
};
}  // namespace kinora::ripple
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using namespace ripple;
struct Waves {
  template <int W>
  static KN_INLINE Vec3<W> offset(const Context& c, At at) {
    const Value st = c.builtin(Builtin::St), height = c.param(kHeight), frequency = c.param(kFrequency);
    const Float<W> turns = loadComponent<W>(st, 0, at) * loadFloat<W>(frequency, at);
    return Vec3<W>::load(c.N, at.first) * (loadFloat<W>(height, at) * sin(turns * Float<W>(6.2831853f)));
  }
};
using Runner = DisplacementRunner<Waves>;
KINORA_WIDTH_TABLES(Runner, DisplacementFunctions)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora {
namespace {
using namespace ripple;

const WidthTable kTables[] = KINORA_ALL_WIDTHS;
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::Displacement,
                             0,
                             "Ripple",
                             "Waves along the normal.",
                             kParams,
                             uint32_t(std::size(kParams)),
                             kTables,
                             4,
                             nullptr,
                             nullptr,
                             nullptr};
}  // namespace
KINORA_REGISTER(Ripple, kDescriptor)
}  // namespace kinora
#endif
