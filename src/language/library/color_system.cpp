#include "language/library/color_system.h"

#include <cmath>

namespace kinora::language {
namespace {
struct Primaries {
  std::string_view name;
  float xr, yr, xg, yg, xb, yb, xw, yw;
};
constexpr float kC[2] = {0.3101f, 0.3162f}, kD65[2] = {0.3127f, 0.3291f}, kE[2] = {0.33333333f, 0.33333333f},
                kAces[2] = {0.32168f, 0.33767f};
constexpr Primaries kPrimaries[] = {
    {"Rec709", .64f, .33f, .30f, .60f, .15f, .06f, kD65[0], kD65[1]},
    {"sRGB", .64f, .33f, .30f, .60f, .15f, .06f, kD65[0], kD65[1]},
    {"NTSC", .67f, .33f, .21f, .71f, .14f, .08f, kC[0], kC[1]},
    {"EBU", .64f, .33f, .29f, .60f, .15f, .06f, kD65[0], kD65[1]},
    {"PAL", .64f, .33f, .29f, .60f, .15f, .06f, kD65[0], kD65[1]},
    {"SECAM", .64f, .33f, .29f, .60f, .15f, .06f, kD65[0], kD65[1]},
    {"SMPTE", .63f, .34f, .31f, .595f, .155f, .07f, kD65[0], kD65[1]},
    {"HDTV", .67f, .33f, .21f, .71f, .15f, .06f, kD65[0], kD65[1]},
    {"CIE", .7355f, .2645f, .2658f, .7243f, .1669f, .0085f, kE[0], kE[1]},
    {"AdobeRGB", .64f, .33f, .21f, .71f, .15f, .06f, kD65[0], kD65[1]},
    {"XYZ", 1, 0, 0, 1, 0, 0, kE[0], kE[1]},
    {"ACES2065-1", .7347f, .2653f, 0, 1, .0001f, -.077f, kAces[0], kAces[1]},
    {"ACEScg", .713f, .293f, .165f, .83f, .128f, .044f, kAces[0], kAces[1]},
};
// CIE 1931, 2 degrees, in units of 1e-4.
constexpr short kMatching[kWavelengths][3] = {
    {14, 0, 65},        {22, 1, 105},       {42, 1, 201},       {76, 2, 362},       {143, 4, 679},
    {232, 6, 1102},     {435, 12, 2074},    {776, 22, 3713},    {1344, 40, 6456},   {2148, 73, 10391},
    {2839, 116, 13856}, {3285, 168, 16230}, {3483, 230, 17471}, {3481, 298, 17826}, {3362, 380, 17721},
    {3187, 480, 17441}, {2908, 600, 16692}, {2511, 739, 15281}, {1954, 910, 12876}, {1421, 1126, 10419},
    {956, 1390, 8130},  {580, 1693, 6162},  {320, 2080, 4652},  {147, 2586, 3533},  {49, 3230, 2720},
    {24, 4073, 2123},   {93, 5030, 1582},   {291, 6082, 1117},  {633, 7100, 782},   {1096, 7932, 573},
    {1655, 8620, 422},  {2257, 9149, 298},  {2904, 9540, 203},  {3597, 9803, 134},  {4334, 9950, 87},
    {5121, 10000, 57},  {5945, 9950, 39},   {6784, 9786, 27},   {7621, 9520, 21},   {8425, 9154, 18},
    {9163, 8700, 17},   {9786, 8163, 14},   {10263, 7570, 11},  {10567, 6949, 10},  {10622, 6310, 8},
    {10456, 5668, 6},   {10026, 5030, 3},   {9384, 4412, 2},    {8544, 3810, 2},    {7514, 3210, 1},
    {6424, 2650, 0},    {5419, 2170, 0},    {4479, 1750, 0},    {3608, 1382, 0},    {2835, 1070, 0},
    {2187, 816, 0},     {1649, 610, 0},     {1212, 446, 0},     {874, 320, 0},      {636, 232, 0},
    {468, 170, 0},      {329, 119, 0},      {227, 82, 0},       {158, 57, 0},       {114, 41, 0},
    {81, 29, 0},        {58, 21, 0},        {41, 15, 0},        {29, 10, 0},        {20, 7, 0},
    {14, 5, 0},         {10, 4, 0},         {7, 2, 0},          {5, 2, 0},          {3, 1, 0},
    {2, 1, 0},          {2, 1, 0},          {1, 0, 0},          {1, 0, 0},          {1, 0, 0},
    {0, 0, 0}};

void cross(const float* a, const float* b, float* r) {
  for (int i = 0; i < 3; ++i) r[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}
float dot(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

ColorSystem build(const Primaries& p) {
  ColorSystem s;
  s.name = p.name;
  const float R[3] = {p.xr, p.yr, 1 - p.xr - p.yr}, G[3] = {p.xg, p.yg, 1 - p.xg - p.yg},
              B[3] = {p.xb, p.yb, 1 - p.xb - p.yb}, white[3] = {p.xw, p.yw, 1 - p.xw - p.yw};
  cross(G, B, s.xyzToRgb);
  cross(B, R, s.xyzToRgb + 3);
  cross(R, G, s.xyzToRgb + 6);
  for (int i = 0; i < 3; ++i) {
    float* row = s.xyzToRgb + 3 * i;
    const float w = dot(row, white) / white[1];
    for (int k = 0; k < 3; ++k) row[k] /= w;
  }
  // the inverse by cofactors: column i of it is the cross product of the two other rows over the determinant
  float c[3];
  for (int i = 0; i < 3; ++i) {
    cross(s.xyzToRgb + 3 * ((i + 1) % 3), s.xyzToRgb + 3 * ((i + 2) % 3), c);
    const float determinant = dot(s.xyzToRgb + 3 * i, c);
    for (int k = 0; k < 3; ++k) s.rgbToXyz[3 * k + i] = c[k] / determinant;
  }
  for (int i = 0; i < 3; ++i) s.luminance[i] = s.rgbToXyz[3 + i];
  const float rest = 1 - s.luminance[0] - s.luminance[1];
  if (std::fabs(rest - s.luminance[2]) < 0.001f) s.luminance[2] = rest;  // so that white is exactly 1
  for (int i = 0; i < kBlackbodySteps; ++i) {
    const std::array<float, 3> color = blackbodyColor(s, kBlackbodyLeast + 2 * float(i) * std::sqrt(float(i)));
    for (float component : color) s.blackbodyRoots.push_back(float(std::pow(double(component), 0.2)));
  }
  return s;
}
const std::vector<ColorSystem>& systems() {
  static const std::vector<ColorSystem> all = [] {
    std::vector<ColorSystem> list;
    for (const Primaries& p : kPrimaries) list.push_back(build(p));
    return list;
  }();
  return all;
}
}  // namespace

const ColorSystem* findColorSystem(std::string_view name) {
  for (const ColorSystem& s : systems())
    if (s.name == name) return &s;
  return nullptr;
}
static const ColorSystem* theDefault = nullptr;
const ColorSystem& defaultColorSystem() { return theDefault ? *theDefault : systems().front(); }
void setDefaultColorSystem(const ColorSystem& system) { theDefault = &system; }

// Planck's law over the matching functions.
std::array<float, 3> blackbodyColor(const ColorSystem& system, float kelvin) {
  const float* matching = matchingFunctions();
  float xyz[3] = {0, 0, 0};
  for (int i = 0; i < kWavelengths; ++i) {
    const double metres = (380 + 5 * i) * 1e-9;
    const float power = float(3.74183e-16 / (metres * metres * metres * metres * metres) /
                              (std::exp(1.4388e-2 / (metres * double(kelvin))) - 1));
    for (int k = 0; k < 3; ++k) xyz[k] += power * matching[3 * i + k] * 5e-9f;
  }
  std::array<float, 3> rgb;
  for (int k = 0; k < 3; ++k) rgb[size_t(k)] = std::fmax(dot(system.xyzToRgb + 3 * k, xyz), 0.f);
  return rgb;
}
const float* matchingFunctions() {
  static const std::array<float, 3 * kWavelengths> table = [] {
    std::array<float, 3 * kWavelengths> t;
    for (int i = 0; i < 3 * kWavelengths; ++i) t[size_t(i)] = float(kMatching[i / 3][i % 3] * 1e-4);
    return t;
  }();
  return table.data();
}

ColorSpace findConstructorSpace(std::string_view name, std::string_view working) {
  if (name == "RGB" || name == "rgb" || name == working) return ColorSpace::Rgb;
  if (name == "hsv") return ColorSpace::Hsv;
  if (name == "hsl") return ColorSpace::Hsl;
  if (name == "YIQ") return ColorSpace::Yiq;
  if (name == "XYZ") return ColorSpace::Xyz;
  if (name == "xyY") return ColorSpace::XyY;
  return ColorSpace::Unknown;
}
ColorSpace findColorSpace(std::string_view name, std::string_view working) {
  if (name == "linear") return ColorSpace::Rgb;
  if (name == "sRGB") return ColorSpace::Srgb;
  return findConstructorSpace(name, working);
}

}  // namespace kinora::language
