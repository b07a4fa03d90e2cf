// What the makers of curves and points share: which user values each control point is made of, widths and normals
// over all keys, and the primvars that go with control points. Used inside geometry/ only.
#pragma once
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "geometry/build.h"

namespace kinora::geometry {

// A control point as a mixture of the user's values: of up to four of class vertex, or of two of class varying.
struct ControlSource {
  std::array<uint32_t, 4> vertex{};
  std::array<float, 4> weight{};
  std::array<uint32_t, 2> varying{};
  float between = 0;  // from varying[0] to varying[1]
  uint32_t curve = 0;
};

class StrandSources {
 public:
  StrandSources(const scene::Primitive& primitive, const PointKeys& points, const ClassCounts& counts,
                Diagnostics& diagnostics);

  size_t keys() const { return points_.keys.size(); }
  bool hasNormals() const { return normals_ != nullptr; }
  Imath::V3d position(size_t key, const ControlSource& c) const;
  double radius(size_t key, const ControlSource& c) const;  // not below 0
  Imath::V3d normal(size_t key, const ControlSource& c) const;
  bool finite(uint32_t vertex) const { return !points_.nonFinite || points_.finite(vertex); }
  // Fills spine, spineNormals (when `mesh` is of an oriented kind), times, origin and primvars; the bounds are there.
  // `walk` visits all `count` control points in order, a few at a time, as often as it is asked: millions of curves have
  // no room for a list of them.
  using Visit = std::function<void(std::span<const ControlSource>)>;
  void store(size_t count, const std::function<void(const Visit&)>& walk, Mesh& mesh) const;

 private:
  double mix(std::span<const float> values, scene::StorageClass storage, int width, int component,
             const ControlSource& c) const;
  std::span<const float> widthsAt(size_t key) const { return widths_[key < widths_.size() ? key : 0]; }

  const scene::Primitive& primitive_;
  const PointKeys& points_;
  Diagnostics& diagnostics_;
  std::vector<SourcePrimvar> primvars_;
  const SourcePrimvar *widthSource_ = nullptr, *normals_ = nullptr;
  std::vector<std::vector<float>> widths_;  // by key, all finite; empty: 1 everywhere
};

}  // namespace kinora::geometry
