#include "rib/byte_source.h"

#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string_view>
#include <vector>

#include "base/text.h"

namespace kinora::rib {

namespace {

// zlib passes bytes through unchanged when they do not begin with gzip's magic.
class GzipOrPlain : public ByteSource {
 public:
  explicit GzipOrPlain(gzFile file) : file_(file) { gzbuffer(file_, 1u << 18); }
  ~GzipOrPlain() override { gzclose_r(file_); }
  size_t read(char* to, size_t size) override {
    const int n = gzread(file_, to, unsigned(std::min<size_t>(size, 1u << 30)));
    if (n > 0) return size_t(n);
    int code = Z_OK;
    const char* text = gzerror(file_, &code);
    if (code == Z_ERRNO)
      failure_ = std::strerror(errno);
    else if (code != Z_OK && code != Z_STREAM_END)
      failure_ = text && *text ? text : "broken gzip data";
    return 0;
  }
  std::string failure() const override { return failure_; }

 private:
  gzFile file_;
  std::string failure_;
};

class Text : public ByteSource {
 public:
  explicit Text(std::string text) : text_(std::move(text)) {}
  size_t read(char* to, size_t size) override {
    const size_t n = std::min(size, text_.size() - at_);
    std::memcpy(to, text_.data() + at_, n);
    at_ += n;
    return n;
  }

 private:
  std::string text_;
  size_t at_ = 0;
};

struct CloseFile {
  void operator()(FILE* f) const { std::fclose(f); }
};
using File = std::unique_ptr<FILE, CloseFile>;

// A member of a zip archive, stored or deflated, read as it is asked for.
class ZipMember : public ByteSource {
 public:
  ZipMember(File file, uint64_t compressedSize, bool deflated)
      : file_(std::move(file)), left_(compressedSize), deflated_(deflated) {
    if (deflated_ && inflateInit2(&stream_, -MAX_WBITS) != Z_OK) failure_ = "cannot start decompression";
  }
  ~ZipMember() override {
    if (deflated_) inflateEnd(&stream_);
  }
  size_t read(char* to, size_t size) override {
    if (!failure_.empty() || ended_) return 0;
    if (!deflated_) {
      const size_t n = std::fread(to, 1, size_t(std::min<uint64_t>(size, left_)), file_.get());
      left_ -= n;
      if (n == 0 && left_ > 0) failure_ = "zip member ends early";
      return n;
    }
    stream_.next_out = reinterpret_cast<Bytef*>(to);
    stream_.avail_out = unsigned(std::min<size_t>(size, 1u << 30));
    const unsigned wanted = stream_.avail_out;
    while (stream_.avail_out == wanted) {
      if (stream_.avail_in == 0) {
        const size_t n = std::fread(in_, 1, size_t(std::min<uint64_t>(sizeof in_, left_)), file_.get());
        left_ -= n;
        if (n == 0) {
          failure_ = "zip member ends early";
          return 0;
        }
        stream_.next_in = in_;
        stream_.avail_in = unsigned(n);
      }
      const int result = inflate(&stream_, Z_NO_FLUSH);
      if (result == Z_STREAM_END) {
        ended_ = true;
        break;
      }
      if (result != Z_OK) {
        failure_ = "broken zip data";
        break;
      }
    }
    return wanted - stream_.avail_out;
  }
  std::string failure() const override { return failure_; }

 private:
  File file_;
  uint64_t left_;
  bool deflated_, ended_ = false;
  z_stream stream_{};
  unsigned char in_[1 << 16];
  std::string failure_;
};

uint32_t little(const unsigned char* p, int bytes) {
  uint32_t v = 0;
  for (int i = 0; i < bytes; ++i) v |= uint32_t(p[i]) << (8 * i);
  return v;
}

struct ZipEntry {
  std::string name;
  unsigned method = 0, flags = 0;
  uint64_t compressed = 0;
  long local = 0;  // offset of the header before its bytes
};

// Walks the central directory (APPNOTE 4.3.12) until `visit` says true. False with a reason when it cannot be read
// to where it was needed. Zip64 is not understood.
template <class Visit>
bool walkZip(FILE* file, std::string& why, const Visit& visit) {
  why = "is not a zip archive";
  std::fseek(file, 0, SEEK_END);
  const long size = std::ftell(file);
  constexpr long kEndRecord = 22, kMostComment = 65535;
  if (size < kEndRecord) return false;
  std::vector<unsigned char> tail(size_t(std::min(size, kEndRecord + kMostComment)));
  std::fseek(file, size - long(tail.size()), SEEK_SET);
  if (std::fread(tail.data(), 1, tail.size(), file) != tail.size()) return false;
  long end = long(tail.size()) - kEndRecord;
  while (end >= 0 && std::memcmp(&tail[size_t(end)], "PK\5\6", 4) != 0) --end;
  if (end < 0) return false;
  const unsigned entries = little(&tail[size_t(end) + 10], 2);
  const uint32_t start = little(&tail[size_t(end) + 16], 4);
  if (start == 0xffffffffu) {
    why = "is a zip archive of the 64-bit form, which is not understood";
    return false;
  }
  why = "is a zip archive with a broken directory";
  if (std::fseek(file, long(start), SEEK_SET) != 0) return false;
  for (unsigned i = 0; i < entries; ++i) {
    unsigned char h[46];
    if (std::fread(h, 1, sizeof h, file) != sizeof h || std::memcmp(h, "PK\1\2", 4) != 0) return false;
    ZipEntry e;
    e.name.assign(little(h + 28, 2), '\0');
    if (std::fread(e.name.data(), 1, e.name.size(), file) != e.name.size()) return false;
    e.method = little(h + 10, 2);
    e.flags = little(h + 8, 2);
    e.compressed = little(h + 20, 4);
    e.local = long(little(h + 42, 4));
    if (visit(e)) return true;
    if (std::fseek(file, long(little(h + 30, 2) + little(h + 32, 2)), SEEK_CUR) != 0) return false;
  }
  why.clear();
  return true;
}

// Encrypted members are not understood.
std::unique_ptr<ByteSource> openEntry(File file, const ZipEntry& e, std::string& why) {
  if ((e.flags & 1) || (e.method != 0 && e.method != Z_DEFLATED)) {
    why = "holds '" + e.name + "' in a form that is not understood (encrypted, or not deflate)";
    return nullptr;
  }
  why = "is a zip archive whose member '" + e.name + "' is not where its directory says";
  unsigned char l[30];
  if (std::fseek(file.get(), e.local, SEEK_SET) != 0 || std::fread(l, 1, sizeof l, file.get()) != sizeof l ||
      std::memcmp(l, "PK\3\4", 4) != 0)
    return nullptr;
  if (std::fseek(file.get(), long(little(l + 26, 2) + little(l + 28, 2)), SEEK_CUR) != 0) return nullptr;
  why.clear();
  return std::make_unique<ZipMember>(std::move(file), e.compressed, e.method == Z_DEFLATED);
}

std::unique_ptr<ByteSource> openZipMember(const std::string& path, const std::string& member, std::string& why) {
  File file(std::fopen(path.c_str(), "rb"));
  if (!file) {
    why = std::strerror(errno);
    return nullptr;
  }
  ZipEntry found;
  bool isFound = false;
  if (!walkZip(file.get(), why, [&](const ZipEntry& e) {
        if (e.name != member) return false;
        found = e;
        return isFound = true;
      }))
    return nullptr;
  if (isFound) return openEntry(std::move(file), found, why);
  why = "has no member '" + member + "'";
  return nullptr;
}

std::string baseOf(const std::string& path) { return path.substr(path.find_last_of("/!") + 1); }

bool isScene(const std::string& name) {
  const std::string base = lowerCase(baseOf(name));
  // Macintoshes put a twin with what their file system knows beside each file
  if (name.starts_with("__MACOSX/") || base.starts_with(".")) return false;
  return base.ends_with(".rib") || base.ends_with(".rib.gz") || base.ends_with(".ribz");
}

// Whether its text has a world, as far as a look at so many bytes tells.
bool hasWorld(const std::string& path, const std::string& member, size_t& most) {
  std::string why;
  const auto source = openZipMember(path, member, why);
  if (!source) return false;
  static constexpr std::string_view kWord = "WorldBegin";
  std::string text;
  std::vector<char> part(1 << 16);
  while (most > 0) {
    const size_t n = source->read(part.data(), std::min(part.size(), most));
    if (n == 0) return false;
    most -= n;
    text.erase(0, text.size() - std::min(text.size(), kWord.size()));
    text.append(part.data(), n);
    if (text.find(kWord) != std::string::npos) return true;
  }
  return false;
}

bool splitZip(const std::string& path, std::string& archive, std::string& member) {
  const size_t bang = path.find('!');
  if (bang == std::string::npos || bang == 0 || bang + 1 == path.size()) return false;
  archive = path.substr(0, bang);
  member = path.substr(bang + 1);
  return true;
}

}  // namespace

// Devices and pipes may never end: a scene's strings cannot name them, the command line can.
bool isReadable(const std::string& path) {
  struct stat s {};
  if (stat(path.c_str(), &s) == 0) return S_ISREG(s.st_mode);
  std::string archive, member, why;
  if (!splitZip(path, archive, member) || stat(archive.c_str(), &s) != 0 || !S_ISREG(s.st_mode)) return false;
  return openZipMember(archive, member, why) != nullptr;
}

std::string sceneIn(const std::string& path, std::string& why) {
  why.clear();
  struct stat s {};
  if (path == "-" || stat(path.c_str(), &s) != 0 || !S_ISREG(s.st_mode)) return path;
  File file(std::fopen(path.c_str(), "rb"));
  char magic[4];
  if (!file || std::fread(magic, 1, sizeof magic, file.get()) != sizeof magic ||
      (std::memcmp(magic, "PK\3\4", 4) != 0 && std::memcmp(magic, "PK\5\6", 4) != 0))
    return path;
  std::vector<std::string> scenes;
  if (!walkZip(file.get(), why, [&](const ZipEntry& e) {
        if (isScene(e.name)) scenes.push_back(e.name);
        return false;
      }))
    return {};
  const auto depth = [](const std::string& name) { return std::count(name.begin(), name.end(), '/'); };
  const auto keep = [&](const auto& is) {
    std::vector<std::string> kept;
    for (const std::string& name : scenes)
      if (is(name)) kept.push_back(name);
    if (!kept.empty()) scenes = std::move(kept);
  };
  // the one named like the archive; the one with a world; the one that stands above all others
  const std::string base = lowerCase(baseOf(path)), stem = base.substr(0, base.rfind('.'));
  keep([&](const std::string& name) { return lowerCase(baseOf(name)).starts_with(stem + ".rib"); });
  size_t most = 64 << 20;
  if (scenes.size() > 1) keep([&](const std::string& name) { return hasWorld(path, name, most); });
  auto least = std::numeric_limits<decltype(depth(path))>::max();
  for (const std::string& name : scenes) least = std::min(least, depth(name));
  keep([&](const std::string& name) { return depth(name) == least; });
  if (scenes.size() == 1) return path + "!" + scenes[0];
  if (scenes.empty()) {
    why = "is a zip archive without a RIB file";
    return {};
  }
  why = "is a zip archive of several RIB files (";
  for (size_t i = 0; i < scenes.size() && i < 4; ++i) why += (i ? ", " : "") + scenes[i].substr(0, 80);
  why += scenes.size() > 4 ? ", ...)" : ")";
  return {};
}

std::unique_ptr<ByteSource> openFile(const std::string& path, std::string& why) {
  if (path == "-") {
    const int fd = dup(0);
    gzFile in = fd >= 0 ? gzdopen(fd, "rb") : nullptr;
    if (in) return std::make_unique<GzipOrPlain>(in);
    if (fd >= 0) close(fd);
    why = "standard input is closed";
    return nullptr;
  }
  struct stat s {};
  if (stat(path.c_str(), &s) != 0) {
    why = std::strerror(errno);
    std::string archive, member;
    if (splitZip(path, archive, member) && stat(archive.c_str(), &s) == 0) return openZipMember(archive, member, why);
    return nullptr;
  }
  if (S_ISDIR(s.st_mode)) {
    why = "is a directory";
    return nullptr;
  }
  gzFile file = gzopen(path.c_str(), "rb");
  if (!file) {
    why = errno ? std::strerror(errno) : "cannot be opened";
    return nullptr;
  }
  return std::make_unique<GzipOrPlain>(file);
}

std::unique_ptr<ByteSource> openText(std::string text) { return std::make_unique<Text>(std::move(text)); }

}  // namespace kinora::rib
