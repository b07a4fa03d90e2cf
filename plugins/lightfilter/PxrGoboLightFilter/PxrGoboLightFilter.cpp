// PxrGoboLightFilter: a picture in the filter's XY plane, which the light shines through along +z in its own
// directions. PxrCookieLightFilter took its place.
#define KINORA_KERNEL_FILE "plugins/lightfilter/PxrGoboLightFilter/PxrGoboLightFilter.cpp"
#include <memory>

#include "plugins/lightfilter/parts/picture.h"
// per target from here
#include <kinora/light_filter_author.h>

#include "plugins/lightfilter/parts/picture_kernel.h"

#if KINORA_PLAIN
namespace kinora::pxrGoboLightFilter {
using namespace filterParts;
constexpr auto kParams =
    joinParams(kPictureParams,
               std::array{param::number("width", 1.f).range(0.1f, 4).help("Size of the image in x."),
                          param::number("height", 1.f).range(0.1f, 4).help("Size of the image in y.")},
               intensity(1, "Factor on the image."), invert("1: the image counts as 1 less itself."), kStrength);

struct Data {
  Plane plane;
  Picture picture;
  float density;
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues v(info, kParams.data(), kParams.size());
  auto k = std::make_unique<Data>();
  k->plane.space = FilterSpace::of(info);
  Picture::Grade grade;
  grade.inverted = v.integer("invert") != 0;
  grade.intensity = atLeast(v, "intensity", 0);
  k->picture.set(v, grade);
  k->density = k->picture.map.valid() ? strength(v) : 0.f;
  v.warnNoEffect();
  return k;
}
float largest(const void* data) { return largestOf(static_cast<const Data*>(data)->picture.mostOfAll); }
}  // namespace kinora::pxrGoboLightFilter
#endif

KINORA_KERNELS_BEGIN
using namespace pxrGoboLightFilter;

struct PxrGoboLightFilter {
  using Data = pxrGoboLightFilter::Data;
  template <int W>
  static KN_INLINE Rgb<W> factor(const Data& k, const LitPoint<W>& p) {
    using F = Float<W>;
    if (k.density == 0) return Rgb<W>(F(1.f), F(1.f), F(1.f));
    return filtered<W>(pictureOnPlane<W>(k.picture, onPlane<W>(k.plane, p)), F(k.density));
  }
};
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(PxrGoboLightFilter, .help = "A picture that the light shines through.", .params = kParams,
                    .setUp = setUpBy<make>, .largest = largest)
