// From a scene description to what passes read: tessellated shapes, BVHs, materials, lights, camera. After an edit
// only what changed is made again. Called by Renderer.
#pragma once
#include <kinora/projection.h>

#include <array>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/file_contents.h"
#include "base/memory.h"
#include "film/light_paths.h"
#include "plugin/registry.h"
#include "render/clipping.h"
#include "render/renderer.h"
#include "render/statistics.h"
#include "scene/scene.h"
#include "shade/group.h"

namespace kinora {
class TextureSystem;
class VolumeSystem;
namespace render {

// A plug-in's data for one node, destroyed with it.
class Instance {
 public:
  Instance() = default;
  // False with a message when create() fails.
  bool create(const Descriptor& plugin, const scene::Node* node, const Placement* placement, const void* extra,
              const Host& host, Diagnostics& diagnostics);
  const Descriptor* plugin() const { return plugin_; }
  const void* data() const { return data_.get(); }
  std::shared_ptr<void> owner() const { return data_; }

 private:
  const Descriptor* plugin_ = nullptr;
  std::shared_ptr<void> data_;
};

struct CameraState {
  Instance projection;
  const ProjectionFunctions* functions = nullptr;  // for the width in use
  std::array<int, 2> resolution{640, 480};
  std::array<int, 4> window{0, 0, 640, 480};  // x0 y0 x1 y1 of the crop, half open
  std::vector<trace::Affine> toRender;        // camera to render, uniform keys over the shutter
  std::vector<trace::Affine> fromRender;
  double shutterOpen = 0, shutterClose = 0;
  std::vector<float> times;     // warp of sample times by the shutter's shape; empty: none
  std::vector<CutPlane> cuts;   // camera space
  scene::Matrix worldToCamera;  // at the middle of the shutter
};

// Names in a list of groups (grouping:membership, subsets), apart by white space or commas; a "+" that stands alone
// is none.
std::vector<std::string> groupNames(const std::string& list);

class WorldBuilder {
 public:
  WorldBuilder(Registry& registry, Diagnostics& diagnostics, const Settings& settings);
  ~WorldBuilder();
  // Where textures and volumes lie; before any plug-in is made, which may ask for images.
  void openTextures(const scene::Scene& scene);
  // Resolution, crop, projection. False when there is nothing to look at.
  bool buildCamera(const scene::Scene& scene);
  // Everything else. `paths` must outlive the world.
  bool buildWorld(const scene::Scene& scene, const film::LightPaths& paths, Statistics& statistics);

  const CameraState& camera() const { return camera_; }
  const shade::ShadingWorld& world() const { return *shading_; }
  TextureSystem& textures() { return *textures_; }
  FileContents& contents() { return contents_; }
  const Host& host() const { return host_; }
  uint32_t width() const { return width_; }
  // Directories for files of a kind: "texture", "shader".
  std::vector<std::string> searchPath(const scene::Scene& scene, const std::string& kind) const;
  // Looks the shaders of the scene's materials up; before needsSplit() and buildWorld().
  void openShaders(const scene::Scene& scene);
  // Whether diffuse and specular must be told apart at every bounce: some light has different factors for them, or
  // some shader asks for the type of a ray.
  bool needsSplit(const scene::Scene& scene) const;

 private:
  struct Shape;
  void flatten(const scene::Scene& scene, const std::set<uint32_t>& leaveOut);
  // What is said of an object about lights: lighting:subset and excludesubset, handles that are off, and the ids of
  // LightSources that are not on its list.
  struct Linking {
    std::string subset, exclude;
    std::vector<std::string> off;
    std::vector<uint32_t> unlisted;
    auto operator<=>(const Linking&) const = default;
  };
  using LinkSets = std::map<Linking, uint32_t>;
  LinkSets linkObjects(const scene::Scene& scene, const std::vector<scene::Light>& sources);
  void tellOfUnusedLights(const std::vector<std::vector<uint32_t>>& sets,
                          const std::vector<const scene::Light*>& sourceOf, const scene::Scene& scene);
  std::shared_ptr<const light::LightSet> makeLights(const scene::Scene& scene,
                                                    const std::vector<scene::Light>& sources,
                                                    const film::LightPaths& paths, const LinkSets& links);
  // Subsets that attributes of placements name: bits of shapes and placements, masks of rays.
  void traceSets(shade::ShadingWorld& world);
  Placement placementOf(const scene::Transform& toWorld) const;
  double edgeLengthFactor(const scene::Attributes* attributes) const;

  Registry& registry_;
  Diagnostics& diagnostics_;
  const Settings& settings_;
  uint32_t width_;
  Host host_{};
  FileContents contents_;  // of what the world reads
  std::unique_ptr<TextureSystem> textures_;
  std::unique_ptr<VolumeSystem> volumes_;
  shade::ShaderLibrary shaders_;
  bool asksRayType_ = false;  // some shader does
  CameraState camera_;
  std::unique_ptr<shade::ShadingWorld> shading_;
  double origin_[3] = {0, 0, 0};
  bool haveOrigin_ = false;
  // Attributes inside objects as an instance gives them, kept for whoever holds a pointer to them, with what of them
  // a shape depends on: an object has a shape for each different one.
  struct Inherited {
    scene::AttributesPtr attributes;
    std::string look;
  };
  std::map<std::pair<const scene::Attributes*, const scene::Attributes*>, Inherited> inherited_;
  // shapes by primitive id and look, kept between edits
  struct Kept {
    uint64_t revision;     // of the primitive
    std::string settings;  // of the camera, as far as the mesh depends on them
    uint64_t made;         // serial number of the mesh: what the world compares
    std::shared_ptr<geometry::Mesh> mesh;
  };
  std::map<std::pair<uint64_t, std::string>, Kept> shapes_;
  uint64_t meshesMade_ = 0;
  std::vector<trace::ShapeInput> shapeInputs_;
  std::vector<trace::PartInput> parts_;
  std::vector<trace::PlacementInput> placements_;
  std::vector<const scene::Primitive*> primitiveOfShape_;
  std::vector<const Inherited*> inheritedOfShape_;  // null: the primitive's own attributes are all it has
  const scene::Primitive& primitiveOf(const trace::PlacementInput& p) const {
    return *primitiveOfShape_[parts_[p.part].shapes[0]];
  }
  std::vector<shade::PlacementInfo> placementInfos_;
  std::vector<const scene::Attributes*> attributesOfPlacement_;
  trace::BuildCounters counters_;
  MemoryHold meshesHeld_{MemoryUse::Meshes};
};

}  // namespace render
}  // namespace kinora
