// Edits rebuild what they touch and nothing else, and the picture after an edit is that of a fresh load, bit for bit.
// Polygons only where that is compared: surfaces diced for the camera keep their dicing when the camera moves.
#include "tests/probes/probe_support.h"

namespace kinora::probes {
namespace {

// A square of 120 x 120 quads in xz: 28,800 triangles, large enough for a part of its own.
std::string grid() {
  constexpr int kQuads = 120;
  std::string counts, ids, points;
  for (int j = 0; j <= kQuads; ++j)
    for (int i = 0; i <= kQuads; ++i) {
      const double x = 2.0 * i / kQuads - 1, z = 2.0 * j / kQuads - 1;
      points += std::to_string(x) + " " + std::to_string(0.05 * std::sin(9 * x) * std::cos(7 * z)) + " " +
                std::to_string(z) + " ";
      if (i == kQuads || j == kQuads) continue;
      const int a = j * (kQuads + 1) + i;
      counts += "4 ";
      for (int v : {a, a + 1, a + kQuads + 2, a + kQuads + 1}) ids += std::to_string(v) + " ";
    }
  return "PointsPolygons [" + counts + "] [" + ids + "] \"vertex point P\" [" + points + "]";
}

const char* const kBlock = R"(PointsPolygons [4 4 4 4 4 4] [0 1 2 3  7 6 5 4  0 4 5 1  1 5 6 2  2 6 7 3  3 7 4 0]
  "vertex point P" [-0.2 0 -0.2  0.2 0 -0.2  0.2 0 0.2  -0.2 0 0.2  -0.2 0.4 -0.2  0.2 0.4 -0.2  0.2 0.4 0.2  -0.2 0.4 0.2])";

std::string sceneText() {
  return std::string(R"(
Hider "raytrace" "int maxsamples" [4]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [2]
Display "probe.exr" "openexr" "Ci,a,z,Nn"
Format 48 32 1
Projection "perspective" "fov" [40]
Rotate -20 1 0 0
Translate 0 -1.2 3
WorldBegin
  AttributeBegin
    Translate 0 2.5 0
    Rotate 90 1 0 0
    Light "PxrRectLight" "lamp" "float intensity" [8]
  AttributeEnd
  Bxdf "PxrDiffuse" "grey" "color diffuseColor" [0.6 0.6 0.7]
  ObjectBegin "tower"
    Bxdf "PxrDiffuse" "red" "color diffuseColor" [0.7 0.2 0.2]
    )") + kBlock +
         R"(
  ObjectEnd
  AttributeBegin
    Attribute "identifier" "string name" ["ground"]
    )" + grid() +
         R"(
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["small"]
    Translate 0.5 0.1 -0.3
    )" + kBlock +
         R"(
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["mirrored"]
    Translate 0.1 0.3 0.6
    Scale -1 1.5 1
    )" + kBlock +
         R"(
  AttributeEnd
  AttributeBegin
    Translate -0.5 0.1 0.3
    ObjectInstance "tower"
  AttributeEnd
  AttributeBegin
    Translate -0.6 0.1 -0.5
    Rotate 30 0 1 0
    ObjectInstance "tower"
  AttributeEnd
WorldEnd
)";
}

scene::Transform moved(const scene::Transform& t, const Imath::V3d& by) {
  scene::Matrix m;
  m.setTranslation(by);
  return scene::concat(t, scene::Transform::fixed(m));
}

class Edits : public ::testing::Test {
 protected:
  void SetUp() override {
    settings.threads = 1;
    r = stage.load(sceneOf(sceneText(), stage.messages), settings);
    ASSERT_EQ(r->scene().primitives.size(), 3u);
    ASSERT_EQ(r->scene().instances.size(), 2u);
    ASSERT_EQ(r->renderFilm(), render::Outcome::Complete);
    before = stateOf(r->film());
    parts = r->statistics().bvhPartsBuilt;
    builds = r->statistics().bvhBuilds;
    // the ground, a batch of small blocks, the prototype; one top level
    EXPECT_EQ(parts, 3u);
    EXPECT_EQ(builds, 1u);
  }
  uint32_t idOf(const std::string& name) {
    for (const auto& p : r->scene().primitives)
      if (p->name() == name) return p->id;
    ADD_FAILURE() << name;
    return 0;
  }
  // What update() built, and that the picture changed to what a fresh load of the edited scene gives.
  void expectBuilt(uint64_t partsBuilt, uint64_t topLevels) {
    ASSERT_TRUE(r->update()) << stage.said;
    EXPECT_EQ(r->statistics().bvhPartsBuilt - parts, partsBuilt);
    EXPECT_EQ(r->statistics().bvhBuilds - builds, topLevels);
    parts = r->statistics().bvhPartsBuilt;
    builds = r->statistics().bvhBuilds;
    ASSERT_EQ(r->renderFilm(), render::Outcome::Complete);
    const std::vector<int64_t> edited = stateOf(r->film());
    EXPECT_NE(edited, before);
    before = edited;
    const auto fresh = stage.load(r->scene(), settings);
    ASSERT_EQ(fresh->renderFilm(), render::Outcome::Complete);
    EXPECT_EQ(edited, stateOf(fresh->film()));
  }
  Workshop stage;
  render::Settings settings;
  std::unique_ptr<render::Renderer> r;
  std::vector<int64_t> before;
  uint64_t parts = 0, builds = 0;
};

TEST_F(Edits, LightRebuildsNoBvh) {
  scene::Light l = r->scene().lights.at(0);
  l.toWorld = moved(l.toWorld, {0.4, -0.3, 0});
  ASSERT_TRUE(r->scene().setLight(l.id, l));
  expectBuilt(0, 0);
}

TEST_F(Edits, CameraRebuildsNoBvh) {
  scene::Camera c = r->scene().cameras.at(0);
  c.worldToCamera = moved(c.worldToCamera, {0.2, 0, 0.4});
  ASSERT_TRUE(r->scene().setCamera(0, c));
  expectBuilt(0, 0);
}

TEST_F(Edits, LargeObjectRebuildsItsOwnPart) {
  const uint32_t id = idOf("ground");
  ASSERT_TRUE(r->scene().setPrimitiveTransform(id, moved(r->scene().primitives[0]->toWorld, {0.1, -0.1, 0})));
  expectBuilt(1, 1);
}

TEST_F(Edits, SmallObjectRebuildsItsBatch) {
  const uint32_t id = idOf("small");
  ASSERT_TRUE(r->scene().setPrimitiveTransform(id, moved(r->scene().primitives[1]->toWorld, {0.2, 0.3, 0})));
  expectBuilt(1, 1);
}

TEST_F(Edits, InstanceRebuildsTheTopLevelOnly) {
  const scene::Instance i = r->scene().instances[0];
  ASSERT_TRUE(r->scene().setInstanceTransform(i.id, moved(i.toWorld, {0, 0.4, 0})));
  expectBuilt(0, 1);
}

TEST_F(Edits, RemovedAndAddedObjects) {
  ASSERT_TRUE(r->scene().removePrimitive(idOf("mirrored")));
  expectBuilt(1, 1);
  scene::Primitive p = *r->scene().primitives[1];
  p.toWorld = moved(p.toWorld, {-0.7, 0.2, -0.2});
  r->scene().add(p);
  expectBuilt(1, 1);
}

TEST_F(Edits, ManyInARow) {
  for (int step = 0; step < 3; ++step) {
    ASSERT_TRUE(
        r->scene().setPrimitiveTransform(idOf("mirrored"), moved(r->scene().primitives[2]->toWorld, {-0.1, 0.1, 0})));
    expectBuilt(1, 1);
    scene::Camera c = r->scene().cameras.at(0);
    c.worldToCamera = moved(c.worldToCamera, {0, -0.1, 0});
    ASSERT_TRUE(r->scene().setCamera(0, c));
    expectBuilt(0, 0);
  }
}

TEST_F(Edits, OpenedShutterMovesWhatWasBaked) {
  // a transform that moves is baked while the shutter is closed, and no more when it opens
  scene::Transform t = r->scene().primitives[1]->toWorld;
  t.matrices.push_back(moved(t, {0, 0.5, 0}).matrices[0]);
  t.times = {0, 1};
  ASSERT_TRUE(r->scene().setPrimitiveTransform(idOf("small"), t));
  ASSERT_TRUE(r->update());
  ASSERT_EQ(r->renderFilm(), render::Outcome::Complete);
  parts = r->statistics().bvhPartsBuilt;
  builds = r->statistics().bvhBuilds;
  before = stateOf(r->film());
  scene::Camera c = r->scene().cameras.at(0);
  c.shutter = {0, 1};
  ASSERT_TRUE(r->scene().setCamera(0, c));
  expectBuilt(2, 1);  // the batch without it, and its own
}

TEST_F(Edits, NoEditBuildsNothing) {
  ASSERT_TRUE(r->update());
  EXPECT_EQ(r->statistics().bvhPartsBuilt, parts);
  EXPECT_EQ(r->statistics().bvhBuilds, builds);
  ASSERT_EQ(r->renderFilm(), render::Outcome::Complete);
  EXPECT_EQ(stateOf(r->film()), before);
}

}  // namespace
}  // namespace kinora::probes
