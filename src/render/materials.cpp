#include "render/materials.h"

#include <array>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "render/legacy_lights.h"
#include "render/primitive_strings.h"
#include "shade/classic_surfaces.h"
#include "shade/legacy_bxdfs.h"

namespace kinora::render {

namespace {

// What decides a placement's material; the first placement of each lends its place to messages.
struct Ask {
  scene::NetworkPtr network;  // null: a plain surface of the Color attribute
  const scene::Attributes* attributes;
  const scene::Primitive* primitive;
};

// Which asks differ, and which of them each kind of placement has.
struct Asks {
  std::vector<Ask> list;
  std::vector<uint32_t> ofKind;
  std::map<std::string, std::pair<SourcePos, std::string>> standIns;  // surface shader -> what stands in
};

using Color = std::array<float, 3>;

// Ambient lights by id. Surface shaders weigh them apart from all other light (Ka), so that they reach a classic
// material as a colour.
std::map<uint32_t, Color> ambientLights(const std::vector<scene::Light>& lights) {
  std::map<uint32_t, Color> found;
  for (const scene::Light& l : lights) {
    if (!isAmbient(l) || (l.attributes && l.attributes->getInt("lighting:mute", 0))) continue;
    const float intensity = l.node->params.getFloat("intensity", 1);
    const std::vector<float> c = l.node->params.getFloats("lightColor");
    for (size_t k = 0; k < 3; ++k) found[l.id][k] = intensity * (c.size() == 3 ? c[k] : 1);
  }
  return found;
}

const scene::Node* defaultSurface() {
  static const scene::Node kNode = [] {
    scene::Node n;
    n.kind = "Surface";
    n.plugin = "defaultsurface";
    return n;
  }();
  return &kNode;
}

// The materials of objects without a Bxdf, from their Surface shader and their Opacity.
class ClassicMaterials {
 public:
  ClassicMaterials(const Materials::Tools& tools, Asks& asks)
      : ambient_(ambientLights(tools.lights)), clipping_(tools.clipping), isClassic_(tools.isClassic), asks_(asks) {}
  // Null where attributes say nothing of the kind.
  scene::NetworkPtr of(const scene::Attributes* a, const scene::Primitive& p) {
    shade::ClassicLook look;
    look.surface = surfaceOf(a);
    // renderers showed what neither a shader nor a light was for as lit from the eye
    const bool isUnlit = !a || !a->lightSources || a->lightSources->empty();
    if (!look.surface && isClassic_ && isUnlit && !(a && a->bxdf)) look.surface = defaultSurface();
    look.hasColor = (a && a->color) || p.primvars.find("Cs");
    look.hasOpacities = p.primvars.find("Os") != nullptr;
    if (a && a->opacity) look.opacity = *a->opacity;
    look.clipping = clipping_;
    for (const scene::NodePtr& n : a ? a->classicShaders : std::vector<scene::NodePtr>())
      if (shade::isAtmosphere(*n)) look.atmosphere = n.get();
    if (!look.surface && !look.atmosphere && !look.hasOpacities && look.opacity == Color{1, 1, 1}) return nullptr;
    for (const uint32_t id : a && a->lightSources ? *a->lightSources : std::vector<uint32_t>())
      if (const auto it = ambient_.find(id); it != ambient_.end())
        for (size_t k = 0; k < 3; ++k) look.ambient[k] += it->second[k];
    scene::NetworkPtr& made =
        made_[{look.surface, look.atmosphere, look.opacity, look.hasColor, look.hasOpacities, look.ambient}];
    if (made) return made;
    shade::ClassicMaterial m = shade::classicMaterial(look);
    if (!m.standIn.empty()) asks_.standIns.try_emplace(look.surface->plugin, look.surface->pos, m.standIn);
    return made = m.network;
  }

 private:
  std::map<uint32_t, Color> ambient_;
  std::array<float, 2> clipping_;
  bool isClassic_;
  Asks& asks_;
  std::map<std::tuple<const scene::Node*, const scene::Node*, Color, bool, bool, Color>, scene::NetworkPtr> made_;
};

Asks asksOf(const FlatScene& flat, const Materials::Tools& tools) {
  Asks asks;
  ClassicMaterials classic(tools, asks);
  PrimitiveStrings strings(tools.diagnostics);
  std::map<Color, scene::NetworkPtr> colored;  // geometry without a material shows its Cs
  std::map<std::tuple<const scene::Network*, Color, bool, std::string>, uint32_t> known;
  asks.ofKind.reserve(flat.kinds.size());
  for (size_t k = 0; k < flat.kinds.size(); ++k) {
    const scene::Attributes* a = flat.attributes[k];
    const scene::Primitive& p = *flat.shapeOf(flat.kinds[k]).primitive;
    scene::NetworkPtr network = a ? strings.completed(a->bxdf, p) : nullptr;
    if (!network) network = classic.of(a, p);
    if (!network && p.primvars.find("Cs")) {
      scene::NetworkPtr& made = colored[a && a->color ? *a->color : Color{1, 1, 1}];
      if (!made) made = shade::colorPrimvarNetwork(a);
      network = made;
    }
    const bool hasColor = !network && a && a->color;
    const auto [it, isNew] = known.try_emplace({network.get(), hasColor ? *a->color : Color{}, hasColor,
                                                a ? a->named.getString("identifier:lpegroup", "") : std::string()},
                                               uint32_t(asks.list.size()));
    if (isNew) asks.list.push_back({std::move(network), a, &p});
    asks.ofKind.push_back(it->second);
  }
  return asks;
}

Digest digestOf(const Ask& ask, scene::NetworkDigests& networks) {
  Hasher h;
  h.word(ask.network != nullptr);
  h.digest(networks.of(ask.network));
  const bool hasColor = !ask.network && ask.attributes && ask.attributes->color;
  h.word(hasColor);
  if (hasColor) h.bytes(ask.attributes->color->data(), sizeof *ask.attributes->color);
  h.text(ask.attributes ? ask.attributes->named.getString("identifier:lpegroup", "") : std::string());
  return h.result();
}

}  // namespace

std::shared_ptr<const shade::MaterialSet> Materials::make(const FlatScene& flat, const Tools& tools,
                                                          std::vector<shade::PlacementInfo>& infos, Rebuilt& made) {
  const Asks asks = asksOf(flat, tools);
  std::vector<Digest> asked;
  for (const Ask& a : asks.list) asked.push_back(digestOf(a, digests_));
  digests_.forgetOthers();
  if (set_ && asked == asked_ && paths_ == tools.paths && shaders_ == tools.shadersInUse) {
    tools.contents.again(files_);
  } else {
    set_ = nullptr;
    paths_ = tools.paths;
    files_.clear();
    ofAsk_.clear();
    auto set = std::make_shared<shade::MaterialSet>(tools.registry, tools.diagnostics, tools.textures, tools.width,
                                                    *tools.paths, tools.shaders);
    {
      const FileContents::Listening listening(tools.contents, files_);
      for (const Ask& a : asks.list) ofAsk_.push_back(set->add(a.network, a.attributes, a.primitive->pos));
    }
    for (const auto& [name, what] : asks.standIns)
      tools.diagnostics.warning("CLASSIC-SURFACE", what.first, "no Surface shader '" + name + "'", what.second,
                                "shaders of the RenderMan Shading Language are not run");
    set->finish();
    made.materials += set->size();
    asked_ = std::move(asked);
    shaders_ = tools.shadersInUse;
    set_ = std::move(set);
  }
  for (size_t k = 0; k < infos.size(); ++k) infos[k].material = ofAsk_[asks.ofKind[k]];
  return set_;
}

}  // namespace kinora::render
