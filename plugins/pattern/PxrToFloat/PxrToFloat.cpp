// PxrToFloat: a channel of a colour, or the mean or luminance of all.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrToFloat/PxrToFloat.cpp"
#include <kinora/pattern.h>
#include <iterator>
#include <kinora/simd/foreach_target.h>
#include <kinora/math/color.h>
#include <kinora/pattern_author.h>

#ifndef PXRTOFLOAT_ONCE
#define PXRTOFLOAT_ONCE
namespace kinora::pxrToFloat {
enum : uint32_t { kInput, kMode };
constexpr Param kParams[] = {
    param::color("input", 0.f).help("Colour to read."),
    param::integer("mode", 0)
        .range(0, 4)
        .options("0 red, 1 green, 2 blue, 3 mean, 4 luminance")
        .help("What is read."),
    param::output(Type::Float, "resultF"),
};
}  // namespace kinora::pxrToFloat
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using namespace pxrToFloat;

struct PxrToFloat {
  static constexpr uint32_t kComponents = 1;
  struct Setup {
    Value color;
    int mode;
    explicit Setup(const Context& c) : color(c.param(kInput)) { mode = fixedInteger(c, kMode); }
    bool uniform() const { return allUniform({&color}); }
  };
  template <int W>
  static KN_INLINE Vec3<W> at(const Setup& s, At at) {
    const Rgb<W> c = loadRgb<W>(s.color, at);
    switch (s.mode) {
      case 1:
        return grey(c.y);
      case 2:
        return grey(c.z);
      case 3:
        return grey(average(c));
      case 4:
        return grey(luminance(c));
      default:
        return grey(c.x);
    }
  }
};

KINORA_POINTWISE_TABLES(PxrToFloat)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
KINORA_REGISTER_PATTERN(PxrToFloat, "One number of a colour.", pxrToFloat::kParams)
#endif
