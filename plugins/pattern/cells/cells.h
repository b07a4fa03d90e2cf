// Points scattered in space, one in each unit cell (S. Worley, "A Cellular Texture Basis Function", SIGGRAPH 1996):
// the 27 cells, or the 9 of a plane, about a position. Included per target.
#include <kinora/pattern_author.h>
#include <kinora/math/noise.h>

#if defined(KINORA_CELLS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_CELLS_H_TARGET
#undef KINORA_CELLS_H_TARGET
#else
#define KINORA_CELLS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Calls visit(way from p to the cell's point, random bits of the cell) for each cell. jitter 0: points in the middle
// of their cells, 1: anywhere in them.
template <int W, class Visit>
KN_INLINE void forCellPoints(Vec3<W> p, Float<W> jitter, bool solid, uint32_t seed, Visit&& visit) {
  using F = Float<W>;
  using I = Int<W>;
  const F half(0.5f), fx = floor(p.x), fy = floor(p.y), fz = floor(p.z);
  const I ix = toInt(fx), iy = toInt(fy), iz = toInt(fz);
  const int depth = solid ? 1 : 0;
  for (int z = -depth; z <= depth; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        const I h = hashLattice(ix + I(x), iy + I(y), iz + I(z), seed);
        const I g = h * I(0x2c1b3c6du);
        const Vec3<W> d(fma(toUnitFloat(h) - half, jitter, F(float(x) + 0.5f)) - (p.x - fx),
                        fma(toUnitFloat(h.template shl<12>()) - half, jitter, F(float(y) + 0.5f)) - (p.y - fy),
                        solid ? fma(toUnitFloat(g) - half, jitter, F(float(z) + 0.5f)) - (p.z - fz) : F(0.f));
        visit(d, foldHigh(g) * I(0x297a2d39u));
      }
}

// Calls visit as forCellPoints does, for the 64 cells that come nearer than 1.5 to p, whatever their points are.
template <int W, class Visit>
KN_INLINE void forNearCellPoints(Vec3<W> p, Float<W> jitter, uint32_t seed, Visit&& visit) {
  using F = Float<W>;
  using I = Int<W>;
  const F half(0.5f), fx = floor(p.x), fy = floor(p.y), fz = floor(p.z);
  // p is in the second or in the third of four cells, whichever has more of them on its nearer side
  const F sx = p.x - fx, sy = p.y - fy, sz = p.z - fz;
  const F bx = select(sx < half, F(-2.f), F(-1.f)), by = select(sy < half, F(-2.f), F(-1.f)),
          bz = select(sz < half, F(-2.f), F(-1.f));
  const I ix = toInt(fx + bx), iy = toInt(fy + by), iz = toInt(fz + bz);
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x) {
        const I h = hashLattice(ix + I(x), iy + I(y), iz + I(z), seed);
        const I g = h * I(0x2c1b3c6du);
        const Vec3<W> d(fma(toUnitFloat(h) - half, jitter, bx + F(float(x) + 0.5f)) - sx,
                        fma(toUnitFloat(h.template shl<12>()) - half, jitter, by + F(float(y) + 0.5f)) - sy,
                        fma(toUnitFloat(g) - half, jitter, bz + F(float(z) + 0.5f)) - sz);
        visit(d, foldHigh(g) * I(0x297a2d39u));
      }
}

// A position of its own or a connected one, of nodes that fill space.
inline Manifold spaceManifold(const Context& c, uint32_t index) {
  if (const Manifold* connected = c.fn->manifold(&c, index)) return *connected;
  Manifold m;
  m.dimensions = 3;
  m.q = c.builtin(Builtin::Po);
  m.radius = c.builtin(Builtin::PoRadius);
  return m;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
