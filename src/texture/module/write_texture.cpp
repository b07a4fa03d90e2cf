#include "texture/module/write_texture.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <vector>

#include "texture/area_average.h"
#include "texture/module/srgb_input.h"
#include "texture/module/texture_files.h"

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

// The display window of the image as floats; "" or why not. Colours stay as the file stores them beside alpha, as
// they do in textures that are not prepared.
std::string readSource(const FileFacts& facts, const MakeTextureOptions& options, OIIO::ImageBuf& image) {
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  image.reset(facts.path, 0, 0, nullptr, &config);
  if (!image.read(0, 0, true, OIIO::TypeFloat)) return firstLine(image.geterror());
  if (options.linearize)
    decodeSrgb(static_cast<float*>(image.localpixels()), size_t(facts.width) * size_t(facts.height), facts.channels,
               facts.alphaChannel, facts.bytes);
  if (image.roi() != image.roi_full() || image.xbegin() != 0 || image.ybegin() != 0)
    image = OIIO::ImageBufAlgo::cut(image, image.roi_full());
  if (options.resize != "none" && !options.resize.empty()) {
    const int w = powerOfTwo(image.spec().width, options.resize), h = powerOfTwo(image.spec().height, options.resize);
    if (w != image.spec().width || h != image.spec().height)
      image = OIIO::ImageBufAlgo::resize(image, "", 0, OIIO::ROI(0, w, 0, h));
  }
  return image.has_error() ? firstLine(image.geterror()) : "";
}

// The header of the finest level.
OIIO::ImageSpec textureSpec(const OIIO::ImageBuf& image, const FileFacts& facts, const MakeTextureOptions& options) {
  OIIO::ImageSpec spec = image.spec();
  const auto& type = options.type;
  spec.set_format(type == "byte"                     ? OIIO::TypeDesc(OIIO::TypeDesc::UINT8)
                  : type == "short"                  ? OIIO::TypeDesc(OIIO::TypeDesc::UINT16)
                  : type == "half"                   ? OIIO::TypeDesc(OIIO::TypeDesc::HALF)
                  : type == "float"                  ? OIIO::TypeDesc(OIIO::TypeDesc::FLOAT)
                  : options.linearize && facts.bytes ? OIIO::TypeDesc(OIIO::TypeDesc::HALF)
                                                     : facts.format);
  spec.channelformats.clear();
  spec.tile_width = spec.tile_height = options.tileSize;
  spec.tile_depth = 1;
  // what the source said of its own levels, tiles, pixels and orientation
  for (const char* name :
       {"oiio:SHA-1", "oiio:ConstantColor", "oiio:AverageColor", "oiio:BitsPerSample", "Orientation", "compression",
        "tiff:Compression", "planarconfig", "tiff:PlanarConfiguration", "tiff:RowsPerStrip", "wrapmodes",
        "openexr:levelmode", "openexr:roundingmode"})
    spec.erase_attribute(name);
  if (options.linearize) spec.attribute("oiio:ColorSpace", "Linear");
  spec.attribute("textureformat", options.latlong ? "LatLong Environment" : "Plain Texture");
  spec.attribute("wrapmodes", options.wrapS + "," + options.wrapT);
  spec.attribute("fovcot", float(spec.width) / float(spec.height));
  spec.attribute("compression", options.compression.empty() ? "zip" : options.compression);
  spec.attribute("planarconfig", "contig");
  if (!options.mipMapped) spec.attribute("openexr:levelmode", 0);
  return spec;
}

// Values that an integer type can hold. What rounding takes from one texel the next one gets: rounding every texel
// alone moves the mean of images of few or dark shades.
void roundToSteps(OIIO::ImageBuf& level, double steps) {
  const size_t channels = size_t(level.nchannels());
  std::vector<double> owed(channels, 0.);
  float* v = static_cast<float*>(level.localpixels());
  const size_t texels = size_t(level.spec().width) * size_t(level.spec().height);
  for (size_t i = 0; i < texels; ++i)
    for (size_t c = 0; c < channels; ++c, ++v) {
      const double want = double(*v) * steps + owed[c], got = std::clamp(std::nearbyint(want), 0., steps);
      owed[c] = want - got;
      *v = float(got / steps);
    }
}

OIIO::ImageBuf coarser(const OIIO::ImageBuf& fine, const std::string& filter) {
  const LevelSize from{fine.spec().width, fine.spec().height}, to{coarserSide(from.width), coarserSide(from.height)};
  if (filter != "box") return OIIO::ImageBufAlgo::resize(fine, filter, 0, OIIO::ROI(0, to.width, 0, to.height));
  OIIO::ImageSpec spec = fine.spec();
  spec.width = spec.full_width = to.width;
  spec.height = spec.full_height = to.height;
  OIIO::ImageBuf level(spec);
  averageAreas(static_cast<const float*>(fine.localpixels()), from, to, {0, 0, to.width, to.height}, spec.nchannels,
               static_cast<float*>(level.localpixels()));
  return level;
}

// The texture with all of its levels; "" or why not.
std::string writeLevels(OIIO::ImageBuf& image, OIIO::ImageSpec spec, const MakeTextureOptions& options,
                        const std::string& file) {
  auto output = options.format.empty()
                    ? OIIO::ImageOutput::create(file)
                    : OIIO::ImageOutput::create(options.format == "pixar" ? "tiff" : options.format);
  if (!output && options.format.empty()) {
    // names that say no format, as those of txmake do (.tex, .env), are of the one that .tx is
    (void)OIIO::geterror();
    output = OIIO::ImageOutput::create("tiff");
  }
  if (!output) return firstLine(OIIO::geterror());
  // TIFF's levels are images of their own
  const auto append =
      output->supports("mipmap") ? OIIO::ImageOutput::AppendMIPLevel : OIIO::ImageOutput::AppendSubimage;
  if (!output->supports("tiles") ||
      (options.mipMapped && append == OIIO::ImageOutput::AppendSubimage && !output->supports("multiimage")))
    return std::string("files of the format '") + output->format_name() + "' have no tiles or mip levels";
  const double steps = spec.format == OIIO::TypeUInt8 ? 255. : spec.format == OIIO::TypeUInt16 ? 65535. : 0.;
  if (steps > 0) {  // before levels are made of what cannot be stored
    float* v = static_cast<float*>(image.localpixels());
    const size_t count = size_t(spec.width) * size_t(spec.height) * size_t(spec.nchannels);
    for (size_t i = 0; i < count; ++i) v[i] = std::clamp(v[i], 0.f, 1.f);
  }
  for (int number = 0;; ++number) {
    spec.width = spec.full_width = image.spec().width;
    spec.height = spec.full_height = image.spec().height;
    const auto mode = number ? append : OIIO::ImageOutput::Create;
    if (!output->open(file, spec, mode)) return firstLine(output->geterror());
    const bool isLast = !options.mipMapped || (spec.width == 1 && spec.height == 1);
    OIIO::ImageBuf stored;  // rounded; the next level is made of what is not
    if (steps > 0 && number > 0) {
      stored = image;
      roundToSteps(stored, steps);
    }
    const OIIO::ImageBuf& pixels = stored.initialized() ? stored : image;
    if (!output->write_image(OIIO::TypeFloat, pixels.localpixels())) return firstLine(output->geterror());
    if (isLast) break;
    image = coarser(image, options.filter);
    if (image.has_error()) return firstLine(image.geterror());
  }
  if (!output->close()) return firstLine(output->geterror());
  return "";
}

}  // namespace

MakeTextureResult writeTexture(const std::string& input, const std::string& output, const MakeTextureOptions& options,
                               std::string& why) {
  FileFacts facts;
  why = examine(input, facts);
  if (!why.empty()) return MakeTextureResult::BadInput;
  namespace fs = std::filesystem;
  // beside the target, with its ending, by which a format is chosen
  const fs::path target(output);
  const fs::path temporary =
      target.parent_path() / ("." + target.stem().string() + ".making" + target.extension().string());
  std::error_code ignored;
  if (fs::exists(target, ignored) && !fs::is_regular_file(target, ignored)) {
    why = output + " is no regular file";
    return MakeTextureResult::CannotWrite;
  }
  try {
    OIIO::ImageBuf image;
    why = readSource(facts, options, image);
    if (!why.empty()) return MakeTextureResult::BadInput;
    if (options.threads > 0) OIIO::attribute("threads", options.threads);
    why = writeLevels(image, textureSpec(image, facts, options), options, temporary.string());
    if (!why.empty()) {
      fs::remove(temporary, ignored);
      return MakeTextureResult::CannotWrite;
    }
    fs::rename(temporary, target);
    return MakeTextureResult::Made;
  } catch (const std::exception& e) {
    why = e.what();
    fs::remove(temporary, ignored);
    return MakeTextureResult::CannotWrite;
  }
}

}  // namespace kinora::texture
