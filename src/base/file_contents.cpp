#include "base/file_contents.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <tbb/parallel_for.h>
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

std::vector<int64_t> stampsOf(const std::vector<std::string>& paths) {
  std::vector<int64_t> stamps;
  for (const std::string& path : paths) {
    struct stat s {};
    const bool isThere = stat(path.c_str(), &s) == 0;
    for (const int64_t v : {int64_t(s.st_mtim.tv_sec), int64_t(s.st_mtim.tv_nsec), int64_t(s.st_size)})
      stamps.push_back(isThere ? v : -1);
  }
  return stamps;
}

// Several are the parts of an atlas, which say by their names where they belong.
std::optional<Digest> read(const std::vector<std::string>& paths) {
  if (paths.empty()) return {};
  if (paths.size() == 1) return digestOfFile(paths[0]);
  Hasher h;
  for (const std::string& path : paths) {
    h.text(std::filesystem::path(path).filename().string());
    h.digest(digestOfFile(path).value_or(Digest()));
  }
  return h.result();
}

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

FileContents::Listening::Listening(FileContents& contents, Names& names) : contents_(contents) {
  const std::lock_guard lock(contents_.mutex_);
  contents_.listener_ = &names;
}

FileContents::Listening::~Listening() {
  const std::lock_guard lock(contents_.mutex_);
  contents_.listener_ = nullptr;
}

bool FileContents::hasChanged(const std::function<std::string(const Entry&)>& find) {
  std::vector<Entry> lacking;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [key, known] : files_) {
      if (known.isGiven) continue;
      if (known.paths.empty()) lacking.push_back({key.first, key.second, {}});
      if (stampsOf(known.paths) != known.stamps) return true;
    }
  }
  return std::any_of(lacking.begin(), lacking.end(), [&](const Entry& e) { return !find(e).empty(); });
}

void FileContents::forgetAll() {
  const std::lock_guard lock(mutex_);
  files_.clear();
}

FileContents::Known& FileContents::used(std::string_view kind, const std::string& name) {
  std::pair<std::string, std::string> key(kind, name);
  if (listener_) listener_->insert(key);
  Known& known = files_[std::move(key)];
  known.isUsed = true;
  return known;
}

void FileContents::use(std::string_view kind, const std::string& name, const std::vector<std::string>& paths) {
  const std::lock_guard lock(mutex_);
  Known& known = used(kind, name);
  if (known.paths == paths && !known.isGiven) return;
  known.paths = paths;
  known.stamps = stampsOf(paths);
  known.content.reset();
  known.isGiven = known.isRead = false;
}

void FileContents::use(std::string_view kind, const std::string& name, const Digest& content) {
  const std::lock_guard lock(mutex_);
  Known& known = used(kind, name);
  known.paths.clear();
  known.content = content;
  known.isGiven = known.isRead = true;
}

void FileContents::again(std::string_view kind, const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (files_.contains({std::string(kind), name})) used(kind, name);
}

void FileContents::again(const Names& names) {
  for (const auto& [kind, name] : names) again(kind, name);
}

std::vector<FileContents::Entry> FileContents::names() {
  const std::lock_guard lock(mutex_);
  std::vector<Entry> list;
  for (const auto& [key, known] : files_)
    if (known.isUsed) list.push_back({key.first, key.second, {}});
  return list;
}

std::optional<Digest> FileContents::contentOf(const std::string& kind, const std::string& name) {
  std::unique_lock lock(mutex_);
  const auto it = files_.find({kind, name});  // entries stay where they are
  if (it == files_.end()) return {};
  Known& known = it->second;
  if (known.isRead) return known.content;
  const std::vector<std::string> paths = known.paths;
  const std::vector<int64_t> stamps = known.stamps;
  lock.unlock();
  std::optional<Digest> content = read(paths);
  if (const std::vector<int64_t> now = stampsOf(paths); now != stamps) {
    Hasher h;
    h.digest(content.value_or(Digest()));
    for (const auto& list : {stamps, now}) h.bytes(list.data(), list.size() * sizeof list[0]);
    content = h.result();
  }
  lock.lock();
  if (known.isRead || known.paths != paths) return known.content;
  known.content = content;
  known.isRead = true;
  return content;
}

std::vector<FileContents::Entry> FileContents::used() {
  std::vector<Entry> list = names();
  // disks answer many requests at once
  tbb::parallel_for(size_t(0), list.size(),
                    [&](size_t i) { list[i].content = contentOf(list[i].kind, list[i].name); });
  return list;
}

}  // namespace kinora
