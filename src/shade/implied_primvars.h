// Primvars that every object answers without having been given them: texture coordinates, Color and Opacity.
#pragma once
#include <cstdint>
#include <cstring>

#include "shade/group.h"
#include "shade/surface_points.h"

namespace kinora::shade {

// The renderer's own, of the vertex and not of the object.
inline constexpr const char* kSeenPrimvar = "__seen";
// Where across a ribbon that faces its ray it was met: -1 to 1, rising with u; 2 on what is no such ribbon.
inline constexpr const char* kRibbonPrimvar = "__ribbon";

inline Implied impliedBy(const char* name) {
  if (!std::strcmp(name, "st")) return Implied::St;
  if (!std::strcmp(name, "s")) return Implied::S;
  if (!std::strcmp(name, "t")) return Implied::T;
  if (!std::strcmp(name, "Cs")) return Implied::Color;
  if (!std::strcmp(name, "Os")) return Implied::Opacity;
  return Implied::None;
}
// Of every object, whatever it says.
inline bool isAlwaysImplied(const char* name) {
  const Implied what = impliedBy(name);
  return what == Implied::St || what == Implied::S || what == Implied::T;
}
inline uint32_t widthOf(Implied what) {
  return what == Implied::Color || what == Implied::Opacity ? 3
         : what == Implied::St                              ? 2
         : what == Implied::None                            ? 0
                                                            : 1;
}
// Whether an object has it by what it says: Color and Opacity are white where nothing is said.
inline bool saysImplied(Implied what, const Tint& tint) {
  return what == Implied::Color ? tint.hasColor : what == Implied::Opacity ? tint.hasOpacity : what != Implied::None;
}
// Whether the object of a point has a primvar (p: its own, or null), or implies it.
inline bool hasPrimvar(const Context* c, const ShadingWorld& world, const geometry::Primvar* p, Implied implied,
                       uint32_t point) {
  if (p || implied == Implied::None) return p != nullptr;
  return saysImplied(implied,
                     world.tints[world.placementOf(c->place.instance[point], c->place.geometry[point]).tint]);
}

}  // namespace kinora::shade
