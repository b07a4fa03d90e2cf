// A file that OpenEXR writes to. The library's own stream forgets the errors of its last flush; this one keeps the first
// of all. For display drivers and whoever else writes EXR; needs OpenEXR's headers.
#pragma once
#include <ImfIO.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>

namespace kinora {

class ExrStream : public Imf::OStream {
 public:
  explicit ExrStream(const std::string& path) : Imf::OStream(path.c_str()), file_(std::fopen(path.c_str(), "wb")) {
    if (!file_) error_ = errno;
  }
  ~ExrStream() override { finish(); }
  void write(const char c[], int n) override {
    if (!error_ && std::fwrite(c, 1, size_t(n), file_) != size_t(n)) error_ = errno ? errno : EIO;
    if (error_) throw std::runtime_error(std::strerror(error_));
  }
  uint64_t tellp() override { return file_ ? uint64_t(std::ftell(file_)) : 0; }
  void seekp(uint64_t pos) override {
    if (!error_ && std::fseek(file_, long(pos), SEEK_SET) != 0) error_ = errno;
  }
  int error() const { return error_; }
  // Closes the file; the first error there was, as errno says it, or 0.
  int finish() {
    if (file_ && std::fclose(file_) != 0 && !error_) error_ = errno;
    file_ = nullptr;
    return error_;
  }

 private:
  std::FILE* file_;
  int error_ = 0;
};

}  // namespace kinora
