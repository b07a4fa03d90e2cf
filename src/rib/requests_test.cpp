// What each family of requests leaves in the scene description. Proves the state machine and the values; how they are
// rendered is no business of this folder.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "rib/test_support.h"

namespace kinora::rib {
namespace {

using namespace scene;

void expectClean(const Read& r) { EXPECT_TRUE(r.messages.empty()) << r.all(); }

TEST(Options, EveryRequestBeforeTheWorld) {
  const Read r = readRib(R"(version 3.04
FrameBegin 7
Format 640 480 0.5
FrameAspectRatio 1.5
ScreenWindow -1 1 -0.5 0.5
CropWindow 0.1 0.9 0.2 0.8
Projection "perspective" "fov" [40]
Clipping 0.1 1000
DepthOfField 2.8 0.05 3
Shutter 0.25 0.75
PixelFilter "mitchell" 3 4
PixelSamples 4 5
PixelVariance 0.01
Exposure 2 2.2
Option "limits" "int[2] bucketsize" [16 32] "gridsize" [256]
Option "user" "string pass" ["beauty"]
Display "a.exr" "openexr" "rgba" "int[4] quantize" [0 0 0 0]
Display "+b.exr" "openexr" "Ci,a"
DisplayChannel "color diffuse" "string source" ["color lpe:C<RD>[<L.>O]"]
DisplayChannel "varying float[2] two"
Hider "raytrace" "int maxsamples" [64]
Integrator "PxrPathTracer" "it" "int maxIndirectBounces" [4]
SampleFilter "PxrA" "a"
SampleFilter "PxrB" "b" "reference samplefilter[1] filter" ["a"]
DisplayFilter "PxrBackgroundDisplayFilter" "bg" "color backgroundColor" [1 0 0]
Translate 0 0 5
WorldBegin
Sphere 1 -1 1 360
WorldEnd
FrameEnd
)");
  expectClean(r);
  ASSERT_EQ(r.worlds.size(), 1u);
  const Scene& s = r.world();
  EXPECT_TRUE(s.hasFrame);
  EXPECT_EQ(s.frame, 7);
  EXPECT_EQ(s.resolution, (std::array<int, 2>{640, 480}));
  EXPECT_EQ(s.pixelAspect, 0.5f);
  EXPECT_EQ(s.frameAspect, 1.5f);
  EXPECT_EQ(s.cropWindow, (std::array<float, 4>{0.1f, 0.9f, 0.2f, 0.8f}));
  EXPECT_EQ(s.pixelFilter, "mitchell");
  EXPECT_EQ(s.pixelFilterWidth, (std::array<float, 2>{3, 4}));
  EXPECT_EQ(s.pixelSamples, (std::array<int, 2>{4, 5}));
  EXPECT_EQ(s.pixelVariance, 0.01f);
  EXPECT_EQ(s.exposure, (std::array<float, 2>{2, 2.2f}));
  EXPECT_EQ(s.options.find("limits:bucketsize")->ints, (std::vector<int>{16, 32}));
  EXPECT_EQ(s.options.getInt("limits:gridsize", 0), 256);
  EXPECT_EQ(s.options.getString("user:pass", ""), "beauty");
  ASSERT_EQ(s.displays.size(), 2u);
  EXPECT_EQ(s.displays[0].driver, "openexr");
  EXPECT_EQ(s.displays[1].file, "b.exr");
  EXPECT_EQ(s.displays[1].mode, "Ci,a");
  ASSERT_EQ(s.channels.size(), 2u);
  EXPECT_EQ(s.channels[0].name, "diffuse");
  EXPECT_EQ(s.channels[0].type, ValueType::Color);
  EXPECT_EQ(s.channels[0].params.getString("source", ""), "color lpe:C<RD>[<L.>O]");
  EXPECT_EQ(s.channels[1].arrayLength, 2);
  EXPECT_EQ(s.hider->params.getInt("maxsamples", 0), 64);
  EXPECT_EQ(s.integrator->plugin, "PxrPathTracer");
  EXPECT_EQ(s.integrator->handle, "it");
  ASSERT_EQ(s.sampleFilters.size(), 2u);
  EXPECT_EQ(s.sampleFilters.back()->plugin, "PxrB");
  EXPECT_EQ(s.displayFilters[0]->params.getFloats("backgroundColor"), (std::vector<float>{1, 0, 0}));
  ASSERT_EQ(s.cameras.size(), 1u);
  const Camera& c = s.cameras[0];
  EXPECT_EQ(c.projection->params.getFloat("fov", 0), 40);
  EXPECT_EQ(c.screenWindow, (std::array<float, 4>{-1, 1, -0.5f, 0.5f}));
  EXPECT_EQ(c.clipping, (std::array<float, 2>{0.1f, 1000}));
  EXPECT_EQ(c.depthOfField, (std::array<float, 3>{2.8f, 0.05f, 3}));
  EXPECT_EQ(c.shutter, (std::array<double, 2>{0.25, 0.75}));
  EXPECT_EQ(c.worldToCamera.matrices[0][3][2], 5);
  EXPECT_EQ(s.pos.line, 27u);
}

TEST(Options, RiGroupAndDefaults) {
  const Read r = readRib(
      R"(Option "Ri" "int[2] FormatResolution" [32 16] "float PixelVariance" [0.5] "float[2] Shutter" [0 1] "int Frame" [3]
DepthOfField 1e999 1 1
WorldBegin
WorldEnd)");
  expectClean(r);
  EXPECT_EQ(r.world().resolution, (std::array<int, 2>{32, 16}));
  EXPECT_EQ(r.world().pixelVariance, 0.5f);
  EXPECT_EQ(r.world().frame, 3);
  EXPECT_EQ(r.world().cameras[0].shutter[1], 1);
  EXPECT_EQ(r.world().cameras[0].depthOfField[0], 0) << "an infinite f-number is a pinhole";
  EXPECT_EQ(r.world().cameras[0].projection, nullptr);
}

TEST(Cameras, NamedAndPrimary) {
  const Read r = readRib(R"(TransformBegin
Translate 0 0 1
Projection "perspective" "fov" [20]
Camera "side"
TransformEnd
Projection "perspective" "fov" [30]
Translate 0 0 2
Camera "world" "float[2] shutteropening" [0 1]
WorldBegin
WorldEnd)");
  expectClean(r);
  ASSERT_EQ(r.world().cameras.size(), 2u);
  EXPECT_EQ(r.world().cameras[0].name, "world");
  EXPECT_EQ(r.world().cameras[0].worldToCamera.matrices[0][3][2], 2);
  EXPECT_EQ(r.world().cameras[0].params.getFloats("shutteropening").size(), 2u);
  EXPECT_EQ(r.world().cameras[1].name, "side");
  EXPECT_EQ(r.world().cameras[1].projection->params.getFloat("fov", 0), 20);
  // no camera called "world" and nothing else placed: the first one named
  const Read t = readRib("TransformBegin Translate 0 0 4 Camera \"main\" TransformEnd WorldBegin WorldEnd");
  ASSERT_EQ(t.world().cameras.size(), 1u);
  EXPECT_EQ(t.world().cameras[0].name, "main");
}

TEST(Frames, StateComesBackAndFilesAreOneStream) {
  const Read r = readRib(std::vector<std::string>{
      "Format 10 20 1\nFrameBegin 1\nFormat 30 40 1\nWorldBegin\nColor 1 0 0\nSphere 1 -1 1 "
      "360\nWorldEnd\nFrameEnd\n",
      "FrameBegin 2\nWorldBegin\nSphere 1 -1 1 360\nWorldEnd\nFrameEnd\nDeclare \"x\" \"constant float\"\n",
      "WorldBegin\nSphere 1 -1 1 360 \"x\" 3\nWorldEnd\n"});
  expectClean(r);
  ASSERT_EQ(r.worlds.size(), 3u);
  EXPECT_EQ(r.worlds[0].resolution[0], 30);
  EXPECT_EQ(r.worlds[1].resolution[0], 10);
  EXPECT_EQ(r.worlds[1].frame, 2);
  EXPECT_FALSE(r.worlds[1].primitives[0]->attributes->color);
  EXPECT_TRUE(r.worlds[0].primitives[0]->attributes->color);
  EXPECT_EQ(r.worlds[2].primitives[0]->primvars.getFloat("x", 0), 3);
  EXPECT_FALSE(r.worlds[2].hasFrame);
}

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

TEST(Transforms, EachRequest) {
  const auto at = [](const char* request, Imath::V3d p) {
    const Read r = readWorld(std::string(request) + "\nSphere 1 -1 1 360");
    EXPECT_TRUE(r.messages.empty()) << r.all();
    Imath::V3d q;
    r.primitive().toWorld.matrices[0].multVecMatrix(p, q);
    return q;
  };
  const auto near = [](Imath::V3d a, Imath::V3d b) { return a.equalWithAbsError(b, 1e-12); };
  EXPECT_TRUE(near(at("Translate 1 2 3", {1, 1, 1}), {2, 3, 4}));
  EXPECT_TRUE(near(at("Scale 1 2 3", {1, 1, 1}), {1, 2, 3}));
  EXPECT_TRUE(near(at("Rotate 90 0 0 1", {1, 0, 0}), {0, 1, 0}));
  EXPECT_TRUE(near(at("Rotate 90 1 0 0", {0, 1, 0}), {0, 0, 1}));
  EXPECT_TRUE(near(at("Translate 1 0 0 Scale 2 2 2", {1, 0, 0}), {3, 0, 0})) << "the latest request acts first";
  EXPECT_TRUE(near(at("Scale 9 9 9 Transform [1 0 0 0 0 1 0 0 0 0 1 0 4 5 6 1]", {1, 1, 1}), {5, 6, 7}));
  EXPECT_TRUE(near(at("Translate 1 0 0 ConcatTransform 1 0 0 0  0 1 0 0  0 0 1 0  4 5 6 1", {0, 0, 0}), {5, 5, 6}));
  EXPECT_TRUE(near(at("Translate 1 0 0 Identity", {0, 0, 1}), {0, 0, 1}));
  EXPECT_TRUE(near(at("Skew 45 0 1 0 1 0 0", {0, 1, 0}), {1, 1, 0}));
  EXPECT_TRUE(near(at("Translate 1e6 0 0 Translate 0.001 0 0", {0, 0, 0}), {1000000.001, 0, 0}))
      << "transforms are double";
  EXPECT_TRUE(near(at("TransformBegin Translate 5 5 5 TransformEnd", {1, 0, 0}), {1, 0, 0}));
  const auto persp = at("Perspective 90", {1, 1, 2});
  EXPECT_TRUE(near(persp, {0.5, 0.5, 0.5}));
}

TEST(Transforms, CoordinateSystems) {
  const Read r = readRib(R"(Translate 0 0 5
CoordinateSystem "behind"
WorldBegin
AttributeBegin
Translate 1 0 0
CoordinateSystem "mark"
AttributeEnd
AttributeBegin
Translate 0 7 0
ScopedCoordinateSystem "scoped"
Sphere 1 -1 1 360
AttributeEnd
CoordSysTransform "mark"
Sphere 1 -1 1 360
CoordSysTransform "camera"
Sphere 1 -1 1 360
WorldEnd)");
  expectClean(r);
  const auto& spaces = r.world().coordinateSystems;
  EXPECT_EQ(spaces.at("mark").matrices[0][3][0], 1);
  EXPECT_EQ(spaces.at("camera").matrices[0][3][2], -5);
  EXPECT_EQ(spaces.at("world").matrices[0], Matrix());
  EXPECT_EQ(spaces.at("behind").matrices[0], Matrix()) << "named before the world: the place of the world's origin";
  EXPECT_EQ(r.primitive(0).attributes->coordinateSystems->at("scoped").matrices[0][3][1], 7);
  EXPECT_EQ(r.primitive(1).toWorld.matrices[0][3][0], 1);
  EXPECT_EQ(r.primitive(1).attributes->coordinateSystems, nullptr);
  EXPECT_EQ(r.primitive(2).toWorld.matrices[0][3][2], -5);
}

// Those of a scope have a name for patterns too, the first of that name; those of objects stand in each of its places.
TEST(Transforms, CoordinateSystemsOfScopes) {
  const Read r = readRib(R"(WorldBegin
AttributeBegin
Translate 1 0 0
ScopedCoordinateSystem "a"
AttributeEnd
AttributeBegin
Translate 1 0 0
ScopedCoordinateSystem "a"
Translate 1 0 0
ScopedCoordinateSystem "a"
CoordSysTransform "a"
Sphere 1 -1 1 360
AttributeEnd
ObjectBegin "o"
Translate 0 3 0
CoordinateSystem "b"
ScopedCoordinateSystem "c"
Sphere 1 -1 1 360
ObjectEnd
ObjectInstance "o"
WorldEnd)");
  expectMessage(r, "RIB-COORDSYS", 10);
  const auto& spaces = r.world().coordinateSystems;
  EXPECT_EQ(spaces.at("a").matrices[0][3][0], 1);
  EXPECT_EQ(spaces.count("c"), 0u);
  EXPECT_EQ(r.primitive(0).toWorld.matrices[0][3][0], 2);
  const auto& inside = *r.world().prototypes.at(0).primitives.at(0)->attributes->coordinateSystems;
  EXPECT_EQ(inside.size(), 2u);
  EXPECT_EQ(inside.at("b").matrices[0][3][1], 3);
  EXPECT_EQ(inside.at("c").matrices[0][3][1], 3);
}

TEST(Motion, TransformsCamerasAndGeometry) {
  const Read r = readRib(R"(MotionBegin [0 1]
Translate 0 0 5
Translate 0 0 6
MotionEnd
WorldBegin
AttributeBegin
MotionBegin [0 0.5 1]
Translate 0 0 0
Translate 1 0 0
Translate 5 0 0
MotionEnd
Sphere 1 -1 1 360
AttributeEnd
MotionBegin [0 1]
Polygon "P" [0 0 0 1 0 0 0 1 0]
Polygon "P" [0 0 1 1 0 1 0 1 1]
MotionEnd
MotionBegin [0 1]
Sphere 1 -1 1 360
Sphere 2 -2 2 360
MotionEnd
WorldEnd)");
  expectClean(r);
  EXPECT_EQ(r.world().cameras[0].worldToCamera.times, (std::vector<double>{0, 1}));
  EXPECT_EQ(r.world().cameras[0].worldToCamera.at(0.5)[3][2], 5.5);
  EXPECT_EQ(r.primitive(0).toWorld.at(0.75)[3][0], 3);
  EXPECT_EQ(r.primitive(0).toWorld.at(9)[3][0], 5);
  const Primitive& p = r.primitive(1);
  ASSERT_EQ(p.motion.size(), 1u);
  EXPECT_EQ(p.times, (std::vector<double>{0, 1}));
  EXPECT_EQ(p.motion[0].getFloats("P")[2], 1);
  EXPECT_EQ(r.primitive(2).motion[0].getFloats("__quadric")[0], 2);
}

TEST(Motion, RotationsStayOnTheirArc) {
  for (const char* block :
       {"Rotate 0 0 0 1\nRotate 180 0 0 1", "Rotate 0 0 0 1\nRotate 720 0 0 1",
        "ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]\nConcatTransform [0 1 0 0 -1 0 0 0 0 0 1 0 3 0 0 1]",
        "Rotate 20 1 0 0\nRotate 50 0 1 0"}) {
    const Read r = readWorld(std::string("MotionBegin [0 1]\n") + block + "\nMotionEnd\nSphere 1 -1 1 360");
    EXPECT_TRUE(r.messages.empty()) << r.all();
    const auto& t = r.primitive().toWorld;
    for (double time = 0; time <= 1; time += 0.00731) {
      Imath::V3d d;
      t.at(time).multDirMatrix(Imath::V3d(1, 0, 0), d);
      EXPECT_NEAR(d.length(), 1, 1e-4) << block << " at " << time;
    }
  }
  const Read r = readWorld("MotionBegin [0 1]\nRotate 0 0 0 1\nRotate 720 0 0 1\nMotionEnd\nSphere 1 -1 1 360");
  Imath::V3d d;
  r.primitive().toWorld.at(0.125).multDirMatrix(Imath::V3d(1, 0, 0), d);
  EXPECT_NEAR(d.y, 1, 1e-3) << "two turns are two turns";
}

TEST(Shading, NetworksAreSnapshotsInOrder) {
  const Read r = readWorld(R"(Pattern "PxrManifold2D" "uv" "float scaleS" [2]
Pattern "PxrTexture" "tex" "string filename" ["a.tex"] "reference struct manifold" ["uv:result"]
Pattern "PxrTexture" "unused" "string filename" ["b.tex"]
Pattern "PxrMix" "mix" "reference color color1" ["tex:resultRGB"] "color color2" [1 0 0] "reference float mix" ["tex:resultA"]
AttributeBegin
Bxdf "PxrSurface" "s" "reference color diffuseColor" ["mix:resultRGB"] "float diffuseGain" [0.5]
Displace "PxrDisplace" "d" "reference float dispScalar" ["tex:resultR"]
Sphere 1 -1 1 360
Pattern "PxrMix" "mix" "color color1" [0 0 1]
Sphere 1 -1 1 360
AttributeEnd
Bxdf "PxrSurface" "t" "reference color diffuseColor" ["mix:resultRGB"]
Sphere 1 -1 1 360)");
  expectClean(r);
  const Network& n = *r.primitive(0).attributes->bxdf;
  EXPECT_EQ(n.terminal->plugin, "PxrSurface");
  ASSERT_EQ(n.patterns.size(), 3u);
  EXPECT_EQ(n.patterns[0]->handle, "uv");
  EXPECT_EQ(n.patterns[1]->handle, "tex");
  EXPECT_EQ(n.patterns[2]->handle, "mix");
  const Parameter* input = n.terminal->params.find("diffuseColor");
  EXPECT_TRUE(input->isReference);
  EXPECT_EQ(input->type, ValueType::Color);
  EXPECT_EQ(input->strings[0], "mix:resultRGB");
  EXPECT_EQ(r.primitive(0).attributes->displacement->patterns.size(), 2u);
  EXPECT_EQ(r.primitive(1).attributes->bxdf, r.primitive(0).attributes->bxdf)
      << "a later pattern leaves the snapshot alone";
  ASSERT_EQ(r.primitive(2).attributes->bxdf->patterns.size(), 3u) << "the inner pattern went with its block";
}

TEST(Shading, PatternsMayStandBehindWhatReadsThem) {
  const Read r = readWorld(
      "Displace \"PxrDisplace\" \"d\" \"reference float dispScalar\" [\"p:out\"]\nPattern \"P\" \"p\"\nSphere 1 -1 1 "
      "360");
  expectClean(r);
  EXPECT_EQ(r.primitive().attributes->displacement->patterns.size(), 1u);
}

TEST(Shading, LayeredBxdfsReadBxdfs) {
  const Read r = readWorld(
      "Bxdf \"LamaDiffuse\" \"a\"\nBxdf \"LamaSurface\" \"b\" \"reference bxdf materialFront\" [\"a\"]\nSphere 1 -1 "
      "1 360");
  expectClean(r);
  EXPECT_EQ(r.primitive().attributes->bxdf->patterns.at(0)->plugin, "LamaDiffuse");
}

TEST(Shading, ABxdfMayBeNamedAsThePatternItReads) {
  const Read r = readWorld(
      "Pattern \"P\" \"wood\"\nBxdf \"B\" \"wood\" \"reference color c\" [\"wood:out\"]\nSphere 1 -1 1 360");
  expectClean(r);
  ASSERT_EQ(r.primitive().attributes->bxdf->patterns.size(), 1u);
  EXPECT_EQ(r.primitive().attributes->bxdf->patterns[0]->plugin, "P");
}

// A Bxdf line of nothing but __materialid names a material that another scope bound; with a parameter, another handle
// or an id that nobody bound it is a material of its own.
TEST(Shading, MaterialsAreFoundByTheirId) {
  const Read r = readWorld(R"(AttributeBegin
Pattern "P" "p"
Bxdf "S" "m" "reference color diffuseColor" ["p:result"] "string __materialid" ["SG"]
AttributeEnd
Bxdf "S" "m" "string __materialid" ["SG"]
Sphere 1 -1 1 360
Bxdf "S" "m" "string __materialid" ["other"]
Sphere 1 -1 1 360
Bxdf "S" "n" "string __materialid" ["SG"]
Sphere 1 -1 1 360
Bxdf "S" "m" "float gain" [2] "string __materialid" ["SG"]
Sphere 1 -1 1 360)");
  expectClean(r);
  const auto terminal = [&](size_t i) { return r.primitive(i).attributes->bxdf->terminal; };
  EXPECT_NE(terminal(0)->params.find("diffuseColor"), nullptr);
  EXPECT_EQ(r.primitive(0).attributes->bxdf->patterns.size(), 1u);
  EXPECT_EQ(terminal(1)->params.find("diffuseColor"), nullptr);
  EXPECT_EQ(terminal(2)->params.find("diffuseColor"), nullptr);
  EXPECT_NE(terminal(3)->params.find("gain"), nullptr);
}

TEST(Lights, ModernWithFiltersPatternsAndMesh) {
  const Read r = readWorld(R"(AttributeBegin
Translate 0 5 0
LightFilter "PxrRodLightFilter" "rod" "float width" [2]
Pattern "PxrTexture" "map"
Attribute "grouping" "string membership" ["key"]
Light "PxrRectLight" "rect" "float intensity" [3] "reference color lightColor" ["map:resultRGB"]
AttributeEnd
AttributeBegin
Light "PxrMeshLight" "mesh" "float intensity" [1]
Sphere 1 -1 1 360
AttributeEnd
Sphere 2 -2 2 360)");
  expectClean(r);
  ASSERT_EQ(r.world().lights.size(), 2u);
  const Light& l = r.world().lights[0];
  EXPECT_EQ(l.node->plugin, "PxrRectLight");
  EXPECT_EQ(l.toWorld.matrices[0][3][1], 5);
  ASSERT_EQ(l.filters.size(), 1u);
  ASSERT_EQ(l.filterToWorld.size(), 1u);
  EXPECT_EQ(l.filterToWorld[0].matrices[0][3][1], 5);
  ASSERT_EQ(l.patterns.size(), 1u);
  EXPECT_EQ(l.attributes->named.getString("grouping:membership", ""), "key");
  ASSERT_TRUE(r.world().lights[1].geometry);
  EXPECT_EQ(std::get<Quadric>(r.world().lights[1].geometry->shape).args[0], 1);
  ASSERT_EQ(r.world().primitives.size(), 1u) << "a mesh light's geometry is the light's";
}

TEST(Options, ImagersThatDisplayFiltersStandFor) {
  const Read r = readRib("Imager \"background\" \"color bgcolor\" [.1 .2 .3]\nWorldBegin\nWorldEnd");
  ASSERT_EQ(r.world().displayFilters.size(), 1u);
  const scene::Node& n = *r.world().displayFilters[0];
  EXPECT_EQ(n.plugin, "PxrBackgroundDisplayFilter");
  EXPECT_EQ(n.params.getFloats("backgroundColor"), (std::vector<float>{.1f, .2f, .3f}));
  EXPECT_EQ(n.params.getFloats("backgroundAlpha"), std::vector<float>{1}) << "the imager left alpha 1";
  EXPECT_TRUE(r.messages.empty()) << r.all();
  EXPECT_EQ(r.world().kept.size(), 1u) << "it is written again";
  // one that the scene says itself is the last
  const Read both =
      readRib("DisplayFilter \"PxrBackgroundDisplayFilter\" \"own\"\nImager \"background\"\nWorldBegin\nWorldEnd");
  ASSERT_EQ(both.world().displayFilters.size(), 2u);
  EXPECT_EQ(both.world().displayFilters.back()->handle, "own");
  const auto filterOf = [](const std::string& imager) {
    const Read x = readRib("Imager " + imager + "\nWorldBegin\nWorldEnd");
    EXPECT_TRUE(x.messages.empty()) << x.all();
    EXPECT_EQ(x.world().displayFilters.size(), 1u) << imager;
    return x.world().displayFilters.empty() ? std::make_shared<const scene::Node>() : x.world().displayFilters[0];
  };
  EXPECT_EQ(
      filterOf("\"background\" \"color color\" [1 0 0] \"float alpha\" [0]")->params.getFloats("backgroundAlpha"),
      std::vector<float>{0});
  EXPECT_EQ(filterOf("\"MOSAICbackground\" \"uniform color bgcolor\" [0 1 0]")->params.getFloats("backgroundColor"),
            (std::vector<float>{0, 1, 0}));
  EXPECT_EQ(filterOf("\"clamp\"")->plugin, "ClampDisplayFilter");
  EXPECT_EQ(filterOf("\"clamp\"")->params.getInt("mode", 7), 0);
  EXPECT_EQ(filterOf("\"clamptoalpha\"")->params.getInt("mode", 7), 1);
  const auto gradient = filterOf("\"gradient\" \"uniform color TopColor\" [0 0 1] \"uniform float Sharpness\" [0.5]");
  EXPECT_EQ(gradient->plugin, "GradientDisplayFilter");
  EXPECT_EQ(gradient->params.getFloats("topColor"), (std::vector<float>{0, 0, 1}));
  EXPECT_EQ(gradient->params.getFloats("sharpness"), std::vector<float>{0.5f});
  EXPECT_FALSE(gradient->params.find("bottomColor")) << "the filter has the imager's defaults";
  // of several the last is in force, whether something stands in for it or not
  EXPECT_TRUE(readRib("Imager \"clamp\"\nImager \"fisheye\"\nWorldBegin\nWorldEnd").world().displayFilters.empty());
  // others are named, each once; bad ones do no harm
  const Read others = readRib(
      "Imager \"MOSAICbackground\"\nImager \"fisheye\"\nImager \"fisheye\"\nImager\nImager 3\nImager \"background\" "
      "\"bgcolor\" [1]\nWorldBegin\nWorldEnd");
  EXPECT_EQ(others.count("RIB-KEPT-IMAGER"), 3u) << others.all();
  EXPECT_NE(others.all().find("Imager 'fisheye' is not rendered"), std::string::npos);
  EXPECT_NE(others.all().find("Imager 'MOSAICbackground' is not rendered"), std::string::npos);
  EXPECT_EQ(others.world().displayFilters.size(), 1u);
}

TEST(Lights, ClassicOnesAreKept) {
  const Read r = readWorld(R"(LightSource "pointlight" 1 "from" [1 2 3] "intensity" 4
AreaLightSource "PxrStdAreaLight" "area" "float exposure" [2]
Geometry "rectlight"
Surface "plastic" "Kd" 0.5
Illuminate 1 0
Sphere 1 -1 1 360)");
  ASSERT_EQ(r.world().classicLights.size(), 3u);
  EXPECT_EQ(r.world().classicLights[0].node->kind, "LightSource");
  EXPECT_EQ(r.world().classicLights[0].node->handle, "1");
  EXPECT_EQ(r.world().classicLights[0].node->params.getFloats("from"), (std::vector<float>{1, 2, 3}));
  EXPECT_TRUE(r.world().classicLights[1].geometry);
  EXPECT_TRUE(r.world().lights.empty());
  EXPECT_EQ(r.primitive(1).attributes->classicShaders.at(0)->plugin, "plastic");
  EXPECT_EQ(*r.primitive(0).attributes->lightSources, (std::vector<uint32_t>{r.world().classicLights[0].id}));
  EXPECT_EQ(r.primitive(1).attributes->lightSources, nullptr);
  EXPECT_TRUE(r.messages.empty()) << "a Surface is rendered, a light's shape is that of its stand-in\n" << r.all();
}

// RISpec 4.1.6: the list of light sources is an attribute. Ids are those of Scene::classicLights.
TEST(Lights, LightSourcesFollowTheAttributeStack) {
  const Read r = readWorld(R"(LightSource "pointlight" 1
AttributeBegin
LightSource "pointlight" 2
LightSource "pointlight" "three"
Sphere 1 -1 1 360
Illuminate 1 0
Illuminate "three" "off"
Sphere 1 -1 1 360
AttributeEnd
Sphere 1 -1 1 360
Illuminate 2 1
Illuminate 1 0
Light "PxrDomeLight" "dome"
Illuminate "dome" 0
TransformBegin
Sphere 1 -1 1 360
TransformEnd
Illuminate "dome" 1
Illuminate 2 0
Sphere 1 -1 1 360)");
  ASSERT_EQ(r.world().classicLights.size(), 3u);
  const uint32_t one = r.world().classicLights[0].id, two = r.world().classicLights[1].id,
                 three = r.world().classicLights[2].id;
  const auto list = [&](size_t i) {
    const auto& held = r.primitive(i).attributes->lightSources;
    return held ? *held : std::vector<uint32_t>();
  };
  EXPECT_EQ(list(0), (std::vector<uint32_t>{one, two, three}));
  EXPECT_EQ(list(1), (std::vector<uint32_t>{two}));
  EXPECT_EQ(list(2), (std::vector<uint32_t>{one}));
  EXPECT_EQ(list(3), (std::vector<uint32_t>{two}));
  EXPECT_EQ(r.primitive(3).attributes->named.find("illuminate:off")->strings, (std::vector<std::string>{"dome"}));
  EXPECT_EQ(list(4), (std::vector<uint32_t>{}));
  EXPECT_EQ(r.primitive(4).attributes->named.find("illuminate:off"), nullptr);
  EXPECT_TRUE(r.messages.empty()) << r.all();
}

TEST(Lights, BeforeTheWorldMoveWithTheCamera) {
  const Read r = readRib(R"(FrameBegin 1
Translate 0 0 2
LightSource "pointlight" 1
Light "PxrDomeLight" "dome"
Translate 1 0 0
WorldBegin
Sphere 1 -1 1 360
WorldEnd
FrameEnd
FrameBegin 2
WorldBegin
Sphere 1 -1 1 360
WorldEnd
FrameEnd
)");
  ASSERT_EQ(r.worlds.size(), 2u);
  ASSERT_EQ(r.worlds[0].classicLights.size(), 1u);
  ASSERT_EQ(r.worlds[0].lights.size(), 1u);
  // the light is 2 in front of the camera, which is at (-1, 0, -2)
  EXPECT_EQ(r.worlds[0].classicLights[0].toWorld.matrices[0].translation(), Imath::V3d(-1, 0, 0));
  EXPECT_EQ(r.worlds[0].lights[0].toWorld.matrices[0].translation(), Imath::V3d(-1, 0, 0));
  EXPECT_EQ(*r.worlds[0].primitives[0]->attributes->lightSources,
            (std::vector<uint32_t>{r.worlds[0].classicLights[0].id}));
  EXPECT_TRUE(r.worlds[1].classicLights.empty()) << "the frame's end forgets them";
  EXPECT_EQ(r.worlds[1].primitives[0]->attributes->lightSources, nullptr);
}

TEST(Options, CameraParametersAndEmptyWindows) {
  const Read r = readRib(R"(Clipping 1 2
CropWindow .5 .5 0 1
Camera "a" "int apertureNSides" [6] "float nearClip" [0.5] "float farClip" [100]
Camera "b" "float nearClip" [5] "float farClip" [1]
WorldBegin
Sphere 1 -1 1 360
WorldEnd
)");
  ASSERT_EQ(r.world().cameras.size(), 2u);
  EXPECT_EQ(r.world().cameras[0].clipping, (std::array<float, 2>{0.5f, 100}));
  EXPECT_EQ(r.world().cameras[1].clipping, (std::array<float, 2>{1, 2})) << "nonsense leaves Clipping";
  EXPECT_EQ(r.world().cropWindow, (std::array<float, 4>{0.5f, 0.5f, 0, 1})) << "the renderer refuses it";
  EXPECT_TRUE(r.messages.empty()) << r.all();
}

TEST(Geometry, EveryRequest) {
  const Read r = readWorld(R"(Sphere 1 -0.5 0.5 180 "Cs" [1 0 0 0 1 0 0 0 1 1 1 1]
Cone 2 1 360
Cylinder 1 0 2 360
Hyperboloid [1 0 0] [1 1 1] 360
Paraboloid 1 0 2 360
Disk 0 [1] 360
Torus 2 0.5 0 360 360
Polygon "P" [0 0 0 1 0 0 1 1 0] "N" [0 0 1 0 0 1 0 0 1]
GeneralPolygon [3 3] "P" [0 0 0 9 0 0 0 9 0 1 1 0 2 1 0 1 2 0]
PointsPolygons [3 3] [0 1 2 2 1 3] "P" [0 0 0 1 0 0 0 1 0 1 1 0] "uniform float u" [1 2] "facevarying float[2] st" [0 0 0 0 0 0 0 0 0 0 0 0]
PointsGeneralPolygons [2] [3 3] [0 1 2 3 4 5] "P" [0 0 0 9 0 0 0 9 0 1 1 0 2 1 0 1 2 0]
Patch "bilinear" "P" [0 0 0 1 0 0 0 1 0 1 1 0]
PatchMesh "bicubic" 7 "nonperiodic" 4 "nonperiodic" "Pz" [0 0 0 0 0 0 0 1 1 1 1 1 1 1 2 2 2 2 2 2 2 3 3 3 3 3 3 3] "varying float t" [1 2 3 4 5 6]
NuPatch 4 4 [0 0 0 0 1 1 1 1] 0 1 2 2 [0 0 1 1] 0 1 "Pw" [0 0 0 1 0 0 0 1 0 0 0 1 0 0 0 1 0 0 0 1 0 0 0 1 0 0 0 1 0 0 0 1]
SubdivisionMesh "catmull-clark" [4] [0 1 2 3] ["interpolateboundary" "crease"] [0 0 2 1] [0 1] [3.5] "P" [0 0 0 1 0 0 1 1 0 0 1 0]
SubdivisionMesh "loop" [3] [0 1 2] "P" [0 0 0 1 0 0 1 1 0]
HierarchicalSubdivisionMesh "catmull-clark" [4] [0 1 2 3] ["creasemethod"] [0 0 1] [] [] ["chaikin"] "P" [0 0 0 1 0 0 1 1 0 0 1 0]
Curves "cubic" [4 7] "nonperiodic" "P" [0 0 0 1 0 0 2 0 0 3 0 0 0 0 0 1 0 0 2 0 0 3 0 0 4 0 0 5 0 0 6 0 0] "varying float width" [1 2 3 4 5]
Points "P" [0 0 0 1 1 1] "constantwidth" [0.1]
)");
  expectClean(r);
  ASSERT_EQ(r.world().primitives.size(), 19u);
  EXPECT_EQ(std::get<Quadric>(r.primitive(0).shape).args[3], 180);
  EXPECT_EQ(r.primitive(0).primvars.find("Cs")->storage, StorageClass::Varying);
  EXPECT_EQ(std::get<Quadric>(r.primitive(3).shape).args[6], 360);
  EXPECT_EQ(std::get<PolygonMesh>(r.primitive(7).shape).verticesPerLoop, (std::vector<int>{3}));
  EXPECT_EQ(std::get<PolygonMesh>(r.primitive(8).shape).loopsPerFace, (std::vector<int>{2}));
  EXPECT_EQ(std::get<PolygonMesh>(r.primitive(9).shape).vertices.size(), 6u);
  EXPECT_TRUE(std::get<PolygonMesh>(r.primitive(9).shape).loopsPerFace.empty());
  EXPECT_EQ(r.primitive(9).primvars.find("st")->arrayLength, 2);
  EXPECT_EQ(std::get<PolygonMesh>(r.primitive(10).shape).verticesPerLoop.size(), 2u);
  EXPECT_EQ(std::get<PatchMesh>(r.primitive(12).shape).nu, 7);
  const auto heights = r.primitive(12).primvars.getFloats("P");
  ASSERT_EQ(heights.size(), 84u);
  EXPECT_EQ(heights[3 * 27], 1);
  EXPECT_EQ(heights[3 * 27 + 1], 1);
  EXPECT_EQ(heights[3 * 27 + 2], 3);
  EXPECT_EQ(std::get<NuPatch>(r.primitive(13).shape).uKnots.size(), 8u);
  const auto& tags = std::get<SubdivisionMesh>(r.primitive(14).shape).tags;
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_EQ(tags[1].name, "crease");
  EXPECT_EQ(tags[1].ints, (std::vector<int>{0, 1}));
  EXPECT_EQ(tags[1].floats, (std::vector<float>{3.5f}));
  EXPECT_EQ(std::get<SubdivisionMesh>(r.primitive(16).shape).tags[0].strings[0], "chaikin");
  EXPECT_TRUE(std::get<scene::Curves>(r.primitive(17).shape).cubic);
  EXPECT_EQ(std::get<Points>(r.primitive(18).shape).count, 2);
  EXPECT_EQ(r.primitive(18).pos.line, 20u);
}

TEST(Geometry, HierarchicalMeshesKeepTheirTags) {
  const Read r = readWorld(
      R"(HierarchicalSubdivisionMesh "catmull-clark" [4 4] [0 1 2 3 1 4 5 2] ["crease" "corner" "hole" "vertexedit" "interpolateboundary"]
[3 1 0 1 1 0 1 0 0 2 3 2 1 0 0] [1 2 5 0 1 1 2 1] [2.5 3 1 2 3] ["P" "add"]
"P" [0 0 0 1 0 0 1 1 0 0 1 0 2 0 0 2 1 0] "constant string primtype" ["mesh"] "facevarying float s" [0 1 1 0 0 1 1 0])");
  expectClean(r);
  const auto& tags = std::get<SubdivisionMesh>(r.primitive().shape).tags;
  ASSERT_EQ(tags.size(), 5u);
  EXPECT_EQ(tags[0].ints, (std::vector<int>{1, 2, 5}));
  EXPECT_EQ(tags[0].floats, (std::vector<float>{2.5f}));
  EXPECT_EQ(tags[1].ints, (std::vector<int>{0}));
  EXPECT_EQ(tags[1].floats, (std::vector<float>{3}));
  EXPECT_EQ(tags[2].ints, (std::vector<int>{1}));
  EXPECT_EQ(tags[3].floats, (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(tags[3].strings, (std::vector<std::string>{"P", "add"}));
  EXPECT_EQ(tags[4].ints, (std::vector<int>{1}));
}

TEST(Geometry, TrimCurvesGoWithNuPatches) {
  const Read r = readWorld(R"(TrimCurve [1] [2] [0 0 1 1] [0] [1] [2] [0 1] [0 1] [1 1]
NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 "P" [0 0 0 1 0 0 0 1 0 1 1 0])");
  expectClean(r);
  EXPECT_EQ(std::get<NuPatch>(r.primitive().shape).trim.find("order")->ints, (std::vector<int>{2}));
}

TEST(Geometry, TrimCurvesThatDoNotFitLeaveTheOnesBefore) {
  const std::string good = "TrimCurve [1] [2] [0 0 1 1] [0] [1] [2] [0 1] [0 1] [1 1]\n";
  const std::string patch = "NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]\n";
  for (const char* bad :
       {"TrimCurve [2] [2] [0 0 1 1] [0] [1] [2] [0 1] [0 1] [1 1]",
        "TrimCurve [1] [2] [0 0 1] [0] [1] [2] [0 1] [0 1] [1 1]",
        "TrimCurve [1] [2] [0 0 1 1] [0] [1] [2000000000] [0 1] [0 1] [1 1]",
        "TrimCurve [1] [900] [0 0 1 1] [0] [1] [2] [0 1] [0 1] [1 1]",
        "TrimCurve [1] [2] [0 0 1 1] [0] [1] [2] [0 nan] [0 1] [1 1]", "TrimCurve [1] [2]", "TrimCurve \"x\" 1"}) {
    const Read r = readWorld(good + bad + "\n" + patch);
    ASSERT_EQ(r.world().primitives.size(), 1u) << bad << r.all();
    EXPECT_FALSE(r.messages.empty()) << bad;
    EXPECT_EQ(std::get<NuPatch>(r.primitive().shape).trim.find("n")->ints, (std::vector<int>{2})) << bad;
  }
}

TEST(Geometry, WhatIsNotRenderedIsKeptWithItsArguments) {
  const Read r = readWorld(R"(Blobby 1 [1001 0] [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] [""]
Volume "box" [-1 1 -1 1 -1 1] [2 2 2] "varying float density" [1 1 1 1 1 1 1 1]
Geometry "envsphere" "constant float[2] resolution" [64 32]
Procedural "DynamicLoad" ["x.so" "arg"] [-1 1 -1 1 -1 1]
Procedural2 "DynamicLoad2" "SimpleBound" "string dsoname" ["x.so"] "float[6] bound" [0 1 0 1 0 1])");
  ASSERT_EQ(r.world().primitives.size(), 5u) << r.all();
  const auto& o = [&](size_t i) -> const OtherPrimitive& { return std::get<OtherPrimitive>(r.primitive(i).shape); };
  EXPECT_EQ(o(0).args.getFloats("floats").size(), 16u);
  EXPECT_EQ(o(1).args.getString("type", ""), "box");
  EXPECT_EQ(r.primitive(1).primvars.getFloats("density").size(), 8u);
  EXPECT_EQ(r.primitive(2).primvars.getFloats("resolution").size(), 2u);
  EXPECT_EQ(o(3).args.find("data")->strings[0], "x.so");
  EXPECT_EQ(r.primitive(4).primvars.getString("dsoname", ""), "x.so");
  for (const char* code : {"RIB-KEPT-PROCEDURAL", "RIB-KEPT-PROCEDURAL2"}) EXPECT_EQ(r.count(code), 1u) << code;
  EXPECT_EQ(r.count("RIB-KEPT-VOLUME"), 0u);
  EXPECT_EQ(r.count("RIB-KEPT-GEOMETRY"), 0u) << "told once, by who knows the names of shapes";
}

TEST(Objects, BeginWithoutAttributes) {
  const Read r = readWorld(R"(Attribute "user" "string pass" ["a"]
Attribute "grouping" "string membership" ["outside"]
Color 1 0 0
Sides 1
Basis "b-spline" 1 "b-spline" 1
Bxdf "PxrDiffuse" "outer"
ObjectBegin "o"
IfBegin "$user:pass == 'a'"
Sphere 1 -1 1 360
IfEnd
Attribute "grouping" "string membership" ["+mine"]
Sides 2
Sphere 1 -1 1 360
ObjectEnd
Attribute "grouping" "string membership" ["placed"]
ObjectInstance "o")");
  expectClean(r);
  const Scene& s = r.world();
  ASSERT_EQ(s.prototypes[0].primitives.size(), 2u);  // conditions inside still know what stands around them
  const Attributes& first = *s.prototypes[0].primitives[0]->attributes;
  EXPECT_TRUE(first.named.empty());
  EXPECT_FALSE(first.color || first.bxdf || first.says(Attributes::kSides));
  EXPECT_EQ(first.vStep, 1);  // bases belong to the points
  const AttributesPtr& given = s.instances[0].attributes;
  EXPECT_EQ(given->sides, 1);
  EXPECT_EQ(inherit(s.prototypes[0].primitives[0]->attributes, given), given);  // nothing of its own: no copy
  const AttributesPtr second = inherit(s.prototypes[0].primitives[1]->attributes, given);
  EXPECT_EQ(second->sides, 2);
  EXPECT_EQ(second->named.getString("grouping:membership", ""), "placed mine");
  EXPECT_EQ(second->named.getString("user:pass", ""), "a");
  EXPECT_TRUE(second->color && second->bxdf);
}

TEST(Options, SlipsInKnownNamesAreTold) {
  const auto what = [](const std::string& before, const std::string& inside) {
    const Read r = readRib(before + "\nWorldBegin\n" + inside + "\nSphere 1 -1 1 360\nWorldEnd\n");
    const Message* m = r.find("RIB-MISSPELT");
    EXPECT_LE(r.count("RIB-MISSPELT"), 1u) << r.all();
    return m ? m->what + " / " + m->advice : std::string();
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  for (const char* name : {"camra", "camerra", "camrea", "camerq", "Camera"}) {
    const std::string said = what("", std::string("Attribute \"visibility\" \"int ") + name + "\" [0]");
    EXPECT_TRUE(has(said, (std::string("visibility:") + name).c_str()) && has(said, "did you mean \"camera\""))
        << said;
  }
  EXPECT_TRUE(has(what("", "Attribute \"visiblity\" \"int camera\" [0]"), "did you mean \"visibility\""));
  EXPECT_TRUE(has(what("Option \"limits\" \"int threds\" [2]", ""), "did you mean \"threads\""));
  EXPECT_TRUE(has(what("Option \"limit\" \"int threads\" [2]", ""), "did you mean \"limits\""));
  EXPECT_TRUE(has(what("Hider \"raytrace\" \"int maxsample\" [2]", ""), "did you mean \"maxsamples\""));
  EXPECT_TRUE(has(what("", "Attribute \"trace\" \"string holdout\" [\"1\"]"), "is a number"));
  EXPECT_TRUE(has(what("", "Attribute \"lighting\" \"int subset\" [1]"), "is a string"));
  // other words, and one's own, are nobody's mistake
  for (const char* said : {"\"user\" \"int camra\" [0]", "\"visibility\" \"int photon\" [0]",
                           "\"visibility\" \"string transmission\" [\"Os\"]", "\"cull\" \"int hidden\" [0]",
                           "\"dice\" \"int hair\" [1]", "\"identifier\" \"string shadinggroup\" [\"a\"]",
                           "\"Ri\" \"int Sides\" [1]", "\"shade\" \"float minsamples\" [2]"})
    EXPECT_EQ(what("", std::string("Attribute ") + said), "");
  EXPECT_EQ(what("Option \"limits\" \"int ptexturememory\" [9] \"color zthreshold\" [1 1 1]\nHider \"hidden\" \"int "
                 "maxsample\" [2]",
                 ""),
            "");
}

TEST(Objects, AreShapesOfMeshLightsAndTakeNoValues) {
  const Read r = readWorld(R"(ObjectBegin "leaf"
Translate 0 1 0
Sphere 1 -1 1 360
ObjectEnd
AttributeBegin
Light "PxrMeshLight" "l"
ObjectInstance "leaf"
AttributeEnd
AreaLightSource "PxrStdAreaLight" "a"
ObjectInstance "leaf" "constant color tint" [1 0 0])");
  expectMessage(r, "RIB-INSTANCE-VALUES", 11);
  expectMessage(r, "CLASSIC-LIGHT-OUT", 11);
  const Scene& s = r.world();
  ASSERT_EQ(s.prototypes.size(), 2u);
  EXPECT_EQ(s.prototypes[0].primitives.size(), 1u);
  EXPECT_TRUE(s.prototypes[1].primitives.empty());
  ASSERT_EQ(s.prototypes[1].lights.size(), 1u);
  EXPECT_EQ(s.prototypes[1].lights[0].toWorld.matrices[0][3][1], 1);
  EXPECT_TRUE(s.prototypes[1].lights[0].geometry);
  ASSERT_EQ(s.instances.size(), 2u);
  EXPECT_EQ(s.instances[0].prototype, 1u);
  EXPECT_EQ(s.instances[1].prototype, 0u) << "a shape of an old light is rendered as ever";
}

TEST(Objects, FaceSetsKeepTheirFaces) {
  const std::string polygons =
      "PointsPolygons [4 3 4] [0 1 2 3 3 2 4 3 4 5 0] \"P\" [-1 -1 0 -1 1 0 0 1 0 0 -1 0 1 1 0 1 -1 0] "
      "\"uniform float u\" [1 2 3] \"facevarying float f\" [0 1 2 3 4 5 6 7 8 9 10] \"vertex float v\" [0 1 2 3 4 5] "
      "\"uniform string s\" [\"a\" \"b\" \"c\"]\n";
  const Read r =
      readWorld("AttributeBegin Attribute \"shade\" \"int[2] faceset\" [2 0]\n" + polygons +
                "SubdivisionMesh \"catmull-clark\" [4 4] [0 1 2 3 3 2 4 5] \"P\" [-1 -1 0 -1 1 0 0 1 0 0 "
                "-1 0 1 1 0 1 -1 0] \"constant int[1] shade:faceset\" [1]\nSphere 1 -1 1 360\nAttributeEnd\n"
                "Attribute \"shade\" \"int[1] faceset\" [7]\n" +
                polygons);
  ASSERT_EQ(r.world().primitives.size(), 3u) << "a mesh of none of its faces is left out";
  expectMessage(r, "RIB-INDEX", 8);
  const auto& m = std::get<PolygonMesh>(r.primitive(0).shape);
  EXPECT_EQ(m.loopsPerFace.size(), 0u);
  EXPECT_EQ(m.verticesPerLoop, (std::vector<int>{4, 4}));
  EXPECT_EQ(m.vertices, (std::vector<int>{0, 1, 2, 3, 3, 4, 5, 0}));
  const auto& values = r.primitive(0).primvars;
  EXPECT_EQ(values.find("u")->floats, (std::vector<float>{1, 3}));
  EXPECT_EQ(values.find("f")->floats, (std::vector<float>{0, 1, 2, 3, 7, 8, 9, 10}));
  EXPECT_EQ(values.find("v")->floats.size(), 6u);
  EXPECT_EQ(values.find("s")->strings, (std::vector<std::string>{"a", "c"}));
  const auto& s = std::get<SubdivisionMesh>(r.primitive(1).shape);
  ASSERT_EQ(s.tags.size(), 1u);
  EXPECT_EQ(s.tags[0].name, "hole");
  EXPECT_EQ(s.tags[0].ints, (std::vector<int>{0}));
}

TEST(Objects, NormalsOfFacesAreNormals) {
  const Read r = readWorld(
      "Polygon \"P\" [0 0 0 1 0 0 0 1 0] \"Np\" [0 1 0]\nPolygon \"P\" [0 0 0 1 0 0 0 1 0] \"Np\" [0 1 0] "
      "\"N\" [1 0 0 1 0 0 1 0 0]");
  expectClean(r);
  const Parameter* n = r.primitive(0).primvars.find("N");
  ASSERT_TRUE(n);
  EXPECT_EQ(n->storage, StorageClass::Uniform);
  EXPECT_EQ(r.primitive(1).primvars.find("N")->floats[0], 1);
}

TEST(Objects, PrototypesInstancesAndNesting) {
  const Read r = readWorld(R"(ObjectBegin "leaf"
Translate 0 1 0
Sphere 1 -1 1 360
ObjectEnd
ObjectBegin 2
ObjectInstance "leaf"
Translate 3 0 0
ObjectInstance "leaf"
ObjectEnd
Translate 10 0 0
Attribute "user" "int k" [5]
ObjectInstance 2
ObjectInstance 2.0)");
  expectClean(r);
  const Scene& s = r.world();
  ASSERT_EQ(s.prototypes.size(), 2u);
  EXPECT_EQ(s.prototypes[0].name, "leaf");
  EXPECT_EQ(s.prototypes[0].primitives[0]->toWorld.matrices[0][3][1], 1);
  ASSERT_EQ(s.prototypes[1].instances.size(), 2u);
  EXPECT_EQ(s.prototypes[1].instances[1].prototype, 0u);
  EXPECT_EQ(s.prototypes[1].instances[1].toWorld.matrices[0][3][0], 3);
  ASSERT_EQ(s.instances.size(), 2u);
  EXPECT_EQ(s.instances[0].prototype, 1u);
  EXPECT_EQ(s.instances[0].toWorld.matrices[0][3][0], 10);
  EXPECT_EQ(s.instances[0].attributes->getInt("user:k", 0), 5);
  EXPECT_TRUE(s.primitives.empty());
  std::set<uint32_t> ids{s.prototypes[0].primitives[0]->id, s.instances[0].id, s.instances[1].id};
  EXPECT_EQ(ids.size(), 3u);
  EXPECT_GT(s.nextId, *ids.rbegin());
}

TEST(Archives, InlineOnesAreReplayedAndSubstituted) {
  const Read r = readWorld(R"(ArchiveBegin "ball"
ArchiveBegin "inner"
Sphere 1 -1 1 360
ArchiveEnd
Attribute "identifier" "string name" ["${user:who}"]
ReadArchive "inner"
ArchiveEnd
Attribute "user" "string who" ["ann"]
ReadArchive "ball"
Attribute "user" "string who" ["bob"]
ReadArchive "ball")");
  expectClean(r);
  ASSERT_EQ(r.world().primitives.size(), 2u);
  EXPECT_EQ(r.primitive(0).name(), "ann");
  EXPECT_EQ(r.primitive(1).name(), "bob");
}

TEST(Archives, DelayedOnesAreReadInAScopeOfTheirOwn) {
  const Read r = readWorld(
      "ArchiveBegin \"a\"\nColor 1 0 0\nTranslate 1 0 0\nSphere 1 -1 1 360\nArchiveEnd\n"
      "Procedural \"DelayedReadArchive\" [\"a\"] [0 1 0 1 0 1]\n"
      "Procedural2 \"DelayedReadArchive2\" \"SimpleBound\" \"string filename\" [\"a\"] \"float[6] bound\" [0 1 0 1 0 "
      "1]\n"
      "Sphere 2 -2 2 360");
  expectClean(r);
  ASSERT_EQ(r.world().primitives.size(), 3u);
  EXPECT_EQ(r.primitive(1).toWorld.matrices[0][3][0], 1);
  EXPECT_FALSE(r.primitive(2).attributes->color);
  EXPECT_EQ(r.primitive(2).toWorld.matrices[0], Matrix());
}

TEST(Programs, AreRunWhereThatIsAllowed) {
  const std::string file = ::testing::TempDir() + "made_by_the_program";
  std::filesystem::remove(file);
  const std::string touch =
      "Procedural \"RunProgram\" [\"touch " + file + "\" \"\"] [0 1 0 1 0 1]\nSphere 2 -2 2 360";
  const Read without = readWorld(touch);
  expectMessage(without, "RIB-KEPT-PROGRAM", 2);
  EXPECT_EQ(without.world().primitives.size(), 2u) << "it is kept, for whoever writes the scene again";
  EXPECT_FALSE(std::filesystem::exists(file)) << "it was run all the same";
  ReadOptions allowed;
  allowed.allowExec = true;
  readWorld(touch, allowed);
  EXPECT_TRUE(std::filesystem::exists(file));
  std::filesystem::remove(file);

  // detail and data come to it, and after a byte 255 it is waited for no longer
  const std::string script = ::testing::TempDir() + "disk_maker";
  std::ofstream(script)
      << "#!/bin/sh\nread detail radius\necho Color 0 0 1\necho Disk 0 $radius 360\nprintf '\\377'\nsleep 1000\n";
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  const Read r = readWorld(
      "Color 1 0 0\nProcedural \"RunProgram\" [\"" + script + "\" \"2\"] [0 1 0 1 0 1]\nSphere 2 -2 2 360", allowed);
  ASSERT_EQ(r.world().primitives.size(), 2u) << r.all();
  const auto& disk = std::get<Quadric>(r.primitive(0).shape);
  EXPECT_EQ(disk.kind, Quadric::Kind::Disk);
  EXPECT_EQ(disk.args[1], 2);
  EXPECT_EQ((*r.primitive(1).attributes->color)[0], 1) << "attributes are as they were";
}

TEST(Programs, ThatFailAreLeftOut) {
  ReadOptions allowed;
  allowed.allowExec = true;
  allowed.programSeconds = .5;
  for (const char* command : {"/nowhere/at/all", "false", "sleep 1000", "   ", "", "yes"}) {
    const auto start = std::chrono::steady_clock::now();
    const Read r = readWorld(
        "Procedural \"RunProgram\" [\"" + std::string(command) + "\" \"x\"] [0 1 0 1 0 1]\nSphere 2 -2 2 360",
        allowed);
    EXPECT_EQ(r.count("RIB-PROGRAM"), 1u) << command << "\n" << r.all();
    EXPECT_EQ(r.world().primitives.size(), 1u) << command;
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20) << command;
  }
  // garbage is what garbage in a file is; one that answers with itself is run once
  const Read garbage =
      readWorld("Procedural \"RunProgram\" [\"echo )(]\" \"x\"] [0 1 0 1 0 1]\nSphere 2 -2 2 360", allowed);
  EXPECT_FALSE(garbage.messages.empty());
  EXPECT_EQ(garbage.world().primitives.size(), 1u);
  allowed.programSeconds = 20;
  const std::string again =
      "Procedural \"RunProgram\" [\"cat " + ::testing::TempDir() + "again.rib\" \"x\"] [0 1 0 1 0 1]\n";
  std::ofstream(::testing::TempDir() + "again.rib") << again;
  const Read recursive = readWorld(again + "Sphere 2 -2 2 360", allowed);
  EXPECT_EQ(recursive.count("RIB-RECURSION"), 1u) << recursive.all();
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

TEST(Options, ClippingPlaneIsKeptInCameraSpace) {
  const Read r = readRib("Translate 0 0 5\nRotate 90 0 1 0\nClippingPlane 1 2 0  0 0 2\nWorldBegin\nWorldEnd");
  expectClean(r);
  ASSERT_EQ(r.world().cameras[0].clippingPlanes.size(), 1u);
  const std::array<double, 6> p = r.world().cameras[0].clippingPlanes[0];
  // left-handed: +z turns to +x, +x to -z
  const double expected[6] = {0, 2, 4, 2, 0, 0};
  for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(p[i], expected[i], 1e-12) << i;
  EXPECT_EQ(readRib("ClippingPlane 1 2 0  0 0 0\nWorldBegin\nWorldEnd").messages.size(), 1u);
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

TEST(Requests, SolidsKeepAttributesAndTransformsToThemselves) {
  const Read r = readWorld(R"(SolidBegin "union"
Translate 0 1 0
SolidBegin "primitive"
Translate 1 0 0
Color [1 0 0]
Sphere 1 -1 1 360
SolidEnd
Sphere 2 -2 2 360
SolidEnd
Sphere 3 -3 3 360)");
  expectClean(r);
  const double wanted[3][2] = {{1, 1}, {0, 1}, {0, 0}};
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(r.primitive(i).toWorld.matrices[0][3][0], wanted[i][0]) << i;
    EXPECT_EQ(r.primitive(i).toWorld.matrices[0][3][1], wanted[i][1]) << i;
    EXPECT_EQ(r.primitive(i).attributes->color.has_value(), i == 0) << i;
  }
}

TEST(Requests, SolidsAreTrees) {
  const Read r = readWorld(R"(SolidBegin "difference"
SolidBegin "primitive"
Cylinder 1 -1 1 360
Disk 1 1 360
SolidEnd
AttributeBegin
SolidBegin "union"
Sphere 1 -1 1 360
Sphere 2 -2 2 360
SolidEnd
AttributeEnd
SolidEnd
ObjectBegin "o"
Sphere 3 -3 3 360
SolidBegin "intersection"
SolidBegin "primitive"
Sphere 4 -4 4 360
SolidEnd
SolidEnd
ObjectEnd
SolidBegin "primitive"
ObjectInstance "o"
SolidEnd
Sphere 5 -5 5 360
)");
  expectClean(r);
  using O = scene::Solid::Operation;
  const auto expectSolids = [](const std::vector<scene::Solid>& got,
                               const std::vector<std::pair<O, uint32_t>>& wanted) {
    ASSERT_EQ(got.size(), wanted.size());
    for (size_t i = 0; i < got.size(); ++i) {
      EXPECT_EQ(got[i].operation, wanted[i].first) << i;
      EXPECT_EQ(got[i].parent, wanted[i].second) << i;
    }
  };
  expectSolids(r.world().solids, {{O::Difference, 0},
                                  {O::Primitive, 1},
                                  {O::Union, 1},
                                  {O::Primitive, 3},
                                  {O::Primitive, 3},
                                  {O::Primitive, 0}});
  expectSolids(r.world().prototypes[0].solids, {{O::Intersection, 0}, {O::Primitive, 1}});
  const std::vector<uint32_t> wanted{2, 2, 4, 5, 0};
  ASSERT_EQ(r.world().primitives.size(), wanted.size());
  for (size_t i = 0; i < wanted.size(); ++i) EXPECT_EQ(r.primitive(i).solid, wanted[i]) << i;
  EXPECT_EQ(r.world().prototypes[0].primitives[0]->solid, 0u);
  EXPECT_EQ(r.world().prototypes[0].primitives[1]->solid, 2u);
  EXPECT_EQ(r.world().instances[0].solid, 6u);
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

TEST(Declarations, BareRowsOfNumbersAreOneValue) {
  const Read r =
      readWorld("Bxdf \"PxrDiffuse\" \"d\" \"color diffuseColor\" 1 0.5 0 \"float x\" 2\nSphere 1 -1 1 360");
  expectClean(r);
  EXPECT_EQ(r.primitive().attributes->bxdf->terminal->params.getFloats("diffuseColor"),
            (std::vector<float>{1, 0.5f, 0}));
}

}  // namespace
}  // namespace kinora::rib
