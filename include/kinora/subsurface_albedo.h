// Half spaces: what one scattering must keep for a surface to have an albedo, and how long free flights are for light
// to reach so far. Used by materials that scatter below their surface; plain code. Light enters by a cosine's law, as
// it does in subsurface.h.
#pragma once
#include <cmath>

namespace kinora {

// Largest Subsurface::tail that the numbers below are good for.
inline constexpr float kMostTail = 0.75f;

namespace half_space {
// Made by tools/make_subsurface_albedo.py: what is missing to van de Hulst's formula, divided by s (1 - s), by powers
// of s and of the mean cosine, and of s and the tail (from its first power on).
inline constexpr double kAnisotropyFit[6][6] = {
    {-0.00130788, 0.0053478, 0.0185712, -0.0377434, -0.0310478, 0.0520568},
    {0.03196, -0.160072, -0.504959, 1.10938, 0.885668, -1.51308},
    {-0.0886417, 0.589439, 2.15112, -4.93823, -2.4576, 5.52594},
    {0.192287, -1.26922, -2.98516, 7.98204, 2.33759, -7.98608},
    {-0.143236, 0.987148, 1.84257, -5.33068, -0.588935, 5.04581},
    {0.0394017, -0.281263, -0.503225, 1.20273, -0.126502, -1.11301},
};
inline constexpr double kTailFit[4][3] = {
    {-0.528681, -0.0378555, 0.0686018},
    {0.264013, 0.400898, -0.197258},
    {0.0330845, -1.60768, 0.959756},
    {0.0900785, 0.499907, -0.288944},
};
template <int kRows, int kColumns>
double polynomial(const double (&c)[kRows][kColumns], double x, double y) {
  double sum = 0;
  for (int i = kRows; i-- > 0;) {
    double row = 0;
    for (int j = kColumns; j-- > 0;) row = row * y + c[i][j];
    sum = sum * x + row;
  }
  return sum;
}
}  // namespace half_space

// sqrt((1 - a) / (1 - a g)) of a half space of that albedo, a being what one scattering keeps; van de Hulst,
// "Multiple Light Scattering" (1980), volume 2, corrected by the fits.
inline double similarity(double albedo, double g, double tail) {
  const double b = 1.139 + 1.17 * albedo;
  const double s = (b - std::sqrt(b * b - 4 * 0.139 * (1 - albedo))) / 0.278;
  const double sum = half_space::polynomial(half_space::kAnisotropyFit, s, g) +
                     tail * half_space::polynomial(half_space::kTailFit, s, tail);
  const double found = s + s * (1 - s) * sum;
  return found > 0 ? found < 1 ? found : 1 : 0;
}

// What one scattering keeps, [0, 1].
inline float singleScatteringAlbedo(float surfaceAlbedo, float g, float tail = 0) {
  const double s = similarity(surfaceAlbedo, g, tail), s2 = s * s;
  return float((1 - s2) / (1 - g * s2));
}

// The mean free path in a medium whose light reaches as far as the diffuse mean free path says: sigma_t' sqrt(3 (1 -
// a') / (2 - a')) is one over that (Grosjean 1956; d'Eon and Irving 2011), in the isotropic medium that is similar.
// Towards an albedo of 1 the flights would shrink to nothing: they are never shorter than 1/24 of the diffuse one.
inline float meanFreePath(float diffuse, float scatteringAlbedo, float g) {
  const float similar = scatteringAlbedo * (1 - g) / (1 - scatteringAlbedo * g);
  const float ratio = std::sqrt(3 * (1 - similar) / (2 - similar));
  return diffuse * (ratio > 1.f / 24 ? ratio : 1.f / 24) * (1 - scatteringAlbedo * g);
}

}  // namespace kinora
