#include "render/trace_stage.h"

#include <map>
#include <tuple>
#include <utility>

#include "scene/digests.h"

namespace kinora::render {

namespace {

// A part of several shapes that its placements show to different rays is one for each such difference: which rays
// see a shape is asked of it once it is in a part.
class PartsBySight {
 public:
  PartsBySight(const FlatScene& flat, const Sight& sight) : flat_(flat), sight_(sight), parts_(flat.parts) {}

  // Part and visibility of placements of a kind.
  std::pair<uint32_t, uint32_t> of(uint32_t kind) {
    const uint32_t part = flat_.kinds[kind].part;
    const std::vector<uint32_t>& shapes = flat_.parts[part].shapes;
    if (shapes.size() == 1) return {part, sight_.ofKind[kind]};
    if (kind == lastKind_) return last_;
    std::vector<uint32_t> seen;
    uint32_t any = 0;
    for (uint32_t k = 0; k < shapes.size(); ++k) {
      seen.push_back(sight_.ofShape[shapes[k]] & sight_.ofKind[kind + k]);
      any |= seen.back();
    }
    const auto [it, isNew] = bySight_.try_emplace({part, seen}, part);
    if (isNew) {
      if (!parts_[part].visibility.empty()) {
        it->second = uint32_t(parts_.size());
        parts_.push_back(flat_.parts[part]);
      }
      parts_[it->second].visibility = std::move(seen);
    }
    lastKind_ = kind;
    return last_ = {it->second, any};
  }
  std::vector<trace::PartInput> take() { return std::move(parts_); }

 private:
  const FlatScene& flat_;
  const Sight& sight_;
  std::vector<trace::PartInput> parts_;
  std::map<std::pair<uint32_t, std::vector<uint32_t>>, uint32_t> bySight_;
  uint32_t lastKind_ = ~0u;
  std::pair<uint32_t, uint32_t> last_;
};

}  // namespace

std::shared_ptr<const trace::World> TraceStage::make(const std::shared_ptr<const FlatScene>& flat,
                                                     const Meshes& meshes, const Sight& sight,
                                                     const CameraState& camera, bool isWatertight,
                                                     Statistics& statistics, Diagnostics& diagnostics) {
  Inputs inputs{flat,        meshes.serials(), sight.ofShape, sight.ofKind, camera.shutterOpen, camera.shutterClose,
                isWatertight};
  if (world_ && inputs == inputs_) return world_;
  std::vector<trace::ShapeInput> shapes = meshes.shapes();
  for (size_t i = 0; i < shapes.size(); ++i) shapes[i].visibility = sight.ofShape[i];
  PartsBySight parts(*flat, sight);
  std::vector<trace::PlacementInput> placements(flat->placements.size());
  for (uint32_t i = 0; i < placements.size(); ++i) {
    const uint32_t kind = flat->placements[i].kind, part = flat->kinds[kind].part;
    placements[i].info = kind;
    std::tie(placements[i].part, placements[i].visibility) = parts.of(kind);
    placements[i].member = flat->memberOf(i);
    if (!flat->parts[part].instanced) placements[i].revision = scene::digestOf(flat->toRender(i)).low;
  }
  trace::BuildOptions options;
  options.toRender = [&](uint32_t placement) { return flat->toRender(placement); };
  options.shutterOpen = camera.shutterOpen;
  options.shutterClose = camera.shutterClose;
  options.watertight = isWatertight;
  trace::BuildCounters counters;
  // from here on meshes may lie in render space: who stops half-way begins with meshes of his own
  const std::shared_ptr<const trace::World> before = std::exchange(world_, nullptr);
  world_ = trace::World::build(std::move(shapes), parts.take(), std::move(placements), options, before.get(),
                               counters, flat->solids);
  for (const trace::OpenSolid& s : world_->openSolids()) {
    const scene::Primitive& p = *flat->shapeOf(flat->kinds[flat->placements[s.placement].kind]).primitive;
    diagnostics.warning("RENDER-SOLID", p.pos,
                        "'" + p.name() + "' and what stands with it in its block do not close a volume",
                        "the surfaces of the solid at " + flat->solidPlaces[s.solid].str() + " are drawn as they are",
                        "each primitive solid needs surfaces without holes, as a Cylinder with two Disks");
  }
  for (const uint32_t placement : world_->lostPlacements()) {
    const scene::Primitive& p = *flat->shapeOf(flat->kinds[flat->placements[placement].kind]).primitive;
    const std::string name = flat->nameOf(placement);
    diagnostics.warning(
        "RENDER-FLAT", p.pos,
        "'" + (name.empty() ? p.name() : name) +
            "' is placed by a transformation that leaves it no volume, or that is too small or too far "
            "away for rays",
        "it is left out there", "look at the scales around its ObjectInstance or in its MotionBegin");
  }
  inputs_ = std::move(inputs);
  statistics.bvhPartsBuilt += counters.partsBuilt;
  statistics.bvhBuilds += counters.topLevelBuilds;
  ++statistics.rebuilt.worlds;
  return world_;
}

}  // namespace kinora::render
