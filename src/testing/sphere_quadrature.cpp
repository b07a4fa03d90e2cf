#include "testing/sphere_quadrature.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kinora::testing {

namespace {
// 2^-18 of a face is 8e-6 rad: narrower than any lobe whose shape single-precision directions can still express
constexpr uint32_t kDeepest = 18;
constexpr int kGaussPoints = 4;
// Eight points just inside a cell's border see an edge of the function that lies between the border and the outermost
// node.
constexpr int kBorder = 8, kAll = kGaussPoints * kGaussPoints + kBorder;
constexpr double kBorderU[kBorder] = {-0.999, 0, 0.999, -0.999, 0.999, -0.999, 0, 0.999};
constexpr double kBorderV[kBorder] = {-0.999, -0.999, -0.999, 0, 0, 0.999, 0.999, 0.999};
// Share of a cell that such an edge may hide.
constexpr double kHidden = 0.02;
constexpr double kNode[kGaussPoints] = {-0.861136311594052575, -0.339981043584856265, 0.339981043584856265,
                                        0.861136311594052575};
constexpr double kWeight[kGaussPoints] = {0.347854845137453857, 0.652145154862546143, 0.652145154862546143,
                                          0.347854845137453857};
}  // namespace

SphereCells::SphereCells(Vec3 z, uint32_t level) : level_(level) {
  const double n[3] = {z.x, z.y, z.z};
  const int least = std::abs(n[0]) < std::abs(n[1]) ? (std::abs(n[0]) < std::abs(n[2]) ? 0 : 2)
                                                    : (std::abs(n[1]) < std::abs(n[2]) ? 1 : 2);
  double a[3] = {0, 0, 0};
  a[least] = 1;
  double x[3] = {a[1] * n[2] - a[2] * n[1], a[2] * n[0] - a[0] * n[2], a[0] * n[1] - a[1] * n[0]};
  const double l = 1 / std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
  for (int k = 0; k < 3; ++k) axis_[0][k] = x[k] * l;
  for (int k = 0; k < 3; ++k) axis_[2][k] = n[k];
  for (int k = 0; k < 3; ++k) {
    const int p = (k + 1) % 3, q = (k + 2) % 3;
    axis_[1][k] = axis_[2][p] * axis_[0][q] - axis_[2][q] * axis_[0][p];
  }
  const uint32_t side = 1u << level;
  for (uint8_t face = 0; face < 6; ++face)
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x2 = 0; x2 < side; ++x2) nodes_.push_back({{face, uint8_t(level), x2, y}});
  number();
}

void SphereCells::number() {
  cells_.clear();
  for (Node& n : nodes_) {
    n.index = -1;
    if (n.child >= 0) continue;
    n.index = int32_t(cells_.size());
    cells_.push_back(n.cell);
  }
}

Vec3 SphereCells::direction(uint32_t face, double u, double v, double& jacobian) const {
  const int k = int(face / 2), p = (k + 1) % 3, q = (k + 2) % 3;
  double local[3];
  local[k] = face & 1 ? -1 : 1;
  local[p] = u;
  local[q] = v;
  const double l2 = 1 + u * u + v * v, l = std::sqrt(l2);
  jacobian = 1 / (l2 * l);
  double w[3];
  for (int i = 0; i < 3; ++i) w[i] = (local[0] * axis_[0][i] + local[1] * axis_[1][i] + local[2] * axis_[2][i]) / l;
  return {float(w[0]), float(w[1]), float(w[2])};
}

uint32_t SphereCells::nodeOf(Vec3 d) const {
  double local[3];
  for (int i = 0; i < 3; ++i) local[i] = d.x * axis_[i][0] + d.y * axis_[i][1] + d.z * axis_[i][2];
  int k = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(local[i]) > std::abs(local[k])) k = i;
  const uint32_t face = uint32_t(2 * k) + (local[k] < 0);
  const double scale = 1 / std::abs(local[k]);
  // to 0..1
  double u = 0.5 + 0.5 * local[(k + 1) % 3] * scale, v = 0.5 + 0.5 * local[(k + 2) % 3] * scale;
  u = std::clamp(u, 0.0, std::nextafter(1.0, 0.0));
  v = std::clamp(v, 0.0, std::nextafter(1.0, 0.0));
  const uint32_t side = 1u << level_;
  u *= side;
  v *= side;
  uint32_t node = (face * side + uint32_t(v)) * side + uint32_t(u);
  u -= std::floor(u);
  v -= std::floor(v);
  while (nodes_[node].child >= 0) {
    u *= 2;
    v *= 2;
    const uint32_t right = u >= 1, up = v >= 1;
    u -= right;
    v -= up;
    node = uint32_t(nodes_[node].child) + 2 * up + right;
  }
  return node;
}

uint32_t SphereCells::find(Vec3 direction) const { return uint32_t(nodes_[nodeOf(direction)].index); }

void SphereCells::split(size_t i) {
  const Cell c = nodes_[i].cell;
  nodes_[i].child = int32_t(nodes_.size());
  for (uint32_t k = 0; k < 4; ++k)
    nodes_.push_back({{c.face, uint8_t(c.level + 1), 2 * c.x + (k & 1), 2 * c.y + (k >> 1)}});
}

void SphereCells::refine(const std::vector<Vec3>& samples, uint32_t most) {
  bool again = true;
  while (again) {
    again = false;
    std::vector<uint32_t> held(nodes_.size(), 0);
    for (const Vec3& s : samples) ++held[nodeOf(s)];
    for (size_t i = 0; i < held.size(); ++i) {
      if (held[i] <= most || nodes_[i].cell.level >= kDeepest) continue;
      split(i);
      again = true;
    }
  }
  // neighbours may differ by one level only: a large cell beside small ones would hide the lobe's rim from quadrature
  for (size_t i = 0; i < nodes_.size(); ++i) {  // children are appended, so one pass meets them all
    if (nodes_[i].child >= 0) continue;
    const Cell c = nodes_[i].cell;
    const double size = 2.0 / double(1u << c.level), u = -1 + (c.x + 0.5) * size, v = -1 + (c.y + 0.5) * size;
    for (int b = -1; b <= 1; ++b)
      for (int a = -1; a <= 1; ++a) {
        if (!a && !b) continue;
        double jacobian;
        // just beyond the border, which may be on another face
        const Vec3 beyond = direction(c.face, u + 0.52 * a * size, v + 0.52 * b * size, jacobian);
        for (uint32_t n = nodeOf(beyond); nodes_[n].cell.level + 1 < c.level; n = nodeOf(beyond)) split(n);
      }
  }
  number();
}

SphereIntegral integrateSphere(const SphereCells& cells, const SphereFunction& f, uint32_t channels, uint32_t watched,
                               double tolerance, uint64_t most, const std::vector<Vec3>& seen) {
  SphereIntegral r;
  r.channels = channels;
  r.cell.assign(size_t(cells.count()) * channels, 0);
  r.error.assign(cells.count(), 0);
  r.total.assign(channels, 0);

  struct Item {
    SphereCells::Cell cell;
    uint32_t bin;
  };
  // integrals of a list of cells, [item * channels + channel]
  constexpr uint32_t kBatch = 256;  // cells evaluated together
  std::vector<float> wi[3];
  std::vector<double> jacobian, out;
  std::vector<double> hidden;  // by cell: what an edge of channel 0 may hide
  const auto integrate = [&](const std::vector<Item>& items, std::vector<double>& value) {
    value.assign(items.size() * channels, 0);
    hidden.assign(items.size(), 0);
    for (size_t first = 0; first < items.size(); first += kBatch) {
      const uint32_t m = uint32_t(std::min<size_t>(kBatch, items.size() - first)), n = m * kAll;
      for (auto& w : wi) w.assign(padded(n), 0.f);
      jacobian.resize(n);
      out.resize(size_t(channels) * n);
      uint32_t at = 0;
      for (uint32_t i = 0; i < m; ++i) {
        const SphereCells::Cell& c = items[first + i].cell;
        const double size = 2.0 / double(1u << c.level), u0 = -1 + c.x * size, v0 = -1 + c.y * size;
        // the next direction, at (u, v) in -1..1 of the cell; its Jacobian
        const auto place = [&](double u, double v) {
          double jac;
          const Vec3 d = cells.direction(c.face, u0 + 0.5 * size * (1 + u), v0 + 0.5 * size * (1 + v), jac);
          wi[0][at] = d.x;
          wi[1][at] = d.y;
          wi[2][at] = d.z;
          return jac;
        };
        for (int b = 0; b < kGaussPoints; ++b)
          for (int a = 0; a < kGaussPoints; ++a, ++at)
            jacobian[at] = place(kNode[a], kNode[b]) * kWeight[a] * kWeight[b] * 0.25 * size * size;
        for (int k = 0; k < kBorder; ++k, ++at) {
          place(kBorderU[k], kBorderV[k]);
          jacobian[at] = 0;
        }
      }
      for (uint32_t i = n; i < padded(n); ++i)
        for (auto& w : wi) w[i] = w[n - 1];
      const float* const arrays[3] = {wi[0].data(), wi[1].data(), wi[2].data()};
      f(n, arrays, out.data());
      r.evaluations += n;
      for (uint32_t i = 0; i < n; ++i)
        for (uint32_t c = 0; c < channels; ++c)
          value[(first + i / kAll) * channels + c] += out[size_t(c) * n + i] * jacobian[i];
      for (uint32_t i = 0; i < m; ++i) {
        double most = 0, area = 0;
        bool none = false;
        for (uint32_t k = i * kAll; k < (i + 1) * kAll; ++k) {
          most = std::max(most, out[k]);
          none = none || out[k] == 0;
          area += jacobian[k];
        }
        hidden[first + i] = none ? kHidden * area * most : 0;
      }
    }
  };

  std::vector<bool> occupied(cells.count(), false);
  for (const Vec3& d : seen) occupied[cells.find(d)] = true;
  std::vector<Item> items;
  for (uint32_t i = 0; i < cells.count(); ++i) items.push_back({cells.cells()[i], i});
  std::vector<double> coarse, fine, squares(cells.count(), 0);
  integrate(items, coarse);
  while (!items.empty()) {
    std::vector<Item> quarters;
    quarters.reserve(items.size() * 4);
    for (const Item& item : items)
      for (uint32_t k = 0; k < 4; ++k)
        quarters.push_back(
            {{item.cell.face, uint8_t(item.cell.level + 1), 2 * item.cell.x + (k & 1), 2 * item.cell.y + (k >> 1)},
             item.bin});
    integrate(quarters, fine);
    std::vector<Item> next;
    std::vector<double> nextCoarse;
    const bool stop = r.evaluations > most;
    for (size_t i = 0; i < items.size(); ++i) {
      double difference = 0;
      for (uint32_t c = 0; c < watched; ++c) {
        double sum = 0;
        for (int k = 0; k < 4; ++k) sum += fine[(4 * i + k) * channels + c];
        difference = std::max(difference, std::abs(sum - coarse[i * channels + c]));
      }
      for (int k = 0; k < 4; ++k) difference = std::max(difference, hidden[4 * i + k]);
      double found = coarse[i * channels];
      for (int k = 0; k < 4; ++k) found += fine[(4 * i + k) * channels];
      const bool missed =
          occupied[items[i].bin] && found == 0 && items[i].cell.level < cells.cells()[items[i].bin].level + 4;
      if ((difference > tolerance || missed) && !stop && items[i].cell.level + 1u < kDeepest + 3) {
        for (int k = 0; k < 4; ++k) {
          next.push_back(quarters[4 * i + k]);
          for (uint32_t c = 0; c < channels; ++c) nextCoarse.push_back(fine[(4 * i + k) * channels + c]);
        }
        continue;
      }
      // the finer value of a converged smooth cell is far nearer than the difference; across an edge it is no nearer,
      // but such errors have random signs
      bool edge = difference > tolerance;
      for (int k = 0; k < 4; ++k) edge = edge || hidden[4 * i + k] > 0;
      if (edge) {
        squares[items[i].bin] += difference * difference;
      } else {
        r.error[items[i].bin] += 0.1 * difference;
        r.totalError += 0.1 * difference;
      }
      for (int k = 0; k < 4; ++k)
        for (uint32_t c = 0; c < channels; ++c)
          r.cell[size_t(items[i].bin) * channels + c] += fine[(4 * i + k) * channels + c];
    }
    items = std::move(next);
    coarse = std::move(nextCoarse);
  }
  double allSquares = 0;
  for (uint32_t i = 0; i < cells.count(); ++i) {
    allSquares += squares[i];
    r.error[i] += std::sqrt(squares[i]);
  }
  r.totalError += 2 * std::sqrt(allSquares);
  for (uint32_t i = 0; i < cells.count(); ++i)
    for (uint32_t c = 0; c < channels; ++c) r.total[c] += r.cell[size_t(i) * channels + c];
  return r;
}

}  // namespace kinora::testing
