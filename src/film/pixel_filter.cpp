#include "film/pixel_filter.h"

#include <math.h>  // j1: not in <cmath>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/text.h"

namespace kinora::film {
namespace {

using std::numbers::pi;

enum Kind {
  Gaussian,
  Box,
  Triangle,
  CatmullRom,
  SeparableCatmullRom,
  Mitchell,
  BlackmanHarris,
  Sinc,
  Bessel,
  Disk,
  Lanczos,
  Foreign  // somebody else's function; behind the names
};

constexpr float kLeastWidth = 1e-3f, kMostWidth = 64.0f;
constexpr int kSeparableCells = 512, kPlanarCells = 128;
// midpoints of the numerical integration: one axis, and each side of the plane
constexpr int kFine = 1 << 15, kFinePlane = 512;

// Cubics with the parameters of Mitchell and Netravali (1988); x in [-2, 2].
double cubic(double x, double b, double c) {
  x = std::fabs(x);
  if (x < 1) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6;
  if (x < 2)
    return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6;
  return 0;
}
double sinc(double x) { return std::fabs(x) < 1e-8 ? 1 : std::sin(pi * x) / (pi * x); }

// One axis of a separable filter; `x` in pixels, inside |x| <= width / 2. Filters made from interpolating functions
// (catmull-rom, sinc) keep their scale of one pixel and are cut by the width, as the RISpec's sources do; the others
// are stretched to it.
double axis(int kind, double x, double width) {
  const double t = 2 * x / width;  // -1..1
  switch (kind) {
    case Gaussian:
      return std::exp(-2 * t * t);
    case Box:
      return 1;
    case Triangle:
      return 1 - std::fabs(t);
    case SeparableCatmullRom:
      return cubic(x, 0, 0.5);
    case Mitchell:
      return cubic(2 * t, 1.0 / 3, 1.0 / 3);
    case BlackmanHarris:  // 4 terms (Harris 1978)
      return 0.35875 + 0.48829 * std::cos(pi * t) + 0.14128 * std::cos(2 * pi * t) + 0.01168 * std::cos(3 * pi * t);
    case Sinc:
      return sinc(x);
    case Lanczos:
      return sinc(x) * sinc(t);
    default:
      return 0;
  }
}

double planar(int kind, double x, double y, double xWidth, double yWidth) {
  const double r = std::hypot(x, y), unit = std::hypot(2 * x / xWidth, 2 * y / yWidth);
  switch (kind) {
    case CatmullRom:
      return cubic(r, 0, 0.5);
    case Bessel:
      return unit > 1 ? 0 : r < 1e-8 ? 1 : 2 * ::j1(pi * r) / (pi * r);
    case Disk:
      return unit <= 1 ? 1 : 0;
    default:
      return 0;
  }
}

bool isPlanar(int kind) { return kind == CatmullRom || kind == Bessel || kind == Disk || kind == Foreign; }

// Coarser than the last bits in which math libraries differ.
float snapped(double v) { return float(std::round(std::ldexp(v, 24)) * std::ldexp(1.0, -24)); }

// Cuts the density `f` (values at the midpoints of equal steps over [low, high], signed) into `cells` cells of equal
// probability under |f|, with cell borders at changes of sign; writes cells + 1 edges and a weight a cell, such that
// the mean of weight x g over cells is the integral of f g, f normalised by `norm` = its integral x probability.
void cutIntoCells(const std::vector<double>& f, double low, double high, int cells, double norm, float* edges,
                  float* weights) {
  const double step = (high - low) / double(f.size());
  struct Run {
    size_t begin, end;
    double mass;
    bool isNegative;
    int cells;
  };
  std::vector<Run> runs;
  double total = 0;
  for (size_t i = 0; i < f.size(); ++i) {
    if (f[i] == 0) {  // belongs to its left neighbour
      if (!runs.empty()) runs.back().end = i + 1;
      continue;
    }
    const bool isNegative = f[i] < 0;
    if (runs.empty() || runs.back().isNegative != isNegative) runs.push_back({i, i + 1, 0, isNegative, 0});
    runs.back().end = i + 1;
    runs.back().mass += std::fabs(f[i]) * step;
    total += std::fabs(f[i]) * step;
  }
  // tiny runs (rounding at a zero) get no cell; their mass is below a cell's thousandth
  std::erase_if(runs, [&](const Run& r) { return r.mass < total * 1e-3 / cells; });
  if (runs.empty()) {
    for (int k = 0; k <= cells; ++k) edges[k] = snapped(low + (high - low) * k / cells);
    std::fill_n(weights, cells, 0.0f);
    return;
  }
  int given = 0;
  for (Run& r : runs) given += r.cells = std::max(1, int(std::lround(cells * r.mass / total)));
  Run& largest = *std::max_element(runs.begin(), runs.end(), [](auto& a, auto& b) { return a.mass < b.mass; });
  largest.cells += cells - given;
  int k = 0;
  for (const Run& r : runs) {
    const double perCell = r.mass / r.cells;
    double mass = 0, next = 0;
    int inRun = 0;
    const float weight = snapped((r.isNegative ? -1 : 1) * perCell * cells / norm);
    for (size_t i = r.begin; i < r.end && inRun < r.cells; ++i) {
      const double here = std::fabs(f[i]) * step;
      while (inRun < r.cells && here > 0 && mass + here >= next) {
        const double inside = std::clamp((next - mass) / here, 0.0, 1.0);
        edges[k] = snapped(low + (double(i) + inside) * step);
        weights[k] = weight;
        ++k;
        next = ++inRun * perCell;
      }
      mass += here;
    }
    for (; inRun < r.cells; ++inRun, ++k) {  // lost to rounding of the sums
      edges[k] = snapped(low + double(r.end) * step);
      weights[k] = weight;
    }
  }
  // a filter that is 0 up to its border (disk) ends where its last run does
  edges[k] = snapped(low + double(runs.back().end) * step);
}

image::Status checkWidths(float x, float y) {
  for (const float w : {x, y})
    if (!(w >= kLeastWidth && w <= kMostWidth))
      return image::Status::fail("FILM-FILTER",
                                 "a pixel filter's width of " + std::to_string(w) + " is outside 0.001 to 64 pixels");
  return {};
}

}  // namespace

const std::vector<std::string>& PixelFilter::names() {
  static const std::vector<std::string> list{
      "gaussian", "box",    "triangle", "catmull-rom", "separable-catmull-rom", "mitchell", "blackman-harris",
      "sinc",     "bessel", "disk",     "lanczos"};
  return list;
}

PixelFilter::PixelFilter() { build(); }

image::Status PixelFilter::make(std::string_view name, float xWidth, float yWidth, PixelFilter& out) {
  const std::string lower = lowerCase(std::string(name));
  const auto it = std::find(names().begin(), names().end(), lower);
  out = PixelFilter();
  if (it == names().end())
    return image::Status::fail("FILM-FILTER", "unknown pixel filter \"" + std::string(name) + "\"");
  if (image::Status s = checkWidths(xWidth, yWidth); !s.ok()) return s;
  PixelFilter made = out;
  made.name_ = lower;
  made.kind_ = int(it - names().begin());
  made.xWidth_ = xWidth;
  made.yWidth_ = yWidth;
  if (!made.build())
    return image::Status::fail("FILM-FILTER", "pixel filter \"" + lower + "\" has no positive integral at width " +
                                                  std::to_string(xWidth) + " " + std::to_string(yWidth));
  out = std::move(made);
  return {};
}

image::Status PixelFilter::make(std::string_view name, float xWidth, float yWidth, Value value, PixelFilter& out) {
  out = PixelFilter();
  if (image::Status s = checkWidths(xWidth, yWidth); !s.ok()) return s;
  PixelFilter made = out;
  made.name_ = name;
  made.kind_ = Foreign;
  made.value_ = std::move(value);
  made.xWidth_ = xWidth;
  made.yWidth_ = yWidth;
  if (!made.build())
    return image::Status::fail("FILM-FILTER", "pixel filter \"" + made.name_ + "\" has no positive integral");
  out = std::move(made);
  return {};
}

double PixelFilter::planarAt(double x, double y) const {
  if (kind_ != Foreign) return planar(kind_, x, y, xWidth_, yWidth_);
  const double v = value_(x, y);
  return std::isfinite(v) ? v : 0;
}

double PixelFilter::evaluate(double x, double y) const {
  if (std::fabs(x) > 0.5 * double(xWidth_) || std::fabs(y) > 0.5 * double(yWidth_)) return 0;
  return isPlanar(kind_) ? planarAt(x, y) : axis(kind_, x, xWidth_) * axis(kind_, y, yWidth_);
}

bool PixelFilter::build() { return isPlanar(kind_) ? buildPlanar() : buildSeparable(); }

bool PixelFilter::buildSeparable() {
  cellsX_ = cellsY_ = kSeparableCells;
  rowStride_ = 0;
  hasNegativeLobes_ = false;
  const auto oneAxis = [&](double width, std::vector<float>& edges, std::vector<float>& weights) {
    // beyond 2 pixels the cubics are 0: no cell may lie there
    const double half = kind_ == SeparableCatmullRom ? std::min(0.5 * width, 2.0) : 0.5 * width;
    std::vector<double> f(kFine);
    double integral = 0;
    for (int i = 0; i < kFine; ++i) {
      f[size_t(i)] = axis(kind_, half * ((2.0 * i + 1) / kFine - 1), width);
      integral += f[size_t(i)] * 2 * half / kFine;
      hasNegativeLobes_ |= f[size_t(i)] < 0;
    }
    if (!(integral > 1e-6 * half)) return false;
    edges.resize(kSeparableCells + 1);
    weights.resize(kSeparableCells + 1, 0.0f);
    cutIntoCells(f, -half, half, kSeparableCells, integral, edges.data(), weights.data());
    return true;
  };
  return oneAxis(xWidth_, xEdges_, xWeight_) && oneAxis(yWidth_, yEdges_, yWeight_);
}

bool PixelFilter::buildPlanar() {
  cellsX_ = cellsY_ = kPlanarCells;
  rowStride_ = kPlanarCells + 1;
  const double limit = kind_ == CatmullRom ? 2.0 : kMostWidth;
  const double halfX = std::min(0.5 * double(xWidth_), limit), halfY = std::min(0.5 * double(yWidth_), limit);
  const double stepX = 2 * halfX / kFinePlane, stepY = 2 * halfY / kFinePlane;
  std::vector<double> f(size_t(kFinePlane) * kFinePlane), marginal(kFinePlane);
  double integral = 0;
  hasNegativeLobes_ = false;
  for (int j = 0; j < kFinePlane; ++j)
    for (int i = 0; i < kFinePlane; ++i) {
      const double v = planarAt((i + 0.5) * stepX - halfX, (j + 0.5) * stepY - halfY);
      f[size_t(j) * kFinePlane + size_t(i)] = v;
      marginal[size_t(j)] += std::fabs(v) * stepX;
      integral += v * stepX * stepY;
      hasNegativeLobes_ |= v < 0;
    }
  if (!(integral > 1e-6 * halfX * halfY)) return false;
  yEdges_.resize(kPlanarCells + 1);
  yWeight_.resize(kPlanarCells + 1);
  cutIntoCells(marginal, -halfY, halfY, kPlanarCells, 1.0, yEdges_.data(), yWeight_.data());
  std::fill(yWeight_.begin(), yWeight_.end(), 1.0f);  // the whole weight is in the rows
  xEdges_.resize(size_t(rowStride_) * kPlanarCells);
  xWeight_.assign(xEdges_.size(), 0.0f);
  std::vector<double> row(kFinePlane);
  for (int j = 0; j < kPlanarCells; ++j) {
    // the filter integrated over the row's span of y, fine rows cut where the span ends inside one
    std::fill(row.begin(), row.end(), 0.0);
    const double low = (double(yEdges_[size_t(j)]) + halfY) / stepY,
                 high = (double(yEdges_[size_t(j) + 1]) + halfY) / stepY;
    for (int r = std::max(0, int(low)); r < kFinePlane && r < high; ++r) {
      const double covered = std::min(high, r + 1.0) - std::max(low, double(r));
      if (covered <= 0) continue;
      for (int i = 0; i < kFinePlane; ++i) row[size_t(i)] += f[size_t(r) * kFinePlane + size_t(i)] * covered * stepY;
    }
    const size_t at = size_t(j) * size_t(rowStride_);
    cutIntoCells(row, -halfX, halfX, kPlanarCells, integral / kPlanarCells, &xEdges_[at], &xWeight_[at]);
  }
  return true;
}

double PixelFilter::negativeMean() const {
  double sum = 0;
  for (int j = 0; j < cellsY_; ++j)
    for (int i = 0; i < cellsX_; ++i)
      sum -=
          std::min(0.0, double(yWeight_[size_t(j)]) * double(xWeight_[size_t(j) * size_t(rowStride_) + size_t(i)]));
  return sum / (double(cellsX_) * cellsY_);
}

FilterSample PixelFilter::sample(float u, float v) const {
  const float ty = v * float(cellsY_), tx = u * float(cellsX_);
  const int j = std::min(int(ty), cellsY_ - 1), i = std::min(int(tx), cellsX_ - 1);
  const size_t row = size_t(j) * size_t(rowStride_);
  const float* x = xEdges_.data() + row;
  FilterSample s;
  s.dy = yEdges_[size_t(j)] + (ty - float(j)) * (yEdges_[size_t(j) + 1] - yEdges_[size_t(j)]);
  s.dx = x[i] + (tx - float(i)) * (x[i + 1] - x[i]);
  s.weight = yWeight_[size_t(j)] * xWeight_[row + size_t(i)];
  return s;
}

}  // namespace kinora::film
