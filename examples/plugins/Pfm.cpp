// A display driver: portable float maps (the first three channels, 32 bits, scene-linear).
//   Display "picture.pfm" "Pfm" "rgba"
#include <kinora/display_author.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace kinora {
namespace {

struct Pfm {
  int width, height;
  uint32_t channels;
  std::FILE* file;

  // Kinora gives a temporary name and renames the file when close() has not thrown.
  Pfm(const CreateInfo&, const DisplayInfo& d)
      : width(d.window[2] - d.window[0]), height(d.window[3] - d.window[1]), channels(d.channelCount) {
    if (channels == 0) throw "a picture needs a channel";
    file = std::fopen(d.writePath, "wb");
    if (!file) throw "the file cannot be opened";
  }
  ~Pfm() {
    if (file) std::fclose(file);
  }

  void write(const DisplayPixels& p) {
    std::fprintf(file, "PF\n%d %d\n-1.0\n", width, height);
    for (int y = height - 1; y >= 0; --y)  // the format counts rows from the bottom
      for (int x = 0; x < width; ++x)
        for (uint32_t c = 0; c < 3; ++c) {
          const float* channel = p.channels[c < channels ? c : channels - 1];
          std::fwrite(channel + size_t(y) * p.rowStride + size_t(x) * p.pixelStride, sizeof(float), 1, file);
        }
    if (std::ferror(file)) throw static_cast<const char*>(std::strerror(errno));
  }

  // A full disk shows here at the latest.
  void close() {
    std::FILE* const done = file;
    file = nullptr;
    if (std::fclose(done) != 0) throw static_cast<const char*>(std::strerror(errno));
  }
};

}  // namespace
}  // namespace kinora

KINORA_DISPLAY(Pfm, Pfm, .help = "Portable float maps.")
