// Which lights may light an object: sets of lights over the nodes of the light tree, a bit a node, that of an inner
// node being set where some light below it is in the set. Kept in runs of 1024 bits that sets share where they are
// alike, so that a set which leaves out a few of many lights costs little.
#pragma once
#include <cstdint>
#include <vector>

#include "light/light_tree.h"

namespace kinora::light {

class LinkSets {
 public:
  static constexpr uint32_t kRunBits = 10, kRunWords = (1u << kRunBits) / 32;

  LinkSets() = default;
  // Each list holds the lights of a set.
  LinkSets(const LightTree& tree, const std::vector<std::vector<uint32_t>>& lists);

  uint32_t count() const { return count_; }
  bool areAllWhole() const { return areAllWhole_; }  // every set holds every light
  bool has(uint32_t set, uint32_t node) const {
    return words_[runs_[set * runsOfSet_ + (node >> kRunBits)] + ((node & ((1u << kRunBits) - 1)) >> 5)] >>
               (node & 31) &
           1;
  }
  // For kernels: words()[runs()[set * runsOfSet() + (node >> kRunBits)] + word] holds 32 nodes.
  const uint32_t* runs() const { return runs_.data(); }
  const uint32_t* words() const { return words_.data(); }
  uint32_t runsOfSet() const { return runsOfSet_; }
  size_t bytes() const { return (runs_.size() + words_.size()) * sizeof(uint32_t); }

 private:
  uint32_t count_ = 0, runsOfSet_ = 0;
  bool areAllWhole_ = true;
  std::vector<uint32_t> runs_, words_;
};

}  // namespace kinora::light
