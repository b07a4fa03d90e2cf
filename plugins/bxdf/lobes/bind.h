// Helpers for materials that fill a closure of lobes from their parameters. Included per target.
#include <kinora/bxdf_author.h>
#include <kinora/math/microfacet_anisotropy.h>
#include "closure.h"

#if defined(KINORA_LOBES_BIND_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_BIND_H_TARGET
#undef KINORA_LOBES_BIND_H_TARGET
#else
#define KINORA_LOBES_BIND_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

inline bool isZero(const Value& v) {
  if (v.stride) return false;
  for (uint32_t i = 0; i < v.components; ++i)
    if (v.data[i][0] != 0.f) return false;
  return true;
}
inline bool flag(const Context& c, uint32_t index) { return c.param(index).data[0][0] != 0.f; }

template <class Closure>
inline int bindNormal(const Context& c, Closure& k, uint32_t index, int general) {
  const Value v = c.param(index);
  if (!isBumped(v)) return general;
  k.normals[k.normalCount] = v;
  return k.normalCount++;
}
inline void bindAnisotropy(const Context& c, lobes::AnisotropyClosure& a, uint32_t amount, uint32_t direction) {
  a.amount = c.param(amount);
  a.on = !isZero(a.amount);
  if (!a.on) return;
  a.tangent = c.builtin(Builtin::Tangent);
  a.direction = c.param(direction);
  a.directed = !isZero(a.direction);
}
// The table of glass for the relative indices and the roughnesses of a context.
inline const GlassEnergy* glassTable(const Context& c, const lobes::GlassClosure& g) {
  TableBounds index{1e30f, 1}, roughness{1, 0};
  const auto extend = [](TableBounds& b, float x) {
    b.low = x < b.low ? x : b.low;
    b.high = x > b.high ? x : b.high;
  };
  const auto at = [](const Value& v, uint32_t i) { return v.data[0][v.stride ? i : 0]; };
  const auto extendRoughness = [&](float r) { extend(roughness, r > 0 ? (r < 1 ? r : 1) : 0); };
  for (uint32_t i = 0; i < c.count; ++i) {
    const float inside = at(g.ior, i), outside = c.outerIor[i];
    extend(index, inside > outside ? inside / outside : outside / inside);
    extendRoughness(at(g.roughness, i));
    if (const float own = at(g.refractionRoughness, i); own >= 0) extendRoughness(own);
  }
  return &glassEnergyTable(index, roughness);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
