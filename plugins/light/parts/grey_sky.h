// What stands in for the map of a dome that cannot be read.
#pragma once
#include <kinora/light_setup.h>

namespace kinora::lightParts {

// `name`: of the parameter that names the map.
inline void greySkyWithout(const LightMap& map, const char* name, const NamedValues& values, LightCommon& common) {
  if (map.valid() || values.string(name).empty()) return;
  // intensities are set for maps, whose means are far below 1: without one the frame would be burnt out
  constexpr float kGreySky = 0.25f;
  for (float& c : common.radiance) c *= kGreySky;
  values.warn("LIGHT-MAP", "there is no map to light with", "an even grey of .25 stands in for it");
}

}  // namespace kinora::lightParts
