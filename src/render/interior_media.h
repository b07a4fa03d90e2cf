// Surfaces that enclose a medium which scatters (cloudy glass): their objects are two, the surface and, of the same
// shape, what fills it (InteriorMedium). The scene that is said knows of one; what is built has both.
#pragma once
#include <map>

#include "base/diagnostics.h"
#include "plugin/registry.h"
#include "scene/scene.h"

namespace kinora::render {

class InteriorMedia {
 public:
  // The scene with those media, which holds until the next call; the scene itself where there are none. Primitives that
  // were asked about before, and are the same, become the same again.
  const scene::Scene& addTo(const scene::Scene& scene, Registry& registry, Diagnostics& diagnostics);
  void forget() { *this = {}; }

 private:
  struct Halves {
    scene::PrimitivePtr whole, surface, medium;
  };
  struct Networks {
    scene::NetworkPtr whole, surface, medium;  // medium null: there is none
  };
  const Networks& networksOf(const scene::NetworkPtr& network, Registry& registry, Diagnostics& diagnostics);
  bool hasAny(const std::vector<scene::PrimitivePtr>& primitives, Registry& registry, Diagnostics& diagnostics);
  void split(std::vector<scene::PrimitivePtr>& primitives, std::map<const scene::Primitive*, Halves>& halves,
             Registry& registry, Diagnostics& diagnostics);

  std::map<const scene::Network*, Networks> networks_;
  std::map<const scene::Primitive*, Halves> halves_;
  scene::Scene scene_;
};

}  // namespace kinora::render
