// PxrColorGrade: (c - black) / (white - black), times multiply and gain, plus lift and offset, gamma, clamps; mask
// blends from the ungraded colour. The grade of PxrGradeSampleFilter on what a network computes.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrColorGrade/PxrColorGrade.cpp"
#include <kinora/grade_params.h>
#include <kinora/named_values.h>
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
constexpr std::array kInput = {param::color("inputColor", 0.f).help("Colour to grade.")};
constexpr std::array kOutputs = {
    KINORA_COLOR_OUTPUTS,
};
constexpr auto kParams = joinParams(kInput, gradeParams::kGrade, kOutputs);

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
