// What each family of requests leaves in the scene description: attributes, conditions, resources, declarations, and
// what is kept as it is. The files named after it have the other families. Proves the state machine and the values; how
// they are rendered is no business of this folder.
#include <array>
#include <string>
#include <variant>
#include <vector>

#include "rib/test_support.h"

namespace kinora::rib {
namespace {

using namespace scene;

TEST(Attributes, ClassicRequestsAndGroups) {
  const Read r = readWorld(R"(Color [1 0.5 0]
Opacity 0.5 0.5 0.5
TextureCoordinates 0 1 2 3 4 5 6 7
ShadingRate 4
ShadingInterpolation "constant"
Matte 1
Sides 1
Orientation "rh"
ReverseOrientation
Basis "b-spline" 1 "catmull-rom" 1
Attribute "identifier" "string name" ["ball"]
Attribute "visibility" "int camera" [0] "int indirect" 1
Attribute "grouping" "membership" ["a"]
Attribute "grouping" "string membership" ["+b c"]
AttributeBegin
  Attribute "user" "float x" [2]
  Sphere 1 -1 1 360
AttributeEnd
Sphere 2 -2 2 360)");
  expectClean(r);
  ASSERT_EQ(r.world().primitives.size(), 2u);
  const Attributes& a = *r.primitive(0).attributes;
  EXPECT_EQ(*a.color, (std::array<float, 3>{1, 0.5f, 0}));
  EXPECT_EQ(*a.opacity, (std::array<float, 3>{0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(a.textureCoordinates[7], 7);
  EXPECT_EQ(a.shadingRate, 4);
  EXPECT_FALSE(a.smoothShading);
  EXPECT_TRUE(a.matte);
  EXPECT_EQ(a.sides, 1);
  EXPECT_EQ(a.orientation, Attributes::Orientation::RightHanded);
  EXPECT_TRUE(a.reverseOrientation);
  EXPECT_EQ(a.uStep, 1);
  EXPECT_FLOAT_EQ(a.uBasis[13], 4.f / 6);
  EXPECT_EQ(a.vBasis[1], 1.5f);
  EXPECT_EQ(a.named.getString("identifier:name", ""), "ball");
  EXPECT_EQ(a.getInt("visibility:camera", 1), 0);
  EXPECT_EQ(a.named.getString("grouping:membership", ""), "a b c");
  EXPECT_EQ(a.named.getFloat("user:x", 0), 2);
  EXPECT_FALSE(r.primitive(1).attributes->named.find("user:x"));
  EXPECT_EQ(r.primitive(0).name(), "ball");
}

TEST(Attributes, RiGroupSetsTheClassicState) {
  const Read r = readWorld(
      "Attribute \"Ri\" \"int Sides\" [1] \"string Orientation\" [\"inside\"] \"int Matte\" [1] \"int "
      "ReverseOrientation\" [1]\nSphere 1 -1 1 360");
  const Attributes& a = *r.primitive().attributes;
  EXPECT_EQ(a.sides, 1);
  EXPECT_EQ(a.orientation, Attributes::Orientation::Inside);
  EXPECT_TRUE(a.matte && a.reverseOrientation);
}

TEST(Attributes, AreSharedBetweenTwoChanges) {
  const Read r = readWorld("Color 1 0 0\nSphere 1 -1 1 360\nSphere 1 -1 1 360\nColor 0 1 0\nSphere 1 -1 1 360");
  EXPECT_EQ(r.primitive(0).attributes, r.primitive(1).attributes);
  EXPECT_NE(r.primitive(0).attributes, r.primitive(2).attributes);
  EXPECT_EQ((*r.primitive(0).attributes->color)[0], 1);
}

TEST(Detail, BecomesAttributes) {
  const Read r = readRib(
      "RelativeDetail .5\nWorldBegin\nTranslate 1 0 0\nDetail [0 1 0 1 0 1]\nDetailRange 0 1 2 3\nSphere 1 -1 1 "
      "360\nWorldEnd");
  expectClean(r);
  EXPECT_EQ(r.world().options.getFloat("detail:relative", 1), .5f);
  EXPECT_EQ(r.primitive().attributes->named.getFloats("detail:range"), (std::vector<float>{0, 1, 2, 3}));
  const std::vector<float> corners = r.primitive().attributes->named.getFloats("detail:corners");
  ASSERT_EQ(corners.size(), 24u);
  EXPECT_EQ(corners[0], 1);
  EXPECT_EQ(corners[23], 1);
}

TEST(Conditions, ChooseBranchesAndNest) {
  const Read r = readRib(R"rib(Option "user" "string pass" ["beauty"] "float level" [3]
WorldBegin
IfBegin "$user:pass == 'shadow'"
  Sphere 1 -1 1 360
  IfBegin "1"
    Sphere 2 -2 2 360
  Else
    Sphere 2.5 -2 2 360
  IfEnd
ElseIf "$user:level > 2"
  Sphere 3 -3 3 360
ElseIf "1"
  Sphere 4 -4 4 360
Else
  Sphere 5 -5 5 360
IfEnd
IfBegin "defined(user:nothing)"
  Sphere 6 -6 6 360
Else
  Sphere 7 -7 7 360
IfEnd
WorldEnd)rib");
  expectClean(r);
  ASSERT_EQ(r.world().primitives.size(), 2u);
  EXPECT_EQ(std::get<Quadric>(r.primitive(0).shape).args[0], 3);
  EXPECT_EQ(std::get<Quadric>(r.primitive(1).shape).args[0], 7);
}

TEST(Conditions, NumbersOfTheSceneAreFloats) {
  const Read r = readRib(R"rib(Option "user" "float n" [.3] "color c" [1 .2 3] "int id" [1234567891]
WorldBegin
IfBegin "$user:n <= .3 && $user:n == 0.3 && $user:c == [1.0 0.2 3.0] && $user:id != 1234567890"
  Sphere 1 -1 1 360
IfEnd
Attribute "identifier" "string name" ["n${user:n}_${user:id}"]
Sphere 2 -2 2 360
WorldEnd)rib");
  expectClean(r);
  ASSERT_EQ(r.world().primitives.size(), 2u);
  EXPECT_EQ(r.primitive(1).attributes->named.getString("identifier:name", ""), "n0.3_1234567891");
}

// One sphere a condition, its radius the condition's place from 1; those that are false are missing.
void expectTrue(const std::string& options, const std::string& attributes, const std::vector<std::string>& conditions,
                const std::string& end = "") {
  std::string text = options + "\nWorldBegin\n" + attributes + "\n";
  for (size_t i = 0; i < conditions.size(); ++i) {
    const std::string radius = std::to_string(i + 1);
    text += "IfBegin \"" + conditions[i] + "\"\nSphere " + radius + " -1 1 360\nIfEnd\n";
  }
  const Read r = readRib(text + "WorldEnd\n" + end);
  expectClean(r);
  size_t next = 0;
  for (size_t i = 0; i < conditions.size(); ++i) {
    const bool isThere =
        next < r.world().primitives.size() && std::get<Quadric>(r.primitive(next).shape).args[0] == float(i + 1);
    EXPECT_TRUE(isThere) << conditions[i] << " after " << options << attributes;
    next += isThere;
  }
}

TEST(Conditions, ReadWhatRequestsSet) {
  expectTrue(
      "Format 8 6 2 PixelVariance .02 FrameAspectRatio 1 PixelFilter \"box\" 1 3 CropWindow 0 .5 0 1 Shutter 0 .5 "
      "ScreenWindow -2 2 -1 1 Clipping .1 100 PixelSamples 4 2 Exposure 2 1",
      "Color 1 .2 3 Opacity .5 .5 .5 Sides 1 Matte 1 Orientation \"lh\" ReverseOrientation ShadingRate 4 "
      "ShadingInterpolation \"constant\" TextureCoordinates 0 1 2 3 4 5 6 7",
      {"$Ri:FormatResolution == [8 6]",
       "$Option:Ri:FormatResolution == [8 6]",
       "$Ri:FormatPixelAspectRatio == 2",
       "$Ri:PixelVariance == .02",
       "$Ri:FrameAspectRatio == 1",
       "$Ri:PixelFilterName == 'box'",
       "$Ri:PixelFilterWidth == [1 3]",
       "$Ri:CropWindow == [0 .5 0 1]",
       "$Ri:Shutter == [0 .5]",
       "$Ri:ScreenWindow == [-2 2 -1 1]",
       "$Ri:Clipping == [.1 100]",
       "$Ri:PixelSamples == [4 2]",
       "$Ri:Exposure == [2 1]",
       "$Ri:Color == [1 .2 3]",
       "$Color == [1 .2 3]",
       "$Ri:Opacity == [.5 .5 .5]",
       "$Attribute:Ri:Sides == 1",
       "$Ri:Matte == 1",
       "$Ri:Orientation == 'lh'",
       "$Ri:ReverseOrientation == 1",
       "$Ri:ShadingRate == 4",
       "$Ri:ShadingInterpolation == 'constant'",
       "$Ri:TextureCoordinates == [0 1 2 3 4 5 6 7]",
       "!defined(Ri:Frame) && !defined(Attribute:Ri:FormatResolution) && !defined(Option:Ri:Sides)"});
  expectTrue("FrameBegin 3", "", {"$Ri:Frame == 3", "$Frame == 3"}, "FrameEnd");
}

// Whichever of a request and the list of its group came last.
TEST(Conditions, RequestsAndListsSetTheSame) {
  expectTrue("Option \"Ri\" \"int[2] FormatResolution\" [8 8] \"float PixelVariance\" [1] Format 4 2 1",
             "Attribute \"Ri\" \"int Sides\" [1] \"int Matte\" [1] Sides 2",
             {"$Ri:FormatResolution == [4 2]", "$Ri:PixelVariance == 1", "$Ri:Sides == 2", "$Ri:Matte == 1"});
  expectTrue("Format 4 2 1 Option \"Ri\" \"int[2] FormatResolution\" [8 8] \"int Frame\" [7]",
             "Sides 1 Attribute \"Ri\" \"int Sides\" [2] \"string Orientation\" [\"rh\"] Scale -1 1 1",
             {"$Ri:FormatResolution == [8 8]", "$Ri:Frame == 7", "$Frame == 7", "$Ri:Sides == 2",
              "$Ri:Orientation == 'lh'"});
}

TEST(Conditions, ReadWhatHoldsWhereNothingIsSaid) {
  expectTrue("Format 200 100 1", "",
             {"$visibility:camera == 1",
              "$identifier:name == ''",
              "$dice:micropolygonlength == 1",
              "$trace:bias == .01",
              "$Ri:Sides == 2",
              "$Ri:Orientation == 'outside'",
              "$Ri:Color == [1 1 1]",
              "$limits:bucketsize == [16 16]",
              "$shutter:offset == 0",
              "$Ri:CropWindow == [0 1 0 1]",
              "$Ri:ScreenWindow == [-2 2 -1 1]",
              "$Ri:FrameAspectRatio == -1",
              "$Ri:PixelFilterName == 'gaussian'",
              "$lighting:minimumestimate == 1e-6",
              "$dice:offscreenmultiplier == -1",
              "$Option:dice:offscreenmultiplier == 1",
              "$lpe:specular4 == 'Clearcoat' && $lpe:user12 == ''",
              "$grouping:id == 0",
              "!defined(visibility:nothing) && !defined(visibility) && !defined(nothing:camera)",
              "!defined(Option:visibility:camera) && !defined(Attribute:limits:bucketsize)"});
  expectTrue("", "Attribute \"visibility\" \"int camera\" [0]", {"$visibility:camera == 0"});
  // an object's own come first, then those around it
  const Read r = readWorld(
      "Sides 1 Color 1 0 0\nObjectBegin \"o\"\nColor 0 1 0\nIfBegin \"$Ri:Sides == 1 && $Ri:Color == [0 1 0] && "
      "$Ri:Matte == 0\"\nSphere 1 -1 1 360\nIfEnd\nObjectEnd\nObjectInstance \"o\"");
  expectClean(r);
  EXPECT_EQ(r.world().prototypes.at(0).primitives.size(), 1u);
}

// A terminal whose patterns are missing yet does not come back after a restore.
TEST(Resources, ShadingReplacesWhatWaitsForPatterns) {
  const Read r = readWorld(R"(Bxdf "A" "a"
Resource "r" "attributes" "string operation" ["save"]
Bxdf "B" "b" "reference color c" ["p:out"]
Displace "D" "d" "reference float s" ["p:out"]
Resource "late" "attributes" "string operation" ["save"]
Resource "r" "attributes" "string operation" ["restore"] "string subset" ["shading"]
Sphere 1 -1 1 360
Pattern "P" "p"
Resource "late" "attributes" "string operation" ["restore"] "string subset" ["shading"]
Sphere 1 -1 1 360)");
  expectClean(r);
  EXPECT_EQ(r.primitive(0).attributes->bxdf->terminal->plugin, "A");
  EXPECT_EQ(r.primitive(0).attributes->displacement, nullptr);
  EXPECT_EQ(r.primitive(1).attributes->bxdf->terminal->plugin, "B");
  EXPECT_EQ(r.primitive(1).attributes->bxdf->patterns.size(), 1u) << "what waited goes on to wait";
  EXPECT_EQ(r.primitive(1).attributes->displacement->patterns.size(), 1u);
}

TEST(Resources, SaveAndRestore) {
  const Read r = readWorld(R"(ResourceBegin
Color 1 0 0
Translate 1 0 0
Resource "r" "attributes" "string operation" ["save"] "string subset" ["all"]
Color 0 1 0
Translate 1 0 0
Resource "r" "attributes" "string operation" ["restore"] "string subset" ["shading"]
Sphere 1 -1 1 360
Resource "r" "attributes" "string operation" ["restore"] "string subset" ["transform"]
Sphere 1 -1 1 360
ResourceEnd)");
  expectClean(r);
  EXPECT_EQ((*r.primitive(0).attributes->color)[0], 1);
  EXPECT_EQ(r.primitive(0).toWorld.matrices[0][3][0], 2);
  EXPECT_EQ(r.primitive(1).toWorld.matrices[0][3][0], 1);
}

TEST(Kept, EveryOtherRequestIsKeptAndReportedOnce) {
  const char* const kNames[] = {"Bound",
                                "ColorSamples",
                                "ConnectShaderLayers",
                                "EnableLightFilter",
                                "ErrorHandler",
                                "GeometricApproximation",
                                "GeometricRepresentation",
                                "Imager",
                                "MakeBrickMap",
                                "MakeBump",
                                "MakeCubeFaceEnvironment",
                                "MakeLatLongEnvironment",
                                "MakeShadow",
                                "MakeTexture",
                                "Quantize",
                                "ShaderLayer",
                                "System",
                                "VolumePixelSamples"};
  std::string text;
  for (int twice = 0; twice < 2; ++twice)
    for (const char* n : kNames) text += std::string(n) + " \"a\" 1 \"string x\" [\"y\"]\n";
  const Read r = readRib(text + "WorldBegin\nWorldEnd");
  EXPECT_EQ(r.world().kept.size(), 2 * std::size(kNames));
  EXPECT_EQ(r.messages.size(), std::size(kNames)) << r.all();
  EXPECT_EQ(r.world().kept[0].request, "Bound");
  EXPECT_EQ(r.world().kept[0].args, (std::vector<std::string>{"a", "1"}));
  EXPECT_EQ(r.world().kept[0].params.getString("x", ""), "y");
  Explanations explain;
  explain.add(explanations());
  for (const Message& m : r.messages) EXPECT_TRUE(explain.find(m.code)) << m.code;
  const Read edit = readWorld("Sphere 1 -1 1 360\nEditBegin \"attribute\"\nSphere 9 -9 9 360\nEditEnd\n");
  EXPECT_EQ(edit.world().kept.size(), 1u);
  EXPECT_EQ(edit.world().primitives.size(), 1u);
}

TEST(Declarations, DeclareAndInline) {
  const Read r = readWorld(R"(Declare "a" "uniform color"
Declare "b" "vertex float[2]"
Polygon "P" [0 0 0 1 0 0 0 1 0] "a" [1 2 3] "b" [1 2 3 4 5 6] "constant int[2] c" [7 8] "constant string d" "text" "varying point e" [1 2 3 4 5 6 7 8 9] "constant matrix m" [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] "constant hpoint h" [1 2 3 4] "facevarying normal n" [0 0 1 0 0 1 0 0 1] "facevertex float v" [1 2 3] "integer i" 4 "normal N" [0 0 1 0 0 1 0 0 1])");
  expectClean(r);
  const ParameterList& p = r.primitive().primvars;
  EXPECT_EQ(p.find("a")->type, ValueType::Color);
  EXPECT_EQ(p.find("b")->storage, StorageClass::Vertex);
  EXPECT_EQ(p.find("b")->elementFloats(), 2u);
  EXPECT_EQ(p.find("c")->ints, (std::vector<int>{7, 8}));
  EXPECT_EQ(p.getString("d", ""), "text");
  EXPECT_EQ(p.find("m")->type, ValueType::Matrix);
  EXPECT_EQ(p.find("h")->type, ValueType::HPoint);
  EXPECT_EQ(p.find("n")->storage, StorageClass::FaceVarying);
  EXPECT_EQ(p.find("v")->storage, StorageClass::FaceVertex);
  EXPECT_EQ(p.getInt("i", 0), 4);
  EXPECT_EQ(p.find("N")->storage, StorageClass::Varying) << "a class left out is the one the name is known by";
}

// type[] and type[0], as exporters write arrays whose length they do not know: the value's, and none is no parameter.
TEST(Declarations, ArraysWithoutALengthHaveTheirValues) {
  for (const char* length : {"[]", "[0]", "[ ]", "[ 0 ]"}) {
    const std::string n = length;
    const Read r =
        readWorld("Declare \"c\" \"constant int" + n + "\"\nBxdf \"PxrDiffuse\" \"d\" \"color" + n +
                  " a\" [1 2 3 4 5 6] \"int" + n + " b\" [] \"c\" [7 8 9] \"string" + n +
                  " e\" [\"x\" \"y\"] \"float" + n + " f\" 2\nSphere 1 -1 1 360 \"constant float" + n + " g\" [1 2]");
    EXPECT_TRUE(r.messages.empty()) << n << r.all();
    const ParameterList& p = r.primitive().attributes->bxdf->terminal->params;
    ASSERT_TRUE(p.find("a") && p.find("c") && p.find("e") && p.find("f")) << n;
    EXPECT_EQ(p.find("a")->arrayLength, 2) << n;
    EXPECT_EQ(p.find("b"), nullptr) << n;
    EXPECT_EQ(p.find("c")->ints, (std::vector<int>{7, 8, 9})) << n;
    EXPECT_EQ(p.find("c")->arrayLength, 3) << n;
    EXPECT_EQ(p.find("e")->arrayLength, 2) << n;
    EXPECT_TRUE(p.find("f")->isArray) << n;
    EXPECT_EQ(p.find("f")->arrayLength, 1) << n;
    ASSERT_TRUE(r.primitive().primvars.find("g")) << n;
    EXPECT_EQ(r.primitive().primvars.find("g")->elementFloats(), 2u) << n;
  }
  // where an element ends is nobody's knowledge
  const Read varying = readWorld("Sphere 1 -1 1 360 \"varying float[] g\" [1 2 3 4 5 6 7 8]");
  expectMessage(varying, "RIB-DECLARATION", 2);
  EXPECT_NE(varying.all().find("varying float[2] g"), std::string::npos) << varying.all();
  expectMessage(readWorld("Bxdf \"PxrDiffuse\" \"d\" \"color[] a\" [1 2 3 4]"), "RIB-ARRAY-LENGTH", 2);
}

TEST(Declarations, BareRowsOfNumbersAreOneValue) {
  const Read r =
      readWorld("Bxdf \"PxrDiffuse\" \"d\" \"color diffuseColor\" 1 0.5 0 \"float x\" 2\nSphere 1 -1 1 360");
  expectClean(r);
  EXPECT_EQ(r.primitive().attributes->bxdf->terminal->params.getFloats("diffuseColor"),
            (std::vector<float>{1, 0.5f, 0}));
}

}  // namespace
}  // namespace kinora::rib
