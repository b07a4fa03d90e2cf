#include "texture/module/texture_files.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "base/file_search.h"
#include "base/text.h"
#include "image/module/pixels.h"
#include "image/volume_file.h"

namespace kinora::texture {
namespace {
namespace fs = std::filesystem;

// Most that a byte of a file can unpack to: deflate reaches 1,032, TIFF's LZW about 2,500.
constexpr double kMaxExpansion = 4096;
constexpr int kMaxSide = 1 << 20, kMaxChannels = 1024;
// A tile is held whole: the library ends the program when one is larger than ten times the cache's budget. Coarse
// levels of a file without them are made of the whole display window.
constexpr double kMaxTileBytes = 1 << 26, kMaxDisplayPixels = 1 << 28;
constexpr int kMaxLevels = 32;
constexpr const char* kExtensions[] = {".tx",  ".tex",  ".exr", ".tif", ".tiff", ".png",
                                       ".jpg", ".jpeg", ".hdr", ".tga", ".bmp"};

// "" or what is not believed of one level's header.
std::string disbelief(const OIIO::ImageSpec& spec, double fileBytes) {
  const auto numbers = [&](const char* what) {
    return "its header promises " + std::to_string(spec.width) + " x " + std::to_string(spec.height) + " pixels of " +
           std::to_string(spec.nchannels) + " channels, " + what;
  };
  if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0) return "it holds no pixels";
  if (spec.deep || spec.depth > 1) return "it is a deep or volume image";
  if (!image::blocksAreBelievable(spec)) return "its strips or tiles have a size that is not believed";
  if (spec.width > kMaxSide || spec.height > kMaxSide || spec.nchannels > kMaxChannels ||
      double(spec.width) * spec.height * double(spec.pixel_bytes(true)) > fileBytes * kMaxExpansion)
    return numbers("more than its size can hold");
  if (double(spec.tile_width) * std::max(spec.tile_height, 1) * spec.nchannels * sizeof(float) > kMaxTileBytes)
    return numbers("in tiles of more than 64 MB");
  for (int64_t x : {int64_t(spec.x), int64_t(spec.y), int64_t(spec.full_x), int64_t(spec.full_y)})
    if (std::abs(x) > kMaxSide) return numbers("far outside of every picture");
  if (spec.full_width > kMaxSide || spec.full_height > kMaxSide ||
      double(spec.full_width) * spec.full_height > kMaxDisplayPixels)
    return numbers("within a picture that is too large");
  return "";
}

// By the file's first word.
bool isPtex(const std::string& path) {
  char word[4] = {};
  return std::ifstream(path, std::ios::binary).read(word, 4) && std::string_view(word, 4) == "Ptex";
}

bool isFile(const fs::path& p) {
  std::error_code ec;
  return fs::is_regular_file(p, ec);
}

enum class Token { None, Udim, LowerUv, UpperUv, MapId };
Token findToken(const std::string& name, size_t& at, size_t& length) {
  static const struct {
    const char* text;
    Token token;
  } kTokens[] = {{"<UDIM>", Token::Udim},     {"<udim>", Token::Udim},     {"%(UDIM)d", Token::Udim},
                 {"<u>_<v>", Token::LowerUv}, {"<U>_<V>", Token::UpperUv}, {"_MAPID_", Token::MapId}};
  for (const auto& t : kTokens) {
    at = name.rfind(t.text);
    length = std::string(t.text).size();
    if (at != std::string::npos) return t.token;
  }
  return Token::None;
}

bool readNumber(const std::string& text, size_t& at, int& value) {
  const size_t begin = at;
  for (value = 0; at < text.size() && std::isdigit(static_cast<unsigned char>(text[at])) && at - begin < 5; ++at)
    value = value * 10 + (text[at] - '0');
  return at > begin;
}

// "1012" -> (1, 1)
bool parseUdim(const std::string& text, AtlasTile& tile) {
  size_t at = 0;
  int number = 0;
  if (text.size() != 4 || !readNumber(text, at, number) || at != 4 || number < 1001) return false;
  tile.u = (number - 1001) % 10;
  tile.v = (number - 1001) / 10;
  return true;
}
// "u0_v1" counts from 0, "U1_V2" from 1
bool parseUv(const std::string& text, bool upper, AtlasTile& tile) {
  size_t at = 1;
  if (text.size() < 5 || text[0] != (upper ? 'U' : 'u') || !readNumber(text, at, tile.u)) return false;
  if (at + 2 > text.size() || text[at] != '_' || text[at + 1] != (upper ? 'V' : 'v')) return false;
  at += 2;
  if (!readNumber(text, at, tile.v) || at != text.size()) return false;
  if (upper) --tile.u, --tile.v;
  return tile.u >= 0 && tile.v >= 0 && tile.u < kMaxAtlasSide && tile.v < kMaxAtlasSide;
}
bool parseToken(Token token, const std::string& text, AtlasTile& tile) {
  switch (token) {
    case Token::Udim:
      return parseUdim(text, tile);
    case Token::LowerUv:
      return parseUv(text, false, tile);
    case Token::UpperUv:
      return parseUv(text, true, tile);
    case Token::MapId:
      return parseUdim(text, tile) || parseUv(text, false, tile) || parseUv(text, true, tile);
    case Token::None:
      break;
  }
  return false;
}

}  // namespace

std::string examine(const std::string& path, FileFacts& facts) {
  try {
    std::error_code ec;
    const double fileBytes = double(fs::file_size(path, ec));
    if (ec) return "it cannot be read (" + ec.message() + ")";
    if (fileBytes == 0) return "it is empty";
    if (image::holdsVolumes(path)) return "it holds volumes (OpenVDB), no picture";
    if (isPtex(path))
      return "it is a Ptex file, of which there is no reader; bake it to a texture over st, or an atlas";
    auto input = OIIO::ImageInput::open(path);
    if (!input) {
      std::string why = OIIO::geterror();
      if (const size_t line = why.find('\n'); line != std::string::npos) why.resize(line);
      return "it is no image that can be read (" + why + ")";
    }
    const OIIO::ImageSpec& spec = input->spec();
    if (std::string why = disbelief(spec, fileBytes); !why.empty()) return why;
    facts.path = path;
    facts.width = spec.width;
    facts.height = spec.height;
    facts.channels = spec.nchannels;
    facts.alphaChannel = spec.alpha_channel;
    facts.tiled = spec.tile_width > 0;
    facts.wrap = spec.get_string_attribute("wrapmodes");
    facts.cropped = spec.roi() != spec.roi_full();
    facts.format = spec.format;
    facts.bytes = spec.format == OIIO::TypeUInt8;
    const std::string space = spec.get_string_attribute("oiio:ColorSpace");
    facts.srgb =
        !spec.format.is_floating_point() && (space == "sRGB" || (space.empty() && spec.format == OIIO::TypeUInt8));
    // further levels have headers of their own
    const int channels = spec.nchannels;
    for (int level = 1; input->seek_subimage(0, level); ++level) {
      const OIIO::ImageSpec& coarse = input->spec();
      std::string why = disbelief(coarse, fileBytes);
      if (why.empty() && (coarse.nchannels != channels || level > kMaxLevels))
        why = "its levels do not belong together";
      if (!why.empty()) return "level " + std::to_string(level) + ": " + why;
      facts.mipMapped = true;
    }
    return "";
  } catch (const std::exception& e) {
    return std::string("it cannot be read (") + e.what() + ")";
  }
}

namespace {

// Folders below and beside those of the search path that by their names hold pictures: authors told their renderers of
// them by files that did not come with the scene.
std::vector<fs::path> pictureFolders(const std::vector<std::string>& searchPath) {
  constexpr size_t kMostFolders = 32, kMostEntries = 2000;
  std::vector<fs::path> found;
  for (const std::string& directory : searchPath)
    for (const fs::path& base : {fs::path(directory), fs::path(directory) / ".."}) {
      std::error_code ec;
      std::vector<fs::path> here;
      size_t entries = 0;
      for (fs::directory_iterator it(base, ec), end; !ec && it != end && ++entries < kMostEntries; it.increment(ec)) {
        const std::string name = lowerCase(it->path().filename().string());
        std::error_code no;
        for (const char* hint : {"tex", "map", "image", "tif", "pict"})
          if (name.find(hint) != std::string::npos && it->is_directory(no)) {
            here.push_back(it->path());
            break;
          }
      }
      std::sort(here.begin(), here.end());  // the system's order is any
      for (const fs::path& f : here)
        if (found.size() < kMostFolders && std::find(found.begin(), found.end(), f) == found.end())
          found.push_back(f);
    }
  return found;
}

}  // namespace

std::vector<std::string> candidates(const std::string& name, const std::vector<std::string>& searchPath,
                                    size_t& exact) {
  std::vector<std::string> found;
  const auto add = [&](const fs::path& p) {
    if (isFile(p) && std::find(found.begin(), found.end(), p.string()) == found.end()) found.push_back(p.string());
  };
  const auto [list, exactPlaces] = placesOf(name, searchPath);
  for (size_t i = 0; i < exactPlaces; ++i) add(list[i]);
  exact = found.size();
  // the same place with another extension is nearer to what was meant than the same name elsewhere
  for (size_t i = 0; i < list.size(); ++i) {
    add(list[i]);
    for (const char* e : kExtensions) {
      fs::path other = list[i];
      add(other.replace_extension(e));
    }
  }
  if (!found.empty() || list.empty()) return found;
  for (const fs::path& folder : pictureFolders(searchPath)) {
    fs::path place = folder / list.back().filename();
    add(place);
    for (const char* e : kExtensions) add(place.replace_extension(e));
  }
  return found;
}

bool isAtlas(const std::string& name) {
  size_t at, length;
  return findToken(name, at, length) != Token::None;
}

std::vector<AtlasTile> atlasTiles(const std::string& name, const std::vector<std::string>& searchPath) {
  for (const fs::path& place : placesOf(name, searchPath).list) {
    const std::string pattern = place.filename().string();
    size_t at, length;
    const Token token = findToken(pattern, at, length);
    if (token == Token::None) continue;  // tokens in directory names are not followed
    const std::string head = pattern.substr(0, at), tail = pattern.substr(at + length);
    std::vector<AtlasTile> tiles;
    std::error_code ec;
    const fs::path directory = place.has_parent_path() ? place.parent_path() : fs::path(".");
    for (fs::directory_iterator it(directory, ec), end; !ec && it != end; it.increment(ec)) {
      const std::string file = it->path().filename().string();
      if (file.size() <= head.size() + tail.size() || file.compare(0, head.size(), head) != 0 ||
          file.compare(file.size() - tail.size(), tail.size(), tail) != 0)
        continue;
      AtlasTile tile;
      if (!parseToken(token, file.substr(head.size(), file.size() - head.size() - tail.size()), tile)) continue;
      tile.path = it->path().string();
      if (isFile(tile.path)) tiles.push_back(std::move(tile));
    }
    if (!tiles.empty()) {
      std::sort(tiles.begin(), tiles.end(), [](const AtlasTile& a, const AtlasTile& b) { return a.path < b.path; });
      return tiles;
    }
  }
  return {};
}

}  // namespace kinora::texture
