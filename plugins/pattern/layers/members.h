// What a material layer consists of: the parameters of PxrSurface that can differ from layer to layer, each with the
// lobe it belongs to. PxrLayer, PxrLayerMixer and their outputs are made of this one list. Plain code.
//
// A layer travels as one output for each member, pxrMaterialOut_diffuseColor and so on; connecting pxrMaterialOut as
// a whole (to PxrLayerSurface's inputMaterial, to a mixer's baselayer) connects all of them.
#pragma once
#include <kinora/pattern.h>
#include <iterator>

namespace kinora::layers {

// L(lobe, on by default). Lobes whose gain is 0 by default need not be switched on as well.
#define KINORA_LAYER_LOBES(L) \
  L(Diffuse, 1)               \
  L(Specular, 0)              \
  L(RoughSpecular, 0)         \
  L(Clearcoat, 0)             \
  L(Iridescence, 0)           \
  L(Fuzz, 1)                  \
  L(Subsurface, 1)            \
  L(Singlescatter, 1)         \
  L(RR, 1)                    \
  L(Glow, 1)

#define KINORA_LAYER_SPECULAR(M, lobe, name, rough) \
  M(color, name##FaceColor, lobe, Weight, 0.f)      \
  M(color, name##EdgeColor, lobe, Weight, 0.f)      \
  M(color, name##Ior, lobe, Shape, 1.5f)            \
  M(color, name##ExtinctionCoeff, lobe, Shape, 0.f) \
  M(number, name##Roughness, lobe, Shape, rough)    \
  M(number, name##Anisotropy, lobe, Shape, 0.f)     \
  M(normal, name##BumpNormal, lobe, Normal)

// M(kind of parameter, name, lobe, role, default...). Weights are 0 where the lobe is off, and a layer brings them in
// by its mask; shapes are the layer's own where nothing below has the lobe.
#define KINORA_LAYER_MEMBERS(M)                                                 \
  M(number, diffuseGain, Diffuse, Weight, 1.f)                                  \
  M(color, diffuseColor, Diffuse, Shape, 0.18f)                                 \
  M(number, diffuseRoughness, Diffuse, Shape, 0.f)                              \
  M(number, diffuseExponent, Diffuse, Shape, 1.f)                               \
  M(normal, diffuseBumpNormal, Diffuse, Normal)                                 \
  M(color, diffuseBackColor, Diffuse, Shape, 0.18f)                             \
  M(number, diffuseTransmitGain, Diffuse, Weight, 0.f)                          \
  M(color, diffuseTransmitColor, Diffuse, Shape, 0.18f)                         \
  KINORA_LAYER_SPECULAR(M, Specular, specular, 0.2f)                            \
  KINORA_LAYER_SPECULAR(M, RoughSpecular, roughSpecular, 0.6f)                  \
  KINORA_LAYER_SPECULAR(M, Clearcoat, clearcoat, 0.f)                           \
  M(number, clearcoatThickness, Clearcoat, Weight, 0.f)                         \
  M(color, clearcoatAbsorptionTint, Clearcoat, Shape, 0.f)                      \
  M(number, iridescenceFaceGain, Iridescence, Weight, 0.f)                      \
  M(number, iridescenceEdgeGain, Iridescence, Weight, 0.f)                      \
  M(color, iridescencePrimaryColor, Iridescence, Shape, 1.f, 0.f, 0.f)          \
  M(color, iridescenceSecondaryColor, Iridescence, Shape, 0.f, 0.f, 1.f)        \
  M(number, iridescenceThickness, Iridescence, Shape, 800.f)                    \
  M(number, iridescenceRoughness, Iridescence, Shape, 0.2f)                     \
  M(number, fuzzGain, Fuzz, Weight, 0.f)                                        \
  M(color, fuzzColor, Fuzz, Shape, 1.f)                                         \
  M(number, fuzzConeAngle, Fuzz, Shape, 8.f)                                    \
  M(normal, fuzzBumpNormal, Fuzz, Normal)                                       \
  M(number, subsurfaceGain, Subsurface, Weight, 0.f)                            \
  M(color, subsurfaceColor, Subsurface, Shape, 0.83f, 0.791f, 0.753f)           \
  M(number, subsurfaceDmfp, Subsurface, Shape, 10.f)                            \
  M(color, subsurfaceDmfpColor, Subsurface, Shape, 0.851f, 0.557f, 0.395f)      \
  M(number, shortSubsurfaceGain, Subsurface, Weight, 0.f)                       \
  M(color, shortSubsurfaceColor, Subsurface, Shape, 0.9f)                       \
  M(number, shortSubsurfaceDmfp, Subsurface, Shape, 5.f)                        \
  M(number, longSubsurfaceGain, Subsurface, Weight, 0.f)                        \
  M(color, longSubsurfaceColor, Subsurface, Shape, 0.8f, 0.f, 0.f)              \
  M(number, longSubsurfaceDmfp, Subsurface, Shape, 20.f)                        \
  M(color, subsurfacePostTint, Subsurface, Shape, 1.f)                          \
  M(number, subsurfaceTransmitGain, Subsurface, Weight, 0.f)                    \
  M(number, singlescatterGain, Singlescatter, Weight, 0.f)                      \
  M(color, singlescatterColor, Singlescatter, Shape, 0.83f, 0.791f, 0.753f)     \
  M(number, singlescatterMfp, Singlescatter, Shape, 10.f)                       \
  M(color, singlescatterMfpColor, Singlescatter, Shape, 0.851f, 0.557f, 0.395f) \
  M(number, singlescatterDirectionality, Singlescatter, Shape, 0.f)             \
  M(number, singlescatterIor, Singlescatter, Shape, 1.3f)                       \
  M(number, singlescatterBlur, Singlescatter, Shape, 0.f)                       \
  M(number, singlescatterDirectGain, Singlescatter, Weight, 0.f)                \
  M(color, singlescatterDirectGainTint, Singlescatter, Shape, 1.f)              \
  M(number, refractionGain, RR, Weight, 0.f)                                    \
  M(number, reflectionGain, RR, Weight, 0.f)                                    \
  M(color, refractionColor, RR, Shape, 1.f)                                     \
  M(number, glassRoughness, RR, Shape, 0.1f)                                    \
  M(number, glassIor, RR, Shape, 1.5f)                                          \
  M(number, glowGain, Glow, Weight, 0.f)                                        \
  M(color, glowColor, Glow, Shape, 1.f)                                         \
  M(normal, bumpNormal, All, Normal)

enum Lobe : uint32_t {
#define X(lobe, on) k##lobe,
  KINORA_LAYER_LOBES(X)
#undef X
      kLobes,
  kAll = kLobes  // belongs to every layer
};
enum class Role : uint8_t { Weight, Shape, Normal };
struct Member {
  uint32_t lobe;
  Role role;
  uint32_t components;
};
constexpr uint32_t kComponents_number = 1, kComponents_color = 3, kComponents_normal = 3;
constexpr Member kMembers[] = {
#define X(kind, name, lobe, role, ...) {k##lobe, Role::role, kComponents_##kind},
    KINORA_LAYER_MEMBERS(X)
#undef X
};
constexpr uint32_t kMemberCount = std::size(kMembers);
enum MemberIndex : uint32_t {
#define X(kind, name, ...) kMember_##name,
  KINORA_LAYER_MEMBERS(X)
#undef X
};

// The parameters of one layer: switches of the lobes, then the members. P: "" or a prefix like "layer1_".
#define KINORA_LAYER_SWITCH(lobe, on) \
  param::flag(KINORA_LAYER_PREFIX "enable" #lobe, on).help("1: the layer has this lobe."),
#define KINORA_LAYER_MEMBER(kind, name, lobe, role, ...) \
  param::kind(KINORA_LAYER_PREFIX #name __VA_OPT__(, ) __VA_ARGS__).help("As of PxrSurface."),
#define KINORA_LAYER_OUTPUT(kind, name, ...) param::output(kOutput_##kind, "pxrMaterialOut_" #name),
constexpr Type kOutput_number = Type::Float, kOutput_color = Type::Color, kOutput_normal = Type::Normal;

// Outputs, in order: the whole, then one for each member.
#define KINORA_LAYER_OUTPUTS param::output(Type::Struct, "pxrMaterialOut"), KINORA_LAYER_MEMBERS(KINORA_LAYER_OUTPUT)

}  // namespace kinora::layers
