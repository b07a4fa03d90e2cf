// PxrShadowFilter: what part of a light camera samples lack.
#define KINORA_KERNEL_FILE "plugins/samplefilter/PxrShadowFilter/PxrShadowFilter.cpp"
#include <kinora/channel_maths.h>

#if KINORA_PLAIN
namespace kinora::pxrShadowFilter {
constexpr auto kParams = joinParams(channelMaths::kShadowParams);
std::unique_ptr<channelMaths::Shadow> make(const CreateInfo& info) {
  const NamedValues v(info, kParams.data(), kParams.size());
  return std::make_unique<channelMaths::Shadow>(v, 0.0);
}
}  // namespace kinora::pxrShadowFilter
#endif

KINORA_PLUGIN(PxrShadowFilter, SampleFilterRunner<ShadowFilter>, SampleFilterPlugin,
              .help = "Shadow from two channels: 1 less light with shadows over light without them.",
              .params = pxrShadowFilter::kParams, .setUp = setUpBy<pxrShadowFilter::make>,
              .channel = channelMaths::channelOf<channelMaths::Shadow>)
