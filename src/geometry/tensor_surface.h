// Surfaces that are tensor products of two Axis: points, tangents, normals and primvars at a place of a piece, and
// how finely such a surface is cut. Used by the makers of patches; it knows neither grids nor meshes.
#pragma once
#include <ImathVec.h>
#include <vector>

#include "geometry/axis.h"
#include "geometry/build.h"

namespace kinora::geometry {

struct TensorSurface {
  Axis u, v;
  std::vector<std::vector<Imath::V4d>> keys;  // homogeneous control points, u fastest
  std::vector<char> rational;                 // by key: the points have weights ("Pw")

  Imath::V3d at(size_t key, const Axis::Span& a, double s, const Axis::Span& b, double t, Imath::V3d* du = nullptr,
                Imath::V3d* dv = nullptr) const;
  // Unit dPdu x dPdv; where it vanishes (a side drawn together to a point), its limit from inside the piece.
  Imath::V3d normal(size_t key, const Axis::Span& a, double s, const Axis::Span& b, double t) const;
};

// One vertex of one piece, for interpolating primvars.
struct PiecePlace {
  const Axis::Span *a, *b;
  double s, t;
};
// Appends the values of a primvar there: those of class vertex follow the basis, others are bilinear over the cell
// that the piece is a part of.
void interpolate(const TensorSurface& surface, const SourcePrimvar& source, const PiecePlace& place,
                 std::vector<float>& out);

// Segments of each span of both axes: the finest that any piece along it asks for, within the rate's most triangles.
void chooseRates(const TensorSurface& surface, const std::vector<SourcePrimvar>& primvars, const DiceRate& rate,
                 std::vector<int>& nu, std::vector<int>& nv);

}  // namespace kinora::geometry
