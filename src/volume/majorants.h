// Bounds from above of a medium's extinction, over even cells of a box of object space: what tracking draws distances
// by; and its means. Rays walk from cell to cell. Made by render/, read by shade/; it knows no medium.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kinora::volume {

class Majorants {
 public:
  Majorants() = default;
  // One cell, or `cells` along each axis; all bounds are 0.
  Majorants(const float low[3], const float high[3], const int cells[3]);

  int cells(int axis) const { return n_[axis]; }
  size_t count() const { return most_.size(); }
  void boundsOf(size_t cell, float low[3], float high[3]) const;
  float& operator[](size_t cell) { return most_[cell]; }
  float operator[](size_t cell) const { return most_[cell]; }
  float largest() const;
  // About what there is in a cell on average: no bound, and no picture depends on how good it is, but for its noise.
  float& mean(size_t cell) { return mean_[cell]; }
  float mean(size_t cell) const { return mean_[cell]; }
  size_t cellAt(const float place[3]) const;
  // The cell where a ray is at t, in the direction it goes; until `end` (in: not beyond), which is above t, it is in it.
  // inverse: 1 / d, of what is 0 anything.
  size_t cellAt(const float o[3], const float d[3], const float inverse[3], float t, float& end) const;
  float at(const float o[3], const float d[3], const float inverse[3], float t, float& end) const {
    return most_[cellAt(o, d, inverse, t, end)];
  }

 private:
  float low_[3] = {0, 0, 0}, size_[3] = {1, 1, 1}, perSize_[3] = {1, 1, 1};  // of a cell
  int n_[3] = {1, 1, 1};
  std::vector<float> most_{0.f}, mean_{0.f};
};

}  // namespace kinora::volume
