// Displaced surfaces: meshes that are diced, shaded where their vertices are, and moved before anything is traced.
// Called by Meshes for each world, on any thread; WorldBuilder holds it and says what shading may ask. Nothing of a
// mesh is kept here.
#pragma once
#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "base/file_contents.h"
#include "film/light_paths.h"
#include "geometry/displace.h"
#include "geometry/tessellate.h"
#include "render/camera.h"
#include "render/flat_scene.h"
#include "render/levels.h"
#include "scene/digests.h"
#include "shade/group.h"
#include "shade/shader_library.h"

namespace kinora::render {

class Displacement {
 public:
  struct Tools {
    const scene::Scene& scene;
    const CameraState& camera;
    Registry& registry;
    Diagnostics& diagnostics;
    TextureSystem& textures;
    VolumeSystem& volumes;
    FileContents& contents;
    shade::ShaderLibrary& shaders;
    const std::vector<std::shared_ptr<const shade::ShaderNode>>& shadersInUse;
    const std::shared_ptr<const film::LightPaths>& paths;
    uint32_t width;
  };
  // Binds the networks of what the scene displaces. Before the rest, for each world; `flat` and the tools stay until
  // the next one.
  void begin(const FlatScene& flat, const Tools& tools);
  // Whether a shape's surface moves: a displacement that is known, on what has a surface.
  bool moves(size_t shape) const { return !materialOf_.empty() && materialOf_[shape] != shade::MaterialSet::kNone; }
  // Of all that decides where its vertices go to, beside its own fields.
  Digest digestOf(size_t shape) const;
  // What levelled() found of a shape's faces, so that apply() need not look again.
  struct Found {
    std::optional<double> triangles;  // that they would be cut into, evenly as they are; none: not known
  };
  // The displaced surface of a shape that moves, from its tessellation with uniform keys. `stop`: may end it early;
  // `known`: of the same faces, at the same rate.
  void apply(size_t shape, const geometry::DiceRate& rate, const std::atomic<bool>* stop, geometry::Mesh& mesh,
             const Found& known) const;
  // Whether a shape's surface may be diced on demand: what it is, its rate and its attributes allow it.
  bool mayHaveLevels(size_t shape) const;
  // The surface of a shape that moves, diced where rays ask, from its tessellation as if it were not displaced, with
  // uniform keys. pixels: length of a micropolygon's edge for the camera. Null: it is small enough to be diced at once,
  // and `mesh` is as it was.
  std::shared_ptr<const LevelledSurface> levelled(size_t shape, const geometry::DiceRate& rate, double pixels,
                                                  const std::atomic<bool>* stop, geometry::Mesh& mesh,
                                                  Found& found) const;
  // Holds what is diced on demand; it lives as long as this.
  trace::GeometryCache& cache() const { return *cache_; }
  const LevelCounters& levelCounters() const { return *levelCounters_; }
  // What was made of files may not be taken for the same again.
  void forget() { ++generation_; }
  // Nothing of the scene is pointed to any more.
  void end();
  uint64_t micropolygons() const { return micropolygons_; }  // quads and triangles, over all worlds
  double seconds() const {
    return double(nanoseconds_) * 1e-9;
  }  // of shading and moving; meshes made at a time count each

 private:
  shade::ShadingWorld worldOf(size_t shape, uint32_t placement, const std::shared_ptr<geometry::Mesh>& mesh) const;
  // By key and vertex, object space; `normals` stay empty where no shader says any.
  struct Shaded {
    std::vector<Imath::V3f> offsets, normals;
  };
  Shaded shade(size_t shape, uint32_t placement, const std::shared_ptr<geometry::Mesh>& mesh,
               const geometry::Micropolygons& grid, const std::atomic<bool>* stop) const;
  // displacementbound in `space` units, and by how much those are longer than the object's; without one: 0.
  double boundOf(size_t shape, std::string& space, double& scale) const;
  void checkBound(size_t shape, double longest) const;
  void tellOfCoarse(size_t shape, double wanted, double made) const;  // triangles
  // Of the placements of a shape whose displacement may be measured in lengths of the world; 0: all are alike.
  struct ScaleRange {
    double least = 0, most = 0;
    uint32_t smallest = 0, largest = 0;
  };
  void tellOfScales();
  void tellOfScale(size_t shape) const;
  // From the space of the shape itself.
  scene::Transform toRenderOf(size_t shape, uint32_t placement) const;
  double scaleAt(size_t shape, uint32_t placement) const;
  // `offsets`: of the first placement, one key at least; null: not known.
  void checkScale(size_t shape, const std::shared_ptr<geometry::Mesh>& mesh, const geometry::Micropolygons& grid,
                  const std::vector<Imath::V3f>* offsets, const std::atomic<bool>* stop) const;

  const FlatScene* flat_ = nullptr;
  std::unique_ptr<Tools> tools_;
  std::shared_ptr<const shade::MaterialSet> set_;
  std::vector<uint32_t> materialOf_;   // by shape; empty: nothing is displaced
  std::vector<uint32_t> placementOf_;  // by shape: its first
  std::vector<Digest> digests_;        // by shape; of those that move
  std::vector<ScaleRange> ranges_;     // by shape; empty: no displacement is measured in lengths of the world
  std::vector<std::shared_ptr<const shade::ShaderNode>> shaders_;
  FileContents::Names files_;  // that are used, also by shaders while they run
  std::unique_ptr<FileContents::Listening> listening_;
  scene::NetworkDigests networks_;
  uint64_t generation_ = 0;
  std::shared_ptr<trace::GeometryCache> cache_ = std::make_shared<trace::GeometryCache>(uint64_t(1) << 30);
  std::shared_ptr<LevelCounters> levelCounters_ = std::make_shared<LevelCounters>();
  mutable std::atomic<uint64_t> micropolygons_{0}, nanoseconds_{0};
};

}  // namespace kinora::render
