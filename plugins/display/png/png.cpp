// Display driver "png" (d_Png): the first colour and alpha, sRGB-encoded, 8 bits (or 16). Colours come divided by
// alpha, as PNG means them. Further channels do not fit: a message says which are left out.
#include <OpenImageIO/imageio.h>
#include <kinora/display_codes.h>

#include <iterator>
#include <string>
#include <vector>

#include "../drivers/encoded_file.h"

namespace kinora {
namespace {

const Param kParams[] = {
    param::integer("quantize", 1).range(0, 1).help("1: 8 bits a channel; 0: 16 bits"),
    param::string("view", "")
        .help("OpenColorIO view to look through ($OCIO); \"default\": the configuration's; \"\": plain sRGB"),
};

struct Png {
  EncodedFile file;
  OIIO::ImageSpec spec;
  std::vector<uint32_t> channels;
  std::vector<bool> isLight;
  bool is16 = false;

  explicit Png(const CreateInfo& info) {
    const DisplayInfo& d = *static_cast<const DisplayInfo*>(info.extra);
    file.path = d.writePath;
    is16 = info.integer(0) != 1;
    channels = channelsToLookAt(d, true);
    warnOfChannels(info, d, channels);
    spec = OIIO::ImageSpec(d.window[2] - d.window[0], d.window[3] - d.window[1], int(channels.size()),
                           is16 ? OIIO::TypeUInt16 : OIIO::TypeUInt8);
    spec.x = d.window[0];
    spec.y = d.window[1];
    spec.full_width = int(d.resolution[0]);
    spec.full_height = int(d.resolution[1]);
    stateColorSpace(spec, d);
    spec.attribute("oiio:UnassociatedAlpha", 1);  // else the library divides codes
    if (d.pixelAspect > 0) spec.attribute("PixelAspectRatio", d.pixelAspect);
    for (const uint32_t c : channels) isLight.push_back(d.channels[c].isColor == 1);
    for (uint32_t i = 0; i < d.metadataCount; ++i) {
      const DisplayMetadata& m = d.metadata[i];
      // text is what PNG can hold; matrices belong to EXR
      if (m.type == DisplayMetadataType::String) spec.attribute(m.key, m.text);
      if (m.type == DisplayMetadataType::Int) spec.attribute(m.key, std::to_string(m.integer));
      if (m.type == DisplayMetadataType::Float) spec.attribute(m.key, std::to_string(m.number));
    }
  }

  template <typename Int>
  void encode(const DisplayPixels& p) {
    const std::vector<Int> data = pictureCodes<Int>(p, channels, isLight, size_t(spec.width), size_t(spec.height));
    file.encode("png", "PNG", spec, is16 ? OIIO::TypeUInt16 : OIIO::TypeUInt8, data.data());
  }
  void write(const DisplayPixels& p) {
    if (is16)
      encode<uint16_t>(p);
    else
      encode<uint8_t>(p);
  }
};

int close(void* display, ErrorText* error) { return static_cast<const Png*>(display)->file.write(error); }
void abort(void*) {}

constexpr DisplayTraits kTraits{1};
const DisplayFunctions kFunctions{DriverCalls<Png>::write, close, abort};
const WidthTable kTables[] = {{1, &kFunctions}};
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::Display,
                             0,
                             "png",
                             "PNG pictures to look at: sRGB, 8 or 16 bits, straight alpha.",
                             kParams,
                             std::size(kParams),
                             kTables,
                             1,
                             &kTraits,
                             DriverCalls<Png>::create,
                             DriverCalls<Png>::destroy};
}  // namespace
KINORA_REGISTER(png, kDescriptor)
}  // namespace kinora
