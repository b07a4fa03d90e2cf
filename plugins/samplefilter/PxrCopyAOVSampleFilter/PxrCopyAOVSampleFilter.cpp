// PxrCopyAOVSampleFilter: copies one channel of each camera sample to another.
#define KINORA_KERNEL_FILE "plugins/samplefilter/PxrCopyAOVSampleFilter/PxrCopyAOVSampleFilter.cpp"
#include <kinora/channel_maths.h>

KINORA_PLUGIN(PxrCopyAOVSampleFilter, SampleFilterRunner<CopyFilter>, SampleFilterPlugin,
              .help = "Copies one channel of each camera sample to another.", .params = channelMaths::kCopyParams,
              .setUp = setUp<channelMaths::Copy>, .channel = channelMaths::channelOf<channelMaths::Copy>)
