// PxrShadowDisplayFilter: what part of a light finished pixels lack.
#define KINORA_KERNEL_FILE "plugins/displayfilter/PxrShadowDisplayFilter/PxrShadowDisplayFilter.cpp"
#include <kinora/channel_maths.h>

#if KINORA_PLAIN
namespace kinora::pxrShadowDisplayFilter {
constexpr auto kParams = joinParams(channelMaths::kShadowParams, channelMaths::kThreshold);
std::unique_ptr<channelMaths::Shadow> make(const CreateInfo& info) {
  const NamedValues v(info, kParams.data(), kParams.size());
  return std::make_unique<channelMaths::Shadow>(v, v.number("shadowThreshold"));
}
}  // namespace kinora::pxrShadowDisplayFilter
#endif

KINORA_PLUGIN(PxrShadowDisplayFilter, DisplayFilterRunner<ShadowFilter>, DisplayFilterPlugin,
              .help = "Shadow from two channels: 1 less light with shadows over light without them.",
              .params = pxrShadowDisplayFilter::kParams, .setUp = setUpBy<pxrShadowDisplayFilter::make>,
              .channel = channelMaths::channelOf<channelMaths::Shadow>)
