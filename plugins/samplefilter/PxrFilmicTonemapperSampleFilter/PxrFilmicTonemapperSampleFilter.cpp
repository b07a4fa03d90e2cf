// PxrFilmicTonemapperSampleFilter: Hable's filmic tone curve on a colour channel of each camera sample.
#define KINORA_KERNEL_FILE "plugins/samplefilter/PxrFilmicTonemapperSampleFilter/PxrFilmicTonemapperSampleFilter.cpp"
#include <kinora/channel_maths.h>

KINORA_PLUGIN(PxrFilmicTonemapperSampleFilter, SampleFilterRunner<FilmicFilter>, SampleFilterPlugin,
              .help = "A filmic tone curve (Hable 2010) on a colour channel of each camera sample.",
              .params = channelMaths::kFilmicParams, .setUp = setUp<channelMaths::Filmic>,
              .channel = channelMaths::channelOf<channelMaths::Filmic>)
