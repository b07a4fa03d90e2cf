// Integrals of functions over the sphere of directions, cell by cell. The cells are squares on the faces of a cube
// about the sphere (no singular poles; the horizon of the frame falls on cell edges), split where pilot samples
// crowd, so that a lobe a thousandth of a radian wide is found. Used by the checks only.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include <kinora/testing/test_context.h>

namespace kinora::testing {

class SphereCells {
 public:
  // z: the frame's pole (unit); faces are cut into 4^level cells.
  SphereCells(Vec3 z, uint32_t level);
  // Splits cells until none holds more than `most` of the samples (or is smaller than single precision resolves) and
  // neighbours differ by one level at most.
  void refine(const std::vector<Vec3>& samples, uint32_t most);
  uint32_t count() const { return uint32_t(cells_.size()); }
  uint32_t find(Vec3 direction) const;

  struct Cell {
    uint8_t face, level;
    uint32_t x, y;
  };
  const std::vector<Cell>& cells() const { return cells_; }
  // The direction at (u, v) in -1..1 of a face, and solid angle per area there.
  Vec3 direction(uint32_t face, double u, double v, double& jacobian) const;

 private:
  struct Node {
    Cell cell;
    int32_t child = -1;  // first of four
    int32_t index = -1;  // among cells_, for leaves
  };
  uint32_t nodeOf(Vec3 direction) const;
  void split(size_t node);
  void number();
  double axis_[3][3];
  uint32_t level_;
  std::vector<Node> nodes_;
  std::vector<Cell> cells_;
};

struct SphereIntegral {
  uint32_t channels = 0;
  std::vector<double> cell;   // [cell * channels + channel]
  std::vector<double> error;  // [cell]: bound of the error of the watched channels
  std::vector<double> total;  // [channel]
  double totalError = 0;
  uint64_t evaluations = 0;
};

// f(n, directions, out): writes channel c of direction i to out[c * n + i].
using SphereFunction = std::function<void(uint32_t n, const float* const wi[3], double* out)>;

// `seen`: directions in which channel 0 is known not to be 0; cells that hold one are searched until it is found.
// Gauss-Legendre products of 4x4 points, refined until a cell and its four quarters agree within `tolerance` in the
// first `watched` channels and no edge of channel 0 hides at their borders; stops refining after `most` evaluations
// and says so in the errors.
SphereIntegral integrateSphere(const SphereCells& cells, const SphereFunction& f, uint32_t channels, uint32_t watched,
                               double tolerance, uint64_t most, const std::vector<Vec3>& seen = {});

}  // namespace kinora::testing
