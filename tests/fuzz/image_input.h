// One fuzzing input for pictures and textures: the bytes of a file. Used by the fuzzer and its short test.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::fuzz {

struct ImageOutcome {
  bool read = false;       // image::read took it
  double sum = 0;          // of all values read
  bool isTexture = false;  // lookups gave colours of the file
  std::string words;       // of the messages, to tell outcomes apart
};
// Writes the bytes under a name that fits their first bytes, and asks every entry point for them: header, whole
// picture, texture lookups at several footprints, light map.
ImageOutcome loadImageInput(std::string_view bytes);

// Small files of each format, made here: name and bytes.
std::vector<std::pair<std::string, std::string>> smallImages();

}  // namespace kinora::fuzz
