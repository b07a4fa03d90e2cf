// A display filter: rounds the colours of finished pixels to a few levels. The film keeps what was rendered.
//   DisplayFilter "Posterize" "poster" "int levels" [4]
#define KINORA_KERNEL_FILE "Posterize.cpp"
#include <kinora/channel_filter.h>
#include <kinora/named_values.h>

#include <cmath>
#include <iterator>
#include <memory>

#include <kinora/simd/foreach_target.h>
#include <kinora/channel_filter_author.h>
#include <kinora/math/elementary.h>

#ifndef POSTERIZE_ONCE
#define POSTERIZE_ONCE
namespace kinora::posterize {
constexpr Param kParams[] = {
    param::integer("levels", 4).range(2, 32).help("Steps from 0 to 1."),
};
struct Data {
  float levels;
};
}  // namespace kinora::posterize
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
struct Steps {
  using Data = posterize::Data;
  template <int W>
  static KN_INLINE Float<W> step(const Data& k, Float<W> x) {
    return floor(fma(x, Float<W>(k.levels), Float<W>(0.5f))) / Float<W>(k.levels);
  }
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    if (!s.has(0)) return;
    const Rgb<W> c = s.rgb(0);
    s.set(0, Rgb<W>(step(k, c.x), step(k, c.y), step(k, c.z)));
  }
};
using Runner = ChannelFilterRunner<Steps, DisplayFilterFunctions>;
KINORA_WIDTH_TABLES(Runner, DisplayFilterFunctions)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora {
namespace {
using namespace posterize;

void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&]() -> void* {
    const NamedValues v(*info, kParams, std::size(kParams));
    if (v.integer("levels") < 2) throw "levels must be 2 or more";
    return std::make_unique<Data>(Data{float(v.integer("levels") - 1)}).release();
  });
}
constexpr ChannelFilterTraits kTraits{[](const void*, uint32_t i) -> const char* { return i == 0 ? "Ci" : nullptr; }};
const WidthTable kTables[] = KINORA_ALL_WIDTHS;
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::DisplayFilter,
                             0,
                             "Posterize",
                             "Rounds colours to a few levels.",
                             kParams,
                             uint32_t(std::size(kParams)),
                             kTables,
                             4,
                             &kTraits,
                             create,
                             [](void* d) { delete static_cast<Data*>(d); }};
}  // namespace
KINORA_REGISTER(Posterize, kDescriptor)
}  // namespace kinora
#endif
