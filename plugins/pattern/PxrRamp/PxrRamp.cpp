// PxrRamp: a spline of colours over texture coordinates or over a number of its own.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrRamp/PxrRamp.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>
#include <kinora/math/noise.h>
#include <kinora/math/ramp.h>

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kRampType,
  kTile,
  kReverse,
  kSplineMap,
  kRandomSource,
  kRandomSeed,
  kManifold,
  kColorRamp,
  kKnots,
  kColors,
  kInterpolation,
  kPositions,
  kOldColors,
  kBasis
};
constexpr float kDefaultKnots[] = {0, 0, 1, 1};
constexpr float kDefaultColors[] = {0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1};
constexpr Param kParams[] = {
    param::integer("rampType", 0)
        .range(0, 7)
        .options("0 s, 1 t, 2 diagonal, 3 angle, 4 distance from the middle, 5 box, 6 splineMap, 7 random by object")
        .help("What runs along the ramp."),
    param::flag("tile", false).help("1: the ramp repeats beyond 0..1."),
    param::flag("reverse", false).help("1: from the other end."),
    structural(param::number("splineMap", 0.f))
        .help("Place on the ramp, where rampType is 6 a pattern is connected here, or it is not 0."),
    param::integer("randomSource", 0).options("0 object, 1 object").help("What picks a random place: the object."),
    param::integer("randomSeed", 0).range(0, 1000).help("Another set of random places."),
    param::structure("manifold").help("Texture coordinates; st where not connected."),
    param::integer("colorRamp", 4).range(0, 64).help("Number of knots; the arrays' lengths count."),
    param::array(Type::Float, "colorRamp_Knots", kDefaultKnots, 4).help("Places of the colours, ascending."),
    param::array(Type::Color, "colorRamp_Colors", kDefaultColors, 12).help("Colours at the knots."),
    param::string("colorRamp_Interpolation", "catmull-rom")
        .options("linear|catmull-rom|bspline|constant")
        .help("Curve between the knots."),
    param::array(Type::Float, "positions", nullptr, 0).help("Former name of colorRamp_Knots."),
    param::array(Type::Color, "colors", nullptr, 0).help("Former name of colorRamp_Colors."),
    param::integer("basis", 4)
        .range(0, 4)
        .options("0 by colorRamp_Interpolation, 1 constant, 2 linear, 3 bspline, 4 catmull-rom")
        .help("Curve, where positions and colors are used."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrRamp {
  static constexpr uint32_t kComponents = 3;
  static constexpr uint32_t kMaxKnots = 256;
  struct Setup {
    Manifold m;
    Value map, object;
    int type;
    bool tile, reverse, mapped;
    uint32_t seed;
    RampKnots ramp;
    explicit Setup(const Context& c) : m(surfaceManifold(c, kManifold)), map(c.param(kSplineMap)) {
      type = fixedInteger(c, kRampType);
      tile = fixedInteger(c, kTile) != 0;
      reverse = fixedInteger(c, kReverse) != 0;
      // what is connected counts whatever it is; a number that the scene says may be what every scene says
      mapped = type == 6 || c.isConnected(kSplineMap) || (map.uniform() && map.data[0][0] != 0.f);
      seed = uint32_t(fixedInteger(c, kRandomSeed));
      if (type == 7) object = c.builtin(Builtin::ObjectId);
      const float *places = nullptr, *colors = nullptr;
      uint32_t n = c.fn->list(&c, kPositions, &places), floats = c.fn->list(&c, kOldColors, &colors);
      if (n && floats >= 3) {
        const int basis = fixedInteger(c, kBasis);
        ramp.curve = basis == 0   ? rampCurveOf(c.fn->text(&c, kInterpolation), RampCurve::CatmullRom)
                     : basis == 1 ? RampCurve::Constant
                     : basis == 2 ? RampCurve::Linear
                     : basis == 3 ? RampCurve::Bspline
                                  : RampCurve::CatmullRom;
      } else {
        n = c.fn->list(&c, kKnots, &places);
        floats = c.fn->list(&c, kColors, &colors);
        ramp.curve = rampCurveOf(c.fn->text(&c, kInterpolation), RampCurve::CatmullRom);
      }
      n = n < floats / 3 ? n : floats / 3;
      ramp.count = int(n < kMaxKnots ? n : kMaxKnots);
      ramp.knots = places;
      for (uint32_t k = 0; k < 3; ++k) {
        float* channel = c.alloc<float>(size_t(ramp.count) + 1);
        for (int i = 0; i < ramp.count; ++i) channel[i] = colors[3 * i + int(k)];
        ramp.rgb[k] = channel;
      }
    }
    bool uniform() const {
      return mapped ? map.uniform() : type == 7 ? object.uniform() : allUniform({&m.q, &m.radius});
    }
  };
  template <int W>
  static KN_INLINE Float<W> place(const Setup& s, At at) {
    using F = Float<W>;
    if (s.mapped) return loadFloat<W>(s.map, at);
    if (s.type == 7) {
      const Int<W> id = toInt(loadFloat<W>(s.object, at));
      return toUnitFloat(hashLattice(id, Int<W>(s.seed), Int<W>(0), 0x9d2c5681u));
    }
    const F u = loadComponent<W>(s.m.q, 0, at), v = loadComponent<W>(s.m.q, 1, at);
    const F x = fraction(u) - F(0.5f), y = fraction(v) - F(0.5f);
    switch (s.type) {
      case 1:
        return v;
      case 2:
        return (u + v) * F(0.5f);
      case 3:
        return fraction(atan2(y, x) * F(kInvTwoPi));
      case 4:
        return sqrt(fma(x, x, y * y)) * F(2.f);
      case 5:
        return max(abs(x), abs(y)) * F(2.f);
      default:
        return u;
    }
  }
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    using F = Float<W>;
    if (s.ramp.count == 0) return Rgb<W>();
    F x = place<W>(s, at);
    if (s.tile) x = fraction(x);
    if (s.reverse) x = F(1.f) - x;
    return rampAt(s.ramp, x);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrRamp, .help = "Colours along a line, a circle, an angle or a number.", .params = kParams)
