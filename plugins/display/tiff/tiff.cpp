// Display driver "tiff" (d_tiff): any number of channels as 8 or 16 bits (colours sRGB-encoded) or as floats
// (scene-linear). Without a word about it, colours and alpha are 8 bits and a picture with data (depth, ids) is
// floats.
#include <kinora/display_codes.h>
#include <strings.h>

#include <cstring>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "../drivers/picture_file.h"

namespace kinora {
namespace {

enum : uint32_t { kFormat, kQuantize, kCompression, kView };

const Param kParams[] = {
    param::string("format", "").options("uint8|uint16|float32").help("how values are stored; \"\": as quantize says"),
    param::integer("quantize", -1)
        .range(-1, 2)
        .help("1: 8 bits; 0: 16 bits; 2: floats; -1: 8 bits, floats where there is data"),
    param::string("compression", "lzw")
        .options("none|lzw|zip|deflate|packbits")
        .help("How pixels are packed; all are lossless. deflate is another name of zip."),
    param::string("view", "")
        .help("OpenColorIO view to look through ($OCIO); \"default\": the configuration's; \"\": none"),
};

bool hasData(const DisplayInfo& d) {
  for (uint32_t c = 0; c < d.channelCount; ++c)
    if (d.channels[c].type == DisplayPixelType::Float) return true;
  return false;
}

struct Tiff {
  std::vector<uint32_t> channels;
  std::vector<bool> isLight;
  PictureFile file;

  Tiff(const CreateInfo& info, const DisplayInfo& d)
      : channels(d.channelCount), file("tiff", d, d.channelCount, chooseCode(info, d)) {
    std::iota(channels.begin(), channels.end(), 0u);
    for (const uint32_t c : channels) {
      isLight.push_back(d.channels[c].isColor == 1);
      file.channel(d.channels[c].name);
      if (isAlphaChannel(d.channels[c]) && file.format.alphaChannel < 0) file.format.alphaChannel = int(c);
    }
    if (file.format.code == DisplayCode::Float)
      file.attribute("oiio:ColorSpace", "linear");
    else
      stateColorSpace(file, d);
    const char* packing = info.string(kCompression);
    file.attribute("compression", strcasecmp(packing, "deflate") == 0 ? "zip" : packing);
    if (d.pixelAspect > 0) file.attribute("PixelAspectRatio", d.pixelAspect);
    for (uint32_t i = 0; i < d.metadataCount; ++i) {
      const DisplayMetadata& m = d.metadata[i];
      // TIFF knows these two matrices by name
      if (m.type == DisplayMetadataType::Matrix && std::strcmp(m.key, "worldToCamera") == 0)
        file.matrix("worldtocamera", m.matrix);
      if (m.type == DisplayMetadataType::Matrix && std::strcmp(m.key, "worldToNDC") == 0) {
        // its screen runs from -1 to 1, y up
        float screen[16];
        for (int r = 0; r < 4; ++r) {
          const float* row = m.matrix + 4 * r;
          screen[4 * r] = 2 * row[0] - row[3];
          screen[4 * r + 1] = row[3] - 2 * row[1];
          screen[4 * r + 2] = row[2];
          screen[4 * r + 3] = row[3];
        }
        file.matrix("worldtoscreen", screen);
      }
      if (m.type == DisplayMetadataType::String) file.attribute(m.key, m.text);
    }
  }

  static DisplayCode chooseCode(const CreateInfo& info, const DisplayInfo& d) {
    const std::string format = info.string(kFormat);
    DisplayCode code = hasData(d) ? DisplayCode::Float : DisplayCode::UInt8;
    const int quantize = info.integer(kQuantize);
    if (quantize >= 0)
      code = quantize == 1 ? DisplayCode::UInt8 : quantize == 0 ? DisplayCode::UInt16 : DisplayCode::Float;
    if (format == "uint8") code = DisplayCode::UInt8;
    if (format == "uint16") code = DisplayCode::UInt16;
    if (format == "float32" || format == "float") code = DisplayCode::Float;
    if (hasData(d) && code != DisplayCode::Float && info.host && info.host->warn) {
      const std::string what =
          "picture \"" + std::string(d.file) + "\" has channels of data, and integers hold 0 to 1 only";
      info.host->warn(info.host->self, "DISPLAY-CHANNELS", what.c_str(),
                      "values beyond are clamped; format \"float32\" holds them");
    }
    return code;
  }

  void write(const DisplayPixels& p) {
    const uint32_t width = file.width(), height = file.height();
    if (file.format.code == DisplayCode::UInt8)
      return file.whole(pictureCodes<uint8_t>(p, channels, isLight, width, height).data());
    if (file.format.code == DisplayCode::UInt16)
      return file.whole(pictureCodes<uint16_t>(p, channels, isLight, width, height).data());
    file.open();
    std::vector<float> line(width * channels.size());
    for (uint32_t y = 0; y < height; ++y) {
      for (size_t x = 0; x < width; ++x)
        for (size_t k = 0; k < channels.size(); ++k)
          line[x * channels.size() + k] = p.channels[channels[k]][y * p.rowStride + x * p.pixelStride];
      file.rows(y, 1, line.data());
    }
  }
  void close() { file.close(); }
};

}  // namespace
}  // namespace kinora

KINORA_DISPLAY(tiff, Tiff, .help = "TIFF pictures: any channels, 8 or 16 bits (sRGB) or floats.", .params = kParams,
               .pictureFiles = 1)
