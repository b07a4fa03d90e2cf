// Display driver "png" (d_Png): the first colour and alpha, sRGB-encoded, 8 bits (or 16). Premultiplied colours are
// written as they are. Further channels do not fit: a message says which are left out.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <kinora/display_codes.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace kinora {
namespace {

const Param kParams[] = {
    param::integer("quantize", 1).range(0, 1).help("1: 8 bits a channel; 0: 16 bits"),
    param::string("view", "").help("OpenColorIO view to look through ($OCIO); \"default\": the configuration's; \"\": plain sRGB"),
};

struct Png {
  std::string path;
  OIIO::ImageSpec spec;
  std::vector<uint32_t> channels;
  std::vector<bool> isLight;
  bool is16 = false;
  std::vector<unsigned char> bytes;  // the finished file

  explicit Png(const CreateInfo& info) {
    const DisplayInfo& d = *static_cast<const DisplayInfo*>(info.extra);
    path = d.writePath;
    is16 = info.integer(0) != 1;
    channels = channelsToLookAt(d, true);
    warnOfChannels(info, d, channels);
    spec = OIIO::ImageSpec(d.window[2] - d.window[0], d.window[3] - d.window[1], int(channels.size()),
                           is16 ? OIIO::TypeUInt16 : OIIO::TypeUInt8);
    spec.x = d.window[0];
    spec.y = d.window[1];
    spec.full_width = int(d.resolution[0]);
    spec.full_height = int(d.resolution[1]);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);  // colours are not divided by alpha
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
    const std::vector<Int> data =
        pictureCodes<Int>(p, channels, isLight, size_t(spec.width), size_t(spec.height));
    // into memory first: the library does not notice a full disk
    OIIO::Filesystem::IOVecOutput memory;
    std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create("png");
    if (!out) throw std::runtime_error("this OpenImageIO cannot write PNG");
    const bool ok = out->set_ioproxy(&memory) && out->open(path, spec) &&
                    out->write_image(is16 ? OIIO::TypeUInt16 : OIIO::TypeUInt8, data.data());
    const std::string why = out->geterror();
    if (!out->close() || !ok) throw std::runtime_error(why.empty() ? "the picture could not be encoded" : why);
    bytes = memory.buffer();
  }
};

int say(ErrorText* error, const char* what) {
  std::snprintf(error->text, sizeof error->text, "%s", what);
  return 0;
}

void* create(const CreateInfo* info, ErrorText* error) {
  try {
    return new Png(*info);
  } catch (const std::exception& e) {
    say(error, e.what());
    return nullptr;
  }
}
void destroy(void* display) { delete static_cast<Png*>(display); }

int write(void* display, const DisplayPixels* pixels, ErrorText* error) {
  Png& d = *static_cast<Png*>(display);
  try {
    if (d.is16)
      d.encode<uint16_t>(*pixels);
    else
      d.encode<uint8_t>(*pixels);
    return 1;
  } catch (const std::exception& e) {
    return say(error, e.what());
  }
}

int close(void* display, ErrorText* error) {
  const Png& d = *static_cast<Png*>(display);
  std::FILE* file = std::fopen(d.path.c_str(), "wb");
  int code = file ? 0 : errno;
  if (file && std::fwrite(d.bytes.data(), 1, d.bytes.size(), file) != d.bytes.size()) code = errno ? errno : EIO;
  if (file && std::fclose(file) != 0 && !code) code = errno;
  return code ? say(error, std::strerror(code)) : 1;
}
void abort(void*) {}

const DisplayFunctions kFunctions{write, close, abort};
const WidthTable kTables[] = {{1, &kFunctions}};
const Descriptor kDescriptor{
    kAbiVersion, sizeof(Descriptor), Kind::Display, 0, "png",   "PNG pictures to look at: sRGB, 8 or 16 bits.",
    kParams,     std::size(kParams), kTables,       1, nullptr, create,
    destroy};
}  // namespace
KINORA_REGISTER(png, kDescriptor)
}  // namespace kinora
