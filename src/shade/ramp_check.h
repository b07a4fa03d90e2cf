// Ramps of patterns that cannot be what was meant: knots that do not ascend, not as many colours as knots. Used by
// MaterialSet; those of light filters say so themselves.
#pragma once
#include "base/diagnostics.h"
#include "scene/scene.h"

namespace kinora::shade {

// Nothing is said of nodes that have no ramp.
void tellOfRamp(const scene::Node& node, Diagnostics& diagnostics);

}  // namespace kinora::shade
