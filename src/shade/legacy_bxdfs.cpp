#include "shade/legacy_bxdfs.h"

#include <initializer_list>

#include "base/text.h"

namespace kinora::shade {

namespace {

struct Renamed {
  const char *from, *to;
};

// A parameter set to a number (all components alike) whatever the node says; Renamed may overwrite it.
struct Fixed {
  const char* name;
  scene::ValueType type;
  float value;
};

struct StandIn {
  const char *missing, *use;
  std::initializer_list<Fixed> fixed;
  std::initializer_list<Renamed> renamed;
};

constexpr auto kInt = scene::ValueType::Int;
constexpr auto kFloat = scene::ValueType::Float;
constexpr auto kColor = scene::ValueType::Color;
constexpr float kThird = 1.f / 3;

// Skins are three profiles of equal parts.
const std::initializer_list<Fixed> kSkinFixed = {{"diffuseGain", kFloat, 0},
                                                 {"subsurfaceType", kInt, 3},
                                                 {"shortSubsurfaceGain", kFloat, kThird},
                                                 {"subsurfaceGain", kFloat, kThird},
                                                 {"longSubsurfaceGain", kFloat, kThird},
                                                 {"subsurfaceDmfpColor", kColor, 1}};
const std::initializer_list<Renamed> kSkinNames = {
    {"nearColor", "shortSubsurfaceColor"}, {"nearLength", "shortSubsurfaceDmfp"}, {"midColor", "subsurfaceColor"},
    {"midLength", "subsurfaceDmfp"},       {"farColor", "longSubsurfaceColor"},   {"farLength", "longSubsurfaceDmfp"},
    {"unitLength", "unitLength"},          {"diffuseTint", "subsurfacePostTint"}, {"bumpNormal", "bumpNormal"}};

// Fresnel of the PxrLM plastics and metals is physical. PxrLMMetal's specularColor is what its users set to say which
// metal, so that it is the colour seen face on where it is given.
const StandIn kTable[] = {
    {"pxrlmdiffuse",
     "PxrSurface",
     {{"diffuseDoubleSided", kInt, 1}},
     {{"frontColor", "diffuseColor"},
      {"backColor", "diffuseBackColor"},
      {"roughness", "diffuseRoughness"},
      {"transmission", "diffuseTransmitGain"},
      {"incandescence", "glowColor"},
      {"bumpNormal", "bumpNormal"},
      {"presence", "presence"}}},
    {"pxrlmplastic",
     "PxrSurface",
     {{"specularFresnelMode", kInt, 1}, {"clearcoatFresnelMode", kInt, 1}, {"specularEdgeColor", kColor, 1}},
     {{"diffuseColor", "diffuseColor"},
      {"diffuseRoughness", "diffuseRoughness"},
      {"specularColor", "specularEdgeColor"},
      {"specularEta", "specularIor"},
      {"specularRoughness", "specularRoughness"},
      {"specularAnisotropy", "specularAnisotropy"},
      {"clearcoatColor", "clearcoatEdgeColor"},
      {"clearcoatEta", "clearcoatIor"},
      {"clearcoatRoughness", "clearcoatRoughness"},
      {"incandescence", "glowColor"},
      {"diffuseNn", "diffuseBumpNormal"},
      {"specularNn", "specularBumpNormal"},
      {"clearcoatNn", "clearcoatBumpNormal"},
      {"presence", "presence"}}},
    {"pxrlmmetal",
     "PxrSurface",
     {{"diffuseGain", kFloat, 0}, {"specularFresnelMode", kInt, 1}, {"specularEdgeColor", kColor, 1}},
     {{"eta", "specularIor"},
      {"kappa", "specularExtinctionCoeff"},
      {"roughness", "specularRoughness"},
      {"anisotropy", "specularAnisotropy"},
      {"specularColor", "specularFaceColor"},
      {"bumpNormal", "bumpNormal"},
      {"presence", "presence"}}},
    {"pxrlmglass",
     "PxrGlass",
     {},
     {{"reflectionColor", "reflectionColor"},
      {"refractionColor", "refractionColor"},
      {"transmissionColor", "transmissionColor"},
      {"roughness", "roughness"},
      {"eta", "ior"},
      {"bumpNormal", "bumpNormal"}}},
    {"pxrlmsubsurface", "PxrSurface", kSkinFixed, kSkinNames},
    {"pxrskin", "PxrSurface", kSkinFixed, kSkinNames},
};

scene::Parameter number(const char* name, scene::ValueType type, float value) {
  scene::Parameter p;
  p.name = name;
  p.type = type;
  if (type == kInt)
    p.ints = {int(value)};
  else
    p.floats.assign(type == kColor ? 3 : 1, value);
  return p;
}

}  // namespace

std::optional<scene::Node> modernBxdfFor(const scene::Node& node) {
  const std::string name = lowerCase(node.plugin);
  for (const StandIn& row : kTable) {
    if (name != row.missing) continue;
    scene::Node out;
    out.kind = node.kind;
    out.plugin = row.use;
    out.handle = node.handle;
    out.pos = node.pos;
    for (const Fixed& f : row.fixed) out.params.set(number(f.name, f.type, f.value));
    for (const Renamed& r : row.renamed) {
      const scene::Parameter* given = node.params.find(r.from);
      if (!given) continue;
      scene::Parameter p = *given;
      p.name = r.to;
      const bool spread = !p.isReference && p.floats.size() == 1 && name == "pxrlmplastic" &&
                          std::string_view(r.to) == "clearcoatIor";
      if (spread) {
        p.type = kColor;
        p.floats.assign(3, p.floats[0]);
      }
      out.params.set(std::move(p));
      if (std::string_view(r.to) == "glowColor") out.params.set(number("glowGain", kFloat, 1));
      if (std::string_view(r.to) == "diffuseBackColor") out.params.set(number("diffuseBackUseDiffuseColor", kInt, 0));
    }
    if (name == "pxrlmmetal" && out.params.find("specularFaceColor"))
      out.params.set(number("specularFresnelMode", kInt, 0));
    return out;
  }
  return std::nullopt;
}

scene::NetworkPtr colorPrimvarNetwork(const scene::Attributes* attributes) {
  const auto text = [](const char* name, const char* value, bool reference) {
    scene::Parameter p;
    p.name = name;
    p.type = reference ? kColor : scene::ValueType::String;
    p.isReference = reference;
    p.strings = {value};
    return p;
  };
  auto read = std::make_shared<scene::Node>();
  read->kind = "Pattern";
  read->plugin = "PxrPrimvar";
  read->handle = "Cs";
  read->params.set(text("varname", "Cs", false));
  read->params.set(text("type", "color", false));
  scene::Parameter plain = number("defaultColor", kColor, 1);
  if (attributes && attributes->color) plain.floats.assign(attributes->color->begin(), attributes->color->end());
  read->params.set(plain);
  auto diffuse = std::make_shared<scene::Node>();
  diffuse->kind = "Bxdf";
  diffuse->plugin = "PxrDiffuse";
  diffuse->handle = "default";
  diffuse->params.set(text("diffuseColor", "Cs:resultRGB", true));
  auto network = std::make_shared<scene::Network>();
  network->patterns = {read};
  network->terminal = diffuse;
  return network;
}

}  // namespace kinora::shade
