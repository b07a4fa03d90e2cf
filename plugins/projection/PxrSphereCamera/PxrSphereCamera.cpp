// PxrSphereCamera: a panorama by longitude and latitude; the view axis is its middle.
#define KINORA_KERNEL_FILE "plugins/projection/PxrSphereCamera/PxrSphereCamera.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include "plugins/projection/parts/around.h"

#if KINORA_PLAIN
namespace kinora::pxrSphereCamera {
constexpr auto kParams = around::params(180, 180);

std::unique_ptr<around::Data> make(const CreateInfo& info) {
  return around::make(info, kParams.data(), kParams.size(), false);
}
}  // namespace kinora::pxrSphereCamera
#endif

KINORA_PLUGIN(PxrSphereCamera, ProjectionRunner<AroundProjection>, ProjectionPlugin,
              .help = "All around the eye by longitude and latitude. No depth of field.",
              .params = pxrSphereCamera::kParams, .setUp = setUpBy<pxrSphereCamera::make>)
