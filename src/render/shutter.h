// The shutter's opening shape as a warp of sample times: a time is drawn as often as the shutter is open then. Read
// by the frame for camera and light paths.
#pragma once
#include <vector>

#include "base/diagnostics.h"
#include "scene/scene.h"

namespace kinora::render {

// Times (0..1 over the shutter) at even shares of the light let in; empty: the shutter opens and closes at once. From
// the camera's shutterOpenTime, shutterCloseTime and shutteropening (rib.md 3), else the hider's shutteropening. With the hider's
// samplemotion 0 all times are that of the opening.
std::vector<float> shutterTimes(const scene::Camera& camera, const scene::NodePtr& hider, Diagnostics& diagnostics);

// Whether rays have times of their own.
bool samplesMotion(const scene::NodePtr& hider);

inline float shutterTime(const std::vector<float>& times, float u) {
  const float x = u * float(times.size() - 1);
  const size_t k = x >= float(times.size() - 1) ? times.size() - 2 : size_t(x);
  return times[k] + (x - float(k)) * (times[k + 1] - times[k]);
}

}  // namespace kinora::render
