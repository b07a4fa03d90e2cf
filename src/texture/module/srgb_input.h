// A file that stores sRGB, presented to the tile cache as linear light: values are decoded before they are filtered,
// which decoding a filtered value cannot make up for. Used by TextureSystem through ImageCache::add_file.
#pragma once
#include <OpenImageIO/imageio.h>

#include <string>

namespace kinora::texture {

// Names of decoded files in the cache: this prefix and the file's path.
inline constexpr const char* kSrgbPrefix = "kinora-srgb:";
OIIO::ImageInput* createSrgbInput();

// IEC 61966-2-1; negative values are mirrored.
float decodeSrgb(float encoded);
// Decodes the colour channels of n pixels in place; the alpha channel (-1: none) stays. bytes: the values came from 8
// bits.
void decodeSrgb(float* pixels, size_t n, int channels, int alphaChannel, bool bytes);

}  // namespace kinora::texture
