#include "texture/pyramid_input.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "texture/area_average.h"

namespace kinora::texture {
namespace {

constexpr const char* kPrefix = "kinora-levels:";
constexpr const char* kMakerAttribute = "kinora:maker";
constexpr const char* kFileAttribute = "kinora:file";
constexpr int kTileSide = 64;

class PyramidInput final : public OIIO::ImageInput {
 public:
  ~PyramidInput() override { close(); }
  const char* format_name() const override { return "kinora-levels"; }

  bool open(const std::string& name, OIIO::ImageSpec& spec) override { return open(name, spec, OIIO::ImageSpec()); }
  bool open(const std::string&, OIIO::ImageSpec& spec, const OIIO::ImageSpec& config) override {
    const OIIO::ParamValue* maker = config.find_attribute(kMakerAttribute, OIIO::TypeDesc::PTR);
    if (!maker) {
      errorfmt("no cache to read from");
      return false;
    }
    maker_ = *static_cast<LevelMaker* const*>(maker->data());
    cache_ = &maker_->cache();
    const LevelMaker::Asker asker(*maker_);
    file_ = cache_->get_image_handle(OIIO::ustring(config.get_string_attribute(kFileAttribute)), asker.thread());
    if (!file_ || !describe(asker.thread())) {
      errorfmt("{}", cache_->geterror());
      return false;
    }
    self_ = OIIO::ustring(kPrefix + std::string(config.get_string_attribute(kFileAttribute)));
    seek_subimage(0, 0);
    spec = m_spec;
    return true;
  }
  bool close() override {
    parts_.clear();
    return true;
  }
  int current_subimage() const override { return part_; }
  int current_miplevel() const override { return level_; }
  bool seek_subimage(int part, int level) override {
    lock_guard lock(*this);
    if (part < 0 || size_t(part) >= parts_.size() || level < 0 || size_t(level) >= parts_[size_t(part)].levels.size())
      return false;
    part_ = part;
    level_ = level;
    m_spec = parts_[size_t(part)].levels[size_t(level)];
    return true;
  }
  bool read_native_scanline(int, int, int, int, void*) override { return false; }  // all levels are tiled
  // Holds no lock while it waits for other tiles of the cache: their readers may come here too.
  bool read_native_tile(int part, int level, int x, int y, int, void* data) override {
    const Part& p = parts_[size_t(part)];
    const OIIO::ImageSpec& spec = p.levels[size_t(level)];
    const size_t channels = size_t(spec.nchannels), row = size_t(spec.tile_width) * channels;
    const LevelWindow window{x, y, std::min(x + spec.tile_width, spec.x + spec.width),
                             std::min(y + spec.tile_height, spec.y + spec.height)};
    std::vector<float> pixels(size_t(window.width()) * size_t(window.height()) * channels);
    if (level < p.given) {
      if (!read(file_, part, level, moved(window, p.originX, p.originY), pixels)) return false;
    } else {
      const OIIO::ImageSpec& finer = p.levels[size_t(level - 1)];
      const LevelSize fine{finer.width, finer.height}, coarse{spec.width, spec.height};
      const LevelWindow under = windowUnder(window, coarse, fine);
      std::vector<float> source(size_t(under.width()) * size_t(under.height()) * channels);
      const bool first = level == p.given;
      const LevelWindow there = first ? moved(under, p.originX, p.originY) : under;
      if (!read(first ? file_ : nullptr, part, level - 1, there, source)) return false;
      averageAreas(source.data(), fine, coarse, window, spec.nchannels, pixels.data());
    }
    // a tile at the border is filled up
    std::vector<float> tile(row * size_t(spec.tile_height), 0.f);
    const size_t held = size_t(window.width()) * channels;
    for (int j = 0; j < window.height(); ++j)
      std::copy_n(pixels.begin() + std::ptrdiff_t(size_t(j) * held), held,
                  tile.begin() + std::ptrdiff_t(size_t(j) * row));
    if (spec.format == OIIO::TypeFloat) {
      std::copy(tile.begin(), tile.end(), static_cast<float*>(data));
    } else {
      // to the nearest, halves to the even one: rounding them up would brighten every level a little
      uint16_t* out = static_cast<uint16_t*>(data);
      for (const float v : tile) *out++ = uint16_t(std::nearbyint(std::clamp(v, 0.f, 1.f) * 65535.f));
    }
    return true;
  }

 private:
  struct Part {
    std::vector<OIIO::ImageSpec> levels;
    int given = 0;  // levels of the file itself
    // of the display window, which is what levels cover: black beyond the data
    int originX = 0, originY = 0;
  };

  bool describe(OIIO::ImageCache::Perthread* thread) {
    parts_.clear();
    static const OIIO::ustring kParts("subimages"), kLevels("miplevels");
    int parts = 0;
    if (!cache_->get_image_info(file_, thread, 0, 0, kParts, OIIO::TypeInt, &parts)) return false;
    for (int part = 0; part < parts; ++part) {
      Part p;
      if (!cache_->get_image_info(file_, thread, part, 0, kLevels, OIIO::TypeInt, &p.given)) return false;
      for (int level = 0; level < p.given; ++level) {
        const OIIO::ImageSpec* held = cache_->imagespec(file_, thread, part, level);
        if (!held) return false;
        p.levels.push_back(*held);
        OIIO::ImageSpec& spec = p.levels.back();
        spec.set_format(held->format == OIIO::TypeUInt8 ? OIIO::TypeUInt16 : OIIO::TypeFloat);
        spec.channelformats.clear();
        tile(spec);
        // hashes and constants of the file
        for (const char* name : {"oiio:SHA-1", "oiio:ConstantColor", "oiio:AverageColor", "ImageDescription"})
          spec.erase_attribute(name);
      }
      if (p.given == 1) takeDisplayWindow(p);
      // a texture that was made without levels is to have none
      if (p.given == 1 && !p.levels[0].find_attribute("textureformat")) addLevels(p);
      parts_.push_back(std::move(p));
    }
    return !parts_.empty();
  }
  static LevelWindow moved(const LevelWindow& w, int x, int y) { return {w.x0 + x, w.y0 + y, w.x1 + x, w.y1 + y}; }
  static void takeDisplayWindow(Part& p) {
    OIIO::ImageSpec& spec = p.levels[0];
    p.originX = spec.full_x, p.originY = spec.full_y;
    spec.x = spec.y = spec.full_x = spec.full_y = 0;
    spec.width = spec.full_width, spec.height = spec.full_height;
    tile(spec);
  }
  static void addLevels(Part& p) {
    OIIO::ImageSpec spec = p.levels[0];
    while (spec.full_width > 1 || spec.full_height > 1) {
      spec.width = spec.full_width = coarserSide(spec.full_width);
      spec.height = spec.full_height = coarserSide(spec.full_height);
      tile(spec);
      p.levels.push_back(spec);
    }
  }
  static void tile(OIIO::ImageSpec& spec) {
    spec.tile_width = std::min(spec.width, kTileSide);
    spec.tile_height = std::min(spec.height, kTileSide);
    spec.tile_depth = 1;
  }
  // from: null for this very entry
  bool read(OIIO::ImageCache::ImageHandle* from, int part, int level, const LevelWindow& w,
            std::vector<float>& pixels) {
    const LevelMaker::Asker asker(*maker_);
    if (!from) from = cache_->get_image_handle(self_, asker.thread());
    const int channels = parts_[size_t(part)].levels[0].nchannels;
    if (from && cache_->get_pixels(from, asker.thread(), part, level, w.x0, w.x1, w.y0, w.y1, 0, 1, 0, channels,
                                   OIIO::TypeFloat, pixels.data()))
      return true;
    errorfmt("{}", cache_->geterror());
    return false;
  }

  LevelMaker* maker_ = nullptr;
  OIIO::ImageCache* cache_ = nullptr;
  OIIO::ImageCache::ImageHandle* file_ = nullptr;
  OIIO::ustring self_;
  std::vector<Part> parts_;  // as open() found them: read without a lock
  int part_ = 0, level_ = 0;
};

OIIO::ImageInput* createPyramidInput() { return new PyramidInput; }

}  // namespace

LevelMaker::~LevelMaker() {
  for (OIIO::ImageCache::Perthread* thread : idle_) cache_.destroy_thread_info(thread);
}

OIIO::ustring LevelMaker::add(const std::string& file) {
  const OIIO::ustring name(kPrefix + file);
  OIIO::ImageSpec config;
  LevelMaker* self = this;
  config.attribute(kMakerAttribute, OIIO::TypeDesc::PTR, &self);
  config.attribute(kFileAttribute, file);
  cache_.add_file(name, createPyramidInput, &config);
  return name;
}

OIIO::ImageCache::Perthread* LevelMaker::borrow() {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      OIIO::ImageCache::Perthread* thread = idle_.back();
      idle_.pop_back();
      return cache_.get_perthread_info(thread);
    }
  }
  return cache_.create_thread_info();
}

void LevelMaker::giveBack(OIIO::ImageCache::Perthread* thread) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(thread);
}

}  // namespace kinora::texture
