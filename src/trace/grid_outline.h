// Where within its box the surface of one patch lies, once its points are known: a box around all of them, and boxes
// around a quarter of its steps each way, in bytes. Rays that pass between the bumps of a patch and the box that was
// made for them in advance are turned away by it without asking for a tessellation: never one that meets it, so that
// what a ray sees does not follow from it.
#pragma once
#include <array>
#include <cstdint>

#include "trace/tessellation.h"

namespace kinora::trace {

class GridOutline {
 public:
  // Grids and agreed edges with less than 2^2 steps have triangles that reach from one of the boxes to another.
  static constexpr int kLeastExponent = 2;
  // Of the finest grid: (2^eu + 1) x (2^ev + 1) points, rows along u, key after key, all of them within the box (lower,
  // then upper).
  void set(int eu, int ev, const Imath::V3f* points, const std::array<float, 6>& box, uint32_t keys = 1);
  // Whether the ray may meet a grid of these points, of every second, fourth, ... of them, at any time: false only if it
  // does not.
  bool mayMeet(const GridRay& ray) const;
  // The same of grids with at least 2^kLeastExponent steps along edges too: more are turned away. box: that of set().
  bool mayMeetFine(const std::array<float, 6>& box, const GridRay& ray) const;

 private:
  static constexpr int kBoxes = 16;
  float all_[6], largest_;                       // around all points: lower, then upper; largestOf() that
  uint8_t lower_[3][kBoxes], upper_[3][kBoxes];  // of 255 parts of the box, by axis
};

}  // namespace kinora::trace
