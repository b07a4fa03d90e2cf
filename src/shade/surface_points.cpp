// Kernels of surface_points.h. Each takes W points at a time: what is stored around them is loaded lane by lane, the
// rest is computed in lanes.
#define KINORA_KERNEL_FILE "shade/surface_points.cpp"
#include "shade/surface_points.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/group.h"
#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include <kinora/simd/wide.h>

#include "shade/surface_corners.h"

KINORA_KERNELS_BEGIN
using namespace shade;

// Brings one lane of a direction into another space.
template <int W>
HWY_ATTR inline void toObject(const scene::Matrix& m, uint32_t lane, Float<W> direction[3]) {
  alignas(64) float x[3][W];
  for (int k = 0; k < 3; ++k) direction[k].store(x[k]);
  Imath::V3d d;
  m.multDirMatrix(Imath::V3d(x[0][lane], x[1][lane], x[2][lane]), d);
  for (int k = 0; k < 3; ++k) {
    x[k][lane] = float(d[k]);
    direction[k] = Float<W>::load(x[k]);
  }
}

template <int W>
struct Surface {
  using F = Float<W>;
  using V = Vec3<W>;

  static void positions(const SurfaceArgs& a, float* const P[3]) {
    for (uint32_t i = 0; i < a.n; i += W) {
      // a point is the triangle's own
      const CornerLanes<W> corners = cornerPositions<W>(a, i, a.isByParameter);
      Placing<W>(a, i).point(interpolate<W>(corners, Inside<W>(a, i))).store(P, i);
      if (!a.strand) continue;
      for (uint32_t l = i; l < i + W; ++l) {
        // a strand's point goes with its control points
        const Spot s = a.spot(l);
        if (!s.strand) continue;
        const geometry::Mesh::KeyPair keys = s.mesh->keysAt(a.time[l]);
        float p[3], q[3];
        for (int k = 0; k < 3; ++k) {
          p[k] = s.strand->rest[k] - float(s.mesh->origin[size_t(k)]);
          for (uint32_t v = 0; v < s.strand->controls; ++v) {
            const Imath::V4f* spine = s.mesh->spine.data() + s.strand->vertex[v];
            p[k] += s.strand->weight[v] * (keys.mix(spine[keys.first][k], spine[keys.second][k]) - spine[0][k]);
          }
        }
        const bool isBaked = a.world->world->instance(a.at.instance[l]).baked;
        if (isBaked)
          std::memcpy(q, p, sizeof q);
        else
          a.toRender(l).point(p, q);
        for (int k = 0; k < 3; ++k) P[k][l] = q[k];
      }
    }
  }

  static void facets(const SurfaceArgs& a, float* const ng[3]) {
    for (uint32_t i = 0; i < a.n; i += W) {
      const CornerLanes<W> corners = cornerPositions<W>(a, i, a.isByParameter);
      const V first = corners.at[0].get();
      V n = area(corners.at[1].get() - first, corners.at[2].get() - first);
      if (corners.anyQuad) {
        // those of the surface between four corners; a corner in which two meet has that of the rest
        V x, y;
        quadEdges(corners, Inside<W>(a, i), x, y);
        const V own = area(x, y);
        const F l2 = own.x * own.x + own.y * own.y + own.z * own.z;
        const V mean = area(corners.at[2].get() - first, corners.at[3].get() - corners.at[1].get());
        n = select(corners.onQuad(), select(l2 > F(0.f), own, mean), n);
      }
      n.store(ng, i);
    }
  }

  static KN_INLINE void quadEdges(const CornerLanes<W>& corners, const Inside<W>& in, V& x, V& y) {
    const V p0 = corners.at[0].get(), p1 = corners.at[1].get(), p2 = corners.at[2].get(), p3 = corners.at[3].get();
    x = (p1 - p0) * (F(1.f) - in.v) + (p2 - p3) * in.v;
    y = (p3 - p0) * (F(1.f) - in.u) + (p2 - p1) * in.u;
  }

  static void normals(const SurfaceArgs& a, const float* const raw[3], float* const ng[3], float* const smooth[3]) {
    for (uint32_t i = 0; i < a.n; i += W) {
      const Placing<W> placing(a, i);
      typename Placing<W>::Normals cofactors;
      if (placing.any) cofactors = placing.cofactors();
      const auto place = [&](V n) {
        if (!placing.any) return n;
        n = placing.normal(cofactors, n);
        return select(cofactors.mirrors, -n, n);
      };
      if (ng) place(V::load(raw, i)).store(ng, i);
      if (!smooth) continue;
      const CornerLanes<W> corners = cornerNormals<W>(a, i, true);
      const V n = place(interpolate<W>(corners, Inside<W>(a, i)));
      const F l2 = n.x * n.x + n.y * n.y + n.z * n.z;
      // "N" of the mesh is oriented outward already; zero: the facet's, as in a context without any normals
      (n * select(l2 > F(0.f), F(1.f) / sqrt(l2), F(0.f))).store(smooth, i);
    }
  }

  static void edges(const SurfaceArgs& a, float* const e1[3], float* const e2[3]) {
    for (uint32_t i = 0; i < a.n; i += W) {
      const CornerLanes<W> corners = cornerPositions<W>(a, i, true);
      const V p0 = corners.at[0].get(), p1 = corners.at[1].get(), p2 = corners.at[2].get();
      V x = p1 - p0, y = p2 - p0;
      if (corners.anyQuad) {
        const V p3 = corners.at[3].get();
        const Inside<W> in(a, i);
        const Mask<W> quad = corners.onQuad();
        y = select(quad, (p3 - p0) * (F(1.f) - in.u) + (p2 - p1) * in.u, y);
        x = select(quad, x * (F(1.f) - in.v) + (p2 - p3) * in.v, x);
      }
      if (a.facet) {
        // along one unit of the patch's parameters
        alignas(64) float steps[2][W];
        for (int l = 0; l < W; ++l)
          for (int k = 0; k < 2; ++k) {
            const trace::UserFacet* f = a.facet[i + uint32_t(l)];
            steps[k][l] = f ? f->steps[k] : 1.f;
          }
        x = x * F::load(steps[0]);
        y = y * F::load(steps[1]);
      }
      const Placing<W> placing(a, i);
      placing.direction(x).store(e1, i);
      placing.direction(y).store(e2, i);
      if (!a.strand) continue;
      for (uint32_t l = i; l < i + W; ++l)
        if (const StrandPlace* s = a.strand[l])
          for (int k = 0; k < 3; ++k) {
            e1[k][l] = s->du[k];
            e2[k][l] = s->dv[k];
          }
    }
  }

  static Across implied(const SurfaceArgs& a, const Spot& s, uint32_t point, Implied what, uint32_t j, float c[4]) {
    if (what == Implied::Color || what == Implied::Opacity) {
      const uint32_t placement = a.world->world->infoOf(a.at.instance[point], a.at.geometry[point]);
      const Tint& tint = a.world->tints[a.world->placements[placement].tint];
      return given((what == Implied::Color ? tint.color : tint.opacity)[j], 0, 0, c);
    }
    if (what == Implied::None) return given(0, 0, 0, c);
    // texture coordinates: primvar st, else s and t, else the patch parameters; each fills what follows it
    const uint32_t component = what == Implied::St ? j : what == Implied::T;
    if (what == Implied::St && j > 1) return given(0, 0, 0, c);
    if (s.info->st) return cornersOf(*s.info->st, s, component, c);
    if (s.info->s && s.info->t) return cornersOf(component ? *s.info->t : *s.info->s, s, 0, c);
    return cornersOfUV(s, component, c);
  }

  static void slopes(const SurfaceArgs& a, const SlopeSource& source, uint32_t components, const Slopes& out) {
    using What = SlopeSource::What;
    for (uint32_t i = 0; i < a.n; i += W) {
      alignas(64) float corner[3][4][W];
      alignas(64) int32_t across[3][W];
      for (int l = 0; l < W; ++l) {
        const uint32_t point = i + uint32_t(l);
        const Spot s = a.spot(point);
        const geometry::Primvar* p = source.what == What::Primvar ? source.primvar[point] : nullptr;
        for (uint32_t j = 0; j < components; ++j) {
          float c[4];
          Across how;
          if (source.what == What::PatchUV)
            how = cornersOfUV(s, j, c);
          else if (source.what == What::St)
            how = implied(a, s, point, Implied::St, j, c);
          else if (!p)
            how = implied(a, s, point, source.implied, j, c);
          else if (p->width == 1)
            how = cornersOf(*p, s, 0, c);
          else if (source.first + j < uint32_t(p->width))
            how = cornersOf(*p, s, source.first + j, c);
          else
            how = given(0, 0, 0, c);
          across[j][l] = int32_t(how);
          for (int k = 0; k < 4; ++k) corner[j][k][l] = c[k];
        }
      }
      const Inside<W> in(a, i, false);
      for (uint32_t j = 0; j < components; ++j) {
        const F c[4] = {F::load(corner[j][0]), F::load(corner[j][1]), F::load(corner[j][2]), F::load(corner[j][3])};
        const Int<W> how = Int<W>::load(across[j]);
        const Mask<W> quad = how == Int<W>(int32_t(Across::Quad)), is = how == Int<W>(int32_t(Across::Given));
        F value = in.overTriangle(c[0], c[1], c[2]), d1 = c[1] - c[0], d2 = c[2] - c[0];
        if (quad.any()) {
          value = select(quad, in.overQuad(c), value);
          d1 = select(quad, in.alongU(c), d1);
          d2 = select(quad, in.alongV(c), d2);
        }
        select(is, c[0], value).store(out.value[j] + i);
        select(is, c[1], d1).store(out.d1[j] + i);
        select(is, c[2], d2).store(out.d2[j] + i);
      }
    }
  }

  static void rest(const SurfaceArgs& a, const float* const P[3], const float* const e1[3], const float* const e2[3],
                   const float* const shift[2], float* const Po[3], float* scale) {
    const trace::World& w = *a.world->world;
    for (uint32_t i = 0; i < a.n; i += W) {
      // of the triangle that was hit, undeformed; slopes of the quad where it is half of one
      const CornerLanes<W> corners = cornerPositions<W>(a, i, true, true);
      const CornerLanes<W> triangle = corners.anyQuad ? cornerPositions<W>(a, i, false, true) : corners;
      Lanes3<W> origin;
      for (int l = 0; l < W; ++l) {
        const Imath::V3d& o = w.mesh(a.at.geometry[i + uint32_t(l)]).origin;
        const float f[3] = {float(o.x), float(o.y), float(o.z)};
        origin.set(l, f);
      }
      const Inside<W> in(a, i, false);
      F o1[3], o2[3];
      for (int k = 0; k < 3; ++k) {
        const F c[4] = {F::load(corners.at[0].x[k]), F::load(corners.at[1].x[k]), F::load(corners.at[2].x[k]),
                        F::load(corners.at[3].x[k])};
        o1[k] = c[1] - c[0];
        o2[k] = c[2] - c[0];
        if (!corners.anyQuad) continue;
        o1[k] = select(corners.onQuad(), in.alongU(c), o1[k]);
        o2[k] = select(corners.onQuad(), in.alongV(c), o2[k]);
      }
      V place = interpolate<W>(triangle, in) + origin.get();
      if (shift)
        place = fma(V(o1[0], o1[1], o1[2]), F::load(shift[0] + i),
                    fma(V(o2[0], o2[1], o2[2]), F::load(shift[1] + i), place));
      place.store(Po, i);
      for (uint32_t l = 0; l < uint32_t(W); ++l) {
        const BakedSpace* baked = a.world->geometries[a.at.geometry[i + l]].baked.get();
        if (!baked || (a.strand && a.strand[i + l])) continue;
        for (F* edge : {o1, o2}) toObject<W>(baked->toObject, l, edge);
      }
      const V x = area(V(o1[0], o1[1], o1[2]), V(o2[0], o2[1], o2[2])), y = area(V::load(e1, i), V::load(e2, i));
      const F object = x.x * x.x + x.y * x.y + x.z * x.z, render = y.x * y.x + y.y * y.y + y.z * y.z;
      select(render > F(0.f), sqrt(sqrt(object / render)), F(1.f)).store(scale + i);
      for (uint32_t l = i; l < i + W; ++l) {
        const trace::Instance& instance = w.instance(a.at.instance[l]);
        const StrandPlace* strand = a.strand ? a.strand[l] : nullptr;
        const BakedSpace* baked = a.world->geometries[a.at.geometry[l]].baked.get();
        if (!instance.baked && !instance.isUnit && !strand && !baked) continue;
        float p[3];
        if (instance.isUnit) {
          const float unit = (*a.world->objectSpaces)[instance.user].unit;
          for (int k = 0; k < 3; ++k) p[k] = Po[k][l] * unit;
          scale[l] *= unit;
        } else if (instance.baked) {
          const ObjectSpace& space = (*a.world->objectSpaces)[instance.user];
          const bool isMoved = !w.mesh(a.at.geometry[l]).rest.empty();
          float q[3];
          for (int k = 0; k < 3; ++k) q[k] = isMoved ? Po[k][l] : P[k][l];
          space.fromRender.point(q, p);
          scale[l] = space.scale;
        } else {
          for (int k = 0; k < 3; ++k) p[k] = strand ? strand->rest[k] : Po[k][l];
          if (strand) {
            const float det = a.toRender(l).determinant();
            scale[l] = det != 0 ? 1.f / std::cbrt(std::fabs(det)) : 1.f;
          }
          if (baked) {
            const Imath::V3d q = Imath::V3d(p[0], p[1], p[2]) * baked->toObject;
            for (int k = 0; k < 3; ++k) p[k] = float(q[k]);
            // strands keep their widths there, so that it is one in all directions
            if (strand) scale[l] *= float(std::cbrt(std::fabs(baked->toObject.determinant())));
          }
        }
        for (int k = 0; k < 3; ++k) Po[k][l] = p[k];
      }
    }
  }

  // Without fused operations: slopes along parallel edges cancel exactly.
  static KN_INLINE V area(V a, V b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

  static void derivatives(uint32_t n, const float* const e1[3], const float* const e2[3], const Slopes& uv,
                          float* const du[3], float* const dv[3]) {
    for (uint32_t i = 0; i < n; i += W) {
      const V x = V::load(e1, i), y = V::load(e2, i);
      const F a = F::load(uv.d1[0] + i), b = F::load(uv.d1[1] + i), c = F::load(uv.d2[0] + i),
              d = F::load(uv.d2[1] + i);
      const F det = a * d - b * c;
      const Mask<W> good = abs(det) > F(1e-20f);
      const F inverse = F(1.f) / select(good, det, F(1.f));
      if (du) select(good, (x * d - y * b) * inverse, x).store(du, i);
      if (dv) select(good, (y * a - x * c) * inverse, y).store(dv, i);
    }
  }

  static void curvatures(const SurfaceArgs& a, float* out) {
    const auto product = [](V p, V q) { return p.x * q.x + p.y * q.y + p.z * q.z; };
    for (uint32_t i = 0; i < a.n; i += W) {
      const CornerLanes<W> corners = cornerPositions<W>(a, i, false);
      const CornerLanes<W> normals = cornerNormals<W>(a, i, false);
      const Placing<W> placing(a, i);
      const V first = corners.at[0].get();
      const V e1 = placing.direction(corners.at[1].get() - first),
              e2 = placing.direction(corners.at[2].get() - first);
      V n[3] = {normals.at[0].get(), normals.at[1].get(), normals.at[2].get()};
      typename Placing<W>::Normals cofactors;
      if (placing.any) cofactors = placing.cofactors();
      for (V& x : n) {
        if (placing.any) {
          x = placing.normal(cofactors, x);
          x = select(cofactors.mirrors, -x, x);
        }
        const F l2 = product(x, x);
        x = x * select(l2 > F(0.f), F(1.f) / sqrt(l2), F(0.f));
      }
      const V whole = area(e1, e2);
      const F size = sqrt(product(whole, whole));
      const Mask<W> some = size > F(0.f);
      const F inverse = select(some, F(1.f) / size, F(0.f));
      const V unit = whole * inverse;
      const F divergence = (product(n[1] - n[0], area(e2, unit)) + product(n[2] - n[0], area(unit, e1))) * inverse;
      (divergence * F(0.5f)).store(out + i);
    }
  }

  static void facetSlopes(const SurfaceArgs& a, float* const e1[3], float* const e2[3], float* const dn1[3],
                          float* const dn2[3]) {
    const auto product = [](V p, V q) { return p.x * q.x + p.y * q.y + p.z * q.z; };
    for (uint32_t i = 0; i < a.n; i += W) {
      const CornerLanes<W> facet = cornerPositions<W>(a, i, false), normals = cornerNormals<W>(a, i, true);
      const V first = facet.at[0].get();
      const V f1 = facet.at[1].get() - first, f2 = facet.at[2].get() - first;
      const V n0 = normals.at[0].get(), n1 = normals.at[1].get(), n2 = normals.at[2].get();
      const Inside<W> in(a, i);
      V n = n0 * in.b0 + n1 * in.b1 + n2 * in.b2, d1 = n1 - n0, d2 = n2 - n0;
      if (normals.anyQuad) {
        // The place in a quad is that of the facet's point seen along the quad's mean normal (quad_place.cpp): a step
        // on the facet is one of u and v, but for what lies along that normal.
        const CornerLanes<W> corners = cornerPositions<W>(a, i, true);
        const V q0 = corners.at[0].get(), e = corners.at[1].get() - q0, d = corners.at[2].get() - q0,
                f = corners.at[3].get() - q0, n3 = normals.at[3].get();
        const V mean = area(e, d) + area(d, f), g = d - e - f;
        const V alongU = e + g * in.v, alongV = f + g * in.u;
        const F size = product(mean, area(alongU, alongV));
        const F inverse = select(size != F(0.f), F(1.f) / size, F(0.f));
        const V nu = (n1 - n0) * (F(1.f) - in.v) + (n2 - n3) * in.v,
                nv = (n3 - n0) * (F(1.f) - in.u) + (n2 - n1) * in.u;
        const auto along = [&](V step) {
          return nu * (product(mean, area(step, alongV)) * inverse) +
                 nv * (product(mean, area(alongU, step)) * inverse);
        };
        const Mask<W> quad = normals.onQuad();
        n = select(quad,
                   (n0 * (F(1.f) - in.u) + n1 * in.u) * (F(1.f) - in.v) + (n3 * (F(1.f) - in.u) + n2 * in.u) * in.v,
                   n);
        d1 = select(quad, along(f1), d1);
        d2 = select(quad, along(f2), d2);
      }
      const Placing<W> placing(a, i);
      if (placing.any) {
        const auto cofactors = placing.cofactors();
        const auto place = [&](V x) {
          x = placing.normal(cofactors, x);
          return select(cofactors.mirrors, -x, x);
        };
        n = place(n);
        d1 = place(d1);
        d2 = place(d2);
      }
      // of n / |n|
      const F l2 = product(n, n), inverse = select(l2 > F(0.f), F(1.f) / sqrt(l2), F(0.f));
      n = n * inverse;
      const auto ofUnit = [&](V x) { return (x - n * product(n, x)) * inverse; };
      placing.direction(f1).store(e1, i);
      placing.direction(f2).store(e2, i);
      ofUnit(d1).store(dn1, i);
      ofUnit(d2).store(dn2, i);
    }
  }

  static void footprints(uint32_t n, const float* radius, const float* const e1[3], const float* const e2[3],
                         const Slopes& st, float* out) {
    for (uint32_t i = 0; i < n; i += W) {
      const V c = area(V::load(e1, i), V::load(e2, i));
      const F size = sqrt(c.x * c.x + c.y * c.y + c.z * c.z);
      const F inUnits =
          abs(F::load(st.d1[0] + i) * F::load(st.d2[1] + i) - F::load(st.d1[1] + i) * F::load(st.d2[0] + i));
      const F scale = select(size > F(0.f), sqrt(inUnits / size), F(0.f));
      (F::load(radius + i) * scale).store(out + i);
    }
  }

  static void ellipses(const EllipseArgs& a, float* const axes[4]) {
    const auto product = [](V p, V q) { return p.x * q.x + p.y * q.y + p.z * q.z; };
    for (uint32_t i = 0; i < a.n; i += W) {
      const V x = V::load(a.e1, i), y = V::load(a.e2, i), n = V::load(a.Ng, i), wo = V::load(a.wo, i);
      const F radius = F::load(a.radius + i), cosine = abs(product(wo, n));
      const V flat = wo - n * product(wo, n);
      // seen from above any direction will do
      const F l2 = product(flat, flat);
      const Mask<W> isAbove = !(l2 > F(1e-6f));
      const V other = x - n * product(x, n), far = select(isAbove, other, flat);
      const V along = far * (F(1.f) / sqrt(max(product(far, far), F(1e-38f))));
      const V across(n.y * along.z - n.z * along.y, n.z * along.x - n.x * along.z, n.x * along.y - n.y * along.x);
      const F order = toFloat(Int<W>::load(a.sampleIndex + i));
      const F stretch = min(F(1.f) / max(cosine, F(1e-6f)), F(kMostStretch)) / fma(order, F(0.25f), F(1.f));
      const F length = radius * max(stretch, F(1.f));
      // in units of the edges, by least squares
      const F g11 = product(x, x), g12 = product(x, y), g22 = product(y, y), det = g11 * g22 - g12 * g12;
      const Mask<W> good =
          (F::load(a.spread + i) <= F(kNarrowSpread)) & (radius > F(0.f)) & (det > F(1e-12f) * g11 * g22);
      const F inverse = F(1.f) / select(good, det, F(1.f));
      const auto store = [&](V step, F size, float* s, float* t) {
        const F r1 = product(x, step), r2 = product(y, step), k = size * inverse;
        const F p = (g22 * r1 - g12 * r2) * k, q = (g11 * r2 - g12 * r1) * k;
        zeroUnless(good, p * F::load(a.st.d1[0] + i) + q * F::load(a.st.d2[0] + i)).store(s + i);
        zeroUnless(good, p * F::load(a.st.d1[1] + i) + q * F::load(a.st.d2[1] + i)).store(t + i);
      };
      store(across, radius, axes[0], axes[1]);
      store(along, length, axes[2], axes[3]);
    }
  }

  static void across(uint32_t n, const float* const N[3], float* const d[3]) {
    for (uint32_t i = 0; i < n; i += W) {
      const V normal = V::load(N, i);
      V x = V::load(d, i);
      x = x - normal * (x.x * normal.x + x.y * normal.y + x.z * normal.z);
      F l2 = x.x * x.x + x.y * x.y + x.z * x.z;
      const Mask<W> lost = !(l2 > F(0.f));
      if (lost.any()) {
        const Mask<W> first = abs(normal.x) < F(0.9f);
        const V axis = select(first, V(F(1.f), F(0.f), F(0.f)), V(F(0.f), F(1.f), F(0.f)));
        x = select(lost, axis - normal * select(first, normal.x, normal.y), x);
        l2 = x.x * x.x + x.y * x.y + x.z * x.z;
      }
      (x * (F(1.f) / sqrt(l2))).store(d, i);
    }
  }

  static void alongEdges(uint32_t n, const float* const e1[3], const float* const e2[3], const float* const step[3],
                         float* a, float* b) {
    for (uint32_t i = 0; i < n; i += W) {
      const V x = V::load(e1, i), y = V::load(e2, i), s = V::load(step, i);
      const auto product = [](V p, V q) { return p.x * q.x + p.y * q.y + p.z * q.z; };
      const F g11 = product(x, x), g12 = product(x, y), g22 = product(y, y), r1 = product(x, s), r2 = product(y, s);
      const F det = g11 * g22 - g12 * g12;
      const Mask<W> good = det > F(1e-12f) * g11 * g22;
      const F safe = select(good, det, F(1.f));
      zeroUnless(good, (g22 * r1 - g12 * r2) / safe).store(a + i);
      zeroUnless(good, (g11 * r2 - g12 * r1) / safe).store(b + i);
    }
  }

  static void terminatorOffsets(const TerminatorArgs& args);
};

// Cosines of the largest angle between facet and corner normals: trusted in full up to 15 degrees (a sphere of 24
// facets around, a cylinder of 12), not at all from 30 on (the edges of a box: 45; its corners: 55).
constexpr float kTrustedLean = 0.9659258f, kFarLean = 0.8660254f;
// Offsets in heights of the triangle. With normals that lean by 15 degrees it is .19 halfway along the longest side of
// half a square; more comes of long thin triangles whose normals lean along them.
constexpr float kSmallOffset = 0.25f, kLargeOffset = 0.5f;

// 1 up to `full`, 0 from `none` on.
template <int W>
KN_INLINE Float<W> fade(Float<W> x, float full, float none) {
  return clamp((Float<W>(none) - x) / Float<W>(none - full), Float<W>(0.f), Float<W>(1.f));
}

template <int W>
void Surface<W>::terminatorOffsets(const TerminatorArgs& args) {
  const SurfaceArgs& a = args.at;
  const auto product = [](V p, V q) { return p.x * q.x + p.y * q.y + p.z * q.z; };
  for (uint32_t i = 0; i < a.n; i += W) {
    const V zero(0.f);
    alignas(64) uint32_t flags[W];
    for (int l = 0; l < W; ++l)
      flags[l] = a.world->geometries[a.at.geometry[i + uint32_t(l)]].flags & kMovesShadowOrigins;
    Mask<W> on = Int<W>::load(flags) != Int<W>(0);
    if (on.none()) {
      zero.store(args.terminatorOffset, i);
      zero.store(args.facet, i);
      continue;
    }
    // corners seen from the first, normals on the side that the ray came from; both in render space, where angles
    // count
    const CornerLanes<W> corners = cornerPositions<W>(a, i, false);
    const CornerLanes<W> normals = cornerNormals<W>(a, i, false);
    const Placing<W> placing(a, i);
    const V first = corners.at[0].get();
    const V corner[3] = {zero, placing.direction(corners.at[1].get() - first),
                         placing.direction(corners.at[2].get() - first)};
    V normal[3] = {normals.at[0].get(), normals.at[1].get(), normals.at[2].get()};
    // normals of the mesh point outward
    F turn = select(Int<W>::load(args.entering + i) != Int<W>(0), F(1.f), F(-1.f));
    if (placing.any) {
      const auto cofactors = placing.cofactors();
      turn = select(cofactors.mirrors, -turn, turn);
      for (V& n : normal) n = placing.normal(cofactors, n);
    }
    const V facet = V::load(args.Ng, i);
    const Inside<W> in(a, i);
    const F b[3] = {in.b0, in.b1, in.b2};
    F least(1.f);
    V p = zero;
    for (int k = 0; k < 3; ++k) {
      const F l2 = product(normal[k], normal[k]);
      normal[k] = normal[k] * select(l2 > F(0.f), turn / sqrt(l2), F(0.f));
      p = p + corner[k] * b[k];
      least = min(least, product(normal[k], facet));
    }
    on &= least > F(kFarLean);
    V offset = zero;
    for (int k = 0; k < 3; ++k) {
      const F below = b[k] * product(corner[k] - p, normal[k]);
      offset = offset + zeroUnless(below > F(0.f), normal[k] * below);
    }
    const F l2 = product(offset, offset);
    // height over the longest side
    const V e3 = corner[2] - corner[1];
    const F s1 = product(corner[1], corner[1]), s2 = product(corner[2], corner[2]);
    const F longest2 = max(s1, max(s2, product(e3, e3)));
    const F along = product(corner[1], corner[2]), twiceArea2 = s1 * s2 - along * along;
    on &= (l2 > F(0.f)) & (twiceArea2 > F(0.f));
    const F heights = sqrt(l2 * longest2 / select(on, twiceArea2, F(1.f)));
    const F part = fade<W>(-least, -kTrustedLean, -kFarLean) * fade<W>(heights, kSmallOffset, kLargeOffset);
    on &= part > F(0.f);
    // What lies on which side follows from the smooth surface too: a facet that is turned away from a light which its
    // normals look at is lit. Media need the true side: what encloses one never comes here.
    const V ng = facet + (V::load(args.N, i) - facet) * part;
    const F inverse = F(1.f) / sqrt(product(ng, ng));  // half a sphere apart at most
    select(on, ng * inverse, facet).store(args.Ng, i);
    zeroUnless(on, facet).store(args.facet, i);
    zeroUnless(on, offset * part).store(args.terminatorOffset, i);
  }
}

template <int W>
constexpr SurfaceKernels kSurface{&Surface<W>::positions,   &Surface<W>::facets,           &Surface<W>::normals,
                                  &Surface<W>::edges,       &Surface<W>::slopes,           &Surface<W>::rest,
                                  &Surface<W>::curvatures,  &Surface<W>::derivatives,      &Surface<W>::footprints,
                                  &Surface<W>::ellipses,    &Surface<W>::across,           &Surface<W>::alongEdges,
                                  &Surface<W>::facetSlopes, &Surface<W>::terminatorOffsets};
#define KN_X(W) \
  [[maybe_unused]] const SurfaceKernels& surface##W() { return kSurface<W>; }
KN_EACH_WIDTH(KN_X)
#undef KN_X
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::shade {
const SurfaceKernels& surfaceKernels(uint32_t width) { return KN_PICK_WIDTH(width, surface)(); }
}  // namespace kinora::shade
#endif
