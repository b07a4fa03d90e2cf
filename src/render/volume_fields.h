// The fields of a Volume request: grids of a file or of the request itself, what a volume plug-in computes, or a mist that
// stands for what is not there; and how far velocities carry them. Called by SpaceMediaStage.
#pragma once
#include "base/diagnostics.h"
#include "plugin/registry.h"
#include "render/camera.h"
#include "scene/scene.h"
#include "shade/material.h"
#include "shade/space_media.h"

namespace kinora {
class VolumeSystem;
namespace render {

// The Volume request that a primitive is; null: it is another.
const scene::OtherPrimitive* volumeRequestOf(const scene::Primitive& p);

struct VolumeTools {
  const CameraState& camera;
  Registry& registry;
  const Host& host;
  VolumeSystem& volumes;
  Diagnostics& diagnostics;
};

// Reads a request's fields into SpaceMedium::fields. The width of footprints by which levels of the grids are chosen over
// that of rays; 0: the finest alone.
float readVolumeFields(const scene::Primitive& p, const VolumeTools& tools, shade::SpaceMedium& medium);

// How far the grids of a medium are carried while the shutter is open. They stand for time 0, or for when the shutter
// opens where that is never.
void setVolumeMotion(const shade::MaterialSet::Extinction& e, const scene::Primitive& p, const VolumeTools& tools,
                     shade::SpaceMedium& m);

}  // namespace render
}  // namespace kinora
