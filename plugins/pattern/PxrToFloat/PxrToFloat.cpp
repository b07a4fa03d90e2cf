// PxrToFloat: a channel of a colour, or the mean or luminance of all.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrToFloat/PxrToFloat.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInput, kMode };
constexpr Param kParams[] = {
    param::color("input", 0.f).help("Colour to read."),
    param::integer("mode", 0)
        .range(0, 4)
        .options("0 red, 1 green, 2 blue, 3 mean, 4 luminance")
        .help("What is read."),
    param::output(Type::Float, "resultF"),
};

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

KINORA_KERNELS_END

KINORA_PATTERN(PxrToFloat, .help = "One number of a colour.", .params = kParams)
