// The part of a grid over the unit square that closed loops leave, cell by cell. Plane geometry only: used by the
// maker of patches, which puts the result onto its surface. Cells that no loop passes stay whole; the others become
// triangles whose corners are shared with all neighbours, so that nothing cracks.
#pragma once
#include <ImathVec.h>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kinora::geometry {

// Closed loops in the unit square: each one's last point is joined to its first.
using TrimLoops = std::vector<std::vector<Imath::V2d>>;

struct TrimmedCells {
  enum Kind : uint8_t { Gone, Whole, Cut };
  std::vector<Kind> kind;             // a cell, u fastest
  std::vector<uint32_t> first;        // a cell and one more: its triangles, by their number
  std::vector<Imath::V2d> triangles;  // three corners each, counter-clockwise; of cells that are Cut
  bool crosses = false;               // a loop crosses itself or another one
  bool tooMuch = false;               // the loops are beyond what can be cut in reasonable time; the rest is empty
};

// A point is inside where a ray from it meets the loops an odd number of times. `u` and `v` are the lines of the grid,
// rising from 0 to 1. Places on the loops are rounded to 1/4096 of a cell.
TrimmedCells trimCells(const TrimLoops& loops, bool keepInside, std::span<const double> u, std::span<const double> v);

}  // namespace kinora::geometry
