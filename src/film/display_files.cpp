#include "film/display_files.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <string>

#include "image/picture_file.h"

namespace kinora::film {
namespace {

image::PictureFormat formatOf(const DisplayPictureFormat& f) {
  image::PictureFormat out;
  out.format = f.format;
  out.path = f.path;
  out.data = {f.window[0], f.window[1], f.window[2], f.window[3]};
  out.fullWidth = int(f.resolution[0]);
  out.fullHeight = int(f.resolution[1]);
  out.channels = int(f.channelCount);
  for (uint32_t c = 0; c < f.channelCount && f.channelNames; ++c) out.names.emplace_back(f.channelNames[c]);
  out.alphaChannel = f.alphaChannel;
  out.type = f.code == DisplayCode::UInt8    ? image::StoredType::UInt8
             : f.code == DisplayCode::UInt16 ? image::StoredType::UInt16
                                             : image::StoredType::Float;
  for (uint32_t i = 0; i < f.attributeCount; ++i) {
    const DisplayMetadata& m = f.attributes[i];
    image::MetaValue value = m.integer;
    if (m.type == DisplayMetadataType::Float) value = m.number;
    if (m.type == DisplayMetadataType::String) value = std::string(m.text);
    if (m.type == DisplayMetadataType::Matrix) {
      image::Matrix44 matrix;
      std::copy_n(m.matrix, matrix.size(), matrix.begin());
      value = matrix;
    }
    out.attributes.emplace_back(m.key, std::move(value));
  }
  return out;
}

// What `run` says, across the border to a plug-in.
template <class Run>
int answer(ErrorText* error, Run run) noexcept {
  std::string why;
  try {
    why = run().what;
  } catch (const std::exception& e) {
    why = e.what();
  }
  const size_t length = std::min(why.size(), sizeof error->text - 1);
  std::copy_n(why.begin(), length, error->text);
  error->text[length] = 0;
  return why.empty() ? 1 : 0;
}

void* open(const DisplayPictureFormat* format, ErrorText* error) {
  std::unique_ptr<image::PictureFile> file;
  const int isOpen = answer(error, [&] { return image::openPictureFile(formatOf(*format), file); });
  return isOpen ? file.release() : nullptr;
}
int write(void* file, uint32_t first, uint32_t count, const void* pixels, ErrorText* error) {
  return answer(error, [&] { return static_cast<image::PictureFile*>(file)->write(int(first), int(count), pixels); });
}
int close(void* file, ErrorText* error) {
  return answer(error, [&] { return static_cast<image::PictureFile*>(file)->close(); });
}
void destroy(void* file) { delete static_cast<image::PictureFile*>(file); }

}  // namespace

const DisplayPictureFiles& displayPictureFiles() {
  static constexpr DisplayPictureFiles kFiles{open, write, close, destroy};
  return kFiles;
}

}  // namespace kinora::film
