// PxrRandomTextureManifold: texture coordinates that each object turns, flips and shifts at random, and a texture
// chosen for it.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrRandomTextureManifold/PxrRandomTextureManifold.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/places/tiles.h"
#include "plugins/pattern/variation/vary.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kNumTextures,
  kTextureOrder,
  kRandomSource,
  kRandomExtraSeed,
  kRandomOrientation,
  kRandomFlipS,
  kRandomFlipT,
  kRandomOffsetS,
  kRandomOffsetT,
  KINORA_TILE_PLACE_INDICES
};
constexpr Param kParams[] = {
    KINORA_TILE_COUNT,
    KINORA_VARY_SOURCE,
    param::number("randomExtraSeed", 0.f).help("Another number, another set of variations."),
    param::flag("randomOrientation", false).help("1: turned by some quarter turns."),
    param::flag("randomFlipS", false).help("1: every other object mirrors s."),
    param::flag("randomFlipT", false).help("1: every other object mirrors t."),
    param::flag("randomOffsetS", false).help("1: s is shifted by 0 to 1."),
    param::flag("randomOffsetT", false).help("1: t is shifted by 0 to 1."),
    KINORA_TILE_PLACE_PARAMS(param::flag("invertT", true).help("1: t becomes 1 - t, last of all.")),
    KINORA_TILE_OUTPUTS,
};

struct PxrRandomTextureManifold {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    using I = Int<W>;
    const Place2D place(*c, KINORA_TILE_PLACE);
    const Value extra = c->param(kRandomExtraSeed), id = c->builtin(Builtin::ObjectId);
    bool on[5];
    for (uint32_t k = 0; k < 5; ++k) on[k] = fixedInteger(*c, kRandomOrientation + k) != 0;
    const bool flip = fixedInteger(*c, kInvertT) != 0;
    const TextureChoice textures(*c, kNumTextures, kTextureOrder);
    TileOutputs out(*c, *args, place.uniform() && allUniform({&extra, &id}));
    for (uint32_t i = 0; i < extent(*c, out.one); i += W) {
      const At at{i, false};
      F s, t, r;
      place.at<W>(at, s, t, r);
      const F object = loadComponent<W>(id, 0, at);
      const I seed = hashWords(seedOf(object), seedOf(loadFloat<W>(extra, at)));
      const auto random = [&](uint32_t k) { return toUnitFloat(hashWords(seed, I(0x9e3779b9u + k))); };
      const F one(1.f), half(0.5f);
      if (on[0]) {
        const F quarters = floor(random(0) * F(4.f));
        const Mask<W> around = quarters >= F(2.f), across = (quarters == one) | (quarters == F(3.f));
        s = select(around, one - s, s);
        t = select(around, one - t, t);
        const F turnedS = select(across, one - t, s);
        t = select(across, s, t);
        s = turnedS;
      }
      if (on[1]) s = select(random(1) < half, s, one - s);
      if (on[2]) t = select(random(2) < half, t, one - t);
      if (on[3]) s += random(3);
      if (on[4]) t += random(4);
      out.store(i, s, flip ? one - t : t, r, textures.of(seed, abs(floor(object))), one);
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrRandomTextureManifold, .help = "Another place of a texture, and another texture, for each object.",
               .params = kParams)
