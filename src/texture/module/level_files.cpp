#include "texture/module/level_files.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "base/digest.h"
#include "image/atomic_file.h"
#include "texture/module/texture_files.h"

namespace kinora::texture {
namespace {
namespace fs = std::filesystem;

constexpr int kKeptTileSide = 64;
constexpr uint64_t kVersion = 1;  // of what is written

// A name that any file system takes.
std::string nameOf(const std::string& source, const std::string& inCache) {
  std::error_code ec;
  const auto size = fs::file_size(source, ec);
  const auto time = fs::last_write_time(source, ec).time_since_epoch().count();
  const char* colors = std::getenv("OCIO");
  Hasher h;
  h.word(kVersion);
  h.text(image::wholeName(source));
  h.word(uint64_t(size));
  h.word(uint64_t(time));
  h.text(inCache);
  h.text(colors ? colors : "");
  std::string stem = fs::path(source).stem().string().substr(0, 60);
  for (char& c : stem)
    if (!std::isalnum(uint8_t(c)) && c != '-') c = '_';
  return stem + '-' + h.result().str();
}

std::string firstLineOf(std::string text) {
  if (const size_t line = text.find('\n'); line != std::string::npos) text.resize(line);
  return text;
}

// Levels [first, last) of a picture in the cache; "" or what failed.
std::string writeFile(OIIO::ImageCache& cache, OIIO::ImageCache::Perthread* thread, OIIO::ustring name, int first,
                      int last, const std::string& target) {
  image::AtomicFile file(target);
  auto* const handle = cache.get_image_handle(name, thread);
  auto out = OIIO::ImageOutput::create("tiff");
  if (!handle || !out) return firstLineOf(handle ? OIIO::geterror() : cache.geterror());
  for (int level = first; level < last; ++level) {
    const OIIO::ImageSpec* held = cache.imagespec(handle, thread, 0, level);
    if (!held) return firstLineOf(cache.geterror());
    const bool isWhole = held->format == OIIO::TypeUInt8 || held->format == OIIO::TypeUInt16;
    OIIO::ImageSpec spec(held->width, held->height, held->nchannels, isWhole ? held->format : OIIO::TypeFloat);
    spec.tile_width = spec.tile_height = kKeptTileSide;
    spec.alpha_channel = -1;  // values as they are
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.attribute("textureformat", "Plain Texture");
    spec.attribute("compression", "zip");
    spec.attribute("planarconfig", "contig");
    const auto mode = level == first ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage;
    if (!out->open(file.path(), spec, mode)) return firstLineOf(out->geterror());
    std::vector<char> rows(spec.pixel_bytes() * size_t(spec.width) * size_t(kKeptTileSide));
    for (int y = 0; y < spec.height; y += kKeptTileSide) {
      const int end = std::min(y + kKeptTileSide, spec.height);
      if (!cache.get_pixels(handle, thread, 0, level, 0, spec.width, y, end, 0, 1, 0, spec.nchannels, spec.format,
                            rows.data()))
        return firstLineOf(cache.geterror());
      if (!out->write_tiles(0, spec.width, y, end, 0, 1, spec.format, rows.data()))
        return firstLineOf(out->geterror());
    }
  }
  if (!out->close()) return firstLineOf(out->geterror());
  const auto status = file.commit();
  return status.ok() ? "" : status.what;
}

}  // namespace

std::string keepLevels(OIIO::ImageCache& cache, OIIO::ImageCache::Perthread* thread, const std::string& folder,
                       const std::string& source, OIIO::ustring finest, OIIO::ustring levels, LevelFiles& out) {
  static const OIIO::ustring kLevels("miplevels");
  int count = 0;
  auto* const handle = cache.get_image_handle(levels, thread);
  if (!handle || !cache.get_image_info(handle, thread, 0, 0, kLevels, OIIO::TypeInt, &count))
    return firstLineOf(cache.geterror());
  const auto* spec = cache.imagespec(handle, thread, 0, 0);
  if (count < 2 || !spec || spec->nchannels > 8) return "it has no levels";
  std::error_code ec;
  fs::create_directories(folder, ec);
  const std::string stem = (fs::path(folder) / nameOf(source, finest.string())).string();
  out = {stem + ".tif", stem + "-levels.tif"};
  FileFacts facts;
  // the coarser ones come last: where they are, all is
  if (examine(out.coarser, facts).empty() && examine(out.finest, facts).empty() && facts.width == spec->width &&
      facts.height == spec->height && facts.channels == spec->nchannels)
    return "";
  std::string why = writeFile(cache, thread, finest, 0, 1, out.finest);
  if (why.empty()) why = writeFile(cache, thread, levels, 1, count, out.coarser);
  return why;
}

}  // namespace kinora::texture
