// What every primitive becomes before it is traced: an indexed triangle mesh with primvars, plus the way back from a
// triangle to the patch (face, u, v) that the user said; or, for Curves and Points, control points with radii (a
// "strand": what is traced as it is, without triangles). Made by geometry/, held by trace/, read by shade/.
#pragma once
#include <ImathBox.h>
#include <ImathVec.h>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scene/parameters.h"

namespace kinora::geometry {

// One primvar, ready for lookup at (triangle, barycentric b1, b2), or bilinearly over a quad: see Mesh::quads.
struct Primvar {
  enum class Rate : uint8_t { Constant, PerFace, PerVertex, PerCorner };  // PerCorner: 3 values a triangle
  std::string name;
  scene::ValueType type = scene::ValueType::Float;
  int width = 1;  // floats (or strings) an element: components x array length
  Rate rate = Rate::Constant;
  std::vector<float> data;  // PerVertex: keys x vertices x width only for "N" of a deforming mesh; else one key
  std::vector<std::string> strings;  // string primvars are Constant or PerFace
  // "N", by vertex, without data.
  static Primvar normals() { return {"N", scene::ValueType::Normal, 3, Rate::PerVertex, {}, {}}; }
};

// Which way it faces. The geometric normal of triangle t is e1 x e2 in object space (e1 = P1 - P0, e2 = P2 - P0),
// negated when `flipNormals`; it goes to world space as a normal does (inverse transpose), so that a mirroring
// transform leaves the outside of an object outside. Who multiplies the *points* by a mirroring matrix first and
// crosses then must negate. "N" already carries the orientation: derived normals point to the side of the geometric
// normal, and normals from the user are turned as a whole when most of them point to the other side. Single ones may
// still disagree.
struct Mesh {
  // Strands: tubes and ribbons along curves, and balls and discs at points. Cubic ones are Bezier pieces whatever
  // basis the user said; ribbons and discs face the ray or, "oriented", stand as their normals say.
  enum class Kind : uint8_t {
    Triangles,
    LinearTube,
    LinearRibbon,
    CubicTube,
    CubicRibbon,
    OrientedRibbon,
    Ball,
    Disc,
    OrientedDisc
  };
  Kind kind = Kind::Triangles;
  // Strands only. A primitive of one is a piece of a curve, or a point; `indices` holds the first control point of
  // each, `faceOfTriangle` the curve of each (empty for points: all belong to face 0), `vertexCount` counts control
  // points. PerVertex primvars go with the control points.
  std::vector<Imath::V4f> spine;         // keys x vertexCount: as `points`, with the radius
  std::vector<Imath::V3f> spineNormals;  // keys x vertexCount: oriented kinds; any length but 0
  std::vector<Imath::V2f> along;         // curve parameter v at both ends of each piece
  // Curves that were drawn wider, since they are seen thinner than `hair:minwidth`: how much of the width is theirs, by
  // control point. A ray sees such a curve with the probability ownWidth() gives. Empty: all is.
  std::vector<float> own;

  // Triangles only:
  // keys x vertexCount points; object space minus `origin` (so that float keeps precision at coordinates around 1e6)
  std::vector<Imath::V3f> points;
  Imath::V3d origin{0, 0, 0};
  // Where displaced vertices were before, by vertex, first key: patterns that lie in the object's space stay with them.
  // Empty: `points`.
  std::vector<Imath::V3f> rest;
  uint32_t vertexCount = 0;
  std::vector<double> times;             // deformation key times; empty: one key
  std::vector<uint32_t> indices;         // 3 a triangle; counter-clockwise about dPdu x dPdv of the patch
  std::vector<uint32_t> faceOfTriangle;  // empty: triangle t belongs to face t (t / 2 with `quadPairs`); ask faceOf()
  // Some triangles are halves of quads: (a, b, c) and, right behind it, (a, c, d). Place and primvars are bilinear
  // over the whole quad (geometry/surface.h), as its two triangles alone would bend them along the diagonal. Nothing
  // is stored for it: quadOf() knows the pairs by their indices, and makers see to it that no others look like one.
  bool quads = false;
  // Every face is such a quad, of triangles 2f and 2f + 1. faceOfTriangle is still filled when PerFace primvars
  // exist.
  bool quadPairs = false;
  // Patch parameters: per corner (3 x 2 floats a triangle). Empty, and no vertexUV: the corners of quads are at (u,
  // v) = (0,0), (1,0), (1,1), (0,1), those of other triangles at (0,0), (1,0), (0,1), i.e. u = b1, v = b2.
  std::vector<Imath::V2f> cornerUV;
  std::vector<Imath::V2f> vertexUV;  // instead of cornerUV where no seam splits vertices (quadrics, patches)
  std::vector<Primvar>
      primvars;              // "N" (unit; object space) and "st" (width 2; else u, v are meant) if present or derived
  bool flipNormals = false;  // orientation: geometric normal is -(e1 x e2)
  bool doubleSided = true;   // Sides 2
  Imath::Box3d bounds;       // over all keys, object space

  bool isStrand() const { return kind != Kind::Triangles; }
  bool isCurve() const { return kind >= Kind::LinearTube && kind <= Kind::OrientedRibbon; }
  bool isCubic() const { return kind >= Kind::CubicTube && kind <= Kind::OrientedRibbon; }
  bool isTube() const { return kind == Kind::LinearTube || kind == Kind::CubicTube; }
  bool isOriented() const { return kind == Kind::OrientedRibbon || kind == Kind::OrientedDisc; }
  bool facesRay() const { return kind == Kind::LinearRibbon || kind == Kind::CubicRibbon || kind == Kind::Disc; }
  int controlsOfPiece() const { return isCubic() ? 4 : isCurve() ? 2 : 1; }

  // 0..1, at a place along a piece.
  float ownWidth(uint32_t piece, float s) const;

  uint32_t triangleCount() const { return isStrand() ? 0 : uint32_t(indices.size() / 3); }
  uint32_t primitiveCount() const { return isStrand() ? uint32_t(indices.size()) : triangleCount(); }
  uint32_t faceOf(uint32_t triangle) const {
    return !faceOfTriangle.empty() ? faceOfTriangle[triangle] : quadPairs ? triangle / 2 : triangle;
  }
  // The first triangle of the quad that this one is a half of, or kNoQuad.
  static constexpr uint32_t kNoQuad = ~0u;
  uint32_t quadOf(uint32_t triangle) const {
    if (!quads) return kNoQuad;
    if (quadPairs) return triangle & ~1u;
    if (isQuad(triangle)) return triangle;
    return triangle > 0 && isQuad(triangle - 1) ? triangle - 1 : kNoQuad;
  }
  // Corner 0..3 of the quad that begins with `first`: where it stands in `indices`, and in PerCorner values.
  static size_t quadCorner(uint32_t first, int corner) { return 3 * size_t(first) + size_t(corner < 3 ? corner : 5); }
  Imath::V2f uvOf(uint32_t triangle,
                  int corner) const;  // patch parameters of a corner (0, 1, 2), whatever their store
  int keyCount() const { return times.empty() ? 1 : int(times.size()); }
  // The deformation keys around a time of the shutter (0..1, held outside), over which they are uniform once a mesh
  // is in a world: where the values of both begin, by vertex, and the part of the second.
  struct KeyPair {
    size_t first = 0, second = 0;
    float part = 0;
    float mix(float a, float b) const { return a + part * (b - a); }
  };
  KeyPair keysAt(float time) const {
    KeyPair k;
    if (times.size() < 2) return k;
    const size_t last = times.size() - 1;
    const float x = (time > 0.f ? time < 1.f ? time : 1.f : 0.f) * float(last);
    const size_t key = size_t(x) < last ? size_t(x) : last - 1;
    k.first = key * vertexCount;
    k.second = k.first + vertexCount;
    k.part = x - float(key);
    return k;
  }
  // Whether a PerVertex primvar has values for each key.
  bool movesWithKeys(const Primvar& p) const {
    return times.size() > 1 && p.data.size() == times.size() * vertexCount * size_t(p.width);
  }
  const Primvar* find(std::string_view name) const;
  size_t bytes() const;

 private:
  // Triangles `first` and the next one are a quad.
  bool isQuad(uint32_t first) const {
    const size_t i = 3 * size_t(first);
    if (i + 6 > indices.size() || indices[i] != indices[i + 3] || indices[i + 2] != indices[i + 4] ||
        faceOf(first) != faceOf(first + 1))
      return false;
    // the triangles of a polygon with more corners may share edges in the same way
    const bool isPolygon = cornerUV.empty() && vertexUV.empty();
    return !isPolygon || ((first == 0 || faceOf(first - 1) != faceOf(first)) &&
                          (i + 9 > indices.size() || faceOf(first + 2) != faceOf(first)));
  }
};

// What a mesh is, but for its vertices, faces and values.
inline Mesh emptyLike(const Mesh& mesh) {
  Mesh out;
  out.kind = mesh.kind;
  out.origin = mesh.origin;
  out.flipNormals = mesh.flipNormals;
  out.doubleSided = mesh.doubleSided;
  out.bounds = mesh.bounds;
  return out;
}

}  // namespace kinora::geometry
