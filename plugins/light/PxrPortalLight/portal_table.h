// What a dome shows through a portal, in coordinates in which a rectangle is a rectangle from wherever it is seen: the angles
// atan(x / z) and atan(y / z) of a direction in the portal's frame (Bitterli, Wyman and Pharr, "Portal-Masked Environment
// Map Sampling", EGSR 2015). Sums over all cells below and left of each corner are kept, so that the radiance in any
// window is four lookups; as whole numbers, so that differences of sums are exact whatever the sky's range is.
#pragma once
#include <kinora/light_setup.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace kinora::lightParts {

class PortalTable {
 public:
  struct Axes {
    Double3 x, y, z;
  };
  // Axes of the portal and of the dome, orthonormal, in one space; directions through the portal have a negative part along
  // `normal`. `radiance`: what the map's channels are multiplied by.
  struct Setup {
    const LightMap* map;
    Double3 portalX, portalY, normal;
    std::vector<Axes> domes;  // one; of a dome that turns, those of times that share the table
    const float* radiance;
    int32_t size;  // cells along each axis: even
  };

  // Cells as wide as the map's texels.
  static int32_t sizeFor(const LightMap& map) { return std::clamp(map.height + map.height % 2, 64, 1024); }
  // How many times of a dome that turns by `angle` (radians, all its way) share a table, so that it goes by about a cell
  // between two of them; makes the cells wider where that takes long.
  static int32_t timesFor(double angle, int32_t& size) {
    constexpr double kMostCells = 1 << 21;  // looked up in all: half a second
    const auto times = [&] { return int32_t(std::clamp(std::ceil(angle / kPi * size), 2.0, 64.0)); };
    while (size > 64 && double(size) * size * times() > kMostCells) size = std::max(64, size / 4 * 2);
    return times();
  }

  // Cells of `seen` hold radiance by solid angle, those of `emitted`, twice as wide, times the cosine to the normal; means
  // over the domes. mean[c]: of the map's channel over the directions through the portal, by that cosine.
  static void build(const Setup& s, PortalTable& seen, PortalTable& emitted, double mean[3]) {
    const LightMap& map = *s.map;
    const size_t n = size_t(s.size);
    std::vector<double> value(n * n, 0.0), passing(n * n / 4, 0.0);
    // lookups at corners no farther from each other than texels of maps up to twice as high are
    const size_t side = size_t(map.height) <= n / 2 ? 1 : 2, fine = n * side;
    const double step = kPi / double(fine);
    const auto tangents = [&](size_t count, double first) {
      std::vector<double> t(count);
      for (size_t i = 0; i < count; ++i)
        t[i] = std::tan(std::clamp((double(i) + first) * step - kPi / 2, -kPi / 2 + 1e-4, kPi / 2 - 1e-4));
      return t;
    };
    const std::vector<double> edges = tangents(fine + 1, 0), middles = tangents(fine, 0.5);
    std::vector<std::array<double, 3>> row[2];
    for (auto& r : row) r.resize(fine + 1);
    const auto lookUpRow = [&](size_t i) {
      for (size_t j = 0; j <= fine; ++j)
        lookUp(s, normalized(s.portalX * edges[i] + s.portalY * edges[j] - s.normal), row[i & 1][j].data());
    };
    double sums[3] = {0, 0, 0}, weights = 0;
    lookUpRow(0);
    for (size_t i = 0; i < fine; ++i) {
      lookUpRow(i + 1);
      for (size_t j = 0; j < fine; ++j) {
        const double a = middles[i], b = middles[j], r2 = 1 + a * a + b * b, cosine = 1 / std::sqrt(r2);
        const double solidAngle = (1 + a * a) * (1 + b * b) / r2 * cosine * step * step;
        double sum = 0;
        for (size_t c = 0; c < 3; ++c) {
          const double texel = (row[0][j][c] + row[0][j + 1][c] + row[1][j][c] + row[1][j + 1][c]) / 4;
          sums[c] += texel * cosine * solidAngle;
          sum += std::fabs(texel * s.radiance[c]) * solidAngle;
        }
        weights += cosine * solidAngle;
        value[i / side * n + j / side] += sum;
        passing[i / side / 2 * (n / 2) + j / side / 2] += sum * cosine;
      }
    }
    // Finer maps have suns between the lookups: their texels are counted where they fall.
    if (size_t(map.height) > 2 * n) {
      double counted[3] = {0, 0, 0};
      count(s, n, value, passing, counted);  // twice as much in all: cells are shares
      for (int c = 0; c < 3; ++c) sums[c] = (sums[c] + counted[c]) / 2;
    }
    for (int c = 0; c < 3; ++c) mean[c] = sums[c] / weights;
    seen.sum(n, value);
    emitted.sum(n / 2, passing);
  }

  bool valid() const { return size_ > 0; }
  int32_t size() const { return size_; }  // cells along each axis, which spans pi
  // (size + 1) squared, sums()[i * (size + 1) + j] over the cells below i along x and j along y.
  const int32_t* sums() const { return sums_.data(); }
  // The sum over all cells, as a window sums them: the columns but the last, and that one.
  float whole() const { return whole_; }

 private:
  static constexpr double kPi = 3.14159265358979323846;

  // Adds radiance times solid angle of the texels to cells, and that times the cosine to cells twice as wide and by channel.
  // Of many domes each texel stands in some, its neighbours in others.
  static void count(const Setup& s, size_t n, std::vector<double>& value, std::vector<double>& passing,
                    double counted[3]) {
    const LightMap& map = *s.map;
    const auto cellOf = [n](double tangent) {
      return size_t(std::clamp((std::atan(tangent) / kPi + .5) * double(n), 0.0, double(n) - 1));
    };
    constexpr size_t kMostTexels = 1 << 24;  // a second
    const size_t domes = s.domes.size(), texels = size_t(map.width) * size_t(map.height);
    const size_t each = std::clamp<size_t>(kMostTexels / texels, 1, domes);
    for (int32_t y = 0; y < map.height; ++y) {
      const double polar = kPi * (y + .5) / map.height, sine = std::sin(polar);
      const double solidAngle = 2 * kPi / map.width * kPi / map.height * sine / double(each);
      for (int32_t x = 0; x < map.width; ++x) {
        const double phi = -2 * kPi * (x + .5) / map.width;
        const size_t at = size_t(y) * size_t(map.width) + size_t(x);
        for (size_t k = 0; k < each; ++k) {
          const Axes& dome = s.domes[(at * 40503 + k * domes / each) % domes];  // 40503: 2^16 by the golden ratio
          const Double3 d =
              dome.x * (sine * std::cos(phi)) + dome.y * (sine * std::sin(phi)) + dome.z * std::cos(polar);
          const double cosine = -dot(d, s.normal);
          if (!(cosine > 1e-9)) continue;
          double sum = 0;
          for (int c = 0; c < 3; ++c) {
            const double texel = map.texel(at, c);
            counted[c] += texel * cosine * solidAngle;
            sum += std::fabs(texel * s.radiance[c]);
          }
          const size_t i = cellOf(dot(d, s.portalX) / cosine), j = cellOf(dot(d, s.portalY) / cosine);
          value[i * n + j] += sum * solidAngle;
          passing[i / 2 * (n / 2) + j / 2] += sum * solidAngle * cosine;
        }
      }
    }
  }
  static void lookUp(const Setup& s, Double3 d, double texel[3]) {
    double sum[3] = {0, 0, 0};
    for (const Axes& dome : s.domes) {
      double one[3];
      lookUp(*s.map, {dot(d, dome.x), dot(d, dome.y), dot(d, dome.z)}, one);
      for (int c = 0; c < 3; ++c) sum[c] += one[c];
    }
    for (int c = 0; c < 3; ++c) texel[c] = sum[c] / double(s.domes.size());
  }
  // Bilinear, as light_author.h looks up.
  static void lookUp(const LightMap& m, Double3 d, double texel[3]) {
    double u = std::atan2(d.y, d.x) * (-.5 / kPi);
    u -= std::floor(u);
    const double v = std::atan2(std::sqrt(d.x * d.x + d.y * d.y), d.z) / kPi;
    const double x = u * m.width - .5, y = v * m.height - .5, fx = std::floor(x), fy = std::floor(y);
    const auto wrap = [&](double i) { return size_t(i < 0 ? m.width - 1 : i >= m.width ? 0 : int32_t(i)); };
    const auto row = [&](double j) { return size_t(std::clamp(j, 0.0, double(m.height - 1))) * size_t(m.width); };
    const size_t x0 = wrap(fx), x1 = wrap(fx + 1), y0 = row(fy), y1 = row(fy + 1);
    const double a = x - fx, b = y - fy;
    for (int c = 0; c < 3; ++c)
      texel[c] = (m.texel(y0 + x0, c) * (1 - a) + m.texel(y0 + x1, c) * a) * (1 - b) +
                 (m.texel(y1 + x0, c) * (1 - a) + m.texel(y1 + x1, c) * a) * b;
  }
  // Every cell keeps a thousandth of the mean, for light that comes into it from its neighbours' texels.
  void sum(size_t n, const std::vector<double>& value) {
    size_ = int32_t(n);
    double total = 0;
    for (double v : value) total += v;
    const double least = total > 0 ? 1e-3 * total / double(n * n) : 1;
    total = 0;
    for (double v : value) total += std::max(v, least);
    const double scale = 1e9 / total;  // cells round to at most one more each: below 2^31 in all
    sums_.assign((n + 1) * (n + 1), 0);
    for (size_t i = 0; i < n; ++i) {
      int32_t column = 0;
      for (size_t j = 0; j < n; ++j) {
        column += std::max(1, int32_t(std::max(value[i * n + j], least) * scale + .5));
        sums_[(i + 1) * (n + 1) + j + 1] = sums_[i * (n + 1) + j + 1] + column;
      }
    }
    // the rows but the last, and that one
    const auto upTo = [&](size_t columns) {
      const int32_t *last = &sums_[columns * (n + 1) + n], *rest = last - 1;
      return float(*last - *rest) + float(*rest);
    };
    whole_ = (upTo(n) - upTo(n - 1)) + upTo(n - 1);
  }

  int32_t size_ = 0;
  std::vector<int32_t> sums_;
  float whole_ = 0;
};

}  // namespace kinora::lightParts
