// Which files a frame reads and what they hold: the part of its identity that stands on disks. Textures, volumes and
// shaders note here what they use, render/frame_identity.h asks for the digests. Names are as the scene says them and
// contents are compared, not places or times: parts of a frame are made on machines with copies of the same files.
// Thread-safe. It reports nothing: who cannot read a file says so.
#pragma once
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/digest.h"

namespace kinora {

// Of a file's bytes; none when it cannot be read. Up to kWholeFile bytes all count. Of a larger one its size, both
// ends and blocks between them, 6 MiB in all: scenes have terabytes of textures, of which a frame reads a small
// part. What changes such a file without changing its size, its first and last MiB (headers, tables of offsets,
// coarse levels) and any of 1,024 blocks is not seen.
inline constexpr uint64_t kWholeFile = 16 << 20;
std::optional<Digest> digestOfFile(const std::string& path);

class FileContents {
 public:
  struct Entry {
    std::string kind, name;         // "texture", "wood.tex"
    std::optional<Digest> content;  // none: there is no such file
    bool operator==(const Entry&) const = default;
  };

  // Kinds and names of files.
  using Names = std::set<std::pair<std::string, std::string>>;
  // Notes in `names` too what is used while it lives: for who keeps what was made of files and says again() for it
  // in another world. One at a time.
  class Listening {
   public:
    Listening(FileContents& contents, Names& names);
    ~Listening();
    Listening(const Listening&) = delete;

   private:
    FileContents& contents_;
  };

  // Another world: what was used before no longer counts. Contents stay what they were when they were read.
  void begin();
  // Whether a file that was ever used is no longer what it was, by time and size, or one that was not there has a
  // place now: `find` gives the place of a name, "" where there is none.
  bool hasChanged(const std::function<std::string(const Entry&)>& find);
  // Nothing is known of any file.
  void forgetAll();
  // A file is used that is `paths`, several for an atlas; without any it is not there. Cheap: files are read when the
  // digests are asked for. What has changed by then is like no other file, since nobody knows what of it was used.
  void use(std::string_view kind, const std::string& name, const std::vector<std::string>& paths);
  // Its content is known already.
  void use(std::string_view kind, const std::string& name, const Digest& content);
  // As it was used before. For callers that remember what a name stands for.
  void again(std::string_view kind, const std::string& name);
  void again(const Names& names);
  // All that are used, by kind and name, without their contents.
  std::vector<Entry> names();
  // What it holds. Reads the file where that is not known, while others may use more of them.
  std::optional<Digest> contentOf(const std::string& kind, const std::string& name);
  // names() with contents.
  std::vector<Entry> used();

 private:
  struct Known {
    std::vector<std::string> paths;
    std::vector<int64_t> stamps;  // times and sizes of the paths when they were first used
    std::optional<Digest> content;
    bool isGiven = false, isRead = false, isUsed = false;
  };

  // The entry of a file that is used.
  Known& used(std::string_view kind, const std::string& name);

  std::mutex mutex_;
  Names* listener_ = nullptr;
  std::map<std::pair<std::string, std::string>, Known> files_;  // by kind and name
};

}  // namespace kinora
