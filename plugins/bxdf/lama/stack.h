// A tree of slabs at W points: leaves mixed into one density, each in its share and attenuated by the layers above.
// What a layer lets through to its base is 1 less its top's directional albedo, the lesser of the two directions',
// which is reciprocal and never gains. Tops that are opaque (diffuse, conductor) let through nothing. Weights of sums
// are scaled down where they would return more than arrives. The leaves' formulas are those of plugins/bxdf/lobes and
// of sheen.h here and burley.h of the lobes. Included per target, by stack.cpp alone.
#include <kinora/bxdf_author.h>
#include <kinora/math/microfacet.h>
#include <iterator>
#include "closure.h"
#include "plugins/bxdf/lobes/bump_shadowing.h"
#include "plugins/bxdf/lobes/burley.h"
#include "sheen.h"
#include "plugins/bxdf/lobes/diffuse.h"
#include "plugins/bxdf/lobes/pick.h"
#include "plugins/bxdf/lobes/specular.h"
#include "plugins/bxdf/lobes/glass.h"

#if defined(KINORA_LAMA_STACK_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LAMA_STACK_H_TARGET
#undef KINORA_LAMA_STACK_H_TARGET
#else
#define KINORA_LAMA_STACK_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

// Ways in which a leaf makes a direction: a diffuse leaf has the first, facets have one for single scattering and one
// for what that loses, glass has all.
constexpr uint32_t kWays = 4;
// Of subsurface: below the surface, or diffuse reflection instead.
constexpr uint32_t kWayBelow = 0, kWayStandIn = 1;

template <int W>
struct LeafLanes {
  Vec3<W> normal;
  Rgb<W> color, through;
  Float<W> gain;  // its share of the tree, before layers take theirs
  // Of the kinds that a leaf is not, nothing is even cleared: an unnamed union runs no constructor.
  union {
    SpecularLobe<W> specular;
  };
  union {
    GlassLobe<W> glass;
  };
  union {
    RoughDiffuse<W> rough;
  };
  union {
    SheenLobe<W> sheen;
  };
  union {
    Frame<W> frame;
  };
  Float<W> roughness;
  // Translucent: its selection weight, and the share that crosses from wo's side and from behind.
  Float<W> mean, across[2];
  Mask<W> sinks;  // subsurface: paths go below
  KN_INLINE LeafLanes() {}
};

// What the tree needs to know of one direction, whichever role it has.
template <int W>
struct SlabView {
  Float<W> mu[lama::kMaxLeaves], energy[lama::kMaxLeaves];
  GlassShares<W> glass[lama::kMaxLeaves];
  Rgb<W> under[lama::kMaxOps];  // of layers: what the base gets
  Float<W> weight[lama::kMaxLeaves][kWays], scale;
  KN_INLINE SlabView() {}
};

// The Lanes of bxdf_author.h.
template <int W>
struct SlabTree {
  using F = Float<W>;
  const lama::Closure& k;
  Vec3<W> Ng, wo, smooth;  // smooth: the surface's own normal
  LeafLanes<W> leaves[lama::kMaxLeaves];
  F amount[lama::kMaxOps];  // of layers and mixes
  SlabView<W> viewO;

  HWY_ATTR HWY_NOINLINE SlabTree(const lama::Closure& closure, const Surface<W>& s)
      : k(closure), Ng(s.Ng), wo(s.wo), smooth(s.N) {
    const F none(0.f), one(1.f);
    Vec3<W> normals[std::size(decltype(k.normals){})];
    for (int i = 0; i < k.normalCount; ++i) normals[i] = bumpedNormal<W>(k.normals[i], s);
    for (uint32_t i = 0; i < k.leafCount; ++i) {
      const lama::Leaf& leaf = k.leaves[i];
      LeafLanes<W>& l = leaves[i];
      l.normal = leaf.bump < 0 ? s.N : normals[leaf.bump];
      l.gain = one;
      l.color = loadRgb<W>(leaf.color, s.at);
      if (leaf.covers) l.through = leaf.through.components ? loadRgb<W>(leaf.through, s.at) : Rgb<W>(1.f);
      if (leaf.isSpecular()) l.specular.set(leaf.specular, *k.reflectionEnergy, l.normal, s);
      if (leaf.kind == lama::kKindGlass)
        l.glass.set(leaf.glass, leaf.glassEnergy, k.reflectionEnergy, k.radiance, l.normal, s);
      if (leaf.kind == lama::kKindDiffuse) l.rough = RoughDiffuse<W>(loadFloat<W>(leaf.roughness, s.at));
      if (leaf.kind == lama::kKindBurley) {
        l.roughness = clamp(loadFloat<W>(leaf.roughness, s.at), none, one);
        l.through = loadRgb<W>(leaf.through, s.at);
      }
      if (leaf.kind == lama::kKindSubsurface) {
        const lobes::SubsurfaceClosure& x = k.below[leaf.medium];
        F length = loadFloat<W>(x.reach, s.at);
        if (x.shortReach.components) {  // a part that gives nothing reaches nowhere
          const auto of = [&](const Value& gain, const Value& reach) {
            return zeroUnless(loadFloat<W>(gain, s.at) > none, loadFloat<W>(reach, s.at));
          };
          length = max(of(x.gain, x.reach), max(of(x.shortGain, x.shortReach), of(x.longGain, x.longReach)));
        }
        const F reach = maxComponent(loadRgb<W>(x.reachColor, s.at)) * length * F(x.unit);
        l.sinks = s.sinks(reach, one);
      }
      if (leaf.kind == lama::kKindSheen) {
        l.sheen = SheenLobe<W>(k.sheen, loadFloat<W>(leaf.roughness, s.at));
        l.frame = Frame<W>(l.normal);
      }
    }
    for (uint32_t i = 0; i < k.leafCount; ++i) {
      if (k.leaves[i].kind != lama::kKindTranslucent) continue;
      LeafLanes<W>& l = leaves[i];
      l.mean = max(average(l.color), none);
      l.across[0] = l.across[1] = one;
      if (k.glass < 0) continue;
      // Where the surface bounds a medium: as n^2 times the share is the same from both sides, less leaves the denser.
      const GlassLobe<W>& g = leaves[k.glass].glass;
      const F e2 = g.eta * g.eta;
      l.across[0] = select(g.encloses, min(one / e2, one), one);
      l.across[1] = select(g.encloses, min(e2, one), one);
      l.color = l.color * (l.across[0] * select(g.encloses, g.radianceScale, one));
    }
    share(s.at);
    look(wo, Mask<W>(false), viewO);
  }

  HWY_ATTR HWY_NOINLINE void evaluate(const Vec3<W>& wi, LobeSum<W>& out) const {
    const F none(0.f), side = dot(Ng, wi);
    const Mask<W> above = side > none, below = side < none;
    SlabView<W> viewI;
    look(wi, below, viewI);
    F pdf(0.f), reverse(0.f);
    const auto add = [&](Mask<W> here, uint32_t leaf, uint32_t way, F p, F r) {
      pdf += zeroUnless(here, viewO.weight[leaf][way] * p);
      reverse += zeroUnless(here, viewI.weight[leaf][way] * r);
    };
    for (uint32_t i = 0; i < k.leafCount; ++i) {
      const lama::Leaf& leaf = k.leaves[i];
      if (leaf.kind == lama::kKindEmission) continue;
      const LeafLanes<W>& l = leaves[i];
      Rgb<W> rest = remaining(i, viewI);
      if (leaf.softens && leaf.kind != lama::kKindGlass && leaf.kind != lama::kKindTranslucent)
        rest = rest * bumpShadowing<W>(smooth, l.normal, k.radiance ? wi : wo);
      if (leaf.isSpecular()) {
        const Vec3<W> w = l.specular.frame.toLocal(wi);
        const Mask<W> here = above & (w.z > none) & !l.specular.smooth;
        if (here.none()) continue;
        F p, r;
        const Rgb<W> f = l.specular.evaluate(w, viewO.energy[i], viewI.energy[i], p, r);
        out.add(leaf.lobes + lama::kSpecular, zeroUnless(here, f * rest));
        add(here, i, 0, p, r);
        add(here, i, 1, F(kInvTwoPi), F(kInvTwoPi));
        continue;
      }
      if (leaf.kind == lama::kKindGlass) {
        const Vec3<W> w = l.glass.frame.toLocal(wi);
        const Mask<W> up = above & (w.z > none), down = below & (w.z < none);
        const F cosine = abs(w.z);
        GlassPdfs<W> p;
        if (up.any()) {
          const F one = l.glass.evaluateReflect(w, p);
          const F f = fma(l.glass.multipleReflected(viewO.glass[i].lost, viewI.glass[i].lost), cosine, one);
          out.add(leaf.lobes + lama::kSpecular,
                  zeroUnless(up, rest * l.glass.reflectTint * (f * l.glass.reflectGain)));
          add(up, i, 0, p.first, p.firstReverse);
          add(up, i, 1, p.second, p.secondReverse);
          add(up, i, 2, F(kInvTwoPi), F(kInvTwoPi));
        }
        if (down.any()) {
          const F one = l.glass.evaluateTransmit(w, p);
          const F f = fma(l.glass.multipleTransmitted(viewO.glass[i].lost, viewI.glass[i].lost), cosine, one);
          out.add(leaf.lobes + lama::kTransmit,
                  zeroUnless(down, rest * l.glass.transmitColor * (f * l.glass.radianceScale)));
          add(down, i, 0, p.first, p.firstReverse);
          add(down, i, 1, p.second, p.secondReverse);
          add(down, i, 3, F(kInvTwoPi), F(kInvTwoPi));
        }
        continue;
      }
      const F muO = max(dot(l.normal, wo), none), muI = dot(l.normal, wi);
      if (leaf.kind == lama::kKindTranslucent) {
        const Mask<W> here = below & (muI < none);
        out.add(leaf.lobes + lama::kDiffuseTransmit, zeroUnless(here, rest * l.color * (-muI * F(kInvPi))));
        add(here, i, 0, -muI * F(kInvPi), muO * F(kInvPi));
        continue;
      }
      const Mask<W> here = above & (muI > none);
      if (leaf.kind == lama::kKindSubsurface) {
        out.add(leaf.lobes + lama::kSubsurfaceReflect,
                zeroUnless(here & !l.sinks, rest * l.color * (muI * F(kInvPi))));
        add(here, i, kWayStandIn, muI * F(kInvPi), muO * F(kInvPi));
        continue;
      }
      if (leaf.kind == lama::kKindSheen) {
        const Vec3<W> o = localOut(l.frame, wo), w = l.frame.toLocal(wi);
        out.add(leaf.lobes + lama::kSheen, zeroUnless(here, rest * l.color * (l.sheen.evaluate(o, w) * muI)));
        add(here, i, 0, F(kInvTwoPi), F(kInvTwoPi));
        continue;
      }
      Rgb<W> f;
      if (leaf.kind == lama::kKindBurley)
        f = l.color * burleyDiffuse(l.roughness, muO, muI, max(dot(wo, wi) + F(1.f), F(0.f))) +
            l.through * schlickWeight(safeSqrt(fma(dot(wo, wi), F(0.5f), F(0.5f))));
      else
        f = l.rough.evaluate(l.color, muO, muI, dot(wo, wi));
      out.add(leaf.lobes + lama::kDiffuse, zeroUnless(here, rest * f * muI));
      add(here, i, 0, muI * F(kInvPi), muO * F(kInvPi));
    }
    out.pdf = pdf * viewO.scale;
    out.pdfReverse = reverse * viewI.scale;
  }

  HWY_ATTR HWY_NOINLINE void sample(const F& u, const F& v, const F& w, LobeSample<W>& out) const {
    const F none(0.f), one(1.f);
    Pick<W> pick(w, viewO.scale, lama::kMaxLeaves * kWays);
    for (uint32_t i = 0; i < k.leafCount; ++i)
      for (uint32_t t = 0; t < kWays; ++t) pick.offer(i * kWays + t, viewO.weight[i][t]);
    const Int<W> made = pick.made;
    const F share = pick.weight, rest = pick.rest;
    Vec3<W> d = cosineHemisphere(u, v);
    // uniform, by the same disk
    const F r2 = fma(d.x, d.x, d.y * d.y), stretch = sqrt(max(F(2.f) - r2, none));
    const Vec3<W> uniform(d.x * stretch, d.y * stretch, max(one - r2, none));
    Frame<W> frame(Ng);
    Mask<W> valid(true), through(false), discrete(false);
    Rgb<W> discreteWeight;
    Int<W> discreteLobe(uint32_t(lama::kSpecular));
    for (uint32_t i = 0; i < k.leafCount; ++i) {
      const lama::Leaf& leaf = k.leaves[i];
      const LeafLanes<W>& l = leaves[i];
      const Mask<W> mine = (made >= Int<W>(i * kWays)) & (made < Int<W>((i + 1) * kWays));
      if (mine.none()) continue;
      const auto is = [&](uint32_t way) { return made == Int<W>(i * kWays + way); };
      Frame<W> own;
      if (leaf.isSpecular()) {
        own = l.specular.frame;
        const Mask<W> facets = is(0), smooth = facets & l.specular.smooth;
        const Vec3<W> up(none, none, one);
        const Vec3<W> h = select(smooth, up, sampleVisibleNormal(l.specular.wo, l.specular.ax, l.specular.ay, u, v));
        const Vec3<W> r = reflect(l.specular.wo, h);
        d = select(facets, r, select(mine, uniform, d));
        valid = valid & ((!facets) | (r.z > none));
        discrete = discrete | smooth;
        discreteWeight = select(smooth, l.specular.fresnel(l.specular.wo.z), discreteWeight);
        discreteLobe = select(smooth, Int<W>(uint32_t(leaf.lobes + lama::kSpecular)), discreteLobe);
      } else if (leaf.kind == lama::kKindGlass) {
        own = l.glass.frame;
        const Mask<W> first = is(0), second = is(1), facets = first | second, behind = is(3);
        const Mask<W> smooth = (first & l.glass.smoothReflect) | (second & l.glass.smoothTransmit);
        const F ax = select(first, l.glass.axReflect, l.glass.axTransmit);
        const F ay = select(first, l.glass.ayReflect, l.glass.ayTransmit);
        const Vec3<W> h = select(smooth, Vec3<W>(none, none, one), sampleVisibleNormal(l.glass.wo, ax, ay, u, v));
        // a rough facet reflects or refracts by its own Fresnel; what is left of w within its share decides
        const Mask<W> free = facets & l.glass.chooses();
        F chance, other;
        l.glass.chances(l.glass.fresnel(dot(l.glass.wo, h)), chance, other);
        const Mask<W> refracts = (second & !free) | (free & (rest >= chance * max(share, F(1e-30f))));
        Vec3<W> r = reflect(l.glass.wo, h);
        Mask<W> good = r.z > none;
        Vec3<W> t(r.x, r.y, -r.z);
        Mask<W> passes = good;
        if (!leaf.glass.thin) {
          passes = refract(l.glass.wo, h, l.glass.eta, t);
          passes = passes & (t.z < none);
        }
        r = select(refracts, t, r);
        good = (good & !refracts) | (passes & refracts);
        const Vec3<W> lost(uniform.x, uniform.y, select(behind, -uniform.z, uniform.z));
        d = select(facets, r, select(mine, lost, d));
        valid = valid & ((!facets) | good);
        through = through | (mine & (refracts | behind));
        discrete = discrete | smooth;
        if (smooth.any()) {
          const F f = l.glass.fresnel(l.glass.wo.z);
          const Rgb<W> one2 = l.glass.reflectTint * (f * l.glass.reflectGain);
          const Rgb<W> two = l.glass.transmitColor * ((one - f) * l.glass.radianceScale);
          discreteWeight = select(smooth, select(refracts, two, one2), discreteWeight);
          discreteLobe = select(smooth, Int<W>(uint32_t(leaf.lobes + lama::kSpecular)), discreteLobe);
          discreteLobe = select(smooth & refracts, Int<W>(uint32_t(leaf.lobes + lama::kTransmit)), discreteLobe);
        }
      } else {
        own = Frame<W>(l.normal);
        if (leaf.kind == lama::kKindSheen) d = select(mine, uniform, d);
        if (leaf.kind == lama::kKindTranslucent) {
          d.z = select(mine, -d.z, d.z);
          through = through | mine;
        }
        if (leaf.kind == lama::kKindSubsurface) {
          const Mask<W> sinks = is(kWayBelow);
          const Frame<W> plane(Ng);
          own = Frame<W>(select(sinks, plane.x, own.x), select(sinks, plane.y, own.y), select(sinks, plane.z, own.z));
          d.z = select(sinks, -d.z, d.z);
          through = through | sinks;
          discrete = discrete | sinks;
          out.below = out.below | sinks;
          out.medium = select(sinks, Int<W>(uint32_t(leaf.medium)), out.medium);
          discreteWeight = select(sinks, Rgb<W>(1.f), discreteWeight);
          discreteLobe = select(sinks, Int<W>(uint32_t(k.belowLobes + lama::kSubsurface)), discreteLobe);
        }
      }
      frame = Frame<W>(select(mine, own.x, frame.x), select(mine, own.y, frame.y), select(mine, own.z, frame.z));
    }
    out.wi = normalize(frame.toWorld(d));
    // A direction that ends on the wrong side of the geometric surface is lost, even where another leaf could have
    // made it: its maker's density is zero there.
    const F side = dot(Ng, out.wi);
    out.valid = valid & (viewO.scale > none) & ((through & (side < none)) | ((!through) & (side > none)));
    out.discrete = discrete;
    out.discreteProbability = share * viewO.scale;
    out.discreteLobe = discreteLobe;
    if (discrete.any()) {
      SlabView<W> viewI;
      look(out.wi, through, viewI);
      Rgb<W> left(1.f);
      for (uint32_t i = 0; i < k.leafCount; ++i) {
        const Mask<W> mine = (made >= Int<W>(i * kWays)) & (made < Int<W>((i + 1) * kWays));
        if ((mine & discrete).any()) left = select(mine, remaining(i, viewI), left);
      }
      out.discreteWeight = discreteWeight * left;
    }
  }

  // For the denoiser: what the leaves return, macroscopically; layers above are taken off at wo alone.
  HWY_ATTR HWY_NOINLINE Rgb<W> albedo() const {
    Rgb<W> sum;
    for (uint32_t i = 0; i < k.leafCount; ++i) {
      const LeafLanes<W>& l = leaves[i];
      Rgb<W> a = l.color;
      switch (k.leaves[i].kind) {
        case lama::kKindEmission:
          continue;
        case lama::kKindSheen:
          a = a * viewO.energy[i];
          break;
        case lama::kKindGlass: {
          const GlassShares<W>& g = viewO.glass[i];
          const F back = fma(g.lost, F(1.f) - l.glass.multipleTransmit[0], g.reflect);
          a = l.glass.reflectTint * (back * l.glass.reflectGain) +
              l.glass.transmitColor * fma(g.lost, l.glass.multipleTransmit[0], g.transmit);
          break;
        }
        default:
          if (k.leaves[i].isSpecular()) a = l.specular.albedo(viewO.mu[i], viewO.energy[i]);
      }
      sum += a * remaining(i, viewO);
    }
    const F none(0.f), one(1.f);
    return {clamp(sum.x, none, one), clamp(sum.y, none, one), clamp(sum.z, none, one)};
  }
  KN_INLINE Rgb<W> emission() const {
    Rgb<W> sum;
    for (uint32_t i = 0; i < k.leafCount; ++i)
      if (k.leaves[i].kind == lama::kKindEmission) sum += leaves[i].color * remaining(i, viewO);
    return sum;
  }
  // Light that goes straight on through the glass, for tinted shadows; as glassThinShadow().
  KN_INLINE Rgb<W> straight(const Surface<W>& s) const {
    Rgb<W> sum;
    for (uint32_t i = 0; i < k.leafCount; ++i) {
      if (k.leaves[i].kind != lama::kKindGlass) continue;
      const GlassLobe<W>& g = leaves[i].glass;
      const F one(1.f), eta = k.leaves[i].glass.thin ? g.eta : min(g.eta, one / g.eta);
      const F f = fresnelDielectric(min(s.cosO, one), eta);
      sum += g.transmitColor * remaining(i, viewO) * (k.leaves[i].glass.thin ? (one - f) / (one + f) : one - f);
    }
    return sum;
  }

 private:
  // Shares of the leaves by mixes, sums and the visibility of tops. bound: what a node returns at most.
  KN_INLINE void share(At at) {
    const F none(0.f), one(1.f);
    F bound[lama::kMaxLeaves + lama::kMaxOps];
    for (uint32_t i = 0; i < k.leafCount; ++i) {
      const char kind = k.leaves[i].kind;
      const bool coloured =
          kind == lama::kKindDiffuse || kind == lama::kKindTranslucent || kind == lama::kKindSubsurface;
      bound[i] = kind == lama::kKindEmission ? none
                 : coloured                  ? clamp(maxComponent(leaves[i].color), none, one)
                                             : one;
    }
    for (uint32_t i = 0; i < k.opCount; ++i) {
      const lama::Op& op = k.ops[i];
      F below = one, above = one;
      F scale = one;
      F& most = bound[lama::kMaxLeaves + i];
      if (op.kind == lama::kOpAdd) {
        below = max(loadFloat<W>(op.amount, at), none);
        above = max(loadFloat<W>(op.other, at), none);
        const F sum = fma(below, bound[op.below], above * bound[op.above]);
        scale = one / max(sum, one);
        most = min(sum, one);
        amount[i] = one;
      } else {
        const F a = clamp(loadFloat<W>(op.amount, at), none, one);
        amount[i] = a;
        above = a;
        if (op.kind == lama::kOpMix) {
          below = one - a;
          most = lerp(bound[op.below], bound[op.above], a);
        } else {
          most = min(fma(a, bound[op.above], bound[op.below]), one);
        }
      }
      for (uint32_t l = op.first; l < op.last; ++l) {
        const F part = l < op.middle ? below : above;
        leaves[l].gain = leaves[l].gain * (k.leaves[l].kind == lama::kKindEmission ? part : part * scale);
      }
    }
  }
  // d: away from the surface; behind: not on wo's side of it.
  HWY_ATTR HWY_NOINLINE void look(const Vec3<W>& d, const Mask<W>& behind, SlabView<W>& x) const {
    const F none(0.f), one(1.f);
    for (uint32_t i = 0; i < k.leafCount; ++i) {
      const lama::Leaf& leaf = k.leaves[i];
      const LeafLanes<W>& l = leaves[i];
      x.mu[i] = min(abs(dot(leaf.isSpecular() ? l.specular.frame.z : l.normal, d)), one);
      x.energy[i] = none;
      if (leaf.isSpecular()) x.energy[i] = l.specular.energy(x.mu[i], d);
      if (leaf.kind == lama::kKindGlass) x.glass[i] = l.glass.shares(x.mu[i], behind);
      if (leaf.kind == lama::kKindSheen) x.energy[i] = min(l.sheen.albedo(*k.sheen, x.mu[i]), one);
    }
    if (k.layered) layer(x);
    F sum(0.f);
    for (uint32_t i = 0; i < k.leafCount; ++i) {
      const lama::Leaf& leaf = k.leaves[i];
      const LeafLanes<W>& l = leaves[i];
      for (uint32_t t = 0; t < kWays; ++t) x.weight[i][t] = none;
      if (leaf.kind == lama::kKindEmission) continue;
      const F seen = max(average(remaining(i, x, x)), none);
      if (leaf.isSpecular()) {
        x.weight[i][0] = seen * l.specular.weightSingle(x.mu[i], x.energy[i]);
        x.weight[i][1] = seen * l.specular.weightMultiple(x.energy[i]);
      } else if (leaf.kind == lama::kKindGlass) {
        const F through = select(behind, l.glass.multipleTransmit[1], l.glass.multipleTransmit[0]);
        const F reflects = seen * l.glass.reflectGain, passes = seen * l.glass.transmitMean;
        x.weight[i][0] = x.glass[i].reflect * reflects;
        x.weight[i][1] = x.glass[i].transmit * passes;
        x.weight[i][2] = x.glass[i].lost * (one - through) * reflects;
        x.weight[i][3] = x.glass[i].lost * through * passes;
      } else {
        F w = seen * max(average(l.color), none);
        if (leaf.kind == lama::kKindTranslucent) w = seen * l.mean * select(behind, l.across[1], l.across[0]);
        if (leaf.kind == lama::kKindSheen) w = w * x.energy[i];
        // at grazing angles, where it matters, sheen returns about a half
        if (leaf.kind == lama::kKindBurley)
          w = fma(seen * max(average(l.through), none), fma((one - x.mu[i]) * (one - x.mu[i]), F(0.5f), F(0.01f)), w);
        x.weight[i][0] = w;
        if (leaf.kind == lama::kKindSubsurface) {
          // thin parts of dark bodies let through more than they would return
          x.weight[i][kWayBelow] = zeroUnless(l.sinks, max(w, F(0.1f) * seen));
          x.weight[i][kWayStandIn] = zeroUnless(!l.sinks, w);
        }
      }
      for (uint32_t t = 0; t < kWays; ++t) sum += x.weight[i][t];
    }
    x.scale = zeroUnless(sum > none, one / max(sum, F(1e-30f)));
  }
  // What the tops of layers let through.
  KN_INLINE void layer(SlabView<W>& x) const {
    const F none(0.f), one(1.f);
    Rgb<W> keep[lama::kMaxLeaves + lama::kMaxOps];
    const auto rest = [&](Rgb<W> a) {
      return Rgb<W>(clamp(one - a.x, none, one), clamp(one - a.y, none, one), clamp(one - a.z, none, one));
    };
    for (uint32_t i = 0; i < k.leafCount; ++i) {
      keep[i] = Rgb<W>();
      const lama::Leaf& leaf = k.leaves[i];
      if (!leaf.covers) continue;
      const LeafLanes<W>& l = leaves[i];
      if (leaf.kind == lama::kKindEmission) keep[i] = Rgb<W>(1.f);
      if (leaf.kind == lama::kKindSheen) keep[i] = rest(l.color * x.energy[i]);
      if (leaf.isSpecular() && leaf.kind != lama::kKindConductor)
        keep[i] = rest(l.specular.albedo(x.mu[i], x.energy[i])) * l.through;
    }
    for (uint32_t i = 0; i < k.opCount; ++i) {
      const lama::Op& op = k.ops[i];
      const Rgb<W> below = keep[op.below], above = keep[op.above];
      Rgb<W>& both = keep[lama::kMaxLeaves + i];
      x.under[i] = Rgb<W>(1.f);
      if (op.kind == lama::kOpLayer) {
        x.under[i] = lerp(Rgb<W>(1.f), above, amount[i]);
        both = below * x.under[i];
      } else if (op.kind == lama::kOpMix) {
        both = lerp(below, above, amount[i]);
      } else {
        both = rest(rest(below) + rest(above));
      }
    }
  }
  KN_INLINE Rgb<W> remaining(uint32_t leaf, const SlabView<W>& i) const { return remaining(leaf, viewO, i); }
  // A leaf's share, less what layers above take on the way in and out.
  KN_INLINE Rgb<W> remaining(uint32_t leaf, const SlabView<W>& x, const SlabView<W>& y) const {
    const F gain = leaves[leaf].gain;
    Rgb<W> r(gain, gain, gain);
    if (!k.layered) return r;
    for (uint32_t o = 0; o < k.opCount; ++o) {
      const lama::Op& op = k.ops[o];
      if (op.kind != lama::kOpLayer || leaf < op.first || leaf >= op.middle) continue;
      const Rgb<W>&a = x.under[o], &b = y.under[o];
      r = r * Rgb<W>(min(a.x, b.x), min(a.y, b.y), min(a.z, b.z));
    }
    return r;
  }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
