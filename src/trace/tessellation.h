// One patch at one resolution: a grid of vertices with the normals of the surface there, and a small hierarchy of boxes
// over blocks of 4 x 4 cells. Made by whoever dices patches, held by GeometryCache, immutable. Rays meet it without
// leaks: the test is watertight (S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1),
// 2013), and where the neighbour beyond an edge has fewer steps on it, triangles between the two lines close the gap.
#pragma once
#include <ImathVec.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace kinora::trace {

// A ray as the tests take it.
struct GridRay {
  // The direction need not be unit; t counts its lengths.
  GridRay(const float origin[3], const float direction[3], float tMin, float tMax);
  float o[3], d[3], inverse[3];
  int kx, ky, kz;  // axes, z the one along which the ray goes most
  float sx, sy, sz;
  float tMin, tMax;
};

// By how much a box (lower, then upper) is larger for a ray than it is: beyond rounding of the tests, which is that of the
// numbers they begin with.
float slackOf(const GridRay& ray, const float box[6]);

struct GridHit {
  float t, u, v;  // u, v: over the whole patch, 0..1
  float ng[3];    // of the triangle, as long as twice its area; dP/du x dP/dv by orientation
};

class Tessellation {
 public:
  static constexpr int kMostExponent = 10;  // 2^10 steps along an edge
  struct Deleter {
    void operator()(Tessellation* t) const { destroy(t); }
  };
  using Ptr = std::unique_ptr<Tessellation, Deleter>;
  // points, normals (unit): (2^eu + 1) x (2^ev + 1) of them, rows along u.
  static Ptr make(int eu, int ev, const Imath::V3f* points, const Imath::V3f* normals);
  static size_t bytesFor(int eu, int ev);
  static void destroy(Tessellation* t);

  int eu() const { return eu_; }
  int ev() const { return ev_; }
  size_t bytes() const { return bytesFor(eu_, ev_); }
  Imath::V3f point(uint32_t i, uint32_t j) const;
  Imath::V3f normal(uint32_t i, uint32_t j) const;

  // Nearest hit. steps: exponents along the edges v = 0, u = 1, v = 1, u = 0 that ray and neighbours agree on, not more
  // than those of the grid.
  bool intersect(const GridRay& ray, const std::array<uint8_t, 4>& steps, GridHit* hit) const;

  mutable std::atomic<uint8_t> isUsed{1};  // since the cache looked last

 private:
  Tessellation(int eu, int ev) : eu_(uint8_t(eu)), ev_(uint8_t(ev)) {}
  ~Tessellation() = default;
  friend struct GridView;
  size_t vertices() const { return ((size_t(1) << eu_) + 1) * ((size_t(1) << ev_) + 1); }
  float* plane(int axis) { return reinterpret_cast<float*>(this + 1) + size_t(axis) * vertices(); }
  const float* plane(int axis) const { return reinterpret_cast<const float*>(this + 1) + size_t(axis) * vertices(); }
  uint32_t* normals() { return reinterpret_cast<uint32_t*>(plane(3)); }
  const uint32_t* normals() const { return reinterpret_cast<const uint32_t*>(plane(3)); }
  float* boxes() { return plane(4); }
  const float* boxes() const { return plane(4); }
  bool meetsStitches(int edge, int exponent, const GridRay& ray, GridHit* hit, float* nearest) const;

  uint8_t eu_, ev_;
  float edgeBox_[4][6];
};

// What of a tessellation the kernel of rays reads.
struct GridView {
  explicit GridView(const Tessellation& t)
      : plane{t.plane(0), t.plane(1), t.plane(2)}, boxes(t.boxes()), eu(t.eu_), ev(t.ev_) {}
  const float* plane[3];
  const float* boxes;  // by node: 6 x 4, lower x, y, z, then upper, of four children
  int eu, ev;
};
// A triangle of a cell: (0,0) (1,0) (1,1), or (0,0) (1,1) (0,1).
struct CellHit {
  float t, u, v;  // within the cell
  uint32_t i, j;
  bool isSecond;
};
bool nearestCell(const GridView& grid, const GridRay& ray, float slack, CellHit* hit);

// Blocks of cells, and the levels of boxes over them, root last.
struct GridBlocks {
  GridBlocks(int eu, int ev);
  int levels;                                 // 1: a single block, and no box
  uint32_t width[10], height[10], first[10];  // of blocks, then nodes; first node of a level
  uint32_t nodes;
};

}  // namespace kinora::trace
