// What texture/ asks of the library of picture files (image/picture_library.h): the files behind a TextureSystem and
// the making of textures. Both sides are built together.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "texture/make_texture.h"
#include "texture/texture_system.h"

namespace kinora::texture {

// A TextureSystem's files, once the first is asked for; its functions under the same names.
class TextureStore {
 public:
  virtual ~TextureStore() = default;
  virtual void setSearchPath(std::vector<std::string> directories) = 0;
  virtual void setCacheLimit(uint64_t bytes) = 0;
  virtual void setLevelFolder(std::string folder) = 0;
  virtual void setReading(TextureReading reading) = 0;
  virtual int handle(const std::string& file, const TextureRequest& request) = 0;
  virtual void lookup(const int32_t* handles, bool varying, uint32_t n, const float* s, const float* t,
                      const float* radius, const TextureOptions& options, const TextureSystem::Part& part,
                      float* const rgba[4], const float* const* axes) = 0;
  virtual int channels(int handle) = 0;
  virtual std::string find(const std::string& file, float s, float t) = 0;
  virtual bool fact(const std::string& path, const std::string& name, int count, int* ints, float* floats,
                    std::string* text) = 0;
  virtual const HostImage* image(const std::string& file, int linearize, const TextureRequest& request) = 0;
  virtual TextureStatistics statistics() = 0;
};

struct TextureCalls {
  static constexpr const char* kSymbol = "kinoraTextureCalls";
  std::unique_ptr<TextureStore> (*open)(Diagnostics& diagnostics, FileContents* contents);
  MakeTextureResult (*make)(const std::string& input, const std::string& output, const MakeTextureOptions& options,
                            std::string& why);
};

}  // namespace kinora::texture
