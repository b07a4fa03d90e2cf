// PxrCross: the vector product, by default of unit length; parallel vectors give 0 0 0.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrCross/PxrCross.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kVector1, kVector2, kNormalizeResult };
constexpr Param kParams[] = {
    param::vector("vector1", 0, 0, 0).help("First factor."),
    param::vector("vector2", 0, 0, 0).help("Second factor."),
    param::flag("normalizeResult", true).help("1: the result has length 1, or 0 where there is none."),
    param::output(Type::Vector, "resultXYZ"),
    param::output(Type::Float, "resultX"),
    param::output(Type::Float, "resultY"),
    param::output(Type::Float, "resultZ"),
};

struct PxrCross {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value a, b;
    bool unit;
    explicit Setup(const Context& c)
        : a(c.param(kVector1)), b(c.param(kVector2)), unit(fixedInteger(c, kNormalizeResult) != 0) {}
    bool uniform() const { return allUniform({&a, &b}); }
  };
  template <int W>
  static KN_INLINE Vec3<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const Vec3<W> v = cross(loadVec<W>(s.a, at), loadVec<W>(s.b, at));
    if (!s.unit) return v;
    const F l = length(v);
    return v * select(l > F(0.f), F(1.f) / max(l, F(1e-30f)), F(0.f));
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrCross, .help = "The cross product of two vectors.", .params = kParams)
