// The world that rays see, made of meshes and placements: which rays see what (visibility, named subsets, shadows
// that are let through), then the hierarchies over it. Kept when none of that is another. Called by WorldBuilder.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "render/camera.h"
#include "render/flat_scene.h"
#include "render/light_shadows.h"
#include "render/meshes.h"
#include "render/statistics.h"
#include "shade/group.h"

namespace kinora::render {

// Which rays see what, and what rays that leave objects ask for.
struct Sight {
  std::vector<uint32_t> ofShape, ofKind;  // VisibilityBits, and a bit for each subset
  std::vector<uint32_t> subsetsOfKind;    // bits of the subsets that it is a member of, whatever sees it; empty: none
  std::vector<shade::TraceSet> sets;      // by PlacementInfo::traceSet; empty: every ray sees everything
  std::map<std::string, uint32_t, std::less<>> byText;  // ShadingWorld::setsByText
  ShadowSets ofLights;                                  // those that there was no room for are not there
  // Objects that rays to lights pass and shadow rays do not, or the other way round, whoever sends them, and those that
  // colour their shadows.
  bool areShadowsOthers = false;
  bool areShadowsUnseen = false;  // of those, some that cast shadows
};
// A plug-in that names groups of objects in a parameter declared with Param::traceSet().
struct SetAsker {
  std::string text, who;
  SourcePos pos;
};
// Of a plug-in as a node sets it; null: its defaults.
std::vector<SetAsker> setAskersOf(const Descriptor& plugin, const scene::Node* node);
// Sets `traceSet` of each of `infos`; their materials are set. `askers`: beside those among the materials. isWhole: there
// are no other objects, so that a group without members is a mistake.
Sight sightOf(const FlatScene& flat, const shade::MaterialSet& materials, const std::vector<SetAsker>& askers,
              const std::vector<ShadowSubset>& ofLights, std::vector<shade::PlacementInfo>& infos, bool isWhole,
              Diagnostics& diagnostics);

// Sets what Sight says of shadows, of objects as they are seen in the end, and where shadows are others `shadowCast` of
// `infos`.
void compareShadows(const FlatScene& flat, const shade::MaterialSet& materials, Sight& sight,
                    std::vector<shade::PlacementInfo>& infos);

// Of procedurals, as trace::BuildOptions takes them. Instances of the scene from `firstInstance` on stand for them.
struct DelayedBounds {
  std::shared_ptr<const trace::UnreadBounds> unread;
  std::vector<trace::UnreadBounds::Box> all;
  uint32_t firstInstance = 0;
  bool operator==(const DelayedBounds&) const = default;
};

class TraceStage {
 public:
  // isWatertight: see trace::BuildOptions. Counts in `statistics`.
  std::shared_ptr<const trace::World> make(const std::shared_ptr<const FlatScene>& flat, const Meshes& meshes,
                                           const Sight& sight, const CameraState& camera, bool isWatertight,
                                           const DelayedBounds& delayed, Statistics& statistics,
                                           Diagnostics& diagnostics);
  void forget() { *this = {}; }

 private:
  struct Inputs {
    std::shared_ptr<const FlatScene> flat;
    std::vector<uint64_t> serials;
    std::vector<uint32_t> ofShape, ofKind;
    double shutterOpen, shutterClose;
    bool isWatertight;
    DelayedBounds delayed;
    bool operator==(const Inputs&) const = default;
  };
  Inputs inputs_{};
  std::shared_ptr<const trace::World> world_;
};

}  // namespace kinora::render
