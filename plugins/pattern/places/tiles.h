// Tiles of texture coordinates: which texture a tile shows, how much of a footprint lies on tiles rather than between
// them, and the outputs that manifolds of several textures share. Included per target.
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>
#include <kinora/random.h>

#include "plugins/pattern/places/place2d.h"

#ifndef KINORA_TILES_ONCE
#define KINORA_TILES_ONCE
#define KINORA_TILE_COUNT                                                                         \
  param::integer("numTextures", 1).range(1, 10).help("How many textures PxrMultiTexture shows."), \
      param::integer("textureOrder", 1)                                                           \
          .options("0 one after the other, 1 at random")                                          \
          .help("Which of them a tile or an object shows.")
#define KINORA_TILE_GROUT                                                                              \
  param::number("groutWidth", 0.f).help("Gap between tiles, a fraction of a tile: 1 leaves nothing."), \
      param::number("tileBevelWidth", 0.f).help("Width over which resultMask rises from the gap to the tile.")
#define KINORA_TILE_SCALE param::number("globalScale", 1.f).range(0, 8).help("Factor of scaleS and scaleT.")
// The parameters by which a texture lies on the plane, and what they are called. `invertT` declares the last but the
// primitive variables.
#define KINORA_TILE_PLACE_INDICES \
  kAngle, kGlobalScale, kScaleS, kScaleT, kOffsetS, kOffsetT, kInvertT, kPrimvarS, kPrimvarT
#define KINORA_TILE_PLACE \
  { kAngle, kScaleS, kScaleT, kOffsetS, kOffsetT, kNoPlaceParam, kNoPlaceParam, kPrimvarS, kPrimvarT, kGlobalScale }
#define KINORA_TILE_PLACE_PARAMS(invertT) \
  KINORA_PLACE_ANGLE, KINORA_TILE_SCALE, KINORA_PLACE_PARAMS, invertT, KINORA_PLACE_PRIMVARS
#define KINORA_TILE_INVERT param::flag("invertT", true).help("1: t becomes 1 - t within each tile.")
#define KINORA_TILE_OUTPUTS                                                              \
  param::output(Type::Struct, "result"), param::output(Type::Float, "resultS"),          \
      param::output(Type::Float, "resultT"), param::output(Type::Struct, "resultMulti"), \
      param::output(Type::Color, "resultMask")
#endif

#if defined(KINORA_TILES_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_TILES_H_TARGET
#undef KINORA_TILES_H_TARGET
#else
#define KINORA_TILES_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// A manifold of several textures has the number of the texture in the third component, plus half of a random number
// of the tile: what PxrMultiTexture varies colours by.
struct TextureChoice {
  int textures;
  bool random;
  TextureChoice(const Context& c, uint32_t numTextures, uint32_t order)
      : textures(fixedInteger(c, numTextures)), random(fixedInteger(c, order) != 0) {
    textures = textures < 1 ? 1 : textures > 10 ? 10 : textures;
  }
  // next: counts up from one tile to the next.
  template <int W>
  KN_INLINE Float<W> of(Int<W> seed, Float<W> next) const {
    using F = Float<W>;
    const F n(static_cast<float>(textures)), u = toUnitFloat(hashWords(seed, Int<W>(0x68e31da4u)));
    const F index = random ? min(floor(toUnitFloat(hashWords(seed, Int<W>(0x1b56c4e9u))) * n), n - F(1.f))
                           : max(fnma(floor(next / n), n, next), F(0.f));
    return fma(u, F(0.5f), index);
  }
};

// The share of a tile in the window x - r to x + r along one axis, where tiles repeat every unit with their gap of
// width g about whole numbers, and count from 0 to 1 over a bevel b: the integral of a trapezoid wave, in closed form.
template <int W>
struct TileWave {
  Float<W> half, bevel;  // half of the gap
  KN_INLINE TileWave(Float<W> gap, Float<W> b) : half(clamp(gap, Float<W>(0.f), Float<W>(1.f)) * Float<W>(0.5f)) {
    bevel = clamp(b, Float<W>(1e-6f), max(Float<W>(0.5f) - half, Float<W>(1e-6f)));
  }
  // From a whole number to y <= 1/2.
  KN_INLINE Float<W> rising(Float<W> y) const {
    using F = Float<W>;
    const F e = max(y - half, F(0.f));
    return select(e < bevel, e * e * F(0.5f) / bevel, fnma(bevel, F(0.5f), e));
  }
  KN_INLINE Float<W> integral(Float<W> x) const {
    using F = Float<W>;
    const F n = floor(x), y = x - n, whole = rising(F(0.5f)) * F(2.f);
    const F low = rising(min(y, F(1.f) - y));
    return fma(n, whole, select(y <= F(0.5f), low, whole - low));
  }
  KN_INLINE Float<W> average(Float<W> x, Float<W> r) const {
    using F = Float<W>;
    x = x - floor(x);
    // narrower windows would be lost in rounding
    r = max(abs(r), F(2e-4f));
    const F mean = clamp((integral(x + r) - integral(x - r)) / (r + r), F(0.f), F(1.f));
    return select(min(x, F(1.f) - x) - r >= half + bevel, F(1.f), mean);
  }
};

// What all of them hand on: place and footprint in the texture, the choice of a texture and the mask.
struct TileOutputs {
  Manifold &single, &multi;
  float *st[3], *radius[3], *choice[3], *mask[3];
  bool one;
  TileOutputs(const Context& c, const PatternArgs& a, bool uniform)
      : single(a.manifolds[0]), multi(a.manifolds[3]), one(uniform) {
    single.dimensions = multi.dimensions = 2;
    makeOutput(c, single.q, 2, one, st);
    makeOutput(c, single.radius, 1, one, radius);
    Value z;
    makeOutput(c, z, 1, one, choice);
    multi.q = single.q;
    multi.q.components = 3;
    multi.q.data[2] = z.data[0];
    multi.radius = single.radius;
    Value& m = a.outputs[4];
    makeOutput(c, m, 1, one, mask);
    m.components = 3;
    m.data[1] = m.data[2] = m.data[0];
    a.outputs[0] = single.q;
    a.outputs[3] = multi.q;
    shareComponent(single.q, 0, a.outputs[1]);
    shareComponent(single.q, 1, a.outputs[2]);
  }
  // Half diameters of footprints that are ellipses: of both manifolds. Null: all are circles.
  float* const* makeAxes(const Context& c, bool has) {
    for (uint32_t k = 0; has && k < 2; ++k) {
      float* data[3];
      makeOutput(c, single.axis[k], 2, false, data);
      axes[2 * k] = data[0];
      axes[2 * k + 1] = data[1];
      multi.axis[k] = single.axis[k];
    }
    return has ? axes : nullptr;
  }
  float* axes[4];
  template <int W>
  KN_INLINE void store(uint32_t i, Float<W> s, Float<W> t, Float<W> r, Float<W> texture, Float<W> covered) {
    s.store(st[0] + i);
    t.store(st[1] + i);
    r.store(radius[0] + i);
    texture.store(choice[0] + i);
    covered.store(mask[0] + i);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
