// GradientDisplayFilter: what the imager gradient of old files (Aqsis, ShaderMan) does: two colours behind the picture,
// one fading into the other from top to bottom. Which place has which share of them follows from that shader's own
// curves: Perlin's bias ("Hypertexture", 1989) for the middle, a smooth step for the sharpness.
#define KINORA_KERNEL_FILE "plugins/displayfilter/GradientDisplayFilter/GradientDisplayFilter.cpp"
#include <kinora/channel_maths.h>

#if KINORA_PLAIN
namespace kinora::gradientDisplayFilter {
constexpr Param kParams[] = {
    param::string("aov", "Ci").help("Channel that gets the background."),
    param::string("aovAlpha", "a")
        .help("Channel that says how much of a pixel is covered; without it nothing is done."),
    param::color("topColor", 0.35f).help("Colour at the top of the picture; scene-linear."),
    param::color("bottomColor", 0.85f).help("Colour at the bottom."),
    param::number("sharpness", 0.f).help("0 fades evenly, 1 makes the change sudden."),
    param::number("midPoint", 0.5f).help("Where the change is, about: part of the way down; 0.5 is the middle."),
    param::number("frequency", 1.f).range(1, 8).help("How often the picture's height holds the whole change."),
    param::number("angle", 0.f)
        .range(-90, 90)
        .help("Degrees by which the change is turned, about the upper left corner."),
    param::number("backgroundAlpha", 1.f)
        .help("Alpha of the background: 1 says that it covers what was empty, 0 leaves the channel as it is."),
};
struct Data : channelMaths::ColorAndAlpha {
  float top[3], range[3], stepX, stepY, power, low, perWidth, sharpness, opacity;
  bool repeats;
  explicit Data(const CreateInfo& info) {
    const NamedValues v(info, kParams, std::size(kParams));
    const auto* picture = static_cast<const ChannelFilterInfo*>(info.extra);
    if (!picture || !picture->resolution[1]) throw "the picture has no pixels";
    aov = v.string("aov");
    alpha = v.string("aovAlpha");
    for (int c = 0; c < 3; ++c) {
      top[c] = float(v.number("topColor", c));
      range[c] = float(v.number("bottomColor", c) - v.number("topColor", c));
    }
    const double turn = v.number("angle") * 3.14159265358979323846 / 180,
                 perHeight = v.number("frequency") / picture->resolution[1];
    stepX = float(std::sin(turn) * perHeight);
    stepY = float(std::cos(turn) * perHeight);
    repeats = v.number("frequency") != 1 || turn != 0;
    power = float(std::log(std::fmin(0.999, std::fmax(0.001, 1 - v.number("midPoint")))) / std::log(0.5));
    sharpness = float(std::fmin(1, std::fmax(0, v.number("sharpness"))));
    low = 0.495f * sharpness;
    perWidth = 1 / (1 - 2 * low);
    opacity = float(v.number("backgroundAlpha"));
  }
};
}  // namespace kinora::gradientDisplayFilter
#endif

KINORA_KERNELS_BEGIN
struct GradientDisplayFilter {
  using Data = gradientDisplayFilter::Data;
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    using F = Float<W>;
    if (!s.has(0) || !s.has(1)) return;
    F down = fma(s.x(), F(k.stepX), s.y() * F(k.stepY));
    if (k.repeats) down = down - floor(down);
    const F share = pow(max(down, F(1e-6f)), F(k.power)),
            t = clamp((share - F(k.low)) * F(k.perWidth), F(0.f), F(1.f)), step = t * t * fnma(F(2.f), t, F(3.f)),
            at = fma(F(k.sharpness), step - share, share), room = max(F(1.f) - s.number(1), F(0.f));
    const Rgb<W> c = s.rgb(0);
    s.set(0, Rgb<W>(fma(room, fma(at, F(k.range[0]), F(k.top[0])), c.x),
                    fma(room, fma(at, F(k.range[1]), F(k.top[1])), c.y),
                    fma(room, fma(at, F(k.range[2]), F(k.top[2])), c.z)));
    if (k.opacity != 0) s.set(1, fma(room, F(k.opacity), s.number(1)));
  }
};
KINORA_KERNELS_END

KINORA_DISPLAY_FILTER(GradientDisplayFilter, .help = "Puts two colours behind the picture, one above the other.",
                      .params = gradientDisplayFilter::kParams, .setUp = setUp<gradientDisplayFilter::Data>,
                      .channel = channelMaths::channelOf<gradientDisplayFilter::Data>)
