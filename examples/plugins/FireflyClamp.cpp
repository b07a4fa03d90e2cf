// A sample filter: dims samples that are brighter than a limit, before they are averaged into pixels.
//   SampleFilter "FireflyClamp" "clamp" "float limit" [4]
#define KINORA_KERNEL_FILE "FireflyClamp.cpp"
#include <kinora/channel_filter.h>
#include <kinora/named_values.h>

#include <cmath>
#include <iterator>
#include <memory>

#include <kinora/simd/foreach_target.h>
#include <kinora/channel_filter_author.h>
#include <kinora/math/elementary.h>

#ifndef FIREFLYCLAMP_ONCE
#define FIREFLYCLAMP_ONCE
namespace kinora::fireflyClamp {
constexpr Param kParams[] = {
    param::number("limit", 10.f).range(0.1f, 100).help("Greatest luminance (Rec. 709) that one sample may have."),
};
struct Data {
  float limit;
};
}  // namespace kinora::fireflyClamp
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
struct Clamp {
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
using Runner = ChannelFilterRunner<Clamp, SampleFilterFunctions>;
KINORA_WIDTH_TABLES(Runner, SampleFilterFunctions)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora {
namespace {
using namespace fireflyClamp;

void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&]() -> void* {
    const NamedValues v(*info, kParams, std::size(kParams));
    if (!(v.number("limit") > 0)) throw "limit must be positive";
    return std::make_unique<Data>(Data{float(v.number("limit"))}).release();
  });
}
// The channels that filter() sees, by index.
constexpr ChannelFilterTraits kTraits{[](const void*, uint32_t i) -> const char* { return i == 0 ? "Ci" : nullptr; }};
const WidthTable kTables[] = KINORA_ALL_WIDTHS;
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::SampleFilter,
                             0,
                             "FireflyClamp",
                             "Limits the luminance of single samples.",
                             kParams,
                             uint32_t(std::size(kParams)),
                             kTables,
                             4,
                             &kTraits,
                             create,
                             [](void* d) { delete static_cast<Data*>(d); }};
}  // namespace
KINORA_REGISTER(FireflyClamp, kDescriptor)
}  // namespace kinora
#endif
