// PxrDisney's parameters, declared once, and its closure. Included by PxrDisney.cpp alone; plain code, no rendering.
#pragma once
#include <kinora/bxdf.h>
#include "plugins/bxdf/lobes/closure.h"

namespace kinora::pxrDisney {

enum : uint32_t {
  kBaseColor,
  kEmitColor,
  kSubsurface,
  kSubsurfaceColor,
  kMetallic,
  kSpecular,
  kSpecularTint,
  kRoughness,
  kAnisotropic,
  kSheen,
  kSheenTint,
  kClearcoat,
  kClearcoatGloss,
  kBumpNormal,
  kPresence,
  kInputAOV
};
constexpr Param kParams[] = {
    param::color("baseColor", 0.2f, 0.5f, 0.8f).help("Colour of the surface: diffuse, or of the metal."),
    param::color("emitColor", 0.f).help("Radiance given off, on both sides."),
    param::number("subsurface", 0.f)
        .help("From the diffuse shape to one that flattens as if light went under the surface."),
    param::color("subsurfaceColor", 0.f).help("Colour of that part; black: baseColor."),
    param::number("metallic", 0.f).help("0 dielectric, 1 metal: no diffuse, reflections in baseColor."),
    param::number("specular", 0.5f).help("Reflectance of the dielectric face on, in units of 0.08."),
    param::number("specularTint", 0.f).help("Tints that reflectance towards the hue of baseColor."),
    param::number("roughness", 0.25f)
        .help("Of diffuse and specular; the facets' alpha is its square, below 0.001 a mirror. Their shadowing is "
              "the course's of 2012, alpha ((1 + roughness) / 2)^2 in both directions apart, nothing given back: a "
              "white metal of roughness 0.25, 0.5, 1 returns 0.99, 0.88, 0.31 face on and 0.51, 0.50, 0.49 at a "
              "cosine of 0.25."),
    param::number("anisotropic", 0.f)
        .help("Stretches highlights along the surface's tangent. The shadowing stays without direction, as "
              "published: at 1, roughness 0.75 and grazing angles the long side returns 1.5 times what arrives, the "
              "short one 0.1."),
    param::number("sheen", 0.f).help("An additional grazing part, for cloth."),
    param::number("sheenTint", 0.5f).help("Tints it towards the hue of baseColor."),
    param::number("clearcoat", 0.f).help("A second, colourless highlight; 1 is a quarter of a dielectric's."),
    param::number("clearcoatGloss", 1.f).help("0 satin .. 1 gloss."),
    param::normal("bumpNormal").help("Shading normal from a bump pattern."),
    param::number("presence", 1.f).help("Existence of the surface: 0 is a hole."),
    param::make(Type::Int, "inputAOV", 0, 0, 0).help("Patterns that show values in display channels: PxrMatteID."),
};

enum Lobe : uint32_t { kDiffuseLobe, kSpecularLobe, kClearcoatLobe, kSheenLobe, kLobeCount };
constexpr LobeDecl kLobes[kLobeCount] = {
    {"Diffuse", kLobeDiffuse}, {"Specular", kLobeSpecular}, {"Clearcoat", kLobeSpecular}, {"Fuzz", kLobeSpecular}};

struct EnergyTable;

struct Closure {
  Value baseColor, emitColor, subsurface, subsurfaceColor, metallic, specular, specularTint, roughness, sheen,
      sheenTint, clearcoat, clearcoatGloss, bump;
  bool flattens = false, sheens = false, coated = false, bumped = false;  // uniform zeros are left out
  lobes::AnisotropyClosure anisotropy;
  const EnergyTable* energy = nullptr;
};

}  // namespace kinora::pxrDisney
