// PxrImageDisplayFilter: a picture behind finished pixels: what the alpha channel leaves of each.
#define KINORA_KERNEL_FILE "plugins/displayfilter/PxrImageDisplayFilter/PxrImageDisplayFilter.cpp"
#include <kinora/channel_picture.h>

#if KINORA_PLAIN
namespace kinora::pxrImageDisplayFilter {
constexpr auto kParams = joinParams(channelPicture::placeParams(0), channelPicture::kPlateParams);
std::unique_ptr<channelPicture::Plate> make(const CreateInfo& info) {
  return std::make_unique<channelPicture::Plate>(NamedValues(info, kParams.data(), kParams.size()), false);
}
}  // namespace kinora::pxrImageDisplayFilter
#endif

KINORA_PLUGIN(PxrImageDisplayFilter, DisplayFilterRunner<PlateFilter>, DisplayFilterPlugin,
              .help = "Puts an image behind the picture; alpha stays.", .params = pxrImageDisplayFilter::kParams,
              .setUp = setUpBy<pxrImageDisplayFilter::make>,
              .channel = channelMaths::channelOf<channelPicture::Plate>)
