#include "image/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace kinora::image {
namespace {

std::string temporaryBeside(const std::string& target) {
  static std::atomic<unsigned> counter{0};
  const size_t slash = target.rfind('/');
  const std::string folder = slash == std::string::npos ? "" : target.substr(0, slash + 1);
  const std::string name = slash == std::string::npos ? target : target.substr(slash + 1);
  const size_t dot = name.rfind('.');
  const std::string stem = name.substr(0, dot);
  const std::string extension = dot == std::string::npos ? "" : name.substr(dot);
  // names have at most 255 bytes; the mark below takes up to 40
  return folder + "." + stem.substr(0, 160) + ".part" + std::to_string(getpid()) + "-" + std::to_string(counter++) +
         extension.substr(0, 40);
}

Status failed(const std::string& what, const std::string& target, int error) {
  return Status::fail("IMAGE-WRITE", "cannot " + what + " \"" + target + "\": " + std::strerror(error));
}

}  // namespace

AtomicFile::AtomicFile(std::string target) : target_(std::move(target)), temporary_(temporaryBeside(target_)) {
  struct stat info;
  isInPlace_ = stat(target_.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
  if (isInPlace_) temporary_ = target_;
}

AtomicFile::~AtomicFile() {
  if (!isCommitted_ && !isInPlace_) unlink(temporary_.c_str());
}

Status AtomicFile::probe() const {
  struct stat info;
  if (stat(target_.c_str(), &info) == 0 && S_ISDIR(info.st_mode)) return failed("write", target_, EISDIR);
  if (target_.empty() || target_.back() == '/') return failed("write", target_, EISDIR);
  const int fd = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (fd < 0) return failed("write", target_, errno);
  close(fd);
  if (!isInPlace_) unlink(temporary_.c_str());
  return {};
}

Status AtomicFile::commit() {
  isCommitted_ = isInPlace_;
  if (isInPlace_) return {};
  const int fd = open(temporary_.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return failed("write", target_, errno);
  // delayed "no space left" comes out here
  const int synced = fsync(fd);
  const int error = errno;
  close(fd);
  if (synced != 0 && error != EINVAL && error != ENOTSUP) return failed("write", target_, error);
  if (rename(temporary_.c_str(), target_.c_str()) != 0) return failed("write", target_, errno);
  isCommitted_ = true;
  return {};
}

std::string wholeName(const std::string& name) {
  std::error_code failed;
  const std::filesystem::path absolute = std::filesystem::absolute(name, failed);
  if (failed) return name;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(absolute, failed);
  return failed ? absolute.lexically_normal().string() : whole.string();
}

bool isSameFile(const std::string& a, const std::string& b) {
  std::error_code failed;
  return !a.empty() && !b.empty() && (wholeName(a) == wholeName(b) || std::filesystem::equivalent(a, b, failed));
}

}  // namespace kinora::image
