// A sample filter: dims samples that are brighter than a limit, before they are averaged into pixels.
//   SampleFilter "FireflyClamp" "clamp" "float limit" [4]
#define KINORA_KERNEL_FILE "FireflyClamp.cpp"
#include <kinora/channel_filter_author.h>
#include <kinora/math/elementary.h>

#if KINORA_PLAIN
namespace kinora::fireflyClamp {
constexpr Param kParams[] = {
    param::number("limit", 10.f).range(0.1f, 100).help("Greatest luminance (Rec. 709) that one sample may have."),
};
struct Data {
  float limit;
  explicit Data(const CreateInfo& info) : limit(info.number(0)) {
    if (!(limit > 0)) throw "limit must be positive";
  }
  // The channels that filter() sees, by index.
  static const char* channel(const void*, uint32_t i) { return i == 0 ? "Ci" : nullptr; }
};
}  // namespace kinora::fireflyClamp
#endif

KINORA_KERNELS_BEGIN
using namespace fireflyClamp;

struct FireflyClamp {
  using Data = fireflyClamp::Data;
  // Colours keep their hue: all three are scaled.
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    using F = Float<W>;
    if (!s.has(0)) return;
    const Rgb<W> c = s.rgb(0);
    const F luminance = fma(F(0.2126f), c.x, fma(F(0.7152f), c.y, F(0.0722f) * c.z));
    s.set(0, c * select(luminance > F(k.limit), F(k.limit) / max(luminance, F(1e-20f)), F(1.f)));
  }
};
KINORA_KERNELS_END

KINORA_SAMPLE_FILTER(FireflyClamp, .help = "Limits the luminance of single samples.", .params = kParams,
                     .setUp = setUp<Data>, .channel = Data::channel)
