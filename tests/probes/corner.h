// A corner of a room with a floor, a wall, a ball and whatever a test adds, as a camera at its open side sees it; the lights
// are not seen. What stands before it (hider, displays, format, shutter) is the test's.
#pragma once
#include <string>

namespace kinora::probes {

inline std::string corner(const std::string& lights, const std::string& floor, const std::string& ball,
                          const std::string& more = "") {
  return R"(
Projection "perspective" "fov" [40]
Translate 0 -0.8 3.2
WorldBegin
  AttributeBegin
    Attribute "visibility" "int camera" [0]
)" + lights +
         R"(
  AttributeEnd
  AttributeBegin
    )" + floor +
         R"(
    Polygon "vertex point P" [-1.5 0 0  1.5 0 0  1.5 0 2  -1.5 0 2]
  AttributeEnd
  Bxdf "PxrDiffuse" "wall" "color diffuseColor" [0.7 0.6 0.5]
  Polygon "vertex point P" [-1.5 0 2  1.5 0 2  1.5 2 2  -1.5 2 2]
  Polygon "vertex point P" [-1.5 0 0  -1.5 0 2  -1.5 2 2  -1.5 2 0]
  AttributeBegin
    Attribute "identifier" "string lpegroup" ["ball"]
    )" + ball +
         R"(
    Translate 0.4 0.45 1.1
    Sphere 0.4 -0.4 0.4 360
  AttributeEnd
)" + more +
         "WorldEnd\n";
}

}  // namespace kinora::probes
