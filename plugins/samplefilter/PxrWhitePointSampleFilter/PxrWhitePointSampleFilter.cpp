// PxrWhitePointSampleFilter: makes a colour neutral in a channel of each camera sample.
#define KINORA_KERNEL_FILE "plugins/samplefilter/PxrWhitePointSampleFilter/PxrWhitePointSampleFilter.cpp"
#include <kinora/channel_maths.h>

KINORA_PLUGIN(PxrWhitePointSampleFilter, SampleFilterRunner<WhitePointFilter>, SampleFilterPlugin,
              .help = "White balance: makes the colour of a temperature, or any, neutral in each camera sample.",
              .params = channelMaths::kWhitePointParams, .setUp = setUp<channelMaths::WhitePoint>,
              .channel = channelMaths::channelOf<channelMaths::WhitePoint>)
