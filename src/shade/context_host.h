// The renderer's side of a Context: lazy evaluation of networks, built-ins and primvars for its points. One for each
// context, in the group's arena; known to shade/ only.
#pragma once
#include "shade/group.h"

namespace kinora::shade {

struct ContextHost {
  GroupState* group;
  const Program* program;
  uint32_t node = 0;         // node being evaluated
  const uint32_t* block;     // by point: material block in the program
  const uint32_t* slot;      // by point
  Value* outputs = nullptr;  // by node and output
  Manifold* manifolds = nullptr;
  uint32_t* firstOutput = nullptr;  // by node
  uint8_t* done = nullptr;          // by node
  Value builtins[size_t(Builtin::Count)];
  bool haveBuiltin[size_t(Builtin::Count)] = {};
  bool computing = false;
  bool hasQuads = false;                      // some point may lie on a quad (GeometryFlags)
  float* quadPlaces[2] = {nullptr, nullptr};  // by point, see findQuadPlaces() of where.h; null: not asked for yet
  RayKind rayKind = RayKind::Camera;          // of the rays that met its points
  const float* lightN[3] = {nullptr, nullptr, nullptr};  // see GroupState::setLightNormals()

  static ContextHost& of(const Context* c) { return *static_cast<ContextHost*>(c->host); }
  void evaluate(const Context* c, uint32_t node);
  void findQuadPlaces(const Context* c);
};

extern const ContextFunctions kContextFunctions;

}  // namespace kinora::shade
