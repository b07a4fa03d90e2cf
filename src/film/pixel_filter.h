// The pixel filters of RIB as distributions: a sample is placed by the filter around its pixel's centre and counts
// for that pixel alone, so no sample touches a neighbour's sums (measured against splatting: docs/performance.md).
// Built once a frame; render/ gathers from sampleTable() for whole groups, and sample() is the same arithmetic for
// one. It draws no random numbers and adds nothing: film.h takes the weights.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "image/status.h"

namespace kinora::film {

// Offset from the pixel's centre in pixels (x right, y down), and the weight: 1, or negative in a negative lobe.
// The weights' mean is 1.
struct FilterSample {
  float dx = 0, dy = 0, weight = 1;
};

// Plain tables: equal-probability cells, uniform inside. For u, v in [0, 1):
//   j = int(v * cellsY); dy = lerp(yEdges[j], yEdges[j + 1], v * cellsY - j)
//   i = int(u * cellsX); row = xEdges + j * rowStride; dx = lerp(row[i], row[i + 1], u * cellsX - i)
//   weight = yWeight[j] * xWeight[j * rowStride + i]
// rowStride is 0 for separable filters. Cell counts are powers of two; each row has cellsX + 1 entries.
struct FilterTable {
  const float* xEdges;
  const float* xWeight;
  const float* yEdges;
  const float* yWeight;
  int cellsX, cellsY, rowStride;
};

class PixelFilter {
 public:
  // Names of RIB: gaussian, box, triangle, catmull-rom, separable-catmull-rom, mitchell, blackman-harris, sinc,
  // bessel, disk, lanczos; case does not matter. Widths are full widths in pixels. FILM-FILTER when the name or a
  // width cannot be used; `out` is then gaussian 2 2.
  static image::Status make(std::string_view name, float xWidth, float yWidth, PixelFilter& out);
  static const std::vector<std::string>& names();
  // A filter of somebody else's: its value at x, y in pixels, asked for while the tables are made and by evaluate().
  using Value = std::function<double(double x, double y)>;
  static image::Status make(std::string_view name, float xWidth, float yWidth, Value value, PixelFilter& out);

  PixelFilter();  // gaussian 2 2
  const std::string& name() const { return name_; }
  float xWidth() const { return xWidth_; }
  float yWidth() const { return yWidth_; }
  bool isSeparable() const { return rowStride_ == 0; }
  bool hasNegativeLobes() const { return hasNegativeLobes_; }
  // Mean of what the samples' weights lie below 0 (ChannelLayout::setNegative); 0 without negative lobes.
  double negativeMean() const;
  // The filter's value, not normalised; 0 outside the widths.
  double evaluate(double x, double y) const;

  FilterSample sample(float u, float v) const;
  FilterTable sampleTable() const {
    return {xEdges_.data(), xWeight_.data(), yEdges_.data(), yWeight_.data(), cellsX_, cellsY_, rowStride_};
  }

 private:
  bool build();  // false: the filter's integral is not positive
  bool buildSeparable();
  bool buildPlanar();
  double planarAt(double x, double y) const;
  Value value_;
  std::string name_ = "gaussian";
  int kind_ = 0;
  float xWidth_ = 2, yWidth_ = 2;
  bool hasNegativeLobes_ = false;
  int cellsX_ = 0, cellsY_ = 0, rowStride_ = 0;
  std::vector<float> xEdges_, xWeight_, yEdges_, yWeight_;
};

}  // namespace kinora::film
