// PxrLightSaturation: changes the saturation of colours where a light reaches, or where it does not; which that is a
// channel of the light's direct light says.
#define KINORA_KERNEL_FILE "plugins/displayfilter/PxrLightSaturation/PxrLightSaturation.cpp"
#include <kinora/channel_maths.h>

#if KINORA_PLAIN
namespace kinora::pxrLightSaturation {
constexpr std::array kParams = {
    channelMaths::kAov,
    param::string("light", "").help("Channel of the light's direct light, e.g. of the expression C[DS]<L.'key'>."),
    param::number("threshold", 1.f).range(0, 2).help("Where its luminance is below this, there is shadow."),
    param::integer("invert", 0).options("0 lit, 1 shadow").help("Which part changes."),
    param::number("shift", 1.f)
        .range(-2, 2)
        .help("Saturation is multiplied by 2 to this power: above 0 more colour, below 0 less."),
};
struct Data {
  std::string aov, light;
  float threshold, scale;
  bool inShadow;
  explicit Data(const CreateInfo& info) {
    const NamedValues v(info, kParams.data(), kParams.size());
    aov = v.string("aov");
    light = v.string("light");
    threshold = float(v.number("threshold"));
    scale = float(std::exp2(std::fmin(20, std::fmax(-20, v.number("shift")))));
    inShadow = v.integer("invert") != 0;
  }
  const char* channel(uint32_t i) const { return i == 0 ? aov.c_str() : i == 1 ? light.c_str() : nullptr; }
};
}  // namespace kinora::pxrLightSaturation
#endif

KINORA_KERNELS_BEGIN
struct PxrLightSaturation {
  using Data = pxrLightSaturation::Data;
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    using F = Float<W>;
    if (!s.has(0) || !s.has(1)) return;
    const Mask<W> dark = luminance(s.rgb(1)) < F(k.threshold);
    const F scale = select(k.inShadow ? dark : !dark, F(k.scale), F(1.f));
    const Rgb<W> c = s.rgb(0);
    const F grey = luminance(c);
    s.set(0, Rgb<W>(fma(scale, c.x - grey, grey), fma(scale, c.y - grey, grey), fma(scale, c.z - grey, grey)));
  }
};
KINORA_KERNELS_END

KINORA_DISPLAY_FILTER(PxrLightSaturation, .help = "Changes the saturation where a light reaches or does not.",
                      .params = pxrLightSaturation::kParams, .setUp = setUp<pxrLightSaturation::Data>,
                      .channel = channelMaths::channelOf<pxrLightSaturation::Data>)
