// The solids of a World: which placements bound them, and which of them are none, since a surface of theirs has a hole.
// How rays meet them is of solids.cpp.
#include <algorithm>
#include <cmath>
#include <map>

#include "trace/embree_device.h"
#include "trace/world_part.h"

namespace kinora::trace {

void World::buildSolids(const std::vector<SolidInput>& inputs, const PlacementSource& placements) {
  solids_ = std::make_unique<Solids>(inputs);
  std::map<std::pair<uint32_t, uint32_t>, std::vector<uint32_t>> topsOfLeaf;  // solid and leaf
  for (uint32_t top = 0; top < instanceOfTop_.size(); ++top) {
    if (instanceOfTop_[top] == kNone || (!isLost_.empty() && isLost_[instanceOfTop_[top]])) continue;
    const Solids::Member member = placements[instance_[instanceOfTop_[top]].user].member;
    if (member.solid == kNoSolid) continue;
    solids_->add(top, member, makeInstance(top));
    topsOfLeaf[{member.solid, member.leaf}].push_back(top);
  }
  solids_->commit();
  throwIfRefused();
  uint32_t open = kNoSolid;  // the last that was found to be
  for (const auto& [leaf, tops] : topsOfLeaf) {
    if (leaf.first == open || !isOpen({leaf.first, leaf.second}, tops)) continue;
    open = leaf.first;
    openSolids_.push_back({open, instance_[instanceOfTop_[tops[0]]].user});
  }
  for (const OpenSolid& s : openSolids_) solids_->dissolve(s.solid);
  std::vector<uint32_t> first(inputs.size(), kNone);
  for (uint32_t i = 0; i < instances_->size(); ++i) bodies_.push_back(i);
  for (uint32_t top = 0; top < instanceOfTop_.size(); ++top) {
    const uint32_t solid = solids_->memberOf(top).solid;
    if (solid == kNoSolid) continue;
    if (first[solid] == kNone) first[solid] = instanceOfTop_[top];
    bodies_[instanceOfTop_[top]] = first[solid];
  }
}

// Lines through middles of triangles, which meet the leaf for certain: each leaves a closed one as often as it enters.
// A few may slip through a seam between surfaces that were diced apart.
bool World::isOpen(const Solids::Member& leaf, const std::vector<uint32_t>& tops) const {
  const auto lines = uint32_t(std::clamp<size_t>(4 * tops.size(), 128, 1024));
  float lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (const uint32_t top : tops) {
    const Part& part = *parts_[partOfTop_[top]];
    if (part.hasUser || part.meshes[0]->isStrand()) return true;
    for (int c = 0; c < 8; ++c) {
      const float q[3] = {c & 1 ? part.upper[0] : part.lower[0], c & 2 ? part.upper[1] : part.lower[1],
                          c & 4 ? part.upper[2] : part.lower[2]};
      float r[3];
      keys(instance_[instanceOfTop_[top]])->point(q, r);
      for (int k = 0; k < 3; ++k) {
        lower[k] = std::min(lower[k], r[k]);
        upper[k] = std::max(upper[k], r[k]);
      }
    }
  }
  float length = 0;
  for (int k = 0; k < 3; ++k) length += upper[k] - lower[k];
  if (!std::isfinite(length)) return true;
  uint32_t met = 0, odd = 0;
  uint32_t drawn = 0;
  const auto next = [&] { return hashWords(0, drawn++) >> 8; };  // the same lines for each world
  for (uint32_t i = 0; i < lines; ++i) {
    const uint32_t top = tops[i % tops.size()];
    const geometry::Mesh& mesh = *parts_[partOfTop_[top]]->meshes[0];
    float d[3], size = 0;
    for (float& x : d) {
      x = float(next()) * (2.f / 16777216.f) - 1.f;
      size += x * x;
    }
    if (!mesh.triangleCount() || !(size > 1e-4f)) continue;
    const size_t triangle = next() % mesh.triangleCount();
    const Imath::V3f middle = (mesh.points[mesh.indices[3 * triangle]] + mesh.points[mesh.indices[3 * triangle + 1]] +
                               mesh.points[mesh.indices[3 * triangle + 2]]) /
                              3.f;
    const float inObject[3] = {middle.x, middle.y, middle.z};
    float o[3];
    keys(instance_[instanceOfTop_[top]])->point(inObject, o);
    for (int k = 0; k < 3; ++k) {
      d[k] /= std::sqrt(size);
      o[k] -= d[k] * length;
    }
    bool hits;
    odd += solids_->isOdd(leaf, o, d, besideFlatMoments(0.f), &hits);
    met += hits;
  }
  return met == 0 || odd * 32 > met;
}

}  // namespace kinora::trace
