// Mutations of picture files that keep a part of their structure: TIFF directory entries, PNG chunks with their
// checksums made right, JPEG segments, EXR attributes, and bytes and cuts of any of them. All choices come from the
// seed.
#pragma once
#include <string>

#include "fuzz/choices.h"

namespace kinora::fuzz {

class ImageMutator : public Choices {
 public:
  using Choices::Choices;
  std::string mutate(std::string bytes, const std::string& other, size_t limit);

 private:
  void field(std::string& s, size_t at, int width, bool bigEndian);  // an interesting number
  void tiff(std::string& s);
  void png(std::string& s);
  void jpeg(std::string& s);
  void exr(std::string& s);
  void anywhere(std::string& s);
};

}  // namespace kinora::fuzz
