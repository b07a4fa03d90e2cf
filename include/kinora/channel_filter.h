// The interfaces of SampleFilter and DisplayFilter. Both change named channels in place: a sample filter those of
// camera samples, after their paths have ended and before the film weighs them; a display filter those of finished
// pixels, before the displays get them. A sample depends on its own values alone, so that pictures do not depend on how
// samples are grouped; a pixel on its own and, of a display filter that sees the picture, on those that all pixels had
// before it. What light paths splat does not pass through sample filters.
#pragma once
#include <kinora/plugin.h>

namespace kinora {

// CreateInfo::extra of both kinds.
struct ChannelFilterInfo {
  uint32_t resolution[2];  // of the full raster, pixels; the origin of x and y is its upper left corner
  float pixelAspect;       // width of a pixel over its height
};

// Arrays of padded length, read and written. components 0: the frame has no such channel.
struct FilterChannel {
  const char* name;
  uint32_t components;  // 1, or 3 for colours
  float* data[3];
  const float* before[3] = {nullptr, nullptr, nullptr};  // DisplayFilterPlugin::seesPicture: of all pixels of the
                                                         // window, row by row, as they were before this filter
};

struct ChannelFilterArgs {
  uint32_t count;
  const int32_t* x;  // pixel of the full raster
  const int32_t* y;
  const FilterChannel* channels;  // those that the filter asked for, in its order
  uint32_t channelCount;
  int32_t window[4] = {0, 0, 0, 0};  // x0 y0 x1 y1 of the pixels that were rendered, half open; with `before`
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
  uint32_t seesPicture = 0;  // display filters, 1: FilterChannel::before is there
};

// What a sample filter declares.
struct SampleFilterPlugin {
  using Functions = SampleFilterFunctions;
  static constexpr Kind kKind = Kind::SampleFilter;
  const char* help = "";
  ListOf<Param> params = {};
  SetUp setUp = {};
  const char* (*channel)(const void* data, uint32_t i) = nullptr;
  constexpr ChannelFilterTraits traits() const { return {channel}; }
};

// What a display filter declares.
struct DisplayFilterPlugin {
  using Functions = DisplayFilterFunctions;
  static constexpr Kind kKind = Kind::DisplayFilter;
  const char* help = "";
  ListOf<Param> params = {};
  SetUp setUp = {};
  const char* (*channel)(const void* data, uint32_t i) = nullptr;
  bool seesPicture = false;  // it reads other pixels than its own (ChannelSpan::before)
  constexpr ChannelFilterTraits traits() const { return {channel, seesPicture}; }
};

}  // namespace kinora
