// The interfaces of SampleFilter and DisplayFilter. Both change named channels in place: a sample filter those of
// camera samples, after their paths have ended and before the film weighs them; a display filter those of finished
// pixels, before the displays get them. A value depends on the values of the same sample or pixel alone, so that
// pictures do not depend on how samples are grouped. What light paths splat does not pass through sample filters.
#pragma once
#include <kinora/plugin.h>

namespace kinora {

// Arrays of padded length, read and written. components 0: the frame has no such channel.
struct FilterChannel {
  const char* name;
  uint32_t components;  // 1, or 3 for colours
  float* data[3];
};

struct ChannelFilterArgs {
  uint32_t count;
  const int32_t* x;  // pixel of the full raster
  const int32_t* y;
  const FilterChannel* channels;  // those that the filter asked for, in its order
  uint32_t channelCount;
};

struct SampleFilterFunctions {
  void (*filter)(const void* data, const ChannelFilterArgs*);
};
struct DisplayFilterFunctions {
  void (*filter)(const void* data, const ChannelFilterArgs*);
};

// Descriptor::traits of both kinds.
struct ChannelFilterTraits {
  // Name i of the channels wanted ("Ci", "a", a DisplayChannel's name), or null past the last. Lives as long as the
  // data.
  const char* (*channel)(const void* data, uint32_t i);
};

// What a sample filter (or a display filter) declares.
template <Kind K, class FilterFunctions>
struct ChannelFilterPlugin {
  using Functions = FilterFunctions;
  static constexpr Kind kKind = K;
  const char* help = "";
  ListOf<Param> params = {};
  SetUp setUp = {};
  const char* (*channel)(const void* data, uint32_t i) = nullptr;
  constexpr ChannelFilterTraits traits() const { return {channel}; }
};
using SampleFilterPlugin = ChannelFilterPlugin<Kind::SampleFilter, SampleFilterFunctions>;
using DisplayFilterPlugin = ChannelFilterPlugin<Kind::DisplayFilter, DisplayFilterFunctions>;

}  // namespace kinora
