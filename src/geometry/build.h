// What the makers of meshes share: checked access to a primitive's points and primvars, storing points at the right
// origin, and normals. Used inside geometry/ only; it knows nothing of any particular primitive.
#pragma once
#include <ImathBox.h>
#include <ImathVec.h>
#include <optional>
#include <span>
#include <vector>

#include "geometry/mesh.h"
#include "geometry/tessellate.h"

namespace kinora::geometry {

// How many values a primvar of each class has on a primitive.
struct ClassCounts {
  size_t uniform = 1, varying = 1, vertex = 1, faceVarying = 1;
};

// The control points of all deformation keys, as 3 floats each. Spans point into the primitive, or into `owned` for
// "Pw".
struct PointKeys {
  std::vector<std::span<const float>> keys;
  std::vector<std::vector<float>> owned;
  std::vector<double> times;  // as in Mesh: empty for one key
  size_t count = 0;
  bool nonFinite = false;  // some coordinate of some key is NaN or infinite
  Imath::V3d point(size_t key, size_t i) const {
    return Imath::V3d(keys[key][3 * i], keys[key][3 * i + 1], keys[key][3 * i + 2]);
  }
  bool finite(size_t i) const;  // in all keys
};

// Nothing (and a message) without usable points. Keys that do not fit the first are dropped with a message; keys that
// are all equal become one.
std::optional<PointKeys> readPoints(const scene::Primitive& primitive, Diagnostics& diagnostics);

// Homogeneous points ("Pw"; w = 1 for "P") of the first key, for rational patches: 4 floats each.
std::vector<Imath::V4d> homogeneousPoints(const scene::Primitive& primitive, size_t key);

// A primvar whose length has been checked. `storage` may differ from what was said when only that fits.
struct SourcePrimvar {
  const scene::Parameter* parameter = nullptr;
  scene::StorageClass storage = scene::StorageClass::Constant;
  size_t elements = 1;
  std::vector<float> values;  // empty for strings; ints as floats
};
// All primvars but the points. Wrong lengths, references and strings that would need interpolation are reported and
// left out, or repaired where one reading is plain.
std::vector<SourcePrimvar> readPrimvars(const scene::Primitive& primitive, const ClassCounts& counts,
                                        Diagnostics& diagnostics);
// The primvar with its name, type and width, without data.
Primvar emptyPrimvar(const SourcePrimvar& source, Primvar::Rate rate);
// Values of `name` at deformation key `key` when the same primvar is said there with the same length, else empty.
std::span<const float> valuesAtKey(const scene::Primitive& primitive, const SourcePrimvar& source, size_t key);

// Where the float points of an object with these bounds are best taken from: zero, or a point near its centre on a
// power-of-two grid when it lies far from zero for its size.
Imath::V3d chooseOrigin(const Imath::Box3d& bounds);
// Sets points, vertexCount, origin and bounds; `points` holds keys x vertices.
void storePoints(const std::vector<Imath::V3d>& points, size_t keys, Mesh& mesh);

// Adds "st" when "s" and "t" are there without it.
void joinTextureCoordinates(Mesh& mesh);
// For grids: adds "st" by the attribute TextureCoordinates when that differs from (u, v) and no "st" is there.
void applyTextureCoordinates(const scene::Primitive& primitive, Mesh& mesh);

// Of a surface with one value of class uniform and four of the others, at (u, v) = (0,0), (1,0), (0,1), (1,1): its
// primvars, its normals where none are said, its texture coordinates.
void finishSurface(const scene::Primitive& primitive, Primvar normals, Diagnostics& diagnostics, Mesh& mesh);

// Area- and angle-weighted vertex normals on the side of the geometric normal, as "N".
void addSmoothNormals(Mesh& mesh);
// Makes user normals unit vectors, replaces unusable ones by geometric ones, and turns all of them when most point
// away from the geometric normal.
void repairNormals(const scene::Primitive& primitive, Mesh& mesh, Diagnostics& diagnostics);

// e1 x e2 with the orientation applied, not normalised.
Imath::V3d geometricNormal(const Mesh& mesh, uint32_t triangle, size_t key = 0);

// What messages about a primitive call it: its name, else its kind.
std::string subject(const scene::Primitive& primitive);

}  // namespace kinora::geometry
