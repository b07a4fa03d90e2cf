#include "film/filter_ratio.h"

#include <algorithm>
#include <cmath>

namespace kinora::film {

// The frame's cells all have the same probability, so that a sample in cell c counts with the integral of the own
// filter over c times the number of cells: then the mean of weight x value is the integral of filter x value, cell by
// cell.
FilterRatio::FilterRatio(const PixelFilter& frame, const PixelFilter& own) {
  const FilterTable t = frame.sampleTable();
  cells_ = std::min({t.cellsX, t.cellsY, kMostCells});
  const int perX = t.cellsX / cells_, perY = t.cellsY / cells_;  // powers of two
  constexpr int kPoints = 4;                                     // midpoints a side of a cell
  std::vector<double> integral(size_t(cells_) * size_t(cells_));
  double sum = 0, absolute = 0;
  for (int j = 0; j < t.cellsY; ++j)
    for (int i = 0; i < cells_ * perX; ++i) {
      if (t.rowStride == 0 && (j % perY || i % perX)) continue;  // separable: whole blocks of cells at once
      const float* row = t.xEdges + size_t(j) * size_t(t.rowStride);
      const bool isBlock = t.rowStride == 0;
      const double x0 = double(row[i]), x1 = double(row[isBlock ? i + perX : i + 1]);
      const double y0 = double(t.yEdges[j]), y1 = double(t.yEdges[isBlock ? j + perY : j + 1]);
      double mean = 0, meanAbsolute = 0;
      for (int b = 0; b < kPoints; ++b)
        for (int a = 0; a < kPoints; ++a) {
          const double f = own.evaluate(x0 + (x1 - x0) * (a + 0.5) / kPoints, y0 + (y1 - y0) * (b + 0.5) / kPoints);
          mean += f / (kPoints * kPoints);
          meanAbsolute += std::fabs(f) / (kPoints * kPoints);
        }
      const double area = (x1 - x0) * (y1 - y0);
      integral[size_t(j / perY) * size_t(cells_) + size_t(i / perX)] += mean * area;
      sum += mean * area;
      absolute += meanAbsolute * area;
    }
  weights_.resize(integral.size());
  const double cells = double(integral.size());
  for (size_t k = 0; k < integral.size(); ++k) {
    const double w = sum > 0 ? integral[k] * cells / sum : 1;
    // coarser than the last bits in which math libraries differ
    weights_[k] = float(std::round(std::ldexp(w, 20)) * std::ldexp(1.0, -20));
  }
  double whole = 0;
  constexpr int kWhole = 256;
  for (int b = 0; b < kWhole; ++b)
    for (int a = 0; a < kWhole; ++a)
      whole += std::fabs(own.evaluate((double(a) + 0.5) / kWhole * own.xWidth() - 0.5 * own.xWidth(),
                                      (double(b) + 0.5) / kWhole * own.yWidth() - 0.5 * own.yWidth()));
  whole *= double(own.xWidth()) * double(own.yWidth()) / (double(kWhole) * kWhole);
  covered_ = whole > 0 ? std::min(1.0, absolute / whole) : 1;
}

double FilterRatio::negativeMean() const {
  double sum = 0;
  for (const float w : weights_) sum -= std::min(0.0, double(w));
  return sum / double(weights_.size());
}

}  // namespace kinora::film
