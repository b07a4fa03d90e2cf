// Files and names of OpenTextures: which file a name stands for, what is known of it, and what was read.
#include <OpenImageIO/imageio.h>

#include <cmath>
#include <filesystem>

#include "image/picture_library.h"
#include "texture/module/open_textures.h"
#include "texture/module/write_texture.h"

namespace kinora::texture {

namespace {

constexpr size_t kLargest = 5;  // files that statistics name

}  // namespace

OpenTextures::OpenTextures(Diagnostics& d, FileContents* c, LentCache lent)
    : diagnostics(d),
      contents(c),
      cache(lent.cache),
      pace(*lent.pace),
      levels(std::make_unique<texture::LevelMaker>(*cache->imagecache(), std::move(lent.threads))),
      readers(std::make_unique<texture::TileReaders>(*levels, pace)) {
  cache->attribute("autotile", 64);
  // the library's coarse levels are points of the finer ones where sides are odd: PyramidInput makes them
  cache->attribute("automip", 0);
  cache->attribute("accept_untiled", 1);
  cache->attribute("accept_unmipped", 1);
  cache->attribute("gray_to_rgb", 0);
  cache->attribute("flip_t", 0);
  cache->attribute("failure_retries", 0);
  cache->attribute("max_open_files", 100);
  // colours as the file stores them; multiplying by alpha is the network's business
  cache->attribute("unassociatedalpha", 1);
  setCacheLimit(uint64_t(1) << 30);
}

OpenTextures::~OpenTextures() {
  threads.clear();
  readers.reset();
  IdleCaches::giveBack({cache, levels->handOver(), &pace});
}

Source* OpenTextures::open(const std::string& path, const TextureRequest& request, std::string& why) {
  if (const auto it = sourceOfPath.find(path); it != sourceOfPath.end()) return it->second;
  FileFacts facts;
  why = texture::examine(path, facts);
  if (!why.empty()) return nullptr;
  auto source = std::make_unique<Source>();
  source->facts = facts;
  source->pos = request.pos;
  source->object = request.object;
  TextureOpt::Wrap s = TextureOpt::WrapDefault, t = TextureOpt::WrapDefault;
  TextureOpt::parse_wrapmodes(facts.wrap.c_str(), s, t);
  if (s != TextureOpt::WrapDefault) source->wrapS = s;
  if (t != TextureOpt::WrapDefault) source->wrapT = t;
  if (!facts.mipMapped && levelFolder.empty())
    diagnostics.info("ASSET-TEXTURE-UNPREPARED", request.pos,
                     "texture '" + path +
                         "' is not mip-mapped; coarse levels are made while rendering; name a folder with "
                         "--texture-folder, or convert it with 'maketex' (what linearize 1 decodes: with 'maketex "
                         "--linearize', and linearize 0), to save time and memory");
  Source* raw = source.get();
  sources.push_back(std::move(source));
  sourceOfPath.emplace(path, raw);
  return raw;
}

std::string OpenTextures::choose(const std::string& file, const TextureRequest& request, Source*& source) {
  size_t exact = 0;
  const std::vector<std::string> list = texture::candidates(file, searchPath, exact);
  std::string code = "ASSET-TEXTURE-MISSING", what = named(file, request) + " is not there";
  for (size_t i = 0; i < list.size(); ++i) {
    std::string why;
    source = open(list[i], request, why);
    if (source) {
      if (i > 0 || exact == 0) diagnostics.warning(code, request.pos, what, "'" + list[i] + "' is used instead");
      return list[i];
    }
    if (i == 0) {
      code = "ASSET-TEXTURE-READ";
      what = named(file, request) + " cannot be used: '" + list[i] + "': " + why;
    }
  }
  diagnostics.warning(code, request.pos, what, "lookups give the missing colour", "check the texture search path");
  return "";
}

int OpenTextures::addAtlas(const std::string& file, const TextureRequest& request) {
  const std::vector<texture::AtlasTile> tiles = texture::atlasTiles(file, searchPath);
  auto atlas = std::make_unique<Atlas>();
  std::vector<std::string> paths;
  for (const texture::AtlasTile& t : tiles) {
    atlas->include(t.u, t.v);
    paths.push_back(t.path);
  }
  note(file, paths);
  atlas->name = named(file, request);
  atlas->pos = request.pos;
  bool any = false;
  for (const texture::AtlasTile& t : tiles) {
    std::string why;
    Source* s = open(t.path, request, why);
    any |= s != nullptr;
    if (!s)
      diagnostics.warning("ASSET-TEXTURE-READ", request.pos, named(t.path, request) + " cannot be used: " + why,
                          "this part of the atlas gives the missing colour");
    Source*& place = atlas->place(t.u, t.v);
    if (!place) place = s;
  }
  if (tiles.empty())
    diagnostics.warning("ASSET-TEXTURE-MISSING", request.pos,
                        named(file, request) + ": no file of the atlas is there", "lookups give the missing colour",
                        "check the texture search path");
  if (!any) return kNoTexture;
  Entry entry;
  entry.atlas = std::move(atlas);
  return int(entries.push_back(std::move(entry)) - entries.begin());
}

int OpenTextures::handle(const std::string& file, const TextureRequest& request) {
  if (file.empty()) return kNoTexture;
  std::lock_guard lock(mutex);
  if (const auto it = handleOfName.find(file); it != handleOfName.end()) {
    if (contents) contents->again(kContentKind, file);
    return it->second;
  }
  int h = kNoTexture;
  note(file, {});
  try {
    if (texture::isAtlas(file)) {
      h = addAtlas(file, request);
    } else {
      Entry entry;
      if (const std::string path = choose(file, request, entry.single); !path.empty()) note(file, {path});
      if (entry.single) h = int(entries.push_back(std::move(entry)) - entries.begin());
    }
  } catch (const std::exception& e) {
    diagnostics.warning("ASSET-TEXTURE-READ", request.pos, named(file, request) + " cannot be used: " + e.what(),
                        "lookups give the missing colour");
  }
  handleOfName.emplace(file, h);
  return h;
}

int OpenTextures::channels(int h) {
  if (h < 0 || size_t(h) >= entries.size()) return 0;
  Entry& entry = entries[size_t(h)];
  float s = 0.5f, t = 0.5f;
  Source* source = entry.single ? entry.single : entry.atlas ? entry.atlas->find(s, t) : nullptr;
  return source ? source->facts.channels : 0;
}

std::string OpenTextures::find(const std::string& file, float s, float t) {
  const std::lock_guard lock(mutex);
  if (texture::isAtlas(file)) {
    const int u = int(std::floor(s)), v = int(std::floor(1 - t));
    const std::string part = file + " " + std::to_string(u) + "," + std::to_string(v);
    for (const texture::AtlasTile& tile : texture::atlasTiles(file, searchPath))
      if (tile.u == u && tile.v == v) return note(part, {tile.path}), tile.path;
    note(part, {});
    return "";
  }
  size_t exact = 0;
  for (const std::string& path : texture::candidates(file, searchPath, exact)) {
    FileFacts facts;
    if (texture::examine(path, facts).empty()) return note(file, {path}), path;
  }
  note(file, {});
  return "";
}

bool OpenTextures::fact(const std::string& path, const std::string& name, int count, int* ints, float* floats,
                        std::string* text) {
  const OIIO::ustring what(name == "type" ? "texturetype" : name);
  OIIO::ustring file(path);
  // the cache keeps how it came to know a file first
  std::error_code ec;
  if (std::filesystem::is_regular_file(path, ec))
    addPooledFile(*cache->imagecache(), OIIO::ustring(path), pace, false);
  // averages are the coarsest level's
  FileFacts facts;
  if ((name == "averagecolor" || name == "averagealpha") && texture::examine(path, facts).empty() && !facts.mipMapped)
    file = levels->add(path);
  const auto get = [&](OIIO::TypeDesc type, void* to) {
    const bool has = cache->get_texture_info(file, 0, what, type, to);
    if (!has) cache->geterror();  // not left for somebody else's message
    return has;
  };
  if (text) {
    const char* s = nullptr;
    if (!get(OIIO::TypeDesc::STRING, &s) || !s) return false;
    *text = s;
    return true;
  }
  const auto of = [&](OIIO::TypeDesc::BASETYPE base, int n) {
    return n == 1 ? OIIO::TypeDesc(base) : OIIO::TypeDesc(base, n);
  };
  if (ints) return get(of(OIIO::TypeDesc::INT, count), ints);
  // triples and matrices are known by their own types
  if (get(of(OIIO::TypeDesc::FLOAT, count), floats)) return true;
  if (count == 3 && get(OIIO::TypeDesc::TypeColor, floats)) return true;
  if (count == 16 && get(OIIO::TypeDesc::TypeMatrix, floats)) return true;
  std::vector<int> whole(size_t(count) + 1);
  if (count > 16 || !get(of(OIIO::TypeDesc::INT, count), whole.data())) return false;
  std::copy_n(whole.begin(), count, floats);
  return true;
}

void OpenTextures::addReadings(const Source& s, TextureStatistics& r) {
  TextureStatistics::File file{s.facts.path};
  OIIO::ImageCache& images = *cache->imagecache();
  for (const bool isDecoded : {false, true}) {
    // a question about one that was not looked up would open it
    if (!(isDecoded ? s.decoded : s.plain).load(std::memory_order_acquire)) continue;
    const OIIO::ustring name(nameInCache(s, isDecoded));
    const auto number = [&](const char* what) {
      long long v = 0;
      const bool has = images.get_image_info(name, 0, 0, OIIO::ustring(what), OIIO::TypeDesc::INT64, &v);
      if (!has) images.geterror();  // not left for somebody else's message
      return has && v > 0 ? uint64_t(v) : 0;
    };
    file.bytesRead += number("stat:bytesread");
    file.tilesAgain += number("stat:redundant_tiles");
  }
  r.tilesAgain += file.tilesAgain;
  if (file.bytesRead) r.largest.push_back(std::move(file));
}

TextureStatistics OpenTextures::statistics() {
  TextureStatistics r;
  const auto number = [&](const char* name) -> uint64_t {
    int i = 0;
    return cache->getattribute(name, i) && i > 0 ? uint64_t(i) : 0;
  };
  const auto bytes = [&](const char* name) -> uint64_t {
    long long v = 0;
    return cache->getattribute(name, OIIO::TypeDesc::INT64, &v) && v > 0 ? uint64_t(v) : 0;
  };
  {
    std::lock_guard lock(mutex);
    r.files = sources.size();
    for (const auto& s : sources) addReadings(*s, r);
  }
  std::sort(r.largest.begin(), r.largest.end(), [](const auto& a, const auto& b) {
    return a.bytesRead != b.bytesRead ? a.bytesRead > b.bytesRead : a.path < b.path;
  });
  if (r.largest.size() > kLargest) r.largest.resize(kLargest);
  r.lookups = lookups;
  r.missingLookups = missingLookups;
  r.imageBytes = imageBytes;
  r.tilesRead = number("stat:tiles_created");
  r.cacheMisses = number("stat:find_tile_cache_misses");
  r.bytesRead = bytes("stat:bytes_read");
  r.cacheBytes = bytes("stat:cache_memory_used");
  return r;
}

}  // namespace kinora::texture

KINORA_PICTURE_LIBRARY_EXPORT(kinora::texture::TextureCalls, kinoraTextureCalls){
    [](kinora::Diagnostics& diagnostics,
       kinora::FileContents* contents) -> std::unique_ptr<kinora::texture::TextureStore> {
      return std::make_unique<kinora::texture::OpenTextures>(diagnostics, contents);
    },
    kinora::texture::writeTexture};
