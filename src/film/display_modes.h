// The mode of a display as a list of channels: "rgba", "Ci,a,diffuse", and what people write besides: any case,
// blanks or semicolons, modes among channels ("rgba,z"), types in the list ("color albedo"), brackets around it.
// Called by display_plan.cpp; display_channels.h says what a name means.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace kinora::film {

struct ModeChannel {
  std::string name;
  std::optional<scene::ValueType> type;  // where the list gives one: a declaration for a channel that has none
  int arrayLength = 1;
};

// In order, each name once. An empty mode is "rgba".
std::vector<ModeChannel> channelsOfMode(const scene::Scene& scene, const scene::Display& display);

}  // namespace kinora::film
