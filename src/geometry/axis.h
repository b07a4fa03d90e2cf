// One direction of a tensor-product surface: how its pieces follow from control points. Used by the patch maker; it
// knows neither points nor the other direction.
#pragma once
#include <array>
#include <string>
#include <vector>

namespace kinora::geometry {

class Axis {
 public:
  // A piece between two parameters; s runs from 0 to 1 over it.
  struct Span {
    int first = 0;                // control point of the first weight
    int cell = 0;                 // piece as counted for uniform and varying primvars
    double cell0 = 0, cell1 = 1;  // part of that piece which is covered
    double u0 = 0, u1 = 1;        // parameter over the whole surface, 0..1
    double knot0 = 0, knot1 = 1;  // NURBS only
  };
  // Each returns what is wrong, or an empty string.
  static std::string linear(int controls, bool periodic, Axis& out);
  // `basis` row-major for [s^3 s^2 s 1] B P.
  static std::string cubic(int controls, bool periodic, const std::array<float, 16>& basis, int step, Axis& out);
  static std::string nurbs(int controls, int order, const std::vector<float>& knots, double low, double high,
                           Axis& out);

  const std::vector<Span>& spans() const { return spans_; }
  int order() const { return order_; }  // weights of a span
  int controls() const { return controls_; }
  int cells() const { return cells_; }  // pieces as counted for uniform primvars
  int varyings() const { return periodic_ ? cells_ : cells_ + 1; }
  bool periodic() const { return periodic_; }
  bool meets() const { return meets_; }  // each piece ends where the next begins, whatever the control points are
  int control(const Span& span, int k) const { return (span.first + k) % controls_; }
  int varying(int cell, int end) const { return (cell + end) % varyings(); }
  // Weights and their derivatives with respect to s; `order()` of each.
  void weights(const Span& span, double s, double* w, double* dw) const;

 private:
  int controls_ = 0, order_ = 2, cells_ = 0;
  bool periodic_ = false, meets_ = true;
  std::vector<Span> spans_;
  std::array<double, 16> basis_{};
  std::vector<double> knots_;  // empty: polynomial with basis_ (order 4) or linear (order 2)
};

}  // namespace kinora::geometry
