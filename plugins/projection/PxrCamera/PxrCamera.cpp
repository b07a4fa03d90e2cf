// PxrCamera: the thin-lens camera with shift, roll, squeeze and natural vignetting. Its other models of lens defects,
// rolling shutter and the like are declared so that scenes which name them are read, and say in their help that they
// change nothing yet.
#define KINORA_KERNEL_FILE "plugins/projection/PxrCamera/PxrCamera.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include <kinora/projection_author.h>

#if KINORA_PLAIN
namespace kinora::pxrCamera {
using namespace param;
constexpr float kZeros[3] = {0, 0, 0}, kEnhance[3] = {0, 0, 1};
constexpr Param list(const char* name, const float* values, uint32_t count, const char* text) {
  return array(Type::Float, name, values, count).help(text);
}
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
    number("tilt", 0.f).range(-45, 45).help("No effect yet: tilt of the lens in degrees."),
    point("focus1", 0, 0, 0)
        .help(
            "World space. With focus2 and focus3: three points that the plane of focus passes through, which may be "
            "tilted; instead of focalDistance. Used when they are not all the same."),
    point("focus2", 0, 0, 0).help("World space; see focus1."),
    point("focus3", 0, 0, 0).help("World space; see focus1."),
    integer("lensType", 2).range(0, 2).help("No effect yet: model of lens distortion."),
    number("radial1", 0.f).range(-1, 1).help("No effect yet: distortion with the square of the radius."),
    number("radial2", 0.f).range(-1, 1).help("No effect yet: distortion with the fourth power of the radius."),
    number("assymX", 0.f).range(-1, 1).help("No effect yet: asymmetric distortion."),
    number("assymY", 0.f).range(-1, 1).help("No effect yet: asymmetric distortion."),
    number("lensAsymmetryX", 0.f).range(-1, 1).help("No effect yet: asymmetric distortion."),
    number("lensAsymmetryY", 0.f).range(-1, 1).help("No effect yet: asymmetric distortion."),
    list("distortionCtr", kZeros, 2, "No effect yet: centre of the distortion."),
    number("lensScale", 1.f)
        .range(0.1f, 10)
        .help("Size of the picture about the middle of the lens: 2 shows things twice as large."),
    number("squeeze", 1.f)
        .range(0.5f, 2)
        .help("Anamorphic lens: so many times as wide a view, squeezed into the picture's width."),
    color("axial", 0.f).help("No effect yet: shift of focus by channel."),
    color("transverse", 1.f).help("No effect yet: magnification by channel."),
    number("natural", 0.f)
        .range(0, 1)
        .help("Natural vignetting: how much of the fourth power of the cosine to the view axis dims the picture; of "
              "a shifted "
              "lens about its axis, not the picture's middle."),
    number("optical", 0.f).range(0, 1).help("No effect yet: vignetting by the lens hood."),
    string("sweep", "down").options("down|right|up|left").help("No effect yet: direction of the rolling shutter."),
    number("duration", 1.f).range(0, 1).help("No effect yet: part of the shutter time that a line is exposed for."),
    number("detail", 0.f).range(-4, 4).help("No effect yet: bias of texture detail."),
    list("enhance", kEnhance, 3, "No effect yet: centre and zoom of a magnifier."),
    integer("enhanceDiffAdjust", 0).range(0, 1).help("No effect yet: see enhance."),
    integer("enhanceDisableDOF", 0).range(0, 1).help("No effect yet: see enhance."),
    integer("enhanceDisableMoBlur", 0).range(0, 1).help("No effect yet: see enhance."),
    string("matte", "").help("No effect yet: image that holds parts of the picture out."),
    string("cocTexture", "").help("No effect yet: image of circles of confusion."),
    number("dofMult", 1.f).range(0, 4).help("No effect yet: factor on depth of field."),
    list("dofPivotCenter", kZeros, 3, "No effect yet: pivot of depth of field."),
    number("dofRadiusStrength", 0.f).range(0, 1).help("No effect yet: depth of field by radius."),
    number("dofRadiusFalloff", 1.f).range(0, 4).help("No effect yet: depth of field by radius."),
    number("dofSqAnamorph", 1.f).range(0.5f, 2).help("No effect yet: squeezed depth of field."),
    list("dofSqCtr", kZeros, 3, "No effect yet: squeezed depth of field."),
    number("dofSqStrength", 0.f).range(0, 1).help("No effect yet: squeezed depth of field."),
    number("dofSqFalloff", 1.f).range(0, 4).help("No effect yet: squeezed depth of field."),
    integer("numSplitDiopters", 0).range(0, 2).help("No effect yet: split dioptres."),
    number("splitDiopterAngle", 0.f).range(-180, 180).help("No effect yet: split dioptres."),
    number("splitDiopterFocusDistance1", 0.f).range(0, 100).help("No effect yet: split dioptres."),
    number("splitDiopterFocusDistance2", 0.f).range(0, 100).help("No effect yet: split dioptres."),
    number("splitDiopterOffset1", 0.f).range(-1, 1).help("No effect yet: split dioptres."),
    number("splitDiopterOffset2", 0.f).range(-1, 1).help("No effect yet: split dioptres."),
    number("splitDiopterWidth1", 0.f).range(0, 1).help("No effect yet: split dioptres."),
    number("splitDiopterWidth2", 0.f).range(0, 1).help("No effect yet: split dioptres."),
};
constexpr auto kParams = joinParams(projectionParams::kLens, kOwn);

struct Camera : ThinLens {
  float natural = 0;
};

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
  const double natural = values.number("natural");
  lens->natural = float(std::fmin(1, std::fmax(0, natural)));
  if (!(natural >= 0 && natural <= 1))
    values.warn("PARAM-RANGE", "natural is not within 0 to 1", "it is brought within");
  const double roll = values.number("roll") * 3.14159265358979323846 / 180;
  lens->screen.cosRoll = float(std::cos(roll));
  lens->screen.sinRoll = float(std::sin(roll));
  double focus[9];
  bool areOne = true;
  for (int i = 0; i < 9; ++i) {
    focus[i] = values.number("focus" + std::to_string(1 + i / 3), i % 3);
    areOne = areOne && focus[i] == focus[i % 3];
  }
  if (!areOne && lens->lensRadius > 0 && !setPlaneOfFocus(*lens, focus, *projection))
    values.warn("PROJECTION-FOCUS", "focus1, focus2 and focus3 span no plane of focus that misses the lens",
                "focalDistance is used");
  values.warnNoEffect();
  return lens;
}
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
  template <int W>
  static KN_INLINE void rays(const Data& k, const CameraSample<W>& in, CameraRay<W>& out) {
    ThinLensProjection::rays<W>(k, in, out);
    if (k.natural > 0) out.weight = dimming<W>(k, out.d.z);
  }
  template <int W>
  static KN_INLINE void connect(const Data& k, const CameraPoint<W>& in, CameraLink<W>& out) {
    ThinLensProjection::connect<W>(k, in, out);
    if (!(k.natural > 0)) return;
    const Vec3<W> to = in.P - out.o;
    out.importance = out.importance * dimming<W>(k, to.z / max(length(to), Float<W>(1e-30f)));
  }
};
KINORA_KERNELS_END

KINORA_PLUGIN(
    PxrCamera, ProjectionRunner<PxrCameraProjection>, ProjectionPlugin,
    .help =
        "Perspective with a thin lens, lens shift and roll, squeeze and natural vignetting. The shape of the lens is "
        "the Camera request's: "
        "apertureNSides, apertureAngle, apertureRoundness, apertureDensity, dofaspect. Depth of field is set by "
        "fStop, focalLength and focalDistance here; the DepthOfField request has no effect.",
    .params = pxrCamera::kParams, .setUp = setUpBy<pxrCamera::makeCamera>, .ndcMatrix = pxrCamera::ndcMatrix)
