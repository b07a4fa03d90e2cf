// A file that appears whole or not at all: written under a temporary name beside its target and renamed at the end.
// What exists and is no regular file (a device, a pipe) is written where it is: a renamed file would take its place.
// Used by whatever writes pictures and shards (image/, film/). It does not make folders, and it does not write: the
// caller hands path() to a library or writes there itself.
#pragma once
#include <string>

#include "image/status.h"

namespace kinora::image {

class AtomicFile {
 public:
  // The temporary keeps the target's extension, by which libraries choose a format. Nothing is created yet.
  explicit AtomicFile(std::string target);
  ~AtomicFile();  // removes the temporary unless it was committed
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  const std::string& path() const { return temporary_; }
  const std::string& target() const { return target_; }
  // Tells early, before an hour of rendering, whether the target could be written: creates and removes the temporary.
  Status probe() const;
  // Flushes to the disk and renames. On failure the target is what it was before.
  Status commit();

 private:
  std::string target_, temporary_;
  bool isCommitted_ = false, isInPlace_ = false;
};

// The name from the root on, links followed; the same for all names of a file, which need not exist yet.
std::string wholeName(const std::string& name);
// Whether both names lead to one file, which need not exist yet: what writes one would take the place of the other.
bool isSameFile(const std::string& a, const std::string& b);

}  // namespace kinora::image
