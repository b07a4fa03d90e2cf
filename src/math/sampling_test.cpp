// math/sampling.h: frames are orthonormal and right-handed, warps have the densities that their comments give
// (chi-square over equal-probability cells), reflection, refraction and Fresnel keep their identities. All at width
// 8; that widths agree follows from wide.h and is tested for whole plug-ins.
#define KINORA_KERNEL_FILE "math/sampling_test.cpp"
#include <gtest/gtest.h>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>
#include <kinora/simd/foreach_target.h>
#include <kinora/simd/tables.h>
#include <kinora/math/sampling.h>

#ifndef SAMPLING_TEST_ONCE
#define SAMPLING_TEST_ONCE
namespace kinora::samplingTest {
struct Rows {  // 8 rows of 8 lanes in, 12 out
  float in[8][8], out[12][8];
};
}  // namespace kinora::samplingTest
#endif

KINORA_KERNELS_BEGIN
using samplingTest::Rows;
#if HWY_TARGET == HWY_AVX2
using F = Float<8>;
using V = Vec3<8>;
HWY_ATTR F in(const Rows& r, int i) { return F::load(r.in[i]); }
HWY_ATTR V vec(const Rows& r, int i) { return {in(r, i), in(r, i + 1), in(r, i + 2)}; }
HWY_ATTR void put(Rows& r, int i, V v) {
  v.x.store(r.out[i]);
  v.y.store(r.out[i + 1]);
  v.z.store(r.out[i + 2]);
}
HWY_ATTR void frame(Rows& r) {
  const Frame<8> f(vec(r, 0));
  put(r, 0, f.x);
  put(r, 3, f.y);
  put(r, 6, f.z);
  put(r, 9, f.toWorld(f.toLocal(vec(r, 3))));
}
HWY_ATTR void tangentFrame(Rows& r) {
  const Frame<8> f = Frame<8>::fromTangent(vec(r, 0), vec(r, 3));
  put(r, 0, f.x);
  put(r, 3, f.y);
  put(r, 6, f.z);
}
HWY_ATTR void disk(Rows& r) {
  F x, y;
  concentricDisk(in(r, 0), in(r, 1), x, y);
  put(r, 0, V(x, y, F(0.f)));
}
HWY_ATTR void hemisphere(Rows& r) { put(r, 0, cosineHemisphere(in(r, 0), in(r, 1))); }
HWY_ATTR void sphere(Rows& r) { put(r, 0, uniformSphere(in(r, 0), in(r, 1))); }
HWY_ATTR void cone(Rows& r) { put(r, 0, uniformCone(in(r, 0), in(r, 1), in(r, 2))); }
HWY_ATTR void mirror(Rows& r) { put(r, 0, reflect(vec(r, 0), vec(r, 3))); }
HWY_ATTR void bend(Rows& r) {
  V t;
  const Mask<8> some = refract(vec(r, 0), vec(r, 3), in(r, 6), t);
  put(r, 0, t);
  zeroUnless(some, F(1.f)).store(r.out[3]);
  const F c = dot(vec(r, 0), vec(r, 3));
  fresnelDielectric(c, in(r, 6)).store(r.out[4]);
  // from the other side: the refracted direction leaves, seen against the turned normal
  fresnelDielectric(-dot(t, vec(r, 3)), F(1.f) / in(r, 6)).store(r.out[5]);
  V back;
  refract(t, -vec(r, 3), F(1.f) / in(r, 6), back);
  put(r, 6, back);
  misBalance(in(r, 6), c).store(r.out[9]);
  misPower(in(r, 6), c).store(r.out[10]);
}
#endif
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora {
namespace {
using samplingTest::Rows;
using namespace N_AVX2;

struct Uniform {
  uint64_t state;
  double next() {
    uint64_t z = (state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return double((z ^ (z >> 31)) >> 40) * 0x1p-24;
  }
};
struct D3 {
  double x, y, z;
};
double dotOf(D3 a, D3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
D3 outAt(const Rows& r, int row, int lane) { return {r.out[row][lane], r.out[row + 1][lane], r.out[row + 2][lane]}; }
D3 inAt(const Rows& r, int row, int lane) { return {r.in[row][lane], r.in[row + 1][lane], r.in[row + 2][lane]}; }
void setIn(Rows& r, int row, int lane, D3 v) {
  r.in[row][lane] = float(v.x);
  r.in[row + 1][lane] = float(v.y);
  r.in[row + 2][lane] = float(v.z);
}
D3 direction(Uniform& u) {
  const double z = 2 * u.next() - 1, p = 2 * M_PI * u.next(), s = std::sqrt(std::max(0.0, 1 - z * z));
  return {s * std::cos(p), s * std::sin(p), z};
}

void expectFrame(const Rows& r, int l, const char* what) {
  const D3 x = outAt(r, 0, l), y = outAt(r, 3, l), z = outAt(r, 6, l);
  const D3 c{x.y * y.z - x.z * y.y, x.z * y.x - x.x * y.z, x.x * y.y - x.y * y.x};
  for (const double e :
       {dotOf(x, x) - 1, dotOf(y, y) - 1, dotOf(z, z) - 1, dotOf(x, y), dotOf(y, z), dotOf(z, x), dotOf(c, z) - 1})
    EXPECT_NEAR(e, 0, 1e-6) << what << " about " << z.x << " " << z.y << " " << z.z;
}

TEST(Sampling, FramesAreOrthonormal) {
  Uniform u{1};
  const D3 special[] = {{0, 0, 1},         {0, 0, -1},     {1, 0, 0},
                        {0, -1, 0},        {0, 0.6, -0.8}, {1e-4, 0, -0.999999995},
                        {1e-5, -1e-5, -1}, {0, 1, -1e-30}};
  for (int round = 0; round < 400; ++round) {
    Rows r{};
    for (int l = 0; l < 8; ++l) {
      setIn(r, 0, l, round ? direction(u) : special[l]);
      setIn(r, 3, l, direction(u));
    }
    frame(r);
    for (int l = 0; l < 8; ++l) {
      expectFrame(r, l, "frame");
      const D3 v = inAt(r, 3, l), back = outAt(r, 9, l);
      EXPECT_NEAR(std::hypot(v.x - back.x, v.y - back.y, v.z - back.z), 0, 2e-6);
    }
    // tangents that are parallel, zero, tiny
    for (int l = 0; l < 8; ++l) {
      const D3 n = inAt(r, 0, l);
      const double s = std::pow(10.0, -2 * l);
      if (round % 3 == 0) setIn(r, 3, l, {n.x * s, n.y * s, n.z * s});
      if (round % 3 == 1) setIn(r, 3, l, l ? D3{s * r.in[3][l], s * r.in[4][l], s * r.in[5][l]} : D3{0, 0, 0});
      const double off = std::pow(10.0, -l);  // nearly parallel
      if (round % 3 == 2) setIn(r, 3, l, {n.x + off * r.in[3][l], n.y + off * r.in[4][l], n.z + off * r.in[5][l]});
    }
    tangentFrame(r);
    for (int l = 0; l < 8; ++l) expectFrame(r, l, "frame from a tangent");
  }
}

// Even counts in 16x16 cells of the coordinates that the warp should make uniform.
void expectUniform(const char* what, void (*warp)(Rows&), float parameter,
                   const std::function<bool(D3, double&, double&)>& cell) {
  Uniform u{7};
  std::vector<double> counts(256, 0);
  constexpr int kRounds = 16384;
  for (int round = 0; round < kRounds; ++round) {
    Rows r{};
    for (int l = 0; l < 8; ++l) {
      r.in[0][l] = float(u.next());
      r.in[1][l] = float(u.next());
      r.in[2][l] = parameter;
    }
    warp(r);
    for (int l = 0; l < 8; ++l) {
      double a = 0, b = 0;
      ASSERT_TRUE(cell(outAt(r, 0, l), a, b)) << what << ": outside its domain";
      const int i = std::min(15, std::max(0, int(a * 16))), k = std::min(15, std::max(0, int(b * 16)));
      ++counts[size_t(i * 16 + k)];
    }
  }
  double statistic = 0;
  const double e = kRounds * 8 / 256.0;
  for (const double c : counts) statistic += (c - e) * (c - e) / e;
  // 255 degrees of freedom: beyond 380 with probability 5e-7 (normal approximation of the cube root, Wilson and
  // Hilferty)
  EXPECT_LT(statistic, 380) << what;
  EXPECT_GT(statistic, 160) << what << ": too even for independent numbers";
}

TEST(Sampling, WarpsHaveTheirDensities) {
  const auto turn = [](D3 d) { return std::atan2(d.y, d.x) / (2 * M_PI) + 0.5; };
  expectUniform("concentricDisk", disk, 0, [&](D3 d, double& a, double& b) {
    a = d.x * d.x + d.y * d.y;
    b = turn(d);
    return a <= 1 + 1e-6;
  });
  const auto onSphere = [](D3 d) { return std::abs(dotOf(d, d) - 1) < 2e-6; };
  expectUniform("cosineHemisphere", hemisphere, 0, [&](D3 d, double& a, double& b) {
    a = d.z * d.z;
    b = turn(d);
    return d.z >= 0 && onSphere(d);
  });
  expectUniform("uniformSphere", sphere, 0, [&](D3 d, double& a, double& b) {
    a = 0.5 + 0.5 * d.z;
    b = turn(d);
    return onSphere(d);
  });
  for (const float h : {1e-6f, 1e-3f, 0.3f, 2.f})
    expectUniform("uniformCone", cone, h, [&, h](D3 d, double& a, double& b) {
      // 1 - cos from the distance to the axis: keeps digits for narrow cones
      const double s2 = d.x * d.x + d.y * d.y;
      a = (d.z > 0 ? s2 / (1 + std::sqrt(std::max(0.0, 1 - s2))) : 1 - d.z) / h;
      b = turn(d);
      return a <= 1.001 && onSphere(d);
    });
}

TEST(Sampling, ReflectionRefractionFresnel) {
  Uniform u{3};
  int total = 0;
  for (int round = 0; round < 2000; ++round) {
    Rows r{};
    for (int l = 0; l < 8; ++l) {
      const D3 n = direction(u);
      D3 w = direction(u);
      if (dotOf(n, w) < 0) w = {-w.x, -w.y, -w.z};
      setIn(r, 0, l, w);
      setIn(r, 3, l, n);
      r.in[6][l] = float(0.4 + 2 * u.next());
    }
    Rows m = r;
    mirror(m);
    bend(r);
    for (int l = 0; l < 8; ++l) {
      const D3 w = inAt(r, 0, l), n = inAt(r, 3, l), out = outAt(m, 0, l), t = outAt(r, 0, l);
      const double c = dotOf(w, n), eta = r.in[6][l];
      EXPECT_NEAR(dotOf(out, n), c, 1e-6);
      EXPECT_NEAR(dotOf(out, out), 1, 3e-6);
      EXPECT_NEAR(r.out[9][l], eta / (eta + c), 1e-6);
      EXPECT_NEAR(r.out[10][l], eta * eta / (eta * eta + c * c), 1e-6);
      const double s2 = eta * eta * (1 - c * c);
      const double fresnel = r.out[4][l];
      EXPECT_GE(fresnel, 0);
      EXPECT_LE(fresnel, 1.000001);
      if (s2 > 1.0001) {
        EXPECT_EQ(r.out[3][l], 0.f) << "total reflection";
        EXPECT_EQ(fresnel, 1);
        ++total;
      }
      if (s2 > 0.999) continue;
      EXPECT_EQ(r.out[3][l], 1.f);
      const double ct = std::sqrt(1 - s2);
      EXPECT_NEAR(dotOf(t, t), 1, 1e-5);
      EXPECT_NEAR(dotOf(t, n), -ct, 1e-4) << "Snell";
      const double rs = (eta * c - ct) / (eta * c + ct), rp = (c - eta * ct) / (c + eta * ct);
      EXPECT_NEAR(fresnel, 0.5 * (rs * rs + rp * rp), 2e-4);
      // Stokes: the same reflectance from the other side; the way back is the way there
      EXPECT_NEAR(r.out[5][l], fresnel, 1e-3 / ct);
      const D3 back = outAt(r, 6, l);
      EXPECT_NEAR(std::hypot(back.x - w.x, back.y - w.y, back.z - w.z), 0, 1e-4 / std::max(0.01, c));
    }
  }
  EXPECT_GT(total, 500);
}

}  // namespace
}  // namespace kinora
#endif
