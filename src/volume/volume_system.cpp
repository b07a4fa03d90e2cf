#include "volume/volume_system.h"

#include <filesystem>

#include "base/file_search.h"
#include "image/volume_file.h"

namespace kinora {

namespace fs = std::filesystem;
using volume::VoxelGrid;

void VolumeSystem::setSearchPath(std::vector<std::string> directories) {
  const std::lock_guard lock(mutex_);
  searchPath_ = std::move(directories);
}

std::string VolumeSystem::place(const std::string& file, bool& isExact) const {
  const FilePlaces places = placesOf(file, searchPath_);
  std::error_code ec;
  for (size_t i = 0; i < places.list.size(); ++i) {
    isExact = i < places.exact;
    if (fs::is_regular_file(places.list[i], ec)) return places.list[i].string();
  }
  return "";
}

std::string VolumeSystem::find(const std::string& file) const {
  const std::lock_guard lock(mutex_);
  bool isExact;
  const std::string path = file.empty() ? "" : place(file, isExact);
  if (path.empty() || !image::holdsVolumes(path)) return "";
  note(file, path);
  return path;
}

void VolumeSystem::note(const std::string& file, const std::string& path) const {
  if (contents_) contents_->use("volume", file, path.empty() ? std::vector<std::string>() : std::vector{path});
}

const VoxelGrid* VolumeSystem::read(const std::string& file, const std::string& which, const std::string& asker) {
  const std::string named = "volume '" + file + "' of " + asker;
  bool isExact;
  const std::string path = place(file, isExact);
  note(file, path);
  if (path.empty()) {
    diagnostics_.warning("ASSET-VOLUME-MISSING", {}, named + " is not there", "lookups give the missing colour",
                         "check the texture search path");
    return nullptr;
  }
  if (!isExact)
    diagnostics_.warning("ASSET-VOLUME-MISSING", {}, named + " is not there", "'" + path + "' is used instead");
  std::string why = "it holds no volumes (OpenVDB)";
  std::unique_ptr<VoxelGrid> grid;
  const volume::VoxelStore::Mark before = store_->mark();
  try {
    if (image::holdsVolumes(path)) grid = volume::readGrid(program_, path, which, why, store_);
  } catch (const std::exception& e) {
    grid.reset();
    why = e.what();
  }
  if (!grid) {
    store_->release(before);
    diagnostics_.warning("ASSET-VOLUME-READ", {}, named + " cannot be used: '" + path + "': " + why,
                         "lookups give the missing colour");
    return nullptr;
  }
  if (!store_->failure().empty() && !std::exchange(toldOfStore_, true))
    diagnostics_.warning("VOLUME-CACHE", {},
                         "volumes beyond --volume-cache cannot lie in a file: " + store_->failure(),
                         "they are held in memory", "TMPDIR names a folder with room");
  // one grid may be asked for by name, by number and as the usual one
  const auto [it, isNew] = held_.try_emplace({path, grid->shape().subimage}, nullptr);
  if (isNew) {
    it->second = std::move(grid);
  } else {
    grid.reset();
    store_->release(before);
  }
  return it->second.get();
}

const VoxelGrid* VolumeSystem::grid(const std::string& file, const std::string& which, const std::string& asker) {
  if (file.empty()) return nullptr;
  const std::lock_guard lock(mutex_);
  const auto [it, isNew] = grids_.try_emplace(Key{file, which}, nullptr);
  if (contents_) contents_->again("volume", file);
  if (isNew) it->second = read(file, which, asker);
  return it->second;
}

}  // namespace kinora
