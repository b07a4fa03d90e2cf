// Display driver "tiff" (d_tiff): any number of channels as 8 or 16 bits (colours sRGB-encoded) or as floats
// (scene-linear). Without a word about it, colours and alpha are 8 bits and a picture with data (depth, ids) is
// floats.
#include <OpenImageIO/imageio.h>
#include <kinora/display_codes.h>

#include <cstring>
#include <iterator>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "../drivers/encoded_file.h"

namespace kinora {
namespace {

enum : uint32_t { kFormat, kQuantize, kCompression, kView };

const Param kParams[] = {
    param::string("format", "").options("uint8|uint16|float32").help("how values are stored; \"\": as quantize says"),
    param::integer("quantize", -1)
        .range(-1, 2)
        .help("1: 8 bits; 0: 16 bits; 2: floats; -1: 8 bits, floats where there is data"),
    param::string("compression", "lzw")
        .options("none|lzw|zip|packbits")
        .help("How pixels are packed; all are lossless."),
    param::string("view", "")
        .help("OpenColorIO view to look through ($OCIO); \"default\": the configuration's; \"\": none"),
};

// The library may fail without a word.
std::string orUnfinished(const std::string& what) { return what.empty() ? "the file could not be finished" : what; }

struct Tiff {
  std::string path;
  OIIO::ImageSpec spec;
  std::vector<uint32_t> channels;
  std::vector<bool> isLight;
  OIIO::TypeDesc type;
  std::unique_ptr<OIIO::ImageOutput> out;

  explicit Tiff(const CreateInfo& info) {
    const DisplayInfo& d = *static_cast<const DisplayInfo*>(info.extra);
    path = d.writePath;
    bool hasData = false;
    for (uint32_t c = 0; c < d.channelCount; ++c) {
      channels.push_back(c);
      isLight.push_back(d.channels[c].isColor == 1);
      hasData |= d.channels[c].type == DisplayPixelType::Float;
    }
    type = chooseType(info, d, hasData);
    spec = OIIO::ImageSpec(d.window[2] - d.window[0], d.window[3] - d.window[1], int(channels.size()), type);
    spec.x = d.window[0];
    spec.y = d.window[1];
    spec.full_width = int(d.resolution[0]);
    spec.full_height = int(d.resolution[1]);
    spec.channelnames.clear();
    spec.alpha_channel = -1;
    for (const uint32_t c : channels) {
      spec.channelnames.emplace_back(d.channels[c].name);
      if (isAlphaChannel(d.channels[c]) && spec.alpha_channel < 0) spec.alpha_channel = int(c);
    }
    if (type == OIIO::TypeFloat)
      spec.attribute("oiio:ColorSpace", "linear");
    else
      stateColorSpace(spec, d);
    spec.attribute("compression", info.string(kCompression));
    if (d.pixelAspect > 0) spec.attribute("PixelAspectRatio", d.pixelAspect);
    for (uint32_t i = 0; i < d.metadataCount; ++i) {
      const DisplayMetadata& m = d.metadata[i];
      // TIFF knows these two matrices by name
      if (m.type == DisplayMetadataType::Matrix && std::strcmp(m.key, "worldToCamera") == 0)
        spec.attribute("worldtocamera", OIIO::TypeMatrix, m.matrix);
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
        spec.attribute("worldtoscreen", OIIO::TypeMatrix, screen);
      }
      if (m.type == DisplayMetadataType::String) spec.attribute(m.key, m.text);
    }
  }

  static OIIO::TypeDesc chooseType(const CreateInfo& info, const DisplayInfo& d, bool hasData) {
    const std::string format = info.string(kFormat);
    OIIO::TypeDesc type = hasData ? OIIO::TypeFloat : OIIO::TypeUInt8;
    const int quantize = info.integer(kQuantize);
    if (quantize >= 0) type = quantize == 1 ? OIIO::TypeUInt8 : quantize == 0 ? OIIO::TypeUInt16 : OIIO::TypeFloat;
    if (format == "uint8") type = OIIO::TypeUInt8;
    if (format == "uint16") type = OIIO::TypeUInt16;
    if (format == "float32" || format == "float") type = OIIO::TypeFloat;
    if (hasData && type != OIIO::TypeFloat && info.host && info.host->warn) {
      const std::string what =
          "picture \"" + std::string(d.file) + "\" has channels of data, and integers hold 0 to 1 only";
      info.host->warn(info.host->self, "DISPLAY-CHANNELS", what.c_str(),
                      "values beyond are clamped; format \"float32\" holds them");
    }
    return type;
  }

  void write(const DisplayPixels& p) {
    if (!writePixels(p)) throw std::runtime_error(orUnfinished(out->geterror()));
  }
  bool writePixels(const DisplayPixels& p) {
    out = OIIO::ImageOutput::create("tiff");
    if (!out) throw std::runtime_error("this OpenImageIO cannot write TIFF");
    if (!out->open(path, spec)) return false;
    const size_t width = size_t(spec.width), height = size_t(spec.height);
    if (type == OIIO::TypeUInt8)
      return out->write_image(type, pictureCodes<uint8_t>(p, channels, isLight, width, height).data());
    if (type == OIIO::TypeUInt16)
      return out->write_image(type, pictureCodes<uint16_t>(p, channels, isLight, width, height).data());
    std::vector<float> line(width * channels.size());
    for (size_t y = 0; y < height; ++y) {
      for (size_t x = 0; x < width; ++x)
        for (size_t k = 0; k < channels.size(); ++k)
          line[x * channels.size() + k] = p.channels[channels[k]][y * p.rowStride + x * p.pixelStride];
      if (!out->write_scanline(int(y) + spec.y, 0, OIIO::TypeFloat, line.data())) return false;
    }
    return true;
  }

  // The library does not notice a full disk: what was written is read back.
  bool close() {
    if (!out || !out->close()) return false;
    out.reset();
    const auto back = OIIO::ImageInput::open(path);
    if (!back) {
      (void)OIIO::geterror();
      return false;
    }
    std::vector<unsigned char> pixels(back->spec().image_bytes(true));
    return back->spec().width == spec.width && back->spec().height == spec.height &&
           back->read_image(0, 0, 0, back->spec().nchannels, OIIO::TypeUnknown, pixels.data());
  }
};

int close(void* display, ErrorText* error) {
  Tiff& d = *static_cast<Tiff*>(display);
  try {
    return d.close()
               ? 1
               : say(error, d.out ? orUnfinished(d.out->geterror()).c_str() : "what was written cannot be read back");
  } catch (const std::exception& e) {
    return say(error, e.what());
  }
}
void abort(void* display) { static_cast<Tiff*>(display)->out.reset(); }

const DisplayFunctions kFunctions{DriverCalls<Tiff>::write, close, abort};
const WidthTable kTables[] = {{1, &kFunctions}};
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::Display,
                             0,
                             "tiff",
                             "TIFF pictures: any channels, 8 or 16 bits (sRGB) or floats.",
                             kParams,
                             std::size(kParams),
                             kTables,
                             1,
                             nullptr,
                             DriverCalls<Tiff>::create,
                             DriverCalls<Tiff>::destroy};
}  // namespace
KINORA_REGISTER(tiff, kDescriptor)
}  // namespace kinora
