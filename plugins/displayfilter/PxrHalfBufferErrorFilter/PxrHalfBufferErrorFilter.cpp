// PxrHalfBufferErrorFilter: from two pictures, each of half the samples, the squared error of the whole: a quarter of the
// squared difference of the halves, on average over the colours (F. Rousselle, C. Knaus and M. Zwicker, "Adaptive
// Rendering with Non-Local Means Filtering", 2012).
#define KINORA_KERNEL_FILE "plugins/displayfilter/PxrHalfBufferErrorFilter/PxrHalfBufferErrorFilter.cpp"
#include <kinora/channel_maths.h>

#if KINORA_PLAIN
namespace kinora::pxrHalfBufferErrorFilter {
constexpr Param kParams[] = {
    param::string("aov1", "even").help("Channel of one half of the samples (DisplayChannel, statistics \"even\")."),
    param::string("aov2", "odd").help("Channel of the other half (statistics \"odd\")."),
    param::string("result", "mse").help("Channel that gets the squared error of the mean of both."),
};
struct Data {
  std::string a, b, result;
  explicit Data(const CreateInfo& info) {
    const NamedValues v(info, kParams, std::size(kParams));
    a = v.string("aov1");
    b = v.string("aov2");
    result = v.string("result");
  }
  const char* channel(uint32_t i) const {
    return i == 0 ? a.c_str() : i == 1 ? b.c_str() : i == 2 ? result.c_str() : nullptr;
  }
};
}  // namespace kinora::pxrHalfBufferErrorFilter
#endif

KINORA_KERNELS_BEGIN
struct PxrHalfBufferErrorFilter {
  using Data = pxrHalfBufferErrorFilter::Data;
  template <int W>
  static KN_INLINE void filter(const Data&, const ChannelSpan<W>& s) {
    using F = Float<W>;
    if (!s.has(0) || !s.has(1) || !s.has(2)) return;
    const Rgb<W> d = s.rgb(0) - s.rgb(1);
    const F e = fma(d.x, d.x, fma(d.y, d.y, d.z * d.z)) * F(1.f / 12);
    s.set(2, Rgb<W>(e, e, e));
  }
};
KINORA_KERNELS_END

KINORA_DISPLAY_FILTER(PxrHalfBufferErrorFilter,
                      .help = "The squared error of a picture, from two halves of its samples.",
                      .params = pxrHalfBufferErrorFilter::kParams, .setUp = setUp<pxrHalfBufferErrorFilter::Data>,
                      .channel = channelMaths::channelOf<pxrHalfBufferErrorFilter::Data>)
