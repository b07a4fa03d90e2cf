// One walk's ray through mirrors and lenses, for many walks at once: with its derivatives, turned at each boundary, until
// it passes its light, and Newton's steps that bring it there. manifold.h says what it is for, what it looks for and
// what comes of it. Included per target.
#include <kinora/integrator.h>
#include <kinora/manifold_options.h>
#include <kinora/math/sampling.h>
#include <kinora/random.h>
#include <kinora/ray_start.h>

#include <cmath>

#if defined(KINORA_MANIFOLD_WALK_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_MANIFOLD_WALK_H_TARGET
#undef KINORA_MANIFOLD_WALK_H_TARGET
#else
#define KINORA_MANIFOLD_WALK_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// N seen so flat that contexts may have bent it: its derivatives are not those of the surface.
template <int W>
KN_INLINE Mask<W> isSeenFlat(Vec3<W> N, Vec3<W> wo) {
  return dot(N, wo) < Float<W>(2e-3f);
}

// What a path is weighed by that was found: the ratio of the densities at y and at z, from the determinant of how the
// one changes with the other. A parameter, so that a test can leave it out and see that it is missed.
struct DensityRatio {
  template <int W>
  static KN_INLINE Float<W> of(Float<W> determinant) {
    return abs(determinant);
  }
};

// Arrays of the group's memory, padded.
struct WalkMemory {
  Group* g;
  const Services* sv;
  float* floats(uint32_t n) const { return static_cast<float*>(sv->alloc(g, (padded(n) + kPad) * sizeof(float))); }
  uint32_t* words(uint32_t n) const {
    return static_cast<uint32_t*>(sv->alloc(g, (padded(n) + kPad) * sizeof(uint32_t)));
  }
  void floats(uint32_t n, float* out[3]) const {
    for (int c = 0; c < 3; ++c) out[c] = floats(n);
  }
};
inline void padWalks(uint32_t m, uint32_t* list) {
  for (uint32_t i = m; i < padded(m); ++i) list[i] = m ? list[m - 1] : 0;
}

// Where walks begin, where they go, and the rays on which they are followed; by walk.
struct WalkStarts {
  // Walks begin at points of contexts, in their order.
  struct Run {
    const Context* c;
    uint32_t first, end;
  };
  uint32_t n = 0, runCount = 0;
  Run* runs = nullptr;
  uint32_t *point, *slot, *seed, *sample;
  float *P[3], *Ng[3], *bias, *time, *radius, *spread;
  WalkTargets to{};
  RayList* rays = nullptr;
  // The rays' derivatives by the two directions across the one at y; what they miss their lights by, and Newton's step.
  float *dP[2][3], *dD[2][3], *miss, *spreadOfPath, *next[3];
  uint32_t *passed, *kinds;  // boundaries so far, and a bit for each that light goes through

  void makeStarts(const WalkMemory& memory) {
    point = memory.words(n);
    slot = memory.words(n);
    seed = memory.words(n);
    sample = memory.words(n);
    memory.floats(n, P);
    memory.floats(n, Ng);
    bias = memory.floats(n);
    time = memory.floats(n);
    radius = memory.floats(n);
    spread = memory.floats(n);
  }
  void makeTracks(const WalkMemory& memory) {
    rays = memory.sv->makeRays(memory.g, n);
    for (int s = 0; s < 2; ++s) {
      memory.floats(rays->capacity, dP[s]);
      memory.floats(rays->capacity, dD[s]);
    }
    miss = memory.floats(n);
    spreadOfPath = memory.floats(n);
    passed = memory.words(n);
    kinds = memory.words(n);
    memory.floats(n, next);
  }
  void padArrays() {
    const auto pad = [&](auto* x) {
      for (uint32_t i = n; i < padded(n); ++i) x[i] = x[n - 1];
    };
    pad(point);
    pad(slot);
    pad(seed);
    pad(sample);
    for (int x = 0; x < 3; ++x) {
      pad(P[x]);
      pad(Ng[x]);
    }
    pad(bias);
    pad(time);
    pad(radius);
    pad(spread);
  }
};

// What paths bring, by walk.
struct WalkFound {
  float* value[3];          // light that arrives at y times the ratio of densities, over the density of z; 0: nothing
  float* transmittance[3];  // of media along a segment
  uint32_t* event[ManifoldOptions::kMostInterfaces];  // of light path expressions, by boundary
};

// What a walk looks for, and what it has; by walk.
struct WalkState {
  static constexpr int kPastTarget = 16;  // see through
  static_assert(ManifoldOptions::kMostInterfaces <= kPastTarget);
  float* d[3];     // direction at y that is being tried
  float* best[3];  // the one that missed least
  float* bestMiss;
  float* step[3];       // Newton's step from there, along directions across it
  float* damp;          // part of it that is tried
  uint32_t* through;    // a bit for each boundary: light goes through, else it is reflected. From bit kPastTarget on
                        // one for each: the ray that leaves it may pass the light and go on to a further boundary
  uint32_t* found;      // boundaries of the path; 0: none
  uint32_t* foundBits;  // their part of `through`
};

// Random numbers of walks, by event.
enum WalkEvent : uint32_t { kWalkEventFacets = 1, kWalkEventSeed = 40, kWalkEventsOfTrial = 8 };
template <int W>
KN_INLINE Float<W> drawOf(const WalkStarts& at, uint32_t depth, const Slots<W>& s, Int<W> event) {
  return drawHashed(s.get(at.seed), s.get(at.sample), dimensionAt(depth) + kDimUser + 3, event);
}

// The listed walks' rays, through the boundaries and towards their lights.
template <int W, class Ratio>
class WalkTracer {
 public:
  using F = Float<W>;
  using I = Int<W>;
  using V = Vec3<W>;
  using M = Mask<W>;
  // most: boundaries of a path; depth: of the vertex that the walks leave.
  WalkTracer(const WalkMemory& memory, const ManifoldOptions& options, const WalkStarts& at, uint32_t depth,
             uint32_t most)
      : memory_(memory), g_(memory.g), sv_(memory.sv), o_(options), at_(at), depth_(depth), most_(most) {}

  // From w.d on, the listed walks: w.found.
  void walk(uint32_t n, const uint32_t* list, const WalkState& w) {
    if (!n) return;
    uint32_t *live = memory_.words(n), *open = memory_.words(n), m = n;
    for (uint32_t i = 0; i < n; ++i) {
      live[i] = list[i];
      w.found[list[i]] = 0;
      w.bestMiss[list[i]] = INFINITY;
      w.damp[list[i]] = 1;
    }
    padWalks(m, live);
    for (uint32_t iteration = 0; m && iteration < o_.iterations; ++iteration) {
      const MemoryMark mark = sv_->markMemory(g_);
      for (uint32_t i = 0; i < padded(m); ++i) open[i] = live[i];
      leaveStart(m, live, w);
      for (uint32_t k = 0, left = m; left; ++k) {
        sv_->traceWalks(g_, at_.rays, depth_ + 1 + k, left, open);
        left = endAtTargets(left, open, k, w, false);
        if (left) left = turn(left, open, k, w, nullptr);
      }
      m = improve(m, live, w, iteration + 1 == o_.iterations);
      sv_->releaseMemory(g_, mark);
    }
  }
  // Sets the listed walks' rays off from y along w.d.
  void leaveStart(uint32_t n, const uint32_t* list, const WalkState& w) {
    const Rays& r = at_.rays->rays;
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(list + i);
      const V d = V::get(w.d, s), o = leave(V::get(at_.P, s), V::get(at_.Ng, s), s.get(at_.bias), d);
      put(s, in, o, r.o);
      put(s, in, d, r.d);
      s.put(in, F(1e30f), r.tMax);
      s.put(in, s.get(at_.time), r.time);
      s.put(in, s.get(at_.radius), r.radius);
      s.put(in, s.get(at_.spread), r.spread);
      s.put(in, I(0), at_.rays->origin);
      const Frame<W> f(d);
      const V zero;
      put(s, in, zero, at_.dP[0]);
      put(s, in, zero, at_.dP[1]);
      put(s, in, f.x, at_.dD[0]);
      put(s, in, f.y, at_.dD[1]);
      s.put(in, F(INFINITY), at_.miss);
      s.put(in, I(0), at_.passed);
      s.put(in, I(0), at_.kinds);
    }
    uint32_t* points = memory_.words(n);
    for (uint32_t i = 0, r0 = 0; i < n;) {
      while (list[i] >= at_.runs[r0].end) ++r0;
      uint32_t m = 0;
      const uint32_t from = i;
      for (; i < n && list[i] < at_.runs[r0].end; ++i) points[m++] = at_.point[list[i]];
      sv_->leave(g_, at_.rays, at_.runs[r0].c, m, points, list + from, nullptr);
    }
  }
  // Of rays that were traced: those that pass their target before they meet anything have come as near as they will,
  // but for those that are to go on to boundary k; `isFound`: only those of the path that was found end, at
  // its last boundary. What they miss it by, and Newton's step. The others that met something stay in `open`; returns
  // their number.
  uint32_t endAtTargets(uint32_t n, uint32_t* open, uint32_t k, const WalkState& w, bool isFound) {
    const bool isLast = k == most_;
    uint32_t m = 0;
    const Rays& r = at_.rays->rays;
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(open + i);
      const F t = s.get(at_.rays->hits.t);
      const M met = in & (t < F(3e38f));
      M ends(false);
      if (const M through = in & (s.get(at_.passed) != I(0)); through.any()) {
        const M infinite = (s.get(at_.to.flags) & I(uint32_t(kLightIsInfinite))) != I(0);
        const V o = V::get(r.o, s), d = V::get(r.d, s), to = V::get(at_.to.to, s);
        const V away = to - o;
        const F along = select(infinite, dot(to, d), dot(away, d));
        ends = through & (along > F(0.f)) & ((infinite & !met) | ((!infinite) & (along < t * F(1.0001f))));
        if (isFound) {
          ends = ends & (s.get(w.found) == I(k));
        } else if (k && !isLast) {
          ends = ends & !(met & ((s.get(w.through) & I(1u << (WalkState::kPastTarget + k - 1))) != I(0)));
        }
        // across the ray: what is missed, as an angle, and how that changes with w
        const F scale = F(1.f) / max(along, F(1e-30f));
        const V e = select(infinite, to - d * along, away - d * along) * scale;
        const Frame<W> f(d);
        const V da = V::get(at_.dD[0], s), db = V::get(at_.dD[1], s);
        const V ca = select(infinite, da, da + V::get(at_.dP[0], s) * scale),
                cb = select(infinite, db, db + V::get(at_.dP[1], s) * scale);
        const F a = dot(f.x, ca), b = dot(f.x, cb), c = dot(f.y, ca), g = dot(f.y, cb);
        const F det = a * g - b * c, ex = dot(f.x, e), ey = dot(f.y, e);
        const M good = abs(det) > F(1e-12f);
        const F inverse = F(1.f) / select(good, det, F(1.f));
        ends = ends & good;
        F sa = (g * ex - b * ey) * inverse, sb = (a * ey - c * ex) * inverse;
        // a step beyond half a radian means nothing
        const F size = sqrt(sa * sa + sb * sb), shorter = min(F(0.5f) / max(size, F(1e-30f)), F(1.f));
        sa = sa * shorter;
        sb = sb * shorter;
        const Frame<W> at(V::get(w.d, s));
        s.put(ends, sqrt(dot(e, e)), at_.miss);
        put(s, ends, at.x * sa + at.y * sb, at_.next);
        // solid angle at the last boundary, seen from y: how much wider the pencil has become
        s.put(ends, Ratio::of(det), at_.spreadOfPath);
      }
      const Packer<W> pack(isLast ? M(false) : met & !ends);
      pack.put(s.s, open + m);
      m += uint32_t(pack.count);
    }
    padWalks(m, open);
    return m;
  }

  // The listed rays' hits: turns them, with their derivatives, at boundary k. Those that go on stay in `open`.
  // `value` (null: not wanted) is multiplied by what the boundary passes on.
  uint32_t turn(uint32_t n, uint32_t* open, uint32_t k, const WalkState& w, const WalkFound* found) {
    Context* const* contexts;
    const uint32_t count = sv_->shade(g_, at_.rays, kTraitEyePath | kTraitWalk, depth_ + 1 + k, n, open, &contexts);
    uint32_t m = 0;
    for (uint32_t c = 0; c < count; ++c)
      if (contexts[c]->traits & kTraitWalkable) m = turnAt(*contexts[c], open, m, k, w, found);
    padWalks(m, open);
    return m;
  }

 private:
  static constexpr float kConverged = 5e-6f;  // what a path may miss its light by at last, as an angle
  static constexpr float kFound = 1e-4f;      // and so that it counts: steps may end where floats do

  static KN_INLINE M firstOf(uint32_t n, uint32_t i) {
    return M::firstN(int(n - i < uint32_t(W) ? n - i : uint32_t(W)));
  }
  static KN_INLINE void put(const Slots<W>& s, M m, V x, float* const to[3]) {
    s.put(m, x.x, to[0]);
    s.put(m, x.y, to[1]);
    s.put(m, x.z, to[2]);
  }

  // Facet of boundary k about the normal (0, 0, 1), and its density by solid angle: GGX facets, whatever the
  // material's are.
  KN_INLINE V facet(const Slots<W>& s, uint32_t k, F alpha, F& density) const {
    const F u = drawOf<W>(at_, depth_, s, I(kWalkEventFacets + 2 * k)),
            v = drawOf<W>(at_, depth_, s, I(kWalkEventFacets + 2 * k + 1));
    const F a2 = alpha * alpha, tan2 = a2 * u / max(F(1.f) - u, F(1e-7f));
    const F c2 = F(1.f) / (F(1.f) + tan2), c = sqrt(c2), sine = safeSqrt(F(1.f) - c2);
    F sn, cs;
    sincos(v * F(kTwoPi), sn, cs);
    const F q = a2 + tan2;
    density = a2 / max(F(kPi) * c2 * c * q * q, F(1e-30f));
    return {sine * cs, sine * sn, c};
  }
  // How the frame about n changes with it: d is the change of n. (Frame's own formula, differentiated.)
  static KN_INLINE V turnFrame(V n, V dn, V local) {
    const F sign = copySign(F(1.f), n.z), a = F(-1.f) / (sign + n.z), da = a * a * dn.z;
    const F db = fma(dn.x * n.y + n.x * dn.y, a, n.x * n.y * da);
    const V x(sign * (F(2.f) * n.x * dn.x * a + n.x * n.x * da), sign * db, -sign * dn.x);
    const V y(db, F(2.f) * n.y * dn.y * a + n.y * n.y * da, -dn.y);
    return x * local.x + y * local.y + dn * local.z;
  }

  uint32_t turnAt(const Context& c, uint32_t* open, uint32_t m, uint32_t k, const WalkState& w,
                  const WalkFound* found) {
    uint32_t *through = memory_.words(c.padded), *lobe = memory_.words(c.padded);
    float *eta = memory_.floats(c.padded), *alpha = memory_.floats(c.padded);
    for (uint32_t i = 0; i < c.padded; ++i) through[i] = w.through[c.path[i]] >> k & 1;
    const InterfaceArgs args{through, eta, alpha, lobe};
    c.bxdf->interface(&c, c.closure, &args);
    // where there is no such lobe the other one is taken
    bool lacks = false;
    for (uint32_t i = 0; i < c.padded; ++i) {
      const bool is = i < c.count ? lobe[i] == kNoLobe : false;
      if (is) through[i] ^= 1u;
      lacks = lacks || is;
    }
    if (lacks) c.bxdf->interface(&c, c.closure, &args);
    const Value e1 = c.builtin(Builtin::FacetEdge1), e2 = c.builtin(Builtin::FacetEdge2),
                n1 = c.builtin(Builtin::DNEdge1), n2 = c.builtin(Builtin::DNEdge2);
    uint32_t *points = memory_.words(c.padded), *passes = memory_.words(c.padded), leaving = 0;
    float *wi[3], *jacobian = nullptr;
    if (found) {
      memory_.floats(c.padded, wi);
      jacobian = memory_.floats(c.padded);
    }
    const uint32_t first = m;
    const Rays& r = at_.rays->rays;
    for (uint32_t i = 0; i < c.count; i += W) {
      M on = firstOf(c.count, i);
      const Slots<W> s = Slots<W>::load(c.path + i);
      const V N = V::load(c.N, i), Ng = V::load(c.Ng, i), wo = V::load(c.wo, i), d = -wo;
      const M passing = I::load(through + i) != I(0);
      on = on & (I::load(lobe + i) != I(kNoLobe)) & !isSeenFlat(N, wo);
      // the point's derivatives on the facet, and with them those of N
      const V x1 = V::load(e1.data, i), x2 = V::load(e2.data, i), G = cross(x1, x2);
      const F size2 = dot(G, G), slant = dot(G, d), t = F::load(c.distance + i);
      on = on & (size2 > F(0.f)) & (slant * slant > F(1e-12f) * size2);
      const F perSlant = F(1.f) / select(on, slant, F(1.f)), perSize = F(1.f) / select(on, size2, F(1.f));
      const F rough = F::load(alpha + i);
      F density(1.f);
      V h = N;
      const M isRough = rough > F(0.f);
      V local(F(0.f), F(0.f), F(1.f));
      if ((on & isRough).any()) {
        local = facet(s, k, max(rough, F(1e-4f)), density);
        h = select(isRough, normalize(Frame<W>(N).toWorld(local)), N);
      }
      const F cosO = dot(wo, h), ratio = F::load(eta + i);
      on = on & (cosO > F(1e-6f));
      const F rest = fnma(ratio * ratio, fnma(cosO, cosO, F(1.f)), F(1.f)), cosT = sqrt(max(rest, F(1e-12f)));
      on = on & ((!passing) | (rest > F(1e-12f)));
      const F mu = fms(ratio, cosO, cosT);
      V to = select(passing, d * ratio + h * mu, fma(h, cosO + cosO, d));
      to = to * (F(1.f) / sqrt(max(dot(to, to), F(1e-20f))));
      const F side = dot(Ng, to);
      on = on & ((passing & (side < F(0.f))) | ((!passing) & (side > F(0.f))));
      if (on.none()) continue;
      for (int a = 0; a < 2; ++a) {
        const V dd = V::get(at_.dD[a], s), along = fma(dd, t, V::get(at_.dP[a], s));
        const V dx = fma(d, -dot(G, along) * perSlant, along);
        const V dN = V::load(n1.data, i) * (dot(G, cross(dx, x2)) * perSize) +
                     V::load(n2.data, i) * (dot(G, cross(x1, dx)) * perSize);
        V dh = dN;
        if (isRough.any()) dh = select(isRough, turnFrame(N, dN, local), dN);
        const F dc = -(dot(dd, h) + dot(d, dh));
        const V refracted = dd * ratio + h * ((ratio - ratio * ratio * cosO / cosT) * dc) + dh * mu;
        const V reflected = dd + (h * dc + dh * cosO) * F(2.f);
        put(s, on, dx, at_.dP[a]);
        put(s, on, select(passing, refracted, reflected), at_.dD[a]);
      }
      const V from = leave(V::load(c.P, i), Ng, F::load(c.bias + i), to);
      put(s, on, from, r.o);
      put(s, on, to, r.d);
      s.put(on, F(1e30f), r.tMax);
      s.put(on, F::load(c.radius + i), r.radius);
      s.put(on, F::load(c.spread + i), r.spread);
      s.put(on,
            select(isRough, I(0), I(uint32_t(kFromDiscrete))) | I(uint32_t(kFromSpecular)) |
                select(passing, I(uint32_t(kFromTransmission)), I(0)),
            at_.rays->origin);
      s.put(on, I(k + 1), at_.passed);
      const I bit = select(passing, I(1u << k), I(0));
      s.put(on, k == 0 ? bit : s.get(at_.kinds) | bit, at_.kinds);
      if (found) {
        to.store(wi, i);
        // solid angle of directions by that of facets (Walter et al. 2007, equations 14 and 17)
        const F m2 = F(1.f) / ratio, cosI = dot(to, h), sum = fma(m2, cosI, cosO);
        const F turns = select(passing, sum * sum / max(m2 * m2 * abs(cosI), F(1e-20f)), F(4.f) * cosO);
        select(isRough, turns / density, F(1.f)).store(jacobian + i);
      }
      const Packer<W> pack(on);
      pack.put(s.s, open + m);
      pack.put(I::lanes(int32_t(i)), points + leaving);
      pack.put(select(passing, I(1), I(0)), passes + leaving);
      m += uint32_t(pack.count);
      leaving += uint32_t(pack.count);
    }
    if (!leaving) return m;
    sv_->leave(g_, at_.rays, &c, leaving, points, open + first, passes);
    if (found) bring(c, leaving, points, through, lobe, wi, jacobian, k, *found);
    return m;
  }
  // What the boundary passes on, into the listed points' paths.
  void bring(const Context& c, uint32_t n, const uint32_t* points, const uint32_t* through, const uint32_t* lobe,
             float* const wi[3], const float* jacobian, uint32_t k, const WalkFound& found) {
    float* value[3];
    memory_.floats(c.padded, value);
    uint32_t* isOn = memory_.words(c.padded);
    for (uint32_t i = 0; i < c.padded; ++i) isOn[i] = 0;
    for (uint32_t i = 0; i < n; ++i) isOn[points[i]] = 1;
    for (uint32_t i = 0; i < c.padded; ++i)
      if (!isOn[i])
        for (int x = 0; x < 3; ++x) wi[x][i] = c.N[x][i];
    const InterfaceValueArgs args{through, {wi[0], wi[1], wi[2]}, {value[0], value[1], value[2]}};
    c.bxdf->interfaceValue(&c, c.closure, &args);
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t p = points[i], s = c.path[p];
      for (int x = 0; x < 3; ++x) found.value[x][s] *= value[x][p] * jacobian[p];
      found.event[k][s] = c.eventOfSlot[c.slotOfLobe[lobe[p]]];
    }
  }

  // Takes what came nearer, tries half the way where nothing did. Walks that are done leave the list.
  uint32_t improve(uint32_t n, uint32_t* live, const WalkState& w, bool isLast) {
    uint32_t m = 0;
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(live + i);
      const F miss = s.get(at_.miss), before = s.get(w.bestMiss);
      const M better = in & (miss < before);
      s.put(better, miss, w.bestMiss);
      put(s, better, V::get(w.d, s), w.best);
      put(s, better, V::get(at_.next, s), w.step);
      s.put(better, s.get(at_.passed), w.found);
      s.put(better, s.get(at_.kinds), w.foundBits);
      F damp = s.get(w.damp);
      damp = select(better, min(damp + damp, F(1.f)), damp * F(0.5f));
      s.put(in, damp, w.damp);
      const F best = min(miss, before);
      // a walk that has not begun has nowhere to go back to; one whose steps help no more is as near as floats are
      const M goes = in & (best < F(3e38f)) & (best > F(kConverged)) & (damp > F(0.01f)) & M(!isLast);
      const M done = in & !goes;
      s.put(done & !(best < F(kFound)), I(0), w.found);
      const V from = V::get(w.best, s), d = normalize(from + V::get(w.step, s) * damp);
      put(s, goes, d, w.d);
      const Packer<W> pack(goes);
      pack.put(s.s, live + m);
      m += uint32_t(pack.count);
    }
    padWalks(m, live);
    return m;
  }

  const WalkMemory memory_;
  Group* g_;
  const Services* sv_;
  const ManifoldOptions& o_;
  const WalkStarts& at_;
  uint32_t depth_, most_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
