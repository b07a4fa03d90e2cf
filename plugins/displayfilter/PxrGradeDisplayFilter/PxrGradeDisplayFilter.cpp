// PxrGradeDisplayFilter: grades a colour channel of finished pixels: (c - black) / (white - black), times multiply
// and gain, plus lift and offset, gamma, clamps; mask blends from the ungraded colour.
#define KINORA_KERNEL_FILE "plugins/displayfilter/PxrGradeDisplayFilter/PxrGradeDisplayFilter.cpp"
#include <kinora/channel_maths.h>

KINORA_PLUGIN(PxrGradeDisplayFilter, DisplayFilterRunner<GradeFilter>, DisplayFilterPlugin,
              .help = "Grades a colour channel of finished pixels.", .params = channelMaths::kGradeParams,
              .setUp = setUp<channelMaths::Grade>, .channel = channelMaths::channelOf<channelMaths::Grade>)
