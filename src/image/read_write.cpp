#include "image/read_write.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "base/text.h"
#include "image/atomic_file.h"
#include "image/picture_calls.h"
#include "image/picture_file.h"
#include "image/picture_library.h"
#include "image/png_bytes.h"
#include "image/straight_alpha.h"
#include "image/volume_file.h"

namespace kinora::image {
namespace {

std::string quoted(const std::string& path) { return "\"" + path + "\""; }

// What can be said without the library is said without loading it.
Status readFile(const std::string& path, Image& out, const ReadOptions& options, bool headerAlone) {
  out = {};
  struct stat info;
  if (stat(path.c_str(), &info) != 0)
    return Status::fail("IMAGE-OPEN", "cannot open " + quoted(path) + ": " + std::strerror(errno));
  if (!S_ISREG(info.st_mode)) return Status::fail("IMAGE-OPEN", quoted(path) + " is not a file");
  if (info.st_size == 0) return Status::fail("IMAGE-OPEN", quoted(path) + " is empty");
  if (holdsVolumes(path)) return Status::fail("IMAGE-OPEN", quoted(path) + " holds volumes (OpenVDB), no picture");
  std::string why;
  const auto* const library = pictureLibrary<PictureCalls>(why);
  if (!library) return Status::fail("IMAGE-LIBRARY", "cannot read " + quoted(path) + ": " + why);
  return library->read(path, out, options, headerAlone);
}

}  // namespace

Status read(const std::string& path, Image& out, const ReadOptions& options) {
  return readFile(path, out, options, false);
}
Status readHeader(const std::string& path, Image& out, const ReadOptions& options) {
  return readFile(path, out, options, true);
}

std::string extensionOf(const std::string& path) {
  const size_t dot = path.rfind('.');
  if (dot == std::string::npos || path.find('/', dot) != std::string::npos) return {};
  return lowerCase(path.substr(dot + 1));
}

bool hasStraightAlpha(const std::string& extension) { return extension == "png" || extension == "tga"; }

Status write(const std::string& path, const Image& given, const WriteOptions& options) {
  Image straight;
  if (!options.isStraight && hasStraightAlpha(extensionOf(path)) && given.findChannel("A") >= 0) {
    straight = given;
    std::vector<size_t> colors;
    for (size_t c = 0; c < straight.channels.size(); ++c)
      if (!isAlphaName(straight.channels[c].name)) colors.push_back(c);
    if (straight.pixels.size() == size_t(straight.data.pixels()) * straight.channels.size())
      makeStraight(straight, colors, size_t(straight.findChannel("A")));
  }
  const Image& image = straight.channels.empty() ? given : straight;
  if (image.data.empty() || image.channels.empty() ||
      image.pixels.size() != size_t(image.data.pixels()) * image.channels.size())
    return Status::fail("IMAGE-WRITE", "cannot write " + quoted(path) + ": the picture is empty or inconsistent");
  AtomicFile file(path);
  if (Status s = file.probe(); !s.ok()) return s;
  std::string why;
  const auto* const library = pictureLibrary<PictureCalls>(why);
  if (!library) return Status::fail("IMAGE-LIBRARY", "cannot write " + quoted(path) + ": " + why);
  if (Status s = library->write(file.path(), path, image, options); !s.ok()) return s;
  return file.commit();
}

Status pngBytes(const Image& image, bool encodeSrgb, std::vector<unsigned char>& out) {
  const int channels = image.channelCount() >= 3 ? 3 : 1;
  if (image.data.empty() || image.channels.empty()) return Status::fail("IMAGE-WRITE", "an empty picture has no PNG");
  std::vector<unsigned char> codes;
  codes.reserve(size_t(image.data.pixels()) * size_t(channels));
  for (size_t i = 0; i < size_t(image.data.pixels()); ++i)
    for (int c = 0; c < channels; ++c) {
      const float v = image.pixels[i * image.channels.size() + size_t(c)];
      codes.push_back(encodeSrgb ? encodeSrgb8(v) : quantize8(v));
    }
  std::string why;
  const auto* const library = pictureLibrary<PictureCalls>(why);
  if (!library) return Status::fail("IMAGE-LIBRARY", "a PNG cannot be made: " + why);
  return library->png(image.width(), image.height(), channels, codes.data(), out)
             ? Status()
             : Status::fail("IMAGE-WRITE", "a PNG cannot be made in memory");
}

Status openPictureFile(const PictureFormat& format, std::unique_ptr<PictureFile>& out) {
  std::string why;
  const auto* const library = pictureLibrary<PictureCalls>(why);
  return library ? library->open(format, out) : Status::fail("IMAGE-LIBRARY", why);
}

}  // namespace kinora::image
