// Helpers for materials that fill a tree of slabs from their parameters. Included per target.
#include <kinora/bxdf_author.h>
#include <string_view>
#include <kinora/math/microfacet.h>
#include "closure.h"
#include "functions.h"
#include "sheen.h"
#include "plugins/bxdf/lobes/bind.h"
#include "plugins/bxdf/lobes/film.h"

#ifndef KINORA_LAMA_BIND_ONCE
#define KINORA_LAMA_BIND_ONCE
namespace kinora::lama {
// Where a leaf's values stand among a node's parameters; -1: nowhere.
struct LeafParams {
  int color = -1;    // colour, or tint of what is reflected
  int through = -1;  // tint of what is let through
  int second = -1;   // conductor: index, or reflectivity; Schlick: reflectivity, or index
  int third = -1;    // conductor: extinction, or edge colour; Schlick: reflectivity at the edge; glass: absorption
  int roughness = -1;
  int anisotropy = -1, direction = -1, rotation = -1;
  int ior = -1;     // dielectrics: index, or reflectivity; film: its index
  int amount = -1;  // Schlick: profile; glass: radius of absorption; film: thickness between those
  int normal = -1;
  int bumpShadowing = -1;
};
// The same of what lies below the surface.
struct SubsurfaceParams {
  uint32_t radius, scale, unit, anisotropy, bleed, subset, continues, ior, topology;
};
// And of the three profiles of kKindThreeProfiles, whose first colour is the leaf's.
struct ThreeParams {
  uint32_t weight[3], radius[3], color[2];
};
}  // namespace kinora::lama

#define KINORA_LAMA_LATER "No effect yet. "
// Parameters that several nodes have in common.
#define KINORA_LAMA_TINTS                                                    \
  param::color("reflectionTint", 1.f).help("Multiplies what is reflected."), \
      param::color("transmissionTint", 1.f)                                  \
          .help("Multiplies what is let through: at each boundary, or to the base of a layer.")
#define KINORA_LAMA_FACETS                                                                                     \
  param::number("roughness", 0.1f).help("0 clear, or a mirror .. 1; the distribution's alpha is its square."), \
      param::normal("normal").help("Shading normal from a bump pattern.")
#define KINORA_LAMA_SCATTERING                                                    \
  param::color("scatterColor", 0.f).help(KINORA_LAMA_LATER "Scattering inside."), \
      param::number("scatterAnisotropy", 0.f).range(-1, 1).help(KINORA_LAMA_LATER "Its direction.")
// The inside of glass, and the medium that fills it where it scatters (PxrVolume).
#define KINORA_LAMA_INTERIOR                                                                              \
  param::color("absorptionColor", 1.f).help("Colour left of white light after absorptionRadius inside."), \
      param::number("absorptionRadius", 1.f).range(0.1f, 10).help("The distance of absorptionColor, render units.")
#define KINORA_LAMA_INTERIOR_SCATTERING                                                                              \
  param::color("scatterColor", 0.f)                                                                                  \
      .help(                                                                                                         \
          "Share of what is lost of light inside that is scattered, once, not absorbed: where it is set the inside " \
          "is a medium, as that of PxrVolume, of the extinction that absorptionColor says."),                        \
      param::number("scatterAnisotropy", 0.f)                                                                        \
          .range(-1, 1)                                                                                              \
          .help("Mean cosine of that scattering: above 0 forward, below 0 backward.")
namespace kinora::lama {
inline constexpr InteriorMedium::Pair kInside[] = {{"absorptionColor", "transmittanceColor"},
                                                   {"absorptionRadius", "transmittanceDistance"},
                                                   {"scatterColor", "diffuseColor"},
                                                   {"scatterAnisotropy", "anisotropy"}};
inline constexpr const char* kInsideCauses[] = {"scatterColor"};
inline constexpr InteriorMedium kInterior{"PxrVolume", kInside, kInsideCauses, "absorptionColor"};
}  // namespace kinora::lama
#define KINORA_LAMA_ROTATION \
  "Turns the direction about the normal, counter-clockwise as seen from outside; 1 is a whole turn."
#define KINORA_LAMA_ANISOTROPY                                                                           \
  param::number("anisotropy", 0.f)                                                                       \
      .range(-1, 1)                                                                                      \
      .help("Above 0 highlights stretch along the direction, below 0 across it; as PxrSurface has it."), \
      param::vector("anisotropyDirection", 0, 0, 0)                                                      \
          .help("Direction in render space; 0 0 0: the surface's tangent."),                             \
      param::number("anisotropyRotation", 0.f).help(KINORA_LAMA_ROTATION)
// The same of nodes whose parameter is called direction.
#define KINORA_LAMA_ANISOTROPY_ALONG                                               \
  param::number("anisotropy", 0.f)                                                 \
      .range(-1, 1)                                                                \
      .help("Above 0 highlights stretch along the direction, below 0 across it."), \
      param::vector("direction", 0, 0, 0).help("Direction in render space; 0 0 0: the surface's tangent.")
// Indices of KINORA_LAMA_FACETS, KINORA_LAMA_ANISOTROPY.
#define KINORA_LAMA_FACET_INDICES kRoughness, kNormal, kAnisotropy, kAnisotropyDirection, kAnisotropyRotation
#define KINORA_LAMA_SUBSURFACE_OF(p)                                                                              \
  param::color(p "Radius", 0.f)                                                                                   \
      .help(                                                                                                      \
          "How far light goes below the surface, by channel, in millimetres: diffuse mean free paths, or mean "   \
          "free paths where the mode says so. Black: diffuse reflection."),                                       \
      param::number(p "Scale", 1.f).help("Multiplies " p "Radius."),                                              \
      param::number(p "UnitLength", 0.00328f)                                                                     \
          .fixed()                                                                                                \
          .help("Render units in a millimetre; the default's unit is a foot."),                                   \
      param::number(p "Anisotropy", 0.f)                                                                          \
          .range(-1, 1)                                                                                           \
          .help("Path traced: mean cosine of scattering (Henyey and Greenstein), limited to 0.95 both ways."),    \
      param::number(p "Bleed", 0.f).help("Mode 0: heavier tails of free flights at the same mean."),              \
      param::string(p "Subset", "")                                                                               \
          .traceSet()                                                                                             \
          .help(                                                                                                  \
              "Groups of objects (grouping:membership) that are one body with the surface; empty: the object "    \
              "alone."),                                                                                          \
      param::flag(p "ContinuationRays", false)                                                                    \
          .help("1: parts of the body that overlap are one; 0: light comes out at the first of its surfaces."),   \
      param::number(p "IOR", 1.f)                                                                                 \
          .range(1, 2)                                                                                            \
          .help(                                                                                                  \
              "Path traced: index of refraction of the inside. Above 1 light goes in refracted, and the surface " \
              "reflects part of it back inside; a plane surface keeps its colour."),                              \
      param::number(p "FollowTopology", 0.f)                                                                      \
          .help(                                                                                                  \
              "1: light that comes out where the surface faces another way than where it went in counts by the "  \
              "cosine between the two, not at all beyond a right angle; 0: wherever it comes out.")
#define KINORA_LAMA_SUBSURFACE KINORA_LAMA_SUBSURFACE_OF("sss")
#define KINORA_LAMA_THREE_OF(p)                                                                          \
  param::number(p "NearWeight", 1.f).help("Share of the surface that the first of three profiles has."), \
      param::number(p "MidWeight", 0.f).help("The second's."),                                           \
      param::number(p "FarWeight", 0.f).help("The third's."),                                            \
      param::number(p "NearRadius", 1.f).help("Its length, times that of the leaf."),                    \
      param::number(p "MidRadius", 1.f).help("The second's."),                                           \
      param::number(p "FarRadius", 1.f).help("The third's."),                                            \
      param::color(p "MidColor", 0.18f).help("The second's colour; the first's is the leaf's."),         \
      param::color(p "FarColor", 0.18f).help("The third's colour.")
#define KINORA_LAMA_SHADOW_COLOR                                                                                    \
  param::color("shadowColor", 0.f)                                                                                  \
      .help(                                                                                                        \
          "Share of lights' light that is left in shadows which the surface casts, by channel. Of a layered "       \
          "material's slabs the first counts that says one, from the base up. Light paths (PxrVCM) see nothing of " \
          "it.")
#define KINORA_LAMA_BUMP_SHADOWING                                                                              \
  "1: what bumps reflect that lean towards a light fades where the surface under them sees it no more. Not of " \
  "mirrors and glass."
#define KINORA_LAMA_COMMON_OF(bumpShadowing, lobeName)                                                      \
  KINORA_LAMA_SHADOW_COLOR,                                                                                 \
      param::number("energyCompensation", 1.f).help("No effect: what facets lose always comes back."),      \
      param::flag("bumpShadowing", true).help(bumpShadowing), param::string("lobeName", "").help(lobeName), \
      param::string("matte", "").help(KINORA_LAMA_LATER "Name of a matte.")
#define KINORA_LAMA_LOBE_NAME                                                                               \
  "Name of its lobes in light path expressions, by which Option \"lpe\" numbers them and \"C<RD'NAME'>L\" " \
  "picks them; empty: Diffuse, Specular ... The slabs of a layered material have at most two."
#define KINORA_LAMA_COMMON KINORA_LAMA_COMMON_OF(KINORA_LAMA_BUMP_SHADOWING, KINORA_LAMA_LOBE_NAME)
// Of those that bumps do not shadow.
#define KINORA_LAMA_COMMON_UNSHADOWED                                                                 \
  KINORA_LAMA_COMMON_OF("No effect: of glass and of light that comes through, bumps shadow nothing.", \
                        KINORA_LAMA_LOBE_NAME)
namespace kinora::lama {
// Settings of facets that reflect all light, by colours.
#define WHITE "fresnelMode=1; reflectivity=1 1 1; "
inline constexpr const char* kLosslessFacets[] = {WHITE "roughness=0", WHITE "roughness=0.3", WHITE "roughness=1",
                                                  nullptr};
#undef WHITE
template <size_t N>
constexpr int indexOf(const Param (&list)[N], std::string_view name) {
  for (size_t i = 0; i < N; ++i)
    if (list[i].name == name) return int(i);
  return -1;
}
}  // namespace kinora::lama
#endif

#if defined(KINORA_LAMA_BIND_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LAMA_BIND_H_TARGET
#undef KINORA_LAMA_BIND_H_TARGET
#else
#define KINORA_LAMA_BIND_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

inline float valueAt(const Value& v, uint32_t channel, uint32_t point) {
  return v.data[v.components == 1 ? 0 : channel][v.stride ? point : 0];
}
// A value made of others, component by component: f(channel, point).
template <class Fn>
inline Value computedValue(const Context& c, uint32_t components, bool uniform, Fn f) {
  Value v;
  v.components = components;
  v.stride = uniform ? 0 : 1;
  for (uint32_t k = 0; k < components; ++k) {
    float* out = c.alloc<float>(uniform ? 1 : c.padded);
    for (uint32_t i = 0; i < (uniform ? 1 : c.padded); ++i) out[i] = f(k, i);
    v.data[k] = out;
  }
  return v;
}
inline Value constant(const Context& c, uint32_t components, float x) {
  return computedValue(c, components, true, [&](uint32_t, uint32_t) { return x; });
}
inline float root(float x) { return sqrt(Float<8>(x > 0 ? x : 0)).lane0(); }
// Index of a dielectric by its reflectance face on.
inline float indexOf(float reflectivity) {
  const float r = root(reflectivity < 0.99f ? reflectivity : 0.99f);
  return (1 + r) / (1 - r);
}

// Builds a closure's tree in postfix order.
class TreeBuilder {
 public:
  TreeBuilder(const Context& c, lama::Closure& k) : c_(c), k_(k) {}

  // False where there is no more room. Kinds by artists' parameters become those by indices.
  bool leaf(char kind, const lama::LeafParams& p) {
    if (k_.leafCount == lama::kMaxLeaves) return false;
    lama::Leaf& l = push(kind);
    l.color = value(p.color, 3, 1);
    l.through = value(p.through, 3, 1);
    l.roughness = value(p.roughness, 1, 0);
    if (p.normal >= 0) l.bump = bindNormal(c_, k_, uint32_t(p.normal), -1);
    l.softens = l.bump >= 0 && p.bumpShadowing >= 0 && flag(c_, uint32_t(p.bumpShadowing));
    lobes::AnisotropyClosure anisotropy;
    if (p.anisotropy >= 0) bindAnisotropy(c_, anisotropy, uint32_t(p.anisotropy), uint32_t(p.direction));
    if (p.rotation >= 0 && anisotropy.on) turn(anisotropy, c_.param(uint32_t(p.rotation)));
    switch (kind) {
      case lama::kKindConductor:
      case lama::kKindArtisticConductor:
        conductor(l, kind, value(p.second, 3, 1), value(p.third, 3, 0));
        break;
      case lama::kKindDielectric:
        dielectric(l, value(p.ior, 1, 1.5f));
        break;
      case lama::kKindArtisticDielectric:
        dielectric(l, byReflectivity(value(p.ior, 1, 0.04f)));
        break;
      case lama::kKindSchlick:
      case lama::kKindScientificSchlick:
        schlick(l, kind, value(p.second, 3, 0.04f), value(p.third, 3, 1), value(p.amount, 1, 0.2f));
        break;
      case lama::kKindGlass:
      case lama::kKindArtisticGlass: {
        const Value ior = value(p.ior, 1, kind == lama::kKindGlass ? 1.5f : 0.04f);
        glass(l, kind == lama::kKindGlass ? ior : byReflectivity(ior), false, anisotropy);
        l.absorption = value(p.third, 3, 1);
        l.absorptionRadius = value(p.amount, 1, 1);
        break;
      }
      case lama::kKindFilm:
        film(l, value(p.ior, 1, 1.3f), value(p.amount, 1, 0.5f), value(p.second, 3, 400), value(p.third, 3, 800));
        break;
      case lama::kKindSheen:
        k_.sheen = &sheenTable();
        break;
      case lama::kKindEmission:
        k_.glows = true;
        break;
    }
    if (lama::isSubsurface(kind)) subsurface(l, kind);
    if (l.isSpecular()) stretch(l, anisotropy);
    return true;
  }
  // The two newest nodes become one.
  bool op(char kind, const Value& amount, const Value& other) {
    if (depth_ < 2 || k_.opCount == lama::kMaxOps) return false;
    lama::Op& o = k_.ops[k_.opCount];
    o.kind = kind;
    o.below = stack_[depth_ - 2].node;
    o.above = stack_[depth_ - 1].node;
    o.first = stack_[depth_ - 2].first;
    o.middle = stack_[depth_ - 1].first;
    o.last = uint8_t(k_.leafCount);
    o.amount = amount;
    o.other = other;
    --depth_;
    stack_[depth_ - 1].node = uint8_t(lama::kMaxLeaves + k_.opCount++);
    if (kind == lama::kOpLayer) {
      k_.layered = true;
      for (uint32_t i = o.middle; i < o.last; ++i) k_.leaves[i].covers = true;
    }
    return true;
  }
  bool op(char kind, float amount) { return op(kind, constant(c_, 1, amount), constant(c_, 1, amount)); }
  bool whole() const { return depth_ == 1; }

  // ---- leaves by values, for materials that compute them ----
  lama::Leaf& push(char kind) {
    stack_[depth_++] = {uint8_t(k_.leafCount), uint8_t(k_.leafCount)};
    lama::Leaf& l = k_.leaves[k_.leafCount++];
    l.kind = kind;
    return l;
  }
  void dielectric(lama::Leaf& l, const Value& ior) {
    l.kind = lama::kKindDielectric;
    const bool uniform = ior.uniform();
    reflecting(l, computedValue(c_, 3, uniform, [&](uint32_t, uint32_t i) { return valueAt(ior, 0, i); }),
               constant(c_, 3, 0));
  }
  void glass(lama::Leaf& l, const Value& ior, bool thin, const lobes::AnisotropyClosure& anisotropy) {
    l.kind = lama::kKindGlass;
    lobes::GlassClosure& g = l.glass;
    g.thin = thin;
    g.tinted = true;
    g.reflectionGain = g.refractionGain = constant(c_, 1, 1);
    g.reflectionColor = l.color;
    g.refractionColor = l.through;
    g.roughness = g.refractionRoughness = l.roughness;
    g.ior = ior;
    g.anisotropy = anisotropy;
    if (thin) {
      k_.reflectionEnergy = &reflectionEnergyTable();
      return;
    }
    l.glassEnergy = glassTable(c_, g);
    if (k_.glass < 0) k_.glass = int(k_.leafCount) - 1;
  }
  // Schlick's between two colours.
  void schlick(lama::Leaf& l, const Value& face, const Value& edge, const Value& exponent) {
    l.kind = lama::kKindSchlick;
    k_.reflectionEnergy = &reflectionEnergyTable();
    l.specular.ggx = true;
    l.specular.roughness = l.roughness;
    l.specular.face = face;
    l.specular.edge = edge;
    l.specular.shape = exponent;
  }
  void stretch(lama::Leaf& l, const lobes::AnisotropyClosure& anisotropy) {
    l.specular.anisotropy = anisotropy;
    if (anisotropy.on) l.specular.anisotropy.energy = &anisotropicEnergyTable(true);
  }

 private:
  // Turns the direction about the surface's outward normal, by so many whole turns: counter-clockwise as it is seen from
  // outside (render space is left-handed), and from inside the same direction.
  void turn(lobes::AnisotropyClosure& a, const Value& turns) {
    if (isZero(turns)) return;
    float* turned[3];
    for (float*& row : turned) row = c_.alloc<float>(c_.padded);
    for (uint32_t i = 0; i < c_.padded; ++i) {
      float d[3] = {0, 0, 0}, n[3];
      for (uint32_t k = 0; k < 3; ++k) {
        if (a.directed) d[k] = valueAt(a.direction, k, i);
        n[k] = c_.entering[i] ? c_.N[k][i] : -c_.N[k][i];
      }
      if (!(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > 1e-20f))
        for (uint32_t k = 0; k < 3; ++k) d[k] = valueAt(a.tangent, k, i);
      Float<8> sine, cosine;
      sincos(Float<8>(kTwoPi * valueAt(turns, 0, i)), sine, cosine);
      const float s = sine.lane0(), co = cosine.lane0();
      turned[0][i] = co * d[0] + s * (d[1] * n[2] - d[2] * n[1]);
      turned[1][i] = co * d[1] + s * (d[2] * n[0] - d[0] * n[2]);
      turned[2][i] = co * d[2] + s * (d[0] * n[1] - d[1] * n[0]);
    }
    a.directed = true;
    a.direction = Value{{turned[0], turned[1], turned[2]}, 1, 3};
  }
  struct Node {
    uint8_t node, first;
  };
  const Context& c_;
  lama::Closure& k_;
  Node stack_[lama::kMaxLeaves];
  uint32_t depth_ = 0;

  // By what bindSubsurface() has said; where that reaches nowhere it is diffuse.
  void subsurface(lama::Leaf& l, char kind) {
    l.medium = uint8_t(k_.belowCount - 1);
    lobes::SubsurfaceClosure& s = k_.below[l.medium];
    l.kind = lama::kKindSubsurface;
    s.color = l.color;
    if (kind == lama::kKindThreeProfiles) return three(l, s);
    s.model = kind == lama::kKindBurleyProfile || kind == lama::kKindBurleyProfileFlights ? SubsurfaceModel::Burley
                                                                                          : SubsurfaceModel::Walk;
    s.heavyTails = kind == lama::kKindSubsurface || kind == lama::kKindSubsurfaceFlights;
    s.areFlights = kind == lama::kKindSubsurfaceFlights || kind == lama::kKindExponentialFlights ||
                   kind == lama::kKindBurleyProfileFlights;
  }
  // Reflects, where it does so instead, what the three return together.
  void three(lama::Leaf& l, lobes::SubsurfaceClosure& s) {
    s.model = SubsurfaceModel::Burley;
    const Value *colors[] = {&s.color, &s.shortColor, &s.longColor}, *gains[] = {&s.gain, &s.shortGain, &s.longGain};
    bool uniform = true;
    for (int t = 0; t < 3; ++t) uniform = uniform && colors[t]->uniform() && gains[t]->uniform();
    l.color = computedValue(c_, 3, uniform, [&](uint32_t k, uint32_t i) {
      float sum = 0;
      for (int t = 0; t < 3; ++t) {
        const float a = valueAt(*colors[t], k, i);
        sum += valueAt(*gains[t], 0, i) * (a > 0 ? a : 0.f);
      }
      return sum;
    });
  }
  Value value(int index, uint32_t components, float otherwise) {
    return index >= 0 ? c_.param(uint32_t(index)) : constant(c_, components, otherwise);
  }
  Value byReflectivity(const Value& r) {
    return computedValue(c_, 1, r.uniform(), [&](uint32_t, uint32_t i) { return indexOf(valueAt(r, 0, i)); });
  }
  void reflecting(lama::Leaf& l, const Value& ior, const Value& extinction) {
    k_.reflectionEnergy = &reflectionEnergyTable();
    l.specular.physical = l.specular.ggx = true;
    l.specular.roughness = l.roughness;
    l.specular.edge = l.color;
    l.specular.ior = ior;
    l.specular.extinction = extinction;
  }
  void film(lama::Leaf& l, const Value& ior, const Value& relative, const Value& least, const Value& most) {
    k_.reflectionEnergy = &reflectionEnergyTable();
    l.specular.ggx = true;
    l.specular.film = &filmTable();
    l.specular.roughness = l.roughness;
    l.specular.edge = l.color;
    l.specular.face = computedValue(c_, 3, ior.uniform(), [&](uint32_t, uint32_t i) { return valueAt(ior, 0, i); });
    const bool uniform = relative.uniform() && least.uniform() && most.uniform();
    l.specular.shape = computedValue(c_, 1, uniform, [&](uint32_t, uint32_t i) {
      const float a = valueAt(relative, 0, i);
      return (1 - a) * valueAt(least, 0, i) + a * valueAt(most, 0, i);
    });
  }
  void conductor(lama::Leaf& l, char kind, const Value& second, const Value& third) {
    l.kind = lama::kKindConductor;
    if (kind == lama::kKindConductor) return reflecting(l, second, third);
    // Gulbrandsen, "Artist Friendly Metallic Fresnel" (JCGT 2014)
    const bool uniform = second.uniform() && third.uniform();
    const auto face = [&](uint32_t k, uint32_t i) {
      const float r = valueAt(second, k, i);
      return r < 0 ? 0.f : r > 0.999f ? 0.999f : r;
    };
    const Value n = computedValue(c_, 3, uniform, [&](uint32_t k, uint32_t i) {
      const float r = face(k, i), s = root(r), edge = valueAt(third, k, i), g = edge < 0 ? 0 : edge > 1 ? 1 : edge;
      return g * (1 - r) / (1 + r) + (1 - g) * (1 + s) / (1 - s);
    });
    reflecting(l, n, computedValue(c_, 3, uniform, [&](uint32_t k, uint32_t i) {
                 const float r = face(k, i), m = valueAt(n, k, i);
                 return root((r * (m + 1) * (m + 1) - (m - 1) * (m - 1)) / (1 - r));
               }));
  }
  void schlick(lama::Leaf& l, char kind, const Value& second, const Value& edge, const Value& profile) {
    const Value tint = l.color;
    const bool uniform = second.uniform() && tint.uniform(), edgeUniform = edge.uniform() && tint.uniform();
    schlick(l,
            computedValue(c_, 3, uniform,
                          [&](uint32_t k, uint32_t i) {
                            const float x = valueAt(second, k, i), r = (x - 1) / (x + 1);
                            return valueAt(tint, k, i) * (kind == lama::kKindSchlick ? x : r * r);
                          }),
            computedValue(c_, 3, edgeUniform,
                          [&](uint32_t k, uint32_t i) { return valueAt(tint, k, i) * valueAt(edge, k, i); }),
            computedValue(c_, 1, profile.uniform(), [&](uint32_t, uint32_t i) {
              const float p = valueAt(profile, 0, i);
              return p > 0.01f ? 1 / p : 100.f;
            }));
  }
};

// Before the leaf of it.
inline lobes::SubsurfaceClosure& bindSubsurface(const Context& c, lama::Closure& k, const lama::SubsurfaceParams& p) {
  lobes::SubsurfaceClosure& s = k.below[k.belowCount++];
  s.reachColor = c.param(p.radius);
  s.reach = c.param(p.scale);
  s.unit = c.param(p.unit).data[0][0];
  s.directionality = c.param(p.anisotropy);
  s.bleed = c.param(p.bleed);
  s.traceSet = c.fn->text(&c, p.subset);
  s.joins = flag(c, p.continues) || (s.traceSet && *s.traceSet);
  s.ior = c.param(p.ior);
  s.topology = c.param(p.topology);
  return s;
}
// After that, of a leaf of kKindThreeProfiles. Weights are shares of the surface: of a sum above 1 they are what each is
// of it. A radius multiplies what bindSubsurface() said.
inline void bindThree(const Context& c, lobes::SubsurfaceClosure& s, const lama::ThreeParams& p) {
  Value weight[3], radius[3];
  bool uniform = true, even = s.reach.uniform();
  for (int t = 0; t < 3; ++t) {
    weight[t] = c.param(p.weight[t]);
    radius[t] = c.param(p.radius[t]);
    uniform = uniform && weight[t].uniform();
    even = even && radius[t].uniform();
  }
  const Value scale = s.reach;
  const auto share = [&](int which) {
    return computedValue(c, 1, uniform, [&](uint32_t, uint32_t i) {
      float own[3], sum = 0;
      for (int t = 0; t < 3; ++t) {
        const float w = valueAt(weight[t], 0, i);
        sum += own[t] = w > 0 ? w : 0.f;
      }
      return sum > 1 ? own[which] / sum : own[which];
    });
  };
  const auto length = [&](int which) {
    return computedValue(c, 1, even,
                         [&](uint32_t, uint32_t i) { return valueAt(radius[which], 0, i) * valueAt(scale, 0, i); });
  };
  s.gain = share(0);
  s.shortGain = share(1);
  s.longGain = share(2);
  s.reach = length(0);
  s.shortReach = length(1);
  s.longReach = length(2);
  s.shortColor = c.param(p.color[0]);
  s.longColor = c.param(p.color[1]);
}
// A colour that has two names: the other counts where it is not the default of both.
inline Value colorOf(const Context& c, uint32_t name, uint32_t otherName, float byDefault) {
  const Value plain = c.param(name), other = c.param(otherName);
  const auto isDefault = [&](uint32_t i) {
    return valueAt(other, 0, i) == byDefault && valueAt(other, 1, i) == byDefault &&
           valueAt(other, 2, i) == byDefault;
  };
  if (other.uniform() && isDefault(0)) return plain;
  return computedValue(c, 3, plain.uniform() && other.uniform(),
                       [&](uint32_t n, uint32_t i) { return valueAt(isDefault(i) ? plain : other, n, i); });
}

// The same of a leaf's normal, of which no normal is the default: the other counts where there is none.
inline void bindOtherNormal(const Context& c, lama::Closure& k, lama::Leaf& l, uint32_t otherName) {
  const Value other = c.param(otherName);
  if (!isBumped(other)) return;
  if (l.bump < 0) {
    l.bump = bindNormal(c, k, otherName, -1);
    return;
  }
  Value& plain = k.normals[l.bump];
  const auto isNone = [plain](uint32_t i) {
    return valueAt(plain, 0, i) == 0 && valueAt(plain, 1, i) == 0 && valueAt(plain, 2, i) == 0;
  };
  plain = computedValue(c, 3, plain.uniform() && other.uniform(),
                        [&, own = plain](uint32_t n, uint32_t i) { return valueAt(isNone(i) ? other : own, n, i); });
}

// The tree of one leaf, for the nodes that are one.
inline void bindLeaf(const Context& c, lama::Closure& k, char kind, const lama::LeafParams& p) {
  TreeBuilder(c, k).leaf(kind, p);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
