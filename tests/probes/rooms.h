// Rooms of 32 x 32 pixels in which integrators are compared: a corner with a glossy floor, under lights of every kind.
#pragma once
#include <string>

#include "tests/probes/corner.h"

namespace kinora::probes {

// What tests of rooms look at.
inline const char* const kShown = R"(
Hider "raytrace" "int maxsamples" [16]
Display "probe.exr" "openexr" "Ci,a,indirect,ball,key"
DisplayChannel "color ball" "string source" ["lpe:C.*<.[DS]'ball'>.*L"]
DisplayChannel "color key" "string source" ["lpe:C.+<L.'key'>"]
Format 32 32 1
PixelFilter "box" 1 1
)";

inline const char* const kGlossyFloor =
    R"(Bxdf "PxrSurface" "floor" "color diffuseColor" [0.4 0.4 0.45] "int specularFresnelMode" [1]
      "color specularEdgeColor" [1 1 1] "color specularIor" [1.6 1.6 1.6] "int specularModelType" [1] "float specularRoughness" [0.4])";

inline std::string room(const std::string& lights, const std::string& ball, const std::string& camera = "",
                        const std::string& more = "") {
  return kShown + std::string("Shutter 0 1\n") + camera + corner(lights, kGlossyFloor, ball, more);
}
inline const char* const kGrey = R"(Bxdf "PxrDiffuse" "grey" "color diffuseColor" [0.6 0.6 0.7])";
inline const char* const kGlass = R"(Bxdf "PxrSurface" "glass" "float diffuseGain" [0] "float refractionGain" [1]
    "float reflectionGain" [1] "float glassRoughness" [0] "float glassIor" [1.5] "color refractionColor" [0.9 1 0.9])";
inline const char* const kRoughGlass = R"(Bxdf "PxrSurface" "glass" "float diffuseGain" [0] "float refractionGain" [1]
    "float reflectionGain" [1] "float glassRoughness" [0.35] "float glassIor" [1.4])";
inline const char* const kFog = R"(
  AttributeBegin
    Bxdf "PxrVolume" "fog" "float densityFloat" [0.4] "int multiScatter" [1]
    Volume "box" [-1.5 1.5 0 2 0 2] [0 0 0]
  AttributeEnd
)";
inline const char* const kRect = R"(
    AttributeBegin
      ConcatTransform [0.8 0 0 0  0 0 0.6 0  0 -1 0 0  -0.2 1.9 1 1]
      Light "PxrRectLight" "lamp" "float intensity" [6] "color lightColor" [1 0.9 0.7] "string lightGroup" ["key"]
    AttributeEnd)";
inline const char* const kSphere = R"(
    AttributeBegin
      Translate -0.8 0.9 0.6
      Scale 0.3 0.3 0.3
      Light "PxrSphereLight" "bulb" "float intensity" [12] "color lightColor" [0.6 0.8 1]
    AttributeEnd)";
inline const char* const kSun = R"(
    AttributeBegin
      Rotate 70 1 0.3 0
      Light "PxrDistantLight" "sun" "float intensity" [2] "float angleExtent" [0] "string lightGroup" ["key"]
    AttributeEnd)";
inline const char* const kPoint = R"(
    AttributeBegin
      Translate -0.7 1.2 0.5
      Light "PointLight" "spot" "float intensity" [3]
    AttributeEnd)";
inline const char* const kDome = R"(
    Light "PxrDomeLight" "sky" "float intensity" [0.5] "string lightGroup" ["key"])";
inline const char* const kMesh = R"(
    AttributeBegin
      Translate -0.7 1.1 0.9
      Light "PxrMeshLight" "shade" "float intensity" [4] "string lightGroup" ["key"]
      PointsPolygons [3 3 3 3] [0 1 2  0 2 3  0 3 1  1 3 2] "vertex point P" [0 0.3 0  -0.2 -0.1 0.1  0.2 -0.1 0.1  0 -0.1 -0.2]
    AttributeEnd)";

// A lamp seen and cast through a ball of clear and one of rough glass.
inline std::string roomBehindGlass() {
  return room(kSphere, kGlass, "",
              R"(
  AttributeBegin )" +
                  std::string(kRoughGlass) +
                  R"(
    Translate -0.6 0.3 0.6
    Sphere 0.25 -0.25 0.25 360
  AttributeEnd
)");
}
// A lamp that does not light the ball and is seen through a filter, beside others. filter: parameters beyond intensity.
inline std::string roomWithLinks(const std::string& screen, const std::string& filter = "") {
  std::string bulb = kSphere;
  bulb.insert(bulb.find("Light \"PxrSphereLight"),
              "LightFilter \"PxrIntMultLightFilter\" \"dim\" \"float intensity\" [0.6]" + filter + "\n");
  return room(std::string(kRect) + bulb + kDome, std::string("Illuminate \"bulb\" 0\n") + kGrey, "", screen);
}
// Coloured fog; `screen`: what else is in the room.
inline std::string foggyRoom(const std::string& screen) {
  return room(std::string(kRect) + kSphere, kGrey, "",
              screen +
                  "  AttributeBegin\n    Bxdf \"PxrVolume\" \"fog\" \"color densityColor\" [0.3 0.4 0.5]\n"
                  "    Volume \"box\" [-1.6 1.6 -0.1 2.1 -0.2 2.1] [0 0 0]\n  AttributeEnd\n");
}
inline const char* const kLens = "DepthOfField 2 0.4 4\n";
// A ball flies through it while the shutter is open.
inline std::string roomInMotionThroughALens() {
  return room(kRect, kGrey, kLens, R"(
  AttributeBegin
    Bxdf "PxrDiffuse" "red" "color diffuseColor" [0.8 0.3 0.2]
    MotionBegin [0 1]
      Translate -0.9 0.3 0.7
      Translate -0.3 0.6 0.9
    MotionEnd
    Sphere 0.25 -0.25 0.25 360
  AttributeEnd
)");
}
// Lights of three kinds, clear glass and a lens: for tests of bits.
inline std::string roomOfEverything() { return room(std::string(kRect) + kSun + kDome, kGlass, kLens); }

}  // namespace kinora::probes
