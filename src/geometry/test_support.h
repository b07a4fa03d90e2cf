// Helpers of this room's tests: primitives filled by hand, and measures of meshes that are computed from the
// triangles alone. Included by *_test.cpp only.
#pragma once
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <tuple>
#include <variant>

#include "geometry/tessellate.h"

namespace kinora::geometry::testing {

using Imath::V3d;
using Imath::V3f;
using scene::PolygonMesh;
using scene::StorageClass;
using scene::ValueType;

inline scene::Parameter parameter(const std::string& name, scene::StorageClass storage, scene::ValueType type,
                                  std::vector<float> values, int arrayLength = 1) {
  scene::Parameter p;
  p.name = name;
  p.storage = storage;
  p.type = type;
  p.isArray = arrayLength > 1;
  p.arrayLength = arrayLength;
  p.floats = std::move(values);
  return p;
}
inline scene::Parameter points(std::vector<float> values) {
  return parameter("P", scene::StorageClass::Vertex, scene::ValueType::Point, std::move(values));
}

inline scene::Primitive primitive(scene::Shape shape) {
  scene::Primitive p;
  p.shape = std::move(shape);
  p.attributes = std::make_shared<scene::Attributes>();
  return p;
}
inline scene::Primitive quadric(scene::Quadric::Kind kind, std::array<float, 7> args) {
  return primitive(scene::Quadric{kind, args});
}
inline void edit(scene::Primitive& p, const std::function<void(scene::Attributes&)>& change) {
  auto a = std::make_shared<scene::Attributes>(*p.attributes);
  change(*a);
  p.attributes = a;
}

// A named attribute of the primitive.
inline void setAttribute(scene::Primitive& p, const std::string& name, std::variant<int, float> value) {
  scene::Parameter a;
  a.name = name;
  if (const int* i = std::get_if<int>(&value)) {
    a.type = ValueType::Int;
    a.ints = {*i};
  } else {
    a.type = ValueType::Float;
    a.floats = {std::get<float>(value)};
  }
  edit(p, [&](scene::Attributes& all) { all.named.set(a); });
}

// Messages go nowhere but into the counts.
struct Quiet : Diagnostics {
  Quiet() : Diagnostics([](const std::string&, Severity) {}) {}
};

inline constexpr double kPi = 3.14159265358979323846;

// The mesh of a primitive that nothing is wrong with.
inline Mesh made(const scene::Primitive& p, const DiceRate& rate = {}) {
  Quiet d;
  std::optional<Mesh> m = tessellate(p, rate, d);
  EXPECT_TRUE(m.has_value());
  EXPECT_EQ(d.warnings() + d.errors(), 0u);
  return m ? std::move(*m) : Mesh{};
}

// Micropolygon edges of one length everywhere.
inline DiceRate edge(double e) {
  DiceRate r;
  r.edgeLength = [e](const V3d&) { return e; };
  return r;
}

inline V3d vertex(const Mesh& m, uint32_t i, size_t key = 0) {
  return V3d(m.points[key * m.vertexCount + i]) + m.origin;
}
inline std::array<V3d, 3> corners(const Mesh& m, uint32_t t, size_t key = 0) {
  const uint32_t* i = &m.indices[size_t(t) * 3];
  return {vertex(m, i[0], key), vertex(m, i[1], key), vertex(m, i[2], key)};
}
inline double area(const Mesh& m, size_t key = 0) {
  double sum = 0;
  for (uint32_t t = 0; t < m.triangleCount(); ++t) {
    const auto c = corners(m, t, key);
    sum += 0.5 * (c[1] - c[0]).cross(c[2] - c[0]).length();
  }
  return sum;
}
// Positive when e1 x e2 points outward.
inline double volume(const Mesh& m) {
  double sum = 0;
  for (uint32_t t = 0; t < m.triangleCount(); ++t) {
    const auto c = corners(m, t);
    sum += c[0].dot(c[1].cross(c[2])) / 6;
  }
  return sum;
}
// Area of the outline of a convex mesh seen along a direction: half of all projected triangles.
inline double silhouette(const Mesh& m, const V3d& direction) {
  double sum = 0;
  for (uint32_t t = 0; t < m.triangleCount(); ++t) {
    const auto c = corners(m, t);
    sum += 0.25 * std::abs((c[1] - c[0]).cross(c[2] - c[0]).dot(direction.normalized()));
  }
  return sum;
}

// Edges by the bits of their positions: {open edges, edges used twice the same way or more than twice}.
struct EdgeCount {
  size_t open = 0, wrong = 0, total = 0;
};
inline EdgeCount edges(const Mesh& m) {
  using Key = std::array<uint32_t, 3>;
  auto key = [&](uint32_t i) {
    const V3f p = m.points[i] + V3f(0);  // -0 becomes 0
    return Key{std::bit_cast<uint32_t>(p.x), std::bit_cast<uint32_t>(p.y), std::bit_cast<uint32_t>(p.z)};
  };
  std::map<std::pair<Key, Key>, int> directed;
  for (uint32_t t = 0; t < m.triangleCount(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Key a = key(m.indices[size_t(t) * 3 + k]), b = key(m.indices[size_t(t) * 3 + (k + 1) % 3]);
      if (a != b) ++directed[{a, b}];
    }
  EdgeCount out;
  for (const auto& [e, n] : directed) {
    const auto back = directed.find({e.second, e.first});
    const int m2 = back == directed.end() ? 0 : back->second;
    if (n > 1 || m2 > 1)
      ++out.wrong;
    else if (m2 == 0)
      ++out.open;
    ++out.total;
  }
  return out;
}

}  // namespace kinora::geometry::testing
