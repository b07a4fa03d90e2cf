// PxrBackgroundDisplayFilter: puts a colour behind a finished channel where its alpha leaves room. Alpha stays as it
// is.
#define KINORA_KERNEL_FILE "plugins/displayfilter/PxrBackgroundDisplayFilter/PxrBackgroundDisplayFilter.cpp"
#include <kinora/channel_filter.h>
#include <kinora/named_values.h>

#include <memory>
#include <string>
#include <kinora/channel_filter_author.h>

#if KINORA_PLAIN
namespace kinora::pxrBackgroundDisplayFilter {
constexpr Param kParams[] = {
    param::string("aov", "Ci").help("Channel that gets the background."),
    param::string("aovAlpha", "a")
        .help("Channel that says how much of a pixel is covered; without it nothing is done."),
    param::color("backgroundColor", 0.f).help("Colour behind the picture; scene-linear."),
};
struct Data {
  std::string aov, alpha;
  float color[3];
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues v(info, kParams, std::size(kParams));
  auto data = std::make_unique<Data>();
  data->aov = v.string("aov");
  data->alpha = v.string("aovAlpha");
  for (int c = 0; c < 3; ++c) data->color[c] = float(v.number("backgroundColor", c));
  return data;
}
const char* channel(const void* data, uint32_t i) {
  const auto* k = static_cast<const Data*>(data);
  return i == 0 ? k->aov.c_str() : i == 1 ? k->alpha.c_str() : nullptr;
}
}  // namespace kinora::pxrBackgroundDisplayFilter
#endif

KINORA_KERNELS_BEGIN
using namespace pxrBackgroundDisplayFilter;

struct PxrBackgroundDisplayFilter {
  using Data = pxrBackgroundDisplayFilter::Data;
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    using F = Float<W>;
    if (!s.has(0) || !s.has(1)) return;
    const F room = max(F(1.f) - s.number(1), F(0.f));
    const Rgb<W> c = s.rgb(0);
    s.set(0, Rgb<W>(fma(room, F(k.color[0]), c.x), fma(room, F(k.color[1]), c.y), fma(room, F(k.color[2]), c.z)));
  }
};
KINORA_KERNELS_END

KINORA_DISPLAY_FILTER(PxrBackgroundDisplayFilter, .help = "Puts a colour behind the picture.", .params = kParams,
                      .setUp = setUpBy<make>, .channel = channel)
