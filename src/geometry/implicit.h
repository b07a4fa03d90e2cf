// The field of a Blobby: leaves of bounded reach, combined by operations. Used by blobby.cpp. Reference: rib.md 7.7;
// the ellipsoid's field (1 - r^2)^3 is that of Wyvill, McPheeters and Wyvill 1986.
#pragma once
#include <ImathBox.h>
#include <ImathMatrix.h>
#include <ImathVec.h>
#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace kinora::geometry {

// The surface is where the field has this value: half of an ellipsoid's unit sphere.
inline constexpr double kBlobbyThreshold = 0.421875;

struct ImplicitNode {
  enum class Kind : uint8_t { Constant, Ellipsoid, Segment, Add, Multiply, Max, Min, Subtract, Divide, Negate };
  Kind kind = Kind::Constant;
  uint32_t leaf = 0;  // leaves: which one, for primvars
  double constant = 0;
  Imath::M44d toLeaf;              // object space to the space of the leaf
  Imath::V3d begin{0}, end{0};     // Segment, leaf space
  double radius = 1;               // Segment: reach about it, leaf space
  std::vector<uint32_t> operands;  // indices of earlier nodes
};

struct FieldBounds {
  double low, high;
};

// Nodes in order of evaluation, the last one the root.
struct ImplicitField {
  std::vector<ImplicitNode> nodes;

  // Scratch of evaluation, kept between calls.
  struct Scratch {
    std::vector<double> value;
    std::vector<Imath::V3d> gradient;
    std::vector<FieldBounds> bounds;
    std::vector<uint32_t> newIndex;
  };
  double valueAt(const Imath::V3d& p, Scratch&) const;
  Imath::V3d gradientAt(const Imath::V3d& p, Scratch&) const;
  // How much leaf i matters at p: its own field; weights[leaf], which has a value for each leaf, is added to.
  void leafFields(const Imath::V3d& p, std::vector<double>& weights) const;
  // Bounds of the field over a box, and into `pruned` the nodes that have a say inside it: they give the same values
  // there, bit for bit. `pruned` is left alone when the box cannot hold a piece of the surface.
  FieldBounds boundsOver(const Imath::V3d& centre, const Imath::V3d& half, ImplicitField& pruned, Scratch&) const;
  // A box outside which every leaf but constants is zero.
  Imath::Box3d reach() const;
};

// "" and the field, or what is wrong with the numbers. `said` gets what is left out (repelling planes, plug-ins).
std::string readBlobby(const scene::ParameterList& args, ImplicitField& field, uint32_t& leafCount,
                       std::string& said);

}  // namespace kinora::geometry
