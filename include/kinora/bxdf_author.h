// The bxdf author's layer: write one struct over W points, and BxdfRunner turns it into the tables of bxdf.h.
//
//   struct MyBxdf {
//     struct Closure { Value color; };                    // bound once a context; Values are uniform or varying
//     static void begin(const Context& c, Closure& k);    // k.color = c.param(kColor);
//     template <int W> struct Lanes {                     // W points
//       Lanes(const Closure& k, const Surface<W>& s);     // load what evaluation needs
//       void evaluate(Vec3<W> wi, LobeSum<W>& out) const; // out.add(lobe, weight with cosine); out.pdf, out.pdfReverse
//       void sample(Float<W> u, Float<W> v, Float<W> w, LobeSample<W>& out) const;
//       Rgb<W> albedo() const;
//     };
//     // optional: HasEmission with emission, and presence, interior, thinShadow, medium, interface and interfaceValue over
//     // whole contexts
//   };
//   KINORA_BXDF(MyBxdf, .help = "...", .params = kParams, .lobes = kLobes)          // after KINORA_KERNELS_END
// Included per target.
#include <kinora/bxdf.h>
#ifdef KINORA_KERNEL_FILE
#include <kinora/simd/foreach_target.h>
#endif
#include <kinora/math/sampling.h>

#if defined(KINORA_BXDF_AUTHOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_BXDF_AUTHOR_H_TARGET
#undef KINORA_BXDF_AUTHOR_H_TARGET
#else
#define KINORA_BXDF_AUTHOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Which points a chunk of lanes stands for: W following ones, or one point on all lanes (evaluateAt).
struct At {
  uint32_t first;
  bool broadcast;
};

template <int W>
KN_INLINE Float<W> loadFloat(const float* p, At at) {
  return at.broadcast ? Float<W>(p[at.first]) : Float<W>::load(p + at.first);
}
template <int W>
KN_INLINE Vec3<W> loadVec(const float* const p[3], At at) {
  return {loadFloat<W>(p[0], at), loadFloat<W>(p[1], at), loadFloat<W>(p[2], at)};
}
template <int W>
KN_INLINE Int<W> loadInt(const uint32_t* p, At at) {
  return at.broadcast ? Int<W>(p[at.first]) : Int<W>::load(p + at.first);
}
template <int W>
KN_INLINE Float<W> loadFloat(const Value& v, At at) {
  return v.stride ? loadFloat<W>(v.data[0], at) : Float<W>(v.data[0][0]);
}
template <int W>
KN_INLINE Rgb<W> loadRgb(const Value& v, At at) {
  if (v.stride) return loadVec<W>(v.data, at);
  return {Float<W>(v.data[0][0]), Float<W>(v.data[1][0]), Float<W>(v.data[2][0])};
}
template <int W>
KN_INLINE Vec3<W> loadVec(const Value& v, At at) {
  return loadRgb<W>(v, at);
}

// The surface at W points, as bxdfs see it. Render space.
template <int W>
struct Surface {
  Vec3<W> N, Ng, wo;
  Float<W> outerIor;
  Mask<W> entering;
  Float<W> cosO;  // N.wo, at least 1e-6
  At at;
  const Context* context;
  KN_INLINE Surface(const Context& c, At a) : at(a), context(&c) {
    N = loadVec<W>(c.N, a);
    Ng = loadVec<W>(c.Ng, a);
    wo = loadVec<W>(c.wo, a);
    outerIor = loadFloat<W>(c.outerIor, a);
    entering = loadInt<W>(c.entering, a) != Int<W>(0);
    cosO = max(dot(N, wo), Float<W>(1e-6f));
  }
  // Where paths go below the surface, in which light reaches so far (render units); they do not where it is shorter than
  // this times the radius of their footprint, nor where it is NaN.
  KN_INLINE Mask<W> sinks(Float<W> reach, Float<W> leastFootprints) const {
    if (!(context->traits & kTraitSubsurface)) return Mask<W>(false);
    const Mask<W> is = reach > Float<W>(1e-6f);
    if (context->traits & kTraitBothEnds) return is;
    return is & (reach > loadFloat<W>(context->radius, at) * leastFootprints);
  }
};

// Bump inputs of 0 0 0 (the default) mean "not connected".
inline bool isBumped(const Value& n) {
  return n.components == 3 && (n.stride || n.data[0][0] != 0.f || n.data[1][0] != 0.f || n.data[2][0] != 0.f);
}
// The normal of a bump input on wo's side, bent until wo sees it (never flipped alone: DESIGN section 2). Points at which
// it is 0 0 0 have the surface's own as it is, as all have where no normal is given.
template <int W>
KN_INLINE Vec3<W> bumpedNormal(const Value& n, const Surface<W>& s) {
  using F = Float<W>;
  Vec3<W> b = loadVec<W>(n, s.at);
  const F l2 = dot(b, b);
  const Mask<W> given = l2 > F(1e-12f);
  b = select(given, b * (F(1.f) / sqrt(max(l2, F(1e-30f)))), s.N);
  b = select(dot(b, s.Ng) < F(0.f), -b, b);
  const F d = dot(b, s.wo);
  const Vec3<W> bent = fma(s.wo, F(0.01f) - d, b);
  return select(given, select(d < F(0.01f), normalize(bent), b), s.N);
}
// Writes a one-component value to n padded floats.
inline void copyFloat(const Value& v, uint32_t n, float* out) {
  for (uint32_t i = 0; i < n; ++i) out[i] = v.data[0][v.stride ? i : 0];
}

// Sums over lobes at one direction. Weights include the cosine.
template <int W>
struct LobeSum {
  Float<W> pdf, pdfReverse;  // selection probabilities included
  bool wantsReverse = true;  // false: nobody reads pdfReverse
  Rgb<W> slot[kMaxSlots];
  const uint8_t* slotOfLobe;
  KN_INLINE LobeSum() {}  // written out: implicit constructors would miss the target's instruction set
  KN_INLINE void add(uint32_t lobe, Rgb<W> weight) { slot[slotOfLobe[lobe]] += weight; }
};

template <int W>
struct LobeSample {
  KN_INLINE LobeSample() {}
  Vec3<W> wi;
  Mask<W> valid;
  // Discrete lobes (mirrors): weight (value), probability of the choice, and the lobe; elsewhere ignored.
  Mask<W> discrete;
  Rgb<W> discreteWeight;
  Float<W> discreteProbability;
  Int<W> discreteLobe;
  // Of those, the ones that go on below the surface (kSampleBelow), of these the ones of kSampleOnce and of
  // kSampleStraight, and which of the material's media they are of.
  Mask<W> below, once, straight;
  Int<W> medium = Int<W>(0);
};

template <class B>
struct BxdfRunner {
  using Closure = typename B::Closure;

  static void* begin(const Context* c) {
    Closure* k = new (c->alloc<Closure>(1)) Closure();
    B::begin(*c, *k);
    return k;
  }

  template <int W>
  static KN_INLINE void evaluateChunk(const Context* c, const Closure& k, At at, Vec3<W> wi, uint32_t out,
                                      const EvaluateArgs* a) {
    const Surface<W> s(*c, at);
    const typename B::template Lanes<W> lanes(k, s);
    LobeSum<W> sum;
    sum.slotOfLobe = c->slotOfLobe;
    sum.wantsReverse = a->pdfReverse != nullptr;
    lanes.evaluate(wi, sum);
    for (uint32_t l = 0; l < c->slotCount; ++l) sum.slot[l].store(a->weight[l], out);
    sum.pdf.store(a->pdf + out);
    if (a->pdfReverse) sum.pdfReverse.store(a->pdfReverse + out);
  }

  template <int W>
  static void evaluate(const Context* c, const void* closure, const EvaluateArgs* a) {
    const Closure& k = *static_cast<const Closure*>(closure);
    for (uint32_t i = 0; i < c->count; i += W) evaluateChunk<W>(c, k, At{i, false}, Vec3<W>::load(a->wi, i), i, a);
  }

  template <int W>
  static void evaluateAt(const Context* c, const void* closure, uint32_t point, uint32_t n, const EvaluateArgs* a) {
    const Closure& k = *static_cast<const Closure*>(closure);
    for (uint32_t i = 0; i < n; i += W) evaluateChunk<W>(c, k, At{point, true}, Vec3<W>::load(a->wi, i), i, a);
  }

  // One direction a point. Lobes share one mixture pdf; then one slot is picked in proportion to its weight, so that
  // each path carries one event and the slots still sum to the whole exactly in expectation.
  template <int W>
  static void generate(const Context* c, const void* closure, const GenerateArgs* a) {
    using F = Float<W>;
    const Closure& k = *static_cast<const Closure*>(closure);
    for (uint32_t i = 0; i < c->count; i += W) {
      const Surface<W> s(*c, At{i, false});
      const typename B::template Lanes<W> lanes(k, s);
      LobeSample<W> sample;
      lanes.sample(F::load(a->u[0] + i), F::load(a->u[1] + i), F::load(a->u[2] + i), sample);
      LobeSum<W> sum;
      sum.slotOfLobe = c->slotOfLobe;
      sum.wantsReverse = a->pdfReverse != nullptr;
      Rgb<W> weight;
      Int<W> slot(0u);
      Mask<W> valid = sample.valid;
      const Mask<W> smooth = valid & !sample.discrete;
      if (smooth.any()) {
        lanes.evaluate(sample.wi, sum);
        valid = valid & (sample.discrete | (sum.pdf > F(0.f)));
        if (c->slotCount == 1) {
          weight = sum.slot[0];
        } else {
          F total(0.f);
          for (uint32_t l = 0; l < c->slotCount; ++l) total += average(sum.slot[l]);
          // walk the slots; q is the probability with which the one reached was picked
          F rest = F::load(a->u[3] + i) * total, q(0.f);
          Mask<W> open(true);
          for (uint32_t l = 0; l < c->slotCount; ++l) {
            const F share = average(sum.slot[l]);
            const Mask<W> here = open & (share > F(0.f)) & (rest < share);
            weight = select(here, sum.slot[l], weight);
            slot = select(here, Int<W>(l), slot);
            q = select(here, share, q);
            open = open & !here;
            rest -= share;
          }
          // rounding may walk past the last slot: take the last that has weight
          if (open.any()) {
            for (uint32_t l = 0; l < c->slotCount; ++l) {
              const F share = average(sum.slot[l]);
              const Mask<W> here = open & (share > F(0.f));
              weight = select(here, sum.slot[l], weight);
              slot = select(here, Int<W>(l), slot);
              q = select(here, share, q);
            }
          }
          weight = select(q > F(0.f), weight * (total / max(q, F(1e-38f))), Rgb<W>());
        }
      }
      F pdf = sum.pdf;
      if ((valid & sample.discrete).any()) {
        weight = select(sample.discrete, sample.discreteWeight, weight);
        pdf = select(sample.discrete, sample.discreteProbability, pdf);
        slot = select(sample.discrete, gatherSlot<W>(c->slotOfLobe, sample.discreteLobe), slot);
      }
      valid = valid & (maxComponent(weight) > F(0.f)) & isFinite(weight) & (pdf > F(0.f));
      sample.wi.store(a->wi, i);
      zeroUnless(valid, weight).store(a->weight, i);
      zeroUnless(valid, pdf).store(a->pdf + i);
      if (a->pdfReverse) zeroUnless(valid, select(sample.discrete, pdf, sum.pdfReverse)).store(a->pdfReverse + i);
      select(valid, slot, Int<W>(kNoLobe)).store(a->slot + i);
      const Mask<W> through = dot(sample.wi, s.Ng) < F(0.f);
      (select(sample.discrete, Int<W>(uint32_t(kSampleDiscrete)), Int<W>(0)) |
       select(through, Int<W>(uint32_t(kSampleTransmit)), Int<W>(0)) |
       select(sample.below, Int<W>(uint32_t(kSampleBelow)), Int<W>(0)) |
       select(sample.once, Int<W>(uint32_t(kSampleOnce)), Int<W>(0)) |
       select(sample.straight, Int<W>(uint32_t(kSampleStraight)), Int<W>(0)) |
       select(sample.below, sample.medium.template shl<kSampleMediumShift>(), Int<W>(0)))
          .store(a->flags + i);
    }
  }

  template <int W>
  static KN_INLINE Int<W> gatherSlot(const uint8_t* slotOfLobe, Int<W> lobe) {
    alignas(64) int32_t l[W];
    lobe.store(l);
    for (int i = 0; i < W; ++i) l[i] = slotOfLobe[uint32_t(l[i]) < kMaxLobes ? l[i] : 0];
    return Int<W>::load(l);
  }

  template <int W>
  static void emission(const Context* c, const void* closure, float* const rgb[3]) {
    if constexpr (requires { typename B::template HasEmission<W>; }) {
      for (uint32_t i = 0; i < c->count; i += W)
        B::template emission<W>(*static_cast<const Closure*>(closure), At{i, false}).store(rgb, i);
    }
  }
  template <int W>
  static void albedo(const Context* c, const void* closure, float* const rgb[3]) {
    for (uint32_t i = 0; i < c->count; i += W) {
      const Surface<W> s(*c, At{i, false});
      const typename B::template Lanes<W> lanes(*static_cast<const Closure*>(closure), s);
      lanes.albedo().store(rgb, i);
    }
  }

  template <int W>
  static constexpr BxdfFunctions table() {
    BxdfFunctions f{};
    f.begin = &begin;
    f.generate = &generate<W>;
    f.evaluate = &evaluate<W>;
    f.evaluateAt = &evaluateAt<W>;
    f.albedo = &albedo<W>;
    if constexpr (requires { typename B::template HasEmission<W>; }) f.emission = &emission<W>;
    if constexpr (requires { &B::presence; }) f.presence = &B::presence;
    if constexpr (requires { &B::interior; }) f.interior = &B::interior;
    if constexpr (requires { &B::subsurface; }) f.subsurface = &B::subsurface;
    if constexpr (requires { &B::template thinShadow<W>; }) f.thinShadow = &B::template thinShadow<W>;
    if constexpr (requires { &B::medium; }) f.medium = &B::medium;
    if constexpr (requires { &B::template interface<W>; }) {
      f.interface = &B::template interface<W>;
      f.interfaceValue = &B::template interfaceValue<W>;
    }
    return f;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif

#include <kinora/simd/tables.h>

// Ends the file of a plug-in, whose struct has its name.
#undef KINORA_BXDF
#define KINORA_BXDF(Name, ...) KINORA_PLUGIN(Name, BxdfRunner<Name>, BxdfPlugin, __VA_ARGS__)
