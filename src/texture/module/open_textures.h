// The files behind a TextureSystem as OpenImageIO's cache has them: TextureStore, for the files of its parts alone. Which file
// a name stands for is in texture_store.cpp, lookups for groups are in texture_lookup.cpp, images as a whole in
// whole_images.cpp.
#pragma once
#include <OpenImageIO/imagecache.h>
#include <OpenImageIO/texture.h>
#include <tbb/concurrent_vector.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/file_contents.h"
#include "base/memory.h"
#include "texture/atlas_grid.h"
#include "texture/module/group_lookup.h"
#include "texture/module/idle_caches.h"
#include "texture/module/srgb_input.h"
#include "texture/module/texture_files.h"
#include "texture/module/tile_readers.h"
#include "texture/texture_store.h"

namespace kinora::texture {

using OIIO::TextureOpt;
using Cache = OIIO::TextureSystem;

// One image file in the cache; twice when it is also asked for decoded.
struct Source {
  FileFacts facts;
  std::atomic<Cache::TextureHandle*> plain{nullptr}, decoded{nullptr};  // null until looked up
  // either with levels that the file has not, for OpenImageIO's call
  std::atomic<Cache::TextureHandle*> withLevels[2] = {nullptr, nullptr};
  TextureOpt::Wrap wrapS = TextureOpt::WrapPeriodic, wrapT = TextureOpt::WrapPeriodic;
  // levels of either, for group lookups; null until asked for, one without levels when OpenImageIO's call serves it
  std::atomic<const texture::Pyramid*> plainLevels{nullptr}, decodedLevels{nullptr};
  std::unique_ptr<texture::Pyramid> held[2];
  std::mutex making;  // of their files, and of the entries above
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

class OpenTextures final : public TextureStore {
 public:
  using Part = TextureSystem::Part;
  static constexpr int kNoTexture = TextureSystem::kNoTexture;
  OpenTextures(Diagnostics& d, FileContents* c) : OpenTextures(d, c, IdleCaches::take()) {}
  ~OpenTextures() override;
  // The library ends the program when it holds ten times its limit: room for the largest tile that is let through.
  void setCacheLimit(uint64_t bytes) override {
    cache->attribute("max_memory_MB", float(std::max(double(bytes) / 1048576.0, 16.0)));
    tileBytes = std::clamp(bytes / 64, uint64_t(1) << 18, uint64_t(1) << 24);
  }
  void setReading(TextureReading reading) override {
    pace.delay = reading.delay;
    readers->setWay(reading.way);
  }
  int handle(const std::string& file, const TextureRequest& request) override;
  void lookup(const int32_t* handles, bool varying, uint32_t n, const float* s, const float* t, const float* radius,
              const TextureOptions& o, const Part& part, float* const rgba[4], const float* const* axes) override;
  int channels(int h) override;
  std::string find(const std::string& file, float s, float t) override;
  bool fact(const std::string& path, const std::string& name, int count, int* ints, float* floats,
            std::string* text) override;
  const HostImage* image(const std::string& file, int linearize, const TextureRequest& request) override;
  TextureStatistics statistics() override;
  void setLevelFolder(std::string folder) override {
    const std::lock_guard lock(mutex);
    levelFolder = std::move(folder);
  }
  void setSearchPath(std::vector<std::string> directories) override {
    const std::lock_guard lock(mutex);
    searchPath = std::move(directories);
  }

 private:
  OpenTextures(Diagnostics& d, FileContents* c, LentCache lent);

  // Files and names: texture_store.cpp.
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
  // The cache's entry of one file; null when it cannot be used.
  Source* open(const std::string& path, const TextureRequest& request, std::string& why);
  // The first usable candidate; says what was wrong with better ones.
  std::string choose(const std::string& file, const TextureRequest& request, Source*& source);
  int addAtlas(const std::string& file, const TextureRequest& request);
  // What was read of a file, as it is and decoded.
  void addReadings(const Source& s, TextureStatistics& r);
  static std::string nameInCache(const Source& s, bool linearize) {
    return linearize ? texture::kSrgbPrefix + s.facts.path : s.facts.path;
  }

  // Lookups: texture_lookup.cpp.
  // The cache's entry of a file, or of its decoded twin, made on first use.
  Cache::TextureHandle* plain(Source& s);
  Cache::TextureHandle* decoded(Source& s);
  // The entry for OpenImageIO's call where some part of the file may be without levels.
  Cache::TextureHandle* withLevels(Source& s, bool linearize);
  // From the folder of levels that were made once.
  bool describeKept(texture::Pyramid& p, const Source& s, const std::string& folder, OIIO::ustring finest,
                    OIIO::ustring coarse, OIIO::ImageCache::Perthread* thread);
  const texture::Pyramid& levelsOf(Source& s, bool linearize, OIIO::ImageCache::Perthread* thread);
  // What holds for all lookups of one source with the same options.
  struct Bound {
    Source* source = nullptr;
    Cache::TextureHandle* handle = nullptr;
    int channels = 0, width = 1, height = 1;
    TextureOpt opt;
    const texture::Pyramid* levels = nullptr;  // null: by OpenImageIO's call
    texture::LookupKind kind;
  };
  void bind(Bound& b, Source* s, const TextureOptions& o, const Part& part, bool atlas,
            OIIO::ImageCache::Perthread* thread);
  void complain(Source& s, std::string why);
  void complainOfHole(Atlas& a);
  // What a thread keeps from one group to the next.
  struct OfThread {
    std::unique_ptr<texture::TileTable> tiles;
    std::vector<uint32_t> order;
    std::vector<uint32_t> later;  // points whose tiles are to be read first
  };
  // Points of one file together, or nearly: what holds for them, and their tiles, are found once.
  static void sortByFile(OfThread& own, const int32_t* handles, bool varying, uint32_t n);

  // Images as a whole: whole_images.cpp.
  std::unique_ptr<HeldImage> load(const std::string& file, int linearize, const TextureRequest& request);

  Diagnostics& diagnostics;
  FileContents* contents;
  Cache* cache;
  ReadPace& pace;
  std::unique_ptr<texture::LevelMaker> levels;
  std::unique_ptr<texture::TileReaders> readers;
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

}  // namespace kinora::texture
