// What the create() functions of lights share: the common parameters, the radiance formula, shaping, placement and
// light maps. Plain code in double precision that runs once a light, before rendering; stock lights and authors'
// lights include it before <kinora/simd/foreach_target.h>. It samples nothing (light_author.h does) and knows nothing
// of shadows, linking or groups, which belong to the host.
#pragma once
#include <kinora/light.h>
#include <kinora/named_values.h>

#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

namespace kinora {

// ---- common parameters (names and defaults of the RIS lights) ----
namespace lightParams {
inline constexpr std::array kRadiance = {
    param::number("intensity", 1.f).range(0, 100).help("Factor on the radiance."),
    param::number("exposure", 0.f).range(-8, 8).help("Stops: the radiance is multiplied by 2 to this power."),
    param::color("lightColor", 1.f).help("Colour, a factor on the radiance; scene-linear Rec. 709."),
    param::onOff("enableTemperature", false).help("Multiply by the colour of a black body."),
    param::number("temperature", 6500.f)
        .range(1000, 10000)
        .help("Kelvin, used where enableTemperature is 1; its colour has luminance 1 and is kept within 1000 to "
              "10000."),
    param::number("specular", 1.f).help("Factor on this light's contribution to specular lobes."),
    param::number("diffuse", 1.f).help("Factor on this light's contribution to diffuse lobes."),
};
inline constexpr std::array kNormalize = {
    param::onOff("areaNormalize", false)
        .help("Divide the radiance by the light's size (area; for distant lights projected solid angle, over that of "
              "the default angle), so that the power does not grow with it."),
};
inline constexpr std::array kMap = {
    param::string("lightColorMap", "")
        .file()
        .help("Image that multiplies the colour; see the light's own text for its orientation."),
    param::vector("colorMapGamma", 1, 1, 1)
        .range(0.2f, 4)
        .help("Each channel c of the map becomes c to the power 1 / gamma."),
    param::number("colorMapSaturation", 1.f)
        .range(0, 2)
        .help("0 makes the map grey (Rec. 709 luminance), 1 leaves it."),
};
inline constexpr std::array kShaping = {
    param::number("emissionFocus", 0.f)
        .range(0, 50)
        .help("Exponent of the cosine to the light's axis that multiplies the radiance; 0 emits alike to all sides."),
    param::color("emissionFocusTint", 0.f).help("Radiance factor towards which the focus falls off."),
    param::onOff("emissionFocusNormalize", false).help("Keep the power whatever emissionFocus is."),
    param::number("coneAngle", 90.f).range(0, 180).help("Degrees off the axis beyond which nothing is emitted."),
    param::number("coneSoftness", 0.f)
        .range(0, 2)
        .help("Part of coneAngle over which the edge fades; above 1 the axis is dimmed too."),
    param::string("iesProfile", "")
        .help("File of a measured light distribution (IES LM-63) about the light's +z axis, horizontal angles from "
              "+x to +y; a factor on the radiance that is 1 where it is largest."),
    param::number("iesProfileScale", 0.f).range(-0.9f, 1).help("Widens the profile's angles by this part of them."),
    param::onOff("iesProfileNormalize", false).help("1: the mean of the factor over all directions is 1."),
    param::number("intensityNearDist", 0.f)
        .range(0, 10)
        .help("World units: nearer to the light than this its brightness rises no more (a factor of the squared "
              "distance over this one's square, not where the camera sees the light)."),
};
inline constexpr std::array kControl = {
    param::onOff("enableShadows", true)
        .help("0: nothing between the light and a surface shadows it. Mirrors still show what stands before it."),
    param::color("shadowColor", 0.f)
        .help("Share of the light that its shadows leave, by channel: 0 is a full shadow, 1 none. Not physical: such "
              "light is left at whatever finds the light where its samples could have; mirrors and clear glass still "
              "show what stands before it, media dim it as ever, and no light paths start at it. So with all "
              "controls of shadows but enableShadows."),
    param::number("shadowDistance", -1.f)
        .range(-1, 100)
        .help("What is farther from the lit point than this, in world units, casts no shadow; below 0: no limit."),
    param::number("shadowFalloff", -1.f)
        .range(-1, 100)
        .help("Shadows fade over this last part of shadowDistance (at most all of it), by the distance from the lit "
              "point to what casts them, of opaque surfaces the nearest; 0 and below: they do not."),
    param::number("shadowFalloffGamma", 1.f)
        .range(0.1f, 4)
        .help("A shadow's strength where it fades is the part of shadowFalloff that is left to this power."),
    param::string("shadowSubset", "")
        .help("Groups (grouping:membership) whose members alone cast this light's shadows, instead of those that the "
              "lit object's trace:shadowsubset says; empty: all do."),
    param::string("shadowExcludeSubset", "").help("Groups whose members cast no shadow of this light."),
    param::onOff("traceLightPaths", false)
        .help("1: the light is as light paths carry it. thinShadow counts as 0, and the controls of shadows below "
              "enableShadows are left out. Light paths of PxrVCM start at such a light, and at all that ask for no "
              "control of shadows, no intensityNearDist and no filter that depends on the lit point."),
    param::onOff("thinShadow", true)
        .help("1: where the integrator has no caustics, shadows go straight through glass and take its tint, and "
              "what refracted paths find of the light is left out. 0: glass blocks its shadow rays, and refracted "
              "paths bring its light. Integrators with caustics take it as 0."),
    param::onOff("visibleInRefractionPath", true)
        .help("0: clear glass does not show the light, nor make caustics of it. Rough glass does, where light "
              "samples find it too."),
    param::onOff("cheapCaustics", false)
        .help("Manifold walks find this light's caustics, where the integrator's manifoldWalk is on, behind "
              "materials whose mwWalkable is. Not of lights without shadows, nor of domes and skies, which paths "
              "find better by chance."),
    param::string("cheapCausticsExcludeGroup", "")
        .help("No effect: whether walks go through an object is said by mwWalkable of its material, for all lights, "
              "so that paths can leave to walks just what these find."),
    param::integer("fixedSampleCount", 0)
        .range(0, 64)
        .help("Light samples of this light alone at each camera hit, whatever it brings, instead of a share in the "
              "integrator's numLightSamples, which go to all lights; 0: none. For a light that is the noise of a "
              "picture. Not with PxrVCM and light paths of PxrUnified."),
    param::string("lightGroup", "").help("The light's name in light path expressions: <L.'key'>."),
    param::number("importanceMultiplier", 1.f)
        .range(0.01f, 10)
        .help("Factor on how often the light is chosen; noise moves, the picture's mean does not."),
    param::number("msApprox", 0.f)
        .help("No effect: light is scattered as often as the integrator's bounces allow; multiScatterOpt of "
              "PxrVolume approximates many of them."),
    param::color("msApproxBleed", 0.5f).help("No effect: see msApprox."),
    param::color("msApproxContribution", 0.5f).help("No effect: see msApprox."),
    param::string("notes", "").help("Free text; read by nobody."),
};
}  // namespace lightParams

// ---- three doubles ----
struct Double3 {
  double x = 0, y = 0, z = 0;
  friend Double3 operator+(Double3 a, Double3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Double3 operator-(Double3 a, Double3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Double3 operator*(Double3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
};
inline double dot(Double3 a, Double3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Double3 cross(Double3 a, Double3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(Double3 a) { return std::sqrt(dot(a, a)); }
// Zero stays zero.
inline Double3 normalized(Double3 a) {
  const double l = length(a);
  return l > 0 ? a * (1 / l) : Double3{};
}
struct Float3 {
  float x = 0, y = 0, z = 0;
  Float3() = default;
  Float3(double a, double b, double c) : x(float(a)), y(float(b)), z(float(c)) {}
  explicit Float3(Double3 d) : x(float(d.x)), y(float(d.y)), z(float(d.z)) {}
};

// The placement as three axes and an origin: local (a, b, c) stands at a x + b y + c z + origin.
struct LocalFrame {
  Double3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin;
  // Throws (for guardedCreate) on numbers that are not finite: nothing sensible can be drawn then.
  static LocalFrame of(const CreateInfo& info) {
    LocalFrame f;
    if (!info.placement) return f;
    const double* m = info.placement->localToRender;
    for (int i = 0; i < 16; ++i)
      if (!std::isfinite(m[i]) || std::fabs(m[i]) > 1e18)
        throw "the light's transformation holds numbers that are not finite";
    f.x = {m[0], m[1], m[2]};
    f.y = {m[4], m[5], m[6]};
    f.z = {m[8], m[9], m[10]};
    f.origin = {m[12], m[13], m[14]};
    return f;
  }
  double determinant() const { return dot(cross(x, y), z); }
};

// Colour of a black body in Rec. 709, scaled to luminance 1, negative components cut. Planck's law times the CIE 1931
// observer in the fit of Wyman, Sloan and Shirley (JCGT 2013), in steps of 5 nm.
inline std::array<double, 3> blackbody(double kelvin) {
  const double T = std::fmin(10000, std::fmax(1000, kelvin));
  const auto lobe = [](double l, double mean, double below, double above) {
    const double t = (l - mean) * (l < mean ? below : above);
    return std::exp(-0.5 * t * t);
  };
  double X = 0, Y = 0, Z = 0;
  for (double nm = 360; nm <= 830; nm += 5) {
    const double l = nm * 1e-9;
    const double power = 1 / (std::pow(nm / 560, 5) * std::expm1(1.4387769e-2 / (l * T)));
    X += power * (0.362 * lobe(nm, 442.0, 0.0624, 0.0374) + 1.056 * lobe(nm, 599.8, 0.0264, 0.0323) -
                  0.065 * lobe(nm, 501.1, 0.0490, 0.0382));
    Y += power * (0.821 * lobe(nm, 568.8, 0.0213, 0.0247) + 0.286 * lobe(nm, 530.9, 0.0613, 0.0322));
    Z += power * (1.217 * lobe(nm, 437.0, 0.0845, 0.0278) + 0.681 * lobe(nm, 459.0, 0.0385, 0.0725));
  }
  const double r = std::fmax(0, 3.2404542 * X - 1.5371385 * Y - 0.4985314 * Z);
  const double g = std::fmax(0, -0.9692660 * X + 1.8760108 * Y + 0.0415560 * Z);
  const double b = std::fmax(0, 0.0556434 * X - 0.2040259 * Y + 1.0572252 * Z);
  const double luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
  return {r / luminance, g / luminance, b / luminance};
}

// How radiance depends on the angle to the light's axis: L(theta) = lerp(tint, 1, cos^focus) * scale * cone.
struct Shaping {
  float focus = 0, tint[3] = {1, 1, 1}, scale[3] = {1, 1, 1};
  float coneEnd = 4, coneStart = 4;  // radians
  float sinCone = 1;                 // of the widest direction emitted, 1 from 90 degrees
  bool focused = false, coned = false;
  float power[3] = {1, 1, 1};  // integral of shape over that without shaping

  // closed: the emitter shows the same area to every direction (sphere); else it is flat and its axis is its normal.
  static Shaping of(const NamedValues& v, bool closed) {
    Shaping s;
    const double focus = std::fmax(0, v.number("emissionFocus"));
    s.focused = focus > 0;
    s.focus = float(focus);
    double tint[3];
    for (int c = 0; c < 3; ++c) s.tint[c] = float(tint[c] = v.number("emissionFocusTint", c));
    const double angle = std::fmin(180, std::fmax(0, v.number("coneAngle"))) * kRadians;
    const double softness = std::fmin(10, std::fmax(0, v.number("coneSoftness")));
    // At 90 degrees and no softness a flat light is not cut; a closed one takes the default 90 as "no cone" too,
    // since its default emission is to all sides.
    s.coned = angle < 90 * kRadians - 1e-6 || (!closed && softness > 0) ||
              (closed && angle > 90 * kRadians + 1e-6 && angle < 180 * kRadians - 1e-6);
    s.coneEnd = float(angle);
    s.coneStart = float(angle * (1 - softness));
    s.sinCone = s.coned && angle < 90 * kRadians ? float(std::sin(angle)) : 1.f;
    if (s.focused && v.integer("emissionFocusNormalize"))
      for (int c = 0; c < 3; ++c) {
        const double kept = tint[c] + (1 - tint[c]) * (closed ? 0.5 / (focus + 1) : 2 / (focus + 2));
        s.scale[c] = kept > 1e-9 ? float(1 / kept) : 1.f;
      }
    if (!s.focused) s.tint[0] = s.tint[1] = s.tint[2] = 1;
    if (!s.focused && !s.coned) return s;
    constexpr int kSteps = 4096;
    double whole = 0, shaped[3] = {0, 0, 0};
    for (int i = 0; i < kSteps; ++i) {
      const double theta = (i + 0.5) / kSteps * (closed ? 180 : 90) * kRadians, cosine = std::cos(theta);
      const double weight = std::sin(theta) * (closed ? 1 : cosine);
      whole += weight;
      double cone = 1;
      if (s.coned) {
        const double a = s.coneStart, b = s.coneEnd;
        const double t = b > a ? std::fmin(1, std::fmax(0, (theta - a) / (b - a))) : (theta > b ? 1 : 0);
        cone = 1 - t * t * (3 - 2 * t);
      }
      const double fall = s.focused ? std::pow(std::fmax(0, cosine), focus) : 1;
      for (int c = 0; c < 3; ++c) shaped[c] += weight * cone * s.scale[c] * (s.tint[c] + (1 - s.tint[c]) * fall);
    }
    for (int c = 0; c < 3; ++c) s.power[c] = float(shaped[c] / whole);
    return s;
  }
  static constexpr double kRadians = 3.14159265358979323846 / 180;
};

// Everything of a light that does not depend on its shape.
struct LightCommon {
  float radiance[3] = {0, 0, 0};  // intensity * 2^exposure * lightColor * blackbody / size
  float diffuse = 1, specular = 1, importance = 1;

  // size: what areaNormalize divides by; negative: the light has no such parameter.
  static LightCommon of(const NamedValues& v, double size) {
    LightCommon c;
    double scale = v.number("intensity") * std::exp2(std::fmin(100, std::fmax(-100, v.number("exposure"))));
    if (size >= 0 && v.integer("areaNormalize")) scale = size > 0 ? scale / size : 0;
    std::array<double, 3> body = {1, 1, 1};
    if (v.integer("enableTemperature")) body = blackbody(v.number("temperature"));
    for (int i = 0; i < 3; ++i) {
      const double l = scale * v.number("lightColor", i) * body[i];
      if (!(std::fabs(l) < 1e30)) throw "the light's radiance is beyond what numbers hold";
      c.radiance[i] = float(l);
    }
    c.diffuse = float(v.number("diffuse"));
    c.specular = float(v.number("specular"));
    c.importance = float(std::fmax(1e-3, v.number("importanceMultiplier")));
    return c;
  }
  bool isBlack() const { return radiance[0] == 0 && radiance[1] == 0 && radiance[2] == 0; }
};

// ---- what describe() tells the host ----
// `power`: what choice among lights goes by before their importance.
inline LightDescription describeLight(const LightCommon& common, bool isBlack, double power) {
  LightDescription d{};
  d.power = isBlack ? 0.f : float(power) * common.importance;
  d.visibleToCamera = 1;
  d.diffuse = common.diffuse;
  d.specular = common.specular;
  return d;
}
// A light from infinitely far: the integral of its radiance over directions; the host multiplies by pi R^2 of the
// world.
inline LightDescription describeInfiniteLight(const LightCommon& common, bool isBlack, double integral) {
  LightDescription d = describeLight(common, isBlack, integral);
  d.radius = -1;
  d.isInfinite = 1;
  return d;
}
// A light with a surface of this area (render units) that lies within `radius` of `center`: pi A L, with its shaping
// and the mean of its map.
inline LightDescription describeSurfaceLight(const LightCommon& common, const Shaping& shaping, bool isBlack,
                                             Float3 center, double radius, double area,
                                             const double mapMean[3] = nullptr) {
  double power = 0;
  for (int c = 0; c < 3; ++c) {
    const double shaped = mapMean ? std::fabs(common.radiance[c] * mapMean[c]) * shaping.power[c]
                                  : std::fabs(common.radiance[c]) * shaping.power[c];
    power += shaped * area * 3.14159265358979323846 / 3;
  }
  LightDescription d = describeLight(common, isBlack, power);
  d.center[0] = center.x;
  d.center[1] = center.y;
  d.center[2] = center.z;
  d.radius = float(radius);
  return d;
}
inline void setAxis(LightDescription& d, Double3 axis) {
  d.axis[0] = float(axis.x);
  d.axis[1] = float(axis.y);
  d.axis[2] = float(axis.z);
}
// Where a surface emits to: its normals lie within the angle of cosNormals about `axis` (unit), shaping is measured
// from them.
inline void describeEmission(LightDescription& d, const Shaping& shaping, Double3 axis, double cosNormals = 1) {
  setAxis(d, axis);
  d.cosNormals = float(cosNormals);
  d.cosEmission = shaping.coned && shaping.coneEnd < 1.5707f ? std::cos(shaping.coneEnd) : 0.f;
}
// The same for a closed surface, which emits to all sides but for its shaping, measured from `axis`.
inline void describeClosedEmission(LightDescription& d, const Shaping& shaping, Double3 axis) {
  const bool halved = shaping.focused && shaping.tint[0] == 0 && shaping.tint[1] == 0 && shaping.tint[2] == 0;
  if (!shaping.coned && !halved) return;
  setAxis(d, axis);
  if (shaping.coned) {  // cut off, even within
    d.cosNormals = std::cos(shaping.coneEnd < 3.1415f ? shaping.coneEnd : 3.1415927f);
    d.cosEmission = 1;
  } else {  // falls off with the cosine at least
    d.cosNormals = 1;
  }
}
// The box about points of the light. Starts as that of none.
struct LightBox {
  double low[3] = {1e300, 1e300, 1e300}, high[3] = {-1e300, -1e300, -1e300};
  void add(Double3 p) {
    const double q[3] = {p.x, p.y, p.z};
    for (int c = 0; c < 3; ++c) {
      low[c] = std::fmin(low[c], q[c]);
      high[c] = std::fmax(high[c], q[c]);
    }
  }
  // Wider by what rounding to single precision may take.
  void describe(LightDescription& d) const {
    for (int c = 0; c < 3 && low[0] <= high[0]; ++c) {
      const double slack = 1e-6 * (std::fabs(low[c]) + std::fabs(high[c]) + d.radius);
      d.low[c] = float(low[c] - slack);
      d.high[c] = float(high[c] + slack);
    }
  }
};

// A light map ready for lookups: interleaved texels, top row first. Points at the host's pixels when nothing is to be
// changed in them (the host keeps them for the world's life), else at its own copy.
struct LightMap {
  const float* texels = nullptr;
  int32_t width = 0, height = 0, stride = 0;
  int32_t green = 0, blue = 0;  // offsets within a texel: 0 0 for grey maps
  std::vector<float> own;
  double mean[3] = {1, 1, 1};  // plain average of the texels

  bool valid() const { return texels != nullptr; }
  // Never fails: a map that is missing or beyond bounds leaves the light without one (the colour alone), with a
  // message. `name`: of the parameter that names the file.
  void load(const NamedValues& v, const std::string& name = "lightColorMap") {
    const std::string file = v.string(name);
    const Host* host = v.info().host;
    if (file.empty() || !host || !host->image) return;
    const HostImage* image = host->image(host->self, file.c_str(), -1);
    if (!image || !image->pixels) return;  // the host has said so
    const uint64_t count = uint64_t(image->width) * image->height * image->channels;
    if (image->width == 0 || image->height == 0 || image->channels == 0 || image->width > 1u << 20 ||
        image->height > 1u << 20 || image->channels > 64 || count > 0x7fffffffu) {
      v.warn("LIGHT-MAP", name + " '" + file + "' is empty or has more than 2^31 numbers", "the light has no map");
      return;
    }
    width = int32_t(image->width);
    height = int32_t(image->height);
    const bool grey = image->channels < 3;
    double gamma[3];
    bool changes = false;
    for (int c = 0; c < 3; ++c) {
      gamma[c] = v.number("colorMapGamma", c);
      if (!(gamma[c] > 1e-3)) gamma[c] = 1;
      changes = changes || gamma[c] != 1;
    }
    const double saturation = v.number("colorMapSaturation");
    changes = changes || saturation != 1;
    const size_t texelCount = size_t(width) * size_t(height);
    size_t bad = 0;
    for (size_t i = 0; i < texelCount * image->channels; ++i) bad += !std::isfinite(image->pixels[i]);
    if (bad)
      v.warn("LIGHT-MAP", name + " '" + file + "' holds " + std::to_string(bad) + " numbers that are not finite",
             "they count as black");
    if (!changes && !bad) {
      texels = image->pixels;
      stride = int32_t(image->channels);
      green = grey ? 0 : 1;
      blue = grey ? 0 : 2;
    } else {
      if (uint64_t(texelCount) * 3 > 0x7fffffffu) {
        v.warn("LIGHT-MAP", name + " '" + file + "' is too large to be changed", "the light has no map");
        width = height = 0;
        return;
      }
      own.resize(texelCount * 3);
      for (size_t i = 0; i < texelCount; ++i) {
        double rgb[3];
        for (int c = 0; c < 3; ++c) {
          const double x = image->pixels[i * image->channels + (grey ? 0 : c)];
          rgb[c] =
              std::isfinite(x) ? (gamma[c] == 1 ? x : std::copysign(std::pow(std::fabs(x), 1 / gamma[c]), x)) : 0;
        }
        const double luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        for (int c = 0; c < 3; ++c) own[3 * i + c] = float(luminance + (rgb[c] - luminance) * saturation);
      }
      texels = own.data();
      stride = 3;
      green = 1;
      blue = 2;
    }
    double sum[3] = {0, 0, 0};
    for (size_t i = 0; i < texelCount; ++i)
      for (int c = 0; c < 3; ++c) sum[c] += texel(i, c);
    for (int c = 0; c < 3; ++c) mean[c] = sum[c] / double(texelCount);
  }
  double texel(size_t i, int channel) const {
    return texels[i * size_t(stride) + size_t(channel == 0 ? 0 : channel == 1 ? green : blue)];
  }
};

}  // namespace kinora
