// From a scene description to what passes read. A world is a graph of stages: files, camera, flat scene, meshes,
// materials, traced world, lights, tables of shading. Each is a function of what it is given and keeps its last
// result, which stands as long as the digests of what it was made of do; what an edit did not reach is not made
// again, however it was made. Called by Renderer.
#pragma once
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/file_contents.h"
#include "film/light_paths.h"
#include "plugin/registry.h"
#include "render/camera.h"
#include "render/displacement.h"
#include "render/flat_scene.h"
#include "render/instance.h"
#include "render/interior_media.h"
#include "render/materials.h"
#include "render/meshes.h"
#include "render/procedurals.h"
#include "render/renderer.h"
#include "render/space_media.h"
#include "render/statistics.h"
#include "render/trace_stage.h"
#include "render/world_lights.h"
#include "scene/scene.h"
#include "shade/group.h"

namespace kinora {
class TextureSystem;
class VolumeSystem;
namespace render {

// Bytes that somebody has said surfaces may take: the command line, else the scene (in KiB). 0: nobody.
uint64_t geometryCacheSaid(const scene::Scene& scene, const Settings& settings);

class WorldBuilder {
 public:
  WorldBuilder(Registry& registry, Diagnostics& diagnostics, const Settings& settings);
  ~WorldBuilder();
  // Where textures and volumes lie; before any plug-in is made, which may ask for images. True when nothing that was
  // made of files before may be used again: the search path is another, or a file has changed.
  bool openTextures(const scene::Scene& scene, Statistics& statistics);
  // Resolution, crop, projection. False when there is nothing to look at.
  bool buildCamera(const scene::Scene& scene, Statistics& statistics);
  // Looks the shaders of the scene's materials up; before needsSplit() and buildWorld().
  void openShaders(const scene::Scene& scene);
  // Whether diffuse and specular must be told apart at every bounce: some light has different factors for them, or
  // some shader asks for the type of a ray.
  bool needsSplit(const scene::Scene& scene) const;
  // Everything else. False when it was stopped. `askers`: of sets of objects, beside materials.
  bool buildWorld(const scene::Scene& scene, const Delayed& delayed,
                  const std::shared_ptr<const film::LightPaths>& paths, const std::vector<SetAsker>& askers,
                  const AggregateChoice& aggregates, Statistics& statistics);
  // Of Delayed::unread, those that rays have met in the world, in order.
  std::vector<uint32_t> metUnread() const;
  uint32_t placeOfUnread(uint32_t bound) const { return unreadPlaces_[bound]; }  // of one of the world's UnreadBounds
  // Adds what the meshes of what instances of the scene place take, with their hierarchies. Those are estimated: what
  // is dropped for a budget must not follow from the order in which threads build.
  void findBytes(std::map<uint32_t, uint64_t>& ofInstances) const;
  // Boxes in the world, a hundredth of the memory, that hold all that these instances place. Without those of which not
  // all is a resting mesh that rays meet at its surface alone.
  void findCells(std::map<uint32_t, std::vector<Imath::Box3d>>& ofInstances) const;
  // Fills in the boxes around what instances of the scene place, in the world, over the shutter.
  void findBounds(std::map<uint32_t, Imath::Box3d>& ofInstances) const;
  // After one of these failed or threw: nothing that was kept is used again.
  void forget();

  // What rays have asked for so far of surfaces that are diced on demand.
  void countLevels(Statistics& statistics) const;
  // See GeometryCache::setStop().
  void stopDicingBy(const std::atomic<bool>* stop) { displacement_.cache().setStop(stop); }
  void countVolumes(Statistics& statistics) const;

  const CameraState& camera() const { return camera_; }
  const shade::ShadingWorld& world() const { return *shading_; }
  TextureSystem& textures() { return *textures_; }
  FileContents& contents() { return contents_; }
  const Host& host() const { return host_.host(); }
  uint32_t width() const { return width_; }
  // Directories for files of a kind: "texture", "shader".
  std::vector<std::string> searchPath(const scene::Scene& scene, const std::string& kind) const;

 private:
  void forgetPlugins();  // all that plug-ins made
  bool haveFilesChanged();
  RenderSpace renderSpace() const;
  void flattenScene(const scene::Scene& scene, const std::set<uint32_t>& emitters, Rebuilt& rebuilt);
  void setScene(const scene::Scene& scene, shade::ShadingWorld& w);
  DelayedBounds boundsOfDelayed(const scene::Scene& scene, const Delayed& delayed);
  void count(const scene::Scene& scene, const shade::ShadingWorld& w, Statistics& statistics);

  Registry& registry_;
  Diagnostics& diagnostics_;
  const Settings& settings_;
  uint32_t width_;
  FileContents contents_;  // of what the world reads
  std::unique_ptr<TextureSystem> textures_;
  std::unique_ptr<VolumeSystem> volumes_;
  PluginHost host_;
  std::vector<std::string> texturePath_;
  bool isOpen_ = false;
  std::map<std::string, std::string> placesOfLacking_;  // of files that are not used: where they are all the same
  shade::ShaderLibrary shaders_;
  std::vector<std::shared_ptr<const shade::ShaderNode>> shadersInUse_;
  bool asksRayType_ = false;  // some shader does
  // the stages' results
  Digest ofCamera_;
  FileContents::Names filesOfCamera_;
  CameraState camera_;
  InteriorMedia interiors_;
  std::shared_ptr<const FlatScene> flat_;
  Displacement displacement_;
  LightSurfaces lightSurfaces_;
  Meshes meshes_;
  Materials materials_;
  TraceStage traced_;
  SpaceMediaStage media_;
  Lights lights_;
  std::unique_ptr<shade::ShadingWorld> shading_;
  std::vector<uint32_t> unreadPlaces_;  // in Delayed::unread, by number in the traced world's
};

}  // namespace render
}  // namespace kinora
