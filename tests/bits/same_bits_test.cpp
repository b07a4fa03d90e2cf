// Proves: all channels of a frame are the same integers at all SIMD widths, with 1 and 2 threads, in groups of 64 to
// 1,024, in any order of buckets, in parts that are merged (through files too), under crop, and as replayed; and that
// they are the integers kept in hashes.txt. Scenes: the gallery, one with coplanar surfaces, instances (also with
// presence and media) and motion blur, that with every kind of display channel, one of curves, points and what
// deforms, and one of objects whose own spaces differ. Misses: other compilers and libraries (their code may round
// differently: the kept hashes would tell), and sample counts above 64.
//
// A change of the pictures on purpose: run test_bits with KINORA_WRITE_HASHES=1 and look at the pictures first.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <unistd.h>

#include "film/shard.h"
#include "support/render_scene.h"

namespace kinora::tests {
namespace {

constexpr int kSamples = 16;
const std::string kHashFile = KINORA_SOURCE_DIR "/tests/bits/hashes.txt";

// Pairs of coplanar polygons (one of them an instance), a block that stands on the floor with a shared face,
// instances that move, turn and deform, a half present sheet, and glass that dips into glass of another priority.
const char* const kOverlap = R"(
Hider "raytrace" "int maxsamples" [16]
Integrator "PxrPathTracer" "i" "int maxIndirectBounces" [4] "int allowCaustics" [1]
Format 64 48 1
PixelFilter "mitchell" 4 4
Shutter 0 1
DepthOfField 4 0.1 4
Projection "perspective" "fov" [45]
Translate 0 -0.6 4
WorldBegin
AttributeBegin
  ConcatTransform [2 0 0 0  0 0 2 0  0 -1 0 0  0 3 0.5 1]
  Light "PxrRectLight" "top" "float intensity" [6]
AttributeEnd
Light "PxrDomeLight" "sky" "float intensity" [0.3]
AttributeBegin
  Translate 1.5 1.5 -1
  Light "PxrSphereLight" "bulb" "float intensity" [5]
AttributeEnd
Bxdf "PxrDiffuse" "floor" "color diffuseColor" [0.5 0.5 0.5]
Polygon "vertex point P" [-3 0 -3  3 0 -3  3 0 3  -3 0 3]
AttributeBegin
  Bxdf "PxrSurface" "patch" "color diffuseColor" [0.8 0.1 0.1] "float specularRoughness" [0.3] "color specularEdgeColor" [1 1 1]
  Polygon "vertex point P" [-1 0 -1  1 0 -1  1 0 1  -1 0 1]
AttributeEnd
ObjectBegin "sheet"
  Bxdf "PxrDiffuse" "green" "color diffuseColor" [0.1 0.7 0.2]
  Polygon "vertex point P" [-0.5 0 -0.5  0.5 0 -0.5  0.5 0 0.5  -0.5 0 0.5]
ObjectEnd
AttributeBegin Translate 0.5 0 0.5 ObjectInstance "sheet" AttributeEnd
AttributeBegin Translate 0.5 0 0.5 ObjectInstance "sheet" AttributeEnd
AttributeBegin
  MotionBegin [0 1]
    Translate -1 0.8 0
    Translate -0.7 1 0
  MotionEnd
  Rotate 60 1 0 0
  ObjectInstance "sheet"
AttributeEnd
AttributeBegin
  MotionBegin [0 1]
    Rotate 0 0 1 0
    Rotate 40 0 1 0
  MotionEnd
  Bxdf "PxrSurface" "metal" "float diffuseGain" [0] "color specularFaceColor" [0.9 0.7 0.5] "color specularEdgeColor" [1 1 1]
    "float specularRoughness" [0.2] "int specularModelType" [1]
  PointsPolygons [4 4 4 4 4 4] [0 1 2 3  7 6 5 4  0 4 5 1  1 5 6 2  2 6 7 3  3 7 4 0]
    "vertex point P" [-0.3 0 -0.3  0.3 0 -0.3  0.3 0 0.3  -0.3 0 0.3  -0.3 0.6 -0.3  0.3 0.6 -0.3  0.3 0.6 0.3  -0.3 0.6 0.3]
AttributeEnd
AttributeBegin
  Bxdf "PxrDiffuse" "half" "float presence" [0.5] "color diffuseColor" [0.2 0.3 0.9]
  Polygon "vertex point P" [0.2 0.1 -1  1.4 0.1 -1  1.4 1 -0.8  0.2 1 -0.8]
AttributeEnd
AttributeBegin
  Bxdf "PxrSurface" "glass" "float diffuseGain" [0] "float refractionGain" [1] "float reflectionGain" [1] "float glassRoughness" [0]
    "color extinction" [0.2 1 0.5]
  Translate 0.6 0.5 -0.3
  Sphere 0.4 -0.4 0.4 360
  Attribute "trace" "int intersectpriority" [2]
  Bxdf "PxrSurface" "rough" "float diffuseGain" [0] "float refractionGain" [1] "float reflectionGain" [1] "float glassRoughness" [0.3]
    "float glassIor" [1.3]
  Translate 0.4 0 0
  Sphere 0.3 -0.3 0.3 360
AttributeEnd
AttributeBegin
  Bxdf "PxrDiffuse" "cloth" "color diffuseColor" [0.7 0.6 0.2]
  MotionBegin [0 1]
    Polygon "vertex point P" [-1.6 0 0.5  -0.9 0 1  -0.9 1 1  -1.6 1 0.5]
    Polygon "vertex point P" [-1.6 0 0.5  -0.9 0 1  -0.7 1.1 1.1  -1.5 1 0.2]
  MotionEnd
AttributeEnd
WorldEnd
)";

// One program over objects whose own spaces differ, with a primvar that is a point in one and absent in the other,
// and one that is a colour in one and a number in the other; one of them moves.
const char* const kSpaces = R"(
Hider "raytrace" "int maxsamples" [16]
Integrator "PxrPathTracer" "i" "int maxIndirectBounces" [3]
Format 48 32 1
Shutter 0 1
Projection "perspective" "fov" [40]
Translate 0.2 -0.2 3
Rotate -30 1 0 0
WorldBegin
Light "PxrDomeLight" "sky" "float intensity" [1]
Pattern "PxrManifold3D" "own" "int use" [1] "string pref" ["where"] "string coordsys" ["object"]
Pattern "PxrFractal" "veins" "reference struct manifold" ["own:result"] "float frequency" [3]
Pattern "PxrPrimvar" "tint" "string varname" ["tint"] "string type" ["color"]
Pattern "PxrMix" "mixed" "reference color color1" ["tint:resultRGB"] "color color2" [1 0.9 0.2] "reference float mix" ["veins:resultF"]
AttributeBegin
  Bxdf "PxrDiffuse" "a" "reference color diffuseColor" ["mixed:resultRGB"]
  Translate -0.4 0.02 -1
  Rotate 30 0 1 0
  PointsPolygons [4] [0 1 2 3] "vertex point P" [-0.4 0 -0.4  0.4 0 -0.4  0.4 0 0.4  -0.4 0 0.4]
    "vertex point where" [0 0 0  2 0 0  2 0 2  0 0 2] "vertex color tint" [1 0 0  0 1 0  0 0 1  1 1 1]
AttributeEnd
AttributeBegin
  Bxdf "PxrDiffuse" "b" "reference color diffuseColor" ["mixed:resultRGB"]
  MotionBegin [0 1]
    Translate -0.1 0.03 -1
    Translate -0.1 0.1 -1
  MotionEnd
  Rotate 70 0 1 0
  PointsPolygons [4] [0 1 2 3] "vertex point P" [-0.4 0 -0.4  0.4 0 -0.4  0.4 0 0.4  -0.4 0 0.4]
    "uniform float tint" [0.6]
AttributeEnd
WorldEnd
)";

// The same with every source of display channels but cpuTime, which is measured; with every rule by which samples
// become pixels; and a dozen light path expressions with labels, groups and lobes.
const char* const kChannels = R"(
DisplayChannel "color key" "string source" ["color lpe:C.*<L.'key'>"]
DisplayChannel "color caustic" "string source" ["lpe:CD[S]+<L.>"]
DisplayChannel "color labelled" "string source" ["lpe:C<.[DS]'marked'>[DS]*[<L.>O]"]
DisplayChannel "color twice" "string source" ["lpe:C(D|S){2}[LO]"]
DisplayChannel "color notDiffuse" "string source" ["lpe:C[^D]+[LO]"]
DisplayChannel "color coat" "string source" ["lpe:CS2.*[LO]"]
DisplayChannel "color through" "string source" ["lpe:C<T[DS]>*<RD>L"]
DisplayChannel "color glass" "string source" ["lpe:C<.S'Glass'>+.*L"]
DisplayChannel "color open" "string source" ["lpe:unoccluded;C[DS]+[LO]"]
DisplayChannel "color shade" "string source" ["lpe:shadows;CD<L.>"]
DisplayChannel "color signal" "string source" ["lpe:nothruput;overwrite;C(U2L)|O"]
DisplayChannel "color magenta" "string source" ["lpe:C<RD"]
DisplayChannel "color tint" "string source" ["tint"]
DisplayChannel "color even" "string source" ["Ci"] "string statistics" ["even"]
DisplayChannel "color odd" "string source" ["Ci"] "string statistics" ["odd"]
DisplayChannel "color var" "string source" ["Ci"] "string statistics" ["variance"]
DisplayChannel "float zmse" "string source" ["zfiltered"] "string statistics" ["mse"]
DisplayChannel "color own" "string source" ["Ci"] "string filter" ["gaussian"] "float[2] filterwidth" [2 2]
DisplayChannel "color calm" "string source" ["Ci"] "float[3] remap" [1 2 50]
DisplayChannel "normal nearN" "string source" ["Nn"] "string filter" ["zmin"]
DisplayChannel "point farP" "string source" ["P"] "string filter" ["zmax"]
DisplayChannel "color most" "string source" ["Ci"] "string filter" ["max"]
DisplayChannel "color least" "string source" ["Ci"] "string filter" ["min"]
DisplayChannel "color plain" "string source" ["Ci"] "string filter" ["average"]
DisplayChannel "color all" "string source" ["Ci"] "string filter" ["sum"]
)";
const char* const kEverySource =
    "Ci,a,Oi,z,zback,zfiltered,depth,id,id2,sampleCount,albedo,P,Po,PRadius,incidentRayRadius,incidentRaySpread,"
    "mpSize,N,Nn,"
    "Ngn,Tn,Vn,VLen,curvature,u,v,w,du,dv,dw,dufp,dvfp,st,s,t,dPdu,dPdv,dPdw,dPdtime,dPcameradtime,motionFore,"
    "motionBack,"
    "time,outsideIOR,biasR,biasT,emissive,diffuse,indirectDiffuse,specular,indirectSpecular,subsurface,transmissive,"
    "key,caustic,labelled,twice,notDiffuse,coat,through,glass,open,shade,signal,magenta,tint,even,odd,var,zmse,own,"
    "calm,"
    "nearN,farP,most,least,plain,all";
std::string channelsScene() {
  std::string text = kChannels + std::string(kOverlap);
  const auto put = [&](const std::string& before, const std::string& what) {
    const size_t at = text.find(before);
    EXPECT_NE(at, std::string::npos) << before;
    if (at != std::string::npos) text.insert(at, what);
  };
  put("\"float intensity\" [6]", "\"string lightGroup\" [\"key\"] ");
  put("Bxdf \"PxrSurface\" \"patch\"",
      "Attribute \"identifier\" \"string lpegroup\" [\"marked\"] \"int id\" [3] \"int id2\" [12]\n  ");
  put("\"vertex point P\" [0.2 0.1 -1", "\"vertex color tint\" [1 0 0  0 1 0  0 0 1  1 1 1] ");
  return text;
}
// Curves and points of every kind, deforming, placed, half present and of glass; meshes that deform with uneven keys;
// a shutter that opens slowly, planes that cut, holes, subsets for rays, and a coarse smooth mesh that lifts its
// shadows.
const char* const kStrands = R"(
Hider "raytrace" "int maxsamples" [16]
Integrator "PxrPathTracer" "i" "int maxIndirectBounces" [4] "int allowCaustics" [1]
Format 64 48 1
PixelFilter "mitchell" 4 4
Shutter 0 1
Clipping 0.5 40
ClippingPlane 1.9 0 0  1 0 0
Projection "perspective" "fov" [45]
Translate 0 -0.6 4
Camera "main" "float shutterOpenTime" [0.3] "float shutterCloseTime" [0.8] "float[8] shutteropening" [0.4 0 0.6 1 0.4 0 0.6 1]
WorldBegin
AttributeBegin
  ConcatTransform [2 0 0 0  0 0 2 0  0 -1 0 0  0 3 0.5 1]
  Light "PxrRectLight" "top" "float intensity" [6]
AttributeEnd
Light "PxrDomeLight" "sky" "float intensity" [0.4]
AttributeBegin
  Bxdf "PxrDiffuse" "floor" "color diffuseColor" [0.5 0.5 0.5]
  Attribute "trace" "string shadowexcludesubset" ["shadowless"] "string reflectsubset" ["seen shadowless"]
  Polygon "vertex point P" [-3 0 -3  3 0 -3  3 0 3  -3 0 3]
AttributeEnd
Attribute "grouping" "string membership" ["seen"]
Pattern "PxrPrimvar" "tint" "string varname" ["tint"] "string type" ["color"]
Pattern "PxrFractal" "veins" "float frequency" [3]
Pattern "PxrMix" "mixed" "reference color color1" ["tint:resultRGB"] "color color2" [1 0.9 0.2] "reference float mix" ["veins:resultF"]
AttributeBegin
  Bxdf "PxrDiffuse" "grass" "reference color diffuseColor" ["mixed:resultRGB"]
  MotionBegin [0 0.3 1]
  Curves "cubic" [4 7] "nonperiodic" "P" [-1.5 0 0 -1.4 0.4 0 -1.5 0.8 0.1 -1.2 1.2 0  -1.1 0 0.3 -1 0.3 0.3 -1.1 0.5 0.4 -1 0.7 0.4 -0.9 0.9 0.4 -0.9 1 0.3 -0.8 1.2 0.2]
    "varying float width" [0.1 0.02 0.1 0.06 0.02] "uniform color tint" [0.1 0.6 0.1 0.5 0.3 0.1]
  Curves "cubic" [4 7] "nonperiodic" "P" [-1.5 0 0 -1.4 0.4 0 -1.4 0.8 0.1 -1.1 1.2 0  -1.1 0 0.3 -1 0.3 0.3 -1.1 0.5 0.4 -0.9 0.7 0.4 -0.8 0.9 0.4 -0.7 1 0.3 -0.6 1.2 0.2]
    "varying float width" [0.1 0.02 0.1 0.06 0.02] "uniform color tint" [0.1 0.6 0.1 0.5 0.3 0.1]
  Curves "cubic" [4 7] "nonperiodic" "P" [-1.5 0 0 -1.4 0.4 0 -1.3 0.8 0.1 -1 1.1 0  -1.1 0 0.3 -1 0.3 0.3 -1 0.5 0.4 -0.8 0.7 0.4 -0.7 0.9 0.4 -0.5 1 0.3 -0.3 1.1 0.2]
    "varying float width" [0.14 0.02 0.1 0.06 0.02] "uniform color tint" [0.1 0.6 0.1 0.5 0.3 0.1]
  MotionEnd
  Attribute "dice" "int roundcurve" [0]
  Basis "b-spline" 1 "b-spline" 1
  Curves "cubic" [7] "periodic" "P" [-0.3 1 0 0 1.3 0 -0.3 1.5 0 -0.6 1.4 0 -0.7 1.1 0.2 -0.6 0.9 0.3 -0.4 0.8 0.2]
    "vertex float width" [0.05 0.1 0.15 0.1 0.05 0.1 0.05] "vertex color tint" [1 0 0 0 1 0 0 0 1 1 1 0 0 1 1 1 0 1 1 1 1]
  Curves "linear" [3 2] "nonperiodic" "P" [-0.8 0 -0.6 -0.6 0.3 -0.7 -0.8 0.6 -0.6 -0.5 0 -0.6 -0.4 0.5 -0.6] "constantwidth" [0.06]
    "constant color tint" [0.7 0.2 0.2]
AttributeEnd
AttributeBegin
  Attribute "grouping" "string membership" ["+shadowless"]
  Bxdf "PxrSurface" "blade" "color diffuseColor" [0.2 0.5 0.8] "float specularRoughness" [0.2] "color specularEdgeColor" [1 1 1]
  Basis "catmull-rom" 1 "catmull-rom" 1
  Curves "cubic" [5] "nonperiodic" "P" [0 -0.4 0 0.1 0 0 0.2 0.5 0 0 1 0 -0.1 1.4 0] "constantwidth" [0.2] "varying normal N" [0 0 -1 1 0 -1 1 0 0]
  Curves "linear" [4] "nonperiodic" "P" [0.5 0 -0.2 0.6 0.4 -0.2 0.5 0.7 0 0.8 0.9 0] "varying float width" [0.2 0.1 0.1 0.02]
AttributeEnd
ObjectBegin "tuft"
  Bxdf "PxrDiffuse" "half" "float presence" [0.5] "reference color diffuseColor" ["mixed:resultRGB"]
  Points "P" [0 0 0 0.15 0 0 0 0.2 0] "varying float width" [0.15 0.1 0.2] "vertex color tint" [1 0 0 0 1 0 0 0 1]
  Curves "cubic" [4] "nonperiodic" "P" [0.2 -0.2 0 0.3 0 0 0.2 0.2 0 0.3 0.4 0] "constantwidth" [0.08] "constant color tint" [0.9 0.5 0.1]
ObjectEnd
AttributeBegin Translate 0.8 0.3 -0.5 ObjectInstance "tuft" AttributeEnd
AttributeBegin
  MotionBegin [0 0.5 1]
    Translate 1.2 0.3 0
    Translate 1.3 0.5 0
    Translate 1.2 0.7 0
  MotionEnd
  Scale 1 1.5 0.7
  Rotate 30 0 0 1
  ObjectInstance "tuft"
AttributeEnd
AttributeBegin
  Bxdf "PxrSurface" "glass" "float diffuseGain" [0] "float refractionGain" [1] "float reflectionGain" [1] "float glassRoughness" [0]
    "color extinction" [0.2 1 0.5]
  MotionBegin [0 1]
  Points "P" [0.2 0.2 -1 0.7 0.2 -1.1] "varying float width" [0.3 0.3] "uniform string type" "sphere"
  Points "P" [0.2 0.25 -1 0.7 0.2 -0.9] "varying float width" [0.3 0.4] "uniform string type" "sphere"
  MotionEnd
AttributeEnd
AttributeBegin
  Bxdf "PxrDiffuse" "coarse" "color diffuseColor" [0.7 0.7 0.7]
  Translate -0.2 0.4 0.8
  MotionBegin [0 0.2 1]
  PointsPolygons [3 3 3 3 3 3 3 3] [0 2 4 2 1 4 1 3 4 3 0 4 2 0 5 1 2 5 3 1 5 0 3 5]
    "vertex point P" [0.4 0 0 -0.4 0 0 0 0.4 0 0 -0.4 0 0 0 0.4 0 0 -0.4] "vertex normal N" [1 0 0 -1 0 0 0 1 0 0 -1 0 0 0 1 0 0 -1]
  PointsPolygons [3 3 3 3 3 3 3 3] [0 2 4 2 1 4 1 3 4 3 0 4 2 0 5 1 2 5 3 1 5 0 3 5]
    "vertex point P" [0.5 0 0 -0.4 0 0 0 0.5 0 0 -0.4 0 0 0 0.4 0 0 -0.4] "vertex normal N" [1 0 0 -1 0 0 0 1 0 0 -1 0 0 0 1 0 0 -1]
  PointsPolygons [3 3 3 3 3 3 3 3] [0 2 4 2 1 4 1 3 4 3 0 4 2 0 5 1 2 5 3 1 5 0 3 5]
    "vertex point P" [0.6 0 0 -0.4 0.1 0 0 0.5 0 0 -0.4 0 0 0 0.5 0 0 -0.5] "vertex normal N" [1 0 0 -1 0 0 0 1 0 0 -1 0 0 0 1 0 0 -1]
  MotionEnd
AttributeEnd
AttributeBegin
  Matte 1
  Bxdf "PxrDiffuse" "hole" "color diffuseColor" [0.5 0.5 0.5]
  Points "P" [-0.1 0.9 -0.8] "constantwidth" [0.2] "vertex normal N" [0.3 0.2 -1]
AttributeEnd
WorldEnd
)";

struct Scene {
  const char* name;
  std::array<int, 2> resolution;
};
const Scene kScenes[] = {
    {"cornell", {64, 36}},  {"materials", {72, 30}},  {"field", {64, 36}},     {"overlap", {64, 48}},
    {"spaces", {64, 40}},   {"channels", {64, 48}},   {"strands", {64, 48}},   {"grass", {64, 36}},
    {"dragon", {64, 40}},   {"still_life", {64, 40}}, {"osl_wood", {48, 27}},  {"osl_brick", {48, 27}},
    {"osl_rust", {48, 27}}, {"osl_weave", {48, 27}},  {"osl_paint", {48, 27}}, {"osl_sky", {48, 27}},
    {"cloud", {44, 30}},    {"fire", {36, 42}},       {"wax", {48, 27}},       {"landscape", {60, 28}},
    {"candle", {27, 36}},   {"blocks", {48, 27}},     {"head", {32, 40}},      {"milk", {40, 30}}};

RenderRequest requestOf(const Scene& s) {
  RenderRequest r;
  r.channels = kAllChannels;
  const std::string name = s.name;
  if (name == "overlap")
    r.rib = kOverlap;
  else if (name == "spaces")
    r.rib = kSpaces;
  else if (name == "strands")
    r.rib = kStrands;
  else if (name == "channels")
    r.rib = channelsScene(), r.channels = kEverySource;
  else
    r.file = std::string(KINORA_SOURCE_DIR "/scenes/") + s.name + ".rib";
  r.settings.resolution = s.resolution;
  r.settings.samplesPerPixel = kSamples;
  r.settings.width = 8;
  return r;
}

// Where two films part: the first pixel and slot, and how many.
std::string difference(const film::Film& a, const film::Film& b) {
  const auto &w = a.window(), &v = b.window();
  if (a.slots() != b.slots()) return "different layouts";
  uint64_t pixels = 0;
  std::string first;
  for (int y = std::max(w.y0, v.y0); y < std::min(w.y1, v.y1); ++y)
    for (int x = std::max(w.x0, v.x0); x < std::min(w.x1, v.x1); ++x) {
      bool differs = false;
      for (int k = 0; k < a.slots(); ++k)
        if (a.pixel(x, y)[k] != b.pixel(x, y)[k] && !differs) {
          differs = true;
          if (first.empty()) {
            std::string channel = "counts";
            for (int c = 0; c < a.layout().size(); ++c)
              if (a.firstSlot(c) <= k) channel = a.layout()[c].name;
            first = "pixel " + std::to_string(x) + "," + std::to_string(y) + " slot " + std::to_string(k) + " (" +
                    channel + "): " + std::to_string(a.pixel(x, y)[k]) + " and " + std::to_string(b.pixel(x, y)[k]);
          }
        }
      pixels += differs;
    }
  return pixels ? std::to_string(pixels) + " pixels differ, first " + first : "";
}

class SameBits : public ::testing::TestWithParam<Scene> {
 protected:
  // The frame that others are compared with: width 8, one thread, groups of the default size.
  SceneRender& base() {
    static std::map<std::string, std::unique_ptr<SceneRender>> kept;
    auto& r = kept[GetParam().name];
    if (!r) r = std::make_unique<SceneRender>(requestOf(GetParam()));
    return *r;
  }
  void expectSame(const std::function<void(render::Settings&)>& change, const std::string& what) {
    RenderRequest request = requestOf(GetParam());
    change(request.settings);
    SceneRender other(request);
    ASSERT_TRUE(base().ok() && other.ok());
    const std::string d = difference(base().film(), other.film());
    EXPECT_EQ(d, "") << what << "; pictures: "
                     << SceneRender::keep(base().channel("Ci"), std::string(GetParam().name) + "-base") << ' '
                     << SceneRender::keep(other.channel("Ci"), std::string(GetParam().name) + "-other");
  }
};
INSTANTIATE_TEST_SUITE_P(Frames, SameBits, ::testing::ValuesIn(kScenes),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_P(SameBits, AtAllWidths) {
  for (const uint32_t width : {1u, 4u, 16u})
    expectSame([&](render::Settings& s) { s.width = width; }, "width " + std::to_string(width));
}

TEST_P(SameBits, WithTwoThreads) {
  for (int again = 0; again < 2; ++again) expectSame([](render::Settings& s) { s.threads = 2; }, "2 threads");
}

TEST_P(SameBits, InGroupsOfAnySize) {
  for (const uint32_t size : {64u, 256u, 1024u})
    expectSame([&](render::Settings& s) { s.groupSize = size; }, "groups of " + std::to_string(size));
}

TEST_P(SameBits, InAnyOrderOfBuckets) {
  for (const char* order : {"spiral", "random"})
    expectSame([&](render::Settings& s) { s.bucketOrder = order; }, order);
}

TEST_P(SameBits, WithEverythingChangedAtOnce) {
  expectSame(
      [](render::Settings& s) {
        s.width = 16;
        s.threads = 2;
        s.groupSize = 16;
        s.bucketOrder = "vertical";
      },
      "width 16, 2 threads, groups of 16, vertical");
}

TEST_P(SameBits, InPartsMergedThroughFiles) {
  constexpr int kMost = 64;
  const auto folder = std::filesystem::temp_directory_path();
  std::vector<std::string> files;
  RenderRequest all = requestOf(GetParam());
  all.settings.samplesPerPixel = kMost;
  SceneRender unsplit(all);
  for (const auto& [first, last] : {std::pair{16, kMost}, std::pair{0, 16}}) {
    RenderRequest request = all;
    request.settings.threads = first ? 2 : 1;
    request.settings.firstSample = first;
    request.settings.lastSample = last;
    SceneRender part(request);
    ASSERT_TRUE(part.ok());
    files.push_back((folder / ("kinora-bits-" + std::string(GetParam().name) + "-" + std::to_string(first) + "-" +
                               std::to_string(::getpid()) + ".exr"))
                        .string());
    ASSERT_TRUE(part.renderer().writeShard(files.back()));
  }
  film::Shard whole;
  std::vector<std::string> warnings;
  const auto status = film::mergeShards(files, whole, warnings);
  ASSERT_TRUE(status.ok()) << status.what;
  EXPECT_TRUE(warnings.empty()) << warnings[0];
  EXPECT_EQ(difference(unsplit.film(), *whole.film), "");
  EXPECT_EQ(stateOf(unsplit.film()), stateOf(*whole.film));
  for (const std::string& f : files) std::filesystem::remove(f);
}

TEST_P(SameBits, UnderCrop) {
  RenderRequest request = requestOf(GetParam());
  request.settings.crop = {0.29f, 0.71f, 0.13f, 0.64f};  // cuts through buckets and camera packets
  SceneRender part(request);
  ASSERT_TRUE(part.ok());
  const auto& w = part.film().window();
  EXPECT_GT(w.pixels(), 100u);
  EXPECT_LT(w.pixels(), base().film().window().pixels());
  EXPECT_EQ(difference(part.film(), base().film()), "");
}

// A replayed sample's printed colour against a film of that sample alone.
TEST_P(SameBits, Replayed) {
  constexpr int kSample = 5;
  RenderRequest request = requestOf(GetParam());
  request.settings.firstSample = kSample;
  request.settings.lastSample = kSample + 1;
  SceneRender one(request);
  request.settings.width = 1;
  SceneRender replayer(request);
  ASSERT_TRUE(one.ok() && replayer.ok());
  const auto& film = one.film();
  const int ci = film.layout().find("Ci"), slot = film.firstSlot(ci);
  const double step = film.layout()[ci].step();
  int compared = 0, lit = 0;
  const int apart = film.width() * film.height() < 2000 ? 4 : 5;
  for (int y = 1; y < film.height(); y += apart)
    for (int x = 2; x < film.width(); x += apart) {
      std::vector<std::string> lines;
      ASSERT_TRUE(replayer.renderer().replay(x, y, kSample, [&](const std::string& l) { lines.push_back(l); }));
      const auto line =
          std::find_if(lines.begin(), lines.end(), [](const std::string& l) { return l.starts_with("sample Ci:"); });
      ASSERT_NE(line, lines.end());
      std::istringstream values(line->substr(10));
      const double weight =
          double(film.pixel(x, y)[film::Film::kWeight]) * std::ldexp(1.0, film::Film::kWeightStepLog2);
      for (int c = 0; c < 3; ++c) {
        float v = 0;
        values >> v;
        lit += v > 0;
        // the weight is itself rounded in the film: exact when it is 1 (all filters without negative lobes)
        const double allowed =
            weight == 1 ? 0 : 1 + std::abs(v) * std::ldexp(1.0, film::Film::kWeightStepLog2) / step;
        EXPECT_NEAR(double(film.pixel(x, y)[slot + c]), double(std::llrint(double(v) * weight / step)), allowed)
            << x << ',' << y << " component " << c << ": replayed " << v;
      }
      ++compared;
    }
  EXPECT_GT(compared, 50);
  EXPECT_GT(lit, 50);
}

// Embree starts its divisions from the CPU's reciprocal estimates, and those are the maker's own: the last bits of a
// hit differ between makers, and hashes are kept for each.
const char* cpuMaker() { return __builtin_cpu_is("intel") ? "intel" : __builtin_cpu_is("amd") ? "amd" : "other"; }

TEST_P(SameBits, AsTheKeptHashes) {
  std::map<std::string, std::string> kept;
  std::ifstream in(kHashFile);
  for (std::string maker, name, hash; in >> maker >> name >> hash;) kept[maker + ' ' + name] = hash;
  in.close();
  const std::string name = std::string(cpuMaker()) + ' ' + GetParam().name;
  for (const uint32_t width : {0u, 1u, 16u}) {
    RenderRequest request = requestOf(GetParam());
    request.settings.width = width;
    request.settings.threads = 2;
    SceneRender r(request);
    ASSERT_TRUE(r.ok());
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hashOf(r.film())));
    if (width == 0 && std::getenv("KINORA_WRITE_HASHES")) {  // the other widths are compared with it
      kept[name] = text;
      std::ofstream out(kHashFile);
      for (const auto& [n, h] : kept) out << n << ' ' << h << '\n';
    }
    if (!kept.count(name)) GTEST_SKIP() << "no hash is kept for this maker's CPUs; here it is " << text;
    EXPECT_EQ(text, kept[name]) << "width " << width << "; picture: "
                                << SceneRender::keep(r.channel("Ci"), std::string(GetParam().name) + "-hash");
  }
}

}  // namespace
}  // namespace kinora::tests
