#include "image/picture_library.h"

#include <dlfcn.h>
#include <unistd.h>

#include <atomic>
#include <cstring>

namespace kinora::image {

namespace {

constexpr const char* kFile = "libkinora_pictures.so";

// Beside the shared library or the program that holds this code.
std::string placeOfLibrary() {
  Dl_info own{};
  const bool isKnown = dladdr(reinterpret_cast<const void*>(&pictureLibraryProblem), &own) && own.dli_fname;
  const std::string place = isKnown ? own.dli_fname : "";
  const size_t slash = place.rfind('/');
  return (slash == std::string::npos ? "./" : place.substr(0, slash + 1)) + kFile;
}

struct PictureLibrary {
  void* handle = RTLD_DEFAULT;
  std::string problem;

  PictureLibrary() {
    // a program may link the library's files itself, as the fuzzers do
    if (dlsym(RTLD_DEFAULT, kPictureLibraryVersion)) return;
    const std::string path = placeOfLibrary();
    handle = dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
    if (!handle) {
      problem = dlerror();  // names the file
    } else {
      const auto* const version = static_cast<const char*>(dlsym(handle, kPictureLibraryVersion));
      if (!version || std::strcmp(version, KINORA_VERSION) != 0)
        problem = path + " belongs to another version of Kinora than " KINORA_VERSION;
    }
    if (!problem.empty()) problem = "the library that reads and writes pictures cannot be loaded: " + problem;
  }
};

std::atomic<const PictureLibrary*> loaded{nullptr};

}  // namespace

const void* findInPictureLibrary(const char* symbol, std::string& why) {
  static const PictureLibrary library;
  loaded = &library;
  why = library.problem;
  return why.empty() ? dlsym(library.handle, symbol) : nullptr;
}

bool isPictureLibraryThere() {
  return dlsym(RTLD_DEFAULT, kPictureLibraryVersion) || access(placeOfLibrary().c_str(), R_OK) == 0;
}

std::string pictureLibraryProblem() {
  const PictureLibrary* const library = loaded;
  return library ? library->problem : "";
}

}  // namespace kinora::image
