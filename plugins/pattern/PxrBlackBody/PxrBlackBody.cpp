// PxrBlackBody: the colour of a black body in Rec. 709: Planck's law times the CIE 1931 observer in the fit of Wyman,
// Sloan and Shirley (JCGT 2013), summed every 10 nm. Lights make theirs of the same law (light_setup.h).
#define KINORA_KERNEL_FILE "plugins/pattern/PxrBlackBody/PxrBlackBody.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kTemperature, kPhysicalIntensity, kExposure };
constexpr Param kParams[] = {
    param::number("temperature", 6500.f).range(1000, 15000).help("Kelvin; kept within 500 to 40000."),
    param::number("physicalIntensity", 0.f)
        .help("0: luminance 1 at any temperature, 1: as bright as Planck's law says, 1 at 6500 kelvin."),
    param::number("exposure", 0.f).range(-4, 4).help("Stops: each one doubles the result."),
    KINORA_COLOR_OUTPUTS,
};

// Every kStep nm from kFirst on: the observer in Rec. 709, times (560 nm / wavelength)^5.
constexpr float kFirst = 355, kStep = 10;
constexpr float kWeights[][3] = {{-0.001477074f, 0.0005620529f, 0.002270422f},
                                 {-0.004904795f, 0.001375267f, 0.008652043f},
                                 {-0.01398491f, 0.002990204f, 0.02842866f},
                                 {-0.02862676f, 0.003824372f, 0.08124634f},
                                 {-0.01634732f, -0.009605815f, 0.2122222f},
                                 {0.1211381f, -0.08261783f, 0.5924001f},
                                 {0.3991123f, -0.2771622f, 1.808087f},
                                 {0.594217f, -0.5698011f, 4.309715f},
                                 {0.7922967f, -0.7914456f, 6.200524f},
                                 {0.7485438f, -0.7134395f, 5.973126f},
                                 {0.2554692f, -0.4330133f, 5.240135f},
                                 {-0.2390153f, -0.08628632f, 4.063405f},
                                 {-0.5089639f, 0.2589389f, 2.480149f},
                                 {-0.7578109f, 0.5919696f, 1.268974f},
                                 {-1.009916f, 0.9244635f, 0.595486f},
                                 {-1.198452f, 1.288195f, 0.2271058f},
                                 {-1.309298f, 1.672271f, 0.002667224f},
                                 {-1.244565f, 1.926101f, -0.1275402f},
                                 {-0.9056165f, 1.898843f, -0.1803958f},
                                 {-0.4150245f, 1.712185f, -0.1901292f},
                                 {0.144737f, 1.434192f, -0.17666f},
                                 {0.701716f, 1.110456f, -0.1513749f},
                                 {1.182681f, 0.7825575f, -0.1214994f},
                                 {1.533508f, 0.4754042f, -0.09060971f},
                                 {1.712135f, 0.2198695f, -0.06234935f},
                                 {1.700161f, 0.0371355f, -0.03923149f},
                                 {1.479856f, -0.05661246f, -0.02300314f},
                                 {1.138214f, -0.08187672f, -0.01288667f},
                                 {0.7787231f, -0.06922572f, -0.00716027f},
                                 {0.4753505f, -0.04436446f, -0.004106536f},
                                 {0.259108f, -0.0223805f, -0.00246446f},
                                 {0.1259997f, -0.008412147f, -0.001508365f},
                                 {0.05449653f, -0.001650686f, -0.0009016923f},
                                 {0.0208342f, 0.0006739574f, -0.0005084023f},
                                 {0.006954117f, 0.0009860194f, -0.0002651529f},
                                 {0.001973956f, 0.0006916792f, -0.000126914f},
                                 {0.000445458f, 0.0003716711f, -5.567973e-05f},
                                 {6.122717e-05f, 0.0001689432f, -2.243539e-05f},
                                 {-7.493929e-06f, 6.764154e-05f, -8.331486e-06f},
                                 {-9.601323e-06f, 2.438106e-05f, -2.862659e-06f},
                                 {-4.547125e-06f, 8.0215e-06f, -9.135867e-07f},
                                 {-1.63622e-06f, 2.432053e-06f, -2.717517e-07f},
                                 {-5.040338e-07f, 6.842129e-07f, -7.556295e-08f}};
// Luminance of the sum at 6500 kelvin.
constexpr float kLuminance6500 = 0.20813336f;

struct PxrBlackBody {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value temperature, physical, exposure;
    explicit Setup(const Context& c)
        : temperature(c.param(kTemperature)), physical(c.param(kPhysicalIntensity)), exposure(c.param(kExposure)) {}
    bool uniform() const { return allUniform({&temperature, &physical, &exposure}); }
  };
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const F kelvin = clamp(loadFloat<W>(s.temperature, at), F(500.f), F(40000.f));
    const F scale = F(-14387769.f) / kelvin;  // -h c / k in nm kelvin
    Rgb<W> c;
    for (uint32_t i = 0; i < std::size(kWeights); ++i) {
      // 1 / (exp(x) - 1) as exp(-x) / (1 - exp(-x)), which cannot overflow
      const F e = exp(scale * F(1.f / (kFirst + kStep * float(i)))), power = e / (F(1.f) - e);
      c = fma(Rgb<W>(F(kWeights[i][0]), F(kWeights[i][1]), F(kWeights[i][2])), power, c);
    }
    c = Rgb<W>(max(c.x, F(0.f)), max(c.y, F(0.f)), max(c.z, F(0.f)));
    const F l = luminance(c), own = F(1.f) / max(l, F(1e-30f));
    const F physical = loadFloat<W>(s.physical, at);
    const F relative = fma(l * F(1.f / kLuminance6500), physical, F(1.f) - physical);
    return c * (own * relative * exp2(loadFloat<W>(s.exposure, at)));
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrBlackBody, .help = "The colour of glowing bodies.", .params = kParams)
