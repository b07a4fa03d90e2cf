#include "language/library/string_hash.h"

#include <cstring>
#include <utility>

namespace kinora::language {
namespace {
constexpr uint64_t k0 = 0xc3a5c85c97cb3127u, k1 = 0xb492b66fbe98f273u, k2 = 0x9ae16a3b2f90404fu;
struct Pair {
  uint64_t first, second;
};
uint64_t word(const char* p) {
  uint64_t v;
  std::memcpy(&v, p, 8);
  return v;
}
uint64_t half(const char* p) {
  uint32_t v;
  std::memcpy(&v, p, 4);
  return v;
}
uint64_t rotate(uint64_t v, int k) { return v >> k | v << (64 - k); }  // right
uint64_t fold(uint64_t v) { return v ^ v >> 47; }
uint64_t join(uint64_t u, uint64_t v, uint64_t mul) { return fold((v ^ fold((u ^ v) * mul)) * mul) * mul; }

uint64_t upTo16(const char* s, size_t n) {
  const uint64_t mul = k2 + n * 2;
  if (n >= 8) {
    const uint64_t a = word(s) + k2, b = word(s + n - 8);
    return join(rotate(b, 37) * mul + a, (rotate(a, 25) + b) * mul, mul);
  }
  if (n >= 4) return join(n + (half(s) << 3), half(s + n - 4), mul);
  if (n == 0) return k2;
  const auto byte = [&](size_t i) { return uint32_t(uint8_t(s[i])); };
  const uint32_t y = byte(0) + (byte(n >> 1) << 8), z = uint32_t(n) + (byte(n - 1) << 2);
  return fold(y * k2 ^ z * k0) * k2;
}
uint64_t upTo32(const char* s, size_t n) {
  const uint64_t mul = k2 + n * 2, a = word(s) * k1, b = word(s + 8), c = word(s + n - 8) * mul,
                 d = word(s + n - 16) * k2;
  return join(rotate(a + b, 43) + rotate(c, 30) + d, a + rotate(b + k2, 18) + c, mul);
}
// 32 bytes at s (n = 32), seeded
uint64_t block(const char* s, uint64_t mul, uint64_t seed0 = 0, uint64_t seed1 = 0) {
  const uint64_t a = word(s) * k1, b = word(s + 8), c = word(s + 24) * mul, d = word(s + 16) * k2;
  const uint64_t u = rotate(a + b, 43) + rotate(c, 30) + d + seed0, v = a + rotate(b + k2, 18) + c + seed1;
  return fold((v ^ fold((u ^ v) * mul)) * mul);
}
uint64_t upTo96(const char* s, size_t n) {
  const uint64_t base = k2 - (n <= 64 ? 30 : 114), mul = base + 2 * n;
  const uint64_t h0 = block(s, base);
  if (n <= 64) return (block(s + n - 32, mul) * mul + h0) * mul;
  const uint64_t h1 = block(s + 32, mul);
  return (block(s + n - 32, mul, h0, h1) * 9 + (h0 >> 17) + (h1 >> 21)) * mul;
}
Pair weak(const char* s, uint64_t a, uint64_t b) {
  a += word(s);
  b = rotate(b + a + word(s + 24), 21);
  const uint64_t c = a;
  a += word(s + 8) + word(s + 16);
  b += rotate(a, 44);
  return {a + word(s + 24), b + c};
}
uint64_t upTo256(const char* s, size_t n) {
  uint64_t x = 81, y = 81 * k1 + 113, z = fold(y * k2 + 113) * k2;
  Pair v{0, 0}, w{0, 0};
  x = x * k2 + word(s);
  const char *const end = s + (n - 1) / 64 * 64, *const last = end + ((n - 1) & 63) - 63;
  do {
    x = rotate(x + y + v.first + word(s + 8), 37) * k1;
    y = rotate(y + v.second + word(s + 48), 42) * k1;
    x ^= w.second;
    y += v.first + word(s + 40);
    z = rotate(z + w.first, 33) * k1;
    v = weak(s, v.second * k1, x + w.first);
    w = weak(s + 32, z + w.second, y + word(s + 16));
    std::swap(z, x);
    s += 64;
  } while (s != end);
  const uint64_t mul = k1 + ((z & 0xff) << 1);
  s = last;
  w.first += (n - 1) & 63;
  v.first += w.first;
  w.first += v.first;
  x = rotate(x + y + v.first + word(s + 8), 37) * mul;
  y = rotate(y + v.second + word(s + 48), 42) * mul;
  x ^= w.second * 9;
  y += v.first * 9 + word(s + 40);
  z = rotate(z + w.first, 33) * mul;
  v = weak(s, v.second * mul, x + w.first);
  w = weak(s + 32, z + w.second, y + word(s + 16));
  std::swap(z, x);
  return join(join(v.first, w.first, mul) + fold(y) * k0 + z, join(v.second, w.second, mul) + x, mul);
}
uint64_t joinRotated(uint64_t x, uint64_t y, uint64_t mul, int r) {
  return rotate((y ^ fold((x ^ y) * mul)) * mul, r) * mul;
}
uint64_t longer(const char* s, size_t n) {
  const uint64_t seed0 = 81, seed1 = 0;
  uint64_t x = seed0, y = seed1 * k2 + 113, z = fold(y * k2) * k2, u = x - z;
  Pair v{seed0, seed1}, w{0, 0};
  x *= k2;
  const uint64_t mul = k2 + (u & 0x82);
  const char *const end = s + (n - 1) / 64 * 64, *const last = end + ((n - 1) & 63) - 63;
  do {
    uint64_t a[8];
    for (int i = 0; i < 8; ++i) a[i] = word(s + 8 * i);
    x += a[0] + a[1], y += a[2], z += a[3];
    v.first += a[4], v.second += a[5] + a[1], w.first += a[6], w.second += a[7];
    x = rotate(x, 26) * 9;
    y = rotate(y, 29);
    z *= mul;
    v.first = rotate(v.first, 33);
    v.second = rotate(v.second, 30);
    w.first = (w.first ^ x) * 9;
    z = rotate(z, 32) + w.second;
    w.second += z;
    z *= 9;
    std::swap(u, y);
    z += a[0] + a[6];
    v.first += a[2], v.second += a[3], w.first += a[4], w.second += a[5] + a[6];
    x += a[1], y += a[7];
    y += v.first;
    v.first += x - y;
    v.second += w.first;
    w.first += v.second;
    w.second += x - y;
    x += w.second;
    w.second = rotate(w.second, 34);
    std::swap(u, z);
    s += 64;
  } while (s != end);
  s = last;
  u *= 9;
  v.second = rotate(v.second, 28);
  v.first = rotate(v.first, 20);
  w.first += (n - 1) & 63;
  u += y;
  y += u;
  x = rotate(y - x + v.first + word(s + 8), 37) * mul;
  y = rotate(y ^ v.second ^ word(s + 48), 42) * mul;
  x ^= w.second * 9;
  y += v.first + word(s + 40);
  z = rotate(z + w.first, 33) * mul;
  v = weak(s, v.second * mul, x + w.first);
  w = weak(s + 32, z + w.second, y + word(s + 16));
  return joinRotated(join(v.first + x, w.first ^ y, mul) + z - u, joinRotated(v.second + y, w.second + z, k2, 30) ^ x,
                     k2, 31);
}
}  // namespace

uint64_t farmHash64(std::string_view s) {
  const char* p = s.data();
  const size_t n = s.size();
  return n <= 16    ? upTo16(p, n)
         : n <= 32  ? upTo32(p, n)
         : n <= 96  ? upTo96(p, n)
         : n <= 256 ? upTo256(p, n)
                    : longer(p, n);
}

}  // namespace kinora::language
