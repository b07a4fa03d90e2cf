// Colour systems of the language: the primaries and white points by name, the matrices that follow, luminance
// weights, the CIE 1931 colour matching functions and the colour of black bodies. Plain data and setup, read by the
// kernels of color.h; conversions to spaces that only OpenColorIO knows are not here.
#pragma once
#include <array>
#include <string_view>
#include <vector>

namespace kinora::language {

inline constexpr int kWavelengths = 81;          // 380 to 780 nm in steps of 5
inline constexpr int kBlackbodySteps = 317;      // T_i = 800 + 2 i^1.5
inline constexpr float kBlackbodyLeast = 800.f;  // below: a trace of red
inline constexpr float kBlackbodyMost = 12000.f;

struct ColorSystem {
  std::string_view name;
  float xyzToRgb[9];  // row-major: rgb = M * xyz
  float rgbToXyz[9];
  float luminance[3];
  std::vector<float> blackbodyRoots;  // kBlackbodySteps x 3: the fifth root of the colour
};

// null for a name that is none. Built once, at the first call.
const ColorSystem* findColorSystem(std::string_view name);
const ColorSystem& defaultColorSystem();  // Rec709
// The working system of this process: set before anything is compiled.
void setDefaultColorSystem(const ColorSystem& system);
// The colour of a black body (W/m^2/sr, negative components 0), by the spectrum.
std::array<float, 3> blackbodyColor(const ColorSystem& system, float kelvin);
// kWavelengths x 3, the matching functions.
const float* matchingFunctions();

// Spaces between which transformc() converts without OpenColorIO.
enum class ColorSpace : int { Unknown = -1, Rgb, Hsv, Hsl, Yiq, Xyz, XyY, Srgb };
// `working` is the name of the working system: that, RGB, rgb and linear mean the working space.
ColorSpace findColorSpace(std::string_view name, std::string_view working);
// As the constructor color("space", r, g, b) sees it: without linear and sRGB.
ColorSpace findConstructorSpace(std::string_view name, std::string_view working);

}  // namespace kinora::language
