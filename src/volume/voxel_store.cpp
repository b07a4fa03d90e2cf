#include "volume/voxel_store.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/mman.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace kinora::volume {

namespace {

bool isInMemory(const std::string& folder) {
  struct statfs of {};
  return ::statfs(folder.c_str(), &of) == 0 && (of.f_type == TMPFS_MAGIC || of.f_type == RAMFS_MAGIC);
}
std::string usualFolder() {
  const char* const named = std::getenv("TMPDIR");
  std::string folder = named && *named ? named : "/tmp";
  if (isInMemory(folder) && !isInMemory("/var/tmp")) folder = "/var/tmp";
  return folder;
}

}  // namespace

VoxelStore::VoxelStore(uint64_t bytes, std::string folder)
    : most_(bytes), folder_(folder.empty() ? usualFolder() : std::move(folder)) {}

VoxelStore::~VoxelStore() {
  if (base_) ::munmap(reinterpret_cast<void*>(base_), kReach);
  if (file_ >= 0) ::close(file_);
}

float* VoxelStore::add(size_t floats, uint32_t level) {
  const uint64_t bytes = floats * sizeof(float);
  // A quarter of the bound may be taken by what stays: the rest is for what comes and goes, and for the process that
  // reads the file while it does (see Filling). A quarter of that quarter is kept for levels above the first coarse
  // one, which are 1 / 56 of their grids.
  const uint64_t mostStays = most_ / 4, mostFine = most_ / 16 * 3;
  const bool isFine = level < 2;
  const bool fits = slabBytes_ + bytes <= mostStays && (!isFine || fineBytes_ + bytes <= mostFine);
  const bool stays = !most_ || !failure_.empty() || (fits && (!base_ || !isFine));
  if (!stays && bytes <= kSegment && (base_ || openFile())) {
    Room own;
    Room& room = level ? coarse_[isFine ? 0 : 1] : own;
    const uint64_t asked = level ? std::max(bytes, kChunk) : bytes;
    if (room.bytes < bytes) room = {addToFile(asked), asked};
    if (room.at) {
      float* const at = room.at;
      room.at += floats;
      room.bytes -= bytes;
      for (uint64_t x = 0; x < bytes; x += kChunk) use(at + x / sizeof(float));
      return at;
    }
    room = {};
  }
  memory_.add(bytes);
  slabs_.push_back(std::make_unique_for_overwrite<float[]>(floats));
  slabBytes_ += bytes;
  if (isFine) fineBytes_ += bytes;
  return slabs_.back().get();
}

float* VoxelStore::addToFile(uint64_t bytes) {
  // no piece lies across the border of two chunks unless it is larger than one
  const uint64_t left = kChunk - used_ % kChunk;
  if (bytes > left && left < kChunk) used_ += left;
  if (used_ + bytes > length_ && !growFile()) return nullptr;
  float* const at = reinterpret_cast<float*>(base_ + used_);
  used_ += bytes;
  return at;
}

void VoxelStore::release(const Mark& mark) {
  slabs_.resize(mark.slabs);
  memory_.set(memory_.bytes() - (slabBytes_ - mark.slabBytes));
  slabBytes_ = mark.slabBytes;
  fineBytes_ = mark.fineBytes;
  used_ = mark.used;
  for (Room& room : coarse_) room = {};  // the chunk may have been given back
}

bool VoxelStore::openFile() {
  const auto fail = [&] {
    failure_ = "no file in '" + folder_ + "' (" + std::strerror(errno) + ")";
    return false;
  };
  file_ = ::open(folder_.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file_ < 0) {  // file systems that know no files without a name
    std::string name = folder_ + "/kinora-voxels-XXXXXX";
    file_ = ::mkostemp(name.data(), O_CLOEXEC);
    if (file_ < 0) return fail();
    ::unlink(name.c_str());
  }
  // addresses for all that may come, so that bricks never move
  constexpr uint64_t kRoom = kReach + kChunk;
  void* const at = ::mmap(nullptr, kRoom, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (at == MAP_FAILED) return fail();
  // a page that is asked for brings its neighbours, up to a huge page: those of its own chunk alone
  const uintptr_t first = reinterpret_cast<uintptr_t>(at), begin = (first + kChunk - 1) / kChunk * kChunk;
  if (begin > first) ::munmap(at, begin - first);
  if (begin < first + kChunk) ::munmap(reinterpret_cast<void*>(begin + kReach), first + kChunk - begin);
  const uint64_t window = std::max(kLeast, most_ - most_ / 4);
  memory_.add(window + kReach / kChunk);
  chunks_ = std::make_unique<std::atomic<uint8_t>[]>(kReach / kChunk);
  mostChunks_ = window / kChunk;
  base_ = begin;
  return true;
}

// The disk's room is taken before it is written to: a page without any would end the program.
bool VoxelStore::growFile() {
  const uint64_t end = length_ + kSegment;
  int error = end > kReach ? EFBIG : ::posix_fallocate(file_, off_t(length_), off_t(kSegment));
  if (!error && ::mmap(reinterpret_cast<void*>(base_ + length_), kSegment, PROT_READ | PROT_WRITE,
                       MAP_SHARED | MAP_FIXED, file_, off_t(length_)) == MAP_FAILED)
    error = errno;
  if (error) {
    failure_ = "no more room for them in '" + folder_ + "' (" + std::strerror(error) + ")";
    return false;
  }
  used_ = length_;
  length_ = end;
  return true;
}

void VoxelStore::comeIn(size_t chunk) {
  // again where others let it go while this thread made room
  while (chunks_[chunk].exchange(kUsed, std::memory_order_relaxed) == kOut) {
    cameIn_.fetch_add(1, std::memory_order_relaxed);
    const uint64_t now = inside_.fetch_add(1, std::memory_order_relaxed) + 1;
    for (uint64_t most = mostInside_.load(std::memory_order_relaxed);
         now > most && !mostInside_.compare_exchange_weak(most, now, std::memory_order_relaxed);) {
    }
    if (now <= mostInside()) return;
    letGo();
  }
}

// Second chances: what was not used since the hand came by last goes, until an eighth of the room is free. Who wants more
// meanwhile waits: the bound would not hold otherwise. A thread that reads a chunk which goes reads the file's pages
// again; they are the same.
void VoxelStore::letGo() {
  const std::lock_guard lock(letting_);
  const uint64_t most = mostInside();
  if (inside_.load(std::memory_order_relaxed) <= most) return;
  const size_t count = (length_ + kChunk - 1) / kChunk;
  const uint64_t goal = most - most / 8;
  for (size_t seen = 0; seen < 3 * count && inside_.load(std::memory_order_relaxed) > goal; ++seen) {
    hand_ = hand_ + 1 < count ? hand_ + 1 : 0;
    std::atomic<uint8_t>& state = chunks_[hand_];
    uint8_t is = kUsed;
    if (state.compare_exchange_strong(is, kOld, std::memory_order_relaxed) || is == kOut) continue;
    is = kOld;
    if (!state.compare_exchange_strong(is, kOut, std::memory_order_relaxed)) continue;
    ::madvise(reinterpret_cast<void*>(base_ + hand_ * kChunk), kChunk, MADV_DONTNEED);
    inside_.fetch_sub(1, std::memory_order_relaxed);
    wentOut_.fetch_add(1, std::memory_order_relaxed);
  }
}

VoxelStore::Counts VoxelStore::counts() const {
  return {slabBytes_, used_, cameIn_, wentOut_, slabBytes_ + mostInside_ * kChunk};
}

}  // namespace kinora::volume
