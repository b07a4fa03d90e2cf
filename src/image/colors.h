// Colour spaces: what the renderer's numbers mean, what a texture's mean, and how a picture is looked at. Without
// $OCIO all is built in: the working space is linear light with the primaries of sRGB/Rec.709, 8-bit textures are
// sRGB, and pictures are sRGB-encoded. With $OCIO the configuration (OpenColorIO) says so: the working space is its
// role scene_linear, its file rules name the space of a texture, and displays may be given one of its views. Used by
// texture/ and film/; render/ reports what is wrong with the configuration. Thread-safe.
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace kinora::image {

class Colors {
 public:
  // Of the process: $OCIO, read once.
  static const Colors& ofEnvironment();
  // "": built in. A file that cannot be used leaves the built-in colours and a problem().
  explicit Colors(const std::string& configuration);
  ~Colors();
  Colors(const Colors&) = delete;

  bool isManaged() const;              // a configuration is in use
  const std::string& problem() const;  // why the configuration is not in use; "" when nothing is wrong
  const std::string& workingSpace() const;

  // The space of a texture by the configuration's file rules; where only the default rule matches, by the file's
  // type: bytes are the configuration's sRGB texture space, all else is scene-linear. "" when it says nothing.
  std::string spaceOf(const std::string& file, bool isBytes) const;
  // Converts n pixels in place from the space of the file to the working space; alpha (-1: none) stays. False when
  // the built-in rules are to be used.
  bool toWorking(const std::string& file, bool isBytes, float* pixels, size_t n, int channels,
                 int alphaChannel) const;

  // A view of the configuration, "default" or "VIEW" or "DISPLAY/VIEW"; "" when there is none, else its full name.
  std::string findView(const std::string& view) const;
  std::vector<std::string> views() const;  // "DISPLAY/VIEW"
  // From the working space to codes 0..1 as the view shows them; each pixel's three floats are `stride` apart. False
  // when the view cannot be made.
  bool toView(const std::string& fullName, float* rgb, size_t n, size_t stride) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinora::image
