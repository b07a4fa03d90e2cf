// PxrTileManifold: cuts the plane of texture coordinates into unit tiles, each row shifted against the one below, with
// coordinates 0 to 1 of its own for each tile.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrTileManifold/PxrTileManifold.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/places/tiles.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kNumTextures,
  kTextureOrder,
  kGridOffset,
  kGroutWidth,
  kTileBevelWidth,
  kSwapTileST,
  KINORA_TILE_PLACE_INDICES
};
constexpr Param kParams[] = {
    KINORA_TILE_COUNT,
    param::number("gridOffset", 0.5f).help("Shift of each row against the one below, in tiles."),
    KINORA_TILE_GROUT,
    param::flag("swapTileST", false).help("1: s and t change places within each tile."),
    KINORA_TILE_PLACE_PARAMS(KINORA_TILE_INVERT),
    KINORA_TILE_OUTPUTS,
};

struct PxrTileManifold {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Place2D place(*c, KINORA_TILE_PLACE);
    const Value offset = c->param(kGridOffset), gap = c->param(kGroutWidth), bevel = c->param(kTileBevelWidth);
    const bool swap = fixedInteger(*c, kSwapTileST) != 0, flip = fixedInteger(*c, kInvertT) != 0;
    const TextureChoice textures(*c, kNumTextures, kTextureOrder);
    TileOutputs out(*c, *args, place.uniform() && allUniform({&offset, &gap, &bevel}));
    float* const* axes = out.makeAxes(*c, place.hasAxes());
    for (uint32_t i = 0; i < extent(*c, out.one); i += W) {
      const At at{i, false};
      F s, t, r;
      place.at<W>(at, s, t, r);
      const F row = floor(t);
      s = fma(row, loadFloat<W>(offset, at), s);
      const F column = floor(s), g = loadFloat<W>(gap, at);
      const TileWave<W> wave(g, loadFloat<W>(bevel, at));
      const F covered = wave.average(s, r) * wave.average(t, r);
      const F grow = F(1.f) / max(F(1.f) - g, F(1e-3f)), half = g * F(0.5f);
      const F x = clamp((s - column - half) * grow, F(0.f), F(1.f)),
              y = clamp((t - row - half) * grow, F(0.f), F(1.f));
      const F inS = swap ? y : x, inT = swap ? x : y;
      const Int<W> seed = hashWords(toInt(column), toInt(row));
      out.store(i, inS, flip ? F(1.f) - inT : inT, r * grow, textures.of(seed, column + row), covered);
      for (uint32_t k = 0; axes && k < 2; ++k) {
        F as, bs;
        place.axisAt<W>(k, at, as, bs);
        ((swap ? bs : as) * grow).store(axes[2 * k] + i);
        ((swap ? as : bs) * (flip ? F(0.f) - grow : grow)).store(axes[2 * k + 1] + i);
      }
    }
    if (args->wanted[0] & kWantGradients) gradients<W>(*c, place, gap, swap, flip, out.single);
    out.multi.gradient[0] = out.single.gradient[0];
    out.multi.gradient[1] = out.single.gradient[1];
  }
  template <int W>
  static void gradients(const Context& c, const Place2D& place, const Value& gap, bool swap, bool flip, Manifold& m) {
    using F = Float<W>;
    Manifold plane;
    place.makeGradients<W>(plane);
    for (uint32_t k = 0; k < 2; ++k) {
      float* to[3];
      makeOutput(c, m.gradient[k], 3, false, to);
      const F sign(k == 1 && flip ? -1.f : 1.f);
      for (uint32_t i = 0; i < c.padded; i += W) {
        const At at{i, false};
        const F grow = sign / max(F(1.f) - loadFloat<W>(gap, at), F(1e-3f));
        (loadVec<W>(plane.gradient[swap ? 1 - k : k], at) * grow).store(to, i);
      }
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrTileManifold, .help = "Rows of tiles: bricks, planks, with a choice of textures.",
               .params = kParams)
