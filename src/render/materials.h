// The materials of a flat scene, bound to shading programs, and which of them each placement has. Kept from one world
// to the next as long as networks, textures, shaders and light paths stay what they are. Called by WorldBuilder.
#pragma once
#include <array>
#include <memory>
#include <vector>

#include "base/file_contents.h"
#include "film/light_paths.h"
#include "render/flat_scene.h"
#include "render/statistics.h"
#include "scene/digests.h"
#include "shade/material.h"

namespace kinora::render {

class Materials {
 public:
  struct Tools {
    Registry& registry;
    Diagnostics& diagnostics;
    TextureSystem& textures;
    FileContents& contents;
    shade::ShaderLibrary& shaders;
    // those that the scene's networks name, as they are now
    const std::vector<std::shared_ptr<const shade::ShaderNode>>& shadersInUse;
    const std::shared_ptr<const film::LightPaths>& paths;
    uint32_t width;
    const std::vector<scene::Light>& lights;  // that are rendered
    std::array<float, 2> clipping;            // as the camera says
    bool isClassic = false;                   // its lights are all of the shading-language age
  };
  // Sets `material` of each of `infos`, which are by placement.
  std::shared_ptr<const shade::MaterialSet> make(const FlatScene& flat, const Tools& tools,
                                                 std::vector<shade::PlacementInfo>& infos, Rebuilt& made);
  void forget() { *this = {}; }

 private:
  std::shared_ptr<const film::LightPaths> paths_;  // outlives the set
  std::shared_ptr<const shade::MaterialSet> set_;
  std::vector<uint32_t> ofAsk_;
  std::vector<Digest> asked_;  // what it was made of, in order
  std::vector<std::shared_ptr<const shade::ShaderNode>> shaders_;
  FileContents::Names files_;
  scene::NetworkDigests digests_;
};

}  // namespace kinora::render
