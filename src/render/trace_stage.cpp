#include "render/trace_stage.h"

#include <utility>

#include "scene/digests.h"

namespace kinora::render {

std::shared_ptr<const trace::World> TraceStage::make(const std::shared_ptr<const FlatScene>& flat,
                                                     const Meshes& meshes, const Sight& sight,
                                                     const CameraState& camera, bool isWatertight,
                                                     Statistics& statistics, Diagnostics& diagnostics) {
  Inputs inputs{flat,        meshes.serials(), sight.ofShape, sight.ofKind, camera.shutterOpen, camera.shutterClose,
                isWatertight};
  if (world_ && inputs == inputs_) return world_;
  std::vector<trace::ShapeInput> shapes = meshes.shapes();
  for (size_t i = 0; i < shapes.size(); ++i) shapes[i].visibility = sight.ofShape[i];
  std::vector<trace::PlacementInput> placements(flat->placements.size());
  for (uint32_t i = 0; i < placements.size(); ++i) {
    const uint32_t kind = flat->placements[i].kind, part = flat->kinds[kind].part;
    placements[i].part = part;
    placements[i].info = kind;
    placements[i].visibility = sight.ofKind[kind];
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
  world_ = trace::World::build(std::move(shapes), flat->parts, std::move(placements), options, before.get(), counters,
                               flat->solids);
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
