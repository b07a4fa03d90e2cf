// PxrLayerSurface: PxrSurface under the name by which layered materials are exported. PxrLayer and PxrLayerMixer feed
// its parameters, one by one or through inputMaterial; nothing else differs, so it is PxrSurface's code.
#include <kinora/plugin.h>

namespace kinora {
const Descriptor* kinoraStock_PxrSurface();

const Descriptor* kinoraStock_PxrLayerSurface() {
  static const Descriptor descriptor = [] {
    Descriptor d = *kinoraStock_PxrSurface();
    d.name = "PxrLayerSurface";
    d.doc = "PxrSurface fed by layers of material.";
    return d;
  }();
  return &descriptor;
}
}  // namespace kinora
