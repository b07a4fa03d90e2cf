// PxrTexture: filtered lookups in an image, at the texture coordinates or at a manifold. The mip level follows the
// footprint. invertT counts only where no manifold is connected, since manifolds invert t themselves.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrTexture/PxrTexture.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kFilename,
  kFirstChannel,
  kAtlasStyle,
  kInvertT,
  kFilter,
  kBlur,
  kLerp,
  kMissingColor,
  kMissingAlpha,
  kLinearize,
  kManifold,
  kMipBias,
  kMaxResolution,
  kOptimizeIndirect,
  kColorScale,
  kColorOffset,
  kSaturation,
  kAlphaScale,
  kAlphaOffset
};
constexpr Param kParams[] = {
    param::string("filename", "")
        .file()
        .help("Image; <UDIM>, <U>_<V>, <u>_<v> or _MAPID_ in its name make it an atlas."),
    param::integer("firstChannel", 0).range(0, 3).help("Channel of the file that becomes red."),
    param::integer("atlasStyle", 0)
        .range(0, 3)
        .options("0 nfalse, 1 UDIM, 2 u0_v0, 3 U1_V1")
        .help("Accepted; the token in the file name says which files make the atlas."),
    param::integer("invertT", 1)
        .range(0, 1)
        .help("1: t counts up in the picture. Ignored where a manifold is connected."),
    param::integer("filter", 1)
        .range(0, 7)
        .options("0 nearest, 1 box, 2 bilinear, 3 b-spline, 6 gaussian, 7 lagrangian")
        .help("Filter of lookups."),
    param::number("blur", 0.f).help("Added to the footprint, fraction of the image."),
    param::integer("lerp", 1).range(0, 1).help("1: blends two mip levels."),
    param::color("missingColor", 1, 0, 1)
        .fixed()
        .help("Result where there is no image; magenta is shown as a checkerboard of two greys."),
    param::number("missingAlpha", 1.f).fixed().help("resultA where there is no image."),
    param::integer("linearize", 0).range(0, 1).help("1: the file stores sRGB; it is decoded before it is filtered."),
    param::structure("manifold").help("Texture coordinates; st where not connected."),
    param::integer("mipBias", 0)
        .range(-4, 4)
        .help("Mip levels to go coarser (or finer, below 0) than the footprint asks."),
    param::integer("maxResolution", 0).range(0, 16384).help("Finest footprint: one over this; 0: no limit."),
    param::integer("optimizeIndirect", 1).range(0, 1).help("1: box filter at points not seen directly."),
    param::color("colorScale", 1.f).help("Factor of the colour."),
    param::color("colorOffset", 0.f).range(-1, 1).help("Added to the colour."),
    param::number("saturation", 1.f).range(0, 2).help("0: grey, 1: as it is."),
    param::number("alphaScale", 1.f).help("Factor of resultA."),
    param::number("alphaOffset", 0.f).range(-1, 1).help("Added to resultA."),
    param::output(Type::Color, "resultRGB"),
    param::output(Type::Float, "resultR"),
    param::output(Type::Float, "resultG"),
    param::output(Type::Float, "resultB"),
    param::output(Type::Float, "resultA"),
};

struct PxrTexture {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Value handles = c->param(kFilename), blur = c->param(kBlur);
    const Value missing = c->param(kMissingColor), missingAlpha = c->param(kMissingAlpha);
    const Manifold m = surfaceManifold(*c, kManifold);
    const bool flip = !c->fn->manifold(c, kManifold) && fixedInteger(*c, kInvertT) != 0;

    TextureOptions o;
    o.firstChannel = fixedInteger(*c, kFirstChannel);
    const bool indirect = !(c->traits & kTraitPrimaryHit) && fixedInteger(*c, kOptimizeIndirect) != 0;
    o.filter = indirect ? 1 : fixedInteger(*c, kFilter);
    o.interpolateLevels = fixedInteger(*c, kLerp);
    o.linearize = fixedInteger(*c, kLinearize);
    for (uint32_t k = 0; k < 3; ++k) o.missingColor[k] = missing.data[k][0];
    o.missingAlpha = missingAlpha.data[0][0];

    float *st[3], *radius[3], *rgb[3], *alpha[3];
    Value place, size;
    makeOutput(*c, place, 2, false, st);
    makeOutput(*c, size, 1, false, radius);
    makeOutput(*c, args->outputs[0], 3, false, rgb);
    makeOutput(*c, args->outputs[4], 1, false, alpha);
    const int bias = fixedInteger(*c, kMipBias), most = fixedInteger(*c, kMaxResolution);
    const LookupEllipses ellipses(*c, kManifold, flip);
    const F scale = exp2(F(float(bias))), least(most > 0 ? 1.f / float(most) : 0.f);
    for (uint32_t i = 0; i < c->padded; i += W) {
      const At at{i, false};
      loadComponent<W>(m.q, 0, at).store(st[0] + i);
      const F t = loadComponent<W>(m.q, 1, at);
      (flip ? F(1.f) - t : t).store(st[1] + i);
      // blur is taken per point here, so that options stay the same for all
      max(fma(abs(loadFloat<W>(m.radius, at)), scale, loadFloat<W>(blur, at)), least).store(radius[0] + i);
      ellipses.store<W>(i, scale, loadFloat<W>(blur, at), least);
    }
    float* const rgba[4] = {rgb[0], rgb[1], rgb[2], alpha[0]};
    c->fn->texture(c, &handles, st[0], st[1], radius[0], ellipses.axes(), &o, rgba);
    // lookups fill the points; the padding repeats the last one
    for (uint32_t i = c->count; i < c->padded; ++i)
      for (float* p : rgba) p[i] = p[c->count - 1];
    adjust<W>(*c, args);
    shareComponents(*args, 0);
  }

  // Colour and alpha corrections, skipped at their defaults.
  template <int W>
  static void adjust(const Context& c, const PatternArgs* args) {
    using F = Float<W>;
    const Value colorScale = c.param(kColorScale), colorOffset = c.param(kColorOffset),
                saturation = c.param(kSaturation);
    const Value alphaScale = c.param(kAlphaScale), alphaOffset = c.param(kAlphaOffset);
    if (isAll(colorScale, 1.f) && isAll(colorOffset, 0.f) && isAll(saturation, 1.f) && isAll(alphaScale, 1.f) &&
        isAll(alphaOffset, 0.f))
      return;
    const Value in = args->outputs[0], inAlpha = args->outputs[4];
    float *out[3], *outAlpha[3];
    makeOutput(c, args->outputs[0], 3, false, out);
    makeOutput(c, args->outputs[4], 1, false, outAlpha);
    for (uint32_t i = 0; i < c.padded; i += W) {
      const At at{i, false};
      Rgb<W> color = loadRgb<W>(in, at);
      const F grey = luminance(color);
      color = lerp(Rgb<W>(grey, grey, grey), color, loadFloat<W>(saturation, at));
      (color * loadRgb<W>(colorScale, at) + loadRgb<W>(colorOffset, at)).store(out, i);
      fma(loadFloat<W>(inAlpha, at), loadFloat<W>(alphaScale, at), loadFloat<W>(alphaOffset, at))
          .store(outAlpha[0] + i);
    }
  }
  static bool isAll(const Value& v, float x) {
    if (!v.uniform()) return false;
    for (uint32_t k = 0; k < v.components; ++k)
      if (v.data[k][0] != x) return false;
    return true;
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrTexture, .help = "Looks up an image, filtered over the footprint.", .params = kParams)
