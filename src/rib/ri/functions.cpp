// Options, attributes, shaders, transforms and blocks of the C interface.
#include <cmath>
#include <cstdlib>
#include <string>

#include "rib/ri/parameter_lists.h"

using kinora::rib::ri::stream;
namespace scene = kinora::scene;

namespace {

// The latest request acts first on points.
void concat(const scene::Matrix& m) { stream().transform() = m * stream().transform(); }
scene::Matrix matrixOf(const RtFloat m[4][4]) {
  scene::Matrix out;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) out[r][c] = m[r][c];
  return out;
}
void numbers(const char* request, std::initializer_list<RtFloat> x) {
  stream().request(request);
  for (const RtFloat v : x) stream().number(v);
}

}  // namespace

extern "C" {

#define KINORA_RI_TOKEN(NAME, TEXT) RtToken NAME = const_cast<RtToken>(TEXT);
KINORA_RI_TOKENS(KINORA_RI_TOKEN)
#undef KINORA_RI_TOKEN

RtInt RiLastError = 0;
RtBasis RiBezierBasis = {{-1, 3, -3, 1}, {3, -6, 3, 0}, {-3, 3, 0, 0}, {1, 0, 0, 0}};
RtBasis RiBSplineBasis = {{-1 / 6.f, 3 / 6.f, -3 / 6.f, 1 / 6.f},
                          {3 / 6.f, -1, 3 / 6.f, 0},
                          {-3 / 6.f, 0, 3 / 6.f, 0},
                          {1 / 6.f, 4 / 6.f, 1 / 6.f, 0}};
RtBasis RiCatmullRomBasis = {{-.5f, 1.5f, -1.5f, .5f}, {1, -2.5f, 2, -.5f}, {-.5f, 0, .5f, 0}, {0, 1, 0, 0}};
RtBasis RiHermiteBasis = {{2, 1, -2, 1}, {-3, -2, 3, -1}, {0, 1, 0, 0}, {1, 0, 0, 0}};
RtBasis RiPowerBasis = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};

// Spec 3.2, section 4: what a C program may call itself. RIB has them by name.
RtFloat RiBoxFilter(RtFloat x, RtFloat y, RtFloat xwidth, RtFloat ywidth) {
  return std::fabs(x) <= xwidth / 2 && std::fabs(y) <= ywidth / 2 ? 1.f : 0.f;
}
RtFloat RiTriangleFilter(RtFloat x, RtFloat y, RtFloat xwidth, RtFloat ywidth) {
  return std::fmax(0.f, 1 - std::fabs(2 * x / xwidth)) * std::fmax(0.f, 1 - std::fabs(2 * y / ywidth));
}
RtFloat RiCatmullRomFilter(RtFloat x, RtFloat y, RtFloat, RtFloat) {
  const float r2 = x * x + y * y, r = std::sqrt(r2);
  return r >= 2 ? 0 : r < 1 ? 1.5f * r * r2 - 2.5f * r2 + 1 : -.5f * r * r2 + 2.5f * r2 - 4 * r + 2;
}
RtFloat RiGaussianFilter(RtFloat x, RtFloat y, RtFloat xwidth, RtFloat ywidth) {
  const float a = 2 * x / xwidth, b = 2 * y / ywidth;
  return std::exp(-2 * (a * a + b * b));
}
RtFloat RiSincFilter(RtFloat x, RtFloat y, RtFloat, RtFloat) {
  const auto sinc = [](float v) { return std::fabs(v) < 1e-4f ? 1.f : float(std::sin(M_PI * v) / (M_PI * v)); };
  return sinc(x) * sinc(y);
}
RtVoid RiErrorIgnore(RtInt, RtInt, char*) {}
RtVoid RiErrorPrint(RtInt, RtInt, char* message) { std::fprintf(stderr, "%s\n", message ? message : ""); }
RtVoid RiErrorAbort(RtInt, RtInt, char* message) {
  RiErrorPrint(0, 0, message);
  std::exit(1);
}

RtVoid RiBegin(RtToken) {}
RtVoid RiEnd(void) {}
RtContextHandle RiGetContext(void) { return &stream(); }
RtVoid RiContext(RtContextHandle) {}
RtToken RiDeclare(char* name, char* declaration) {
  if (name && stream().declare(name, declaration)) stream().request("Declare").word(name).word(declaration);
  return name;
}
RtVoid RiErrorHandler(RtErrorHandler handler) {
  stream().request("ErrorHandler");
  stream().word(handler == RiErrorIgnore ? "ignore" : handler == RiErrorAbort ? "abort" : "print");
}

// ---- blocks
RtVoid RiFrameBegin(RtInt frame) { stream().request("FrameBegin").integer(frame); }
RtVoid RiFrameEnd(void) { stream().request("FrameEnd"); }
RtVoid RiWorldBegin(void) { stream().request("WorldBegin"); }
RtVoid RiWorldEnd(void) { stream().request("WorldEnd"); }
RtVoid RiAttributeBegin(void) {
  stream().request("AttributeBegin");
  stream().push(true);
}
RtVoid RiAttributeEnd(void) {
  stream().request("AttributeEnd");
  stream().pop(true);
}
RtVoid RiTransformBegin(void) {
  stream().request("TransformBegin");
  stream().push(false);
}
RtVoid RiTransformEnd(void) {
  stream().request("TransformEnd");
  stream().pop(false);
}
RtVoid RiSolidBegin(RtToken operation) {
  stream().request("SolidBegin").word(operation);
  stream().push(true);
}
RtVoid RiSolidEnd(void) {
  stream().request("SolidEnd");
  stream().pop(true);
}
RtVoid RiMotionBegin(RtInt n, ...) {
  std::vector<RtFloat> times;
  va_list list;
  va_start(list, n);
  for (RtInt i = 0; i < n; ++i) times.push_back(RtFloat(va_arg(list, double)));
  va_end(list);
  RiMotionBeginV(n, times.data());
}
RtVoid RiMotionBeginV(RtInt n, RtFloat times[]) {
  stream().request("MotionBegin").floats(times, size_t(n > 0 ? n : 0));
}
RtVoid RiMotionEnd(void) { stream().request("MotionEnd"); }
RtObjectHandle RiObjectBegin(void) {
  const RtObjectHandle handle = stream().newHandle();
  stream().request("ObjectBegin").handle(handle);
  stream().push(true);
  return handle;
}
RtVoid RiObjectEnd(void) {
  stream().request("ObjectEnd");
  stream().pop(true);
}
RtVoid RiObjectInstance(RtObjectHandle object) { stream().request("ObjectInstance").handle(object); }
RtVoid RiArchiveRecord(RtToken type, char* format, ...) {
  va_list list;
  va_start(list, format);
  char text[4096];
  std::vsnprintf(text, sizeof text, format, list);
  va_end(list);
  const std::string kind = type ? type : "";
  // a line's end in a comment would make RIB of the rest
  std::string words(text);
  if (kind != "verbatim")
    for (char& c : words)
      if (c == '\n') c = ' ';
  stream().request((kind == "verbatim" ? words : (kind == "structure" ? "##" : "#") + words).c_str());
}
KINORA_RI(RiReadArchive, callback, (name, callback), RtToken name, RtArchiveCallback callback) {
  (void)callback;  // of comments in the archive, which is not read here
  stream().request("ReadArchive").word(name).list({n, tokens, values});
}
KINORA_RI(RiArchiveBegin, name, (name), RtToken name) {
  stream().request("ArchiveBegin").word(name).list({n, tokens, values});
  stream().push(true);
}
RtVoid RiArchiveEnd(void) {
  stream().request("ArchiveEnd");
  stream().pop(true);
}

// ---- transforms
RtVoid RiIdentity(void) {
  stream().request("Identity");
  stream().transform() = scene::Matrix();
}
RtVoid RiTransform(RtMatrix m) {
  stream().request("Transform").floats(&m[0][0], 16);
  stream().transform() = matrixOf(m);
}
RtVoid RiConcatTransform(RtMatrix m) {
  stream().request("ConcatTransform").floats(&m[0][0], 16);
  concat(matrixOf(m));
}
RtVoid RiPerspective(RtFloat fov) { numbers("Perspective", {fov}); }
RtVoid RiTranslate(RtFloat dx, RtFloat dy, RtFloat dz) {
  numbers("Translate", {dx, dy, dz});
  concat(scene::Matrix().setTranslation(Imath::V3d(dx, dy, dz)));
}
RtVoid RiRotate(RtFloat angle, RtFloat dx, RtFloat dy, RtFloat dz) {
  numbers("Rotate", {angle, dx, dy, dz});
  if (const Imath::V3d axis(dx, dy, dz); axis.length() > 0)
    concat(scene::Matrix().setAxisAngle(axis, angle * M_PI / 180));
}
RtVoid RiScale(RtFloat sx, RtFloat sy, RtFloat sz) {
  numbers("Scale", {sx, sy, sz});
  concat(scene::Matrix().setScale(Imath::V3d(sx, sy, sz)));
}
// The transform here is for sizes alone, which a skew hardly changes.
RtVoid RiSkew(RtFloat angle, RtFloat dx1, RtFloat dy1, RtFloat dz1, RtFloat dx2, RtFloat dy2, RtFloat dz2) {
  numbers("Skew", {angle, dx1, dy1, dz1, dx2, dy2, dz2});
}
RtVoid RiCoordinateSystem(RtToken space) { stream().request("CoordinateSystem").word(space); }
RtVoid RiScopedCoordinateSystem(RtToken space) { stream().request("ScopedCoordinateSystem").word(space); }
RtVoid RiCoordSysTransform(RtToken space) { stream().request("CoordSysTransform").word(space); }
RtPoint* RiTransformPoints(RtToken, RtToken, RtInt, RtPoint[]) { return nullptr; }

// ---- options
RtVoid RiFormat(RtInt xresolution, RtInt yresolution, RtFloat pixelaspect) {
  stream().request("Format").integer(xresolution).integer(yresolution).number(pixelaspect);
}
RtVoid RiFrameAspectRatio(RtFloat aspect) { numbers("FrameAspectRatio", {aspect}); }
RtVoid RiScreenWindow(RtFloat left, RtFloat right, RtFloat bottom, RtFloat top) {
  numbers("ScreenWindow", {left, right, bottom, top});
}
RtVoid RiCropWindow(RtFloat xmin, RtFloat xmax, RtFloat ymin, RtFloat ymax) {
  numbers("CropWindow", {xmin, xmax, ymin, ymax});
}
KINORA_RI(RiProjection, name, (name), RtToken name) {
  stream().request("Projection").word(name).list({n, tokens, values});
}
RtVoid RiClipping(RtFloat hither, RtFloat yon) { numbers("Clipping", {hither, yon}); }
RtVoid RiClippingPlane(RtFloat x, RtFloat y, RtFloat z, RtFloat nx, RtFloat ny, RtFloat nz) {
  numbers("ClippingPlane", {x, y, z, nx, ny, nz});
}
RtVoid RiDepthOfField(RtFloat fstop, RtFloat focallength, RtFloat focaldistance) {
  numbers("DepthOfField", {fstop, focallength, focaldistance});
}
RtVoid RiShutter(RtFloat opening, RtFloat closing) { numbers("Shutter", {opening, closing}); }
RtVoid RiPixelVariance(RtFloat variance) { numbers("PixelVariance", {variance}); }
RtVoid RiPixelSamples(RtFloat x, RtFloat y) { numbers("PixelSamples", {x, y}); }
RtVoid RiPixelFilter(RtFilterFunc filter, RtFloat xwidth, RtFloat ywidth) {
  const struct {
    RtFilterFunc function;
    const char* name;
  } kFilters[] = {{RiBoxFilter, "box"},
                  {RiTriangleFilter, "triangle"},
                  {RiCatmullRomFilter, "catmull-rom"},
                  {RiGaussianFilter, "gaussian"},
                  {RiSincFilter, "sinc"}};
  const char* name = "gaussian";
  for (const auto& f : kFilters)
    if (f.function == filter) name = f.name;
  stream().request("PixelFilter").word(name).number(xwidth).number(ywidth);
}
RtVoid RiExposure(RtFloat gain, RtFloat gamma) { numbers("Exposure", {gain, gamma}); }
RtVoid RiQuantize(RtToken type, RtInt one, RtInt min, RtInt max, RtFloat dither) {
  stream().request("Quantize").word(type).integer(one).integer(min).integer(max).number(dither);
}
KINORA_RI(RiDisplay, mode, (name, type, mode), RtToken name, RtToken type, RtToken mode) {
  stream().request("Display").word(name).word(type).word(mode).list({n, tokens, values});
}
RtVoid RiColorSamples(RtInt n, RtFloat nRGB[], RtFloat RGBn[]) {
  const size_t count = 3 * size_t(n > 0 ? n : 0);
  stream().request("ColorSamples").floats(nRGB, count).floats(RGBn, count);
}
RtVoid RiRelativeDetail(RtFloat factor) { numbers("RelativeDetail", {factor}); }

// ---- requests that are a name and a list
#define KINORA_RI_NAMED(REQUEST)                                     \
  KINORA_RI(Ri##REQUEST, name, (name), RtToken name) {               \
    stream().request(#REQUEST).word(name).list({n, tokens, values}); \
  }
KINORA_RI_NAMED(Imager)
KINORA_RI_NAMED(Hider)
KINORA_RI_NAMED(Option)
KINORA_RI_NAMED(Attribute)
KINORA_RI_NAMED(Surface)
KINORA_RI_NAMED(Displacement)
KINORA_RI_NAMED(Atmosphere)
KINORA_RI_NAMED(Interior)
KINORA_RI_NAMED(Exterior)
KINORA_RI_NAMED(IfBegin)
KINORA_RI_NAMED(ElseIf)
#undef KINORA_RI_NAMED
#define KINORA_RI_PLUGIN(REQUEST)                                                 \
  KINORA_RI(Ri##REQUEST, handle, (name, handle), RtToken name, RtToken handle) {  \
    stream().request(#REQUEST).word(name).word(handle).list({n, tokens, values}); \
  }
KINORA_RI_PLUGIN(Pattern)
KINORA_RI_PLUGIN(Bxdf)
KINORA_RI_PLUGIN(Displace)
KINORA_RI_PLUGIN(Resource)
#undef KINORA_RI_PLUGIN
#define KINORA_RI_LIGHT(REQUEST)                                                    \
  KINORA_RI_OF(RtLightHandle, Ri##REQUEST, name, (name), RtToken name) {            \
    const RtLightHandle handle = stream().newHandle();                              \
    stream().request(#REQUEST).word(name).handle(handle).list({n, tokens, values}); \
    return handle;                                                                  \
  }
KINORA_RI_LIGHT(LightSource)
KINORA_RI_LIGHT(AreaLightSource)
#undef KINORA_RI_LIGHT
RtVoid RiResourceBegin(void) { stream().request("ResourceBegin"); }
RtVoid RiResourceEnd(void) { stream().request("ResourceEnd"); }
RtVoid RiElse(void) { stream().request("Else"); }
RtVoid RiIfEnd(void) { stream().request("IfEnd"); }

// ---- attributes
RtVoid RiColor(RtColor color) { stream().request("Color").floats(color, 3); }
RtVoid RiOpacity(RtColor opacity) { stream().request("Opacity").floats(opacity, 3); }
RtVoid RiTextureCoordinates(RtFloat s1, RtFloat t1, RtFloat s2, RtFloat t2, RtFloat s3, RtFloat t3, RtFloat s4,
                            RtFloat t4) {
  numbers("TextureCoordinates", {s1, t1, s2, t2, s3, t3, s4, t4});
}
RtVoid RiIlluminate(RtLightHandle light, RtBoolean on) {
  stream().request("Illuminate").handle(light).integer(on != 0);
}
RtVoid RiShadingRate(RtFloat size) { numbers("ShadingRate", {size}); }
RtVoid RiShadingInterpolation(RtToken type) { stream().request("ShadingInterpolation").word(type); }
RtVoid RiMatte(RtBoolean on) { stream().request("Matte").integer(on != 0); }
RtVoid RiBound(RtBound bound) { stream().request("Bound").floats(bound, 6); }
RtVoid RiDetail(RtBound bound) { stream().request("Detail").floats(bound, 6); }
RtVoid RiDetailRange(RtFloat minvisible, RtFloat lower, RtFloat upper, RtFloat maxvisible) {
  numbers("DetailRange", {minvisible, lower, upper, maxvisible});
}
RtVoid RiGeometricApproximation(RtToken type, RtFloat value) {
  stream().request("GeometricApproximation").word(type).number(value);
}
RtVoid RiOrientation(RtToken orientation) { stream().request("Orientation").word(orientation); }
RtVoid RiReverseOrientation(void) { stream().request("ReverseOrientation"); }
RtVoid RiSides(RtInt sides) { stream().request("Sides").integer(sides); }
RtVoid RiBasis(RtBasis ubasis, RtInt ustep, RtBasis vbasis, RtInt vstep) {
  stream().request("Basis").floats(&ubasis[0][0], 16).integer(ustep).floats(&vbasis[0][0], 16).integer(vstep);
  stream().basisSteps(ustep, vstep);
}

}  // extern "C"
