// What image/ asks of the library of picture files (picture_library.h). Both sides are built together.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "image/image.h"
#include "image/picture_file.h"
#include "image/read_write.h"
#include "image/status.h"

namespace kinora::image {

struct PictureCalls {
  static constexpr const char* kSymbol = "kinoraPictureCalls";
  // read() and readHeader(), of a regular file.
  Status (*read)(const std::string& path, Image& out, const ReadOptions& options, bool headerAlone);
  // write() to a temporary; messages name the target, whose extension chooses the format. Colours are as it means
  // them.
  Status (*write)(const std::string& temporary, const std::string& target, const Image& image,
                  const WriteOptions& options);
  // False: there is no writer.
  bool (*png)(int width, int height, int channels, const unsigned char* codes, std::vector<unsigned char>& out);
  Status (*open)(const PictureFormat& format, std::unique_ptr<PictureFile>& out);
};

}  // namespace kinora::image
