// What transforms, coordinate systems and motion blocks leave in the scene description.
#include <string>
#include <vector>

#include "rib/test_support.h"

namespace kinora::rib {
namespace {

using namespace scene;

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

TEST(Transforms, RotateWithoutAnAxisSaysSo) {
  const Read r = readWorld("Rotate 30 0 0 0\nSphere 1 -1 1 360");
  ASSERT_NE(r.find("RIB-TRANSFORM"), nullptr);
  EXPECT_EQ(r.find("RIB-TRANSFORM")->what, "Rotate has no axis: it is (0 0 0)");
  EXPECT_EQ(r.primitive(0).toWorld.matrices[0], Matrix());
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

// A scope's name ends with it for CoordSysTransform, and stays for patterns.
TEST(Transforms, CoordinateSystemsEndWithTheirScope) {
  const std::string scope =
      "WorldBegin\nAttributeBegin\nTranslate 3 0 0\nScopedCoordinateSystem \"q\"\nAttributeEnd\n";
  const Read r = readRib(scope + "CoordSysTransform \"q\"\nSphere 1 -1 1 360\nWorldEnd");
  expectMessage(r, "RIB-COORDSYS", 6);
  EXPECT_EQ(r.primitive().toWorld.matrices[0], Matrix());
  EXPECT_EQ(r.world().coordinateSystems.at("q").matrices[0][3][0], 3);
  // what CoordinateSystem names, before or after, is everybody's
  for (const char* text : {"Translate 5 0 0 CoordinateSystem \"q\" Identity CoordSysTransform \"q\"",
                           "Translate 5 0 0 CoordinateSystem \"q\" AttributeBegin Translate 1 0 0 "
                           "ScopedCoordinateSystem \"q\" AttributeEnd Identity CoordSysTransform \"q\""}) {
    const Read all = readRib(scope + text + "\nSphere 1 -1 1 360\nWorldEnd");
    EXPECT_EQ(all.primitive().toWorld.matrices[0][3][0], 5) << text << all.all();
  }
  // the next world does not know the names of this one
  const Read next = readRib(scope +
                            "WorldEnd\nTranslate 0 0 1\nCoordinateSystem \"q\"\nWorldBegin\n"
                            "CoordSysTransform \"q\"\nSphere 1 -1 1 360\nWorldEnd");
  expectClean(next);
  EXPECT_EQ(next.primitive().toWorld.matrices[0], Matrix());
}

// Before the world a scope's names end with it too, and rename nobody's; those of the scope that holds the world are
// known in it, at the places that they had before the camera.
TEST(Transforms, CoordinateSystemsOfScopesBeforeTheWorld) {
  const std::string scope =
      "Translate 0 0 5\nAttributeBegin\nTranslate 3 0 0\nScopedCoordinateSystem \"q\"\nAttributeEnd\n";
  const Read ended = readRib(scope + "CoordSysTransform \"q\"\nWorldBegin\nSphere 1 -1 1 360\nWorldEnd");
  expectMessage(ended, "RIB-COORDSYS", 6);
  EXPECT_EQ(ended.world().coordinateSystems.count("q"), 0u);
  EXPECT_EQ(ended.primitive().attributes->coordinateSystems, nullptr);
  const Read within = readRib(scope + "WorldBegin\nCoordSysTransform \"q\"\nSphere 1 -1 1 360\nWorldEnd");
  expectMessage(within, "RIB-COORDSYS", 7);

  const Read kept = readRib(
      "Translate 0 0 5\nTranslate 3 0 0\nCoordinateSystem \"q\"\nTranslate -3 0 0\n"
      "AttributeBegin\nTranslate 7 0 0\nScopedCoordinateSystem \"q\"\nAttributeEnd\n"
      "WorldBegin\nCoordSysTransform \"q\"\nSphere 1 -1 1 360\nWorldEnd");
  expectMessage(kept, "RIB-COORDSYS", 7);
  EXPECT_EQ(kept.primitive().toWorld.matrices[0][3][0], 3) << "the scope's is not everybody's";

  const Read open = readRib(
      "AttributeBegin\nTranslate 3 0 0\nScopedCoordinateSystem \"q\"\nIdentity\n"
      "Translate 0 0 5\nWorldBegin\nCoordSysTransform \"q\"\nSphere 1 -1 1 360\nWorldEnd\n"
      "CoordSysTransform \"q\"\nAttributeEnd\n");
  expectClean(open);
  const auto isThere = [](const Transform& t) { return t.matrices[0][3][0] == 3 && t.matrices[0][3][2] == -5; };
  EXPECT_TRUE(isThere(open.primitive().toWorld));
  EXPECT_TRUE(isThere(open.primitive().attributes->coordinateSystems->at("q")));
  EXPECT_TRUE(isThere(open.world().coordinateSystems.at("q"))) << "for patterns";
}

// Lights of the camera, and what waits for lights, keep the systems of their scope and their places.
TEST(Transforms, LightsBeforeTheWorldTakeTheirScopeAlong) {
  const Read r = readRib(
      "Translate 0 0 5\nAttributeBegin\nTranslate 3 0 0\nScopedCoordinateSystem \"q\"\n"
      "LightFilter \"PxrBlockerLightFilter\" \"f\" \"string coordsys\" [\"q\"]\n"
      "Light \"PxrSphereLight\" \"l\"\nAttributeEnd\nTranslate 2 0 0\n"
      "LightFilter \"PxrBlockerLightFilter\" \"g\"\nTranslate -2 0 0\nWorldBegin\n"
      "Light \"PxrSphereLight\" \"m\"\nSphere 1 -1 1 360\nWorldEnd");
  expectClean(r);
  ASSERT_EQ(r.world().lights.size(), 2u);
  const Light &l = r.world().lights[0], &m = r.world().lights[1];
  EXPECT_EQ(l.toWorld.matrices[0][3][0], 3);
  EXPECT_EQ(l.toWorld.matrices[0][3][2], 0);
  EXPECT_EQ(l.attributes->coordinateSystems->at("q").matrices[0], l.toWorld.matrices[0]);
  EXPECT_EQ(r.world().coordinateSystems.at("q").matrices[0], l.toWorld.matrices[0]) << "its patterns ask by name";
  ASSERT_EQ(m.filterToWorld.size(), 1u);
  EXPECT_EQ(m.filterToWorld[0].matrices[0][3][0], 2);
  EXPECT_EQ(m.filterToWorld[0].matrices[0][3][2], 0);
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

}  // namespace
}  // namespace kinora::rib
