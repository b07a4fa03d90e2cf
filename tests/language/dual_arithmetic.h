// Arithmetic of the interpreter's numbers: a float and its derivatives along x and y.
#pragma once
#include <algorithm>
#include <cmath>

#include "language/interpreter.h"

namespace kinora::oracle {

inline double rounded(double v) { return double(float(v)); }
inline Dual operator-(Dual a) { return {-a.v, -a.dx, -a.dy}; }
inline Dual operator+(Dual a, Dual b) { return {rounded(a.v + b.v), a.dx + b.dx, a.dy + b.dy}; }
inline Dual operator-(Dual a, Dual b) { return {rounded(a.v - b.v), a.dx - b.dx, a.dy - b.dy}; }
inline Dual operator*(Dual a, Dual b) {
  return {rounded(a.v * b.v), a.dx * b.v + a.v * b.dx, a.dy * b.v + a.v * b.dy};
}
// What is not finite is 0 (reference: osl-numerics, section 8 and 10).
inline Dual operator/(Dual a, Dual b) {
  const double q = rounded(a.v / b.v), inverse = rounded(1 / b.v);
  const double v = std::isfinite(q) ? q : 0, r = std::isfinite(inverse) ? inverse : 0;
  return {v, (a.dx - v * b.dx) * r, (a.dy - v * b.dy) * r};
}
inline Dual plain(double v) { return {rounded(v), 0, 0}; }
// f(x) with its derivative there.
inline Dual chained(Dual x, double f, double derivative) {
  return {rounded(f), derivative * x.dx, derivative * x.dy};
}
inline Dual rootOf(Dual x) { return x.v > 0 ? chained(x, std::sqrt(x.v), 0.5 / std::sqrt(x.v)) : Dual(); }
inline Dual minOf(Dual a, Dual b) { return a.v <= b.v ? a : b; }
inline Dual maxOf(Dual a, Dual b) { return a.v > b.v ? a : b; }

}  // namespace kinora::oracle
