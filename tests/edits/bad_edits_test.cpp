// Proves: edits that leave the description in a state that no file can say (objects that are gone, empty places,
// transforms that are none) and edits after which nothing can be rendered end in a message and a defined result, and
// the next edit is rendered as if they had not been.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>

#include "film/film.h"
#include "plugin/registry.h"
#include "render/renderer.h"
#include "tests/edits/edited_scene.h"
#include "tests/support/render_scene.h"

namespace kinora::tests {
namespace {

using namespace scene;

class BadEdits : public ::testing::Test {
 protected:
  void SetUp() override {
    settings_.threads = 1;
    settings_.texturePath = settings_.shaderPath = {folder_.path()};
    base_ = sceneWithEverything(folder_, diagnostics_);
    r_ = std::make_unique<render::Renderer>(registry_, diagnostics_, settings_);
    ASSERT_TRUE(r_->load(base_)) << said_;
  }
  static std::vector<int64_t> picture(render::Renderer& r) {
    return r.renderFilm() == render::Outcome::Complete ? stateOf(r.film()) : std::vector<int64_t>();
  }
  std::vector<int64_t> fresh(const Scene& s) {
    render::Renderer r(registry_, diagnostics_, settings_);
    return r.load(s) ? picture(r) : std::vector<int64_t>();
  }
  // The code is told, and the picture is that of `instead`.
  void expect(const char* code, const std::function<void(Scene&)>& edit, const std::function<void(Scene&)>& instead) {
    r_->scene() = base_;
    edit(r_->scene());
    const auto told = diagnostics_.count(code);  // each code is shown once, and counted
    ASSERT_TRUE(r_->update()) << said_;
    EXPECT_GT(diagnostics_.count(code), told) << code;
    Scene wanted = base_;
    instead(wanted);
    EXPECT_TRUE(picture(*r_) == fresh(wanted)) << code;
    r_->scene() = base_;
  }

  SceneFolder folder_;
  Registry registry_;
  std::string said_;
  Diagnostics diagnostics_{[this](const std::string& line, Severity) { said_ += line + "\n"; }};
  render::Settings settings_;
  Scene base_;
  std::unique_ptr<render::Renderer> r_;
};

TEST_F(BadEdits, ThingsThatAreGone) {
  Scene& s = r_->scene();
  const uint32_t id = s.primitives[2]->id, lamp = s.lights[0].id, placed = s.instances[0].id;
  ASSERT_TRUE(s.removePrimitive(id));
  s.lights.erase(s.lights.begin());
  s.instances.erase(0);
  const auto left = s.primitives;
  EXPECT_FALSE(s.removePrimitive(id));
  EXPECT_FALSE(s.setPrimitiveTransform(id, {}));
  EXPECT_FALSE(s.setPrimitiveAttributes(id, nullptr));
  EXPECT_FALSE(s.replacePrimitive(id, Primitive()));
  EXPECT_FALSE(s.setLight(lamp, Light()));
  EXPECT_FALSE(s.setInstanceTransform(placed, {}));
  EXPECT_FALSE(s.setCamera(7, Camera()));
  EXPECT_EQ(s.primitives, left);
  ASSERT_TRUE(r_->update());
  EXPECT_TRUE(picture(*r_) == fresh(r_->scene()));
}

TEST_F(BadEdits, AnInstanceOfAnObjectThatIsGone) {
  const auto gone = [](Scene& s) { s.prototypes.pop_back(); };
  expect("RENDER-INSTANCE-GONE", gone, [](Scene& s) {
    const auto last = uint32_t(s.prototypes.size() - 1);
    s.instances.eraseIf([&](const Instance& i) { return i.prototype == last; });
    s.prototypes.pop_back();
  });
  expect(
      "RENDER-INSTANCE-GONE", [](Scene& s) { s.instances.edit(0, [](Instance& i) { i.prototype = ~0u; }); },
      [](Scene& s) { s.instances.erase(0); });
}

TEST_F(BadEdits, EmptyPlaces) {
  expect(
      "EDIT-EMPTY", [](Scene& s) { s.primitives[3].reset(); },
      [](Scene& s) { s.primitives.erase(s.primitives.begin() + 3); });
  expect(
      "EDIT-EMPTY", [](Scene& s) { s.prototypes[0].primitives[0].reset(); },
      [](Scene& s) { s.prototypes[0].primitives.erase(s.prototypes[0].primitives.begin()); });
  expect(
      "EDIT-EMPTY", [](Scene& s) { s.sampleFilters.push_back(nullptr); }, [](Scene&) {});
  expect(
      "EDIT-EMPTY", [](Scene& s) { s.lights[1].filters.push_back(nullptr); }, [](Scene&) {});
  const auto withPatterns = [](bool withEmpty) {
    return [=](Scene& s) {
      auto p = std::make_shared<Primitive>(*s.primitives[0]);
      auto a = std::make_shared<Attributes>(*p->attributes);
      auto n = std::make_shared<Network>(*a->bxdf);
      if (withEmpty) n->patterns.insert(n->patterns.begin(), nullptr);
      a->bxdf = n;
      p->attributes = a;
      s.primitives[0] = p;
    };
  };
  expect("EDIT-EMPTY", withPatterns(true), withPatterns(false));
}

TEST_F(BadEdits, TransformsThatAreNone) {
  const auto withTransform = [](std::vector<double> times, size_t matrices) {
    return [=](Scene& s) {
      auto p = std::make_shared<Primitive>(*s.primitives[4]);
      const Matrix first = p->toWorld.matrices[0];
      p->toWorld.times = times;
      p->toWorld.matrices.assign(matrices, first);
      s.primitives[4] = p;
    };
  };
  const auto still = [](Scene& s) {
    auto p = std::make_shared<Primitive>(*s.primitives[4]);
    p->toWorld = Transform::fixed(p->toWorld.matrices[0]);
    s.primitives[4] = p;
  };
  expect("EDIT-TRANSFORM", withTransform({0}, 2), still);
  expect("EDIT-TRANSFORM", withTransform({}, 3), still);
  expect("EDIT-TRANSFORM", withTransform({1, 0}, 2), still);
  expect("EDIT-TRANSFORM", withTransform({0, 1}, 0), [](Scene& s) {
    auto p = std::make_shared<Primitive>(*s.primitives[4]);
    p->toWorld = Transform();
    s.primitives[4] = p;
  });
  expect(
      "EDIT-TRANSFORM", [](Scene& s) { s.lights[0].toWorld.matrices.clear(); },
      [](Scene& s) { s.lights[0].toWorld = Transform(); });
  expect(
      "EDIT-TRANSFORM", [](Scene& s) { s.cameras[0].worldToCamera.matrices.clear(); },
      [](Scene& s) { s.cameras[0].worldToCamera = Transform(); });
}

TEST_F(BadEdits, NumbersThatAreNone) {
  // whatever it is, it is the same as for a fresh load
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::function<void(Scene&)> kEdits[] = {
      [&](Scene& s) { s.cameras[0].worldToCamera.matrices[0][3][0] = double(nan); },
      [&](Scene& s) { s.lights[0].toWorld.matrices[0][0][0] = double(nan); },
      [&](Scene& s) { s.instances.edit(0, [](Instance& i) { i.toWorld.matrices[0] = Matrix(0.0); }); },
      [&](Scene& s) {
        s.resolution = {-5, 0};
      },
      [&](Scene& s) {
        auto p = std::make_shared<Primitive>(*s.primitives[2]);
        p->primvars.find("P")->floats[0] = nan;
        s.primitives[2] = p;
      }};
  for (const auto& edit : kEdits) {
    r_->scene() = base_;
    edit(r_->scene());
    if (r_->scene().resolution[0] < 0) r_->scene().cropWindow = {0, 0.02f, 0, 0.02f};
    ASSERT_TRUE(r_->update()) << said_;
    EXPECT_TRUE(picture(*r_) == fresh(r_->scene()));
  }
}

TEST_F(BadEdits, WhereNothingIsLeftToRender) {
  const std::vector<int64_t> before = picture(*r_);
  r_->scene().cropWindow = {0.5f, 0.5f, 0, 1};
  EXPECT_FALSE(r_->update());
  EXPECT_NE(said_.find("RENDER-CROP"), std::string::npos) << said_;
  said_.clear();
  EXPECT_EQ(r_->renderFilm(), render::Outcome::BadScene);
  EXPECT_NE(said_.find("RENDER-NO-WORLD"), std::string::npos) << said_;
  EXPECT_FALSE(r_->replay(0, 0, 0, [](const std::string&) {}));
  // it is as if that had not been
  r_->scene() = base_;
  ASSERT_TRUE(r_->update());
  EXPECT_TRUE(picture(*r_) == before);
}

// The picture between an edit and its update() is that of before.
TEST_F(BadEdits, RenderedBeforeTheUpdate) {
  const std::vector<int64_t> before = picture(*r_);
  r_->scene().primitives.clear();
  r_->scene().prototypes.clear();
  r_->scene().lights.clear();
  render::Renderer again(registry_, diagnostics_, settings_);
  ASSERT_TRUE(again.load(base_));
  again.scene().primitives.clear();
  again.scene().instances.clear();
  again.scene().prototypes.clear();
  again.scene().lights.clear();
  EXPECT_TRUE(picture(again) == before);
}

}  // namespace
}  // namespace kinora::tests
