// ClampDisplayFilter: what the imagers clamp and clamptoalpha of old files do: colours and alpha are cut to 0..1, and,
// for programs that take a colour above its alpha for a mistake, colours to alpha.
#define KINORA_KERNEL_FILE "plugins/displayfilter/ClampDisplayFilter/ClampDisplayFilter.cpp"
#include <kinora/channel_maths.h>

#if KINORA_PLAIN
namespace kinora::clampDisplayFilter {
constexpr Param kParams[] = {
    param::string("aov", "Ci").help("Channel that is cut."),
    param::string("aovAlpha", "a")
        .help("Channel of alpha, which is cut to 0..1; colours may not exceed it in mode 1."),
    param::integer("mode", 0)
        .options("0 to 0..1, 1 to alpha")
        .help("Where colours end; 1 without an alpha channel counts as 0."),
};
struct Data : channelMaths::ColorAndAlpha {
  bool toAlpha;
  explicit Data(const CreateInfo& info) {
    const NamedValues v(info, kParams, std::size(kParams));
    aov = v.string("aov");
    alpha = v.string("aovAlpha");
    toAlpha = v.integer("mode") != 0;
  }
};
}  // namespace kinora::clampDisplayFilter
#endif

KINORA_KERNELS_BEGIN
struct ClampDisplayFilter {
  using Data = clampDisplayFilter::Data;
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    using F = Float<W>;
    const F zero(0.f);
    F most(1.f);
    if (s.has(1)) {
      const F alpha = clamp(s.number(1), zero, most);
      s.set(1, alpha);
      if (k.toAlpha) most = alpha;
    }
    if (!s.has(0)) return;
    const Rgb<W> c = s.rgb(0);
    s.set(0, Rgb<W>(clamp(c.x, zero, most), clamp(c.y, zero, most), clamp(c.z, zero, most)));
  }
};
KINORA_KERNELS_END

KINORA_DISPLAY_FILTER(ClampDisplayFilter, .help = "Cuts colours to 0..1 or to alpha.",
                      .params = clampDisplayFilter::kParams, .setUp = setUp<clampDisplayFilter::Data>,
                      .channel = channelMaths::channelOf<clampDisplayFilter::Data>)
