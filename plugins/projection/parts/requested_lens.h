// The DepthOfField request for projections that have no parameters for a lens: those with one take its lens, all others
// tell that it does nothing. Plain code that runs once, before rendering.
#pragma once
#include <kinora/projection_setup.h>

namespace kinora {

// A pinhole where the request is missing, or asks for a lens that cannot exist.
inline void setRequestedLens(ThinLens& k, const ProjectionInfo& info) {
  if (!(info.fStop > 0)) return;
  const double radius = double(info.focalLength) / (2 * double(info.fStop)), distance = info.focalDistance;
  if (!(radius > 0) || !(radius < 1e30) || !(distance > 1e-9) || !(distance < 1e30)) return;
  k.lensRadius = float(radius);
  k.sharp[2] = float(1 / distance);
  k.aperture = Aperture::of(info);
}

inline void tellOfNoLens(const CreateInfo& info) {
  const auto* picture = static_cast<const ProjectionInfo*>(info.extra);
  if (picture && picture->fStop > 0)
    NamedValues(info, nullptr, 0)
        .warn("PROJECTION-LENS", "the DepthOfField request does not reach this projection, which has no lens",
              "everything is sharp");
}

}  // namespace kinora
