// A volume: a ball of smoke. This version of Kinora finds it and keeps it; media of varying density come later.
#define KINORA_KERNEL_FILE "Puff.cpp"
#include <kinora/volume.h>
#include <kinora/named_values.h>

#include <cmath>
#include <iterator>
#include <memory>

#include <kinora/simd/foreach_target.h>
#include <kinora/volume_author.h>
#include <kinora/math/elementary.h>

#ifndef PUFF_ONCE
#define PUFF_ONCE
namespace kinora::puff {
constexpr Param kParams[] = {
    param::number("radius", 1.f).range(0.1f, 10).help("Beyond it the density is 0."),
    param::number("density", 1.f).range(0, 10).help("In the middle."),
};
struct Data {
  float radius, density;
};
}  // namespace kinora::puff
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
struct Ball {
  using Data = puff::Data;
  template <int W>
  static KN_INLINE Rgb<W> value(const Data& k, uint32_t, Vec3<W> P, Float<W>) {
    using F = Float<W>;
    const F left = max(fnma(dot(P, P), F(1.f / (k.radius * k.radius)), F(1.f)), F(0.f));
    return {left * F(k.density), F(0.f), F(0.f)};
  }
};
using Runner = VolumeRunner<Ball>;
KINORA_WIDTH_TABLES(Runner, VolumeFunctions)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora {
namespace {
using namespace puff;

void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&]() -> void* {
    const NamedValues v(*info, kParams, std::size(kParams));
    if (!(v.number("radius") > 0)) throw "radius must be positive";
    return std::make_unique<Data>(Data{float(v.number("radius")), float(v.number("density"))}).release();
  });
}
constexpr VolumeField kFields[] = {{"density", 1}};
constexpr VolumeTraits kTraits{kFields, 1,
                               [](const void* d, VolumeBound* b) {
                                 for (int c = 0; c < 3; ++c)
                                   b->high[c] = static_cast<const Data*>(d)->radius, b->low[c] = -b->high[c];
                               },
                               [](const void* d, uint32_t, const VolumeBound*, float low[3], float high[3]) {
                                 low[0] = 0;
                                 high[0] = static_cast<const Data*>(d)->density;
                               }};
const WidthTable kTables[] = KINORA_ALL_WIDTHS;
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::Volume,
                             0,
                             "Puff",
                             "A ball of smoke, densest in the middle.",
                             kParams,
                             uint32_t(std::size(kParams)),
                             kTables,
                             4,
                             &kTraits,
                             create,
                             [](void* d) { delete static_cast<Data*>(d); }};
}  // namespace
KINORA_REGISTER(Puff, kDescriptor)
}  // namespace kinora
#endif
