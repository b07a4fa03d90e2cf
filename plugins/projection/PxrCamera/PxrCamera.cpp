// PxrCamera: the thin-lens camera with shift, roll, tilt, squeeze, distortion and vignetting.
#define KINORA_KERNEL_FILE "plugins/projection/PxrCamera/PxrCamera.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include <kinora/projection_author.h>
#include <kinora/math/sampling.h>

#include "plugins/projection/parts/lens_distortion.h"

#if KINORA_PLAIN
namespace kinora::pxrCamera {
using namespace param;
constexpr float kZeros[3] = {0, 0, 0}, kEnhance[3] = {0, 0, 1};
constexpr Param list(const char* name, const float* values, uint32_t count, const char* text) {
  return array(Type::Float, name, values, count).help(text);
}
constexpr const char kOneLens[] = "No effect: depth of field is that of one lens, the same all over the picture.";
constexpr const char kWhite[] =
    "No effect: a camera path carries all three channels, which leave the lens in one direction.";
constexpr std::array kOwn = {
    number("shiftX", 0.f)
        .range(-1, 1)
        .help("Lens shift, in units of the screen window: positive shows more of the right."),
    number("shiftY", 0.f)
        .range(-1, 1)
        .help("Lens shift, in units of the screen window: positive shows more of what is above."),
    number("roll", 0.f)
        .range(-180, 180)
        .help("Degrees about the view axis. Positive turns the camera's up towards its left, so the picture turns "
              "clockwise."),
    number("tilt", 0.f)
        .range(-45, 45)
        .help("Degrees by which the lens is tilted up, which tilts the plane of focus about the line where it meets "
              "the plane of the lens, at focalLength / sin(tilt) above it: above 0 the top of the picture is sharp "
              "nearer. Not with focus1, focus2 and focus3."),
    point("focus1", 0, 0, 0)
        .help("World space. With focus2 and focus3: three points that the plane of focus passes through, which may "
              "be tilted; instead of focalDistance. Used when they are not all the same."),
    point("focus2", 0, 0, 0).help("World space; see focus1."),
    point("focus3", 0, 0, 0).help("World space; see focus1."),
    integer("lensType", 2).range(0, 2).help("No effect: there is one model of distortion, see radial1."),
    number("radial1", 0.f)
        .range(-1, 1)
        .help("Distortion: what an ideal lens shows at (x, y) of the screen lies at x (1 + (radial1 + assymX) r^2 + "
              "radial2 r^4), y (1 + (radial1 + assymY) r^2 + radial2 r^4), r its distance from distortionCtr. Above "
              "0 a cushion, below 0 a barrel, which is black where it shows nothing."),
    number("radial2", 0.f).range(-1, 1).help("See radial1."),
    number("assymX", 0.f).range(-1, 1).help("See radial1: distortion along x alone."),
    number("assymY", 0.f).range(-1, 1).help("See radial1: distortion along y alone."),
    number("lensAsymmetryX", 0.f).range(-1, 1).help("Added to assymX."),
    number("lensAsymmetryY", 0.f).range(-1, 1).help("Added to assymY."),
    list("distortionCtr", kZeros, 2, "Centre of the distortion, in units of the screen window."),
    number("lensScale", 1.f)
        .range(0.1f, 10)
        .help("Size of the picture about the middle of the lens: 2 shows things twice as large."),
    number("squeeze", 1.f)
        .range(0.5f, 2)
        .help("Anamorphic lens: so many times as wide a view, squeezed into the picture's width."),
    color("axial", 0.f).help(kWhite),
    color("transverse", 1.f).help(kWhite),
    number("natural", 0.f)
        .help("Natural vignetting: how much of the fourth power of the cosine to the view axis dims the picture; of "
              "a shifted lens about its axis, not the picture's middle."),
    number("optical", 0.f)
        .help("Vignetting by the rim of the lens hood, as large as the lens, which it covers from one side: at (x, "
              "y) of the screen the hood stands optical * (x, y) lens radii off. Highlights out of focus become "
              "cat's eyes; without depth of field the picture darkens as much."),
    string("sweep", "down").options("down|right|up|left").help("Where the shutter opens last; see duration."),
    number("duration", 1.f)
        .help("Rolling shutter: part of the shutter's time for which each line of pixels is open, one after the "
              "other in the direction of sweep; shutteropening shapes that part. 1: all of it, everywhere at once; "
              "the least is 0.001."),

    number("detail", 0.f)
        .range(-4, 4)
        .help("Bias of the level of textures and geometry: footprints of camera rays grow 2^detail times as fast."),
    list("enhance", kEnhance, 3,
         "A magnifier: the place of the screen (x, y) that the picture shows in its middle, and how many times as "
         "large. "
         "Levels of textures and geometry stay those of the whole picture."),
    onOff("enhanceDiffAdjust", false).help("1: with enhance, levels are those of the enlarged picture."),
    onOff("enhanceDisableDOF", false).help("1: with enhance, everything is sharp."),
    flag("enhanceDisableMoBlur", false).help("No effect: Shutter 0 0 does this."),
    string("matte", "")
        .help("No effect: holdouts are objects with trace:holdout, and pictures lie over the frame by display "
              "filters."),
    string("cocTexture", "").help(kOneLens),
    number("dofMult", 1.f).range(0, 4).help("Factor on the radius of the lens, which blurs so much more."),
    list("dofPivotCenter", kZeros, 3, kOneLens),
    number("dofRadiusStrength", 0.f).help(kOneLens),
    number("dofRadiusFalloff", 1.f).range(0, 4).help(kOneLens),
    number("dofSqAnamorph", 1.f).range(0.5f, 2).help(kOneLens),
    list("dofSqCtr", kZeros, 3, kOneLens),
    number("dofSqStrength", 0.f).help(kOneLens),
    number("dofSqFalloff", 1.f).range(0, 4).help(kOneLens),
    integer("numSplitDiopters", 0).range(0, 2).help(kOneLens),
    number("splitDiopterAngle", 0.f).range(-180, 180).help(kOneLens),
    number("splitDiopterFocusDistance1", 0.f).range(0, 100).help(kOneLens),
    number("splitDiopterFocusDistance2", 0.f).range(0, 100).help(kOneLens),
    number("splitDiopterOffset1", 0.f).range(-1, 1).help(kOneLens),
    number("splitDiopterOffset2", 0.f).range(-1, 1).help(kOneLens),
    number("splitDiopterWidth1", 0.f).help(kOneLens),
    number("splitDiopterWidth2", 0.f).help(kOneLens),
};
constexpr auto kParams = joinParams(projectionParams::kLens, kOwn);

struct Camera : ThinLens {
  float natural = 0, optical = 0;
  float footprint = 1;  // factor on its growth
  LensDistortion distortion;
  ShutterSweep sweep;
};

// A number of an array, its default where the scene gives fewer or none that is finite.
double listed(const CreateInfo& info, const char* name, uint32_t at) {
  uint32_t i = 0;
  while (std::string_view(kParams[i].name) != name) ++i;
  const ParamValue& v = info.values[i];
  return v.floats && at < v.count && std::isfinite(v.floats[at]) ? v.floats[at] : kParams[i].list[at];
}
// The picture shows what lies about (x, y) of the screen, larger.
void enhance(Camera& lens, double x, double y, double zoom) {
  ScreenMap& m = lens.screen;
  m.stepX = float(m.stepX / zoom);
  m.stepY = float(m.stepY / zoom);
  m.left = float(x - 0.5 * double(m.width) * double(m.stepX));
  m.top = float(y + 0.5 * double(m.height) * double(m.stepY));
}
std::unique_ptr<Camera> makeCamera(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  const auto* projection = static_cast<const ProjectionInfo*>(info.extra);
  auto lens = std::make_unique<Camera>();
  lens->screen = ScreenMap::of(projection);
  // authors' pictures show that this camera's lens is its own: with a DepthOfField request alone they are sharp
  ProjectionInfo without = *projection;
  without.fStop = 0;
  setLens(*lens, values, without);
  if (projection->fStop > 0 && !values.given("fStop") && !values.given("focalLength"))
    values.warn("PROJECTION-LENS", "the DepthOfField request does not reach this camera, whose lens is its own",
                "everything is sharp; give it fStop, focalLength and focalDistance");
  lens->screen.left += float(values.number("shiftX"));
  lens->screen.top += float(values.number("shiftY"));
  const auto factor = [&](const char* name) {
    const double x = values.number(name);
    if (x > 1e-3 && x < 1e3) return x;
    values.warn("PARAM-RANGE", std::string(name) + " is no factor above 0", "1 is used");
    return 1.0;
  };
  const double size = 1 / factor("lensScale"), squeeze = factor("squeeze");
  if (size != 1 || squeeze != 1) {
    for (float* x : {&lens->screen.left, &lens->screen.stepX}) *x = float(*x * size * squeeze);
    for (float* y : {&lens->screen.top, &lens->screen.stepY}) *y = float(*y * size);
  }
  const auto share = [&](const char* name) {
    const double x = values.number(name);
    if (!(x >= 0 && x <= 1))
      values.warn("PARAM-RANGE", std::string(name) + " is not within 0 to 1", "it is brought within");
    return float(std::fmin(1, std::fmax(0, x)));
  };
  lens->natural = share("natural");
  lens->optical = share("optical");
  lens->sweep.duration = share("duration");
  const std::string direction = values.string("sweep");
  lens->sweep.columns = direction == "right" || direction == "left";
  lens->sweep.backward = direction == "up" || direction == "left";
  if (!lens->sweep.columns && !lens->sweep.backward && direction != "down")
    values.warn("PARAM-CHOICE", "sweep is down, right, up or left, not '" + direction + "'", "down is used");
  const auto bounded = [&](const char* name, double most) {
    return std::fmin(most, std::fmax(-most, values.number(name)));
  };
  lens->footprint = float(std::exp2(bounded("detail", 10)));
  const double radial = bounded("radial1", 100);
  lens->distortion.set(radial + bounded("assymX", 100) + bounded("lensAsymmetryX", 100),
                       radial + bounded("assymY", 100) + bounded("lensAsymmetryY", 100), bounded("radial2", 100),
                       listed(info, "distortionCtr", 0), listed(info, "distortionCtr", 1));
  const double dof = values.number("dofMult");
  if (!(dof >= 0)) values.warn("PARAM-RANGE", "dofMult is no factor", "1 is used");
  if (dof >= 0 && dof < 1e6) lens->lensRadius = float(double(lens->lensRadius) * dof);
  if (const double zoom = listed(info, "enhance", 2); zoom != 1) {
    if (zoom > 1e-3 && zoom < 1e6) {
      enhance(*lens, listed(info, "enhance", 0), listed(info, "enhance", 1), zoom);
      if (!values.integer("enhanceDiffAdjust")) lens->footprint *= float(zoom);
      if (values.integer("enhanceDisableDOF")) lens->lensRadius = 0;
    } else {
      values.warn("PARAM-RANGE", "enhance enlarges by no factor above 0", "the whole picture is shown");
    }
  }
  const double roll = values.number("roll") * 3.14159265358979323846 / 180;
  lens->screen.cosRoll = float(std::cos(roll));
  lens->screen.sinRoll = float(std::sin(roll));
  double focus[9];
  bool areOne = true;
  for (int i = 0; i < 9; ++i) {
    focus[i] = values.number("focus" + std::to_string(1 + i / 3), i % 3);
    areOne = areOne && focus[i] == focus[i % 3];
  }
  if (const double tilt = values.number("tilt"), length = values.number("focalLength");
      areOne && tilt != 0 && lens->lensRadius > 0) {
    const double slope = std::sin(tilt * 3.14159265358979323846 / 180) / length;
    // where the plane cuts the lens, a point of the picture has no one direction
    if (std::isfinite(slope) && std::fabs(slope) * double(lens->lensRadius) < 0.99)
      lens->sharp[1] = float(slope);
    else
      values.warn("PROJECTION-FOCUS", "tilt brings the plane of focus into the lens", "the lens is not tilted");
  }
  if (!areOne && lens->lensRadius > 0 && !setPlaneOfFocus(*lens, focus, *projection))
    values.warn("PROJECTION-FOCUS", "focus1, focus2 and focus3 span no plane of focus that misses the lens",
                "focalDistance is used");
  values.warnNoEffect();
  return lens;
}
void sweep(const void* data, ShutterSweep* out) { *out = static_cast<const Camera*>(data)->sweep; }
void ndcMatrix(const void* data, double out[16]) { perspectiveMatrix(*static_cast<const Camera*>(data), out); }
}  // namespace kinora::pxrCamera
#endif

KINORA_KERNELS_BEGIN
struct PxrCameraProjection {
  using Data = pxrCamera::Camera;
  // Of a ray whose cosine to the axis is this.
  template <int W>
  static KN_INLINE Float<W> dimming(const Data& k, Float<W> cosine) {
    const Float<W> square = cosine * cosine;
    return fma(fms(square, square, Float<W>(1.f)), Float<W>(k.natural), Float<W>(1.f));
  }
  // How much of the light for place (x, y) of the screen the hood lets through to a point of the lens; of a pinhole to
  // all of it: the overlap of two disks.
  template <int W>
  static KN_INLINE Float<W> throughHood(const Data& k, Float<W> x, Float<W> y, const Vec3<W>& o) {
    using F = Float<W>;
    const F dx = x * F(k.optical), dy = y * F(k.optical);
    if (k.lensRadius > 0) {
      const F u = fma(o.x, F(1.f / (k.lensRadius * k.aperture.stretch)), dx), v = fma(o.y, F(1.f / k.lensRadius), dy);
      return select(fma(u, u, v * v) <= F(1.f), F(1.f), F(0.f));
    }
    const F half = min(sqrt(fma(dx, dx, dy * dy)) * F(0.5f), F(1.f));
    return fnma(half, safeSqrt(fnma(half, half, F(1.f))), acos(half)) * F(2 * kInvPi);
  }
  template <int W>
  static KN_INLINE void rays(const Data& k, const CameraSample<W>& in, CameraRay<W>& out) {
    using F = Float<W>;
    F area(1.f);
    CameraSample<W> ideal = in;
    if (k.distortion.isThere) {
      F x, y;
      toScreen(k.screen, in.x, in.y, x, y);
      const DistortedPlace<W> at = undistorted<W>(k.distortion, x, y);
      toRaster(k.screen, at.x, at.y, ideal.x, ideal.y);
      area = at.area;
    }
    ThinLensProjection::rays<W>(k, ideal, out);
    if (k.distortion.isThere) {
      out.weight = select(area > F(0.f), F(1.f), F(0.f));
      out.spread = out.spread / sqrt(max(area, F(1e-3f)));
    }
    if (k.natural > 0) out.weight = out.weight * dimming<W>(k, out.d.z);
    if (k.optical > 0) {
      F x, y;
      toScreen(k.screen, ideal.x, ideal.y, x, y);
      out.weight = out.weight * throughHood<W>(k, x, y, out.o);
    }
    if (k.footprint != 1) out.spread = out.spread * F(k.footprint);
  }
  template <int W>
  static KN_INLINE void connect(const Data& k, const CameraPoint<W>& in, CameraLink<W>& out) {
    using F = Float<W>;
    ThinLensProjection::connectAnywhere<W>(k, in, out);
    F x, y;
    toScreen(k.screen, out.x, out.y, x, y);
    if (k.distortion.isThere) {
      const DistortedPlace<W> at = distorted<W>(k.distortion, x, y);
      toRaster(k.screen, at.x, at.y, out.x, out.y);
      // a pixel there sees more or less
      out.pdf = out.pdf * max(at.area, F(0.f));
    }
    out.pdf = zeroUnless(insideRaster(k.screen, out.x, out.y), out.pdf);
    out.importance = out.pdf;
    if (k.natural > 0) {
      const Vec3<W> to = in.P - out.o;
      out.importance = out.importance * dimming<W>(k, to.z / max(length(to), F(1e-30f)));
    }
    if (k.optical > 0) out.importance = out.importance * throughHood<W>(k, x, y, out.o);
  }
};
KINORA_KERNELS_END

KINORA_PLUGIN(
    PxrCamera, ProjectionRunner<PxrCameraProjection>, ProjectionPlugin,
    .help =
        "Perspective with a thin lens, lens shift, tilt and roll, squeeze, distortion and vignetting. The shape of "
        "the lens is "
        "the Camera request's: "
        "apertureNSides, apertureAngle, apertureRoundness, apertureDensity, dofaspect. Depth of field is set by "
        "fStop, focalLength and focalDistance here; the DepthOfField request has no effect.",
    .params = pxrCamera::kParams, .setUp = setUpBy<pxrCamera::makeCamera>, .ndcMatrix = pxrCamera::ndcMatrix,
    .sweep = pxrCamera::sweep)
