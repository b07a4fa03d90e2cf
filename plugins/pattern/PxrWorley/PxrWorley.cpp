// PxrWorley: distances to the nearest and second nearest of points scattered one a lattice cell (Worley, "A Cellular
// Texture Basis Function", SIGGRAPH 1996), mixed by c1 and c2. With points at most half a cell off the middle the
// nearest two lie in the 27 cells around by the Euclidean metric but for rare misses of the second, which all
// implementations of the kind share.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrWorley/PxrWorley.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/noise.h>

#include "plugins/pattern/cells/cells.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kFrequency,
  kMetric,
  kJitter,
  kC1,
  kC2,
  kExponent,
  kShape,
  kClamp,
  kInvert,
  kRandomScale,
  kRandomScaleCenter,
  kManifold
};
constexpr Param kParams[] = {
    param::number("frequency", 4.f).range(0.1f, 32).help("Cells per unit."),
    param::integer("distancemetric", 0)
        .range(0, 3)
        .options("0 Euclidean, 1 Manhattan, 2 Chebyshev, 3 Minkowski")
        .help("How distances are measured."),
    param::number("jitter", 0.75f).help("0: points at the middle of cells, 1: anywhere in them."),
    param::number("c1", 0.8f).range(-2, 2).help("Factor of the distance to the nearest point."),
    param::number("c2", -0.2f).range(-2, 2).help("Factor of the distance to the second nearest point."),
    param::number("minkowskiExponent", 4.f).range(0.5f, 16).help("Exponent of metric 3."),
    param::integer("shape", 0).options("0 distances, 1 a value for each cell").help("What is shown."),
    param::flag("clamp", true).help("1: the result is kept in 0 to 1."),
    param::flag("invert", false).help("1: one less the result."),
    param::number("randomScale", 0.f).help("How much distances of each point are scaled at random."),
    param::number("randomScaleCenter", 0.f).help("Where in that range the scale 1 lies."),
    param::structure("manifold").help("Position; the surface's in object space where not connected."),
    param::output(Type::Float, "resultF"),
    KINORA_COLOR_OUTPUTS,
};

struct PxrWorley {
  static constexpr uint32_t kComponents = 1;
  struct Setup {
    Value frequency, jitter, c1, c2, exponent, scale, scaleCenter;
    Manifold m;
    int metric, shape;
    bool clamped, inverted;
    explicit Setup(const Context& c)
        : frequency(c.param(kFrequency)),
          jitter(c.param(kJitter)),
          c1(c.param(kC1)),
          c2(c.param(kC2)),
          exponent(c.param(kExponent)),
          scale(c.param(kRandomScale)),
          scaleCenter(c.param(kRandomScaleCenter)),
          m(spaceManifold(c, kManifold)),
          metric(fixedInteger(c, kMetric)),
          shape(fixedInteger(c, kShape)),
          clamped(fixedInteger(c, kClamp) != 0),
          inverted(fixedInteger(c, kInvert) != 0) {}
    bool uniform() const {
      return allUniform({&frequency, &jitter, &c1, &c2, &exponent, &scale, &scaleCenter, &m.q});
    }
  };
  template <int W>
  static KN_INLINE Float<W> distance(int metric, Vec3<W> d, Float<W> exponent) {
    using F = Float<W>;
    const Vec3<W> a(abs(d.x), abs(d.y), abs(d.z));
    if (metric == 1) return a.x + a.y + a.z;
    if (metric == 2) return maxComponent(a);
    if (metric == 3)
      return pow(max(pow(a.x, exponent) + pow(a.y, exponent) + pow(a.z, exponent), F(1e-30f)), F(1.f) / exponent);
    return length(d);
  }
  template <int W>
  static KN_INLINE Vec3<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const F zero(0.f), one(1.f);
    const Vec3<W> p = loadPosition<W>(s.m, at) * loadFloat<W>(s.frequency, at);
    const F jitter = clamp(loadFloat<W>(s.jitter, at), zero, one);
    const F exponent = max(loadFloat<W>(s.exponent, at), F(0.1f));
    const F spread = loadFloat<W>(s.scale, at), center = loadFloat<W>(s.scaleCenter, at);
    F first(1e30f), second(1e30f), value(0.f);
    forCellPoints(p, jitter, s.m.dimensions > 2, 0x51ed270bu, [&](Vec3<W> d, Int<W> bits) {
      const F own = toUnitFloat(bits);
      const F l = distance<W>(s.metric, d, exponent) * max(fma(spread, own - center, one), F(0.01f));
      const Mask<W> nearer = l < first;
      second = select(nearer, first, min(second, l));
      value = select(nearer, own, value);
      first = select(nearer, l, first);
    });
    F r = s.shape == 1 ? value : fma(loadFloat<W>(s.c1, at), first, loadFloat<W>(s.c2, at) * second);
    if (s.clamped) r = clamp(r, zero, one);
    if (s.inverted) r = one - r;
    return Vec3<W>(r, r, r);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrWorley, .help = "Distances to scattered points: cells, cracks, pebbles.", .params = kParams)
