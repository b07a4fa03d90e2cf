// Constructive solid geometry, resolved at hits: closed surfaces are the leaves of a solid's tree of operations, and a
// ray sees of them what lies on the boundary of the composed solid. Each surface carries a filter that Embree asks
// about a candidate for a hit; the answer follows from how often lines through the point cross each leaf. It depends
// on ray and candidate alone. Made by World for solids of the scene; other geometry never comes here.
#pragma once
#include <embree3/rtcore.h>

#include <cstdint>
#include <vector>

namespace kinora::trace {

inline constexpr uint32_t kNoSolid = ~0u;
inline constexpr uint32_t kMostSolidNodes = 8192;  // of one solid: a hit evaluates all of them

// One node of a solid's tree. Parents stand before their children, the first node is the root.
struct SolidNode {
  enum class Joins : uint8_t { Or, And, AndNot };  // what its parent has so far
  uint32_t parent = 0;
  Joins joins = Joins::Or;
  bool isFull = false;       // all of space, before children join it
  uint32_t leaf = kNoSolid;  // what this closed surface encloses belongs to it
};
struct SolidInput {
  std::vector<SolidNode> nodes;  // at most kMostSolidNodes
  uint32_t leaves = 0;
};

// The solids of one world.
class Solids {
 public:
  struct Member {
    uint32_t solid = kNoSolid, leaf = 0;
  };

  explicit Solids(const std::vector<SolidInput>& inputs);
  ~Solids();
  Solids(const Solids&) = delete;
  Solids& operator=(const Solids&) = delete;

  // A surface of a leaf: `instance`, which is not committed yet, places it in render space, and is number `top` of
  // the world's top level. Takes the reference.
  void add(uint32_t top, const Member& member, RTCGeometry instance);
  void commit();
  // Its surfaces are from now on drawn as they are.
  void dissolve(uint32_t solid);
  // Whether a line crosses a leaf an odd number of times, which no line through a closed surface does. `hits`: whether
  // it meets the leaf at all.
  bool isOdd(const Member& member, const float o[3], const float d[3], float time, bool* hits) const;
  // Whether the point at distance t of a ray, on a surface of `member`, lies on its solid's boundary.
  bool keeps(const Member& member, const float o[3], const float d[3], float t, float time) const;
  Member memberOf(uint32_t top) const { return top < ofTop_.size() ? ofTop_[top] : Member(); }

  // For the surfaces of leaves.
  static void setFilters(RTCGeometry geometry);

 private:
  struct Solid {
    std::vector<SolidNode> nodes;
    uint32_t words = 0;  // of a set of leaves
    RTCScene scene = nullptr;
    std::vector<uint32_t> leafOf;  // by instance of the scene
  };
  struct LeafSet;
  struct Crossings;
  static void filter(const RTCFilterFunctionNArguments* a);
  static void cross(const Solid& solid, const float o[3], const float d[3], float time, Crossings& crossings);
  static bool contains(const Solid& solid, const uint64_t* leaves);

  std::vector<Solid> solids_;
  std::vector<Member> ofTop_;
};

}  // namespace kinora::trace
