// What primitives, objects and solids leave in the scene description.
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "rib/test_support.h"

namespace kinora::rib {
namespace {

using namespace scene;

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
  EXPECT_EQ(r.count("ASSET-PROGRAM-REFUSED"), 2u) << r.all();
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
  EXPECT_EQ(r.messages.size(), 1u) << r.all();
  const Scene& s = r.world();
  ASSERT_EQ(s.prototypes.size(), 3u);
  EXPECT_EQ(s.prototypes[0].primitives.size(), 1u);
  EXPECT_TRUE(s.prototypes[1].primitives.empty());
  ASSERT_EQ(s.prototypes[1].lights.size(), 1u);
  EXPECT_EQ(s.prototypes[1].lights[0].toWorld.matrices[0][3][1], 1);
  EXPECT_TRUE(s.prototypes[1].lights[0].geometry);
  ASSERT_EQ(s.instances.size(), 2u);
  EXPECT_EQ(s.instances[0].prototype, 1u);
  EXPECT_EQ(s.instances[1].prototype, 2u) << "as those of an old light";
  EXPECT_TRUE(s.prototypes[2].primitives.empty());
  ASSERT_EQ(s.prototypes[2].lights.size(), 1u);
  EXPECT_EQ(s.prototypes[2].lights[0].node->kind, "AreaLightSource");
}

TEST(Objects, FaceSetsOfInstances) {
  const std::string mesh =
      "PointsPolygons [3 3 3] [0 1 2 1 2 3 2 3 4] \"P\" [0 0 0 1 0 0 0 1 0 1 1 0 0 2 0] \"uniform float u\" [1 2 "
      "3]\n";
  const Read r = readWorld("ObjectBegin \"o\"\n" + mesh +
                           "Sphere 1 -1 1 360\nAttribute \"shade\" \"int[1] faceset\" [1]\n" + mesh + R"(ObjectEnd
ObjectBegin "outer"
ObjectInstance "o"
MotionBegin [0 1]
PointsPolygons [3 3] [0 1 2 1 2 3] "P" [0 0 0 1 0 0 0 1 0 1 1 0] "uniform float w" [1 2]
PointsPolygons [3 3] [0 1 2 1 2 3] "P" [0 0 1 1 0 0 0 1 0 1 1 0] "uniform float w" [3 4]
MotionEnd
ObjectEnd
ObjectInstance "outer"
AttributeBegin
Attribute "shade" "int[2] faceset" [2 0]
ObjectInstance "o"
ObjectInstance "o"
AttributeEnd
Attribute "shade" "int[1] faceset" [0]
ObjectInstance "o"
ObjectInstance "outer"
Attribute "shade" "int[1] faceset" [9]
ObjectInstance "o")");
  expectMessage(r, "RIB-INDEX", 25);
  EXPECT_EQ(r.messages.size(), 1u) << r.all();
  const Scene& s = r.world();
  ASSERT_EQ(s.instances.size(), 6u);
  const auto uOf = [&](const Prototype& p, size_t k) { return p.primitives.at(k)->primvars.find("u")->floats; };
  const auto objectOf = [&](size_t k) -> const Prototype& { return s.prototypes.at(s.instances.prototypeOf(k)); };
  const std::vector<float> all{1, 2, 3}, ends{1, 3}, own{2}, first{1};
  EXPECT_EQ(s.instances.prototypeOf(0), 1u) << "without a set it is the object as said";
  EXPECT_EQ(uOf(s.prototypes[0], 0), all);
  EXPECT_EQ(s.instances.prototypeOf(1), s.instances.prototypeOf(2)) << "a set is made once";
  ASSERT_EQ(objectOf(1).primitives.size(), 3u);
  EXPECT_EQ(uOf(objectOf(1), 0), ends);
  EXPECT_EQ(uOf(objectOf(1), 2), own) << "a set that is said in the object comes first";
  EXPECT_EQ(std::get<PolygonMesh>(objectOf(1).primitives[0]->shape).vertices, (std::vector<int>{0, 1, 2, 2, 3, 4}));
  EXPECT_EQ(uOf(objectOf(3), 0), first);
  // in objects within, too; all times of a motion block
  ASSERT_EQ(objectOf(4).instances.size(), 1u);
  EXPECT_EQ(objectOf(4).instances.prototypeOf(0), s.instances.prototypeOf(3));
  ASSERT_EQ(objectOf(4).primitives.size(), 1u);
  const Primitive& moving = *objectOf(4).primitives[0];
  EXPECT_EQ(moving.primvars.find("w")->floats, (std::vector<float>{1}));
  ASSERT_EQ(moving.motion.size(), 1u);
  EXPECT_EQ(moving.motion[0].find("w")->floats, (std::vector<float>{3}));
  EXPECT_EQ(objectOf(5).primitives.size(), 2u) << "a mesh of none of its faces is left out";
  for (size_t k = 0; k < s.instances.size(); ++k)
    EXPECT_FALSE(s.instances.attributesOf(k)->named.find("shade:faceset")) << "not twice to what is written and read";
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

}  // namespace
}  // namespace kinora::rib
