#include "shade/layered_bxdfs.h"

#include <kinora/lama_limits.h>

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.h"
#include "shade/material.h"

namespace kinora::shade {

namespace {

constexpr int kMaxLeaves = lama::kMaxLeaves, kMaxBelow = lama::kMaxBelow, kLobeNames = lama::kLobeNames;
constexpr int kMaxVisits = 256;
constexpr int kMaxHairLeaves = 4;  // of plugins/bxdf/LamaHairSurface

struct Slot {
  const char *from, *to;
};
// A leaf: its letters in a structure by fresnelMode, alone or at the bottom and (on) lying on something, and where its
// parameters go. Rows of the same plug-in and another mode differ in what they read.
struct LeafRow {
  const char* plugin;
  int mode;  // -1: any
  char alone, on;
  std::initializer_list<Slot> slots;
};
// Of facets; some slabs name the direction of anisotropy otherwise than others.
#define KINORA_FACET_SLOTS(DIRECTION, ROTATION) \
  {"roughness", "roughness"}, {"anisotropy", "anisotropy"}, {DIRECTION, "direction"}, { ROTATION, "rotation" }
const LeafRow kLeaves[] = {
    {"LamaDiffuse", -1, 'D', 'D', {{"color", "color"}, {"roughness", "roughness"}}},
    {"LamaConductor",
     0,
     'C',
     'C',
     {{"tint", "color"},
      {"IOR", "second"},
      {"extinction", "third"},
      KINORA_FACET_SLOTS("anisotropyDirection", "anisotropyRotation")}},
    {"LamaConductor",
     1,
     'A',
     'A',
     {{"tint", "color"},
      {"reflectivity", "second"},
      {"edgeColor", "third"},
      KINORA_FACET_SLOTS("anisotropyDirection", "anisotropyRotation")}},
    {"LamaDielectric",
     0,
     'g',
     'r',
     {{"reflectionTint", "color"},
      {"transmissionTint", "through"},
      KINORA_FACET_SLOTS("direction", "rotation"),
      {"reflectivity", "ior"}}},
    {"LamaDielectric",
     1,
     'G',
     'R',
     {{"reflectionTint", "color"},
      {"transmissionTint", "through"},
      KINORA_FACET_SLOTS("direction", "rotation"),
      {"IOR", "ior"}}},
    {"LamaGeneralizedSchlick",
     0,
     's',
     's',
     {{"reflectionTint", "color"},
      {"transmissionTint", "through"},
      {"IOR", "second"},
      {"reflectivity90", "third"},
      KINORA_FACET_SLOTS("anisotropyDirection", "anisotropyRotation"),
      {"reflectivityProfile", "amount"}}},
    {"LamaGeneralizedSchlick",
     1,
     'S',
     'S',
     {{"reflectionTint", "color"},
      {"transmissionTint", "through"},
      {"reflectivity", "second"},
      {"reflectivity90", "third"},
      KINORA_FACET_SLOTS("anisotropyDirection", "anisotropyRotation"),
      {"reflectivityProfile", "amount"}}},
    {"LamaIridescence",
     -1,
     'F',
     'F',
     {{"tint", "color"},
      {"filmIOR", "ior"},
      {"relativeFilmThickness", "amount"},
      {"minFilmThickness", "second"},
      {"maxFilmThickness", "third"},
      {"roughness", "roughness"},
      {"anisotropy", "anisotropy"},
      {"direction", "direction"}}},
    {"LamaSheen", -1, 'H', 'H', {{"color", "color"}, {"roughness", "roughness"}}},
    {"LamaTranslucent", -1, 'T', 'T', {{"color", "color"}}},
    {"LamaEmission", -1, 'E', 'E', {{"color", "color"}}},
};
#undef KINORA_FACET_SLOTS

struct OpRow {
  const char* plugin;
  char letter;
  const char *below, *above;   // inputs
  const char *amount, *other;  // numbers; null: none
};
constexpr OpRow kOps[] = {{"LamaLayer", 'L', "materialBase", "materialTop", "topMix", nullptr},
                          {"LamaMix", 'M', "material1", "material2", "mix", nullptr},
                          {"LamaAdd", 'P', "material1", "material2", "weight1", "weight2"}};

const OpRow* opOf(const scene::Node& n) {
  for (const OpRow& row : kOps)
    if (sameName(n.plugin, row.plugin)) return &row;
  return nullptr;
}

constexpr const char* kHairPlugin = "LamaHairChiang";
// Its parameters, which LamaHairSurface has for each leaf.
constexpr const char* kHairParams[] = {"colorMode",          "colorR",       "colorTT",
                                       "colorTintTT",        "colorTintTRT", "eumelanin",
                                       "pheomelanin",        "absorption",   "longitudinalRoughness",
                                       "azimuthalRoughness", "offset",       "IOR"};
// What may stand beside it, with its letter there. on: it lies on something.
char besideHair(const scene::Node& n, bool on) {
  if (on && sameName(n.plugin, "LamaDielectric")) return n.params.getInt("fresnelMode", 0) == 1 ? 'R' : 'r';
  return sameName(n.plugin, kHairPlugin)         ? 'I'
         : sameName(n.plugin, "LamaDiffuse")     ? 'D'
         : sameName(n.plugin, "LamaTranslucent") ? 'T'
                                                 : 0;
}

// Whether LamaSurface takes a structure that was written by hand.
bool isTree(std::string_view text) {
  int open = 0, leaves = 0, below = 0;
  for (const char letter : text) {
    if (std::string_view("LMP").find(letter) != std::string_view::npos) {
      if (--open < 1) return false;
    } else {
      if (std::string_view("DCAGgRrSsFHTEUVXWYZQ").find(letter) == std::string_view::npos) return false;
      ++open;
      below += (letter >= 'U' && letter <= 'Z') || letter == 'Q';
      if (++leaves > kMaxLeaves || below > kMaxBelow) return false;
    }
  }
  return open == 1;
}

class Flattener {
 public:
  Flattener(const scene::Network& network, Registry& registry, Diagnostics& diagnostics)
      : network_(network), registry_(registry), diagnostics_(diagnostics) {}

  scene::NetworkPtr flat(const scene::Node& terminal, const scene::Node* root) {
    if (root) survey(*root, false);
    visits_ = 0;
    isOfHair_ = holdsHair_ && !holdsOthers_;
    mostLeaves_ = isOfHair_ ? kMaxHairLeaves : kMaxLeaves;
    node_.kind = "Bxdf";
    node_.plugin = isOfHair_ ? "LamaHairSurface" : "LamaSurface";
    node_.handle = terminal.handle;
    node_.pos = terminal.pos;
    const auto isForAll = [&](const std::string& name) {
      if (isOfHair_) return sameName(name, "presence") || sameName(name, "shadowColor");
      return !sameName(name, "materialFront") && !sameName(name, "materialBack");
    };
    if (&terminal != root)
      for (const scene::Parameter& p : terminal.params)
        if (isForAll(p.name)) node_.params.set(p);
    if (!root || !add(*root, false)) {
      tell(terminal.pos, "no slab is connected to the material '" + terminal.handle + "'", "the surface is black");
      black();
    }
    scene::Parameter structure;
    structure.name = "structure";
    structure.type = scene::ValueType::String;
    structure.strings = {structure_};
    node_.params.set(structure);
    for (size_t k = 0; k < lobeNames_.size(); ++k) {
      structure.name = "lobeName" + std::to_string(k + 1);
      structure.strings = {lobeNames_[k]};
      node_.params.set(structure);
    }
    auto network = std::make_shared<scene::Network>();
    for (const scene::NodePtr& p : network_.patterns)
      if (p->kind != "Bxdf") network->patterns.push_back(p);
    network->terminal = std::make_shared<scene::Node>(std::move(node_));
    return network;
  }
  // A material that is no slab but a root by itself.
  scene::NetworkPtr alone(const scene::Node& terminal, const scene::Node& root) const {
    auto network = std::make_shared<scene::Network>();
    for (const scene::NodePtr& p : network_.patterns)
      if (p->kind != "Bxdf") network->patterns.push_back(p);
    scene::Node node = root;
    node.handle = terminal.handle;
    if (const scene::Parameter* p = terminal.params.find("presence")) node.params.set(*p);
    network->terminal = std::make_shared<scene::Node>(std::move(node));
    return network;
  }
  // What an input is connected to.
  const scene::Node* input(const scene::Node& n, std::string_view name) const {
    for (const scene::Parameter& p : n.params) {
      if (!sameName(p.name, name) || p.strings.empty()) continue;
      const std::string handle = p.strings[0].substr(0, p.strings[0].find(':'));
      for (const scene::NodePtr& q : network_.patterns)
        if (q->handle == handle) return q.get();
    }
    return nullptr;
  }
  void tell(const SourcePos& pos, const std::string& what, const std::string& done) {
    diagnostics_.warning("BXDF-LAYERS", pos, what, done);
  }

 private:
  const scene::Network& network_;
  Registry& registry_;
  Diagnostics& diagnostics_;
  scene::Node node_;
  std::string structure_;
  std::vector<std::string> lobeNames_;
  int leaves_ = 0, ops_ = 0, visits_ = 0, below_ = 0;
  bool told_ = false, isFilled_ = false;
  bool holdsHair_ = false, holdsOthers_ = false, isOfHair_ = false;  // others: than those of besideHair()
  int mostLeaves_ = kMaxLeaves;

  // What a tree is made of, as far as it will be read; false where nothing comes of it, as add() says.
  bool survey(const scene::Node& n, bool on) {
    if (++visits_ > kMaxVisits) return false;
    const OpRow* op = opOf(n);
    if (!op) {
      const char letter = besideHair(n, on);
      holdsHair_ = holdsHair_ || letter == 'I';
      holdsOthers_ = holdsOthers_ || !letter;
      return true;
    }
    const scene::Node *below = input(n, op->below), *above = input(n, op->above);
    const bool hasBelow = below && survey(*below, on);
    return (above && survey(*above, on || (hasBelow && op->letter == 'L'))) || hasBelow;
  }
  // Appends a node's tree; false where nothing came of it. on: it lies on something.
  bool add(const scene::Node& n, bool on) {
    // nodes are few, but each may be read twice by the next: a chain of them would be a tree without end
    if (++visits_ > kMaxVisits || leaves_ == mostLeaves_) {
      if (!told_)
        tell(n.pos, "the material '" + node_.handle + "' has more than " + std::to_string(mostLeaves_) + " leaves",
             "'" + n.handle + "' and those after it are left out");
      told_ = true;
      return false;
    }
    const OpRow* op = opOf(n);
    if (!op) return leaf(n, on);
    const Descriptor* d = registry_.find(Kind::Bxdf, op->plugin, diagnostics_, n.pos);
    if (d) ResolvedParams(*d, &n, diagnostics_);  // for its messages
    const scene::Node *below = input(n, op->below), *above = input(n, op->above);
    bool hasBelow = below && add(*below, on);
    // The half that is not there returns no light; what is there keeps its place. A top that shows in part and has no
    // base shows by a mix: it may be glass, which lies on nothing.
    const bool isBareTop = op->letter == 'L' && !hasBelow && above && showsInPart(n, op->amount);
    const bool wantsBelow = !hasBelow && above && (op->letter != 'L' || isBareTop) && leaves_ + 1 < mostLeaves_;
    if (wantsBelow) black();
    bool hasAbove = above && add(*above, on || (hasBelow && op->letter == 'L'));
    if (wantsBelow && !hasAbove) {
      structure_.pop_back();
      node_.params.erase("leaf" + std::to_string(leaves_--) + "_color");
    }
    hasBelow = hasBelow || (wantsBelow && hasAbove);
    if (op->letter != 'L' && hasBelow && !hasAbove && leaves_ < mostLeaves_) {
      black();
      hasAbove = true;
    }
    if (hasBelow && hasAbove) return combine(n, *op, d, isBareTop ? 'M' : op->letter);
    return hasBelow || hasAbove;
  }
  static bool showsInPart(const scene::Node& n, const char* amount) {
    for (const scene::Parameter& p : n.params)
      if (sameName(p.name, amount)) return p.isReference || n.params.getFloat(p.name, 1.f) < 1;
    return false;
  }
  bool combine(const scene::Node& n, const OpRow& op, const Descriptor* d, char letter) {
    structure_ += letter;
    const std::string prefix = "op" + std::to_string(++ops_) + "_";
    copy(n, d, op.amount, prefix + "amount");
    if (op.other) copy(n, d, op.other, prefix + "other");
    return true;
  }
  // LamaSSS and LamaTricolorSSS: where their values go there is room for kMaxBelow.
  bool subsurface(const scene::Node& n, bool isThree) {
    const Descriptor* d = registry_.find(Kind::Bxdf, isThree ? "LamaTricolorSSS" : "LamaSSS", diagnostics_, n.pos);
    if (!d) return false;
    ResolvedParams(*d, &n, diagnostics_);  // for its messages
    const bool isFull = below_ == kMaxBelow;
    if (isFull)
      tell(n.pos,
           "the material '" + node_.handle + "' has more than " + std::to_string(kMaxBelow) +
               " slabs that scatter below the surface",
           "a diffuse slab stands in for '" + n.handle + "'");
    const bool areFlights = n.params.getInt("albedoInversionMethod", 0) == 1;
    constexpr char kLetters[2][4] = {{'U', 'X', 'Y', 'Z'}, {'V', 'W', 'Y', 'Z'}};
    const int mode = std::clamp(n.params.getInt("sssMode", 0), 0, 3);
    const std::string prefix = next(isFull ? 'D' : isThree ? 'Q' : kLetters[areFlights][mode]);
    nameLobes(n, prefix);
    if (isThree)
      copy(n, d, "nearColor", prefix + "color");
    else
      copy(n, d, n.params.find("sssColor") ? "sssColor" : "color", prefix + "color");
    copy(n, d, n.params.find("sssNormal") ? "sssNormal" : "normal", prefix + "normal");
    copy(n, d, "bumpShadowing", prefix + "bumpShadowing");
    if (isFull) return true;
    const std::string own = below_++ ? "sss2" : "sss";
    for (const char* name : {"Radius", "Scale", "UnitLength", "Anisotropy", "Bleed", "Subset", "ContinuationRays",
                             "IOR", "FollowTopology"})
      copy(n, d, ("sss" + std::string(name)).c_str(), own + name);
    if (!isThree) return true;
    for (const char* name :
         {"nearWeight", "midWeight", "farWeight", "nearRadius", "midRadius", "farRadius", "midColor", "farColor"})
      copy(n, d, name, own + char(name[0] - 'a' + 'A') + (name + 1));
    // their lengths are grey: radii times sssScale
    scene::Parameter grey;
    grey.name = own + "Radius";
    grey.type = scene::ValueType::Color;
    grey.floats = {1, 1, 1};
    node_.params.set(std::move(grey));
    return true;
  }
  bool leaf(const scene::Node& n, bool on) {
    // one for the whole surface: light that passes it has passed all slabs
    const scene::Parameter* shadow = n.params.find("shadowColor");
    if (shadow && !node_.params.find("shadowColor") &&
        (shadow->isReference ||
         std::any_of(shadow->floats.begin(), shadow->floats.end(), [](float x) { return x != 0; })))
      node_.params.set(*shadow);
    if (isOfHair_) return leafOfHair(n, on);
    const bool isThree = sameName(n.plugin, "LamaTricolorSSS");
    if ((isThree || sameName(n.plugin, "LamaSSS")) && subsurface(n, isThree)) return true;
    for (const LeafRow& row : kLeaves) {
      if (!sameName(n.plugin, row.plugin)) continue;
      const Descriptor* d = registry_.find(Kind::Bxdf, row.plugin, diagnostics_, n.pos);
      if (!d) break;
      if (row.mode >= 0 && row.mode != n.params.getInt("fresnelMode", 0)) continue;
      ResolvedParams(*d, &n, diagnostics_);  // for its messages
      const std::string prefix = next(on ? row.on : row.alone);
      nameLobes(n, prefix);
      for (const Slot& s : row.slots) copy(n, d, s.from, prefix + s.to);
      // the first glass bounds what is inside
      if (!on && sameName(row.plugin, "LamaDielectric") && !std::exchange(isFilled_, true))
        for (const char* name : {"absorptionColor", "absorptionRadius", "scatterColor", "scatterAnisotropy"})
          copy(n, d, name, name);
      if (sameName(row.plugin, "LamaDiffuse") && n.params.find("diffuseColor"))
        copy(n, d, "diffuseColor", prefix + "color");
      copy(n, d, "normal", prefix + "normal");
      copy(n, d, "bumpShadowing", prefix + "bumpShadowing");
      return true;
    }
    // keeps the look where the node says a colour
    const std::string prefix = next('D');
    const char* said = nullptr;
    for (const char* name : {"color", "diffuseColor", "sssColor", "baseColor", "colorTT"})
      if (!said && n.params.find(name)) said = name;
    scene::Parameter p;
    p.type = scene::ValueType::Color;
    p.floats = {0.8f, 0.f, 0.8f};
    if (said) p = *n.params.find(said);
    p.name = prefix + "color";
    node_.params.set(std::move(p));
    tell(
        n.pos,
        "the bxdf '" + n.plugin + "' (node '" + n.handle + "') " +
            (besideHair(n, on) ? "can be layered, mixed and summed with hair, LamaDiffuse, LamaTranslucent and coats "
                                 "of LamaDielectric alone"
                               : "is no slab that layers are made of"),
        said ? std::string("a diffuse slab of its ") + said + " stands in" : "a magenta diffuse slab stands in");
    return true;
  }
  // In a material of hair, in which all leaves are those of besideHair().
  bool leafOfHair(const scene::Node& n, bool on) {
    const char letter = besideHair(n, on);
    if (!letter) return false;  // beyond what was surveyed
    const Descriptor* d = registry_.find(Kind::Bxdf, n.plugin, diagnostics_, n.pos);
    if (!d) return false;
    ResolvedParams(*d, &n, diagnostics_);  // for its messages
    const std::string prefix = next(letter);
    nameLobes(n, prefix);
    if (letter == 'I') {
      for (const char* name : kHairParams) copy(n, d, name, prefix + name);
      return true;
    }
    if (letter == 'R' || letter == 'r') {
      for (const Slot& s : {Slot{"reflectionTint", "color"}, Slot{"transmissionTint", "through"},
                            Slot{letter == 'R' ? "IOR" : "reflectivity", "coatIOR"}})
        copy(n, d, s.from, prefix + s.to);
    } else {
      copy(n, d, letter == 'D' && n.params.find("diffuseColor") ? "diffuseColor" : "color", prefix + "color");
    }
    if (letter != 'T') copy(n, d, "roughness", prefix + "roughness");
    if (const scene::Parameter* normal = n.params.find("normal"); normal && normal->isReference)
      tell(n.pos, "'" + n.handle + "' is combined with hair, which has no bumps", "its normal is the fibre's");
    return true;
  }
  // Of a leaf whose lobes have a name: which.
  void nameLobes(const scene::Node& n, const std::string& prefix) {
    const std::string name = n.params.getString("lobeName", "");
    if (name.empty()) return;
    size_t k = size_t(std::find(lobeNames_.begin(), lobeNames_.end(), name) - lobeNames_.begin());
    if (k == kLobeNames)
      return tell(n.pos,
                  "the slabs of the material '" + node_.handle + "' have more than " + std::to_string(kLobeNames) +
                      " names of lobes",
                  "the lobes of '" + n.handle + "' are not named '" + name.substr(0, 60) + "'");
    if (k == lobeNames_.size()) lobeNames_.push_back(name);
    number(prefix + "lobes", float(k + 1));
  }
  std::string next(char letter) {
    structure_ += letter;
    return "leaf" + std::to_string(++leaves_) + "_";
  }
  void black() {
    scene::Parameter p;
    p.name = next('E') + "color";
    p.type = scene::ValueType::Color;
    p.floats = {0, 0, 0};
    node_.params.set(std::move(p));
  }
  void number(const std::string& to, float value) {
    scene::Parameter p;
    p.name = to;
    p.floats = {value};
    node_.params.set(std::move(p));
  }
  // The value of a node's parameter, or its plug-in's default, as another parameter.
  void copy(const scene::Node& n, const Descriptor* d, const char* from, const std::string& to) {
    for (const scene::Parameter& q : n.params)
      if (sameName(q.name, from)) {
        scene::Parameter p = q;
        p.name = to;
        node_.params.set(std::move(p));
        return;
      }
    for (uint32_t i = 0; d && i < d->paramCount; ++i) {
      const Param& q = d->params[i];
      if (!sameName(q.name, from)) continue;
      scene::Parameter p;
      p.name = to;
      const bool isNumber = q.type == Type::Float;
      if (!isNumber && q.type != Type::Color && q.type != Type::Vector && q.type != Type::Normal) return;  // as there
      p.type = isNumber ? scene::ValueType::Float : scene::ValueType::Color;
      p.floats.assign(q.value, q.value + (isNumber ? 1 : 3));
      node_.params.set(std::move(p));
    }
  }
};

}  // namespace

scene::NetworkPtr withFlatLayers(const scene::Network& network, Registry& registry, Diagnostics& diagnostics) {
  if (!network.terminal) return nullptr;
  const scene::Node& terminal = *network.terminal;
  Flattener flattener(network, registry, diagnostics);
  if (opOf(terminal)) return flattener.flat(terminal, &terminal);
  if (!sameName(terminal.plugin, "LamaSurface")) return nullptr;
  if (terminal.params.find("structure")) {
    const std::string text = terminal.params.getString("structure", "");
    if (!isTree(text))
      flattener.tell(terminal.pos,
                     "the structure '" + text.substr(0, 40) + "' of '" + terminal.handle + "' is no tree",
                     "a diffuse surface of its first leaf's colour stands in");
    return nullptr;
  }
  const scene::Node *front = flattener.input(terminal, "materialFront"),
                    *back = flattener.input(terminal, "materialBack");
  if (!front && !back) {
    flattener.tell(terminal.pos, "no slab is connected to the material '" + terminal.handle + "'",
                   "a diffuse surface stands in");
    return nullptr;
  }
  if (back && front && back != front)
    flattener.tell(terminal.pos, "the material '" + terminal.handle + "' has another back than front",
                   "the front's is on both sides");
  const scene::Node& root = front ? *front : *back;
  if (sameName(root.plugin, kHairPlugin)) return flattener.alone(terminal, root);
  return flattener.flat(terminal, &root);
}

}  // namespace kinora::shade
