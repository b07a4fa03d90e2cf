// The objects of a flat scene that are full of a medium: their fields from files and requests, the hierarchy of their
// boundaries, and bounds of their extinction for tracking, from the fields or by shading a lattice of points. Kept
// from one world to the next while none of that is another. Called by WorldBuilder.
#pragma once
#include <atomic>
#include <memory>
#include <set>
#include <vector>

#include "base/file_contents.h"
#include "plugin/registry.h"
#include "render/flat_scene.h"
#include "render/meshes.h"
#include "render/volume_aggregates.h"
#include "render/volume_fields.h"
#include "shade/group.h"

namespace kinora::render {

// Whether objects of these attributes are full of a medium, and have no surface.
bool fillsSpace(const scene::Attributes* attributes, Registry& registry, Diagnostics& diagnostics);

// Whether placements of a kind are of a Volume request.
bool isVolume(const FlatScene& flat, size_t kind);

class SpaceMediaStage {
 public:
  struct Tools {
    VolumeTools volumes;
    FileContents& contents;
    const std::atomic<bool>* stop;
    const AggregateChoice& aggregates;
    const std::vector<uint32_t>& subsetsOfKind;  // see Sight
  };
  // Sets the media of a world of which all is set that shading needs. Null: there are none.
  std::shared_ptr<const shade::SpaceMedia> make(const std::shared_ptr<const FlatScene>& flat, const Meshes& meshes,
                                                shade::ShadingWorld& world, const Tools& tools);
  void forget() { *this = {}; }

 private:
  void use(shade::ShadingWorld& world) const;
  struct Inputs {
    std::shared_ptr<const FlatScene> flat;
    std::shared_ptr<const shade::MaterialSet> materials;
    std::shared_ptr<const trace::World> world;
    AggregateChoice aggregates;
    std::vector<uint32_t> subsetsOfKind;
    std::vector<shade::TraceSet> sets;
    bool operator==(const Inputs&) const = default;
  };
  Inputs inputs_{};
  FileContents::Names files_;
  std::shared_ptr<const shade::SpaceMedia> made_;
};

}  // namespace kinora::render
