// Picture files to and from image::Image, through OpenImageIO: any format it reads; .exr, .png, .tif, .jpg written.
// Used by the commands (diff, info, merge), the tests and displays of formats without a driver plug-in. Colours are
// not managed: what a file holds is what is read.
#pragma once
#include <cstdint>
#include <string>

#include "image/image.h"
#include "image/status.h"

namespace kinora::image {

struct ReadOptions {
  // Of decoded floats. A file can claim any size in a few bytes; what it holds also bounds what is believed.
  uint64_t maxBytes = uint64_t(1) << 34;
  int maxChannels = 4096;
};

// All channels as float; 8- and 16-bit values become 0..1 as stored: colours beside a straight alpha stay so.
// IMAGE-OPEN, IMAGE-SIZE or IMAGE-READ on failure.
Status read(const std::string& path, Image& out, const ReadOptions& options = {});
// The header alone: everything but `pixels`, which stays empty.
Status readHeader(const std::string& path, Image& out, const ReadOptions& options = {});

enum class Compression : uint8_t { None, Rle, Zips, Zip, Piz, Pxr24, B44, B44a, Dwaa, Dwab };

struct WriteOptions {
  Compression compression = Compression::Zips;  // EXR
  float dwaLevel = 45;                          // EXR, Dwaa and Dwab
  bool isTiled = true;                          // EXR: 64 x 64
  bool encodeSrgb = true;                       // 8- and 16-bit formats: colours (not alpha) are scene-linear
  int jpegQuality = 95;
  // Colours are divided by alpha already, as some formats hold them. Else they are multiplied, and divided on the way
  // into such a file.
  bool isStraight = false;
};

// Of a file's name, in small letters and without its dot; "" when it has none.
std::string extensionOf(const std::string& path);
// Formats, by their extension in small letters, whose colours are not multiplied by alpha.
bool hasStraightAlpha(const std::string& extension);

// By the extension. Each channel is stored as its `type` in EXR; .png and .jpg hold 8 bits (or 16 where every channel
// asks for UInt16 or more and the format can), .tif what the first channel says. Atomic: the target is whole or as
// before.
Status write(const std::string& path, const Image& image, const WriteOptions& options = {});

// sRGB transfer of a scene-linear value to 8 bits, by a table of exact thresholds: the same on every CPU and library.
// NaN and negative values give 0.
uint8_t encodeSrgb8(float linear);
uint16_t encodeSrgb16(float linear);
float decodeSrgb(float encoded);  // 0..1
uint8_t quantize8(float v);       // linear: alpha and data; round half up, clamped

}  // namespace kinora::image
