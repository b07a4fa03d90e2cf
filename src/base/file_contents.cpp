#include "base/file_contents.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

namespace kinora {

namespace {

class File {
 public:
  explicit File(const std::string& path) : descriptor_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~File() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  File(const File&) = delete;
  // Of a regular file; -1: it is none or cannot be opened.
  int64_t size() const {
    struct stat s;
    return descriptor_ >= 0 && fstat(descriptor_, &s) == 0 && S_ISREG(s.st_mode) ? int64_t(s.st_size) : -1;
  }
  bool read(char* to, size_t bytes, uint64_t at) const {
    while (bytes > 0) {
      const ssize_t n = pread(descriptor_, to, bytes, off_t(at));
      if (n <= 0) return false;
      to += n, at += uint64_t(n), bytes -= size_t(n);
    }
    return true;
  }

 private:
  int descriptor_;
};

}  // namespace

std::optional<Digest> digestOfFile(const std::string& path) {
  constexpr uint64_t kPiece = 1 << 20, kBlock = 4096, kBlocks = 1024;
  const File file(path);
  const int64_t found = file.size();
  if (found < 0) return {};
  const uint64_t size = uint64_t(found);
  std::vector<char> piece(size_t(std::min(size, kPiece)));
  Hasher h;
  h.word(size);
  const auto take = [&](uint64_t at, uint64_t bytes) {
    if (!file.read(piece.data(), size_t(bytes), at)) return false;
    h.bytes(piece.data(), size_t(bytes));
    return true;
  };
  if (size <= kWholeFile) {
    for (uint64_t at = 0; at < size; at += kPiece)
      if (!take(at, std::min(kPiece, size - at))) return {};
    return h.result();
  }
  if (!take(0, kPiece)) return {};
  const uint64_t between = size - 2 * kPiece - kBlock;
  for (uint64_t i = 0; i < kBlocks; ++i)
    if (!take(kPiece + between / kBlocks * i + between % kBlocks * i / kBlocks, kBlock)) return {};
  if (!take(size - kPiece, kPiece)) return {};
  return h.result();
}

void FileContents::begin() {
  const std::lock_guard lock(mutex_);
  for (auto& [key, known] : files_) known.isUsed = false;
}

void FileContents::use(std::string_view kind, const std::string& name, const std::vector<std::string>& paths) {
  const std::lock_guard lock(mutex_);
  Known& known = files_[{std::string(kind), name}];
  known.isUsed = true;
  if (known.paths == paths && !known.isGiven) return;
  known.paths = paths;
  known.content.reset();
  known.isGiven = known.isRead = false;
}

void FileContents::use(std::string_view kind, const std::string& name, const Digest& content) {
  const std::lock_guard lock(mutex_);
  Known& known = files_[{std::string(kind), name}];
  known.paths.clear();
  known.content = content;
  known.isGiven = known.isRead = known.isUsed = true;
}

void FileContents::again(std::string_view kind, const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (const auto it = files_.find({std::string(kind), name}); it != files_.end()) it->second.isUsed = true;
}

std::optional<Digest> FileContents::read(const std::vector<std::string>& paths) {
  if (paths.empty()) return {};
  if (paths.size() == 1) return digestOfFile(paths[0]);
  // the parts of an atlas say by their names where they belong
  Hasher h;
  for (const std::string& path : paths) {
    h.text(std::filesystem::path(path).filename().string());
    h.digest(digestOfFile(path).value_or(Digest()));
  }
  return h.result();
}

std::vector<FileContents::Entry> FileContents::used() {
  const std::lock_guard lock(mutex_);
  std::vector<Known*> unread;
  for (auto& [key, known] : files_)
    if (known.isUsed && !known.isRead) unread.push_back(&known);
  // Disks answer many requests at once. Isolated: a thread that waits here with the lock takes no other work, which
  // might use a file too.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(size_t(0), unread.size(), [&](size_t i) {
      unread[i]->content = read(unread[i]->paths);
      unread[i]->isRead = true;
    });
  });
  std::vector<Entry> list;
  for (const auto& [key, known] : files_)
    if (known.isUsed) list.push_back({key.first, key.second, known.content});
  return list;
}

}  // namespace kinora
