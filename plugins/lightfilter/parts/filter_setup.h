// What the create() functions of light filters share: parameters, the filter's own space, strength, ramps. Plain code
// that runs once a filter.
#pragma once
#include <kinora/light_filter.h>
#include <kinora/light_setup.h>
#include <kinora/math/ramp_knots.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace kinora::filterParts {

inline constexpr std::array kStrength = {
    param::number("density", 1.f).help("0 leaves the light as it is, 1 filters it fully."),
    param::number("diffuse", 1.f)
        .help("How much of the filter weighs on light to diffuse lobes; 0: they get the light as it is."),
    param::number("specular", 1.f).help("The same of specular lobes."),
    param::string("combineMode", "mult")
        .options("mult|max|min|screen")
        .help("How the filter combines with others of its light that have the same mode and are in no combiner; what "
              "the modes give is multiplied."),
    param::string("coordsys", "").help("Coordinate system of the filter; empty: the light's."),
    param::string("linkingGroups", "")
        .help("Groups that the filter belongs to: objects whose attribute lightfilter:subset names groups are "
              "without filters of other groups; empty: it is on all objects."),
    param::string("notes", "").help("Free text; read by nobody."),
};
inline constexpr std::array kSaturation = {
    param::number("saturation", 1.f)
        .range(0, 2)
        .help("Saturation of the filter's colour, about its luminance: 0 is grey, 1 leaves it."),
};
constexpr std::array<Param, 1> intensity(float standard, const char* help) {
  return {param::number("intensity", standard).range(0, 10).help(help)};
}
constexpr std::array<Param, 1> invert(const char* help) { return {param::onOff("invert", false).help(help)}; }

inline constexpr float kUnitKnots[] = {0, 0, 1, 1};
inline constexpr float kWhites[] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
constexpr auto colorRamp(const char* help) {
  return std::array{
      param::integer("colorRamp", 4).range(0, 64).help("Number of knots; the arrays' lengths count."),
      param::array(Type::Float, "colorRamp_Knots", kUnitKnots, 4).help("Places of the colours, ascending."),
      param::array(Type::Color, "colorRamp_Colors", kWhites, 12).help(help),
      param::string("colorRamp_Interpolation", "linear")
          .options("linear|catmull-rom|bspline|constant")
          .help("Curve between the knots."),
  };
}

// Render space to the filter's: local = (dot(p - origin, x), dot(p - origin, y), dot(p - origin, z)).
struct FilterSpace {
  Float3 origin{0, 0, 0}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

  static FilterSpace of(const CreateInfo& info) {
    const LocalFrame f = LocalFrame::of(info);
    const double determinant = f.determinant();
    if (!(std::fabs(determinant) > 1e-30)) throw "the filter's transformation is flat";
    FilterSpace s;
    s.origin = Float3(f.origin);
    s.x = Float3(cross(f.y, f.z) * (1 / determinant));
    s.y = Float3(cross(f.z, f.x) * (1 / determinant));
    s.z = Float3(cross(f.x, f.y) * (1 / determinant));
    return s;
  }
  Double3 direction(Double3 d) const {
    const auto row = [&](Float3 r) { return d.x * r.x + d.y * r.y + d.z * r.z; };
    return {row(x), row(y), row(z)};
  }
  Double3 place(Double3 p) const { return direction(p - Double3{origin.x, origin.y, origin.z}); }
};

// Numbers that must not be negative and stay within what single precision can square.
inline float atLeast(const NamedValues& v, const char* name, double least) {
  return float(std::clamp(v.number(name), least, 1e18));
}
inline float saturation(const NamedValues& v) { return float(std::clamp(v.number("saturation"), 0.0, 100.0)); }
inline float strength(const NamedValues& v) { return float(std::clamp(v.number("density"), 0.0, 1.0)); }

// Strength by a distance: three values at the ends and at a part of the way between, linear between them.
struct DistanceStrength {
  float near = 0, perReach = 1, power = 1, middle = 0.5f, atNear = 1, atMiddle = 1, atFar = 1;
  bool varies = false;

  void set(double nearest, double farthest, double exponent, double valueNear, double valueFar) {
    set(nearest, farthest, exponent, valueNear, valueFar, 0.5, (part(valueNear) + part(valueFar)) / 2);
  }
  void set(double nearest, double farthest, double exponent, double valueNear, double valueFar, double midpoint,
           double valueMiddle) {
    near = float(nearest);
    perReach = float(1 / std::max(farthest - nearest, 1e-9));
    power = float(std::max(exponent, 1e-3));
    middle = float(std::clamp(midpoint, 1e-6, 1 - 1e-6));
    atNear = part(valueNear);
    atMiddle = part(valueMiddle);
    atFar = part(valueFar);
    varies = atNear != 1 || atMiddle != 1 || atFar != 1;
  }

 private:
  static float part(double x) { return float(std::clamp(x, 0.0, 1.0)); }
};

// A ramp with its numbers. Cubic B-splines begin and end at their first and last value: their outer control points are
// mirrored, whatever the scene has there, since a region of light must reach both ends of its ramp.
struct Ramp {
  static constexpr int kMostKnots = 64;
  float knots[kMostKnots] = {}, rgb[3][kMostKnots] = {};
  RampKnots ramp;
  Ramp() = default;
  Ramp(const Ramp&) = delete;

  void set(const NamedValues& v, const std::string& name, const char* values, uint32_t channels) {
    const ParamValue& places = v.info().values[v.index(name + "_Knots")];
    const ParamValue& numbers = v.info().values[v.index(name + values)];
    const uint32_t given = places.count;
    bool good = given > 0 && given <= kMostKnots && numbers.count / channels >= given;
    for (uint32_t i = 0; good && i < given; ++i) {
      good = std::isfinite(places.floats[i]) && (i == 0 || places.floats[i] >= places.floats[i - 1]);
      for (uint32_t c = 0; c < channels; ++c) good = good && std::fabs(numbers.floats[channels * i + c]) < 1e18f;
    }
    if (!good) {
      v.warn("LIGHT-FILTER-RAMP",
             "the ramp '" + name + "' has " + std::to_string(places.count) + " knots and " +
                 std::to_string(numbers.count / channels) +
                 " values: they are none, too many, not as many, not ascending or no numbers",
             "the ramp is 1 everywhere");
      ramp.count = 1;
      for (float* channel : rgb) channel[0] = 1;
    } else {
      ramp.count = int(given);
      for (uint32_t i = 0; i < given; ++i) {
        knots[i] = places.floats[i];
        for (uint32_t c = 0; c < 3; ++c) rgb[c][i] = numbers.floats[channels * i + (channels == 3 ? c : 0)];
      }
      ramp.curve = rampCurveOf(v.string(name + "_Interpolation").c_str(), RampCurve::Linear);
      const int n = ramp.count;
      if (ramp.curve == RampCurve::Bspline && n >= 4)
        for (float* channel : rgb) {
          if (knots[0] == knots[1]) channel[0] = 2 * channel[1] - channel[2];
          if (knots[n - 1] == knots[n - 2]) channel[n - 1] = 2 * channel[n - 2] - channel[n - 3];
        }
    }
    ramp.knots = knots;
    for (int c = 0; c < 3; ++c) ramp.rgb[c] = rgb[c];
  }
  // What no value of the ramp is beyond, in magnitude: Catmull-Rom's weights add up to 1.25 at most.
  float bound() const {
    float most = 0;
    for (const float* channel : ramp.rgb)
      for (int i = 0; i < ramp.count; ++i) most = std::max(most, std::fabs(channel[i]));
    return most * (ramp.curve == RampCurve::CatmullRom ? 1.25f : 1.f);
  }
};

// The largest factor of a filter whose own is at most `most`, with room for rounding.
inline float largestOf(float most) { return std::max(1.f, most) * 1.00001f; }

}  // namespace kinora::filterParts
