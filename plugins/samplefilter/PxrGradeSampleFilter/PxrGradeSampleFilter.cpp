// PxrGradeSampleFilter: grades a colour channel of each camera sample: (c - black) / (white - black), times multiply
// and gain, plus lift and offset, gamma, clamps; mask blends from the ungraded colour.
#define KINORA_KERNEL_FILE "plugins/samplefilter/PxrGradeSampleFilter/PxrGradeSampleFilter.cpp"
#include <kinora/channel_filter.h>
#include <kinora/named_values.h>

#include <cmath>
#include <memory>
#include <string>
#include <kinora/channel_filter_author.h>
#include <kinora/math/elementary.h>

#if KINORA_PLAIN
namespace kinora::pxrGradeSampleFilter {
constexpr Param kParams[] = {
    param::string("aov", "Ci").help("Channel that is graded."),
    param::color("blackPoint", 0.f).help("Becomes black."),
    param::color("whitePoint", 1.f).help("Becomes white."),
    param::color("lift", 0.f).range(-1, 1).help("Added after the gain."),
    param::color("gain", 1.f).range(0, 4).help("Factor."),
    param::color("multiply", 1.f).range(0, 4).help("Factor."),
    param::color("offset", 0.f).range(-1, 1).help("Added after the gain."),
    param::color("gamma", 1.f)
        .range(0.1f, 4)
        .help("The colour becomes itself to the power 1 / gamma; 1 changes nothing."),
    param::integer("clampBlack", 1).range(0, 1).options("0 off, 1 on").help("Cuts negative colours."),
    param::integer("clampWhite", 0).range(0, 1).options("0 off, 1 on").help("Cuts colours above 1."),
    param::color("mask", 1.f).help("0 keeps the colour, 1 grades it."),
};
struct Data {
  std::string aov;
  float black[3], scale[3], add[3], power[3], mask[3];
  bool clampBlack, clampWhite;
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues v(info, kParams, std::size(kParams));
  auto data = std::make_unique<Data>();
  data->aov = v.string("aov");
  for (int c = 0; c < 3; ++c) {
    const double black = v.number("blackPoint", c), range = v.number("whitePoint", c) - black;
    if (std::fabs(range) < 1e-6) throw "blackPoint and whitePoint are the same";
    const double gamma = v.number("gamma", c);
    data->black[c] = float(black);
    data->scale[c] = float(v.number("multiply", c) * v.number("gain", c) / range);
    data->add[c] = float(v.number("lift", c) + v.number("offset", c));
    data->power[c] = gamma > 1e-3 ? float(1 / gamma) : 1.f;
    data->mask[c] = float(v.number("mask", c));
  }
  data->clampBlack = v.integer("clampBlack") != 0;
  data->clampWhite = v.integer("clampWhite") != 0;
  return data;
}
const char* channel(const void* data, uint32_t i) {
  return i == 0 ? static_cast<const Data*>(data)->aov.c_str() : nullptr;
}
}  // namespace kinora::pxrGradeSampleFilter
#endif

KINORA_KERNELS_BEGIN
using namespace pxrGradeSampleFilter;

struct PxrGradeSampleFilter {
  using Data = pxrGradeSampleFilter::Data;
  template <int W>
  static KN_INLINE Float<W> one(const Data& k, int c, Float<W> x) {
    using F = Float<W>;
    F y = fma(x - F(k.black[c]), F(k.scale[c]), F(k.add[c]));
    if (k.power[c] != 1.f) y = select(y > F(0.f), pow(max(y, F(1e-30f)), F(k.power[c])), y);
    if (k.clampBlack) y = max(y, F(0.f));
    if (k.clampWhite) y = min(y, F(1.f));
    return k.mask[c] == 1.f ? y : fma(F(k.mask[c]), y - x, x);
  }
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    if (!s.has(0)) return;
    const Rgb<W> c = s.rgb(0);
    s.set(0, Rgb<W>(one(k, 0, c.x), one(k, 1, c.y), one(k, 2, c.z)));
  }
};
KINORA_KERNELS_END

KINORA_SAMPLE_FILTER(PxrGradeSampleFilter, .help = "Grades a colour channel of each camera sample.",
                     .params = kParams, .setUp = setUpBy<make>, .channel = channel)
