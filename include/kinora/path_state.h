// What the paths of the forward loop carry from vertex to vertex, by slot of the group: throughput, density, the state
// of light path expressions, and flags that say which light they may still count, so that each light is counted by one
// technique. Used by the loop's parts (path_loop.h). Included per target.
#include <kinora/clamp_luminance.h>
#include <kinora/guiding.h>
#include <kinora/integrator.h>
#include <kinora/manifold.h>
#include <kinora/path_loop_options.h>
#include <kinora/ray_start.h>
#include <kinora/refracted_alpha.h>

#include <cmath>

#ifndef KINORA_PATH_STATE_ONCE
#define KINORA_PATH_STATE_ONCE
namespace kinora {
// Beside the bits of RayOrigin. Without caustics:
struct PathFlags {
  enum : uint32_t {
    kHadDiffuse = 1u << kOriginBits,   // some vertex took light samples whose shadow rays went through glass
    kCaustic = 2u << kOriginBits,      // a mirror or lens after that: light that the ray finds does not count
    kRefracted = 4u << kOriginBits,    // through glass after that, which tinted shadows stand for: neither does this
    kSeenThrough = 8u << kOriginBits,  // only refracted since the camera, and no light in its way (RefractedAlpha)
    kFromBody = 16u << kOriginBits  // scattered once within a body, at `begin`, from where it is weighed for lights
  };
  static constexpr int kWalkedShift = 24;
};
}  // namespace kinora
#endif

#if defined(KINORA_PATH_STATE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PATH_STATE_H_TARGET
#undef KINORA_PATH_STATE_H_TARGET
#else
#define KINORA_PATH_STATE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Not black; what is not a number counts, so that the film can report it.
template <int W>
KN_INLINE Mask<W> isThere(Vec3<W> v) {
  return abs(v.x) + abs(v.y) + abs(v.z) != Float<W>(0.f);
}

template <int W>
struct PathState {
  Group* g;
  const Services* sv;
  const PathLoopOptions& o;
  uint32_t interfaces;  // boundaries that manifold walks go through; 0: there are no walks
  float *throughput[3], *medium[3], *pdf;
  uint32_t* state;  // of light path expressions
  uint32_t* flags;  // RayOrigin, PathFlags, and from kWalkedShift on the state of WalkedPaths
  // Where media scatter: how much of the light at the vertex of a path it counts (the rest is lightOnTheWay's); and
  // where they glow, see RayList.
  float *share = nullptr, *againstLights = nullptr;
  // RayList::begin and behind: of paths of kFromBody, where they were scattered.
  float *begin[3], *behind;
  uint32_t part = 0, parts = 1;  // directions from the first vertex: the one under way, and how many
  RefractedAlpha* alpha = nullptr;
  Lessons<W>* lessons = nullptr;

  PathState(Group* group, const Services* services, const PathLoopOptions& options, uint32_t interfaces)
      : g(group), sv(services), o(options), interfaces(interfaces) {
    const uint32_t n = g->padded + kPad;
    for (int c = 0; c < 3; ++c) {
      g->paths.throughput[c] = throughput[c] = floats(n);
      medium[c] = sv->hasMedia ? floats(n) : nullptr;
    }
    pdf = floats(n);
    state = words(n);
    flags = g->paths.origin;
    parts = o.byLobe.given ? o.byLobe.most() : o.indirectSamples < 1 ? 1 : o.indirectSamples;
    if (o.refractsAlpha) alpha = new (sv->alloc(g, sizeof(RefractedAlpha))) RefractedAlpha(g, sv);
    for (int c = 0; c < 3; ++c) g->paths.begin[c] = begin[c] = floats(n);
    g->paths.behind = behind = floats(n);
    if (!sv->mediaScatter) return;
    share = floats(n);
    if (!g->paths.glow[0]) return;
    againstLights = floats(n);
    g->paths.againstLights = againstLights;
    g->paths.share = share;
  }
  void start(uint32_t slot, float weight) {
    for (float* t : throughput) t[slot] = weight;
    pdf[slot] = 0;
    state[slot] = sv->paths.start;
    flags[slot] = kFromDiscrete;
    behind[slot] = 0;
    if (share) share[slot] = 1;
    if (againstLights) againstLights[slot] = HUGE_VALF;
  }
  // Sends paths from the context's points i ... along w: all that their rays have beside density, spread and flags.
  KN_INLINE void send(Mask<W> on, const Context& c, uint32_t i, const Slots<W>& s, Vec3<W> w) const {
    const Vec3<W> from = leave(Vec3<W>::load(c.P, i), Vec3<W>::load(c.Ng, i), Float<W>::load(c.bias + i), w);
    const Rays& r = g->paths.rays;
    s.put(on, from.x, r.o[0]);
    s.put(on, from.y, r.o[1]);
    s.put(on, from.z, r.o[2]);
    s.put(on, w.x, r.d[0]);
    s.put(on, w.y, r.d[1]);
    s.put(on, w.z, r.d[2]);
    s.put(on, Float<W>(o.farthest), r.tMax);
    s.put(on, Float<W>::load(c.radius + i), r.radius);
  }
  KN_INLINE void setThroughput(Mask<W> on, const Slots<W>& s, Vec3<W> t) const {
    s.put(on, t.x, throughput[0]);
    s.put(on, t.y, throughput[1]);
    s.put(on, t.z, throughput[2]);
  }
  // The automaton's step at an event of each lane.
  KN_INLINE void step(Mask<W> on, const Slots<W>& s, Int<W> event) const {
    const Int<W> row = s.get(state) * Int<W>(sv->paths.eventCount);
    s.put(on, gather(sv->paths.next, select(on, row + event, Int<W>(0))), state);
  }
  void contribute(const Contributions& c) const {
    sv->contribute(g, &c);
    if (lessons) lessons->collect(c);
  }

  float* floats(uint32_t n) const { return static_cast<float*>(sv->alloc(g, n * sizeof(float))); }
  uint32_t* words(uint32_t n) const { return static_cast<uint32_t*>(sv->alloc(g, n * sizeof(uint32_t))); }

  float* const* mediumIfAny() const { return sv->hasMedia ? medium : nullptr; }
  void applyMedium(uint32_t n, const uint32_t* live) const {
    if (!sv->hasMedia) return;
    for (uint32_t i = 0; i < n; i += W) {
      const Mask<W> m = Mask<W>::firstN(int(n - i < W ? n - i : W));
      const Slots<W> s = Slots<W>::load(live + i);
      for (int c = 0; c < 3; ++c) s.put(m, s.get(throughput[c]) * s.get(medium[c]), throughput[c]);
    }
  }

  // ---- clamps and lists ----

  float mostAt(uint32_t depth) const {
    return depth >= o.clampDepth ? o.clampLuminance : depth ? o.clampDirect : 1e30f;
  }
  // depth: of the ray that found the light, camera rays 0.
  void clampOne(uint32_t depth, float v[3]) const {
    const float most = mostAt(depth);
    if (!(most < 1e30f)) return;
    const float k = factorToLuminance(Vec3<1>(v[0], v[1], v[2]), Float<1>(most)).lane0();
    for (int c = 0; c < 3; ++c) v[c] *= k;
  }

  // Drops escaped rays from the list; returns how many stay.
  uint32_t keepHits(uint32_t n, uint32_t* live) const {
    uint32_t m = 0;
    for (uint32_t i = 0; i < n; i += W) {
      const Mask<W> in = Mask<W>::firstN(int(n - i < W ? n - i : W));
      const Slots<W> s = Slots<W>::load(live + i);
      const Packer<W> pack(in & (s.get(g->paths.hits.t) < Float<W>(3e38f)));
      pack.put(s.s, live + m);
      m += uint32_t(pack.count);
    }
    padList(m, live);
    return m;
  }
  static void padList(uint32_t m, uint32_t* live) {
    for (uint32_t i = m; i < padded(m); ++i) live[i] = m ? live[m - 1] : 0;
  }

  // At the first vertex; where its paths come out that went below is behind it.
  static bool isFirst(const Context& c, uint32_t depth) { return depth == 0 && !(c.traits & kTraitComesOut); }
  // By what sample indices behind the first vertex are raised, where parts have sequences of their own.
  uint32_t sequence() const { return o.byLobe.given ? part * kSequenceOfPart : 0; }

  // ---- which light a path may count ----

  KN_INLINE bool isBlockedByGlass(uint32_t light) const {
    return sv->lightExceptions && light < sv->lightCount && sv->lightExceptions[light] & kLightBlockedByGlass;
  }
  // Whether what a path with these flags finds of a light does not count.
  KN_INLINE bool isLeftOut(uint32_t flags, uint32_t light) const {
    return flags & PathFlags::kCaustic || (flags & PathFlags::kRefracted && !isBlockedByGlass(light)) ||
           isWalked(flags, light);
  }
  // Whether what a path finds of a light is left to walks.
  bool isWalked(uint32_t flags, uint32_t light) const {
    return WalkedPaths::isWalked(flags >> PathFlags::kWalkedShift) && sv->lightWalks[light];
  }
  KN_INLINE Int<W> walkedAfter(const Context& c, uint32_t i, const Slots<W>& s, Int<W> slot, Mask<W> discrete) const {
    if (!interfaces) return Int<W>(0);
    const Int<W> before = s.get(flags).template shr<PathFlags::kWalkedShift>();
    return WalkedPaths::after(c, i, slot, discrete, before, interfaces).template shl<PathFlags::kWalkedShift>();
  }
  // Light without caustics. Shadow rays go straight through glass with its tint; they stand for all light that a path
  // would find by refraction since the vertex which they left (PathFlags). Within glass that the path itself entered
  // there are none: rough glass seen by the camera refracts twice, as clear glass does.
  KN_INLINE bool standsIn(const Context& c) const { return !o.allowCaustics && (c.traits & kTraitTinted); }
  KN_INLINE Mask<W> hasFlag(const Slots<W>& s, uint32_t bit) const {
    return (s.get(flags) & Int<W>(bit)) != Int<W>(0);
  }
  // Lanes whose light walks go to.
  KN_INLINE Mask<W> walkedTo(const uint32_t* light) const {
    alignas(64) uint32_t is[W];
    for (int l = 0; l < W; ++l) is[l] = light[l] < sv->lightCount && sv->lightWalks[light[l]];
    return Int<W>::load(is) != Int<W>(0);
  }
  // Lanes whose light sees glass as opaque.
  KN_INLINE Mask<W> blockedByGlass(const uint32_t* light) const {
    if (!sv->lightExceptions) return Mask<W>(false);
    alignas(64) uint32_t is[W];
    for (int l = 0; l < W; ++l) is[l] = isBlockedByGlass(light[l]);
    return Int<W>::load(is) != Int<W>(0);
  }
  bool walksFrom(const Context& c, uint32_t depth) const {
    return interfaces && !(c.traits & (kTraitWalkable | kTraitScattersOnce)) && depth < o.maxIndirectBounces;
  }
  static uint32_t walkableSlot(const Context& c) { return uint32_t(__builtin_ctz(c.walkableSlots | 1u << 31)); }
  static KN_INLINE Int<W> flag(Mask<W> m, uint32_t bit) { return select(m, Int<W>(bit), Int<W>(0)); }
  // Whether directions from the context's points lead through glass that its surface bounds.
  static KN_INLINE Mask<W> staysInside(const Context& c, uint32_t i, Vec3<W> wi) {
    if ((c.traits & (kTraitTinted | kTraitEncloses)) != (kTraitTinted | kTraitEncloses)) return Mask<W>(false);
    const Mask<W> below = dot(Vec3<W>::load(c.Ng, i), wi) < Float<W>(0.f);
    const Mask<W> outside = Int<W>::load(c.entering + i) != Int<W>(0);
    return (outside & below) | !(outside | below);
  }
  // The flags of new directions beside those of RayOrigin.
  KN_INLINE Int<W> withoutCaustics(const Context& c, uint32_t i, const Slots<W>& s, Vec3<W> wi, Int<W> slot,
                                   Mask<W> discrete) const {
    const Mask<W> had = hasFlag(s, PathFlags::kHadDiffuse);
    Mask<W> refracted(false), inside(false);
    if (c.traits & kTraitTinted) {
      Mask<W> through(false);
      for (uint32_t l = 0; l < c.slotCount; ++l)
        if (c.tintedSlots >> l & 1) through = through | (slot == Int<W>(l));
      refracted = had & through;
      inside = staysInside(c, i, wi);
    }
    const Mask<W> rough = !discrete;
    return flag(had | (rough & !inside), PathFlags::kHadDiffuse) |
           flag(had & discrete & !refracted, PathFlags::kCaustic) | flag(refracted, PathFlags::kRefracted) |
           flag(rough & !inside & !refracted, kFromTintedLight);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
