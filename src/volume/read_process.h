// Files of volumes are read in a process of their own: OpenVDB ends the program, or goes on for minutes, where a file
// is damaged, and scenes come from anywhere. The renderer starts itself with a command that no help names
// (app/read_volume_command.cpp), which bounds its own time and memory, reads and writes one grid to a pipe.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "volume/voxel_grid.h"

namespace kinora::volume {

// How to start the process that reads. FILE, GRID (grid_stream.h), the bytes it may take and the seconds of computing
// that it may last follow the command.
struct ReaderProgram {
  std::vector<std::string> command;  // empty: there is none, nothing is read
  double seconds = 60;               // of computing, and one more for each 20 MB of the file; of waiting, twice that
};
inline constexpr const char* kReadCommand = "read-volume";
// This very program.
ReaderProgram thisProgram();

// Reader and grid may each take 1 GiB and a hundred times the file's size, within the machine's memory and what
// --memory-limit leaves; that does not bound what a store keeps in a file. Null with `error` where there is none. Throws
// MemoryExceeded or bad_alloc.
std::unique_ptr<VoxelGrid> readGrid(const ReaderProgram& program, const std::string& path, const std::string& which,
                                    std::string& error, std::shared_ptr<VoxelStore> store = nullptr);

// What the started process does, with the words after the command: its exit code.
int serveGrid(const std::vector<std::string>& words);

}  // namespace kinora::volume
