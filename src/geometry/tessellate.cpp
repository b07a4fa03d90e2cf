#include "geometry/tessellate.h"

#include <cmath>
#include <limits>

#include "geometry/build.h"
#include "geometry/makers.h"

namespace kinora::geometry {

double DiceRate::at(const Imath::V3d& p) const {
  if (edgeLength) {
    const double e = edgeLength(p);
    if (e > 0 && std::isfinite(e)) return e;
  }
  return std::numeric_limits<double>::infinity();
}

bool flipsNormals(const scene::Primitive& primitive, bool worldMirrored) {
  if (!primitive.attributes) return false;
  using Orientation = scene::Attributes::Orientation;
  const scene::Attributes& a = *primitive.attributes;
  bool flip = false;
  switch (a.orientation) {
    case Orientation::Outside:
      flip = false;
      break;
    case Orientation::Inside:
      flip = true;
      break;
    case Orientation::LeftHanded:
      flip = worldMirrored;
      break;
    case Orientation::RightHanded:
      flip = !worldMirrored;
      break;
  }
  return flip != a.reverseOrientation;
}

namespace {

const char* laterKind(const scene::Shape& shape) {
  if (const auto* other = std::get_if<scene::OtherPrimitive>(&shape)) return other->request.c_str();
  return "Primitive";
}

bool make(const scene::Primitive& p, const DiceRate& rate, Diagnostics& d, Mesh& mesh) {
  if (const auto* q = std::get_if<scene::Quadric>(&p.shape)) return makeQuadric(p, *q, rate, d, mesh);
  if (const auto* q = std::get_if<scene::PolygonMesh>(&p.shape)) return makePolygons(p, *q, d, mesh);
  if (const auto* q = std::get_if<scene::SubdivisionMesh>(&p.shape)) return makeSubdivision(p, *q, rate, d, mesh);
  if (std::holds_alternative<scene::Patch>(p.shape) || std::holds_alternative<scene::PatchMesh>(p.shape) ||
      std::holds_alternative<scene::NuPatch>(p.shape))
    return makePatches(p, rate, d, mesh);
  if (const auto* q = std::get_if<scene::Curves>(&p.shape)) return makeCurves(p, *q, rate, d, mesh);
  if (std::holds_alternative<scene::Points>(p.shape)) return makePoints(p, d, mesh);
  if (const auto* q = std::get_if<scene::OtherPrimitive>(&p.shape); q && q->request == "Blobby")
    return makeBlobby(p, *q, rate, d, mesh);
  if (const auto* q = std::get_if<scene::OtherPrimitive>(&p.shape); q && q->request == "Geometry")
    return makeNamedShape(p, *q, rate, d, mesh);
  if (const auto* q = std::get_if<scene::OtherPrimitive>(&p.shape); q && q->request == "Volume")
    return makeVolume(p, *q, d, mesh);
  const std::string kind = laterKind(p.shape);
  if (kind.starts_with("Procedural")) return false;  // whoever read it knows why it was not expanded, and has said so
  // The code holds the kind, so that a thousand of one do not hide the first of another.
  std::string code = "GEOM-NOT-RENDERED-YET-";
  for (char c : kind) code += c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c;
  d.warning(code, p.pos, kind + " is not rendered yet (" + subject(p) + ")", "the primitive is left out");
  return false;
}

}  // namespace

std::optional<Mesh> tessellate(const scene::Primitive& primitive, const DiceRate& rate, Diagnostics& diagnostics) {
  Mesh mesh;
  mesh.flipNormals = flipsNormals(primitive, rate.worldMirrored);
  mesh.doubleSided = !primitive.attributes || primitive.attributes->sides != 1;
  if (!make(primitive, rate, diagnostics, mesh)) return std::nullopt;
  // flat polygons that move as if they were smooth
  if (rate.isDisplaced && mesh.triangleCount() && !mesh.find("N") && primitive.attributes &&
      primitive.attributes->getInt("polygon:smoothdisplacement", 0) != 0)
    addSmoothNormals(mesh);
  return mesh;
}

}  // namespace kinora::geometry
