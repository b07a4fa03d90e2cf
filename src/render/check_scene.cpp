#include "render/check_scene.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>

namespace kinora::render {

namespace {

class Checker {
 public:
  explicit Checker(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  void check(scene::Scene& s) {
    checkPrimitives(s.primitives, "the scene");
    checkInstances(s.instances);
    for (scene::Prototype& p : s.prototypes) {
      checkPrimitives(p.primitives, "object '" + p.name + "'");
      checkInstances(p.instances);
      checkLights(p.lights);
    }
    checkLights(s.lights);
    checkLights(s.classicLights);
    for (scene::Camera& c : s.cameras) checkTransform(c.worldToCamera, "a camera", c.pos);
    for (auto& [name, t] : s.coordinateSystems) checkTransform(t, "coordinate system '" + name + "'", {});
    checkNodes(s.sampleFilters, "sample filters");
    checkNodes(s.displayFilters, "display filters");
  }

 private:
  // As many times as matrices, rising; what stands still needs none.
  static bool isWhole(const scene::Transform& t) {
    return t.matrices.size() == 1 || (!t.matrices.empty() && t.times.size() == t.matrices.size() &&
                                      std::is_sorted(t.times.begin(), t.times.end()));
  }
  void checkTransform(scene::Transform& t, const std::string& whose, const SourcePos& pos) {
    if (isWhole(t)) return;
    diagnostics_.warning("EDIT-TRANSFORM", pos,
                         "the transform of " + whose + " has " + std::to_string(t.matrices.size()) + " matrices at " +
                             std::to_string(t.times.size()) + " times, or times that do not rise",
                         t.matrices.empty() ? "the identity is used" : "its first matrix is used");
    t = t.matrices.empty() ? scene::Transform() : scene::Transform::fixed(t.matrices.front());
  }
  template <class T>
  void takeEmptyOnes(std::vector<std::shared_ptr<T>>& list, const std::string& where) {
    if (const size_t count = std::erase(list, nullptr); count > 0)
      diagnostics_.warning("EDIT-EMPTY", {}, std::to_string(count) + " empty places in " + where,
                           "they are taken out", "to remove a thing, erase it from its list");
  }
  void checkPrimitives(std::vector<scene::PrimitivePtr>& list, const std::string& where) {
    takeEmptyOnes(list, "the primitives of " + where);
    for (scene::PrimitivePtr& p : list) {
      if (!isWhole(p->toWorld)) {
        auto whole = std::make_shared<scene::Primitive>(*p);
        checkTransform(whole->toWorld, whole->name(), whole->pos);
        p = std::move(whole);
      }
      checkNetwork(p);
    }
  }
  void checkInstances(scene::InstanceList& list) {
    for (size_t k = 0; k < list.size(); ++k) {
      scene::Matrix still;
      if (!list.stillToWorld(k, still) && !isWhole(list.toWorldOf(k)))
        list.edit(k, [&](scene::Instance& i) { checkTransform(i.toWorld, "an instance", i.pos); });
      if (std::optional<scene::AttributesPtr> whole = repaired(list.attributesOf(k)))
        list.edit(k, [&](scene::Instance& i) { i.attributes = std::move(*whole); });
    }
  }
  void checkLights(std::vector<scene::Light>& list) {
    for (scene::Light& l : list) {
      checkTransform(l.toWorld, "a light", l.node ? l.node->pos : SourcePos());
      for (scene::Transform& t : l.filterToWorld) checkTransform(t, "a light's filter", {});
      checkNodes(l.filters, "a light's filters");
      checkNodes(l.patterns, "a light's patterns");
      if (l.geometry) checkTransform(l.geometry->toWorld, "a light's geometry", l.geometry->pos);
    }
  }
  void checkNodes(std::vector<scene::NodePtr>& list, const std::string& where) { takeEmptyOnes(list, where); }

  static bool hasEmptyOnes(const scene::NetworkPtr& n) {
    return n && std::find(n->patterns.begin(), n->patterns.end(), nullptr) != n->patterns.end();
  }
  // Nothing where they are as they should be. Most objects share the attributes of the one before.
  std::optional<scene::AttributesPtr> repaired(const scene::AttributesPtr& a) {
    if (!a || a.get() == lastGood_) return {};
    const auto isEmpty = [](const scene::NodePtr& n) { return !n; };
    const bool hasEmptyShaders = std::any_of(a->classicShaders.begin(), a->classicShaders.end(), isEmpty);
    if (!hasEmptyOnes(a->bxdf) && !hasEmptyOnes(a->displacement) && !hasEmptyShaders) {
      lastGood_ = a.get();
      return {};
    }
    auto whole = std::make_shared<scene::Attributes>(*a);
    for (scene::NetworkPtr* n : {&whole->bxdf, &whole->displacement})
      if (hasEmptyOnes(*n)) {
        auto network = std::make_shared<scene::Network>(**n);
        takeEmptyOnes(network->patterns, "the patterns of a network");
        *n = std::move(network);
      }
    takeEmptyOnes(whole->classicShaders, "an object's shaders");
    return scene::AttributesPtr(std::move(whole));
  }
  void checkNetwork(scene::PrimitivePtr& p) {
    std::optional<scene::AttributesPtr> attributes = repaired(p->attributes);
    if (!attributes) return;
    auto whole = std::make_shared<scene::Primitive>(*p);
    whole->attributes = std::move(*attributes);
    p = std::move(whole);
  }

  Diagnostics& diagnostics_;
  const scene::Attributes* lastGood_ = nullptr;
};

}  // namespace

void checkScene(scene::Scene& scene, Diagnostics& diagnostics) { Checker(diagnostics).check(scene); }

}  // namespace kinora::render
