// Lights that move and turn while the shutter is open. What moves is relative: a light that moves in a room at rest
// makes the picture of a light at rest in a room that moves the other way, camera and all. Geometry that deforms shines
// as an object of the same shape does that glows.
#include <string>

#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

constexpr const char* kLamps = R"(
  AttributeBegin
    Translate 0.3 0.9 0.1 Rotate 90 1 0 0
    Light "PxrRectLight" "panel" "float intensity" [9]
  AttributeEnd
  AttributeBegin
    Translate -0.8 0.5 -0.4 Scale 0.4 0.4 0.4
    Light "PxrSphereLight" "bulb" "float intensity" [20] "color lightColor" [1 0.7 0.4]
  AttributeEnd
)";
constexpr const char* kSuns = R"(
  AttributeBegin
    Rotate 60 1 0 0
    Light "PxrDistantLight" "sun" "float intensity" [2] "float angleExtent" [8]
  AttributeEnd
  AttributeBegin
    Rotate -90 1 0 0
    Light "PxrEnvDayLight" "sky" "float intensity" [0.5]
  AttributeEnd
)";
constexpr const char* kShades = R"(
  AttributeBegin
    Translate 0 0.9 0 Rotate 90 1 0 0
    LightFilter "PxrBarnLightFilter" "doors" "float width" [0.5] "float height" [0.3] "float edge" [0.1]
    Light "PxrDiskLight" "key" "float intensity" [20]
  AttributeEnd
)";
constexpr const char* kMeshes = R"(
  AttributeBegin
    Light "PxrMeshLight" "mesh" "float intensity" [6]
    Polygon "vertex point P" [0.3 0.8 -0.3  0.3 0.8 0.3  -0.3 0.9 0.3  -0.3 0.9 -0.3]
  AttributeEnd
)";

// Many lamps: those that rays meet lie in a tree of their own.
std::string swarm() {
  std::string text;
  for (int i = 0; i < 12; ++i) {
    const std::string n = std::to_string(i);
    text += "AttributeBegin Translate " + std::to_string(-1.1 + 0.2 * i) + " 0.6 " + std::to_string(0.1 * (i % 5)) +
            " Scale 0.1 0.1 0.1 Light \"PxrSphereLight\" \"lamp" + n + "\" \"float intensity\" [60] AttributeEnd\n";
  }
  return text;
}

enum class Moving { Lights, Room };

std::string scene(Moving moving, const std::string& lights) {
  const std::string forth = R"(
    MotionBegin [0 1] Translate -0.25 0 0.1 Translate 0.3 0.1 -0.1 MotionEnd
    MotionBegin [0 1] Rotate -15 0 0 1 Rotate 25 0 0 1 MotionEnd
)",
                    back = R"(
    MotionBegin [0 1] Rotate 15 0 0 1 Rotate -25 0 0 1 MotionEnd
    MotionBegin [0 1] Translate 0.25 0 -0.1 Translate -0.3 -0.1 0.1 MotionEnd
)";
  const bool isRoom = moving == Moving::Room;
  return R"(
Format 32 32 1
PixelFilter "box" 1 1
Hider "raytrace" "int maxsamples" [16]
Shutter 0 1
Projection "perspective" "float fov" [50]
DisplayChannel "color Ci"
DisplayChannel "float a"
DisplayChannel "color indirect" "string source" ["lpe:C[DS]{2,}[LO]"]
DisplayChannel "color ball" "string source" ["lpe:C.*<.[DS]'ball'>.*L"]
DisplayChannel "color key" "string source" ["lpe:C.+<L.'key'>"]
Display "out.exr" "openexr" "Ci,a,indirect,ball,key"
Translate 0 0 4
)" + (isRoom ? forth : "") +
         R"(
WorldBegin
)" + "AttributeBegin\n" +
         (isRoom ? "" : forth) + lights + "AttributeEnd\n" + (isRoom ? back : "") + R"(
  AttributeBegin
    Bxdf "PxrDiffuse" "grey" "color diffuseColor" [0.6 0.6 0.6]
    Polygon "vertex point P" [-2 -1 -2  2 -1 -2  2 -1 2  -2 -1 2]
    Polygon "vertex point P" [-2 -1 1.5  2 -1 1.5  2 2 1.5  -2 2 1.5]
  AttributeEnd
  AttributeBegin
    Attribute "grouping" "string membership" ["ball"]
    Attribute "identifier" "string lpegroup" ["ball"]
    Bxdf "PxrSurface" "shiny" "color diffuseColor" [0.3 0.3 0.3] "color specularFaceColor" [0.3 0.3 0.3]
      "float specularRoughness" [0.3]
    Translate 0.1 -0.5 0
    Sphere 0.5 -0.5 0.5 360
  AttributeEnd
WorldEnd
)";
}

// Path tracing and bidirectional methods with the lights moving, against path tracing with the room moving.
void expectRelative(const std::string& lights, double sharpness, uint32_t seeds = 24) {
  Workshop stage;
  const Pictures room = renderAll(stage, scene(Moving::Room, lights), pathTracer(2), 1000, seeds);
  EXPECT_GT(room.at("Ci").mean(), 0.01) << stage.said;
  const std::string moving = scene(Moving::Lights, lights);
  expectEqual(renderAll(stage, moving, pathTracer(2), 2000, seeds), room, "path tracing", sharpness);
  expectEqual(renderAll(stage, moving, vcm(true, false, 5, 2), 3000, seeds), room, "connections", sharpness);
}

TEST(LightMotion, LampsAreRelative) { expectRelative(kLamps, 0.04); }
TEST(LightMotion, SunAndSkyAreRelative) { expectRelative(kSuns, 0.04); }
TEST(LightMotion, FiltersMoveWithTheirLight) { expectRelative(kShades, 0.05); }
TEST(LightMotion, MeshesAreRelative) { expectRelative(kMeshes, 0.05); }
TEST(LightMotion, ManyLampsAreRelative) { expectRelative(swarm(), 0.05); }
// A sheet over a floor and a ball, which see its lower side alone, that leans over and stretches, as geometry of a light or as a surface that glows.
std::string deforming(bool isLight) {
  return std::string(R"(
Format 32 32 1
PixelFilter "box" 1 1
Hider "raytrace" "int maxsamples" [16]
Shutter 0 1
Projection "perspective" "float fov" [50]
DisplayChannel "color Ci"
DisplayChannel "float a"
DisplayChannel "color indirect" "string source" ["lpe:C[DS]{2,}[LO]"]
DisplayChannel "color ball" "string source" ["lpe:C<.[DS]'ball'>[LO]"]
DisplayChannel "color key" "string source" ["lpe:CD[LO]"]
Display "out.exr" "openexr" "Ci,a,indirect,ball,key"
Translate 0 0 4
WorldBegin
AttributeBegin
  Attribute "visibility" "int camera" [0]
)") +
         (isLight ? "Light \"PxrMeshLight\" \"mesh\" \"float intensity\" [6]\n"
                  : "Bxdf \"PxrConstant\" \"glow\" \"color emitColor\" [6 6 6]\n") +
         R"(
  MotionBegin [0 0.3 1]
    Polygon "vertex point P" [0.3 0.8 -0.3  0.3 0.8 0.3  -0.3 0.9 0.3  -0.3 0.9 -0.3]
    Polygon "vertex point P" [0.4 0.9 -0.3  0.3 0.9 0.4  -0.4 0.8 0.3  -0.5 0.8 -0.3]
    Polygon "vertex point P" [0.7 0.65 -0.2  0.6 0.6 0.5  -0.2 0.95 0.4  -0.5 0.8 -0.5]
  MotionEnd
AttributeEnd
  AttributeBegin
    Bxdf "PxrDiffuse" "grey" "color diffuseColor" [0.6 0.6 0.6]
    Polygon "vertex point P" [-2 -1 -2  2 -1 -2  2 -1 2  -2 -1 2]
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string lpegroup" ["ball"]
    Bxdf "PxrSurface" "shiny" "color diffuseColor" [0.3 0.3 0.3] "color specularFaceColor" [0.3 0.3 0.3]
      "float specularRoughness" [0.3]
    Translate 0.1 -0.5 0
    Sphere 0.5 -0.5 0.5 360
  AttributeEnd
WorldEnd
)";
}

TEST(LightMotion, MeshesThatDeformShineAsWhatGlows) {
  Workshop stage;
  const Pictures glow = renderAll(stage, deforming(false), pathTracer(2), 1000);
  EXPECT_GT(glow.at("Ci").mean(), 0.01) << stage.said;
  Method raysAlone = pathTracer(2);
  raysAlone.sets.emplace_back("integrator.numLightSamples", "0");
  const auto expectGlow = [&](const Method& method, uint32_t firstSeed, const char* what) {
    Pictures light = renderAll(stage, deforming(true), method, firstSeed);
    light.erase("indirect");  // too few paths find the sheet so; of the whole picture it is compared
    expectEqual(light, glow, what, 0.1);
  };
  expectGlow(raysAlone, 2000, "rays alone");
  expectGlow(pathTracer(2), 3000, "light samples and rays");
  expectGlow(vcm(true, false, 5, 2), 4000, "connections");
}

TEST(LightMotion, SameBits) {
  expectSameBits({}, deforming(true), "PxrVCM");
  expectSameBits({}, scene(Moving::Lights, std::string(kLamps) + kSuns + kShades), "PxrPathTracer");
}

}  // namespace
}  // namespace kinora::probes
