// PxrPerspective: a pinhole or thin-lens camera. RIB's Projection "perspective" is this one. Importance and densities
// are derived in projection_author.h.
#define KINORA_KERNEL_FILE "plugins/projection/PxrPerspective/PxrPerspective.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include <kinora/projection_author.h>

#if KINORA_PLAIN
namespace kinora::pxrPerspective {
constexpr auto kParams = joinParams(projectionParams::kLens);

std::unique_ptr<ThinLens> make(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  const auto* projection = static_cast<const ProjectionInfo*>(info.extra);
  auto lens = std::make_unique<ThinLens>();
  lens->screen = ScreenMap::of(projection);
  setLens(*lens, values, *projection);
  return lens;
}
void ndcMatrix(const void* data, double out[16]) { perspectiveMatrix(*static_cast<const ThinLens*>(data), out); }
}  // namespace kinora::pxrPerspective
#endif

KINORA_PLUGIN(PxrPerspective, ProjectionRunner<ThinLensProjection>, ProjectionPlugin,
              .help =
                  "Perspective through a pinhole or a thin lens. Its shape is the Camera request's: apertureNSides, "
                  "apertureAngle, apertureRoundness, apertureDensity, dofaspect. fStop, focalLength and "
                  "focalDistance given here "
                  "replace those of the DepthOfField request.",
              .params = pxrPerspective::kParams, .setUp = setUpBy<pxrPerspective::make>,
              .ndcMatrix = pxrPerspective::ndcMatrix)
