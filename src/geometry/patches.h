// A surface as patches that are diced on demand: the quads of a coarse mesh, each edge with the steps that a DiceRate
// asks for at most, in powers of two, so that coarser grids are parts of finer ones. Who dices a patch finds here which
// sides lie along an edge and around a corner, and so moves the points that they share as one. Made by render/ for
// surfaces whose dicing all at once would be too much; it displaces nothing.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "geometry/mesh.h"
#include "geometry/tessellate.h"

namespace kinora::geometry {

class Patches {
 public:
  static constexpr int kMostExponent = 10;
  static constexpr uint32_t kUnit = 1u << kMostExponent;  // of the steps that places are counted in

  // A place: of patch's parameters (u, v), in units of 1 / kUnit.
  struct Place {
    uint32_t patch;
    uint16_t u, v;
    bool operator==(const Place&) const = default;
  };
  struct Edge {
    uint32_t site[2];  // its ends, rising: points in space
    uint32_t firstSide;
    float size;        // of a step at the finest rate, object units; the largest of all keys
    uint8_t exponent;  // of that rate: the one of the key that asks for most
    bool isJoined;     // sides differ in what they carry: its points are moved as a mean
  };
  // A patch that has the edge or the corner. corner k: (0,0), (1,0), (1,1), (0,1); edge k leads from corner k to the
  // next.
  struct Side {
    uint32_t patch;
    uint8_t number;   // of the edge, or corner, there
    bool isReversed;  // edges: the patch goes along it from site[1]
    uint16_t piece;   // equal ones: the surface is smooth from one to the other
  };

  // `mesh`: without edges that only some faces have, primvars by vertex (refined()); of several keys, points that are
  // one are so at all of them. Faces that are no quads are cut into quads, with all others. Edges are cut by `rate`;
  // where that stops, nothing may be asked of it.
  Patches(Mesh mesh, const DiceRate& rate);

  const std::shared_ptr<Mesh>& mesh() const { return mesh_; }
  uint32_t keyCount() const { return uint32_t(mesh_->keyCount()); }
  uint32_t count() const { return uint32_t(edgesOf_.size()); }
  const std::array<uint32_t, 4>& edgesOf(uint32_t patch) const { return edgesOf_[patch]; }
  const Edge& edge(uint32_t e) const { return edges_[e]; }
  const Side* sides(uint32_t e, uint32_t* count) const {
    *count = edges_[e + 1].firstSide - edges_[e].firstSide;
    return &edgeSides_[edges_[e].firstSide];
  }
  const Side* around(uint32_t site, uint32_t* count, bool* isJoined) const {
    *count = firstAtSite_[site + 1].first - firstAtSite_[site].first;
    *isJoined = firstAtSite_[site].isJoined;
    return &siteSides_[firstAtSite_[site].first];
  }
  uint32_t siteOf(uint32_t patch, int corner) const { return siteOfVertex_[vertexOf(patch, corner)]; }
  float sizeAt(uint32_t site) const { return firstAtSite_[site].size; }
  uint32_t vertexOf(uint32_t patch, int corner) const { return mesh_->indices[Mesh::quadCorner(2 * patch, corner)]; }
  // Exponents of the finest grid.
  int eu(uint32_t patch) const {
    return std::max(edges_[edgesOf_[patch][0]].exponent, edges_[edgesOf_[patch][2]].exponent);
  }
  int ev(uint32_t patch) const {
    return std::max(edges_[edgesOf_[patch][1]].exponent, edges_[edgesOf_[patch][3]].exponent);
  }
  uint64_t triangles() const;  // of all finest grids
  uint64_t bytes() const;

  // The place on a side of an edge that lies `t` (of kUnit) from site[0].
  static Place onEdge(const Side& side, uint32_t t);
  static Place atCorner(const Side& side);

 private:
  struct Site {
    uint32_t first;
    float size;
    bool isJoined;
  };
  void splitIntoQuads();
  void findEdges(const DiceRate& rate);
  void findSites();
  bool isSmooth(uint32_t a, uint32_t b) const;

  std::shared_ptr<Mesh> mesh_;
  std::vector<std::array<uint32_t, 4>> edgesOf_;  // by patch
  std::vector<Edge> edges_;                       // one more at the end
  std::vector<Side> edgeSides_, siteSides_;
  std::vector<Site> firstAtSite_;  // one more at the end
  std::vector<uint32_t> siteOfVertex_;
};

}  // namespace kinora::geometry
