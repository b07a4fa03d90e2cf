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
    param::integer("coverAll", 0)
        .range(0, 1)
        .options("0 off, 1 on")
        .help(
            "1: alpha says that the background covers what was empty, as after the background imager of old files."),
};
std::unique_ptr<channelMaths::Background> make(const CreateInfo& info) {
  const NamedValues v(info, kParams, std::size(kParams));
  return std::make_unique<channelMaths::Background>(v, v.string("aov"), v.string("aovAlpha"),
                                                    v.integer("coverAll") != 0);
}
}  // namespace kinora::pxrBackgroundDisplayFilter
#endif

KINORA_PLUGIN(PxrBackgroundDisplayFilter, DisplayFilterRunner<BackgroundFilter>, DisplayFilterPlugin,
              .help = "Puts a colour behind the picture.", .params = pxrBackgroundDisplayFilter::kParams,
              .setUp = setUpBy<pxrBackgroundDisplayFilter::make>,
              .channel = channelMaths::channelOf<channelMaths::Background>)
