// PxrColorGrade: (c - black) / (white - black), times multiply and gain, plus lift and offset, gamma, clamps; mask
// blends from the ungraded colour. The grade of PxrGradeSampleFilter on what a network computes.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrColorGrade/PxrColorGrade.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kInputColor,
  kBlackPoint,
  kWhitePoint,
  kLift,
  kGain,
  kMultiply,
  kOffset,
  kGamma,
  kClampBlack,
  kClampWhite,
  kMask
};
constexpr Param kParams[] = {
    param::color("inputColor", 0.f).help("Colour to grade."),
    param::color("blackPoint", 0.f).help("Becomes black."),
    param::color("whitePoint", 1.f).help("Becomes white."),
    param::color("lift", 0.f).range(-1, 1).help("Added after the gain."),
    param::color("gain", 1.f).range(0, 4).help("Factor."),
    param::color("multiply", 1.f).range(0, 4).help("Factor."),
    param::color("offset", 0.f).range(-1, 1).help("Added after the gain."),
    param::color("gamma", 1.f)
        .range(0.1f, 4)
        .help("The colour becomes itself to the power 1 / gamma; 1 changes nothing."),
    param::integer("clampBlack", 1).range(0, 1).options("0 off, 1 on").help("Cuts negative colours."),
    param::integer("clampWhite", 0).range(0, 1).options("0 off, 1 on").help("Cuts colours above 1."),
    param::color("mask", 1.f).help("0 keeps the colour, 1 grades it."),
    param::output(Type::Color, "resultRGB"),
    param::output(Type::Float, "resultR"),
    param::output(Type::Float, "resultG"),
    param::output(Type::Float, "resultB"),
};

struct PxrColorGrade {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value color, black, white, lift, gain, multiply, offset, gamma, mask;
    bool clampBlack, clampWhite;
    explicit Setup(const Context& c)
        : color(c.param(kInputColor)),
          black(c.param(kBlackPoint)),
          white(c.param(kWhitePoint)),
          lift(c.param(kLift)),
          gain(c.param(kGain)),
          multiply(c.param(kMultiply)),
          offset(c.param(kOffset)),
          gamma(c.param(kGamma)),
          mask(c.param(kMask)),
          clampBlack(fixedInteger(c, kClampBlack) != 0),
          clampWhite(fixedInteger(c, kClampWhite) != 0) {}
    bool uniform() const {
      return allUniform({&color, &black, &white, &lift, &gain, &multiply, &offset, &gamma, &mask});
    }
  };
  template <int W>
  static KN_INLINE Float<W> powered(Float<W> x, Float<W> gamma) {
    using F = Float<W>;
    const F e = F(1.f) / max(gamma, F(1e-3f));
    return select((x > F(0.f)) & (gamma != F(1.f)), pow(max(x, F(1e-30f)), e), x);
  }
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const Rgb<W> in = loadRgb<W>(s.color, at), black = loadRgb<W>(s.black, at), gamma = loadRgb<W>(s.gamma, at);
    const Rgb<W> span = loadRgb<W>(s.white, at) - black;
    // points that meet grade as if they were a millionth apart
    const auto safe = [](F x) { return select(abs(x) < F(1e-6f), F(1e-6f), x); };
    Rgb<W> c = (in - black) * loadRgb<W>(s.multiply, at) * loadRgb<W>(s.gain, at);
    c = Rgb<W>(c.x / safe(span.x), c.y / safe(span.y), c.z / safe(span.z));
    c = c + loadRgb<W>(s.lift, at) + loadRgb<W>(s.offset, at);
    c = Rgb<W>(powered(c.x, gamma.x), powered(c.y, gamma.y), powered(c.z, gamma.z));
    if (s.clampBlack) c = Rgb<W>(max(c.x, F(0.f)), max(c.y, F(0.f)), max(c.z, F(0.f)));
    if (s.clampWhite) c = Rgb<W>(min(c.x, F(1.f)), min(c.y, F(1.f)), min(c.z, F(1.f)));
    return in + (c - in) * loadRgb<W>(s.mask, at);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrColorGrade, .help = "Grades a colour as compositors do.", .params = kParams)
