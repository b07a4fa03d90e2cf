// Display driver "openexr" (d_OpenExr): scanline or tiled, any number of layers, half or float, metadata as
// attributes. Colours are written scene-linear as they are. Deep pictures are another driver.
#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfCompression.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTiledOutputFile.h>
#include <half.h>
#include <kinora/display_author.h>
#include <kinora/exr_stream.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace kinora {
namespace {

enum : uint32_t {
  kAsRgba,
  kAsRgbaAlpha,
  kAsRgbaColor,
  kAutoCrop,
  kCompression,
  kLevel,
  kPixelType,
  kForcePar,
  kMetadataCount,
  kStorage,
  kTileSize
};

const Param kParams[] = {
    param::flag("asrgba", true).help("1: Ci, a and z become R G B, A and Z; 0: they keep their names"),
    param::string("asrgbaalphachannel", "").help("channel that becomes A; \"\": a"),
    param::string("asrgbacolorchannel", "").help("channel that becomes R G B; \"\": Ci"),
    param::string("autocrop", "false").options("false|true").help("data window shrinks to the pixels that are not 0"),
    param::string("compression", "zips")
        .options("none|rle|zip|zips|piz|pixar|pxr24|b44|b44a|dwaa|dwab")
        .help("How pixels are packed; none of b44, b44a, dwaa, dwab and pixar alias pxr24 (for floats) is lossless."),
    param::number("compressionlevel", 45).range(0, 500).help("of dwaa and dwab: larger loses more"),
    param::string("exrpixeltype", "half").options("half|float").help("half: colours in half, data in float"),
    param::number("forcepar", 0).range(0, 4).help("pixel aspect ratio to state; 0: the render's"),
    param::integer("metadatacount", 0).range(0, 1000).help("accepted, not needed: exrheader_* parameters are found"),
    param::string("storage", "scanline")
        .options("scanline|tiled")
        .help("Order in the file: whole lines, or tiles of tilesize."),
    param::integer("tilesize", 64).range(8, 1024).help("of tiled storage, pixels"),
};

Imf::Compression compressionNamed(const std::string& name) {
  const std::pair<const char*, Imf::Compression> table[] = {
      {"none", Imf::NO_COMPRESSION},     {"rle", Imf::RLE_COMPRESSION},  {"zip", Imf::ZIP_COMPRESSION},
      {"zips", Imf::ZIPS_COMPRESSION},   {"piz", Imf::PIZ_COMPRESSION},  {"pixar", Imf::PXR24_COMPRESSION},
      {"pxr24", Imf::PXR24_COMPRESSION}, {"b44", Imf::B44_COMPRESSION},  {"b44a", Imf::B44A_COMPRESSION},
      {"dwaa", Imf::DWAA_COMPRESSION},   {"dwab", Imf::DWAB_COMPRESSION}};
  std::string lower = name;
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? char(c + 32) : c;
  for (const auto& [key, value] : table)
    if (lower == key) return value;
  throw std::runtime_error("unknown compression \"" + name + "\"");
}

struct OpenExr {
  std::string path;
  std::unique_ptr<Imf::Header> header;
  std::vector<std::string> names;
  std::vector<bool> isHalf;
  Imath::Box2i window;
  bool isTiled = false, autoCrop = false;
  int tileSize = 64;
  std::unique_ptr<ExrStream> file;

  OpenExr(const CreateInfo& info, const DisplayInfo& d) {
    path = d.writePath;
    window = {{d.window[0], d.window[1]}, {d.window[2] - 1, d.window[3] - 1}};
    const float par = info.number(kForcePar) > 0 ? info.number(kForcePar) : d.pixelAspect;
    header = std::make_unique<Imf::Header>(Imath::Box2i({0, 0}, {int(d.resolution[0]) - 1, int(d.resolution[1]) - 1}),
                                           window, par > 0 ? par : 1.0f, Imath::V2f(0, 0), 1.0f, Imf::INCREASING_Y,
                                           compressionNamed(info.string(kCompression)));
    if (header->compression() == Imf::DWAA_COMPRESSION || header->compression() == Imf::DWAB_COMPRESSION)
      header->dwaCompressionLevel() = info.number(kLevel);
    autoCrop = std::strcmp(info.string(kAutoCrop), "true") == 0;
    isTiled = std::strcmp(info.string(kStorage), "tiled") == 0;
    tileSize = std::min(std::max(info.integer(kTileSize), 8), 1024);
    if (isTiled) header->setTileDescription(Imf::TileDescription(unsigned(tileSize), unsigned(tileSize)));
    const bool allFloat = std::strcmp(info.string(kPixelType), "float") == 0;
    for (uint32_t c = 0; c < d.channelCount; ++c) {
      names.emplace_back(d.channels[c].name);
      isHalf.push_back(!allFloat && d.channels[c].type == DisplayPixelType::Half);
      header->channels().insert(names.back(), Imf::Channel(isHalf.back() ? Imf::HALF : Imf::FLOAT));
    }
    for (uint32_t i = 0; i < d.metadataCount; ++i) addAttribute(d.metadata[i]);
    if (d.screenWindow[2] > 0) {
      // OpenEXR's camera space has x to the left
      header->screenWindowCenter() = Imath::V2f(0 - d.screenWindow[0], d.screenWindow[1]);
      header->screenWindowWidth() = d.screenWindow[2];
    }
    file = std::make_unique<ExrStream>(path);
    if (file->error()) finish();
  }

  void addAttribute(const DisplayMetadata& m) {
    switch (m.type) {
      case DisplayMetadataType::Int:
        header->insert(m.key, Imf::IntAttribute(m.integer));
        break;
      case DisplayMetadataType::Float:
        header->insert(m.key, Imf::FloatAttribute(m.number));
        break;
      case DisplayMetadataType::String:
        header->insert(m.key, Imf::StringAttribute(m.text));
        // the primaries of another working space are not known here
        if (std::strcmp(m.key, "colorSpace") == 0 && std::strncmp(m.text, "linear Rec.709", 14) == 0)
          Imf::addChromaticities(*header, Imf::Chromaticities());  // Rec. 709, D65
        break;
      case DisplayMetadataType::Matrix: {
        Imath::M44f matrix;
        std::memcpy(matrix.getValue(), m.matrix, 16 * sizeof(float));
        header->insert(m.key, Imf::M44fAttribute(matrix));
        break;
      }
    }
  }

  // The smallest box of pixels with a value other than 0; one pixel when there is none.
  Imath::Box2i usedPart(const DisplayPixels& p) const {
    const int w = window.max.x - window.min.x + 1, h = window.max.y - window.min.y + 1;
    Imath::Box2i box;
    for (size_t c = 0; c < names.size(); ++c) {
      if (names[c] == "Z") continue;  // "nothing hit" is not 0
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x)
          if (p.channels[c][size_t(y) * p.rowStride + size_t(x) * p.pixelStride] != 0)
            box.extendBy(Imath::V2i(window.min.x + x, window.min.y + y));
    }
    return box.isEmpty() ? Imath::Box2i(window.min, window.min) : box;
  }

  void encode(const DisplayPixels& p) {
    const Imath::Box2i box = autoCrop ? usedPart(p) : window;
    header->dataWindow() = box;
    const size_t w = size_t(box.max.x - box.min.x + 1), h = size_t(box.max.y - box.min.y + 1);
    Imf::FrameBuffer buffer;
    std::vector<std::vector<half>> halves(names.size());
    std::vector<std::vector<float>> floats(names.size());
    for (size_t c = 0; c < names.size(); ++c) {
      const auto value = [&](size_t x, size_t y) {
        return p.channels[c][(y + size_t(box.min.y - window.min.y)) * p.rowStride +
                             (x + size_t(box.min.x - window.min.x)) * p.pixelStride];
      };
      char* base;
      size_t bytes;
      if (isHalf[c]) {
        halves[c].resize(w * h);
        for (size_t y = 0; y < h; ++y)
          for (size_t x = 0; x < w; ++x) {
            // beyond half's range: its largest number, so that a bright lamp does not become infinity
            const float v = value(x, y);
            halves[c][y * w + x] = half(std::isfinite(v) ? std::min(std::max(v, -65504.0f), 65504.0f) : v);
          }
        base = reinterpret_cast<char*>(halves[c].data());
        bytes = sizeof(half);
      } else {
        floats[c].resize(w * h);
        for (size_t y = 0; y < h; ++y)
          for (size_t x = 0; x < w; ++x) floats[c][y * w + x] = value(x, y);
        base = reinterpret_cast<char*>(floats[c].data());
        bytes = sizeof(float);
      }
      // the library addresses pixel (x, y) as base + x * bytes + y * w * bytes, box coordinates
      const ptrdiff_t origin = (ptrdiff_t(box.min.y) * ptrdiff_t(w) + box.min.x) * ptrdiff_t(bytes);
      buffer.insert(names[c], Imf::Slice(isHalf[c] ? Imf::HALF : Imf::FLOAT, base - origin, bytes, w * bytes));
    }
    if (isTiled) {
      Imf::TiledOutputFile out(*file, *header);
      out.setFrameBuffer(buffer);
      out.writeTiles(0, out.numXTiles() - 1, 0, out.numYTiles() - 1);
    } else {
      Imf::OutputFile out(*file, *header);
      out.setFrameBuffer(buffer);
      out.writePixels(int(h));
    }
  }

  void write(const DisplayPixels& p) {
    try {
      encode(p);
    } catch (const std::exception&) {
      finish();  // what the disk said is clearer than what the library makes of it
      throw;
    }
  }
  void close() { finish(); }
  void finish() const {
    if (const int code = file->finish()) throw std::runtime_error(std::strerror(code));
  }
};

}  // namespace
}  // namespace kinora

KINORA_DISPLAY(openexr, OpenExr, .help = "OpenEXR pictures, scene-linear, with layers and metadata.",
               .params = kParams)
