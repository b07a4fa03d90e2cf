// Points as balls or discs that are traced as they are.
#include <cmath>
#include <utility>

#include "geometry/makers.h"
#include "geometry/strand.h"

namespace kinora::geometry {

bool makePoints(const scene::Primitive& primitive, Diagnostics& diagnostics, Mesh& mesh) {
  const std::optional<PointKeys> points = readPoints(primitive, diagnostics);
  if (!points) return false;
  const StrandSources sources(primitive, *points, {1, points->count, points->count, points->count}, diagnostics);
  const std::string type = primitive.primvars.getString("type", "particle");
  mesh.kind = sources.hasNormals() ? Mesh::Kind::OrientedDisc : Mesh::Kind::Disc;
  if (type == "sphere" || type == "blobby") mesh.kind = Mesh::Kind::Ball;
  const bool plain = type == "particle" || type == "disk" || type == "sphere";
  if (!plain) {
    const bool known = type == "patch" || type == "blobby";
    diagnostics.warning("GEOM-POINTS-TYPE", primitive.pos,
                        (known ? "points of type '" + type + "' have a stand-in only"
                               : "no type of points is called '" + type.substr(0, 40) + "'") +
                            " (" + subject(primitive) + ")",
                        mesh.kind == Mesh::Kind::Ball ? "spheres are rendered" : "discs are rendered");
  }
  const auto softens = [](const scene::Parameter* p) { return p && !p->floats.empty() && p->floats[0] != 0; };
  const scene::Attributes* given = primitive.attributes.get();
  if (softens(std::as_const(primitive.primvars).find("falloffpower")) ||
      softens(given ? std::as_const(given->named).find("Ri:falloffpower") : nullptr))
    diagnostics.warning("GEOM-POINTS-FALLOFF", primitive.pos,
                        "points have a falloffpower (" + subject(primitive) + ")", "their edges are hard",
                        "presence of their material makes them thinner, all over");
  std::vector<ControlSource> controls;
  size_t notFinite = 0;
  for (uint32_t i = 0; i < points->count; ++i) {
    if (!sources.finite(i)) {
      ++notFinite;
      continue;
    }
    ControlSource c;
    c.vertex[0] = i;
    c.weight[0] = 1;
    c.varying = {i, i};
    bool width = false;
    for (size_t key = 0; key < sources.keys(); ++key) width |= sources.radius(key, c) > 0;
    if (!width) continue;
    for (size_t key = 0; key < sources.keys(); ++key) {
      const Imath::V3d p = sources.position(key, c), r(sources.radius(key, c));
      mesh.bounds.extendBy(p - r);
      mesh.bounds.extendBy(p + r);
    }
    mesh.indices.push_back(uint32_t(controls.size()));
    controls.push_back(c);
  }
  if (notFinite)
    diagnostics.error("GEOM-NOT-FINITE", primitive.pos,
                      std::to_string(notFinite) + " points of " + subject(primitive) + " are not finite",
                      "these points are left out");
  if (controls.empty()) {
    if (!notFinite)
      diagnostics.warning("GEOM-ZERO-AREA", primitive.pos, subject(primitive) + " has no width",
                          "the primitive is left out");
    return false;
  }
  sources.store(
      controls.size(), [&](const StrandSources::Visit& visit) { visit(controls); }, mesh);
  return true;
}

}  // namespace kinora::geometry
