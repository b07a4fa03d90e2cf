#include <algorithm>

#include "volume/grid_stream.h"

namespace kinora::volume {

std::string gridByNumber(int number) { return "#" + std::to_string(number); }
std::string gridByName(const std::string& name) { return "=" + name; }

std::unique_ptr<VoxelGrid> receiveGrid(const std::function<bool(void*, size_t)>& read, uint64_t most,
                                       std::string& error, std::shared_ptr<VoxelStore> store) {
  error.clear();
  std::unique_ptr<VoxelGrid> grid;
  uint64_t records = 0, next = 0;
  for (;;) {
    uint32_t head[2];
    if (!read(head, sizeof head)) return nullptr;
    const GridRecord kind = GridRecord(head[0]);
    if (kind == GridRecord::Refusal) {
      std::string text(std::min(head[1], 1000u), ' ');
      if (!read(text.data(), text.size())) return nullptr;
      text.resize(std::min<size_t>(text.size(), 300));
      for (char& c : text)  // words of a damaged file may stand in it
        if (c < ' ' || c > '~') c = '?';
      error = text.empty() ? "no reason was given" : text;
      return nullptr;
    }
    error = "what came of it cannot be understood";
    if (kind == GridRecord::Shape) {
      GridShape shape;
      if (grid || head[1] != sizeof shape) return nullptr;
      error.clear();
      if (!read(&shape, sizeof shape)) return nullptr;
      if (const char* why = shape.disbelief()) {
        error = why;
        return nullptr;
      }
      grid = std::make_unique<VoxelGrid>(shape, store);
      continue;
    }
    if (!grid) return nullptr;
    if (kind == GridRecord::End) {
      if (head[1] != records) return nullptr;
      uint8_t more;
      if (read(&more, 1)) return nullptr;
      error.clear();
      grid->coarsen(grid->shape().brickCount());
      return grid;
    }
    const bool isConstant = kind == GridRecord::Constant;
    if ((!isConstant && kind != GridRecord::Brick) || head[1] < next || head[1] >= grid->shape().brickCount())
      return nullptr;
    if (grid->bytes() > most) {
      error = "its voxels take more memory (" + asBinaryBytes(most) + ") than is given to a file of its size";
      return nullptr;
    }
    // while the bricks that they are made of are still in memory
    grid->coarsen(head[1]);
    next = head[1] + uint64_t(1);
    ++records;
    error.clear();
    const size_t channels = size_t(grid->shape().channels);
    if (isConstant) {
      float value[3];
      if (!read(value, channels * sizeof(float))) return nullptr;
      grid->addConstantBrick(head[1], value);
    } else if (!read(grid->addBrick(head[1]), size_t(GridShape::kVoxels) * channels * sizeof(float))) {
      return nullptr;
    }
  }
}

}  // namespace kinora::volume
