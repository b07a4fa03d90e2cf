// A volume: a ball of smoke, for Volume "blobbydso:Puff" with Bxdf "PxrVolume" "string densityFloatPrimVar" ["density"].
#define KINORA_KERNEL_FILE "Puff.cpp"
#include <kinora/volume_author.h>
#include <kinora/math/elementary.h>

#if KINORA_PLAIN
namespace kinora::puff {
enum : uint32_t { kRadius, kDensity };
constexpr Param kParams[] = {
    param::number("radius", 1.f).range(0.1f, 10).help("Beyond it the density is 0."),
    param::number("density", 1.f).range(0, 10).help("In the middle."),
};
constexpr VolumeField kFields[] = {{"density", 1}};
struct Data {
  float radius, density;
  explicit Data(const CreateInfo& info) : radius(info.number(kRadius)), density(info.number(kDensity)) {
    if (!(radius > 0)) throw "radius must be positive";
  }
};
inline void bound(const void* data, VolumeBound* b) {
  for (int c = 0; c < 3; ++c) b->high[c] = static_cast<const Data*>(data)->radius, b->low[c] = -b->high[c];
}
inline void extremes(const void* data, uint32_t, const VolumeBound*, float low[3], float high[3]) {
  low[0] = 0;
  high[0] = static_cast<const Data*>(data)->density;
}
}  // namespace kinora::puff
#endif

KINORA_KERNELS_BEGIN
using namespace puff;

struct Puff {
  using Data = puff::Data;
  template <int W>
  static KN_INLINE Rgb<W> value(const Data& k, uint32_t, Vec3<W> P, Float<W>) {
    using F = Float<W>;
    const F left = max(fnma(dot(P, P), F(1.f / (k.radius * k.radius)), F(1.f)), F(0.f));
    return {left * F(k.density), F(0.f), F(0.f)};
  }
};
KINORA_KERNELS_END

KINORA_VOLUME(Puff, .help = "A ball of smoke, densest in the middle.", .params = kParams, .setUp = setUp<Data>,
              .fields = kFields, .bound = bound, .extremes = extremes)
