// Solids (SolidBegin ... SolidEnd) as the world wants them: a tree of operations for each that is placed, with an
// object's own solids grown into the one that its instance stands in. Used while a scene is flattened.
#pragma once
#include <cstdint>
#include <vector>

#include "base/diagnostics.h"
#include "scene/scene.h"
#include "trace/world.h"

namespace kinora::render {

class SolidTrees {
 public:
  // A block of a placed solid; without one: what stands there bounds nothing.
  struct Place {
    uint32_t solid = trace::kNoSolid, node = 0;
  };
  explicit SolidTrees(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  // Of the solids of a scene, or of an object that is placed at `around`: the place of each.
  std::vector<Place> open(const std::vector<scene::Solid>& solids, const Place& around);
  // Whether what is inside there is taken away from the whole, so that surfaces show their other side.
  bool isTurned(const Place& p) const { return p.solid != trace::kNoSolid && trees_[p.solid].nodes[p.node].isTurned; }
  // A surface that is placed there. The world's number of the leaf follows in finish().
  trace::Solids::Member add(const Place& p, const scene::Transform& toRender);
  // Messages of what cannot be resolved, whose surfaces are members of nothing then. `places`: where each solid stands
  // in files.
  std::vector<trace::SolidInput> finish(std::vector<SourcePos>& places);
  // After finish(): what add() gave, with the world's number of the leaf.
  trace::Solids::Member resolved(const trace::Solids::Member& added) const;

 private:
  using Operation = scene::Solid::Operation;
  struct Node {
    Operation operation;
    SourcePos pos;
    trace::SolidNode in;  // its parent and how it joins that
    uint32_t children = 0, surfaces = 0;
    bool isTurned = false, isAlive = false;
  };
  struct Tree {
    std::vector<Node> nodes;
    bool isInReach = true;  // of rays that stay in the surfaces' own spaces
  };
  Place addNode(const scene::Solid& solid, const Place& parent);
  // False: it means nothing.
  bool check(Tree& tree) const;

  Diagnostics& diagnostics_;
  std::vector<Tree> trees_;
  std::vector<std::vector<uint32_t>> leafOf_;  // by tree and node; empty: its surfaces are members of nothing
};

}  // namespace kinora::render
