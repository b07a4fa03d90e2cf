// What a display does to values between the film and its driver: exposure, and quantisation with dither. Made by
// display_plan.cpp from the parameters of displays and channels, applied by display_output.cpp to the picture of one
// output. Drivers encode and store; they know nothing of it.
#pragma once
#include <array>
#include <cstdint>

#include "base/diagnostics.h"
#include "scene/parameters.h"

namespace kinora::film {

struct DisplayValues {
  float gain = 1,
        gamma = 1;  // exposure: (value x gain)^(1 / gamma), of colours; a gamma takes the place of a driver's sRGB
  // quantize [zero one min max]: value 0 becomes the code `zero`, 1 the code `one`, all is cut to min..max; one 0:
  // none.
  float zero = 0, one = 0, least = 0, most = 0;
  float dither = 0;  // amplitude in quantised steps
  bool isExposed() const { return gain != 1 || gamma != 1; }
  bool isQuantised() const { return one != 0; }
  bool operator==(const DisplayValues&) const = default;
};

// The frame's gain and gamma (Exposure), the display's parameters over them, the channel's (which may be null) over
// those. What cannot be used is a DISPLAY-PARAMETER warning and ignored.
DisplayValues displayValues(const std::array<float, 2>& exposure, const scene::ParameterList& display,
                            const scene::ParameterList* channel, const std::string& name, const SourcePos& pos,
                            Diagnostics& diagnostics);

// One float of a pixel. `largestCode`: of the integers that the driver stores (255, 65535), 0 where it stores floats;
// `isEncoded`: of the sRGB-encoded value, on which dither and quantisation then work. What comes out is what the
// driver makes those codes of. `component` tells the floats of a pixel apart.
float displayed(float value, const DisplayValues& v, bool isColor, float largestCode, bool isEncoded, int x, int y,
                int component);

}  // namespace kinora::film
