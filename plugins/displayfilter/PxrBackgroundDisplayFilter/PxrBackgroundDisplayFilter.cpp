// PxrBackgroundDisplayFilter: a colour behind the picture: what the alpha channel leaves of each pixel.
#define KINORA_KERNEL_FILE "plugins/displayfilter/PxrBackgroundDisplayFilter/PxrBackgroundDisplayFilter.cpp"
#include <kinora/channel_maths.h>

#if KINORA_PLAIN
namespace kinora::pxrBackgroundDisplayFilter {
constexpr Param kParams[] = {
    param::string("aov", "Ci").help("Channel that gets the background."),
    param::string("aovAlpha", "a")
        .help("Channel that says how much of a pixel is covered; without it nothing is done."),
    param::color("backgroundColor", 0.f).help("Colour behind the picture; scene-linear."),
    param::number("backgroundAlpha", 0.f)
        .help("Alpha of the background: 0 leaves the channel as it is, 1 says that the background covers what was "
              "empty, as after the background imager of old files."),
};
std::unique_ptr<channelMaths::Background> make(const CreateInfo& info) {
  const NamedValues v(info, kParams, std::size(kParams));
  return std::make_unique<channelMaths::Background>(v, v.string("aov"), v.string("aovAlpha"),
                                                    v.number("backgroundAlpha"));
}
}  // namespace kinora::pxrBackgroundDisplayFilter
#endif

KINORA_PLUGIN(PxrBackgroundDisplayFilter, DisplayFilterRunner<BackgroundFilter>, DisplayFilterPlugin,
              .help = "Puts a colour behind the picture.", .params = pxrBackgroundDisplayFilter::kParams,
              .setUp = setUpBy<pxrBackgroundDisplayFilter::make>,
              .channel = channelMaths::channelOf<channelMaths::Background>)
