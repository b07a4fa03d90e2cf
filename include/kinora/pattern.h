// The interface of a pattern: all outputs for all points of a context in one call. Called lazily by the renderer,
// once a context, when a parameter connected to it is asked for. Shading-language shaders answer to the same call.
#pragma once
#include <kinora/context.h>

namespace kinora {

struct PatternArgs {
  uint32_t outputCount;
  const uint8_t* wanted;  // outputCount flags: outputs that somebody is connected to
  Value* outputs;         // out; arrays from Context::alloc, uniform values allowed. Colours, points: 3 components
  Manifold* manifolds;    // out; for outputs of Type::Struct, at the output's index
};

struct PatternFunctions {
  void (*compute)(const Context*, const PatternArgs*);
};

}  // namespace kinora
