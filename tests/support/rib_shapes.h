// RIB text of shapes that scenes of a bit of everything have.
#pragma once

namespace kinora::tests {

// A cube without its bottom, as a cage with a crease and a corner.
inline constexpr const char* kCreasedCage =
    R"(  SubdivisionMesh "catmull-clark" [4 4 4 4 4] [0 1 3 2  2 3 5 4  4 5 7 6  1 7 5 3  6 0 2 4]
    ["interpolateboundary" "crease" "corner"] [1 0 2 1 1 1] [2 0 1 3] [2.5 1.5]
    "P" [-1 -1 1  1 -1 1  -1 1 1  1 1 1  -1 1 -1  1 1 -1  -1 -1 -1  1 -1 -1]
)";
// A curve named hair, with a material of its own.
inline constexpr const char* kHair = R"(AttributeBegin
  Attribute "identifier" "string name" ["hair"]
  Bxdf "PxrDiffuse" "dull" "color diffuseColor" [0.3 0.3 0.3]
  Basis "b-spline" 1 "b-spline" 1
  Curves "cubic" [5] "nonperiodic" "P" [-2 0 0  -1 1 0  0 1 0  1 1 0  2 0 0] "constant float constantwidth" [0.2]
AttributeEnd
)";

}  // namespace kinora::tests
