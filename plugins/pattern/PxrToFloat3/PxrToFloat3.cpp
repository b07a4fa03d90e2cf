// PxrToFloat3: three numbers as a colour; where none of them is given, one number in all channels.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrToFloat3/PxrToFloat3.cpp"
#include <kinora/pattern.h>
#include <iterator>
#include <kinora/simd/foreach_target.h>
#include <kinora/pattern_author.h>

#ifndef PXRTOFLOAT3_ONCE
#define PXRTOFLOAT3_ONCE
namespace kinora::pxrToFloat3 {
enum : uint32_t { kInput, kInputR, kInputG, kInputB };
constexpr Param kParams[] = {
    param::number("input", 0.f).help("All channels, where inputR, inputG and inputB are 0 and not connected."),
    param::number("inputR", 0.f).help("Red."),
    param::number("inputG", 0.f).help("Green."),
    param::number("inputB", 0.f).help("Blue."),
    param::output(Type::Color, "resultRGB"),
    param::output(Type::Float, "resultR"),
    param::output(Type::Float, "resultG"),
    param::output(Type::Float, "resultB"),
};
}  // namespace kinora::pxrToFloat3
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using namespace pxrToFloat3;

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

KINORA_POINTWISE_TABLES(PxrToFloat3)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
KINORA_REGISTER_PATTERN(PxrToFloat3, "A colour of three numbers, or of one.", pxrToFloat3::kParams)
#endif
