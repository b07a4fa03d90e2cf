// Texture calls of shaders: texture, environment, texture3d, gettextureinfo with all their options, for the points of
// a batch. Called by ShaderServices while a frame is rendered, by `kinora shader run` and by the bench: what a call gives
// is decided here once. One for each thread.
#pragma once
#include <cstdint>
#include <unordered_map>

#include "language/vm/services.h"

namespace kinora {
class Arena;
class TextureSystem;
}  // namespace kinora

namespace kinora::shade {

class ShaderTextures {
 public:
  // system is asked for with the first call and may be null before; both outlive this. What a call takes of the arena
  // it gives back.
  ShaderTextures(TextureSystem* system, Arena& arena) : system_(system), arena_(arena) {}
  void texture(const language::Batch& batch, const language::TextureCall& call);
  // Latitude and longitude, y up: the picture's middle lies along +z, its left edge is -z seen over +x (OpenImageIO's
  // convention for "latlong" files).
  void environment(const language::Batch& batch, const language::TextureCall& call);
  // There are no files of volumes yet: the missing colour, else black.
  void volume(const language::Batch& batch, const language::TextureCall& call);
  void info(const language::Batch& batch, language::Span file, language::Span coordinates, language::Span name,
            language::Span to, language::Span found);

 private:
  struct Places;
  int32_t handleOf(int32_t name);
  void lookUp(const language::Batch& batch, const language::TextureCall& call, const Places& at);

  TextureSystem* system_;
  Arena& arena_;
  std::unordered_map<int32_t, int32_t> handles_;  // by the handle of the file's name
};

}  // namespace kinora::shade
