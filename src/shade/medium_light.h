// What a medium emits, as a light that is chosen among the others: fire. Its samples say where to look, and with which
// density; how much is emitted there the medium is asked for itself (GroupState::lightSamples), for light/ knows no
// networks. No ray meets it as a light: what rays come through on their way is RayList::glow, the other half of the
// estimate. It begins no light paths.
#pragma once
#include <kinora/light.h>

#include <memory>

#include "light/light_set.h"
#include "shade/group.h"
#include "volume/emission_cells.h"

namespace kinora::shade {

class MediumLight {
 public:
  MediumLight(const ShadingWorld& world, const SpaceMedium& medium,
              std::shared_ptr<const volume::EmissionCells> cells);

  // Of the direction d (unit) at o, per solid angle: that a sample there makes it.
  float density(const float o[3], const float d[3], float time) const;
  // False: nothing. `weight`: one over the density of the distance t, by length.
  bool sample(const float P[3], float u, float v, float time, float wi[3], float& t, float& weight, float& pdf) const;
  // Whether samples may lie at a point of object space.
  bool emits(const float object[3]) const { return cells_->emits(object); }
  // power: of all that it emits, as of other lights.
  void describe(float power, LightDescription& d) const;

 private:
  trace::Affine fromRender(float time) const;
  std::shared_ptr<const trace::World> world_;
  uint32_t instance_, geometry_;
  bool moves_;
  trace::Affine still_;
  std::shared_ptr<const volume::EmissionCells> cells_;
};

// Of lights whose instances are MediumLight.
light::LightKind mediumLightKind();

}  // namespace kinora::shade
