// PxrMultiTexture: one of up to ten images, chosen by a manifold of several textures (PxrTileManifold, PxrRoundCube
// ...), with colours that vary from tile to tile and from object to object.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrMultiTexture/PxrMultiTexture.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/images/image_lookup.h"
#include "plugins/pattern/variation/vary.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kManifold,
  kFilename0,
  kFirstChannel = kFilename0 + 10,
  kImage,
  kRandomSource = kImage + kImageParams,
  kRandomSeed,
  kRandomHue,
  kHueMode = kRandomHue + 4
};
constexpr uint32_t kFiles = 10;
#define KINORA_FILE(n) param::string("filename" #n, "").file().help("Image " #n " of the manifold's.")
constexpr Param kParams[] = {
    param::structure("manifoldMulti")
        .help("Texture coordinates and number of the image; st and image 0 where not connected."),
    KINORA_FILE(0),
    KINORA_FILE(1),
    KINORA_FILE(2),
    KINORA_FILE(3),
    KINORA_FILE(4),
    KINORA_FILE(5),
    KINORA_FILE(6),
    KINORA_FILE(7),
    KINORA_FILE(8),
    KINORA_FILE(9),
    param::integer("firstChannel", 0).range(0, 3).help("Channel of the files that becomes red."),
    KINORA_IMAGE_PARAMS,
    KINORA_VARY_SOURCE,
    param::number("randomSeed", 0.f).help("Another number, another set of variations."),
    KINORA_VARY_AMOUNTS("randomHue", "randomSaturation", "randomLuminance", "randomGamma"),
    KINORA_VARY_SIDES,
    KINORA_IMAGE_OUTPUTS,
};
#undef KINORA_FILE

struct PxrMultiTexture {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const ImageLookup lookup(*c, kManifold, kImage + kImageInvertT);
    float *rgb[3], *alpha[3];
    makeOutput(*c, args->outputs[0], 3, false, rgb);
    makeOutput(*c, args->outputs[4], 1, false, alpha);
    float* const rgba[4] = {rgb[0], rgb[1], rgb[2], alpha[0]};
    lookup.read<W>(chosen(*c, lookup.manifold()), c->param(kImage + kImageBlur),
                   imageOptions(*c, kImage, kFirstChannel), rgba);
    vary<W>(*c, lookup.manifold(), rgb);
    shareComponents(*args, 0);
  }
  // Each point's file: numbers past the last one that is named go round.
  static Value chosen(const Context& c, const Manifold& m) {
    Value files[kFiles];
    uint32_t most = 0;
    for (uint32_t k = 0; k < kFiles; ++k) {
      files[k] = c.param(kFilename0 + k);
      if (hasFile(files[k])) most = k + 1;
    }
    if (most < 2 || m.q.components < 3) return files[0];
    Value v;
    float* handles[3];
    makeOutput(c, v, 1, false, handles);
    for (uint32_t i = 0; i < c.padded; ++i) {
      const float x = m.q.data[2][m.q.stride ? i : 0];
      uint32_t n = most;  // of this point's material
      while (n > 1 && handleAt(files[n - 1], i) < 0) --n;
      const uint32_t k = (x > 0 && x < 65536 ? uint32_t(x) : 0) % n;
      const int32_t h = handleAt(files[k], i);
      std::memcpy(&handles[0][i], &h, sizeof h);
    }
    return v;
  }
  template <int W>
  static void vary(const Context& c, const Manifold& m, float* const rgb[3]) {
    const Variation change(c, kRandomHue, kHueMode);
    if (change.isOff()) return;
    const Value extra = c.param(kRandomSeed), id = c.builtin(Builtin::ObjectId);
    for (uint32_t i = 0; i < c.padded; i += W) {
      const At at{i, false};
      Int<W> seed = hashWords(seedOf(loadComponent<W>(id, 0, at)), seedOf(loadFloat<W>(extra, at)));
      // what manifolds of tiles hand on behind the number of the image
      if (m.q.components > 2) seed = hashWords(seed, seedOf(loadComponent<W>(m.q, 2, at)));
      change.apply(Rgb<W>::load(rgb, i), seed, at).store(rgb, i);
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrMultiTexture, .help = "One of several images, chosen tile by tile.", .params = kParams)
