// Sheen: the microflake-like distribution of Conty Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF"
// (SIGGRAPH course 2017), D = (2 + 1/a) sin^(1/a) / (2 pi), with Neubelt and Pettineo's visibility ("Crafting a
// Next-Gen Material Pipeline for The Order: 1886", 2013), divided by its greatest albedo where that is over 1: what it
// takes from what is below is its own albedo, from a table. Included per target.
#include <kinora/math/microfacet.h>

#ifndef KINORA_LAMA_SHEEN_ONCE
#define KINORA_LAMA_SHEEN_ONCE
namespace kinora::lama {
struct SheenTable {
  static constexpr int kMu = 32, kRough = 32;
  float albedo[kRough][kMu];  // over roughness and the cosine's square root; scaled
  float scale[kRough];
};
}  // namespace kinora::lama
#endif

#if defined(KINORA_LAMA_SHEEN_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LAMA_SHEEN_H_TARGET
#undef KINORA_LAMA_SHEEN_H_TARGET
#else
#define KINORA_LAMA_SHEEN_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

template <int W>
struct SheenLobe {
  using F = Float<W>;
  F inverseAlpha, scale;
  TableAxis<W> rough;
  KN_INLINE SheenLobe() {}
  // No distribution is narrower than roughness 0.1 would be; roughness 1 is a sine.
  KN_INLINE SheenLobe(const lama::SheenTable* table, F roughness) {
    const F r = clamp(roughness, F(0.f), F(1.f)), a = fma(r, F(0.9f), F(0.1f));
    inverseAlpha = F(1.f) / (a * a);
    scale = F(1.f);
    rough = TableAxis<W>(r, lama::SheenTable::kRough);
    if (table) scale = tableLine(table->scale, rough.cell, rough.t);
  }
  // Directions local, both above; without the cosine.
  KN_INLINE F evaluate(Vec3<W> wo, Vec3<W> wi) const {
    const Vec3<W> h = normalize(wo + wi);
    const F s2 = min(fma(h.x, h.x, h.y * h.y), F(1.f));
    const F d = (inverseAlpha + F(2.f)) * F(kInvTwoPi) * pow(max(s2, F(1e-20f)), inverseAlpha * F(0.5f));
    const F v = F(0.25f) / max(wo.z + wi.z - wo.z * wi.z, F(1e-6f));
    return scale * d * v;
  }
  KN_INLINE F albedo(const lama::SheenTable& table, F mu) const {
    const TableAxis<W> m(safeSqrt(mu), lama::SheenTable::kMu);
    return tablePlane(&table.albedo[0][0], rough.cell * Int<W>(lama::SheenTable::kMu) + m.cell, lama::SheenTable::kMu,
                      m.t, rough.t);
  }
};

// Set-up code, on 8 lanes always (microfacet.h).
inline void buildSheen(lama::SheenTable& table) {
  using F = Float<8>;
  using lama::SheenTable;
  for (int r = 0; r < SheenTable::kRough; ++r) {
    const SheenLobe<8> lobe(nullptr, F(float(r) / float(SheenTable::kRough - 1)));
    float most = 1;
    for (int m = 0; m < SheenTable::kMu; ++m) {
      const Vec3<8> wo = tableDirection(m, SheenTable::kMu);
      F sum(0.f);
      for (int k = 0; k < kLatticeSize; k += 8) {
        const LatticePoint p(k);
        const F z = p.u, side = safeSqrt(fnma(z, z, F(1.f)));
        F s, c;
        sincos(p.v * F(kTwoPi), s, c);
        sum += lobe.evaluate(wo, Vec3<8>(side * c, side * s, z)) * z;
      }
      const float a = sumLanes(sum) * kTwoPi / float(kLatticeSize);
      table.albedo[r][m] = a;
      most = a > most ? a : most;
    }
    // the table sees what lies between its nodes a little too low
    table.scale[r] = most > 1 ? 1 / (1.01f * most) : 1;
  }
  // scales are interpolated on their own: what is stored holds for the greater neighbour as well
  for (int r = 0; r < SheenTable::kRough; ++r)
    for (int m = 0; m < SheenTable::kMu; ++m) table.albedo[r][m] *= table.scale[r];
}
inline const lama::SheenTable& sheenTable() { return builtTable<lama::SheenTable, buildSheen>(); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
