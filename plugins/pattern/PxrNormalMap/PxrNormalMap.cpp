// PxrNormalMap: a normal encoded as a colour, 0.5 standing for 0, from a pattern or an image. Red leans along the
// rows of the picture, green across them, blue is above the surface: the frame is that of the texture coordinates and
// turns with their manifold. Heights above the surface are kept positive; bumpScale stretches the slopes.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrNormalMap/PxrNormalMap.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/images/image_lookup.h"
#include "plugins/pattern/slopes/surface_gradient.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kBumpScale,
  kInputRGB,
  kFilename,
  kBumpOverlay,
  kInvertBump,
  kOrientation,
  kFlipX,
  kFlipY,
  kFirstChannel,
  kAtlasStyle,
  kInvertT,
  kBlur,
  kLerp,
  kManifold,
  kReverse,
  kAdjustAmount,
  kSurfaceNormalMix,
  kDisable
};
constexpr Param kParams[] = {
    param::number("bumpScale", 1.f).range(0, 4).help("Factor of the slopes."),
    param::color("inputRGB", 0.5f, 0.5f, 1).help("Encoded normal, where no image is given."),
    param::string("filename", "").file().help("Image of encoded normals."),
    param::normal("bumpOverlay").help("Normal that the map bends further."),
    param::flag("invertBump", false).help("1: slopes the other way."),
    param::integer("orientation", 2)
        .range(0, 3)
        .options("0 red right green up, 1 red left green up, 2 red right green down, 3 red left green down")
        .help("Which way more red and more green lean in the picture: 0 as OpenGL, 2 as DirectX."),
    param::flag("flipX", false).help("1: red the other way."),
    param::flag("flipY", false).help("1: green the other way."),
    param::integer("firstChannel", 0).range(0, 3).help("Channel of the file that becomes red."),
    KINORA_IMAGE_ATLAS,
    param::flag("invertT", true)
        .help("1: t counts up in the picture, also in one behind inputRGB. Ignored where a manifold is connected."),
    KINORA_IMAGE_BLUR,
    param::structure("manifold")
        .gradients()
        .help("Texture coordinates, which the normals lean along; st where not connected. Connect it for a picture "
              "behind inputRGB too."),
    param::flag("reverse", false).help("1: slopes the other way, on top of invertBump."),
    param::number("adjustAmount", 0.f).help("No effect: materials bend averted normals themselves."),
    param::number("surfaceNormalMix", 0.f).help("Share of the unbent normal."),
    param::flag("disable", false).help("1: the normal stays as it is."),
    KINORA_BENT_NORMAL_OUTPUTS,
};

struct PxrNormalMap : BendsNormals<PxrNormalMap> {
  template <int W>
  static void bend(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Value overlay = c->param(kBumpOverlay), scale = c->param(kBumpScale), mix = c->param(kSurfaceNormalMix);
    float* out[3];
    makeOutput(*c, args->outputs[0], 3, false, out);
    const bool off = fixedInteger(*c, kDisable) != 0, bumped = isBumped(overlay);
    const ImageLookup lookup(*c, kManifold, kInvertT, true);
    const Manifold& m = lookup.manifold();
    const Value rgb = off ? Value() : encoded<W>(*c, lookup);
    const int orientation = fixedInteger(*c, kOrientation);
    const bool turned = (fixedInteger(*c, kInvertBump) != 0) != (fixedInteger(*c, kReverse) != 0);
    const bool left = (orientation & 1) != 0, down = orientation >= 2;
    const F signX((left != (fixedInteger(*c, kFlipX) != 0)) != turned ? -2.f : 2.f);
    const F signY((down != (fixedInteger(*c, kFlipY) != 0)) != turned ? -2.f : 2.f);
    const F up(lookup.flips() ? 1.f : -1.f);  // t of pictures counts down
    for (uint32_t i = 0; i < c->padded; i += W) {
      const At at{i, false};
      const Surface<W> s(*c, at);
      const Vec3<W> n = bumped ? bumpedNormal<W>(overlay, s) : s.N;
      if (off) {
        n.store(out, i);
        continue;
      }
      const Rgb<W> e = loadRgb<W>(rgb, at);
      const F k = loadFloat<W>(scale, at);
      const F x = (e.x - F(0.5f)) * signX * k, y = (e.y - F(0.5f)) * signY * k;
      const F z = max(fma(F(2.f), e.z, F(-1.f)), F(1e-3f));
      // along s where t stands still; mirrored coordinates turn the other axis over
      const Vec3<W> s1 = loadVec<W>(m.gradient[0], at), t1 = loadVec<W>(m.gradient[1], at);
      const Mask<W> mirrored = dot(cross(s1, t1), n) < F(0.f);
      const Vec3<W> across = cross(t1, n);
      const Frame<W> frame = Frame<W>::fromTangent(n, select(mirrored, -across, across));
      const Vec3<W> bent = normalize(frame.toWorld({x, select(mirrored, -y, y) * up, z}));
      normalize(lerp(bent, n, loadFloat<W>(mix, at))).store(out, i);
    }
  }
  // The colour at all points: of the image where there is one.
  template <int W>
  static Value encoded(const Context& c, const ImageLookup& lookup) {
    const Value handles = c.param(kFilename), input = c.param(kInputRGB);
    if (!hasFile(handles)) return input;
    TextureOptions o;
    o.firstChannel = fixedInteger(c, kFirstChannel);
    o.interpolateLevels = fixedInteger(c, kLerp);
    // a missing map leaves the surface flat
    o.missingColor[0] = o.missingColor[1] = 0.5f;
    Value rgb, alpha;
    float *color[3], *a[3];
    makeOutput(c, rgb, 3, false, color);
    makeOutput(c, alpha, 1, false, a);
    float* const rgba[4] = {color[0], color[1], color[2], a[0]};
    lookup.read<W>(handles, c.param(kBlur), o, rgba);
    // materials of the group that have no file
    for (uint32_t i = 0; handles.stride && i < c.padded; ++i)
      for (uint32_t k = 0; handleAt(handles, i) < 0 && k < 3; ++k) color[k][i] = input.data[k][input.stride ? i : 0];
    return rgb;
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrNormalMap, .help = "Shading normals from a tangent-space image.", .params = kParams)
