// PxrChecker: unit squares (or cubes) of two colours. The edges are box-filtered over the footprint in closed form,
// so that the pattern fades to the mean of both colours with distance.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrChecker/PxrChecker.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kColorA, kColorB, kDimensions, kManifold };
constexpr Param kParams[] = {
    param::color("colorA", 1.f).help("Colour of the square at the origin."),
    param::color("colorB", 0.f).help("Colour of its neighbours."),
    param::integer("dimensions", 2)
        .range(2, 3)
        .options("2 squares, 3 cubes")
        .help("Squares, or cubes of a 3D manifold."),
    param::structure("manifold").help("Position; st where not connected."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrChecker {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value a, b;
    Manifold m;
    bool solid;
    explicit Setup(const Context& c) : a(c.param(kColorA)), b(c.param(kColorB)), m(surfaceManifold(c, kManifold)) {
      solid = fixedInteger(c, kDimensions) == 3 && m.dimensions > 2;
    }
    bool uniform() const { return allUniform({&a, &b, &m.q, &m.radius}); }
  };
  // Integral from 0 of the square wave that is 1 on [0, 1) and -1 on [1, 2): a triangle wave.
  template <int W>
  static KN_INLINE Float<W> triangle(Float<W> x) {
    const Float<W> u = fraction(x * Float<W>(0.5f)) * Float<W>(2.f);
    return Float<W>(1.f) - abs(u - Float<W>(1.f));
  }
  // The square wave averaged over [x - r, x + r].
  template <int W>
  static KN_INLINE Float<W> wave(Float<W> x, Float<W> r) {
    using F = Float<W>;
    const F u = fraction(x * F(0.5f)) * F(2.f), inCell = fraction(x);
    const F edge = min(inCell, F(1.f) - inCell), sign = select(u < F(1.f), F(1.f), F(-1.f));
    // a narrow window meets one edge at most; differences of the integral would cancel there
    const F narrow = sign * min(edge / max(r, F(1e-20f)), F(1.f));
    const F wide = (triangle(x + r) - triangle(x - r)) / max(r + r, F(1e-20f));
    return select(r <= F(0.5f), narrow, wide);
  }
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const Vec3<W> p = loadPosition<W>(s.m, at);
    const F r = abs(loadFloat<W>(s.m.radius, at));
    F product = wave(p.x, r) * wave(p.y, r);
    if (s.solid) product = product * wave(p.z, r);
    return lerp(loadRgb<W>(s.b, at), loadRgb<W>(s.a, at), fma(product, F(0.5f), F(0.5f)));
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrChecker, .help = "A chequered pattern of two colours.", .params = kParams)
