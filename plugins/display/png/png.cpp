// Display driver "png" (d_Png): the first colour and alpha, sRGB-encoded, 8 bits (or 16). Premultiplied colours are
// written as they are. Further channels do not fit and are left out.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <kinora/display.h>
#include <kinora/math/srgb.h>

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
};

struct Png {
  std::string path;
  OIIO::ImageSpec spec;
  std::vector<bool> isColor;
  bool is16 = false;
  std::vector<unsigned char> bytes;  // the finished file

  explicit Png(const CreateInfo& info) {
    const DisplayInfo& d = *static_cast<const DisplayInfo*>(info.extra);
    path = d.writePath;
    is16 = info.integer(0) == 0;
    const int count = int(std::min<uint32_t>(d.channelCount, 4));
    spec = OIIO::ImageSpec(d.window[2] - d.window[0], d.window[3] - d.window[1], count,
                           is16 ? OIIO::TypeUInt16 : OIIO::TypeUInt8);
    spec.x = d.window[0];
    spec.y = d.window[1];
    spec.full_width = int(d.resolution[0]);
    spec.full_height = int(d.resolution[1]);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);  // colours are not divided by alpha
    if (d.pixelAspect > 0) spec.attribute("PixelAspectRatio", d.pixelAspect);
    for (int c = 0; c < count; ++c) isColor.push_back(d.channels[c].isColor != 0);
    for (uint32_t i = 0; i < d.metadataCount; ++i) {
      const DisplayMetadata& m = d.metadata[i];
      // text is what PNG can hold; matrices belong to EXR
      if (m.type == DisplayMetadataType::String) spec.attribute(m.key, m.text);
      if (m.type == DisplayMetadataType::Int) spec.attribute(m.key, std::to_string(m.integer));
      if (m.type == DisplayMetadataType::Float) spec.attribute(m.key, std::to_string(m.number));
    }
  }

  template <typename Int>
  void encode(const DisplayPixels& p, uint32_t most) {
    const SrgbEncoder encoder(int(most) + 1);
    std::vector<Int> data;
    data.reserve(size_t(spec.width) * size_t(spec.height) * isColor.size());
    for (size_t y = 0; y < size_t(spec.height); ++y)
      for (size_t x = 0; x < size_t(spec.width); ++x)
        for (size_t c = 0; c < isColor.size(); ++c) {
          const float v = p.channels[c][y * p.rowStride + x * p.pixelStride];
          data.push_back(Int(isColor[c] ? encoder.encode(v) : quantizeLinear(v, most)));
        }
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
      d.encode<uint16_t>(*pixels, 65535);
    else
      d.encode<uint8_t>(*pixels, 255);
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
