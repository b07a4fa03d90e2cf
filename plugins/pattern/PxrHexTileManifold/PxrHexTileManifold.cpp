// PxrHexTileManifold: cuts the plane of texture coordinates into hexagons one unit wide, each with coordinates of its
// own, the middle of the hexagon at the middle of the texture, and turned at random by sixths where asked.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrHexTileManifold/PxrHexTileManifold.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/places/tiles.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kNumTextures,
  kTextureOrder,
  kGroutWidth,
  kTileBevelWidth,
  kRandomOrientation,
  KINORA_TILE_PLACE_INDICES
};
constexpr Param kParams[] = {
    KINORA_TILE_COUNT,
    KINORA_TILE_GROUT,
    param::flag("randomOrientation", false).help("1: each hexagon is turned by some sixths of a turn."),
    KINORA_TILE_PLACE_PARAMS(KINORA_TILE_INVERT),
    KINORA_TILE_OUTPUTS,
};

constexpr float kRoot3 = 1.7320508f;

struct PxrHexTileManifold {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    using I = Int<W>;
    const Place2D place(*c, KINORA_TILE_PLACE);
    const Value gap = c->param(kGroutWidth), bevel = c->param(kTileBevelWidth);
    const bool turned = fixedInteger(*c, kRandomOrientation) != 0, flip = fixedInteger(*c, kInvertT) != 0;
    const TextureChoice textures(*c, kNumTextures, kTextureOrder);
    TileOutputs out(*c, *args, place.uniform() && allUniform({&gap, &bevel}));
    for (uint32_t i = 0; i < extent(*c, out.one); i += W) {
      const At at{i, false};
      F s, t, r;
      place.at<W>(at, s, t, r);
      // middles stand on two lattices, 1 wide and sqrt(3) high, the second one in the middle of the first
      const F height(kRoot3), half(0.5f), up = t / height;
      const F x0 = floor(s), y0 = floor(up), x1 = floor(s - half), y1 = floor(up - half);
      const F dx0 = s - x0 - half, dy0 = (up - y0 - half) * height;
      const F dx1 = s - x1 - F(1.f), dy1 = (up - y1 - F(1.f)) * height;
      const Mask<W> first = fma(dx0, dx0, dy0 * dy0) <= fma(dx1, dx1, dy1 * dy1);
      F x = select(first, dx0, dx1), y = select(first, dy0, dy1);
      const F column = select(first, x0, x1), row = select(first, y0 * F(2.f), fma(y1, F(2.f), F(1.f)));
      // from the middle towards the nearest edge: 1/2 there
      const F ax = abs(x), reach = max(ax, fma(ax, half, abs(y) * F(kRoot3 / 2)));
      const F g = loadFloat<W>(gap, at), covered = TileWave<W>(g, loadFloat<W>(bevel, at)).average(half - reach, r);
      const I seed = hashWords(toInt(column), toInt(row));
      if (turned) {
        F sine, cosine;
        sincos(floor(toUnitFloat(hashWords(seed, I(0x2545f491u))) * F(6.f)) * F(kPi / 3), sine, cosine);
        const F turnedX = fms(x, cosine, y * sine);
        y = fma(x, sine, y * cosine);
        x = turnedX;
      }
      const F grow = F(1.f) / max(F(1.f) - g, F(1e-3f)), inS = fma(x, grow, half), inT = fma(y, grow, half);
      out.store(i, inS, flip ? F(1.f) - inT : inT, r * grow, textures.of(seed, column + row), covered);
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrHexTileManifold, .help = "Hexagonal tiles with a choice of textures.", .params = kParams)
