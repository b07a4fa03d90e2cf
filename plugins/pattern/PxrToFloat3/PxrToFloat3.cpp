// PxrToFloat3: three numbers as a colour; where none of them is given, one number in all channels.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrToFloat3/PxrToFloat3.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInput, kInputR, kInputG, kInputB };
constexpr Param kParams[] = {
    param::number("input", 0.f).help("All channels, where inputR, inputG and inputB are 0 and not connected."),
    param::number("inputR", 0.f).help("Red."),
    param::number("inputG", 0.f).help("Green."),
    param::number("inputB", 0.f).help("Blue."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrToFloat3 {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value all, r, g, b;
    explicit Setup(const Context& c)
        : all(c.param(kInput)), r(c.param(kInputR)), g(c.param(kInputG)), b(c.param(kInputB)) {}
    bool uniform() const { return allUniform({&all, &r, &g, &b}); }
  };
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const F one = loadFloat<W>(s.all, at);
    const Rgb<W> v(loadFloat<W>(s.r, at), loadFloat<W>(s.g, at), loadFloat<W>(s.b, at));
    return select((v.x == F(0.f)) & (v.y == F(0.f)) & (v.z == F(0.f)), Rgb<W>(one, one, one), v);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrToFloat3, .help = "A colour of three numbers, or of one.", .params = kParams)
