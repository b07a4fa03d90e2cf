// Mutations of picture files that keep a part of their structure: TIFF directory entries, PNG chunks with their
// checksums made right, JPEG segments, EXR attributes, and bytes and cuts of any of them. All choices come from the
// seed.
#pragma once
#include <cstdint>
#include <string>

namespace kinora::fuzz {

class ImageMutator {
 public:
  explicit ImageMutator(uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
  std::string mutate(std::string bytes, const std::string& other, size_t limit);
  uint32_t below(size_t n);  // 0 for n = 0

 private:
  void field(std::string& s, size_t at, int width, bool bigEndian);  // an interesting number
  void tiff(std::string& s);
  void png(std::string& s);
  void jpeg(std::string& s);
  void exr(std::string& s);
  void anywhere(std::string& s);

  uint64_t state_;
};

}  // namespace kinora::fuzz
