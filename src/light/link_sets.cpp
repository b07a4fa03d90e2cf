#include "light/link_sets.h"

#include <algorithm>
#include <array>
#include <map>

namespace kinora::light {

LinkSets::LinkSets(const LightTree& tree, const std::vector<std::vector<uint32_t>>& lists)
    : count_(uint32_t(lists.size())) {
  const TreeNode* nodes = tree.nodes();
  const uint32_t count = tree.nodeCount();
  const std::vector<LightTree::Place>& places = tree.places();
  uint32_t lit = 0;
  for (const LightTree::Place& p : places) lit += p.leaf != LightTree::kNone;
  runsOfSet_ = std::max<uint32_t>(1, uint32_t((count + (1u << kRunBits) - 1) >> kRunBits));
  std::map<std::array<uint32_t, kRunWords>, uint32_t> known;
  std::vector<uint32_t> bits;
  for (const std::vector<uint32_t>& list : lists) {
    uint32_t found = 0;
    for (const uint32_t l : list) found += places[l].leaf != LightTree::kNone;
    const bool isWhole = found == lit;
    areAllWhole_ = areAllWhole_ && isWhole;
    bits.assign(size_t(runsOfSet_) * kRunWords, isWhole ? ~0u : 0u);
    if (!isWhole) {
      for (const uint32_t l : list)
        if (const uint32_t leaf = places[l].leaf; leaf != LightTree::kNone) bits[leaf >> 5] |= 1u << (leaf & 31);
      // children stand behind their parents
      for (uint32_t i = count; i-- > 0;) {
        const TreeNode& n = nodes[i];
        if ((n.child & kLeaf) || !(n.weight > 0)) continue;
        const uint32_t a = n.child, b = n.child + 1;
        if ((bits[a >> 5] >> (a & 31) | bits[b >> 5] >> (b & 31)) & 1) bits[i >> 5] |= 1u << (i & 31);
      }
    }
    for (uint32_t r = 0; r < runsOfSet_; ++r) {
      std::array<uint32_t, kRunWords> run;
      std::copy_n(bits.begin() + long(r) * kRunWords, kRunWords, run.begin());
      const auto [it, isNew] = known.try_emplace(run, uint32_t(words_.size()));
      if (isNew) words_.insert(words_.end(), run.begin(), run.end());
      runs_.push_back(it->second);
    }
  }
}

}  // namespace kinora::light
