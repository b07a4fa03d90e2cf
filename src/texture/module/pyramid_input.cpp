#include "texture/module/pyramid_input.h"

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
constexpr int kRowsAtOnce = 32;

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
      if (!read(part, level, moved(window, p.originX, p.originY), pixels)) return false;
    } else if (level == p.given) {
      if (!average(p, part, window, pixels.data())) return false;
    } else {
      const std::vector<std::vector<float>>* kept = keptLevels(p, part);
      if (!kept) return false;
      const float* from = (*kept)[size_t(level - p.given - 1)].data();
      const size_t count = size_t(window.width()) * channels;
      for (int j = 0; j < window.height(); ++j)
        std::copy_n(from + (size_t(y + j) * size_t(spec.width) + size_t(x)) * channels, count,
                    pixels.data() + size_t(j) * count);
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
  static LevelSize sizeOf(const OIIO::ImageSpec& spec) { return {spec.width, spec.height}; }

  // A window of the first coarse level.
  bool average(const Part& p, int part, const LevelWindow& window, float* out) {
    const LevelSize fine = sizeOf(p.levels[size_t(p.given - 1)]), coarse = sizeOf(p.levels[size_t(p.given)]);
    const LevelWindow under = windowUnder(window, coarse, fine);
    const int channels = p.levels[0].nchannels;
    std::vector<float> source(size_t(under.width()) * size_t(under.height()) * size_t(channels));
    if (!read(part, p.given - 1, moved(under, p.originX, p.originY), source)) return false;
    averageAreas(source.data(), fine, coarse, window, channels, out);
    return true;
  }

  // Null when the file cannot be read. Who waits here holds up tiles of coarse levels alone, which the making of them
  // does not need.
  const std::vector<std::vector<float>>* keptLevels(const Part& p, int part) {
    LevelMaker::Kept& kept = maker_->kept(self_.string(), part);
    const std::lock_guard lock(kept.mutex);
    if (!kept.levels.empty()) return &kept.levels;
    const size_t first = size_t(p.given) + 1, channels = size_t(p.levels[0].nchannels);
    std::vector<std::vector<float>> made(p.levels.size() - first);
    for (size_t i = 0; i < made.size(); ++i) {
      const LevelSize fine = sizeOf(p.levels[first + i - 1]), coarse = sizeOf(p.levels[first + i]);
      made[i].resize(size_t(coarse.width) * size_t(coarse.height) * channels);
      // the first of them by rows, of as much of the image as these need
      const int step = i == 0 ? kRowsAtOnce : coarse.height;
      std::vector<float> strip;
      for (int row = 0; row < coarse.height; row += step) {
        const LevelWindow rows{0, row, coarse.width, std::min(row + step, coarse.height)};
        if (i == 0) {
          const LevelWindow under = windowUnder(rows, coarse, fine);
          strip.resize(size_t(under.width()) * size_t(under.height()) * channels);
          if (!average(p, part, under, strip.data())) return nullptr;
        }
        averageAreas(i == 0 ? strip.data() : made[i - 1].data(), fine, coarse, rows, int(channels),
                     made[i].data() + size_t(row) * size_t(coarse.width) * channels);
      }
    }
    kept.levels = std::move(made);
    return &kept.levels;
  }

  bool read(int part, int level, const LevelWindow& w, std::vector<float>& pixels) {
    const LevelMaker::Asker asker(*maker_);
    const int channels = parts_[size_t(part)].levels[0].nchannels;
    // the shorter form of the call forgets whose it is
    if (cache_->get_pixels(file_, asker.thread(), part, level, w.x0, w.x1, w.y0, w.y1, 0, 1, 0, channels,
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
  {
    const std::lock_guard lock(adding_);  // the entry's reader asks for mutex_
    if (!added_.insert(name.string()).second) return name;
    // an entry of a cache that was used before reads by a maker that is gone
    cache_.add_file(name, createPyramidInput, &config, true);
  }
  return name;
}

LevelMaker::Kept& LevelMaker::kept(const std::string& file, int part) {
  const std::lock_guard lock(mutex_);
  return kept_[{file, part}];
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
