// What a material made of a stack of lobes binds once a context: parameter values of the lobes that are on, and
// uniform switches. Filled by materials (bind.h helps), read by stack.h; plain data.
#pragma once
#include <kinora/bxdf.h>

namespace kinora {
struct ReflectionEnergy;
struct AnisotropicEnergy;
struct GlassEnergy;
}  // namespace kinora
namespace kinora::lobes {

struct FilmTable;

// Which lobe is which in LobeSum, and what each is to light path expressions.
enum Lobe : uint32_t {
  kDiffuse,
  kDiffuseTransmit,
  kSubsurface,
  kSubsurfaceReflect,  // where paths do not go below
  kSpecular,
  kRoughSpecular,
  kClearcoat,
  kIridescence,
  kFuzz,
  kGlassReflect,
  kGlassTransmit,
  kSingleScatter,
  kLobeCount
};
constexpr LobeDecl kLobes[kLobeCount] = {
    {"Diffuse", kLobeDiffuse},
    {"Diffuse", kLobeDiffuse | kLobeTransmit},
    {"Subsurface", kLobeDiffuse | kLobeTransmit},
    {"Subsurface", kLobeDiffuse},
    {"Specular", kLobeSpecular},
    {"RoughSpecular", kLobeSpecular},
    {"Clearcoat", kLobeSpecular},
    {"Iridescence", kLobeSpecular},
    {"Fuzz", kLobeSpecular},
    {"Glass", kLobeSpecular},
    {"Glass", kLobeSpecular | kLobeTransmit},
    {"SingleScatter", kLobeSpecular | kLobeTransmit},
};
// The lobes that reflect by microfacets, from kSpecular on in the order of Lobe.
constexpr uint32_t kReflecting = 4, kCoat = kClearcoat - kSpecular;

struct AnisotropyClosure {
  bool on = false, directed = false;
  Value amount, direction, tangent;           // direction only where directed; tangent where it is 0 0 0
  const AnisotropicEnergy* energy = nullptr;  // of reflecting lobes that are on
};
// Colours that change with the angle: Schlick's curve between `face` and `edge` of the lobe is multiplied by them.
struct IridescenceClosure {
  bool flip = false;                // artistic: the colours change places
  Value primary, secondary;         // artistic
  Value curve, scale;               // artistic: they alternate along scale (1 - cosine)^curve
  const FilmTable* film = nullptr;  // physical: the colours of a film
  Value thickness;                  // nm
};
struct SpecularClosure {
  bool physical = false, ggx = false, doubleSided = false;
  int bump = -1;  // index into Closure::normals, -1: the surface's
  Value face, edge, shape, ior, extinction, roughness;
  const FilmTable* film = nullptr;  // a thin film of index `face` (3 alike) and thickness `shape` in nm
  const IridescenceClosure* iridescence = nullptr;
  AnisotropyClosure anisotropy;
};
struct GlassClosure {
  bool thin = false;
  bool tinted = false;  // reflectionColor counts
  int bump = -1;
  Value reflectionGain, reflectionColor, refractionGain, refractionColor, roughness, refractionRoughness, ior;
  AnisotropyClosure anisotropy;
  Value walkIor;  // of manifold walks through mirror-like facets, where it is above 0; no components: ior
};
// Scattering below the surface. Lengths are diffuse mean free paths in render units: reach * scale by channel.
struct SubsurfaceClosure {
  SubsurfaceModel model = SubsurfaceModel::Walk;
  bool areFlights = false;  // lengths are mean free paths instead, from one scattering to the next
  bool doubleSided = false, joins = false, heavyTails = false;
  const char* traceSet = nullptr;
  Value gain, color, tint, entryTint;  // tints multiply what comes out
  Value reach, reachColor;
  float unit = 1;               // of reach
  Value directionality, bleed;  // walks: mean cosine; how heavy the tails of flights are
  Value diffuseSwitch, diffuseBlend;
  Value ior;       // of the boundary, or in the dipoles; no components: 1
  Value topology;  // how much of the light that turns away is lost; no components: nothing
  bool comesOutBehind = true;
  Value straight;  // gain of light that crosses the body without scattering; no components: none
  // two more terms of profiles; no components: none
  Value shortGain, shortColor, shortReach, longGain, longColor, longReach;
};
// Light that scatters exactly once below the surface. Lengths are mean free paths in render units: reach * scale.
struct SingleClosure {
  bool scatters = false;  // else there is only what passes unscattered
  bool doubleSided = false, skipsGaps = false, comesOutBehind = true;
  const char* traceSet = nullptr;
  Value gain, color, reach, reachColor, directionality, ior;
  Value blur;                     // roughness of the boundary
  Value straight, straightColor;  // gain and tint of light that crosses the body without scattering
  uint32_t mostPassed = 0;
  float unit = 1;
};
struct Closure {
  uint32_t on = 0;  // bit per Lobe
  bool has(uint32_t lobe) const { return on >> lobe & 1; }

  Value diffuseGain, diffuseColor, diffuseBackColor, diffuseRoughness, diffuseExponent, transmitGain, transmitColor;
  bool diffuseDoubleSided = false, backHasOwnColor = false;
  SpecularClosure specular[kReflecting];
  IridescenceClosure iridescence;
  GlassClosure glass;
  SubsurfaceClosure subsurface;
  SingleClosure single;
  Value fuzzGain, fuzzColor, fuzzConeAngle;
  bool fuzzDoubleSided = false;
  Value glowGain, glowColor;
  bool glows = false;

  // Lobes below others are attenuated by what is above: only where one of these is not zero.
  bool coatAttenuates = false, specularAttenuates = false;
  Value coatThickness, coatTint, coatCompensation, specularCompensation;

  Value normals[8];  // bump inputs in use: the general one and those of seven lobes
  int normalCount = 0;
  bool bumped = false;   // normals[0] is bumpNormal
  bool softens = false;  // bump_shadowing.h, of lobes that are not mirrors and no glass
  int diffuseBump = -1, fuzzBump = -1;

  bool radiance = true;  // eta^2 on refraction
  const ReflectionEnergy* reflectionEnergy = nullptr;
  const GlassEnergy* glassEnergy = nullptr;
};

}  // namespace kinora::lobes
