// The interface of a material (bxdf): a closure bound to a shading context, and the author's layer over it. Most are
// surfaces; those that fill space (kBxdfFillsSpace) are media, whose closures are phase functions.
// Called by the renderer (begin, presence, interior, albedo, medium) and by integrators (generate, evaluate, emission).
// Conventions: weights include the cosine |N.wi| and are values of the bsdf, not divided by a pdf; pdfs are per solid
// angle; a discrete lobe is flagged and gives a probability instead. Radiance is transported from wi to wo;
// refraction weights carry the factor (eta)^2 of radiance unless the context transports importance.
#pragma once
#include <kinora/context.h>

namespace kinora {

// What a lobe is to light path expressions: <R|T|V  D|S>. V: scattering in a medium.
enum LobeFlags : uint32_t {
  kLobeReflect = 0,
  kLobeTransmit = 1,
  kLobeDiffuse = 0,
  kLobeSpecular = 2,
  kLobeVolume = 4
};
struct LobeDecl {
  const char* name;  // "Diffuse", numbered by Option "lpe"; "=lobeName:Diffuse": that parameter's text, if any
  uint32_t flags;
};

inline constexpr uint32_t kMaxLobes = 24, kMaxSlots = 8;
inline constexpr uint32_t kNoLobe = 0xff;

// Directions asked for or made, one a point; arrays of the context's padded length.
struct EvaluateArgs {
  const float* wi[3];  // unit, render space
  // out; slots are cleared by the callee
  float* weight[kMaxSlots][3];  // per slot
  float* pdf;                   // of generate() making wi, all lobes together
  float* pdfReverse;            // of making wo from wi; null: not wanted
};
struct GenerateArgs {
  const float* u[4];  // in [0, 1): direction (0, 1), lobe (2), slot (3)
  float* wi[3];       // out: unit, render space
  float* weight[3];   // out: weight of the slot chosen, divided by that choice's probability
  float* pdf;         // out: of all lobes together; a probability where discrete
  float* pdfReverse;  // out; may be null
  uint32_t* slot;     // out: slot chosen, kNoLobe where there is no sample
  uint32_t* flags;    // out: SampleFlags
};
enum SampleFlags : uint32_t {
  kSampleDiscrete = 1,
  kSampleTransmit = 2,
  // The path goes on below the surface, from where it comes out elsewhere: only in contexts with kTraitSubsurface (and
  // with kTraitBothEnds whatever their footprints, see Surface::sinks()).
  // wi is the direction in which it starts there; the weight leaves out what BxdfFunctions::subsurface tells. All such
  // samples of a context are of one slot.
  kSampleBelow = 4,
  // Of those, a path that scatters exactly once on its way, as Subsurface::single tells. wi is refracted, and
  // the weight has all but the flight: what the boundary lets in, and what one scattering keeps. They have a slot of
  // their own.
  kSampleOnce = 8,
  // Of those of kSampleBelow, a path that crosses the body straight on and does not scatter. With kSampleOnce, in its
  // slot, it goes in and out as through clear glass; else by a cosine's law, losing a factor of e in each diffuse mean
  // free path (Subsurface::term[0]). The weight has all but what the way takes.
  kSampleStraight = 16,
  // From this bit on: which of the material's media a path of kSampleBelow is of (Subsurface::which).
  kSampleMediumShift = 8
};

// What lies under a surface. Light goes in and comes out by a cosine's law, whatever its direction was. Where walks have
// an index of the boundary it is crossed inside only: light goes in by that law as refraction bends and Fresnel lets it
// in, and what arrives from inside is reflected by Fresnel's formulas or comes out.
enum class SubsurfaceModel : uint32_t { Walk, Burley, BetterDipole, JensenDipole };
inline constexpr uint32_t kMaxSubsurfaceTerms = 3;
// One profile of diffusion, by point.
struct SubsurfaceTerm {
  float* share[3];   // of the term in the whole; the shares of a channel sum to 1
  float* albedo[3];  // of a plane surface, [0, 1]
  float* length[3];  // diffuse mean free path, render units, above 0
};
// A homogeneous medium in which paths scatter once (kSampleOnce), by point.
struct SingleScatter {
  const char* traceSet = nullptr;  // as in Subsurface
  float* length[3];                // mean free path, render units, above 0
  float* anisotropy;               // mean cosine of scattering (Henyey and Greenstein), (-1, 1)
  float* ior;                      // of the inside over the outside, at least 1
  float* alpha;                    // of the boundary's facets (GGX) where straight ways come out; 0: it is clear
  // Surfaces of the body that a straight way may pass: it comes out at the last of these from which it leaves. Of the
  // gaps in between it is as long as all of it, or as what is within (skipsGaps).
  uint32_t mostPassed = 0, skipsGaps = 0;
};
// Filled by BxdfFunctions::subsurface for the points of a context; arrays are the caller's, of padded length. Where
// surface[0] is null, only `single` is wanted; where the arrays of that are, all but it.
struct Subsurface {
  uint32_t which = 0;  // in: of the material's media, as flagged at kSampleMediumShift
  SubsurfaceModel model = SubsurfaceModel::Walk;
  const char* traceSet =
      nullptr;         // the text of a parameter declared with traceSet(): members of these groups are one
                       // body. Null, "": the object itself
  uint32_t joins = 0;  // 1: parts that overlap are one; 0: paths come out at the first surface they meet
  float* surface[3];   // albedo of a plane surface: what comes out at once where nothing lies below
  // Walk
  float* albedo[3];   // of one scattering, [0, 1]
  float* length[3];   // mean free path, render units, above 0
  float* anisotropy;  // mean cosine of scattering (Henyey and Greenstein), (-1, 1)
  // Free flights of a length x keep (1 + tail x / length)^(-1 - 1 / tail), of the mean `length`, after a scattering
  // and (1 + tail x / length)^(-1 / tail) after the boundary (d'Eon 2018); 0: the exponential.
  float* tail;
  // profiles
  uint32_t terms = 1;
  SubsurfaceTerm term[kMaxSubsurfaceTerms];
  float* ior;  // of the inside over the outside: of walks and for the dipoles; 1: there is no boundary
  // How much of what comes out at a place is lost as its normal turns away from that where the path went in: the rest is
  // 1 - f + f max(0, cosine). 0: nothing.
  float* topology;
  uint32_t comesOutBehind = 1;  // 0: not where the surface faces away from that normal
  SingleScatter single{};
  uint32_t leavesOutSingle = 0;  // 1: walks that scattered exactly once are left to samples of kSampleOnce
};

// The medium behind a surface, by point: what a path enters that is transmitted.
struct InteriorArgs {
  float* ior;            // relative to vacuum
  float* absorption[3];  // per render unit, >= 0
};

// The boundary at which manifold walks turn, by point: facets about N that reflect or refract (Walter et al. 2007).
struct InterfaceArgs {
  // in: 1: light goes through, 0: it is reflected; by point
  const uint32_t* through;
  // out
  float* eta;      // index of refraction on wo's side over the one behind
  float* alpha;    // of the facets' distribution for what `through` says; 0: a mirror, all facets lie in the surface
  uint32_t* lobe;  // that light takes there; kNoLobe: none
};
// What the boundary passes on from wi to wo by that lobe alone.
struct InterfaceValueArgs {
  const uint32_t* through;
  const float* wi[3];  // unit, render space; of mirrors the one direction that they have
  // out: of rough facets the weight, cosine included; of mirrors the value of the discrete lobe. In the space of
  // generate(): radiance carries eta^2.
  float* value[3];
};

// The medium that a material fills space with, by point of a context in space (kTraitInSpace).
struct MediumArgs {
  float* extinction[3];  // per render unit: how much of the light is absorbed or scattered; >= 0
  float* emission[3];    // radiance per render unit of length; null: not wanted
};
// What is known of a medium without running its network. Its extinction where that is a product: factor * the primvar
// `number` * the primvar `color` (null: 1). The rest also where it is none.
struct ExtinctionProduct {
  float factor[3];
  const char* number;
  const char* color;
  float most;  // largest extinction as the user says it, by render unit; -1: unsaid
  // How much distances that suit the lights count in it beside those that suit its extinction: 0 none, 1 alone.
  float towardsLights = 0.5f;
  // Similarity: after each scattering in it extinction counts so much, and what a further one brings. 1: exact.
  float extinctionByBounce = 1, contributionByBounce = 1;
  // How its grids move, in object space by unit of the shutter's time: the primvar `velocity` (null: none) times
  // velocityFactor, and a constant part.
  const char* velocity = nullptr;
  float velocityFactor = 1, constantVelocity[3] = {0, 0, 0};
};
enum MediumFlags : uint32_t {
  kMediumScattersOnce = 1,  // what was scattered in it goes to lights only
  kMediumMayEmit = 2
};

struct BxdfFunctions {
  void* (*begin)(const Context*);  // evaluates parameters; never null
  void (*generate)(const Context*, const void* closure, const GenerateArgs*);
  void (*evaluate)(const Context*, const void* closure, const EvaluateArgs*);
  // n directions at one point of the context; arrays have padded(n) elements.
  void (*evaluateAt)(const Context*, const void* closure, uint32_t point, uint32_t n, const EvaluateArgs*);
  void (*emission)(const Context*, const void* closure, float* const rgb[3]);  // null: none
  void (*albedo)(const Context*, const void* closure, float* const rgb[3]);    // for the albedo channel; null: black
  void (*presence)(const Context*, float* presence);                           // 0..1; null: always 1
  void (*interior)(const Context*, const InteriorArgs*);                       // null: no medium behind it
  // Tinted shadows: what a shadow ray that goes straight on keeps where the surface is present; null: nothing. Asked
  // of materials for which BxdfTraits::letsShadowsThrough holds.
  void (*thinShadow)(const Context*, float* const rgb[3]);
  // Materials that fill space. Their weights are phase function times albedo, without a cosine; wo points back along
  // the ray that was scattered.
  void (*medium)(const Context*, const MediumArgs*);
  // What lies below, asked of contexts of which samples were flagged kSampleBelow; null: there are none.
  void (*subsurface)(const Context*, const void* closure, Subsurface*);
  // Manifold walks, of materials with BxdfTraits::walkableLobes; null: they go through none.
  void (*interface)(const Context*, const void* closure, const InterfaceArgs*);
  void (*interfaceValue)(const Context*, const void* closure, const InterfaceValueArgs*);
};

// Descriptor::flags of a bxdf.
enum BxdfDescriptorFlags : uint32_t {
  kBxdfNotReciprocal = 1,  // f(wo, wi) and f(wi, wo) differ on purpose: the testing kit leaves reciprocity out
  kBxdfFillsSpace = 2,     // a medium: objects of the material have no surface, they are full of it
  // The closure stands for the whole passage through a fibre: on curves rays leave from behind it as well as from the
  // front, without meeting it again. Its reverse density is that of a path which comes in where this one, mirrored across
  // the fibre, would: at the same offset to the other side. For importance it may answer with its adjoint: the testing
  // kit does not ask that both be one.
  kBxdfFiber = 4
};

// The medium that objects of a surface's material are full of (cloudy glass), told as another material, which fills
// space: that of the name, with parameters of this one under its own names. Values and connections go along.
struct InteriorMedium {
  struct Pair {
    const char* own;
    const char* there;
  };
  const char* material;
  ListOf<Pair> parameters;
  // There is one where one of these is set, to something else than 0 or by a connection, and enclosesMedium() says so.
  ListOf<const char*> causes;
  // The surface keeps all but this one, which is the medium's: it would absorb twice.
  const char* moves;
};

struct BxdfTraits {
  const LobeDecl* lobes;
  uint32_t lobeCount;
  int presenceParam;  // index, or -1: with its default and unconnected the surface is opaque
  // Materials whose key differs never share a program: e.g. a bit for each lobe that is on. null: 0. Connected values
  // are flagged in ParamValue.
  uint64_t (*programKey)(const ParamValue*, uint32_t count);
  // 1: this material encloses a medium (glass): interior() is called and paths keep it on their stack of media.
  uint32_t (*enclosesMedium)(const ParamValue*, uint32_t count);
  // Test settings, null-terminated list of "name=v[ v v]; name=v" strings: albedo 1 within 1 % (lossless and
  // compensated).
  const char* const* lossless;
  // Settings that must never reflect more than they receive, tried besides the covering array; null: none.
  const char* const* conserving;
  // 1: tinted shadows pass this material (glass, window panes): thinShadow() stands for the light that its lobes
  // flagged kLobeTransmit | kLobeSpecular bring. null: what enclosesMedium says.
  uint32_t (*letsShadowsThrough)(const ParamValue*, uint32_t count) = nullptr;
  // Materials that fill space: their MediumFlags (null: 0), and whether their extinction is a product (null: never).
  uint32_t (*mediumFlags)(const ParamValue*, uint32_t count) = nullptr;
  uint32_t (*extinctionProduct)(const ParamValue*, uint32_t count, ExtinctionProduct*) = nullptr;
  // 1: generate() may flag samples kSampleBelow. null: what BxdfFunctions::subsurface says by being there.
  uint32_t (*scattersBelow)(const ParamValue*, uint32_t count) = nullptr;
  // A bit for each lobe that interface() may name; 0, null: walks do not go through the material. Its normals must be
  // those of the surface: how a bump changes along it is not known.
  uint32_t (*walkableLobes)(const ParamValue*, uint32_t count) = nullptr;
  // null: objects of the material are empty, or full of what interior() says alone.
  const InteriorMedium* interiorMedium = nullptr;
};

// What a bxdf declares; see BxdfTraits.
struct BxdfPlugin {
  using Functions = BxdfFunctions;
  static constexpr Kind kKind = Kind::Bxdf;
  const char* help = "";
  ListOf<Param> params = {};
  ListOf<LobeDecl> lobes = {};
  int presenceParam = -1;
  uint64_t (*programKey)(const ParamValue*, uint32_t count) = nullptr;
  uint32_t (*enclosesMedium)(const ParamValue*, uint32_t count) = nullptr;
  uint32_t (*letsShadowsThrough)(const ParamValue*, uint32_t count) = nullptr;
  uint32_t (*mediumFlags)(const ParamValue*, uint32_t count) = nullptr;
  uint32_t (*extinctionProduct)(const ParamValue*, uint32_t count, ExtinctionProduct*) = nullptr;
  uint32_t (*scattersBelow)(const ParamValue*, uint32_t count) = nullptr;
  uint32_t (*walkableLobes)(const ParamValue*, uint32_t count) = nullptr;
  const InteriorMedium* interiorMedium = nullptr;
  const char* const* lossless = nullptr;
  const char* const* conserving = nullptr;
  uint32_t flags = 0;
  constexpr BxdfTraits traits() const {
    return {lobes.data,    lobes.count,   presenceParam,      programKey,  enclosesMedium,
            lossless,      conserving,    letsShadowsThrough, mediumFlags, extinctionProduct,
            scattersBelow, walkableLobes, interiorMedium};
  }
};

}  // namespace kinora
