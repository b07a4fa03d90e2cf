// The tree by which lights are chosen: each node bounds where the lights below it stand, to where they emit and how
// brightly, so that the irradiance that they could bring to a point can be estimated without looking at them (after
// Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", HPG 2018). Infinite
// lights are nodes too. Built once a world; choose.h walks it.
#pragma once
#include <kinora/integrator.h>
#include <kinora/light.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <vector>

namespace kinora::light {

// A node as the kernels read it; siblings lie side by side.
struct TreeNode {
  float center[3];   // of the box; infinite lights: mean direction, as in LightDescription
  float weight;      // largest radiant intensity; infinite lights: largest irradiance. Over that of all lights
  uint32_t extent;   // half the box along x and y, 14 bits each: floats without sign and low digits; NodeFlags
  uint32_t extentZ;  // the same along z; two flags below; high half: cosine of the angle of normals, times 32767
  uint32_t axis;     // three times 8 signed bits; high 8: cosine of the angle of emission, times 127
  uint32_t child;    // the first of two, or kLeaf and the light's index
};
static_assert(sizeof(TreeNode) == 32);
inline constexpr uint32_t kLeaf = 0x80000000u;
enum NodeFlags : uint32_t { kNodeInfinite = 1u << 30, kNodeTwoSided = 1u << 31 };
// In extentZ: the lights below emit alike, so that from afar they differ in power alone.
inline constexpr uint32_t kNodeUniform = 1u << 14;
// And: they emit to all sides.
inline constexpr uint32_t kNodeAround = 1u << 15;
inline constexpr uint32_t kExtentBits = 14, kExtentMask = (1u << kExtentBits) - 1;
// By which a cosine to the axis may be off, for want of digits.
inline constexpr float kAxisSlack = 0.008f;

// The top of the tree, whose nodes are weighed all at once: with few lights the whole of it.
inline constexpr uint32_t kMostTop = kLightClusters;
struct TopNode {
  float center[3], half[3], weight, axis[3], cosNormals, sinNormals, cosEmission, concentration;
  uint32_t isInfinite, isTwoSided, isUniform, isAround;
  uint32_t node, end, start;  // end: of the nodes below it; start: its first light in the order of the tree
};

void useLargePages(void* memory, size_t bytes);  // asks the system, which may not

// Siblings share a line of the cache; large trees lie on large pages, for each step of a walk is on another one.
template <class T>
struct LineAllocator {
  using value_type = T;
  static constexpr std::align_val_t kLine{64}, kLargePage{2 << 20};
  LineAllocator() = default;
  template <class U>
  LineAllocator(const LineAllocator<U>&) {}
  static std::align_val_t alignmentOf(size_t n) { return n * sizeof(T) < size_t(kLargePage) ? kLine : kLargePage; }
  T* allocate(size_t n) {
    void* p = ::operator new(n * sizeof(T), alignmentOf(n));
    if (alignmentOf(n) == kLargePage) useLargePages(p, n * sizeof(T));
    return static_cast<T*>(p);
  }
  void deallocate(T* p, size_t n) { ::operator delete(p, alignmentOf(n)); }
  friend bool operator==(const LineAllocator&, const LineAllocator&) { return true; }
};

class LightTree {
 public:
  // Where a light hangs: which child at each step below a top node, first step in the lowest bit, and where it stands
  // among all lights in the order of the tree.
  struct Place {
    uint32_t leaf = kNone;  // node; kNone: the light is black and not in the tree
    uint32_t path = 0;
    uint32_t position = 0;
  };
  static constexpr uint32_t kNone = 0xffffffffu;

  LightTree() = default;
  // Lights without power have no place.
  explicit LightTree(std::span<const LightDescription> lights);

  const TreeNode* nodes() const { return nodes_.data(); }
  uint32_t nodeCount() const { return uint32_t(nodes_.size()); }
  const TopNode* top() const { return top_.data(); }
  uint32_t topCount() const { return topCount_; }
  const std::vector<Place>& places() const { return places_; }
  // Lights in the order of the tree, those below any node side by side, with the sums of the power of those before
  // each, by which they are chosen below nodes of finite lights that are far: in units of which each has one at least,
  // below 2^31. One more at the end. Deep trees only.
  struct Power {
    uint32_t sum, light;
  };
  const Power* powers() const { return powers_.data(); }
  // Where to look for a sum: the last light before which there are at most g << guideShift(), for each g.
  const uint32_t* guide() const { return guide_.data(); }
  uint32_t guideShift() const { return guideShift_; }
  size_t powerBytes() const { return powers_.size() * sizeof(Power) + guide_.size() * sizeof(uint32_t); }
  bool isDeep() const { return isDeep_; }  // some top node has children

 private:
  friend class TreeBuilder;
  void chooseTop(uint32_t finiteEnd);
  void sumPowers(uint32_t finiteCount);
  std::vector<TreeNode, LineAllocator<TreeNode>> nodes_;
  std::vector<Place> places_;
  std::array<TopNode, kMostTop> top_{};
  uint32_t topCount_ = 0;
  bool isDeep_ = false;
  std::vector<Power, LineAllocator<Power>> powers_;
  std::vector<uint32_t, LineAllocator<uint32_t>> guide_;
  uint32_t guideShift_ = 0;
};

}  // namespace kinora::light
