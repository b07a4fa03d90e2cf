// A small scene with something of every kind, the files that it reads, and random edits of it: what a user of
// Renderer::scene() may do between two renders. Used by tests/edits only.
#pragma once
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "scene/scene.h"

namespace kinora::tests {

// A temporary folder with textures and shaders; removed with the object.
class SceneFolder {
 public:
  SceneFolder();
  ~SceneFolder();
  SceneFolder(const SceneFolder&) = delete;
  const std::string& path() const { return path_; }
  // Another picture of this name.
  void picture(const std::string& file, float level) const;
  void write(const std::string& file, const std::string& text) const;

 private:
  std::string path_;
};

scene::Scene sceneWithEverything(const SceneFolder& folder, Diagnostics& diagnostics);

// Edits of all kinds at random, the same for each seed.
class RandomEdits {
 public:
  explicit RandomEdits(uint32_t seed) : rng_(seed) {}
  // Makes one edit; returns what it was.
  std::string apply(scene::Scene& scene);
  // Makes an edit of this kind; "" when the scene has nothing to edit so.
  std::string apply(scene::Scene& scene, size_t kind);
  static size_t kinds();
  static const char* nameOf(size_t kind);
  uint32_t below(size_t n) { return uint32_t(rng_() % n); }
  double number(double from, double to) { return from + (to - from) * double(rng_() >> 8) * 0x1p-24; }
  bool coin() { return rng_() & 1; }

 private:
  std::mt19937 rng_;
};

}  // namespace kinora::tests
