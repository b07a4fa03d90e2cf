#include "texture/make_texture.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <exception>
#include <filesystem>

#include "texture/srgb_input.h"
#include "texture/texture_files.h"

namespace kinora::texture {
namespace {

std::string firstLine(std::string text) {
  if (const size_t line = text.find('\n'); line != std::string::npos) text.resize(line);
  return text;
}

// Side of a power of two by the mode: the next one up, down, or the nearer.
int powerOfTwo(int side, const std::string& mode) {
  int below = 1;
  while (below * 2 <= side) below *= 2;
  if (below == side || mode.rfind("down", 0) == 0) return below;
  const bool up = mode.rfind("up", 0) == 0 || side - below > 2 * below - side;
  return up ? 2 * below : below;
}

}  // namespace

MakeTextureResult makeTexture(const std::string& input, const std::string& output, const MakeTextureOptions& options,
                              std::string& why) {
  FileFacts facts;
  why = examine(input, facts);
  if (!why.empty()) return MakeTextureResult::BadInput;
  namespace fs = std::filesystem;
  // beside the target, with its ending, by which a format is chosen
  const fs::path target(output);
  const fs::path temporary =
      target.parent_path() / ("." + target.stem().string() + ".making" + target.extension().string());
  try {
    OIIO::ImageBuf image(input);
    if (!image.read(0, 0, true, OIIO::TypeFloat)) {
      why = firstLine(image.geterror());
      return MakeTextureResult::BadInput;
    }
    if (options.linearize)
      decodeSrgb(static_cast<float*>(image.localpixels()), size_t(facts.width) * size_t(facts.height), facts.channels,
                 facts.alphaChannel, facts.bytes);
    if (options.resize != "none" && !options.resize.empty()) {
      const int w = powerOfTwo(facts.width, options.resize), h = powerOfTwo(facts.height, options.resize);
      if (w != facts.width || h != facts.height)
        image = OIIO::ImageBufAlgo::resize(image, "", 0, OIIO::ROI(0, w, 0, h));
    }
    OIIO::ImageSpec config;
    const auto& type = options.type;
    config.set_format(type == "byte"                     ? OIIO::TypeDesc(OIIO::TypeDesc::UINT8)
                      : type == "short"                  ? OIIO::TypeDesc(OIIO::TypeDesc::UINT16)
                      : type == "half"                   ? OIIO::TypeDesc(OIIO::TypeDesc::HALF)
                      : type == "float"                  ? OIIO::TypeDesc(OIIO::TypeDesc::FLOAT)
                      : options.linearize && facts.bytes ? OIIO::TypeDesc(OIIO::TypeDesc::HALF)
                                                         : image.nativespec().format);
    config.tile_width = config.tile_height = options.tileSize;
    config.tile_depth = 1;
    config.attribute("wrapmodes", options.wrapS + "," + options.wrapT);
    config.attribute("maketx:filtername", options.filter);
    config.attribute("maketx:nomipmap", options.mipMapped ? 0 : 1);
    if (!options.format.empty())
      config.attribute("maketx:fileformatname", options.format == "pixar" ? "tiff" : options.format);
    if (!options.compression.empty()) config.attribute("compression", options.compression);
    if (options.threads > 0) OIIO::attribute("threads", options.threads);
    const auto mode = options.latlong ? OIIO::ImageBufAlgo::MakeTxEnvLatl : OIIO::ImageBufAlgo::MakeTxTexture;
    if (!OIIO::ImageBufAlgo::make_texture(mode, image, temporary.string(), config)) {
      why = firstLine(OIIO::geterror());
      std::error_code ignored;
      fs::remove(temporary, ignored);
      return MakeTextureResult::CannotWrite;
    }
    fs::rename(temporary, target);
    why.clear();
    return MakeTextureResult::Made;
  } catch (const std::exception& e) {
    why = e.what();
    std::error_code ignored;
    fs::remove(temporary, ignored);
    return MakeTextureResult::CannotWrite;
  }
}

}  // namespace kinora::texture
