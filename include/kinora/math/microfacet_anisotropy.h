// How much of the light one scattering by an anisotropic microfacet surface keeps: the table of microfacet.h with two
// more axes, the stretch of the distribution and the azimuth. By it stretched lobes are compensated; with the table
// of round ones they would lose up to half of the light. Within 0.01 at every angle, 0.002 on average. Included per
// target.
#include <kinora/math/microfacet.h>

#ifndef KINORA_MICROFACET_ANISOTROPY_ONCE
#define KINORA_MICROFACET_ANISOTROPY_ONCE
namespace kinora {

// Alphas are alpha / aspect along the wide axis and alpha * aspect across it. The axes are the aspect from 1 down to
// kLeast, roughness, the square root of the cosine, and the azimuth as |across| / (|along| + |across|), which needs
// no trigonometry. mean is the cosine-weighted average of the interpolant over all directions.
struct AnisotropicEnergy {
  static constexpr int kAspect = 8, kRough = 16, kMu = 16, kAzimuth = 12;
  static constexpr float kLeast = 0.316227766f;  // of Disney's aspect, sqrt(1 - 0.9 amount)
  float e[kAspect][kRough][kMu][kAzimuth];
  float mean[kAspect][kRough];
};

}  // namespace kinora
#endif

#if defined(KINORA_MICROFACET_ANISOTROPY_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_MICROFACET_ANISOTROPY_H_TARGET
#undef KINORA_MICROFACET_ANISOTROPY_H_TARGET
#else
#define KINORA_MICROFACET_ANISOTROPY_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Where a lobe is on the axes that do not depend on direction.
template <int W>
struct AnisotropicAxes {
  TableAxis<W> aspect, rough;
  KN_INLINE AnisotropicAxes() {}
  KN_INLINE AnisotropicAxes(Float<W> aspectOfLobe, Float<W> roughness) {
    using T = AnisotropicEnergy;
    aspect = TableAxis<W>((Float<W>(1.f) - aspectOfLobe) * Float<W>(1.f / (1.f - T::kLeast)), T::kAspect);
    rough = TableAxis<W>(roughness, T::kRough);
  }
};
// along, across: components of the direction along the wide axis and across it, of either sign.
template <int W>
KN_INLINE Float<W> anisotropicEnergy(const AnisotropicEnergy& table, const AnisotropicAxes<W>& lobe, Float<W> mu,
                                     Float<W> along, Float<W> across) {
  using F = Float<W>;
  using T = AnisotropicEnergy;
  constexpr int kLine = T::kAzimuth, kPlane = T::kMu * kLine, kSlab = T::kRough * kPlane;
  const F x = abs(along), y = abs(across);
  const TableAxis<W> m(safeSqrt(mu), T::kMu), p(y / max(x + y, F(1e-20f)), T::kAzimuth);
  const Int<W> at =
      lobe.aspect.cell * Int<W>(kSlab) + lobe.rough.cell * Int<W>(kPlane) + m.cell * Int<W>(kLine) + p.cell;
  const float* e = &table.e[0][0][0][0];
  const auto slab = [&](Int<W> i) {
    return lerp(tablePlane(e, i, kLine, p.t, m.t), tablePlane(e, i + Int<W>(kPlane), kLine, p.t, m.t), lobe.rough.t);
  };
  return lerp(slab(at), slab(at + Int<W>(kSlab)), lobe.aspect.t);
}
template <int W>
KN_INLINE Float<W> anisotropicEnergyMean(const AnisotropicEnergy& table, const AnisotropicAxes<W>& lobe) {
  using T = AnisotropicEnergy;
  return tablePlane(&table.mean[0][0], lobe.aspect.cell * Int<W>(T::kRough) + lobe.rough.cell, T::kRough,
                    lobe.rough.t, lobe.aspect.t);
}

// Set-up code, as that of microfacet.h: 8 lanes, our own functions, the same bits everywhere.
inline void buildAnisotropicEnergy(AnisotropicEnergy& table, bool ggx) {
  using F = Float<8>;
  using T = AnisotropicEnergy;
  constexpr int kPoints = 610, kStep = 377;  // Fibonacci's
  // weight of each node in the mean over the azimuth: its hat function over (1 - p)^2 + p^2, the azimuth's derivative
  double weight[T::kAzimuth] = {}, all = 0;
  for (int i = 0; i + 1 < T::kAzimuth; ++i)
    for (int k = 0; k < 64; ++k) {
      const double t = (k + 0.5) / 64, p = (i + t) / (T::kAzimuth - 1), w = 1 / ((1 - p) * (1 - p) + p * p);
      weight[i] += (1 - t) * w;
      weight[i + 1] += t * w;
      all += w;
    }
  for (int a = 0; a < T::kAspect; ++a)
    for (int r = 0; r < T::kRough; ++r) {
      const float aspect = 1.f - float(a) / float(T::kAspect - 1) * (1.f - T::kLeast);
      const float rough = float(r) / float(T::kRough - 1), alpha = rough * rough;
      const F ax(alpha / aspect), ay(alpha * aspect);
      float line[T::kMu];
      for (int i = 0; i < T::kMu; ++i) {
        double mean = 0;
        for (int j = 0; j < T::kAzimuth; ++j) {
          float& e = table.e[a][r][i][j];
          e = 1;
          if (r > 0) {
            const Vec3<8> w = tableDirection(i, T::kMu);
            const float p = float(j) / float(T::kAzimuth - 1);
            const F scale = w.x / sqrt(F((1.f - p) * (1.f - p) + p * p));
            const Vec3<8> wo(scale * F(1.f - p), scale * F(p), w.z);
            const F lambdaO = smithLambda(ggx, wo, ax, ay), lambdaGgx = smithLambda(true, wo, ax, ay);
            F sum(0.f);
            for (int k = 0; k < kPoints; k += 8) {
              const F n = F::lanes(float(k)), y = n * F(float(kStep)) * F(1.f / kPoints);
              const F u = (n + F(0.5f)) * F(1.f / kPoints), v = min(y - floor(y) + F(0.5f / kPoints), F(0.9999999f));
              const Vec3<8> h = sampleVisibleNormal(wo, ax, ay, min(u, F(0.9999999f)), v), wi = reflect(wo, h);
              F f = (F(1.f) + lambdaGgx) / (F(1.f) + lambdaO + smithLambda(ggx, wi, ax, ay));
              if (!ggx) f = f * microfacetD(false, h, ax, ay) / microfacetD(true, h, ax, ay);
              sum += zeroUnless((wi.z > F(0.f)) & (n < F(float(kPoints))), f);
            }
            const float mine = sumLanes(sum) / float(kPoints);
            e = mine < 1 ? mine : 1;
          }
          mean += weight[j] * e;
        }
        line[i] = float(mean / all);
      }
      table.mean[a][r] = tableMean(line, T::kMu);
    }
}
// Built at first use, by one thread while the others wait; call it when a closure is bound.
inline const AnisotropicEnergy& anisotropicEnergyTable(bool ggx) {
  if (ggx) {
    static AnisotropicEnergy table;
    static const bool built = (buildAnisotropicEnergy(table, true), true);
    (void)built;
    return table;
  }
  static AnisotropicEnergy table;
  static const bool built = (buildAnisotropicEnergy(table, false), true);
  (void)built;
  return table;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
