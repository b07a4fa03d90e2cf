// Hashes, noises and splines. Formulas: reference osl-numerics, sections 1 to 4 and 6.
#include <cmath>
#include <cstring>

#include "language/dual_arithmetic.h"

namespace kinora::oracle {

using namespace language;

namespace {

uint32_t turned(uint32_t x, int k) { return x << k | x >> (32 - k); }
uint32_t bitsOf(double v) {
  const auto f = float(v);
  uint32_t u;
  std::memcpy(&u, &f, 4);
  return u;
}
double unit(uint32_t h) { return double(float(h) * 2.3283064365386963e-10f); }  // 2^-32
uint32_t cell(double v) { return uint32_t(int32_t(std::floor(v))); }

// The dot product of the gradient that a hash chooses with an offset.
Dual gradient(uint32_t h, const std::vector<Dual>& d) {
  const auto sign = [h](Dual x, int bit) { return h >> bit & 1 ? -x : x; };
  switch (d.size()) {
    case 1:
      return sign(plain(1 + (h & 7)) * d[0], 3);
    case 2:
      return sign((h & 7) < 4 ? d[0] : d[1], 0) + sign(plain(2) * ((h & 7) < 4 ? d[1] : d[0]), 1);
    case 3: {
      const uint32_t k = h & 15;
      return sign(k < 8 ? d[0] : d[1], 0) + sign(k < 4 ? d[1] : k == 12 || k == 14 ? d[0] : d[2], 1);
    }
    default: {
      const uint32_t k = h & 31;
      return sign(k < 24 ? d[0] : d[1], 0) + sign(k < 16 ? d[1] : d[2], 1) + sign(k < 8 ? d[2] : d[3], 2);
    }
  }
}

}  // namespace

uint32_t hashOf(const std::vector<uint32_t>& words) {
  uint32_t s[3];
  for (uint32_t& x : s) x = 0xdeadbeef + 4 * uint32_t(words.size()) + 13;
  size_t at = 0;
  for (; words.size() - at > 3; at += 3) {
    for (size_t k = 0; k < 3; ++k) s[k] += words[at + k];
    static constexpr int kMix[6] = {4, 6, 8, 16, 19, 4};
    for (size_t i = 0; i < 6; ++i) {
      uint32_t &x = s[i % 3], &y = s[(i + 1) % 3], &z = s[(i + 2) % 3];
      x -= z;
      x ^= turned(z, kMix[i]);
      z += y;
    }
  }
  for (size_t k = 0; at < words.size(); ++at, ++k) s[k] += words[at];
  static constexpr int kFinal[7][3] = {{2, 1, 14}, {0, 2, 11}, {1, 0, 25}, {2, 1, 16},
                                       {0, 2, 4},  {1, 0, 14}, {2, 1, 24}};
  for (const auto& f : kFinal) {
    s[f[0]] ^= s[f[1]];
    s[f[0]] -= turned(s[f[1]], f[2]);
  }
  return s[2];
}

std::vector<Dual> perlin(const std::vector<Dual>& at, size_t components) {
  static constexpr double kScale[4] = {0.2500, 0.6616, 0.9820, 0.8344};
  const size_t n = at.size();
  std::vector<Dual> f(n), fade(n);
  for (size_t k = 0; k < n; ++k) {
    f[k] = at[k] - plain(std::floor(at[k].v));
    fade[k] = f[k] * f[k] * f[k] * (f[k] * (f[k] * plain(6) - plain(15)) + plain(10));
  }
  std::vector<Dual> out(components);
  for (size_t c = 0; c < components; ++c) {
    std::vector<Dual> corners(size_t(1) << n);
    for (size_t corner = 0; corner < corners.size(); ++corner) {
      std::vector<uint32_t> words(n);
      std::vector<Dual> d(n);
      for (size_t k = 0; k < n; ++k) {
        const uint32_t bit = corner >> k & 1;
        words[k] = cell(at[k].v) + bit;
        d[k] = f[k] - plain(bit);
      }
      const uint32_t h = hashOf(words);
      corners[corner] = gradient(components == 1 ? h : h >> (8 * c) & 255, d);
    }
    for (size_t k = 0; k < n; ++k) {  // one axis after the other
      const size_t half = corners.size() / 2;
      std::vector<Dual> next(half);
      for (size_t j = 0; j < half; ++j)
        next[j] = corners[2 * j] * (plain(1) - fade[k]) + corners[2 * j + 1] * fade[k];
      corners = next;
    }
    out[c] = corners[0] * plain(kScale[n - 1]);
  }
  return out;
}

bool Interpreter::patterns(const Instruction& i) {
  size_t first = 1;
  static const std::map<Opcode, std::string> kNames = {{Opcode::Noise, "noise"},    {Opcode::SNoise, "snoise"},
                                                       {Opcode::CellNoise, "cell"}, {Opcode::HashNoise, "hash"},
                                                       {Opcode::Hash, "int"},       {Opcode::Spline, "spline"}};
  const auto named = kNames.find(i.opcode);
  if (named == kNames.end()) return false;
  std::string name = named->second;
  if (i.opcode == Opcode::Noise && type(1).base == Base::String) {
    name = text(1);
    first = 2;
  }
  if (name == "spline") {
    const std::string basis = text(1);
    const size_t step = basis == "bezier" ? 3 : basis == "hermite" ? 2 : 1;
    const size_t n = components(0), given = i.arguments.size();
    std::vector<std::vector<Dual>> knots;
    const bool hasCount = given == 5 && type(4).arrayLength != 0;
    if (type(given - 1).arrayLength != 0) {
      const Cells& c = cells(given - 1);
      const size_t count =
          hasCount ? std::min(size_t(std::max(integer(3), 0)), c.numbers.size() / n) : c.numbers.size() / n;
      for (size_t k = 0; k < count; ++k)
        knots.emplace_back(c.numbers.begin() + long(k * n), c.numbers.begin() + long(k * n + n));
    } else {
      for (size_t a = 3; a < given; ++a) {
        knots.emplace_back();
        for (size_t k = 0; k < n; ++k) knots.back().push_back(number(a, k));
      }
    }
    if (knots.size() < 4) return false;
    Dual x = number(2);
    if (x.v <= 0) x = plain(0);
    if (x.v >= 1) x = plain(1);
    const size_t segments = (knots.size() - 4) / step + 1;
    const Dual y = x * plain(double(segments));
    const size_t at = std::min(size_t(y.v), segments - 1);
    const Dual t = y - plain(double(at));
    static constexpr double kCatmull[16] = {-.5, 1.5, -1.5, .5, 1, -2.5, 2, -.5, -.5, 0, .5, 0, 0, 1, 0, 0};
    static constexpr double kBezier[16] = {-1, 3, -3, 1, 3, -6, 3, 0, -3, 3, 0, 0, 1, 0, 0, 0};
    static constexpr double kBSpline[16] = {-1. / 6, .5, -.5, 1. / 6, .5,     -1,     .5,     0,
                                            -.5,     0,  .5,  0,      1. / 6, 4. / 6, 1. / 6, 0};
    static constexpr double kHermite[16] = {2, 1, -2, 1, -3, -2, 3, -1, 0, 1, 0, 0, 1, 0, 0, 0};
    static constexpr double kLinear[16] = {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 1, 0, 0, 1, 0, 0};
    const double* m = basis == "catmull-rom" ? kCatmull
                      : basis == "bezier"    ? kBezier
                      : basis == "bspline"   ? kBSpline
                      : basis == "hermite"   ? kHermite
                                             : kLinear;
    std::vector<Dual> r(n);
    for (size_t k = 0; k < n; ++k) {
      if (basis == "constant") {
        r[k] = plain(knots[at + 1][k].v);
        continue;
      }
      for (size_t row = 0; row < 4; ++row) {
        Dual c;
        for (size_t q = 0; q < 4; ++q) c = c + plain(m[4 * row + q]) * knots[at * step + q][k];
        r[k] = r[k] * t + c;
      }
    }
    for (size_t k = 0; k < n; ++k) set(0, k, r[k]);
    return true;
  }
  std::vector<Dual> at;
  std::vector<uint32_t> words;
  for (size_t a = first; a < i.arguments.size(); ++a) {
    if (type(a).base == Base::String) return false;
    if (name == "int" && type(a).base == Base::Int)
      words.push_back(uint32_t(integer(a)));
    else
      for (size_t k = 0; k < components(a); ++k) at.push_back(number(a, k));
  }
  if (name == "int") {
    for (const Dual& d : at) words.push_back(bitsOf(d.v));
    cells(0).ints[0] = int32_t(hashOf(words));
    return true;
  }
  const size_t n = components(0);
  if (name == "cell" || name == "hash") {
    for (const Dual& d : at) words.push_back(name == "cell" ? cell(d.v) : bitsOf(d.v));
    for (size_t k = 0; k < n; ++k) {
      std::vector<uint32_t> w = words;
      if (n > 1) w.push_back(uint32_t(k));
      set(0, k, {unit(hashOf(w)), 0, 0});
    }
    return true;
  }
  const bool isUnsigned = name == "noise" || name == "uperlin";
  if (!isUnsigned && name != "snoise" && name != "perlin") return false;
  const std::vector<Dual> r = perlin(at, n);
  for (size_t k = 0; k < n; ++k) set(0, k, isUnsigned ? plain(0.5) * (r[k] + plain(1)) : r[k]);
  return true;
}

}  // namespace kinora::oracle
