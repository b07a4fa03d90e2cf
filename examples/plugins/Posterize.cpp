// A display filter: rounds the colours of finished pixels to a few levels. The film keeps what was rendered.
//   DisplayFilter "Posterize" "poster" "int levels" [4]
#define KINORA_KERNEL_FILE "Posterize.cpp"
#include <kinora/channel_filter_author.h>
#include <kinora/math/elementary.h>

#if KINORA_PLAIN
namespace kinora::posterize {
constexpr Param kParams[] = {
    param::integer("levels", 4).range(2, 32).help("Steps from 0 to 1."),
};
struct Data {
  float steps;
  explicit Data(const CreateInfo& info) : steps(info.number(0) - 1) {
    if (!(steps >= 1)) throw "levels must be 2 or more";
  }
  static const char* channel(const void*, uint32_t i) { return i == 0 ? "Ci" : nullptr; }
};
}  // namespace kinora::posterize
#endif

KINORA_KERNELS_BEGIN
using namespace posterize;

struct Posterize {
  using Data = posterize::Data;
  template <int W>
  static KN_INLINE Float<W> step(const Data& k, Float<W> x) {
    return floor(fma(x, Float<W>(k.steps), Float<W>(0.5f))) / Float<W>(k.steps);
  }
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    if (!s.has(0)) return;
    const Rgb<W> c = s.rgb(0);
    s.set(0, Rgb<W>(step(k, c.x), step(k, c.y), step(k, c.z)));
  }
};
KINORA_KERNELS_END

KINORA_DISPLAY_FILTER(Posterize, .help = "Rounds colours to a few levels.", .params = kParams, .setUp = setUp<Data>,
                      .channel = Data::channel)
