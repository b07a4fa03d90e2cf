#include "render/ies_profiles.h"

#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>
#include <utility>

#include "base/file_search.h"
#include "light/ies_profile.h"

namespace kinora::render {

namespace {

void set(scene::Node& n, const char* name, std::vector<float> list) {
  scene::Parameter p;
  p.name = name;
  p.isArray = list.size() != 1;
  p.arrayLength = int(list.size());
  p.floats = std::move(list);
  n.params.set(std::move(p));
}
void set(scene::Node& n, const char* name, int value) {
  scene::Parameter p;
  p.name = name;
  p.type = scene::ValueType::Int;
  p.ints = {value};
  n.params.set(std::move(p));
}

}  // namespace

std::string placeOfProfile(const std::string& name, const std::vector<std::string>& searchPath) {
  std::error_code ec;
  for (const std::filesystem::path& p : placesOf(name, searchPath).list)
    if (std::filesystem::is_regular_file(p, ec)) return p.string();
  return "";
}

scene::NodePtr iesFilterOf(const scene::Node& light, const std::vector<std::string>& searchPath,
                           FileContents& contents, Diagnostics& diagnostics) {
  const std::string name = light.params.getString("iesProfile", "");
  if (name.empty()) return nullptr;
  const std::string who = light.plugin + " '" + light.handle + "'";
  const char* done = "the light has no profile";
  const std::string path = placeOfProfile(name, searchPath);
  contents.use("light profile", name, path.empty() ? std::vector<std::string>() : std::vector<std::string>{path});
  if (path.empty()) {
    diagnostics.warning("ASSET-IES-MISSING", light.pos, "the IES profile '" + name + "' of " + who + " is not there",
                        done, "profiles are looked for along the search path of textures");
    return nullptr;
  }
  std::string text;
  {
    std::ifstream in(path, std::ios::binary);
    text.resize(light::kMostIesBytes + 1);
    in.read(text.data(), std::streamsize(text.size()));
    text.resize(size_t(in.gcount()));
    text.shrink_to_fit();
  }
  light::IesProfile profile;
  if (const light::IesError e = light::readIes(text, profile); e.line) {
    diagnostics.warning("ASSET-IES-READ", {FileName(path), e.line}, e.what + " (IES profile of " + who + ")", done);
    return nullptr;
  }
  auto n = std::make_shared<scene::Node>();
  n->kind = "LightFilter";
  n->plugin = "IesLightFilter";
  n->handle = light.handle + ".iesProfile";
  n->pos = light.pos;
  set(*n, "webType", int(profile.type));
  set(*n, "verticalAngles", std::move(profile.vertical));
  set(*n, "horizontalAngles", std::move(profile.horizontal));
  set(*n, "candela", std::move(profile.candela));
  set(*n, "scale", std::vector<float>{light.params.getFloat("iesProfileScale", 0)});
  set(*n, "normalize", light.params.getInt("iesProfileNormalize", 0));
  return n;
}

}  // namespace kinora::render
