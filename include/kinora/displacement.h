// The interface of a displacement: where points of a surface move to, before anything is traced. It sees a context
// like a pattern does: parameters, primvars, the undisplaced P and N. It is asked for whole grids of one object at
// once; a point's offset must not depend on the others. This version keeps displacements in the scene description and
// checks that their plug-ins are there; the geometry they move comes with subdivision-level dicing.
#pragma once
#include <kinora/context.h>
#include <kinora/plugin.h>

namespace kinora {

struct DisplacementFunctions {
  // Offsets for all points of the context, in the space of Context::P; arrays of padded length.
  void (*displace)(const Context*, float* const offset[3]);
};

struct DisplacementTraits {
  // How far a point may move, in the same space, from the node's own numbers: the renderer widens bounds by it. Null:
  // the attribute displacementbound says so.
  float (*bound)(const CreateInfo*);
};

// What a displacement declares.
struct DisplacementPlugin {
  using Functions = DisplacementFunctions;
  static constexpr Kind kKind = Kind::Displacement;
  const char* help = "";
  ListOf<Param> params = {};
  float (*bound)(const CreateInfo*) = nullptr;
  constexpr DisplacementTraits traits() const { return {bound}; }
};

}  // namespace kinora
