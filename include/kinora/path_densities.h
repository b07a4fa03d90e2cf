// By what other ways could this path have been made? Weights of bidirectional methods in two numbers for each path,
// that go along with it: I. Georgiev, "Implementing Vertex Connection and Merging" (2012). Both are sums of densities
// relative to that by which the path was made; his third, for merging, is the second over the number of merges that
// one light path in all could have been part of. Included per target.
//
// In media an edge that was sampled also has a density of its length: transmittance times, at the end of an edge in a
// medium, the extinction there. Each technique makes each vertex once, so that extinctions cancel; an edge that is
// connected lacks its transmittance. Tracking knows none: Services::meanTransmittance stands for it, a function of the
// edge that is the same in all sums, so that the weights of a path's techniques sum to one and its mean is right
// whatever it follows from. Lights met by rays count by what media let through on the way to them, not by chance: such
// edges have no transmittance in their density.
#include <kinora/integrator.h>
#include <kinora/simd/wide.h>

#ifndef KINORA_PATH_DENSITIES_ONCE
#define KINORA_PATH_DENSITIES_ONCE
#include <algorithm>
#include <cmath>
namespace kinora {
// All are for balance-heuristic weights 1 / (1 + others). F: a float, or one for each lane.
template <class F>
struct PathSumsOf {
  F last;    // connections through the last vertex; the density of the connection is a factor yet to come
  F before;  // those through the vertices before; the density of the reverse direction is a factor yet to come
  F edge;    // 1: the last edge is one that a method could have made by connecting its ends, 0: none does
};
using PathSums = PathSumsOf<float>;

// What a method does beside meeting lights and sampling them.
struct PathTechniques {
  bool connectsPaths = true;  // vertices of camera paths to those of light paths
  float lightPaths = 0;       // how many of a sample are connected to the camera; 0: none is
};
}  // namespace kinora
#endif

#if defined(KINORA_PATH_DENSITIES_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PATH_DENSITIES_H_TARGET
#undef KINORA_PATH_DENSITIES_H_TARGET
#else
#define KINORA_PATH_DENSITIES_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// |cos| between the surface and a direction; geometric normals, so that both ends of a ray say the same to both kinds
// of paths. Of a fibre: how much of its width a direction sees. What goes in at one place comes out at another, whose
// normal is not known; only a measure of the fibre's length and width is one for both ends.
template <int W>
KN_INLINE Float<W> surfaceCosines(Vec3<W> Ng, Vec3<W> fiber, Vec3<W> w) {
  const Float<W> along = dot(fiber, w), one(1.f);
  const Mask<W> isFiber = dot(fiber, fiber) > Float<W>(0.5f);
  return max(select(isFiber, safeSqrt(one - along * along), abs(dot(Ng, w))), Float<W>(1e-7f));
}
template <int W>
KN_INLINE Float<W> surfaceCosines(const Context& c, uint32_t i, Vec3<W> w) {
  if (c.traits & kTraitInSpace) return Float<W>(1.f);  // density is by volume there
  const Vec3<W> Ng = Vec3<W>::load(c.Ng, i);
  if (c.traits & kTraitFiber) return surfaceCosines(Ng, Vec3<W>::load(c.builtin(Builtin::Fiber).data, i), w);
  return max(abs(dot(Ng, w)), Float<W>(1e-7f));
}
inline float surfaceCosine(const Context& c, uint32_t i, Vec3<1> w) { return surfaceCosines(c, i, w).lane0(); }

// What lights say of rays that met them.
class LightDensities {
 public:
  // Rays that left the points of a context in directions d, t away from lights.
  LightDensities(Group* g, const Services* services, const Context& c, const float* const d[3], const float* t,
                 const uint32_t* light) {
    ask(g, services, {&c, nullptr, c.count}, d, t, light, nullptr);
  }
  // The same of n rays that left the listed points of the context.
  LightDensities(Group* g, const Services* services, const Context& c, uint32_t n, const uint32_t* points,
                 const float* const d[3], const float* t, const uint32_t* light) {
    ask(g, services, {&c, nullptr, n}, d, t, light, points);
  }
  // Of the group's paths.
  LightDensities(Group* g, const Services* services, const LightHits& hits) {
    float* d[3];
    for (int k = 0; k < 3; ++k) {
      d[k] = static_cast<float*>(services->alloc(g, (hits.count + kPad) * sizeof(float)));
      for (uint32_t i = 0; i < hits.count; ++i) d[k][i] = g->paths.rays.d[k][hits.slot[i]];
    }
    ask(g, services, {nullptr, &g->paths, hits.count}, d, hits.t, hits.light, hits.slot);
  }
  // By ray; of W of them from i on where the width is given.
  template <int W>
  Mask<W> isDelta(uint32_t i) const {
    return (Int<W>::load(x_.flags + i) & Int<W>(uint32_t(kLightIsDelta))) != Int<W>(0);
  }
  // Of light paths that begin with this light, over the cosine at which they leave it; per solid angle and, of
  // infinite lights, per area across the ray.
  template <int W>
  Float<W> emission(uint32_t i) const {
    using F = Float<W>;
    const F pdf = F::load(x_.pdfPosition + i) * F::load(x_.pdfDirection + i);
    const F cosine = -dot(Vec3<W>::load(x_.N, i), Vec3<W>::load(x_.d, i));
    const Int<W> kind = Int<W>::load(x_.flags + i) & Int<W>(uint32_t(kLightIsDelta | kLightIsInfinite));
    return select(kind != Int<W>(0), pdf, select(cosine > F(0.f), pdf / cosine, F(0.f)));
  }
  float emission(uint32_t i) const { return emission<1>(i).lane0(); }
  // Of a light sample at the vertex that the ray left, per solid angle. Seen from there a point has none, but so it
  // is with every way to find it: the square of the distance is left.
  template <int W>
  Float<W> direct(uint32_t i) const {
    using F = Float<W>;
    const Int<W> kind = Int<W>::load(x_.flags + i) & Int<W>(uint32_t(kLightIsDelta | kLightIsInfinite));
    const F pdf = F::load(x_.pdf + i), t = F::load(x_.t + i);
    return select(kind == Int<W>(uint32_t(kLightIsDelta)), pdf * t * t, pdf);
  }
  float direct(uint32_t i) const { return direct<1>(i).lane0(); }

 private:
  void ask(Group* g, const Services* services, ShadowRun run, const float* const d[3], const float* t,
           const uint32_t* light, const uint32_t* point) {
    x_.count = run.end;
    for (int k = 0; k < 3; ++k) x_.d[k] = d[k];
    x_.t = t;
    x_.light = light;
    x_.point = point;
    x_.runCount = 1;
    x_.runs = &run;
    services->lightEnds(g, &x_);
    x_.runs = nullptr;
  }
  LightEnds x_{};
};

// About what media let through between points of a context and what lies in directions d (unit), so far away; where
// paths do not scatter in media 1.
inline const float* transmittanceOfEdges(Group* g, const Services* services, const Context& c,
                                         const float* const d[3], const float* distance) {
  float* out = c.alloc<float>(c.padded + kPad);
  std::fill_n(out, c.padded + kPad, 1.f);
  if (services->mediaScatter) services->meanTransmittance(g, c.count, c.P, d, distance, c.time, out);
  return out;
}

// The numbers of a group's paths, by slot.
class PathDensities {
 public:
  PathDensities(Group* g, const Services* services, PathTechniques techniques = {})
      : g_(g),
        sv_(services),
        of_(static_cast<PathSums*>(services->alloc(g, (g->padded + kPad) * sizeof(PathSums)))),
        is_(techniques) {
    std::fill_n(of_, g->padded + kPad, PathSums{0, 0, 0});
  }
  const PathSums& operator[](uint32_t slot) const { return of_[slot]; }
  template <int W>
  PathSumsOf<Float<W>> at(Int<W> slots) const {
    const Int<W> i = slots * Int<W>(uint32_t(sizeof(PathSums) / sizeof(float)));
    return {gather(&of_->last, i), gather(&of_->before, i), gather(&of_->edge, i)};
  }

  // At the first vertex of light paths; `light` by slot.
  void begin(Group* g, const Services* services, const Context& c, const uint32_t* light) {
    uint32_t* lights = c.alloc<uint32_t>(c.padded);
    for (uint32_t i = 0; i < c.padded; ++i) lights[i] = light[c.path[i]];
    const LightDensities x(g, services, c, c.wo, c.distance, lights);
    const float* through = transmittanceOfEdges(g, services, c, c.wo, c.distance);
    const bool isMet = !(c.traits & kTraitScattersOnce);  // rays that leave such points meet no lights
    for (uint32_t i = 0; i < c.count; ++i) {
      // a light sample connects the light with any vertex
      const float density = x.emission(i) * surfaceCosine(c, i, Vec3<1>::load(c.wo, i)) * through[i];
      // 0 at a light's edge, which the way back from a fibre's axis may miss: no other technique finds it there
      const float share = density > 0 ? 1 / density : 0;
      of_[c.path[i]] = {x.direct(i) * share, x.isDelta<1>(i).any() || !isMet ? 0 : share, 1};
    }
  }
  // At what camera rays hit, where light paths are connected to the camera.
  void beginAtCamera(const Context& c, const CameraConnection& camera) {
    const float* through = transmittanceOfEdges(g_, sv_, c, c.wo, c.distance);
    for (uint32_t i = 0; i < c.count; ++i) {
      const float back = camera.pdf[i] * surfaceCosine(c, i, Vec3<1>::load(c.wo, i)) * through[i];
      const float distance = c.distance[i] + camera.begin[i];  // densities are by the lens
      of_[c.path[i]] = {back > 0 ? is_.lightPaths * distance * distance / back : 0, 0, 1};
    }
  }
  // Behind the meeting of lights: see beginAnew().
  void endLit(uint32_t n, const uint32_t* slots) {
    for (uint32_t i = 0; hasLit_ && i < n; ++i)
      if (of_[slots[i]].last == kAllBySamples) of_[slots[i]].last = 0;
    hasLit_ = false;
  }
  // At each other vertex: from densities per solid angle to those per area.
  void arrive(const Context& c) {
    const float* through = transmittanceOfEdges(g_, sv_, c, c.wo, c.distance);
    for (uint32_t i = 0; i < c.count; ++i) {
      PathSums& x = of_[c.path[i]];
      const float inverse = 1 / surfaceCosine(c, i, Vec3<1>::load(c.wo, i));
      x = {x.last * c.distance[i] * c.distance[i] * inverse / through[i], x.before * inverse,
           is_.connectsPaths ? 1.f : 0.f};
    }
  }
  // Of a path that went where no other technique goes: none makes a vertex before this one in another way. lit: light
  // samples have all that its next ray might find of lights, up to endLit().
  void beginAnew(uint32_t slot, bool lit = false) {
    of_[slot] = {lit ? kAllBySamples : 0, 0, 0};
    hasLit_ |= lit;
  }
  // After new directions were taken; merges: see below, null: none.
  void leave(const Context& c, const GenerateArgs& a, const float* merges = nullptr) {
    for (uint32_t i = 0; i < c.count; ++i) {
      if (a.slot[i] == kNoLobe) continue;
      PathSums& x = of_[c.path[i]];
      const float cosine = surfaceCosine(c, i, Vec3<1>::load(a.wi, i)) / a.pdf[i];
      const float here = throughVertex(x, a.pdfReverse[i], merges ? merges[i] : 0.f);
      x = a.flags[i] & kSampleDiscrete ? PathSums{0, cosine * x.before * a.pdfReverse[i], 0}
                                       : PathSums{1 / a.pdf[i], cosine * here, 0};
    }
  }
  // Connections of the last edge, those before it, and merges at the vertex. reverse: density at the vertex of the
  // way back. merges: how many of a sample's light paths go through the neighbourhood with which a camera path's
  // vertex there is merged, for one that does so with a density of 1 per area.
  template <class F>
  static F throughVertex(const PathSumsOf<F>& x, F reverse, F merges) {
    return x.edge * x.last + x.before * reverse + merges;
  }

 private:
  static constexpr float kAllBySamples = 1e30f;  // more than any density
  Group* g_;
  const Services* sv_;
  PathSums* of_;
  PathTechniques is_;
  bool hasLit_ = false;  // some path has kAllBySamples
};

// The other ways to make a path that was made by...
// ... a ray that met a light, which light samples would have made with density `pdf` (LightHits::pdf). through, here and
// below: transmittanceOfEdges() of the edge.
inline float othersOfHit(const PathSums& path, float pdf, const LightDensities& light, uint32_t i,
                         float through = 1) {
  return pdf * path.last + light.emission(i) * through * path.before;
}
// ... light samples from W points of a context, from i on, in directions wi; pdf, reverse: the bxdf's for wi.
template <int W>
KN_INLINE Float<W> othersOfSample(const PathSumsOf<Float<W>>& path, const Context& c, uint32_t i, Vec3<W> wi,
                                  Float<W> pdf, Float<W> reverse, const LightDensities& light, Float<W> merges,
                                  Float<W> through = Float<W>(1.f)) {
  const Float<W> back =
      light.emission<W>(i) * through * surfaceCosines(c, i, wi) * PathDensities::throughVertex(path, reverse, merges);
  return (zeroUnless(!light.isDelta<W>(i), pdf) + back) / light.direct<W>(i);
}
// ... a connection of two vertices.
template <class F>
struct ConnectedEnd {
  PathSumsOf<F> path;
  F pdfTo;    // of the direction to here, by the other end's bxdf
  F cosine;   // between the surface here and that direction
  F reverse;  // of the way back, by the bxdf here
  F merges = F(0.f);
};
template <class F>
KN_INLINE F othersOfConnection(F distance, const ConnectedEnd<F>& a, const ConnectedEnd<F>& b, F through = F(1.f)) {
  const auto side = [](const ConnectedEnd<F>& x) {
    return x.pdfTo * x.cosine * PathDensities::throughVertex(x.path, x.reverse, x.merges);
  };
  return through * (side(a) + side(b)) / (distance * distance);
}
// ... a connection of a light path's vertex to the camera, which makes that direction with density `pdf`; light paths
// so connected; cosine, reverse, merges: as above.
inline float othersOfSplat(const PathSums& path, float distance, float pdf, float lightPaths, float cosine,
                           float reverse, float merges, float through = 1) {
  return through * pdf * cosine / (distance * distance * lightPaths) *
         PathDensities::throughVertex(path, reverse, merges);
}
// ... merging a camera path's vertex with those of light paths: `last` and `before` are these paths' sums, the first
// times its edge. pdf: of the camera path's bxdf for the directions in which the light paths came, and its reverse.
template <int W>
KN_INLINE Float<W> othersOfMerge(const PathSums& camera, Float<W> last, Float<W> before, Float<W> pdf,
                                 Float<W> reverse, float merges) {
  using F = Float<W>;
  return (F(camera.edge * camera.last) + F(camera.before) * reverse + last + before * pdf) * F(1 / merges);
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
