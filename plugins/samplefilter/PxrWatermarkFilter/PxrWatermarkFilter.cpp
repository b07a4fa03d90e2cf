// PxrWatermarkFilter: a picture over camera samples, by its alpha.
#define KINORA_KERNEL_FILE "plugins/samplefilter/PxrWatermarkFilter/PxrWatermarkFilter.cpp"
#include <kinora/channel_picture.h>

#if KINORA_PLAIN
namespace kinora::pxrWatermarkFilter {
constexpr std::array kOwn = {
    param::integer("mode", 3).range(3, 3).options("3 over").help(
        "How the picture and the samples mix. What other numbers mean is not published; they count as 3."),
    param::number("transparency", 0.f).help("0 shows the picture in full, 1 not at all."),
};
constexpr auto kParams = joinParams(channelPicture::placeParams(1), kOwn);
struct Data {
  channelPicture::Picture picture;
  float share;
  explicit Data(const CreateInfo& info)
      : picture(NamedValues(info, kParams.data(), kParams.size())),
        share(float(1 - NamedValues(info, kParams.data(), kParams.size()).number("transparency"))) {}
  const char* channel(uint32_t i) const { return i == 0 ? "Ci" : nullptr; }
};
}  // namespace kinora::pxrWatermarkFilter
#endif

KINORA_KERNELS_BEGIN
struct PxrWatermarkFilter {
  using Data = pxrWatermarkFilter::Data;
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    using F = Float<W>;
    if (!k.picture.width || !s.has(0)) return;
    Rgb<W> over;
    F alpha;
    lookUpPicture(k.picture, s, over, alpha);
    const F share(k.share), under = fnma(alpha, share, F(1.f));
    const Rgb<W> c = s.rgb(0);
    s.set(0,
          Rgb<W>(fma(c.x, under, over.x * share), fma(c.y, under, over.y * share), fma(c.z, under, over.z * share)));
  }
};
KINORA_KERNELS_END

KINORA_SAMPLE_FILTER(PxrWatermarkFilter, .help = "Puts an image over camera samples, by its alpha.",
                     .params = pxrWatermarkFilter::kParams, .setUp = setUp<pxrWatermarkFilter::Data>,
                     .channel = channelMaths::channelOf<pxrWatermarkFilter::Data>)
