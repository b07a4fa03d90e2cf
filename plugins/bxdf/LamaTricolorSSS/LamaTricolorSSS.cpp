// LamaTricolorSSS: three profiles of scattering below the surface, each of a colour and of one length for all channels,
// so that light keeps that colour however far it goes; alone or as a leaf of a layered material (LamaSurface). Published
// are its purpose, and that each of three layers has a weight, a colour and a radius. How they scatter is not: here each is
// Burley's profile, as in subsurfaceType 3 of PxrSurface. Names of the layers follow PxrLMSubsurface's, the others LamaSSS.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaTricolorSSS/LamaTricolorSSS.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kNearWeight,
  kNearColor,
  kNearRadius,
  kMidWeight,
  kMidColor,
  kMidRadius,
  kFarWeight,
  kFarColor,
  kFarRadius,
  kNormal,
  kSssNormal,
  kScale,
  kUnitLength,
  kSubset,
  kFollowTopology
};
constexpr Param kParams[] = {
    param::number("nearWeight", 1.f / 3).help("Share of the near layer. Weights of a sum above 1 are scaled to 1."),
    param::color("nearColor", 0.18f).help("Albedo of the near layer: what comes out of what arrives there."),
    param::number("nearRadius", 0.f)
        .help("How far light goes in the near layer, in millimetres: its diffuse mean free path, in all channels. "
              "All three 0: diffuse reflection."),
    param::number("midWeight", 1.f / 3).help("Share of the middle layer."),
    param::color("midColor", 0.18f).help("Albedo of the middle layer."),
    param::number("midRadius", 0.f).help("How far light goes in the middle layer."),
    param::number("farWeight", 1.f / 3).help("Share of the far layer."),
    param::color("farColor", 0.18f).help("Albedo of the far layer."),
    param::number("farRadius", 0.f).help("How far light goes in the far layer."),
    param::normal("normal").help("Shading normal from a bump pattern."),
    param::normal("sssNormal").help("Another name of normal."),
    param::number("sssScale", 1.f).help("Multiplies the three radii."),
    param::number("sssUnitLength", 0.00328f)
        .fixed()
        .help("Render units in a millimetre; the default's unit is a foot."),
    param::string("sssSubset", "")
        .traceSet()
        .help("Groups of objects (grouping:membership) that are one body with the surface; empty: the object alone."),
    param::number("sssFollowTopology", 0.f)
        .help("1: light that comes out where the surface faces another way than where it went in counts by the "
              "cosine between the two, not at all beyond a right angle; 0: wherever it comes out."),
    KINORA_LAMA_COMMON};
#define KINORA_TRICOLOR_WHITE "nearColor=1 1 1; midColor=1 1 1; farColor=1 1 1"
constexpr const char* kLossless[] = {KINORA_TRICOLOR_WHITE, nullptr};
constexpr const char* kConserving[] = {
    KINORA_TRICOLOR_WHITE "; nearWeight=1; midWeight=1; farWeight=1",
    KINORA_TRICOLOR_WHITE "; nearRadius=0.001; midRadius=0.01; farRadius=0.04; sssUnitLength=1", nullptr};

struct LamaTricolorSSS {
  static constexpr bool kScatters = true;

  static void begin(const Context& c, lama::Closure& k) {
    lobes::SubsurfaceClosure& s = k.below[k.belowCount++];
    s.reachColor = constant(c, 3, 1);
    s.reach = c.param(kScale);
    s.unit = c.param(kUnitLength).data[0][0];
    s.traceSet = c.fn->text(&c, kSubset);
    s.joins = s.traceSet && *s.traceSet;
    s.topology = c.param(kFollowTopology);
    bindThree(c, s,
              {{kNearWeight, kMidWeight, kFarWeight}, {kNearRadius, kMidRadius, kFarRadius}, {kMidColor, kFarColor}});
    bindLeaf(c, k, lama::kKindThreeProfiles, {.color = kNearColor, .normal = kNormal});
    lama::Leaf& l = k.leaves[0];
    bindOtherNormal(c, k, l, kSssNormal);
    l.softens = l.bump >= 0 && flag(c, uint32_t(lama::indexOf(kParams, "bumpShadowing")));
  }
  static uint32_t scattersBelow(const ParamValue* v, uint32_t) {
    return v[kScale].mayBeOn() && (v[kNearRadius].mayBeOn() || v[kMidRadius].mayBeOn() || v[kFarRadius].mayBeOn());
  }
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaTricolorSSS, SlabMaterial<LamaTricolorSSS>, BxdfPlugin,
              .help =
                  "Scattering below the surface in three layers, each of a colour that stays; a material by itself, "
                  "or a leaf of LamaLayer, LamaMix and LamaAdd.",
              .params = kParams, .lobes = lama::kNamedLobes, .scattersBelow = LamaTricolorSSS::scattersBelow,
              .lossless = kLossless, .conserving = kConserving)
