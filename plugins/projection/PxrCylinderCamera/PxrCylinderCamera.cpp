// PxrCylinderCamera: a panorama on an upright cylinder; the view axis is its middle.
#define KINORA_KERNEL_FILE "plugins/projection/PxrCylinderCamera/PxrCylinderCamera.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include "plugins/projection/parts/around.h"

#if KINORA_PLAIN
namespace kinora::pxrCylinderCamera {
constexpr auto kParams = around::params(90, 170);

std::unique_ptr<around::Data> make(const CreateInfo& info) {
  return around::make(info, kParams.data(), kParams.size(), true);
}
}  // namespace kinora::pxrCylinderCamera
#endif

KINORA_PLUGIN(PxrCylinderCamera, ProjectionRunner<AroundProjection>, ProjectionPlugin,
              .help = "All around the eye on an upright cylinder. No depth of field.",
              .params = pxrCylinderCamera::kParams, .setUp = setUpBy<pxrCylinderCamera::make>)
