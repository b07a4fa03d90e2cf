// PxrFilmicTonemapperDisplayFilter: Hable's filmic tone curve on a colour channel of finished pixels.
#define KINORA_KERNEL_FILE \
  "plugins/displayfilter/PxrFilmicTonemapperDisplayFilter/PxrFilmicTonemapperDisplayFilter.cpp"
#include <kinora/channel_maths.h>

KINORA_PLUGIN(PxrFilmicTonemapperDisplayFilter, DisplayFilterRunner<FilmicFilter>, DisplayFilterPlugin,
              .help = "A filmic tone curve (Hable 2010) on a colour channel of finished pixels.",
              .params = channelMaths::kFilmicParams, .setUp = setUp<channelMaths::Filmic>,
              .channel = channelMaths::channelOf<channelMaths::Filmic>)
