// PxrBackgroundSampleFilter: a colour behind each camera sample.
#define KINORA_KERNEL_FILE "plugins/samplefilter/PxrBackgroundSampleFilter/PxrBackgroundSampleFilter.cpp"
#include <kinora/channel_maths.h>

#if KINORA_PLAIN
namespace kinora::pxrBackgroundSampleFilter {
constexpr Param kParams[] = {
    param::color("backgroundColor", 0.f).help("Colour behind the picture; scene-linear."),
};
std::unique_ptr<channelMaths::Background> make(const CreateInfo& info) {
  const NamedValues v(info, kParams, std::size(kParams));
  return std::make_unique<channelMaths::Background>(v, "Ci", "a");
}
}  // namespace kinora::pxrBackgroundSampleFilter
#endif

KINORA_PLUGIN(PxrBackgroundSampleFilter, SampleFilterRunner<BackgroundFilter>, SampleFilterPlugin,
              .help = "Puts a colour behind each camera sample.", .params = pxrBackgroundSampleFilter::kParams,
              .setUp = setUpBy<pxrBackgroundSampleFilter::make>,
              .channel = channelMaths::channelOf<channelMaths::Background>)
