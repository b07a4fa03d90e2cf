// Files of a texture that is cut into tiles (UDIM and its kin), on a grid with holes. Used by texture_system.cpp.
#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace kinora::texture {

template <class File>
class AtlasGrid {
 public:
  // Makes room for a tile; before place().
  void include(int u, int v) {
    columns_ = std::max(columns_, u + 1);
    rows_ = std::max(rows_, v + 1);
  }
  File*& place(int u, int v) {
    grid_.resize(size_t(columns_) * size_t(rows_));
    return grid_[size_t(v) * size_t(columns_) + size_t(u)];
  }

  // The file under s and `up`, which become coordinates inside it; null where there is none. The far border of a tile
  // that has no neighbour belongs to it: geometry that fills a tile reaches its border.
  File* find(float& s, float& up) const {
    const float column = std::floor(s), row = std::floor(up);
    for (const float x : {column, s == column ? column - 1 : -1.f})
      for (const float y : {row, up == row ? row - 1 : -1.f})
        if (File* found = at(x, y)) {
          s -= x;
          up -= y;
          return found;
        }
    return nullptr;
  }

  // The tiles within the grid that have no file: "1002, 1012"; "" when there are none.
  std::string holes() const {
    constexpr int kMostNamed = 8;
    std::string text;
    int count = 0;
    for (int v = 0; v < rows_; ++v)
      for (int u = 0; u < columns_; ++u) {
        if (grid_[size_t(v) * size_t(columns_) + size_t(u)] || ++count > kMostNamed) continue;
        // names by four digits have at most ten columns
        text += (text.empty() ? "" : ", ") + (columns_ <= 10 ? std::to_string(1001 + u + 10 * v)
                                                             : "u" + std::to_string(u) + "_v" + std::to_string(v));
      }
    return count > kMostNamed ? text + " and " + std::to_string(count - kMostNamed) + " more" : text;
  }

 private:
  File* at(float column, float row) const {  // NaN is nowhere
    const bool isInside = column >= 0.f && row >= 0.f && column < float(columns_) && row < float(rows_);
    return isInside ? grid_[size_t(row) * size_t(columns_) + size_t(column)] : nullptr;
  }

  int columns_ = 0, rows_ = 0;
  std::vector<File*> grid_;  // columns x rows
};

}  // namespace kinora::texture
