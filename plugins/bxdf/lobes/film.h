// Reflectance of a thin film with the same medium on both sides, as colour. The film's transmittance (Airy's sum) is
// (1 - r) / (1 + r) (1 + 2 sum r^m cos m d) for a face's reflectance r and the phase d = 2 pi D / wavelength of the
// detour D; as the eye's curves are fixed, the cosines become a table over m D, as Belcour and Barla do ("A Practical
// Extension to Microfacet Theory for the Modeling of Varying Iridescence", 2017). Included per target.
#include <kinora/math/microfacet.h>

#ifndef KINORA_LOBES_FILM_ONCE
#define KINORA_LOBES_FILM_ONCE
namespace kinora::lobes {
// What the channels see of cos(2 pi x / wavelength): 1 at x = 0, and light is incoherent past the end.
struct FilmTable {
  static constexpr int kCount = 2048;
  static constexpr float kStep = 12;  // nm
  float seen[3][kCount];
};
}  // namespace kinora::lobes
#endif

#if defined(KINORA_LOBES_FILM_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_FILM_H_TARGET
#undef KINORA_LOBES_FILM_H_TARGET
#else
#define KINORA_LOBES_FILM_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

// cosine: with the facet's normal; eta: of the film over what is around it; thickness in nm.
template <int W>
KN_INLINE Rgb<W> filmReflectance(const lobes::FilmTable& table, Float<W> cosine, Float<W> eta, Float<W> thickness) {
  using F = Float<W>;
  using lobes::FilmTable;
  const F c = clamp(cosine, F(0.f), F(1.f)), inside = safeSqrt(F(1.f) - fnma(c, c, F(1.f)) / (eta * eta));
  const F rs = (c - eta * inside) / max(fma(eta, inside, c), F(1e-6f));
  const F rp = (eta * c - inside) / max(fma(eta, c, inside), F(1e-6f));
  const F s = rs * rs, p = rp * rp, step = F(2.f / FilmTable::kStep) * eta * thickness * inside;
  const F shareS = (F(1.f) - s) / (F(1.f) + s), shareP = (F(1.f) - p) / (F(1.f) + p);
  Rgb<W> sum;
  F powerS = shareS, powerP = shareP, at = step;
  for (int m = 0; m < 8; ++m) {
    powerS = powerS * s;
    powerP = powerP * p;
    const F x = min(at, F(float(FilmTable::kCount - 2))), whole = floor(x), t = x - whole;
    const Int<W> cell = toInt(whole);
    const Mask<W> coherent = at < F(float(FilmTable::kCount - 2));
    const F both = zeroUnless(coherent, powerS + powerP);
    sum += Rgb<W>(tableLine(table.seen[0], cell, t), tableLine(table.seen[1], cell, t),
                  tableLine(table.seen[2], cell, t)) *
           both;
    at = at + step;
  }
  // the two polarisations' mean, and each term of the sum twice
  const F none(0.f), one(1.f), flat = one - F(0.5f) * (shareS + shareP);
  return {clamp(flat - sum.x, none, one), clamp(flat - sum.y, none, one), clamp(flat - sum.z, none, one)};
}

// Set-up code, on 8 lanes always (microfacet.h). The observer is Wyman, Sloan and Shirley's fit of CIE 1931 (JCGT
// 2013), in Rec. 709; each channel is scaled to see 1 of light of equal energy.
inline void buildFilm(lobes::FilmTable& table) {
  using F = Float<8>;
  using lobes::FilmTable;
  constexpr int kWaves = 80;
  const auto bell = [](float nm, float height, float middle, float below, float above) {
    const float t = (nm - middle) * (nm < middle ? below : above);
    return height * exp(F(-0.5f * t * t)).lane0();
  };
  float weight[3][kWaves], total[3] = {0, 0, 0}, wave[kWaves];
  for (int i = 0; i < kWaves; ++i) {
    const float nm = 382.5f + 5.f * float(i);
    wave[i] = nm;
    const float x = bell(nm, 0.362f, 442.f, 0.0624f, 0.0374f) + bell(nm, 1.056f, 599.8f, 0.0264f, 0.0323f) +
                    bell(nm, -0.065f, 501.1f, 0.0490f, 0.0382f);
    const float y = bell(nm, 0.821f, 568.8f, 0.0213f, 0.0247f) + bell(nm, 0.286f, 530.9f, 0.0613f, 0.0322f);
    const float z = bell(nm, 1.217f, 437.f, 0.0845f, 0.0278f) + bell(nm, 0.681f, 459.f, 0.0385f, 0.0725f);
    weight[0][i] = 3.2406f * x - 1.5372f * y - 0.4986f * z;
    weight[1][i] = -0.9689f * x + 1.8758f * y + 0.0415f * z;
    weight[2][i] = 0.0557f * x - 0.2040f * y + 1.0570f * z;
    for (int k = 0; k < 3; ++k) total[k] += weight[k][i];
  }
  for (int n = 0; n < FilmTable::kCount; n += 8) {
    F sum[3] = {F(0.f), F(0.f), F(0.f)};
    const F x = F::lanes(float(n)) * F(FilmTable::kStep);
    for (int i = 0; i < kWaves; ++i) {
      const F turns = x * F(1.f / wave[i]);
      F s, c;
      sincos((turns - floor(turns)) * F(kTwoPi), s, c);
      for (int k = 0; k < 3; ++k) sum[k] += c * F(weight[k][i] / total[k]);
    }
    for (int k = 0; k < 3; ++k) sum[k].store(table.seen[k] + n);
  }
}
inline const lobes::FilmTable& filmTable() { return builtTable<lobes::FilmTable, buildFilm>(); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
