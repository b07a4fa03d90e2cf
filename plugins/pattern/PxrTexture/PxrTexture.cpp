// PxrTexture: filtered lookups in an image, at the texture coordinates or at a manifold. The mip level follows the
// footprint. invertT counts only where no manifold is connected, since manifolds invert t themselves.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrTexture/PxrTexture.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/images/image_lookup.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kFilename,
  kFirstChannel,
  kAtlasStyle,
  kImage,
  kManifold = kImage + kImageParams,
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
    KINORA_IMAGE_ATLAS,
    KINORA_IMAGE_PARAMS,
    param::structure("manifold").help("Texture coordinates; st where not connected."),
    param::integer("mipBias", 0)
        .range(-4, 4)
        .help("Mip levels to go coarser (or finer, below 0) than the footprint asks."),
    param::integer("maxResolution", 0).range(0, 16384).help("Finest footprint: one over this; 0: no limit."),
    param::flag("optimizeIndirect", true).help("1: box filter at points not seen directly."),
    param::color("colorScale", 1.f).help("Factor of the colour."),
    param::color("colorOffset", 0.f).range(-1, 1).help("Added to the colour."),
    param::number("saturation", 1.f).range(0, 2).help("0: grey, 1: as it is."),
    param::number("alphaScale", 1.f).help("Factor of resultA."),
    param::number("alphaOffset", 0.f).range(-1, 1).help("Added to resultA."),
    KINORA_IMAGE_OUTPUTS,
};

struct PxrTexture {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    TextureOptions o = imageOptions(*c, kImage, kFirstChannel);
    if (!(c->traits & kTraitPrimaryHit) && fixedInteger(*c, kOptimizeIndirect) != 0) o.filter = 1;
    float *rgb[3], *alpha[3];
    makeOutput(*c, args->outputs[0], 3, false, rgb);
    makeOutput(*c, args->outputs[4], 1, false, alpha);
    const int bias = fixedInteger(*c, kMipBias), most = fixedInteger(*c, kMaxResolution);
    float* const rgba[4] = {rgb[0], rgb[1], rgb[2], alpha[0]};
    ImageLookup(*c, kManifold, kImage + kImageInvertT)
        .read<W>(c->param(kFilename), c->param(kImage + kImageBlur), o, rgba, exp2(F(float(bias))),
                 F(most > 0 ? 1.f / float(most) : 0.f));
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
