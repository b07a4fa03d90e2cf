// What is written reads back: the second description, written again, is the same text as the first. Proves that
// nothing is lost on the way that the writer knows of; requests_test.cpp proves that the reader finds all there is.
#include "rib/writer.h"

#include <cstdlib>
#include <filesystem>
#include <regex>

#include "rib/test_support.h"
#include "scene/edits_testing.h"

namespace kinora::rib {
namespace {

bool isOfWhatIsKept(const Message& m) { return m.code.starts_with("RIB-KEPT-") || m.code == "ASSET-PROGRAM-REFUSED"; }

std::string again(const std::string& text, size_t primitives) {
  const Read r = readRib(text);
  for (const Message& m : r.messages)
    if (!isOfWhatIsKept(m)) ADD_FAILURE() << m.str() << "\n" << text.substr(0, 3000);
  EXPECT_EQ(r.world().primitives.size(), primitives);
  return r.worlds.empty() ? std::string() : writeRib(r.world());
}

const char* const kEverything = R"(FrameBegin 3
Format 64 32 1
Option "limits" "int[2] bucketsize" [16 16]
Integrator "PxrPathTracer" "it" "int maxIndirectBounces" [4]
Hider "raytrace" "int maxsamples" [64]
DisplayChannel "color diffuse" "string source" ["color lpe:C<RD>[<L.>O]"]
Display "a \"b\".exr" "openexr" "rgba"
Display "+c.exr" "openexr" "diffuse"
Quantize "rgba" 255 0 255 0.5
TransformBegin
Projection "orthographic"
Camera "top"
TransformEnd
Projection "perspective" "fov" [35]
DepthOfField 2.8 0.05 3
Shutter 0 1
MotionBegin [0 1]
Translate 0 0 5
Translate 0 0 6
MotionEnd
WorldBegin
CoordinateSystem "mark"
Attribute "Ri" "int ReverseOrientation" [1]
ReverseOrientation
ObjectBegin "leaf"
Sides 2
Sphere 1 -1 1 360 "constant color Cs" [1 0 0]
SolidBegin "primitive"
SolidEnd
ObjectEnd
ObjectBegin "tree"
SolidBegin "primitive"
SolidEnd
Translate 0 1 0
ObjectInstance "leaf"
ObjectEnd
AttributeBegin
LightFilter "PxrRodLightFilter" "rod"
Translate 0 5 0
Light "PxrRectLight" "key" "float intensity" [3]
AttributeEnd
AttributeBegin
Light "PxrMeshLight" "mesh"
Sphere 0.1 -0.1 0.1 360
AttributeEnd
LightSource "pointlight" 1 "from" [1 2 3]
Pattern "PxrTexture" "tex" "string filename" ["a\nb.tex"]
Bxdf "PxrSurface" "s" "reference color diffuseColor" ["tex:resultRGB"] "float diffuseGain" [0.1]
Surface "plastic" "Kd" 0.5
Color 0.1 0.2 0.3
Basis "b-spline" 1 "catmull-rom" 1
Orientation "rh"
AttributeBegin
MotionBegin [0 1]
Rotate 0 0 1 0
Rotate 30 0 1 0
MotionEnd
MotionBegin [0 1]
Sphere 1 -1 1 360
Sphere 2 -2 2 360
MotionEnd
AttributeEnd
MotionBegin [0 1]
Polygon "P" [0 0 0 1 0 0 0 1 0]
Polygon "P" [0 0 1 1 0 1 0 1 1.1]
MotionEnd
GeneralPolygon [3 3] "P" [0 0 0 9 0 0 0 9 0 1 1 0 2 1 0 1 2 0]
PointsPolygons [3 3] [0 1 2 2 1 3] "P" [0 0 0 1 0 0 0 1 0 1 1 0] "facevarying float[2] st" [0 0 0 0 0 0 0 0 0 0 0 0]
SubdivisionMesh "catmull-clark" [4] [0 1 2 3] ["interpolateboundary" "crease"] [0 0 2 1] [0 1] [3.5] "P" [0 0 0 1 0 0 1 1 0 0 1 0]
Curves "cubic" [4] "nonperiodic" "P" [0 0 0 1 0 0 2 0 0 3 0 0] "varying float width" [1 2]
Points "P" [0 0 0 1 1 1] "constantwidth" [0.1]
Patch "bilinear" "P" [0 0 0 1 0 0 0 1 0 1 1 0]
PatchMesh "bilinear" 2 "nonperiodic" 2 "nonperiodic" "P" [0 0 0 1 0 0 0 1 0 1 1 0]
TrimCurve [1] [2] [0 0 1 1] [0] [1] [2] [0 1] [0 1] [1 1]
NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 "P" [0 0 0 1 0 0 0 1 0 1 1 0]
Blobby 1 [1001 0] [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] [""]
Volume "box" [-1 1 -1 1 -1 1] [2 2 2] "varying float density" [1 1 1 1 1 1 1 1]
Procedural "RunProgram" ["x" "y"] [-1 1 -1 1 -1 1]
AttributeBegin
LightSource "distantlight" 1 "to" [0 1 0]
Illuminate "key" 0
Sphere 1 -1 1 360
AttributeEnd
Scale 2 2 2
ObjectInstance "tree"
SolidBegin "difference"
SolidBegin "primitive"
Cone 1 1 360
SolidEnd
SolidBegin "union"
Sphere 1 -1 1 360
ObjectInstance "tree"
SolidEnd
SolidEnd
WorldEnd
FrameEnd
)";

TEST(Writer, RoundTrip) {
  const Read r = readRib(kEverything);
  for (const Message& m : r.messages) EXPECT_TRUE(isOfWhatIsKept(m)) << m.str();
  ASSERT_EQ(r.world().primitives.size(), 16u);
  const std::string first = writeRib(r.world()), second = again(first, 16);
  EXPECT_EQ(first, second);
  const Read back = readRib(first);
  EXPECT_EQ(back.world().frame, 3);
  EXPECT_EQ(back.world().cameras.size(), 2u);
  EXPECT_EQ(back.world().cameras[0].worldToCamera.at(0.5)[3][2], 5.5);
  EXPECT_EQ(back.world().displays[0].file, "a \"b\".exr");
  EXPECT_EQ(back.world().lights.size(), 2u);
  ASSERT_EQ(back.world().classicLights.size(), 2u);
  const auto lights = [&](size_t i) { return *back.primitive(i).attributes->lightSources; };
  EXPECT_EQ(lights(13), (std::vector<uint32_t>{back.world().classicLights[0].id, back.world().classicLights[1].id}));
  EXPECT_EQ(lights(0), (std::vector<uint32_t>{back.world().classicLights[0].id}));
  EXPECT_EQ(back.world().prototypes.size(), 2u);
  EXPECT_EQ(back.world().solids, r.world().solids);
  EXPECT_EQ(back.primitive(15).solid, 4u);
  EXPECT_EQ(back.world().instances[1].solid, 5u);
  EXPECT_EQ(back.world().instances[0].toWorld.matrices[0][0][0], 2);
  // the default, said inside an object, wins over an instance's
  EXPECT_TRUE(back.world().prototypes[0].primitives[0]->attributes->says(scene::Attributes::kSides));
  EXPECT_FALSE(back.world().prototypes[0].primitives[0]->attributes->says(scene::Attributes::kMatte));
  EXPECT_EQ(back.primitive(0).toWorld.at(0.5), r.primitive(0).toWorld.at(0.5));
  EXPECT_EQ(back.primitive(0).attributes->bxdf->patterns[0]->params.getString("filename", ""), "a\nb.tex");
  EXPECT_EQ(back.primitive(0).attributes->reverseOrientation, r.primitive(0).attributes->reverseOrientation);
}

// So many that the description packs them: placed, turned, moving and coloured each by itself.
TEST(Writer, ManyInstances) {
  std::string rib = "WorldBegin\nObjectBegin \"a\"\nSphere 1 -1 1 360\nObjectEnd\nObjectBegin \"b\"\nDisk 0 1 360\n";
  for (int i = 0; i < 300; ++i)
    rib += "TransformBegin\nTranslate 0 " + std::to_string(i) + " 0\nObjectInstance \"a\"\nTransformEnd\n";
  rib += "ObjectEnd\n";
  for (int i = 0; i < 1500; ++i) {
    const std::string n = std::to_string(i);
    rib += "AttributeBegin\n";
    if (i >= 600 && i < 1200 && i % 3 == 0) rib += "Color [." + n + " 0 1]\n";
    if (i % 400 == 399) rib += "MotionBegin [0 1]\nTranslate 0 0 0\nTranslate 0 ." + n + " 0\nMotionEnd\n";
    rib += i % 2 ? "Translate " + n + " .5 0\n" : "Rotate " + n + ".3 0 1 .2\n";
    rib += std::string("ObjectInstance \"") + (i % 7 ? "a" : "b") + "\"\nAttributeEnd\n";
  }
  const Read r = readRib(rib + "WorldEnd\n");
  ASSERT_EQ(r.world().instances.size(), 1500u);
  ASSERT_EQ(r.world().prototypes[1].instances.size(), 300u);
  const std::string text = writeRib(r.world());
  const Read back = readRib(text);
  ASSERT_EQ(back.world().instances.size(), 1500u);
  EXPECT_EQ(writeRib(back.world()), text);
  for (size_t i = 0; i < 1500; ++i) {
    const scene::Instance a = r.world().instances[i], b = back.world().instances[i];
    ASSERT_EQ(a.prototype, b.prototype);
    ASSERT_EQ(a.attributes->color, b.attributes->color);
    ASSERT_EQ(a.toWorld.at(0.5), b.toWorld.at(0.5)) << i;
  }
}

// Every edit of a field shows in the text, but for what requests have no place for. Misses edits that make lists
// longer or shorter, which most of them take from each other.
TEST(Writer, WritesEveryField) {
  static const std::regex kNoPlace(
      // requests have positions instead of declarations there, or no place for a handle
      ".*(argument \".*|trim curves \".*|attribute \"illuminate:off)\": (type|storage class|reference|array|name.*)|"
      ".*array length|.*\"__quadric\": .*|.*(shaders.*|projection|hider): handle.*|"
      // what follows from something else: static transforms, the camera's space, a mesh light's own transform and
      // attributes, numbers of points
      ".*times.*|coordinate system \"(camera|world)\".*|.*geometry: (attributes|transform):.*|"
      ".*shape: (loops|faces|count).*|"
      // what is no operand of another: a light's geometry, a solid of itself
      ".*geometry: solid|.*solids\\[0\\]: operand of|"
      // what is off stays off: a lens, a frame's aspect, the last numbers of a quadric that has fewer, lights that
      // are not there
      "cameras.*depth of field.*|frame aspect|pixel variance|pixel samples.*|.*size.*|.*light sources made");
  const Read r = readRib(kEverything);
  scene::test::Edits edits(r.world());
  const std::string before = writeRib(r.world());
  size_t shown = 0;
  for (size_t i = 0; i < edits.sites().size(); ++i) {
    const scene::test::EditSite& site = edits.sites()[i];
    if (!site.counts || site.path.ends_with("= none") || site.path.ends_with("longer") ||
        site.path.ends_with("shorter"))
      continue;
    const bool isShown = writeRib(edits.edited(i)) != before;
    shown += isShown;
    EXPECT_TRUE(isShown || std::regex_match(site.path, kNoPlace)) << site.path;
  }
  EXPECT_GT(shown, 1500u);
}

}  // namespace
}  // namespace kinora::rib
