// The interface of a pixel filter: a function of the place in a pixel. The renderer asks for it some thousand times
// when a frame begins, makes a distribution of it and draws samples from that, so it costs nothing while rendering.
// It may be negative in places; its integral must be positive. RIB: PixelFilter "name" xwidth ywidth.
#pragma once
#include <kinora/plugin.h>

namespace kinora {

struct PixelFilterInfo {  // CreateInfo::extra
  float width[2];         // full widths in pixels, positive
};

struct PixelFilterFunctions {
  // At x, y in pixels from the pixel's centre, inside the widths. Not normalised. Called by one thread.
  double (*value)(const void* filter, double x, double y);
};

// What a pixel filter declares: a struct made of a PixelFilterInfo, with double value(double x, double y) const.
template <class Filter>
struct PixelFilterPlugin {
  using Functions = PixelFilterFunctions;
  static constexpr Kind kKind = Kind::PixelFilter;
  static constexpr SetUp setUp{[](const CreateInfo* info, ErrorText* error) {
                                 const auto& widths = *static_cast<const PixelFilterInfo*>(info->extra);
                                 return guardedCreate(error, [&] { return new Filter(widths); });
                               },
                               [](void* filter) { delete static_cast<Filter*>(filter); }};
  static constexpr Functions kFunctions{
      [](const void* filter, double x, double y) { return static_cast<const Filter*>(filter)->value(x, y); }};
  const char* help = "";
  ListOf<Param> params = {};
  constexpr NoTraits traits() const { return {}; }
};
// Ends the file of a plug-in, outside of namespaces.
#define KINORA_PIXEL_FILTER(Name, Filter, ...) \
  KINORA_SCALAR_PLUGIN(Name, PixelFilterPlugin<Filter>::kFunctions, PixelFilterPlugin<Filter>, __VA_ARGS__)

}  // namespace kinora
