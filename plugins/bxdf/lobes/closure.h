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
  kSpecular,
  kRoughSpecular,
  kClearcoat,
  kFuzz,
  kGlassReflect,
  kGlassTransmit,
  kLobeCount
};
constexpr LobeDecl kLobes[kLobeCount] = {
    {"Diffuse", kLobeDiffuse},    {"Diffuse", kLobeDiffuse | kLobeTransmit},
    {"Specular", kLobeSpecular},  {"RoughSpecular", kLobeSpecular},
    {"Clearcoat", kLobeSpecular}, {"Fuzz", kLobeSpecular},
    {"Glass", kLobeSpecular},     {"Glass", kLobeSpecular | kLobeTransmit},
};

struct AnisotropyClosure {
  bool on = false, directed = false;
  Value amount, direction, tangent;           // direction only where directed; tangent where it is 0 0 0
  const AnisotropicEnergy* energy = nullptr;  // of reflecting lobes that are on
};
struct SpecularClosure {
  bool physical = false, ggx = false, doubleSided = false;
  int bump = -1;  // index into Closure::normals, -1: the surface's
  Value face, edge, shape, ior, extinction, roughness;
  const FilmTable* film = nullptr;  // a thin film of index `face` (3 alike) and thickness `shape` in nm
  AnisotropyClosure anisotropy;
};
struct GlassClosure {
  bool thin = false;
  bool tinted = false;  // reflectionColor counts
  int bump = -1;
  Value reflectionGain, reflectionColor, refractionGain, refractionColor, roughness, refractionRoughness, ior;
  AnisotropyClosure anisotropy;
};
struct Closure {
  uint32_t on = 0;  // bit per Lobe
  bool has(uint32_t lobe) const { return on >> lobe & 1; }

  Value diffuseGain, diffuseColor, diffuseBackColor, diffuseRoughness, diffuseExponent, transmitGain, transmitColor;
  bool diffuseDoubleSided = false, backHasOwnColor = false;
  SpecularClosure specular[3];  // specular, rough specular, clear coat
  GlassClosure glass;
  Value fuzzGain, fuzzColor, fuzzConeAngle;
  bool fuzzDoubleSided = false;
  Value glowGain, glowColor;
  bool glows = false;

  // Lobes below others are attenuated by what is above: only where one of these is not zero.
  bool coatAttenuates = false, specularAttenuates = false;
  Value coatThickness, coatTint, coatCompensation, specularCompensation;

  Value normals[7];  // bump inputs in use: the general one and those of six lobes
  int normalCount = 0;
  bool bumped = false;  // normals[0] is bumpNormal
  int diffuseBump = -1, fuzzBump = -1;

  bool radiance = true;  // eta^2 on refraction
  const ReflectionEnergy* reflectionEnergy = nullptr;
  const GlassEnergy* glassEnergy = nullptr;
};

}  // namespace kinora::lobes
