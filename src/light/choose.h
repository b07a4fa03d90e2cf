// The wide kernels that walk the light tree: which light a point samples, and how likely a given light was. Both read
// one function of (node, point, normal), so that they agree to the bit. Internal to light/.
#pragma once
#include <cstdint>

#include "light/light_tree.h"
#include "light/link_sets.h"

namespace kinora::light {

// What stands between a light and the point is not known, and the brightest light may be the one in shadow: each top
// node gets, beside its share s, this times the root of s.
inline constexpr float kRootShare = 0.1f;

// For points on their way down a deep tree.
struct ChooseScratch {
  static constexpr uint32_t kWords = 15, kLists = 5;
  float* words;     // kLists times kWords arrays of `room`
  uint32_t room;    // points, padded, and a full vector more
  uint32_t* parts;  // 10 for each point
};

struct ChooseArgs {
  const LightTree* tree;
  const LinkSets* links;
  uint32_t n;
  const float* P[3];
  const float* N[3];        // null: points in space. Length 1: lit from this side; 1/2: from both, less from behind;
                            // 0: from all sides
  const uint32_t* linkSet;  // null: all in set 0
  const float* weights;     // factors on top nodes, by row and node; null: none
  const uint32_t* row;
  const float* u[2];      // choose
  uint32_t* light;        // choose: out, kNone where no light reaches the point; density: in
  float* probability;     // out
  uint32_t* top;          // choose: out, which top node; null: not wanted
  float* chance;          // choose: out, its probability over its share in all importances, without factors
  ChooseScratch scratch;  // choose, where the tree is deep
  const void* data;       // choose, where the tree is deep: what is wanted next of the lights, each of dataSize bytes
  size_t dataSize;
};
inline constexpr uint32_t kNone = LightTree::kNone;
using ChooseKernel = void (*)(const ChooseArgs&);
ChooseKernel chooseKernel(uint32_t width);       // arrays of padded length
ChooseKernel probabilityKernel(uint32_t width);  // a light that is not linked, or does not reach: 0

}  // namespace kinora::light
