// Scenes as films have them, written as RIB files with their textures, so that any version of the program can render
// them: `kinora-bench scenes FOLDER`, tools/compare_speed. The rich one comes with its meshes and placements too, for
// bare Embree. Set-up code: nothing here is measured.
#pragma once
#include <string>
#include <vector>

#include "scene/scene.h"
#include "scenes.h"

namespace kinora::bench {

// A mesh of a rich scene; smooth normals and texture coordinates by vertex.
struct RichMesh {
  TriangleMesh mesh;
  std::vector<float> later;  // points at the end of the shutter, where it deforms
  std::vector<float> st;
  bool isGlass = false;
};
struct RichPlacement {
  size_t mesh = 0;
  bool isInstance = false;   // of a prototype
  scene::Transform toWorld;  // over the shutter, 0 to 1
};
struct RichScene {
  std::string file;
  std::vector<RichMesh> meshes;
  std::vector<RichPlacement> placements;
};

// Writes folder/rich.rib and its textures: a bumpy ground between three walls, open to a dome with a map, 20 more
// lights of four kinds, 300 instances of 8 prototypes, objects placed once, objects that turn as they move, two that
// deform, and six of glass; 40 materials of five textures each, of four structures. The camera stands in the origin
// and looks along z. Throws std::runtime_error when a file cannot be written.
RichScene writeRichScene(const std::string& folder, bool quick);
// Writes folder/glass.rib: ten glasses, each in the one before, over a floor under a dome and a light. Its file.
std::string writeNestedGlasses(const std::string& folder, bool quick);

}  // namespace kinora::bench
