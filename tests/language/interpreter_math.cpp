// Functions of numbers, vectors, matrices and strings. Formulas: reference osl-numerics, sections 8 to 10.
#include <cmath>
#include <cstdio>

#include "language/dual_arithmetic.h"

namespace kinora::oracle {

using namespace language;

namespace {

constexpr double kLargest = 3.40282346638528860e+38;

Dual power(Dual x, Dual y) {
  double v;
  if (y.v == 0)
    v = 1;
  else if (x.v == 0)
    v = 0;
  else if (x.v < 0 && std::floor(y.v) != y.v)
    v = 0;
  else if (v = std::pow(x.v, y.v); y.v != 1 && y.v != 2 && std::fabs(v) < 0x1p-126)
    v = std::copysign(0x1p-126, v);  // exp2() takes no less than -126
  if (!(std::fabs(v) <= double(kLargest))) v = v < 0 ? -kLargest : kLargest;
  const double byX = x.v == 0 || (x.v < 0 && std::floor(y.v) != y.v) ? 0 : y.v * std::pow(x.v, y.v - 1);
  const double byY = x.v > 0 ? std::log(x.v) * v : 0;
  return {rounded(v), byX * x.dx + byY * y.dx, byX * x.dy + byY * y.dy};
}

Dual unary(Opcode op, Dual x) {
  constexpr double kPi = 3.14159265358979323846, kLeast = 1.17549435082228751e-38;
  const double v = x.v, positive = std::max(v, kLeast);
  const bool isInside = v >= kLeast;
  switch (op) {
    case Opcode::Sin:
      return chained(x, std::sin(v), std::cos(v));
    case Opcode::Cos:
      return chained(x, std::cos(v), -std::sin(v));
    case Opcode::Tan:
      return chained(x, std::tan(v), 1 / (std::cos(v) * std::cos(v)));
    case Opcode::Asin:
      return chained(x, std::asin(std::clamp(v, -1.0, 1.0)), std::fabs(v) < 1 ? 1 / std::sqrt(1 - v * v) : 0);
    case Opcode::Acos:
      return chained(x, std::acos(std::clamp(v, -1.0, 1.0)), std::fabs(v) < 1 ? -1 / std::sqrt(1 - v * v) : 0);
    case Opcode::Atan:
      return chained(x, std::atan(v), 1 / (1 + v * v));
    case Opcode::Sinh:
      return chained(x, std::sinh(v), std::cosh(v));
    case Opcode::Cosh:
      return chained(x, std::cosh(v), std::sinh(v));
    case Opcode::Tanh:
      return chained(x, std::tanh(v), 1 - std::tanh(v) * std::tanh(v));
    case Opcode::Radians:
      return chained(x, v * kPi / 180, kPi / 180);
    case Opcode::Degrees:
      return chained(x, v * 180 / kPi, 180 / kPi);
    case Opcode::Exp:
      return chained(x, std::exp(std::clamp(v, -87.0, 87.0)), std::exp(std::clamp(v, -87.0, 87.0)));
    case Opcode::Exp2:
      return chained(x, std::exp2(std::clamp(v, -126.0, 126.0)),
                     std::log(2.0) * std::exp2(std::clamp(v, -126.0, 126.0)));
    case Opcode::Expm1:
      return chained(x, std::expm1(std::min(v, 87.0)), std::exp(std::min(v, 87.0)));
    case Opcode::Log:
      return chained(x, std::log(positive), isInside ? 1 / v : 0);
    case Opcode::Log2:
      return chained(x, std::log2(positive), isInside ? 1 / (v * std::log(2.0)) : 0);
    case Opcode::Log10:
      return chained(x, std::log10(positive), isInside ? 1 / (v * std::log(10.0)) : 0);
    case Opcode::Logb:
      return plain(std::logb(std::max(std::fabs(v), kLeast)));
    case Opcode::Sqrt:
      return rootOf(x);
    case Opcode::InverseSqrt:
      return v > 0 ? chained(x, 1 / std::sqrt(v), -0.5 / (v * std::sqrt(v))) : Dual();
    case Opcode::Cbrt:
      return chained(x, std::cbrt(v), v != 0 ? 1 / (3 * std::cbrt(v) * std::cbrt(v)) : 0);
    case Opcode::Abs:
    case Opcode::Fabs:
      return v >= 0 ? x : -x;
    case Opcode::Sign:
      return plain(v < 0 ? -1 : v > 0);
    case Opcode::Floor:
      return plain(std::floor(v));
    case Opcode::Ceil:
      return plain(std::ceil(v));
    case Opcode::Round:
      return plain(std::round(v));
    case Opcode::Trunc:
      return plain(std::trunc(v));
    case Opcode::Erf:
      return chained(x, std::erf(v), 2 / std::sqrt(kPi) * std::exp(-v * v));
    case Opcode::Erfc:
      return chained(x, std::erfc(v), -2 / std::sqrt(kPi) * std::exp(-v * v));
    default:
      return {NAN, 0, 0};
  }
}

Dual smoothed(Dual e0, Dual e1, Dual x) {
  if (x.v < e0.v) return {};
  if (x.v >= e1.v) return plain(1);
  const Dual t = (x - e0) / (e1 - e0);
  return (plain(3) - plain(2) * t) * (t * t);
}

Dual linear(Dual e0, Dual e1, Dual x) {
  if (e0.v == e1.v) return plain(x.v < e0.v ? 0 : 1);
  return maxOf(minOf((x - e0) / (e1 - e0), plain(1)), plain(0));
}

Dual smoothLinear(Dual e0, Dual e1, Dual x, Dual eps) {
  if (e0.v == e1.v) return plain(x.v < e0.v ? 0 : 1);
  const Dual w = plain(1) / (e1 - e0), e = eps * w, at = (x - e0) * w;
  const auto ramp = [&](Dual q) { return q * q * plain(0.5) / (plain(2) * e); };
  if (at.v <= -e.v) return {};
  if (at.v >= e.v && at.v <= 1 - e.v) return at;
  if (at.v >= 1 + e.v) return plain(1);
  return at.v < e.v ? ramp(at + e) : plain(1) - ramp(plain(1) + e - at);
}

Dual dotOf(const std::vector<Dual>& a, const std::vector<Dual>& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
std::vector<Dual> crossOf(const std::vector<Dual>& a, const std::vector<Dual>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
std::vector<Dual> unitOf(const std::vector<Dual>& a) {
  const Dual length = rootOf(dotOf(a, a));
  if (!(length.v > 0)) return std::vector<Dual>(3);
  const Dual s = plain(1) / length;
  return {a[0] * s, a[1] * s, a[2] * s};
}

using Matrix = std::vector<double>;  // 16, by rows
Matrix times(const Matrix& a, const Matrix& b) {
  Matrix m(16);
  for (size_t r = 0; r < 4; ++r)
    for (size_t c = 0; c < 4; ++c)
      for (size_t k = 0; k < 4; ++k) m[4 * r + c] += a[4 * r + k] * b[4 * k + c];
  return m;
}
double determinantOf(Matrix m) {
  double d = 1;
  for (size_t c = 0; c < 4; ++c) {
    size_t p = c;
    for (size_t r = c; r < 4; ++r)
      if (std::fabs(m[4 * r + c]) > std::fabs(m[4 * p + c])) p = r;
    if (m[4 * p + c] == 0) return 0;
    if (p != c) d = -d;
    for (size_t k = 0; k < 4; ++k) std::swap(m[4 * p + k], m[4 * c + k]);
    d *= m[5 * c];
    for (size_t r = c + 1; r < 4; ++r) {
      const double f = m[4 * r + c] / m[5 * c];
      for (size_t k = c; k < 4; ++k) m[4 * r + k] -= f * m[4 * c + k];
    }
  }
  return d;
}
Matrix identity() {
  Matrix m(16);
  for (size_t i = 0; i < 16; i += 5) m[i] = 1;
  return m;
}
// Singular: the identity.
Matrix inverseOf(Matrix m) {
  Matrix inverse = identity();
  for (size_t c = 0; c < 4; ++c) {
    size_t p = c;
    for (size_t r = c; r < 4; ++r)
      if (std::fabs(m[4 * r + c]) > std::fabs(m[4 * p + c])) p = r;
    if (m[4 * p + c] == 0) return identity();
    for (size_t k = 0; k < 4; ++k) {
      std::swap(m[4 * p + k], m[4 * c + k]);
      std::swap(inverse[4 * p + k], inverse[4 * c + k]);
    }
    const double s = 1 / m[5 * c];
    for (size_t k = 0; k < 4; ++k) m[4 * c + k] *= s, inverse[4 * c + k] *= s;
    for (size_t r = 0; r < 4; ++r) {
      const double f = r == c ? 0 : m[4 * r + c];
      for (size_t k = 0; k < 4; ++k) m[4 * r + k] -= f * m[4 * c + k], inverse[4 * r + k] -= f * inverse[4 * c + k];
    }
  }
  return inverse;
}

}  // namespace

bool Interpreter::math(const Instruction& i) {
  const size_t count = i.arguments.size();
  const bool isInt = count > 0 && type(0).base == Base::Int;
  const auto each = [&](auto f) {
    const size_t n = components(0);
    std::vector<Dual> r(n);
    for (size_t k = 0; k < n; ++k) {
      r[k] = f(k);
      r[k].v = rounded(r[k].v * (1 + disturbance));
    }
    for (size_t k = 0; k < n; ++k) set(0, k, r[k]);
    return true;
  };
  switch (i.opcode) {
    case Opcode::SinCos:
      for (size_t k = 0, n = components(0); k < n; ++k) {
        const Dual x = number(0, k);
        set(1, k, unary(Opcode::Sin, x));
        set(2, k, unary(Opcode::Cos, x));
      }
      return true;
    case Opcode::Pow:
      return each([&](size_t k) { return power(number(1, k), number(2, k)); });
    case Opcode::Log:
      if (count == 3)
        return each([&](size_t k) { return unary(Opcode::Log, number(1, k)) / unary(Opcode::Log, number(2, k)); });
      break;
    case Opcode::Atan2:
      return each([&](size_t k) {
        const Dual y = number(1, k), x = number(2, k);
        const double d = x.v * x.v + y.v * y.v, r = d > 0 ? 1 / d : 0;
        return Dual{rounded(std::atan2(y.v, x.v)), (y.v * x.dx - x.v * y.dx) * r, (y.v * x.dy - x.v * y.dy) * r};
      });
    case Opcode::Fmod:
      return each([&](size_t k) {
        const Dual a = number(1, k), b = number(2, k);
        // by the formula of osl-numerics, section 8, each step rounded: not the remainder of exact numbers
        const double whole = std::trunc(rounded(a.v / b.v));
        return b.v == 0 ? Dual() : Dual{rounded(a.v - rounded(whole * b.v)), a.dx, a.dy};
      });
    case Opcode::FloorMod:
      if (isInt) {
        const int32_t a = integer(1), b = integer(2);
        cells(0).ints[0] = b == 0 ? a : b == -1 ? 0 : a % b;
        return true;
      }
      return each([&](size_t k) {
        const Dual a = number(1, k), b = number(2, k);
        if (b.v == 0) return a;
        const double f = std::floor(rounded(a.v / b.v));
        return a - b * plain(f);
      });
    case Opcode::Step:
      return each([&](size_t k) { return plain(number(2, k).v < number(1, k).v ? 0 : 1); });
    case Opcode::Abs:
    case Opcode::Fabs:
      if (isInt) {
        cells(0).ints[0] = integer(1) < 0 ? int32_t(0 - uint32_t(integer(1))) : integer(1);
        return true;
      }
      break;
    case Opcode::Min:
    case Opcode::Max:
      if (isInt) {
        cells(0).ints[0] =
            i.opcode == Opcode::Min ? std::min(integer(1), integer(2)) : std::max(integer(1), integer(2));
        return true;
      }
      return each([&](size_t k) {
        return i.opcode == Opcode::Min ? minOf(number(1, k), number(2, k)) : maxOf(number(1, k), number(2, k));
      });
    case Opcode::Clamp:
      if (isInt) {
        cells(0).ints[0] = std::max(std::min(integer(1), integer(3)), integer(2));
        return true;
      }
      return each([&](size_t k) { return maxOf(minOf(number(1, k), number(3, k)), number(2, k)); });
    case Opcode::Mix:
      return each([&](size_t k) { return number(1, k) * (plain(1) - number(3, k)) + number(2, k) * number(3, k); });
    case Opcode::Select:
      return each([&](size_t k) { return number(3, k).v != 0 ? number(2, k) : number(1, k); });
    case Opcode::SmoothStep:
      return each([&](size_t k) { return smoothed(number(1, k), number(2, k), number(3, k)); });
    case Opcode::LinearStep:
      return each([&](size_t k) { return linear(number(1, k), number(2, k), number(3, k)); });
    case Opcode::SmoothLinearStep:
      return each([&](size_t k) { return smoothLinear(number(1, k), number(2, k), number(3, k), number(4, k)); });
    case Opcode::IsNan:
      cells(0).ints[0] = std::isnan(number(1).v);
      return true;
    case Opcode::IsInf:
      cells(0).ints[0] = std::isinf(number(1).v);
      return true;
    case Opcode::IsFinite:
      cells(0).ints[0] = std::isfinite(number(1).v);
      return true;
    default:
      break;
  }
  if (i.opcode < Opcode::Cos || i.opcode > Opcode::Erfc || count != 2 || std::isnan(unary(i.opcode, plain(0.5)).v))
    return false;
  return each([&](size_t k) { return unary(i.opcode, number(1, k)); });
}

bool Interpreter::geometry(const Instruction& i) {
  const auto give = [&](const std::vector<Dual>& r) {
    for (size_t k = 0; k < r.size(); ++k) {
      Dual d = r[k];
      d.v = rounded(d.v * (1 + disturbance));
      set(0, k, d);
    }
    return true;
  };
  const auto matrix = [&](size_t a) {
    Matrix m(16);
    for (size_t k = 0; k < 16; ++k) m[k] = components(a) == 16 ? cells(a).numbers[k].v : k % 5 == 0 ? number(a).v : 0;
    return m;
  };
  const auto giveMatrix = [&](const Matrix& m) {
    std::vector<Dual> r;
    for (const double v : m) r.push_back(plain(v));
    return give(r);
  };
  const auto minus = [](const std::vector<Dual>& a, const std::vector<Dual>& b) {
    return std::vector<Dual>{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  };
  const auto scaled = [](const std::vector<Dual>& a, Dual s) {
    return std::vector<Dual>{a[0] * s, a[1] * s, a[2] * s};
  };
  switch (i.opcode) {
    case Opcode::Mul:
      return giveMatrix(times(matrix(1), matrix(2)));
    case Opcode::Div:
      return giveMatrix(times(
          matrix(1), components(2) == 16 ? inverseOf(matrix(2)) : [&] {
            Matrix m = identity();
            for (size_t k = 0; k < 16; k += 5) m[k] = (plain(1) / number(2)).v;
            return m;
          }()));
    case Opcode::Dot:
      return give({dotOf(vector(1), vector(2))});
    case Opcode::Cross:
      return give(crossOf(vector(1), vector(2)));
    case Opcode::Length:
      return give({rootOf(dotOf(vector(1), vector(1)))});
    case Opcode::Distance: {
      const std::vector<Dual> d = minus(vector(1), vector(2));
      return give({rootOf(dotOf(d, d))});
    }
    case Opcode::Normalize:
      return give(unitOf(vector(1)));
    case Opcode::FaceForward:
      return give(dotOf(vector(2), vector(3)).v > 0 ? scaled(vector(1), plain(-1)) : vector(1));
    case Opcode::Reflect: {
      const std::vector<Dual> in = vector(1), n = vector(2);
      return give(minus(in, scaled(n, plain(2) * dotOf(n, in))));
    }
    case Opcode::Refract: {
      const std::vector<Dual> in = vector(1), n = vector(2);
      const Dual eta = number(3), c = dotOf(in, n), k = plain(1) - eta * eta * (plain(1) - c * c);
      if (k.v < 0) return give(std::vector<Dual>(3));
      return give(minus(scaled(in, eta), scaled(n, eta * c + rootOf(k))));
    }
    case Opcode::Rotate: {  // Rodrigues' formula
      const std::vector<Dual> p = vector(1), a = unitOf(vector(3)), x = crossOf(a, p);
      const Dual c = unary(Opcode::Cos, number(2)), s = unary(Opcode::Sin, number(2)),
                 along = dotOf(a, p) * (plain(1) - c);
      std::vector<Dual> r(3);
      for (size_t k = 0; k < 3; ++k) r[k] = p[k] * c + x[k] * s + a[k] * along;
      return give(r);
    }
    case Opcode::Determinant:
      return give({plain(determinantOf(matrix(1)))});
    case Opcode::Transpose: {
      const Matrix m = matrix(1);
      Matrix t(16);
      for (size_t k = 0; k < 16; ++k) t[k] = m[4 * (k % 4) + k / 4];
      return giveMatrix(t);
    }
    case Opcode::TransformPoint:
    case Opcode::TransformVector:
    case Opcode::TransformNormal: {
      if (i.arguments.size() != 3 || type(1).base != Base::Matrix) return false;
      Matrix m = matrix(1);
      if (i.opcode == Opcode::TransformNormal) {
        const Matrix inverse = inverseOf(m);
        for (size_t k = 0; k < 16; ++k) m[k] = inverse[4 * (k % 4) + k / 4];
      }
      const std::vector<Dual> p = vector(2);
      std::vector<Dual> r(3);
      Dual w = plain(m[15]);
      for (size_t c = 0; c < 3; ++c) {
        if (i.opcode == Opcode::TransformPoint) r[c] = plain(m[12 + c]), w = w + p[c] * plain(m[4 * c + 3]);
        for (size_t k = 0; k < 3; ++k) r[c] = r[c] + p[k] * plain(m[4 * k + c]);
      }
      if (i.opcode == Opcode::TransformPoint)
        for (Dual& d : r) d = w.v == 0 ? Dual() : d / w;
      return give(r);
    }
    case Opcode::Luminance:
      return give(
          {number(1, 0) * plain(0.2125072) + number(1, 1) * plain(0.7153502) + number(1, 2) * plain(0.0721426)});
    case Opcode::DerivX:
    case Opcode::DerivY:
    case Opcode::DerivZ: {
      std::vector<Dual> r(components(0));
      for (size_t k = 0; k < r.size(); ++k) {
        const Dual d = number(1, k);
        r[k] = plain(i.opcode == Opcode::DerivX ? d.dx : i.opcode == Opcode::DerivY ? d.dy : 0);
      }
      return give(r);
    }
    case Opcode::FilterWidth: {
      std::vector<Dual> r(components(0));
      for (size_t k = 0; k < r.size(); ++k) r[k] = plain(std::hypot(number(1, k).dx, number(1, k).dy));
      return give(r);
    }
    case Opcode::Area:
    case Opcode::CalculateNormal: {
      std::vector<Dual> x(3), y(3);
      for (size_t k = 0; k < 3; ++k) x[k] = plain(number(1, k).dx), y[k] = plain(number(1, k).dy);
      const std::vector<Dual> n = crossOf(x, y);
      return give(i.opcode == Opcode::Area ? std::vector<Dual>{rootOf(dotOf(n, n))} : n);
    }
    default:
      return false;
  }
}

// Conversions of C's printf, one element after the other with a space between (reference: section 9). Widths and
// flags other than precision are not interpreted.
std::string Interpreter::formatted(size_t first) {
  const std::string f = text(first);
  std::string out;
  size_t next = first + 1;
  for (size_t i = 0; i < f.size(); ++i) {
    if (f[i] != '%') {
      out += f[i];
      continue;
    }
    if (f[i + 1] == '%') {
      out += f[++i];
      continue;
    }
    const size_t end = f.find_first_of("cdefgimnopsuvxX", i);
    std::string how = f.substr(i, end + 1 - i);
    i = end;
    const Cells& c = cells(next);
    std::vector<std::string> items = c.strings;
    char buffer[256];
    for (const int32_t v : c.ints) {
      std::snprintf(buffer, sizeof buffer, how.c_str(), v);
      items.emplace_back(buffer);
    }
    if (std::string("cmnpv").find(how.back()) != std::string::npos) how.back() = 'f';
    if (componentsOf(type(next).base) && c.ints.empty() && c.strings.empty())
      for (const Dual& d : c.numbers) {
        std::snprintf(buffer, sizeof buffer, how.c_str(), d.v);
        items.emplace_back(buffer);
      }
    for (size_t k = 0; k < items.size(); ++k) out += (k ? " " : "") + items[k];
    ++next;
  }
  return out;
}

bool Interpreter::strings(const Instruction& i) {
  const auto starts = [](const std::string& s, const std::string& with) {
    return s.compare(0, with.size(), with) == 0;
  };
  switch (i.opcode) {
    case Opcode::Printf:
      printed_ += formatted(0);
      return true;
    case Opcode::Format: {
      const std::string s = formatted(1);
      cells(0).strings[0] = s;
      return true;
    }
    case Opcode::Concat: {
      std::string s;
      for (size_t a = 1; a < i.arguments.size(); ++a) s += text(a);
      cells(0).strings[0] = s;
      return true;
    }
    case Opcode::Strlen:
      cells(0).ints[0] = int32_t(text(1).size());
      return true;
    case Opcode::GetChar: {
      const int32_t at = integer(2);
      const std::string& s = text(1);
      cells(0).ints[0] = at >= 0 && size_t(at) < s.size() ? int32_t(static_cast<unsigned char>(s[size_t(at)])) : 0;
      return true;
    }
    case Opcode::StartsWith:
      cells(0).ints[0] = starts(text(1), text(2));
      return true;
    case Opcode::EndsWith: {
      const std::string &s = text(1), &with = text(2);
      cells(0).ints[0] = with.size() <= s.size() && s.compare(s.size() - with.size(), with.size(), with) == 0;
      return true;
    }
    case Opcode::Substr: {
      const std::string s = text(1);
      const auto n = int64_t(s.size());
      int64_t from = integer(2);
      if (from < 0) from += n;
      from = std::clamp<int64_t>(from, 0, n);
      cells(0).strings[0] = s.substr(size_t(from), size_t(std::clamp<int64_t>(integer(3), 0, n)));
      return true;
    }
    case Opcode::StoI: {
      const std::string s = text(1);
      size_t at = s.find_first_not_of(" \t\n\r\v\f");
      bool isNegative = false;
      int64_t v = 0;
      if (at != std::string::npos && (s[at] == '-' || s[at] == '+')) isNegative = s[at++] == '-';
      for (; at < s.size() && s[at] >= '0' && s[at] <= '9' && v < (int64_t(1) << 33); ++at)
        v = 10 * v + (s[at] - '0');
      cells(0).ints[0] = int32_t(std::clamp<int64_t>(isNegative ? -v : v, INT32_MIN, INT32_MAX));
      return true;
    }
    case Opcode::StoF:
      set(0, 0, plain(std::strtof(text(1).c_str(), nullptr)));
      return true;
    default:
      return false;
  }
}

}  // namespace kinora::oracle
