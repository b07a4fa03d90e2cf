// Images into tiled, mip-mapped texture files. Called by the command maketex; OpenImageIO writes the files.
// Levels are area averages of the values that are stored (of light where sRGB is decoded, as it is before), colours
// beside alpha as the source holds them. It refuses what texture_files.h refuses, and the file appears whole or not
// at all.
#pragma once
#include <string>

namespace kinora::texture {

struct MakeTextureOptions {
  std::string wrapS = "periodic", wrapT = "periodic";  // black, clamp, periodic, mirror
  std::string resize = "none";  // none, or up, down, round: to powers of two (a dash behind them means the same)
  std::string filter =
      "box";  // of mip levels: box (area average, keeps the mean), triangle, gaussian, lanczos3, mitchell, ...
  std::string format;       // tiff, openexr; "": by the output's ending
  std::string type;         // byte, short, half, float; "": as the source has it
  std::string compression;  // "": the format's usual one
  bool latlong = false;     // an environment map: wraps around, clamps at the poles
  bool linearize = false;   // decodes sRGB
  bool mipMapped = true;
  int tileSize = 64;
  int threads = 0;  // 0: all
};

enum class MakeTextureResult { Made, BadInput, CannotWrite };
// `why` says what went wrong.
MakeTextureResult makeTexture(const std::string& input, const std::string& output, const MakeTextureOptions& options,
                              std::string& why);

}  // namespace kinora::texture
