// The library of picture files, libkinora_pictures.so: all that calls OpenImageIO is compiled into it (src/*/module).
// OpenImageIO brings 260 shared libraries, .4 s of CPU time and 130 MB, and most runs open no picture but the OpenEXR
// files that film/ writes, so the library is loaded when the first one is opened. Called by image/, texture/ and
// volume/, each of which declares its own table of functions. Thread-safe; it prints nothing.
#pragma once
#include <string>

namespace kinora::image {

// A constant of the library by its exported name; null with `why`, one line, where the library is missing, cannot be
// loaded or belongs to another version.
const void* findInPictureLibrary(const char* symbol, std::string& why);
// Why it was asked for in vain, "" otherwise. Then the installation is at fault and not the scene, which the exit
// code has to tell.
std::string pictureLibraryProblem();

// Whether it lies where it belongs, without loading it: asked before an hour of rendering.
bool isPictureLibraryThere();

// A room's table, such as PictureCalls; null with `why`.
template <class Calls>
const Calls* pictureLibrary(std::string& why) {
  return static_cast<const Calls*>(findInPictureLibrary(Calls::kSymbol, why));
}

// The version that the library was built for.
using VersionText = char[sizeof KINORA_VERSION];
inline constexpr const char* kPictureLibraryVersion = "kinoraPictureLibraryVersion";

}  // namespace kinora::image

// Begins the definition of a constant that the library exports: KINORA_PICTURE_LIBRARY_EXPORT(Type, name){...};
#define KINORA_PICTURE_LIBRARY_EXPORT(Type, name)                    \
  extern "C" __attribute__((visibility("default"))) const Type name; \
  const Type name
