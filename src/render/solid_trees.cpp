#include "render/solid_trees.h"

#include <cmath>
#include <string>

namespace kinora::render {

namespace {

constexpr const char* kAsTheyAre = "its surfaces are drawn as they are";

// Surfaces of solids keep spaces of their own, in which Embree takes no ray whose numbers are beyond 1e18.
bool isInReach(const scene::Transform& toRender) {
  constexpr double kMost = 1e9;
  for (const scene::Matrix& m : toRender.matrices) {
    if (!(std::fabs(m.determinant()) > 1e-100)) return false;
    const scene::Matrix inverse = m.inverse();
    for (int i = 0; i < 16; ++i)
      if (!(std::fabs(m[i / 4][i % 4]) < kMost && std::fabs(inverse[i / 4][i % 4]) < kMost)) return false;
  }
  return true;
}

}  // namespace

SolidTrees::Place SolidTrees::addNode(const scene::Solid& solid, const Place& parent) {
  using Joins = trace::SolidNode::Joins;
  Node node{solid.operation, solid.pos, {}, 0, 0, false, false};
  node.in.isFull = solid.operation == Operation::Intersection || solid.operation == Operation::Difference;
  if (parent.solid == trace::kNoSolid) {
    trees_.emplace_back().nodes.push_back(std::move(node));
    return {uint32_t(trees_.size() - 1), 0};
  }
  std::vector<Node>& nodes = trees_[parent.solid].nodes;
  Node& whole = nodes[parent.node];
  node.in.parent = parent.node;
  if (whole.operation == Operation::Intersection)
    node.in.joins = Joins::And;
  else if (whole.operation == Operation::Difference)
    node.in.joins = whole.children == 0 ? Joins::And : Joins::AndNot;
  node.isTurned = whole.isTurned != (node.in.joins == Joins::AndNot);
  ++whole.children;
  nodes.push_back(std::move(node));
  return {parent.solid, uint32_t(nodes.size() - 1)};
}

std::vector<SolidTrees::Place> SolidTrees::open(const std::vector<scene::Solid>& solids, const Place& around) {
  std::vector<Place> places;
  places.reserve(solids.size());
  for (const scene::Solid& s : solids) {
    // an edit may leave one without the solid that it was a part of: it stands for itself
    const bool isOperand = s.parent > 0 && s.parent <= places.size();
    places.push_back(addNode(s, isOperand ? places[s.parent - 1] : around));
  }
  return places;
}

trace::Solids::Member SolidTrees::add(const Place& p, const scene::Transform& toRender) {
  if (p.solid == trace::kNoSolid) return {};
  trees_[p.solid].isInReach &= isInReach(toRender);
  ++trees_[p.solid].nodes[p.node].surfaces;
  return {p.solid, p.node};
}

bool SolidTrees::check(Tree& tree) const {
  std::vector<Node>& nodes = tree.nodes;
  std::vector<uint32_t> alive(nodes.size(), 0);  // children
  std::vector<bool> hasFirst(nodes.size(), false);
  for (size_t i = nodes.size(); i-- > 0;) {
    Node& n = nodes[i];
    n.isAlive = n.surfaces > 0 || alive[i] > 0;
    if (!n.isAlive || i == 0) continue;
    ++alive[n.in.parent];
    if (n.in.joins == trace::SolidNode::Joins::And) hasFirst[n.in.parent] = true;
  }
  if (!tree.isInReach) {
    diagnostics_.warning("RENDER-SOLID", nodes[0].pos,
                         "a part of a solid is a billion times larger or smaller than it was made, or as far away",
                         kAsTheyAre);
    return false;
  }
  if (nodes.size() > trace::kMostSolidNodes) {
    diagnostics_.warning(
        "RENDER-SOLID", nodes[0].pos,
        "a solid has " + std::to_string(nodes.size()) + " parts, more than " + std::to_string(trace::kMostSolidNodes),
        kAsTheyAre);
    return false;
  }
  bool isSound = true;
  for (size_t i = 0; i < nodes.size(); ++i) {
    const Node& n = nodes[i];
    if (!n.isAlive || n.operation != Operation::Difference) continue;
    if (!hasFirst[i]) {
      diagnostics_.warning("RENDER-SOLID", n.pos, "a difference has nothing to take away from", kAsTheyAre,
                           "its first operand is what the others are taken away from");
      isSound = false;
    } else if (n.children == 1) {
      diagnostics_.warning("RENDER-SOLID", n.pos, "a difference has one operand", "nothing is taken away from it");
    }
  }
  for (const Node& n : nodes)
    if (!n.isAlive && n.children == 0)
      diagnostics_.warning("RENDER-SOLID", n.pos, "a solid holds no surface", "it is left out");
  return isSound && nodes[0].isAlive;
}

std::vector<trace::SolidInput> SolidTrees::finish(std::vector<SourcePos>& places) {
  std::vector<trace::SolidInput> solids(trees_.size());
  leafOf_.resize(trees_.size());
  for (size_t k = 0; k < trees_.size(); ++k) {
    Tree& tree = trees_[k];
    places.push_back(tree.nodes[0].pos);
    if (!check(tree)) continue;
    trace::SolidInput& to = solids[k];
    std::vector<uint32_t> numberOf(tree.nodes.size(), 0);
    leafOf_[k].assign(tree.nodes.size(), trace::kNoSolid);
    for (size_t i = 0; i < tree.nodes.size(); ++i) {
      const Node& n = tree.nodes[i];
      if (!n.isAlive) continue;
      numberOf[i] = uint32_t(to.nodes.size());
      trace::SolidNode& node = to.nodes.emplace_back(n.in);
      node.parent = numberOf[n.in.parent];
      if (n.surfaces > 0) leafOf_[k][i] = node.leaf = to.leaves++;
    }
  }
  return solids;
}

trace::Solids::Member SolidTrees::resolved(const trace::Solids::Member& added) const {
  if (added.solid == trace::kNoSolid || leafOf_[added.solid].empty()) return {};
  return {added.solid, leafOf_[added.solid][added.leaf]};
}

}  // namespace kinora::render
