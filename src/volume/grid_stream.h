// One grid on its way from the process that reads the file to the one that renders: records of a kind, a count and
// what they say, in the byte order of the machine both run on. The sender is given a file that nobody vouches for and
// a library that such files can break; the receiver believes nothing that comes. See read_process.h.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "volume/voxel_grid.h"

namespace kinora::volume {

// Which grid of a file: "" the one named "density", else the first; "#3" by number from 0; "=NAME" by name.
std::string gridByNumber(int number);
std::string gridByName(const std::string& name);

enum class GridRecord : uint32_t {
  End,       // count: records of bricks that came before
  Constant,  // a brick of one value; count: its number, which grows from record to record
  Brick,     // a brick, 512 voxels
  Refusal,   // count: bytes of a text that says why there is no grid
  Shape,     // GridShape
};

// Reads `which` of a file and writes it to a descriptor; a refusal where that cannot be. May end the process or never
// return where the file is damaged. False: the descriptor cannot be written.
bool sendGrid(const std::string& path, const std::string& which, int descriptor);

// What sendGrid() asks of the library of picture files (image/picture_library.h).
struct VolumeCalls {
  static constexpr const char* kSymbol = "kinoraVolumeCalls";
  bool (*send)(const std::string& path, const std::string& which, int descriptor);
};

// The grid that `read` gives (false: no more bytes), of `most` bytes; null with `error`, which is "" where the bytes
// end too early. store: see VoxelGrid. Throws MemoryExceeded or bad_alloc.
std::unique_ptr<VoxelGrid> receiveGrid(const std::function<bool(void* to, size_t bytes)>& read, uint64_t most,
                                       std::string& error, std::shared_ptr<VoxelStore> store = nullptr);

}  // namespace kinora::volume
