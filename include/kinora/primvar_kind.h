// What a point's object says of a primitive variable, beside its value.
#pragma once
#include <cstdint>

namespace kinora {

// ContextFunctions::primvar gives these in its `radius`, by point.
enum PrimvarAbout : uint32_t {
  kPrimvarFootprint = 0,   // in units of the variable
  kPrimvarComponents = 1,  // of the object's own, which the scene's widest of that name is given as; 0: it has none
  kPrimvarKind = 2,        // PrimvarKind
};
// How a variable moves to render space: numbers and colours stay as they were said.
enum class PrimvarKind : uint32_t { Number, Point, Vector, Normal };

}  // namespace kinora
