// The region of a Volume request, as its closed surface: a box, or what is round within the bound.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "geometry/build.h"
#include "geometry/makers.h"

namespace kinora::geometry {

namespace {

// Faces and points of the shape in the cube from -1 to 1, their normals outward.
struct Solid {
  scene::PolygonMesh faces;
  std::vector<Imath::V3d> points;
  void face(std::initializer_list<int> corners) {
    faces.verticesPerLoop.push_back(int(corners.size()));
    faces.vertices.insert(faces.vertices.end(), corners);
  }
  void face(const std::vector<int>& corners) {
    faces.verticesPerLoop.push_back(int(corners.size()));
    faces.vertices.insert(faces.vertices.end(), corners.begin(), corners.end());
  }
};

constexpr int kAround = 64;
constexpr double kHalfTurn = std::numbers::pi;

Solid box() {
  Solid s;
  for (int k = 0; k < 8; ++k) s.points.push_back({k & 1 ? 1. : -1., k & 2 ? 1. : -1., k & 4 ? 1. : -1.});
  s.face({0, 2, 3, 1});
  s.face({4, 5, 7, 6});
  s.face({0, 1, 5, 4});
  s.face({2, 6, 7, 3});
  s.face({0, 4, 6, 2});
  s.face({1, 3, 7, 5});
  return s;
}

// About z, by radii and heights from the bottom to the top; ends of radius 0 are points, others have a lid.
Solid turned(const std::vector<std::array<double, 2>>& profile) {
  Solid s;
  std::vector<std::vector<int>> rings;
  for (const auto& [radius, z] : profile) {
    rings.emplace_back();
    for (int k = 0; k < (radius > 0 ? kAround : 1); ++k) {
      const double a = 2 * kHalfTurn * k / kAround;
      rings.back().push_back(int(s.points.size()));
      s.points.push_back({radius * std::cos(a), radius * std::sin(a), z});
    }
  }
  for (size_t r = 0; r + 1 < rings.size(); ++r) {
    const auto &low = rings[r], &high = rings[r + 1];
    const auto at = [](const std::vector<int>& ring, int k) { return ring[size_t(k) % ring.size()]; };
    for (int k = 0; k < kAround; ++k) {
      if (low.size() == 1)
        s.face({low[0], at(high, k + 1), at(high, k)});
      else if (high.size() == 1)
        s.face({at(low, k), at(low, k + 1), high[0]});
      else
        s.face({at(low, k), at(low, k + 1), at(high, k + 1), at(high, k)});
    }
  }
  if (rings.front().size() > 1) s.face(std::vector<int>(rings.front().rbegin(), rings.front().rend()));
  if (rings.back().size() > 1) s.face(rings.back());
  return s;
}

Solid solidOf(const std::string& type) {
  if (type == "ellipsoid") {
    std::vector<std::array<double, 2>> profile;
    for (int k = 0; k <= kAround / 2; ++k) {
      const double a = kHalfTurn * k / (kAround / 2);
      profile.push_back({k == 0 || k == kAround / 2 ? 0 : std::sin(a), -std::cos(a)});
    }
    return turned(profile);
  }
  if (type == "cylinder") return turned({{1, -1}, {1, 1}});
  if (type == "cone") return turned({{1, -1}, {0, 1}});
  return box();
}

}  // namespace

bool makeVolume(const scene::Primitive& primitive, const scene::OtherPrimitive& request, Diagnostics& diagnostics,
                Mesh& mesh) {
  const std::string type = request.args.getString("type", "box");
  if (type != "box" && type != "ellipsoid" && type != "cone" && type != "cylinder" && !type.starts_with("blobbydso:"))
    diagnostics.warning("GEOM-VOLUME", primitive.pos, "no Volume is called '" + type.substr(0, 40) + "'",
                        "it is taken for a box",
                        "known are box, ellipsoid, cone, cylinder and blobbydso:impl_openvdb");
  const std::vector<float> bound = request.args.getFloats("bound");
  double half[3], middle[3];
  for (int k = 0; k < 3; ++k) {
    const double low = bound.size() == 6 ? bound[2 * k] : NAN, high = bound.size() == 6 ? bound[2 * k + 1] : NAN;
    half[k] = 0.5 * (high - low);
    middle[k] = 0.5 * (high + low);
    if (half[k] > 0 && std::isfinite(half[k])) continue;
    diagnostics.warning("GEOM-VOLUME", primitive.pos, "the bound of a Volume holds no space", "it is left out",
                        "six numbers: from and to along x, y and z");
    return false;
  }
  Solid solid = solidOf(type);
  scene::Primitive shape = primitive;
  shape.motion.clear();
  shape.times.clear();
  shape.primvars = {};
  for (const scene::Parameter& p : primitive.primvars)
    if (p.storage == scene::StorageClass::Constant) shape.primvars.set(p);
  scene::Parameter P;
  P.name = "P";
  P.storage = scene::StorageClass::Vertex;
  P.type = scene::ValueType::Point;
  for (const Imath::V3d& p : solid.points)
    for (int k = 0; k < 3; ++k) P.floats.push_back(float(middle[k] + half[k] * p[k]));
  shape.primvars.set(P);
  shape.shape = std::move(solid.faces);
  return makePolygons(shape, std::get<scene::PolygonMesh>(shape.shape), diagnostics, mesh);
}

}  // namespace kinora::geometry
