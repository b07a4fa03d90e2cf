// Folders of archives with a scene that waits for them, rendered in this process. For the tests of this folder.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "film/shard.h"
#include "render/renderer.h"
#include "rib/reader.h"
#include "support/render_scene.h"

namespace kinora::tests {

using Files = std::map<std::string, std::string>;

class Folder {
 public:
  explicit Folder(const Files& files) : path_(::testing::TempDir() + "procedurals-" + std::to_string(::getpid())) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
    for (const auto& [name, text] : files) std::ofstream(path_ + "/" + name) << text;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

// What the scene of a folder says.
struct Said {
  std::optional<scene::Scene> scene;
  std::shared_ptr<const scene::ProceduralSources> procedurals;
};

inline Said readScene(const Folder& folder, Diagnostics& diagnostics, bool allowExec = false,
                      const std::string& proceduralHost = "") {
  Said out;
  rib::ReadOptions reading;
  reading.delaysProcedurals = true;
  reading.allowExec = allowExec;
  reading.programSeconds = 0.5;
  reading.proceduralHost = proceduralHost;
  rib::RibReader reader(diagnostics, reading, [&](scene::Scene&& s) {
    out.scene = std::move(s);
    out.procedurals = reader.procedurals();
  });
  EXPECT_TRUE(reader.readFile(folder.file("scene.rib")));
  reader.finish();
  return out;
}

struct Rendered {
  render::Outcome outcome = render::Outcome::Internal;
  std::vector<int64_t> sums;
  std::vector<std::string> replayed;
  render::Statistics statistics;
  std::string said, hash;
  size_t late = 0;  // files that the part names beside its hash
  uint64_t warnings = 0, errors = 0;
};

inline Rendered rendered(const Folder& folder, render::Settings settings, bool allowExec = false,
                         const std::string& proceduralHost = "") {
  Rendered out;
  Diagnostics diagnostics([&](const std::string& line, Severity s) {
    if (s != Severity::Info) out.said += line + "\n";
  });
  auto [scene, procedurals] = readScene(folder, diagnostics, allowExec, proceduralHost);
  if (!scene) return out;
  if (settings.threads == 0) settings.threads = 1;
  settings.texturePath = settings.shaderPath = {folder.file("")};
  Registry registry;
  render::Renderer renderer(registry, diagnostics, settings);
  if (!renderer.load(std::move(*scene), procedurals)) return out;
  out.outcome = renderer.renderFilm();
  out.sums = stateOf(renderer.film());
  out.statistics = renderer.statistics();
  if (settings.firstSample >= 0 && renderer.writeShard(folder.file("part.exr"))) {
    film::Shard part;
    EXPECT_TRUE(film::readShard(folder.file("part.exr"), part).ok());
    out.hash = part.info.sceneHash;
    out.late = part.info.lateFiles.size();
  }
  renderer.replay(24, 18, 1, [&](const std::string& line) { out.replayed.push_back(line); });
  out.errors = diagnostics.errors();
  out.warnings = diagnostics.warnings() + out.errors;
  return out;
}

inline const std::string kHead = R"(Format 48 36 1
Projection "perspective" "fov" [45]
Display "t" "openexr" "rgba"
PixelSamples 4 4
)";
inline const std::string kLights = R"(AttributeBegin
Rotate -50 1 .3 0
Light "PxrDistantLight" "sun" "float intensity" [2]
AttributeEnd
Light "PxrDomeLight" "dome" "float intensity" [.3]
AttributeBegin
Translate 0 3 3
Rotate 90 1 0 0
Light "PxrRectLight" "lamp" "float intensity" [6]
AttributeEnd
)";
inline const std::string kRoom = R"(AttributeBegin
Bxdf "PxrDiffuse" "floor" "color diffuseColor" [.6 .5 .4]
Polygon "P" [-9 -1 0 9 -1 0 9 -1 14 -9 -1 14]
Polygon "P" [-9 -1 7 9 -1 7 9 8 7 -9 8 7]
AttributeEnd
)";
inline std::string world(const std::string& content,
                         const std::string& integrator = "Integrator \"PxrPathTracer\" \"i\"\n",
                         const std::string& before = "") {
  return kHead + integrator + before + "WorldBegin\n" + kLights + kRoom + content + "WorldEnd\n";
}
inline std::string delayed(const std::string& at, const std::string& file,
                           const std::string& bound = "-.6 .6 -.6 .6 -.6 .6") {
  return "AttributeBegin\nTranslate " + at + "\nProcedural \"DelayedReadArchive\" [\"" + file + "\"] [" + bound +
         "]\nAttributeEnd\n";
}
inline const std::string kBall =
    "Bxdf \"PxrDiffuse\" \"b\" \"color diffuseColor\" [.8 .2 .1]\nSphere .5 -.5 .5 360\n";
inline const std::string kBoxes = R"(Bxdf "PxrDiffuse" "b" "color diffuseColor" [.1 .6 .3]
PointsPolygons [4 4 4 4] [0 1 2 3 4 5 6 7 0 1 5 4 3 2 6 7] "P" [-.5 -.5 -.5 .5 -.5 -.5 .5 .5 -.5 -.5 .5 -.5 -.5 -.5 .5 .5 -.5 .5 .5 .5 .5 -.5 .5 .5]
Translate 0 .2 0 Sphere .3 -.3 .3 360
)";

}  // namespace kinora::tests
