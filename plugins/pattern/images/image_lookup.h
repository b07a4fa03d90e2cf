// Lookups of images at a manifold, or at the texture coordinates where none is connected: what the patterns that read
// pictures have in common, parameters and the way to the texels. Included per target.
#include <kinora/pattern_author.h>

#ifndef KINORA_IMAGE_LOOKUP_ONCE
#define KINORA_IMAGE_LOOKUP_ONCE
#define KINORA_IMAGE_ATLAS                           \
  param::integer("atlasStyle", 0)                    \
      .range(0, 3)                                   \
      .options("0 nfalse, 1 UDIM, 2 u0_v0, 3 U1_V1") \
      .help("Accepted; the token in the file name says which files make the atlas.")
#define KINORA_IMAGE_BLUR                                                            \
  param::number("blur", 0.f).help("Added to the footprint, fraction of the image."), \
      param::flag("lerp", true).help("1: blends two mip levels.")
// In the order of kImageInvertT and those behind it.
#define KINORA_IMAGE_PARAMS                                                                                   \
  param::flag("invertT", true).help("1: t counts up in the picture. Ignored where a manifold is connected."), \
      param::integer("filter", 1)                                                                             \
          .range(0, 7)                                                                                        \
          .options("0 nearest, 1 box, 2 bilinear, 3 b-spline, 6 gaussian, 7 lagrangian")                      \
          .help(                                                                                              \
              "Filter of lookups. 7 is the b-spline where texels are larger than the footprint: "             \
              "free of facets, and softer than the curve of its name; elsewhere 1."),                         \
      KINORA_IMAGE_BLUR,                                                                                      \
      param::color("missingColor", 1, 0, 1)                                                                   \
          .fixed()                                                                                            \
          .help("Result where there is no image; magenta is shown as a checkerboard of two greys."),          \
      param::number("missingAlpha", 1.f).fixed().help("resultA where there is no image."),                    \
      param::flag("linearize", false).help("1: the file stores sRGB; it is decoded before it is filtered.")
#define KINORA_IMAGE_OUTPUTS KINORA_COLOR_OUTPUTS, param::output(Type::Float, "resultA")
namespace kinora {
// Indices of KINORA_IMAGE_PARAMS from the first of them on, and their number.
inline constexpr uint32_t kImageInvertT = 0, kImageFilter = 1, kImageBlur = 2, kImageLerp = 3, kImageMissingColor = 4,
                          kImageMissingAlpha = 5, kImageLinearize = 6, kImageParams = 7;
}  // namespace kinora
#endif

#if defined(KINORA_IMAGE_LOOKUP_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_IMAGE_LOOKUP_H_TARGET
#undef KINORA_IMAGE_LOOKUP_H_TARGET
#else
#define KINORA_IMAGE_LOOKUP_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// What KINORA_IMAGE_PARAMS ask for. first: of them.
inline TextureOptions imageOptions(const Context& c, uint32_t first, uint32_t firstChannel) {
  TextureOptions o;
  o.firstChannel = fixedInteger(c, firstChannel);
  o.filter = fixedInteger(c, first + kImageFilter);
  o.interpolateLevels = fixedInteger(c, first + kImageLerp);
  o.linearize = fixedInteger(c, first + kImageLinearize);
  const Value missing = c.param(first + kImageMissingColor);
  for (uint32_t k = 0; k < 3; ++k) o.missingColor[k] = missing.data[k][0];
  o.missingAlpha = c.param(first + kImageMissingAlpha).data[0][0];
  return o;
}

class ImageLookup {
 public:
  // Indices of the parameters. gradients: see surfaceManifold().
  ImageLookup(const Context& c, uint32_t manifold, uint32_t invertT, bool gradients = false)
      : c_(c),
        index_(manifold),
        manifold_(surfaceManifold(c, manifold, gradients)),
        flips_(!c.fn->manifold(&c, manifold) && fixedInteger(c, invertT) != 0) {}
  const Manifold& manifold() const { return manifold_; }
  // Pictures are read at 1 - t.
  bool flips() const { return flips_; }
  // At all points; footprints are scaled, widened by `blur` and to `least`.
  template <int W>
  void read(const Value& handles, const Value& blur, const TextureOptions& options, float* const rgba[4],
            Float<W> scale = Float<W>(1.f), Float<W> least = Float<W>(0.f)) const {
    using F = Float<W>;
    float *st[3], *radius[3];
    Value place, size;
    makeOutput(c_, place, 2, false, st);
    makeOutput(c_, size, 1, false, radius);
    const LookupEllipses ellipses(c_, index_, flips_);
    for (uint32_t i = 0; i < c_.padded; i += W) {
      const At at{i, false};
      // blur is taken per point here, so that options stay the same for all
      const F b = loadFloat<W>(blur, at), t = loadComponent<W>(manifold_.q, 1, at);
      loadComponent<W>(manifold_.q, 0, at).store(st[0] + i);
      (flips_ ? F(1.f) - t : t).store(st[1] + i);
      max(fma(abs(loadFloat<W>(manifold_.radius, at)), scale, b), least).store(radius[0] + i);
      ellipses.store<W>(i, scale, b, least);
    }
    c_.fn->texture(&c_, &handles, st[0], st[1], radius[0], ellipses.axes(), &options, rgba);
    // lookups fill the points; the padding repeats the last one
    for (uint32_t i = c_.count; i < c_.padded; ++i)
      for (uint32_t k = 0; k < 4; ++k) rgba[k][i] = rgba[k][c_.count - 1];
  }

 private:
  const Context& c_;
  uint32_t index_;
  Manifold manifold_;
  bool flips_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
