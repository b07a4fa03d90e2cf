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
  PartsBySight(const FlatScene& flat, const Sight& sight) : parts_(flat.parts) {
    std::map<std::pair<uint32_t, std::vector<uint32_t>>, uint32_t> bySight;
    for (uint32_t kind = 0; kind < flat.kinds.size(); ++kind) {
      const uint32_t part = flat.kinds[kind].part;
      const std::vector<uint32_t>& shapes = flat.parts[part].shapes;
      ofKind_.emplace_back(part, sight.ofKind[kind]);
      if (shapes.size() == 1 || flat.kinds[kind].shape != shapes[0]) continue;
      std::vector<uint32_t> seen;
      uint32_t any = 0;
      for (uint32_t k = 0; k < shapes.size(); ++k) {
        seen.push_back(sight.ofShape[shapes[k]] & sight.ofKind[kind + k]);
        any |= seen.back();
      }
      const auto [it, isNew] = bySight.try_emplace({part, seen}, part);
      if (isNew) {
        if (!parts_[part].visibility.empty()) {
          it->second = uint32_t(parts_.size());
          parts_.push_back(flat.parts[part]);
        }
        parts_[it->second].visibility = std::move(seen);
      }
      ofKind_.back() = {it->second, any};
    }
  }
  // Part and visibility of placements of a kind.
  std::pair<uint32_t, uint32_t> of(uint32_t kind) const { return ofKind_[kind]; }
  const std::vector<trace::PartInput>& parts() const { return parts_; }

 private:
  std::vector<trace::PartInput> parts_;
  std::vector<std::pair<uint32_t, uint32_t>> ofKind_;
};

}  // namespace

std::shared_ptr<const trace::World> TraceStage::make(const std::shared_ptr<const FlatScene>& flat,
                                                     const Meshes& meshes, const Sight& sight,
                                                     const CameraState& camera, bool isWatertight,
                                                     const DelayedBounds& delayed, Statistics& statistics,
                                                     Diagnostics& diagnostics) {
  Inputs inputs{flat,         meshes.serials(), sight.ofShape, sight.ofKind, camera.shutterOpen, camera.shutterClose,
                isWatertight, delayed};
  if (world_ && inputs == inputs_) return world_;
  std::vector<trace::ShapeInput> shapes = meshes.shapes();
  for (size_t i = 0; i < shapes.size(); ++i) shapes[i].visibility = sight.ofShape[i];
  const PartsBySight parts(*flat, sight);
  const trace::PlacementSource placements(uint32_t(flat->placements.size()), [&](uint32_t i) {
    trace::PlacementInput place;
    place.info = flat->placements[i].kind;
    std::tie(place.part, place.visibility) = parts.of(place.info);
    place.member = flat->memberOf(i);
    return place;
  });
  trace::BuildOptions options;
  options.toRender = [&](uint32_t placement) { return flat->toRender(placement); };
  options.stillToRender = [&](uint32_t placement, scene::Matrix& m) { return flat->stillToRender(placement, m); };
  options.revisionOf = [&](uint32_t placement) { return scene::digestOf(flat->toRender(placement)).low; };
  options.shutterOpen = camera.shutterOpen;
  options.shutterClose = camera.shutterClose;
  options.watertight = isWatertight;
  options.unread = delayed.unread;
  options.delayed = delayed.all;
  if (!delayed.all.empty())
    options.isDelayed = [&](uint32_t placement) {
      const uint32_t in = flat->outermostOf(placement);
      return in != FlatScene::kWorld && in >= delayed.firstInstance;
    };
  trace::BuildCounters counters;
  // from here on meshes may lie in render space: who stops half-way begins with meshes of his own
  const std::shared_ptr<const trace::World> before = std::exchange(world_, nullptr);
  world_ = trace::World::build(std::move(shapes), parts.parts(), placements, options, before.get(), counters,
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
