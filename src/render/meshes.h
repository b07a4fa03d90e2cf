// The meshes of a flat scene: tessellated on all threads, kept from one world to the next. A mesh is made again when
// its primitive's own fields, its look, its place, its displacement or the shutter are others, and where it was diced
// by the camera, when that sees it otherwise. Called by WorldBuilder.
#pragma once
#include <atomic>
#include <memory>
#include <vector>

#include "base/diagnostics.h"
#include "base/memory.h"
#include "geometry/tessellate.h"
#include "render/camera.h"
#include "render/displacement.h"
#include "render/flat_scene.h"
#include "render/statistics.h"
#include "trace/world.h"

namespace kinora::render {

// Brings a deforming mesh to keys that are even over the shutter, as Embree wants them; one key where nothing moves.
void uniformKeys(geometry::Mesh& mesh, double open, double close);

class Meshes {
 public:
  // One for each shape of the scene, in its order. False when `stop` was set meanwhile. Counts in `made`.
  bool make(const FlatScene& flat, const CameraState& camera, const Displacement& displacement,
            const std::atomic<bool>* stop, Diagnostics& diagnostics, Rebuilt& made);
  // Keys, serial numbers and meshes as the world wants them; visibility is left to the caller.
  std::vector<trace::ShapeInput> shapes() const;
  std::vector<const geometry::Mesh*> all() const;
  const std::shared_ptr<geometry::Mesh>& operator[](size_t shape) const { return kept_[shape].mesh; }
  // Serial numbers, by shape: equal ones are the same meshes.
  std::vector<uint64_t> serials() const;
  size_t size() const { return kept_.size(); }
  void setHeld(uint64_t bytes) { held_.set(bytes); }  // what they take, once all of them are there
  void forget() {
    kept_.clear();
    held_.set(0);
  }
  // Those that shade on demand, with what plug-ins made for it. True where there were some.
  bool forgetLevelled();
  uint64_t levelledBytes() const;
  uint64_t levelledQuads() const;  // of all patches at the finest rates

 private:
  struct Kept {
    scene::PrimitivePtr source;  // as long as it is held nothing else has its address
    std::shared_ptr<const std::vector<scene::PrimitivePtr>> more;  // see FlatScene::Shape
    Digest look, settings;
    Digest dicing;         // what it was diced by,
    bool isDiced = false;  // where it was diced by the camera at all,
    Digest content;        // and what came out, before it was brought into render space
    uint64_t serial = 0;
    std::shared_ptr<geometry::Mesh> mesh;
    std::shared_ptr<const LevelledSurface> levels;    // instead of the mesh's triangles; null: these
    std::shared_ptr<const trace::UserGeometry> user;  // the same, in the space of its part
  };
  class Finder;
  static Kept tessellated(const FlatScene& flat, size_t shape, const geometry::DiceRate& rate,
                          const CameraState& camera, const Displacement& displacement, const std::atomic<bool>* stop,
                          const std::atomic<bool>& isDiced, Diagnostics& diagnostics);

  std::vector<Kept> kept_;  // by shape
  uint64_t lastSerial_ = 0;
  MemoryHold held_{MemoryUse::Meshes};
};

}  // namespace kinora::render
