// Half spaces: what one scattering must keep for a surface to have an albedo, and how long free flights are for light
// to reach so far. Used by materials that scatter below their surface; plain code. Light enters by a cosine's law, as
// it does in subsurface.h.
#pragma once
#include <cmath>

namespace kinora {

// Largest Subsurface::tail that the numbers below are good for.
inline constexpr float kMostTail = 0.75f;

// What the boundary of a dielectric lets through of light that arrives by a cosine's law, from outside: the integral of
// 2 mu (1 - F) over the cosine mu.
inline double diffuseTransmittance(double ior) {
  constexpr int kSteps = 128;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double mu = (i + 0.5) / kSteps, inside = std::sqrt(1 - (1 - mu * mu) / (ior * ior));
    const double a = (mu - ior * inside) / (mu + ior * inside), b = (ior * mu - inside) / (ior * mu + inside);
    sum += 2 * mu * (1 - 0.5 * (a * a + b * b)) / kSteps;
  }
  return sum;
}

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
// And with a boundary, of s, the mean cosine and, from its first power on, sqrt(1 - 1 / ior^2). Of albedos above 0.02
// it is off by 3 % at most up to an index of 1.7 and mean cosines of 0.8, by 8 % in the corners beyond.
inline constexpr double kBoundaryFit[3][6][6] = {
    {
        {0.0314949258, -0.138931654, -0.708534294, 0.233662722, 1.15572137, -0.00487012483},
        {-0.315050048, 1.68766336, 4.98436907, 5.48124933, -1.74854521, -22.3554101},
        {-0.299275646, -3.00758855, -6.69806828, -84.5473435, -11.0603514, 181.321568},
        {1.1305677, -2.91019127, 6.03534783, 255.61005, 16.2085269, -471.565568},
        {-0.874520133, 7.63680196, -12.9618677, -287.967394, 10.6080842, 503.639732},
        {0.134674004, -3.5092136, 9.32737744, 110.915029, -16.2273831, -191.890837},
    },
    {
        {-0.118606248, 0.555022872, 2.85697228, 0.368606157, -2.77340685, -0.0100295388},
        {-1.24234181, -4.64566496, -11.9558012, -61.6264161, -45.5164346, 114.238191},
        {5.46754259, -8.188698, -32.0236661, 609.943341, 355.617392, -897.699073},
        {-12.7642631, 58.8660322, 100.338855, -1693.62467, -774.457488, 2256.46359},
        {10.1427093, -82.3564546, -46.32489, 1857.40435, 668.260311, -2334.97829},
        {-2.39771138, 32.7977285, -16.2897111, -714.327908, -197.720123, 865.307243},
    },
    {
        {0.0780580656, -0.372974423, -1.67151403, -0.764124428, 0.83021694, 0.64813031},
        {1.44816755, -0.89959173, -16.650147, 79.4192033, 92.3234788, -142.278484},
        {-8.77191727, 40.766502, 194.901597, -700.988652, -576.796458, 1009.1094},
        {19.7524364, -139.146971, -458.94348, 1810.48876, 1210.47656, -2369.69267},
        {-15.7510213, 167.247476, 410.685933, -1873.43274, -1075.34454, 2320.43958},
        {3.73295038, -67.3396687, -125.801425, 688.523306, 346.237519, -821.366761},
    },
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
// "Multiple Light Scattering" (1980), volume 2, corrected by the fits. ior: of the boundary that light goes in and
// comes out by (subsurface.h), up to kMostIor.
inline constexpr double kMostIor = 2;
inline double similarity(double albedo, double g, double tail, double ior = 1) {
  const auto plain = [&](double a) {
    const double b = 1.139 + 1.17 * a;
    const double s = (b - std::sqrt(b * b - 4 * 0.139 * (1 - a))) / 0.278;
    const double sum = half_space::polynomial(half_space::kAnisotropyFit, s, g) +
                       tail * half_space::polynomial(half_space::kTailFit, s, tail);
    const double found = s + s * (1 - s) * sum;
    return found > 0 ? found < 1 ? found : 1 : 0;
  };
  if (!(ior > 1)) return plain(albedo);
  // of light that is diffuse inside, so much comes out at once of what arrives there; the rest is reflected, again and
  // again (Saunderson 1942)
  const double out = diffuseTransmittance(ior) / (ior * ior), s = plain(albedo / (out + (1 - out) * albedo));
  const double y = std::sqrt(1 - 1 / (ior * ior));
  double sum = 0;
  for (int k = 3; k-- > 0;) sum = (sum + half_space::polynomial(half_space::kBoundaryFit[k], s, g)) * y;
  const double found = s + s * (1 - s) * sum;
  return found > 0 ? found < 1 ? found : 1 : 0;
}

// What one scattering keeps, [0, 1].
inline float singleScatteringAlbedo(float surfaceAlbedo, float g, float tail = 0, float ior = 1) {
  const double s = similarity(surfaceAlbedo, g, tail, ior), s2 = s * s;
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
