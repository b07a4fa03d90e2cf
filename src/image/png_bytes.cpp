#include "image/png_bytes.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "image/read_write.h"

namespace kinora::image {

Status pngBytes(const Image& image, bool encodeSrgb, std::vector<unsigned char>& out) {
  const int channels = image.channelCount() >= 3 ? 3 : 1;
  if (image.data.empty() || image.channels.empty()) return Status::fail("IMAGE-WRITE", "an empty picture has no PNG");
  std::vector<uint8_t> codes;
  codes.reserve(size_t(image.data.pixels()) * size_t(channels));
  for (size_t i = 0; i < size_t(image.data.pixels()); ++i)
    for (int c = 0; c < channels; ++c) {
      const float v = image.pixels[i * image.channels.size() + size_t(c)];
      codes.push_back(encodeSrgb ? encodeSrgb8(v) : quantize8(v));
    }
  OIIO::ImageSpec spec(image.width(), image.height(), channels, OIIO::TypeUInt8);
  OIIO::Filesystem::IOVecOutput memory;
  const auto output = OIIO::ImageOutput::create("png");
  if (!output || !output->set_ioproxy(&memory) || !output->open("memory.png", spec) ||
      !output->write_image(OIIO::TypeUInt8, codes.data()) || !output->close())
    return Status::fail("IMAGE-WRITE", "a PNG cannot be made in memory");
  out = memory.buffer();
  return {};
}

}  // namespace kinora::image
