// What a channel name of a display means: a DisplayChannel declaration of the scene, or one of the built-in names.
// Called by display_plan.cpp. It does not judge whether the integrator can fill the channel.
#pragma once
#include <string>

#include "base/diagnostics.h"
#include "film/channel.h"
#include "film/display_modes.h"
#include "scene/scene.h"

namespace kinora::film {

// A channel for any name in the list of `display`: what is unknown becomes a primvar's colour, with a warning.
Channel describeChannel(const scene::Scene& scene, const ModeChannel& wanted, const scene::Display& display,
                        Diagnostics& diagnostics);

}  // namespace kinora::film
