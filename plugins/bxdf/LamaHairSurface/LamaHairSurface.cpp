// LamaHairSurface: the root of a material in which hair is layered, mixed or summed. The renderer (shade/layered_bxdfs) makes one
// node of this plug-in of a tree of LamaLayer, LamaMix and LamaAdd over LamaHairChiang, LamaDiffuse, LamaTranslucent and
// coats of LamaDielectric: `structure` is the tree in postfix order, as in LamaSurface. It stands apart from that because
// a material of hair is a fibre (kBxdfFiber), which a plug-in is or is not, and because lobes of all slabs beside those of
// hair are more than a bxdf has.
//
// What is returned is the sum of the leaves by their shares. Under a layer's top a leaf has what that lets through: of a
// coat what it does not reflect, of all others nothing. (Of what enters hair, its own values hold what goes through.)
// Unlike in LamaSurface only the way in counts, as hair counts its own surface: light paths take the adjoint, by which
// both are one over the fibre's width. Directions are made by a leaf chosen by the energy that it returns, and then as
// that leaf makes them.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaHairSurface/LamaHairSurface.cpp"
#include <kinora/bxdf_author.h>

#include <string_view>

#include "plugins/bxdf/hair/chiang.h"
#include "plugins/bxdf/hair/coat.h"
#include "plugins/bxdf/lama/bind.h"
#include "plugins/bxdf/lobes/diffuse.h"

KINORA_KERNELS_BEGIN

constexpr uint32_t kMostLeaves = 4, kMostOps = kMostLeaves - 1;
// Coat: by its index, or by its reflectance face on.
enum : char { kHair = 'I', kDiffuse = 'D', kTranslucent = 'T', kCoat = 'R', kArtisticCoat = 'r', kNothing = 'E' };
enum : char { kLayer = 'L', kMix = 'M', kSum = 'P' };

enum : uint32_t { kPresence, kStructure, kShadowColor, kLobeName1, kLobeName2, kFirstLeaf };
// Of a leaf: those of hair::ChiangClosure, and these.
enum : uint32_t { kColor = hair::kChiangParams, kRoughness, kThrough, kCoatIor, kLobes, kLeafSize };
#define LEAF(n)                                                                                          \
  KINORA_HAIR_CHIANG_PARAMS("leaf" #n "_", "Leaf " #n ", hair. "),                                       \
      param::color("leaf" #n "_color", 0.5f)                                                             \
          .help("Leaf " #n ", diffuse or translucent: its colour; coat: tint of what it reflects."),     \
      param::number("leaf" #n "_roughness", 0.f).help("Leaf " #n ", diffuse or coat: its roughness."),   \
      param::color("leaf" #n "_through", 1.f).help("Leaf " #n ", coat: tint of what reaches its base."), \
      param::number("leaf" #n "_coatIOR", 1.5f)                                                          \
          .range(0, 3)                                                                                   \
          .help("Leaf " #n ", coat: index of refraction (R), or reflectance seen face on (r)."),         \
      param::integer("leaf" #n "_lobes", 0)                                                              \
          .range(0, 2)                                                                                   \
          .help("Leaf " #n ": its lobes are named by lobeName1, lobeName2; 0: HairSpecularR, Diffuse ...")
#define OP(n)                                                                                      \
  param::number("op" #n "_amount", 0.5f)                                                           \
      .help("Operation " #n ": visibility of the top, mix, or the weight of the first of a sum."), \
      param::number("op" #n "_other", 1.f).help("Operation " #n ": weight of the second of a sum.")
constexpr Param kParams[] = {
    param::number("presence", 1.f).help("Existence of the surface: 0 is a hole."),
    param::string("structure", "I")
        .options("I|IIM|IDP|ITMEM|IIMDP|IRL|IDMrLIL")
        .help("The tree in postfix order, made from what is connected. Leaves: I hair, D diffuse, T translucent, R "
              "or r a coat, E nothing. L: layer (the base first), M: mix, P: sum."),
    KINORA_LAMA_SHADOW_COLOR,
    param::string("lobeName1", "").help("Name in light path expressions of the lobes of some leaves."),
    param::string("lobeName2", "").help("The same of others."),
    LEAF(1),
    LEAF(2),
    LEAF(3),
    LEAF(4),
    OP(1),
    OP(2),
    OP(3)};
#undef LEAF
#undef OP
constexpr uint32_t kFirstOp = kFirstLeaf + kMostLeaves * kLeafSize;
static_assert(std::size(kParams) == kFirstOp + 2 * kMostOps);

// By set of names. Hair scatters to both sides of the surface; one follows the other.
#define LOBES(P)                                                                                  \
  {P "HairSpecularR", kLobeSpecular}, {P "HairSpecularR", kLobeSpecular | kLobeTransmit},         \
      {P "HairSpecularTT", kLobeSpecular}, {P "HairSpecularTT", kLobeSpecular | kLobeTransmit},   \
      {P "HairSpecularTRT", kLobeSpecular}, {P "HairSpecularTRT", kLobeSpecular | kLobeTransmit}, \
      {P "Diffuse", kLobeDiffuse}, {                                                              \
    P "Diffuse", kLobeDiffuse | kLobeTransmit                                                     \
  }
constexpr LobeDecl kTreeLobes[] = {LOBES(""), LOBES("=lobeName1:"), LOBES("=lobeName2:")};
#undef LOBES
constexpr uint32_t kLobesOfSet = 8, kDiffuseLobe = 6, kTranslucentLobe = 7;
static_assert(std::size(kTreeLobes) == 3 * kLobesOfSet && std::size(kTreeLobes) <= kMaxLobes);

#define WHITE(n) "leaf" #n "_colorTT=1 1 1; leaf" #n "_color=1 1 1; "
constexpr const char* kLossless[] = {
    WHITE(1) "structure=I",
    WHITE(1) WHITE(2) "structure=IIM; op1_amount=0.3; leaf2_azimuthalRoughness=0.8; leaf2_offset=-3",
    WHITE(1) WHITE(2) WHITE(3) "structure=IIMIM; op1_amount=0.4; op2_amount=0.25; leaf1_azimuthalRoughness=0.7",
    WHITE(1) WHITE(2) "structure=IIP; op1_amount=0.75; op1_other=0.25",
    WHITE(1) WHITE(2) "structure=IRL; op1_amount=1; leaf2_roughness=0.5; leaf2_coatIOR=1.8",
    WHITE(1) WHITE(2)
        WHITE(3) "structure=IrLIM; op1_amount=0.7; op2_amount=0.5; leaf2_coatIOR=0.2; leaf2_roughness=0.2",
    nullptr};
constexpr const char* kConserving[] = {WHITE(1) WHITE(2) "structure=IDP; op1_amount=1; op1_other=1",
                                       WHITE(1) WHITE(2) WHITE(3) "structure=IDMTM; op1_amount=0.4; op2_amount=0.25",
                                       WHITE(1) WHITE(2) WHITE(3) "structure=IEMTP; op1_amount=0.5",
                                       WHITE(1) WHITE(2) WHITE(3) WHITE(4)
                                       "structure=IDMRLIL; op1_amount=0.5; op2_amount=0.8; op3_amount=0.3; "
                                       "leaf3_roughness=0.8; leaf3_color=0.9 0.5 0.2; leaf3_through=0.5 0.9 0.9",
                                       nullptr};
#undef WHITE

struct LamaHairSurface {
  struct Leaf {
    char kind = kNothing;
    uint32_t lobes = 0;  // where those of its name begin
    hair::ChiangClosure hair;
    hair::CoatClosure coat;
    Value color, roughness;
    bool isCoat() const { return kind == kCoat || kind == kArtisticCoat; }
    bool isColored() const { return kind == kDiffuse || kind == kTranslucent; }
  };
  struct Op {
    char kind = kMix;
    uint32_t below = 0, above = 0;             // nodes: leaves first, then operations from kMostLeaves on
    uint32_t first = 0, middle = 0, last = 0;  // leaves [first, middle) of below and [middle, last) of above
    Value amount, other;
  };
  struct Closure {
    uint32_t leafCount = 0, opCount = 0;
    Leaf leaves[kMostLeaves];
    Op ops[kMostOps];
    bool isLayered = false, adjoint = false;
    hair::FiberPlace place;
  };

  static void begin(const Context& c, Closure& k) {
    k.place.bind(c);
    k.adjoint = c.traits & kTraitLightPath;
    struct Node {
      uint32_t node, first, last;
    } open[kMostLeaves];
    uint32_t count = 0;
    bool sound = true;
    for (const char letter : std::string_view(c.fn->text(&c, kStructure))) {
      if (letter == kLayer || letter == kMix || letter == kSum) {
        sound = sound && count > 1 && k.opCount < kMostOps;
        if (!sound) break;
        const Node above = open[--count], below = open[--count];
        const uint32_t first = kFirstOp + 2 * k.opCount;
        k.ops[k.opCount] = {letter,     below.node, above.node,     below.first,
                            below.last, above.last, c.param(first), c.param(first + 1)};
        open[count++] = {kMostLeaves + k.opCount++, below.first, above.last};
        k.isLayered = k.isLayered || letter == kLayer;
      } else {
        sound =
            sound && k.leafCount < kMostLeaves && std::string_view("IDTRrE").find(letter) != std::string_view::npos;
        if (!sound) break;
        bindLeaf(c, k, letter);
        open[count++] = {k.leafCount - 1, k.leafCount - 1, k.leafCount};
      }
    }
    if (sound && count == 1) return;
    // written by hand and no tree
    k.leafCount = k.opCount = 0;
    k.isLayered = false;
    bindLeaf(c, k, kHair);
  }
  static void bindLeaf(const Context& c, Closure& k, char kind) {
    const uint32_t first = kFirstLeaf + kLeafSize * k.leafCount;
    Leaf& leaf = k.leaves[k.leafCount++];
    leaf.kind = kind;
    const float name = c.param(first + kLobes).data[0][0];
    leaf.lobes = (name == 1 ? 1u : name == 2 ? 2u : 0u) * kLobesOfSet;
    if (kind == kHair) leaf.hair.bind(c, first);
    leaf.color = c.param(first + kColor);
    leaf.roughness = c.param(first + kRoughness);
    leaf.coat = {k.adjoint,      kind == kArtisticCoat,    leaf.color, c.param(first + kThrough),
                 leaf.roughness, c.param(first + kCoatIor)};
  }
  static void presence(const Context* c, float* out) { copyFloat(c->param(kPresence), c->padded, out); }

  template <int W>
  struct Lanes {
    using F = Float<W>;
    // What of the tree a direction sees that light is asked from, whichever of the two that is.
    struct Side {
      Rgb<W> rest[kMostLeaves];  // of a leaf: its share of the tree, less what layers above it take
      F seen[kMostLeaves];       // its mean
      KN_INLINE Side() {}
    };
    const Closure& k;
    Vec3<W> N, Ng, wo;
    FiberFrame<W> frame;
    ChiangFiber<W> fibers[kMostLeaves];
    FiberCoat<W> coats[kMostLeaves];
    Rgb<W> color[kMostLeaves];
    RoughDiffuse<W> rough[kMostLeaves];
    F gain[kMostLeaves];    // share of the tree, before layers take theirs
    F amount[kMostOps];     // of layers and mixes
    F weight[kMostLeaves];  // energy that comes back from wo
    F total;
    Side own;

    HWY_ATTR HWY_NOINLINE Lanes(const Closure& closure, const Surface<W>& s)
        : k(closure), N(s.N), Ng(s.Ng), wo(s.wo), frame(k.place, s) {
      const F none(0.f);
      for (uint32_t i = 0; i < kMostLeaves; ++i) gain[i] = weight[i] = none;
      for (uint32_t i = 0; i < k.leafCount; ++i) {
        const Leaf& leaf = k.leaves[i];
        gain[i] = F(1.f);
        if (leaf.kind == kHair) fibers[i] = ChiangFiber<W>(leaf.hair, s);
        if (leaf.isCoat()) coats[i] = FiberCoat<W>(leaf.coat, frame, s);
        if (leaf.isColored()) color[i] = loadRgb<W>(leaf.color, s.at);
        if (leaf.kind == kDiffuse) rough[i] = RoughDiffuse<W>(loadFloat<W>(leaf.roughness, s.at));
      }
      share(s.at);
      own = sideOf(frame.outgoing, frame.gamma);
      total = none;
      for (uint32_t i = 0; i < k.leafCount; ++i) {
        const Leaf& leaf = k.leaves[i];
        if (leaf.kind == kHair) weight[i] = own.seen[i] * fibers[i].own.total;
        if (leaf.isCoat()) weight[i] = own.seen[i] * coats[i].own.total;
        if (leaf.isColored()) weight[i] = own.seen[i] * max(average(color[i]), none);
        total += weight[i];
      }
    }
    HWY_ATTR HWY_NOINLINE Side sideOf(const Inclination<W>& o, F normal) const {
      Side side;
      for (uint32_t i = 0; i < k.leafCount; ++i) {
        side.rest[i] = Rgb<W>(gain[i], gain[i], gain[i]);
        side.seen[i] = gain[i];
      }
      if (!k.isLayered) return side;
      const F none(0.f), one(1.f);
      const auto complement = [&](Rgb<W> a) {
        return Rgb<W>(clamp(one - a.x, none, one), clamp(one - a.y, none, one), clamp(one - a.z, none, one));
      };
      Rgb<W> keep[kMostLeaves + kMostOps];  // what a node lets through; hair and diffuse slabs nothing
      for (uint32_t i = 0; i < k.leafCount; ++i) {
        if (k.leaves[i].kind == kNothing) keep[i] = Rgb<W>(1.f);
        if (k.leaves[i].isCoat()) keep[i] = coats[i].passes(coats[i].sideOf(o, normal));
      }
      for (uint32_t i = 0; i < k.opCount; ++i) {
        const Op& op = k.ops[i];
        const Rgb<W> below = keep[op.below], above = keep[op.above];
        Rgb<W>& both = keep[kMostLeaves + i];
        if (op.kind == kMix) {
          both = lerp(below, above, amount[i]);
        } else if (op.kind == kSum) {
          both = complement(complement(below) + complement(above));
        } else {
          const Rgb<W> under = lerp(Rgb<W>(1.f), above, amount[i]);
          both = below * under;
          for (uint32_t l = op.first; l < op.middle; ++l) side.rest[l] = side.rest[l] * under;
        }
      }
      for (uint32_t i = 0; i < k.leafCount; ++i) side.seen[i] = average(side.rest[i]);
      return side;
    }
    // Shares of the leaves by mixes, by the visibility of tops, and by sums, which are scaled down where they would return
    // more than arrives. bound: what a node returns at most.
    KN_INLINE void share(At at) {
      const F none(0.f), one(1.f);
      F bound[kMostLeaves + kMostOps];
      for (uint32_t i = 0; i < k.leafCount; ++i) {
        const char kind = k.leaves[i].kind;
        bound[i] = kind == kNothing ? none : k.leaves[i].isColored() ? clamp(maxComponent(color[i]), none, one) : one;
      }
      for (uint32_t i = 0; i < k.opCount; ++i) {
        const Op& op = k.ops[i];
        F below = max(loadFloat<W>(op.amount, at), none), above;
        amount[i] = min(below, one);
        if (op.kind == kMix) {
          above = amount[i];
          below = one - above;
        } else if (op.kind == kLayer) {
          // what the base gets is found by direction
          above = amount[i];
          below = one;
          bound[kMostLeaves + i] = min(fma(above, bound[op.above], bound[op.below]), one);
          for (uint32_t l = op.middle; l < op.last; ++l) gain[l] = gain[l] * above;
          continue;
        } else {
          above = max(loadFloat<W>(op.other, at), none);
        }
        const F sum = fma(below, bound[op.below], above * bound[op.above]), scale = one / max(sum, one);
        bound[kMostLeaves + i] = min(sum, one);
        for (uint32_t l = op.first; l < op.last; ++l) gain[l] = gain[l] * (l < op.middle ? below : above) * scale;
      }
    }

    HWY_ATTR HWY_NOINLINE void evaluate(const Vec3<W>& wi, LobeSum<W>& out) const {
      const F none(0.f), side = dot(Ng, wi), muO = max(dot(N, wo), none), muI = dot(N, wi);
      F sum(0.f), back(0.f), backTotal(0.f);
      // The way back comes in at the offset that is mirrored at the fibre: the normal there is as far about the fibre from
      // wo as this one is from wi, and the cosines differ by those of the inclinations.
      F phi;
      const Inclination<W> arriving = frame.inclinationOf(wi, phi);
      const F wayBack = frame.outgoing.c / max(arriving.c, F(1e-3f));
      Side other;
      const bool isBack = out.wantsReverse || k.adjoint;
      if (isBack) other = sideOf(arriving, -frame.gamma);
      const Side& lit = k.adjoint ? other : own;
      for (uint32_t i = 0; i < k.leafCount; ++i) {
        const Leaf& leaf = k.leaves[i];
        if (leaf.kind == kNothing) continue;
        if (leaf.kind == kHair || leaf.isCoat()) {
          FiberDensity<W> forward, reverse;
          if (leaf.kind == kHair)
            evaluateFiber(fibers[i], wi, lit.rest[i], leaf.lobes, out, forward, reverse);
          else
            evaluateFiber(coats[i], wi, lit.rest[i], leaf.lobes, out, forward, reverse);
          sum = fma(own.seen[i], forward.sum, sum);
          if (!isBack) continue;
          back = fma(other.seen[i], reverse.sum, back);
          backTotal = fma(other.seen[i], reverse.total, backTotal);
          continue;
        }
        const bool isThrough = leaf.kind == kTranslucent;
        const Mask<W> here = isThrough ? (side < none) & (muI < none) : (side > none) & (muI > none);
        const F cosine = abs(muI);
        const Rgb<W> f = isThrough ? color[i] * F(kInvPi) : rough[i].evaluate(color[i], muO, cosine, dot(wo, wi));
        out.add(leaf.lobes + (isThrough ? kTranslucentLobe : kDiffuseLobe),
                zeroUnless(here, f * (lit.rest[i] * cosine)));
        sum += zeroUnless(here, weight[i] * (cosine * F(kInvPi)));
        if (!isBack) continue;
        const F energy = other.seen[i] * max(average(color[i]), none);
        back += zeroUnless(here, energy * (cosine * wayBack * F(kInvPi)));
        backTotal += energy;
      }
      out.pdf = sum / max(total, F(1e-30f));
      out.pdfReverse = back / max(backTotal, F(1e-30f));
    }

    HWY_ATTR HWY_NOINLINE void sample(const F& u, const F& v, const F& w, LobeSample<W>& out) const {
      const F none(0.f);
      const ChosenTechnique<W> chosen(weight, total, w);
      const Vec3<W> up = cosineHemisphere(u, v);
      const Frame<W> upright(N);
      Vec3<W> wi = N;
      Mask<W> valid = chosen.found;
      for (uint32_t i = 0; i < k.leafCount; ++i) {
        const Mask<W> mine = chosen.found & (chosen.which == Int<W>(i));
        const char kind = k.leaves[i].kind;
        if (kind == kNothing || mine.none()) continue;
        if (kind == kHair || k.leaves[i].isCoat()) {
          LobeSample<W> made;
          if (kind == kHair)
            fibers[i].sample(u, v, chosen.rest, made);
          else
            coats[i].sample(u, v, chosen.rest, made);
          wi = select(mine, made.wi, wi);
          valid = valid & ((!mine) | made.valid);
          continue;
        }
        const bool isThrough = kind == kTranslucent;
        const Vec3<W> d = normalize(upright.toWorld(Vec3<W>(up.x, up.y, isThrough ? -up.z : up.z)));
        const F side = dot(Ng, d);
        wi = select(mine, d, wi);
        // what ends on the wrong side of the geometric surface is lost
        valid = valid & ((!mine) | (isThrough ? side < none : side > none));
      }
      out.wi = wi;
      out.valid = valid;
      out.discrete = Mask<W>(false);
      out.below = Mask<W>(false);
    }

    KN_INLINE Rgb<W> albedo() const {
      Rgb<W> sum;
      for (uint32_t i = 0; i < k.leafCount; ++i) {
        const Leaf& leaf = k.leaves[i];
        if (leaf.kind == kHair) sum += fibers[i].albedo() * own.rest[i];
        if (leaf.isCoat()) sum += coats[i].albedo() * own.rest[i];
        if (leaf.isColored()) sum += color[i] * own.rest[i];
      }
      return sum;
    }
  };
};

KINORA_KERNELS_END

KINORA_BXDF(LamaHairSurface,
            .help =
                "The root of a material in which LamaLayer, LamaMix and LamaAdd combine hair, with diffuse slabs "
                "and coats too.",
            .params = kParams, .lobes = kTreeLobes, .presenceParam = kPresence, .lossless = kLossless,
            .conserving = kConserving, .flags = kBxdfNotReciprocal | kBxdfFiber)
