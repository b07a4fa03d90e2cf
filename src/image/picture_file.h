// A picture file that is written row by row with its values as they are: what display drivers of plain pictures stand
// on. Used by film/ (display_files.h); whole pictures are read_write.h's. Through the library of picture files.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "image/image.h"
#include "image/status.h"

namespace kinora::image {

struct PictureFormat {
  std::string format;  // "png", "jpeg", "tiff"
  std::string path;
  Window data;
  int fullWidth = 0, fullHeight = 0;  // of the whole picture, from (0, 0)
  int channels = 0;
  std::vector<std::string> names;  // of the channels; none: as the format calls them
  int alphaChannel = -1;
  StoredType type = StoredType::UInt8;                        // of all values; not Half
  std::vector<std::pair<std::string, MetaValue>> attributes;  // as OpenImageIO names them
};

// Goes without a trace of the file's content where close() has not been called.
class PictureFile {
 public:
  virtual ~PictureFile() = default;
  // `count` rows from `first` on (0: the window's top), in order; pixels without gaps, in the type of the format.
  virtual Status write(int first, int count, const void* pixels) = 0;
  // Ok: the file is whole.
  virtual Status close() = 0;
};

Status openPictureFile(const PictureFormat& format, std::unique_ptr<PictureFile>& out);

}  // namespace kinora::image
