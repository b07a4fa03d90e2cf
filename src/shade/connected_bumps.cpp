#include "shade/connected_bumps.h"

#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "base/text.h"

namespace kinora::shade {

namespace {

const scene::Parameter* parameterOf(const scene::Node& n, std::string_view name) {
  for (const scene::Parameter& p : n.params)
    if (sameName(p.name, name)) return &p;
  return nullptr;
}

scene::Parameter number(const char* name, scene::ValueType type, float value) {
  scene::Parameter p;
  p.name = name;
  p.type = type;
  if (type == scene::ValueType::Int)
    p.ints = {int(value)};
  else
    p.floats = {value};
  return p;
}

// Which of red, green and blue an output of PxrTexture hands to a number; -1: none, or the mean of all.
int channelOf(std::string_view output) {
  for (const auto& [name, channel] : {std::pair{"resultR", 0}, {"resultG", 1}, {"resultB", 2}})
    if (sameName(output, name)) return channel;
  return -1;
}

// A bump with the heights of `texture`; null where that is more than it can do by itself.
std::shared_ptr<scene::Node> bumpOf(const scene::Node& bump, const scene::Node& texture, std::string_view output) {
  const int channel = channelOf(output);
  const scene::Parameter* factor = parameterOf(texture, "colorScale");
  const scene::Parameter* saturation = parameterOf(texture, "saturation");
  const scene::Parameter* scale = parameterOf(bump, "scale");
  if (channel < 0 || !parameterOf(texture, "filename")) return nullptr;
  if (saturation && (saturation->isReference || texture.params.getFloat(saturation->name, 1) != 1)) return nullptr;
  // colorOffset has no slope, unless it is a picture too
  if (const scene::Parameter* offset = parameterOf(texture, "colorOffset"); offset && offset->isReference)
    return nullptr;
  auto made = std::make_shared<scene::Node>(bump);
  if (factor) {
    if (factor->isReference || factor->floats.empty() || (scale && scale->isReference)) return nullptr;
    const size_t at = factor->floats.size() > size_t(channel) ? size_t(channel) : 0;
    const float own = scale ? bump.params.getFloat(scale->name, 1) : 1;
    if (scale) made->params.erase(scale->name);
    made->params.set(number("scale", scene::ValueType::Float, own * factor->floats[at]));
  }
  for (const char* name : {"filename", "atlasStyle", "invertT", "blur", "lerp", "manifold", "linearize"}) {
    if (const scene::Parameter* own = parameterOf(*made, name)) made->params.erase(std::string(own->name));
    if (const scene::Parameter* p = parameterOf(texture, name)) {
      scene::Parameter copy = *p;
      copy.name = name;
      made->params.set(std::move(copy));
    }
  }
  const scene::Parameter* first = parameterOf(texture, "firstChannel");
  made->params.set(number("firstChannel", scene::ValueType::Int,
                          float(channel + (first ? texture.params.getInt(first->name, 0) : 0))));
  made->params.erase(std::string(parameterOf(*made, "inputBump")->name));
  return made;
}

const scene::Node* nodeBefore(const scene::Network& network, size_t end, const std::string& handle) {
  const scene::Node* found = nullptr;
  for (size_t k = 0; k < end; ++k)
    if (network.patterns[k]->handle == handle) found = network.patterns[k].get();
  return found;
}

// Whether only shaders feed what `node` gives, and it is one: then derivatives go all the way. What is no plug-in is a
// shader, or missing, which is told elsewhere. `seen`: nodes that are known to be so.
bool comesOfShaders(const scene::Network& network, size_t end, const scene::Node& node, Registry& registry,
                    Diagnostics& diagnostics, std::set<const scene::Node*>& seen) {
  if (!seen.insert(&node).second) return true;
  if (registry.find(Kind::Pattern, node.plugin, diagnostics, node.pos)) return false;
  for (const scene::Parameter& p : node.params) {
    if (!p.isReference) continue;
    for (const std::string& from : p.strings) {
      const scene::Node* before = nodeBefore(network, end, from.substr(0, from.rfind(':')));
      // itself at most: connections lead back
      if (before && before != &node && !comesOfShaders(network, end, *before, registry, diagnostics, seen))
        return false;
    }
  }
  return true;
}

// A bump that is run as a shader: with the parameters that the shader has, as it spells them.
std::shared_ptr<scene::Node> bumpOfShader(const scene::Node& bump) {
  auto made = std::make_shared<scene::Node>(bump);
  for (const char* name :
       {"filename", "firstChannel", "atlasStyle", "invertT", "blur", "lerp", "manifold", "linearize", "adjustAmount"})
    if (const scene::Parameter* p = parameterOf(*made, name)) made->params.erase(std::string(p->name));
  for (const char* name : {"scale", "disable", "inputBump", "inputN", "reverse", "surfaceNormalMix"})
    if (const scene::Parameter* p = parameterOf(*made, name); p && p->name != name) {
      scene::Parameter copy = *p;
      made->params.erase(std::string(p->name));
      copy.name = name;
      made->params.set(std::move(copy));
    }
  made->params.set(number(kBumpOfShader, scene::ValueType::Int, 1));
  return made;
}

}  // namespace

scene::NetworkPtr withConnectedBumps(const scene::Network& network, Registry& registry, Diagnostics& diagnostics) {
  std::shared_ptr<scene::Network> other;
  for (size_t i = 0; i < network.patterns.size(); ++i) {
    const scene::Node& bump = *network.patterns[i];
    if (!sameName(bump.plugin, "PxrBump")) continue;
    const scene::Parameter* input = parameterOf(bump, "inputBump");
    if (!input || !input->isReference || input->strings.empty()) continue;
    const scene::Parameter* file = parameterOf(bump, "filename");
    if (file && (file->isReference || !bump.params.getString(file->name, "").empty())) continue;  // heights enough
    const std::string ref = input->strings[0];
    const size_t colon = ref.rfind(':');
    const scene::Node* from = nodeBefore(network, i, ref.substr(0, colon));
    if (!from) continue;
    std::shared_ptr<scene::Node> made;
    std::set<const scene::Node*> seen;
    if (colon != std::string::npos && sameName(from->plugin, "PxrTexture"))
      made = bumpOf(bump, *from, std::string_view(ref).substr(colon + 1));
    else if (comesOfShaders(network, i, *from, registry, diagnostics, seen))
      made = bumpOfShader(bump);
    if (!made) continue;  // the general way: ContextFunctions::paramGradient
    if (!other) other = std::make_shared<scene::Network>(network);
    other->patterns[i] = std::move(made);
  }
  return other;
}

}  // namespace kinora::shade
