// Each mistake a file can make: one message with its code, file and line, what was done, and a scene that goes on.
// Proves that reading survives; that the exit code follows is app's business.
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "rib/test_support.h"

namespace kinora::rib {
namespace {

using namespace scene;

struct BadRequest {
  const char* name;
  const char* text;  // inside a world, from line 2
  const char* code;
  uint32_t line;
  size_t primitives;  // that are left besides the last one, which every case must keep
};
class BadRequests : public testing::TestWithParam<BadRequest> {};

TEST_P(BadRequests, OneMessageAndADefinedRepair) {
  const BadRequest& c = GetParam();
  const Read r = readWorld(std::string(c.text) + "\nSphere 7 -7 7 360");
  expectMessage(r, c.code, c.line);
  EXPECT_EQ(r.messages.size(), 1u) << r.all();
  ASSERT_EQ(r.world().primitives.size(), c.primitives + 1);
  EXPECT_EQ(std::get<Quadric>(r.world().primitives.back()->shape).args[0], 7);
  Explanations explain;
  explain.add(explanations());
  ASSERT_TRUE(explain.find(c.code));
  EXPECT_GT(explain.find(c.code)->text.size(), 60u);
}

INSTANTIATE_TEST_SUITE_P(
    All, BadRequests,
    testing::Values(
        BadRequest{"UnknownRequest", "Fnord 1 \"x\" [1 2]", "RIB-UNKNOWN-REQUEST", 2, 0},
        BadRequest{"WrongCase", "\nsphere 1 -1 1 360", "RIB-UNKNOWN-REQUEST", 3, 0},
        BadRequest{"TooFewArguments", "Sphere 1 -1 1", "RIB-ARGUMENTS", 2, 0},
        BadRequest{"ColorOfStrings", "Color \"red\"", "RIB-ARGUMENTS", 2, 0},
        BadRequest{"NotANumber", "Color nan 0 0", "RIB-NUMBER", 2, 0},
        BadRequest{"TooLargeANumber", "Color 1e999 0 0", "RIB-NUMBER", 2, 0},
        BadRequest{"QuadricNotFinite", "Sphere nan -1 1 360", "RIB-SHAPE", 2, 0},
        BadRequest{"SidesThree", "Sides 3", "RIB-ARGUMENTS", 2, 0},
        BadRequest{"PrimvarTooShort", "Polygon \"P\" [0 0 0 1 0 0 0 1 0] \"N\" [0 0 1 0 0 1]", "RIB-PRIMVAR-COUNT", 2,
                   1},
        BadRequest{"PrimvarTooLong", "Polygon \"P\" [0 0 0 1 0 0 0 1 0] \"varying float s\" [1 2 3 4]",
                   "RIB-PRIMVAR-COUNT", 2, 1},
        BadRequest{"PrimvarOne", "Polygon \"P\" [0 0 0 1 0 0 0 1 0] \"Cs\" [1 0 0]", "RIB-PRIMVAR-ONE", 2, 1},
        BadRequest{"PrimvarNotWhole", "Polygon \"P\" [0 0 0 1 0 0 0 1 0] \"N\" [0 0 1 0]", "RIB-ARRAY-LENGTH", 2, 1},
        BadRequest{"PrimvarOfStrings", "Polygon \"P\" [0 0 0 1 0 0 0 1 0] \"s\" [\"a\" \"b\" \"c\"]", "RIB-TYPE", 2,
                   1},
        BadRequest{"PrimvarUndeclared", "Sphere 1 -1 1 360 \"foo\" [1 2 3 4]", "RIB-UNDECLARED", 2, 1},
        BadRequest{"PrimvarBadDeclaration", "Sphere 1 -1 1 360 \"varying flat foo\" [1 2 3 4]", "RIB-DECLARATION", 2,
                   1},
        BadRequest{"PrimvarNotFinite", "Sphere 1 -1 1 360 \"s\" [nan 1e999 3 4]", "RIB-NUMBER", 2, 1},
        BadRequest{"ArrayLengthHuge", "Sphere 1 -1 1 360 \"constant float[999999999999] foo\" [1]", "RIB-DECLARATION",
                   2, 1},
        BadRequest{"ArrayLengthNegative", "Sphere 1 -1 1 360 \"constant float[-1] foo\" [1]", "RIB-DECLARATION", 2,
                   1},
        BadRequest{"ParameterWithoutValue", "Sphere 1 -1 1 360 \"Cs\"", "RIB-PARAMETER", 2, 1},
        BadRequest{"ParameterWithoutName", "Sphere 1 -1 1 360 [1 2 3]", "RIB-PARAMETER", 2, 1},
        BadRequest{"IndexTooLarge", "\nPointsPolygons [3] [0 1 3] \"P\" [0 0 0 1 0 0 0 1 0]", "RIB-INDEX", 3, 0},
        BadRequest{"IndexNegative", "PointsPolygons [3] [0 -1 2] \"P\" [0 0 0 1 0 0 0 1 0]", "RIB-INDEX", 2, 0},
        BadRequest{"IndexFraction", "PointsPolygons [3] [0 1.5 2] \"P\" [0 0 0 1 0 0 0 1 0]", "RIB-ARGUMENTS", 2, 0},
        BadRequest{"CountNegative", "PointsPolygons [-3] [0 1 2] \"P\" [0 0 0 1 0 0 0 1 0]", "RIB-SHAPE", 2, 0},
        BadRequest{"CountHuge", "PointsPolygons [2147483647 2147483647 2147483647] [0 1 2] \"P\" [0 0 0 1 0 0 0 1 0]",
                   "RIB-SHAPE", 2, 0},
        BadRequest{"CountTwo", "PointsPolygons [2] [0 1] \"P\" [0 0 0 1 0 0 0 1 0]", "RIB-SHAPE", 2, 0},
        BadRequest{"CountsAndIndices", "PointsPolygons [3 3] [0 1 2] \"P\" [0 0 0 1 0 0 0 1 0]", "RIB-SHAPE", 2, 0},
        BadRequest{"LoopsAndCounts", "PointsGeneralPolygons [2 1] [3] [0 1 2] \"P\" [0 0 0 1 0 0 0 1 0]", "RIB-SHAPE",
                   2, 0},
        BadRequest{"SubdivisionIndex",
                   "SubdivisionMesh \"catmull-clark\" [4] [0 1 2 9] \"P\" [0 0 0 1 0 0 1 1 0 0 1 0]", "RIB-INDEX", 2,
                   0},
        BadRequest{"SubdivisionLoopOfQuads", "SubdivisionMesh \"loop\" [4] [0 1 2 3] \"P\" [0 0 0 1 0 0 1 1 0 0 1 0]",
                   "RIB-SHAPE", 2, 0},
        BadRequest{"SubdivisionScheme", "SubdivisionMesh \"doo\" [4] [0 1 2 3] \"P\" [0 0 0 1 0 0 1 1 0 0 1 0]",
                   "RIB-SCHEME", 2, 1},
        BadRequest{"SubdivisionTags",
                   "SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"crease\"] [9 1] [0 1] [2] \"P\" [0 0 0 1 0 0 "
                   "1 1 0 0 1 0]",
                   "RIB-TAGS", 2, 1},
        BadRequest{"SubdivisionTagsNegative",
                   "SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"crease\"] [-1 1] [0 1] [2] \"P\" [0 0 0 1 0 0 "
                   "1 1 0 0 1 0]",
                   "RIB-TAGS", 2, 1},
        BadRequest{"CurvesCount", "Curves \"linear\" [3] \"nonperiodic\" \"P\" [0 0 0 1 0 0]", "RIB-SHAPE", 2, 0},
        BadRequest{"CurvesNegative", "Curves \"linear\" [-3 5] \"nonperiodic\" \"P\" [0 0 0 1 0 0]", "RIB-SHAPE", 2,
                   0},
        BadRequest{"PatchPoints", "Patch \"bicubic\" \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]", "RIB-SHAPE", 2, 0},
        BadRequest{"PatchType", "Patch \"cubic\" \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]", "RIB-ARGUMENTS", 2, 0},
        BadRequest{"PatchMeshHuge",
                   "PatchMesh \"bilinear\" 1000000000 \"periodic\" 1000000000 \"periodic\" \"P\" [0 0 0]",
                   "RIB-SHAPE", 2, 0},
        BadRequest{"PatchMeshNegative", "PatchMesh \"bilinear\" -2 \"periodic\" 2 \"periodic\" \"P\" [0 0 0]",
                   "RIB-ARGUMENTS", 2, 0},
        BadRequest{"NuPatchKnots", "NuPatch 2 2 [0 0 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]",
                   "RIB-SHAPE", 2, 0},
        BadRequest{"NuPatchOrder", "NuPatch 2 9 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]",
                   "RIB-SHAPE", 2, 0},
        BadRequest{"TrimCurve", "TrimCurve [1] [2] [0 0 1] [0] [1] [2] [0 1] [0 1] [1 1]", "RIB-ARGUMENTS", 2, 0},
        BadRequest{"SingularScale", "Scale 1 0 1", "RIB-TRANSFORM", 2, 0},
        BadRequest{"SingularMatrix", "ConcatTransform [1 2 3 0 2 4 6 0 0 0 1 0 0 0 0 1]", "RIB-TRANSFORM", 2, 0},
        BadRequest{"NanMatrix", "Transform [nan 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]", "RIB-TRANSFORM", 2, 0},
        BadRequest{"NanTranslate", "Translate 0 nan 0", "RIB-TRANSFORM", 2, 0},
        BadRequest{"RotateWithoutAxis", "Rotate 90 0 0 0", "RIB-TRANSFORM", 2, 0},
        BadRequest{"ShortMatrix", "ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0]", "RIB-ARGUMENTS", 2, 0},
        BadRequest{"CoordSys", "CoordSysTransform \"nowhere\"", "RIB-COORDSYS", 2, 0},
        BadRequest{"StrayEnd", "AttributeEnd", "RIB-NESTING", 2, 0},
        BadRequest{"OpenAttribute", "TransformBegin\nAttributeBegin\nTransformEnd", "RIB-NESTING", 4, 0},
        BadRequest{"OpenSolid", "AttributeBegin\nSolidBegin \"union\"\nAttributeEnd", "RIB-NESTING", 4, 0},
        BadRequest{"StraySolidEnd", "SolidEnd", "RIB-NESTING", 2, 0},
        BadRequest{"SolidNeverClosed", "\n\nSolidBegin \"union\"", "RIB-NESTING", 6, 0},
        BadRequest{"UnknownSolid", "SolidBegin \"xor\"\nSphere 1 -1 1 360\nSolidEnd", "RIB-SOLID", 2, 1},
        BadRequest{"NoKindOfSolid", "SolidBegin\nSphere 1 -1 1 360\nSolidEnd", "RIB-SOLID", 2, 1},
        BadRequest{"SolidInPrimitive",
                   "SolidBegin \"primitive\"\nSolidBegin \"union\"\nSphere 1 -1 1 360\nSolidEnd\nSolidEnd",
                   "RIB-SOLID", 3, 1},
        BadRequest{"StrayElse", "Else", "RIB-NESTING", 2, 0},
        BadRequest{"StrayArchiveEnd", "ArchiveEnd", "RIB-NESTING", 2, 0},
        BadRequest{"StrayMotionEnd", "MotionEnd", "RIB-NESTING", 2, 0},
        BadRequest{"Condition", "IfBegin \"$user:x ==\"\nIfEnd", "RIB-CONDITION", 2, 0},
        BadRequest{"MotionTimes", "MotionBegin [1 0]\nTranslate 1 0 0\nMotionEnd", "RIB-MOTION", 2, 0},
        BadRequest{"MotionTimesOfShapes", "MotionBegin [1 0]\nSphere 1 -1 1 360\nSphere 2 -2 2 360\nMotionEnd",
                   "RIB-MOTION", 2, 1},
        BadRequest{"MotionTimeNan", "MotionBegin [0 nan]\nSphere 1 -1 1 360\nSphere 2 -2 2 360\nMotionEnd",
                   "RIB-MOTION", 2, 1},
        BadRequest{"MotionNoTimes", "MotionBegin []\nSphere 1 -1 1 360\nMotionEnd", "RIB-MOTION", 2, 1},
        BadRequest{"MotionTooMany", "MotionBegin [0 1]\nTranslate 1 0 0\nTranslate 2 0 0\nTranslate 3 0 0\nMotionEnd",
                   "RIB-MOTION", 2, 0},
        BadRequest{"MotionPoints", "MotionBegin [0 1]\nPoints \"P\" [0 0 0]\nPoints \"P\" [0 0 0 1 1 1]\nMotionEnd",
                   "RIB-MOTION", 4, 1},
        BadRequest{"MotionCount", "MotionBegin [0 1]\nTranslate 1 0 0\nMotionEnd", "RIB-MOTION", 2, 0},
        BadRequest{"MotionMixed", "MotionBegin [0 1]\nSphere 1 -1 1 360\nCone 1 1 360\nMotionEnd", "RIB-MOTION", 4,
                   1},
        BadRequest{"MotionNested",
                   "MotionBegin [0 1]\nMotionBegin [0 1]\nTranslate 1 0 0\nTranslate 2 0 0\nMotionEnd", "RIB-MOTION",
                   3, 0},
        BadRequest{"MotionTopology",
                   "MotionBegin [0 1]\nPolygon \"P\" [0 0 0 1 0 0 0 1 0]\nPolygon \"P\" [0 0 0 1 0 0 0 1 0 2 2 "
                   "2]\nMotionEnd",
                   "RIB-MOTION", 4, 1},
        BadRequest{"MotionStatic", "MotionBegin [0 1]\nSides 1\nSides 2\nMotionEnd", "RIB-MOTION-STATIC", 3, 0},
        BadRequest{"MotionVolume",
                   "MotionBegin [0 1]\nVolume \"box\" [0 1 0 1 0 1] [0 0 0]\nVolume \"box\" [2 3 0 1 0 1] [0 0 "
                   "0]\nMotionEnd",
                   "RIB-MOTION-STATIC", 3, 1},
        BadRequest{"MotionBlobby",
                   "MotionBegin [0 1]\n"
                   "Blobby 1 [1001 0] [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] [\"\"]\n"
                   "Blobby 1 [1001 0] [1 0 0 0 0 1 0 0 0 0 1 0 2 0 0 1] [\"\"]\nMotionEnd",
                   "RIB-MOTION-STATIC", 3, 1},
        BadRequest{"Handle", "ObjectInstance \"none\"", "RIB-HANDLE", 2, 0},
        BadRequest{"ObjectInItself", "ObjectBegin 1\nObjectInstance 1\nObjectEnd", "RIB-RECURSION", 3, 0},
        BadRequest{"MissingArchive", "ReadArchive \"/none/of/this.rib\"", "ASSET-MISSING-ARCHIVE", 2, 0},
        BadRequest{"ArchiveInItself", "ArchiveBegin \"a\"\nReadArchive \"a\"\nArchiveEnd\nReadArchive \"a\"",
                   "RIB-RECURSION", 3, 0},
        BadRequest{"OptionInWorld", "Format 10 10 1", "RIB-OPTION-IN-WORLD", 2, 0},
        BadRequest{"IntegerTooLarge", "Attribute \"identifier\" \"int id\" [4294967295]", "RIB-TYPE", 2, 0},
        BadRequest{"IntegerFraction", "Attribute \"visibility\" \"int camera\" [0.5]", "RIB-TYPE", 2, 0},
        BadRequest{"AttributeType", "Attribute \"identifier\" \"string name\" [5]", "RIB-TYPE", 2, 0},
        BadRequest{"NodeArrayTooLong", "Pattern \"P\" \"p\" \"color c\" [1 2 3 4 5 6]", "RIB-ARRAY-LENGTH", 2, 0},
        BadRequest{"NodeArrayTooShort", "Pattern \"P\" \"p\" \"float[4] c\" [1 2]", "RIB-ARRAY-LENGTH", 2, 0},
        BadRequest{"NodeWithoutName", "Bxdf", "RIB-ARGUMENTS", 2, 0},
        BadRequest{"Reference", "Bxdf \"B\" \"b\" \"reference color c\" [\"none:out\"]", "RIB-REFERENCE", 2, 0},
        BadRequest{"Cycle",
                   "Pattern \"P\" \"p\" \"reference color c\" [\"q:out\"]\nPattern \"Q\" \"q\" \"reference color c\" "
                   "[\"p:out\"]\nBxdf \"B\" \"b\" \"reference color c\" [\"p:out\"]",
                   "RIB-CYCLE", 3, 0},
        BadRequest{"SelfReference",
                   "Pattern \"P\" \"p\" \"reference color c\" [\"p:out\"]\nBxdf \"B\" \"b\" \"reference color c\" "
                   "[\"p:out\"]",
                   "RIB-CYCLE", 2, 0},
        BadRequest{"DeclareOfADeclaration", "Declare \"varying float x\" \"int\"", "RIB-DECLARATION", 2, 0},
        BadRequest{"DeclareWithoutName", "Declare \"\" \"int\"", "RIB-DECLARATION", 2, 0},
        BadRequest{"SkewAlongOneLine", "Skew 30 0 1 0 0 2 0", "RIB-TRANSFORM", 2, 0},
        BadRequest{"SkewTooFar", "Skew 100 0 1 0 1 0 0", "RIB-TRANSFORM", 2, 0},
        BadRequest{"Declare", "Declare \"x\" \"no such type\"", "RIB-DECLARATION", 2, 0},
        BadRequest{"Basis", "Basis \"fnord\" 3 \"bezier\" 3", "RIB-ARGUMENTS", 2, 0},
        BadRequest{"NoP", "Points", "RIB-MISSING-P", 2, 0}),
    [](const auto& info) { return info.param.name; });

TEST(BadInput, PointsThatAreNotFiniteLeaveTheirPrimitiveOut) {
  const Read r = readWorld("Polygon \"P\" [0 0 0 1 0 0 0 nan 0]\nPoints \"P\" [0 0 1e999]");
  EXPECT_EQ(r.world().primitives.size(), 0u);
  EXPECT_EQ(r.count("RIB-NUMBER"), 2u) << r.all();
  EXPECT_EQ(r.find("RIB-NUMBER")->pos.line, 2u);
}

TEST(BadInput, RepairsAreWhatTheMessageSays) {
  Read r = readWorld("Scale 0 1 1\nTranslate 1 0 0\nSphere 1 -1 1 360");
  EXPECT_EQ(r.primitive().toWorld.matrices[0][3][0], 1);
  EXPECT_EQ(r.primitive().toWorld.matrices[0][0][0], 1) << "the identity is used";
  r = readWorld("Polygon \"P\" [0 0 0 1 0 0 0 1 0] \"N\" [0 0 1] \"uniform color Cs\" [1 0 0 1 0 0]");
  EXPECT_EQ(r.primitive().primvars.find("N")->storage, StorageClass::Constant);
  EXPECT_FALSE(r.primitive().primvars.find("Cs"));
  r = readWorld("Bxdf \"B\" \"b\" \"reference color c\" [\"none:out\"] \"float k\" [2]\nSphere 1 -1 1 360");
  EXPECT_FALSE(r.primitive().attributes->bxdf->terminal->params.find("c")) << "its default is used";
  EXPECT_EQ(r.primitive().attributes->bxdf->terminal->params.getFloat("k", 0), 2);
  r = readWorld("Sphere 1 -1 1 360 \"s\" [nan 1e999 3 4]");
  EXPECT_EQ(r.primitive().primvars.getFloats("s")[0], 0);
  EXPECT_EQ(r.primitive().primvars.getFloats("s")[1], std::numeric_limits<float>::max());
  r = readRib("Format 1e9 1e9 1\nFormat -1 0 0\nWorldBegin\nWorldEnd");
  EXPECT_EQ(r.world().resolution[0], 1000000000) << "what is too large for memory is said by those who allocate it";
}

TEST(BadInput, MeshesMayHavePointsThatNoFaceUses) {
  const Read r = readWorld(
      "PointsPolygons [3] [0 1 2] \"P\" [0 0 0 1 0 0 0 1 0 5 5 5] \"varying float s\" [1 2 3 4] \"vertex float t\" "
      "[1 2 3]");
  EXPECT_TRUE(r.messages.empty()) << r.all();
  EXPECT_EQ(r.primitive().primvars.size(), 3u);
}

TEST(BadInput, NothingAndNoWorld) {
  Read r = readRib("");
  EXPECT_FALSE(r.ok);
  EXPECT_EQ(r.count("RIB-EMPTY"), 1u);
  EXPECT_EQ(r.count("RIB-NO-WORLD"), 1u);
  r = readRib("# only a comment\n");
  EXPECT_FALSE(r.ok);
  r = readRib("Sphere 1 -1 1 360\nLight \"PxrRectLight\" \"l\"");
  EXPECT_TRUE(r.ok);
  EXPECT_EQ(r.worlds.size(), 0u);
  EXPECT_EQ(r.count("RIB-OUTSIDE-WORLD"), 1u);
  EXPECT_EQ(r.count("RIB-NO-WORLD"), 1u);
}

TEST(BadInput, OpenBlocksAreClosedAtTheEnd) {
  const Read r = readRib(
      "FrameBegin 1\nWorldBegin\nAttributeBegin\nObjectBegin 1\nIfBegin \"1\"\nSphere 1 -1 1 360\nObjectEnd\nSphere "
      "1 -1 1 360\nMotionBegin [0 1]\nTranslate 1 0 0\n");
  ASSERT_EQ(r.worlds.size(), 1u);
  EXPECT_EQ(r.world().primitives.size(), 1u);
  EXPECT_EQ(r.count("RIB-NESTING"), 5u) << r.all();  // If, Motion, Attribute, World, Frame
}

TEST(BadInput, WorldsAndFramesInsideEachOther) {
  Read r = readRib("WorldBegin\nSphere 1 -1 1 360\nWorldBegin\nSphere 1 -1 1 360\nWorldEnd\nWorldEnd\n");
  EXPECT_EQ(r.worlds.size(), 2u);
  r = readRib("FrameBegin 1\nWorldBegin\nFrameBegin 2\nWorldBegin\nWorldEnd\nFrameEnd\n");
  EXPECT_EQ(r.worlds.size(), 2u);
  EXPECT_EQ(r.worlds[1].frame, 2);
}

TEST(BadInput, DeepNestingIsBounded) {
  std::string deep;
  for (int i = 0; i < 300000; ++i) deep += "AttributeBegin ";
  deep += "Sphere 1 -1 1 360 ";
  for (int i = 0; i < 300000; ++i) deep += "AttributeEnd ";
  Read r = readWorld(deep);
  EXPECT_EQ(r.count("RIB-DEPTH"), 1u);
  EXPECT_EQ(r.count("RIB-NESTING"), 0u) << r.all();
  EXPECT_EQ(r.world().primitives.size(), 1u);
  deep.clear();
  for (int i = 0; i < 300000; ++i) deep += "IfBegin \"1\" ";
  r = readWorld(deep);
  EXPECT_EQ(r.count("RIB-DEPTH"), 1u);
  EXPECT_EQ(r.count("RIB-NESTING"), 1u) << "all conditions at once: " << r.all();
  deep += "Else Sphere 2 -2 2 360 ";
  for (int i = 0; i < 300000; ++i) deep += "IfEnd ";
  r = readWorld(deep + "Sphere 1 -1 1 360");
  EXPECT_EQ(r.count("RIB-DEPTH"), 1u);
  EXPECT_EQ(r.count("RIB-NESTING"), 0u) << r.all();
  deep.clear();
  for (int i = 0; i < 300000; ++i) deep += "ArchiveBegin \"a\" ";
  r = readWorld(deep);
  EXPECT_EQ(r.count("RIB-NESTING"), 2u) << "the archive and the world";
}

TEST(BadInput, ArchivesThatMultiplyEndAtALimit) {
  std::string text = "ArchiveBegin \"a0\" Sphere 1 -1 1 360 ArchiveEnd\n";
  for (int i = 1; i < 30; ++i) {
    const std::string before = "ReadArchive \"a" + std::to_string(i - 1) + "\" ";
    text += "ArchiveBegin \"a" + std::to_string(i) + "\" " + before + before + "ArchiveEnd\n";
  }
  ReadOptions options;
  options.maxArchiveReads = 5000;
  const Read r = readWorld(text + "ReadArchive \"a29\"\nSphere 7 -7 7 360", options);
  EXPECT_EQ(r.count("RIB-DEPTH"), 1u) << r.all();
  EXPECT_LT(r.world().primitives.size(), 5001u);
  options = {};
  options.maxArchiveDepth = 5;
  EXPECT_GE(readWorld(text + "ReadArchive \"a10\"", options).count("RIB-DEPTH"), 1u);
}

class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("kinora_bad_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_ / "geo/deep");
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return (path_ / name).string();
  }
  std::string path(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

Read readFile(const std::string& file, ReadOptions options = {}) {
  Read out;
  Diagnostics messages([](const std::string&, Severity) {});
  RibReader reader(messages, std::move(options), [&](Scene&& s) { out.worlds.push_back(std::move(s)); });
  out.ok = reader.readFile(file);
  reader.finish();
  out.messages = messages.messages();
  return out;
}

// What keeps requests waiting for its end would take the rest of the scene with it.
TEST(Archives, WhatTheyLeaveOpenEndsWithThem) {
  const Folder f;
  f.write("ball.rib", "Sphere 2 -2 2 360\n");
  const std::pair<const char*, size_t> open[] = {{"ArchiveBegin \"in\"\nSphere 1 -1 1 360\n", 1},
                                                 {"MotionBegin [0 1]\nTranslate 0 0 1\n", 1},
                                                 {"MotionBegin [0 1]\nReadArchive \"ball.rib\"\n", 2},
                                                 {"EditBegin \"attribute\"\nSphere 1 -1 1 360\n", 1},
                                                 {"IfBegin \"0\"\nSphere 1 -1 1 360\n", 1}};
  for (const auto& [text, count] : open) {
    f.write("open.rib", text);
    const Read r =
        readFile(f.write("main.rib", "WorldBegin\nReadArchive \"open.rib\"\nSphere 7 -7 7 360\nWorldEnd\n"));
    ASSERT_EQ(r.count("RIB-NESTING"), 1u) << text << r.all();
    EXPECT_EQ(*r.find("RIB-NESTING")->pos.file, f.path("open.rib")) << text;
    EXPECT_EQ(r.find("RIB-NESTING")->pos.line, 1u) << text;
    ASSERT_EQ(r.world().primitives.size(), count) << text << r.all();
    EXPECT_EQ(std::get<Quadric>(r.world().primitives.back()->shape).args[0], 7) << text;
  }
  // nor do they end, or turn round, conditions around them
  for (const char* text : {"IfEnd\n", "Else\n", "ElseIf \"1\"\n"}) {
    f.write("end.rib", text);
    const Read r = readFile(f.write("main.rib",
                                    "WorldBegin\nIfBegin \"1\"\nReadArchive \"end.rib\"\nSphere 7 -7 7 360\n"
                                    "Else\nSphere 1 -1 1 360\nIfEnd\nWorldEnd\n"));
    EXPECT_EQ(r.count("RIB-NESTING"), 1u) << text << r.all();
    ASSERT_EQ(r.world().primitives.size(), 1u) << text << r.all();
    EXPECT_EQ(std::get<Quadric>(r.primitive().shape).args[0], 7) << text;
  }
  // blocks that the scene closes are told by their own file
  f.write("open.rib", "\nAttributeBegin\n");
  const Read r = readFile(f.write("main.rib", "WorldBegin\nReadArchive \"open.rib\"\nWorldEnd\n"));
  EXPECT_NE(r.all().find("open.rib:2 is still open"), std::string::npos) << r.all();
}

TEST(Archives, AreFoundAsNamedBesideAlongThePathAndByBaseName) {
  const Folder f;
  f.write("geo/ball.rib", "Sphere 1 -1 1 360\nReadArchive \"deep/inner.rib\"\n");
  f.write("geo/deep/inner.rib", "Sphere 2 -2 2 360\n");
  const auto world = [&](const std::string& text) {
    return readFile(f.write("main.rib", "WorldBegin\n" + text + "\nWorldEnd\n"));
  };
  Read r = world("ReadArchive \"geo/ball.rib\"");
  EXPECT_EQ(r.world().primitives.size(), 2u) << r.all();
  EXPECT_EQ(*r.primitive(1).pos.file, f.path("geo/deep/inner.rib"));
  r = world("Option \"searchpath\" \"string archive\" [\"geo:@\"]\nReadArchive \"ball.rib\"");
  EXPECT_EQ(r.world().primitives.size(), 2u) << r.all();
  r = world(
      "Option \"searchpath\" \"archive\" [\"geo\"]\nOption \"searchpath\" \"archive\" [\"nowhere:&\"]\nReadArchive "
      "\"/Users/someone/project/ball.rib\"");
  EXPECT_EQ(r.world().primitives.size(), 2u) << r.all();
  r = readFile(f.write("geo/deep/scene.rib", "WorldBegin\nReadArchive \"geo/ball.rib\"\nWorldEnd\n"));
  EXPECT_EQ(r.world().primitives.size(), 2u) << "from the project's folder: " << r.all();
  ReadOptions options;
  options.archivePath = {f.path("geo")};
  r = readFile(f.write("main.rib", "WorldBegin\nReadArchive \"ball.rib\"\nWorldEnd\n"), options);
  EXPECT_EQ(r.world().primitives.size(), 2u);
  options = {};
  options.dirmap = {{"/far/away", f.path("geo")}};
  r = readFile(f.write("main.rib", "WorldBegin\nReadArchive \"/far/away/ball.rib\"\nWorldEnd\n"), options);
  EXPECT_EQ(r.world().primitives.size(), 2u);
  r = world("ReadArchive \"none.rib\"\nSphere 1 -1 1 360");
  EXPECT_EQ(r.count("ASSET-MISSING-ARCHIVE"), 1u);
  EXPECT_EQ(r.find("ASSET-MISSING-ARCHIVE")->pos.line, 2u);
  EXPECT_EQ(r.world().primitives.size(), 1u);
  r = world("ReadArchive \"geo\"");
  EXPECT_EQ(r.count("ASSET-MISSING-ARCHIVE"), 1u) << "a directory is no archive";
}

TEST(Archives, SearchPathsNameVariablesOfTheEnvironment) {
  const Folder f;
  f.write("geo/ball.rib", "Sphere 1 -1 1 360\n");
  setenv("KINORA_TEST_FOLDER", f.path("geo").c_str(), 1);
  for (const char* written : {"$KINORA_TEST_FOLDER", "${KINORA_TEST_FOLDER}", "${KINORA_TEST_FOLDER}/../geo/:@",
                              "nowhere:$KINORA_TEST_FOLDER:$KINORA_TEST_NOT_SET"}) {
    const Read r = readRib("Option \"searchpath\" \"string archive\" [\"" + std::string(written) +
                           "\"]\nWorldBegin\nReadArchive \"ball.rib\"\nWorldEnd\n");
    EXPECT_EQ(r.world().primitives.size(), 1u) << written << "\n" << r.all();
  }
  const Read r =
      readWorld("Option \"searchpath\" \"string texture\" [\"$KINORA_TEST_FOLDER:$KINORA_TEST_NOT_SET/x\"]\n");
  EXPECT_EQ(r.world().options.getString("searchpath:texture", ""), f.path("geo") + ":$KINORA_TEST_NOT_SET/x");
  unsetenv("KINORA_TEST_FOLDER");
}

TEST(Archives, TheScenesOwnDirmap) {
  const Folder f;
  f.write("geo/ball.rib", "Sphere 1 -1 1 360\n");
  const auto world = [&](const std::string& map, ReadOptions options = {}) {
    return readFile(f.write("main.rib", "Option \"searchpath\" \"string dirmap\" [\"" + map +
                                            "\"]\nDisplay \"/studio/out.exr\" \"openexr\" \"rgba\"\nWorldBegin\n"
                                            "ReadArchive \"/studio/geo/deep/ball.rib\"\nWorldEnd\n"),
                    std::move(options));
  };
  const auto mapped = [&](const char* zone, const std::string& to) {
    return std::string("[\\\"") + zone + "\\\" \\\"/studio/geo/deep\\\" \\\"" + to + "\\\"]";
  };
  f.write("main.rib", "");
  // without the map the base name is looked for beside the scene and along the path, where it is not
  EXPECT_EQ(world("").world().primitives.size(), 0u);
  EXPECT_EQ(world(mapped("NFS", f.path("geo"))).world().primitives.size(), 1u);
  EXPECT_EQ(world(mapped("UNC", f.path("geo"))).world().primitives.size(), 1u) << "a folder of this machine";
  EXPECT_EQ(world(mapped("UNC", "Z:/geo")).world().primitives.size(), 0u) << "one of another";
  Read r = world(" " + mapped("NFS", "/nowhere") + " [\\\"NFS\\\" \\\"/studio\\\" \\\"" + f.path("geo") + "\\\"] ");
  EXPECT_EQ(r.world().primitives.size(), 0u) << "the first that fits";
  EXPECT_EQ(r.world().displays[0].file, f.path("geo") + "/out.exr") << "all names are mapped";
  ReadOptions options;
  options.dirmap = {{"/studio/geo/deep", f.path("geo")}};
  EXPECT_EQ(world(mapped("NFS", "/nowhere"), options).world().primitives.size(), 1u)
      << "the command line comes first";
  for (const char* bad :
       {"x", "[\\\"NFS\\\" \\\"a\\\"]", "[\\\"NFS\\\" \\\"a\\\" \\\"b\\\"", "[\\\"NFS\\\" \\\"a\\\" \\\"b]"}) {
    r = world(bad);
    EXPECT_EQ(r.count("RIB-DIRMAP"), 1u) << bad << "\n" << r.all();
    EXPECT_EQ(r.find("RIB-DIRMAP")->pos.line, 1u);
  }
}

// A zip archive of stored members; `claim` is added to the sizes and offsets that its directory says.
std::string zipOf(const std::vector<std::pair<std::string, std::string>>& members, uint32_t claim = 0) {
  std::string out, directory;
  const auto put = [](std::string& to, uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) to += char(value >> (8 * i));
  };
  for (const auto& [name, text] : members) {
    const uint32_t offset = uint32_t(out.size());
    std::string common;
    put(common, 20, 2);  // version, flags, method, time, date, crc
    for (const int n : {2, 2, 2, 2, 4}) put(common, 0, n);
    put(common, uint32_t(text.size()) + claim, 4);
    put(common, uint32_t(text.size()) + claim, 4);
    put(common, uint32_t(name.size()), 2);
    put(common, 0, 2);
    out += "PK\3\4" + common + name + text;
    directory += "PK\1\2";
    put(directory, 20, 2);
    directory += common;
    for (const int n : {2, 2, 2, 4}) put(directory, 0, n);
    put(directory, offset + claim, 4);
    directory += name;
  }
  const uint32_t start = uint32_t(out.size());
  out += directory + "PK\5\6";
  put(out, 0, 4);
  put(out, uint32_t(members.size()), 2);
  put(out, uint32_t(members.size()), 2);
  put(out, uint32_t(directory.size()), 4);
  put(out, start, 4);
  put(out, 0, 2);
  return out;
}
const std::string kBall = "Sphere 1 -1 1 360\n";
const std::string kReads = "WorldBegin\nReadArchive \"geo/ball.rib\"\nReadArchive \"beside.rib\"\nWorldEnd\n";

TEST(Zip, AsTheMainFileOpensAsItsScene) {
  const Folder f;
  f.write("beside.rib", kBall);
  const std::vector<std::vector<std::pair<std::string, std::string>>> archives = {
      {{"anything.rib", kReads}, {"geo/ball.rib", kBall}},                    // the only one that stands highest
      {{"geo/ball.rib", kBall}, {"other.rib", kBall}, {"show.rib", kReads}},  // named like the archive
      {{"other.rib", kBall}, {"geo/ball.rib", kBall}, {"main.RIB", kReads}},  // the one with a world
      {{"__MACOSX/._x.rib", "\1\2"},
       {"._x.rib", "\1"},
       {"x.rib", kReads},
       {"geo/ball.rib", kBall},
       {"readme.txt", "x"}}};
  for (size_t i = 0; i < archives.size(); ++i)
    // what it is shows in its bytes, not in its name
    for (const char* name : {"show.zip", "show.archive"}) {
      const Read r = readFile(f.write(name, zipOf(archives[i])));
      EXPECT_TRUE(r.ok) << i << "\n" << r.all();
      EXPECT_EQ(r.world().primitives.size(), 2u) << "one inside, one beside: " << i << "\n" << r.all();
    }
  // in a folder of the archive, whose neighbours it names
  const Read deep = readFile(f.write("deep.zip", zipOf({{"a/b/show.rib",
                                                         "WorldBegin\nReadArchive \"ball.rib\"\nReadArchive "
                                                         "\"a/top.rib\"\nWorldEnd\n"},
                                                        {"a/b/c/d.rib", kBall},
                                                        {"a/b/ball.rib", kBall},
                                                        {"a/top.rib", kBall}})));
  EXPECT_EQ(deep.world().primitives.size(), 2u) << deep.all();
  const Read named = readFile(f.path("deep.zip") + "!a/b/show.rib");
  EXPECT_EQ(named.world().primitives.size(), 2u) << named.all();
}

TEST(Zip, ThatHoldsNoSceneSaysWhy) {
  const Folder f;
  const auto expectRefused = [&](const std::string& bytes, const std::string& why) {
    const Read r = readFile(f.write("bad.zip", bytes));
    EXPECT_FALSE(r.ok);
    ASSERT_EQ(r.count("RIB-ZIP") + r.count("RIB-OPEN"), 1u) << why << "\n" << r.all();
    EXPECT_NE(r.all().find(why), std::string::npos) << r.all();
  };
  const std::string world = "WorldBegin\nSphere 1 -1 1 360\nWorldEnd\n";
  expectRefused(zipOf({{"readme.txt", "x"}}), "without a RIB file");
  expectRefused(zipOf({{"a.rib", world}, {"b.rib", world}}), "several RIB files (a.rib, b.rib)");
  const std::string good = zipOf({{"a.rib", world}});
  for (size_t length = 4; length < good.size(); length += 7) expectRefused(good.substr(0, length), "zip");
  expectRefused(zipOf({{"a.rib", world}}, 1000), "not where its directory says");
  // the directory claims more than the file has: what is there is read
  std::string longer = good;
  longer[good.find("PK\1\2") + 20] = char(200);
  const Read r = readFile(f.write("long.zip", longer));
  EXPECT_EQ(r.count("RIB-TRUNCATED"), 1u) << r.all();
  EXPECT_EQ(r.world().primitives.size(), 1u);
  // any byte broken: a message or the scene, never more
  uint32_t state = 7;
  for (int i = 0; i < 500; ++i) {
    std::string broken = good;
    for (int k = 0; k < 3; ++k) {
      state = state * 1664525u + 1013904223u;
      broken[(state >> 8) % broken.size()] = char(state >> 24);
    }
    readFile(f.write("broken.zip", broken));
  }
}

// Keys at even times stand for those of motion blocks: what is closer than they are is told.
TEST(MotionBlocks, TimesThatAreTooCloseAreTold) {
  const auto told = [](const std::string& shutter, const std::string& times) {
    const Read r = readRib(shutter + "\nWorldBegin\nMotionBegin [" + times +
                           "]\nTranslate 0 0 0\nTranslate 1 0 0\nTranslate 2 0 0\nMotionEnd\nSphere 1 -1 1 "
                           "360\nWorldEnd\n");
    return r.count("RIB-MOTION-CLOSE");
  };
  EXPECT_EQ(told("Shutter 0 1", "0 .001 1"), 1u);
  EXPECT_EQ(told("Shutter 0 1", "0 .5 1"), 0u);
  EXPECT_EQ(told("Shutter 0 1", "-.001 0 1"), 0u);
  EXPECT_EQ(told("Shutter 0 .01", "0 .001 1"), 0u);
  EXPECT_EQ(told("", "0 .001 1"), 0u) << "nothing is open";
  Explanations explain;
  explain.add(explanations());
  EXPECT_TRUE(explain.find("RIB-MOTION-CLOSE"));
}

TEST(Archives, ThatReadEachOtherStop) {
  const Folder f;
  f.write("a.rib", "ReadArchive \"b.rib\"\nSphere 1 -1 1 360\n");
  f.write("b.rib", "ReadArchive \"./a.rib\"\nSphere 2 -2 2 360\n");
  const Read r = readFile(f.write("main.rib", "WorldBegin\nReadArchive \"a.rib\"\nWorldEnd\n"));
  EXPECT_EQ(r.world().primitives.size(), 2u);
  EXPECT_EQ(r.count("RIB-RECURSION"), 1u);
  EXPECT_EQ(*r.find("RIB-RECURSION")->pos.file, f.path("b.rib"));
  const Read self = readFile(f.write("self.rib", "WorldBegin\nReadArchive \"self.rib\"\nWorldEnd\n"));
  EXPECT_EQ(self.count("RIB-RECURSION"), 1u);
}

TEST(Archives, AnOpenConditionDoesNotSwallowTheRest) {
  const Folder f;
  f.write("a.rib", "IfBegin \"0\"\nSphere 1 -1 1 360\n");
  const Read r = readFile(f.write("main.rib", "WorldBegin\nReadArchive \"a.rib\"\nSphere 2 -2 2 360\nWorldEnd\n"));
  EXPECT_EQ(r.world().primitives.size(), 1u);
  EXPECT_EQ(r.count("RIB-NESTING"), 1u);
}

// A whole file read inside a world adds what it holds; a world that the same file begins ends the one before.
TEST(Archives, AWorldInsideAWorldIsPartOfIt) {
  const Folder f;
  f.write("vase.rib",
          "Display \"v.tif\" \"file\" \"rgb\"\nTranslate 0 0 5\nWorldBegin\nColor 1 0 0\n"
          "Sphere 1 -1 1 360\nWorldEnd\n");
  f.write("cut.rib", "WorldBegin\nSphere 1 -1 1 360\n");
  const Read r = readFile(f.write("main.rib",
                                  "WorldBegin\nColor 0 1 0\nAttributeBegin\nReadArchive \"vase.rib\"\n"
                                  "Sphere 2 -2 2 360\nAttributeEnd\nSphere 3 -3 3 360\nWorldEnd\n"));
  ASSERT_EQ(r.worlds.size(), 1u) << r.all();
  ASSERT_EQ(r.world().primitives.size(), 3u);
  EXPECT_EQ(r.count("RIB-NESTING"), 1u) << r.all();
  EXPECT_EQ(r.primitive(0).toWorld.matrices[0][3][2], 5);
  EXPECT_EQ((*r.primitive(0).attributes->color)[0], 1);
  EXPECT_EQ((*r.primitive(1).attributes->color)[1], 1) << "its colour ended with its world";
  const Read cut = readFile(f.write("main.rib",
                                    "WorldBegin\nReadArchive \"cut.rib\"\nSphere 2 -2 2 360\nWorldEnd\n"
                                    "WorldBegin\nSphere 3 -3 3 360\nWorldEnd\n"));
  ASSERT_EQ(cut.worlds.size(), 2u) << cut.all();
  EXPECT_EQ(cut.worlds[0].primitives.size(), 2u);
  EXPECT_EQ(cut.worlds[1].primitives.size(), 1u);
  EXPECT_EQ(readRib("WorldBegin\nSphere 1 -1 1 360\nWorldBegin\nSphere 2 -2 2 360\nWorldEnd").worlds.size(), 2u);
}

// A file of one frame, too: with its world or without one, and cut short.
TEST(Archives, AFrameInsideAWorldIsPartOfIt) {
  const Folder f;
  f.write("frame.rib",
          "FrameBegin 1\nTranslate 0 0 5\nWorldBegin\nColor 1 0 0\nSphere 1 -1 1 360\nWorldEnd\nFrameEnd\n");
  f.write("bare.rib", "FrameBegin 1\nColor 1 0 0\nSphere 1 -1 1 360\nFrameEnd\n");
  f.write("cut.rib", "FrameBegin 1\nSphere 1 -1 1 360\n");
  const Read r = readFile(f.write("main.rib",
                                  "FrameBegin 7\nWorldBegin\nColor 0 1 0\nReadArchive \"frame.rib\"\n"
                                  "ReadArchive \"bare.rib\"\nSphere 2 -2 2 360\nWorldEnd\nFrameEnd\n"));
  ASSERT_EQ(r.worlds.size(), 1u) << r.all();
  ASSERT_EQ(r.world().primitives.size(), 3u) << r.all();
  EXPECT_EQ(r.count("RIB-NESTING"), 3u) << r.all();
  EXPECT_EQ(r.messages.size(), 3u) << r.all();
  EXPECT_EQ(r.world().frame, 7);
  EXPECT_EQ(r.primitive(0).toWorld.matrices[0][3][2], 5);
  EXPECT_EQ((*r.primitive(0).attributes->color)[0], 1);
  EXPECT_EQ((*r.primitive(1).attributes->color)[0], 1);
  EXPECT_EQ((*r.primitive(2).attributes->color)[1], 1) << "its colour ended with its frame";
  EXPECT_EQ(r.primitive(2).toWorld.matrices[0][3][2], 0);
  const Read cut = readFile(f.write("main.rib",
                                    "FrameBegin 1\nWorldBegin\nReadArchive \"cut.rib\"\nSphere 2 -2 2 360\n"
                                    "WorldEnd\nFrameEnd\nFrameBegin 2\nWorldBegin\nSphere 3 -3 3 360\nWorldEnd\n"
                                    "FrameEnd\n"));
  ASSERT_EQ(cut.worlds.size(), 2u) << cut.all();
  EXPECT_EQ(cut.worlds[0].primitives.size(), 2u);
  EXPECT_EQ(cut.worlds[1].primitives.size(), 1u);
  EXPECT_EQ(cut.worlds[1].frame, 2);
}

TEST(BadInput, CheckOnlyKeepsNothing) {
  ReadOptions options;
  options.checkOnly = true;
  const Read r = readWorld("Sphere 1 -1 1 360\nPointsPolygons [3] [0 1 9] \"P\" [0 0 0 1 0 0 0 1 0]", options);
  EXPECT_EQ(r.world().primitives.size(), 0u);
  EXPECT_EQ(r.count("RIB-INDEX"), 1u);
}

// Requests with arguments of every kind in every place: nothing may crash, whatever it says.
TEST(BadInput, RandomArgumentsForEveryRequest) {
  static const char* const kNames[] = {"Sphere",
                                       "Cone",
                                       "Hyperboloid",
                                       "Torus",
                                       "Polygon",
                                       "GeneralPolygon",
                                       "PointsPolygons",
                                       "PointsGeneralPolygons",
                                       "Patch",
                                       "PatchMesh",
                                       "NuPatch",
                                       "SubdivisionMesh",
                                       "HierarchicalSubdivisionMesh",
                                       "Curves",
                                       "Points",
                                       "Blobby",
                                       "Volume",
                                       "Geometry",
                                       "Procedural",
                                       "Procedural2",
                                       "TrimCurve",
                                       "Basis",
                                       "Format",
                                       "Display",
                                       "DisplayChannel",
                                       "Option",
                                       "Attribute",
                                       "Bxdf",
                                       "Pattern",
                                       "Light",
                                       "LightFilter",
                                       "Surface",
                                       "LightSource",
                                       "AreaLightSource",
                                       "Illuminate",
                                       "Color",
                                       "Transform",
                                       "Rotate",
                                       "Skew",
                                       "Perspective",
                                       "CoordinateSystem",
                                       "CoordSysTransform",
                                       "MotionBegin",
                                       "MotionEnd",
                                       "AttributeBegin",
                                       "AttributeEnd",
                                       "TransformBegin",
                                       "TransformEnd",
                                       "ObjectBegin",
                                       "ObjectEnd",
                                       "ObjectInstance",
                                       "WorldBegin",
                                       "WorldEnd",
                                       "FrameBegin",
                                       "FrameEnd",
                                       "IfBegin",
                                       "ElseIf",
                                       "Else",
                                       "IfEnd",
                                       "ArchiveBegin",
                                       "ArchiveEnd",
                                       "ReadArchive",
                                       "Resource",
                                       "Camera",
                                       "Projection",
                                       "DepthOfField",
                                       "Shutter",
                                       "Hider",
                                       "Integrator",
                                       "Quantize",
                                       "SolidBegin",
                                       "SolidEnd",
                                       "EditBegin",
                                       "EditEnd",
                                       "Declare",
                                       "Identity"};
  static const char* const kArgs[] = {"1",
                                      "-1",
                                      "0",
                                      "1e999",
                                      "nan",
                                      "2.5",
                                      "[1 2 3]",
                                      "[]",
                                      "[0 1 2 2147483647 -5]",
                                      "[0.5 1e38 nan]",
                                      "\"a\"",
                                      "\"P\" [0 0 0 1 0 0 0 1 0]",
                                      "\"bicubic\"",
                                      "\"catmull-clark\"",
                                      "[\"crease\" \"hole\"]",
                                      "\"linear\"",
                                      "\"periodic\"",
                                      "\"float x\" [1]",
                                      "\"reference color c\" [\"a:b\"]",
                                      "[3]",
                                      "[4 3]",
                                      "[0 1 2 0]",
                                      "\"DelayedReadArchive\" [\"a\"]",
                                      "\"user\"",
                                      "\"$user:x\"",
                                      "[1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]",
                                      "\"Pw\" [0 0 0 1]",
                                      "\"N\" [0 0 1]",
                                      "\"attributes\"",
                                      "\"primitive\"",
                                      "\"difference\""};
  uint32_t state = 99;
  const auto next = [&](size_t n) {
    state = state * 1664525u + 1013904223u;
    return size_t(state >> 16) % n;
  };
  for (int run = 0; run < 200; ++run) {
    std::string text = "WorldBegin\n";
    for (int i = 0; i < 100; ++i) {
      text += kNames[next(std::size(kNames))];
      for (size_t k = next(8); k > 0; --k) text += std::string(" ") + kArgs[next(std::size(kArgs))];
      text += '\n';
    }
    const Read r = readRib(text);
    for (const Scene& s : r.worlds) EXPECT_GT(s.bytes(), 0u);
  }
}

}  // namespace
}  // namespace kinora::rib
