// The interface of a pattern: all outputs for all points of a context in one call. Called lazily by the renderer,
// once a context, when a parameter connected to it is asked for. Shading-language shaders answer to the same call.
#pragma once
#include <kinora/context.h>

namespace kinora {

// Bits of PatternArgs::wanted.
enum Want : uint8_t {
  kWantValue = 1,      // somebody is connected to the output
  kWantGradients = 2,  // somebody reads a manifold's gradients (kParamGradients)
};

struct PatternArgs {
  uint32_t outputCount;
  const uint8_t* wanted;  // an entry an output
  Value* outputs;         // out; arrays from Context::alloc, uniform values allowed. Colours, points: 3 components
  Manifold* manifolds;    // out; for outputs of Type::Struct, at the output's index
};

struct PatternFunctions {
  void (*compute)(const Context*, const PatternArgs*);
};

// What a pattern declares.
struct PatternPlugin {
  using Functions = PatternFunctions;
  static constexpr Kind kKind = Kind::Pattern;
  const char* help = "";
  ListOf<Param> params = {};
  constexpr NoTraits traits() const { return {}; }
};

}  // namespace kinora
