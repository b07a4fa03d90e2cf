// Proves: of 300 random pairs of edits of one scene, parts of the two frames merge where the scenes say the same, and
// never where they do not; and the part of an edited scene is that of a fresh load. Misses: files that differ
// (tests/identity).
#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "film/shard.h"
#include "plugin/registry.h"
#include "render/renderer.h"
#include "scene/identity.h"
#include "tests/edits/edited_scene.h"

namespace kinora::tests {
namespace {

TEST(NeverMerge, PartsOf300RandomPairsOfEdits) {
  const SceneFolder folder;
  Registry registry;
  std::string said;
  Diagnostics diagnostics{[&](const std::string& line, Severity) { said += line + "\n"; }};
  render::Settings settings;
  settings.threads = 1;
  settings.texturePath = settings.shaderPath = {folder.path()};
  settings.resolution = {8, 6};
  const scene::Scene base = sceneWithEverything(folder, diagnostics);
  struct Part {
    std::string what, first, second;  // files of sample 0 and 1
    Digest scene;
  };
  std::vector<Part> parts;
  settings.firstSample = 0;
  settings.lastSample = 1;
  render::Renderer edited(registry, diagnostics, settings);
  ASSERT_TRUE(edited.load(base)) << said;
  for (uint32_t seed = 0; parts.size() < 60; ++seed) {
    edited.scene() = base;
    RandomEdits edits(seed);
    Part p;
    if (seed > 0) p.what = edits.apply(edited.scene());
    SCOPED_TRACE(p.what);
    if (!edited.update()) continue;  // nothing is left to render
    const std::string name = folder.path() + "/" + std::to_string(seed);
    ASSERT_EQ(edited.renderFilm(), render::Outcome::Complete);
    p.first = name + "a.exr", p.second = name + "b.exr";
    ASSERT_TRUE(edited.writeShard(p.first));
    render::Settings other = settings;
    other.firstSample = 1;
    other.lastSample = 2;
    render::Renderer fresh(registry, diagnostics, other);
    ASSERT_TRUE(fresh.load(edited.scene()));
    ASSERT_EQ(fresh.renderFilm(), render::Outcome::Complete);
    ASSERT_TRUE(fresh.writeShard(p.second));
    p.scene = scene::digestOf(edited.scene());
    parts.push_back(p);
  }
  const auto merges = [](const std::string& a, const std::string& b) {
    film::Shard merged;
    std::vector<std::string> warnings;
    return film::mergeShards({a, b}, merged, warnings).ok();
  };
  for (const Part& p : parts) EXPECT_TRUE(merges(p.first, p.second)) << p.what;
  std::mt19937 rng(1);
  size_t refused = 0;
  for (int pair = 0; pair < 300; ++pair) {
    const Part &a = parts[rng() % parts.size()], &b = parts[rng() % parts.size()];
    const bool isOne = a.scene == b.scene;
    refused += !isOne;
    EXPECT_EQ(merges(a.first, b.second), isOne) << a.what << " and " << b.what;
  }
  EXPECT_GT(refused, 250u);
}

}  // namespace
}  // namespace kinora::tests
