// Profiles of diffusion: how light that enters a plane surface at a point comes out around it. Burley's normalised
// profile (Christensen and Burley, "Approximate reflectance profiles for efficient subsurface scattering", Pixar 2015),
// the dipole of Jensen, Marschner, Levoy and Hanrahan (SIGGRAPH 2001) and the better dipole of d'Eon (2012). Used by
// subsurface.h; set up by point in plain code, evaluated wide. All are scaled to integrate to 1 over the plane. Included
// per target.
#include <kinora/bxdf.h>
#include <kinora/math/sampling.h>

#ifndef KINORA_SUBSURFACE_PROFILES_ONCE
#define KINORA_SUBSURFACE_PROFILES_ONCE
#include <cmath>
namespace kinora {
// Diffuse mean free path over the length of Burley's profile: the exponential of its tail is three of the latter.
inline float burleyScale(float albedo) {
  const float x = albedo - 0.33f, x2 = x * x;
  return 3.5f + 100 * x2 * x2;
}

// One dipole: flux * sum of z (1 + s d) e^(-s d) / d^3 and fluence * difference of e^(-s d) / d, of the real source at
// the depth z and of the one that mirrors it.
struct Dipole {
  float decay, depth, mirrored, flux, fluence;
};

// Moments of a boundary's reflectance from inside: integral of R mu^n.
struct BoundaryMoments {
  double first = 0, second = 0;
  explicit BoundaryMoments(double ior) {
    constexpr int kSteps = 256;
    for (int i = 0; i < kSteps; ++i) {
      const double mu = (i + 0.5) / kSteps, sin2 = ior * ior * (1 - mu * mu);
      double r = 1;
      if (sin2 < 1) {
        const double out = std::sqrt(1 - sin2), a = (ior * mu - out) / (ior * mu + out),
                     b = (mu - ior * out) / (mu + ior * out);
        r = 0.5 * (a * a + b * b);
      }
      first += r * mu / kSteps;
      second += r * mu * mu / kSteps;
    }
  }
};

// In units of 1 / sigma_t', what a medium of a reduced albedo returns, and the dipole that does it.
inline double dipoleAlbedo(bool better, double reduced, const BoundaryMoments& m, Dipole* out = nullptr) {
  const double a = 1 - reduced;  // sigma_a
  double diffusion = 1.0 / 3, bound, flux = 1, fluence = 0, scale = reduced;
  if (better) {
    diffusion = (1 + a) / 3;
    bound = 2 * diffusion * (1 + 3 * m.second) / (1 - 2 * m.first);
    flux = 0.5 * (1 - 3 * m.second);
    fluence = 0.25 * (1 - 2 * m.first) / diffusion;
    scale = reduced * reduced;
  } else {
    bound = 2 * diffusion * (1 + 2 * m.first) / (1 - 2 * m.first);
  }
  const double decay = std::sqrt(a / diffusion), depth = 1, mirrored = 1 + 2 * bound;
  const double real = std::exp(-decay * depth), other = std::exp(-decay * mirrored);
  if (out) *out = {float(decay), float(depth), float(mirrored), float(flux), float(fluence)};
  // the flux of a source integrates to 2 pi e^(-s z), its fluence to 2 pi e^(-s z) / s
  return scale * 0.5 * (flux * (real + other) + (decay > 0 ? fluence * (real - other) / decay : 0.));
}

// The dipole of a surface with that albedo whose light decays over a length of 1.
inline Dipole makeDipole(bool better, float albedo, const BoundaryMoments& m) {
  double low = 1e-4, high = 0.9999;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (dipoleAlbedo(better, middle, m) < double(albedo) ? low : high) = middle;
  }
  Dipole d;
  dipoleAlbedo(better, low, m, &d);
  // from free paths to lengths of decay
  const double pi = 3.14159265358979324, unit = double(d.decay);
  const double real = std::exp(-double(d.decay * d.depth)), other = std::exp(-double(d.decay * d.mirrored));
  const double fluence = double(d.fluence) / unit;
  const double whole = 2 * pi * (double(d.flux) * (real + other) + fluence * (real - other));
  return {1, float(d.depth * unit), float(d.mirrored * unit), float(double(d.flux) / whole), float(fluence / whole)};
}
inline Dipole stretched(const Dipole& d, float length) {
  return {d.decay / length, d.depth * length, d.mirrored * length, d.flux, d.fluence / length};
}
}  // namespace kinora
#endif

#if defined(KINORA_SUBSURFACE_PROFILES_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SUBSURFACE_PROFILES_H_TARGET
#undef KINORA_SUBSURFACE_PROFILES_H_TARGET
#else
#define KINORA_SUBSURFACE_PROFILES_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Burley's profile, per area at the distance r from where light went in; also the density by which distances are
// taken for all profiles: two exponentials, d and 3 d long.
template <int W>
KN_INLINE Float<W> burleyProfile(Float<W> d, Float<W> r) {
  using F = Float<W>;
  const F x = max(r / d, F(1e-4f));
  return (exp(-x) + exp(-(x * F(1.f / 3.f)))) / (F(8.f * kPi) * d * d * x);
}
template <int W>
KN_INLINE Float<W> sampleBurleyProfile(Float<W> d, Float<W> which, Float<W> u) {
  return -log(Float<W>(1.f) - u) * select(which < Float<W>(0.25f), d, d * Float<W>(3.f));
}
template <int W>
KN_INLINE Float<W> dipoleProfile(Float<W> decay, Float<W> depth, Float<W> mirrored, Float<W> flux, Float<W> fluence,
                                 Float<W> r) {
  using F = Float<W>;
  const F r2 = r * r, a = sqrt(fma(depth, depth, r2)), b = sqrt(fma(mirrored, mirrored, r2));
  const F ea = exp(-(decay * a)) / a, eb = exp(-(decay * b)) / b;
  const F one(1.f);
  return flux * (depth * fma(decay, a, one) * ea / (a * a) + mirrored * fma(decay, b, one) * eb / (b * b)) +
         fluence * (ea - eb);
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
