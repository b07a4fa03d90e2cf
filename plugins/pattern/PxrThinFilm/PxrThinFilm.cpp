// PxrThinFilm: what a thin film reflects, in six bands of 50 nm. The two reflections of the film travel
// 2 eta d cos(theta) apart, one of them turned by half a wave, so that a band is seen as (1 - cos(phase)) / 2; a film
// whose thickness spreads (and a band has a width) fades towards 1/2.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrThinFilm/PxrThinFilm.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputRGB, kEta, kSpread, kThickness, kThicknessScale, kFrontOnly };
constexpr Param kParams[] = {
    param::color("inputRGB", 1.f).help("Factor of the film's colour."),
    param::number("eta", 1.5f).range(1, 4).help("Index of refraction of the film."),
    param::number("spread", 0.01f).help("Deviation of the thickness, as a fraction of it: greyer where larger."),
    param::number("thickness", 1896.f).range(0, 5000).help("Of the film, nanometres."),
    param::number("thicknessScale", 1.f).range(0, 4).help("Factor of the thickness."),
    param::flag("frontOnly", false).help("1: seen from inside the result is inputRGB."),
    KINORA_COLOR_OUTPUTS,
};

// The bands' shares of red, green and blue light in Rec. 709 (CIE 1931 observer, fit of Wyman, Sloan and Shirley),
// which sum to 1.
constexpr float kShares[6][3] = {{0.05636f, -0.06584f, 0.54300f},  {-0.08919f, 0.07104f, 0.56808f},
                                 {-0.27570f, 0.61547f, -0.02666f}, {0.50219f, 0.42414f, -0.06856f},
                                 {0.72074f, -0.03791f, -0.01446f}, {0.08560f, -0.00690f, -0.00140f}};
constexpr float kShortest = 425, kBand = 50;  // nm: middle of the first, width

struct PxrThinFilm {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value color, eta, spread, thickness, scale;
    const Context& c;
    bool frontOnly;
    explicit Setup(const Context& context)
        : color(context.param(kInputRGB)),
          eta(context.param(kEta)),
          spread(context.param(kSpread)),
          thickness(context.param(kThickness)),
          scale(context.param(kThicknessScale)),
          c(context),
          frontOnly(fixedInteger(context, kFrontOnly) != 0) {}
    bool uniform() const { return false; }
  };
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const Rgb<W> color = loadRgb<W>(s.color, at);
    const F eta = max(loadFloat<W>(s.eta, at), F(1.f)), spread = loadFloat<W>(s.spread, at);
    const F cosine = clamp(abs(dot(loadVec<W>(s.c.N, at), loadVec<W>(s.c.wo, at))), F(0.f), F(1.f));
    const F inside = safeSqrt(F(1.f) - fnma(cosine, cosine, F(1.f)) / (eta * eta));
    const F detour = F(2.f) * eta * loadFloat<W>(s.thickness, at) * loadFloat<W>(s.scale, at) * inside;
    Rgb<W> film;
    for (uint32_t b = 0; b < 6; ++b) {
      const float nm = kShortest + kBand * float(b);
      const F phase = detour * F(2 * kPi / nm), off = phase * spread;
      F sine, wave;
      sincos(phase, sine, wave);
      const F seen = fnma(wave * exp(off * off * F(-0.5f)), F(0.5f), F(0.5f));
      film = fma(Rgb<W>(F(kShares[b][0]), F(kShares[b][1]), F(kShares[b][2])), seen, film);
    }
    film = Rgb<W>(max(film.x, F(0.f)), max(film.y, F(0.f)), max(film.z, F(0.f))) * color;
    if (!s.frontOnly) return film;
    return select(loadInt<W>(s.c.entering, at) != Int<W>(0), film, color);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrThinFilm, .help = "Colours of soap bubbles and oil films.", .params = kParams)
