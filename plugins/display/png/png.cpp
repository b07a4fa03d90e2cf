// Display driver "png" (d_Png): the first colour and alpha, sRGB-encoded, 8 bits (or 16). Colours come divided by
// alpha, as PNG means them. Further channels do not fit: a message says which are left out.
#include <kinora/display_codes.h>

#include <string>
#include <vector>

#include "../drivers/picture_file.h"

namespace kinora {
namespace {

const Param kParams[] = {
    param::flag("quantize", true).help("1: 8 bits a channel; 0: 16 bits"),
    param::string("view", "")
        .help("OpenColorIO view to look through ($OCIO); \"default\": the configuration's; \"\": plain sRGB"),
};

struct Png {
  std::vector<uint32_t> channels;
  std::vector<bool> isLight;
  bool is16;
  PictureFile file;

  Png(const CreateInfo& info, const DisplayInfo& d)
      : channels(channelsToLookAt(d, true)),
        is16(info.integer(0) != 1),
        file("png", d, uint32_t(channels.size()), is16 ? DisplayCode::UInt16 : DisplayCode::UInt8) {
    warnOfChannels(info, d, channels);
    stateColorSpace(file, d);
    file.attribute("oiio:UnassociatedAlpha", 1);  // else the library divides codes
    if (d.pixelAspect > 0) file.attribute("PixelAspectRatio", d.pixelAspect);
    for (const uint32_t c : channels) isLight.push_back(d.channels[c].isColor == 1);
    for (uint32_t i = 0; i < d.metadataCount; ++i) {
      const DisplayMetadata& m = d.metadata[i];
      // text is what PNG can hold; matrices belong to EXR
      if (m.type == DisplayMetadataType::String) file.attribute(m.key, m.text);
      if (m.type == DisplayMetadataType::Int) file.attribute(m.key, std::to_string(m.integer));
      if (m.type == DisplayMetadataType::Float) file.attribute(m.key, std::to_string(m.number));
    }
  }

  void write(const DisplayPixels& p) {
    if (is16)
      file.whole(pictureCodes<uint16_t>(p, channels, isLight, file.width(), file.height()).data());
    else
      file.whole(pictureCodes<uint8_t>(p, channels, isLight, file.width(), file.height()).data());
  }
  void close() { file.close(); }
};

}  // namespace
}  // namespace kinora

KINORA_DISPLAY(png, Png, .help = "PNG pictures to look at: sRGB, 8 or 16 bits, straight alpha.", .params = kParams,
               .straightAlpha = 1, .pictureFiles = 1)
