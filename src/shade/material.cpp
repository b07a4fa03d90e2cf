#include "shade/material.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <set>
#include <tuple>

#include "base/text.h"
#include "language/vm/strings.h"
#include "plugin/refused.h"
#include "plugin/types.h"
#include "shade/legacy_bxdfs.h"
#include "shade/missing_patterns.h"
#include "shade/clock.h"
#include "shade/connected_bumps.h"
#include "shade/layered_bxdfs.h"
#include "shade/ramp_check.h"
#include "shade/resolved_node.h"
#include "shade/rules_by_name.h"
#include "shade/shader_parameters.h"
#include "shade/standard_shaders.h"
#include "texture/texture_system.h"

namespace kinora::shade {

struct MaterialSet::Handles {
  std::map<std::string, int> nodes;                    // by handle, into the list of resolved nodes
  std::map<std::string, const scene::Node*> missing;   // patterns that nobody has
  std::map<std::string, scene::Node> imagesOfMissing;  // textures that stand for some of them
};

MaterialSet::MaterialSet(Registry& registry, Diagnostics& diagnostics, TextureSystem& textures, uint32_t width,
                         const film::LightPaths& paths, ShaderLibrary& shaders)
    : registry_(registry),
      diagnostics_(diagnostics),
      textures_(textures),
      width_(width),
      paths_(paths),
      shaders_(shaders) {}

bool MaterialSet::resolve(const scene::Node& node, Kind kind, Resolved& out) {
  out.plugin = registry_.find(kind, node.plugin, diagnostics_, node.pos);
  out.node = &node;
  if (!out.plugin && kind == Kind::Pattern) {
    const std::string name = shaderNameOf(node);
    if (!name.empty()) out.shader = shaders_.find(name, node.pos);
    if (out.shader) out.plugin = &out.shader->descriptor;
  }
  if (!out.plugin && kind == Kind::Displacement) {
    const std::string name = shaderNameOf(node);
    const auto shader = name.empty() ? nullptr : shaders_.find(name, node.pos);
    if (shader) out.shader = shader->shader ? shaders_.displacementOf(shader) : shader;
    if (out.shader) out.plugin = &out.shader->descriptor;
    if (shader && !out.shader)
      diagnostics_.warning("SHADER-DISPLACEMENT", node.pos,
                           "shader '" + name + "' (node '" + node.handle + "') writes no P", "it moves nothing",
                           "bump() and N alone belong to the material");
  }
  if (!out.plugin) return false;
  std::optional<StandardShader> standard;
  if (kind == Kind::Pattern && !out.shader) standard = standardShader(node, shaders_);
  if (standard) {
    out.shader = standard->shader;
    out.plugin = &out.shader->descriptor;
  }
  if (out.shader) {
    const scene::Node own = forShader(standard ? standard->node : node, *out.shader, out.wantedParts, diagnostics_);
    out.values = std::make_unique<ResolvedParams>(*out.plugin, out.shader->shader ? &own : nullptr, diagnostics_);
  } else {
    const std::optional<scene::Node> split = withElements(node, *out.plugin, diagnostics_);
    out.values = std::make_unique<ResolvedParams>(*out.plugin, split ? &*split : &node, diagnostics_);
  }
  if (kind == Kind::Pattern) tellOfRamp(node, diagnostics_);
  out.links.resize(out.plugin->paramCount);
  return true;
}

uint32_t MaterialSet::add(const scene::NetworkPtr& given, const scene::Attributes* attributes, const SourcePos& pos) {
  // objects without a bxdf differ by their Color
  std::string variant;
  scene::Node plain;
  plain.kind = "Bxdf";
  plain.plugin = "PxrDiffuse";
  plain.handle = "default";
  plain.pos = pos;
  if (!given && attributes && attributes->color) {
    scene::Parameter p;
    p.name = "diffuseColor";
    p.type = scene::ValueType::Color;
    p.floats.assign(attributes->color->begin(), attributes->color->end());
    for (float f : p.floats) variant += std::to_string(f) + ",";
    plain.params.set(p);
  }
  std::string lpeGroup = attributes ? attributes->named.getString("identifier:lpegroup", "") : "";
  if (!paths_.usesSurface(lpeGroup)) lpeGroup.clear();
  const std::pair<const void*, std::string> id(given.get(), variant + '\1' + lpeGroup);
  if (const auto it = known_.find(id); it != known_.end()) return it->second;
  keepAlive_[given.get()] = given;
  if (given) noEffect_.tell(*given, Kind::Bxdf, registry_, diagnostics_);
  const scene::NetworkPtr bumped = given ? withConnectedBumps(*given, registry_, diagnostics_) : nullptr;
  if (bumped) keepAlive_[bumped.get()] = bumped;
  const scene::NetworkPtr& whole = bumped ? bumped : given;
  const scene::NetworkPtr flat = whole ? withFlatLayers(*whole, registry_, diagnostics_) : nullptr;
  if (flat) keepAlive_[flat.get()] = flat;
  const scene::NetworkPtr& network = flat ? flat : whole;

  std::vector<Resolved> nodes;
  Handles handles;
  if (network) addPatterns(*network, nodes, handles);
  Resolved terminal;
  scene::Node fallback = plain;
  const scene::Node* node = network && network->terminal ? network->terminal.get() : &plain;
  if (!resolve(*node, Kind::Bxdf, terminal)) {
    const std::string who = "no bxdf '" + node->plugin + "' (node '" + node->handle + "')";
    if (std::optional<scene::Node> near = modernBxdfFor(*node)) {
      diagnostics_.warning("PLUGIN-STAND-IN", node->pos, who,
                           near->plugin + " stands in, with its colours and roughness");
      fallback = std::move(*near);
    } else {
      // keeps the look where the missing material says a colour, else magenta
      std::string done = "a magenta diffuse material stands in";
      scene::Parameter p;
      p.name = "diffuseColor";
      p.type = scene::ValueType::Color;
      p.floats = {0.8f, 0.f, 0.8f};
      if (const scene::Parameter* color = colorOfMissingBxdf(*node)) {
        p = *color;
        p.name = "diffuseColor";
        done = "a diffuse material of its " + color->name + " stands in";
      }
      diagnostics_.warning("PLUGIN-MISSING", node->pos, who, done, adviceOnMissing(Kind::Bxdf, node->plugin));
      fallback.handle = node->handle;
      fallback.params.set(p);
    }
    resolve(fallback, Kind::Bxdf, terminal);
  }
  nodes.push_back(std::move(terminal));

  connect(nodes, handles);
  const uint32_t m = addResolved(nodes, lpeGroup);
  known_[id] = m;
  return m;
}

uint32_t MaterialSet::addDisplacement(const scene::NetworkPtr& network) {
  const std::pair<const void*, std::string> id(network.get(), "");
  if (const auto it = known_.find(id); it != known_.end()) return it->second;
  keepAlive_[network.get()] = network;
  noEffect_.tell(*network, Kind::Displacement, registry_, diagnostics_);
  const scene::Node& node = *network->terminal;
  std::vector<Resolved> nodes;
  Handles handles;
  addPatterns(*network, nodes, handles);
  Resolved terminal;
  if (!resolve(node, Kind::Displacement, terminal)) {
    const std::string shader = shaderNameOf(node);
    if (shader.empty() || !shaders_.find(shader, node.pos))
      diagnostics_.warning(
          "PLUGIN-MISSING", node.pos, "no displacement '" + node.plugin + "' (node '" + node.handle + "')",
          "surfaces are where they are without it", adviceOnMissing(Kind::Displacement, node.plugin));
    return known_[id] = kNone;
  }
  if (terminal.shader) {
    if (!terminal.shader->shader) return known_[id] = kNone;  // told when it was compiled
    nodes.push_back(std::move(terminal));
    connect(nodes, handles);
    // what reads the point that the shader has moved
    static constexpr Param kPlace[] = {Param{.name = "P", .type = Type::Point},
                                       Param{.name = "N", .type = Type::Normal}};
    static constexpr Descriptor kMoves{kAbiVersion,
                                       sizeof(Descriptor),
                                       Kind::Displacement,
                                       0,
                                       "moved point",
                                       "",
                                       kPlace,
                                       2,
                                       nullptr,
                                       0,
                                       nullptr,
                                       nullptr,
                                       nullptr};
    Resolved reader;
    reader.plugin = &kMoves;
    reader.node = &node;
    reader.values = std::make_unique<ResolvedParams>(kMoves, nullptr, diagnostics_);
    reader.links.resize(2);
    uint32_t output = 0;
    const Descriptor& shader = *nodes.back().plugin;
    for (uint32_t i = 0; i < shader.paramCount; ++i) {
      if (!(shader.params[i].flags & kParamOutput)) continue;
      for (const uint32_t to : {0u, 1u})
        if (!std::strcmp(shader.params[i].name, to ? kMovedNormal : kMovedPoint)) {
          reader.values->connect(to);
          reader.links[to] = {int(nodes.size() - 1), output, -1};
        }
      ++output;
    }
    nodes.push_back(std::move(reader));
    return known_[id] = addResolved(nodes, "");
  }
  const auto* traits = static_cast<const DisplacementTraits*>(terminal.plugin->traits);
  const CreateInfo info{nullptr, node.handle.c_str(), terminal.values->values(), terminal.values->count(), nullptr,
                        nullptr};
  if (traits && traits->bound && traits->bound(&info) == 0) return known_[id] = kNone;
  nodes.push_back(std::move(terminal));
  connect(nodes, handles);
  return known_[id] = addResolved(nodes, "");
}

void MaterialSet::addPatterns(const scene::Network& network, std::vector<Resolved>& nodes, Handles& handles) {
  for (const scene::NodePtr& p : network.patterns) {
    Resolved r;
    if (!resolve(*p, Kind::Pattern, r)) {
      const std::string shader = sameName(p->plugin, "PxrOSL") ? p->params.getString("shader", "") : "";
      diagnostics_.warning(
          "PLUGIN-MISSING", p->pos,
          (shader.empty() ? "no pattern '" + p->plugin : "no shader '" + shader) + "' (node '" + p->handle + "')",
          describeStandIn(*p),
          shader.empty() ? adviceOnMissing(Kind::Pattern, p->plugin)
                         : "is its folder on the search path for shaders?");
      handles.missing[p->handle] = p.get();
      const std::optional<scene::Node> texture = textureOfMissing(*p);
      if (!texture || !resolve(handles.imagesOfMissing[p->handle] = *texture, Kind::Pattern, r)) continue;
    }
    nodes.push_back(std::move(r));
    handles.nodes[p->handle] = int(nodes.size() - 1);
  }
}

// Follows what each node's parameters are connected to.
void MaterialSet::connect(std::vector<Resolved>& nodes, const Handles& handles) {
  for (size_t n = 0; n < nodes.size(); ++n) {
    Resolved& r = nodes[n];
    // What "handle:output" names; node -1 after a message.
    const auto follow = [&](const auto& self, const std::string& ref, uint32_t i, int32_t toPart,
                            Resolved::Link& link, int passed) -> void {
      const Param& to = r.plugin->params[i];
      const size_t colon = ref.rfind(':');
      const std::string handle = ref.substr(0, colon);
      std::string output = colon == std::string::npos ? "result" : ref.substr(colon + 1);
      const auto it = handles.nodes.find(handle);
      const auto warn = [&](const std::string& what) {
        diagnostics_.warning("PARAM-CONNECTION", r.node->pos,
                             std::string(r.plugin->name) + "." + to.name +
                                 (toPart < 0 ? "" : "[" + std::to_string(toPart) + "]") + " of '" + r.node->handle +
                                 "' is connected to '" + ref + "': " + what,
                             "its default is used");
      };
      const auto missing = handles.missing.find(handle);
      if (missing != handles.missing.end() && to.type == Type::Color && toPart < 0) {
        constexpr int kMostPassed = 16;  // missing patterns that hand on each other's colours
        const scene::Parameter* color = colorOfMissing(*missing->second, output);
        if (color && color->isReference && passed < kMostPassed)
          return self(self, color->strings[0], i, toPart, link, passed + 1);
        if (color && !color->isReference)
          return r.values->setColor(i, color->floats[0], color->floats[1], color->floats[2]);
        output = "resultRGB";  // of the texture that stands for it
      }
      if (it == handles.nodes.end() || size_t(it->second) >= n)
        return warn(missing != handles.missing.end() ? "that node's plug-in is missing"
                                                     : "there is no such node before it");
      const Resolved& from = nodes[size_t(it->second)];
      if (from.shader && !from.shader->shader) {                     // told when it was compiled
        if (to.type == Type::Color) r.values->setColor(i, 1, 0, 1);  // magenta
        return;
      }
      const auto find = [&] {
        uint32_t index = 0;
        for (uint32_t k = 0; k < from.plugin->paramCount; ++k) {
          if (!(from.plugin->params[k].flags & kParamOutput)) continue;
          if (sameName(from.plugin->params[k].name, output)) return std::pair(index, &from.plugin->params[k]);
          ++index;
        }
        return std::pair(index, static_cast<const Param*>(nullptr));
      };
      int32_t part = -1;
      auto [index, found] = find();
      if (!found && from.shader && (part = splitIndex(output)) >= 0) std::tie(index, found) = find();
      if (!found) return warn(std::string(from.plugin->name) + " has no output '" + output + "'");
      std::string problem;
      if (from.shader || r.shader)
        problem = connectionProblem(*found, from.shader != nullptr, part, to, r.shader != nullptr, toPart);
      else if ((found->type == Type::Struct) != (to.type == Type::Struct))
        problem = "the types do not fit";
      if (problem.empty() && toPart >= 0 && r.shader && !from.shader)
        problem = "only a shader can feed a part of a parameter";
      if (!problem.empty()) return warn(problem);
      link = {it->second, index, part};
    };
    for (uint32_t i = 0; i < r.plugin->paramCount; ++i) {
      const ParamValue& v = r.values->values()[i];
      if (v.connected && r.plugin->params[i].flags & kParamArray && !r.shader) {
        // a plug-in reads no array of outputs: they are patterns that show something, and are named to be there
        const std::vector<std::string>& named = r.values->texts(i);
        Resolved::Link unread;
        for (size_t k = 0; k < named.size(); ++k) follow(follow, named[k], i, int32_t(k), unread, 0);
        continue;
      }
      if (v.connected && v.strings) follow(follow, v.strings[0], i, -1, r.links[i], 0);
    }
    for (const PartReference& wanted : r.wantedParts) {
      Resolved::Link link;
      follow(follow, wanted.from, wanted.parameter, wanted.part, link, 0);
      if (link.node >= 0)
        r.parts.push_back({wanted.parameter, wanted.part, uint32_t(link.node), link.output, link.part});
    }
    for (uint32_t i = 0; i < r.plugin->paramCount; ++i)
      if (r.plugin->params[i].type == Type::Struct && r.links[i].node >= 0) connectMembers(nodes, r, i);
    switchOffEmpty(r);
  }
}

uint32_t MaterialSet::addResolved(std::vector<Resolved>& nodes, const std::string& lpeGroup) {
  // The key names all that materials of one program have in common.
  std::string key;
  const auto put = [&](const void* p, size_t n) { key.append(static_cast<const char*>(p), n); };
  const Resolved& last = nodes.back();
  const bool isBxdf = last.plugin->kind == Kind::Bxdf;
  const auto* traits = isBxdf ? static_cast<const BxdfTraits*>(last.plugin->traits) : nullptr;
  const bool encloses =
      traits && traits->enclosesMedium && traits->enclosesMedium(last.values->values(), last.values->count());
  const auto* functions = isBxdf ? static_cast<const BxdfFunctions*>(functionsFor(*last.plugin, width_)) : nullptr;
  const ShadowsCast shadows = isBxdf ? shadowsCast(last) : ShadowsCast();
  const bool tints =
      traits && functions->thinShadow && !shadows.isColorAll &&
      (traits->letsShadowsThrough ? traits->letsShadowsThrough(last.values->values(), last.values->count()) != 0
                                  : encloses);
  const bool fillsSpace = isBxdf && (last.plugin->flags & kBxdfFillsSpace) && functions->medium;
  const uint32_t mediumFlags =
      fillsSpace && traits->mediumFlags ? traits->mediumFlags(last.values->values(), last.values->count()) : 0;
  const bool scatters =
      traits && functions && functions->subsurface &&
      (!traits->scattersBelow || traits->scattersBelow(last.values->values(), last.values->count()));
  uint32_t walkableLobes =
      traits && functions && functions->interface && functions->interfaceValue && traits->walkableLobes
          ? traits->walkableLobes(last.values->values(), last.values->count())
          : 0;
  bool opaque = true;
  if (traits && traits->presenceParam >= 0) {
    const ParamValue& v = last.values->values()[traits->presenceParam];
    opaque = last.links[size_t(traits->presenceParam)].node < 0 && v.count && v.floats[0] >= 1.f;
  }
  // whether a point is there would be another draw for the walk and for the path that it finds
  if (!opaque) walkableLobes = 0;
  for (const Resolved& r : nodes) {
    put(&r.plugin, sizeof r.plugin);
    for (uint32_t i = 0; i < r.plugin->paramCount; ++i) {
      const Param& p = r.plugin->params[i];
      if (p.flags & kParamOutput) continue;
      const ParamValue& v = r.values->values()[i];
      if (r.shader) key += v.given ? 'g' : 'd';
      if (r.links[i].node >= 0) {
        put("c", 1);
        put(&r.links[i], sizeof r.links[i]);
      } else if (r.shader && p.type == Type::Int && (p.flags & kParamFixed)) {  // floats do not hold all of them
        put(v.floats, v.count * sizeof(float));
        put(r.values->ints(i).data(), r.values->ints(i).size() * sizeof(int));
        key += '\2';
      } else if (p.type == Type::String && !(p.flags & kParamFile)) {
        for (uint32_t k = 0; k < v.count; ++k) {
          key += v.strings[k];
          key += '\1';
        }
      } else if (p.flags & kParamFixed && !(p.flags & kParamFile)) {  // files are handles, gathered by point
        put(v.floats, v.count * sizeof(float));
        key += '\2';
      } else {
        key += 'v';
      }
    }
    put(r.parts.data(), r.parts.size() * sizeof(PartSource));
    key += '\3';
  }
  if (traits && traits->programKey) {
    const uint64_t k = traits->programKey(last.values->values(), last.values->count());
    put(&k, sizeof k);
  }
  key += opaque ? 'o' : 'p';
  key += encloses ? 'e' : '-';
  key += scatters ? 'u' : '-';
  key += tints ? 't' : '-';
  key += shadows.color >= 0 ? 'c' : '-';
  if (walkableLobes) key += 'w' + std::to_string(walkableLobes);
  key += char('0' + mediumFlags);
  key += lpeGroup;

  uint32_t program;
  if (const auto it = programOfKey_.find(key); it != programOfKey_.end()) {
    program = it->second;
  } else {
    program = uint32_t(programs_.size());
    programOfKey_[key] = program;
    auto made = std::make_unique<Program>();
    Program& p = *made;
    p.traits = traits;
    p.opaque = opaque;
    p.encloses = encloses;
    p.scatters = scatters;
    p.tints = tints;
    p.shadowColor = shadows.color;
    p.walkableLobes = walkableLobes;
    p.fillsSpace = fillsSpace;
    p.isFiber = isBxdf && (last.plugin->flags & kBxdfFiber);
    p.mediumFlags = mediumFlags;
    p.lpeGroup = lpeGroup;
    p.bxdf = functions;
    if (!isBxdf) p.displacement = static_cast<const DisplacementFunctions*>(functionsFor(*last.plugin, width_));
    p.isMovedByShader = !isBxdf && !p.displacement;
    for (const Resolved& r : nodes) {
      ProgramNode n;
      n.plugin = r.plugin;
      n.handle = r.node->handle;
      n.pos = r.node->pos;
      n.parts = r.parts;
      n.source = r.shader;
      n.params.resize(r.plugin->paramCount);
      for (uint32_t i = 0; i < r.plugin->paramCount; ++i) {
        const Param& q = r.plugin->params[i];
        ParamSource& s = n.params[i];
        s.components = uint8_t(std::clamp(componentsOf(q.type), 1u, 3u));
        if (q.flags & kParamOutput) {
          n.outputParam.push_back(i);
          continue;
        }
        const ParamValue& v = r.values->values()[i];
        s.given = v.given;
        if (r.links[i].node >= 0) {
          s.from = ParamSource::From::Connected;
          s.node = uint32_t(r.links[i].node);
          s.output = r.links[i].output;
          s.part = r.links[i].part;
          p.nodes[s.node].wanted[s.output] |= q.flags & kParamGradients ? kWantValue | kWantGradients : kWantValue;
        } else if (q.type == Type::Struct) {
          s.from = ParamSource::From::Constant;
        } else if (q.type == Type::String && !(q.flags & kParamFile)) {
          p.texts.push_back(v.count ? v.strings[0] : "");
          s.offset = uint32_t(p.texts.size() - 1);
          if (q.flags & kParamArray)
            for (uint32_t k = 0; k < v.count; ++k) s.strings.push_back(v.strings[k]);
        } else if (q.flags & kParamArray) {
          s.list.assign(v.floats, v.floats + v.count);
          s.ints = r.values->ints(i);
        } else {
          s.from = ParamSource::From::Gathered;
          s.offset = p.blockFloats;
          p.blockFloats += s.components;
        }
      }
      n.wanted.assign(n.outputParam.size(), 0);
      p.nodes.push_back(std::move(n));
      if (&r != &nodes.back())
        p.patterns.push_back(r.shader ? nullptr
                                      : static_cast<const PatternFunctions*>(functionsFor(*r.plugin, width_)));
    }
    for (ProgramNode& n : p.nodes)
      for (uint32_t i = 0; i < n.plugin->paramCount; ++i)
        if (n.plugin->params[i].type == Type::String && !(n.plugin->params[i].flags & kParamFile))
          n.params[i].text = p.texts[n.params[i].offset].c_str();
    programs_.push_back(std::move(made));
  }
  Program& p = *programs_[program];
  // this material's numbers
  const size_t base = p.blocks.size();
  p.blocks.resize(base + p.blockFloats, 0.f);
  for (size_t n = 0; n < nodes.size(); ++n)
    for (uint32_t i = 0; i < nodes[n].plugin->paramCount; ++i) {
      const ParamSource& s = p.nodes[n].params[i];
      const Param& q = nodes[n].plugin->params[i];
      if (s.from != ParamSource::From::Gathered || (q.flags & kParamOutput)) continue;
      const ParamValue& v = nodes[n].values->values()[i];
      if (q.flags & kParamFile) {
        const std::string file = v.count ? v.strings[0] : "";
        const int32_t handle = nodes[n].shader ? language::internString(file)
                               : file.empty()
                                   ? TextureSystem::kNoTexture
                                   : textures_.handle(file, {nodes[n].node->pos, std::string(q.name) + " of '" +
                                                                                     nodes[n].node->handle + "'"});
        std::memcpy(&p.blocks[base + s.offset], &handle, 4);
      } else if (nodes[n].shader && q.type == Type::Int) {  // of shaders the bits: floats do not hold all of them
        const std::vector<int>& ints = nodes[n].values->ints(i);
        const int32_t own = ints.empty() ? int32_t(v.floats[0]) : ints[0];
        std::memcpy(&p.blocks[base + s.offset], &own, 4);
      } else {
        for (uint32_t c = 0; c < s.components && c < v.count; ++c) p.blocks[base + s.offset + c] = v.floats[c];
      }
    }
  if (fillsSpace) {
    Extinction& e = extinctions_[uint32_t(materials_.size())];
    ExtinctionProduct said{};
    if (traits->extinctionProduct) {
      e.isProduct = traits->extinctionProduct(last.values->values(), last.values->count(), &said);
      e.most = said.most;
      e.towardsLights = said.towardsLights;
      e.extinctionByBounce = said.extinctionByBounce;
      e.contributionByBounce = said.contributionByBounce;
      e.velocityFactor = said.velocityFactor;
      std::copy_n(said.constantVelocity, 3, e.constantVelocity);
      if (said.velocity) e.velocity = said.velocity;
      std::copy_n(said.factor, 3, e.factor);
      if (said.number) e.number = said.number;
      if (said.color) e.color = said.color;
    }
  }
  materials_.push_back({program, p.materials++});
  return uint32_t(materials_.size() - 1);
}

void MaterialSet::finish() {
  // only for finding what is there already
  known_.clear();
  keepAlive_.clear();
  programOfKey_.clear();
  materials_.shrink_to_fit();
  for (const auto& owned : programs_) {
    Program& p = *owned;
    p.blocks.shrink_to_fit();
    findTees(p);
    for (ProgramNode& n : p.nodes)
      for (ParamSource& s : n.params) {
        if (s.from != ParamSource::From::Gathered) continue;
        bool same = true;
        for (uint32_t m = 1; m < p.materials && same; ++m)
          same = !std::memcmp(&p.blocks[s.offset], &p.blocks[size_t(m) * p.blockFloats + s.offset], s.components * 4);
        if (!same) continue;
        s.from = ParamSource::From::Constant;
        std::memcpy(s.constant, &p.blocks[s.offset], s.components * 4);
      }
    uint64_t nanoseconds = 0;
    {
      const Clock clock(nanoseconds);
      makeShaderUses(p, shaders_.executables(), width_, diagnostics_);
    }
    if (!p.shaders.empty()) shaders_.addCompileSeconds(double(nanoseconds) * 1e-9);
    for (ShaderUse& use : p.shaders) {
      use.number = uint32_t(shaderUses_.size());
      shaderUses_.push_back(&use);
      materialsOfUse_.push_back(p.materials);
    }
    const uint32_t lobes = p.traits ? p.traits->lobeCount : 0;
    p.slotOfLobe.assign(std::max(lobes, 1u), 0);
    p.eventOfSlot.clear();
    p.tintedSlots = p.walkableSlots = 0;
    const auto isTinted = [&](const LobeDecl& lobe) {
      return p.tints && (lobe.flags & (kLobeTransmit | kLobeSpecular)) == (kLobeTransmit | kLobeSpecular);
    };
    // What tinted shadows and walks stand for comes first: when slots are short, others share the last one.
    std::vector<uint32_t> order(lobes);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_partition(order.begin(), order.end(),
                          [&](uint32_t l) { return isTinted(p.traits->lobes[l]) || (p.walkableLobes >> l & 1); });
    for (const uint32_t l : order) {
      const LobeDecl& lobe = p.traits->lobes[l];
      const bool tinted = isTinted(lobe), walkable = p.walkableLobes >> l & 1;
      const uint16_t e = paths_.event(lobe.flags, lobeName(lobe, p.nodes.back()), p.lpeGroup);
      size_t slot = 0;
      while (slot < p.eventOfSlot.size() && (p.eventOfSlot[slot] != e || bool(p.tintedSlots >> slot & 1) != tinted ||
                                             bool(p.walkableSlots >> slot & 1) != walkable))
        ++slot;
      if (slot == kMaxSlots) {
        slot = kMaxSlots - 1;
        diagnostics_.warning("LPE-LOBES", {},
                             std::string("expressions tell more than ") + std::to_string(kMaxSlots) + " lobes of " +
                                 p.nodes.back().plugin->name + " apart",
                             "the last ones share their outputs");
      }
      if (slot == p.eventOfSlot.size()) p.eventOfSlot.push_back(e);
      if (tinted) p.tintedSlots |= 1u << slot;
      if (walkable) p.walkableSlots |= 1u << slot;
      p.slotOfLobe[l] = uint8_t(slot);
    }
    if (p.eventOfSlot.empty()) p.eventOfSlot.push_back(0);
    p.slotCount = uint32_t(p.eventOfSlot.size());
  }
}

uint64_t MaterialSet::shaderBytes() const {
  uint64_t n = 0;
  std::set<const language::Executable*> shared;
  for (const ShaderUse* use : shaderUses_) {
    n += use->bytes();
    if (use->code && shared.insert(use->code.get()).second) n += use->code->bytes();
  }
  return n;
}

uint64_t MaterialSet::bytes() const {
  uint64_t n = materials_.size() * sizeof(Material);
  for (const auto& p : programs_) {
    n += sizeof(Program) + p->blocks.size() * 4 + p->nodes.size() * sizeof(ProgramNode);
    for (const ProgramNode& node : p->nodes) {
      n += node.params.size() * sizeof(ParamSource);
      for (const ParamSource& s : node.params) n += s.list.capacity() * sizeof(float);
    }
  }
  return n;
}

}  // namespace kinora::shade
