#define KINORA_KERNEL_FILE "../bench/shading_fused.cpp"
#include "shading_fused.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/cell_noise.h"
#include "language/library/fast_math.h"
#include "language/library/perlin.h"
#include "language/library/round_math.h"
#include "language/library/vector.h"

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using bench::FusedArguments;
using lang::Dual;
using lang::Dual3;

template <int W>
KN_INLINE Float<W> noise(Vec3<W> p) {
  const Float<W> x[3] = {p.x, p.y, p.z};
  Float<W> r;
  lang::UnsignedNoise<lang::PerlinNoise>::value<3, 1, W>(x, nullptr, &r);
  return r;
}
template <int W>
KN_INLINE Float<W> cell(Float<W> a, Float<W> b) {
  const Float<W> x[2] = {a, b};
  Float<W> r;
  lang::CellNoise::value<2, 1, W>(x, nullptr, &r);
  return r;
}
template <int W>
KN_INLINE Vec3<W> mixOf(Vec3<W> a, Vec3<W> b, Float<W> t) {
  return {lang::mix(a.x, b.x, t), lang::mix(a.y, b.y, t), lang::mix(a.z, b.z, t)};
}

template <int W>
void marble(const FusedArguments& a) {
  using F = Float<W>;
  for (uint32_t i = 0; i < a.points; i += W) {
    const Vec3<W> p = Vec3<W>::load(a.P, i) * F(4.f);
    F t(0.f), amplitude(1.f), frequency(1.f);
    for (int k = 0; k < 4; ++k) {
      t = t + amplitude * noise(p * frequency);
      amplitude = amplitude * F(0.5f);
      frequency = frequency * F(2.f);
    }
    const F m = lang::sin(p.x * F(2.f) + t * F(6.f)) * F(0.5f) + F(0.5f);
    const Vec3<W> r =
        mixOf(Vec3<W>(F(0.1f), F(0.15f), F(0.2f)), Vec3<W>(F(0.9f), F(0.85f), F(0.8f)), lang::pow(m, F(0.7f)));
    r.store(a.result, i);
  }
}
template <int W>
KN_INLINE Dual<W> dualAt(const float* v, const float* dx, const float* dy, uint32_t i) {
  return {Float<W>::load(v + i), Float<W>::load(dx + i), Float<W>::load(dy + i)};
}
template <int W>
KN_INLINE Float<W> aastep(Float<W> edge, Dual<W> s) {
  using F = Float<W>;
  const F width = HWY_NAMESPACE::abs(lang::filterwidth(s));
  const F start = edge - width * F(0.5f), end = edge + width * F(0.5f);
  F r = lang::divide(s.v - start, width);
  r = select(s.v >= end, F(1.f), r);
  return select(s.v <= start, F(0.f), r);
}
template <int W>
void brick(const FusedArguments& a) {
  using F = Float<W>;
  using D = Dual<W>;
  for (uint32_t i = 0; i < a.points; i += W) {
    const D u = dualAt<W>(a.u, a.udx, a.udy, i), v = dualAt<W>(a.v, a.vdx, a.vdy, i);
    const D y = v * F(16.f);
    const F row = floor(y.v);
    const D x = u * F(8.f) + lang::fmod(row, F(2.f)) * F(0.5f);
    const F column = floor(x.v);
    const D fx = x - column, fy = y - row;
    const F bx = aastep(F(0.05f), fx) * (F(1.f) - aastep(F(0.95f), fx));
    const F by = aastep(F(0.1f), fy) * (F(1.f) - aastep(F(0.9f), fy));
    const F shade = F(0.7f) + F(0.3f) * cell(column, row);
    const Vec3<W> r =
        mixOf(Vec3<W>(F(0.6f), F(0.6f), F(0.55f)), Vec3<W>(F(0.7f), F(0.25f), F(0.2f)) * shade, bx * by);
    r.store(a.result, i);
  }
}
template <int W>
void fractal(const FusedArguments& a) {
  using F = Float<W>;
  for (uint32_t i = 0; i < a.points; i += W) {
    const Vec3<W> p = Vec3<W>::load(a.P, i);
    F sum(0.f), amplitude(0.5f), weight(1.f);
    Vec3<W> q = p * F(2.f);
    for (int k = 0; k < 8; ++k) {
      const F n = F(1.f) - HWY_NAMESPACE::abs(F(2.f) * noise(q) - F(1.f));
      const F s = n * n * weight;
      weight = lang::clampTo(s * F(2.f), F(0.f), F(1.f));
      sum = sum + s * amplitude;
      amplitude = amplitude * F(0.5f);
      q = q * F(2.1f) + Vec3<W>(F(1.7f), F(9.2f), F(3.3f));
    }
    const Vec3<W> r = mixOf(Vec3<W>(F(0.2f), F(0.3f), F(0.1f)), Vec3<W>(F(1.f), F(1.f), F(0.95f)),
                            lang::smoothstep(F(0.2f), F(0.9f), sum));
    r.store(a.result, i);
  }
}
// three branches, points of which differ
template <int W>
void branches(const FusedArguments& a) {
  using F = Float<W>;
  for (uint32_t i = 0; i < a.points; i += W) {
    const Vec3<W> p = Vec3<W>::load(a.P, i);
    const F u = F::load(a.u + i), v = F::load(a.v + i);
    const F k = noise(p * F(3.f));
    Vec3<W> r;
    const Mask<W> rock = k < F(0.4f), sand = (!rock) & (k < F(0.55f)), grass = !(rock | sand);
    if (rock.any()) {
      const F n = noise(p * F(20.f));
      r = select(rock, mixOf(Vec3<W>(F(0.3f), F(0.3f), F(0.3f)), Vec3<W>(F(0.6f), F(0.55f), F(0.5f)), n * n), r);
    }
    if (sand.any()) {
      const F s = lang::sin(u * F(80.f) + noise(p * F(6.f)) * F(4.f)) * F(0.5f) + F(0.5f);
      r = select(sand, Vec3<W>(F(0.8f), F(0.7f), F(0.5f)) * (s * F(0.3f) + F(0.7f)), r);
    }
    if (grass.any()) {
      F n = noise(p * F(12.f));
      const Mask<W> tall = n > F(0.5f);
      F h = n;
      if ((grass & tall).any()) h = select(grass & tall, lang::pow(n, F(2.5f)) + v, h);
      r = select(grass, Vec3<W>(F(0.1f), F(0.5f), F(0.1f)) * (h + F(0.3f)), r);
    }
    r.store(a.result, i);
  }
}
// a loop of few operations that points leave at different turns
template <int W>
void thinLoop(const FusedArguments& a) {
  using F = Float<W>;
  for (uint32_t i = 0; i < a.points; i += W) {
    const F cx = F::load(a.u + i) * F(3.f) - F(2.f), cy = F::load(a.v + i) * F(2.f) - F(1.f);
    F x(0.f), y(0.f), turns(0.f);
    Mask<W> live = turns < F(64.f);
    for (;;) {
      live &= (x * x + y * y < F(4.f)) & (turns < F(64.f));
      if (live.none()) break;
      const F t = x * x - y * y + cx;
      y = select(live, F(2.f) * x * y + cy, y);
      x = select(live, t, x);
      turns = select(live, turns + F(1.f), turns);
    }
    const F r = turns / F(64.f);
    r.store(a.result[0] + i);
    r.store(a.result[1] + i);
    r.store(a.result[2] + i);
  }
}

// three filtered lookups: coordinates for a group, the group's lookups, arithmetic on the answers
template <int W>
void textured(const FusedArguments& a) {
  using F = Float<W>;
  constexpr uint32_t kGroup = 256;
  alignas(64) float s[3][kGroup], t[3][kGroup], radius[3][kGroup], rgba[3][4][kGroup];
  const float scales[3] = {4.f, 11.f, 2.f};
  for (uint32_t first = 0; first < a.points; first += kGroup) {
    const uint32_t n = a.points - first < kGroup ? a.points - first : kGroup;
    for (uint32_t i = 0; i < n; i += W) {
      const auto at = [&](const float* p) { return F::load(p + first + i); };
      const F u = at(a.u), v = at(a.v);
      for (int k = 0; k < 3; ++k) {
        const F scale(scales[k]);
        (u * scale).store(s[k] + i);
        (v * scale).store(t[k] + i);
        const auto half = [&](const float* x, const float* y) {
          const F dx = at(x) * scale, dy = at(y) * scale;
          return F(0.5f) * sqrt(dx * dx + dy * dy);
        };
        const F x = half(a.udx, a.vdx), y = half(a.udy, a.vdy);
        select(x < y, y, x).store(radius[k] + i);
      }
    }
    for (int k = 0; k < 3; ++k) {
      float* const to[4] = {rgba[k][0], rgba[k][1], rgba[k][2], rgba[k][3]};
      a.lookup(a.textures, n, s[k], t[k], radius[k], to);
    }
    for (uint32_t i = 0; i < n; i += W) {
      const auto color = [&](int k) {
        return Vec3<W>(F::load(rgba[k][0] + i), F::load(rgba[k][1] + i), F::load(rgba[k][2] + i));
      };
      const F mask = lang::smoothstep(F(0.3f), F(0.7f), F::load(rgba[2][0] + i));
      const Vec3<W> base = color(0), detail = color(1);
      const Vec3<W> worn = base * detail * F(1.5f);
      const F n1 = noise(Vec3<W>::load(a.P, first + i) * F(5.f));
      const Vec3<W> r = mixOf(base, worn, mask) * (F(0.8f) + F(0.2f) * n1);
      r.x.store(a.result[0] + first + i);
      r.y.store(a.result[1] + first + i);
      r.z.store(a.result[2] + first + i);
    }
  }
}

#undef KN_FUSED
#if HWY_TARGET == HWY_AVX2
#define KN_FUSED(name) constexpr bench::Fused k##name[3] = {&name<1>, &name<4>, &name<8>};
#else
#define KN_FUSED(name) constexpr bench::Fused k##name[1] = {&name<16>};
#endif
KN_FUSED(marble)
KN_FUSED(brick)
KN_FUSED(fractal)
KN_FUSED(branches)
KN_FUSED(textured)
KN_FUSED(thinLoop)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::bench {
namespace {
#define KN_WIDTHS(name) \
  { N_AVX2::k##name[0], N_AVX2::k##name[1], N_AVX2::k##name[2], N_AVX3::k##name[0] }
const FusedProgram kPrograms[] = {
    {"marble", R"(shader marble(output color result = 0) {
  point p = P * 4;
  float t = 0, amplitude = 1, frequency = 1;
  for (int k = 0; k < 4; k++) { t += amplitude * noise(p * frequency); amplitude *= 0.5; frequency *= 2; }
  float m = sin(p[0] * 2 + t * 6) * 0.5 + 0.5;
  result = mix(color(0.1, 0.15, 0.2), color(0.9, 0.85, 0.8), pow(m, 0.7));
})",
     KN_WIDTHS(marble)},
    {"brick", R"(
float soft(float edge, float s) {
  float width = abs(filterwidth(s));
  float start = edge - width * 0.5, end = edge + width * 0.5;
  float r = (s - start) / width;
  r = s >= end ? 1.0 : r;
  return s <= start ? 0.0 : r;
}
shader brick(output color result = 0) {
  float y = v * 16;
  float row = floor(y);
  float x = u * 8 + fmod(row, 2.0) * 0.5;
  float column = floor(x);
  float fx = x - column, fy = y - row;
  float bx = soft(0.05, fx) * (1 - soft(0.95, fx));
  float by = soft(0.1, fy) * (1 - soft(0.9, fy));
  float shade = 0.7 + 0.3 * noise("cell", column, row);
  result = mix(color(0.6, 0.6, 0.55), color(0.7, 0.25, 0.2) * shade, bx * by);
})",
     KN_WIDTHS(brick)},
    {"fractal", R"(shader fractal(output color result = 0) {
  float sum = 0, amplitude = 0.5, weight = 1;
  point q = P * 2;
  for (int k = 0; k < 8; k++) {
    float n = 1 - abs(2 * noise(q) - 1);
    float s = n * n * weight;
    weight = clamp(s * 2, 0.0, 1.0);
    sum += s * amplitude;
    amplitude *= 0.5;
    q = q * 2.1 + vector(1.7, 9.2, 3.3);
  }
  result = mix(color(0.2, 0.3, 0.1), color(1, 1, 0.95), smoothstep(0.2, 0.9, sum));
})",
     KN_WIDTHS(fractal)},
    {"branches", R"(shader branches(output color result = 0) {
  float k = noise(P * 3);
  if (k < 0.4) {
    float n = noise(P * 20);
    result = mix(color(0.3), color(0.6, 0.55, 0.5), n * n);
  } else if (k < 0.55) {
    float s = sin(u * 80 + noise(P * 6) * 4) * 0.5 + 0.5;
    result = color(0.8, 0.7, 0.5) * (s * 0.3 + 0.7);
  } else {
    float n = noise(P * 12), h = n;
    if (n > 0.5) h = pow(n, 2.5) + v;
    result = color(0.1, 0.5, 0.1) * (h + 0.3);
  }
})",
     KN_WIDTHS(branches)},
    {"textures", R"(shader textures(output color result = 0) {
  color base = texture("bench.tx", u * 4, v * 4, "wrap", "periodic");
  color detail = texture("bench.tx", u * 11, v * 11, "wrap", "periodic");
  float mask = texture("bench.tx", u * 2, v * 2, "wrap", "periodic");
  color worn = base * detail * 1.5;
  float n = noise(P * 5);
  result = mix(base, worn, smoothstep(0.3, 0.7, mask)) * (0.8 + 0.2 * n);
})",
     KN_WIDTHS(textured)},
    {"thin_loop", R"(shader thin(output color result = 0) {
  float cx = u * 3 - 2, cy = v * 2 - 1, x = 0, y = 0, turns = 0;
  while (x * x + y * y < 4 && turns < 64) {
    float t = x * x - y * y + cx;
    y = 2 * x * y + cy;
    x = t;
    turns += 1;
  }
  result = turns / 64;
})",
     KN_WIDTHS(thinLoop)},
};
}  // namespace
const FusedProgram* fusedPrograms(uint32_t& count) {
  count = uint32_t(sizeof kPrograms / sizeof *kPrograms);
  return kPrograms;
}
}  // namespace kinora::bench
#endif
