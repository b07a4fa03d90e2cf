// The interface of a displacement: where points of a surface move to, before anything is traced. It sees a context
// like a pattern does: parameters, primvars, and as P and N the undisplaced ones in the space of the object. (Patterns
// that feed it see the point as it stands in the scene.) It is asked for vertices of one object's grids at once; a
// point's offset must not depend on the others.
#pragma once
#include <kinora/context.h>
#include <kinora/plugin.h>

namespace kinora {

struct DisplacementFunctions {
  // Offsets for all points of the context, in object space; arrays of padded length. A point whose offset is not
  // finite stays where it is, and the user is told.
  void (*displace)(const Context*, float* const offset[3]);
};

struct DisplacementTraits {
  // How far a point may move, in the same space, from the node's own numbers; infinity where what is connected decides.
  // What moves by 0 is not diced. Null: nothing is known.
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
