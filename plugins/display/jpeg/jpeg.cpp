// Display driver "jpeg": the first colour, sRGB-encoded, 8 bits. JPEG has no alpha: premultiplied colours stand on
// black. Further channels do not fit: a message says which are left out.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <kinora/display_codes.h>

#include <algorithm>
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
    param::integer("quality", 95).range(1, 100).help("of the compression; 100 is nearest to the picture and largest"),
    param::string("view", "")
        .help("OpenColorIO view to look through ($OCIO); \"default\": the configuration's; \"\": plain sRGB"),
};

constexpr int kMostSide = 65500;  // libjpeg's

struct Jpeg {
  std::string path;
  OIIO::ImageSpec spec;
  std::vector<uint32_t> channels;
  std::vector<bool> isLight;
  std::vector<unsigned char> bytes;  // the finished file

  explicit Jpeg(const CreateInfo& info) {
    const DisplayInfo& d = *static_cast<const DisplayInfo*>(info.extra);
    path = d.writePath;
    channels = channelsToLookAt(d, false);
    warnOfChannels(info, d, channels);
    for (const uint32_t c : channels) isLight.push_back(d.channels[c].isColor == 1);
    const int width = d.window[2] - d.window[0], height = d.window[3] - d.window[1];
    if (width > kMostSide || height > kMostSide)
      throw std::runtime_error("JPEG holds at most 65500 pixels on a side");
    spec = OIIO::ImageSpec(width, height, int(channels.size()), OIIO::TypeUInt8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("CompressionQuality", std::clamp(info.integer(0), 1, 100));
    spec.attribute("jpeg:subsampling", "4:4:4");  // coloured edges stay sharp
    if (d.pixelAspect > 0) spec.attribute("PixelAspectRatio", d.pixelAspect);
    for (uint32_t i = 0; i < d.metadataCount; ++i)
      if (d.metadata[i].type == DisplayMetadataType::String) spec.attribute(d.metadata[i].key, d.metadata[i].text);
  }

  void encode(const DisplayPixels& p) {
    const auto data = pictureCodes<uint8_t>(p, channels, isLight, size_t(spec.width), size_t(spec.height));
    // into memory first: the library does not notice a full disk
    OIIO::Filesystem::IOVecOutput memory;
    std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create("jpeg");
    if (!out) throw std::runtime_error("this OpenImageIO cannot write JPEG");
    const bool ok =
        out->set_ioproxy(&memory) && out->open(path, spec) && out->write_image(OIIO::TypeUInt8, data.data());
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
    return new Jpeg(*info);
  } catch (const std::exception& e) {
    say(error, e.what());
    return nullptr;
  }
}
void destroy(void* display) { delete static_cast<Jpeg*>(display); }

int write(void* display, const DisplayPixels* pixels, ErrorText* error) {
  Jpeg& d = *static_cast<Jpeg*>(display);
  try {
    d.encode(*pixels);
    return 1;
  } catch (const std::exception& e) {
    return say(error, e.what());
  }
}

int close(void* display, ErrorText* error) {
  const Jpeg& d = *static_cast<Jpeg*>(display);
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
    kAbiVersion, sizeof(Descriptor), Kind::Display, 0, "jpeg",  "JPEG pictures to look at: sRGB, 8 bits, no alpha.",
    kParams,     std::size(kParams), kTables,       1, nullptr, create,
    destroy};
}  // namespace
KINORA_REGISTER(jpeg, kDescriptor)
}  // namespace kinora
