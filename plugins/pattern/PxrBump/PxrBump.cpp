// PxrBump: the slope of an image of heights bends the normal. Slopes are differences of two lookups a footprint
// apart, so that they fade with distance like the image; the gradients of the texture coordinates take them to the
// surface, so that they follow the picture however a manifold turns, mirrors or stretches it. A PxrTexture connected to
// inputBump has become this node's own file before shading, and one whose heights come of shaders alone has become a
// shader (shade/connected_bumps); the gradient of what other patterns connect is the renderer's to find.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrBump/PxrBump.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/images/image_lookup.h"
#include "plugins/pattern/slopes/surface_gradient.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kScale,
  kDisable,
  kInputBump,
  kFilename,
  kFirstChannel,
  kAtlasStyle,
  kInvertT,
  kBlur,
  kLerp,
  kManifold,
  kInputN,
  kReverse,
  kAdjustAmount,
  kSurfaceNormalMix,
  kLinearize
};
constexpr Param kParams[] = {
    param::number("scale", 1.f).range(-2, 2).help("Height of white, render units."),
    param::flag("disable", false).help("1: the normal stays as it is."),
    param::number("inputBump", 0.f)
        .help("Heights of a pattern. A PxrTexture connected here gives file, manifold, linearize and colorScale; "
              "heights of OSL shaders have their own slopes; those of other patterns are differences over the "
              "footprint, for which all that feeds them runs three times. A number alone has no slope."),
    param::string("filename", "").file().help("Image of heights."),
    param::integer("firstChannel", 0).range(0, 3).help("Channel of the file with the heights."),
    KINORA_IMAGE_ATLAS,
    param::flag("invertT", true).help("1: t counts up in the picture. Ignored where a manifold is connected."),
    KINORA_IMAGE_BLUR,
    param::structure("manifold").gradients().help("Texture coordinates; st where not connected."),
    param::normal("inputN").help("Normal that the heights bend further."),
    param::flag("reverse", false).help("1: white is low."),
    param::number("adjustAmount", 1.f).help("No effect: materials bend averted normals themselves."),
    param::number("surfaceNormalMix", 0.f).help("Share of the unbent normal."),
    param::flag("linearize", false).help("1: heights are decoded from sRGB before they are filtered."),
    KINORA_BENT_NORMAL_OUTPUTS,
};

struct PxrBump : BendsNormals<PxrBump> {
  template <int W>
  static void bend(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Value input = c->param(kInputN), scale = c->param(kScale), mix = c->param(kSurfaceNormalMix);
    float* out[3];
    makeOutput(*c, args->outputs[0], 3, false, out);
    const bool bumped = isBumped(input), isOff = fixedInteger(*c, kDisable) != 0;
    const Value handles = c->param(kFilename);
    const bool hasImage = !isOff && hasFile(handles);
    // an image counts before what is connected, material by material
    const Value slope = isOff || (hasImage && handles.uniform()) ? Value() : c->fn->paramGradient(c, kInputBump, 0);
    if (!hasImage && !slope.components) {
      for (uint32_t i = 0; i < c->padded; i += W) {
        const Surface<W> s(*c, At{i, false});
        (bumped ? bumpedNormal<W>(input, s) : s.N).store(out, i);
      }
      return;
    }
    // how much it rises along the surface
    float* rises[3];
    Value rise;
    makeOutput(*c, rise, 3, false, rises);
    const F sign(fixedInteger(*c, kReverse) != 0 ? -1.f : 1.f);
    if (hasImage) findRises<W>(*c, handles, sign, scale, rises);
    for (uint32_t i = 0; slope.components && i < c->padded; i += W) {
      const At at{i, false};
      const Vec3<W> own = loadVec<W>(slope, at) * (sign * loadFloat<W>(scale, at));
      alignas(64) float hasNone[W];
      for (uint32_t l = 0; l < uint32_t(W); ++l) hasNone[l] = handleAt(handles, i + l) < 0;
      select(F::load(hasNone) > F(0.f), own, hasImage ? Vec3<W>::load(rises, i) : own).store(rises, i);
    }
    for (uint32_t i = 0; i < c->padded; i += W) {
      const At at{i, false};
      const Surface<W> s(*c, at);
      const Vec3<W> n = bumped ? bumpedNormal<W>(input, s) : s.N;
      Vec3<W> r = Vec3<W>::load(rises, i);
      r = fma(n, -dot(n, r), r);
      normalize(lerp(normalize(n - r), n, loadFloat<W>(mix, at))).store(out, i);
    }
  }
  // Of the heights of an image.
  template <int W>
  static void findRises(const Context& c, const Value& handles, Float<W> sign, const Value& scale,
                        float* const rises[3]) {
    using F = Float<W>;
    const Value blur = c.param(kBlur);
    const Manifold m = surfaceManifold(c, kManifold, true);
    const bool flip = !c.fn->manifold(&c, kManifold) && fixedInteger(c, kInvertT) != 0;
    TextureOptions o;
    o.firstChannel = fixedInteger(c, kFirstChannel);
    o.interpolateLevels = fixedInteger(c, kLerp);
    o.filter = 2;
    o.linearize = fixedInteger(c, kLinearize);
    o.missingColor[0] = o.missingColor[1] = o.missingColor[2] = 0.f;
    // heights at the point, a step along s, a step up t
    float *height[3], *st[3], *radius[3], *rest[3];
    Value heights, place, size, unused;
    makeOutput(c, heights, 3, false, height);
    makeOutput(c, place, 2, false, st);
    makeOutput(c, size, 2, false, radius);
    makeOutput(c, unused, 3, false, rest);
    for (uint32_t step = 0; step < 3; ++step) {
      for (uint32_t i = 0; i < c.padded; i += W) {
        const At at{i, false};
        const F r = max(abs(loadFloat<W>(m.radius, at)) + loadFloat<W>(blur, at), F(kLeastStep));
        F s = loadComponent<W>(m.q, 0, at), t = loadComponent<W>(m.q, 1, at);
        if (step == 1) s += r;
        if (step == 2) t += r;
        s.store(st[0] + i);
        (flip ? F(1.f) - t : t).store(st[1] + i);
        r.store(radius[0] + i);
      }
      float* const rgba[4] = {height[step], rest[0], rest[1], rest[2]};
      c.fn->texture(&c, &handles, st[0], st[1], radius[0], nullptr, &o, rgba);
      for (uint32_t i = c.count; i < c.padded; ++i) height[step][i] = height[step][c.count - 1];
    }
    for (uint32_t i = 0; i < c.padded; i += W) {
      const At at{i, false};
      const F k = sign * loadFloat<W>(scale, at) / F::load(radius[0] + i), h = F::load(height[0] + i);
      fma(loadVec<W>(m.gradient[0], at), (F::load(height[1] + i) - h) * k,
          loadVec<W>(m.gradient[1], at) * ((F::load(height[2] + i) - h) * k))
          .store(rises, i);
    }
  }
  static constexpr float kLeastStep = 1e-4f;  // fraction of the image: below it differences are noise
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrBump, .help = "Shading normals from an image of heights.", .params = kParams)
