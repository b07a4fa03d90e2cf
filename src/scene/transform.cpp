#include <algorithm>
#include <cmath>

#include "scene/scene.h"

namespace kinora::scene {

namespace {

Matrix lerp(const Matrix& a, const Matrix& b, double f) {
  Matrix m;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) m[i][j] = a[i][j] + (b[i][j] - a[i][j]) * f;
  return m;
}

double largestEntry(const Matrix& m) {
  double largest = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) largest = std::max(largest, std::abs(m[i][j]));
  return largest;
}

// Leaves kMostKeys of them, the first and the last among these.
void thin(std::vector<double>& times) {
  if (times.size() <= Transform::kMostKeys) return;
  const size_t n = times.size() - 1, kept = Transform::kMostKeys - 1;
  for (size_t k = 0; k <= kept; ++k) times[k] = times[k * n / kept];
  times.resize(kept + 1);
}

}  // namespace

Matrix Transform::at(double time) const {
  if (matrices.size() == 1 || time <= times.front()) return matrices.front();
  if (!(time < times.back())) return matrices.back();
  const size_t k = size_t(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  const double span = times[k] - times[k - 1];
  return lerp(matrices[k - 1], matrices[k], span > 0 ? (time - times[k - 1]) / span : 0);
}

Transform Transform::inverse() const {
  Transform t = *this;
  for (Matrix& m : t.matrices) m = m.inverse();
  return t;
}

Transform Transform::fixed(const Matrix& m) {
  Transform t;
  if (m != Matrix()) t.matrices[0] = m;  // the usual one takes no memory
  return t;
}

Transform concat(const Transform& a, const Transform& b) {
  if (a.isStatic() && b.isStatic()) return Transform::fixed(a.matrices[0] * b.matrices[0]);
  Transform out;
  if (a.isStatic() || b.isStatic()) {
    out = a.isStatic() ? b : a;
    for (size_t k = 0; k < out.matrices.size(); ++k)
      out.matrices[k] = a.isStatic() ? a.matrices[0] * b.matrices[k] : a.matrices[k] * b.matrices[0];
    return out;
  }
  std::vector<double> times;
  std::set_union(a.times.begin(), a.times.end(), b.times.begin(), b.times.end(), std::back_inserter(times));
  thin(times);
  out.times.clear();
  out.matrices.clear();
  for (size_t k = 0; k < times.size(); ++k) {
    out.times.push_back(times[k]);
    out.matrices.push_back(a.at(times[k]) * b.at(times[k]));
    if (k + 1 == times.size()) break;
    // Between two keys the product is quadratic in time; a straight line misses it by |dA dB| / 4 at most. Keys are
    // added until that is 1e-4 of the matrix, the error that Transform promises.
    const Matrix dA = a.at(times[k + 1]) - a.at(times[k]), dB = b.at(times[k + 1]) - b.at(times[k]);
    const double miss = largestEntry(dA * dB) / 4,
                 allowed = 1e-4 * std::max(largestEntry(out.matrices.back()), 1e-300);
    const double most = std::min(64.0, double(Transform::kMostKeys) / double(times.size()));
    const double wanted = std::ceil(std::sqrt(miss / allowed));
    const int pieces = wanted > 1 ? int(std::min(wanted, most)) : 1;
    for (int i = 1; i < pieces; ++i) {
      const double t = times[k] + (times[k + 1] - times[k]) * i / pieces;
      if (!(t > out.times.back()) || !(t < times[k + 1])) continue;
      out.times.push_back(t);
      out.matrices.push_back(a.at(t) * b.at(t));
    }
  }
  return out;
}

}  // namespace kinora::scene
