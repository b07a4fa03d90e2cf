// A picture encoded in memory and written whole at the end: OpenImageIO's writers do not notice a full disk. For
// formats whose files are small (PNG, JPEG).
#pragma once
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "calls.h"

namespace kinora {

// What a file of integers says of its codes, by the metadata "colorSpace": the sRGB curve, a gamma, or nothing where
// neither is the whole truth.
inline void stateColorSpace(OIIO::ImageSpec& spec, const DisplayInfo& d) {
  for (uint32_t i = 0; i < d.metadataCount; ++i) {
    const DisplayMetadata& m = d.metadata[i];
    if (m.type != DisplayMetadataType::String || std::strcmp(m.key, "colorSpace") != 0) continue;
    float gamma = 0;
    int end = 0;
    if (std::strcmp(m.text, "sRGB") == 0) {
      spec.attribute("oiio:ColorSpace", "sRGB");
    } else if (std::sscanf(m.text, "gamma %f%n", &gamma, &end) == 1 && m.text[end] == '\0' && gamma > 0) {
      spec.attribute("oiio:ColorSpace", gamma == 1 ? std::string("Linear") : "Gamma" + std::string(m.text + 6));
      spec.attribute("oiio:Gamma", gamma);
    }
  }
}

struct EncodedFile {
  std::string path;
  std::vector<unsigned char> bytes;

  // `name`: of the format, as messages write it. Throws.
  void encode(const std::string& format, const char* name, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
              const void* pixels) {
    OIIO::Filesystem::IOVecOutput memory;
    std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create(format);
    if (!out) throw std::runtime_error(std::string("this OpenImageIO cannot write ") + name);
    const bool ok = out->set_ioproxy(&memory) && out->open(path, spec) && out->write_image(type, pixels);
    const std::string why = out->geterror();
    if (!out->close() || !ok) throw std::runtime_error(why.empty() ? "the picture could not be encoded" : why);
    bytes = memory.buffer();
  }

  // 1, or 0 and a message.
  int write(ErrorText* error) const {
    std::FILE* file = std::fopen(path.c_str(), "wb");
    int code = file ? 0 : errno;
    if (file && std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size()) code = errno ? errno : EIO;
    if (file && std::fclose(file) != 0 && !code) code = errno;
    return code ? say(error, std::strerror(code)) : 1;
  }
};

}  // namespace kinora
