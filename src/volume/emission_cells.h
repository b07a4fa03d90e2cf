// What a medium emits, over even cells of a box of object space: how points of it are sampled as light, and with which
// density a ray's direction would have been. Made by render/, read by shade/ on any thread; it knows no medium.
//
// A direction is that from a place to a point drawn by the cells' emission, evenly within a cell; its density per solid
// angle is the integral over the ray of the points' density times the squared distance, so that nothing is singular
// where the place lies in the fire itself (after Villemin and Hery, "Practical Illumination from Flames", JCGT 2013, and
// Simon et al., "Line Integration for Rendering Heterogeneous Emissive Volumes", CGF 2017). Where along that ray light
// is looked for is drawn by what its cells emit.
#pragma once
#include <cstdint>
#include <vector>

#include "volume/majorants.h"

namespace kinora::volume {

class EmissionCells {
 public:
  // emitted: by cell of `cells`, x fastest, power by volume in any unit; cells of 0 are never sampled.
  EmissionCells(const float low[3], const float high[3], const int cells[3], const std::vector<float>& emitted);

  bool isBlack() const { return sums_.empty(); }
  // A box around all that emits.
  void bounds(float low[3], float high[3]) const;
  bool emits(const float object[3]) const;
  // A point of object space; u, v, w in [0, 1).
  void sample(float u, float v, float w, float object[3]) const;
  // All along the ray o + t d, t from 0 on: the density of points by volume of object space times t^2, integrated over
  // t, and the density alone.
  struct Along {
    float squared, line;
  };
  Along along(const float o[3], const float d[3]) const;
  // Of such a ray, where `u` of its line integral lies; `density` is by t. -1: nothing emits along it.
  float distance(const float o[3], const float d[3], float u, const Along& along, float& density) const;

 private:
  template <class F>
  void forCells(const float o[3], const float d[3], F&& f) const;
  Majorants cells_;                                // of densities by volume of object space
  float low_[3], high_[3], size_[3], cellVolume_;  // size_: of a cell
  float around_[2][3] = {};                        // the box around all that emits
  std::vector<float> sums_;                        // of the probabilities, of cells that emit
  std::vector<uint32_t> cellOf_;
};

}  // namespace kinora::volume
