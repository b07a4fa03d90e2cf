// Display driver "jpeg": the first colour, sRGB-encoded, 8 bits. JPEG has no alpha: premultiplied colours stand on
// black. Further channels do not fit: a message says which are left out.
#include <kinora/display_codes.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "../drivers/picture_file.h"

namespace kinora {
namespace {

const Param kParams[] = {
    param::integer("quality", 95).range(1, 100).help("of the compression; 100 is nearest to the picture and largest"),
    param::string("view", "")
        .help("OpenColorIO view to look through ($OCIO); \"default\": the configuration's; \"\": plain sRGB"),
};

constexpr uint32_t kMostSide = 65500;  // libjpeg's

struct Jpeg {
  std::vector<uint32_t> channels;
  std::vector<bool> isLight;
  PictureFile file;

  Jpeg(const CreateInfo& info, const DisplayInfo& d)
      : channels(channelsToLookAt(d, false)), file("jpeg", d, uint32_t(channels.size()), DisplayCode::UInt8) {
    warnOfChannels(info, d, channels);
    for (const uint32_t c : channels) isLight.push_back(d.channels[c].isColor == 1);
    if (file.width() > kMostSide || file.height() > kMostSide)
      throw std::runtime_error("JPEG holds at most 65500 pixels on a side");
    // the format has no place for a window in a larger picture
    file.format.resolution[0] = uint32_t(file.format.window[2] -= file.format.window[0]);
    file.format.resolution[1] = uint32_t(file.format.window[3] -= file.format.window[1]);
    file.format.window[0] = file.format.window[1] = 0;
    stateColorSpace(file, d);
    file.attribute("CompressionQuality", std::clamp(info.integer(0), 1, 100));
    file.attribute("jpeg:subsampling", "4:4:4");  // coloured edges stay sharp
    if (d.pixelAspect > 0) file.attribute("PixelAspectRatio", d.pixelAspect);
    for (uint32_t i = 0; i < d.metadataCount; ++i)
      if (d.metadata[i].type == DisplayMetadataType::String) file.attribute(d.metadata[i].key, d.metadata[i].text);
  }

  void write(const DisplayPixels& p) {
    file.whole(pictureCodes<uint8_t>(p, channels, isLight, file.width(), file.height()).data());
  }
  void close() { file.close(); }
};

}  // namespace
}  // namespace kinora

KINORA_DISPLAY(jpeg, Jpeg, .help = "JPEG pictures to look at: sRGB, 8 bits, no alpha.", .params = kParams,
               .pictureFiles = 1)
