#include "geometry/axis.h"

#include <algorithm>
#include <cmath>

namespace kinora::geometry {

std::string Axis::linear(int controls, bool periodic, Axis& out) {
  if (controls < 2) return std::to_string(controls) + " points in one direction";
  out.controls_ = controls;
  out.periodic_ = periodic;
  out.order_ = 2;
  out.cells_ = periodic ? controls : controls - 1;
  for (int i = 0; i < out.cells_; ++i)
    out.spans_.push_back({i, i, 0, 1, double(i) / out.cells_, (i + 1.0) / out.cells_});
  return {};
}

std::string Axis::cubic(int controls, bool periodic, const std::array<float, 16>& basis, int step, Axis& out) {
  if (step < 1) return "a basis step of " + std::to_string(step);
  if (controls < (periodic ? 3 : 4)) return std::to_string(controls) + " points in one direction";
  if (periodic ? controls % step : (controls - 4) % step)
    return std::to_string(controls) + " points in one direction with a basis step of " + std::to_string(step);
  for (float b : basis)
    if (!std::isfinite(b)) return "a basis that is not finite";
  out.controls_ = controls;
  out.periodic_ = periodic;
  out.order_ = 4;
  out.cells_ = periodic ? controls / step : (controls - 4) / step + 1;
  std::copy(basis.begin(), basis.end(), out.basis_.begin());
  for (int i = 0; i < out.cells_; ++i)
    out.spans_.push_back({i * step, i, 0, 1, double(i) / out.cells_, (i + 1.0) / out.cells_});
  double begin[4], end[4], unused[4];
  out.weights(out.spans_[0], 0, begin, unused);
  out.weights(out.spans_[0], 1, end, unused);
  for (int k = 0; k < 4 + step; ++k) {
    const double here = k < 4 ? end[k] : 0, next = k >= step ? begin[k - step] : 0;
    out.meets_ &= std::abs(here - next) <= 1e-6;
  }
  return {};
}

std::string Axis::nurbs(int controls, int order, const std::vector<float>& knots, double low, double high,
                        Axis& out) {
  if (order < 2 || order > 64 || controls < order)
    return "order " + std::to_string(order) + " with " + std::to_string(controls) + " points";
  if (knots.size() < size_t(controls) + size_t(order))
    return std::to_string(knots.size()) + " knots where " + std::to_string(controls + order) + " belong";
  for (size_t i = 0; i < size_t(controls + order); ++i)
    if (!std::isfinite(knots[i]) || (i > 0 && knots[i] < knots[i - 1])) return "knots that do not increase";
  out.controls_ = controls;
  out.order_ = order;
  out.cells_ = controls - order + 1;
  out.knots_.assign(knots.begin(), knots.begin() + controls + order);
  low = std::max(low, out.knots_[order - 1]);
  high = std::min(high, out.knots_[controls]);
  if (!(low < high)) return "an empty parameter range";
  for (int i = 0; i < out.cells_; ++i) {
    const double a = out.knots_[i + order - 1], b = out.knots_[i + order];
    const double from = std::max(a, low), to = std::min(b, high);
    if (!(from < to)) continue;
    out.spans_.push_back({i, i, (from - a) / (b - a), (to - a) / (b - a), (from - low) / (high - low),
                          (to - low) / (high - low), from, to});
  }
  return {};
}

void Axis::weights(const Span& span, double s, double* w, double* dw) const {
  if (!knots_.empty()) {
    // Cox-de Boor upwards from order 1; the weights of order - 1 give the derivative.
    const double t = s == 1 ? span.knot1 : span.knot0 + (span.knot1 - span.knot0) * s;
    const int last = span.first + order_ - 1;  // knot interval [last, last + 1)
    double n[65] = {1};
    for (int p = 1; p < order_; ++p) {
      if (p == order_ - 1) {
        for (int k = 0; k <= p; ++k) {
          const int i = last - p + k;
          const double left = k > 0 ? n[k - 1] / (knots_[i + p] - knots_[i]) : 0;
          const double right = k < p ? n[k] / (knots_[i + p + 1] - knots_[i + 1]) : 0;
          dw[k] = p * (left - right) * (span.knot1 - span.knot0);
        }
      }
      double carried = 0;
      for (int k = 0; k < p; ++k) {
        const double a = knots_[last - p + 1 + k], b = knots_[last + 1 + k];
        const double share = n[k] / (b - a);
        n[k] = carried + (b - t) * share;
        carried = (t - a) * share;
      }
      n[p] = carried;
    }
    std::copy_n(n, order_, w);
    return;
  }
  if (order_ == 2) {
    w[0] = 1 - s, w[1] = s;
    dw[0] = -1, dw[1] = 1;
    return;
  }
  for (int k = 0; k < 4; ++k) {
    const double a = basis_[k], b = basis_[4 + k], c = basis_[8 + k], d = basis_[12 + k];
    w[k] = ((a * s + b) * s + c) * s + d;
    dw[k] = (3 * a * s + 2 * b) * s + c;
  }
}

}  // namespace kinora::geometry
