// PxrImagePlaneFilter: a picture behind camera samples: what their alpha leaves of each. A sample shows the picture as it
// is at the middle of its pixel.
#define KINORA_KERNEL_FILE "plugins/samplefilter/PxrImagePlaneFilter/PxrImagePlaneFilter.cpp"
#include <kinora/channel_picture.h>

#if KINORA_PLAIN
namespace kinora::pxrImagePlaneFilter {
constexpr std::array kOwn = {
    param::onOff("useAlpha", false)
        .help("1: alpha grows by the picture's own, by which its colours are multiplied already; 0: alpha stays."),
};
constexpr auto kParams = joinParams(channelPicture::placeParams(0), channelPicture::kPlateParams, kOwn);
std::unique_ptr<channelPicture::Plate> make(const CreateInfo& info) {
  const NamedValues v(info, kParams.data(), kParams.size());
  return std::make_unique<channelPicture::Plate>(v, v.integer("useAlpha") != 0);
}
}  // namespace kinora::pxrImagePlaneFilter
#endif

KINORA_PLUGIN(PxrImagePlaneFilter, SampleFilterRunner<PlateFilter>, SampleFilterPlugin,
              .help = "Puts an image behind camera samples.", .params = pxrImagePlaneFilter::kParams,
              .setUp = setUpBy<pxrImagePlaneFilter::make>, .channel = channelMaths::channelOf<channelPicture::Plate>)
