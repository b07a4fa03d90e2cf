// Worlds of a few meshes, for tests of trace/: each is a part of its own, over a shutter from 0 to 1.
#pragma once
#include <memory>
#include <utility>
#include <vector>

#include "trace/world.h"

namespace kinora::trace::test {

struct Placed {
  std::shared_ptr<geometry::Mesh> mesh;  // copied
  scene::Transform toRender;
  Solids::Member member;
};

inline std::shared_ptr<const World> worldOf(const std::vector<Placed>& all,
                                            const std::vector<SolidInput>& solids = {}) {
  std::vector<ShapeInput> shapes;
  std::vector<PartInput> parts;
  std::vector<PlacementInput> placements;
  for (uint32_t i = 0; i < all.size(); ++i) {
    ShapeInput s;
    s.key = i + 1;
    s.mesh = std::make_shared<geometry::Mesh>(*all[i].mesh);
    shapes.push_back(std::move(s));
    PartInput p;
    p.key = i + 1;
    p.shapes = {i};
    parts.push_back(p);
    PlacementInput place;
    place.part = i;
    place.toRender = all[i].toRender;
    place.member = all[i].member;
    placements.push_back(std::move(place));
  }
  BuildOptions options;
  options.shutterClose = 1;
  BuildCounters counters;
  return World::build(std::move(shapes), std::move(parts), std::move(placements), options, nullptr, counters, solids);
}

}  // namespace kinora::trace::test
