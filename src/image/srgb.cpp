#include <kinora/math/srgb.h>

#include "image/read_write.h"

namespace kinora::image {

uint8_t encodeSrgb8(float linear) {
  static const SrgbEncoder encoder(256);
  return uint8_t(encoder.encode(linear));
}
uint16_t encodeSrgb16(float linear) {
  static const SrgbEncoder encoder(65536);
  return uint16_t(encoder.encode(linear));
}
float decodeSrgb(float encoded) { return float(srgbToLinear(encoded)); }
uint8_t quantize8(float v) { return uint8_t(quantizeLinear(v, 255)); }

}  // namespace kinora::image
