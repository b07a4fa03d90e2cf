// A display driver: portable float maps (the first three channels, 32 bits, scene-linear).
//   Display "picture.pfm" "Pfm" "rgba"
#include <kinora/display.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

namespace kinora {
namespace {

struct Pfm {
  std::string path;
  int width, height;
  uint32_t channels;
  std::FILE* file = nullptr;
  ~Pfm() {
    if (file) std::fclose(file);
  }
};

int say(ErrorText* error, const char* what) {
  std::snprintf(error->text, sizeof error->text, "%s", what);
  return 0;
}

// Kinora gives a temporary name and renames the file when close() says that all is written.
void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&]() -> void* {
    const auto* d = static_cast<const DisplayInfo*>(info->extra);
    auto k = std::make_unique<Pfm>();
    k->path = d->writePath;
    k->width = d->window[2] - d->window[0];
    k->height = d->window[3] - d->window[1];
    k->channels = d->channelCount;
    if (d->channelCount == 0) throw "a picture needs a channel";
    k->file = std::fopen(d->writePath, "wb");
    if (!k->file) throw "the file cannot be opened";
    return k.release();
  });
}

int write(void* display, const DisplayPixels* p, ErrorText* error) {
  auto* k = static_cast<Pfm*>(display);
  std::fprintf(k->file, "PF\n%d %d\n-1.0\n", k->width, k->height);
  for (int y = k->height - 1; y >= 0; --y)  // the format counts rows from the bottom
    for (int x = 0; x < k->width; ++x)
      for (uint32_t c = 0; c < 3; ++c) {
        const float* channel = p->channels[c < k->channels ? c : k->channels - 1];
        std::fwrite(channel + size_t(y) * p->rowStride + size_t(x) * p->pixelStride, sizeof(float), 1, k->file);
      }
  return std::ferror(k->file) ? say(error, std::strerror(errno)) : 1;
}

// A full disk shows here at the latest.
int close(void* display, ErrorText* error) {
  auto* k = static_cast<Pfm*>(display);
  std::FILE* file = k->file;
  k->file = nullptr;
  return std::fclose(file) == 0 ? 1 : say(error, std::strerror(errno));
}

void abort(void*) {}

const DisplayFunctions kFunctions{&write, &close, &abort};
const WidthTable kTables[] = {{1, &kFunctions}};
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::Display,
                             0,
                             "Pfm",
                             "Portable float maps.",
                             nullptr,
                             0,
                             kTables,
                             1,
                             nullptr,
                             create,
                             [](void* d) { delete static_cast<Pfm*>(d); }};

}  // namespace
KINORA_REGISTER(Pfm, kDescriptor)
}  // namespace kinora
