// PxrCopyAOVDisplayFilter: copies one channel of finished pixels to another.
#define KINORA_KERNEL_FILE "plugins/displayfilter/PxrCopyAOVDisplayFilter/PxrCopyAOVDisplayFilter.cpp"
#include <kinora/channel_maths.h>

KINORA_PLUGIN(PxrCopyAOVDisplayFilter, DisplayFilterRunner<CopyFilter>, DisplayFilterPlugin,
              .help = "Copies one channel of finished pixels to another.", .params = channelMaths::kCopyParams,
              .setUp = setUp<channelMaths::Copy>, .channel = channelMaths::channelOf<channelMaths::Copy>)
