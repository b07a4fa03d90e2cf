// One patch at one resolution: a grid of vertices with the normals of the surface there, and a small hierarchy of boxes
// over blocks of 4 x 4 cells; of a surface that deforms, all that at each of its keys, between which a ray meets the
// cells, and asks the boxes, where they are at its time. Made by whoever dices patches, held by GeometryCache,
// immutable. Rays meet it without leaks: the test is watertight (S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle
// Intersection", JCGT 2(1), 2013), and where the neighbour beyond an edge has fewer steps on it, triangles between the two lines close the gap.
#pragma once
#include <ImathVec.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace kinora::trace {

// Between two of the keys that lie at even distances over the shutter: at or behind `key`, by a part of the way to the
// next. Of one key there is nothing between.
struct Moment {
  uint32_t key = 0;
  float part = 0;
  float mix(float a, float b) const { return a + (b - a) * part; }
};
// time: 0..1 over the shutter, held outside.
inline Moment momentAt(float time, uint32_t keys) {
  if (keys < 2) return {};
  const float x = (time > 0.f ? time < 1.f ? time : 1.f : 0.f) * float(keys - 1);
  const uint32_t key = std::min(uint32_t(x), keys - 2);
  return {key, x - float(key)};
}

// A ray as the tests take it.
struct GridRay {
  // The direction need not be unit; t counts its lengths. time: 0..1 over the shutter.
  GridRay(const float origin[3], const float direction[3], float tMin, float tMax, float time = 0);
  float o[3], d[3], inverse[3];
  int kx, ky, kz;  // axes, z the one along which the ray goes most
  float sx, sy, sz;
  float tMin, tMax, time;
  float largest;  // coordinate of the origin, whatever its sign
};

// The largest of a box's numbers (lower, then upper), whatever their sign.
float largestOf(const float box[6]);
// By how much a box is larger for a ray than it is: beyond rounding of the tests, which is that of the numbers they begin
// with. largest: largestOf() it.
float slackOf(const GridRay& ray, float largest);
// Whether the ray meets the box, larger by that.
bool meetsBox(const GridRay& ray, const float box[6], float slack);

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
  // points, normals (unit): (2^eu + 1) x (2^ev + 1) of them, rows along u, key after key.
  static Ptr make(int eu, int ev, const Imath::V3f* points, const Imath::V3f* normals, uint32_t keys = 1);
  static size_t bytesFor(int eu, int ev, uint32_t keys = 1);
  static void destroy(Tessellation* t);

  int eu() const { return eu_; }
  int ev() const { return ev_; }
  uint32_t keys() const { return keys_; }
  size_t bytes() const { return bytesFor(eu_, ev_, keys_); }
  Imath::V3f point(uint32_t i, uint32_t j, const Moment& at = {}) const;
  Imath::V3f normal(uint32_t i, uint32_t j, const Moment& at = {}) const;  // unit but between two keys

  // Nearest hit at the ray's time. steps: exponents along the edges v = 0, u = 1, v = 1, u = 0 that ray and neighbours
  // agree on, not more than those of the grid.
  bool intersect(const GridRay& ray, const std::array<uint8_t, 4>& steps, GridHit* hit) const;

  mutable std::atomic<uint8_t> isUsed{1};  // since the cache looked last

 private:
  Tessellation(int eu, int ev, uint32_t keys)
      : eu_(uint8_t(eu)), ev_(uint8_t(ev)), keys_(uint8_t(keys)), keyFloats_(uint32_t(floatsOfKey(eu, ev))) {}
  ~Tessellation() = default;
  friend struct GridView;
  size_t vertices() const { return ((size_t(1) << eu_) + 1) * ((size_t(1) << ev_) + 1); }
  // By key: three planes of coordinates, one of normals, and the boxes.
  static size_t floatsOfKey(int eu, int ev);
  float* plane(int axis, uint32_t key) {
    return reinterpret_cast<float*>(this + 1) + size_t(key) * keyFloats_ + size_t(axis) * vertices();
  }
  const float* plane(int axis, uint32_t key) const { return const_cast<Tessellation*>(this)->plane(axis, key); }
  uint32_t* normalsAt(uint32_t key) { return reinterpret_cast<uint32_t*>(plane(3, key)); }
  const uint32_t* normalsAt(uint32_t key) const { return reinterpret_cast<const uint32_t*>(plane(3, key)); }
  float* boxes(uint32_t key) { return plane(4, key); }
  const float* boxes(uint32_t key) const { return plane(4, key); }
  bool meetsStitches(int edge, int exponent, const Moment& at, const GridRay& ray, GridHit* hit,
                     float* nearest) const;

  void set(uint32_t key, const Imath::V3f* points, const Imath::V3f* normals);

  uint8_t eu_, ev_, keys_;
  uint32_t keyFloats_;
  float edgeBox_[4][6];  // over all keys
  float largest_;        // of their numbers
};

// What of a tessellation the kernel of rays reads.
struct GridView {
  GridView(const Tessellation& t, const Moment& at)
      : plane{t.plane(0, at.key), t.plane(1, at.key), t.plane(2, at.key)},
        boxes(t.boxes(at.key)),
        toNext(at.part > 0 ? t.keyFloats_ : 0),
        part(at.part),
        eu(t.eu_),
        ev(t.ev_) {}
  const float* plane[3];
  const float* boxes;  // by node: 6 x 4, lower x, y, z, then upper, of four children
  size_t toNext;       // floats from each of these to those of the next key; 0: all is where this one has it
  float part;          // of the next key
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
  static const GridBlocks& of(int eu, int ev);
  int levels = 0;                                   // 1: a single block, and no box
  uint32_t width[10]{}, height[10]{}, first[10]{};  // of blocks, then nodes; first node of a level
  uint32_t nodes = 0;
};

}  // namespace kinora::trace
