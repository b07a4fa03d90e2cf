// LamaSurface: the root of a layered material. The renderer (shade/layered_bxdfs) turns the tree of LamaLayer, LamaMix,
// LamaAdd and their leaves that is connected here into one node of this plug-in: `structure` is the tree in postfix
// order, and each leaf's values stand in the parameters leaf1_ ... of its turn, each operation's in op1_ ... So trees
// of one structure share a shading program, whatever feeds their values.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaSurface/LamaSurface.cpp"
#include <kinora/bxdf_author.h>
#include <string_view>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kFront,
  kBack,
  kPresence,
  kStructure,
  kShadowColor,
  kLobeName1,
  kLobeName2,
  kAbsorptionColor,
  kAbsorptionRadius,
  kScatterColor,
  kScatterAnisotropy,
  kFirstLeaf
};
enum : uint32_t {  // of a leaf
  kColor,
  kThrough,
  kSecond,
  kThird,
  kRoughness,
  kAnisotropy,
  kDirection,
  kIor,
  kAmount,
  kNormal,
  kRotation,
  kLobes,
  kBumpShadowing,
  kLeafSize
};
#define LEAF(n)                                                                                                     \
  param::color("leaf" #n "_color", 0.5f).help("Leaf " #n ": its colour, or tint of what it reflects."),             \
      param::color("leaf" #n "_through", 1.f).help("Leaf " #n ": tint of what it lets through."),                   \
      param::color("leaf" #n "_second", 0.5f)                                                                       \
          .help("Leaf " #n ": index or reflectivity of a conductor or Schlick's."),                                 \
      param::color("leaf" #n "_third", 1.f)                                                                         \
          .help("Leaf " #n ": extinction or edge colour of a conductor, or reflectivity90."),                       \
      param::number("leaf" #n "_roughness", 0.2f).help("Leaf " #n ": roughness."),                                  \
      param::number("leaf" #n "_anisotropy", 0.f).range(-1, 1).help("Leaf " #n ": anisotropy."),                    \
      param::vector("leaf" #n "_direction", 0, 0, 0).help("Leaf " #n ": direction of anisotropy."),                 \
      param::number("leaf" #n "_ior", 1.5f).range(1, 3).help("Leaf " #n ": index, or reflectivity of kinds r, g."), \
      param::number("leaf" #n "_amount", 0.2f)                                                                      \
          .range(0.1f, 1)                                                                                           \
          .help("Leaf " #n ": profile of Schlick's, thickness of films."),                                          \
      param::normal("leaf" #n "_normal").help("Leaf " #n ": shading normal from a bump pattern."),                  \
      param::number("leaf" #n "_rotation", 0.f).help("Leaf " #n ": turns the direction; 1 is a whole turn."),       \
      param::integer("leaf" #n "_lobes", 0)                                                                         \
          .range(0, 2)                                                                                              \
          .help("Leaf " #n ": its lobes are named by lobeName1, lobeName2; 0: Diffuse, Specular ..."),              \
      param::flag("leaf" #n "_bumpShadowing", true).help("Leaf " #n ": bumpShadowing of it.")
#define OP(n)                                                                                         \
  param::number("op" #n "_amount", 1.f).help("Operation " #n ": topMix, mix, or the base's weight."), \
      param::number("op" #n "_other", 1.f).help("Operation " #n ": weight of the second of a sum.")
constexpr Param kParams[] = {
    param::structure("materialFront").help("The material: a Lama node."),
    param::structure("materialBack").help("Not rendered yet: the front's material is on both sides."),
    param::number("presence", 1.f).help("Existence of the surface: 0 is a hole."),
    param::string("structure", "D")
        .options("D|DRL|CDM|DHP|GRL|DSLHL|TDMEP|TGM|XQM")
        .help("The tree in postfix order, made from what is connected. Leaves: D diffuse, C conductor (A by "
              "colours), G glass and R dielectric on something (g, r by reflectivity), S Schlick (s by index), F "
              "film, H sheen, T translucent, E emission, U subsurface by sssRadius and its kin, the second such leaf "
              "by sss2Radius (X exponential, Y Burley's profile, Q three of them; V, W, Z the same by mean free "
              "paths). L: the newest lies on the one before, M: mix, P: sum."),
    KINORA_LAMA_SHADOW_COLOR,
    param::string("lobeName1", "").help("Name in light path expressions of the lobes of some leaves."),
    param::string("lobeName2", "").help("The same of others."),
    KINORA_LAMA_INTERIOR,
    KINORA_LAMA_INTERIOR_SCATTERING,
    LEAF(1),
    LEAF(2),
    LEAF(3),
    LEAF(4),
    LEAF(5),
    LEAF(6),
    LEAF(7),
    LEAF(8),
    OP(1),
    OP(2),
    OP(3),
    OP(4),
    OP(5),
    OP(6),
    OP(7),
    KINORA_LAMA_SUBSURFACE,
    KINORA_LAMA_THREE_OF("sss"),
    KINORA_LAMA_SUBSURFACE_OF("sss2"),
    KINORA_LAMA_THREE_OF("sss2")};
constexpr uint32_t kFirstOp = kFirstLeaf + lama::kMaxLeaves * kLeafSize,
                   kFirstOfSubsurface = kFirstOp + 2 * lama::kMaxOps;
// Of each leaf that scatters below, in their order.
constexpr uint32_t kSubsurfaceSize = 17;
constexpr lama::SubsurfaceParams subsurfaceAt(uint32_t leaf) {
  const uint32_t f = kFirstOfSubsurface + leaf * kSubsurfaceSize;
  return {f, f + 1, f + 2, f + 3, f + 4, f + 5, f + 6, f + 7, f + 8};
}
constexpr lama::ThreeParams threeAt(uint32_t leaf) {
  const uint32_t f = kFirstOfSubsurface + leaf * kSubsurfaceSize + 9;
  return {{f, f + 1, f + 2}, {f + 3, f + 4, f + 5}, {f + 6, f + 7}};
}
static_assert(std::size(kParams) == kFirstOfSubsurface + lama::kMaxBelow * kSubsurfaceSize);

struct LamaSurface {
  static constexpr bool kGlass = true, kScatters = true;

  static void begin(const Context& c, lama::Closure& k) {
    TreeBuilder tree(c, k);
    bool sound = true;
    for (const char letter : std::string_view(c.fn->text(&c, kStructure))) {
      if (letter == lama::kOpLayer || letter == lama::kOpMix || letter == lama::kOpAdd) {
        const uint32_t first = kFirstOp + 2 * k.opCount;
        sound = sound && k.opCount < lama::kMaxOps && tree.op(letter, c.param(first), c.param(first + 1));
      } else {
        const int first = int(kFirstLeaf + kLeafSize * k.leafCount);
        sound = sound && std::string_view(lama::kLeafKinds).find(letter) != std::string_view::npos &&
                !(lama::isSubsurface(letter) && k.belowCount == lama::kMaxBelow);
        if (sound && lama::isSubsurface(letter)) {
          const uint32_t which = k.belowCount;
          lobes::SubsurfaceClosure& s = bindSubsurface(c, k, subsurfaceAt(which));
          if (letter == lama::kKindThreeProfiles) bindThree(c, s, threeAt(which));
        }
        const bool isGlass = letter == lama::kKindGlass || letter == lama::kKindArtisticGlass;
        sound = sound && tree.leaf(letter, {.color = first + int(kColor),
                                            .through = first + int(kThrough),
                                            .second = first + int(kSecond),
                                            .third = isGlass ? int(kAbsorptionColor) : first + int(kThird),
                                            .roughness = first + int(kRoughness),
                                            .anisotropy = first + int(kAnisotropy),
                                            .direction = first + int(kDirection),
                                            .rotation = first + int(kRotation),
                                            .ior = first + int(kIor),
                                            .amount = isGlass ? int(kAbsorptionRadius) : first + int(kAmount),
                                            .normal = first + int(kNormal),
                                            .bumpShadowing = first + int(kBumpShadowing)});
        if (sound) {
          const float name = c.param(uint32_t(first) + kLobes).data[0][0];
          lama::Leaf& leaf = k.leaves[k.leafCount - 1];
          leaf.lobes = uint8_t((name == 1 ? 1 : name == 2 ? 2 : 0) * lama::kLobeCount);
          if (leaf.kind == lama::kKindSubsurface && leaf.medium == 0) k.belowLobes = leaf.lobes;
        }
      }
    }
    if (sound && tree.whole()) return;
    // written by hand and no tree: the first leaf as a diffuse surface
    k.leafCount = k.opCount = k.belowCount = 0;
    k.layered = k.glows = false;
    k.glass = -1;
    bindLeaf(c, k, lama::kKindDiffuse, {.color = int(kFirstLeaf)});
  }
  static void presence(const Context* c, float* out) { copyFloat(c->param(kPresence), c->padded, out); }
  template <class Is>
  static uint32_t has(const ParamValue* v, Is is) {
    if (!v[kStructure].count || !v[kStructure].strings) return 0;
    for (const char letter : std::string_view(v[kStructure].strings[0]))
      if (is(letter)) return 1;
    return 0;
  }
  static uint32_t enclosesMedium(const ParamValue* v, uint32_t) {
    return has(v, [](char kind) { return kind == lama::kKindGlass || kind == lama::kKindArtisticGlass; });
  }
  static uint32_t scattersBelow(const ParamValue* v, uint32_t) {
    const auto reaches = [&](uint32_t leaf) {
      const lama::SubsurfaceParams p = subsurfaceAt(leaf);
      return v[p.radius].mayBeOn() && v[p.scale].mayBeOn();
    };
    return (reaches(0) || reaches(1)) && has(v, lama::isSubsurface);
  }
};
#define PLASTIC "structure=DRL; leaf1_color=0.9 0.9 0.9; leaf2_color=1 1 1; "
constexpr const char* kLossless[] = {"structure=D; leaf1_color=1 1 1",
                                     "structure=GRL; op1_amount=0; leaf1_color=1 1 1", nullptr};
constexpr const char* kConserving[] = {
    PLASTIC "leaf2_roughness=0",
    PLASTIC "leaf2_roughness=0.3",
    PLASTIC "leaf2_roughness=1; leaf2_ior=2.5",
    "structure=DHP; leaf1_color=1 1 1; leaf2_color=1 1 1",
    "structure=DHL; leaf1_color=0.9 0.9 0.9; leaf2_color=1 1 1; leaf2_roughness=0.4",
    "structure=DSLHL; leaf1_color=0.9 0.9 0.9; leaf2_color=1 1 1; leaf3_color=1 1 1",
    "structure=URL; leaf1_color=0.8 0.8 0.8; sssRadius=1 0.5 0.2; sssUnitLength=1",
    "structure=XYM; op1_amount=0.3; leaf1_color=1 1 1; leaf2_color=1 1 1; sssRadius=1 0.5 0.2; sssUnitLength=1; "
    "sss2Radius=2 1 1; sss2UnitLength=1",
    "structure=Q; leaf1_color=1 1 1; sssMidColor=1 1 1; sssFarColor=1 1 1; sssMidWeight=1; sssFarWeight=1; "
    "sssRadius=1 1 1; sssUnitLength=1",
    nullptr};
#undef PLASTIC
#undef LEAF
#undef OP

KINORA_KERNELS_END

KINORA_PLUGIN(LamaSurface, SlabMaterial<LamaSurface>, BxdfPlugin,
              .help = "The root of a material made of LamaLayer, LamaMix, LamaAdd and the slabs they combine.",
              .params = kParams, .lobes = lama::kTreeLobes, .presenceParam = int(kPresence),
              .enclosesMedium = LamaSurface::enclosesMedium, .scattersBelow = LamaSurface::scattersBelow,
              .interiorMedium = &lama::kInterior, .lossless = kLossless, .conserving = kConserving)
