// Parameters of materials and patterns that a scene sets in vain: those whose help begins with kNoEffect. Lights,
// cameras and integrators say the same by themselves (NamedValues::warnNoEffect). Used by MaterialSet.
#pragma once
#include <kinora/plugin.h>

#include <set>
#include <utility>

#include "base/diagnostics.h"
#include "plugin/registry.h"
#include "scene/scene.h"

namespace kinora::shade {

class NoEffect {
 public:
  // Of all nodes of a network as the scene has it. Each parameter of a plug-in is told once, not once an object.
  void tell(const scene::Network& network, Kind terminal, Registry& registry, Diagnostics& diagnostics);

 private:
  std::set<std::pair<const Descriptor*, uint32_t>> told_;
};

}  // namespace kinora::shade
