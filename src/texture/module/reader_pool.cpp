#include "texture/module/reader_pool.h"

#include <OpenImageIO/imageio.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "texture/module/srgb_input.h"

namespace kinora::texture {
namespace {

constexpr const char* kPaceAttribute = "kinora:pace";
constexpr int kMostReaders = 8;  // of a file
// Of all files, beside the first of each. The library keeps a hundred files open, and the process has others.
constexpr int kMostExtra = 192;
constexpr uint64_t kFilesOfOthers = 256;

int mostExtra() {
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur < kFilesOfOthers) return 0;
  return int(std::min<uint64_t>((files.rlim_cur - kFilesOfOthers) / 4, kMostExtra));
}

// Notes how long its life was without the CPU, if it slept at all: a thread that others have pushed aside is not
// waiting for its file.
class WaitClock {
 public:
  explicit WaitClock(ReadPace& pace) : pace_(pace), start_(Clock::now()) { getrusage(RUSAGE_THREAD, &used_); }
  ~WaitClock() {
    rusage now{};
    getrusage(RUSAGE_THREAD, &now);
    const double wall = std::chrono::duration<double, std::micro>(Clock::now() - start_).count();
    const bool slept = now.ru_nvcsw > used_.ru_nvcsw;
    const float waited = slept ? float(std::max(wall - (cpu(now) - cpu(used_)), 0.0)) : 0.f;
    constexpr float kShare = 1 / 16.f;
    const float mean = pace_.waited.load(std::memory_order_relaxed);
    pace_.waited.store(mean + (waited - mean) * kShare, std::memory_order_relaxed);  // a lost one does not matter
  }
  WaitClock(const WaitClock&) = delete;
  WaitClock& operator=(const WaitClock&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  static double cpu(const rusage& r) {
    return double(r.ru_utime.tv_sec + r.ru_stime.tv_sec) * 1e6 + double(r.ru_utime.tv_usec + r.ru_stime.tv_usec);
  }
  ReadPace& pace_;
  Clock::time_point start_;
  rusage used_{};
};

class PooledInput final : public OIIO::ImageInput {
 public:
  explicit PooledInput(bool isSrgb) : isSrgb_(isSrgb) {}
  ~PooledInput() override { close(); }
  const char* format_name() const override { return format_.c_str(); }
  int supports(OIIO::string_view feature) const override { return first_ ? first_->supports(feature) : 0; }

  bool open(const std::string& name, OIIO::ImageSpec& spec) override { return open(name, spec, OIIO::ImageSpec()); }
  bool open(const std::string& name, OIIO::ImageSpec& spec, const OIIO::ImageSpec& config) override {
    close();
    const OIIO::ParamValue* pace = config.find_attribute(kPaceAttribute, OIIO::TypeDesc::PTR);
    if (!pace) {
      errorfmt("no cache to read for");
      return false;
    }
    pace_ = *static_cast<ReadPace* const*>(pace->data());
    name_ = name;
    config_ = config;
    std::string why;
    std::unique_ptr<OIIO::ImageInput> reader = openOne(why);
    if (!reader) {
      errorfmt("{}", why);
      return false;
    }
    first_ = reader.get();
    format_ = first_->format_name();
    part_ = level_ = 0;
    spec = m_spec = first_->spec();
    idle_.push_back(std::move(reader));
    readers_ = 1;
    return true;
  }
  bool close() override {
    if (readers_ > 1) pace_->extra.fetch_sub(readers_ - 1, std::memory_order_relaxed);
    first_ = nullptr;
    readers_ = 0;
    idle_.clear();
    return true;
  }
  int current_subimage() const override { return part_; }
  int current_miplevel() const override { return level_; }
  bool seek_subimage(int part, int level) override {
    lock_guard lock(*this);
    if (part == part_ && level == level_) return true;
    const Loan reader(*this, part, level);
    if (!reader->seek_subimage(part, level)) return false;
    m_spec = reader->spec();
    part_ = part;
    level_ = level;
    return true;
  }
  OIIO::ImageSpec spec(int part, int level) override { return Loan(*this, part, level)->spec(part, level); }
  OIIO::ImageSpec spec_dimensions(int part, int level) override {
    return Loan(*this, part, level)->spec_dimensions(part, level);
  }
  using OIIO::ImageInput::spec;
  // What the cache calls, by any number of threads.
  bool read_tiles(int part, int level, int x0, int x1, int y0, int y1, int z0, int z1, int c0, int c1,
                  OIIO::TypeDesc format, void* data, OIIO::stride_t dx, OIIO::stride_t dy,
                  OIIO::stride_t dz) override {
    return read(part, level, [&](OIIO::ImageInput& r) {
      return r.read_tiles(part, level, x0, x1, y0, y1, z0, z1, c0, c1, format, data, dx, dy, dz);
    });
  }
  bool read_scanlines(int part, int level, int y0, int y1, int z, int c0, int c1, OIIO::TypeDesc format, void* data,
                      OIIO::stride_t dx, OIIO::stride_t dy) override {
    return read(part, level, [&](OIIO::ImageInput& r) {
      return r.read_scanlines(part, level, y0, y1, z, c0, c1, format, data, dx, dy);
    });
  }
  bool read_native_scanline(int part, int level, int y, int z, void* data) override {
    return read(part, level, [&](OIIO::ImageInput& r) { return r.read_native_scanline(part, level, y, z, data); });
  }
  bool read_native_tile(int part, int level, int x, int y, int z, void* data) override {
    return read(part, level, [&](OIIO::ImageInput& r) { return r.read_native_tile(part, level, x, y, z, data); });
  }

 private:
  // One of the readers, for one thread; rather one that stands at the level: seeking may mean to read a directory.
  class Loan {
   public:
    Loan(PooledInput& pool, int part, int level) : pool_(pool), reader_(pool.take(part, level)) {}
    ~Loan() { pool_.giveBack(std::move(reader_)); }
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    OIIO::ImageInput* operator->() const { return reader_.get(); }
    OIIO::ImageInput& operator*() const { return *reader_; }

   private:
    PooledInput& pool_;
    std::unique_ptr<OIIO::ImageInput> reader_;
  };

  template <class Call>
  bool read(int part, int level, const Call& call) {
    const Loan reader(*this, part, level);
    const WaitClock clock(*pace_);
    if (const uint32_t delay = pace_->delay.load(std::memory_order_relaxed))
      std::this_thread::sleep_for(std::chrono::microseconds(delay));
    if (call(*reader)) return true;
    errorfmt("{}", reader->geterror());
    return false;
  }

  std::unique_ptr<OIIO::ImageInput> openOne(std::string& why) const {
    std::unique_ptr<OIIO::ImageInput> reader;
    if (isSrgb_) {
      OIIO::ImageSpec ignored;
      reader.reset(createSrgbInput());
      if (reader->open(name_, ignored, config_)) return reader;
      why = reader->geterror();
      return nullptr;
    }
    reader = OIIO::ImageInput::open(name_, &config_);
    if (!reader) why = OIIO::geterror();
    return reader;
  }

  std::unique_ptr<OIIO::ImageInput> take(int part, int level) {
    std::unique_lock lock(pool_);
    for (;;) {
      if (!idle_.empty()) {
        const auto stands = [&](const auto& r) {
          return r->current_subimage() == part && r->current_miplevel() == level;
        };
        const auto found = std::find_if(idle_.begin(), idle_.end(), stands);
        std::swap(found == idle_.end() ? idle_.back() : *found, idle_.back());
        std::unique_ptr<OIIO::ImageInput> reader = std::move(idle_.back());
        idle_.pop_back();
        return reader;
      }
      if (readers_ < kMostReaders && !isFull_ && mayOpen()) {
        ++readers_;
        lock.unlock();
        std::string why;  // told by the first reader, if it fails as well
        if (std::unique_ptr<OIIO::ImageInput> reader = openOne(why)) return reader;
        lock.lock();
        --readers_;
        isFull_ = true;
        pace_->extra.fetch_sub(1, std::memory_order_relaxed);
        continue;
      }
      returned_.wait(lock);
    }
  }
  void giveBack(std::unique_ptr<OIIO::ImageInput> reader) {
    {
      const std::lock_guard lock(pool_);
      idle_.push_back(std::move(reader));
    }
    returned_.notify_one();
  }
  bool mayOpen() {
    if (pace_->extra.fetch_add(1, std::memory_order_relaxed) < mostExtra()) return true;
    pace_->extra.fetch_sub(1, std::memory_order_relaxed);
    return false;
  }

  const bool isSrgb_;
  ReadPace* pace_ = nullptr;
  std::string name_, format_ = "kinora-pool";
  OIIO::ImageSpec config_;
  const OIIO::ImageInput* first_ = nullptr;  // never closed while another is open
  int part_ = 0, level_ = 0;
  std::mutex pool_;
  std::condition_variable returned_;
  std::vector<std::unique_ptr<OIIO::ImageInput>> idle_;
  int readers_ = 0;
  bool isFull_ = false;  // another could not be opened
};

OIIO::ImageInput* createPooledInput() { return new PooledInput(false); }
OIIO::ImageInput* createPooledSrgbInput() { return new PooledInput(true); }

}  // namespace

void addPooledFile(OIIO::ImageCache& cache, OIIO::ustring name, ReadPace& pace, bool isSrgb, OIIO::ImageSpec config) {
  ReadPace* to = &pace;
  config.attribute(kPaceAttribute, OIIO::TypeDesc::PTR, &to);
  cache.add_file(name, isSrgb ? createPooledSrgbInput : createPooledInput, &config);
}

}  // namespace kinora::texture
