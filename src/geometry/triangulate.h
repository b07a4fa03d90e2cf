// Cuts one polygon, concave and with holes, into triangles. Used by polygons and by cages that cannot be subdivided.
// Ear clipping over a grid of the corners that can block an ear, holes joined by bridges: near n log n on real
// polygons, bounded on all. Corners keep their identity (none is added or moved), so neighbours that share an edge
// stay watertight.
#pragma once
#include <ImathVec.h>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace kinora::geometry {

class Triangulator {
 public:
  enum class Outcome {
    Good,
    Tangled,  // crosses itself or has holes outside: covered as well as its corners can, no triangle faces backwards
    NoArea,   // nothing was made
  };
  // `corners` holds all loops one after the other, the outer one first; loops may run either way, the outer one
  // decides which way the triangles run. Appends 3 indices into `corners` a triangle.
  Outcome run(std::span<const Imath::V3d> corners, std::span<const int> loopSizes, std::vector<uint32_t>& triangles);

 private:
  struct Node {
    double x, y;
    uint32_t corner;
    int prev, next;
    bool blocker = false;  // not strictly convex when the grid was made
  };
  bool project(std::span<const Imath::V3d> corners, int outerSize);
  int addLoop(std::span<const Imath::V3d> corners, int first, int size, bool hole);
  bool bridge(int outer, int hole, int holeSize);
  int openCorner(int outer, int at, int seen);
  void splice(int target, int hole);
  void buildGrid(int start, int count);
  bool isEar(int node, bool strict);
  bool clip(int start, int count, std::vector<uint32_t>& triangles);
  void unlink(int node);
  double turn(int a, int b, int c) const;
  double turnAt(int node) const { return turn(nodes_[node].prev, node, nodes_[node].next); }
  bool same(int a, int b) const { return nodes_[a].x == nodes_[b].x && nodes_[a].y == nodes_[b].y; }

  int axisX_ = 0, axisY_ = 1;
  Imath::V3d base_;
  std::vector<Node> nodes_;
  std::map<std::pair<double, double>, int> ring_;  // a node at each place of the ring, while holes are joined
  std::vector<int> cellStart_, cellNodes_, blockers_;
  int cellsX_ = 0, cellsY_ = 0;
  double minX_ = 0, minY_ = 0, perX_ = 0, perY_ = 0;
  int64_t work_ = 0, workLimit_ = 0;
};

}  // namespace kinora::geometry
