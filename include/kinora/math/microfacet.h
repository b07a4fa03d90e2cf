// Microfacet theory for wide values: normal distributions (GGX, Beckmann), Smith masking, sampling of visible
// normals, exact Fresnel of conductors, and tables of the energy that one scattering keeps, by which rough lobes are
// compensated. Called by bxdfs; it holds no lobe of its own. Vectors are in the local frame: z is the normal, x the
// tangent. Included per target, like wide.h.
#include <kinora/math/sampling.h>

#ifndef KINORA_MICROFACET_ONCE
#define KINORA_MICROFACET_ONCE
#include <atomic>
#include <mutex>
namespace kinora {

// Directional albedo of one scattering by a reflecting surface without loss, over roughness (alpha = roughness^2) and
// the square root of the cosine. mean is the cosine-weighted average of the *interpolant*, so that compensation by
// (1 - e)(1 - e) / (1 - mean) returns exactly what the table says is missing.
struct ReflectionEnergy {
  static constexpr int kMu = 32, kRough = 32;
  float e[2][kRough][kMu];  // [0] Beckmann, [1] GGX
  float mean[2][kRough];
};
// The same for a rough dielectric, reflected and transmitted part apart, GGX. Side 0 looks from the thinner medium,
// side 1 from the denser. With m the larger index over the smaller, up to 3, the axis of the index is the square root
// of 2 (m - 1) / (m + 1): the cosine of the critical angle is nearly linear in it.
struct GlassEnergy {
  static constexpr int kMu = 32, kRough = 24, kEta = 40;
  float reflect[2][kEta][kRough][kMu], transmit[2][kEta][kRough][kMu];
  float reflectMean[2][kEta][kRough], transmitMean[2][kEta][kRough];
};

}  // namespace kinora
#endif

#if defined(KINORA_MICROFACET_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_MICROFACET_H_TARGET
#undef KINORA_MICROFACET_H_TARGET
#else
#define KINORA_MICROFACET_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Below this alpha a surface is a perfect mirror: its lobe would be narrower than single precision resolves well.
constexpr float kMirrorAlpha = 1e-3f;

// ---- distributions ----
// Density of microfacet normals, per solid angle and per area of the macrosurface.
template <int W>
KN_INLINE Float<W> microfacetD(bool ggx, Vec3<W> h, Float<W> ax, Float<W> ay) {
  using F = Float<W>;
  const F x = h.x / ax, y = h.y / ay, s = fma(x, x, y * y), z2 = h.z * h.z;
  if (ggx) {
    const F t = s + z2;
    return F(1.f) / max(F(kPi) * ax * ay * t * t, F(1e-30f));
  }
  const F zz = max(z2, F(1e-12f));
  return exp(-s / zz) / (F(kPi) * ax * ay * zz * zz);
}
// Smith's Lambda: masking is 1 / (1 + Lambda). Beckmann's is the rational fit of Walter et al. (EGSR 2007).
template <int W>
KN_INLINE Float<W> smithLambda(bool ggx, Vec3<W> w, Float<W> ax, Float<W> ay) {
  using F = Float<W>;
  const F x = w.x * ax, y = w.y * ay, t2 = fma(x, x, y * y) / max(w.z * w.z, F(1e-14f));
  if (ggx) return fma(sqrt(t2 + F(1.f)), F(0.5f), F(-0.5f));
  const F a = F(1.f) / sqrt(max(t2, F(1e-12f)));
  const F l = fma(a, fma(a, F(0.396f), F(-1.259f)), F(1.f)) / (a * fma(a, F(2.181f), F(3.535f)));
  return zeroUnless(a < F(1.6f), l);
}
// A microfacet normal seen from wo, GGX: Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps"
// (2023). Density: microfacetD(true) * (wo.h) / (wo.z * (1 + Lambda(wo))). It serves Beckmann as well, whose density
// over this one stays below about 1.5 at every angle (its tail is lighter), at no cost in special functions.
template <int W>
KN_INLINE Vec3<W> sampleVisibleNormal(Vec3<W> wo, Float<W> ax, Float<W> ay, Float<W> u, Float<W> v) {
  using F = Float<W>;
  const Vec3<W> s = normalize(Vec3<W>(wo.x * ax, wo.y * ay, wo.z));
  const F z = fnma(v, F(1.f) + s.z, F(1.f));  // uniform in (-s.z, 1]
  const F r = safeSqrt(fnma(z, z, F(1.f)));
  F sn, cs;
  sincos(u * F(kTwoPi), sn, cs);
  const Vec3<W> h(fma(r, cs, s.x), fma(r, sn, s.y), z + s.z);
  return normalize(Vec3<W>(h.x * ax, h.y * ay, max(h.z, F(1e-7f))));
}

// ---- Fresnel ----
// Unpolarised reflectance of a surface with complex index eta + i k relative to the medium of incidence; exact for
// conductors and, with k = 0, for dielectrics from either side (Born and Wolf).
template <int W>
KN_INLINE Float<W> fresnelConductor(Float<W> cosI, Float<W> eta, Float<W> k) {
  using F = Float<W>;
  const F c2 = cosI * cosI, s2 = max(F(1.f) - c2, F(0.f));
  const F t0 = fms(eta, eta, fma(k, k, s2)), ek = (eta + eta) * k;
  const F ab = sqrt(fma(t0, t0, ek * ek));
  const F a = safeSqrt(F(0.5f) * (ab + t0)), ac = (a + a) * cosI;
  const F t1 = ab + c2;
  const F rs = (t1 - ac) / max(t1 + ac, F(1e-20f));
  const F t3 = fma(c2, ab, s2 * s2), t4 = ac * s2;
  const F rp = rs * (t3 - t4) / max(t3 + t4, F(1e-20f));
  return min(max(F(0.5f) * (rs + rp), F(0.f)), F(1.f));
}
// Two-point Gauss rule for averages over directions, 2 * integral of f(c) c dc: nodes and weights.
constexpr float kMeanCos0 = 0.355051026f, kMeanCos1 = 0.844948974f, kMeanWeight0 = 0.363917103f,
                kMeanWeight1 = 0.636082897f;
// Average reflectance of a dielectric from its thinner side, m >= 1 (Kulla and Conty, SIGGRAPH course 2017: a fit).
template <int W>
KN_INLINE Float<W> fresnelDielectricMean(Float<W> m) {
  using F = Float<W>;
  return max(m - F(1.f), F(0.f)) / fma(m, F(1.00071f), F(4.08567f));
}

// ---- energy tables ----
// Cell and fraction on an axis of n nodes over [0, 1].
template <int W>
struct TableAxis {
  Int<W> cell;
  Float<W> t;
  KN_INLINE TableAxis() {}
  KN_INLINE TableAxis(Float<W> x, int n) {
    const Float<W> y = clamp(x, Float<W>(0.f), Float<W>(1.f)) * Float<W>(float(n - 1));
    const Float<W> f = min(floor(y), Float<W>(float(n - 2)));
    cell = toInt(f);
    t = y - f;
  }
};
template <int W>
KN_INLINE Float<W> tableLine(const float* p, Int<W> at, Float<W> t) {
  return lerp(gather(p, at), gather(p, at + Int<W>(1)), t);
}
template <int W>
KN_INLINE Float<W> tablePlane(const float* p, Int<W> at, int stride, Float<W> tx, Float<W> ty) {
  return lerp(tableLine(p, at, tx), tableLine(p, at + Int<W>(stride), tx), ty);
}

template <int W>
KN_INLINE Float<W> reflectionEnergy(const ReflectionEnergy& e, bool ggx, Float<W> mu, TableAxis<W> rough) {
  const TableAxis<W> a(safeSqrt(mu), ReflectionEnergy::kMu);
  return tablePlane(&e.e[ggx][0][0], rough.cell * Int<W>(ReflectionEnergy::kMu) + a.cell, ReflectionEnergy::kMu, a.t,
                    rough.t);
}
template <int W>
KN_INLINE Float<W> reflectionEnergyMean(const ReflectionEnergy& e, bool ggx, TableAxis<W> rough) {
  return tableLine(e.mean[ggx], rough.cell, rough.t);
}

// m: the larger index over the smaller.
template <int W>
KN_INLINE TableAxis<W> glassAxis(Float<W> m) {
  return TableAxis<W>(safeSqrt((m - Float<W>(1.f)) / (m + Float<W>(1.f)) * Float<W>(2.f)), GlassEnergy::kEta);
}
// table: GlassEnergy::reflect or transmit; side: 0 or 1 in each lane.
template <int W>
KN_INLINE Float<W> glassEnergy(const float* table, Int<W> side, TableAxis<W> eta, TableAxis<W> rough, Float<W> mu) {
  constexpr int kRow = GlassEnergy::kMu, kSlab = kRow * GlassEnergy::kRough;
  const TableAxis<W> a(safeSqrt(mu), GlassEnergy::kMu);
  const Int<W> at =
      (side * Int<W>(GlassEnergy::kEta) + eta.cell) * Int<W>(kSlab) + rough.cell * Int<W>(kRow) + a.cell;
  return lerp(tablePlane(table, at, kRow, a.t, rough.t), tablePlane(table, at + Int<W>(kSlab), kRow, a.t, rough.t),
              eta.t);
}
template <int W>
KN_INLINE Float<W> glassEnergyMean(const float* table, Int<W> side, TableAxis<W> eta, TableAxis<W> rough) {
  const Int<W> at = (side * Int<W>(GlassEnergy::kEta) + eta.cell) * Int<W>(GlassEnergy::kRough) + rough.cell;
  return tablePlane(table, at, GlassEnergy::kRough, rough.t, eta.t);
}

// Set-up code. Always on 8 lanes with our own functions, so that the tables have the same bits on every CPU. The
// lattice is Fibonacci's (2584 points, a multiple of 8), over the unit square of sampleVisibleNormal.
constexpr int kLatticeSize = 2584, kLatticeStep = 1597;
struct LatticePoint {
  Float<8> u, v;
  KN_INLINE explicit LatticePoint(int first) {
    using F = Float<8>;
    u = (F::lanes(float(first)) + F(0.5f)) * F(1.f / kLatticeSize);
    const F x = F::lanes(float(first)) * F(float(kLatticeStep)) * F(1.f / kLatticeSize);
    v = min(x - floor(x) + F(0.5f / kLatticeSize), F(0.9999999f));
  }
};
// 2 * integral of e(mu) mu dmu of a table line that is linear in sqrt(mu); exact (Gauss's 3-point rule, degree 5).
inline float tableMean(const float* e, int n) {
  constexpr double node[3] = {-0.774596669241483377, 0, 0.774596669241483377}, weight[3] = {5. / 9, 8. / 9, 5. / 9};
  double sum = 0;
  for (int i = 0; i + 1 < n; ++i)
    for (int g = 0; g < 3; ++g) {
      const double t = 0.5 + 0.5 * node[g], x = (i + t) / (n - 1);
      sum += weight[g] * 0.5 / (n - 1) * 4 * x * x * x * (e[i] + t * (e[i + 1] - e[i]));
    }
  return float(sum);
}
KN_INLINE Vec3<8> tableDirection(int i, int n) {
  const float x = float(i) / float(n - 1), mu = x * x < 1e-4f ? 1e-4f : x * x;
  return Vec3<8>(safeSqrt(Float<8>(1.f - mu * mu)), Float<8>(0.f), Float<8>(mu));
}

inline void buildReflectionEnergy(ReflectionEnergy& table) {
  using F = Float<8>;
  for (int model = 0; model < 2; ++model)
    for (int r = 0; r < ReflectionEnergy::kRough; ++r) {
      float* line = table.e[model][r];
      const float rough = float(r) / float(ReflectionEnergy::kRough - 1);
      const F alpha(rough * rough);
      for (int i = 0; i < ReflectionEnergy::kMu; ++i) {
        if (r == 0) {
          line[i] = 1;
          continue;
        }
        const Vec3<8> wo = tableDirection(i, ReflectionEnergy::kMu);
        const F lambdaO = smithLambda(model == 1, wo, alpha, alpha), lambdaGgx = smithLambda(true, wo, alpha, alpha);
        F sum(0.f);
        for (int k = 0; k < kLatticeSize; k += 8) {
          const LatticePoint p(k);
          const Vec3<8> h = sampleVisibleNormal(wo, alpha, alpha, p.u, p.v), wi = reflect(wo, h);
          F w = (F(1.f) + lambdaGgx) / (F(1.f) + lambdaO + smithLambda(model == 1, wi, alpha, alpha));
          if (model == 0) w = w * microfacetD(false, h, alpha, alpha) / microfacetD(true, h, alpha, alpha);
          sum += zeroUnless(wi.z > F(0.f), w);
        }
        const float e = sumLanes(sum) / float(kLatticeSize);
        line[i] = e < 1 ? e : 1;
      }
      table.mean[model][r] = tableMean(line, ReflectionEnergy::kMu);
    }
}

// One node of the index's axis and one of roughness: both sides, all angles.
inline void buildGlassEnergy(GlassEnergy& table, int e, int r) {
  using F = Float<8>;
  const float x = float(e) / float(GlassEnergy::kEta - 1), s = 0.5f * x * x, m = (1 + s) / (1 - s);
  for (int side = 0; side < 2; ++side) {
    const F eta(side == 0 ? 1 / m : m);  // ior(wo side) / ior(other)
    const float rough = float(r) / float(GlassEnergy::kRough - 1);
    const F alpha(rough * rough);
    float* reflected = table.reflect[side][e][r];
    float* transmitted = table.transmit[side][e][r];
    for (int i = 0; i < GlassEnergy::kMu; ++i) {
      const Vec3<8> wo = tableDirection(i, GlassEnergy::kMu);
      if (r == 0) {
        reflected[i] = fresnelDielectric(wo.z, eta).lane0();
        transmitted[i] = 1 - reflected[i];
        continue;
      }
      const F one = F(1.f) + smithLambda(true, wo, alpha, alpha);
      F up(0.f), down(0.f);
      for (int k = 0; k < kLatticeSize; k += 8) {
        const LatticePoint p(k);
        const Vec3<8> h = sampleVisibleNormal(wo, alpha, alpha, p.u, p.v), wr = reflect(wo, h);
        const F f = fresnelDielectric(dot(wo, h), eta);
        Vec3<8> wt;
        const Mask<8> passes = refract(wo, h, eta, wt);
        up += zeroUnless(wr.z > F(0.f), f * one / (one + smithLambda(true, wr, alpha, alpha)));
        down +=
            zeroUnless(passes & (wt.z < F(0.f)), (F(1.f) - f) * one / (one + smithLambda(true, wt, alpha, alpha)));
      }
      reflected[i] = sumLanes(up) / float(kLatticeSize);
      transmitted[i] = sumLanes(down) / float(kLatticeSize);
    }
    table.reflectMean[side][e][r] = tableMean(reflected, GlassEnergy::kMu);
    table.transmitMean[side][e][r] = tableMean(transmitted, GlassEnergy::kMu);
  }
}

// Tables are built at first use, by one thread while the others wait. Call these when a closure is bound.
template <class Table, void (*build)(Table&)>
const Table& builtTable() {
  static Table table;
  static const bool built = (build(table), true);
  (void)built;
  return table;
}
inline const ReflectionEnergy& reflectionEnergyTable() {
  return builtTable<ReflectionEnergy, buildReflectionEnergy>();
}
// Ready for relative indices (the larger over the smaller) and roughnesses between bounds: only the nodes around them
// are built, so that smooth glass, which most is, waits for a few of them.
struct TableBounds {
  float low, high;
};
inline const GlassEnergy& glassEnergyTable(TableBounds index, TableBounds roughness) {
  static GlassEnergy table;
  static std::atomic<bool> ready[GlassEnergy::kEta][GlassEnergy::kRough];
  static std::mutex building;
  const auto roughAxis = [](float r) { return TableAxis<1>(Float<1>(r), GlassEnergy::kRough).cell.lane0(); };
  const int firstIndex = glassAxis(Float<1>(index.low)).cell.lane0();
  const int lastIndex = glassAxis(Float<1>(index.high)).cell.lane0() + 1;
  const int firstRough = roughAxis(roughness.low), lastRough = roughAxis(roughness.high) + 1;
  for (int e = firstIndex; e <= lastIndex; ++e)
    for (int r = firstRough; r <= lastRough; ++r) {
      if (ready[e][r].load(std::memory_order_acquire)) continue;
      const std::lock_guard<std::mutex> lock(building);
      if (ready[e][r].load(std::memory_order_relaxed)) continue;
      buildGlassEnergy(table, e, r);
      ready[e][r].store(true, std::memory_order_release);
    }
  return table;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
