// PxrWhitePointDisplayFilter: makes a colour neutral in a channel of finished pixels.
#define KINORA_KERNEL_FILE "plugins/displayfilter/PxrWhitePointDisplayFilter/PxrWhitePointDisplayFilter.cpp"
#include <kinora/channel_maths.h>

KINORA_PLUGIN(PxrWhitePointDisplayFilter, DisplayFilterRunner<WhitePointFilter>, DisplayFilterPlugin,
              .help = "White balance: makes the colour of a temperature, or any, neutral in finished pixels.",
              .params = channelMaths::kWhitePointParams, .setUp = setUp<channelMaths::WhitePoint>,
              .channel = channelMaths::channelOf<channelMaths::WhitePoint>)
