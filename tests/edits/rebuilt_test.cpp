// Proves: update() makes what an edit reached and nothing else, as Statistics counts it. That the picture is right is
// same_picture_test.cpp's. Misses: time; kinora-bench edits measures that.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <stdexcept>

#include "plugin/registry.h"
#include "render/renderer.h"
#include "tests/edits/edited_scene.h"

namespace kinora::tests {
namespace {

using render::Rebuilt;
using namespace scene;

std::string shown(const Rebuilt& r) {
  std::string s;
  const std::pair<const char*, uint64_t> all[] = {
      {"textures", r.textures},   {"cameras", r.cameras},    {"integrators", r.integrators}, {"plans", r.plans},
      {"flattened", r.flattened}, {"meshes", r.meshes},      {"materials", r.materials},     {"worlds", r.worlds},
      {"lights", r.lights},       {"lightSets", r.lightSets}};
  for (const auto& [name, count] : all)
    if (count) s += std::string(name) + " " + std::to_string(count) + " ";
  return s;
}

class Rebuild : public ::testing::Test {
 protected:
  void SetUp() override {
    settings_.threads = 1;
    settings_.texturePath = settings_.shaderPath = {folder_.path()};
    r_ = std::make_unique<render::Renderer>(registry_, diagnostics_, settings_);
    ASSERT_TRUE(r_->load(sceneWithEverything(folder_, diagnostics_))) << said_;
  }
  // What an edit made anew.
  std::string after(const std::function<void(Scene&)>& edit) {
    const Rebuilt a = r_->statistics().rebuilt;
    parts_ = r_->statistics().bvhPartsBuilt;
    tops_ = r_->statistics().bvhBuilds;
    edit(r_->scene());
    EXPECT_TRUE(r_->update()) << said_;
    const Rebuilt b = r_->statistics().rebuilt;
    parts_ = r_->statistics().bvhPartsBuilt - parts_;
    tops_ = r_->statistics().bvhBuilds - tops_;
    return shown({b.textures - a.textures, b.cameras - a.cameras, b.integrators - a.integrators, b.plans - a.plans,
                  b.flattened - a.flattened, b.meshes - a.meshes, b.materials - a.materials, b.worlds - a.worlds,
                  b.lights - a.lights, b.lightSets - a.lightSets});
  }
  PrimitivePtr& named(const std::string& name) {
    for (PrimitivePtr& p : r_->scene().primitives)
      if (p->givenName() == name) return p;
    throw std::runtime_error(name);
  }
  // Another primitive in its place, past the scene's functions.
  void change(const std::string& name, const std::function<void(Primitive&)>& edit) {
    auto copy = std::make_shared<Primitive>(*named(name));
    edit(*copy);
    named(name) = std::move(copy);
  }
  void changeAttributes(const std::string& name, const std::function<void(Attributes&)>& edit) {
    change(name, [&](Primitive& p) {
      auto copy = std::make_shared<Attributes>(*p.attributes);
      edit(*copy);
      p.attributes = std::move(copy);
    });
  }
  static Parameter number(const char* name, float value) {
    Parameter p;
    p.name = name;
    p.floats = {value};
    return p;
  }
  static NodePtr with(const NodePtr& node, Parameter p) {
    auto copy = std::make_shared<Node>(*node);
    copy->params.set(std::move(p));
    return copy;
  }
  static Transform moved(const Transform& t, double x) {
    return concat(t, Transform::fixed(Matrix().setTranslation(Imath::V3d(x, 0, 0))));
  }

  SceneFolder folder_;
  Registry registry_;
  std::string said_;
  Diagnostics diagnostics_{[this](const std::string& line, Severity) { said_ += line + "\n"; }};
  render::Settings settings_;
  std::unique_ptr<render::Renderer> r_;
  uint64_t parts_ = 0, tops_ = 0;
};

TEST_F(Rebuild, NothingWithoutAnEdit) {
  EXPECT_EQ(after([](Scene&) {}), "");
  // what says the same in other words is none: another copy, other ids of edits, other places in files
  EXPECT_EQ(after([](Scene& s) {
              const Light l = s.lights[0];
              ASSERT_TRUE(s.setLight(l.id, l));
              for (PrimitivePtr& p : s.primitives) p = std::make_shared<Primitive>(*p);
            }),
            "flattened 1 worlds 1 ");
  EXPECT_EQ(parts_, 0u);
  EXPECT_EQ(tops_, 0u);
}

TEST_F(Rebuild, CameraAndLens) {
  // surfaces that were diced for the camera are diced again; the ball is the same ball from a little aside
  const auto aside = [](Scene& s) { s.cameras[0].worldToCamera = moved(s.cameras[0].worldToCamera, 1e-4); };
  EXPECT_EQ(after(aside), "cameras 1 ");
  EXPECT_EQ(after([](Scene& s) { s.cameras[0].depthOfField = {2, 0.5f, 5}; }), "cameras 1 ");
  EXPECT_EQ(after([](Scene& s) { s.cropWindow = {0, 0.5f, 0, 0.5f}; }), "cameras 1 plans 1 ");
}

TEST_F(Rebuild, Frame) {
  EXPECT_EQ(after([](Scene& s) { s.pixelFilterWidth = {3, 3}; }), "plans 1 ");
  EXPECT_EQ(after([](Scene& s) { s.exposure = {2, 1}; }), "plans 1 ");
  EXPECT_EQ(after([](Scene& s) {
              Parameter p;
              p.name = "maxIndirectBounces";
              p.type = ValueType::Int;
              p.ints = {1};
              s.integrator = with(s.integrator, p);
            }),
            "integrators 1 plans 1 ");
}

// Light paths are told apart by a frame's channels, so that materials and groups of lights are bound anew.
TEST_F(Rebuild, Channels) {
  EXPECT_EQ(after([](Scene& s) { s.displays[0].mode = "Ci,a"; }), "plans 1 materials 9 lightSets 1 ");
}

TEST_F(Rebuild, Lights) {
  EXPECT_EQ(after([](Scene& s) { s.lights[0].node = with(s.lights[0].node, number("intensity", 3)); }),
            "lights 1 lightSets 1 ");
  EXPECT_EQ(after([](Scene& s) { s.lights[1].toWorld = moved(s.lights[1].toWorld, 0.5); }), "lights 1 lightSets 1 ");
  EXPECT_EQ(after([](Scene& s) { s.lights.pop_back(); }), "lightSets 1 ");
  // what its attributes say does not reach the light itself
  EXPECT_EQ(after([](Scene& s) {
              auto a = std::make_shared<Attributes>(*s.lights[0].attributes);
              Parameter p;
              p.name = "visibility:camera";
              p.type = ValueType::Int;
              p.ints = {0};
              a->named.set(p);
              s.lights[0].attributes = a;
            }),
            "lightSets 1 ");
}

TEST_F(Rebuild, Material) {
  EXPECT_EQ(after([this](Scene&) {
              changeAttributes("hair", [](Attributes& a) {
                auto n = std::make_shared<Network>(*a.bxdf);
                Parameter p = number("diffuseColor", 0);
                p.type = ValueType::Color;
                p.floats = {0.1f, 0.2f, 0.3f};
                n->terminal = with(n->terminal, p);
                a.bxdf = n;
              });
            }),
            "flattened 1 materials 9 worlds 1 ");
  EXPECT_EQ(parts_, 0u);
  EXPECT_EQ(tops_, 0u);
}

TEST_F(Rebuild, Objects) {
  // its own fields: one mesh
  EXPECT_EQ(after([this](Scene&) { change("floor", [](Primitive& p) { p.primvars.find("P")->floats[1] += 0.2f; }); }),
            "flattened 1 meshes 1 worlds 1 ");
  EXPECT_EQ(parts_, 1u);
  // what nothing but shading asks for: none
  EXPECT_EQ(after([this](Scene&) {
              changeAttributes("floor", [](Attributes& a) { a.named.set(number("user:wear", 0.5f)); });
            }),
            "flattened 1 worlds 1 ");
  EXPECT_EQ(parts_ + tops_, 0u);
  // one that moves with the shutter is placed, and stays as it is
  EXPECT_EQ(after([](Scene& s) { s.instances.edit(0, [](Instance& i) { i.toWorld = moved(i.toWorld, 0.2); }); }),
            "flattened 1 worlds 1 ");
  EXPECT_EQ(parts_, 0u);
  EXPECT_EQ(tops_, 1u);
}

TEST_F(Rebuild, CoordinateSystemsReachShadersAndFiltersOfLights) {
  EXPECT_EQ(after([](Scene& s) { s.coordinateSystems["mark"] = moved(Transform(), 0.5); }), "lights 1 lightSets 1 ");
}

TEST_F(Rebuild, DisplacementsMakeTheirMeshesAgain) {
  const auto displace = [this](const char* name, float value) {
    return after([&](Scene&) {
      changeAttributes("relief", [&](Attributes& a) {
        auto n = std::make_shared<Network>(*a.displacement);
        n->terminal = with(n->terminal, number(name, value));
        a.displacement = n;
      });
    });
  };
  EXPECT_EQ(displace("dispAmount", 0.1f), "flattened 1 meshes 1 worlds 1 ");
  EXPECT_EQ(parts_, 1u);
  EXPECT_EQ(displace("dispAmount", 0.1f), "flattened 1 worlds 1 ");
  // what shades it alone, and what moves others
  EXPECT_EQ(
      after([this](Scene&) { changeAttributes("relief", [](Attributes& a) { a.bxdf = nullptr; }); }).find("meshes"),
      std::string::npos);
  EXPECT_EQ(after([this](Scene&) { changeAttributes("relief", [](Attributes& a) { a.displacement = nullptr; }); }),
            "flattened 1 meshes 1 worlds 1 ");
}

TEST_F(Rebuild, FilesThatHaveChanged) {
  EXPECT_EQ(after([this](Scene&) {
              folder_.write("stripe.osl",
                            "shader stripe(float at = .5, output color resultRGB = 0) { resultRGB = v; }");
            }),
            "materials 9 ");
  const std::string all = after([this](Scene&) { folder_.picture("brick.png", 0.9f); });
  EXPECT_EQ(all, "") << "a file that nobody reads";
  // the relief is made of it too
  EXPECT_EQ(after([this](Scene&) { folder_.picture("wood.png", 0.9f); }),
            "textures 1 cameras 1 integrators 1 plans 1 meshes 1 materials 9 worlds 1 lights 4 lightSets 1 ");
}

}  // namespace
}  // namespace kinora::tests
