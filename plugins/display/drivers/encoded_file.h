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
