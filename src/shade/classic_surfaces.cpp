#include "shade/classic_surfaces.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>

#include "base/text.h"

namespace kinora::shade {

namespace {

enum Traits : uint32_t {
  kMetal = 1,          // highlights have the surface's colour
  kReflectsByMap = 2,  // Kr counts where a reflection map is named, which is traced instead
  kPainted = 4,        // texturename multiplies the colour
  kUnlit = 8,          // shows its colour whatever lights it
  kFromTheEye = 16,    // lit from where it is seen: Kd cos^2
  kGlass = 32,
  kMapIsAround = 64,  // a texture is of what is reflected, which is traced
  kBlack = 128
};

// Coefficients of a shader's parameters by default. A standard shader takes those parameters that are not 0 here.
struct Model {
  const char* name;
  float ka, kd, ks, kr;
  uint32_t traits;
};

// RISpec 3.2, appendix A.1; defaultsurface is that of the RenderMan Toolkit, glass stands for the ray-traced shaders
// of that name. null leaves colour and opacity as they come.
constexpr Model kModels[] = {
    {"matte", 1, 1, 0, 0, 0},
    {"plastic", 1, .5f, .5f, 0, 0},
    {"paintedplastic", 1, .5f, .5f, 0, kPainted},
    {"metal", 1, 0, 1, 0, kMetal},
    {"shinymetal", 1, 0, 1, 1, kMetal | kReflectsByMap},
    {"constant", 0, 0, 0, 0, kUnlit},
    {"null", 0, 0, 0, 0, kUnlit},
    {"defaultsurface", .2f, .8f, 0, 0, kPainted | kFromTheEye},
    {"glass", 0, 0, .5f, 1, kGlass},
};
// What words alone tell of: plastic that reflects, whose map, if it has one, is of what is around it; and skies full of
// stars, of which the stars are lost.
constexpr Model kShiny = {"plastic that reflects", 1, .5f, .5f, .5f, kMapIsAround};
constexpr Model kStars = {"black", 0, 0, 0, 0, kUnlit | kBlack};
// Of shaders that no word tells anything about; published ones have their Kd about there.
constexpr Model kUnknown = {"matte", 1, .75f, 0, 0, 0};

// What a word in a shader's name says about it; the first that is met counts.
struct Word {
  const char *word, *model;
};
constexpr Word kWords[] = {{"glass", "glass"},       {"constant", "constant"}, {"chrome", "shinymetal"},
                           {"mirror", "shinymetal"}, {"metal", "metal"},       {"steel", "metal"},
                           {"plastic", "plastic"},   {"phong", "plastic"},     {"blinn", "plastic"},
                           {"shiny", "shiny"},       {"matte", "matte"},       {"lambert", "matte"},
                           {"starfield", "stars"}};

const Model& modelNamed(std::string_view name) {
  if (name == "shiny") return kShiny;
  if (name == "stars") return kStars;
  for (const Model& m : kModels)
    if (name == m.name) return m;
  return kModels[0];
}

// Parameters that shaders of many people share, by the names they go under.
using Names = std::initializer_list<const char*>;
constexpr const char* kColors[] = {"basecolor",    "surfacecolor", "diffusecolor", "csurf",
                                   "surfaceColor", "baseColor",    "diffuseColor", "Csurf"};
constexpr const char* kTextures[] = {"texturename", "texname", "mapname",  "tmap",        "Csmapname", "colorMap",
                                     "ColMap",      "Texture", "colormap", "textureName", "file",      "texturefile"};

scene::Parameter floats(const char* name, scene::ValueType type, std::initializer_list<float> values) {
  scene::Parameter p;
  p.name = name;
  p.type = type;
  p.floats = values;
  return p;
}
scene::Parameter number(const char* name, float v) { return floats(name, scene::ValueType::Float, {v}); }
scene::Parameter color(const char* name, const float c[3]) {
  return floats(name, scene::ValueType::Color, {c[0], c[1], c[2]});
}
scene::Parameter integer(const char* name, int v) {
  scene::Parameter p;
  p.name = name;
  p.type = scene::ValueType::Int;
  p.ints = {v};
  return p;
}
scene::Parameter text(const char* name, const std::string& v) {
  scene::Parameter p;
  p.name = name;
  p.type = scene::ValueType::String;
  p.strings = {v};
  return p;
}
scene::Parameter link(const char* name, scene::ValueType type, const char* from) {
  scene::Parameter p = text(name, from);
  p.type = type;
  p.isReference = true;
  return p;
}

class Builder {
 public:
  explicit Builder(const ClassicLook& look) : look_(look) {
    if (look.surface) {
      const std::string& plugin = look.surface->plugin;
      const std::string name = plugin.substr(plugin.find_last_of("/\\") + 1);
      const auto at =
          std::find_if(std::begin(kModels), std::end(kModels), [&](const Model& m) { return name == m.name; });
      isStandard_ = at != std::end(kModels);
      model_ = isStandard_ ? at : &guess(lowerCase(name));
    }
  }

  ClassicMaterial build() {
    network_ = std::make_shared<scene::Network>();
    const float presence = (look_.opacity[0] + look_.opacity[1] + look_.opacity[2]) / 3;
    std::shared_ptr<scene::Node> surface = make("Bxdf", model_->traits & kGlass ? "PxrSurface" : "ClassicSurface",
                                                look_.surface ? look_.surface->plugin.c_str() : "default");
    if (model_->traits & kGlass)
      glass(*surface);
    else
      reflector(*surface);
    if (!(model_->traits & kGlass)) {
      if (look_.hasOpacities)
        surface->params.set(link("presence", scene::ValueType::Float, meanOpacity()));
      else if (presence < 1)
        surface->params.set(number("presence", std::max(presence, 0.f)));
    }
    network_->terminal = surface;
    ClassicMaterial out{network_, {}};
    if (!isStandard_)
      out.standIn = std::string(model_->name) +
                    " stands in, with its colour and those of its parameters that are "
                    "known by their names";
    return out;
  }

 private:
  const Model& guess(const std::string& name) const {
    for (const Word& w : kWords)
      if (name.find(w.word) != std::string::npos) return modelNamed(w.model);
    return given({"Ks", "specularcolor", "specularColor"}) ? modelNamed("plastic") : kUnknown;
  }
  const scene::Parameter* given(Names names) const {
    for (const char* n : names)
      if (const scene::Parameter* p = look_.surface ? look_.surface->params.find(n) : nullptr) return p;
    return nullptr;
  }
  // A parameter that the shader has: those of a standard one are what its model says is not 0.
  float coefficient(const char* name, float byDefault) const {
    const bool has = byDefault != 0 || !isStandard_;
    const float v = has && look_.surface ? look_.surface->params.getFloat(name, byDefault) : byDefault;
    return std::isfinite(v) ? v : byDefault;
  }
  std::shared_ptr<scene::Node> make(const char* kind, const char* plugin, const char* handle) const {
    auto n = std::make_shared<scene::Node>();
    n->kind = kind;
    n->plugin = plugin;
    n->handle = handle;
    if (look_.surface) n->pos = look_.surface->pos;
    return n;
  }
  // A pattern that reads a primitive variable, white where there is none.
  void reads(const char* name) {
    constexpr float kWhite[3] = {1, 1, 1};
    const auto n = make("Pattern", "PxrPrimvar", name);
    n->params.set(text("varname", name));
    n->params.set(text("type", "color"));
    n->params.set(color("defaultColor", kWhite));
    network_->patterns.push_back(n);
  }
  const char* meanOpacity() {
    reads("Os");
    const auto mean = make("Pattern", "PxrToFloat", "opacity");
    mean->params.set(link("input", scene::ValueType::Color, "Os:resultRGB"));
    mean->params.set(integer("mode", 3));
    network_->patterns.push_back(mean);
    return "opacity:resultF";
  }

  std::string textureName() const {
    if (!look_.surface || (isStandard_ && !(model_->traits & kPainted))) return {};
    if (model_->traits & kMapIsAround) return {};
    for (const char* n : kTextures)
      if (std::string file = look_.surface->params.getString(n, ""); !file.empty()) return file;
    return {};
  }

  void reflector(scene::Node& out) {
    const uint32_t traits = model_->traits;
    colors(out);
    if (look_.atmosphere) fade(out, *look_.atmosphere);
    float ka = coefficient("Ka", model_->ka);
    if (!isStandard_) ka = std::min(ka, 1.f);  // it may mean something else there, and blows pictures out
    const float kd = coefficient("Kd", model_->kd);
    if (traits & kFromTheEye) {
      out.params.set(number("facingGain", kd));
      const float unlit[3] = {ka, ka, ka};
      out.params.set(color("unlitColor", unlit));
    } else {
      float unlit[3];
      for (int k = 0; k < 3; ++k) unlit[k] = traits & kUnlit ? 1 : ka * look_.ambient[size_t(k)];
      out.params.set(color("unlitColor", unlit));
    }
    out.params.set(number("Kd", traits & (kFromTheEye | kUnlit) ? 0 : kd));
    out.params.set(number("Ks", traits & kUnlit ? 0 : coefficient("Ks", model_->ks)));
    out.params.set(number("roughness", coefficient("roughness", .1f)));
    const bool hasMap = look_.surface && !look_.surface->params.getString("texturename", "").empty();
    const bool reflects = !isStandard_ || !(traits & kReflectsByMap) || hasMap;
    out.params.set(
        number("Kr", reflects && !(traits & kUnlit) ? std::clamp(coefficient("Kr", model_->kr), 0.f, 1.f) : 0));
    out.params.set(integer("metallic", traits & kMetal ? 1 : 0));
    if (const scene::Parameter* p = given({"specularcolor", "specularColor"});
        p && p->floats.size() == 3 && !(traits & kMetal))
      out.params.set(color("specularColor", p->floats.data()));
  }

  // A colour that an unknown shader has instead of Cs: by a usual name, or where the scene says no Color the first of
  // its colours that is no highlight's.
  const scene::Parameter* ownColor() const {
    if (isStandard_ || !look_.surface) return nullptr;
    for (const char* n : kColors)
      if (const scene::Parameter* p = look_.surface->params.find(n); p && p->floats.size() == 3) return p;
    for (const scene::Parameter& p : look_.surface->params)
      if (!look_.hasColor && p.type == scene::ValueType::Color && p.floats.size() == 3 &&
          lowerCase(p.name).find("spec") == std::string::npos)
        return &p;
    return nullptr;
  }

  // surfaceColor: Cs, or a colour that the shader has instead, times its texture.
  void colors(scene::Node& out) {
    constexpr float kNone[3] = {0, 0, 0};
    if (model_->traits & kBlack) return out.params.set(color("surfaceColor", kNone));
    const scene::Parameter* own = ownColor();
    if (!own) reads("Cs");
    const std::string file = textureName();
    if (file.empty())
      return out.params.set(own ? color("surfaceColor", own->floats.data())
                                : link("surfaceColor", scene::ValueType::Color, "Cs:resultRGB"));
    constexpr float kWhite[3] = {1, 1, 1};
    const auto n = make("Pattern", "PxrTexture", "texture");
    n->params.set(text("filename", file));
    n->params.set(integer("invertT", 0));  // t of the RenderMan Interface runs down
    n->params.set(color("missingColor", kWhite));
    n->params.set(own ? color("colorScale", own->floats.data())
                      : link("colorScale", scene::ValueType::Color, "Cs:resultRGB"));
    network_->patterns.push_back(n);
    out.params.set(link("surfaceColor", scene::ValueType::Color, "texture:resultRGB"));
  }

  // Depth is linear between the clipping planes; the length of the ray stands for it.
  void fade(scene::Node& out, const scene::Node& shader) const {
    const scene::ParameterList& given = shader.params;
    const std::vector<float> c = given.getFloats("background");
    if (c.size() == 3) out.params.set(color("fogColor", c.data()));
    if (lowerCase(shader.plugin) == "fog") {
      out.params.set(number("fogDistance", std::max(given.getFloat("distance", 1), 1e-6f)));
      return;
    }
    const auto [hither, yon] = look_.clipping;
    if (!(yon > hither) || yon > 1e30f) return;                               // all of the scene is at depth 0
    const auto length = [&](float depth) { return depth * (yon - hither); };  // rays begin at the first plane
    out.params.set(number("cueStart", length(given.getFloat("mindistance", 0))));
    out.params.set(number("cueEnd", std::max(length(given.getFloat("maxdistance", 1)), 1e-6f)));
  }

  // Clear glass, and the highlight that lights without extent leave on it: a Beckmann lobe as wide as the power of the
  // cosine that shaders had, and as bright in its middle.
  void glass(scene::Node& out) const {
    out.params.set(number("diffuseGain", 0));
    out.params.set(number("reflectionGain", std::clamp(coefficient("Kr", 1), 0.f, 1.f)));
    out.params.set(number("refractionGain", std::clamp(coefficient("Kt", 1), 0.f, 1.f)));
    out.params.set(number("glassRoughness", 0));
    for (const char* n : {"eta", "ior", "refractIndex"})
      if (const scene::Parameter* p = given({n}); p && p->size() == 1)
        out.params.set(number("glassIor", look_.surface->params.getFloat(n, 1.5f)));
    if (const scene::Parameter* p = given({"transmitcolor", "transmitColor"}); p && p->floats.size() == 3)
      out.params.set(color("refractionColor", p->floats.data()));
    const float exponent = 8 / std::clamp(coefficient("roughness", .05f), .008f, 1.f);
    const float alphaSquared = 2 / (exponent + 2);
    const float peak = std::clamp(4 * alphaSquared * coefficient("Ks", model_->ks), 0.f, 1.f);
    if (!(peak > 0)) return;
    float shine[3] = {peak, peak, peak};
    if (const scene::Parameter* p = given({"specularcolor", "specularColor"}); p && p->floats.size() == 3)
      for (size_t c = 0; c < 3; ++c) shine[c] = std::clamp(peak * p->floats[c], 0.f, 1.f);
    out.params.set(color("specularFaceColor", shine));
    out.params.set(color("specularEdgeColor", shine));
    out.params.set(number("specularRoughness", std::sqrt(std::sqrt(alphaSquared))));
  }

  const ClassicLook& look_;
  const Model* model_ = &kModels[0];
  bool isStandard_ = true;
  std::shared_ptr<scene::Network> network_;
};

}  // namespace

bool isAtmosphere(const scene::Node& shader) {
  const std::string name = lowerCase(shader.plugin);
  return shader.kind == "Atmosphere" && (name == "fog" || name == "depthcue");
}

ClassicMaterial classicMaterial(const ClassicLook& look) { return Builder(look).build(); }

}  // namespace kinora::shade
