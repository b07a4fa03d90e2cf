// What a material made of a tree of slabs binds once a context: leaves, each a lobe or a pair of them, and the
// operations that combine them (layer, mix, add), in postfix order. Filled by materials (bind.h helps), read by
// stack.h; plain data.
#pragma once
#include <kinora/bxdf.h>
#include <kinora/lama_limits.h>
#include "plugins/bxdf/lobes/closure.h"

namespace kinora::lama {

struct SheenTable;

constexpr uint32_t kMaxOps = kMaxLeaves - 1;

// Which lobe is which in LobeSum, and what each is to light path expressions.
enum Lobe : uint32_t {
  kDiffuse,
  kDiffuseTransmit,
  kSpecular,
  kTransmit,
  kSheen,
  kSubsurface,
  kSubsurfaceReflect,
  kLobeCount
};
#define KINORA_LAMA_LOBES(P)                                                                               \
  {P "Diffuse", kLobeDiffuse}, {P "Diffuse", kLobeDiffuse | kLobeTransmit}, {P "Specular", kLobeSpecular}, \
      {P "Glass", kLobeSpecular | kLobeTransmit}, {P "Fuzz", kLobeSpecular},                               \
      {P "Subsurface", kLobeDiffuse | kLobeTransmit}, {                                                    \
    P "Subsurface", kLobeDiffuse                                                                           \
  }
constexpr LobeDecl kLobes[kLobeCount] = {KINORA_LAMA_LOBES("")};
// Of a slab by itself, which may name them; and of a tree, in which leaves have one of two names or none.
constexpr LobeDecl kNamedLobes[kLobeCount] = {KINORA_LAMA_LOBES("=lobeName:")};
constexpr LobeDecl kTreeLobes[(1 + kLobeNames) * kLobeCount] = {
    KINORA_LAMA_LOBES(""), KINORA_LAMA_LOBES("=lobeName1:"), KINORA_LAMA_LOBES("=lobeName2:")};
#undef KINORA_LAMA_LOBES

// The kinds of leaves, as the letters of a structure: a tree in postfix order, "DRL" a dielectric over a diffuse base.
enum Kind : char {
  kKindDiffuse = 'D',
  kKindBurley = 'B',              // the diffuse of PxrDisneyBsdf
  kKindConductor = 'C',           // by complex index
  kKindArtisticConductor = 'A',   // by the colours seen face on and towards the edge
  kKindGlass = 'G',               // a dielectric that light goes through
  kKindArtisticGlass = 'g',       // by the reflectance seen face on instead of the index
  kKindDielectric = 'R',          // one that lies on something: it reflects, the rest reaches what is below
  kKindArtisticDielectric = 'r',  // by the reflectance seen face on
  kKindSchlick = 'S',             // the generalised Schlick, by reflectances
  kKindScientificSchlick = 's',   // by index
  kKindFilm = 'F',                // a thin film
  kKindSheen = 'H',
  kKindTranslucent = 'T',
  kKindEmission = 'E',
  // Paths go below the surface; where they do not, diffuse. Up to kMaxBelow leaves of a tree; their kind is 'U' when
  // they are bound.
  kKindSubsurface = 'U',            // random walks with heavy tails, by diffuse mean free paths
  kKindSubsurfaceFlights = 'V',     // by mean free paths
  kKindExponential = 'X',           // exponential walks, by diffuse mean free paths
  kKindExponentialFlights = 'W',    // by mean free paths
  kKindBurleyProfile = 'Y',         // Burley's profile, by diffuse mean free paths
  kKindBurleyProfileFlights = 'Z',  // by mean free paths
  kKindThreeProfiles = 'Q',         // the sum of three of Burley's profiles, each of a colour and a length of its own
};
// What a structure may be made of.
constexpr const char kLeafKinds[] = "DCAGgRrSsFHTEUVXWYZQ";
constexpr bool isSubsurface(char kind) { return (kind >= 'U' && kind <= 'Z') || kind == kKindThreeProfiles; }
// The operations: the base stands before what lies on it.
enum OpKind : char { kOpLayer = 'L', kOpMix = 'M', kOpAdd = 'P' };

struct Leaf {
  char kind = 0;
  bool covers = false;   // it is in the top of a layer: what it lets through counts
  uint8_t medium = 0;    // index into Closure::below
  uint8_t lobes = 0;     // where the Lobes of its name begin
  bool softens = false;  // lobes/bump_shadowing.h; not of mirrors and glass
  int bump = -1;         // index into Closure::normals, -1: the surface's
  Value color;           // of what is reflected (translucent: let through, emission: given off)
  Value through;         // tint of what reaches the base; of Burley's diffuse: its sheen
  Value roughness;
  lobes::SpecularClosure specular;
  lobes::GlassClosure glass;
  Value absorption, absorptionRadius;  // glass: the colour left after that distance
  const GlassEnergy* glassEnergy = nullptr;
  bool isSpecular() const { return kind == 'C' || kind == 'R' || kind == 'S' || kind == 'F'; }
};
// Nodes: leaves first, then operations from kMaxLeaves on. Leaves of a node are neighbours.
struct Op {
  char kind = 0;
  uint8_t below = 0, above = 0;             // its two nodes: base and top, or first and second
  uint8_t first = 0, middle = 0, last = 0;  // leaves [first, middle) of below and [middle, last) of above
  Value amount, other;                      // layer: visibility of the top; mix: share of the second; add: weights
};
struct Closure {
  uint32_t leafCount = 0, opCount = 0;
  Leaf leaves[kMaxLeaves];
  Op ops[kMaxOps];
  bool layered = false;  // there is an op of kind layer
  bool glows = false;
  lobes::SubsurfaceClosure below[kMaxBelow];  // of the leaves that have it
  uint32_t belowCount = 0;
  uint8_t belowLobes = 0;  // Leaf::lobes of the first of them: paths that go below share a lobe
  int glass = -1;          // the first leaf of glass that bounds a medium
  Value normals[10];       // bump inputs in use
  int normalCount = 0;
  bool radiance = true;  // eta^2 on refraction
  const ReflectionEnergy* reflectionEnergy = nullptr;
  const SheenTable* sheen = nullptr;
  const Context* context = nullptr;
};

}  // namespace kinora::lama
