// Grids of volume files by name, for lookups of shaders: read once, kept for life. Called by shade/; knows no scene.
// Problems go to Diagnostics, once for each file and grid, and nothing throws.
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "base/file_contents.h"
#include "volume/read_process.h"
#include "volume/voxel_grid.h"

namespace kinora {

// Thread-safe. Who asks for a grid that is being read waits; grids stay valid for the life of the system.
class VolumeSystem {
 public:
  // contents: what the files hold is noted there; it outlives the system.
  // cacheBytes: see VoxelStore, whose bound it is.
  VolumeSystem(Diagnostics& diagnostics, volume::ReaderProgram program, FileContents* contents = nullptr,
               uint64_t cacheBytes = 0)
      : diagnostics_(diagnostics),
        program_(std::move(program)),
        contents_(contents),
        store_(std::make_shared<volume::VoxelStore>(cacheBytes)) {}
  VolumeSystem(const VolumeSystem&) = delete;
  VolumeSystem& operator=(const VolumeSystem&) = delete;

  // Directories for relative names, in order; the working directory comes last.
  void setSearchPath(std::vector<std::string> directories);
  // The file that a name stands for; "" when it is not there, or holds no volumes.
  std::string find(const std::string& file) const;
  // A grid, named as volume/grid_stream.h says; null after a message. `asker`: "a shader".
  const volume::VoxelGrid* grid(const std::string& file, const std::string& which, const std::string& asker);
  const volume::VoxelStore& store() const { return *store_; }

 private:
  std::string place(const std::string& file, bool& isExact) const;
  void note(const std::string& file, const std::string& path) const;
  const volume::VoxelGrid* read(const std::string& file, const std::string& which, const std::string& asker);

  Diagnostics& diagnostics_;
  const volume::ReaderProgram program_;
  FileContents* const contents_;
  const std::shared_ptr<volume::VoxelStore> store_;
  bool toldOfStore_ = false;
  mutable std::mutex mutex_;
  std::vector<std::string> searchPath_;
  using Key = std::pair<std::string, std::string>;
  std::map<Key, const volume::VoxelGrid*> grids_;  // by file and grid as they were asked for
  std::map<std::pair<std::string, int32_t>, std::unique_ptr<volume::VoxelGrid>> held_;  // by path and number
};

}  // namespace kinora
