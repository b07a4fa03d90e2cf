// PxrSurface's parameters, declared once, and how the plug-in's code finds them: at(name) is the index, resolved
// while compiling. Included by PxrSurface.cpp alone; plain code, no rendering.
#pragma once
#include <kinora/bxdf.h>
#include <iterator>

namespace kinora::pxrSurface {

#define PXRSURFACE_LATER "No effect yet. "

// The parameters that specular, rough specular and clear coat have in common.
#define PXRSURFACE_SPECULAR(P, what, rough)                                                                          \
  param::integer(P "FresnelMode", 0)                                                                                 \
      .options("0 artistic, 1 physical")                                                                             \
      .help("Reflectance of the " what                                                                               \
            " lobe: artistic from face and edge colour, or physical from ior and extinction."),                      \
      param::color(P "FaceColor", 0.f)                                                                               \
          .help("Artistic: reflectance of the " what " lobe seen face on. Black with a black edge: off."),           \
      param::color(P "EdgeColor", 0.f)                                                                               \
          .help("Artistic: reflectance at grazing angles. Physical: multiplies the lobe; black: off."),              \
      param::number(P "FresnelShape", 5.f)                                                                           \
          .range(1, 10)                                                                                              \
          .help("Artistic: exponent of (1 - cos) between face and edge; 5 is Schlick's."),                           \
      param::color(P "Ior", 1.5f).range(1, 4).help("Physical: index of refraction, by channel."),                    \
      param::color(P "ExtinctionCoeff", 0.f).range(0, 6).help("Physical: extinction; not black for conductors."),    \
      param::number(P "Roughness", rough)                                                                            \
          .help("0 mirror .. 1; the distribution's alpha is its square, below 0.001 the lobe is a perfect mirror."), \
      param::integer(P "ModelType", 0).options("0 Beckmann, 1 GGX").help("Distribution of microfacet normals."),     \
      param::number(P "Anisotropy", 0.f)                                                                             \
          .range(-1, 1)                                                                                              \
          .help(                                                                                                     \
              "Above 0 highlights stretch along the direction, below 0 across it; alphas are alpha / a and alpha * " \
              "a, a = sqrt(1 - 0.9 |anisotropy|)."),                                                                 \
      param::vector(P "AnisotropyDirection", 0, 0, 0)                                                                \
          .help("Direction in render space; 0 0 0: the surface's tangent."),                                         \
      param::normal(P "BumpNormal").help("Normal of this lobe; 0 0 0: bumpNormal, else the surface's."),             \
      param::flag(P "DoubleSided", false).help("1: the lobe is there on the back as well.")

constexpr Param connectable(Param p) {
  p.flags &= ~uint32_t(kParamNotConnectable);
  return p;
}
constexpr Param kParams[] = {
    param::structure("inputMaterial")
        .help("Layers from PxrLayer or PxrLayerMixer (pxrMaterialOut): they feed all parameters they have."),
    connectable(param::array(Type::Int, "utilityPattern", nullptr, 0))
        .help("Patterns that show values in display channels: PxrMatteID."),
    param::normal("bumpNormal").help("Shading normal of all lobes that have none of their own."),
    param::number("presence", 1.f).help("Existence of the surface: 0 is a hole."),
    param::flag("presenceCached", true).help(PXRSURFACE_LATER "Presence is evaluated at each hit."),
    param::color("shadowColor", 0.f)
        .help("Share of lights' light that is left in shadows which the surface casts, by channel. Light paths "
              "(PxrVCM) see nothing of it."),
    param::integer("shadowMode", 0)
        .options("0 shader and shadow colour, 1 shadow colour")
        .help("0: glass colours its shadows by its tint too. 1: shadowColor alone says what is left."),
    param::flag("shadowBumpTerminator", true)
        .help("1: what bumps reflect that lean towards a light fades where the surface under them sees it no more. "
              "Not of mirrors and glass."),
    param::color("userColor", 0.f).help(PXRSURFACE_LATER "A colour handed to an output."),
    param::number("roughnessMollificationClamp", 32.f)
        .range(1, 64)
        .help(PXRSURFACE_LATER "Limit of path roughening."),
    param::flag("mwStartable", false)
        .help(PXRSURFACE_LATER "Manifold walks start at all surfaces that they do not go through."),
    param::number("unitLength", 0.1f).fixed().range(0, 10).help("Scale of all mean free paths, render units."),
    param::color("irradianceTint", 1.f).help("Multiplies what subsurface scattering returns, as subsurfacePostTint."),
    param::number("irradianceRoughness", 0.f).help(PXRSURFACE_LATER "Roughness of light entering the surface."),

    param::number("diffuseGain", 1.f).help("Multiplies diffuseColor and diffuseBackColor; 0: off."),
    param::color("diffuseColor", 0.18f).help("Fraction of light reflected diffusely."),
    param::number("diffuseRoughness", 0.f).help("0 Lambert, 1 roughest Oren-Nayar; energy is kept."),
    param::number("diffuseExponent", 1.f)
        .range(1, 10)
        .help("Above 1 the surface darkens faster away from the light and from the viewer (Minnaert's law); below 1 "
              "acts as 1."),
    param::normal("diffuseBumpNormal").help("Normal of this lobe; 0 0 0: bumpNormal, else the surface's."),
    param::flag("diffuseDoubleSided", false).help("1: diffuse on the back as well."),
    param::flag("diffuseBackUseDiffuseColor", true).help("1: the back has diffuseColor, 0: diffuseBackColor."),
    param::color("diffuseBackColor", 0.18f).help("Reflectance of the back where diffuseBackUseDiffuseColor is 0."),
    param::number("diffuseTransmitGain", 0.f)
        .help("Multiplies diffuseTransmitColor; 0: off. Needs diffuseDoubleSided."),
    param::color("diffuseTransmitColor", 0.18f).help("Fraction of light transmitted diffusely."),

    PXRSURFACE_SPECULAR("specular", "primary specular", 0.2f),
    PXRSURFACE_SPECULAR("roughSpecular", "rough specular", 0.6f),
    PXRSURFACE_SPECULAR("clearcoat", "clear coat", 0.f),
    param::number("clearcoatThickness", 0.f)
        .range(0, 2)
        .help("Thickness of the coat, in the unit of the absorption."),
    param::color("clearcoatAbsorptionTint", 0.f)
        .help("Absorption of all below the coat, per unit of path through it."),
    param::number("specularEnergyCompensation", 0.f)
        .help("Part of the light reflected by specular and rough specular that diffuse and glass go without."),
    param::number("clearcoatEnergyCompensation", 0.f)
        .help("Part of the light reflected by the clear coat that all lobes below it go without."),

    param::color("iridescenceFaceGain", 0.f)
        .help("Multiplies iridescence seen face on. Black with a black edge: off."),
    param::color("iridescenceEdgeGain", 0.f).help("Multiplies iridescence at grazing angles."),
    param::number("iridescenceFresnelShape", 5.f)
        .range(1, 10)
        .help("Exponent of (1 - cos) between the gains of face and edge; 5 is Schlick's."),
    param::integer("iridescenceMode", 0)
        .options("0 artistic, 1 physical")
        .help("Artistic: two colours that alternate with the angle; physical: a thin film of index 1.5 in air."),
    param::color("iridescencePrimaryColor", 1, 0, 0).help("Artistic: the colour face on."),
    param::color("iridescenceSecondaryColor", 0, 0, 1)
        .help("Artistic: the colour where iridescenceScale (1 - cos)^iridescenceCurve is 1, 3 ..."),
    param::number("iridescenceRoughness", 0.2f)
        .help("0 mirror .. 1; the Beckmann distribution's alpha is its square."),
    param::number("iridescenceAnisotropy", 0.f)
        .range(-1, 1)
        .help("Above 0 highlights stretch along the direction, below 0 across it."),
    param::vector("iridescenceAnisotropyDirection", 0, 0, 0)
        .help("Direction in render space; 0 0 0: the surface's tangent."),
    param::normal("iridescenceBumpNormal").help("Normal of this lobe; 0 0 0: bumpNormal, else the surface's."),
    param::number("iridescenceCurve", 1.f)
        .range(0, 10)
        .help("Artistic: above 1 the first colour lasts longer, below 1 shorter."),
    param::number("iridescenceScale", 1.f)
        .range(0, 10)
        .help("Artistic: how often the colour changes to the other one between face and edge."),
    param::flag("iridescenceFlip", false).help("Artistic: 1: the colours change places."),
    param::number("iridescenceThickness", 800.f).range(100, 2000).help("Physical: thickness of the film, nm."),
    param::flag("iridescenceDoubleSided", false).help("1: the lobe is there on the back as well."),

    param::number("fuzzGain", 0.f).help("Multiplies fuzzColor; 0: off."),
    param::color("fuzzColor", 1.f)
        .help("Reflectance of short fibres standing on the surface, seen at grazing angles."),
    param::number("fuzzConeAngle", 8.f).range(0, 32).help("Degrees: how far the glow reaches in from the outline."),
    param::normal("fuzzBumpNormal").help("Normal of this lobe; 0 0 0: bumpNormal, else the surface's."),
    param::flag("fuzzDoubleSided", false).help("1: the lobe is there on the back as well."),

    param::integer("subsurfaceType", 5)
        .range(0, 5)
        .options("0 Jensen dipole, 1 better dipole, 2 Burley, 3 multiple mean free paths, 4 path traced exponential, "
                 "5 path traced")
        .help("Model of scattering below the surface: profiles of diffusion (0 to 3) or random walks. 5 is 4 but for "
              "what subsurfaceBleed does. Integrators other than PxrPathTracer, PxrDirectLighting and PxrOcclusion "
              "reflect diffusely instead."),
    param::number("subsurfaceGain", 0.f).help("Multiplies subsurfaceColor; 0: off."),
    param::color("subsurfaceColor", 0.830f, 0.791f, 0.753f)
        .help("Albedo of a plane surface by subsurface scattering: what one scattering keeps follows from it."),
    param::number("subsurfaceDmfp", 10.f)
        .range(0, 100)
        .help("Diffuse mean free path, times unitLength in render units: how far light reaches below the surface. 0: "
              "diffuse reflection."),
    param::color("subsurfaceDmfpColor", 0.851f, 0.557f, 0.395f)
        .help("Multiplies subsurfaceDmfp by channel. A channel is never shorter than 1/256 of the longest."),
    param::number("shortSubsurfaceGain", 0.f).help("Type 3: multiplies shortSubsurfaceColor."),
    param::color("shortSubsurfaceColor", 0.9f).help("Type 3: albedo by a second profile."),
    param::number("shortSubsurfaceDmfp", 5.f)
        .range(0, 100)
        .help("Type 3: its diffuse mean free path, also times subsurfaceDmfpColor."),
    param::number("longSubsurfaceGain", 0.f).help("Type 3: multiplies longSubsurfaceColor."),
    param::color("longSubsurfaceColor", 0.8f, 0, 0).help("Type 3: albedo by a third profile."),
    param::number("longSubsurfaceDmfp", 20.f)
        .range(0, 100)
        .help("Type 3: its diffuse mean free path, also times subsurfaceDmfpColor."),
    param::number("subsurfaceDirectionality", 0.f)
        .range(-1, 1)
        .help("Types 4 and 5: mean cosine of scattering (Henyey and Greenstein), limited to 0.95 both ways; the "
              "surface keeps its albedo and light its reach."),
    param::number("subsurfaceBleed", 0.f)
        .help("Type 5: heavier tails of free flights at the same mean, up to the power law of the exponent -2.3: "
              "some light reaches far while details stay."),
    param::number("subsurfaceDiffuseBlend", 0.f).help("Part that is reflected diffusely instead."),
    param::flag("subsurfaceResolveSelfIntersections", false)
        .help("Types 4 and 5: 1: parts of the object that overlap are one body; 0: light comes out at the first "
              "surface of the object that it meets."),
    param::number("subsurfaceIor", 1.4f).range(1, 3).help("Types 0 and 1: index of refraction of the inside."),
    param::color("subsurfacePostTint", 1.f).help("Multiplies the result."),
    param::number("subsurfaceDiffuseSwitch", 1.f)
        .help("Reflects diffusely where the footprint of the path times this is longer than the diffuse mean free "
              "path; 0: never. PxrVCM never does."),
    param::flag("subsurfaceDoubleSided", false).help("1: on the back as well."),
    param::number("subsurfaceTransmitGain", 0.f)
        .help("Adds light that crosses the body straight on: in and out by a cosine's law, in subsurfaceColor, less "
              "by a factor of e in each diffuse mean free path. Needs closed meshes."),
    param::flag("considerBackside", true)
        .help("0: light does not come out where the surface faces away from where it went in; what "
              "subsurfaceTransmitGain adds does."),
    param::integer("continuationRayMode", 0)
        .range(0, 2)
        .options("0 off, 1 last hit, 2 all hits")
        .help("Types 4 and 5, 1 and 2: paths pass inner surfaces of parts that overlap, as with "
              "subsurfaceResolveSelfIntersections."),
    param::integer("maxContinuationHits", 2)
        .range(0, 16)
        .help("No effect: paths pass as many inner surfaces as there are."),
    param::number("followTopology", 0.f)
        .help("1: light that comes out where the surface faces another way than where it went in counts by the "
              "cosine between the two, not at all beyond a right angle; 0: wherever it comes out."),
    param::string("subsurfaceSubset", "")
        .traceSet()
        .help("Groups of objects (grouping:membership) that are one body with the surface; empty: the object alone."),

    param::number("singlescatterGain", 0.f)
        .help("Multiplies light that scatters exactly once below the surface, which needs closed meshes; 0: off. "
              "Walks (subsurfaceType 4 and 5) then leave out those that scattered once."),
    param::color("singlescatterColor", 0.830f, 0.791f, 0.753f)
        .help("What one scattering keeps of the light that it turns."),
    param::number("singlescatterMfp", 10.f)
        .range(0, 100)
        .help("Mean free path, times unitLength in render units: from the boundary to the scattering and from there "
              "out."),
    param::color("singlescatterMfpColor", 0.851f, 0.557f, 0.395f).help("Multiplies singlescatterMfp by channel."),
    param::number("singlescatterDirectionality", 0.f)
        .range(-1, 1)
        .help("Mean cosine of that scattering (Henyey and Greenstein), limited to 0.95 both ways; above 0 light "
              "behind the object shines through."),
    param::number("singlescatterIor", 1.3f)
        .range(1, 3)
        .help("Index of refraction of the inside: bends light that goes in and out, as a clear boundary does."),
    param::number("singlescatterBlur", 0.f)
        .help("Roughness of the boundary, where singlescatterIor is above 1: the GGX distribution's alpha is its "
              "square. Light that was scattered is blurred on the way of the eye alone."),
    param::number("singlescatterDirectGain", 0.f)
        .help("Multiplies light that passes the body unscattered, bent as by clear glass and less by a factor of e "
              "in each mean free path; 0: off."),
    param::color("singlescatterDirectGainTint", 1.f).help("Tint of light that passes unscattered."),
    param::flag("singlescatterDoubleSided", false).help("1: on the back as well."),
    param::flag("singlescatterConsiderBackside", true)
        .help("0: light that was scattered does not come out where the surface faces away from where it went in."),
    param::integer("singlescatterContinuationRayMode", 0)
        .range(0, 2)
        .options("0 off, 1 last hit, 2 all hits")
        .help("1 and 2: straight ways inside go on to the last surface from which they leave the body, of as many as "
              "singlescatterMaxContinuationHits. 1: gaps on the way count as filled; 2: as empty."),
    param::integer("singlescatterMaxContinuationHits", 2)
        .range(0, 16)
        .help("Surfaces of the body that a straight way may pass."),
    param::flag("singlescatterDirectGainMode", false).help(PXRSURFACE_LATER "How unscattered light is weighted."),
    param::string("singlescatterSubset", "")
        .traceSet()
        .help("Groups of objects (grouping:membership) that single scattering sees as one body with the surface; "
              "empty: the object alone."),

    param::number("refractionGain", 0.f).help("Multiplies light that glass lets through; 0: off."),
    param::number("reflectionGain", 0.f).help("Multiplies light that glass reflects; 0: off."),
    param::color("refractionColor", 1.f)
        .help("Tint of each passage through the surface; the inside absorbs by extinction."),
    param::number("glassRoughness", 0.1f).help("0 clear .. 1; the GGX distribution's alpha is its square."),
    param::number("glassRefractionRoughness", -1.f)
        .range(-1, 1)
        .help("Roughness of refraction; below 0: glassRoughness."),
    param::number("glassAnisotropy", 0.f)
        .range(-1, 1)
        .help("Stretches reflection and refraction along the direction (above 0) or across it."),
    param::vector("glassAnisotropyDirection", 0, 0, 0)
        .help("Direction in render space; 0 0 0: the surface's tangent."),
    param::normal("glassBumpNormal").help("Normal of this lobe; 0 0 0: bumpNormal, else the surface's."),
    param::number("glassIor", 1.5f)
        .range(1, 3)
        .help("Index of refraction of the inside. Within 1 % of the outside light passes straight."),
    param::onOff("mwWalkable", false)
        .help("Manifold walks go through the glass, or where there is none are reflected by the specular lobe: the "
              "caustics of lights with cheapCaustics are found by them. Not where a bump is connected, of thin "
              "glass, nor with presence below 1."),
    param::number("mwIor", -1.f)
        .range(-1, 3)
        .help("Index of refraction of manifold walks through clear glass; -1: glassIor. Another one moves the "
              "caustic from where the glass would throw it."),
    param::flag("thinGlass", false).help("1: a thin sheet; light passes without bending, both faces reflect."),
    param::flag("ignoreFresnel", false).help(PXRSURFACE_LATER "Reflection and refraction by their gains alone."),
    param::flag("ignoreAccumOpacity", false).help(PXRSURFACE_LATER "Opacity met so far does not count."),
    param::flag("blocksVolumes", false).help(PXRSURFACE_LATER "Volumes end at this surface."),
    param::string("volumeAggregateName", "")
        .help("Volumes that are inside: rays know of those in the aggregates of these names, with blanks between "
              "them, while they are inside the surface, whatever the integrator asks for elsewhere. Where "
              "refractionGain is on and thinGlass off."),
    param::color("ssAlbedo", 0.f)
        .help("Share of the extinction that is scattered, not absorbed: where it is set the inside of glass is a "
              "medium, as that of PxrVolume. 0: it only absorbs."),
    param::color("extinction", 0.f)
        .range(0, 10)
        .help("Extinction of the inside of glass, per unit of length in the scene."),
    param::number("g", 0.f).range(-1, 1).help("Mean cosine of scattering inside glass."),
    param::number("g0", 0.f).range(-1, 1).help("The same; where it is given it counts, not g."),
    param::number("g1", 0.f).range(-1, 1).help("Mean cosine of a second lobe."),
    param::number("blend", 0.f).help("Share of the second lobe."),
    param::color("volumeGlow", 0.f).help("Radiance that the inside of glass emits per unit of length in the scene."),
    param::number("maxExtinction", -1.f)
        .range(-1, 10)
        .help("Largest extinction that patterns make of it; -1: found out by looking."),
    param::integer("multiScatter", 0)
        .options("0 once, 1 any number of times")
        .help("How often light is scattered inside glass."),
    param::flag("enableOverlappingVolumes", false)
        .help(PXRSURFACE_LATER "Insides of objects add where they overlap."),

    param::number("glowGain", 0.f).range(0, 10).help("Multiplies glowColor; 0: off."),
    param::color("glowColor", 1.f).help("Radiance given off, on both sides."),
};
constexpr uint32_t kParamCount = std::size(kParams);

consteval uint32_t at(const char* name) {
  for (uint32_t i = 0; i < kParamCount; ++i) {
    const char *a = kParams[i].name, *b = name;
    while (*a && *a == *b) ++a, ++b;
    if (*a == *b) return i;
  }
  throw "no such parameter";
}

// Where each of specular, rough specular and clear coat has its parameters: the same order, from its first one.
enum : uint32_t {
  kFresnelMode,
  kFaceColor,
  kEdgeColor,
  kFresnelShape,
  kIor,
  kExtinction,
  kRoughness,
  kModelType,
  kAnisotropy,
  kAnisotropyDirection,
  kBump,
  kDoubleSided
};
constexpr uint32_t kSpecularFirst[3] = {at("specularFresnelMode"), at("roughSpecularFresnelMode"),
                                        at("clearcoatFresnelMode")};
static_assert(kSpecularFirst[0] + kDoubleSided == at("specularDoubleSided"));

}  // namespace kinora::pxrSurface
