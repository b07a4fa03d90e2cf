// A plain picture's file by the renderer's own writers, for the drivers of PNG, JPEG and TIFF. All functions throw.
#pragma once
#include <kinora/display_author.h>

#include <cstdio>
#include <cstring>
#include <deque>
#include <stdexcept>
#include <string>
#include <vector>

namespace kinora {

class PictureFile {
 public:
  DisplayPictureFormat format{};

  // The whole window at its place in the picture; the caller changes what its format means otherwise.
  PictureFile(const char* name, const DisplayInfo& d, uint32_t channelCount, DisplayCode code)
      : writers_(d.pictureFiles), path_(d.writePath) {
    format.format = name;
    std::memcpy(format.window, d.window, sizeof format.window);
    std::memcpy(format.resolution, d.resolution, sizeof format.resolution);
    format.channelCount = channelCount;
    format.alphaChannel = -1;
    format.code = code;
  }
  ~PictureFile() {
    if (file_) writers_->destroy(file_);
  }
  PictureFile(const PictureFile&) = delete;
  PictureFile& operator=(const PictureFile&) = delete;

  uint32_t width() const { return uint32_t(format.window[2] - format.window[0]); }
  uint32_t height() const { return uint32_t(format.window[3] - format.window[1]); }

  void attribute(const char* key, int value) { add(key, DisplayMetadataType::Int).integer = value; }
  void attribute(const char* key, float value) { add(key, DisplayMetadataType::Float).number = value; }
  void attribute(const char* key, const std::string& value) {
    add(key, DisplayMetadataType::String).text = kept(value.c_str());
  }
  void attribute(const char* key, const char* value) { attribute(key, std::string(value)); }
  void matrix(const char* key, const float* value) {
    matrices_.emplace_back(value, value + 16);
    add(key, DisplayMetadataType::Matrix).matrix = matrices_.back().data();
  }
  void channel(const char* name) { names_.push_back(kept(name)); }

  void open() {
    ErrorText error{};
    format.path = path_.c_str();
    format.channelNames = names_.empty() ? nullptr : names_.data();
    format.attributes = attributes_.data();
    format.attributeCount = uint32_t(attributes_.size());
    file_ = writers_->open(&format, &error);
    if (!file_) throw std::runtime_error(error.text);
  }
  void rows(uint32_t first, uint32_t count, const void* pixels) {
    ErrorText error{};
    if (!writers_->write(file_, first, count, pixels, &error)) throw std::runtime_error(error.text);
  }
  void whole(const void* pixels) {
    open();
    rows(0, height(), pixels);
  }
  void close() {
    ErrorText error{};
    if (!writers_->close(file_, &error)) throw std::runtime_error(error.text);
  }

 private:
  DisplayMetadata& add(const char* key, DisplayMetadataType type) {
    attributes_.push_back({kept(key), type, 0, 0, "", nullptr});
    return attributes_.back();
  }
  const char* kept(const char* text) { return texts_.emplace_back(text).c_str(); }

  const DisplayPictureFiles* writers_;
  std::string path_;
  void* file_ = nullptr;
  std::deque<std::string> texts_;  // elements stay where they are
  std::deque<std::vector<float>> matrices_;
  std::vector<const char*> names_;
  std::vector<DisplayMetadata> attributes_;
};

// What a file of integers says of its codes, by the metadata "colorSpace": the sRGB curve, a gamma, or nothing where
// neither is the whole truth.
inline void stateColorSpace(PictureFile& file, const DisplayInfo& d) {
  for (uint32_t i = 0; i < d.metadataCount; ++i) {
    const DisplayMetadata& m = d.metadata[i];
    if (m.type != DisplayMetadataType::String || std::strcmp(m.key, "colorSpace") != 0) continue;
    float gamma = 0;
    int end = 0;
    if (std::strcmp(m.text, "sRGB") == 0) {
      file.attribute("oiio:ColorSpace", "sRGB");
    } else if (std::sscanf(m.text, "gamma %f%n", &gamma, &end) == 1 && m.text[end] == '\0' && gamma > 0) {
      file.attribute("oiio:ColorSpace", gamma == 1 ? std::string("Linear") : "Gamma" + std::string(m.text + 6));
      file.attribute("oiio:Gamma", gamma);
    }
  }
}

}  // namespace kinora
