// PxrRamp: a spline of colours over texture coordinates or over a number of its own. Two neighbouring knots make a
// piece; repeated knots at the ends, as exporters write them, are the outer control points of the cubic splines.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrRamp/PxrRamp.cpp"
#include <cstring>
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>
#include <kinora/math/noise.h>

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
    param::integer("tile", 0).range(0, 1).help("1: the ramp repeats beyond 0..1."),
    param::integer("reverse", 0).range(0, 1).help("1: from the other end."),
    param::number("splineMap", 0.f).help("Place on the ramp, where rampType is 6 or a pattern is connected here."),
    param::integer("randomSource", 0)
        .range(0, 1)
        .options("0 object, 1 object")
        .help("What picks a random place: the object."),
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
    param::output(Type::Color, "resultRGB"),
    param::output(Type::Float, "resultR"),
    param::output(Type::Float, "resultG"),
    param::output(Type::Float, "resultB"),
};

enum class Curve { Constant, Linear, Bspline, CatmullRom };

struct PxrRamp {
  static constexpr uint32_t kComponents = 3;
  static constexpr uint32_t kMaxKnots = 256;
  struct Setup {
    Manifold m;
    Value map, object;
    int type, count = 0;
    bool tile, reverse, mapped;
    uint32_t seed;
    const float* knots = nullptr;
    float* rgb[3] = {nullptr, nullptr, nullptr};
    Curve curve = Curve::CatmullRom;
    explicit Setup(const Context& c) : m(surfaceManifold(c, kManifold)), map(c.param(kSplineMap)) {
      type = fixedInteger(c, kRampType);
      tile = fixedInteger(c, kTile) != 0;
      reverse = fixedInteger(c, kReverse) != 0;
      mapped = type == 6 || !map.uniform() || map.data[0][0] != 0.f;
      seed = uint32_t(fixedInteger(c, kRandomSeed));
      if (type == 7) object = c.builtin(Builtin::ObjectId);
      const float *places = nullptr, *colors = nullptr;
      uint32_t n = c.fn->list(&c, kPositions, &places), floats = c.fn->list(&c, kOldColors, &colors);
      if (n && floats >= 3) {
        const int basis = fixedInteger(c, kBasis);
        curve = basis == 1   ? Curve::Constant
                : basis == 2 ? Curve::Linear
                : basis == 3 ? Curve::Bspline
                             : Curve::CatmullRom;
      } else {
        n = c.fn->list(&c, kKnots, &places);
        floats = c.fn->list(&c, kColors, &colors);
        const char* name = c.fn->text(&c, kInterpolation);
        if (!std::strcmp(name, "linear")) curve = Curve::Linear;
        if (!std::strcmp(name, "bspline")) curve = Curve::Bspline;
        if (!std::strcmp(name, "constant")) curve = Curve::Constant;
      }
      n = n < floats / 3 ? n : floats / 3;
      count = int(n < kMaxKnots ? n : kMaxKnots);
      knots = places;
      for (uint32_t k = 0; k < 3; ++k) {
        rgb[k] = c.alloc<float>(size_t(count) + 1);
        for (int i = 0; i < count; ++i) rgb[k][i] = colors[3 * i + int(k)];
      }
    }
    bool uniform() const {
      return mapped ? map.uniform() : type == 7 ? object.uniform() : allUniform({&m.q, &m.radius});
    }
  };
  template <int W>
  static KN_INLINE Rgb<W> colorAt(const Setup& s, Int<W> i) {
    const Int<W> last(s.count - 1), j = select(i > last, last, select(i < Int<W>(0), Int<W>(0), i));
    return {gather(s.rgb[0], j), gather(s.rgb[1], j), gather(s.rgb[2], j)};
  }
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
    using I = Int<W>;
    if (s.count == 0) return Rgb<W>();
    F x = place<W>(s, at);
    if (s.tile) x = fraction(x);
    if (s.reverse) x = F(1.f) - x;
    x = clamp(x, F(s.knots[0]), F(s.knots[s.count - 1]));
    // the last knot at or before x; pieces between repeated knots are empty and never chosen, but at the upper end
    I i(0);
    F from(s.knots[0]), to(s.knots[s.count > 1 ? 1 : 0]);
    for (int k = 1; k + 1 < s.count; ++k) {
      const Mask<W> here = (x >= F(s.knots[k])) & (F(s.knots[k + 1]) > F(s.knots[k]));
      i = select(here, I(k), i);
      from = select(here, F(s.knots[k]), from);
      to = select(here, F(s.knots[k + 1]), to);
    }
    const F span = to - from;
    const F t = select(span > F(0.f), clamp((x - from) / max(span, F(1e-20f)), F(0.f), F(1.f)), F(0.f));
    const Rgb<W> b = colorAt<W>(s, i), c = colorAt<W>(s, i + I(1));
    if (s.curve == Curve::Constant) return b;
    if (s.curve == Curve::Linear) return lerp(b, c, t);
    const Rgb<W> a = colorAt<W>(s, i - I(1)), d = colorAt<W>(s, i + I(2));
    const F t2 = t * t, t3 = t2 * t;
    if (s.curve == Curve::Bspline) {
      const F u = F(1.f) - t, sixth(1.f / 6.f);
      const F wb = fma(F(3.f), t3, fma(F(-6.f), t2, F(4.f))), wc = fma(F(3.f), t + t2 - t3, F(1.f));
      return (a * (u * u * u) + b * wb + c * wc + d * t3) * sixth;
    }
    const F half(0.5f);
    const F wa = fma(F(2.f), t2, -t3 - t), wb = fma(F(3.f), t3, fma(F(-5.f), t2, F(2.f)));
    const F wc = fma(F(-3.f), t3, fma(F(4.f), t2, t)), wd = t3 - t2;
    return (a * wa + b * wb + c * wc + d * wd) * half;
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrRamp, .help = "Colours along a line, a circle, an angle or a number.", .params = kParams)
