// Parameter lists, transforms over time, and edits of the scene description.
#include "scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kinora::scene {
namespace {

Parameter floatParameter(std::string name, std::vector<float> v) {
  Parameter p;
  p.name = std::move(name);
  p.floats = std::move(v);
  return p;
}
Parameter intParameter(std::string name, std::vector<int> v) {
  Parameter p;
  p.name = std::move(name);
  p.type = ValueType::Int;
  p.ints = std::move(v);
  return p;
}

TEST(ParameterList, SetFindEraseAndConversions) {
  ParameterList list;
  list.set(floatParameter("a", {1.5f, 2}));
  list.set(intParameter("b", {7, 8}));
  list.set(floatParameter("a", {2.75f}));
  Parameter s;
  s.name = "s";
  s.type = ValueType::String;
  s.strings = {"x"};
  list.set(s);
  s.name = "r";
  s.isReference = true;
  list.set(s);
  EXPECT_EQ(list.size(), 4u);
  EXPECT_EQ(list.getFloat("a", 0), 2.75f);
  EXPECT_EQ(list.getInt("a", 0), 2);
  EXPECT_EQ(list.getFloat("b", 0), 7);
  EXPECT_EQ(list.getInt("b", 0), 7);
  EXPECT_EQ(list.getFloats("b"), (std::vector<float>{7, 8}));
  EXPECT_EQ(list.getString("s", "y"), "x");
  EXPECT_EQ(list.getString("r", "y"), "y") << "a reference is no value";
  EXPECT_EQ(list.getFloat("s", 3), 3);
  EXPECT_EQ(list.getInt("none", 4), 4);
  list.set(floatParameter("huge", {1e30f, 0}));
  EXPECT_EQ(list.getInt("huge", 0), INT32_MAX);
  list.set(floatParameter("nan", {NAN}));
  EXPECT_EQ(list.getInt("nan", 5), 5);
  EXPECT_TRUE(list.erase("a"));
  EXPECT_FALSE(list.erase("a"));
  EXPECT_EQ(std::as_const(list).begin()->name, "b");
}

TEST(ParameterList, CopiesShareUntilEdited) {
  ParameterList a;
  a.set(floatParameter("x", {1}));
  ParameterList b = a;
  EXPECT_EQ(std::as_const(a).find("x"), std::as_const(b).find("x"));
  b.find("x")->floats[0] = 2;
  EXPECT_EQ(a.getFloat("x", 0), 1);
  EXPECT_EQ(b.getFloat("x", 0), 2);
  ParameterList c = a;
  for (Parameter& p : c) p.floats[0] = 3;
  EXPECT_EQ(a.getFloat("x", 0), 1);
  EXPECT_EQ(c.getFloat("x", 0), 3);
}

TEST(ValueTypes, NamesAndComponents) {
  EXPECT_EQ(componentsOf(ValueType::Matrix), 16);
  EXPECT_EQ(componentsOf(ValueType::HPoint), 4);
  EXPECT_EQ(componentsOf(ValueType::String), 1);
  EXPECT_STREQ(nameOf(ValueType::Struct), "struct");
  EXPECT_STREQ(nameOf(ValueType::MPoint), "mpoint");
  EXPECT_STREQ(nameOf(StorageClass::FaceVertex), "facevertex");
  EXPECT_TRUE(isFloatBased(ValueType::MPoint) && isFloatBased(ValueType::Float));
  EXPECT_FALSE(isFloatBased(ValueType::Int) || isFloatBased(ValueType::String) || isFloatBased(ValueType::Bxdf));
}

Matrix translation(double x, double y, double z) {
  Matrix m;
  m.setTranslation(Imath::V3d(x, y, z));
  return m;
}

TEST(Transform, LinearBetweenKeysAndHeldOutside) {
  Transform t;
  t.times = {0, 1, 3};
  t.matrices = {translation(0, 0, 0), translation(1, 0, 0), translation(5, 0, 0)};
  EXPECT_EQ(t.at(-1)[3][0], 0);
  EXPECT_EQ(t.at(0.5)[3][0], 0.5);
  EXPECT_EQ(t.at(2)[3][0], 3);
  EXPECT_EQ(t.at(9)[3][0], 5);
  EXPECT_EQ(t.at(NAN)[3][0], 5) << "no time: held, not a crash";
  EXPECT_EQ(t.inverse().at(3)[3][0], -5);
  EXPECT_TRUE(Transform::fixed(translation(1, 2, 3)).isStatic());
}

// Of motions in one another the keys are bounded; what is between them stays where it is.
TEST(Transforms, KeysOfNestedMotionsAreBounded) {
  Transform a, b;
  a.times.clear(), a.matrices.clear(), b.times.clear(), b.matrices.clear();
  for (int i = 0; i < 900; ++i) {
    a.times.push_back(i / 900.0);
    a.matrices.push_back(translation(std::sin(i * 0.01), 0, 0));
    b.times.push_back((i + 0.5) / 900.0);
    b.matrices.push_back(translation(0, i * 0.001, 0));
  }
  const Transform c = concat(a, b);
  EXPECT_EQ(c.matrices.size(), Transform::kMostKeys);
  EXPECT_EQ(c.times.size(), Transform::kMostKeys);
  EXPECT_EQ(c.times.front(), 0);
  EXPECT_EQ(c.times.back(), 899.5 / 900);
  for (size_t k = 1; k < c.times.size(); ++k) ASSERT_LT(c.times[k - 1], c.times[k]);
  for (double t = 0; t < 1; t += 0.013) {
    const Matrix exact = a.at(t) * b.at(t), m = c.at(t);
    for (int x = 0; x < 3; ++x) EXPECT_NEAR(m[3][x], exact[3][x], 1e-3) << t;
  }
  Transform d = c;
  for (int i = 0; i < 5; ++i) d = concat(a, d);
  EXPECT_EQ(d.matrices.size(), Transform::kMostKeys);
}

TEST(Transform, ConcatIsTheProductAtAllTimes) {
  Transform a, b;
  a.times = {0, 0.4, 1};
  b.times = {0.2, 0.9};
  for (double x : {0.0, 2.0, -1.0}) a.matrices.push_back(translation(x, 0, 0));
  a.matrices.erase(a.matrices.begin());
  Matrix r;
  r.setAxisAngle(Imath::V3d(0, 0, 1), 0.6);
  Matrix s;
  s.setScale(Imath::V3d(3, 1, 1));
  b.matrices = {r, s};
  const Transform c = concat(a, b);
  for (size_t i = 1; i < c.times.size(); ++i) EXPECT_LT(c.times[i - 1], c.times[i]);
  for (double t = -0.1; t < 1.1; t += 0.013) {
    const Matrix expected = a.at(t) * b.at(t), got = c.at(t);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) EXPECT_NEAR(got[i][j], expected[i][j], 2e-3) << t;
  }
  EXPECT_TRUE(concat(Transform::fixed(translation(1, 0, 0)), Transform::fixed(s)).isStatic());
  EXPECT_EQ(concat(Transform::fixed(translation(1, 0, 0)), Transform::fixed(s)).matrices[0][3][0], 3)
      << "the first acts first";
}

TEST(Scene, EditsMakeNewObjectsOfWhatTheyTouch) {
  Scene s;
  const uint32_t a = s.add(Primitive()), b = s.add(Primitive()), l = s.add(Light()), i = s.add(Instance());
  EXPECT_EQ(a, 1u);
  EXPECT_EQ(i, 4u);
  const auto untouched = s.primitives[1];
  ASSERT_TRUE(s.setPrimitiveTransform(a, Transform::fixed(translation(1, 0, 0))));
  EXPECT_EQ(s.primitives[0]->toWorld.matrices[0][3][0], 1);
  EXPECT_EQ(s.primitives[1], untouched);
  EXPECT_TRUE(s.setPrimitiveAttributes(b, std::make_shared<Attributes>()));
  EXPECT_NE(s.primitives[1], untouched) << "others may still hold the old one";
  EXPECT_TRUE(s.replacePrimitive(a, Primitive()));
  EXPECT_EQ(s.primitives[0]->id, a);
  EXPECT_TRUE(s.setInstanceTransform(i, Transform()));
  EXPECT_TRUE(s.setLight(l, Light()));
  EXPECT_EQ(s.lights[0].id, l);
  EXPECT_FALSE(s.setCamera(0, Camera()));
  s.cameras.resize(1);
  EXPECT_TRUE(s.setCamera(0, Camera()));
  EXPECT_TRUE(s.removePrimitive(b));
  const auto last = s.primitives;
  EXPECT_FALSE(s.removePrimitive(b));
  EXPECT_FALSE(s.setPrimitiveTransform(b, Transform()));
  EXPECT_FALSE(s.setInstanceTransform(a, Transform()));
  EXPECT_FALSE(s.setLight(99, Light()));
  EXPECT_EQ(s.primitives, last);
}

TEST(Scene, NamesAndStatistics) {
  Scene s;
  Primitive p;
  PolygonMesh mesh;
  mesh.verticesPerLoop = {3, 3};
  mesh.vertices = {0, 1, 2, 2, 1, 3};
  p.shape = mesh;
  p.pos = {FileName("f.rib"), 12};
  EXPECT_EQ(p.name(), "PointsPolygons at f.rib:12");
  auto a = std::make_shared<Attributes>();
  Parameter n;
  n.name = "identifier:name";
  n.type = ValueType::String;
  n.strings = {"cube"};
  a->named.set(n);
  p.attributes = a;
  EXPECT_EQ(p.name(), "cube");
  const size_t empty = s.bytes();
  p.primvars.set(floatParameter("P", std::vector<float>(30000)));
  s.add(p);
  const SceneStatistics st = s.statistics();
  EXPECT_EQ(st.primitives, 1u);
  EXPECT_EQ(st.faces, 2u);
  EXPECT_GT(s.bytes(), empty + 120000);
  EXPECT_LT(s.bytes(), empty + 123000);
  EXPECT_EQ(a->uBasis[0], -1);
  EXPECT_EQ(a->vStep, 3);
}

}  // namespace
}  // namespace kinora::scene
