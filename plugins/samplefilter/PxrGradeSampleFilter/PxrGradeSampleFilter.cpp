// PxrGradeSampleFilter: grades a colour channel of each camera sample: (c - black) / (white - black), times multiply
// and gain, plus lift and offset, gamma, clamps; mask blends from the ungraded colour.
#define KINORA_KERNEL_FILE "plugins/samplefilter/PxrGradeSampleFilter/PxrGradeSampleFilter.cpp"
#include <kinora/channel_maths.h>

KINORA_PLUGIN(PxrGradeSampleFilter, SampleFilterRunner<GradeFilter>, SampleFilterPlugin,
              .help = "Grades a colour channel of each camera sample.", .params = channelMaths::kGradeParams,
              .setUp = setUp<channelMaths::Grade>, .channel = channelMaths::channelOf<channelMaths::Grade>)
