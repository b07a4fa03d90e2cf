// Reading all pixels of an open picture, for both readers of picture files: image/ itself and the textures.
#pragma once
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstddef>

namespace kinora::image {

// TIFF files say how many rows a strip has. OpenImageIO 2.4 allocates that many rows, and near 2^31, where its sum
// overflows, never ends. More than the picture has serves nobody, but for all ones ("one strip"), which it does not
// tell.
// Tiles are allocated whole too, and divided by: a TIFF's sizes of 2^31 and more come as negative ones, and a tile of no
// rows ends the program.
inline bool blocksAreBelievable(const OIIO::ImageSpec& spec) {
  const int rows = spec.get_int_attribute("tiff:RowsPerStrip", 1);
  if (rows <= 0 || rows > 2 * spec.height + 1024) return false;
  if (spec.tile_width == 0 && spec.tile_height == 0) return true;
  return spec.tile_width > 0 && spec.tile_width <= 2 * spec.width + 1024 && spec.tile_height > 0 &&
         spec.tile_height <= 2 * spec.height + 1024 && spec.tile_depth == 1;
}

// Channels 0 .. channels-1 of the first subimage as floats, interleaved, into spec.width x spec.height x channels.
// False: input.geterror() says why. In bands, ended by the first that fails: the library's own call goes on to the
// end of the file, gathers a message for each row, and aborts the program when they fill 16 MB.
inline bool readPixels(OIIO::ImageInput& input, int channels, float* out) {
  const OIIO::ImageSpec& spec = input.spec();
  const int band = std::max(spec.tile_height, 64);
  for (int y = 0; y < spec.height; y += std::max(band, 1)) {
    float* const to = out + size_t(y) * size_t(spec.width) * size_t(channels);
    const int begin = spec.y + y, end = spec.y + std::min(y + band, spec.height);
    const bool good = spec.tile_width > 0
                          ? input.read_tiles(0, 0, spec.x, spec.x + spec.width, begin, end, spec.z, spec.z + 1, 0,
                                             channels, OIIO::TypeFloat, to)
                          : input.read_scanlines(0, 0, begin, end, spec.z, 0, channels, OIIO::TypeFloat, to);
    if (!good) return false;
  }
  return true;
}

}  // namespace kinora::image
