// What controlled shadow rays carry along; see light_shadows.cpp. Internal to shade/.
#pragma once
#include "shade/group.h"

namespace kinora::shade {

// By ray: its light's controls (null: none), and the masks of what blocks it and of what lets part of it through.
struct GroupState::ControlledShadows {
  const light::ShadowControls* const* of;
  const uint32_t *opaque, *clear;
};

}  // namespace kinora::shade
