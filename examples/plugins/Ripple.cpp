// A displacement: waves along s.
//   Displace "Ripple" "waves" "float height" [0.2]
#define KINORA_KERNEL_FILE "Ripple.cpp"
#include <kinora/displacement_author.h>
#include <kinora/math/elementary.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kHeight, kFrequency };
constexpr Param kParams[] = {
    param::number("height", 0.1f).help("Of a wave, along the normal."),
    param::number("frequency", 4.f).range(0, 40).help("Waves over s from 0 to 1."),
};

struct Ripple {
  template <int W>
  static KN_INLINE Vec3<W> offset(const Context& c, At at) {
    const Value st = c.builtin(Builtin::St), height = c.param(kHeight), frequency = c.param(kFrequency);
    const Float<W> turns = loadComponent<W>(st, 0, at) * loadFloat<W>(frequency, at);
    return Vec3<W>::load(c.N, at.first) * (loadFloat<W>(height, at) * sin(turns * Float<W>(6.2831853f)));
  }
};

KINORA_KERNELS_END

KINORA_DISPLACEMENT(Ripple, .help = "Waves along the normal.", .params = kParams)
