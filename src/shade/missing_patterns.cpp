#include "shade/missing_patterns.h"

#include <algorithm>

#include "base/text.h"

namespace kinora::shade {

namespace {

bool isColor(const scene::Parameter& p) {
  return p.type == scene::ValueType::Color && (p.isReference ? p.strings.size() == 1 : p.floats.size() == 3);
}

// "Cin" for "Cout"; empty where the output's name does not end so.
std::string inputOf(const std::string& output) {
  const std::string name = lowerCase(output);
  return name.ends_with("out") ? name.substr(0, name.size() - 3) + "in" : std::string();
}

const scene::Parameter* namedColor(const scene::Node& node, const std::string& output) {
  const std::string wanted = inputOf(output);
  if (!wanted.empty())
    for (const scene::Parameter& p : node.params)
      if (isColor(p) && lowerCase(p.name) == wanted) return &p;
  return nullptr;
}

const scene::Parameter* image(const scene::Node& node) {
  for (const scene::Parameter& p : node.params) {
    if (p.type != scene::ValueType::String || p.isReference || p.strings.size() != 1) continue;
    const std::string name = lowerCase(p.strings[0]);
    for (const char* extension : {".tx", ".tex", ".tif", ".tiff", ".exr", ".png", ".jpg", ".jpeg", ".tga", ".hdr"})
      if (name.ends_with(extension)) return &p;
  }
  return nullptr;
}

// The usual names of a shader's one colour and of its result.
bool hasOwnColor(const scene::Node& node) {
  return std::any_of(node.params.begin(), node.params.end(), [](const scene::Parameter& p) {
    return isColor(p) && (lowerCase(p.name) == "cin" || lowerCase(p.name) == "colorin");
  });
}

}  // namespace

const scene::Parameter* colorOfMissing(const scene::Node& missing, const std::string& output) {
  if (const scene::Parameter* p = namedColor(missing, output)) return p;
  if (image(missing)) return nullptr;
  for (const scene::Parameter& p : missing.params)
    if (isColor(p)) return &p;
  return nullptr;
}

std::optional<scene::Node> textureOfMissing(const scene::Node& missing) {
  const scene::Parameter* named = image(missing);
  if (!named || hasOwnColor(missing)) return std::nullopt;
  scene::Node out;
  out.kind = missing.kind;
  out.plugin = "PxrTexture";
  out.handle = missing.handle;
  out.pos = missing.pos;
  scene::Parameter file = *named;
  file.name = "filename";
  out.params.set(std::move(file));
  return out;
}

std::string describeStandIn(const scene::Node& missing) {
  if (textureOfMissing(missing))
    return "colours that it feeds are those of image '" + image(missing)->strings[0] + "'";
  for (const scene::Parameter& p : missing.params)
    if (isColor(p) && (hasOwnColor(missing) ? lowerCase(p.name).ends_with("in") : true))
      return "colours that it feeds are its " + p.name + ", other parameters have their defaults";
  return "what it feeds uses its defaults";
}

}  // namespace kinora::shade
