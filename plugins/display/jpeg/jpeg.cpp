// Display driver "jpeg": the first colour, sRGB-encoded, 8 bits. JPEG has no alpha: premultiplied colours stand on
// black. Further channels do not fit: a message says which are left out.
#include <OpenImageIO/imageio.h>
#include <kinora/display_codes.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "../drivers/encoded_file.h"

namespace kinora {
namespace {

const Param kParams[] = {
    param::integer("quality", 95).range(1, 100).help("of the compression; 100 is nearest to the picture and largest"),
    param::string("view", "")
        .help("OpenColorIO view to look through ($OCIO); \"default\": the configuration's; \"\": plain sRGB"),
};

constexpr int kMostSide = 65500;  // libjpeg's

struct Jpeg {
  EncodedFile file;
  OIIO::ImageSpec spec;
  std::vector<uint32_t> channels;
  std::vector<bool> isLight;

  explicit Jpeg(const CreateInfo& info) {
    const DisplayInfo& d = *static_cast<const DisplayInfo*>(info.extra);
    file.path = d.writePath;
    channels = channelsToLookAt(d, false);
    warnOfChannels(info, d, channels);
    for (const uint32_t c : channels) isLight.push_back(d.channels[c].isColor == 1);
    const int width = d.window[2] - d.window[0], height = d.window[3] - d.window[1];
    if (width > kMostSide || height > kMostSide)
      throw std::runtime_error("JPEG holds at most 65500 pixels on a side");
    spec = OIIO::ImageSpec(width, height, int(channels.size()), OIIO::TypeUInt8);
    stateColorSpace(spec, d);
    spec.attribute("CompressionQuality", std::clamp(info.integer(0), 1, 100));
    spec.attribute("jpeg:subsampling", "4:4:4");  // coloured edges stay sharp
    if (d.pixelAspect > 0) spec.attribute("PixelAspectRatio", d.pixelAspect);
    for (uint32_t i = 0; i < d.metadataCount; ++i)
      if (d.metadata[i].type == DisplayMetadataType::String) spec.attribute(d.metadata[i].key, d.metadata[i].text);
  }

  void write(const DisplayPixels& p) {
    const auto data = pictureCodes<uint8_t>(p, channels, isLight, size_t(spec.width), size_t(spec.height));
    file.encode("jpeg", "JPEG", spec, OIIO::TypeUInt8, data.data());
  }
};

int close(void* display, ErrorText* error) { return static_cast<const Jpeg*>(display)->file.write(error); }
void abort(void*) {}

const DisplayFunctions kFunctions{DriverCalls<Jpeg>::write, close, abort};
const WidthTable kTables[] = {{1, &kFunctions}};
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::Display,
                             0,
                             "jpeg",
                             "JPEG pictures to look at: sRGB, 8 bits, no alpha.",
                             kParams,
                             std::size(kParams),
                             kTables,
                             1,
                             nullptr,
                             DriverCalls<Jpeg>::create,
                             DriverCalls<Jpeg>::destroy};
}  // namespace
KINORA_REGISTER(jpeg, kDescriptor)
}  // namespace kinora
