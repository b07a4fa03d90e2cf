// How a light (or a light filter) moves while the shutter is open: rigidly, about where it stands in the middle of that
// time. Plug-ins know their light at rest; points and rays are carried there before a plug-in is asked, and what it
// answers back. Distances, radiances and densities are the same in both places. Built by render/light_places.h.
#pragma once
#include <kinora/light.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace kinora::light {

struct LightMotion {
  // x (at rest) is at pivot + turn (x - pivot) + shift.
  struct Pose {
    float turn[4];   // unit quaternion: w, x, y, z
    float shift[3];  // render units
  };
  float pivot[3] = {0, 0, 0};  // render space
  // At uniform times over the shutter, at least two; a turn and the next are less than half a turn apart.
  std::vector<Pose> poses;

  // time: 0..1 over the shutter. Turns in between stay turns.
  Pose at(float time) const;
};

enum class LightVector : uint8_t { Point, Direction };
// Into where the light rests, and from there.
void carryToRest(const LightMotion& motion, float time, LightVector kind, float x[3]);
void carryFromRest(const LightMotion& motion, float time, LightVector kind, float x[3]);

// Widens the bounds of a light, as it describes itself at rest, to those of all that it is over the shutter.
void widen(LightDescription& description, const LightMotion& motion);

}  // namespace kinora::light
