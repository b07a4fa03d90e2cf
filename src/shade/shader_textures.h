// Texture calls of shaders: texture, environment, texture3d, gettextureinfo with all their options, for the points of
// a batch. Called by ShaderServices while a frame is rendered, by `kinora shader run` and by the bench: what a call
// gives is decided here once. One for each thread.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>

#include "language/vm/services.h"

namespace kinora {
class Arena;
class TextureSystem;
class VolumeSystem;
namespace volume {
class VoxelGrid;
}
}  // namespace kinora

namespace kinora::shade {

struct TextureCallOptions;

class ShaderTextures {
 public:
  // system is asked for with the first call and may be null before; without volumes none are there. All outlive this.
  // What a call takes of the arena it gives back.
  ShaderTextures(TextureSystem* system, VolumeSystem* volumes, Arena& arena)
      : system_(system), volumes_(volumes), arena_(arena) {}
  void texture(const language::Batch& batch, const language::TextureCall& call);
  // Latitude and longitude, y up: the picture's middle lies along +z, its left edge is -z seen over +x (OpenImageIO's
  // convention for "latlong" files).
  void environment(const language::Batch& batch, const language::TextureCall& call);
  // Grids of OpenVDB files at points of world space (shader_volumes.cpp). Files have one level: a footprint wider
  // than a voxel is averaged over eight places.
  void volume(const language::Batch& batch, const language::TextureCall& call);
  void info(const language::Batch& batch, language::Span file, language::Span coordinates, language::Span name,
            language::Span to, language::Span found);

 private:
  struct Places;
  int32_t handleOf(int32_t name);
  void lookUp(const language::Batch& batch, const language::TextureCall& call, const Places& at);

  const volume::VoxelGrid* gridOf(int32_t name, const TextureCallOptions& options);
  // A fact of a volume file: "exists", "channels" or "resolution" of its usual grid; how many numbers, 0: not known.
  uint32_t volumeFact(int32_t file, const std::string& what, int32_t out[3]);
  // What a name stands for where no place of an atlas is given.
  struct File {
    std::string path;  // of a picture; "": there is none
    bool isVolume = false;
  };
  const File& fileOf(int32_t name);

  TextureSystem* system_;
  VolumeSystem* volumes_;
  Arena& arena_;
  std::unordered_map<int32_t, File> files_;                           // by the handle of the name
  std::unordered_map<int32_t, int32_t> handles_;                      // by the handle of the file's name
  std::map<std::array<int32_t, 3>, const volume::VoxelGrid*> grids_;  // by that name, kind of part and part
};

}  // namespace kinora::shade
