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

// One function table, of width 1: const WidthTable kTables[] = {{1, &kFunctions}}.

}  // namespace kinora
