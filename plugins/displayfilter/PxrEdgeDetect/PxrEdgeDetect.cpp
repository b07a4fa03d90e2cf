// PxrEdgeDetect: a channel becomes the length of its gradient over the picture, by I. Sobel's operator over the pixels
// around, of each colour by itself. In a ramp that rises by x a pixel it is x; beside a step of 1 it is a half.
#define KINORA_KERNEL_FILE "plugins/displayfilter/PxrEdgeDetect/PxrEdgeDetect.cpp"
#include <kinora/channel_maths.h>

#if KINORA_PLAIN
namespace kinora::pxrEdgeDetect {
constexpr std::array kParams = {channelMaths::kAov};
struct Data {
  std::string aov;
  explicit Data(const CreateInfo& info) : aov(NamedValues(info, kParams.data(), kParams.size()).string("aov")) {}
  const char* channel(uint32_t i) const { return i == 0 ? aov.c_str() : nullptr; }
};
}  // namespace kinora::pxrEdgeDetect
#endif

KINORA_KERNELS_BEGIN
struct PxrEdgeDetect {
  using Data = pxrEdgeDetect::Data;
  template <int W>
  static KN_INLINE void filter(const Data&, const ChannelSpan<W>& s) {
    using F = Float<W>;
    if (!s.has(0)) return;
    const auto along = [&](int x, int y) {  // the difference across (x, y), smoothed across that
      const auto side = [&](int sign) {
        const Rgb<W> a = s.before(0, sign * x - y, sign * y - x), b = s.before(0, sign * x, sign * y),
                     c = s.before(0, sign * x + y, sign * y + x);
        return a + b + b + c;
      };
      return (side(1) - side(-1)) * F(0.125f);
    };
    const Rgb<W> gx = along(1, 0), gy = along(0, 1);
    const auto norm = [](F a, F b) { return sqrt(fma(a, a, b * b)); };
    s.set(0, Rgb<W>(norm(gx.x, gy.x), norm(gx.y, gy.y), norm(gx.z, gy.z)));
  }
};
KINORA_KERNELS_END

KINORA_DISPLAY_FILTER(PxrEdgeDetect, .help = "Shows how much a channel changes from pixel to pixel.",
                      .params = pxrEdgeDetect::kParams, .setUp = setUp<pxrEdgeDetect::Data>,
                      .channel = channelMaths::channelOf<pxrEdgeDetect::Data>, .seesPicture = true)
