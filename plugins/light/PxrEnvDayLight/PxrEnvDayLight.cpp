// PxrEnvDayLight: sky and sun by the model of Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight"
// (SIGGRAPH 1999): Perez' distribution of luminance and chromaticity over the sky for a turbidity, the sun's position
// from date and place, its light after Rayleigh and aerosol scattering (appendix A; ozone and water vapour are left
// out, they take a few percent of green and red).
//
// Orientation as of PxrDomeLight: the native frame is Z-up, and rotation and mirroring of the placement count. +X is
// north and +Y east, which makes east lie right of north where the placement turns a left-handed light space into the
// scene's world, as exporters do. Units: the model's luminance in kcd/m^2 times kUnit.
//
// Sampling: with probability pSun the sun's disc evenly in solid angle, else a cell of an equal-area grid over the
// sphere by what its mean radiance leaves to do (mis_compensation.h). The density is the mixture's, so both ways agree.
#define KINORA_KERNEL_FILE "plugins/light/PxrEnvDayLight/PxrEnvDayLight.cpp"
#include <kinora/light_setup.h>
#include <algorithm>
#include <memory>
#include <kinora/light_author.h>

#include "plugins/light/parts/mis_compensation.h"
#include "plugins/light/parts/sky_axes.h"
#include "plugins/light/parts/sky_kernel.h"

#if KINORA_PLAIN
namespace kinora::pxrEnvDayLight {
inline constexpr std::array kDay = {
    param::integer("month", 11).range(0, 12).help("1 to 12; 0: sunDirection says where the sun is."),
    param::integer("day", 20).range(1, 31).help("Day of the month."),
    param::integer("year", 2014).range(1900, 2100).help("Leap years have their day more."),
    param::number("hour", 14.633333f).range(0, 24).help("Local standard time, hours."),
    param::number("zone", -8.f).range(-12, 12).help("Hours by which local standard time is before UTC."),
    param::number("latitude", 47.6019f).range(-90, 90).help("Degrees north."),
    param::number("longitude", -122.3318f).range(-180, 180).help("Degrees east."),
    param::vector("sunDirection", 0, 1, 0).help("Towards the sun in the light's Z-up space, used where month is 0."),
    param::number("haziness", 2.f).range(1.7f, 10).help("Turbidity: 2 is a clear sky, 10 haze."),
    param::color("skyTint", 1.f).help("Factor on the sky's colour."),
    param::color("sunTint", 1.f).help("Factor on the sun's colour."),
    param::number("sunSize", 1.f)
        .range(0, 10)
        .help("Of the sun's disc, 1 is 0.55 degrees; its power stays the same."),
    param::integer("groundMode", 0)
        .range(0, 2)
        .options("0 horizon's colour, 1 the same, 2 diffuse ground")
        .help("What is seen below the horizon."),
    param::color("groundColor", 0.18f).help("Fraction of sky and sun that the ground reflects."),
};
constexpr auto kParams = joinParams(lightParams::kRadiance, kDay, lightParams::kControl);
constexpr int32_t kRows = 32, kColumns = 32;  // of the grid; rows are even in z
constexpr double kPi = 3.14159265358979323846;
// As bright as the light of this name is in pictures that its users published: 300 klx are pi.
constexpr double kUnit = 3.14159265358979323846 / 300;

struct Perez {
  float a = 0, b = 0, c = 0, d = 0, e = 0, scale = 0;  // scale: value at the zenith over the distribution there
};
struct Data {
  LightCommon common;
  Float3 axis[3];  // local axes in render space: orthonormal, perhaps left-handed
  Perez luminance, x, y;
  Float3 sun{0, 0, 1};  // local
  float skyTint[3] = {1, 1, 1}, sunRadiance[3] = {0, 0, 0}, ground[3] = {0, 0, 0};
  float sunOneMinusCos = 0;  // of the disc's half angle; 0: no sun
  float sunShare = 0;        // pSun
  bool horizonBelow = false;
  std::vector<float> rowCdf, cellCdf, density;  // kRows + 1, kRows (kColumns + 1), kRows kColumns
  double meanRadiance = 0;                      // over directions and RGB
  double sampledMean = 0;                       // what samples are made for, as a mean radiance
  Double3 meanDirection;                        // towards the light, weighted by that
  bool isBlack = true;
};
}  // namespace kinora::pxrEnvDayLight
#endif

KINORA_KERNELS_BEGIN
using namespace pxrEnvDayLight;

// Largest i in [0, n) with cdf[offset + i] <= u; n is a power of two.
template <int W>
KN_INLINE Int<W> find(const float* cdf, Int<W> offset, int32_t n, Float<W> u) {
  using I = Int<W>;
  I low(0);
  for (int32_t step = n / 2; step; step /= 2) {
    const I next = low + I(step);
    low = select(gather(cdf, offset + next) <= u, next, low);
  }
  return low;
}

template <int W>
KN_INLINE Float<W> perez(const Perez& p, Float<W> inverseCosine, Float<W> gamma, Float<W> cos2Gamma) {
  using F = Float<W>;
  const F up = fma(F(p.a), exp(F(p.b) * inverseCosine), F(1.f));
  const F round = fma(F(p.c), exp(F(p.d) * gamma), fma(F(p.e), cos2Gamma, F(1.f)));
  return F(p.scale) * up * round;
}

struct PxrEnvDayLight : DirectionalLight<PxrEnvDayLight, pxrEnvDayLight::Data> {
  // Sky and ground without the sun's disc, local direction.
  template <int W>
  static KN_INLINE Rgb<W> sky(const Data& k, Vec3<W> l) {
    using F = Float<W>;
    const F one(1.f), zero(0.f), cosine = max(l.z, F(0.002f));
    // below the horizon the sky's values are those at it
    const F flat = F(1.f) / max(sqrt(fma(l.x, l.x, l.y * l.y)), F(1e-12f));
    const Mask<W> below = l.z < zero;
    const Vec3<W> at = select(below, Vec3<W>(l.x * flat, l.y * flat, zero), l);
    const F cosGamma = clamp(dot(at, wide<W>(k.sun)), -one, one), gamma = acos(cosGamma), cos2 = cosGamma * cosGamma;
    const F inverse = one / cosine;
    const F Y = perez(k.luminance, inverse, gamma, cos2), x = perez(k.x, inverse, gamma, cos2);
    const F y = max(perez(k.y, inverse, gamma, cos2), F(0.02f));
    const F X = x / y * Y, Z = (one - x - y) / y * Y;
    // CIE XYZ to linear Rec. 709 (IEC 61966-2-1); what lies outside the gamut is cut
    Rgb<W> c(max(fma(F(3.2404542f), X, fma(F(-1.5371385f), Y, F(-0.4985314f) * Z)), zero),
             max(fma(F(-0.969266f), X, fma(F(1.8760108f), Y, F(0.041556f) * Z)), zero),
             max(fma(F(0.0556434f), X, fma(F(-0.2040259f), Y, F(1.0572252f) * Z)), zero));
    c = c * wideRgb<W>(k.skyTint);
    return k.horizonBelow ? c : select(below, wideRgb<W>(k.ground), c);
  }

  // Radiance and density in one direction: sample, evaluate and emit all come here, so that they cannot disagree.
  template <int W>
  static KN_INLINE void at(const Data& k, Vec3<W> d, Rgb<W>& radiance, Float<W>& pdf) {
    using F = Float<W>;
    using I = Int<W>;
    const Vec3<W> l = toSky<W>(k.axis, d);
    radiance = sky<W>(k, l);
    pdf = F(0.f);
    if (!k.density.empty()) {
      const F turn = atan2(l.y, l.x) * F(kInvTwoPi), u = select(turn < F(0.f), turn + F(1.f), turn);
      const F v = fma(l.z, F(0.5f), F(0.5f));
      const I column = toInt(clamp(u * F(float(kColumns)), F(0.f), F(float(kColumns - 1))));
      const I row = toInt(clamp(v * F(float(kRows)), F(0.f), F(float(kRows - 1))));
      pdf = gather(k.density.data(), row * I(kColumns) + column);
    }
    if (k.sunOneMinusCos > 0) {
      // the chord tells small angles with all their digits
      const Vec3<W> off = l - wide<W>(k.sun);
      const Mask<W> inSun = dot(off, off) <= F(2 * k.sunOneMinusCos * (1 + 1e-4f));
      radiance += zeroUnless(inSun, wideRgb<W>(k.sunRadiance));
      pdf = fma(zeroUnless(inSun, F(kInvTwoPi / k.sunOneMinusCos)), F(k.sunShare), pdf * F(1.f - k.sunShare));
    }
    radiance = radiance * wideRgb<W>(k.common.radiance);
  }
  template <int W>
  static KN_INLINE Vec3<W> direction(const Data& k, Float<W> u, Float<W> v) {
    using F = Float<W>;
    using I = Int<W>;
    const F one(1.f), share(k.sunShare);
    const Mask<W> toSun = u < share;
    u = clamp(select(toSun, u / F(k.sunShare > 0 ? k.sunShare : 1.f), (u - share) / F(1.f - k.sunShare)), F(0.f),
              F(0.99999994f));
    const I row = find<W>(k.rowCdf.data(), I(0), kRows, v);
    const F r0 = gather(k.rowCdf.data(), row), r1 = gather(k.rowCdf.data(), row + I(1));
    const F up = clamp((v - r0) / max(r1 - r0, F(1e-30f)), F(0.f), one);
    const I start = row * I(kColumns + 1);
    const I column = find<W>(k.cellCdf.data(), start, kColumns, u);
    const F c0 = gather(k.cellCdf.data(), start + column), c1 = gather(k.cellCdf.data(), start + column + I(1));
    const F across = clamp((u - c0) / max(c1 - c0, F(1e-30f)), F(0.f), one);
    const F z = fma(toFloat(row) + up, F(2.f / float(kRows)), -one), s = safeSqrt(fnma(z, z, one));
    F sine, cosine;
    sincos((toFloat(column) + across) * F(kTwoPi / float(kColumns)), sine, cosine);
    Vec3<W> l(s * cosine, s * sine, z);
    if (k.sunShare > 0) {
      const Frame<W> disc(wide<W>(k.sun));
      l = select(toSun, disc.toWorld(uniformCone(u, v, F(k.sunOneMinusCos))), l);
    }
    return normalize(fromSky<W>(k.axis, l));
  }
};

KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora {
namespace {
using pxrEnvDayLight::Data;
using pxrEnvDayLight::kColumns;
using pxrEnvDayLight::kPi;
using pxrEnvDayLight::kRows;
using pxrEnvDayLight::kUnit;
using pxrEnvDayLight::Perez;

// Local direction to the sun (+X north, +Y east, +Z up) by the paper's appendix A.6.
Double3 sunOf(const NamedValues& v) {
  if (v.integer("month") == 0) {
    const Double3 d =
        normalized({v.number("sunDirection", 0), v.number("sunDirection", 1), v.number("sunDirection", 2)});
    return length(d) > 0 ? d : Double3{0, 0, 1};
  }
  static constexpr int kBefore[12] = {0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334};
  const int month = std::clamp(v.integer("month"), 1, 12), year = v.integer("year");
  const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  const double J = kBefore[month - 1] + std::clamp(v.integer("day"), 1, 31) + (leap && month > 2 ? 1 : 0);
  const double solar = v.number("hour") + 0.170 * std::sin(4 * kPi * (J - 80) / 373) -
                       0.129 * std::sin(2 * kPi * (J - 8) / 355) +
                       (v.number("longitude") - 15 * v.number("zone")) / 15;
  const double declination = 0.4093 * std::sin(2 * kPi * (J - 81) / 368), angle = kPi * (solar - 12) / 12;
  const double latitude = v.number("latitude") * kPi / 180, sl = std::sin(latitude), cl = std::cos(latitude);
  const double sd = std::sin(declination), cd = std::cos(declination);
  return {cl * sd - sl * cd * std::cos(angle), -cd * std::sin(angle), sl * sd + cl * cd * std::cos(angle)};
}

double distribution(const Perez& p, double theta, double gamma) {
  return (1 + p.a * std::exp(p.b / std::fmax(std::cos(theta), 0.002))) *
         (1 + p.c * std::exp(p.d * gamma) + p.e * std::cos(gamma) * std::cos(gamma));
}

// The paper's table 2 (appendix A.2). s: the sun's angle from the zenith.
void setSky(Data& k, double T, double s) {
  const auto set = [&](Perez& p, const double m[5][2], double zenith) {
    float* const out[5] = {&p.a, &p.b, &p.c, &p.d, &p.e};
    for (int i = 0; i < 5; ++i) *out[i] = float(m[i][0] * T + m[i][1]);
    p.scale = float(zenith / distribution(p, 0, s));
  };
  static constexpr double kY[5][2] = {
      {0.1787, -1.4630}, {-0.3554, 0.4275}, {-0.0227, 5.3251}, {0.1206, -2.5771}, {-0.0670, 0.3703}};
  static constexpr double kx[5][2] = {
      {-0.0193, -0.2592}, {-0.0665, 0.0008}, {-0.0004, 0.2125}, {-0.0641, -0.8989}, {-0.0033, 0.0452}};
  static constexpr double ky[5][2] = {
      {-0.0167, -0.2608}, {-0.0950, 0.0092}, {-0.0079, 0.2102}, {-0.0441, -1.6537}, {-0.0109, 0.0529}};
  const double chi = (4.0 / 9 - T / 120) * (kPi - 2 * s);
  const double Y = std::fmax(0, (4.0453 * T - 4.9710) * std::tan(chi) - 0.2155 * T + 2.4192);
  const double s2 = s * s, s3 = s2 * s;
  const double x = T * T * (0.00166 * s3 - 0.00375 * s2 + 0.00209 * s) +
                   T * (-0.02903 * s3 + 0.06377 * s2 - 0.03202 * s + 0.00394) +
                   (0.11693 * s3 - 0.21196 * s2 + 0.06052 * s + 0.25886);
  const double y = T * T * (0.00275 * s3 - 0.00610 * s2 + 0.00317 * s) +
                   T * (-0.04214 * s3 + 0.08970 * s2 - 0.04153 * s + 0.00516) +
                   (0.15346 * s3 - 0.26756 * s2 + 0.06670 * s + 0.26688);
  set(k.luminance, kY, Y * kUnit);
  set(k.x, kx, x);
  set(k.y, ky, y);
}

// Irradiance of the sun on a surface that faces it, in the light's units: 128 klx above the atmosphere (the solar
// illuminance constant), with the colour of a black body of 5778 K at wavelengths that stand for Rec. 709's
// primaries, behind the paper's Rayleigh and Angstrom turbidity terms (appendix A.1; Iqbal 1983).
void sunIrradiance(double T, double elevation, double rgb[3]) {
  constexpr double kLambda[3] = {0.610, 0.549, 0.467};  // micrometres
  const double degrees = 90 - elevation * 180 / kPi;
  const double mass = 1 / (std::sin(elevation) + 0.15 * std::pow(93.885 - degrees, -1.253));
  const std::array<double, 3> body = blackbody(5778);
  const double beta = std::fmax(0, 0.04608 * T - 0.04586);
  for (int c = 0; c < 3; ++c) {
    const double rayleigh = std::exp(-0.008735 * std::pow(kLambda[c], -4.08) * mass);
    const double aerosol = std::exp(-beta * std::pow(kLambda[c], -1.3) * mass);
    rgb[c] = 128 * kUnit * body[size_t(c)] * rayleigh * aerosol;
  }
}

// The grid's cells by the light's own evaluate (without sun and density yet), four places each way in a cell.
void buildGrid(Data& k, double skyIrradiance[3]) {
  constexpr int kPlaces = 4;
  using Runner = HWY_NAMESPACE::LightRunner<HWY_NAMESPACE::PxrEnvDayLight>;
  constexpr LightFunctions kOwn = Runner::table<1>();
  std::vector<float> d[3], rgb[3], pdf(kColumns * kPlaces), o(kColumns * kPlaces, 0.f);
  for (int c = 0; c < 3; ++c) {
    d[c].resize(kColumns * kPlaces);
    rgb[c].resize(kColumns * kPlaces);
    skyIrradiance[c] = 0;
  }
  std::vector<double> cell(size_t(kRows) * kColumns, 0.0);
  k.meanDirection = {};
  for (int row = 0; row < kRows; ++row)
    for (int place = 0; place < kPlaces; ++place) {
      const double z = 2 * (row + (place + 0.5) / kPlaces) / kRows - 1, s = std::sqrt(1 - z * z);
      for (int i = 0; i < kColumns * kPlaces; ++i) {
        const double turn = 2 * kPi * (i + 0.5) / (kColumns * kPlaces);
        const Double3 l = lightParts::inRender(k.axis, {s * std::cos(turn), s * std::sin(turn), z});
        d[0][size_t(i)] = float(l.x);
        d[1][size_t(i)] = float(l.y);
        d[2][size_t(i)] = float(l.z);
      }
      LightRayArgs a{};
      const void* light = &k;
      a.light = &light;
      a.count = kColumns * kPlaces;
      for (int c = 0; c < 3; ++c) {
        a.o[c] = o.data();
        a.d[c] = d[c].data();
        a.radiance[c] = rgb[c].data();
      }
      a.pdf = pdf.data();
      kOwn.evaluate(&a);
      for (int i = 0; i < kColumns * kPlaces; ++i) {
        double mean = 0;
        for (int c = 0; c < 3; ++c) {
          mean += std::fabs(double(rgb[c][size_t(i)])) / 3;
          if (z > 0) skyIrradiance[c] += rgb[c][size_t(i)] * z;
        }
        cell[size_t(row) * kColumns + size_t(i / kPlaces)] += mean / (kPlaces * kPlaces);
      }
    }
  const double cells = double(kRows) * kColumns;
  for (int c = 0; c < 3; ++c) skyIrradiance[c] *= 4 * kPi / (cells * kPlaces * kPlaces);
  const std::vector<double> solid(kRows, 4 * kPi / cells);
  lightParts::Cells sphere{cell, solid, kColumns};
  k.meanRadiance = sphere.mean();
  k.density.clear();
  k.sampledMean = 0;
  if (!(k.meanRadiance > 0) || !std::isfinite(k.meanRadiance)) return;
  sphere.compensate(k.meanRadiance);
  k.sampledMean = sphere.mean();
  double total = k.sampledMean * cells;
  for (int row = 0; row < kRows; ++row)
    for (int i = 0; i < kColumns; ++i) {
      const double z = 2 * (row + 0.5) / kRows - 1, s = std::sqrt(1 - z * z), turn = 2 * kPi * (i + 0.5) / kColumns;
      const double share = cell[size_t(row) * kColumns + size_t(i)] / total;
      k.meanDirection =
          k.meanDirection + lightParts::inRender(k.axis, {s * std::cos(turn), s * std::sin(turn), z}) * share;
    }
  // none without density: a cell's places may all have missed a bright corner
  for (double& x : cell) x += 0.01 * total / cells;
  total *= 1.01;
  double below = 0;
  k.rowCdf.assign(1, 0.f);
  k.cellCdf.clear();
  for (int row = 0; row < kRows; ++row) {
    const double* line = &cell[size_t(row) * kColumns];
    double sum = 0, left = 0;
    for (int i = 0; i < kColumns; ++i) sum += line[i];
    k.cellCdf.push_back(0);
    for (int i = 0; i < kColumns; ++i) {
      left += line[i];
      k.cellCdf.push_back(i + 1 == kColumns ? 1.f : float(left / sum));
      k.density.push_back(float(line[i] / total * cells / (4 * kPi)));
    }
    below += sum;
    k.rowCdf.push_back(row + 1 == kRows ? 1.f : float(below / total));
  }
}

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues values(info, pxrEnvDayLight::kParams.data(), pxrEnvDayLight::kParams.size());
  const LocalFrame frame = LocalFrame::of(info);
  auto light = std::make_unique<Data>();
  light->common = LightCommon::of(values, -1);
  values.warnNoEffect();
  if (!lightParts::setSkyAxes(frame, light->axis)) {
    values.warn("LIGHT-DEGENERATE", "the light's transformation leaves it no directions", "the light is black");
    return light;
  }
  light->isBlack = light->common.isBlack();
  if (light->isBlack) return light;
  const double haze = std::clamp(values.number("haziness"), 1.7, 10.0);
  Double3 sun = sunOf(values);
  const double height = std::asin(std::clamp(sun.z, -1.0, 1.0));
  // the model ends at the horizon: the sky after sunset is that of sunset, which fades over civil twilight (6
  // degrees)
  double dusk = 1;
  if (height < 0) {
    values.warn("LIGHT-SUN-SET", "the sun stands below the horizon", "the sky is that of dusk, without the sun");
    dusk = std::fmax(0.01, 1 + height / (6 * kPi / 180));
    const double flat = std::hypot(sun.x, sun.y);
    sun = flat > 1e-6 ? Double3{sun.x / flat, sun.y / flat, 0} : Double3{1, 0, 0};
  }
  light->sun = Float3(sun);
  setSky(*light, haze, kPi / 2 - std::fmax(0, height));
  double sunE[3] = {0, 0, 0};
  const double half = 0.275 * kPi / 180 * std::fmin(100, std::fmax(0, values.number("sunSize")));
  const double oneMinusCos = 2 * std::pow(std::sin(half / 2), 2);
  double sunMean = 0;
  for (int c = 0; c < 3; ++c) light->skyTint[c] = float(values.number("skyTint", c) * dusk);
  if (height > 0 && half > 0) {
    sunIrradiance(haze, height, sunE);
    for (int c = 0; c < 3; ++c) {
      sunE[c] *= values.number("sunTint", c);
      // of a disc that is evenly bright
      light->sunRadiance[c] = float(sunE[c] / (2 * kPi * oneMinusCos));
      sunMean += std::fabs(sunE[c] * light->common.radiance[c]) / 3;
    }
  }
  light->horizonBelow = values.integer("groundMode") != 2;
  // twice: the ground reflects what the first round finds of the sky
  double skyE[3];
  buildGrid(*light, skyE);
  for (int c = 0; c < 3; ++c) {
    const double factor = light->common.radiance[c];
    const double sky = factor != 0 ? skyE[c] / factor : 0;
    light->ground[c] = float(values.number("groundColor", c) / kPi * (sky + sunE[c] * std::fmax(0, double(sun.z))));
  }
  if (!light->horizonBelow) buildGrid(*light, skyE);
  const double skyMean = light->sampledMean * 4 * kPi;
  if (light->density.empty() && !(sunMean > 0)) {
    light->isBlack = true;
    return light;
  }
  if (light->density.empty()) {  // the sun alone: the grid keeps a density for the mixture's other half
    light->density.assign(size_t(kRows) * kColumns, float(1 / (4 * kPi)));
    for (int i = 0; i <= kRows; ++i) light->rowCdf.push_back(float(i) / kRows);
    for (int row = 0; row < kRows; ++row)
      for (int i = 0; i <= kColumns; ++i) light->cellCdf.push_back(float(i) / kColumns);
  }
  if (sunMean > 0) {
    light->sunOneMinusCos = float(oneMinusCos);
    // by what each gives a surface: the sky's light comes from aslant
    light->sunShare = float(std::clamp(sunMean / (sunMean + 0.5 * skyMean), 0.05, 0.95));
    light->meanRadiance += sunMean / (4 * kPi);
    light->sampledMean += sunMean / (4 * kPi);
    const double share = sunMean / (4 * kPi * light->sampledMean);
    const Double3 towards = lightParts::inRender(light->axis, sun);
    light->meanDirection = light->meanDirection * (1 - share) + towards * share;
  }
  return light;
}

void describe(const void* data, LightDescription* d) {
  const Data& k = *static_cast<const Data*>(data);
  *d = describeInfiniteLight(k.common, k.isBlack, 4 * kPi * k.meanRadiance);
  d->sampledShare = k.meanRadiance > 0 ? float(k.sampledMean / k.meanRadiance) : 0.f;
  setAxis(*d, k.meanDirection);
}

}  // namespace
}  // namespace kinora
#endif

KINORA_LIGHT(PxrEnvDayLight,
             .help =
                 "Sky and sun by date and place, or by the sun's direction, after the daylight model of Preetham, "
                 "Shirley and Smits (1999). Z-up: local +Z is the zenith, +X north, +Y east. Only rotation and "
                 "mirroring of the placement count.",
             .params = pxrEnvDayLight::kParams, .setUp = setUpBy<make>, .describe = describe)
