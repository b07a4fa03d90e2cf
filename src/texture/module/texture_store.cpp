#include "texture/texture_store.h"

#include <OpenImageIO/imagecache.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/texture.h>
#include <tbb/concurrent_vector.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>
#include <numeric>

#include "base/file_contents.h"
#include "base/memory.h"
#include "image/colors.h"
#include "image/module/pixels.h"
#include "image/picture_library.h"
#include "texture/atlas_grid.h"
#include "texture/footprint.h"
#include "texture/missing_color.h"
#include "texture/module/group_lookup.h"
#include "texture/module/level_files.h"
#include "texture/module/pyramid_input.h"
#include "texture/module/srgb_input.h"
#include "texture/module/texture_files.h"
#include "texture/module/write_texture.h"

namespace kinora {
namespace {
using OIIO::TextureOpt;
using Cache = OIIO::TextureSystem;
using texture::FileFacts;

// One image file in the cache; twice when it is also asked for decoded.
struct Source {
  FileFacts facts;
  Cache::TextureHandle* plain = nullptr;
  std::atomic<Cache::TextureHandle*> decoded{nullptr};
  // either with levels that the file has not, for OpenImageIO's call
  std::atomic<Cache::TextureHandle*> withLevels[2] = {nullptr, nullptr};
  TextureOpt::Wrap wrapS = TextureOpt::WrapPeriodic, wrapT = TextureOpt::WrapPeriodic;
  // levels of either, for group lookups; null until asked for, one without levels when OpenImageIO's call serves it
  std::atomic<const texture::Pyramid*> plainLevels{nullptr}, decodedLevels{nullptr};
  std::unique_ptr<texture::Pyramid> held[2];
  std::mutex making;  // of their files
  std::atomic<bool> complained{false};
  SourcePos pos;
  std::string object;
};

// The files of an atlas, and whom to tell of its holes.
struct Atlas : texture::AtlasGrid<Source> {
  std::string name;  // with the object that asked for it
  SourcePos pos;
  std::atomic<bool> complained{false};
};

// What a handle stands for: one file or an atlas.
struct Entry {
  Source* single = nullptr;
  std::unique_ptr<Atlas> atlas;
};

struct HeldImage {
  std::vector<float> pixels;
  HostImage image{};
  MemoryHold memory{MemoryUse::Textures};
};

TextureOpt::Wrap wrapOf(int code, TextureOpt::Wrap file) {
  switch (code) {
    case 0:
      return TextureOpt::WrapBlack;
    case 2:
      return TextureOpt::WrapClamp;
    case 3:
      return TextureOpt::WrapPeriodic;
    case 4:
      return TextureOpt::WrapMirror;
    default:
      return file;
  }
}
// OpenImageIO's bicubic is the cubic B-spline; a gaussian of PxrTexture's width is within a few percent of it. The
// box filter is the footprint's mip level itself (made by box filtering), read bilinearly.
TextureOpt::InterpMode interpolationOf(int code) {
  switch (code) {
    case 0:
      return TextureOpt::InterpClosest;
    case 3:
    case 6:
      return TextureOpt::InterpBicubic;
    case 7:
      return TextureOpt::InterpSmartBicubic;
    default:
      return TextureOpt::InterpBilinear;
  }
}

// Texture coordinates that fit OpenImageIO's integers and never are NaN. Periodic ones lose whole turns only.
inline float safeCoordinate(float x, TextureOpt::Wrap wrap) {
  constexpr float kLimit = 256.f;
  if (std::fabs(x) <= kLimit) return x;
  if (!std::isfinite(x)) return 0.f;
  if (wrap == TextureOpt::WrapPeriodic) return x - std::floor(x);
  if (wrap == TextureOpt::WrapMirror) return std::fmod(x, 2.f);
  return std::clamp(x, -kLimit, kLimit);
}
inline float safeRadius(float r, float blur) {
  const float x = r + blur;
  return x > 0.f ? std::min(x, 4.f) : 0.f;  // NaN gives 0
}

// Tile caches that are not in use. The library knows what it keeps for a thread by the cache's address, and forgets it for
// the thread alone that frees the cache: another cache in the same place would be asked with files of the one before, by
// threads that live on. So caches are emptied and used again, and never freed.
struct LentCache {
  Cache* cache = nullptr;
  texture::LevelMaker::Lent threads;  // the library cannot count once one of them was destroyed
};
class IdleCaches {
 public:
  static LentCache take() {
    const std::lock_guard lock(mutex());
    std::vector<LentCache>& list = idle();
    if (list.empty()) return {Cache::create(false), {}};
    LentCache lent = std::move(list.back());
    list.pop_back();
    return lent;
  }
  static void giveBack(LentCache lent) {
    lent.cache->invalidate_all(true);  // files are looked at anew
    lent.cache->reset_stats();
    const std::lock_guard lock(mutex());
    idle().push_back(std::move(lent));
  }

 private:
  static std::mutex& mutex() {
    static auto* const m = new std::mutex;
    return *m;
  }
  static std::vector<LentCache>& idle() {
    static auto* const list = new std::vector<LentCache>;
    return *list;
  }
};

struct OpenTextures final : texture::TextureStore {
  using Part = TextureSystem::Part;
  static constexpr int kNoTexture = TextureSystem::kNoTexture;

  OpenTextures(Diagnostics& d, FileContents* c) : OpenTextures(d, c, IdleCaches::take()) {}
  OpenTextures(Diagnostics& d, FileContents* c, LentCache lent)
      : diagnostics(d),
        contents(c),
        cache(lent.cache),
        levels(std::make_unique<texture::LevelMaker>(*cache->imagecache(), std::move(lent.threads))) {
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
  ~OpenTextures() override {
    threads.clear();
    IdleCaches::giveBack({cache, levels->handOver()});
  }

  // The library ends the program when it holds ten times its limit: room for the largest tile that is let through.
  void setCacheLimit(uint64_t bytes) override {
    cache->attribute("max_memory_MB", float(std::max(double(bytes) / 1048576.0, 16.0)));
    tileBytes = std::clamp(bytes / 64, uint64_t(1) << 18, uint64_t(1) << 24);
  }

  // The cache's entry of one file; null when it cannot be used.
  Source* open(const std::string& path, const TextureRequest& request, std::string& why) {
    if (const auto it = sourceOfPath.find(path); it != sourceOfPath.end()) return it->second;
    FileFacts facts;
    why = texture::examine(path, facts);
    if (!why.empty()) return nullptr;
    auto source = std::make_unique<Source>();
    source->facts = facts;
    source->pos = request.pos;
    source->object = request.object;
    source->plain = cache->get_texture_handle(OIIO::ustring(path));
    if (!source->plain || !cache->good(source->plain)) {
      why = "it cannot be opened (" + firstLine(cache->geterror()) + ")";
      return nullptr;
    }
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

  static std::string firstLine(std::string text) {
    if (const size_t line = text.find('\n'); line != std::string::npos) text.resize(line);
    return text;
  }
  static std::string named(const std::string& file, const TextureRequest& r) {
    return "texture '" + file + "'" + (r.object.empty() ? "" : " of " + r.object);
  }

  static constexpr const char* kContentKind = "texture";
  void note(const std::string& file, const std::vector<std::string>& paths) {
    if (contents) contents->use(kContentKind, file, paths);
  }

  // The first usable candidate; says what was wrong with better ones.
  std::string choose(const std::string& file, const TextureRequest& request, Source*& source) {
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

  int addAtlas(const std::string& file, const TextureRequest& request) {
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

  int handle(const std::string& file, const TextureRequest& request) override {
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

  // The decoded twin of a file, made on first use.
  Cache::TextureHandle* decoded(Source& s) {
    if (Cache::TextureHandle* h = s.decoded.load(std::memory_order_acquire)) return h;
    std::lock_guard lock(mutex);
    if (Cache::TextureHandle* h = s.decoded.load(std::memory_order_acquire)) return h;
    // TIFF does not record that colours are light, so that the type of the numbers is all there is to judge by
    if (s.facts.format.is_floating_point() && !image::Colors::ofEnvironment().isManaged())
      diagnostics.info(
          "ASSET-TEXTURE-DECODED", s.pos,
          "texture '" + s.facts.path +
              "' holds floating-point numbers, which are light already in most files (maketex --linearize "
              "makes such), and linearize 1 decodes them from sRGB once more; for light use linearize 0");
    const OIIO::ustring name(texture::kSrgbPrefix + s.facts.path);
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    cache->imagecache()->add_file(name, texture::createSrgbInput, &config);
    Cache::TextureHandle* h = cache->get_texture_handle(name);
    s.decoded.store(h, std::memory_order_release);
    return h;
  }

  static std::string nameInCache(const Source& s, bool linearize) {
    return linearize ? texture::kSrgbPrefix + s.facts.path : s.facts.path;
  }

  // The entry for OpenImageIO's call where some part of the file may be without levels.
  Cache::TextureHandle* withLevels(Source& s, bool linearize) {
    std::atomic<Cache::TextureHandle*>& known = s.withLevels[linearize];
    if (Cache::TextureHandle* h = known.load(std::memory_order_acquire)) return h;
    std::lock_guard lock(mutex);
    if (Cache::TextureHandle* h = known.load(std::memory_order_acquire)) return h;
    Cache::TextureHandle* h = cache->get_texture_handle(levels->add(nameInCache(s, linearize)));
    known.store(h, std::memory_order_release);
    return h;
  }

  // From the folder of levels that were made once.
  bool describeKept(texture::Pyramid& p, const Source& s, const std::string& folder, OIIO::ustring finest,
                    OIIO::ustring coarse, OIIO::ImageCache::Perthread* thread) {
    // a picture that has none, or whose parts have, is as fast without
    if (s.facts.width < 2 && s.facts.height < 2) return false;
    OIIO::ImageCache& images = *cache->imagecache();
    texture::LevelFiles files;
    std::string why;
    try {
      why = texture::keepLevels(images, thread, folder, s.facts.path, finest, coarse, files);
      if (why.empty() && p.describe(images, thread, OIIO::ustring(files.finest), OIIO::ustring(files.coarser), true))
        return true;
      if (why.empty()) why = firstLine(images.geterror());
    } catch (const std::exception& e) {
      why = e.what();
    }
    diagnostics.warning("ASSET-TEXTURE-FOLDER", s.pos,
                        "levels of texture '" + s.facts.path + "' cannot be kept in '" + folder + "': " + why,
                        "they are made while rendering", "a folder that can be written, with room: --texture-folder");
    return false;
  }

  const texture::Pyramid& levelsOf(Source& s, bool linearize, OIIO::ImageCache::Perthread* thread) {
    std::atomic<const texture::Pyramid*>& known = linearize ? s.decodedLevels : s.plainLevels;
    if (const texture::Pyramid* p = known.load(std::memory_order_acquire)) return *p;
    const std::lock_guard one(s.making);  // other files need not wait for those of this one
    if (const texture::Pyramid* p = known.load(std::memory_order_acquire)) return *p;
    auto made = std::make_unique<texture::Pyramid>();
    OIIO::ImageCache& images = *cache->imagecache();
    const OIIO::ustring name(nameInCache(s, linearize));
    OIIO::ustring coarse = name;
    std::string folder;
    {
      const std::lock_guard lock(mutex);
      if (!s.facts.mipMapped) coarse = levels->add(name.string());
      folder = levelFolder;
    }
    const OIIO::ustring finest = s.facts.cropped ? coarse : name;
    if (s.facts.mipMapped || folder.empty() || !describeKept(*made, s, folder, finest, coarse, thread))
      if (!made->describe(images, thread, finest, coarse)) made->levels.clear();
    const std::lock_guard lock(mutex);
    s.held[linearize] = std::move(made);
    known.store(s.held[linearize].get(), std::memory_order_release);
    return *s.held[linearize];
  }

  // What holds for all lookups of one source with the same options.
  struct Bound {
    Source* source = nullptr;
    Cache::TextureHandle* handle = nullptr;
    int channels = 0, width = 1, height = 1;
    TextureOpt opt;
    const texture::Pyramid* levels = nullptr;  // null: by OpenImageIO's call
    texture::LookupKind kind;
  };
  static bool simple(TextureOpt::Wrap w, texture::Wrap& out) {
    if (w != TextureOpt::WrapBlack && w != TextureOpt::WrapClamp && w != TextureOpt::WrapPeriodic) return false;
    out = w == TextureOpt::WrapBlack   ? texture::Wrap::Black
          : w == TextureOpt::WrapClamp ? texture::Wrap::Clamp
                                       : texture::Wrap::Periodic;
    return true;
  }
  void bind(Bound& b, Source* s, const TextureOptions& o, const Part& part, bool atlas,
            OIIO::ImageCache::Perthread* thread) {
    b.source = s;
    b.handle = o.linearize ? decoded(*s) : s->plain;
    const int available = s->facts.channels - std::max(o.firstChannel, 0);
    b.channels = std::clamp(available, 0, 4);
    b.opt.firstchannel = std::max(o.firstChannel, 0);
    b.opt.swrap = atlas ? TextureOpt::WrapClamp : wrapOf(o.wrapS, s->wrapS);
    b.opt.twrap = atlas ? TextureOpt::WrapClamp : wrapOf(o.wrapT, s->wrapT);
    b.opt.interpmode = interpolationOf(o.filter);
    // the library chooses between cubic and linear only in the mode that would be anisotropic, which at most 1 is not
    const bool isSmart = b.opt.interpmode == TextureOpt::InterpSmartBicubic;
    b.opt.mipmode = !o.interpolateLevels ? TextureOpt::MipModeOneLevel
                    : isSmart            ? TextureOpt::MipModeAniso
                                         : TextureOpt::MipModeTrilinear;
    b.opt.anisotropic = 1;
    b.levels = nullptr;
    b.opt.subimage = std::max(part.number, 0);
    b.opt.subimagename = part.name.empty() ? OIIO::ustring() : OIIO::ustring(std::string(part.name));
    const bool isFirst = part.number <= 0 && part.name.empty();
    if (isFirst && b.channels > 0 && (b.opt.interpmode == TextureOpt::InterpBilinear || isSmart) &&
        simple(b.opt.swrap, b.kind.wrapS) && simple(b.opt.twrap, b.kind.wrapT)) {
      const texture::Pyramid& levels = levelsOf(*s, o.linearize != 0, thread);
      if (!levels.levels.empty()) b.levels = &levels;
      b.kind.blendLevels = o.interpolateLevels != 0;
      b.kind.isCubic = isSmart;
      b.kind.firstChannel = b.opt.firstchannel;
      b.kind.channels = b.channels;
    }
    b.width = b.levels ? b.levels->levels[0].width : std::max(s->facts.width, 1);
    b.height = b.levels ? b.levels->levels[0].height : std::max(s->facts.height, 1);
    if (!b.levels && (!s->facts.mipMapped || !isFirst)) b.handle = withLevels(*s, o.linearize != 0);
    if (b.channels == 0 && !s->complained.exchange(true))
      diagnostics.warning("ASSET-TEXTURE-CHANNEL", s->pos,
                          "texture '" + s->facts.path + "' has " + std::to_string(s->facts.channels) +
                              " channels, the first one asked for is " + std::to_string(o.firstChannel),
                          "lookups give the missing colour");
  }

  void complain(Source& s) {
    std::string why = firstLine(cache->geterror());
    if (why.empty()) why = firstLine(cache->imagecache()->geterror());
    if (s.complained.exchange(true)) return;
    diagnostics.warning(
        "ASSET-TEXTURE-READ", s.pos,
        "texture '" + s.facts.path + "'" + (s.object.empty() ? "" : " of " + s.object) + " is damaged: " + why,
        "its unreadable parts give the missing colour");
  }

  void complainOfHole(Atlas& a) {
    if (a.complained.exchange(true)) return;
    const std::string holes = a.holes();
    diagnostics.warning(
        "ASSET-TEXTURE-TILE", a.pos,
        a.name + " is looked up at a tile that has no file" +
            (holes.empty() ? " (outside of those that it has)" : " (there is none for " + holes + ")"),
        "lookups there give the missing colour", "add the files, or keep the texture coordinates inside the set");
  }

  // What a thread keeps from one group to the next.
  struct OfThread {
    std::unique_ptr<texture::TileTable> tiles;
    std::vector<uint32_t> order;
  };

  // Points of one file together, or nearly: what holds for them, and their tiles, are found once.
  static void sortByFile(OfThread& own, const int32_t* handles, bool varying, uint32_t n) {
    own.order.resize(n);
    if (!varying) {
      std::iota(own.order.begin(), own.order.end(), 0u);
      return;
    }
    constexpr uint32_t kKeys = 256;
    uint32_t at[kKeys + 1] = {};
    for (uint32_t i = 0; i < n; ++i) ++at[uint32_t(handles[i]) % kKeys + 1];
    for (uint32_t k = 0; k < kKeys; ++k) at[k + 1] += at[k];
    for (uint32_t i = 0; i < n; ++i) own.order[at[uint32_t(handles[i]) % kKeys]++] = i;
  }

  void lookup(const int32_t* handles, bool varying, uint32_t n, const float* s, const float* t, const float* radius,
              const TextureOptions& o, const Part& part, float* const rgba[4], const float* const* axes) override {
    Cache::Perthread* thread = cache->get_perthread_info();
    OIIO::ImageCache& images = *cache->imagecache();
    OIIO::ImageCache::Perthread* imageThread = images.get_perthread_info();
    OfThread& own = threads.local();
    if (!own.tiles) own.tiles = std::make_unique<texture::TileTable>(images);
    texture::TileTable& tiles = *own.tiles;
    tiles.enter(imageThread, tileBytes);
    sortByFile(own, handles, varying, n);
    Bound bound;
    uint64_t missing = 0;
    const texture::MissingColor missingColor(o);
    // of the texels that tiles are asked for
    struct Asker {
      uint32_t point, channels;
      float share;   // of what the point is given
      bool isFirst;  // of the point's probes, which come one after the other
    };
    Asker askers[texture::TileTable::kBlock];
    const auto put = [&](const Asker& to, const float texel[4]) {
      const uint32_t available = to.channels;
      const float values[4] = {texel[0], available >= 3 ? texel[1] : texel[0], available >= 3 ? texel[2] : texel[0],
                               available == 4   ? texel[3]
                               : available == 2 ? texel[1]
                                                : 1.f};
      for (int c = 0; c < 4; ++c) {
        float& sum = rgba[c][to.point];
        sum = to.isFirst ? values[c] * to.share : sum + values[c] * to.share;
      }
    };
    const auto answer = [&] {
      float texels[texture::TileTable::kBlock][4];
      const uint32_t count = tiles.asked();
      tiles.answer(texels);
      for (uint32_t k = 0; k < count; ++k) put(askers[k], texels[k]);
    };
    const Entry* entry = nullptr;
    int32_t handle = kNoTexture;
    const size_t known = entries.size();
    for (const uint32_t i : own.order) {
      if (const int32_t h = handles[varying ? i : 0]; h != handle) {
        handle = h;
        entry = h >= 0 && size_t(h) < known ? &entries[size_t(h)] : nullptr;
      }
      Source* source = entry ? entry->single : nullptr;
      float si = s[i], ti = t[i];
      const bool atlas = entry && entry->atlas;
      if (atlas) {
        // t counts down from the top of the first row; rows of an atlas count up
        float up = 1.f - ti;
        source = entry->atlas->find(si, up);
        ti = 1.f - up;
        if (!source) complainOfHole(*entry->atlas);
      }
      bool found = false;
      if (source) {
        if (source != bound.source) bind(bound, source, o, part, atlas, imageThread);
        if (bound.channels > 0) {
          texture::Probes probes;
          const float least = float(std::min(bound.width, bound.height));
          bool isEllipse = false;
          if (axes && bound.opt.interpmode != TextureOpt::InterpClosest) {
            const float axis[4] = {axes[0][i], axes[1][i], axes[2][i], axes[3][i]};
            isEllipse = texture::findProbes(axis, o.blur, bound.width, bound.height, probes);
          }
          const float r = isEllipse ? probes.texels / least : safeRadius(radius[i], o.blur);
          if (!isEllipse) probes.texels = r * least;
          const float x = safeCoordinate(si, bound.opt.swrap), y = safeCoordinate(ti, bound.opt.twrap);
          const texture::TileTable::LevelMix mix =
              bound.levels ? texture::TileTable::mixOf(*bound.levels, bound.kind, probes.texels)
                           : texture::TileTable::LevelMix();
          const float share = 1.f / float(probes.count);
          found = true;
          for (int k = 0; found && k < probes.count; ++k) {
            const Asker from{i, uint32_t(bound.channels), share, k == 0};
            const float xs = x + (probes.firstS + float(k) * probes.stepS),
                        yt = y + (probes.firstT + float(k) * probes.stepT);
            if (bound.levels) {
              if (tiles.isFull()) answer();
              askers[tiles.asked()] = from;
              found = tiles.ask(*bound.levels, bound.kind, mix, xs, yt);
            } else {
              float texel[4];
              found = cache->texture(bound.handle, thread, bound.opt, xs, yt, r, 0.f, 0.f, r, bound.channels, texel);
              if (found) put(from, texel);
            }
          }
          if (!found) {
            complain(*source);
            if (tiles.asked()) answer();  // probes of this point that could be read
          }
        }
      }
      if (found) continue;
      ++missing;
      float color[3];
      missingColor.at(s[i], t[i], safeRadius(radius[i], o.blur), color);
      for (int c = 0; c < 3; ++c) rgba[c][i] = color[c];
      rgba[3][i] = o.missingAlpha;
    }
    if (tiles.asked()) answer();
    lookups.fetch_add(n, std::memory_order_relaxed);
    if (missing) missingLookups.fetch_add(missing, std::memory_order_relaxed);
  }

  const HostImage* image(const std::string& file, int linearize, const TextureRequest& request) override {
    std::lock_guard lock(imageMutex);
    const auto key = std::make_pair(file, linearize);
    if (const auto it = images.find(key); it != images.end()) {
      if (contents) contents->again(kContentKind, file);
      return it->second ? &it->second->image : nullptr;
    }
    note(file, {});
    std::unique_ptr<HeldImage> held;
    try {
      held = load(file, linearize, request);
    } catch (const MemoryExceeded&) {  // no fault of the file
      throw;
    } catch (const std::exception& e) {
      diagnostics.warning("ASSET-TEXTURE-READ", request.pos, named(file, request) + " cannot be used: " + e.what(),
                          "no image is used");
    }
    const HostImage* result = held ? &held->image : nullptr;
    images.emplace(key, std::move(held));
    return result;
  }

  std::unique_ptr<HeldImage> load(const std::string& file, int linearize, const TextureRequest& request) {
    size_t exact = 0;
    const std::vector<std::string> list = texture::candidates(file, searchPath, exact);
    std::string code = "ASSET-TEXTURE-MISSING", what = named(file, request) + " is not there";
    for (size_t i = 0; i < list.size(); ++i) {
      FileFacts facts;
      std::string why = texture::examine(list[i], facts);
      auto held = std::make_unique<HeldImage>();
      if (why.empty()) {
        OIIO::ImageSpec config;
        config.attribute("oiio:UnassociatedAlpha", 1);
        auto input = OIIO::ImageInput::open(list[i], &config);
        const int channels = std::min(facts.channels, 4);
        if (input) {
          held->memory.add(uint64_t(facts.width) * uint64_t(facts.height) * uint64_t(channels) * sizeof(float));
          held->pixels.resize(size_t(facts.width) * size_t(facts.height) * size_t(channels));
          if (!image::readPixels(*input, channels, held->pixels.data())) why = firstLine(input->geterror());
        } else {
          why = firstLine(OIIO::geterror());
        }
        if (why.empty()) {
          const int alpha = facts.alphaChannel < channels ? facts.alphaChannel : -1;
          const size_t pixels = size_t(facts.width) * size_t(facts.height);
          if (linearize != 0 &&
              !image::Colors::ofEnvironment().toWorking(list[i], facts.bytes, held->pixels.data(), pixels, channels,
                                                        alpha) &&
              (linearize == 1 || facts.srgb))
            texture::decodeSrgb(held->pixels.data(), pixels, channels, alpha, facts.bytes);
          note(file, {list[i]});
          held->image = {held->pixels.data(), uint32_t(facts.width), uint32_t(facts.height), uint32_t(channels)};
          imageBytes.fetch_add(held->pixels.size() * sizeof(float), std::memory_order_relaxed);
          if (i > 0 || exact == 0) diagnostics.warning(code, request.pos, what, "'" + list[i] + "' is used instead");
          return held;
        }
      }
      if (i == 0) {
        code = "ASSET-TEXTURE-READ";
        what = named(file, request) + " cannot be used: '" + list[i] + "': " + why;
      }
    }
    diagnostics.warning(code, request.pos, what, "no image is used", "check the texture search path");
    return nullptr;
  }

  void setLevelFolder(std::string folder) override {
    const std::lock_guard lock(mutex);
    levelFolder = std::move(folder);
  }
  void setSearchPath(std::vector<std::string> directories) override {
    const std::lock_guard lock(mutex);
    searchPath = std::move(directories);
  }

  int channels(int h) override {
    if (h < 0 || size_t(h) >= entries.size()) return 0;
    Entry& entry = entries[size_t(h)];
    float s = 0.5f, t = 0.5f;
    Source* source = entry.single ? entry.single : entry.atlas ? entry.atlas->find(s, t) : nullptr;
    return source ? source->facts.channels : 0;
  }

  std::string find(const std::string& file, float s, float t) override {
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

  bool fact(const std::string& path, const std::string& name, int count, int* ints, float* floats,
            std::string* text) override {
    const OIIO::ustring what(name == "type" ? "texturetype" : name);
    OIIO::ustring file(path);
    // averages are the coarsest level's
    FileFacts facts;
    if ((name == "averagecolor" || name == "averagealpha") && texture::examine(path, facts).empty() &&
        !facts.mipMapped)
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

  static constexpr size_t kLargest = 5;
  // What was read of a file, as it is and decoded.
  void addReadings(const Source& s, TextureStatistics& r) {
    TextureStatistics::File file{s.facts.path};
    OIIO::ImageCache& images = *cache->imagecache();
    for (const bool isDecoded : {false, true}) {
      if (isDecoded && !s.decoded.load(std::memory_order_acquire)) continue;
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

  TextureStatistics statistics() override {
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

  Diagnostics& diagnostics;
  FileContents* contents;
  Cache* cache;
  std::unique_ptr<texture::LevelMaker> levels;
  std::mutex mutex;  // files, names
  std::vector<std::string> searchPath;
  std::string levelFolder;
  std::map<std::string, int> handleOfName;
  std::map<std::string, Source*> sourceOfPath;
  std::vector<std::unique_ptr<Source>> sources;
  tbb::concurrent_vector<Entry> entries;  // read without a lock: elements never move
  std::mutex imageMutex;
  std::map<std::pair<std::string, int>, std::unique_ptr<HeldImage>> images;
  std::atomic<uint64_t> lookups{0}, missingLookups{0}, imageBytes{0};
  uint64_t tileBytes = 0;  // that a thread's table holds: a share of the cache
  tbb::enumerable_thread_specific<OfThread> threads;
};

}  // namespace
}  // namespace kinora

KINORA_PICTURE_LIBRARY_EXPORT(kinora::texture::TextureCalls, kinoraTextureCalls){
    [](kinora::Diagnostics& diagnostics,
       kinora::FileContents* contents) -> std::unique_ptr<kinora::texture::TextureStore> {
      return std::make_unique<kinora::OpenTextures>(diagnostics, contents);
    },
    kinora::texture::writeTexture};
